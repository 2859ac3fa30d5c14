//! DNA in nanometres and piconewtons: material constants, well-known molecules, salt-dependent contact diameter.
//!
//! Units: length nm, force pN, energy pN·nm, bending and twist stiffness pN·nm². Temperature 298 K. Values are for
//! B-DNA in physiological conditions, each with its source.

pub mod base_pairs;
pub mod blocks;
pub(crate) mod bound;
pub(crate) mod pose;
pub(crate) mod salt;
pub mod sequence;

use crate::error::InputError;

/// Boltzmann's constant, pN·nm/K.
pub const BOLTZMANN: f64 = 0.013_806_49;

/// Temperature of the constants, K.
pub const TEMPERATURE: f64 = 298.0;

/// Thermal energy kT at [`TEMPERATURE`], pN·nm.
pub const THERMAL_ENERGY: f64 = 4.114;

/// Bending persistence length, nm (Hagerman 1988; Bustamante et al. 1994: 50 ± 3 at moderate salt).
pub const BENDING_PERSISTENCE: f64 = 50.0;

/// Twist persistence length at low tension, nm (cyclisation and thermal twist: Shore & Baldwin 1983; Moroz & Nelson
/// 1997 use 75 to 120).
pub const TWIST_PERSISTENCE_LOW: f64 = 75.0;

/// Twist persistence length of stretched DNA, nm (single-molecule torque: Bryant et al. 2003; Lipfert et al. 2010).
pub const TWIST_PERSISTENCE_HIGH: f64 = 110.0;

/// Bending stiffness EI = kT · 50 nm, pN·nm².
pub const BENDING_STIFFNESS: f64 = THERMAL_ENERGY * BENDING_PERSISTENCE;

/// Twist stiffness GJ = kT · 75 nm (C/B = 1.5, the ratio usual in models of supercoiling), pN·nm².
pub const TWIST_STIFFNESS: f64 = THERMAL_ENERGY * TWIST_PERSISTENCE_LOW;

/// Stretch modulus EA, pN (Smith, Cui & Bustamante 1996; Wang et al. 1997: about 1000 to 1200).
pub const STRETCH_MODULUS: f64 = 1100.0;

/// Rise per base pair, nm.
pub const RISE: f64 = 0.34;

/// Helical repeat of relaxed B-DNA in solution, base pairs per turn (Wang 1979).
pub const HELICAL_REPEAT: f64 = 10.5;

/// Geometric diameter of the bare duplex, nm: the contact diameter in the limit of full screening.
pub(crate) const BARE_DIAMETER: f64 = 2.0;

/// A double-stranded molecule of known length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Molecule {
    /// Common name.
    pub name: &'static str,
    /// Number of base pairs.
    pub base_pairs: u64,
}

/// Minicircle whose topoisomers were imaged one by one (Irobalieva et al. 2015, Nat. Commun. 6:8440).
pub const MINICIRCLE: Molecule = Molecule { name: "minicircle", base_pairs: 336 };
/// Cloning plasmid pUC19.
pub const PUC19: Molecule = Molecule { name: "pUC19", base_pairs: 2686 };
/// Plasmid pBR322.
pub const PBR322: Molecule = Molecule { name: "pBR322", base_pairs: 4361 };
/// Genome of phage λ.
pub const LAMBDA: Molecule = Molecule { name: "phage lambda", base_pairs: 48_502 };
/// Chromosome of Escherichia coli K-12, rounded.
pub const E_COLI: Molecule = Molecule { name: "E. coli chromosome", base_pairs: 4_640_000 };

/// The molecules above, by length.
pub const MOLECULES: [Molecule; 5] = [MINICIRCLE, PUC19, PBR322, LAMBDA, E_COLI];

impl Molecule {
    /// The molecule of [`MOLECULES`] with this name, upper and lower case alike.
    ///
    /// # Errors
    /// [`InputError::Name`] with the known names if there is none.
    pub fn named(name: &str) -> Result<Self, InputError> {
        MOLECULES.into_iter().find(|m| m.name.eq_ignore_ascii_case(name)).ok_or_else(|| InputError::Name {
            field: "molecule".to_owned(),
            name: name.to_owned(),
            allowed: format!("one of {}", MOLECULES.map(|m| m.name).join(", ")),
        })
    }

    /// Contour length L = base pairs × rise, nm.
    pub fn contour_length(&self) -> f64 {
        self.base_pairs as f64 * RISE
    }

