//! Base pairs of a molecule, and the files that programs for DNA read: oxDNA, XYZ, frames as NumPy arrays.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use crate::dna::HELICAL_REPEAT;
use crate::dna::sequence::Sequence;
use crate::error::InputError;
use crate::math::quaternion::spin;
use crate::math::shape_functions::lagrange;
use crate::math::{Mat3, Quat, Vec3};

/// oxDNA's unit of length, nm.
const OXDNA_LENGTH: f64 = 0.8518;
/// Distance of a nucleotide's centre from the helix axis in oxDNA, its units.
const OXDNA_OFFSET: f64 = 0.6;
/// Side of the simulation box over the largest extent of the molecule: room to turn and to open.
const BOX: f64 = 2.0;

/// Places (nm) and frames of base pairs: d1 to the major groove, d2 to the strand that is read, d3 along it from 5′ to
/// 3′.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BasePairs {
    /// Origins, nm.
    pub positions: Vec<Vec3>,
    /// Frames.
    pub frames: Vec<Quat>,
    /// The last pair is followed by the first.
    pub closed: bool,
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
    /// Closed rods: link Tw + Wr of the frames, turns; the frame at the end is the first turned by it.
    pub closed: Option<f64>,
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

    /// Turns of the frames about d3 along the rod.
    fn twist(&self) -> f64 {
        let turn = |k: usize| (self.node(k).1.inverse() * self.node(k + 1).1).scaled_axis().z;
        (0..self.num_segments()).map(turn).sum::<f64>() / TAU
    }
}

impl BasePairs {
    /// `count` base pairs evenly along a rod: of a closed one the first lies at s = 0, of an open one also the last at
    /// its end.
    ///
    /// A rod whose frames carry the double helix, as that of a sequence, hands them on. Others model the axis alone: they
    /// have less than half of a turn per [`HELICAL_REPEAT`] base pairs, and the helix is put in, evenly, with the whole
    /// number of turns in a closed molecule that is next to pairs / [`HELICAL_REPEAT`] + link of the frames.
    ///
    /// # Errors
    /// Fewer than two base pairs; nodes that are none of a rod of that order.
    pub fn along(nodes: &Nodes, count: usize) -> Result<Self, InputError> {
        if count < 2 {
            let field = "number of base pairs".to_owned();
            return Err(InputError::Count { field, value: count, allowed: "at least 2" });
        }
        let segments = nodes.num_segments();
        let whole = (1..=3).contains(&nodes.order) && segments > 0 && segments.is_multiple_of(nodes.order);
        if !whole || nodes.frames.len() != nodes.positions.len() {
            let allowed = "a multiple of the order (plus 1 if open), with as many frames";
            return Err(InputError::Count { field: "nodes".to_owned(), value: nodes.positions.len(), allowed });
        }
        let steps = if nodes.closed.is_some() { count } else { count - 1 };
        let natural = steps as f64 / HELICAL_REPEAT;
        let added = match nodes.closed {
            _ if nodes.twist() > 0.5 * natural => 0.0,
            Some(link) => (natural + link).round() - link,
            None => natural,
        };
        let pair = |k: usize| {
            let (position, frame) = nodes.at(k as f64 / steps as f64);
            (position, frame * spin(TAU * added * (k as f64 / steps as f64)))
        };
        let (positions, frames) = (0..count).map(pair).unzip();
        Ok(Self { positions, frames, closed: nodes.closed.is_some() })
    }

    /// Centres of the nucleotides of the strand that is read and of the other one, nm, in the order of the pairs.
    #[must_use]
    pub fn strands(&self) -> [Vec<Vec3>; 2] {
        [1.0, -1.0].map(|side| {
            let centre = |(r, q): (&Vec3, &Quat)| r + q * Vec3::y() * (side * OXDNA_OFFSET * OXDNA_LENGTH);
            self.positions.iter().zip(&self.frames).map(centre).collect()
        })
    }

    /// oxDNA's configuration: the strand that is read, then the other one, each from its 3′ end to its 5′ end.
    ///
    /// A nucleotide's a1 points to the axis, its a3 to the 5′ end; velocities are 0.
    #[must_use]
    pub fn oxdna_configuration(&self) -> String {
        let extent = |k: usize| {
            let range = self.positions.iter().fold([f64::MAX, f64::MIN], |[a, b], r| [a.min(r[k]), b.max(r[k])]);
            range[1] - range[0]
        };
        let side = BOX * ((0..3).map(extent).fold(0.0, f64::max) / OXDNA_LENGTH + 2.0 * OXDNA_OFFSET + 1.0);
        let mut text = format!("t = 0\nb = {side} {side} {side}\nE = 0 0 0\n");
        let mut add = |k: usize, sign: f64| {
            let (a1, a3) = (self.frames[k] * Vec3::y() * -sign, self.frames[k] * Vec3::z() * -sign);
            let r = self.positions[k] / OXDNA_LENGTH - a1 * OXDNA_OFFSET;
            for v in [r, a1, a3] {
                // writing to a string does not fail
                let _ = write!(text, "{:?} {:?} {:?} ", v.x, v.y, v.z);
            }
            text.push_str("0 0 0 0 0 0\n");
        };
        (0..self.positions.len()).rev().for_each(|k| add(k, 1.0));
        (0..self.positions.len()).for_each(|k| add(k, -1.0));
        text
    }

