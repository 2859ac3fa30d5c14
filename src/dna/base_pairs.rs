//! Base pairs of a molecule, and their file formats: oxDNA, XYZ, VECT, PDB, frames as NumPy arrays, 3DNA's frames and
//! step parameters.

mod at_rest;
mod frames;
pub(super) mod oxdna;
mod points;

use std::f64::consts::TAU;
use std::path::Path;

use crate::dna::pose::parameters;
use crate::dna::sequence::Sequence;
use crate::error::InputError;
use crate::math::quaternion::spin;
use crate::math::shape_functions::lagrange;
use crate::math::{Quat, Vec3};
use crate::text::read_regular_bytes;

pub use at_rest::{AtRest, StepDeviation};

/// oxDNA's unit of length, nm.
const OXDNA_LENGTH: f64 = 0.8518;
/// Distance of a nucleotide's centre from the helix axis in oxDNA, its units.
const OXDNA_OFFSET: f64 = 0.6;
/// Side of the simulation box over the largest extent of the molecule, because it must be free to rotate and to open.
const BOX: f64 = 2.0;

/// Origins (nm) and frames of base pairs: d1 to the major groove, d2 to the strand of the sequence, d3 along it from 5′
/// to 3′.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BasePairs {
    /// Origins, nm.
    pub positions: Vec<Vec3>,
    /// Frames.
    pub frames: Vec<Quat>,
    /// Whether the first pair follows the last.
    pub closed: bool,
    /// The bases, where they are known: files name them.
    pub sequence: Option<Sequence>,
}

/// The nodes of a rod as its elements interpolate them.
#[derive(Debug, Clone, Copy)]
pub struct Nodes<'a> {
    /// Positions, nm.
    pub positions: &'a [Vec3],
    /// Frames.
    pub frames: &'a [Quat],
    /// Order of the elements, 1 to 3.
    pub order: usize,
    /// Closed rods: link Tw + Wr of the frames, turns; the frame at the end is the first one rotated by it.
    pub closed: Option<f64>,
    /// Turns of the double helix that the frames leave out, where the rod says so itself; else 0.
    pub turns_left_out: f64,
    /// Base pairs a turn of the double helix that is put into a rod which models the axis alone;
    /// [`HELICAL_REPEAT`](crate::dna::HELICAL_REPEAT) of DNA in solution.
    pub helical_repeat: f64,
}

impl Nodes<'_> {
    fn node(&self, index: usize) -> (Vec3, Quat) {
        match (self.positions.get(index), self.closed) {
            (None, Some(link)) => (self.positions[0], self.frames[0] * spin(TAU * link)),
            _ => (self.positions[index], self.frames[index]),
        }
    }

    fn num_segments(&self) -> usize {
        if self.closed.is_some() { self.positions.len() } else { self.positions.len().saturating_sub(1) }
    }

    /// Position and frame at a fraction of the length.
    fn at(&self, fraction: f64) -> (Vec3, Quat) {
        let elements = self.num_segments() / self.order;
        let x = fraction * elements as f64;
        let element = (x as usize).min(elements - 1);
        let weights = lagrange(self.order, x - element as f64).0;
        let first = self.node(element * self.order);
        let (mut position, mut sum, mut before) = (Vec3::zeros(), nalgebra::Vector4::zeros(), first.1.coords);
        for (a, weight) in weights.iter().enumerate().take(self.order + 1) {
            let (r, q) = self.node(element * self.order + a);
            let aligned = if before.dot(&q.coords) < 0.0 { -q.coords } else { q.coords };
            position += r * *weight;
            sum += aligned * *weight;
            before = aligned;
        }
        (position, Quat::new_normalize(nalgebra::Quaternion::from(sum)))
    }

    /// Refuses a number of nodes that does not fit the order.
    fn check(&self) -> Result<(), InputError> {
        let segments = self.num_segments();
        let whole = (1..=3).contains(&self.order) && segments > 0 && segments.is_multiple_of(self.order);
        if whole && self.frames.len() == self.positions.len() {
            return Ok(());
        }
        let allowed = "a multiple of the order (plus 1 if open), with as many frames";
        Err(InputError::Count { field: "nodes".to_owned(), value: self.positions.len(), allowed })
    }

    /// Twist of the frames along the rod, turns.
    fn twist(&self) -> f64 {
        let turn = |k: usize| (self.node(k).1.inverse() * self.node(k + 1).1).scaled_axis().z;
        (0..self.num_segments()).map(turn).sum::<f64>() / TAU
    }
}

