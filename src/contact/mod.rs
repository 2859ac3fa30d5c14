//! Contact of curves with radii: usable on its own, knows no rods. All lengths in one unit of the caller's choice.
//!
//! [`Detector`] takes curves in and gives contact sites and zones out. Underneath:
//!
//! ```text
//!  input ──▶ broad_phase ──▶ pair_filter ──▶ site, closest ──▶ sites
//!  curves    box pairs       capsules        zone, interval ──▶ zones     law, detect ──▶ energy, gradient, Hessian
//!            exclusion: along-strand neighbours left out as the tree is traversed
//! ```
//!
//! The data flow of the potential: [`curve`] (cubic pieces strung into curves) → [`exclusion`] (which parts of one
//! curve are too near *along* it to touch) → [`broad_phase`] (candidate pairs from a bounding-volume hierarchy) →
//! [`capsule`] (cheap lower bounds of distance) → [`projection`] (every orthogonal projection of a point, certified) →
//! [`zone`] (where the gap is below the reach, with exact ends) → [`law`] (pressure) → [`mod@detect`] (energy,
//! gradient, Hessian per pair). Beside it, and independent of zones, [`clearance`] certifies the smallest gap.

pub(crate) mod arc;
mod boxes;
pub mod broad_phase;
pub mod capsule;
pub(crate) mod chain;
pub mod clearance;
mod closest;
pub mod curve;
pub mod detect;
mod detector;
pub mod exclusion;
mod input;
mod interval;
pub mod law;
mod options;
mod pair_filter;
pub mod projection;
mod radius;
pub mod screened;
mod site;
#[doc(hidden)]
pub mod stages;
mod vertex;
pub mod zone;

pub use detector::{Contacts, Detector, Forces, detect};
pub use input::{Curve, Shape};
pub use interval::Zone;
pub use law::Law;
pub use options::{Neighbours, Options};
pub use radius::Radius;
pub use site::{Site, SiteKind};
