//! Files and pictures: [`vtk`] (ParaView), [`csv`] (tables, points, states), [`picture`] (shaded tubes, plots), [`table`]
//! (a run as a table), [`record`] (all that a run leaves behind).

pub mod csv;
pub mod picture;
pub mod record;
pub mod table;
pub mod vtk;
