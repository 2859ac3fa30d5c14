//! Topology of rods: link, twist and writhe, all in turns.
//!
//! A framed closed polygon has `Lk = Tw + Wr`, Lk an integer (plus the fraction of a turn put into the seam). Link
//! cannot change while no strand passes through another, so it is the invariant to check a computation by.
//!
//! * [`writhe`] and [`linking_number`] are exact for polygons: signed solid angles of edge pairs (Banchoff 1976; Klenin
//!   & Langowski 2000, method 1a), or, for long closed polygons, signed crossings in a projection plus the twist of the
//!   projection's own ribbon (the same number to rounding, in a time proportional to the edges and crossings).
//! * [`link_of_ends`] is the link of an open rod between parallel ends, by the same crossings.
//! * [`ribbon_twist`] is the twist of a material direction about the same polygon.
//! * [`knot_type`] names knots, by their Alexander and Jones polynomials.
//! * [`writhe_smooth`] is the writhe of a smooth curve to near rounding from a few hundred samples.

mod crossings;
pub(crate) mod knot;
mod smooth;

use crate::math::direction::{any_normal, transport};
use crate::math::{Vec3, parallel};
use std::f64::consts::TAU;

pub use knot::{Alexander, KnotType, alexander, knot_type};
pub use smooth::writhe_smooth;

/// Link, twist and writhe of a closed rod, in turns; `link = twist + writhe`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkNumbers {
    /// Linking number of the centreline with the material line d1, modulo 1 equal to the turns of the seam.
    pub link: f64,
    /// Twist of d1 about the centreline.
    pub twist: f64,
    /// Writhe of the centreline.
    pub writhe: f64,
}

/// From this many edges on a closed polygon's crossings are counted instead of summing over all edge pairs.
const MIN_EDGES_FOR_CROSSINGS: usize = 400;
/// Edges of one polygon per parallel task; each is compared with all others.
const ROWS: usize = 8;

/// Link, twist and writhe of a closed rod (turns).
///
/// `points` [any length unit] are the N distinct nodes, `d1` the material direction at each (need not be unit or
/// exactly normal). The frame at s = L is the frame at s = 0 turned by `seam_turns` about d3; `link` equals
/// `seam_turns` modulo 1 up to rounding (about 1e-13). See [`ribbon_twist`] for how far neighbouring frames may differ.
///
/// ```
/// use std::f64::consts::TAU;
/// use supercoil::math::{Vec3, link::link_numbers};
/// let angle = |k: usize| TAU * k as f64 / 60.0;
/// let circle: Vec<Vec3> = (0..60).map(|k| Vec3::new(angle(k).cos(), angle(k).sin(), 0.0)).collect();
/// // d1 turns twice about the circle from its normal z
/// let d1 = |k: usize| circle[k] * (2.0 * angle(k)).sin() + Vec3::z() * (2.0 * angle(k)).cos();
/// let d1: Vec<Vec3> = (0..60).map(d1).collect();
/// let numbers = link_numbers(&circle, &d1, 0.0);
/// assert!((numbers.link.abs() - 2.0).abs() < 1e-12 && numbers.writhe.abs() < 1e-12);
/// ```
///
/// # Panics
/// If `d1` and `points` differ in length.
pub fn link_numbers(points: &[Vec3], d1: &[Vec3], seam_turns: f64) -> LinkNumbers {
    let twist = twist_with_seam(points, d1, true, seam_turns);
    let writhe = writhe(points, true);
    LinkNumbers { link: twist + writhe, twist, writhe }
}

