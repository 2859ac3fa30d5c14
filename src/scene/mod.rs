//! What is to be solved: [`model`] holds rods, supports, loads, contact choice and stages as plain data;
//! [`file`](mod@file) reads them from a scene file (TOML); [`Fidelity`] sets mesh, law and tolerances by one word.

mod fidelity;
pub mod file;
pub mod model;

pub use fidelity::{Accuracy, Fidelity};
pub use file::Scene;
pub use model::{Contact, ContactLaw, Joint, LineLoad, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
