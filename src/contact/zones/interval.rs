//! Contact zones: intervals of arc length on one curve within range of another interval, its partner.
//!
//! For a straight segment against a straight segment the interval is exact: the distance from a segment is convex, so
//! the part of a line within range of it is one interval, its ends roots of quadratics. Cubics go through
//! [`SegmentPair::pieces`](crate::contact::zones::SegmentPair::pieces). The intervals of pairs of segments are then
//! joined where both they and their partner intervals touch.

use std::cell::OnceCell;

use crate::contact::curves::curve::angle;
use crate::contact::curves::input::Strands;
use crate::contact::measures::COINCIDENT;
use crate::contact::pairs::capsule::segment_distance;
use crate::contact::tree::exclusion::bytes;
use crate::contact::zones::straight::{chord, cut};
use crate::contact::zones::{BranchPiece, SegmentPair, SmoothJoint};
use crate::math::Vec3;
use crate::math::groups::Groups;

/// A maximal interval of one curve whose points have a point of the partner interval within range.
///
/// Every contact gives two zones, one from each side. On a closed curve zones are cut at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Curve the interval lies on.
    pub curve: usize,
    /// Start and end of the interval, arc length \[L\].
    pub arc: [f64; 2],
    /// Curve of the partner interval.
    pub partner: usize,
    /// Smallest and largest arc length \[L\] of the nearest points on the partner.
    pub partner_arc: [f64; 2],
    /// Smallest gap between segments of the zone \[L\].
    pub gap: f64,
}

/// Part of a zone on one pair of segments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Segment (of all curves) the part lies on.
    pub(crate) segment: u32,
    pub(crate) curve: u32,
    pub(crate) partner: u32,
    pub(crate) arc: [f64; 2],
    pub(crate) partner_arc: [f64; 2],
    pub(crate) gap: f64,
}

/// The search for parts of zones on pairs of segments.
pub(crate) struct PartSearch<'a, A> {
    pub(crate) strands: &'a Strands<'a>,
    /// Arc length \[L\] at a segment and parameter, from the start of the curve.
    pub(crate) arc: A,
    /// Largest gap \[L\].
    pub(crate) range: f64,
}

impl<A: Fn(usize, f64) -> f64> PartSearch<'_, A> {
    /// Parts of segment `i` within range of segment `j`, then of `j` within range of `i`.
    pub(crate) fn both(&self, i: usize, j: usize, out: &mut Vec<Part>) {
        let (strands, radii) = (self.strands, self.strands.radius_of(i) + self.strands.radius_of(j));
        if radii + self.range <= 0.0 {
            return;
        }
        if strands.is_straight(i) && strands.is_straight(j) {
            // Computed only where there is an interval; the same from both sides.
            let distance = OnceCell::new();
            for [i, j] in [[i, j], [j, i]] {
                let gap = || {
                    let ((a0, a1), (b0, b1)) = (strands.ends(i), strands.ends(j));
                    distance.get_or_init(|| segment_distance(&a0, &a1, &b0, &b1)) - radii
                };
                self.straight([i, j], radii + self.range, |u, v| out.push(self.part([i, j], u, v, gap())));
            }
        } else {
            for [i, j] in [[i, j], [j, i]] {
                self.cubic([i, j], radii + self.range, |u, v, distance| {
                    out.push(self.part([i, j], u, v, distance - radii));
                });
            }
        }
    }

    /// The part of segment i with parameters `u` whose feet have parameters `v` on segment j.
    fn part(&self, [i, j]: [usize; 2], u: [f64; 2], v: [f64; 2], gap: f64) -> Part {
        let (t0, t1) = ((self.arc)(j, v[0]), (self.arc)(j, v[1]));
        Part {
            segment: i as u32,
            curve: self.strands.curve_of(i) as u32,
            partner: self.strands.curve_of(j) as u32,
            arc: u.map(|u| (self.arc)(i, u)),
            partner_arc: [t0.min(t1), t0.max(t1)],
            gap,
        }
    }

    /// The segments before and after segment `j`, if they are as thick: then they take over beyond the joint.
    fn neighbours(&self, j: usize) -> [Option<usize>; 2] {
        let thick = |k: &usize| self.strands.radius_of(*k) >= self.strands.radius_of(j);
        [self.strands.prev(j).filter(thick), self.strands.next(j).filter(thick)]
    }

    /// Calls `push(u, v)` for the intervals of straight segment i within `reach` of straight segment j.
    fn straight(&self, [i, j]: [usize; 2], reach: f64, push: impl FnMut([f64; 2], [f64; 2])) {
        let ((a0, a1), (b0, b1)) = (self.strands.ends(i), self.strands.ends(j));
        let chord = |k: usize| {
            let (start, end) = self.strands.ends(k);
            end - start
        };
        let corners = self.neighbours(j).map(|k| k.map(chord));
        let pair = StraightPair { d: a1 - a0, e: b1 - b0, r: a0 - b0 };
        pair.intervals(reach, &corners, push);
    }

    /// Calls `push(u, v, smallest distance)` for the intervals of segment i within `reach` of segment j.
    fn cubic(&self, [i, j]: [usize; 2], reach: f64, mut push: impl FnMut([f64; 2], [f64; 2], f64)) {
        let strands = self.strands;
        // Near the origin, because far from it rounding would hide the ends. All masters use the same origin, so that
        // two that meet at a joint compute the same bits there.
        let origin = strands.ends(i).0;
        let near = |k: usize| strands.cubic(k).relative_to(&origin);
        let (slave, master) = (near(i), near(j));
        let corner = |before: Option<usize>, after: Option<usize>| match (before, after) {
            (Some(p), Some(n)) => {
                angle(&strands.cubic(p).end_tangent(), &strands.cubic(n).start_tangent()) > COINCIDENT
            }
            _ => true,
        };
        let [before, after] = self.neighbours(j);
        let pair = SegmentPair {
            slave: &slave,
            master: &master,
            open_start: corner(before, Some(j)),
            open_end: corner(Some(j), after),
            reach: [reach; 2],
            joints: SmoothJoint::both(strands.prev(j).map(near), &master, strands.next(j).map(near), &origin),
            kinks: [None; 2],
        };
        let mut pieces = Vec::new();
        pair.pieces(&mut pieces);
        // Farthest points lie in the zones of nearest ones.
        for piece in pieces.iter().filter(|piece| !piece.branch.is_subtracted()) {
            let BranchPiece { u, v, .. } = piece.ascending();
            push(u, v, piece.nearest.distance);
        }
    }
}

