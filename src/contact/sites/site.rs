//! Contact sites, mutually nearest pairs of points of the curves, and their search on a pair of *straight* segments.
//!
//! The squared distance of two straight segments is a convex quadratic of the two parameters, so each pair has one
//! minimum or one straight interval of minima. It is a local minimum of the curves if it lies inside both segments, or
//! if at each joint it lies on the distance does not fall on the far side either: at a joint the two parameters'
//! one-sided slopes decide separately. This is why every local minimum of a pair of polylines is found and none is
//! invented.

use crate::contact::curves::curve::norm;
use crate::contact::curves::input::{JOINT, Strands};
use crate::contact::measures::USUAL;
use crate::math::Vec3;

/// Location of a site on its curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SiteLocation {
    /// Both points are inside their curves (also at joints).
    Interior,
    /// At least one point is an open end of its curve.
    End,
}

/// A bilateral local minimum of the distance between two curves, or between two parts of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Curve of the first point: its index in the input.
    pub curve_a: usize,
    /// Segment within that curve.
    pub segment_a: usize,
    /// Parameter on that segment, in \[0, 1\].
    pub u_a: f64,
    /// Arc length \[L\] from the start of that curve.
    pub arc_a: f64,
    /// Curve of the second point. (`curve_a`, `segment_a`) comes before (`curve_b`, `segment_b`).
    pub curve_b: usize,
    /// Segment within that curve.
    pub segment_b: usize,
    /// Parameter on that segment.
    pub u_b: f64,
    /// Arc length \[L\] from the start of that curve.
    pub arc_b: f64,
    /// Distance of the points minus both radii \[L\] (at a joint the larger of its segments'); negative is overlap.
    pub gap: f64,
    /// Unit vector from a to b; zero if the points coincide.
    pub normal: Vec3,
    /// Angle between the lines of the two tangents, rad, in \[0, π/2\].
    pub angle: f64,
    /// Interior or end.
    pub kind: SiteLocation,
    /// Whether the minimum is not isolated within rounding. The site is then one point of it; for parallel segments the
    /// middle of their overlap. (Straight cubics 1e12 of their length apart are flat, too, because their distance
    /// varies by less than its rounding.)
    pub flat: bool,
}

/// A minimum of a pair of segments (global indices); [`site_of`] makes a [`Site`] of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Minimum {
    pub(crate) u: f64,
    pub(crate) v: f64,
    pub(crate) i: u32,
    pub(crate) j: u32,
    pub(crate) flat: bool,
}

/// Largest sine of parallel directions, because the directions themselves are rounded by as much.
const PARALLEL: f64 = 4.0 * f64::EPSILON;
/// Largest one-sided slope that counts as zero at joints, relative to the product of the lengths, because it is rounded
/// by as much; duplicates are removed later.
const LEVEL: f64 = 8.0 * f64::EPSILON;

/// num/den in \[0, 1\].
#[inline]
fn ratio(num: f64, den: f64) -> f64 {
    (num / den).clamp(0.0, 1.0)
}

/// The minimum of the distance of straight segments i < j if it is a local minimum of their curves that segments i and
/// j own (a joint belongs to the segment after it) and not farther than `max_distance`.
pub(crate) fn straight_minimum(strands: &Strands, i: usize, j: usize, max_distance: f64) -> Option<Minimum> {
    let ((a0, a1), (b0, b1)) = (strands.ends(i), strands.ends(j));
    let (d, e, r) = (a1 - a0, b1 - b0, a0 - b0);
    let scale = d.amax().max(e.amax()).max(r.amax());
    let unit = if USUAL.contains(&scale) { 1.0 } else { scale };
    let (d, e, r) = if unit == 1.0 { (d, e, r) } else { (d / unit, e / unit, r / unit) };
    let (dd, ee, de) = (d.norm_squared(), e.norm_squared(), d.dot(&e));
    let (dr, er) = (d.dot(&r), e.dot(&r));
    let n = d.cross(&e);
    let nn = n.norm_squared();
    let at = |u: f64, v: f64| (r + d * u - e * v).norm_squared();
    let mut flat = false;
    let (mut u, mut v) = if nn > PARALLEL * PARALLEL * dd * ee {
        let u = e.cross(&r).dot(&n) / nn;
        let v = d.cross(&r).dot(&n) / nn;
        (u, v)
    } else {
        let (s, t) = (-dr / dd, (de - dr) / dd);
        let (low, high) = (s.min(t).max(0.0), s.max(t).min(1.0));
        flat = low < high;
        let middle = 0.5 * (low + high);
        if flat { (middle, ratio(er + de * middle, ee)) } else { (-1.0, -1.0) }
    };
    let inside = u > 0.0 && u < 1.0 && v > 0.0 && v < 1.0;
    if !inside {
        flat = false;
        (u, v) = (0.0, ratio(er, ee));
        let mut best = at(u, v);
        for (s, t) in [(1.0, ratio(er + de, ee)), (ratio(-dr, dd), 0.0), (ratio(de - dr, dd), 1.0)] {
            let other = at(s, t);
            if other < best {
                (u, v, best) = (s, t, other);
            }
        }
    }
    let w = r + d * u - e * v;
    let allowed = max_distance / unit;
    let far = w.norm_squared() > allowed * allowed;
    if far || max_distance < 0.0 {
        return None;
    }
    let owned = owned(strands, i, u, &w) && owned(strands, j, v, &-w);
    owned.then_some(Minimum { i: i as u32, u, j: j as u32, v, flat })
}

