//! Full stiffnesses of a section: 6×6 matrices that couple its strains.

use crate::error::InputError;
use crate::rod::Section;

/// A symmetric positive definite stiffness in the order Γ1 Γ2 Γ3 K1 K2 K3, natural strains subtracted: W = ½ ∫ εᵀ C ε
/// ds. Units \[F\] among Γ, \[F·L\] between Γ and K, \[F·L²\] among K. Twist–bend coupling is entries (4, 5) and (5,
/// 4).
pub type Stiffness = nalgebra::Matrix6<f64>;

/// Smallest eigenvalue accepted, of the matrix scaled to a unit diagonal. Smaller ones are rounding.
const LEAST_EIGENVALUE: f64 = 1e-12;
/// Largest difference of symmetric entries, relative to the diagonal, because numbers may be written with ten digits.
const TOL_SYMMETRY: f64 = 1e-9;

impl Section {
    /// The section whose six stiffnesses are the diagonal of `stiffness`; provides scales for a rod with a full
    /// stiffness.
    #[must_use]
    pub fn of_diagonal(stiffness: &Stiffness, contact_radius: f64) -> Self {
        let c = stiffness.diagonal();
        Self { shearing: [c[0], c[1]], stretching: c[2], bending: [c[3], c[4]], twisting: c[5], contact_radius }
    }

    /// The six stiffnesses as a diagonal matrix, to which couplings may be added.
    #[must_use]
    pub fn stiffness(&self) -> Stiffness {
        let ([g1, g2], [b1, b2]) = (self.shearing, self.bending);
        Stiffness::from_diagonal(&[g1, g2, self.stretching, b1, b2, self.twisting].into())
    }
}

/// Refuses a matrix that is not finite, symmetric and positive definite.
pub(crate) fn check_stiffness(field: &str, stiffness: &Stiffness) -> Result<(), InputError> {
    for (i, value) in stiffness.diagonal().iter().enumerate() {
        InputError::positive(&format!("{field}[{i}][{i}]"), *value)?;
    }
    let mut scaled = *stiffness;
    for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
        let scale = (stiffness[(i, i)] * stiffness[(j, j)]).sqrt();
        let (value, mirrored) = (stiffness[(i, j)], stiffness[(j, i)]);
        let symmetric = (value - mirrored).abs() <= TOL_SYMMETRY * scale;
        InputError::check(&format!("{field}[{i}][{j}]"), value, symmetric, "finite and equal to its mirrored entry")?;
        scaled[(i, j)] = 0.5 * (value + mirrored) / scale;
    }
    let least = scaled.symmetric_eigenvalues().min();
    if least > LEAST_EIGENVALUE {
        return Ok(());
    }
    let reason = format!(
        "is not positive definite: scaled to a diagonal of ones, its smallest eigenvalue is {least:.3e}; it must be \
         greater than {LEAST_EIGENVALUE:e}"
    );
    Err(InputError::Inconsistent { field: field.to_owned(), reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_matrices_are_refused() {
        let section = Section { bending: [2.0, 3.0], ..Section::isotropic(1.0, 4.0, 5.0, 6.0, 0.1) };
        let good = section.stiffness();
        assert_eq!(Section::of_diagonal(&good, 0.1), section);
        let with = |entries: &[(usize, usize, f64)]| {
            let mut matrix = good;
            entries.iter().for_each(|&(i, j, value)| matrix[(i, j)] = value);
            check_stiffness("C", &matrix).map_err(|error| error.to_string())
        };
        // 3 · 4 − k² > 0
        assert_eq!(with(&[(4, 5, 3.46), (5, 4, 3.46)]), Ok(()));
        let refused = with(&[(4, 5, 3.47), (5, 4, 3.47)]).unwrap_err();
        assert!(refused.starts_with("C: is not positive definite") && refused.contains("-1.7"), "{refused}");
        assert_eq!(with(&[(4, 5, 1.0)]).unwrap_err(), "C[4][5] = 1: must be finite and equal to its mirrored entry");
        assert!(with(&[(2, 2, -5.0)]).unwrap_err().starts_with("C[2][2] = -5"));
        assert!(with(&[(0, 3, f64::NAN), (3, 0, f64::NAN)]).unwrap_err().starts_with("C[0][3] = NaN"));
    }
}
