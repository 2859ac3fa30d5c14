//! How far a step may go before a strand passes the surface of an obstacle.
//!
//! A strand must stay where the signed distance φ is positive. A linear motion of control points is bounded by a
//! function of the curve's parameter u and the fraction t that is below φ, a cubic of u whose coefficients are concave
//! in t:
//!
//! * outside a convex body φ is convex, so it is above its tangent anywhere: the distance from the tangent plane at the
//!   nearest point, linear in t. Of a plane this is φ itself.
//! * inside a convex body φ is concave: φ of a point of a curve is above the same mean of φ of its control points.
//!
//! Segments are divided into parts so short that the bound is near φ at t = 0. Dinkelbach's iteration (Management
//! Science 13 (1967) 492), Newton's method from above, finds the largest fraction under which all points keep their
//! distance: the nearest point says how far the step may go, until it is the same point twice. The second-order part of
//! the rotations is left out, and bounded as between strands.
//!
//! Of a body that a node carries the motion of the strand relative to it counts: δr − δc − θ × a from its point c, a =
//! r − c. What a finite turn of the body adds is of second order: from a + δ, δ = δr − δc, it takes |θ| |θ⊥| (|a| +
//! |δ|)/2 + |θ⊥| |δ| or less, θ⊥ the part of θ across the body's axis, because turns about the axis move no surface;
//! none of a sphere's does.

use super::{Keep, SegmentMotion};
use crate::contact::potential::surface::{ball, nearest_in, point_of, relative};
use crate::math::Vec3;
use crate::math::bernstein::{Roots, derivative, eval, roots};
use crate::math::signed_distance::{Skeleton, Surface};
use crate::solve::measures::{MAX_ROUNDS, ROUNDING};
use crate::solve::problem::carried_bodies::BodyMotion;
use crate::solve::problem::carrier::can_touch;
use crate::solve::problem::contact_side::ContactSide;

/// By how much a bound may be below φ, over the radius or the present distance, because steps lose as much.
const LOST: f64 = 0.05;
/// Parts of a segment, at most, because a node spacing is some dozens of radii at most where strands touch.
const MAX_PARTS: f64 = 64.0;

/// Largest t ≤ 1 for which no point of a strand comes nearer to an obstacle than is to be kept. Strands that are beyond
/// one already are pushed back, and may move.
pub(super) fn fraction(side: &ContactSide, increment: &[f64], motions: &[SegmentMotion], keep: Keep) -> f64 {
    if side.surfaces.is_empty() {
        return 1.0;
    }
    let bodies: Vec<BodyMotion> =
        (0..side.surfaces.len()).map(|index| BodyMotion::of(side, index, increment)).collect();
    let mut t = 1.0;
    for (segment, motion) in motions.iter().enumerate() {
        let (middle, size) = ball(&side.set, segment);
        let kept = keep.distance * side.set.radius_of(segment);
        let fastest = motion.fastest();
        for (index, (surface, body)) in side.surfaces.iter().zip(&bodies).enumerate() {
            let from_point = middle - surface.point();
            let fastest = fastest + body.fastest(from_point.norm() + size, fastest);
            if surface.distance(&from_point) - size - t * fastest < kept
                && can_touch(&side.carriers, &side.surfaces, [segment, index])
            {
                t = of_segment((side, segment), (surface, body), motion, keep, t);
            }
        }
    }
    t
}

/// The motion of a segment at these places from a body's point, relative to the body.
fn relative_to_body(motion: &SegmentMotion, (surface, body): (&Surface, &BodyMotion), r: &[Vec3; 4]) -> SegmentMotion {
    if !surface.carried {
        return SegmentMotion { ..*motion };
    }
    let across = match surface.skeleton {
        Skeleton::Piece { axis, .. } => body.rotation - axis * axis.dot(&body.rotation),
        _ => Vec3::zeros(),
    };
    let turning = BodyMotion { rotation: across, ..*body };
    let slid = motion.linear.map(|linear| linear - body.displacement);
    let [far, fast] = [r, &slid].map(|all| all.iter().map(Vec3::norm).fold(0.0, f64::max));
    let (turn, across) = (body.rotation.norm(), across.norm());
    SegmentMotion {
        linear: std::array::from_fn(|m| motion.linear[m] - turning.at(&r[m])),
        second_order: motion.second_order + 0.5 * turn * across * (far + fast) + across * fast,
    }
}

