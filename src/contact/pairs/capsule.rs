//! Capsules around segments (the chord swept by the bulge) and the distance between straight segments, in any unit of
//! length.

use crate::contact::curves::curve::Cubic;
use crate::contact::measures::{SUM_ROUNDING, USUAL};
use crate::math::Vec3;

/// Squared distance \[L²\] between the segments p0 p1 and q0 q1.
///
/// Smallest of the distances of the four ends from the other segment and, if the lines' common perpendicular meets
/// both, its length. All tests are relative to the pair's own size, so units and offsets do not matter: correct to a
/// few ulp of (size)² from 1e-150 to 1e150 \[L\], for parallel and nearly parallel segments and for segments shrunk to
/// points. Beyond, the *square* under- or overflows; [`segment_distance`] does not. NaN input gives NaN or the distance
/// of the finite part.
#[must_use]
pub fn segment_distance_sq(p0: &Vec3, p1: &Vec3, q0: &Vec3, q1: &Vec3) -> f64 {
    let Scaled { scale, unit_sq, .. } = scaled_distance_sq(&(p1 - p0), &(q1 - q0), &(p0 - q0));
    // Grouped so that neither factor alone over- or underflows early.
    (scale * unit_sq) * scale
}

/// Distance \[L\] between the segments p0 p1 and q0 q1; as [`segment_distance_sq`] over the whole range of f64.
#[must_use]
pub fn segment_distance(p0: &Vec3, p1: &Vec3, q0: &Vec3, q1: &Vec3) -> f64 {
    let Scaled { scale, unit_sq, .. } = scaled_distance_sq(&(p1 - p0), &(q1 - q0), &(p0 - q0));
    scale * unit_sq.sqrt()
}

/// A squared distance in units of a scale \[L\], and the size of the pair \[L\].
struct Scaled {
    size: f64,
    scale: f64,
    unit_sq: f64,
}

/// Squared distance of the segments r + [0,1] d and [0,1] e.
fn scaled_distance_sq(d: &Vec3, e: &Vec3, r: &Vec3) -> Scaled {
    let size =
        [d, e, r].into_iter().flat_map(|v| v.iter()).fold(0.0, |size, x| if x.abs() > size { x.abs() } else { size });
    if size == 0.0 {
        return Scaled { size, scale: 0.0, unit_sq: 0.0 };
    }
    // Division, not a reciprocal: 1/scale overflows for subnormal sizes.
    let (scale, d, e, r) = if USUAL.contains(&size) { (1.0, *d, *e, *r) } else { (size, d / size, e / size, r / size) };
    let (dd, ee, de) = (d.norm_squared(), e.norm_squared(), d.dot(&e));
    let (dr, er) = (d.dot(&r), e.dot(&r));
    // Parameter of the nearest point, clamped; a segment that is a point uses its start.
    let clamp = |num: f64, den: f64| if den > 0.0 { (num / den).clamp(0.0, 1.0) } else { 0.0 };
    let at = |s: f64, t: f64| (r + d * s - e * t).norm_squared();
    let mut best = at(0.0, clamp(er, ee));
    best = best.min(at(1.0, clamp(er + de, ee)));
    best = best.min(at(clamp(-dr, dd), 0.0));
    best = best.min(at(clamp(de - dr, dd), 1.0));
    // Common perpendicular, with the sine of the angle from the cross product (no cancellation when nearly parallel).
    let n = d.cross(&e);
    let nn = n.norm_squared();
    if nn > 0.0 {
        let s = e.cross(&r).dot(&n) / nn;
        if (0.0..=1.0).contains(&s) {
            let t = clamp(er + s * de, ee);
            best = best.min(at(s, t));
            // A second projection removes the rounding of s where lines are nearly parallel.
            let s = clamp(t * de - dr, dd);
            best = best.min(at(s, clamp(er + s * de, ee)));
        }
    }
    Scaled { size, scale, unit_sq: best }
}

/// A segment's chord swept by its bulge: contains the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Start of the chord \[L\].
    pub start: Vec3,
    /// End of the chord \[L\].
    pub end: Vec3,
    /// Radius around the chord \[L\], at least the largest distance of the curve from it.
    pub bulge: f64,
}

impl Capsule {
    /// The capsule of a cubic.
    #[must_use]
    pub fn new(curve: &Cubic) -> Self {
        Self { start: curve.b[0], end: curve.b[3], bulge: curve.bulge() }
    }

    /// Lower bound \[L\] of the distance between the curves inside two capsules: chord distance − both bulges, at
    /// least 0. Rounded down by 64 ulp of the pair's size, so it never exceeds the true distance of the curves given
    /// by the control points.
    #[must_use]
    pub fn distance_lower_bound(&self, other: &Self) -> f64 {
        let (d, e, r) = (self.end - self.start, other.end - other.start, self.start - other.start);
        let Scaled { size, scale, unit_sq } = scaled_distance_sq(&d, &e, &r);
        (scale * unit_sq.sqrt() - self.bulge - other.bulge - SUM_ROUNDING * size).max(0.0)
    }
}

/// Lower bound \[L\] of the distance between two cubics; see [`Capsule::distance_lower_bound`].
#[must_use]
pub fn distance_lower_bound(a: &Cubic, b: &Cubic) -> f64 {
    Capsule::new(a).distance_lower_bound(&Capsule::new(b))
}

