//! Proteins on a sequence: frozen steps, steps with imposed parameters, rigid blocks between two frames.
//!
//! A held piece is ten thousand times as stiff as its DNA: it deforms by a ten-thousandth of a free piece, without a
//! constraint in the solver. A block is a piece of constant strain (a part of a helix) from the frame of one base pair
//! to that of another, also for contact.

use std::path::Path;

use super::pose::strains;
use crate::error::InputError;
use crate::rod::{NaturalStrains, Stiffness};
use crate::text::{NumberTable, read_regular};

use super::sequence::PARAMETERS;

/// Stiffness of a held piece over that of its DNA.
const RIGID: f64 = 1e4;

/// Constraint of a piece; the six parameters are tilt, roll, twist (degrees), shift, slide, rise (Å).
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hold {
    /// The parameters of the sequence.
    Frozen,
    /// The same parameters for each step.
    Steps([f64; 6]),
    /// Parameters from the first base pair of the piece to the last.
    Block([f64; 6]),
}

/// A piece that a protein holds.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    line: usize,
    /// First and last base pair, from 0.
    pairs: [usize; 2],
    hold: Hold,
}

/// The proteins of a molecule.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bound(Vec<Piece>);

impl Bound {
    /// Reads a table: CSV with the columns `hold`, `from`, `to`, `tilt`, `roll`, `twist`, `shift`, `slide`, `rise`, one
    /// protein (or part of one) a line. `from` and `to` are base pairs, counted from 1. `hold` is
    ///
    /// * `frozen`: the steps between them stay as the sequence has them; the six numbers are 0;
    /// * `steps`: each of these steps has the six numbers for parameters;
    /// * `block`: the six numbers are those of the base pair `to` as seen from `from`, as if that were one step.
    ///
    /// # Errors
    /// [`InputError::File`] if it cannot be read; [`InputError::Parse`] with line and value for other columns and
    /// words, base pairs that are no whole numbers or not in order, pieces that overlap.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let refuse = |reason: String| InputError::Parse { file: path.display().to_string(), reason };
        Self::parse(&read_regular(path)?).map_err(refuse)
    }

    /// [`Bound::read`] of a text.
    ///
    /// # Errors
    /// As there, without the file.
    pub fn parse(text: &str) -> Result<Self, String> {
        let table = NumberTable::parse_with(text, Some("hold"))?;
        let column = |name: &str| {
            let found = table.names.iter().position(|here| here == name);
            found.ok_or_else(|| format!("line {}: there is no column {name}", table.head))
        };
        let [from, to] = [column("from")?, column("to")?];
        let mut places = [0; 6];
        for (place, name) in places.iter_mut().zip(PARAMETERS) {
            *place = column(name)?;
        }
        let mut pieces: Vec<Piece> = Vec::new();
        for ((line, row), word) in table.rows.iter().zip(&table.words) {
            let line = *line;
            let numbers = places.map(|place| row[place]);
            let hold = match word.as_str() {
                "frozen" if numbers == [0.0; 6] => Hold::Frozen,
                "frozen" => return Err(format!("line {line}: frozen steps keep their parameters: give six zeros")),
                "steps" => Hold::Steps(numbers),
                "block" => Hold::Block(numbers),
                other => return Err(format!("line {line}: hold is \"{other}\": must be frozen, steps or block")),
            };
            let ends = [row[from], row[to]];
            let whole = ends.iter().all(|x| x.fract() == 0.0 && *x >= 1.0);
            if !whole || ends[0] >= ends[1] {
                let reason = "must be two base pairs, counted from 1, the first before the second";
                return Err(format!("line {line}: from {} to {}: {reason}", ends[0], ends[1]));
            }
            let pairs = ends.map(|x| x as usize - 1);
            if let Some(other) = pieces.iter().find(|other| pairs[0] < other.pairs[1] && other.pairs[0] < pairs[1]) {
                return Err(format!("line {line}: overlaps with line {}", other.line));
            }
            pieces.push(Piece { line, pairs, hold });
        }
        Ok(Self(pieces))
    }

    /// Applies the proteins to the steps of a molecule, each of length `spacing` (nm).
    pub(super) fn hold(
        &self,
        (natural, stiffness): (&mut [NaturalStrains], &mut [Stiffness]),
        spacing: f64,
        base_pairs: usize,
    ) -> Result<(), InputError> {
        for &Piece { line, pairs: [first, last], hold } in &self.0 {
            if last >= base_pairs {
                let reason = format!("line {line}: to {}, but there are {base_pairs} base pairs", last + 1);
                return Err(InputError::Inconsistent { field: "proteins".to_owned(), reason });
            }
            for k in first..last {
                stiffness[k] *= RIGID;
                match hold {
                    Hold::Frozen => {}
                    Hold::Steps(parameters) => natural[k] = strains(&parameters, spacing),
                    Hold::Block(parameters) => natural[k] = strains(&parameters, spacing * (last - first) as f64),
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dna::pose::pose;
    use crate::dna::sequence::{Sequence, Steps};
    use crate::math::{Quat, Vec3};

    const HEAD: &str = "hold, from, to, tilt, roll, twist, shift, slide, rise\n";
    const BLOCK: [f64; 6] = [10.0, 70.0, -50.0, 4.0, -8.0, 25.0];

    /// The frame of each base pair of the stress-free rod.
    fn base_pair_frames(natural: impl Fn(f64) -> NaturalStrains, spacing: f64, count: usize) -> Vec<(Quat, Vec3)> {
        let (mut frame, mut place, mut all) = (Quat::identity(), Vec3::zeros(), vec![]);
        for k in 0..count {
            all.push((frame, place));
            let strain = natural((k as f64 + 0.5) * spacing);
            let (turn, parts) = (strain.fixed_rows::<3>(3).into_owned() * spacing, 4000);
            for part in 0..parts {
                let part = (f64::from(part) + 0.5) / f64::from(parts);
                place += frame
                    * (Quat::from_scaled_axis(turn * part) * strain.fixed_rows::<3>(0))
                    * (spacing / f64::from(parts));
            }
            frame *= Quat::from_scaled_axis(turn);
        }
        all
    }

    #[test]
    fn proteins_hold_steps_and_blocks() {
        let sequence = Sequence::parse("ACGTTGCAATCCGGATTACAACGT").unwrap();
        let steps = Steps::protein_dna_1998().unwrap();
        let text = format!(
            "{HEAD}frozen, 1, 4, 0, 0, 0, 0, 0, 0\nsteps, 4, 7, 0, 20, 30, 0, 1, 3.4\n\
             block, 9, 18, 10, 70, -50, 4, -8, 25\n"
        );
        let bound = Bound::parse(&text).unwrap();
        let (free, held) =
            (sequence.helix(&steps, false).unwrap(), sequence.helix_with(&steps, false, &bound).unwrap());
        let spacing = held.length / 23.0;
        let all = base_pair_frames(|s| held.natural.at(s), spacing, 24);
        let between = |a: usize, b: usize| {
            let (first, last) = (all[a - 1], all[b - 1]);
            (first.0.inverse() * last.0, first.0.inverse() * (last.1 - first.1))
        };
        for (a, b, parameters) in [(4, 5, [0.0, 20.0, 30.0, 0.0, 1.0, 3.4]), (9, 18, BLOCK)] {
            let ((turn, shift), (to_be, where_to)) = (between(a, b), pose(&parameters));
            assert!(turn.angle_to(&to_be) < 1e-7 && (shift - where_to).norm() < 1e-6, "{a}: {shift} {where_to}");
        }
        for k in 0..23 {
            let s = (f64::from(k) + 0.5) * spacing;
            let stiffer = held.stiffness.at(s)[(3, 3)] / free.stiffness.at(s)[(3, 3)];
            let inside = (0..6).contains(&k) || (8..17).contains(&k);
            assert!((stiffer / if inside { RIGID } else { 1.0 } - 1.0).abs() < 1e-12, "{k} {stiffer}");
            let same = held.natural.at(s) == free.natural.at(s);
            assert_eq!(same, !((3..6).contains(&k) || (8..17).contains(&k)), "{k}");
        }
    }

    #[test]
    fn bad_tables_are_refused_with_line_and_value() {
        for (rows, reason) in [
            ("frozen, 1, 4, 0, 3, 0, 0, 0, 0", "line 2: frozen steps keep their parameters: give six zeros"),
            ("loose, 1, 4, 0, 0, 0, 0, 0, 0", "line 2: hold is \"loose\": must be frozen, steps or block"),
            ("frozen, 4, 4, 0, 0, 0, 0, 0, 0", "line 2: from 4 to 4: must be two base pairs, counted from 1"),
            ("frozen, 0, 4, 0, 0, 0, 0, 0, 0", "line 2: from 0 to 4: must be two base pairs, counted from 1"),
            ("frozen, 1.5, 4, 0, 0, 0, 0, 0, 0", "line 2: from 1.5 to 4: must be"),
            ("frozen, 1, 4, 0, 0, 0, 0, 0, 0\n\nblock, 3, 9, 0, 0, 0, 0, 0, 0", "line 4: overlaps with line 2"),
            ("frozen, 1, 4, 0, x, 0, 0, 0, 0", "line 2, column roll: a finite number expected, found \"x\""),
        ] {
            let refused = Bound::parse(&format!("{HEAD}{rows}\n")).unwrap_err();
            assert!(refused.starts_with(reason), "{refused}");
        }
        let refused = Bound::parse("hold, from, to, tilt\nfrozen, 1, 2, 0\n").unwrap_err();
        assert_eq!(refused, "line 1: there is no column roll");
        let bound = Bound::parse(&format!("{HEAD}frozen, 1, 40, 0, 0, 0, 0, 0, 0\n")).unwrap();
        let refused = Sequence::parse("ACGT").unwrap().helix_with(&Steps::ideal(), false, &bound).unwrap_err();
        assert!(refused.to_string().contains("line 2: to 40, but there are 4 base pairs"), "{refused}");
    }
}
