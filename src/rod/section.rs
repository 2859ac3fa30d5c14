//! Sections: the stiffnesses of the quadratic Cosserat energy and the contact radius.

use std::f64::consts::PI;

use crate::error::InputError;

/// Stiffnesses of a section (axes d1, d2; d3 along the rod) and its contact radius.
///
/// Energy per reference length: ½(GA1 Γ1² + GA2 Γ2² + EA Γ3² + EI1 K1² + EI2 K2² + GJ K3²).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Shear stiffnesses GA1, GA2 \[F\].
    pub shearing: [f64; 2],
    /// Extensional stiffness EA \[F\].
    pub stretching: f64,
    /// Bending stiffnesses EI1, EI2 about d1, d2 \[F·L²\].
    pub bending: [f64; 2],
    /// Torsional stiffness GJ \[F·L²\].
    pub twisting: f64,
    /// Contact radius ε \[L\]; 0 = this rod takes no part in contact.
    pub contact_radius: f64,
}

/// Geometry of a cross-section for [`Section::from_moduli`]; lengths \[L\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CrossSection {
    /// Solid disc of the given radius.
    Circle {
        /// Radius.
        radius: f64,
    },
    /// Solid rectangle, `width` along d1 and `height` along d2.
    Rectangle {
        /// Extent along d1.
        width: f64,
        /// Extent along d2.
        height: f64,
    },
}

impl CrossSection {
    /// Area A \[L²\].
    pub fn area(&self) -> f64 {
        match *self {
            Self::Circle { radius } => PI * radius.powi(2),
            Self::Rectangle { width, height } => width * height,
        }
    }

    /// Second moments of area I1 = ∫x2² dA about d1 and I2 = ∫x1² dA about d2 \[L⁴\].
    pub(crate) fn second_moments(&self) -> [f64; 2] {
        match *self {
            Self::Circle { radius } => [PI * radius.powi(4) / 4.0; 2],
            Self::Rectangle { width, height } => [width * height.powi(3) / 12.0, height * width.powi(3) / 12.0],
        }
    }

    /// Saint-Venant torsion constant J \[L⁴\]: torsional stiffness GJ = shear modulus × J.
    ///
    /// Disc: ½π r⁴. Rectangle of sides a ≥ b (Timoshenko & Goodier 1970, Theory of Elasticity, §109, eq. 171):
    /// J = a b³ ⅓ (1 − (192/π⁵)(b/a) Σ_{n odd} tanh(nπa/2b)/n⁵), summed to machine precision.
    pub(crate) fn torsion_constant(&self) -> f64 {
        match *self {
            Self::Circle { radius } => PI * radius.powi(4) / 2.0,
            Self::Rectangle { width, height } => {
                let (a, b) = (width.max(height), width.min(height));
                // tanh(nπa/2b) is 1 to machine precision from n = 13 on, and Σ_{n odd} n⁻⁵ = (31/32) ζ(5): only the
                // differences from 1 are summed, which vanish quickly.
                let defect: f64 = (1..=13)
                    .step_by(2)
                    .map(f64::from)
                    .map(|n| (1.0 - (n * PI * a / (2.0 * b)).tanh()) / n.powi(5))
                    .sum();
                let odd_sum = 31.0 / 32.0 * 1.036_927_755_143_37;
                a * b.powi(3) / 3.0 * (1.0 - 192.0 / PI.powi(5) * (b / a) * (odd_sum - defect))
            }
        }
    }

    /// Shear correction factor k of Cowper (1966, J. Appl. Mech. 33:335) for Poisson's ratio ν: 6(1+ν)/(7+6ν) for a
    /// disc, 10(1+ν)/(12+11ν) for a rectangle.
    ///
    /// ```
    /// use supercoil::rod::CrossSection;
    /// let disc = CrossSection::Circle { radius: 1.0 };
    /// assert!((disc.shear_correction(0.3) - 0.886).abs() < 1e-3);
    /// ```
    pub fn shear_correction(&self, poisson: f64) -> f64 {
        match self {
            Self::Circle { .. } => 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson),
            Self::Rectangle { .. } => 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson),
        }
    }

    fn check(&self, field: &str) -> Result<(), InputError> {
        match *self {
            Self::Circle { radius } => InputError::positive(&format!("{field}.circle"), radius),
            Self::Rectangle { width, height } => {
                InputError::positive(&format!("{field}.rectangle[0]"), width)?;
                InputError::positive(&format!("{field}.rectangle[1]"), height)
            }
        }
    }
}

impl Section {
    /// Bending and twisting equal about all axes of the section.
    ///
    /// ```
    /// use supercoil::rod::Section;
    /// let dna = Section::isotropic(205.7, 308.55, 1100.0, 1100.0, 2.5); // pN nm², pN nm², pN, pN, nm
    /// assert_eq!(dna.bending, [205.7; 2]);
    /// ```
    pub fn isotropic(bending: f64, twisting: f64, stretching: f64, shearing: f64, contact_radius: f64) -> Self {
        Self { shearing: [shearing; 2], stretching, bending: [bending; 2], twisting, contact_radius }
    }

