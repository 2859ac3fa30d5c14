//! Self-contact of curves with radii: usable without any rod.
//!
//! [`Detector`] takes curves in and gives contact sites and zones out. Underneath:
//!
//! ```text
//!  input ──▶ chain_tree ──▶ pair_filter ──▶ site, closest ──▶ sites
//!  curves    box pairs      capsules        zone, interval ──▶ zones     law, detect ──▶ energy, gradient, Hessian
//!            exclusion: along-strand neighbours left out inside the traversal
//! ```

mod chain_tree;
mod input;
mod pair_filter;

pub mod broad_phase;
pub mod capsule;
pub mod clearance;
pub mod curve;
pub mod detect;
pub mod exclusion;
pub mod law;
pub mod projection;
pub mod zone;

pub use input::{Curve, Shape};
