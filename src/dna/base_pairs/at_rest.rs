//! Base pairs on the rod that models them: where each lies on the rod at rest, so that states of the rod give states of
//! the base pairs.
//!
//! A rod interpolates between its nodes, base pairs do not: their steps jump. So a base pair is not read off the
//! interpolation. It has a place and a frame relative to the rod there, which are those at rest: the stress-free rod
//! with its nodes on their places, interpolated by the same elements. What elements interpolate is then the deformation
//! alone. A rod at rest gives back its own steps exactly, on any mesh, and in blocks of steps too.

use std::fmt::Write as _;
use std::path::Path;

use super::{BasePairs, Nodes};
use crate::dna::HELICAL_REPEAT;
use crate::dna::pose::parameters;
use crate::dna::sequence::{Helix, PARAMETERS, Sequence};
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::rest::rest_poses;
use crate::text::{NumberTable, read_regular};

/// Columns of the file after `base` and `rod`: place and frame relative to the rod, in the frame of the rod.
const PLACE: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

/// The base pairs of a rod at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct AtRest {
    /// The bases.
    pub sequence: Sequence,
    /// Tilt, roll, twist (degrees), shift, slide, rise (Å) of every step at rest; of a closed molecule also the last
    /// one, back to the first pair.
    pub steps: Vec<[f64; 6]>,
    /// Frame and place (nm) of every base pair as seen from the rod there.
    on_rod: Vec<(Quat, Vec3)>,
}

/// Largest deviation of steps from those at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepDeviation {
    /// Of tilt, roll and twist, degrees.
    pub degrees: f64,
    /// Of shift, slide and rise, Å.
    pub angstroms: f64,
}

impl std::fmt::Display for StepDeviation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.2}° and {:.3} Å", self.degrees, self.angstroms)
    }
}

impl AtRest {
    /// Of a rod with these segments in elements of an order; `None` if the molecule has no constant piece a step.
    pub(crate) fn new(helix: &Helix, closed: bool, order: usize, segments: usize) -> Option<Self> {
        let pairs = helix.sequence.num_bases();
        let part = |k: usize, of: usize| helix.length * (k as f64 / of as f64);
        let nodes: Vec<f64> = (0..=segments).map(|k| part(k, segments)).collect();
        let arcs: Vec<f64> = (0..=helix.num_steps).map(|k| part(k, helix.num_steps)).collect();
        let (axis, exact) = (rest_poses(&helix.natural, &nodes)?, rest_poses(&helix.steps, &arcs)?);
        let (positions, frames): (Vec<Vec3>, Vec<Quat>) = axis.iter().map(|at| (at.position, at.frame)).unzip();
        let rod = Nodes {
            positions: &positions,
            frames: &frames,
            order,
            closed: None,
            turns_left_out: 0.0,
            helical_repeat: HELICAL_REPEAT,
        };
        let on_rod = |k: usize| {
            let (position, frame) = rod.at(k as f64 / helix.num_steps as f64);
            (frame.inverse() * exact[k].frame, frame.inverse() * (exact[k].position - position))
        };
        let step = |k: usize| {
            let (turn, shift) = exact[k].to(&exact[k + 1]);
            parameters(&turn, &shift)
        };
        debug_assert_eq!(pairs + usize::from(closed), helix.num_steps + 1);
        let (steps, on_rod) = ((0..helix.num_steps).map(step).collect(), (0..pairs).map(on_rod).collect());
        Some(Self { sequence: helix.sequence.clone(), steps, on_rod })
    }

    /// The base pairs of a state of the rod.
    ///
    /// # Errors
    /// A number of nodes that does not fit the order.
    pub fn along(&self, nodes: &Nodes) -> Result<BasePairs, InputError> {
        nodes.check()?;
        let pair = |(k, (turn, shift)): (usize, &(Quat, Vec3))| {
            let (position, frame) = nodes.at(k as f64 / self.steps.len() as f64);
            (position + frame * shift, frame * turn)
        };
        let (positions, frames) = self.on_rod.iter().enumerate().map(pair).unzip();
        let sequence = Some(self.sequence.clone());
        Ok(BasePairs { positions, frames, closed: nodes.closed.is_some(), sequence })
    }

