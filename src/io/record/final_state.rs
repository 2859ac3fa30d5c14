//! `final_state.csv`: positions and frames of all nodes.

use crate::error::InputError;
use crate::io::csv::{RodState, write_state};

use super::rods::RodHead;
use super::run::{RecordedFrame, RecordedRun, RodSnapshot};
use super::{Writer, files};

#[derive(Debug)]
pub(super) struct FinalStateWriter;

impl Writer for FinalStateWriter {
    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        write_state(&run.dir.join(files::FINAL_STATE), &rod_states(run, last), &run.units)
    }
}

/// The nodes of all rods.
pub(super) fn rod_states(run: &RecordedRun, last: &RecordedFrame) -> Vec<RodState> {
    let heads = run.heads(last.step);
    let state = |(head, rod): (&RodHead, &RodSnapshot)| RodState {
        arc_lengths: head.arc_lengths(),
        positions: rod.positions.clone(),
        frames: rod.frames.clone(),
    };
    heads.iter().zip(&last.rods).map(state).collect()
}