    /// oxDNA's topology in its classic form (3′ to 5′), for [`BasePairs::oxdna_configuration`].
    ///
    /// # Errors
    /// A sequence of another length.
    pub fn oxdna_topology(&self, sequence: &Sequence) -> Result<String, InputError> {
        let count = self.positions.len();
        if sequence.num_bases() != count {
            let reason = format!("has {} bases, but there are {count} base pairs", sequence.num_bases());
            return Err(InputError::Inconsistent { field: "sequence".to_owned(), reason });
        }
        let letters = sequence.letters();
        let other: String = letters.chars().map(complement).collect();
        let mut text = format!("{} 2\n", 2 * count);
        for (strand, bases) in [letters.chars().rev().collect::<String>(), other].iter().enumerate() {
            let first = strand * count;
            for (k, base) in bases.chars().enumerate() {
                let beside = |inside: bool, index: usize, wrapped: usize| match (inside, self.closed) {
                    (true, _) => (first + index).to_string(),
                    (false, true) => (first + wrapped).to_string(),
                    (false, false) => "-1".to_owned(),
                };
                let n3 = beside(k > 0, k.saturating_sub(1), count - 1);
                let n5 = beside(k + 1 < count, k + 1, 0);
                let _ = writeln!(text, "{} {base} {n3} {n5}", strand + 1);
            }
        }
        Ok(text)
    }

    /// Base pairs of a configuration of two strands, as [`BasePairs::oxdna_configuration`] writes them.
    ///
    /// # Errors
    /// [`InputError::Parse`] naming the line of what is no such configuration.
    pub fn from_oxdna(text: &str, closed: bool) -> Result<Self, InputError> {
        let refuse = |line: usize, reason: &str| InputError::Parse {
            file: "oxDNA configuration".to_owned(),
            reason: format!("line {line}: {reason}"),
        };
        let mut rows = Vec::new();
        for (number, line) in (1..).zip(text.lines()).skip(3).filter(|(_, line)| !line.trim().is_empty()) {
            let cells: Vec<f64> = line.split_whitespace().filter_map(|cell| cell.parse().ok()).collect();
            let Some(&[x, y, z, ax, ay, az, cx, cy, cz]) = cells.first_chunk::<9>() else {
                return Err(refuse(number, "position, a1 and a3 expected: nine numbers or more"));
            };
            rows.push([Vec3::new(x, y, z), Vec3::new(ax, ay, az), Vec3::new(cx, cy, cz)]);
        }
        if rows.is_empty() || rows.len() % 2 == 1 {
            return Err(refuse(text.lines().count(), "two strands of as many nucleotides expected"));
        }
        let count = rows.len() / 2;
        let mut pairs = Self { closed, ..Self::default() };
        for k in 0..count {
            let ([r, a1, a3], [other, ..]) = (&rows[count - 1 - k], &rows[count + k]);
            let (d2, d3) = (-a1, -a3);
            pairs.positions.push((r + other) * (0.5 * OXDNA_LENGTH));
            let frame = Mat3::from_columns(&[d2.cross(&d3), d2, d3]);
            pairs.frames.push(Quat::from_matrix(&frame));
        }
        Ok(pairs)
    }

    /// XYZ, one point a base pair, nm: what tacoxDNA reads as a centreline (the first line the number of points, the
    /// second a comment).
    #[must_use]
    pub fn xyz(&self) -> String {
        let mut text = format!("{}\nbase pairs, nm\n", self.positions.len());
        for r in &self.positions {
            let _ = writeln!(text, "C {:?} {:?} {:?}", r.x, r.y, r.z);
        }
        text
    }

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

    /// Writes one of the texts or arrays above, replacing what is there.
    ///
    /// # Errors
    /// [`InputError::Write`].
    pub fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
        std::fs::write(path, content).map_err(refuse)
    }
}