/// Segments r + \[0, 1\] d and \[0, 1\] e \[L\].
struct StraightPair {
    d: Vec3,
    e: Vec3,
    r: Vec3,
}

impl StraightPair {
    /// {u in \[0, 1\] : r + u d within `reach` of the segment from 0 to e} and the parameters on e of its ends' nearest
    /// points, in at most three intervals, ascending. `corners`: the directions of the segments before and after e, if
    /// their radii are as large. A point nearest to such a joint counts only if the joint is the nearest point of the
    /// neighbour, too (otherwise the neighbour has a nearer point and its own interval).
    fn intervals(&self, reach: f64, corners: &[Option<Vec3>; 2], mut push: impl FnMut([f64; 2], [f64; 2])) {
        let Self { d, e, r } = self;
        // In units of the reach, to avoid overflow and underflow of squares.
        let unit = 1.0 / reach;
        let (d, e, r) = if unit.is_finite() && unit > 0.0 {
            (d * unit, e * unit, r * unit)
        } else {
            (d / reach, e / reach, r / reach)
        };
        let (ee, de, er) = (e.norm_squared(), d.dot(&e), e.dot(&r));
        let foot = |u: f64| ((er + u * de) / ee).clamp(0.0, 1.0);
        // Before the start of e, beside it, beyond its end: the line relative to the nearest point, and the range of u
        // with its foot there.
        let beside = [r - e * (er / ee), d - e * (de / ee)];
        let unit = [0.0, 1.0];
        let before = (cut(unit, -er, -de), [r, d]);
        let after = (cut(unit, er - ee, de), [r - e, d]);
        let middle = (cut(cut(unit, er, de), ee - er, -de), beside);
        let wedge = |range: [f64; 2], corner: &Option<Vec3>, p: &Vec3, sign: f64| match corner {
            Some(t) => cut(range, sign * p.dot(t), sign * d.dot(t)),
            None => range,
        };
        let before = (wedge(before.0, &corners[0], &r, 1.0), before.1);
        let after = (wedge(after.0, &corners[1], &(r - e), -1.0), after.1);
        let ordered = if de < 0.0 { [after, middle, before] } else { [before, middle, after] };
        let mut open: Option<[f64; 2]> = None;
        for (range, [x, y]) in ordered {
            let Some(inside) = chord(&x, &y, 1.0) else { continue };
            let part = [inside[0].max(range[0]), inside[1].min(range[1])];
            let empty = part[0].is_nan() || part[0] > part[1];
            if empty {
                continue;
            }
            open = match open {
                Some(u) if part[0] <= u[1] => Some([u[0], u[1].max(part[1])]),
                Some(u) => {
                    push(u, u.map(foot));
                    Some(part)
                }
                None => Some(part),
            };
        }
        if let Some(u) = open {
            push(u, u.map(foot));
        }
    }
}

/// Buffers of [`join`], kept between calls: at 72 bytes a part, new memory would cost a quarter of the time.
#[derive(Debug, Default)]
pub(crate) struct JoinBuffers {
    parts: Vec<Part>,
    place: Vec<u32>,
    groups: Vec<u32>,
    zone_of: Vec<u32>,
}

impl JoinBuffers {
    /// Memory, bytes.
    pub(crate) fn memory(&self) -> usize {
        bytes(&self.parts) + bytes(&self.place) + bytes(&self.groups) + bytes(&self.zone_of)
    }
}

