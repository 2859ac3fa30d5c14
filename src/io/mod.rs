//! Files and pictures: [`vtk`] (ParaView), `csv` (tables, points,
//! states; feature `tables`), `picture` (shaded tubes, plots; feature `pictures`), `view` (a page to turn and to step
//! through, glTF; `view`), `table` (a run as a table; `tables`), and with the feature `runs` `checkpoint` (a run that
//! survives), `fingerprint` (what distinguishes one problem from another), `final_state` (of a run, from its folder),
//! `comparison` (of two), `thermal` (at a thermal energy), `record` (all that a run leaves behind), `run` (a scene from
//! start to files), `export` (the base pairs of a run), `plot_run` (columns of its table), `schema` (scene files as
//! editors know them), and with `sweeps` `sweep` (thousands of runs).

#[cfg(feature = "runs")]
pub mod asked;
#[cfg(feature = "runs")]
pub mod checkpoint;
#[cfg(feature = "runs")]
pub mod comparison;
#[cfg(feature = "tables")]
pub mod csv;
pub mod detail;
#[cfg(feature = "runs")]
pub mod export;
#[cfg(feature = "runs")]
pub mod final_state;
#[cfg(feature = "runs")]
pub(crate) mod fingerprint;
#[cfg(feature = "runs")]
mod folder;
#[cfg(feature = "pictures")]
pub mod picture;
#[cfg(feature = "runs")]
pub mod plot_run;
#[cfg(feature = "runs")]
pub mod record;
#[cfg(feature = "runs")]
mod replace;
#[cfg(feature = "runs")]
pub mod run;
#[cfg(feature = "runs")]
pub mod schema;
#[cfg(feature = "sweeps")]
pub mod sweep;
#[cfg(feature = "tables")]
pub mod table;
#[cfg(feature = "runs")]
pub mod thermal;
#[cfg(feature = "view")]
pub mod view;
pub mod vtk;