impl BasePairs {
    /// `count` equally spaced base pairs along a rod. The first lies at s = 0, the last of an open rod at its end.
    ///
    /// A rod whose frames carry the double helix, as that of a sequence, hands them on; one in blocks is given back the
    /// turns that it left out. Others model the axis alone: they have less than half of a turn per
    /// [`Nodes::helical_repeat`] base pairs, and the helix is put in, evenly, with the whole number of turns in a
    /// closed molecule that is next to pairs / repeat + link of the frames.
    ///
    /// # Errors
    /// Fewer than two base pairs; a number of nodes that does not fit the order.
    pub fn along(nodes: &Nodes, count: usize) -> Result<Self, InputError> {
        if count < 2 {
            let field = "number of base pairs".to_owned();
            return Err(InputError::Count { field, value: count, allowed: "at least 2" });
        }
        nodes.check()?;
        InputError::positive("helical_repeat", nodes.helical_repeat)?;
        let steps = if nodes.closed.is_some() { count } else { count - 1 };
        let natural = steps as f64 / nodes.helical_repeat;
        let added = match nodes.closed {
            _ if nodes.turns_left_out != 0.0 => nodes.turns_left_out,
            _ if nodes.twist() > 0.5 * natural => 0.0,
            Some(link) => (natural + link).round() - link,
            None => natural,
        };
        let pair = |k: usize| {
            let (position, frame) = nodes.at(k as f64 / steps as f64);
            (position, frame * spin(TAU * added * (k as f64 / steps as f64)))
        };
        let (positions, frames) = (0..count).map(pair).unzip();
        Ok(Self { positions, frames, closed: nodes.closed.is_some(), sequence: None })
    }

    /// The same with its bases.
    ///
    /// # Errors
    /// [`InputError::Inconsistent`] for another number of bases than of pairs.
    pub fn with_sequence(self, sequence: Sequence) -> Result<Self, InputError> {
        let count = self.positions.len();
        if sequence.num_bases() != count {
            let reason = format!("has {} bases, but there are {count} base pairs", sequence.num_bases());
            return Err(InputError::inconsistent("sequence", reason));
        }
        Ok(Self { sequence: Some(sequence), ..self })
    }

    /// Tilt, roll, twist (degrees), shift, slide, rise (Å) from every base pair to the next, of a closed molecule also
    /// from the last to the first.
    #[must_use]
    pub fn steps(&self) -> Vec<[f64; 6]> {
        let count = self.positions.len();
        let step = |k: usize| {
            let (next, back) = ((k + 1) % count, self.frames[k].inverse());
            parameters(&(back * self.frames[next]), &(back * (self.positions[next] - self.positions[k])))
        };
        (0..if self.closed { count } else { count.saturating_sub(1) }).map(step).collect()
    }

    /// Letters of pair k: of the strand of the sequence and of its complement; `None` where bases are not known.
    fn bases(&self, k: usize) -> Option<[char; 2]> {
        let base = self.sequence.as_ref()?.letter(k)?;
        Some([base, complement(base)])
    }

    /// Centres of the nucleotides of the strand of the sequence and of its complement, nm, in the order of the pairs.
    #[must_use]
    pub fn strands(&self) -> [Vec<Vec3>; 2] {
        [1.0, -1.0].map(|side| {
            let centre = |(r, q): (&Vec3, &Quat)| r + q * Vec3::y() * (side * OXDNA_OFFSET * OXDNA_LENGTH);
            self.positions.iter().zip(&self.frames).map(centre).collect()
        })
    }

    /// Base pairs of a file: `.npy` (frames as mdna has them), or a text whose first line identifies it as an oxDNA
    /// configuration (`t = …`), step parameters (`.par`) or frames (`ref_frames.dat`) of 3DNA.
    ///
    /// # Errors
    /// [`InputError::File`] if it cannot be read; [`InputError::Parse`] with line and value for other contents.
    pub fn read(path: &Path, closed: bool) -> Result<Self, InputError> {
        let refuse = |reason: String| InputError::Parse { file: path.display().to_string(), reason };
        let bytes = read_regular_bytes(path)?;
        if bytes.starts_with(frames::MAGIC) {
            return Self::from_npy(&bytes, closed).map_err(refuse);
        }
        let text = String::from_utf8(bytes).map_err(|e| refuse(e.to_string()))?;
        let first = text.lines().next().unwrap_or_default();
        let read = match first {
            _ if first.trim_start().starts_with('t') => Self::from_oxdna(&text, closed),
            _ if first.contains("base-pairs") && text.contains("step parameters") => Self::from_par(&text, closed),
            _ => Self::from_ref_frames(&text, closed),
        };
        read.map_err(refuse)
    }

    /// Frames of the axis, for a rod that is straight when stress-free: the double helix of `repeat` base pairs a turn
    /// is removed uniformly.
    #[must_use]
    pub fn unwound(mut self, repeat: f64) -> Self {
        for (k, frame) in self.frames.iter_mut().enumerate() {
            *frame *= spin(-TAU * k as f64 / repeat);
        }
        self
    }

    /// Writes one of the texts or arrays above to a file, replacing an existing one.
    ///
    /// # Errors
    /// [`InputError::Write`].
    pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
        std::fs::write(path, content).map_err(refuse)
    }
}

/// The base that pairs with another.
fn complement(base: char) -> char {
    match base {
        'A' => 'T',
        'C' => 'G',
        'G' => 'C',
        _ => 'A',
    }
}

#[cfg(test)]
mod tests;