/// Joins parts into zones: those of the same two curves that touch on both sides (to `tolerance(curve)` \[L\]). Zones
/// come out ordered by curve, partner and start.
pub(crate) fn join(
    lists: &[Vec<Part>],
    num_segments: usize,
    tolerance: impl Fn(usize) -> f64,
    workspace: &mut JoinBuffers,
) -> Vec<Zone> {
    let key = |p: &Part| (p.curve, p.partner);
    in_order(lists, num_segments, workspace);
    let JoinBuffers { parts, groups, zone_of, .. } = workspace;
    let mut groups = Groups::apart(parts.len(), groups);
    // Parts that end after the start of the present one.
    let mut active: Vec<usize> = Vec::new();
    for k in 0..parts.len() {
        let part = &parts[k];
        let (tol, tol_partner) = (tolerance(part.curve as usize), tolerance(part.partner as usize));
        active.retain(|&m| key(&parts[m]) == key(part) && parts[m].arc[1] + tol >= part.arc[0]);
        for &m in &active {
            let (p, q) = (parts[m].partner_arc, part.partner_arc);
            if p[0] <= q[1] + tol_partner && q[0] <= p[1] + tol_partner {
                groups.join(m, k);
            }
        }
        active.push(k);
    }
    let mut zones: Vec<Zone> = Vec::new();
    zone_of.clear();
    zone_of.resize(parts.len(), u32::MAX);
    for (k, part) in parts.iter().enumerate() {
        let first = groups.first(k);
        if zone_of[first] == u32::MAX {
            zone_of[first] = zones.len() as u32;
            let (curve, partner) = (part.curve as usize, part.partner as usize);
            zones.push(Zone { curve, arc: part.arc, partner, partner_arc: part.partner_arc, gap: part.gap });
        }
        let zone = &mut zones[zone_of[first] as usize];
        zone.arc[1] = zone.arc[1].max(part.arc[1]);
        zone.partner_arc = [zone.partner_arc[0].min(part.partner_arc[0]), zone.partner_arc[1].max(part.partner_arc[1])];
        zone.gap = zone.gap.min(part.gap);
    }
    zones
}

/// All parts ordered by curve, partner, start, partner's start, end. Sorted by counting the segments they lie on, which
/// is the order along the curves but for ties at joints and several parts of one segment.
fn in_order(lists: &[Vec<Part>], num_segments: usize, workspace: &mut JoinBuffers) {
    let JoinBuffers { parts, place, .. } = workspace;
    place.clear();
    place.resize(num_segments + 1, 0);
    for part in lists.iter().flatten() {
        place[part.segment as usize + 1] += 1;
    }
    for k in 1..=num_segments {
        place[k] += place[k - 1];
    }
    let Some(any) = lists.iter().flatten().next() else { return parts.clear() };
    // Every place is written below.
    parts.resize(place[num_segments] as usize, *any);
    for part in lists.iter().flatten() {
        let next = &mut place[part.segment as usize];
        parts[*next as usize] = *part;
        *next += 1;
    }
    let along = |p: &Part, q: &Part| {
        p.arc[0]
            .total_cmp(&q.arc[0])
            .then(p.partner_arc[0].total_cmp(&q.partner_arc[0]))
            .then(p.arc[1].total_cmp(&q.arc[1]))
    };
    // Insertion sort: no part is far from its position.
    for k in 1..parts.len() {
        let mut m = k;
        while m > 0 && parts[m].curve == parts[m - 1].curve && along(&parts[m], &parts[m - 1]).is_lt() {
            parts.swap(m, m - 1);
            m -= 1;
        }
    }
    for curve in parts.chunk_by_mut(|p, q| p.curve == q.curve) {
        if curve.iter().any(|p| p.partner != curve[0].partner) {
            curve.sort_by_key(|p| p.partner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// The interval of a line within reach of a segment against sampling.
    #[test]
    fn intervals_match_sampling() {
        let mut numbers = Random(5);
        let mut random = || numbers.unit();
        let mut found = 0;
        for case in 0..4000 {
            let mut vector = || Vec3::new(random(), random(), random());
            let (d, mut e, r) = (vector() * 2.0, vector(), vector());
            match case % 5 {
                0 => e = d * 0.7,
                1 => e -= d * (e.dot(&d) / d.norm_squared()),
                _ => {}
            }
            let mut interval: Option<([f64; 2], [f64; 2])> = None;
            StraightPair { d, e, r }.intervals(0.6, &[None, None], |u, v| {
                assert!(interval.is_none());
                interval = Some((u, v));
            });
            for k in 0..=200 {
                let u = f64::from(k) / 200.0;
                let p = r + d * u;
                let distance = segment_distance(&p, &p, &Vec3::zeros(), &e);
                let inside = interval.is_some_and(|(u01, _)| u >= u01[0] && u <= u01[1]);
                assert!((distance - 0.6).abs() < 1e-12 || inside == (distance < 0.6), "case {case} u {u} {distance}");
            }
            found += usize::from(interval.is_some());
        }
        assert!(found > 1000);
    }
}
