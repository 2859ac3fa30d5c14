//! (to be written)

pub mod pattern;
pub mod factor;
