//! Sections: the stiffnesses of the quadratic Cosserat energy and the contact radius.

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

impl Section {
    /// Bending and twisting equal about all axes of the section.
    pub fn isotropic(bending: f64, twisting: f64, stretching: f64, shearing: f64, contact_radius: f64) -> Self {
        Self { shearing: [shearing; 2], stretching, bending: [bending; 2], twisting, contact_radius }
    }

    /// Whether the section has no preferred bending or shear direction.
    pub fn is_isotropic(&self) -> bool {
        self.bending[0] == self.bending[1] && self.shearing[0] == self.shearing[1]
    }

    /// Refuses non-positive or non-finite stiffnesses; `field` names the section in the error.
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