    /// Relaxed link Lk₀ = base pairs / helical repeat, turns (not rounded: a closed molecule's own link is an integer).
    pub(crate) fn relaxed_link(&self) -> f64 {
        self.base_pairs as f64 / HELICAL_REPEAT
    }

    /// Excess link ΔLk = σ Lk₀ at supercoiling density `sigma` (bacterial plasmids: about −0.06), turns.
    pub fn excess_link(&self, sigma: f64) -> f64 {
        sigma * self.relaxed_link()
    }
}

/// Sodium chloride concentration (mol/l) and effective contact diameter (nm) of the duplex.
///
/// Values of the electrostatic theory as confirmed by knotting probabilities (Stigter 1977; Rybenkov, Cozzarelli &
/// Vologodskii 1993; Vologodskii & Cozzarelli 1995), about ±10 %.
pub(crate) const SALT_TABLE: [(f64, f64); 6] =
    [(0.01, 15.0), (0.05, 7.5), (0.1, 5.5), (0.15, 5.0), (0.2, 4.5), (1.0, 3.0)];

/// Effective contact diameter (nm) of the duplex at a sodium chloride concentration in mol/l, 0.01 to 1.
///
/// Interpolates ln(diameter) linearly in ln(concentration) between the entries of `SALT_TABLE`; about ±10 %.
///
/// # Errors
/// [`InputError::Value`] outside the table.
pub fn contact_diameter_nm(sodium_chloride: f64) -> Result<f64, InputError> {
    let inside = (SALT_TABLE[0].0..=SALT_TABLE[SALT_TABLE.len() - 1].0).contains(&sodium_chloride);
    InputError::check("sodium_chloride", sodium_chloride, inside, "between 0.01 and 1 mol/l")?;
    let above = SALT_TABLE.partition_point(|(c, _)| *c < sodium_chloride).max(1);
    let ((c0, d0), (c1, d1)) = (SALT_TABLE[above - 1], SALT_TABLE[above]);
    let fraction = (sodium_chloride / c0).ln() / (c1 / c0).ln();
    Ok(d0 * (d1 / d0).powf(fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a value agrees with a printed one, relative.
    fn close(found: f64, printed: f64, tolerance: f64) -> bool {
        (found / printed - 1.0).abs() <= tolerance
    }

    #[test]
    fn molecules_have_the_published_sizes() {
        let table = [
            (MINICIRCLE, 114.2, 32.0, -1.92, 4.4e-2),
            (PUC19, 913.0, 255.8, -15.3, 5.5e-3),
            (PBR322, 1483.0, 415.3, -24.9, 3.4e-3),
            (LAMBDA, 16.5e3, 4619.0, -277.0, 3.0e-4),
            (E_COLI, 1.58e6, 4.42e5, -2.65e4, 3.2e-6),
        ];
        for (molecule, length, link, excess, slenderness) in table {
            assert!(close(molecule.contour_length(), length, 2e-3), "{}", molecule.name);
            assert!(close(molecule.relaxed_link(), link, 5e-4), "{}", molecule.name);
            assert!(close(molecule.excess_link(-0.06), excess, 4e-3), "{}", molecule.name);
            assert!(close(5.0 / molecule.contour_length(), slenderness, 2e-2), "{}", molecule.name);
        }
    }

    #[test]
    fn stiffness_is_persistence_times_thermal_energy() {
        assert!(close(BENDING_STIFFNESS, 205.7, 1e-12));
        assert!(close(TWIST_STIFFNESS / BENDING_STIFFNESS, 1.5, 1e-12));
    }

    #[test]
    fn diameter_follows_the_salt() {
        for (salt, diameter) in SALT_TABLE {
            assert!(close(contact_diameter_nm(salt).unwrap(), diameter, 1e-12));
        }
        let between = contact_diameter_nm(0.02).unwrap();
        assert!(between < 15.0 && between > 7.5);
        for refused in [0.0, 0.009, 1.1, f64::NAN, -1.0] {
            assert!(contact_diameter_nm(refused).is_err());
        }
    }

    #[test]
    fn molecules_are_found_by_name() {
        assert_eq!(Molecule::named("PUC19").unwrap(), PUC19);
        let refused = Molecule::named("pUC18").unwrap_err().to_string();
        assert!(refused.contains("pUC18") && refused.contains("pBR322"), "{refused}");
    }
}