/// Writhe of a polygon (turns): `Wr = (1/4π) ∮∮ (t₁ × t₂)·(r₁ − r₂)/|r₁ − r₂|³ ds₁ ds₂`, exact for straight edges.
///
/// `closed` joins the last point to the first. Coplanar, adjacent and zero-length edge pairs add exactly nothing;
/// polygons of fewer than four points have no writhe, those with a NaN or infinite point a NaN. Independent of scale
/// and offset; the same bits for any number of threads. Error about 1e-13; cost N²/2 edge pairs (about 20 ns each) for
/// open polygons and for closed ones of fewer than 400 edges, about 1 µs an edge plus the crossings of one projection
/// for longer closed ones. Where the polygon cuts itself, writhe jumps by 2 and the mean of both sides is returned.
///
/// ```
/// use supercoil::math::{Vec3, link::writhe};
/// let radius = |t: f64| 2.0 + (3.0 * t).cos();
/// let trefoil = |t: f64| Vec3::new(radius(t) * (2.0 * t).cos(), radius(t) * (2.0 * t).sin(), (3.0 * t).sin());
/// let knot: Vec<Vec3> = (0..90).map(|k| trefoil(std::f64::consts::TAU * k as f64 / 90.0)).collect();
/// let mirrored: Vec<Vec3> = knot.iter().map(|p| Vec3::new(p.x, p.y, -p.z)).collect();
/// assert!((writhe(&knot, true) + writhe(&mirrored, true)).abs() < 1e-12);
/// assert!(writhe(&knot, true).abs() > 3.0); // turns
/// ```
pub fn writhe(points: &[Vec3], closed: bool) -> f64 {
    if !all_finite(points) {
        return f64::NAN;
    }
    let points = without_repeats(points, closed);
    if points.len() < 4 {
        return 0.0;
    }
    let points = normalised(&points, points[0], extent(&points));
    if closed
        && points.len() >= MIN_EDGES_FOR_CROSSINGS
        && let Some(exact) = crossings::writhe(&points)
    {
        return exact;
    }
    writhe_by_pairs(&points, closed)
}

/// Link of an open rod (turns): the rotation of its end relative to its start about `direction`, as long as no strand
/// passes through another or over an end.
///
/// It is Tw + Wr of the polygon `points` [any length unit] with the material direction `d1` at each, extended to
/// infinity by straight lines along `direction` (need not be unit), which the rod's ends should be parallel to.
/// Whatever the shape in between, the link differs from the angle of the last d1 to the first one about `direction` by
/// an integer, to rounding. Cost as of [`writhe`] for long closed polygons, for any number of points. NaN if a number
/// is not finite, or `direction` is zero.
///
/// ```
/// use std::f64::consts::TAU;
/// use supercoil::math::{Vec3, link::link_of_ends};
/// let line: Vec<Vec3> = (0..11).map(|k| Vec3::z() * k as f64).collect();
/// let d1: Vec<Vec3> = (0..11).map(|k| 0.125 * TAU * k as f64).map(|a| Vec3::new(a.cos(), a.sin(), 0.0)).collect();
/// assert!((link_of_ends(&line, &d1, Vec3::z()) - 1.25).abs() < 1e-12); // ten eighths of a turn
/// ```
///
/// # Panics
/// If `d1` and `points` differ in length.
pub fn link_of_ends(points: &[Vec3], d1: &[Vec3], direction: Vec3) -> f64 {
    assert_eq!(points.len(), d1.len(), "one material direction per point");
    let Some(direction) = direction.try_normalize(0.0).filter(|_| all_finite(points) && all_finite(d1)) else {
        return f64::NAN;
    };
    let Some(&first) = points.first() else { return 0.0 };
    let size = extent(points);
    let line = extended(points, direction * FAR * size);
    let twist = ribbon_twist(&line, &extended(d1, Vec3::zeros()), false);
    let inner = normalised(&without_repeats(points, false), first, size);
    twist + crossings::writhe_extended(&inner, direction).unwrap_or_else(|| writhe(&line, false))
}

/// One point more at either end, `by` before the first and behind the last.
fn extended(points: &[Vec3], by: Vec3) -> Vec<Vec3> {
    let (first, last) = (points[0], points[points.len() - 1]);
    [&[first - by], points, &[last + by]].concat()
}

/// Length of straight lines for infinite ones in sums over pairs of edges, over the rod's extent, because the rest adds
/// less than 1e-6 turns.
const FAR: f64 = 1e4;

