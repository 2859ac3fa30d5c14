//! Change of gaps in a finite motion beyond the linear prediction.
//!
//! A sideways slide of the strands by s opens the gap by s²/2d, and a rotation of a contact line about its axis opens
//! it, too. These changes are small, but contact is stiff. The result is the distance from the constraint, whether
//! contact persists or not. Differences of contact forces would not do: they vanish where contact is lost, and push
//! along the strands as the normals rotate. Gaps are compared at the points of contact after the motion: these slide
//! along either strand (a motion of two crossing lines along themselves moves the point of contact and opens no gap).

use super::stiffness::Coordinates;
use super::term::{ContactPair, QuadraturePoint};
use crate::contact::curves::curve::{Cubic, CurveSet};
use crate::contact::measures::{LAST_STEP, MAX_STEPS};
use crate::contact::zones::FootKind;
use crate::math::Vec3;
use crate::math::bernstein::cubic_weights;

/// Least second derivative of the distance to a foot, over that far from the curve, because beyond the centre of
/// curvature a Newton step would lead away from the foot. With 0.1 instead, the minicircle takes 375 iterations for
/// 376.
const LEAST_CURVATURE: f64 = 0.2;
/// Squared difference of unit tangents below which lines count as parallel, because lines at less than 6°
/// cross too far away.
const SAME_DIRECTION: f64 = 0.01;

/// Σ W k e ∂gap/∂x, e = gap(moved) − gap − δgap, of a term with respect to the ends of `cubics` (slave and master where
/// the term was evaluated): the gradient, six coordinates an end, of a law continued linearly. `change` is the linear
/// motion of the control points, slave's four and master's four \[L\]. Also returns the segments that the first and the
/// last point of contact move to.
pub(crate) fn second_order_of_gaps(
    term: &ContactPair,
    cubics: [&Cubic; 2],
    change: &[Vec3; 8],
    moved: &CurveSet,
) -> ([f64; 24], [usize; 2]) {
    let [slave, master] = cubics;
    let (mut first, mut last) = (None, term.slave);
    let gradient = sum_of_gaps(term, cubics, change, |point, touch| {
        let (along, beside) = (slave.derivatives(point.u).1, master.derivatives(point.v).1);
        let (speed, speed_beside) = (along.norm(), beside.norm());
        let follows = matches!(point.kind, FootKind::Orthogonal | FootKind::Fold);
        let [shift, shift_beside] =
            if follows { sliding(&(along / speed), &(beside / speed_beside), &touch.approach) } else { [0.0; 2] };
        let (segment, u) = place(moved, term.slave, point.u + shift / speed);
        (first, last) = (first.or(Some(segment)), segment);
        let there = moved.segments[segment].point(u);
        let foot = if follows {
            follow_foot(moved, &there, term.master, point.v + shift_beside / speed_beside)
        } else {
            moved.segments[term.master].point(point.v)
        };
        let slope = touch.normal.dot(&along) / speed;
        (there - foot).norm() - touch.distance - touch.linear - slope * shift
    });
    (gradient, [first.unwrap_or(last), last])
}

/// Shift of the point of contact of two lines with these unit tangents along each \[L\], when the second moves by `by`
/// relative to the first. Exact for crossing lines; half the slide on each of parallel lines.
fn sliding(first: &Vec3, second: &Vec3, by: &Vec3) -> [f64; 2] {
    let part = |way: Vec3| {
        let size_sq = way.norm_squared();
        if size_sq < SAME_DIRECTION { 0.0 } else { by.dot(&way) / size_sq }
    };
    let (sum, difference) = (part(first + second), part(first - second));
    [difference + sum, difference - sum]
}

/// Σ W k (∂gap·δx) ∂gap/∂x, otherwise like [`second_order_of_gaps`]: the forces of the normal stiffness of contact
/// against a motion.
pub(crate) fn stiffness_of_gaps(term: &ContactPair, cubics: [&Cubic; 2], change: &[Vec3; 8]) -> [f64; 24] {
    sum_of_gaps(term, cubics, change, |_, here| here.linear)
}

