//! Numbers of a state: [`observe()`] fills an [`Observation`](report::Observation) with all of them, [`report`] holds
//! the plain data; [`estimate_error`] tells how far off a state is, [`strains()`] strains and stress resultants.

mod error_estimate;
mod knots;
mod planes;
pub mod report;
mod sites;
mod start;
mod state;
mod strains;

pub use error_estimate::{Comparison, Differences, ErrorEstimate, estimate_error};
pub use start::{StartOverlap, start_overlaps};
pub use state::{OVERLAP, contact_lines, contact_sites, observe};
pub use strains::{RodStrains, strains};
