//! Pairs of segments: lower bounds of their distance, and the filter of pairs by these.

pub mod capsule;
pub mod filter;
