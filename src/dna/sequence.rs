//! From a base sequence and a table of base-pair steps to a rod: natural strains and stiffness along s, nm and pN.
//!
//! A step between two base pairs has six parameters: tilt, roll, twist (degrees) and shift, slide, rise (Å), in the
//! convention of El Hassan & Calladine (1995, J. Mol. Biol. 251:648) that 3DNA uses. A table gives their means and a
//! symmetric 6×6 of force constants (kT/deg², kT/(deg Å), kT/Å²) for each pair of bases.
//!
//! The rod's frame is that of the base pairs: d1 to the major groove, d2 to the strand of the sequence, d3 along the
//! helix; so Γ1 Γ2 Γ3 are shift, slide, rise and K1 K2 K3 tilt, roll, twist, per reference length. Base pair k lies at
//! s = k h, h the mean rise. Natural strains are constant within a step, chosen so that the stress-free rod passes
//! exactly through all base pairs. Its stiffness is C = F h with the force constants F, in pN and nm: deviations of
//! step parameters are approximated by h times those of the strains. The two agree to first order in the angles of a
//! step; a bend of constant direction in space, as in a ring, costs the same energy in both.
//!
//! One node per base pair suffices. Finer meshes resolve the displacements of base-pair centres by shift and slide,
//! which are sharper than the strand is thick: with contact such a mesh overlaps itself and does not converge.

use std::path::Path;

use crate::dna::THERMAL_ENERGY;
use crate::dna::base_pairs::oxdna::read_strand;
use crate::dna::bound::Bound;
use crate::dna::pose::{ANGSTROM, pose, strains};
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::{Along, NaturalStrains, Stiffness, check_stiffness};
use crate::text::{NumberTable, read_regular};

/// Names of the step parameters, in order.
pub(super) const PARAMETERS: [&str; 6] = ["tilt", "roll", "twist", "shift", "slide", "rise"];
const BASES: [char; 4] = ['A', 'C', 'G', 'T'];
/// Signs of the parameters when a step is read along the complementary strand: tilt and shift change.
const SIGNS: [f64; 6] = [-1.0, 1.0, 1.0, -1.0, 1.0, 1.0];

/// Means and force constants of one step, in the order tilt, roll, twist, shift, slide, rise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Means: degrees and Å.
    pub mean: [f64; 6],
    /// Force constants: kT/deg², kT/(deg Å), kT/Å². Symmetric, positive definite.
    pub stiffness: [[f64; 6]; 6],
}

impl Step {
    /// The same step read along the complementary strand.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            mean: std::array::from_fn(|i| SIGNS[i] * self.mean[i]),
            stiffness: std::array::from_fn(|i| std::array::from_fn(|j| SIGNS[i] * SIGNS[j] * self.stiffness[i][j])),
        }
    }

    /// Rotation and displacement (nm) from one base pair to the next, in the frame of the first.
    #[must_use]
    pub fn pose(&self) -> (Quat, Vec3) {
        pose(&self.mean)
    }

    /// Stiffness of the rod, pN and nm.
    fn section(&self, spacing: f64) -> Stiffness {
        let unit = |i: usize| if i < 3 { 1f64.to_degrees() } else { 1.0 / ANGSTROM };
        let of_strain = |i: usize| (i + 3) % 6;
        Stiffness::from_fn(|i, j| {
            let (i, j) = (of_strain(i), of_strain(j));
            THERMAL_ENERGY * spacing * self.stiffness[i][j] * unit(i) * unit(j)
        })
    }
}

/// A table of the sixteen steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps([[Step; 4]; 4]);

