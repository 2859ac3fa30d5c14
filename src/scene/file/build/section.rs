//! A section from the text of a scene: stiffnesses, moduli and geometry, a 6 × 6 matrix or a table.

use std::path::Path;

use crate::error::InputError;
use crate::rod::{Along, CrossSection, Section, Stiffness, check_stiffness};
use crate::scene::file::syntax::SectionText;
use crate::scene::file::syntax::values::List;
use crate::scene::{SectionTable, read_section};

const SECTION_WAYS: &str = "a section is given either by bending, twisting, stretching, shearing (stiffnesses), by \
    young, poisson or shear_modulus, and circle = radius or rectangle = [width, height], by a stiffness of 6 × 6 \
    numbers, or by a table";

const BY_SEQUENCE: &str = "the sequence gives the stiffness: give contact_radius only";

/// A section, and what varies along the rod.
pub(super) struct GivenSection {
    pub section: Section,
    pub stiffness: Option<Along<Stiffness>>,
    pub contact_radii: Option<Along<f64>>,
}

impl GivenSection {
    /// The same all along.
    pub fn uniform(section: Section) -> Self {
        Self { section, stiffness: None, contact_radii: None }
    }
}

pub(super) fn section(
    text: &SectionText,
    contact: bool,
    base_dir: &Path,
    by_sequence: Option<Along<Stiffness>>,
) -> Result<GivenSection, InputError> {
    let table = text.table.as_ref().map(|file| read_section(&base_dir.join(file))).transpose()?;
    let contact_radii = table.as_ref().and_then(|table| table.contact_radii.clone());
    let radius = match (text.contact_radius, text.circle, &contact_radii) {
        (Some(_), _, Some(_)) => {
            let reason = "the table has a column contact_radius: remove this key";
            return Err(InputError::inconsistent("section.contact_radius", reason));
        }
        (Some(radius), _, None) | (None, Some(radius), None) => radius,
        // where lines of contact need the most nodes
        (None, _, Some(radii)) => radii.least(),
        (None, None, None) if !contact => 0.0,
        (None, None, None) => {
            let reason = "missing: the radius within which other strands touch this rod (0 = takes no part in contact)";
            return Err(InputError::inconsistent("section.contact_radius", reason));
        }
    };
    let moduli = [text.young, text.poisson, text.shear_modulus, text.circle, text.shear_correction];
    let geometric = moduli.iter().any(Option::is_some) || text.rectangle.is_some();
    let stiff = [text.twisting, text.stretching].iter().any(Option::is_some)
        || [text.bending, text.shearing].iter().any(Option::is_some);
    let full = match (full_stiffness(text, table)?, by_sequence) {
        (Some(_), Some(_)) => {
            return Err(InputError::inconsistent("section", BY_SEQUENCE));
        }
        (None, Some(_)) if stiff || geometric => return Err(InputError::inconsistent("section", BY_SEQUENCE)),
        (own, by_sequence) => own.or(by_sequence),
    };
    if let Some(along) = full {
        if stiff || geometric {
            return Err(InputError::inconsistent("section", format!("keys of several kinds: {SECTION_WAYS}")));
        }
        // the mean over the rod replaces it later; the length is not known here
        let section = Section::of_diagonal(&along.at(0.0), radius);
        return section.check("section").map(|()| GivenSection { section, stiffness: Some(along), contact_radii });
    }
    match (stiff, geometric) {
        (true, false) => stiffnesses(text, radius).map(GivenSection::uniform),
        (false, true) => moduli_section(text, radius).map(GivenSection::uniform),
        (true, true) => Err(InputError::inconsistent("section", format!("keys of both kinds: {SECTION_WAYS}"))),
        (false, false) => Err(InputError::inconsistent("section", format!("nothing given: {SECTION_WAYS}"))),
    }
}

/// The full stiffness, where a table or a matrix is given.
fn full_stiffness(text: &SectionText, table: Option<SectionTable>) -> Result<Option<Along<Stiffness>>, InputError> {
    match (table, text.stiffness) {
        (None, None) => Ok(None),
        (Some(table), None) => Ok(Some(table.stiffness)),
        (None, Some(List(rows))) => {
            let matrix = Stiffness::from_fn(|i, j| rows[i].0[j]);
            check_stiffness("section.stiffness", &matrix).map(|()| Some(Along::constant(matrix)))
        }
        (Some(_), Some(_)) => Err(InputError::inconsistent("section", "give either a table or a stiffness")),
    }
}

fn stiffnesses(text: &SectionText, contact_radius: f64) -> Result<Section, InputError> {
    let section = Section {
        bending: present("bending", text.bending)?.0,
        twisting: present("twisting", text.twisting)?,
        stretching: present("stretching", text.stretching)?,
        shearing: present("shearing", text.shearing)?.0,
        contact_radius,
    };
    section.check("section").map(|()| section)
}

fn moduli_section(text: &SectionText, contact_radius: f64) -> Result<Section, InputError> {
    let young = present("young", text.young)?;
    let shear_modulus = match (text.poisson, text.shear_modulus) {
        (None, Some(shear_modulus)) => shear_modulus,
        (Some(poisson), None) => {
            let ok = poisson > -1.0 && poisson <= 0.5;
            InputError::check("section.poisson", poisson, ok, "greater than -1 and at most 0.5")?;
            young / (2.0 * (1.0 + poisson))
        }
        _ => return Err(InputError::inconsistent("section", "give either poisson or shear_modulus")),
    };
    let cross_section = match (text.circle, text.rectangle) {
        (Some(radius), None) => CrossSection::Circle { radius },
        (None, Some(List([width, height]))) => CrossSection::Rectangle { width, height },
        _ => {
            return Err(InputError::inconsistent(
                "section",
                "give either circle = radius or rectangle = [width, height]",
            ));
        }
    };
    let poisson = young / (2.0 * shear_modulus) - 1.0;
    let shear_correction = text.shear_correction.unwrap_or_else(|| cross_section.shear_correction(poisson));
    Section::from_moduli(young, shear_modulus, cross_section, shear_correction, contact_radius)
}

fn present<T>(key: &str, value: Option<T>) -> Result<T, InputError> {
    value.ok_or_else(|| InputError::inconsistent(format!("section.{key}"), format!("missing: {SECTION_WAYS}")))
}
