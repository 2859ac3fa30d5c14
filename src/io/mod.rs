//! Files and pictures: [`vtk`] (ParaView), [`base_pairs`] (oxDNA, XYZ, NumPy arrays of frames), `csv` (tables, points,
//! states; feature `tables`), `picture` (shaded tubes, plots; feature `pictures`), `view` (a page to turn and to step
//! through, glTF; `view`), `table` (a run as a table; `tables`), and with the feature `runs` `checkpoint` (a run that
//! survives), `record` (all that a run leaves behind), `run` (a scene from start to files), `export` (the base pairs of
//! a run), and with `sweeps` `sweep` (thousands of runs).

pub mod base_pairs;
#[cfg(feature = "runs")]
pub mod checkpoint;
#[cfg(feature = "tables")]
pub mod csv;
pub mod detail;
#[cfg(feature = "runs")]
pub mod export;
#[cfg(feature = "runs")]
mod folder;
#[cfg(feature = "pictures")]
pub mod picture;
#[cfg(feature = "runs")]
pub mod record;
#[cfg(feature = "runs")]
pub mod run;
#[cfg(feature = "sweeps")]
pub mod sweep;
#[cfg(feature = "tables")]
pub mod table;
#[cfg(feature = "view")]
pub mod view;
pub mod vtk;