impl Steps {
    /// "IdealDNA", the same for all sequences: straight and isotropic; twist 34.2857°, rise 3.4 Å, .0427 kT/deg² for
    /// tilt and roll, .0597 kT/deg² for twist, 20 kT/Å² for all translations (the values of emDNA, github.com/nicocvn/emDNA).
    #[must_use]
    pub fn ideal() -> Self {
        let constants = [0.0427, 0.0427, 0.0597, 20.0, 20.0, 20.0];
        let stiffness = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { constants[i] } else { 0.0 }));
        Self([[Step { mean: [0.0, 0.0, 34.2857, 0.0, 0.0, 3.4], stiffness }; 4]; 4])
    }

    /// Steps in crystals of B-DNA with proteins: Olson, Gorin, Lu, Hock & Zhurkin (1998), PNAS 95:11163. The force
    /// constants are those of two programs that cite the paper, the means those of one of them; the file names them.
    ///
    /// # Errors
    /// None: the table is part of the library.
    pub fn protein_dna_1998() -> Result<Self, InputError> {
        Self::named("protein_dna_1998.csv", include_str!("protein_dna_1998.csv"))
    }

    /// Reads a table: CSV with the columns `step` (two letters), `tilt`, `roll`, `twist`, `shift`, `slide`, `rise`, and
    /// force constants, each named by two of these: `roll_roll`, `roll_twist` … Missing force constants are 0. A
    /// missing step is taken from the complementary strand (`TT` from `AA`).
    ///
    /// # Errors
    /// [`InputError::File`] if it cannot be read; [`InputError::Parse`] with line and value for columns that are
    /// unknown or missing, letters other than A, C, G, T, duplicate or missing steps, force constants that are not
    /// positive definite.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::named(&path.display().to_string(), &read_regular(path)?)
    }

    fn named(file: &str, text: &str) -> Result<Self, InputError> {
        Self::parse(text).map_err(|reason| InputError::Parse { file: file.to_owned(), reason })
    }

    fn parse(text: &str) -> Result<Self, String> {
        let table = NumberTable::parse_with(text, Some("step"))?;
        let index = |name: &str| PARAMETERS.iter().position(|parameter| *parameter == name);
        let means = PARAMETERS.map(|name| table.column(name).ok_or(name));
        if let Some(missing) = means.iter().find_map(|found| found.err()) {
            return Err(format!("line {}: there is no column {missing}", table.head));
        }
        let entry = |name: &str| name.split_once('_').and_then(|(a, b)| Some((index(a)?, index(b)?)));
        let constants = table.columns(&PARAMETERS, entry, "or two of them such as roll_twist")?;
        let mut found = [[None; 4]; 4];
        for ((line, row), word) in table.rows.iter().zip(&table.words) {
            let refuse = |reason: String| format!("line {line}: step {word}: {reason}");
            let bases: Vec<usize> = word.chars().filter_map(base).collect();
            let [a, b] = bases[..] else { return Err(refuse("must be two of the letters A, C, G, T".to_owned())) };
            let mut step = Step { mean: means.map(|column| row[column.unwrap_or_default()]), stiffness: [[0.0; 6]; 6] };
            for &(column, (i, j)) in &constants {
                (step.stiffness[i][j], step.stiffness[j][i]) = (row[column], row[column]);
            }
            InputError::positive("rise", step.mean[5]).map_err(|error| refuse(error.to_string()))?;
            let matrix = Stiffness::from_fn(|i, j| step.stiffness[i][j]);
            check_stiffness("force constants", &matrix).map_err(|error| refuse(error.to_string()))?;
            if found[a][b].replace(step).is_some() {
                return Err(refuse("is there twice".to_owned()));
            }
        }
        let of = |a: usize, b: usize| {
            let other = || found[3 - b][3 - a].map(|step: Step| step.reversed());
            found[a][b].or_else(other).ok_or_else(|| format!("there is no step {}{}", BASES[a], BASES[b]))
        };
        let mut steps = Self::ideal();
        for (a, b) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
            steps.0[a][b] = of(a, b)?;
        }
        Ok(steps)
    }
}

/// Index of a base among [`BASES`]; complements are mirrored.
pub(super) fn base(letter: char) -> Option<usize> {
    BASES.iter().position(|known| letter.eq_ignore_ascii_case(known))
}

/// A sequence of bases, of one strand from 5′ to 3′.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sequence(Vec<u8>);

/// Input of [`Rod`](crate::rod::Rod) for a sequence, in nm and pN.
#[derive(Debug, Clone, PartialEq)]
pub struct Helix {
    /// Natural strains, for [`Natural::Varying`](crate::rod::Natural).
    pub natural: Along<NaturalStrains>,
    /// Stiffness, for [`Rod::with_stiffness`](crate::rod::Rod::with_stiffness).
    pub stiffness: Along<Stiffness>,
    /// Length of the rod, nm: steps × mean rise.
    pub length: f64,
    /// Natural twist ∫ K3 ds/2π, turns: the link of a relaxed ring.
    pub turns: f64,
    /// Number of steps, all of one length.
    pub num_steps: usize,
    /// Turns of the double helix that the frames leave out, a whole number: 0 unless [in blocks](Helix::in_blocks).
    pub turns_left_out: f64,
}

