//! (to be written)

pub mod section;
pub mod shape;
pub mod element;
pub mod rod;
