//! Knot types of closed polygons, identified by two values of the Alexander polynomial (Alexander 1928).
//!
//! The crossings of a projection cut the polygon into as many arcs, each from an underpass to the next. At a crossing
//! arc `o` passes over arcs `i` (incoming) and `j` (outgoing): its row is (1 − t) o − i + t j, with i and j exchanged
//! for a left-handed crossing. Any minor of the matrix with one row and one column less is Δ(t) up to a factor ±tᵏ,
//! whose modulus is 1 on the unit circle.

use nalgebra::{Complex, DMatrix};

use super::crossings::{self, Crossing};
use super::{all_finite, extent, normalised, without_repeats};
use crate::math::Vec3;

/// Most crossings of a projection that is evaluated. Time grows with their cube: a tenth of a second here.
const MOST_CROSSINGS: usize = 400;
/// Largest distance of a value from the whole number that it counts as.
const TOL_WHOLE: f64 = 1e-3;

/// Moduli of the Alexander polynomial Δ of a knot at two points of the unit circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alexander {
    /// |Δ(−1)|: the knot's determinant.
    pub determinant: f64,
    /// |Δ(exp(2πi/3))|.
    pub at_third: f64,
}

/// Knots of up to six crossings, and two trefoils: name, |Δ(−1)|, |Δ(exp(2πi/3))|.
const KNOTS: [(&str, f64, f64); 10] = [
    ("0_1", 1.0, 1.0),
    ("3_1", 3.0, 2.0),
    ("4_1", 5.0, 4.0),
    ("5_1", 5.0, 1.0),
    ("5_2", 7.0, 5.0),
    ("6_1", 9.0, 7.0),
    ("6_2", 11.0, 5.0),
    ("6_3", 13.0, 7.0),
    ("7_1", 7.0, 1.0),
    ("3_1#3_1", 9.0, 4.0),
];

impl Alexander {
    /// Name of the simplest knot with these values (0_1: no knot), "other" beyond those of six crossings, 7_1 and two
    /// trefoils. Mirror images have one name.
    pub fn name(&self) -> &'static str {
        let near = |a: f64, b: f64| (a - b).abs() < TOL_WHOLE;
        let fits = |knot: &&(&str, f64, f64)| near(knot.1, self.determinant) && near(knot.2, self.at_third);
        KNOTS.iter().find(fits).map_or("other", |knot| knot.0)
    }
}

/// Values of the Alexander polynomial of a closed polygon; `None` for coordinates that are not finite, for one that no
/// viewing direction shows clearly, and for pictures of more than 400 crossings. Time grows with the edges and with the cube of the crossings.
///
/// ```
/// use supercoil::math::{Vec3, link::alexander};
/// let trefoil = |t: f64| Vec3::new((2.0 + (3.0 * t).cos()) * (2.0 * t).cos(), (2.0 + (3.0 * t).cos()) * (2.0 * t).sin(), (3.0 * t).sin());
/// let points: Vec<Vec3> = (0..100).map(|k| trefoil(std::f64::consts::TAU * k as f64 / 100.0)).collect();
/// assert_eq!(alexander(&points).unwrap().name(), "3_1");
/// ```
#[must_use]
pub fn alexander(points: &[Vec3]) -> Option<Alexander> {
    if !all_finite(points) {
        return None;
    }
    let points = without_repeats(points, true);
    if points.len() < 4 {
        return Some(Alexander { determinant: 1.0, at_third: 1.0 });
    }
    let points = normalised(&points, points[0], extent(&points));
    let crossings = crossings::list(&points).filter(|found| found.len() <= MOST_CROSSINGS)?;
    let third = std::f64::consts::TAU / 3.0;
    Some(Alexander {
        determinant: size(&crossings, Complex::new(-1.0, 0.0)),
        at_third: size(&crossings, Complex::new(third.cos(), third.sin())),
    })
}

/// |Δ(t)| for t of length 1.
fn size(crossings: &[Crossing], t: Complex<f64>) -> f64 {
    if crossings.len() < 3 {
        return 1.0;
    }
    let mut ends: Vec<f64> = crossings.iter().map(|crossing| crossing.under).collect();
    ends.sort_by(f64::total_cmp);
    let count = ends.len();
    // arc k ends at underpass k
    let arc = |place: f64| ends.partition_point(|end| *end < place) % count;
    let one = Complex::new(1.0, 0.0);
    let mut rows = DMatrix::from_element(count, count, Complex::new(0.0, 0.0));
    for (row, crossing) in crossings.iter().enumerate() {
        let into = arc(crossing.under);
        let out = (into + 1) % count;
        let (into, out) = if crossing.sign > 0 { (into, out) } else { (out, into) };
        rows[(row, arc(crossing.over))] += one - t;
        rows[(row, into)] -= one;
        rows[(row, out)] += t;
    }
    rows.remove_row(count - 1).remove_column(count - 1).determinant().norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn torus_knot(p: f64, q: f64) -> Vec<Vec3> {
        let point = |t: f64| {
            let wide = 2.0 + (q * t).cos();
            Vec3::new(wide * (p * t).cos(), wide * (p * t).sin(), (q * t).sin())
        };
        (0..300).map(|k| point(TAU * f64::from(k) / 300.0)).collect()
    }

    /// Windings that close to knots of known names, mirrored ones too; an unknotted coil with many crossings.
    #[test]
    fn knots_have_their_names() {
        for (p, q, name) in
            [(2.0, 3.0, "3_1"), (3.0, 2.0, "3_1"), (2.0, -3.0, "3_1"), (2.0, 5.0, "5_1"), (2.0, 7.0, "7_1")]
        {
            assert_eq!(alexander(&torus_knot(p, q)).unwrap().name(), name, "{p} {q}");
        }
        assert_eq!(alexander(&torus_knot(1.0, 17.0)).unwrap().name(), "0_1");
        let eight = |t: f64| {
            let wide = 2.0 + (2.0 * t).cos();
            Vec3::new(wide * (3.0 * t).cos(), wide * (3.0 * t).sin(), (4.0 * t).sin())
        };
        let points: Vec<Vec3> = (0..300).map(|k| eight(TAU * f64::from(k) / 300.0)).collect();
        let found = alexander(&points).unwrap();
        assert_eq!((found.name(), found.determinant.round()), ("4_1", 5.0));
        assert!(alexander(&[Vec3::new(f64::NAN, 0.0, 0.0); 5]).is_none());
    }
}
