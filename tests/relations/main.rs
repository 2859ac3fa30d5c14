//! Scenes that must agree with each other: turned, mirrored, in other units, cut and joined, in other steps, from a
//! file.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../../src/math/random.rs"]
mod random;
#[path = "../common/relations/mod.rs"]
mod relations;

mod agreement;
mod covering;
