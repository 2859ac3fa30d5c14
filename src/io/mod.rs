//! Files and pictures: [`vtk`] (ParaView), [`csv`] (tables, points, states), [`picture`] (shaded tubes, plots),
//! [`table`] (a run as a table), [`checkpoint`] (a run that survives), [`record`] (all that a run leaves behind),
//! [`run`](mod@run) (a scene from start to files).

pub mod checkpoint;
pub mod csv;
pub mod detail;
pub mod picture;
pub mod record;
pub mod run;
pub mod table;
pub mod vtk;
