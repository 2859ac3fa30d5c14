//! `modes.vtp`, `modes.html`, `modes.png`: the softest modes of the final state.

mod picture;

use std::path::PathBuf;

use crate::error::InputError;
use crate::io::view::{Film, FilmRod, FilmTable, Frame, FrameRod};
use crate::io::vtk::{VtkRod, VtkStep, write_vtp};
use crate::math::Vec3;
use crate::scene::Obstacle;
use crate::tangent::Modes;

use super::rods::RodHead;
use super::run::{RecordedFrame, RecordedRun, RodSnapshot, placements};
use super::{Writer, files};

/// Frames of a swing of a mode.
const SWING: usize = 16;
/// Amplitude of a swing over the size of the rods.
const AMPLITUDE: f64 = 0.08;

#[derive(Debug)]
pub(super) struct ModesWriter;

impl Writer for ModesWriter {
    fn last(&mut self, run: &RecordedRun, last: &RecordedFrame) -> Result<(), InputError> {
        write(run, last).map(drop)
    }
}

/// Writes the shapes of the modes, if there are any, at the nodes that the VTK files of steps have. A page shows them
/// swing, and a picture if the run has pictures. Returns the paths.
pub(super) fn write(run: &RecordedRun, frame: &RecordedFrame) -> Result<Vec<PathBuf>, InputError> {
    let Some(modes) = run.ending.answers.modes.as_ref().filter(|modes| !modes.modes.is_empty()) else {
        return Ok(Vec::new());
    };
    let names: Vec<[String; 3]> = (1..=modes.modes.len())
        .map(|k| [format!("mode_{k}"), format!("mode_{k}_rotation"), format!("eigenvalue_{k}")])
        .collect();
    let mut first = 0;
    let (mut points, mut nodes) = (Vec::new(), Vec::new());
    for (index, rod) in frame.rods.iter().enumerate() {
        let kept = run.vtk_nodes(&run.head(index, frame.step), rod);
        points.push(kept.iter().map(|&i| rod.positions[i]).collect::<Vec<Vec3>>());
        nodes.push(kept.iter().map(|&i| first + i).collect::<Vec<usize>>());
        first += rod.positions.len();
    }
    let mut rods = Vec::new();
    for ((points, nodes), head) in points.iter().zip(&nodes).zip(&run.rods) {
        let at = |list: &[Vec3]| nodes.iter().map(|&node| list[node]).collect::<Vec<_>>();
        let shapes = modes.modes.iter().zip(&names).flat_map(|(mode, [shape, rotation, _])| {
            [(shape.as_str(), at(&mode.displacements)), (rotation.as_str(), at(&mode.rotations))]
        });
        rods.push(VtkRod { points, closed: head.closed, scalars: Vec::new(), vectors: shapes.collect() });
    }
    let numbers = names.iter().zip(modes.eigenvalues()).map(|([_, _, name], value)| (name.as_str(), value));
    let files = [files::MODES, files::MODES_PAGE].map(|name| run.dir.join(name));
    write_vtp(&files[0], &rods, &VtkStep { numbers: numbers.collect(), units: Vec::new() })?;
    let film = film(run, frame, modes);
    film.save_page(&files[1])?;
    let mut written = Vec::from(files);
    if run.output.picture {
        let at = |k: usize| film.frames[k].rods.iter().map(|rod| rod.points.clone()).collect::<Vec<_>>();
        let far = |(k, value): (usize, f64)| (at(k * SWING + SWING / 4), format!("mode {}: {value:.4e}", k + 1));
        let ends: Vec<_> = modes.eigenvalues().enumerate().map(far).collect();
        written.push(picture::write(run, &at(0), &ends)?);
    }
    Ok(written)
}

/// Each mode through a swing, one after the other.
pub(super) fn film(run: &RecordedRun, frame: &RecordedFrame, modes: &Modes) -> Film {
    let positions = || frame.rods.iter().flat_map(|rod| &rod.positions);
    let centre = positions().sum::<Vec3>() / positions().count().max(1) as f64;
    let size = positions().map(|r| (r - centre).norm()).fold(0.0, f64::max);
    let (mut frames, mut rows) = (Vec::new(), Vec::new());
    for (index, (mode, eigenvalue)) in modes.modes.iter().zip(modes.eigenvalues()).enumerate() {
        let largest = mode.displacements.iter().map(Vec3::norm).fold(f64::MIN_POSITIVE, f64::max);
        for k in 0..SWING {
            let phase = k as f64 / SWING as f64;
            let amplitude = AMPLITUDE * size / largest * (std::f64::consts::TAU * phase).sin();
            let mut first = 0;
            let swung = |(rod, head): (&RodSnapshot, &RodHead)| {
                let moved = mode.displacements[first..].iter().zip(&rod.positions);
                let points: Vec<Vec3> = moved.map(|(by, r)| r + by * amplitude).collect();
                first += points.len();
                let zeros = vec![0.0; points.len()];
                FrameRod {
                    directions: vec![Vec3::zeros(); points.len()],
                    pressure: zeros.clone(),
                    curvature: zeros.clone(),
                    twist_rate: zeros,
                    radii: vec![head.radius()],
                    seam_turns: 0.0,
                    points,
                }
            };
            let rods = frame.rods.iter().zip(&run.rods).map(swung).collect();
            let placements = run.steps.last().map(placements);
            let at_start = || run.obstacles.iter().map(Obstacle::start).collect();
            let placements = placements.unwrap_or_else(at_start);
            frames.push(Frame { step: rows.len(), rods, forces: Vec::new(), placements });
            rows.push(vec![(index + 1) as f64, eigenvalue, phase]);
        }
    }
    let columns = ["mode", "eigenvalue", "phase"].map(|name| (name.to_owned(), String::new())).to_vec();
    let rods = run.rods.iter().map(|rod| FilmRod { name: rod.name.clone(), closed: rod.closed }).collect();
    let title = format!("softest modes {}", run.title).trim_end().to_owned();
    let table = FilmTable { columns, rows };
    let (units, obstacles) = (run.units.clone(), run.obstacles.clone());
    Film { title, units, rods, obstacles, frames, table, plots: Vec::new(), note: String::new() }
}