/// Whether a minimum at parameter u of a segment is the segment's to report and no further fall lies beyond its start;
/// `w` points from the other curve to this one.
fn owned(strands: &Strands, segment: usize, u: f64, w: &Vec3) -> bool {
    if u == 1.0 {
        return strands.next(segment).is_none();
    }
    if u > 0.0 {
        return true;
    }
    strands.prev(segment).is_none_or(|prev| {
        let (p0, p1) = strands.ends(prev);
        let back = p1 - p0;
        w.dot(&back) <= LEVEL * w.norm() * back.norm()
    })
}

/// The site of a minimum: gap, normal, angle and arc lengths from its parameters. `arc(segment, u)` is the arc length
/// from the start of the curve.
pub(crate) fn site_of(strands: &Strands, arc: impl Fn(usize, f64) -> f64, found: &Minimum) -> Site {
    let (i, j, u, v) = (found.i as usize, found.j as usize, found.u, found.v);
    let ((a, da), (b, db)) = (point_and_tangent(strands, i, u), point_and_tangent(strands, j, v));
    let w = b - a;
    let distance = norm(&w);
    let scaled = if USUAL.contains(&distance) { w / distance } else { w / w.amax() };
    let open = |segment: usize, u: f64| {
        (u == 0.0 && strands.prev(segment).is_none()) || (u == 1.0 && strands.next(segment).is_none())
    };
    let (curve_a, curve_b) = (strands.curve_of(i), strands.curve_of(j));
    let (strand_a, strand_b) = (&strands.curves[curve_a], &strands.curves[curve_b]);
    Site {
        curve_a,
        segment_a: i - strand_a.first,
        u_a: u,
        arc_a: arc(i, u),
        curve_b,
        segment_b: j - strand_b.first,
        u_b: v,
        arc_b: arc(j, v),
        gap: distance - (strands.radius_at(i, u) + strands.radius_at(j, v)),
        normal: if distance > 0.0 { scaled.normalize() } else { Vec3::zeros() },
        angle: crossing_angle(&da, &db),
        kind: if open(i, u) || open(j, v) { SiteLocation::End } else { SiteLocation::Interior },
        flat: found.flat,
    }
}

/// From the first point of a minimum to the second.
pub(crate) fn connection(strands: &Strands, m: &Minimum) -> Vec3 {
    point_and_tangent(strands, m.j as usize, m.v).0 - point_and_tangent(strands, m.i as usize, m.u).0
}

/// Angle between two lines in \[0, π/2\].
fn crossing_angle(d: &Vec3, e: &Vec3) -> f64 {
    if USUAL.contains(&d.amax()) && USUAL.contains(&e.amax()) {
        return d.cross(e).norm().atan2(d.dot(e).abs());
    }
    let angle = crate::contact::curves::curve::angle(d, e);
    angle.min(std::f64::consts::PI - angle)
}

fn point_and_tangent(strands: &Strands, segment: usize, u: f64) -> (Vec3, Vec3) {
    if strands.is_straight(segment) {
        let (p0, p1) = strands.ends(segment);
        // Measured from the nearer end, so that both ends are exact.
        let d = p1 - p0;
        (if u < 0.5 { p0 + d * u } else { p1 - d * (1.0 - u) }, d)
    } else {
        let cubic = strands.cubic(segment);
        let (point, slope, _) = cubic.derivatives(u);
        let tangent = if slope != Vec3::zeros() {
            slope
        } else if u < 0.5 {
            cubic.start_tangent()
        } else {
            cubic.end_tangent()
        };
        (point, tangent)
    }
}

/// Sorts minima whose first segments ascend by (i, u, j, v) and removes those found twice because rounding put them on
/// both sides of a joint: arc lengths equal to [`JOINT`] of a segment. Keeps the first of each group.
pub(crate) fn put_in_order(
    strands: &Strands,
    minima: &mut Vec<Minimum>,
    arc: impl Fn(usize, f64) -> f64,
    lengths: &[f64],
) {
    for group in minima.chunk_by_mut(|a, b| a.i == b.i) {
        group.sort_by(|a, b| a.u.total_cmp(&b.u).then(a.j.cmp(&b.j)).then(a.v.total_cmp(&b.v)));
    }
    let on_joint = |t: f64| !(JOINT..=1.0 - JOINT).contains(&t);
    let twin = |a: &Minimum, b: &Minimum| {
        let close = |s: u32, u: f64, t: u32, v: f64| {
            let (s, t) = (s as usize, t as usize);
            let curve = strands.strand(s);
            if strands.curve_of(t) != strands.curve_of(s) {
                return false;
            }
            let apart = (arc(s, u) - arc(t, v)).abs();
            let last = curve.first + curve.count - 1;
            let round = if curve.closed { (arc(last, 1.0) - apart).abs() } else { apart };
            apart.min(round) <= JOINT * lengths[s].min(lengths[t])
        };
        close(a.i, a.u, b.i, b.u) && close(a.j, a.v, b.j, b.v)
    };
    // Twins lie on a joint of at least one side. The kept ones are moved to the front.
    let mut kept = 0;
    for k in 0..minima.len() {
        let m = minima[k];
        let known = (on_joint(m.u) || on_joint(m.v))
            && (minima[..kept].iter().rev().take_while(|t| t.i + 1 >= m.i).any(|t| twin(t, &m))
                || strands.next(m.i as usize).filter(|&n| n < m.i as usize).is_some_and(|n| {
                    // Across the seam of a closed curve, whose first segment is far up the list.
                    let first = minima[..kept].partition_point(|t| (t.i as usize) < n);
                    minima[first..kept].iter().take_while(|t| t.i as usize == n).any(|t| twin(t, &m))
                }));
        if !known {
            minima[kept] = m;
            kept += 1;
        }
    }
    minima.truncate(kept);
}
