//! Contact of curves with radii: usable on its own, knows no rods. All lengths in one unit of the caller's choice.
//!
//! [`Detector`] computes contact sites, zones, energy and forces of curves. The folders follow the data:
//!
//! | folder | from → to |
//! |---|---|
//! | `curves` | polylines and cubics with radii, as one list of segments |
//! | `tree` | segments → pairs of segments whose boxes overlap, neighbours along a curve left out |
//! | `pairs` | these → candidates, by lower bounds of the distance of two segments |
//! | `projection` | a point and a segment → all its orthogonal projections, certified |
//! | `zones` | a candidate → where its gap is below the reach, with exact ends |
//! | `law` | zones → pressure, and the contact potential: energy, gradient, Hessian of each pair |
//! | `sites` | candidates → local minima of the gap; zones → contacts; the smallest clearance, certified, without zones |

mod curves;
mod detector;
pub(crate) mod law;
mod measures;
mod options;
mod pairs;
pub(crate) mod projection;
pub(crate) mod screened;
mod sites;
pub(crate) mod steps;
mod tree;
mod zones;

// For higher layers.
#[cfg(feature = "solver")]
pub(crate) use curves::arc;
pub(crate) use curves::curve;
pub(crate) use law::potential;
pub(crate) use pairs::capsule;
#[cfg(feature = "solver")]
pub(crate) use sites::chain;
pub(crate) use sites::clearance;
pub(crate) use tree::{broad_phase, exclusion};

pub use curves::curve::Cubic;
pub use curves::input::{Curve, CurveShape};
pub use curves::radius::Radius;
pub use detector::{Contacts, Detector, Forces, detect};
pub use law::Law;
pub use law::potential::{Hessian, PairTerm, Want, ZonePiece};
pub use options::{DetectorOptions, Neighbours};
pub use sites::clearance::Clearance;
pub use sites::site::{Site, SiteLocation};
pub use zones::interval::Zone;
