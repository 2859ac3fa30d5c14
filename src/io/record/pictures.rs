//! Pictures of a run.

pub(super) mod camera;
mod drawing;
mod film_strip;
mod final_picture;
pub(super) mod still;
mod writhe_plot;

pub(super) use film_strip::FilmStripWriter;
pub(super) use final_picture::PictureWriter;
pub(super) use writhe_plot::WrithePlotWriter;
