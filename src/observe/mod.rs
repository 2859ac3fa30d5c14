//! What is to be known of a state: [`observe()`] fills an [`Observation`](report::Observation) with everything,
//! [`link`] has the topology of closed curves, [`report`] the plain data; [`estimate_error`] says how far off a state
//! is; [`strains()`] what the elements know.

mod error_estimate;
mod knots;
pub mod report;
mod sites;
mod start;
mod state;
mod strains;

/// Link, twist and writhe of closed curves (they live among the mathematics, for start shapes need them too).
pub use crate::math::link;
pub use error_estimate::{Comparison, Differences, ErrorEstimate, estimate_error};
pub use start::{StartOverlap, start_overlaps};
pub use state::{OVERLAP, contact_lines, contact_sites, observe};
pub use strains::{RodStrains, strains};
