//! Results of a state: [`observe()`] computes an [`Observation`](report::Observation), the plain data of [`report`];
//! [`estimate_error`] estimates its error, [`strains()`] gives strains and stress resultants.

mod braids;
#[cfg(feature = "tables")]
mod end_links;
mod error_estimate;
mod knots;
mod mesh;
mod obstacles;
pub mod report;
mod sites;
mod start;
mod state;
mod strains;
mod topology;

#[cfg(feature = "tables")]
pub use end_links::EndLinks;
pub use error_estimate::{COVERS, Comparison, Differences, ErrorEstimate, estimate_error};
pub use mesh::mesh_note;
pub use start::{StartOverlap, start_overlaps};
#[cfg(feature = "tables")]
pub(crate) use state::SNAP;
pub use state::{OVERLAP, contact_lines, contact_sites, ending, observe, smoothed_contact_forces};
pub use strains::{RodStrains, strains};
