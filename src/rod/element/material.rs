//! The material matrix: from strains to stress resultants.

use super::blocks::Slope;
use super::kinematics::inner;
use super::{Strain, Stress};
use crate::rod::Section;

/// The material matrix C of an element, in the order of [`Strain`].
#[derive(Debug, Clone, Copy)]
pub enum Material<'a> {
    /// A uniform diagonal matrix.
    Diagonal(&'a Strain),
    /// A full symmetric matrix for each integration point.
    Full(&'a [[Strain; 6]; 3]),
}

impl Material<'_> {
    /// One of no stiffness, of the same kind.
    #[must_use]
    pub(crate) fn without_stiffness(&self) -> Material<'static> {
        match self {
            Self::Diagonal(_) => Material::Diagonal(&[0.0; 6]),
            Self::Full(_) => Material::Full(&[[[0.0; 6]; 6]; 3]),
        }
    }

    /// Stress of a strain at integration point `g`.
    #[must_use]
    pub fn stress(&self, g: usize, strain: &Stress) -> Stress {
        match self {
            Self::Diagonal(material) => material.stress(g, strain),
            Self::Full(material) => material.stress(g, strain),
        }
    }
}

/// Products with the material matrix, separately for diagonal matrices, because most rods have these.
pub(super) trait MaterialLaw<const S: usize> {
    /// C ε at integration point `g`.
    fn stress(&self, g: usize, strain: &[f64; S]) -> [f64; S];

    /// C B for the derivatives B of the strains.
    fn of_slopes<const R: usize, const Z: usize>(&self, g: usize, b: &[Slope<R, Z>; S]) -> [Slope<R, Z>; S];
}

impl<const S: usize> MaterialLaw<S> for [f64; S] {
    #[inline]
    fn stress(&self, _: usize, strain: &[f64; S]) -> [f64; S] {
        std::array::from_fn(|i| self[i] * strain[i])
    }

    #[inline]
    fn of_slopes<const R: usize, const Z: usize>(&self, _: usize, b: &[Slope<R, Z>; S]) -> [Slope<R, Z>; S] {
        std::array::from_fn(|i| b[i].times(self[i]))
    }
}

impl MaterialLaw<6> for [[Strain; 6]; 3] {
    #[inline]
    fn stress(&self, g: usize, strain: &Stress) -> Stress {
        std::array::from_fn(|i| inner(&self[g][i], strain))
    }

    #[inline]
    fn of_slopes<const R: usize, const Z: usize>(&self, g: usize, b: &[Slope<R, Z>; 6]) -> [Slope<R, Z>; 6] {
        self[g].map(|entries| Slope::sum(&entries, b))
    }
}

/// Diagonal of the material matrix, in the order of [`Strain`].
pub fn stiffness(section: &Section) -> Strain {
    [
        section.shearing[0],
        section.shearing[1],
        section.stretching,
        section.bending[0],
        section.bending[1],
        section.twisting,
    ]
}
