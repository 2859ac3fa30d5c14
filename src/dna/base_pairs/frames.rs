//! Frames of base pairs: NumPy arrays, frames and step parameters of 3DNA.

use std::fmt::Write as _;

use super::BasePairs;
use crate::dna::pose::pose;
use crate::math::quaternion::rotation_of;
use crate::math::{Mat3, Quat, Vec3};
use crate::text::finite;
use crate::text::npy::NpyArray;

pub(super) use crate::text::npy::MAGIC;

/// Å per nm.
const ANGSTROMS: f64 = 10.0;
/// Largest deviation of the axes of a frame from unit length and right angles, because files have three decimals.
const TOL_FRAME: f64 = 5e-3;
/// Names of step parameters in 3DNA's order.
const STEP: [&str; 6] = ["Shift", "Slide", "Rise", "Tilt", "Roll", "Twist"];
/// Names of the intra-base-pair parameters, which are 0 here.
const PAIR: [&str; 6] = ["Shear", "Stretch", "Stagger", "Buckle", "Prop-Tw", "Opening"];

impl BasePairs {
    /// A NumPy array (`.npy`, version 1.0) of shape (pairs, 4, 3), nm: origin, d1, d2, d3 of each, as mdna has frames.
    #[must_use]
    pub fn npy(&self) -> Vec<u8> {
        let shape = format!("({}, 4, 3)", self.positions.len());
        let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        // magic, version, length of the header and the header fill whole blocks of 64 bytes
        header.push_str(&" ".repeat((64 - (10 + header.len() + 1) % 64) % 64));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        for (r, q) in self.positions.iter().zip(&self.frames) {
            for v in [*r, q * Vec3::x(), q * Vec3::y(), q * Vec3::z()] {
                bytes.extend([v.x, v.y, v.z].iter().flat_map(|x| x.to_le_bytes()));
            }
        }
        bytes
    }

    /// Base pairs of an array as [`BasePairs::npy`] writes it.
    ///
    /// # Errors
    /// Another shape; frames that are not orthonormal, by their index.
    pub(crate) fn from_npy(bytes: &[u8], closed: bool) -> Result<Self, String> {
        let NpyArray { shape, values } = NpyArray::parse(bytes)?;
        let [count, 4, 3] = shape[..] else { return Err(format!("has shape {shape:?}, not (pairs, 4, 3)")) };
        let vector = |k: usize| Vec3::new(values[3 * k], values[3 * k + 1], values[3 * k + 2]);
        let mut pairs = Self { closed, ..Self::default() };
        for k in 0..count {
            pairs.positions.push(vector(4 * k));
            let axes = [1, 2, 3].map(|axis| vector(4 * k + axis));
            pairs.frames.push(frame(&axes).map_err(|reason| format!("base pair {}: {reason}", k + 1))?);
        }
        Ok(pairs)
    }

    /// Frames as 3DNA has them in `ref_frames.dat`, Å: a line that numbers the pair, origin, x-, y- and z-axis.
    #[must_use]
    pub fn ref_frames(&self) -> String {
        let mut text = format!("{:>5} base-pairs\n", self.positions.len());
        for (k, (r, q)) in self.positions.iter().zip(&self.frames).enumerate() {
            let name = self.name(k);
            let _ = writeln!(text, "... {:>5} {name}", k + 1);
            let rows = [
                (r * ANGSTROMS, "origin"),
                (q * Vec3::x(), "x-axis"),
                (q * Vec3::y(), "y-axis"),
                (q * Vec3::z(), "z-axis"),
            ];
            for (v, name) in rows {
                let _ = writeln!(text, "{:>22.15} {:>22.15} {:>22.15}  # {name}", v.x, v.y, v.z);
            }
        }
        text
    }

    /// Base pairs of a text as [`BasePairs::ref_frames`] writes it.
    ///
    /// # Errors
    /// The first illegal line.
    pub(crate) fn from_ref_frames(text: &str, closed: bool) -> Result<Self, String> {
        let mut rows: Vec<(usize, Vec3)> = Vec::new();
        let lines = (1..).zip(text.lines()).skip(1);
        for (number, line) in lines {
            let content = line.split('#').next().unwrap_or_default().trim();
            if content.is_empty() || content.starts_with("...") {
                continue;
            }
            let cells = numbers(content).map_err(|reason| format!("line {number}: {reason}"))?;
            let [x, y, z] = cells[..] else {
                return Err(format!("line {number}: three numbers expected, found {}", cells.len()));
            };
            rows.push((number, Vec3::new(x, y, z)));
        }
        if rows.is_empty() || !rows.len().is_multiple_of(4) {
            return Err(format!("holds {} lines of three numbers, not four a base pair", rows.len()));
        }
        let mut pairs = Self { closed, ..Self::default() };
        for four in rows.chunks_exact(4) {
            pairs.positions.push(four[0].1 / ANGSTROMS);
            let axes = [four[1].1, four[2].1, four[3].1];
            pairs.frames.push(frame(&axes).map_err(|reason| format!("line {}: {reason}", four[1].0))?);
        }
        Ok(pairs)
    }

