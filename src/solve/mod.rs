//! (to be written)

pub mod newton;
pub mod step_bound;
pub mod path;
pub mod stability;
