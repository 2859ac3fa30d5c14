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
//! A node a base pair suffices; base pairs between nodes are placed by [`AtRest`](crate::dna::base_pairs::AtRest).
//! Finer meshes resolve the displacements of base-pair centres by shift and slide, which are sharper than the strand is
//! thick: with contact such a mesh overlaps itself and does not converge.

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

/// Base-pair steps: a table of the sixteen kinds, or the steps of one molecule in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps(StepList);

#[derive(Debug, Clone, PartialEq)]
enum StepList {
    /// By the bases of both pairs.
    ByBases(Box<[[Step; 4]; 4]>),
    /// From the first pair on.
    InOrder(Vec<Step>),
}

impl Steps {
    /// "IdealDNA", the same for all sequences: straight and isotropic; twist 34.2857°, rise 3.4 Å, 0.0427 kT/deg² for
    /// tilt and roll, 0.0597 kT/deg² for twist, 20 kT/Å² for all translations (the values of emDNA,
    /// github.com/nicocvn/emDNA).
    #[must_use]
    pub fn ideal() -> Self {
        let constants = [0.0427, 0.0427, 0.0597, 20.0, 20.0, 20.0];
        let stiffness = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { constants[i] } else { 0.0 }));
        Self(StepList::ByBases(Box::new([[Step { mean: [0.0, 0.0, 34.2857, 0.0, 0.0, 3.4], stiffness }; 4]; 4])))
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
    /// Where the column `step` has numbers 1, 2, … the table is one molecule's own, a line a step in its order:
    /// parameters that depend on more than two bases, as those of cgNA+ do, computed elsewhere. Of a model whose steps
    /// are coupled with each other give the 6×6 of each step with the others free (the inverse of its block of the
    /// covariance): couplings are lost.
    ///
    /// # Errors
    /// [`InputError::File`] if it cannot be read; [`InputError::Parse`] with line and value for columns that are
    /// unknown or missing, letters other than A, C, G, T, duplicate or missing steps, numbers out of order, force
    /// constants that are not positive definite.
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
        let (mut found, mut in_order) = ([[None; 4]; 4], Vec::new());
        let is_numbered = table.words.first().is_some_and(|word| word.parse::<usize>().is_ok());
        for ((line, row), word) in table.rows.iter().zip(&table.words) {
            let refuse = |reason: String| format!("line {line}: step {word}: {reason}");
            let mut step = Step { mean: means.map(|column| row[column.unwrap_or_default()]), stiffness: [[0.0; 6]; 6] };
            for &(column, (i, j)) in &constants {
                (step.stiffness[i][j], step.stiffness[j][i]) = (row[column], row[column]);
            }
            InputError::positive("rise", step.mean[5]).map_err(|error| refuse(error.to_string()))?;
            let matrix = Stiffness::from_fn(|i, j| step.stiffness[i][j]);
            check_stiffness("force constants", &matrix).map_err(|error| refuse(error.to_string()))?;
            if is_numbered {
                in_order.push(step);
                if *word != in_order.len().to_string() {
                    return Err(refuse(format!("must be {}: numbers count the steps", in_order.len())));
                }
                continue;
            }
            let bases: Vec<usize> = word.chars().filter_map(base).collect();
            let [a, b] = bases[..] else { return Err(refuse("must be two of the letters A, C, G, T".to_owned())) };
            if found[a][b].replace(step).is_some() {
                return Err(refuse("is there twice".to_owned()));
            }
        }
        if is_numbered {
            return Ok(Self(StepList::InOrder(in_order)));
        }
        let of = |a: usize, b: usize| {
            let other = || found[3 - b][3 - a].map(|step: Step| step.reversed());
            found[a][b].or_else(other).ok_or_else(|| format!("there is no step {}{}", BASES[a], BASES[b]))
        };
        let mut steps = Vec::new();
        for a in 0..4 {
            steps.push([of(a, 0)?, of(a, 1)?, of(a, 2)?, of(a, 3)?]);
        }
        Ok(Self(StepList::ByBases(Box::new([steps[0], steps[1], steps[2], steps[3]]))))
    }
}

/// Index of a base among [`BASES`]; complements are mirrored.
pub(super) fn base(letter: char) -> Option<usize> {
    BASES.iter().position(|known| letter.eq_ignore_ascii_case(known))
}

/// Whether a character of a sequence stands for no base: white space, a gap of an alignment.
fn is_skipped(letter: char) -> bool {
    letter.is_whitespace() || matches!(letter, '-' | '.')
}

/// Most bases that are made up, more than any chromosome of a bacterium.
const MOST_BASES: usize = 100_000_000;

/// splitmix64 (Steele, Lea & Flood 2014): the same numbers on every machine and in every version.
#[derive(Debug, Clone)]
pub(crate) struct SplitMix(pub u64);

impl SplitMix {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
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
    /// The bases.
    pub sequence: Sequence,
    /// Natural strains of the single steps, one constant piece each; those of `natural` unless in blocks.
    pub steps: Along<NaturalStrains>,
}

