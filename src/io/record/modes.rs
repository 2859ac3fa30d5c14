//! Softest modes in the record: shapes for ParaView, eigenvalues for the summary.

use serde::Serialize;

use super::{Record, RecordedFrame, files};
use crate::error::InputError;
use crate::io::vtk::{VtkRod, VtkStep, write_vtp};
use crate::math::Vec3;
use crate::tangent::{Modes, Participation};

/// The part of `summary.json`.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ModesPart {
    /// Ascending, over B/L⁴ of the smallest bending stiffness and the longest rod.
    eigenvalues: Vec<f64>,
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
            unit: modes.unit,
            num_unstable: modes.num_unstable,
            num_zero_energy: modes.num_zero_energy,
            participation: modes.modes.iter().map(|mode| mode.participation).collect(),
        }
    }
}

impl Record {
    /// Writes the shapes of the modes, if there are any, at the nodes that the VTK files of steps have.
    pub(super) fn write_modes(&self, frame: &RecordedFrame) -> Result<(), InputError> {
        let Some(modes) = &self.answers.modes else { return Ok(()) };
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
        write_vtp(&self.dir.join(files::MODES), &rods, &VtkStep { numbers: numbers.collect(), units: Vec::new() })
    }
}
