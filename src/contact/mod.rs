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
mod closest;
mod detector;
mod input;
mod interval;
mod options;
mod pair_filter;
mod site;
mod vertex;

pub mod broad_phase;
pub mod capsule;
pub mod clearance;
pub mod curve;
pub mod detect;
pub mod exclusion;
pub mod law;
pub mod projection;
#[doc(hidden)]
pub mod stages;
pub mod zone;

pub use detector::{Contacts, Detector, detect};
pub use input::{Curve, Shape};
pub use interval::Zone;
pub use options::{Neighbours, Options};
pub use site::{Site, SiteKind};