fn complement(base: char) -> char {
    match base {
        'A' => 'T',
        'C' => 'G',
        'G' => 'C',
        _ => 'A',
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::link::{link_numbers, linking_number};
    use crate::rod::{Natural, Rod, Section, Shape};

    fn ring(link: f64, count: usize) -> BasePairs {
        let circle = Shape::Circle { length: 0.34 * count as f64, center: Vec3::new(1.0, 2.0, 3.0), normal: Vec3::y() };
        let section = Section::isotropic(200.0, 300.0, 1e3, 1e3, 0.0);
        let rod = Rod::new("ring", &circle, true, section, 40, 3, Natural::Straight).unwrap();
        let rod = rod.with_excess_link(link).unwrap();
        let nodes = Nodes { positions: &rod.positions, frames: &rod.frames, order: 3, closed: Some(link) };
        BasePairs::along(&nodes, count).unwrap()
    }

    /// 336 base pairs have 32 turns at rest; the strands of the written molecule are linked so often, and their excess.
    #[test]
    fn strands_are_linked_as_imposed() {
        for (link, turns) in [(0.0, 32), (-3.0, 29), (2.0, 34), (-0.4, 32)] {
            let pairs = ring(link, 336);
            let [a, b] = pairs.strands();
            assert_eq!(linking_number(&a, &b).round() as i32, turns, "{link}");
            let d1: Vec<Vec3> = pairs.frames.iter().map(|q| q * Vec3::x()).collect();
            let numbers = link_numbers(&pairs.positions, &d1, 0.0);
            assert!((numbers.link - f64::from(turns)).abs() < 1e-6, "{numbers:?}");
        }
    }

    #[test]
    fn configurations_read_back() {
        let pairs = ring(-3.0, 336);
        let text = pairs.oxdna_configuration();
        assert_eq!(text.lines().count(), 3 + 2 * 336);
        let back = BasePairs::from_oxdna(&text, true).unwrap();
        for k in 0..336 {
            assert!((back.positions[k] - pairs.positions[k]).norm() < 1e-12, "{k}");
            assert!(back.frames[k].angle_to(&pairs.frames[k]) < 1e-7, "{k}");
        }
        let refused = BasePairs::from_oxdna("t = 0\nb = 1 1 1\nE = 0 0 0\n1 2 3\n", true).unwrap_err().to_string();
        assert!(refused.contains("line 4: position, a1 and a3 expected"), "{refused}");
    }

    /// Partners face each other across the axis, neighbours are listed from 3′ to 5′, and a3 points to the 5′ end.
    #[test]
    fn oxdna_conventions() {
        let sequence = Sequence::parse("AACGT").unwrap();
        let pairs = BasePairs {
            positions: (0..5).map(|k| Vec3::z() * (0.34 * f64::from(k))).collect(),
            frames: vec![Quat::identity(); 5],
            closed: false,
        };
        let topology = pairs.oxdna_topology(&sequence).unwrap();
        let lines: Vec<&str> = topology.lines().collect();
        assert_eq!(lines[..4], ["10 2", "1 T -1 1", "1 G 0 2", "1 C 1 3"]);
        assert_eq!(lines[5..8], ["1 A 3 -1", "2 T -1 6", "2 T 5 7"]);
        let configuration = pairs.oxdna_configuration();
        let row = |k: usize| -> Vec<f64> {
            configuration.lines().nth(3 + k).unwrap().split(' ').map(|cell| cell.parse().unwrap()).collect()
        };
        // the first listed is the last of the strand that is read: at +d2, looking back to the axis and to its 5′ end
        assert_eq!(row(0)[..9], [0.0, 0.6, 4.0 * 0.34 / OXDNA_LENGTH, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0]);
        assert_eq!(row(5)[..9], [0.0, -0.6, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let closed = BasePairs { closed: true, ..pairs.clone() }.oxdna_topology(&sequence).unwrap();
        assert_eq!([1, 5, 6, 10].map(|k| closed.lines().nth(k).unwrap()), ["1 T 4 1", "1 A 3 0", "2 T 9 6", "2 A 8 5"]);
        let short = Sequence::parse("AAC").unwrap();
        assert!(pairs.oxdna_topology(&short).unwrap_err().to_string().contains("has 3 bases, but there are 5"));
    }

    #[test]
    fn arrays_and_points() {
        let pairs = ring(0.0, 50);
        let bytes = pairs.npy();
        let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + header) % 64, 0);
        let text = std::str::from_utf8(&bytes[10..10 + header]).unwrap();
        assert_eq!(text.trim_end(), "{'descr': '<f8', 'fortran_order': False, 'shape': (50, 4, 3), }");
        assert_eq!(bytes.len(), 10 + header + 50 * 12 * 8);
        let number = |k: usize| f64::from_le_bytes(bytes[10 + header + 8 * k..][..8].try_into().unwrap());
        assert_eq!([12, 13, 14].map(number), <[f64; 3]>::from(pairs.positions[1]));
        assert_eq!([21, 22, 23].map(number), <[f64; 3]>::from(pairs.frames[1] * Vec3::z()));
        assert!(pairs.xyz().starts_with("50\nbase pairs, nm\nC ") && pairs.xyz().lines().count() == 52);
    }
}
