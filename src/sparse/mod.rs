//! Sparse symmetric matrices over nodes with up to six unknowns each: [`pattern`] (built once per contact graph,
//! refilled), `ordering` (orders of elimination), [`factor`] (LDLᵀ with inertia; the only file that names the sparse
//! library), `fronts` (the order of its work, on all threads), `forest` (what of it is independent).

pub mod factor;
mod forest;
mod fronts;
mod ordering;
pub mod pattern;

pub use factor::Factor;
pub use pattern::{NodeGraph, Pattern};
