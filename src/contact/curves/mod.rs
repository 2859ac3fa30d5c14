//! Curves in contact: sets of cubic segments, borrowed polylines and cubics, radii, arcs.

pub mod arc;
pub mod curve;
pub mod input;
pub mod radius;