/// Gauss sum over all pairs of edges.
fn writhe_by_pairs(points: &[Vec3], closed: bool) -> f64 {
    let n = points.len();
    let edges = if closed { n } else { n - 1 };
    let rows = parallel::map(edges, ROWS, &|i| {
        let end = if closed && i == 0 { edges - 1 } else { edges };
        compensated_sum(
            (i + 2..end).map(|j| solid_angle([points[i], points[(i + 1) % n]], [points[j], points[(j + 1) % n]])),
        )
    });
    compensated_sum(rows.into_iter()) / TAU
}

/// Linking number of two closed polygons (turns): `(1/4π) ∮∮ (t_a × t_b)·(r_a − r_b)/|r_a − r_b|³ ds_a ds_b`.
///
/// An integer up to about 1e-13 if the polygons are disjoint; a crossing of right-handed sense counts +½. Zero if
/// either has fewer than three points, NaN if a coordinate is not finite. Symmetric in `a` and `b`; changes sign when
/// one of them is traversed backwards.
///
/// ```
/// use std::f64::consts::TAU;
/// use supercoil::math::{Vec3, link::linking_number};
/// let around = |k: usize| (TAU * k as f64 / 20.0).sin_cos();
/// let a: Vec<Vec3> = (0..20).map(around).map(|(sin, cos)| Vec3::new(cos, sin, 0.0)).collect();
/// let b: Vec<Vec3> = (0..20).map(around).map(|(sin, cos)| Vec3::new(1.0 + cos, 0.0, sin)).collect();
/// assert!((linking_number(&a, &b).abs() - 1.0).abs() < 1e-12); // a Hopf link
/// ```
pub fn linking_number(a: &[Vec3], b: &[Vec3]) -> f64 {
    if !all_finite(a) || !all_finite(b) {
        return f64::NAN;
    }
    let (a, b) = (without_repeats(a, true), without_repeats(b, true));
    if a.len() < 3 || b.len() < 3 {
        return 0.0;
    }
    let (origin, size) = (a[0], extent(&a).max(extent(&b)));
    let (a, b) = (normalised(&a, origin, size), normalised(&b, origin, size));
    if a.len().max(b.len()) >= MIN_EDGES_FOR_CROSSINGS
        && let Some(exact) = crossings::link(&a, &b)
    {
        return exact;
    }
    let rows = parallel::map(a.len(), ROWS, &|i| {
        let edge = [a[i], a[(i + 1) % a.len()]];
        compensated_sum((0..b.len()).map(|j| solid_angle(edge, [b[j], b[(j + 1) % b.len()]])))
    });
    compensated_sum(rows.into_iter()) / (2.0 * TAU)
}

/// Signed solid angle (rad) of the parallelogram of chords from edge `b` to edge `a`, in (−2π, 2π).
///
/// Two triangles of the parallelogram share one triple product, so with van Oosterom & Strackee (1983)
/// `tan(Ω/2) = det / (|x||y||z| + (x·y)|z| + (x·z)|y| + (y·z)|x|)` each; no asin, hence no loss at right angles.
fn solid_angle(a: [Vec3; 2], b: [Vec3; 2]) -> f64 {
    let corners = [a[0] - b[0], a[0] - b[1], a[1] - b[1], a[1] - b[0]];
    let norms = corners.map(|c| c.norm());
    let shortest = (1..4).fold(0, |best, k| if norms[k] < norms[best] { k } else { best });
    let (u, v) = (a[1] - a[0], b[1] - b[0]);
    let normal = u.cross(&v);
    let det = normal.dot(&corners[shortest]);
    // Coplanar to rounding: the solid angle is 0, also at an intersection, as the mean of both signs.
    if norms[shortest] == 0.0 || det.abs() <= 4.0 * f64::EPSILON * u.norm() * v.norm() * norms[shortest] {
        return 0.0;
    }
    let triangle = |i: usize, j: usize, k: usize| {
        let (x, y, z) = (corners[i], corners[j], corners[k]);
        let denominator =
            norms[i] * norms[j] * norms[k] + x.dot(&y) * norms[k] + x.dot(&z) * norms[j] + y.dot(&z) * norms[i];
        2.0 * det.atan2(denominator)
    };
    triangle(0, 1, 2) + triangle(0, 2, 3)
}

