//! `step_0000.vtp` …, `obstacles_0000.vtp` …, `run.pvd`: states for ParaView.

use std::path::{Path, PathBuf};

use crate::error::InputError;
use crate::io::picture::obstacle::placed_lines;
use crate::io::vtk::{PvdWriter, VtkRod, VtkStep, write_obstacle_lines, write_vtp};
use crate::math::Vec3;
use crate::observe::report::Observation;
use crate::scene::Units;

use super::run::{RecordedFrame, RecordedRun, RodSnapshot, placements};
use super::{RecordState, Writer, files};

/// Writes every so many states as soon as they are accepted, and the last one in any case.
#[derive(Debug)]
pub(super) struct VtkWriter {
    /// Units of the arrays at the points.
    point_units: [(&'static str, String); 9],
    last_written: Option<usize>,
    pvd: PvdWriter,
}

impl VtkWriter {
    /// Goes on after the step `last_written`, with these entries of the collection.
    pub fn new(units: &Units, dir: &Path, last_written: Option<usize>, collection: String) -> Self {
        let pvd = PvdWriter::resume(dir.join(files::COLLECTION), collection);
        Self { point_units: point_units(units), last_written, pvd }
    }

    fn write(&mut self, run: &RecordedRun, frame: &RecordedFrame) -> Result<(), InputError> {
        let (points, rods): (Vec<Vec<Vec3>>, Vec<VtkRod>) =
            frame.rods.iter().enumerate().map(|(index, rod)| vtk_rod(run, frame.step, index, rod)).unzip();
        let rods: Vec<VtkRod> = points.iter().zip(rods).map(|(points, rod)| VtkRod { points, ..rod }).collect();
        let path = run.dir.join(files::of_step(frame.step));
        write_vtp(&path, &rods, &self.field_data(run, &run.steps[frame.step]))?;
        self.last_written = Some(frame.step);
        let mut paths = vec![path];
        if !run.obstacles.is_empty() {
            paths.push(run.dir.join(files::of_obstacles(frame.step)));
            let points = || frame.rods.iter().flat_map(|rod| &rod.positions);
            let placed = run.obstacles.iter().zip(placements(&run.steps[frame.step])).enumerate();
            let lines: Vec<(usize, [Vec3; 2])> = placed
                .flat_map(|(k, (obstacle, pose))| {
                    placed_lines(obstacle, &pose, points()).into_iter().map(move |line| (k, line))
                })
                .collect();
            write_obstacle_lines(&paths[1], &lines, &VtkStep::default())?;
        }
        let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
        self.pvd.push(frame.step as f64, &paths)
    }

    /// The numbers of the table, how far the run is, units.
    fn field_data<'a>(&'a self, run: &'a RecordedRun, step: &'a Observation) -> VtkStep<'a> {
        let (time, value) = run.columns.progress(step);
        let mut told = VtkStep { numbers: vec![("TimeValue", value)], units: vec![("TimeValue", time)] };
        for (name, unit, value) in run.columns.numbers(step) {
            told.numbers.push((name, value));
            told.units.extend((!unit.is_empty()).then_some((name, unit)));
        }
        told.units.extend(self.point_units.iter().map(|(name, unit)| (*name, unit.as_str())));
        told
    }
}

impl Writer for VtkWriter {
    fn step(&mut self, run: &RecordedRun, frame: &RecordedFrame) -> Result<(), InputError> {
        if run.output.vtk && frame.step.is_multiple_of(run.output.every) { self.write(run, frame) } else { Ok(()) }
    }

    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        if run.output.vtk && self.last_written != Some(last.step) { self.write(run, last) } else { Ok(()) }
    }

    fn save(&self, state: &mut RecordState) {
        state.last_written = self.last_written;
        self.pvd.entries().clone_into(&mut state.collection);
    }
}

/// Points and arrays of a rod, whose points are set by the caller, who owns them.
fn vtk_rod<'a>(run: &RecordedRun, step: usize, index: usize, rod: &RodSnapshot) -> (Vec<Vec3>, VtkRod<'a>) {
    let head = run.head(index, step);
    let kept = run.vtk_nodes(&head, rod);
    let axis = |axis: Vec3| kept.iter().map(|&i| rod.frames[i] * axis).collect::<Vec<_>>();
    let scalar = |values: &[f64]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let vector = |values: &[Vec3]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let (fields, spacing) = (&rod.fields, head.spacing());
    let is_end = |i: usize| !head.closed && (i == 0 || i + 1 == head.nodes);
    let share = |i: usize| if is_end(i) { 0.5 * spacing } else { spacing };
    let vectors = vec![
        ("d1", axis(Vec3::x())),
        ("d2", axis(Vec3::y())),
        ("d3", axis(Vec3::z())),
        ("smoothed_contact_force_per_length", vector(&rod.smoothed_contact_force)),
        ("contact_force_on_node", kept.iter().map(|&i| fields.contact_force[i] * share(i)).collect()),
        ("internal_force", vector(&fields.internal_force)),
        ("internal_moment", vector(&fields.internal_moment)),
    ];
    let scalars = vec![
        ("arc_length", kept.iter().map(|&i| spacing * i as f64).collect()),
        ("radius", kept.iter().map(|&i| head.radius_at(i)).collect()),
        ("curvature", scalar(&fields.curvature)),
        ("twist_rate", scalar(&fields.twist_rate)),
    ];
    (vector(&rod.positions), VtkRod { points: &[], closed: head.closed, scalars, vectors })
}

/// Units of the arrays at the points.
fn point_units(units: &Units) -> [(&'static str, String); 9] {
    const DIMENSIONS: [(&str, &str); 9] = [
        ("Points", "L"),
        ("arc_length", "L"),
        ("radius", "L"),
        ("curvature", "1/L"),
        ("twist_rate", "rad/L"),
        ("smoothed_contact_force_per_length", "F/L"),
        ("contact_force_on_node", "F"),
        ("internal_force", "F"),
        ("internal_moment", "F L"),
    ];
    DIMENSIONS.map(|(name, dimension)| (name, units.of(dimension)))
}