/// Lower bound \[L\] of the distance between two cubics, at most `tol` \[L\] below it: the cubics are halved until
/// their bulges (which fall by four each time) are together below `tol`, and only where a nearer pair of parts is not
/// known yet.
///
/// For curves whose bulge between two nodes exceeds the gap.
#[must_use]
pub fn distance_lower_bound_within(a: &Cubic, b: &Cubic, tol: f64) -> f64 {
    nearest_parts(a, b, tol, MAX_HALVINGS, f64::INFINITY)
}

/// Halvings of a pair of cubics in all, because their bulges have then fallen to 1e-7, and the work could double with
/// each.
const MAX_HALVINGS: usize = 24;

fn nearest_parts(a: &Cubic, b: &Cubic, tol: f64, halvings: usize, known: f64) -> f64 {
    let (capsule_a, capsule_b) = (Capsule::new(a), Capsule::new(b));
    let bound = capsule_a.distance_lower_bound(&capsule_b);
    if halvings == 0 || bound >= known || capsule_a.bulge + capsule_b.bulge <= tol {
        return bound.min(known);
    }
    let longer_a = capsule_a.bulge >= capsule_b.bulge;
    let (first, second) = if longer_a { a.split() } else { b.split() };
    let of = |part: &Cubic, known: f64| {
        let (x, y) = if longer_a { (part, b) } else { (a, part) };
        nearest_parts(x, y, tol, halvings - 1, known)
    };
    let known = of(&first, known);
    of(&second, known)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two arcs that bulge towards each other by twenty times their distance: the bound with halving is below the
    /// distance by no more than `tol`.
    #[test]
    fn halved_capsules_come_as_near_as_asked_for() {
        let arc = |top: f64, sign: f64, x: f64| Cubic {
            b: [
                Vec3::new(x - 1.0, top - sign, 0.0),
                Vec3::new(x - 0.3, top + sign / 3.0, 0.0),
                Vec3::new(x + 0.3, top + sign / 3.0, 0.0),
                Vec3::new(x + 1.0, top - sign, 0.0),
            ],
        };
        for x in [0.0, 0.1, 0.7] {
            let (a, b) = (arc(0.0, 1.0, 0.0), arc(0.05, -1.0, x));
            let sampled = (0..=400).flat_map(|i| (0..=400).map(move |j| (f64::from(i) / 400.0, f64::from(j) / 400.0)));
            let nearest = sampled.map(|(u, v)| (a.point(u) - b.point(v)).norm()).fold(f64::INFINITY, f64::min);
            // the bound without halving contains the bulges, not their positions
            assert!(x < 0.5 || distance_lower_bound(&a, &b) < nearest - 0.1);
            for tol in [1e-2, 1e-3, 1e-4] {
                let bound = distance_lower_bound_within(&a, &b, tol);
                assert!(bound <= nearest && bound >= nearest - tol - 2e-5, "{bound} {nearest} {tol}");
            }
        }
    }

    fn distance(p: [[f64; 3]; 4], unit: f64) -> f64 {
        let [a, b, c, d] = p.map(|x| Vec3::from(x) * unit);
        segment_distance_sq(&a, &b, &c, &d).sqrt() / unit
    }

    #[test]
    fn closed_forms_in_any_unit() {
        let cases = [
            ([[0., 0., 0.], [1., 0., 0.], [0.5, -1., 0.3], [0.5, 1., 0.3]], 0.3),
            ([[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]], 1.0),
            ([[0., 0., 0.], [1., 0., 0.], [3., 0., 0.], [2., 0., 0.]], 1.0),
            ([[0., 0., 0.], [0., 0., 0.], [1., -1., 0.], [1., 5., 0.]], 1.0),
            ([[0., 0., 0.], [0., 0., 0.], [3., 4., 0.], [3., 4., 0.]], 5.0),
            ([[0., 0., 0.], [1., 0., 0.], [0.5, 0., 0.], [0.5, 1., 0.]], 0.0),
        ];
        for (p, exact) in cases {
            for unit in [1.0, 1e-12, 1e12, 1e-150, 1e150] {
                let found = distance(p, unit);
                assert!((found - exact).abs() < 1e-15, "{p:?} {unit:e}: {found}");
            }
        }
    }

    #[test]
    fn nearly_parallel_crossings() {
        // Two segments of length 2 crossing at their middles at height 0.1, angle θ: the ends are at most θ apart
        // sideways.
        for k in 1..18 {
            let t = 10f64.powi(-k);
            let p = [[-1., 0., 0.], [1., 0., 0.], [-1., -t, 0.1], [1., t, 0.1]];
            assert!((distance(p, 1.0) - 0.1).abs() < 1e-16 * 8.0, "{k}");
            let touching = [[-1., 0., 0.], [1., 0., 0.], [-1., -t, 0.], [1., t, 0.]];
            assert!(distance(touching, 1.0) < 1e-15, "{k} {}", distance(touching, 1.0));
        }
    }

    #[test]
    fn the_range_of_f64() {
        let z = Vec3::zeros();
        for unit in [1e-300, 1e300, 1e-310] {
            let d = segment_distance(&z, &(Vec3::x() * unit), &(Vec3::y() * unit), &(Vec3::new(1., 1., 0.) * unit));
            assert!((d / unit - 1.0).abs() < 1e-12);
        }
    }
}
