//! Orthogonal projection of a point on a cubic: all local minima of |c(u) − x|, certified.
//!
//! The stationary points are the roots of q(u) = (c(u) − x)·c′(u)/3, a quintic whose Bernstein coefficients are q_k =
//! Σ_{i+j=k} C(3,i) C(2,j) / C(5,k) (b_i − x)·(b_{j+1} − b_j); minima are where q rises from − to +. Everything is
//! relative to x, so the distance from the origin of coordinates costs nothing; there is no absolute tolerance.

use crate::contact::curves::curve::{Cubic, CurveSet};
use crate::contact::measures::{COINCIDENT, SMOOTH, USUAL};
use crate::math::Vec3;
use crate::math::bernstein::{Roots, SignChange, product_with_quadratic, roots};

/// Feet on one segment, at most, because a quintic rises three times at most, and there are two ends.
const CAPACITY: usize = 5;

/// A local minimum of the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Parameter on the segment, in \[0, 1\].
    pub u: f64,
    /// |c(u) − x| \[L\].
    pub distance: f64,
}

/// Feet found, ascending in u; fixed capacity, lives on the stack.
#[derive(Clone, Copy, Debug)]
pub struct Feet {
    feet: [Foot; CAPACITY],
    len: usize,
}

impl Default for Feet {
    fn default() -> Self {
        Self::new()
    }
}

impl Feet {
    /// No feet.
    #[must_use]
    pub const fn new() -> Self {
        Self { feet: [Foot { u: 0.0, distance: 0.0 }; CAPACITY], len: 0 }
    }

    /// Forgets all feet.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// The feet, ascending in u.
    #[must_use]
    pub fn as_slice(&self) -> &[Foot] {
        &self.feet[..self.len]
    }

    /// The foot with the smallest distance (the first of equals).
    #[must_use]
    pub fn nearest(&self) -> Option<Foot> {
        self.as_slice().iter().copied().reduce(|a, b| if b.distance < a.distance { b } else { a })
    }

    fn push(&mut self, foot: Foot) {
        // A quintic rises at most three times, plus two ends.
        debug_assert!(self.len < CAPACITY, "more feet than a quintic has rising roots");
        if self.len < CAPACITY {
            self.feet[self.len] = foot;
            self.len += 1;
        }
    }
}

/// Bernstein coefficients of (c(u) − x)·c′(u)/3 \[L²\].
#[must_use]
pub fn stationarity(curve: &Cubic, x: &Vec3) -> [f64; 6] {
    let a = relative(curve, x);
    let e = curve.edges();
    product_with_quadratic(|i, j| a[i].dot(&e[j]))
}

fn relative(curve: &Cubic, x: &Vec3) -> [Vec3; 4] {
    curve.b.map(|b| b - x)
}

/// |c(u) − x| \[L\], without cancellation far from the origin or overflow of squares.
fn distance_at(a: &[Vec3; 4], u: f64) -> f64 {
    let v = 1.0 - u;
    let d = a[0] * (v * v * v) + a[1] * (3.0 * v * v * u) + a[2] * (3.0 * v * u * u) + a[3] * (u * u * u);
    let scale = d.amax();
    if scale > 0.0 { scale * (d / scale).norm() } else { 0.0 }
}

/// All stationary local minima of |c(u) − x| on \[0, 1\] with distance ≤ `max_distance`, ascending in u, replacing
/// `out`.
///
/// * Complete and without spurious minima up to rounding: roots of the quintic are isolated by sign variation.
/// * A minimum exactly at u = 0 or 1 *with c′·(c − x) = 0 there* is included when the curve's own side of it rises; an
///   end that is merely nearest (slope not zero) is not: see `end_is_local_min`. Over a whole curve use
///   [`feet_on_segment`], which counts joints once.
/// * A flat or higher-order minimum (touching arcs of osculating circles) is one foot. A saddle (double root of q) is
///   none.
/// * x on the curve: foot at distance 0 (to rounding).
/// * A curve shrunk to a point (q identically zero) has no stationary minima, likewise NaN input.
/// * c′ = 0 inside (a cusp of the parametrisation) is a root of q as well and a foot if it is a local minimum.
pub fn local_minima(curve: &Cubic, x: &Vec3, max_distance: f64, out: &mut Feet) {
    out.clear();
    minima_from(curve, x, &stationarity(curve, x), max_distance, out);
}

fn minima_from(curve: &Cubic, x: &Vec3, q: &[f64; 6], max_distance: f64, out: &mut Feet) {
    if q.iter().all(|&c| c > 0.0) || q.iter().all(|&c| c < 0.0) {
        return;
    }
    let mut found = Roots::new();
    roots(q, &mut found);
    let a = relative(curve, x);
    for root in found.iter().filter(|r| r.crossing == SignChange::Rising) {
        let distance = distance_at(&a, root.t);
        if distance <= max_distance {
            out.push(Foot { u: root.t, distance });
        }
    }
}

