//! Knot types of closed polygons, identified by two values of the Alexander polynomial (Alexander 1928) and by the
//! Jones polynomial ([`jones`]).
//!
//! The crossings of a projection cut the polygon into as many arcs, each from an underpass to the next. At a crossing
//! arc `o` passes over arcs `i` (incoming) and `j` (outgoing): its row is (1 − t) o − i + t j, with i and j exchanged
//! for a left-handed crossing. Any minor of the matrix with one row and one column less is Δ(t) up to a factor ±tᵏ,
//! whose modulus is 1 on the unit circle.

pub(crate) mod closed_braid;
mod diagram;
mod jones;
mod names;
#[cfg(any(test, feature = "scenes"))]
pub(crate) mod pd_code;
pub(crate) mod table;

use nalgebra::{Complex, DMatrix};

use super::crossings::{self, Crossing};
use super::{all_finite, extent, normalised, without_repeats};
use crate::math::Vec3;
use diagram::{nodes, reduced};
use jones::{Jones, jones};

/// Most crossings of a projection that is evaluated. Time grows with their cube: a tenth of a second here.
const MOST_CROSSINGS: usize = 400;
/// Moduli of the Alexander polynomial Δ of a knot at two points of the unit circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alexander {
    /// |Δ(−1)|: the knot's determinant.
    pub determinant: f64,
    /// |Δ(exp(2πi/3))|.
    pub at_third: f64,
}

impl Alexander {
    /// Those of no knot.
    const UNKNOT: Self = Self { determinant: 1.0, at_third: 1.0 };
}

/// Which knot a closed polygon is.
#[derive(Debug, Clone, PartialEq)]
pub struct KnotType {
    /// Name of the simplest knot with the same Alexander and Jones polynomials: Rolfsen's, with up to eight crossings,
    /// "3_1#4_1" for composite knots, "0_1" for none, "other" beyond. A star marks the mirror image of the knot that
    /// `shape = { kind = "knot", name = … }` makes.
    pub name: String,
    /// Values of its Alexander polynomial.
    pub alexander: Alexander,
}

/// What is computed of a knot.
struct Invariants {
    alexander: Alexander,
    /// `None` of a projection too wide for it.
    jones: Option<Jones>,
}

/// The knot of a closed polygon; `None` as for [`alexander`].
///
/// The name is by the Alexander polynomial alone where no projection is narrow enough for the Jones polynomial: tangles
/// of hundreds of crossings. Mirror images then have one name, without a star.
///
/// ```
/// use supercoil::math::{Vec3, link::knot_type};
/// let radius = |t: f64| 2.0 + (3.0 * t).cos();
/// let trefoil = |t: f64| Vec3::new(radius(t) * (2.0 * t).cos(), radius(t) * (2.0 * t).sin(), (3.0 * t).sin());
/// let points: Vec<Vec3> = (0..100).map(|k| trefoil(std::f64::consts::TAU * k as f64 / 100.0)).collect();
/// let mirrored: Vec<Vec3> = points.iter().map(|p| Vec3::new(p.x, p.y, -p.z)).collect();
/// assert_eq!([&points, &mirrored].map(|points| knot_type(points).unwrap().name), ["3_1*", "3_1"]);
/// ```
#[must_use]
pub fn knot_type(points: &[Vec3]) -> Option<KnotType> {
    let found = invariants(points)?;
    Some(KnotType { name: names::name(&found), alexander: found.alexander })
}

fn invariants(points: &[Vec3]) -> Option<Invariants> {
    let crossings = projected(points)?;
    Some(Invariants { alexander: alexander_of(&crossings), jones: jones(&nodes(&crossings)) })
}

/// Values of the Alexander polynomial of a closed polygon; `None` for coordinates that are not finite, for one that no
/// viewing direction shows clearly, and for pictures of more than 400 crossings. Time grows with the edges and with the
/// cube of the crossings.
///
/// ```
/// use supercoil::math::{Vec3, link::alexander};
/// let radius = |t: f64| 2.0 + (3.0 * t).cos();
/// let trefoil = |t: f64| Vec3::new(radius(t) * (2.0 * t).cos(), radius(t) * (2.0 * t).sin(), (3.0 * t).sin());
/// let points: Vec<Vec3> = (0..100).map(|k| trefoil(std::f64::consts::TAU * k as f64 / 100.0)).collect();
/// assert!((alexander(&points).unwrap().determinant - 3.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn alexander(points: &[Vec3]) -> Option<Alexander> {
    projected(points).map(|crossings| alexander_of(&crossings))
}

