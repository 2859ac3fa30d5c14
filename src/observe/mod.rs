//! (to be written)

pub mod link;
pub mod report;
