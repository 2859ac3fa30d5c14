//! What is said to the author of a scene file: the reference of its keys, scenes to begin with, errors in its words,
//! advice.

pub(super) mod advice;
mod entry;
pub(super) mod reference;
mod templates;
pub(super) mod words;

pub use entry::help;
pub use reference::{Key, keys, reference};
pub use templates::{TEMPLATES, Template};