/// Total twist (turns) of the material direction `d1` about a polygon.
///
/// Along edge i the twist is the angle about the edge from the projection of d1_i to that of d1_{i+1}; at a vertex it
/// is the angle from d1 projected on the incoming edge, parallel-transported to the outgoing one, to d1 projected on
/// the outgoing edge. Every angle is taken in (−π, π], so neighbouring frames must differ by less than half a turn. For
/// a closed ribbon `Tw + Wr` is an integer to rounding, without any discretisation error. A d1 parallel to an edge (as
/// no rod has) is replaced by the projection before it.
///
/// ```
/// use std::f64::consts::TAU;
/// use supercoil::math::{Vec3, link::ribbon_twist};
/// let line: Vec<Vec3> = (0..5).map(|k| Vec3::z() * k as f64).collect();
/// let d1: Vec<Vec3> = (0..5).map(|k| 0.1 * TAU * k as f64).map(|a| Vec3::new(a.cos(), a.sin(), 0.0)).collect();
/// assert!((ribbon_twist(&line, &d1, false) - 0.4).abs() < 1e-12); // right-handed, turns
/// ```
///
/// # Panics
/// If `d1` and `points` differ in length.
pub fn ribbon_twist(points: &[Vec3], d1: &[Vec3], closed: bool) -> f64 {
    twist_with_seam(points, d1, closed, 0.0)
}

/// [`ribbon_twist`] where the closing edge arrives at d1_0 turned by `seam_turns`.
fn twist_with_seam(points: &[Vec3], d1: &[Vec3], closed: bool, seam_turns: f64) -> f64 {
    assert_eq!(points.len(), d1.len(), "one material direction per point");
    let n = points.len();
    let num_edges = if closed { n } else { n.saturating_sub(1) };
    let edges: Vec<(usize, usize, Vec3)> = (0..num_edges)
        .map(|i| (i, (i + 1) % n, points[(i + 1) % n] - points[i]))
        .filter_map(|(i, j, e)| e.try_normalize(0.0).map(|e| (i, j, e)))
        .collect();
    let Some(&(first, _, first_edge)) = edges.first() else { return 0.0 };
    let start = across(d1[first], first_edge).unwrap_or_else(|| any_normal(first_edge));
    let (mut field, mut previous) = (start, first_edge);
    let mut angles = Vec::with_capacity(2 * n + 1);
    for &(i, j, edge) in &edges {
        field = transport(field, previous, edge);
        for (node, seam) in [(i, 0.0), (j, if closed && j == 0 { seam_turns } else { 0.0 })] {
            let next = across(d1[node], edge).unwrap_or(field);
            let turned = signed_angle(field, next, edge) + TAU * (seam - seam.round());
            angles.push(turned - TAU * (turned / TAU - 0.5).ceil());
            field = next;
        }
        previous = edge;
    }
    if closed {
        angles.push(signed_angle(transport(field, previous, first_edge), start, first_edge));
    }
    compensated_sum(angles.into_iter()) / TAU
}

/// Unit part of `v` normal to the unit vector `edge`; `None` if that part is rounding.
fn across(v: Vec3, edge: Vec3) -> Option<Vec3> {
    let size = v.norm();
    (v - edge * edge.dot(&v)).try_normalize(1e-12 * size)
}

/// Angle in (−π, π] from `u` to `v` about the unit vector `axis` (u, v normal to it).
fn signed_angle(u: Vec3, v: Vec3, axis: Vec3) -> f64 {
    axis.dot(&u.cross(&v)).atan2(u.dot(&v))
}