    /// Step parameters as 3DNA has them in `bp_step.par`: degrees and Å. A line has the step that leads to its pair. A
    /// closed molecule ends with its first pair once more: the step from the last pair back to it. The pose of the
    /// first pair is lost.
    #[must_use]
    pub fn par(&self) -> String {
        let (count, steps) = (self.positions.len(), self.steps());
        let lines = if self.closed { count + 1 } else { count };
        let mut text = format!("{lines:>5} # base-pairs\n    0 # ***local base-pair & step parameters***\n#       ");
        PAIR.iter().chain(&STEP).for_each(|name| text.push_str(&format!("{name:>19}")));
        for k in 0..lines {
            let [tilt, roll, twist, shift, slide, rise] = if k == 0 { [0.0; 6] } else { steps[k - 1] };
            let name = self.name(k % count);
            let _ = write!(text, "\n{name:<8}");
            [0.0; 6].iter().chain(&[shift, slide, rise, tilt, roll, twist]).for_each(|x| {
                let _ = write!(text, "{x:>19.12}");
            });
        }
        text.push('\n');
        text
    }

    /// Name of a pair as 3DNA has it, for example `A-T`; `N-N` where bases are not known.
    fn name(&self, k: usize) -> String {
        let [base, other] = self.bases(k).unwrap_or(['N', 'N']);
        format!("{base}-{other}")
    }

    /// Base pairs of step parameters, the first at the origin with the global axes. The header names the columns.
    ///
    /// # Errors
    /// The first illegal line.
    pub(crate) fn from_par(text: &str, closed: bool) -> Result<Self, String> {
        let mut lines = (1..).zip(text.lines()).skip(2);
        let (head, names) =
            lines.next().ok_or_else(|| "ends where the names of the columns are expected".to_owned())?;
        let names: Vec<&str> = names.trim_start_matches('#').split_whitespace().collect();
        let column = |name: &str| {
            let found = names.iter().position(|here| here.eq_ignore_ascii_case(name));
            found.ok_or_else(|| format!("line {head}: no column {name}; there are {}", names.join(", ")))
        };
        let mut columns = [0; 6];
        for (place, name) in columns.iter_mut().zip(["Tilt", "Roll", "Twist", "Shift", "Slide", "Rise"]) {
            *place = column(name)?;
        }
        let mut pairs = Self { closed, ..Self::default() };
        let (mut position, mut turned) = (Vec3::zeros(), Quat::identity());
        for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            // the first cell names the pair
            let cells = line.trim().split_once(char::is_whitespace).map_or("", |(_, cells)| cells);
            let cells = numbers(cells).map_err(|reason| format!("line {number}: {reason}"))?;
            if cells.len() != names.len() {
                return Err(format!("line {number}: {} numbers expected, found {}", names.len(), cells.len()));
            }
            if !pairs.positions.is_empty() {
                let (turn, shift) = pose(&columns.map(|place| cells[place]));
                position += turned * shift;
                turned *= turn;
            }
            pairs.positions.push(position);
            pairs.frames.push(turned);
        }
        if closed && pairs.comes_round() {
            pairs.positions.pop();
            pairs.frames.pop();
        }
        if pairs.positions.len() < 2 {
            return Err("holds less than two base pairs".to_owned());
        }
        Ok(pairs)
    }
}

impl BasePairs {
    /// Whether the last pair is the first once more: much nearer to it than to the one before.
    fn comes_round(&self) -> bool {
        let r = &self.positions;
        let [first, .., before, last] = &r[..] else { return false };
        (last - first).norm() < 0.1 * (last - before).norm()
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split_whitespace().map(finite).collect()
}

/// The frame with these axes, made orthonormal.
pub(super) fn frame(axes: &[Vec3; 3]) -> Result<Quat, String> {
    let matrix = Mat3::from_columns(axes);
    let off = (matrix.transpose() * matrix - Mat3::identity()).amax();
    if off.is_finite() && off <= TOL_FRAME && matrix.determinant() > 0.0 {
        return rotation_of(&matrix).ok_or_else(|| "axes that are no frame".to_owned());
    }
    Err(format!("axes that are no right-handed unit frame (off by {off:.1e})"))
}
