//! (to be written)

pub mod curve;
pub mod broad_phase;
pub mod capsule;
pub mod projection;
pub mod exclusion;
pub mod clearance;
pub mod zone;
pub mod law;
pub mod detect;