/// Neumaier's compensated sum, in the order given.
fn compensated_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (sum, carry) = terms.fold((0.0_f64, 0.0_f64), |(sum, carry), x| {
        let t = sum + x;
        let lost = if sum.abs() >= x.abs() { (sum - t) + x } else { (x - t) + sum };
        (t, carry + lost)
    });
    sum + carry
}

/// The points without consecutive duplicates, because an edge of no length has no direction.
fn without_repeats(points: &[Vec3], closed: bool) -> Vec<Vec3> {
    let mut kept: Vec<Vec3> = points.to_vec();
    kept.dedup();
    while closed && kept.len() > 1 && kept.first() == kept.last() {
        kept.pop();
    }
    kept
}

/// No NaN and no infinity.
fn all_finite(points: &[Vec3]) -> bool {
    points.iter().all(|p| p.iter().all(|x| x.is_finite()))
}

/// Largest distance from the first point, 0 for no points.
fn extent(points: &[Vec3]) -> f64 {
    points.iter().fold(0.0, |size: f64, p| size.max((p - points[0]).amax()))
}

/// Points relative to `origin`, times the power of two (exact) that brings `size` near 1.
fn normalised(points: &[Vec3], origin: Vec3, size: f64) -> Vec<Vec3> {
    let scale = if size > 0.0 && size.is_finite() { (-size.log2().round()).exp2() } else { 1.0 };
    points.iter().map(|p| (p - origin) * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;

    /// (2,3) torus knot with a material direction that turns `turns` times about a field fixed to the torus.
    fn knot(n: usize, turns: f64) -> (Vec<Vec3>, Vec<Vec3>) {
        let at = |t: f64| {
            let rho = 2.0 + (3.0 * t).cos();
            Vec3::new(rho * (2.0 * t).cos(), rho * (2.0 * t).sin(), (3.0 * t).sin())
        };
        let frame = |t: f64| {
            let tangent = (at(t + 1e-5) - at(t - 1e-5)).normalize();
            let out = Vec3::new((3.0 * t).cos() * (2.0 * t).cos(), (3.0 * t).cos() * (2.0 * t).sin(), (3.0 * t).sin());
            let u = (out - tangent * tangent.dot(&out)).normalize();
            u * (turns * t).cos() + tangent.cross(&u) * (turns * t).sin()
        };
        let parameters = (0..n).map(|i| TAU * i as f64 / n as f64);
        (parameters.clone().map(at).collect(), parameters.map(frame).collect())
    }

    #[test]
    fn both_ways_to_the_writhe_agree() {
        for n in [400, 1000] {
            let (points, _) = knot(n, 0.0);
            let (pairs, crossings) = (writhe_by_pairs(&points, true), crossings::writhe(&points).expect("generic"));
            assert!((pairs - crossings).abs() < 1e-12, "{n}: {pairs} {crossings}");
        }
    }

    #[test]
    fn planar_and_tiny_polygons_do_not_writhe() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.1));
        assert_eq!(writhe(&square, true), 0.0);
        assert_eq!(writhe(&square[..3], true), 0.0);
        assert_eq!(writhe(&[], true), 0.0);
        assert!(writhe(&[square[0], square[1], square[2], Vec3::repeat(f64::INFINITY)], true).is_nan());
        let eight = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.1));
        assert_eq!(writhe(&eight, true), 0.0, "a figure of eight that cuts itself: the mean of +1 and -1");
    }

    /// A helix about z whose ends bend into z, and which changes its sense on the way for odd `n`; d1 turns `turns`
    /// times about a parallel field.
    fn line(n: usize, turns: f64) -> (Vec<Vec3>, Vec<Vec3>) {
        let at = |t: f64| {
            let radius = (TAU * t / 2.0).sin().powi(2);
            let sense = if n.is_multiple_of(2) { 1.0 } else { (3.0 * TAU * t).cos().signum() };
            let angle = sense * 5.0 * TAU * t;
            Vec3::new(radius * angle.cos(), radius * angle.sin(), t + 1.5 * (2.0 * TAU * t).sin() * radius)
        };
        let points: Vec<Vec3> = (0..=n).map(|i| at(i as f64 / n as f64)).collect();
        let mut field = Vec3::x();
        let mut edge = Vec3::z();
        let mut d1 = Vec::new();
        for i in 0..=n {
            let next = if i < n { (points[i + 1] - points[i]).normalize() } else { Vec3::z() };
            field = transport(field, edge, next);
            edge = next;
            let angle = TAU * turns * i as f64 / n as f64;
            d1.push(field * angle.cos() + edge.cross(&field) * angle.sin());
        }
        (points, d1)
    }

    /// Along z, and along each viewing direction, which sees the rays as points.
    fn all_ways() -> Vec<Vec3> {
        let along = crossings::DIRECTIONS.iter().map(|d| Vec3::from(*d).normalize());
        std::iter::once(Vec3::z()).chain(along).collect()
    }

    #[test]
    fn link_of_ends_is_the_sum_over_all_pairs() {
        for (n, turns) in [(300, 0.0), (301, 2.25), (400, -3.5), (401, 11.0)] {
            let (points, d1) = line(n, turns);
            let line = extended(&points, Vec3::z() * 1e5);
            let sum = ribbon_twist(&line, &extended(&d1, Vec3::zeros()), false) + writhe_by_pairs(&line, false);
            let angle = d1[0].cross(&d1[n]).z.atan2(d1[0].xy().dot(&d1[n].xy())) / TAU;
            for direction in all_ways() {
                let turn = Quat::rotation_between(&Vec3::z(), &direction).unwrap();
                let [turned, frames] = [&points, &d1].map(|all| all.iter().map(|x| turn * x).collect::<Vec<_>>());
                let found = link_of_ends(&turned, &frames, direction * 2.0);
                assert!((found - sum).abs() < 1e-6, "{n}, {direction:?}: {found} {sum}");
                let whole = found - angle;
                assert!((whole - whole.round()).abs() < 1e-11, "{n}, {direction:?}: {found} {angle}");
            }
        }
    }

    #[test]
    fn lines_have_the_link_of_their_frames() {
        let points: Vec<Vec3> = (0..1200).map(|i| Vec3::new(0.5, 0.0, f64::from(i))).collect();
        let d1 = |i: i32| Vec3::new((0.01 * f64::from(i)).cos(), (0.01 * f64::from(i)).sin(), 0.0);
        let d1: Vec<Vec3> = (0..1200).map(d1).collect();
        assert!((link_of_ends(&points, &d1, Vec3::z()) - 11.99 / TAU).abs() < 1e-12);
        assert_eq!(link_of_ends(&[], &[], Vec3::z()), 0.0);
        assert!((link_of_ends(&points[..2], &d1[..2], Vec3::z()) - 0.01 / TAU).abs() < 1e-12);
        assert!(link_of_ends(&points, &d1, Vec3::zeros()).is_nan());
    }

    /// A spike without width adds nothing, although the ribbon's twist is undefined at its tip.
    #[test]
    fn spikes_do_not_count() {
        let (points, _) = knot(500, 0.0);
        let mut spiked = points.clone();
        spiked.splice(7..7, [points[6], points[6] + Vec3::new(0.5, 0.25, 1.0), points[6]]);
        spiked.remove(7);
        assert!((writhe(&spiked, true) - writhe(&points, true)).abs() < 1e-11);
    }

    #[test]
    fn link_is_an_integer_plus_the_seam() {
        for (turns, seam) in [(0.0, 0.0), (5.0, 0.0), (-3.75, 0.25), (2.4, -0.4), (1.5, 0.5)] {
            let (points, d1) = knot(300, turns);
            let found = link_numbers(&points, &d1, seam);
            assert!((found.link - seam - (found.link - seam).round()).abs() < 1e-12, "{turns}: {found:?}");
        }
    }
}