impl Sequence {
    /// A sequence from letters; white space and gaps (`-`, `.`) are ignored, upper and lower case are equal.
    /// `random:336:7` are 336 bases drawn with the seed 7, each as likely as the others, the same on every machine;
    /// `poly:AT:336` are 336 bases of the repeated unit `AT`.
    ///
    /// # Errors
    /// [`InputError::Name`] for other letters, with their position, and for other words with a colon;
    /// [`InputError::Count`] for fewer than two bases.
    ///
    /// ```
    /// use supercoil::dna::sequence::{Sequence, Steps};
    /// // a ring: 14 base pairs, 14 steps
    /// let helix = Sequence::parse("GATTACA GATTACA")?.helix(&Steps::ideal(), true)?;
    /// assert!((helix.length - 14.0 * 0.34).abs() < 1e-12);
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, InputError> {
        if text.contains(':') {
            return Self::made(text);
        }
        let mut bases = Vec::new();
        for letter in text.chars().filter(|c| !is_skipped(*c)) {
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

    /// `random:NUMBER:SEED` or `poly:UNIT:NUMBER`.
    fn made(text: &str) -> Result<Self, InputError> {
        let refuse = || InputError::Name {
            field: "sequence.letters".to_owned(),
            name: text.to_owned(),
            allowed: "A, C, G, T, random:NUMBER:SEED or poly:UNIT:NUMBER, with 2 to 100 million bases".to_owned(),
        };
        let words: Vec<&str> = text.trim().split(':').map(str::trim).collect();
        let count = |word: &str| word.parse().ok().filter(|count| (2..=MOST_BASES).contains(count)).ok_or_else(refuse);
        match words[..] {
            ["random", number, seed] => {
                let mut stream = SplitMix(seed.parse().map_err(|_| refuse())?);
                Ok(Self((0..count(number)?).map(|_| (stream.bits() >> 62) as u8).collect()))
            }
            ["poly", unit, number] => {
                let unit: Option<Vec<u8>> = unit.chars().map(|letter| base(letter).map(|base| base as u8)).collect();
                let unit = unit.filter(|unit| !unit.is_empty()).ok_or_else(refuse)?;
                Ok(Self(unit.iter().copied().cycle().take(count(number)?).collect()))
            }
            _ => Err(refuse()),
        }
    }

    /// Reads a FASTA file of one sequence (gaps are left out; lines that begin with `>` or `;` are its name or
    /// comments), or the topology of two complementary strands that oxDNA has (its first line begins with a number):
    /// the first strand.
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
            if let Some(letter) = line.chars().find(|c| !is_skipped(*c) && base(*c).is_none()) {
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

    /// The letter of base k, upper case.
    pub(super) fn letter(&self, k: usize) -> Option<char> {
        self.0.get(k).map(|&base| BASES[usize::from(base)])
    }

    /// The steps between consecutive base pairs, in a closed molecule also from the last to the first.
    fn steps<'a>(&'a self, steps: &'a Steps, closed: bool) -> impl Iterator<Item = &'a Step> {
        let count = self.0.len();
        let number = if closed { count } else { count - 1 };
        (0..number).filter_map(move |k| match &steps.0 {
            StepList::ByBases(all) => Some(&all[usize::from(self.0[k])][usize::from(self.0[(k + 1) % count])]),
            StepList::InOrder(all) => all.get(k),
        })
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
        let count = self.0.len() - usize::from(!closed);
        if let StepList::InOrder(given) = &steps.0
            && given.len() != count
        {
            let (bases, kind) = (self.0.len(), if closed { "closed" } else { "open" });
            let reason = format!("has {} steps, but a {kind} molecule of {bases} base pairs has {count}", given.len());
            return Err(InputError::inconsistent("sequence.steps", reason));
        }
        let rise: f64 = self.steps(steps, closed).map(|step| step.mean[5]).sum();
        let length = rise * ANGSTROM;
        let spacing = length / count as f64;
        let ends: Vec<f64> = (1..=count).map(|k| length * (k as f64 / count as f64)).collect();
        let mut natural: Vec<_> = self.steps(steps, closed).map(|step| strains(&step.mean, spacing)).collect();
        let mut stiffness: Vec<_> = self.steps(steps, closed).map(|step| step.section(spacing)).collect();
        proteins.hold((&mut natural, &mut stiffness), spacing, self.0.len())?;
        let turns = natural.iter().map(|strains| strains[5]).sum::<f64>() * spacing / std::f64::consts::TAU;
        let (natural, stiffness) = (Along::pieces(ends.clone(), natural)?, Along::pieces(ends, stiffness)?);
        let steps = natural.clone();
        let sequence = self.clone();
        Ok(Helix { natural, stiffness, length, turns, num_steps: count, turns_left_out: 0.0, sequence, steps })
    }
}

#[cfg(test)]
mod tests;
