//! supercoil: equilibria of elastic rods that touch themselves and each other.

pub mod contact;
pub mod dna;
pub mod error;
pub mod io;
pub mod math;
pub mod observe;
pub mod rod;
pub mod scene;
pub mod solve;
pub mod sparse;

pub use error::{InputError, SolveError};
pub use nalgebra;