/// Whether the end u = 0 (`at_end` false) or u = 1 (true) is a local minimum of |c(u) − x| on \[0, 1\] by the sign
/// of the one-sided derivative: moving into the curve increases the distance, c′(0)·(c(0) − x) > 0 or c′(1)·(c(1) −
/// x) < 0. An exactly stationary end (zero derivative) is left to [`local_minima`]. If c′ vanishes at the end, its
/// limiting direction is used.
#[must_use]
pub fn end_is_local_min(curve: &Cubic, x: &Vec3, at_end: bool) -> bool {
    if at_end {
        (curve.b[3] - x).dot(&curve.end_tangent()) < 0.0
    } else {
        (curve.b[0] - x).dot(&curve.start_tangent()) > 0.0
    }
}

/// The local minima of the distance from x over the *whole curve* that segment `segment` owns, replacing `out`: the
/// union over all segments of a curve has every local minimum exactly once.
///
/// A segment owns its interior, its start (u = 0, joint with its predecessor) and any open end. At a smooth joint both
/// neighbours use the one computed sign of c′·(c − x), so that rounding neither loses a minimum sitting on the joint
/// nor counts it twice; at a kink the two signs differ and − to + is a minimum there. Open ends count when
/// `end_is_local_min`.
pub fn feet_on_segment(set: &CurveSet, segment: usize, x: &Vec3, max_distance: f64, out: &mut Feet) {
    out.clear();
    let curve = &set.segments[segment];
    let mut q = stationarity(curve, x);
    let start = match set.prev(segment) {
        Some(p) => {
            let prev = &set.segments[p];
            let before = (prev.b[3] - x).dot(&prev.edges()[2]);
            if smooth_joint(prev, curve, curve.b[0].amax()) {
                // The predecessor's computed value, scaled to this segment's speed.
                q[0] = before * (curve.edges()[0].norm() / prev.edges()[2].norm());
                before == 0.0 && rises_after_start(&q)
            } else {
                before <= 0.0 && q[0] >= 0.0 && (q[0] > 0.0 || rises_after_start(&q))
            }
        }
        None => q[0] > 0.0 || (q[0] == 0.0 && rises_after_start(&q)),
    };
    let a = relative(curve, x);
    if start {
        push_within(&a, 0.0, max_distance, out);
    }
    let mut inner = Feet::new();
    minima_from(curve, x, &q, max_distance, &mut inner);
    for foot in inner.as_slice() {
        // An exactly stationary start is handled above; an exactly stationary end belongs to the successor.
        if (foot.u > 0.0 || q[0] != 0.0) && (foot.u < 1.0 || q[5] != 0.0) {
            out.push(*foot);
        }
    }
    if set.next(segment).is_none() && (end_is_local_min(curve, x, true) || (q[5] == 0.0 && rises_before_end(&q))) {
        push_within(&a, 1.0, max_distance, out);
    }
}

fn push_within(a: &[Vec3; 4], u: f64, max_distance: f64, out: &mut Feet) {
    let distance = distance_at(a, u);
    if distance <= max_distance {
        out.push(Foot { u, distance });
    }
}

/// Sign of q just after 0: the first non-zero coefficient.
fn rises_after_start(q: &[f64; 6]) -> bool {
    q.iter().find(|c| **c != 0.0).is_some_and(|c| *c > 0.0)
}

/// Sign of q just before 1 is negative: the last non-zero coefficient.
fn rises_before_end(q: &[f64; 6]) -> bool {
    q.iter().rev().find(|c| **c != 0.0).is_some_and(|c| *c < 0.0)
}

/// Same tangent direction on both sides to rounding ([`SMOOTH`]) of control points given `far` \[L\] from the origin;
/// false if a tangent vanishes.
pub(crate) fn smooth_joint(prev: &Cubic, next: &Cubic, far: f64) -> bool {
    same_direction(&prev.edges()[2], &next.edges()[0], far)
}

