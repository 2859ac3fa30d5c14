//! `sensitivities.csv`: derivatives of observables.

use std::path::PathBuf;

use crate::error::InputError;
use crate::io::asked::Answers;
use crate::io::csv::write_table;

use super::run::{RecordedFrame, RecordedRun};
use super::{Writer, files};

/// Names of natural strains.
const STRAINS: [&str; 6] = ["gamma_1", "gamma_2", "gamma_3", "kappa_1", "kappa_2", "kappa_3"];

#[derive(Debug)]
pub(super) struct SensitivitiesWriter;

impl Writer for SensitivitiesWriter {
    fn last(&mut self, run: &RecordedRun, _: &RecordedFrame) -> Result<(), InputError> {
        write(run).map(drop)
    }
}

/// Writes derivatives, if there are any: a line each, with row and strain those of a table. Returns the path.
pub(super) fn write(run: &RecordedRun) -> Result<Option<PathBuf>, InputError> {
    let Answers { sensitivities, tables, .. } = &run.ending.answers;
    if sensitivities.is_empty() && tables.is_empty() {
        return Ok(None);
    }
    let path = run.dir.join(files::SENSITIVITIES);
    let head = ["of", "to", "row", "strain", "value"];
    let numbers = sensitivities
        .iter()
        .map(|one| vec![one.of.clone(), one.to.clone(), String::new(), String::new(), format!("{:e}", one.value)]);
    let rows = tables.iter().flat_map(|table| {
        table.rows.iter().enumerate().flat_map(move |(row, six)| {
            six.iter().zip(STRAINS).map(move |(value, strain)| {
                vec![table.of.clone(), table.to.clone(), row.to_string(), strain.to_owned(), format!("{value:e}")]
            })
        })
    });
    write_table(&path, &head, numbers.chain(rows))?;
    Ok(Some(path))
}
