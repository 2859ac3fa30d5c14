//! `sites.csv`, `lines.csv`, `joints.csv`: what rods exert on each other in the final state.

use crate::error::InputError;
use crate::io::table::{Named, write_joints, write_lines, write_sites};

use super::rods::RodHead;
use super::run::{RecordedFrame, RecordedRun};
use super::{Writer, files};

#[derive(Debug)]
pub(super) struct InteractionsWriter;

impl Writer for InteractionsWriter {
    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        let heads = run.heads(last.step);
        let names: Vec<String> = heads.iter().map(|head| head.name.clone()).collect();
        let lengths: Vec<f64> = heads.iter().map(|head| head.length).collect();
        let obstacles: Vec<String> = run.obstacles.iter().map(|obstacle| obstacle.name.clone()).collect();
        let named = Named { rods: &names, lengths: &lengths, obstacles: &obstacles, units: &run.units };
        let step = run.steps.get(last.step);
        let on_obstacles = step.map_or(&[][..], |step| &step.obstacle_sites);
        write_sites(&run.dir.join(files::SITES), &last.sites, on_obstacles, named)?;
        if !run.ending.lines.is_empty() {
            write_lines(&run.dir.join(files::LINES), &run.ending.lines, named)?;
        }
        let joints = step.map_or(&[][..], |step| &step.joints);
        if !joints.is_empty() {
            let arcs: Vec<Vec<f64>> = heads.iter().map(RodHead::arc_lengths).collect();
            write_joints(&run.dir.join(files::JOINTS), joints, &arcs, named)?;
        }
        Ok(())
    }
}