    /// Stiffnesses of a homogeneous solid section: EA, EI1, EI2 from Young's modulus `young` E \[F/L²\], GJ and
    /// GA1 = GA2 = k G A from the shear modulus `shear_modulus` G \[F/L²\].
    ///
    /// `shear_correction` k (dimensionless) lowers the shear stiffness, because the shear stress is not uniform over
    /// the section (see [`CrossSection::shear_correction`]; 1 = none). `contact_radius` \[L\] need not be the radius of
    /// the section.
    ///
    /// # Errors
    /// Any modulus, size or `shear_correction` not finite and positive, a `contact_radius` negative or not finite.
    ///
    /// ```
    /// use supercoil::rod::{CrossSection, Section};
    /// let wire = Section::from_moduli(210e9, 80e9, CrossSection::Circle { radius: 1e-3 }, 0.9, 1e-3)?;
    /// assert!(wire.is_isotropic());
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    pub fn from_moduli(
        young: f64,
        shear_modulus: f64,
        cross_section: CrossSection,
        shear_correction: f64,
        contact_radius: f64,
    ) -> Result<Self, InputError> {
        InputError::positive("section.young", young)?;
        InputError::positive("section.shear_modulus", shear_modulus)?;
        InputError::positive("section.shear_correction", shear_correction)?;
        cross_section.check("section")?;
        let area = cross_section.area();
        let section = Self {
            shearing: [shear_correction * shear_modulus * area; 2],
            stretching: young * area,
            bending: cross_section.second_moments().map(|moment| young * moment),
            twisting: shear_modulus * cross_section.torsion_constant(),
            contact_radius,
        };
        section.check("section").map(|()| section)
    }

    /// Whether the section has no preferred bending or shear direction.
    pub fn is_isotropic(&self) -> bool {
        self.bending[0] == self.bending[1] && self.shearing[0] == self.shearing[1]
    }

    /// The smaller bending stiffness \[F·L²\].
    pub(crate) fn smaller_bending(&self) -> f64 {
        self.bending[0].min(self.bending[1])
    }

    /// Refuses non-positive or non-finite stiffnesses; `field` names the section in the error.
    ///
    /// # Errors
    /// The first offending stiffness or radius.
    pub fn check(&self, field: &str) -> Result<(), InputError> {
        for (name, value) in [
            ("shearing[0]", self.shearing[0]),
            ("shearing[1]", self.shearing[1]),
            ("stretching", self.stretching),
            ("bending[0]", self.bending[0]),
            ("bending[1]", self.bending[1]),
            ("twisting", self.twisting),
        ] {
            InputError::positive(&format!("{field}.{name}"), value)?;
        }
        let radius = self.contact_radius;
        InputError::check(&format!("{field}.contact_radius"), radius, radius >= 0.0, "finite and not negative")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn torsion(width: f64, height: f64) -> f64 {
        CrossSection::Rectangle { width, height }.torsion_constant()
    }

    #[test]
    fn torsion_of_rectangles_matches_the_plain_series_and_the_published_table() {
        // Timoshenko & Goodier 1970, §109, table: J/(a b³) for a/b = 1, 2, 10 and infinity.
        for (ratio, coefficient) in [(1.0, 0.1406), (2.0, 0.229), (10.0, 0.312), (1e6, 0.333)] {
            assert_relative_eq!(torsion(ratio, 1.0), coefficient * ratio, max_relative = 3e-3);
        }
        let series: f64 =
            (1..20001).step_by(2).rev().map(f64::from).map(|n| (n * PI * 1.3 / 2.0).tanh() / n.powi(5)).sum();
        let expected = 1.3 / 3.0 * (1.0 - 192.0 / PI.powi(5) / 1.3 * series);
        assert_relative_eq!(torsion(1.3, 1.0), expected, max_relative = 1e-14);
        assert_eq!(torsion(1.3, 1.0), torsion(1.0, 1.3));
    }

    #[test]
    fn stiffnesses_of_disc_and_rectangle() {
        let disc = Section::from_moduli(2.0, 0.8, CrossSection::Circle { radius: 0.5 }, 0.9, 0.5).unwrap();
        assert_relative_eq!(disc.stretching, 2.0 * PI / 4.0, max_relative = 1e-15);
        assert_relative_eq!(disc.twisting / disc.bending[0], 0.8 * 2.0 / 2.0, max_relative = 1e-15);
        let strip = CrossSection::Rectangle { width: 3.0, height: 0.1 };
        let strip = Section::from_moduli(12.0, 5.0, strip, 1.0, 0.0).unwrap();
        assert_relative_eq!(strip.bending[0], 3.0 * 1e-3, max_relative = 1e-14);
        assert_relative_eq!(strip.bending[1], 0.1 * 27.0, max_relative = 1e-14);
        assert!(!strip.is_isotropic());
    }

    #[test]
    fn bad_sizes_are_named() {
        let error = Section::from_moduli(1.0, 1.0, CrossSection::Rectangle { width: 1.0, height: -2.0 }, 1.0, 0.0);
        assert_eq!(error.unwrap_err().to_string(), "section.rectangle[1] = -2: must be a finite number greater than 0");
        let error = Section::from_moduli(f64::NAN, 1.0, CrossSection::Circle { radius: 1.0 }, 1.0, 0.0).unwrap_err();
        assert!(error.to_string().starts_with("section.young = NaN"));
    }
}
