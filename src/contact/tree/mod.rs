//! From curves to pairs of segments: boxes, the tree over them, and the neighbours along a curve that it leaves out.

pub mod boxes;
pub mod broad_phase;
pub mod exclusion;
mod leaves;
