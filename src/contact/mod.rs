//! Contact of curves with radii: usable on its own, knows no rods. All lengths in one unit of the caller's choice.
//!
//! The data flow: [`curve`] (cubic pieces strung into curves) → [`exclusion`] (which parts of one curve are too near *along*
//! it to touch) → [`broad_phase`] (candidate pairs from a bounding-volume hierarchy) → [`capsule`] (cheap lower bounds of
//! distance) → [`projection`] (every orthogonal projection of a point, certified) → [`zone`] (where the gap is below the
//! reach, with exact ends) → [`law`] (pressure) → [`detect`] (energy, gradient, Hessian per pair). Beside it, and
//! independent of zones, [`clearance`] certifies the smallest gap.

pub mod broad_phase;
pub mod capsule;
pub mod clearance;
pub mod curve;
pub mod detect;
pub mod exclusion;
pub mod law;
pub mod projection;
pub mod zone;
