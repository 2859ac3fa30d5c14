//! What holds for every input: rigid motions, topology, units, far from the origin.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
mod common;
#[path = "../../src/math/random.rs"]
mod random;

mod far_from_origin;
mod fuzz_library;
mod objectivity;
mod observables;
mod problem_size;
mod topology;
