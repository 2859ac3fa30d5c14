//! What the tangent says in the record: shapes of modes for ParaView and the browser, eigenvalues for the summary, a table
//! of sensitivities.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Record, RecordedFrame, RodSnapshot, files};
use crate::error::InputError;
use crate::io::asked::Answers;
use crate::io::csv::write_table;
use crate::io::view::{Film, FilmRod, FilmTable, Frame, FrameRod, GlbOptions};
use crate::io::vtk::{VtkRod, VtkStep, write_vtp};
use crate::math::Vec3;
use crate::scene::Scene;
use crate::tangent::{Modes, Participation};

/// The part of `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ModesPart {
    /// Ascending, over B/L⁴ of the smallest bending stiffness and the longest rod.
    eigenvalues: Vec<f64>,
    /// \[1/T\], where rods have masses; NaN of an unstable mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    frequencies: Option<Vec<f64>>,
    /// B/L⁴ \[F/L²\].
    unit: f64,
    num_unstable: usize,
    num_zero_energy: usize,
    participation: Vec<Participation>,
}

impl ModesPart {
    pub(super) fn of(modes: &Modes) -> Self {
        Self {
            eigenvalues: modes.eigenvalues().collect(),
            frequencies: modes.frequencies(),
            unit: modes.unit,
            num_unstable: modes.num_unstable,
            num_zero_energy: modes.num_zero_energy,
            participation: modes.modes.iter().map(|mode| mode.participation).collect(),
        }
    }
}

/// Frames of a swing of a mode.
const SWING: usize = 16;
/// Amplitude of a swing over the size of the rods.
const AMPLITUDE: f64 = 0.08;

impl Record {
    /// Writes answers for the final state of a run, whose other files stay as they are, and with `glb` the modes as a binary
    /// glTF file. Returns their paths.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn write_answers(
        scene: &Scene,
        dir: &Path,
        rods: Vec<RodSnapshot>,
        (answers, glb): (Answers, Option<&Path>),
    ) -> Result<Vec<PathBuf>, InputError> {
        let mut record = Self::open(scene, dir)?;
        record.answers = answers;
        let frame = RecordedFrame { step: 0, rods, sites: Vec::new() };
        let mut written = record.write_modes(&frame)?;
        if let (Some(file), Some(modes)) = (glb, &record.answers.modes) {
            record.film_of_modes(&frame, modes).save_glb(file, &GlbOptions::default())?;
            written.push(file.to_owned());
        }
        written.extend(record.write_sensitivities()?);
        Ok(written)
    }

    /// Writes derivatives, if there are any: a line each, with row and strain those of a table.
    pub(super) fn write_sensitivities(&self) -> Result<Option<PathBuf>, InputError> {
        let Answers { sensitivities, tables, .. } = &self.answers;
        if sensitivities.is_empty() && tables.is_empty() {
            return Ok(None);
        }
        let path = self.dir.join(files::SENSITIVITIES);
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

    /// Writes the shapes of the modes, if there are any, at the nodes that the VTK files of steps have, and a page that
    /// shows them swing.
    pub(super) fn write_modes(&self, frame: &RecordedFrame) -> Result<Vec<PathBuf>, InputError> {
        let Some(modes) = self.answers.modes.as_ref().filter(|modes| !modes.modes.is_empty()) else {
            return Ok(Vec::new());
        };
        let names: Vec<[String; 3]> = (1..=modes.modes.len())
            .map(|k| [format!("mode_{k}"), format!("mode_{k}_rotation"), format!("eigenvalue_{k}")])
            .collect();
        let mut first = 0;
        let (mut points, mut nodes) = (Vec::new(), Vec::new());
        for (index, rod) in frame.rods.iter().enumerate() {
            let kept = self.vtk_nodes(&self.head(index, frame.step), rod);
            points.push(kept.iter().map(|&i| rod.positions[i]).collect::<Vec<Vec3>>());
            nodes.push(kept.iter().map(|&i| first + i).collect::<Vec<usize>>());
            first += rod.positions.len();
        }
        let mut rods = Vec::new();
        for ((points, nodes), head) in points.iter().zip(&nodes).zip(&self.rods) {
            let at = |list: &[Vec3]| nodes.iter().map(|&node| list[node]).collect::<Vec<_>>();
            let shapes = modes.modes.iter().zip(&names).flat_map(|(mode, [shape, rotation, _])| {
                [(shape.as_str(), at(&mode.displacements)), (rotation.as_str(), at(&mode.rotations))]
            });
            rods.push(VtkRod { points, closed: head.closed, scalars: Vec::new(), vectors: shapes.collect() });
        }
        let numbers = names.iter().zip(modes.eigenvalues()).map(|([_, _, name], value)| (name.as_str(), value));
        let files = [files::MODES, files::MODES_PAGE].map(|name| self.dir.join(name));
        write_vtp(&files[0], &rods, &VtkStep { numbers: numbers.collect(), units: Vec::new() })?;
        let film = self.film_of_modes(frame, modes);
        film.save_page(&files[1])?;
        let mut written = Vec::from(files);
        if self.output.picture {
            let at = |k: usize| film.frames[k].rods.iter().map(|rod| rod.points.clone()).collect::<Vec<_>>();
            let far = |(k, value): (usize, f64)| (at(k * SWING + SWING / 4), format!("mode {}: {value:.4e}", k + 1));
            let ends: Vec<_> = modes.eigenvalues().enumerate().map(far).collect();
            written.push(self.write_picture_of_modes(&at(0), &ends)?);
        }
        Ok(written)
    }

    /// Each mode through a swing, one after the other.
    fn film_of_modes(&self, frame: &RecordedFrame, modes: &Modes) -> Film {
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
                let swung = |(rod, head): (&RodSnapshot, &super::RodHead)| {
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
                let rods = frame.rods.iter().zip(&self.rods).map(swung).collect();
                let placements = self.steps.last().map(super::placements);
                let at_start = || self.obstacles.iter().map(crate::scene::Obstacle::start).collect();
                let placements = placements.unwrap_or_else(at_start);
                frames.push(Frame { step: rows.len(), rods, forces: Vec::new(), placements });
                rows.push(vec![(index + 1) as f64, eigenvalue, phase]);
            }
        }
        let columns = ["mode", "eigenvalue", "phase"].map(|name| (name.to_owned(), String::new())).to_vec();
        let rods = self.rods.iter().map(|rod| FilmRod { name: rod.name.clone(), closed: rod.closed }).collect();
        let title = format!("softest modes {}", self.title).trim_end().to_owned();
        let table = FilmTable { columns, rows };
        let (units, obstacles) = (self.units.clone(), self.obstacles.clone());
        Film { title, units, rods, obstacles, frames, table, plots: Vec::new(), note: String::new() }
    }
}

/// Names of natural strains.
const STRAINS: [&str; 6] = ["gamma_1", "gamma_2", "gamma_3", "kappa_1", "kappa_2", "kappa_3"];
