//! `view.html`: a page that shows the run.

use crate::error::InputError;
use crate::io::view;

use super::run::{RecordedFrame, RecordedRun};
use super::{Writer, files};

/// Reads `table.csv` and the VTK files of the steps: their writers come before it.
#[derive(Debug)]
pub(super) struct PageWriter;

impl Writer for PageWriter {
    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        if !(run.output.vtk && run.output.view) {
            return Ok(());
        }
        let (title, units, obstacles, steps) = (run.title.as_str(), &run.units, &run.obstacles, &run.steps);
        let parts = view::Parts { title, units, rods: &run.heads(last.step), obstacles, steps };
        view::film(&run.dir, &parts, view::MAX_NODES)?.save_page(&run.dir.join(files::VIEW))
    }
}