/// The fraction t, or less if this segment needs it.
fn of_segment(
    (side, segment): (&ContactSide, usize),
    (surface, body): (&Surface, &BodyMotion),
    motion: &SegmentMotion,
    keep: Keep,
    t: f64,
) -> f64 {
    let r = relative(surface, &side.set, segment);
    let radius = side.set.radius_of(segment);
    let motion = &relative_to_body(motion, (surface, body), &r);
    let fastest = motion.fastest();
    // enough where strands are far
    if surface.least_in_hull(&r) - t * fastest >= keep.distance * radius {
        return t;
    }
    let nearest = nearest_in(surface, &r, [0.0, 1.0]).1;
    if nearest <= 0.0 {
        return t;
    }
    let kept = (keep.distance * radius).min((1.0 - keep.deep) * nearest);
    let count = num_parts(surface, &r, LOST * radius.min(nearest));
    (0..count).fold(t, |t, k| {
        let ends = [k, k + 1].map(|k| k as f64 / count as f64);
        let moving = Moving { r: part(&r, ends), motion: part(&motion.linear, ends), slack: motion.second_order };
        // a part whose bound is lost in rounding: no point moves farther than this
        moving.fraction(surface, kept, keep.deep, t).unwrap_or_else(|| t.min((nearest - kept) / fastest))
    })
}

/// Parts into which a segment is divided so that bounds are at most `lost` below the distance \[L\].
fn num_parts(surface: &Surface, r: &[Vec3; 4], lost: f64) -> usize {
    if surface.skeleton.is_flat() {
        return 1;
    }
    let length: f64 = r.windows(2).map(|pair| surface.skeleton.away(&(pair[1] - pair[0])).norm()).sum();
    let from_skeleton = surface.level + surface.sign * nearest_in(surface, r, [0.0, 1.0]).1;
    // the sagitta of an arc, but no more than its length
    let longest = (8.0 * from_skeleton.max(0.0) * lost).sqrt().max(lost);
    (length / longest).ceil().clamp(1.0, MAX_PARTS) as usize
}

/// The control points of a part of a cubic: its polar form at the ends.
fn part(b: &[Vec3; 4], [start, end]: [f64; 2]) -> [Vec3; 4] {
    let polar = |u: [f64; 3]| {
        let mut w = *b;
        for (level, u) in u.into_iter().enumerate() {
            (0..3 - level).for_each(|i| w[i] = w[i] * (1.0 - u) + w[i + 1] * u);
        }
        w[0]
    };
    [[start; 3], [start, start, end], [start, end, end], [end; 3]].map(polar)
}

/// A part of a segment that moves.
struct Moving {
    /// Control points relative to the surface's own \[L\].
    r: [Vec3; 4],
    /// Their linear motion \[L\].
    motion: [Vec3; 4],
    /// Bound of the rest \[L\].
    slack: f64,
}

impl Moving {
    /// A bound of φ at a fraction t and its rate, as Bernstein coefficients.
    fn bound(&self, surface: &Surface) -> impl Fn(f64) -> [[f64; 4]; 2] {
        let at = point_of(&self.r, nearest_in(surface, &self.r, [0.0, 1.0]).0);
        let (distance, normal) = (surface.distance(&at), surface.normal(&at));
        let (surface, r, motion, slack) = (*surface, self.r, self.motion, self.slack);
        let is_concave = surface.is_hollow() && !surface.skeleton.is_flat();
        move |t: f64| {
            let there = |m: usize| r[m] + motion[m] * t;
            let value = |m: usize| {
                if is_concave { surface.distance(&there(m)) } else { distance + normal.dot(&(there(m) - at)) }
            };
            let normal = |m: usize| if is_concave { surface.normal(&there(m)) } else { normal };
            [std::array::from_fn(|m| value(m) - t * slack), std::array::from_fn(|m| normal(m).dot(&motion[m]) - slack)]
        }
    }

    /// The fraction t, or less under which the distance is kept; none if the bound is not positive where it is.
    fn fraction(&self, surface: &Surface, kept: f64, deep: f64, t: f64) -> Option<f64> {
        let bound = self.bound(surface);
        let here = least(&bound(0.0)[0]).1;
        if here <= 0.0 {
            return None;
        }
        let kept = kept.min((1.0 - deep) * here);
        let (mut t, mut left) = (t, 0.0);
        for _ in 0..MAX_ROUNDS {
            let [values, rates] = bound(t);
            let (u, value) = least(&values);
            let rate = eval(&rates, u);
            left = value - kept;
            if left >= 0.0 || rate >= 0.0 {
                return Some(t);
            }
            let next = t - left / rate;
            if next >= t * (1.0 - ROUNDING) {
                return Some(next);
            }
            t = next;
        }
        // the chord of a concave function is below it
        Some(t * (here - kept) / (here - kept - left.min(0.0)))
    }
}

/// Place and value of the minimum of a cubic of these Bernstein coefficients in \[0, 1\].
fn least(coeffs: &[f64; 4]) -> (f64, f64) {
    let mut found = Roots::new();
    roots(&derivative(coeffs)[..3], &mut found);
    let places = [0.0, 1.0].into_iter().chain(found.as_slice().iter().copied()).map(|u| (u, eval(coeffs, u)));
    places.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, f64::INFINITY))
}
