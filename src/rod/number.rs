//! Numbers of a rod that stages may change: section, length, natural curvature and twist, the part of a bound natural
//! state.

use crate::error::InputError;
use crate::rod::{Along, Natural, NaturalStrains, Rod};

/// A number of a rod that stages may ramp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RodNumber {
    /// Contact radius \[L\].
    ContactRadius,
    /// Reference length \[L\]: the rod grows or shrinks evenly along itself.
    Length,
    /// EI1, about d1 \[F·L²\].
    Bending1,
    /// EI2, about d2 \[F·L²\].
    Bending2,
    /// GJ \[F·L²\].
    Twisting,
    /// EA \[F\].
    Stretching,
    /// GA1 \[F\].
    Shearing1,
    /// GA2 \[F\].
    Shearing2,
    /// Natural curvature about d1 \[1/L\].
    Curvature1,
    /// Natural curvature about d2 \[1/L\].
    Curvature2,
    /// Natural twist \[rad/L\].
    Twist,
    /// Part of a bound natural state that is in force, see [`Binding`].
    Binding,
}

/// A natural state of which a part is in force: free strains + part × (bound strains − free strains), six numbers along
/// the rod. Where a rod does not get to its natural state from its start shape by itself, the part is ramped from 0 to
/// 1.
#[derive(Debug, Clone)]
pub struct Binding {
    /// Natural strains at 0.
    pub free: Along<NaturalStrains>,
    /// Natural strains at 1.
    pub bound: Along<NaturalStrains>,
    /// The part. Legal: 0 to 1.
    pub part: f64,
}

impl Binding {
    /// The natural state that is in force.
    pub fn natural(&self) -> Natural {
        Natural::Varying(self.free.mixed(&self.bound, self.part))
    }
}

impl RodNumber {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::ContactRadius => "contact_radius",
            Self::Length => "length",
            Self::Bending1 => "bending_1",
            Self::Bending2 => "bending_2",
            Self::Twisting => "twisting",
            Self::Stretching => "stretching",
            Self::Shearing1 => "shearing_1",
            Self::Shearing2 => "shearing_2",
            Self::Curvature1 => "natural_curvature_1",
            Self::Curvature2 => "natural_curvature_2",
            Self::Twist => "natural_twist",
            Self::Binding => "binding",
        }
    }

    fn is_natural(self) -> bool {
        matches!(self, Self::Curvature1 | Self::Curvature2 | Self::Twist)
    }

    fn is_stiffness(self) -> bool {
        !self.is_natural() && !matches!(self, Self::ContactRadius | Self::Length | Self::Binding)
    }
}

impl Rod {
    /// Value of a number of this rod.
    pub fn number(&self, which: RodNumber) -> f64 {
        let (section, kappa) = (&self.section, self.uniform_kappa());
        match which {
            RodNumber::ContactRadius => section.contact_radius,
            RodNumber::Length => self.length,
            RodNumber::Bending1 => section.bending[0],
            RodNumber::Bending2 => section.bending[1],
            RodNumber::Twisting => section.twisting,
            RodNumber::Stretching => section.stretching,
            RodNumber::Shearing1 => section.shearing[0],
            RodNumber::Shearing2 => section.shearing[1],
            RodNumber::Curvature1 => kappa[0],
            RodNumber::Curvature2 => kappa[1],
            RodNumber::Twist => kappa[2],
            RodNumber::Binding => self.binding.as_ref().map_or(1.0, |binding| binding.part),
        }
    }

    /// Sets a number that `Rod::check_number` allows. Nodes are unchanged.
    #[cfg(feature = "solver")]
    pub(crate) fn set_number(&mut self, which: RodNumber, value: f64) {
        let mut kappa = self.uniform_kappa();
        let section = &mut self.section;
        match which {
            RodNumber::ContactRadius => section.contact_radius = value,
            RodNumber::Length => self.length = value,
            RodNumber::Bending1 => section.bending[0] = value,
            RodNumber::Bending2 => section.bending[1] = value,
            RodNumber::Twisting => section.twisting = value,
            RodNumber::Stretching => section.stretching = value,
            RodNumber::Shearing1 => section.shearing[0] = value,
            RodNumber::Shearing2 => section.shearing[1] = value,
            RodNumber::Curvature1 => kappa[0] = value,
            RodNumber::Curvature2 => kappa[1] = value,
            RodNumber::Twist => kappa[2] = value,
            RodNumber::Binding => {
                if let Some(binding) = &mut self.binding {
                    binding.part = value;
                    self.natural = binding.natural();
                }
            }
        }
        if which.is_natural() {
            self.natural = Natural::Uniform { kappa };
        }
    }

    /// Refuses illegal values, and numbers that vary along this rod.
    ///
    /// # Errors
    /// A stiffness, length or contact radius that is not positive; the contact radius of a rod that takes no part in
    /// contact, or whose radius varies along it; stiffnesses of a rod with a full stiffness; length and natural strains
    /// of rods whose natural strains, or radii, vary along them; a binding of rods without one, or beyond 0 to 1.
    pub(crate) fn check_number(&self, field: &str, which: RodNumber, to: f64) -> Result<(), InputError> {
        let refuse = |reason: &str| {
            let reason = format!("rod \"{}\" {reason}", self.name);
            Err(InputError::Inconsistent { field: field.to_owned(), reason })
        };
        let is_uniform = matches!(self.natural, Natural::Straight | Natural::Uniform { .. });
        if which.is_stiffness() && self.stiffness.is_some() {
            return refuse("has a full stiffness: its single numbers cannot be ramped");
        }
        if !is_uniform && (which.is_natural() || which == RodNumber::Length) {
            return refuse(
                "has natural strains that vary along it: ramps of natural strains and of length need uniform ones",
            );
        }
        if self.contact_radii.is_some() && matches!(which, RodNumber::ContactRadius | RodNumber::Length) {
            return refuse(
                "has a contact radius that varies along it: ramps of radius and of length need a uniform one",
            );
        }
        if which == RodNumber::ContactRadius && self.section.contact_radius <= 0.0 {
            return refuse("takes no part in contact: a contact radius cannot be ramped from 0");
        }
        if which.is_natural() {
            return InputError::check(field, to, true, "a finite number");
        }
        if which == RodNumber::Binding {
            if self.binding.is_none() {
                return refuse(
                    "has no natural state that could be in force in part: give it a natural table, or proteins",
                );
            }
            return InputError::check(field, to, (0.0..=1.0).contains(&to), "between 0 and 1");
        }
        InputError::positive(field, to)
    }

    fn uniform_kappa(&self) -> [f64; 3] {
        if let Natural::Uniform { kappa } = self.natural { kappa } else { [0.0; 3] }
    }
}