/// Same direction to rounding ([`SMOOTH`]) of two differences of points that are `far` \[L\] from the origin; false if
/// one is zero.
pub(crate) fn same_direction(a: &Vec3, b: &Vec3, far: f64) -> bool {
    // The plain cases first: an angle above 1e-6 or below a third of the limit, and so near the origin that rounding is
    // much less than 1e-6.
    let (aa, bb, cross_sq) = (a.norm_squared(), b.norm_squared(), a.cross(b).norm_squared());
    let shorter = aa.min(bb);
    if USUAL.contains(&shorter) && USUAL.contains(&aa.max(bb)) && far * far * COINCIDENT * COINCIDENT < shorter {
        if cross_sq > COINCIDENT * COINCIDENT * aa * bb {
            return false;
        }
        if cross_sq < 0.1 * SMOOTH * SMOOTH * aa * bb && a.dot(b) > 0.0 {
            return true;
        }
    }
    let (sa, sb) = (a.amax(), b.amax());
    if sa == 0.0 || sb == 0.0 {
        return false;
    }
    let (a, b) = (a / sa, b / sb);
    // Differences of control points carry the ulps of their distance from the origin.
    let rounding = f64::EPSILON * far * (1.0 / sa + 1.0 / sb);
    a.dot(&b) > 0.0 && a.cross(&b).norm() <= (SMOOTH + 4.0 * rounding) * a.norm() * b.norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::curves::curve::CurveInput;

    #[test]
    fn straight_segment() {
        let c = Cubic::straight(Vec3::zeros(), Vec3::x() * 2.0);
        let mut feet = Feet::new();
        for unit in [1.0, 1e-12, 1e12, 1e-120] {
            let c = Cubic { b: c.b.map(|p| p * unit) };
            local_minima(&c, &(Vec3::new(0.5, 0.3, 0.4) * unit), unit, &mut feet);
            assert_eq!(feet.as_slice().len(), 1);
            assert!((feet.as_slice()[0].u - 0.25).abs() < 1e-15);
            assert!((feet.as_slice()[0].distance / unit - 0.5).abs() < 1e-15);
            local_minima(&c, &(Vec3::new(0.5, 0.3, 0.4) * unit), 0.4 * unit, &mut feet);
            assert!(feet.as_slice().is_empty());
        }
        local_minima(&c, &Vec3::new(-0.5, 0.3, 0.4), 9.0, &mut feet);
        assert!(feet.as_slice().is_empty());
        assert!(end_is_local_min(&c, &Vec3::new(-0.5, 0.3, 0.4), false));
        assert!(!end_is_local_min(&c, &Vec3::new(-0.5, 0.3, 0.4), true));
    }

    #[test]
    fn two_minima_on_a_hairpin() {
        let p = [Vec3::zeros(), Vec3::new(4.0, 0.0, 0.0), Vec3::new(4.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
        let mut feet = Feet::new();
        local_minima(&Cubic { b: p }, &Vec3::new(1.0, 0.5, 0.0), 10.0, &mut feet);
        assert_eq!(feet.as_slice().len(), 2);
        let [a, b] = feet.as_slice() else { panic!() };
        assert!((a.u + b.u - 1.0).abs() < 1e-14 && (a.distance - b.distance).abs() < 1e-14);
        assert_eq!(feet.nearest().unwrap().u, if a.distance <= b.distance { a.u } else { b.u });
    }

    #[test]
    fn degenerate_curve_and_nan() {
        let mut feet = Feet::new();
        local_minima(&Cubic { b: [Vec3::x(); 4] }, &Vec3::zeros(), 10.0, &mut feet);
        assert!(feet.as_slice().is_empty());
        local_minima(&Cubic { b: [Vec3::x() * f64::NAN; 4] }, &Vec3::zeros(), 10.0, &mut feet);
        assert!(feet.as_slice().is_empty());
    }

    /// Points in the normal plane of a joint, perturbed by rounding: one foot per curve, always.
    #[test]
    fn a_foot_on_a_joint_counts_once() {
        let n = 12;
        let h = 2.0 * std::f64::consts::PI / f64::from(n);
        for turn in 0..50 {
            let phase = 0.1 * f64::from(turn);
            let p = |i: i32| {
                let (s, c) = (phase + h * f64::from(i % n)).sin_cos();
                (Vec3::new(c, s, 0.1), Vec3::new(-s, c, 0.0) * h)
            };
            let segments = (0..n).map(|i| Cubic::from_hermite(p(i).0, p(i).1, p(i + 1).0, p(i + 1).1)).collect();
            let input = CurveInput { segments, lengths: vec![h; 12], closed: true, radius: 0.01 };
            let set = CurveSet::new(vec![input]).unwrap();
            for i in 0..n {
                let x = p(i).0 * 1.5;
                let mut count = 0;
                let mut feet = Feet::new();
                for s in 0..set.len() {
                    feet_on_segment(&set, s, &x, 0.6, &mut feet);
                    count += feet.as_slice().len();
                }
                assert_eq!(count, 1, "turn {turn} joint {i}");
            }
        }
    }

    #[test]
    fn polyline_corners_and_ends() {
        let p = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0)];
        let set = CurveSet::from_polylines(&[(&p, 0.1, false)]).unwrap();
        let mut feet = Feet::new();
        let x = Vec3::new(1.5, -0.5, 0.0);
        feet_on_segment(&set, 0, &x, 2.0, &mut feet);
        assert!(feet.as_slice().is_empty());
        feet_on_segment(&set, 1, &x, 2.0, &mut feet);
        assert_eq!(feet.as_slice().len(), 1);
        assert_eq!(feet.as_slice()[0].u, 0.0);
        feet_on_segment(&set, 1, &Vec3::new(1.2, 1.5, 0.0), 2.0, &mut feet);
        assert_eq!(feet.as_slice()[0].u, 1.0);
        feet_on_segment(&set, 0, &Vec3::new(-1.0, 0.1, 0.0), 2.0, &mut feet);
        assert_eq!(feet.as_slice()[0].u, 0.0);
    }
}
