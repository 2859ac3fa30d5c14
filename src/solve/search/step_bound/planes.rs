//! How far a step may go before a strand passes a plane.
//!
//! The distance of a segment's points from a plane is a cubic polynomial, and so is the rate at which a linear motion
//! of its control points changes it: both are known exactly. Dinkelbach's iteration (Management Science 13 (1967) 492)
//! finds the largest fraction of a step under which all points keep their distance: the nearest point tells how far the
//! step may go, until it is the same point twice. The second-order part of the rotations is left out, and bounded as
//! between strands.

use super::{Keep, SegmentMotion};
use crate::contact::curve::CurveSet;
use crate::contact::potential::plane::{HalfSpace, least};
use crate::math::bernstein::eval;
use crate::solve::measures::{MAX_ROUNDS, ROUNDING};

/// Largest t ≤ 1 for which no point of a strand comes nearer to a plane than is to be kept. Strands that are beyond one
/// already are pushed back, and may move.
pub(super) fn fraction(set: &CurveSet, planes: &[HalfSpace], motions: &[SegmentMotion], keep: Keep) -> f64 {
    planes.iter().fold(1.0, |t, plane| (0..set.len()).fold(t, |t, k| of_segment((set, k), plane, &motions[k], keep, t)))
}

/// The fraction t, or less if this segment needs it.
fn of_segment(
    (set, segment): (&CurveSet, usize),
    plane: &HalfSpace,
    motion: &SegmentMotion,
    keep: Keep,
    t: f64,
) -> f64 {
    let distances = plane.distances(set, segment);
    let rates: [f64; 4] = std::array::from_fn(|m| plane.normal.dot(&motion.linear[m]) - motion.second_order);
    if rates.iter().all(|rate| *rate >= 0.0) {
        return t;
    }
    let nearest = least(&distances, [0.0, 1.0]).1;
    if nearest <= 0.0 {
        return t;
    }
    let least_kept = (keep.distance * set.radius_of(segment)).min((1.0 - keep.deep) * nearest);
    let room = |m: usize| distances[m] - least_kept;
    // by the control points: enough where strands are far
    if (0..4).all(|m| room(m) + t * rates[m] >= 0.0) {
        return t;
    }
    let mut t = t;
    for _ in 0..MAX_ROUNDS {
        let moved: [f64; 4] = std::array::from_fn(|m| room(m) + t * rates[m]);
        let (u, left) = least(&moved, [0.0, 1.0]);
        let rate = eval(&rates, u);
        if left >= 0.0 || rate >= 0.0 {
            return t;
        }
        let next = t - left / rate;
        if next >= t * (1.0 - ROUNDING) {
            return next;
        }
        t = next;
    }
    t
}
