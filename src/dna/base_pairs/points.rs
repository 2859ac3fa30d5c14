//! The axis as points: XYZ, VECT, PDB.

use std::fmt::Write as _;

use super::BasePairs;

/// Atom numbers of PDB restart here, residue numbers after 9999.
const MOST_ATOMS: usize = 100_000;
const MOST_RESIDUES: usize = 10_000;
/// Largest coordinate that fits the columns of PDB, Å.
const LARGEST_PDB: f64 = 9999.999;
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

    /// PDB: one atom P per base pair on the axis, Å; in a closed molecule the last atom is bonded to the first.
    ///
    /// # Errors
    /// A molecule that reaches 999 nm from the origin, where the format's columns end, with the base pair.
    pub fn pdb(&self) -> Result<String, String> {
        let mut text = String::from("REMARK   axis of a double helix, one atom a base pair\n");
        for (k, r) in self.positions.iter().enumerate() {
            let [x, y, z] = [r.x, r.y, r.z].map(|x| x * ANGSTROMS);
            if r.amax() * ANGSTROMS > LARGEST_PDB {
                return Err(format!("base pair {}: {} nm from the origin, PDB ends at 999.9", k + 1, r.amax()));
            }
            let (atom, residue) = ((k + 1) % MOST_ATOMS, (k + 1) % MOST_RESIDUES);
            let _ = writeln!(
                text,
                "ATOM  {atom:>5}  P    DA A{residue:>4}    {x:>8.3}{y:>8.3}{z:>8.3}  1.00  0.00           P"
            );
        }
        if self.closed && self.positions.len() < MOST_ATOMS {
            let _ = writeln!(text, "CONECT{:>5}{:>5}", self.positions.len(), 1);
        }
        text.push_str("END\n");
        Ok(text)
    }
}