    /// How far the steps of base pairs are from those at rest; twist by whole turns is none.
    #[must_use]
    pub fn deviation(&self, pairs: &BasePairs) -> StepDeviation {
        let mut most = StepDeviation { degrees: 0.0, angstroms: 0.0 };
        for (found, rest) in pairs.steps().iter().zip(&self.steps) {
            for i in 0..3 {
                let angle = found[i] - rest[i];
                most.degrees = most.degrees.max((angle - 360.0 * (angle / 360.0).round()).abs());
                most.angstroms = most.angstroms.max((found[i + 3] - rest[i + 3]).abs());
            }
        }
        most
    }

    /// The file of the base pairs of several rods: a line each, with the step that leads to it at rest (zeros for the
    /// first of an open molecule).
    pub(crate) fn table<'a>(rods: impl Iterator<Item = (usize, &'a Self)>) -> String {
        let mut text = format!("base,rod,{},{}\n", PLACE.join(","), PARAMETERS.join(","));
        for (rod, at_rest) in rods {
            let closed = at_rest.steps.len() == at_rest.on_rod.len();
            for (k, (base, (turn, shift))) in at_rest.sequence.letters().chars().zip(&at_rest.on_rod).enumerate() {
                let step = match k {
                    0 if closed => at_rest.steps[at_rest.steps.len() - 1],
                    0 => [0.0; 6],
                    _ => at_rest.steps[k - 1],
                };
                let _ = write!(text, "{base},{rod}");
                for x in [shift.x, shift.y, shift.z, turn.w, turn.i, turn.j, turn.k].iter().chain(&step) {
                    // writing to a string does not fail
                    let _ = write!(text, ",{x:?}");
                }
                text.push('\n');
            }
        }
        text
    }

    /// The base pairs of one rod in a file that [`AtRest::table`] has written; `None` if it has none.
    ///
    /// # Errors
    /// A file that cannot be read; the first illegal line.
    pub(crate) fn read(path: &Path, rod: usize, closed: bool) -> Result<Option<Self>, InputError> {
        let refuse = |reason: String| InputError::Parse { file: path.display().to_string(), reason };
        let table = NumberTable::parse_with(&read_regular(path)?, Some("base")).map_err(refuse)?;
        let column = |name: &str| {
            table.column(name).ok_or_else(|| refuse(format!("line {}: there is no column {name}", table.head)))
        };
        let index = column("rod")?;
        let places = PLACE.iter().map(|name| column(name)).collect::<Result<Vec<_>, _>>()?;
        let steps = PARAMETERS.iter().map(|name| column(name)).collect::<Result<Vec<_>, _>>()?;
        let (mut letters, mut on_rod, mut all) = (String::new(), Vec::new(), Vec::new());
        for ((_, row), word) in table.rows.iter().zip(&table.words).filter(|((_, row), _)| row[index] == rod as f64) {
            let at = |k: usize| row[places[k]];
            letters.push_str(word);
            let turn = Quat::new_normalize(nalgebra::Quaternion::new(at(3), at(4), at(5), at(6)));
            on_rod.push((turn, Vec3::new(at(0), at(1), at(2))));
            all.push(std::array::from_fn(|i| row[steps[i]]));
        }
        if on_rod.is_empty() {
            return Ok(None);
        }
        // a line has the step that leads to it
        all.rotate_left(1);
        if !closed {
            all.pop();
        }
        let sequence = Sequence::parse(&letters).map_err(|error| refuse(error.to_string()))?;
        Ok(Some(Self { sequence, steps: all, on_rod }))
    }
}
