//! `resultants.csv`: forces and moments along the rods of the final state.

use crate::error::InputError;
use crate::io::table::{ResultantsOf, write_resultants};

use super::run::{RecordedFrame, RecordedRun};
use super::{Writer, files};

#[derive(Debug)]
pub(super) struct ResultantsWriter;

impl Writer for ResultantsWriter {
    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        let rods = last.rods.iter().enumerate().filter(|(_, rod)| !rod.fields.curvature.is_empty());
        let rods: Vec<ResultantsOf> = rods
            .map(|(index, rod)| ResultantsOf {
                name: &run.rods[index].name,
                arc_lengths: run.head(index, last.step).arc_lengths(),
                frames: &rod.frames,
                fields: &rod.fields,
                contact_force: &rod.smoothed_contact_force,
            })
            .collect();
        write_resultants(&run.dir.join(files::RESULTANTS), &rods, &run.units)
    }
}
