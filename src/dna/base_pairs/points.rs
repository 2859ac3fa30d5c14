//! The axis as points (XYZ, VECT), strands as atoms (PDB).

use std::fmt::Write as _;

use super::BasePairs;
use crate::math::Vec3;

/// Atom numbers of PDB restart here, residue numbers after 9999.
const MOST_ATOMS: usize = 100_000;
const MOST_RESIDUES: usize = 10_000;
/// Largest coordinate that fits the columns of PDB, Å.
const LARGEST_PDB: f64 = 9999.999;
/// Place of an atom P in the frame of its base pair, Å: outward along d2, and along d3 to the 5' end of its strand.
/// Atoms of the ideal helix face each other by 12 Å across the minor and 18 Å across the major groove, as in fibres.
const PHOSPHORUS_OUTWARD: f64 = 9.3;
const PHOSPHORUS_TO_5: f64 = 1.8;
/// Å per nm.
const ANGSTROMS: f64 = 10.0;

impl BasePairs {
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

    /// Geomview's VECT, one curve, nm.
    #[must_use]
    pub fn vect(&self) -> String {
        let count = self.positions.len();
        let sign = if self.closed { "-" } else { "" };
        let mut text = format!("VECT\n1 {count} 0\n{sign}{count}\n0\n");
        for r in &self.positions {
            // writing to a string does not fail
            let _ = writeln!(text, "{:?} {:?} {:?}", r.x, r.y, r.z);
        }
        text
    }

    /// PDB, Å: the atoms P of both strands, as residues DA, DC, DG, DT of chain A (the strand of the sequence, from its
    /// 5' end) and of chain B (its complement, from its own 5' end), numbered on. DN where bases are not known. In a
    /// closed molecule the last atom of a chain is bonded to its first.
    ///
    /// An atom P lies where fibres of B-DNA have it on average: 9.3 Å from the axis of the base pair, 1.8 Å towards the
    /// 5' end.
    ///
    /// # Errors
    /// A molecule that reaches 999 nm from the origin, where the format's columns end, with the base pair.
    pub fn pdb(&self) -> Result<String, String> {
        let (mut text, count) = (String::from("REMARK   atoms P of a double helix\n"), self.positions.len());
        let mut serial = 0;
        let mut chain_ends = Vec::new();
        for (chain, side) in [('A', 1.0), ('B', -1.0)] {
            for place in 0..count {
                let k = if side > 0.0 { place } else { count - 1 - place };
                let frame = self.frames[k];
                let atom = self.positions[k] * ANGSTROMS
                    + frame * Vec3::new(0.0, PHOSPHORUS_OUTWARD * side, -PHOSPHORUS_TO_5 * side);
                if atom.amax() > LARGEST_PDB {
                    let far = atom.amax() / ANGSTROMS;
                    return Err(format!("base pair {}: {far:.1} nm from the origin, PDB ends at 999.9", k + 1));
                }
                serial += 1;
                let (number, residue) = (serial % MOST_ATOMS, ((serial - 1) % (MOST_RESIDUES - 1)) + 1);
                let base = self.bases(k).map_or('N', |bases| bases[usize::from(side < 0.0)]);
                let [x, y, z]: [f64; 3] = atom.into();
                let _ = writeln!(
                    text,
                    "ATOM  {number:>5}  P    D{base} {chain}{residue:>4}    {x:>8.3}{y:>8.3}{z:>8.3}  1.00  \
                     0.00           P"
                );
            }
            chain_ends.push(serial);
            text.push_str("TER\n");
        }
        if self.closed && serial < MOST_ATOMS {
            for last in chain_ends {
                let _ = writeln!(text, "CONECT{last:>5}{:>5}", last + 1 - count);
            }
        }
        text.push_str("END\n");
        Ok(text)
    }
}
