//! (to be written)

pub mod broad_phase;
pub mod capsule;
pub mod clearance;
pub mod curve;
pub mod detect;
pub mod exclusion;
pub mod law;
pub mod projection;
pub mod zone;
