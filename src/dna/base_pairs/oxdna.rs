//! oxDNA's configurations and topologies.

use std::fmt::Write as _;

use super::frames::frame;
use super::{BOX, BasePairs, OXDNA_LENGTH, OXDNA_OFFSET, complement};
use crate::dna::sequence::{Sequence, base};
use crate::error::InputError;
use crate::math::Vec3;
use crate::text::finite;

impl BasePairs {
    /// oxDNA's configuration: the strand of the sequence, then its complement, each from its 3′ end to its 5′ end.
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
    /// A sequence whose length is not the number of base pairs.
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
    /// Both orders are read, from 3′ to 5′ (classic) and from 5′ to 3′; a3 shows the order.
    ///
    /// # Errors
    /// The first illegal line.
    pub fn from_oxdna(text: &str, closed: bool) -> Result<Self, String> {
        let refuse = |line: usize, reason: &str| format!("line {line}: {reason}");
        let mut rows = Vec::new();
        for (number, line) in (1..).zip(text.lines()).skip(3).filter(|(_, line)| !line.trim().is_empty()) {
            let cells: Vec<f64> = line.split_whitespace().map_while(|cell| finite(cell).ok()).collect();
            let Some(&[x, y, z, ax, ay, az, cx, cy, cz]) = cells.first_chunk::<9>() else {
                return Err(refuse(number, "position, a1 and a3 expected: nine numbers or more"));
            };
            rows.push((number, [Vec3::new(x, y, z), Vec3::new(ax, ay, az), Vec3::new(cx, cy, cz)]));
        }
        if rows.is_empty() || rows.len() % 2 == 1 {
            return Err(refuse(text.lines().count(), "two strands of as many nucleotides expected"));
        }
        let count = rows.len() / 2;
        let mut pairs = Self { closed, ..Self::default() };
        for k in 0..count {
            let ((number, [r, a1, a3]), (_, [other, ..])) = (&rows[count - 1 - k], &rows[count + k]);
            let (d2, d3) = (-a1, -a3);
            pairs.positions.push((r + other) * (0.5 * OXDNA_LENGTH));
            pairs.frames.push(frame(&[d2.cross(&d3), d2, d3]).map_err(|reason| refuse(*number, &reason))?);
        }
        let along = |k: usize| (pairs.positions[k + 1] - pairs.positions[k]).dot(&(pairs.frames[k] * Vec3::z()));
        if (0..count - 1).map(along).sum::<f64>() < 0.0 {
            pairs.positions.reverse();
            pairs.frames.reverse();
        }
        Ok(pairs)
    }
}

/// The strand that is read of an oxDNA topology of two strands, letters from 5′ to 3′: the first of the file, in its
/// classic form (a line a nucleotide, 3′ to 5′) or in that since version 3.6 (a line a strand, 5′ to 3′). The second
/// strand must be its complement.
///
/// # Errors
/// The line of what is no such topology.
pub(crate) fn read_strand(text: &str) -> Result<String, String> {
    let mut lines = (1..).zip(text.lines().map(str::trim)).filter(|(_, line)| !line.is_empty());
    let (_, head) = lines.next().ok_or("is empty")?;
    let counts: Vec<usize> = head.split_whitespace().filter_map(|cell| cell.parse().ok()).collect();
    let [nucleotides, 2] = counts[..] else {
        return Err(format!("line 1: the number of nucleotides and two strands expected, found \"{head}\""));
    };
    let by_strand = head.ends_with("5->3");
    // strands as they are listed, and the line that each base is in
    let mut strands: [Vec<(usize, char)>; 2] = Default::default();
    for (number, line) in lines {
        let cells: Vec<&str> = line.split_whitespace().collect();
        let (strand, letters) = match (by_strand, &cells[..]) {
            (true, [letters, ..]) => (usize::from(!strands[0].is_empty()), *letters),
            (false, [strand, letter, _, _]) => (usize::from(*strand != "1"), *letter),
            _ => return Err(format!("line {number}: strand, base and its two neighbours expected, found \"{line}\"")),
        };
        for letter in letters.chars() {
            if base(letter).is_none() {
                return Err(format!("line {number}: \"{letter}\" is no base: A, C, G or T expected"));
            }
            strands[strand].push((number, letter.to_ascii_uppercase()));
        }
    }
    let [read, other] = &strands;
    if read.len() != other.len() || 2 * read.len() != nucleotides {
        let (found, partners) = (read.len(), other.len());
        return Err(format!(
            "strands of {found} and {partners} bases, but line 1 says {nucleotides} in all: two of one length expected"
        ));
    }
    // listed the same way round, so that the first of one strand is the partner of the last of the other
    for (&(line, letter), &(_, partner)) in other.iter().zip(read.iter().rev()) {
        if complement(partner) != letter {
            return Err(format!("line {line}: base {letter} faces {partner}, of which it is no complement"));
        }
    }
    let letters = read.iter().map(|(_, letter)| *letter);
    Ok(if by_strand { letters.collect() } else { letters.rev().collect() })
}
