//! Pairs of segments: lower bounds of their distance, and the pairs that these discard.

pub mod capsule;
pub mod filter;
