//! What is to be solved: [`model`] holds rods, supports, loads, contact choice and stages as plain data;
//! [`file`](mod@file) reads them from a scene file (TOML).

pub mod file;
pub mod model;

pub use file::Scene;
pub use model::{Contact, ContactLaw, Joint, LineLoad, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
