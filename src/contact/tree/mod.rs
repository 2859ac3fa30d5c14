//! From curves to pairs of segments: boxes, the tree over them, and the exclusion of neighbours along a curve.

pub mod boxes;
pub mod broad_phase;
pub mod exclusion;
mod leaves;
