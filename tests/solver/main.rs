//! What searches, load steps and runs do and promise.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/families/mod.rs"]
mod families;
#[path = "../common/knots.rs"]
mod knots;
#[path = "../common/play.rs"]
mod play;
#[path = "../../src/math/random.rs"]
mod random;
#[path = "../common/supercoiling.rs"]
mod supercoiling;
#[path = "../common/tally.rs"]
mod tally;

mod as_shaped;
mod augmented_ring;
mod branches;
mod cable;
mod certificate;
mod coaxial_clamps;
mod contact_by_mesh;
mod contact_held_open;
mod contact_laws;
mod contact_layer;
mod contact_unfelt;
mod contact_unloaded;
mod error_estimate;
mod everyday_scenes;
mod fidelity;
mod free_rods;
mod grips;
mod held_motions;
mod honest_endings;
mod joined;
mod light_contact;
mod long_plectonemes;
mod moments;
mod natural_twist;
mod obstacles;
mod planar;
mod planes;
mod poses;
mod random_scenes;
mod random_supercoiling;
mod shear;
mod snaps;
mod start_shapes;
mod swivels;
mod ways;
mod winding;
