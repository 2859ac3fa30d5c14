//! Finds equilibria.

pub mod assembly;
mod coupling;
pub mod engine;
pub mod newton;
pub mod path;
pub mod stability;
pub mod state;
pub mod step_bound;

pub use engine::Engine;
pub use state::{Drive, State};
