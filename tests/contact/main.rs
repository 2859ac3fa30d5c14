//! Contact of curves with radii, without a rod.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../../benches/inputs.rs"]
#[allow(dead_code)] // each module uses its part
mod inputs;
#[path = "../../examples/contact_of_polylines.rs"]
#[allow(dead_code)] // each module uses its part
mod polylines;
#[path = "../../src/math/random.rs"]
mod random;
#[path = "../common/smooth_curves.rs"]
mod smooth_curves;
#[path = "../../examples/contact_in_foreign_stepper.rs"]
#[allow(dead_code)] // each module uses its part
mod stepper;

mod contact_cubics;
mod contact_detector;
mod contact_examples;
mod contact_forces;
mod contact_geometry;
mod contact_radii;
mod contact_sites;
