//! What is to be known of a state: [`observe()`] fills an [`Observation`](report::Observation) with everything, [`link`] has the
//! topology of closed curves, [`report`] the plain data.

pub mod link;
pub mod report;
mod sites;
mod state;

pub use state::{contact_sites, observe};
