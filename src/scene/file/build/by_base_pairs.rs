//! DNA by base pairs, salt and supercoiling density.

use crate::dna::salt::debye_length_nm;
use crate::dna::{self, BENDING_PERSISTENCE, HELICAL_REPEAT, RISE, STRETCH_MODULUS, TWIST_PERSISTENCE_LOW};
use crate::error::InputError;
use crate::rod::Section;
use crate::scene::file::syntax::{DnaText, ElectrostaticsText, RodText, SceneText};
use crate::scene::{Electrostatics, Units};

pub(super) const NEEDS_DNA: &str =
    "a supercoiling density is counted on the link of relaxed DNA: the rod has no dna, so give excess_link in turns";
/// Default salt concentration, mmol/l: physiological.
const SALT: f64 = 150.0;
/// Largest relative difference of two lengths of one molecule: rounding of a rise or of points.
const TOL_LENGTH: f64 = 0.01;

/// A molecule, in nm and pN.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dna {
    pub section: Section,
    /// Contour length, nm.
    pub length: f64,
    /// Link of the relaxed molecule, turns.
    pub relaxed_link: f64,
    /// Base pairs.
    pub base_pairs: usize,
}

impl Dna {
    /// `charged`: whether strands repel each other beyond their contact diameter.
    pub(super) fn new(text: &DnaText, charged: bool) -> Result<Self, InputError> {
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
            0.5 * diameter(text, charged)?,
        );
        let (base_pairs, count) = (text.base_pairs, text.base_pairs as f64);
        Ok(Self { section, length: count * rise, relaxed_link: count / repeat, base_pairs })
    }

    /// Refuses a shape whose length differs from that of the molecule.
    pub(super) fn check_length(&self, length: f64) -> Result<(), InputError> {
        if (length / self.length - 1.0).abs() <= TOL_LENGTH {
            return Ok(());
        }
        let reason = format!(
            "are {:.3} nm long, but the shape is {length:.3} nm long: they are to agree within 1 % (of measured \
             points, fit = \"rise\" in the shape takes the rise from them)",
            self.length
        );
        Err(InputError::inconsistent("dna.base_pairs", &reason))
    }
}

/// Converts salt \[mmol/l\] to the unit of the tables, mol/l.
fn molar(field: &str, salt: f64, otherwise: &'static str) -> Result<f64, InputError> {
    InputError::check(field, salt, (10.0..=1000.0).contains(&salt), otherwise)?;
    Ok((salt / 1000.0).clamp(0.01, 1.0))
}

/// Charges of all rods; those by salt are in pN and nm.
pub(super) fn electrostatics(text: ElectrostaticsText) -> Result<Electrostatics, InputError> {
    const FIELD: &str = "contact.electrostatics";
    match (text.salt, text.strength, text.debye_length) {
        (Some(salt), None, None) => {
            let salt = molar(
                &format!("{FIELD}.salt_mM"),
                salt,
                "between 10 and 1000 mmol/l (or give strength and debye_length)",
            )?;
            let strength = text.charge.unwrap_or_default().strength(salt)?;
            Ok(Electrostatics { strength, debye_length: debye_length_nm(salt)? })
        }
        (None, Some(strength), Some(debye_length)) if text.charge.is_none() => {
            Ok(Electrostatics { strength, debye_length })
        }
        _ => Err(InputError::inconsistent(FIELD.to_owned(), "give salt_mM (and charge), or strength and debye_length")),
    }
}

fn diameter(text: &DnaText, charged: bool) -> Result<f64, InputError> {
    if charged && text.salt.is_some() {
        let reason = "is part of the effective diameter, but strands repel each other: contact.electrostatics says it";
        return Err(InputError::inconsistent("dna.salt_mM", reason));
    }
    match (text.diameter, text.salt) {
        (None, None) if charged => Ok(dna::BARE_DIAMETER),
        (Some(_), Some(_)) => Err(InputError::inconsistent("dna.diameter", "follows from salt_mM: give one of them")),
        (Some(diameter), None) => InputError::positive("dna.diameter", diameter).map(|()| diameter),
        (None, salt) => {
            let salt = salt.unwrap_or(SALT);
            let allowed = "between 10 and 1000 mmol/l (or give the contact diameter, in nm)";
            dna::contact_diameter_nm(molar("dna.salt_mM", salt, allowed)?)
        }
    }
}

/// The units of a scene; nm and pN if it has DNA, by its length or by its sequence.
pub(super) fn units(text: &SceneText) -> Result<Units, InputError> {
    let key = |rod: &RodText| match (&rod.dna, &rod.sequence) {
        (Some(_), _) => Some("dna"),
        (None, Some(_)) => Some("sequence"),
        (None, None) => None,
    };
    let key = text.rods.iter().find_map(key);
    if let Some(temperature) = text.temperature {
        InputError::positive("temperature", temperature)?;
    }
    let dna = key.is_some();
    if dna && text.units == Units::default() {
        return Ok(Units { length: "nm".to_owned(), force: "pN".to_owned() });
    }
    let Units { length, force } = &text.units;
    let needs = |field: &str, what: &str| {
        let reason = format!("{what} counts in nm and pN, but units are {length} and {force}: leave units out");
        InputError::inconsistent(field.to_owned(), &reason)
    };
    if let Some(key) = key.filter(|_| !text.units.are_molecular()) {
        return Err(needs(&format!("rods.{key}"), key));
    }
    if text.contact.electrostatics.is_some_and(|charges| charges.salt.is_some()) && !text.units.are_molecular() && !dna
    {
        return Err(needs("contact.electrostatics.salt_mM", "salt"));
    }
    if text.temperature.is_some() && !text.units.are_molecular() {
        return Err(needs("temperature", "kT"));
    }
    Ok(text.units.clone())
}
