//! `table.csv`: a line for each accepted step.

use crate::error::InputError;

use super::run::RecordedRun;
use super::{Writer, files};

#[derive(Debug)]
pub(super) struct TableWriter;

impl Writer for TableWriter {
    fn end(&mut self, run: &RecordedRun) -> Result<(), InputError> {
        run.columns.write(&run.dir.join(files::TABLE), &run.steps)
    }
}
