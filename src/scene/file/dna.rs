//! DNA in the words of those who work with it: base pairs, salt, supercoiling density.

use crate::dna::{self, BENDING_PERSISTENCE, HELICAL_REPEAT, RISE, STRETCH_MODULUS, TWIST_PERSISTENCE_LOW};
use crate::error::InputError;
use crate::rod::Section;
use crate::scene::Units;

use super::refuse::inconsistent;
use super::text::{DnaText, SceneText};

/// Salt of a scene that says nothing of it, mmol/l: physiological.
const SALT: f64 = 150.0;
/// Relative difference of two lengths of one molecule that counts as rounding of a rise or of points.
const TOL_LENGTH: f64 = 0.01;

/// A molecule: nm and pN.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dna {
    pub section: Section,
    /// Contour length, nm.
    pub length: f64,
    /// Link of the relaxed molecule, turns.
    pub relaxed_link: f64,
}

impl Dna {
    pub(super) fn new(text: &DnaText) -> Result<Self, InputError> {
        if text.base_pairs == 0 {
            return Err(InputError::Count { field: "dna.base_pairs".into(), value: 0, allowed: "at least 1" });
        }
        let given = |key: &str, value: Option<f64>, default: f64| {
            let value = value.unwrap_or(default);
            InputError::positive(&format!("dna.{key}"), value).map(|()| value)
        };
        let repeat = given("helical_repeat", text.helical_repeat, HELICAL_REPEAT)?;
        let rise = given("rise", text.rise, RISE)?;
        let bending = given("bending_persistence", text.bending_persistence, BENDING_PERSISTENCE)?;
        let twisting = given("twist_persistence", text.twist_persistence, TWIST_PERSISTENCE_LOW)?;
        let stretching = given("stretch_modulus", text.stretch_modulus, STRETCH_MODULUS)?;
        let section = Section::isotropic(
            bending * dna::THERMAL_ENERGY,
            twisting * dna::THERMAL_ENERGY,
            stretching,
            stretching,
            0.5 * diameter(text)?,
        );
        let base_pairs = text.base_pairs as f64;
        Ok(Self { section, length: base_pairs * rise, relaxed_link: base_pairs / repeat })
    }

    /// Refuses a shape that is not as long as the molecule.
    pub(super) fn check_length(&self, length: f64) -> Result<(), InputError> {
        if (length / self.length - 1.0).abs() <= TOL_LENGTH {
            return Ok(());
        }
        let reason =
            format!("are {} nm long, but the shape is {length} nm long: they are to agree within 1 %", self.length);
        Err(inconsistent("dna.base_pairs".to_owned(), &reason))
    }
}

fn diameter(text: &DnaText) -> Result<f64, InputError> {
    match (text.diameter, text.salt) {
        (Some(_), Some(_)) => Err(inconsistent("dna.diameter".to_owned(), "follows from salt_mM: give one of them")),
        (Some(diameter), None) => InputError::positive("dna.diameter", diameter).map(|()| diameter),
        (None, salt) => {
            let salt = salt.unwrap_or(SALT);
            let allowed = "between 10 and 1000 mmol/l (or give the contact diameter, in nm)";
            InputError::check("dna.salt_mM", salt, (10.0..=1000.0).contains(&salt), allowed)?;
            dna::contact_diameter_nm((salt / 1000.0).clamp(0.01, 1.0))
        }
    }
}

/// The units of a scene: nm and pN where there is DNA in it.
pub(super) fn units(text: &SceneText) -> Result<Units, InputError> {
    let dna = text.rods.iter().any(|rod| rod.dna.is_some());
    if dna && text.units == Units::default() {
        return Ok(Units { length: "nm".to_owned(), force: "pN".to_owned() });
    }
    let Units { length, force } = &text.units;
    let needs = |field: &str, what: &str| {
        let reason = format!("{what} counts in nm and pN, but units are {length} and {force}");
        inconsistent(field.to_owned(), &reason)
    };
    if dna && !text.units.are_molecular() {
        return Err(needs("rods.dna", "dna"));
    }
    if let Some(temperature) = text.temperature {
        InputError::positive("temperature", temperature)?;
        if !text.units.are_molecular() {
            return Err(needs("temperature", "kT"));
        }
    }
    Ok(text.units.clone())
}
