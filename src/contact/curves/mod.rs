//! The curves that contact sees: cubic pieces strung into curves, borrowed polylines and cubics, their radii, and arcs
//! of them.

pub mod arc;
pub mod curve;
pub mod input;
pub mod radius;