/// Crossings of the clearest projection, without those that can be undone at once.
fn projected(points: &[Vec3]) -> Option<Vec<Crossing>> {
    if !all_finite(points) {
        return None;
    }
    let points = without_repeats(points, true);
    if points.len() < 4 {
        return Some(Vec::new());
    }
    let points = normalised(&points, points[0], extent(&points));
    crossings::list(&points).map(reduced).filter(|left| left.len() <= MOST_CROSSINGS)
}

fn alexander_of(crossings: &[Crossing]) -> Alexander {
    let third = std::f64::consts::TAU / 3.0;
    Alexander {
        determinant: size(crossings, Complex::new(-1.0, 0.0)),
        at_third: size(crossings, Complex::new(third.cos(), third.sin())),
    }
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
    use crate::math::random::Random;
    use std::f64::consts::TAU;

    fn torus_knot(p: f64, q: f64) -> Vec<Vec3> {
        let point = |t: f64| {
            let wide = 2.0 + (q * t).cos();
            Vec3::new(wide * (p * t).cos(), wide * (p * t).sin(), (q * t).sin())
        };
        (0..300).map(|k| point(TAU * f64::from(k) / 300.0)).collect()
    }

    /// Windings that close to knots of known names and hands; an unknotted coil with many crossings.
    #[test]
    fn knots_have_their_names() {
        let named = |points: &[Vec3]| knot_type(points).unwrap().name;
        for (p, q, name) in [
            (2.0, 3.0, "3_1*"),
            (3.0, 2.0, "3_1*"),
            (2.0, -3.0, "3_1"),
            (2.0, 5.0, "5_1*"),
            (2.0, -7.0, "7_1"),
            (3.0, -4.0, "8_19"),
        ] {
            assert_eq!(named(&torus_knot(p, q)), name, "{p} {q}");
        }
        assert_eq!(named(&torus_knot(1.0, 17.0)), "0_1");
        assert_eq!(named(&torus_knot(3.0, 5.0)), "other");
        let eight = |t: f64| {
            let wide = 2.0 + (2.0 * t).cos();
            Vec3::new(wide * (3.0 * t).cos(), wide * (3.0 * t).sin(), (4.0 * t).sin())
        };
        let points: Vec<Vec3> = (0..300).map(|k| eight(TAU * f64::from(k) / 300.0)).collect();
        assert_eq!(named(&points), "4_1");
        assert!(knot_type(&[Vec3::new(f64::NAN, 0.0, 0.0); 5]).is_none());
    }

    /// Braids of the table, their mirror images, and sums of knots as one braid: 3_1 # 4_1 has the Alexander polynomial
    /// of 8_21, the square knot that of 8_20.
    #[test]
    fn braids_have_the_names_of_their_knots() {
        let named = |word: &[i32]| knot_type(&closed_braid::closed_braid(word, None).unwrap()).unwrap().name;
        for (name, word) in table::KNOTS {
            assert_eq!(named(word), name);
            let mirrored: Vec<i32> = word.iter().map(|letter| -letter).collect();
            let mirror = named(&mirrored);
            assert!(mirror == name || mirror == format!("{name}*"), "{name}: {mirror}");
        }
        let sums: [(&[i32], &str); 5] = [
            (&[1, 1, 1, 2, 2, 2], "3_1#3_1"),
            (&[1, 1, 1, -2, -2, -2], "3_1#3_1*"),
            (&[-1, -1, -1, -2, -2, -2], "3_1*#3_1*"),
            (&[1, 1, 1, 2, -3, 2, -3], "3_1#4_1"),
            (&[1, -2, 1, -2, 3, -4, 3, -4], "4_1#4_1"),
        ];
        for (word, name) in sums {
            assert_eq!(named(word), name, "{word:?}");
        }
    }

    /// Moves that change nothing but the picture, by turning a knot: the same name from many sides, and after
    /// crumpling.
    #[test]
    fn names_do_not_depend_on_the_view() {
        let mut random = Random(5);
        for (name, word) in [("8_20", table::named("8_20").unwrap()), ("7_7", table::named("7_7").unwrap())] {
            let points = closed_braid::closed_braid(&word, None).unwrap();
            for view in 0..12 {
                let axis = Vec3::new(random.unit(), random.unit(), random.unit());
                let turn = nalgebra::Rotation3::new(axis * 3.0);
                let crumple = if view % 2 == 0 { 0.0 } else { 0.15 };
                let seen: Vec<Vec3> = points
                    .iter()
                    .map(|p| turn * (p + Vec3::new(random.unit(), random.unit(), random.unit()) * crumple))
                    .collect();
                assert_eq!(knot_type(&seen).unwrap().name, name, "{view}");
            }
        }
    }
}
