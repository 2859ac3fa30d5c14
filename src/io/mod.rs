//! (to be written)

pub mod vtk;
pub mod csv;
pub mod picture;