/// ∂gap/∂x at each point of a term with respect to the ends of `cubics` (slave and master where the term was
/// evaluated), and weight × stiffness there \[F/L\].
pub(crate) fn gap_gradients<'a>(
    term: &'a ContactPair,
    [slave, master]: [&'a Cubic; 2],
) -> impl Iterator<Item = ([f64; 24], f64)> + 'a {
    let at = move |point: &QuadraturePoint| Some((gap_gradient([slave, master], [point.u, point.v])?, point.stiffness));
    term.points.iter().filter_map(at)
}

/// ∂gap/∂x of a point of a slave and its foot on a master, by their parameters, as in [`gap_gradients`]; `None` where
/// they coincide.
pub(crate) fn gap_gradient([slave, master]: [&Cubic; 2], [u, v]: [f64; 2]) -> Option<[f64; 24]> {
    let normal = (slave.point(u) - master.point(v)).try_normalize(0.0)?;
    let (wa, wb) = (cubic_weights(u), cubic_weights(v));
    let rate: [Vec3; 8] = std::array::from_fn(|m| normal * if m < 4 { wa[m] } else { -wb[m - 4] });
    Some(Coordinates::ends(slave, master).pull(&rate))
}

/// A point of contact and its linear motion, where its term was evaluated.
struct PointMotion {
    distance: f64,
    normal: Vec3,
    /// Linear change of the distance at this slave point.
    linear: f64,
    /// Linear motion of the foot relative to the slave point.
    approach: Vec3,
}

/// Σ W k e ∂gap/∂x.
fn sum_of_gaps(
    term: &ContactPair,
    [slave, master]: [&Cubic; 2],
    change: &[Vec3; 8],
    mut e: impl FnMut(&QuadraturePoint, &PointMotion) -> f64,
) -> [f64; 24] {
    let mut sum = [Vec3::zeros(); 8];
    for point in &term.points {
        let chord = slave.point(point.u) - master.point(point.v);
        let distance = chord.norm();
        if distance == 0.0 {
            continue;
        }
        let normal = chord / distance;
        let (wa, wb) = (cubic_weights(point.u), cubic_weights(point.v));
        let w: [f64; 8] = std::array::from_fn(|m| if m < 4 { wa[m] } else { -wb[m - 4] });
        let apart: Vec3 = w.iter().zip(change).map(|(w, change)| change * *w).sum();
        let here = PointMotion { distance, normal, linear: normal.dot(&apart), approach: -apart };
        let push = normal * (point.stiffness * e(point, &here));
        for (sum, w) in sum.iter_mut().zip(w) {
            *sum += push * w;
        }
    }
    Coordinates::ends(slave, master).pull(&sum)
}

/// Segment and parameter of a point whose parameter lies beyond a segment's ends; beyond an end of the curve the last
/// segment is kept.
fn place(set: &CurveSet, mut segment: usize, mut u: f64) -> (usize, f64) {
    for _ in 0..MAX_STEPS {
        let beyond = match u {
            _ if u < 0.0 => set.prev(segment).map(|prev| (prev, u + 1.0)),
            _ if u > 1.0 => set.next(segment).map(|next| (next, u - 1.0)),
            _ => None,
        };
        let Some(place) = beyond else { break };
        (segment, u) = place;
    }
    (segment, u.clamp(0.0, 1.0))
}

/// The foot of a point near parameter `v` of a segment; it may lie on a neighbour.
fn follow_foot(set: &CurveSet, point: &Vec3, segment: usize, v: f64) -> Vec3 {
    let (mut segment, mut v) = place(set, segment, v);
    for _ in 0..MAX_STEPS {
        let (foot, tangent, curvature) = set.segments[segment].derivatives(v);
        let (chord, speed_sq) = (point - foot, tangent.norm_squared());
        let step = chord.dot(&tangent) / (speed_sq - chord.dot(&curvature)).max(LEAST_CURVATURE * speed_sq);
        let before = (segment, v);
        (segment, v) = place(set, segment, v + step.clamp(-1.0, 1.0));
        if step.abs() < LAST_STEP || before == (segment, v) {
            break;
        }
    }
    set.segments[segment].point(v)
}
