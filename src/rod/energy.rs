//! Elastic energies by kind of deformation.

use std::ops::AddAssign;

/// Kind of deformation that a strain measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Deformation {
    Stretching,
    Shearing,
    Bending,
    Twisting,
}

impl Deformation {
    pub(crate) const ALL: [Self; 4] = [Self::Stretching, Self::Shearing, Self::Bending, Self::Twisting];
    /// Of Γ1, Γ2, Γ3, K1, K2, K3.
    pub(crate) const OF_STRAINS: [Self; 6] =
        [Self::Shearing, Self::Shearing, Self::Stretching, Self::Bending, Self::Bending, Self::Twisting];

    /// Name of its energy in reports.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Stretching => "stretching",
            Self::Shearing => "shearing",
            Self::Bending => "bending",
            Self::Twisting => "twisting",
        }
    }
}

/// Elastic energies \[F·L\]: half of stress times strain. The energy of a coupling is split evenly.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ElasticEnergies {
    /// ½∫EA Γ3².
    pub stretching: f64,
    /// ½∫GA1 Γ1² + GA2 Γ2².
    pub shearing: f64,
    /// ½∫EI1 K1² + EI2 K2².
    pub bending: f64,
    /// ½∫GJ K3².
    pub twisting: f64,
}

impl ElasticEnergies {
    /// Sum of all kinds.
    pub fn total(&self) -> f64 {
        self.stretching + self.shearing + self.bending + self.twisting
    }

    /// The energy of one kind.
    pub(crate) fn of(&self, kind: Deformation) -> f64 {
        match kind {
            Deformation::Stretching => self.stretching,
            Deformation::Shearing => self.shearing,
            Deformation::Bending => self.bending,
            Deformation::Twisting => self.twisting,
        }
    }

    /// Adds energy of one kind.
    pub(crate) fn add(&mut self, kind: Deformation, energy: f64) {
        let sum = match kind {
            Deformation::Stretching => &mut self.stretching,
            Deformation::Shearing => &mut self.shearing,
            Deformation::Bending => &mut self.bending,
            Deformation::Twisting => &mut self.twisting,
        };
        *sum += energy;
    }

    /// All of them times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            stretching: factor * self.stretching,
            shearing: factor * self.shearing,
            bending: factor * self.bending,
            twisting: factor * self.twisting,
        }
    }
}

impl AddAssign for ElasticEnergies {
    fn add_assign(&mut self, other: Self) {
        self.stretching += other.stretching;
        self.shearing += other.shearing;
        self.bending += other.bending;
        self.twisting += other.twisting;
    }
}