impl Sequence {
    /// A sequence from letters; white space is ignored, upper and lower case are equal.
    ///
    /// # Errors
    /// [`InputError::Name`] for other letters, with their position; [`InputError::Count`] for fewer than two bases.
    ///
    /// ```
    /// use supercoil::dna::sequence::{Sequence, Steps};
    /// let helix = Sequence::parse("GATTACA GATTACA")?.helix(&Steps::ideal(), true)?; // a ring: 14 base pairs, 14 steps
    /// assert!((helix.length - 14.0 * 0.34).abs() < 1e-12);
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let mut bases = Vec::new();
        for letter in text.chars().filter(|c| !c.is_whitespace()) {
            let Some(base) = base(letter) else {
                let field = format!("sequence, base {}", bases.len() + 1);
                let allowed = "A, C, G or T".to_owned();
                return Err(InputError::Name { field, name: letter.to_string(), allowed });
            };
            bases.push(base as u8);
        }
        if bases.len() < 2 {
            let field = "number of bases".to_owned();
            return Err(InputError::Count { field, value: bases.len(), allowed: "at least 2" });
        }
        Ok(Self(bases))
    }

    /// Reads a FASTA file of one sequence (lines that begin with `>` or `;` are its name or comments), or the topology of
    /// two complementary strands that oxDNA has (its first line begins with a number): the first strand.
    ///
    /// # Errors
    /// [`InputError::File`] if it cannot be read; [`InputError::Parse`] for a second sequence, for strands that are no
    /// complements, and for letters that are no bases, with their line.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text = read_regular(path)?;
        let refuse = |reason: String| InputError::Parse { file: path.display().to_string(), reason };
        if text.starts_with(|c: char| c.is_ascii_digit()) {
            return read_strand(&text)
                .and_then(|letters| Self::parse(&letters).map_err(|e| e.to_string()))
                .map_err(refuse);
        }
        let mut letters = String::new();
        for (number, line) in (1..).zip(text.lines()) {
            if line.starts_with('>') && !letters.is_empty() {
                return Err(refuse(format!("line {number}: a second sequence: one is read")));
            }
            if line.starts_with(['>', ';']) {
                continue;
            }
            if let Some(letter) = line.chars().find(|c| !c.is_whitespace() && base(*c).is_none()) {
                return Err(refuse(format!("line {number}: \"{letter}\" is no base: A, C, G or T expected")));
            }
            letters.push_str(line);
        }
        Self::parse(&letters).map_err(|error| refuse(error.to_string()))
    }

    /// Number of bases.
    #[must_use]
    pub fn num_bases(&self) -> usize {
        self.0.len()
    }

    /// The letters, upper case.
    #[must_use]
    pub fn letters(&self) -> String {
        self.0.iter().map(|&base| BASES[usize::from(base)]).collect()
    }

    /// The steps between consecutive base pairs, in a closed molecule also from the last to the first.
    fn steps<'a>(&'a self, steps: &'a Steps, closed: bool) -> impl Iterator<Item = &'a Step> {
        let count = self.0.len();
        let number = if closed { count } else { count - 1 };
        (0..number).map(move |k| &steps.0[usize::from(self.0[k])][usize::from(self.0[(k + 1) % count])])
    }

    /// The molecule as a rod, one constant piece a step.
    ///
    /// # Errors
    /// None for tables of this module.
    pub fn helix(&self, steps: &Steps, closed: bool) -> Result<Helix, InputError> {
        self.helix_with(steps, closed, &Bound::default())
    }

    /// [`Sequence::helix`] with bound proteins.
    ///
    /// # Errors
    /// Proteins beyond the last base pair.
    pub(crate) fn helix_with(&self, steps: &Steps, closed: bool, proteins: &Bound) -> Result<Helix, InputError> {
        let count = self.steps(steps, closed).count();
        let rise: f64 = self.steps(steps, closed).map(|step| step.mean[5]).sum();
        let length = rise * ANGSTROM;
        let spacing = length / count as f64;
        let ends: Vec<f64> = (1..=count).map(|k| length * (k as f64 / count as f64)).collect();
        let mut natural: Vec<_> = self.steps(steps, closed).map(|step| strains(&step.mean, spacing)).collect();
        let mut stiffness: Vec<_> = self.steps(steps, closed).map(|step| step.section(spacing)).collect();
        proteins.hold((&mut natural, &mut stiffness), spacing, self.0.len())?;
        let turns = natural.iter().map(|strains| strains[5]).sum::<f64>() * spacing / std::f64::consts::TAU;
        let (natural, stiffness) = (Along::pieces(ends.clone(), natural)?, Along::pieces(ends, stiffness)?);
        Ok(Helix { natural, stiffness, length, turns, num_steps: count, turns_left_out: 0.0 })
    }
}

#[cfg(test)]
mod tests;
