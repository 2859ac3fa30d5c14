//! Contact radius of a curve: one number, or one for each segment.

use crate::error::InputError;
use crate::math::LARGEST;

/// Contact radius of a curve \[L\], greater than 0.
///
/// A radius per segment is constant along the segment and steps at joints, where the larger of the two counts; the
/// contact distance of two points is the sum of their radii. Sites stay minima of the *distance of the centrelines*: a
/// shoulder, where a thick segment ends beside another strand, is no site unless the distance has a minimum there; the
/// zones and the smallest clearance see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius<'a> {
    /// One radius for the whole curve.
    Constant(f64),
    /// One for each segment, in order.
    PerSegment(&'a [f64]),
}

impl From<f64> for Radius<'_> {
    fn from(radius: f64) -> Self {
        Self::Constant(radius)
    }
}

impl<'a> From<&'a [f64]> for Radius<'a> {
    fn from(radii: &'a [f64]) -> Self {
        Self::PerSegment(radii)
    }
}

impl<'a> From<&'a Vec<f64>> for Radius<'a> {
    fn from(radii: &'a Vec<f64>) -> Self {
        Self::PerSegment(radii)
    }
}

impl<'a, const N: usize> From<&'a [f64; N]> for Radius<'a> {
    fn from(radii: &'a [f64; N]) -> Self {
        Self::PerSegment(radii)
    }
}

impl<'a> Radius<'a> {
    /// Radius of the k-th segment.
    #[inline]
    pub(crate) fn of(&self, k: usize) -> f64 {
        match self {
            Self::Constant(radius) => *radius,
            Self::PerSegment(radii) => radii[k],
        }
    }

    /// Largest radius.
    pub(crate) fn largest(&self) -> f64 {
        match self {
            Self::Constant(radius) => *radius,
            Self::PerSegment(radii) => radii.iter().copied().fold(0.0, f64::max),
        }
    }

    /// The radii if they were given one by one.
    pub(crate) fn list(&self) -> Option<&'a [f64]> {
        match *self {
            Self::Constant(_) => None,
            Self::PerSegment(radii) => Some(radii),
        }
    }

    /// Refuses a list of length other than `count`, and radii that are not finite and positive.
    pub(crate) fn check(&self, count: usize, field: &dyn Fn(&str) -> String) -> Result<(), InputError> {
        match self {
            Self::Constant(radius) => check_radius(&field("radius"), *radius),
            Self::PerSegment(radii) if radii.len() != count => {
                let allowed = "as many as segments";
                Err(InputError::Count { field: field("radius"), value: radii.len(), allowed })
            }
            Self::PerSegment(radii) => match radii.iter().position(|r| !is_legal(*r)) {
                Some(k) => check_radius(&field(&format!("radius[{k}]")), radii[k]),
                None => Ok(()),
            },
        }
    }
}

fn is_legal(radius: f64) -> bool {
    radius > 0.0 && radius <= LARGEST
}

fn check_radius(field: &str, radius: f64) -> Result<(), InputError> {
    InputError::check(field, radius, is_legal(radius), "a finite number greater than 0 and at most 1e100")
}
