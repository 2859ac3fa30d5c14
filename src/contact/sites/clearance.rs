//! Certified smallest clearance between curves: branch and bound over pairs of cubic pieces.
//!
//! Capsules discard far pairs. Along a line of contact, where the gap is nearly constant over many pieces, their error
//! (the bulge) would require millions of pieces; a bound of fourth order serves there. Let a(u) and b(v) be the pieces
//! and D(u, v) = |b(v) − a(u)|². If ½∂²D/∂v² ≥ m > 0 on the whole box (least Bernstein coefficient over the control
//! points of a), then for *any* map v = φ(u) into the box
//!
//! ```text
//!     min_v D(u, v) ≥ |w(u)|² − Q(u)²/m,   w(u) = b(φ(u)) − a(u),   Q(u) = w(u)·b′(φ(u)) = ½∂D/∂v at φ(u).
//! ```
//!
//! With φ linear between the feet of the piece's two ends w is a cubic, the minimum of |w|² is found by Bernstein
//! roots, and Q is a quintic that vanishes at both ends, so the error shrinks with the fourth power of the piece. Where
//! the foot runs against the end v = 0 or 1 of the box, φ is constant there and only the half of Q with the harmful
//! sign counts; pieces are cut where the foot reaches the end (roots of (b(v_end) − a(u))·b′(v_end)).

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use crate::contact::curves::curve::{Cubic, CurveSet};
use crate::contact::measures::{MAX_STEPS, SUM_ROUNDING};
use crate::contact::pairs::capsule::{Capsule, distance_lower_bound};
use crate::contact::projection::{Feet, end_is_local_min, local_minima};
use crate::contact::tree::broad_phase::BroadPhase;
use crate::contact::tree::exclusion::Exclusion;
use pieces::{PowerForm, at, extent, halves};

mod pieces;
#[cfg(test)]
mod tests;

/// Pieces examined per candidate pair, and in all at least, before the search ends with a wider interval, because a
/// line of contact that is level to rounding could be cut without end.
const BUDGET_PER_PAIR: usize = 2000;
const BUDGET_MIN: usize = 200_000;
/// Parts of the largest gap below which is looked, one after the other, because beside each other rods have a number of
/// pairs of segments that grows with the root of the ceiling, and only those near the smallest gap matter.
const CEILINGS: [f64; 3] = [1.0 / 256.0, 1.0 / 16.0, 1.0];
/// Distance beyond the smallest one known, over the radii, within which a place is tried, because a smaller known
/// distance leaves fewer pieces.
const NEARBY: f64 = 1e-3;
/// Halvings of a pair of pieces, at most, because the bounds of pieces that small are rounding.
const MAX_DEPTH: u32 = 40;
/// Halvings, at most, to decide whether pieces of one curve are neighbours, because 1/64 of a segment turns by little.
const MAX_STRADDLE: u32 = 6;

/// Certified smallest gap: the true one lies in [`lower`, `upper`] (centre distance minus both radii; negative =
/// overlap) \[L\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Nothing is closer than this.
    pub lower: f64,
    /// Gap at the points below.
    pub upper: f64,
    /// Segment (global index) and parameter of one point.
    pub segment_a: usize,
    /// Parameter on `segment_a`.
    pub u_a: f64,
    /// Segment of the other point.
    pub segment_b: usize,
    /// Parameter on `segment_b`.
    pub u_b: f64,
    /// Reference arc length \[L\] of the first point from the start of its curve.
    pub arc_a: f64,
    /// Reference arc length \[L\] of the second point.
    pub arc_b: f64,
}

/// Smallest gap between parts that are not neighbours, to within `tol` \[L\]; `None` if it is above `max_gap` \[L\]
/// (either answer is possible within `tol` of `max_gap`), if geometry or arguments are not finite, or if there is
/// nothing to compare.
///
/// Compares points of different curves, and points of one curve with at least π of total curvature (by the
/// control-polygon bound, resolved to 1/64 of a segment) between them both ways: points closer along the curve cannot
/// be a mutual closest pair (Fenchel). The open ends of a curve are also compared with their one-sided projections on
/// that curve, from π/2 of total curvature on.
///
/// Branch and bound, smallest lower bound first. The work is bounded (2000 pieces per candidate pair, at least 200
/// 000): when it runs out (the place may then be beyond `max_gap`), or `tol` is below rounding (about 1e-14 of the
/// squared segment size over the distance), the returned interval is wider than `tol` but still true. `exclusion` must
/// be up to date with `set`.
#[must_use]
pub fn smallest_clearance(set: &CurveSet, exclusion: &Exclusion, max_gap: f64, tol: f64) -> Option<Clearance> {
    if !max_gap.is_finite() || tol.is_nan() {
        return None;
    }
    let ceilings: &[f64] = if max_gap > 0.0 { &CEILINGS } else { &[1.0] };
    ceilings.iter().find_map(|part| clearance_below(set, exclusion, part * max_gap, tol))
}

/// Smallest gap below a ceiling.
fn clearance_below(set: &CurveSet, exclusion: &Exclusion, ceiling: f64, tol: f64) -> Option<Clearance> {
    let mut broad = BroadPhase::new();
    let pairs = broad.candidates(set, exclusion, ceiling, 0.0).ok()?;
    let mut search = ClearanceSearch {
        set,
        exclusion,
        best: None,
        upper: ceiling,
        tol: tol.max(0.0),
        heap: BinaryHeap::new(),
        dropped: f64::INFINITY,
    };
    search.open_ends(pairs);
    search.run(pairs)
}

/// A pair of pieces: part [u0, u1] of segment i against part [v0, v1] of segment j.
#[derive(Clone, Copy, Debug)]
struct Box2 {
    lower: f64,
    i: u32,
    j: u32,
    u: [f64; 2],
    v: [f64; 2],
    depth: u32,
    straddle: u32,
    /// Whether its lower bound is final.
    last: bool,
    /// Whether it has been cut where feet reach the ends of v.
    cut: bool,
}

impl PartialEq for Box2 {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Box2 {}
impl PartialOrd for Box2 {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Box2 {
    /// Smallest lower bound on top of the heap; ties are ordered by index, so that the search is deterministic.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .lower
            .total_cmp(&self.lower)
            .then_with(|| (other.i, other.j).cmp(&(self.i, self.j)))
            .then_with(|| other.u[0].total_cmp(&self.u[0]))
            .then_with(|| other.v[0].total_cmp(&self.v[0]))
    }
}

struct ClearanceSearch<'a> {
    set: &'a CurveSet,
    exclusion: &'a Exclusion,
    /// Segment and parameter of both points of the best gap found.
    best: Option<(usize, f64, usize, f64)>,
    /// Best gap found, or the caller's ceiling.
    upper: f64,
    tol: f64,
    heap: BinaryHeap<Box2>,
    /// Smallest lower bound of the pieces not pursued.
    dropped: f64,
}

/// Result of the neighbour test for a pair of pieces: all, a part or none of it is excluded.
enum ExcludedPart {
    Yes,
    Partly,
    No,
}

impl ClearanceSearch<'_> {
    fn run(&mut self, pairs: &[[u32; 2]]) -> Option<Clearance> {
        let (set, exclusion) = (self.set, self.exclusion);
        let capsules: Vec<Capsule> = set.segments.iter().map(Capsule::new).collect();
        let whole = |&[i, j]: &[u32; 2]| {
            let (a, b) = (i as usize, j as usize);
            let lower = capsules[a].distance_lower_bound(&capsules[b]) - (set.radius_of(a) + set.radius_of(b));
            let [u, v] = [[0.0, 1.0]; 2];
            Box2 { lower, i, j, u, v, depth: 0, straddle: 0, last: false, cut: false }
        };
        let apart = |[i, j]: &[u32; 2]| !exclusion.excluded_bilateral(*i as usize, *j as usize);
        let open = || pairs.iter().filter(|pair| apart(pair)).map(whole);
        // the nearest pair gives a gap above which the others need not be kept
        let nearest = open().max();
        if let Some(nearest) = nearest.filter(|piece| matches!(self.neighbours(piece), ExcludedPart::No)) {
            self.offer_at(&nearest, 0.5, 0.5);
        }
        let kept: Vec<Box2> = open().filter(|piece| piece.lower <= self.upper).collect();
        self.heap = kept.into();
        let mut budget = BUDGET_MIN.max(BUDGET_PER_PAIR.saturating_mul(pairs.len()));
        let mut lower = f64::INFINITY;
        while let Some(top) = self.heap.pop() {
            if budget == 0 && self.best.is_none() {
                // The result needs a pair of points, even one beyond the ceiling.
                self.upper = f64::INFINITY;
                self.offer_at(&top, 0.5, 0.5);
            }
            // All remaining pairs are at least as far as the top.
            if top.lower >= self.upper - self.tol || budget == 0 || top.last {
                lower = top.lower;
                break;
            }
            budget -= 1;
            self.refine(&top);
        }
        let (segment_a, u_a, segment_b, u_b) = self.best?;
        let arc = |s, u| self.set.arc_length(s, u);
        Some(Clearance {
            lower: lower.min(self.dropped).min(self.upper),
            upper: self.upper,
            segment_a,
            u_a,
            segment_b,
            u_b,
            arc_a: arc(segment_a, u_a),
            arc_b: arc(segment_b, u_b),
        })
    }

    fn radii(&self, i: usize, j: usize) -> f64 {
        self.set.radius_of(i) + self.set.radius_of(j)
    }

    fn offer(&mut self, gap: f64, place: (usize, f64, usize, f64)) {
        if gap < self.upper || (gap == self.upper && self.best.is_none()) {
            self.upper = gap;
            self.best = Some(place);
        }
    }

    /// Refines the point (u, v in \[0, 1\] of the pieces) and keeps its gap if it is the best.
    fn offer_at(&mut self, piece: &Box2, u: f64, v: f64) {
        let (i, j) = (piece.i as usize, piece.j as usize);
        let (distance, u, v) = self.polish(piece, at(piece.u, u), at(piece.v, v));
        self.offer(distance - self.radii(i, j), (i, u, j, v));
    }

    /// Ends of open curves against their own curve, exact; their feet need π/2 of total curvature only.
    fn open_ends(&mut self, pairs: &[[u32; 2]]) {
        let mut feet = Feet::new();
        for &[p, q] in pairs {
            let (p, q) = (p as usize, q as usize);
            if self.set.curve_of(p) != self.set.curve_of(q) {
                continue;
            }
            // p < q: only the start of the first segment and the end of the last can be open.
            for (end, u, other) in [(p, 0.0, q), (q, 1.0, p)] {
                let open = if u == 0.0 { self.set.prev(end).is_none() } else { self.set.next(end).is_none() };
                if !open {
                    continue;
                }
                let x = self.set.segments[end].b[if u == 0.0 { 0 } else { 3 }];
                let curve = &self.set.segments[other];
                let radii = self.radii(end, other);
                local_minima(curve, &x, self.upper + radii, &mut feet);
                let ends = [0.0, 1.0].into_iter().filter(|&v| end_is_local_min(curve, &x, v == 1.0));
                for v in feet.as_slice().iter().map(|f| f.u).chain(ends) {
                    if !self.exclusion.excluded_points(self.set, (end, u), (other, v)) {
                        let relative = Cubic { b: curve.b.map(|p| p - x) };
                        self.offer(relative.point(v).norm() - radii, (end, u, other, v));
                    }
                }
            }
        }
    }

    /// Replaces a pair of pieces by better bounded ones.
    fn refine(&mut self, top: &Box2) {
        let (i, j) = (top.i as usize, top.j as usize);
        match self.neighbours(top) {
            ExcludedPart::Yes => return,
            ExcludedPart::Partly if top.straddle < MAX_STRADDLE => {
                let next = Box2 { straddle: top.straddle + 1, depth: top.depth + 1, ..*top };
                for u in halves(top.u) {
                    for v in halves(top.v) {
                        self.push_capsule(Box2 { u, v, ..next });
                    }
                }
                return;
            }
            _ => {}
        }
        let local = PowerForm::new(&self.set.segments[i], &self.set.segments[j], top.u, top.v);
        let convexity = local.convexity();
        if convexity <= 0.0 || !convexity.is_finite() {
            self.split_box(top, &local);
            return;
        }
        if !top.cut {
            // The first refinement cuts where the foot meets an end of v and bounds each part.
            let mut cuts = local.foot_leaves();
            cuts.push(1.0);
            let mut start = 0.0;
            for end in cuts {
                if end > start {
                    let u = [at(top.u, start), if end == 1.0 { top.u[1] } else { at(top.u, end) }];
                    self.bound(&Box2 { u, cut: true, ..*top });
                }
                start = end;
            }
            return;
        }
        if top.depth >= MAX_DEPTH {
            self.heap.push(Box2 { last: true, ..*top });
            return;
        }
        for u in halves(top.u) {
            self.bound(&Box2 { u, depth: top.depth + 1, ..*top });
        }
    }

    /// Fourth-order bound of a pair of pieces convex in v; pushes it unless it cannot matter.
    fn bound(&mut self, piece: &Box2) {
        let (i, j) = (piece.i as usize, piece.j as usize);
        let radii = self.radii(i, j);
        let local = PowerForm::new(&self.set.segments[i], &self.set.segments[j], piece.u, piece.v);
        let bound = local.fourth_order(local.convexity());
        // Never below the known bound.
        let lower = (bound.lower - radii).max(piece.lower);
        if bound.at_place - radii < self.upper + self.tol.max(NEARBY * radii) {
            self.offer_at(piece, bound.u, bound.v);
        }
        self.push(Box2 { lower, ..*piece });
    }

    /// Halves the longer of the two pieces.
    fn split_box(&mut self, top: &Box2, local: &PowerForm) {
        self.offer_at(top, 0.5, 0.5);
        if top.depth >= MAX_DEPTH {
            self.heap.push(Box2 { last: true, ..*top });
            return;
        }
        let next = Box2 { depth: top.depth + 1, ..*top };
        if extent(&local.a) >= extent(&local.b) {
            halves(top.u).into_iter().for_each(|u| self.push_capsule(Box2 { u, ..next }));
        } else {
            halves(top.v).into_iter().for_each(|v| self.push_capsule(Box2 { v, ..next }));
        }
    }

    fn push_capsule(&mut self, piece: Box2) {
        let (i, j) = (piece.i as usize, piece.j as usize);
        let local = PowerForm::new(&self.set.segments[i], &self.set.segments[j], piece.u, piece.v);
        let lower = (distance_lower_bound(&local.a, &local.b) * local.scale - self.radii(i, j)).max(piece.lower);
        self.push(Box2 { lower, ..piece });
    }

    /// Keeps a pair of pieces only if it can still lower the result by more than `tol`.
    fn push(&mut self, piece: Box2) {
        if piece.lower < self.upper - self.tol {
            self.heap.push(piece);
        } else {
            self.dropped = self.dropped.min(piece.lower);
        }
    }

    /// Whether less than π of total curvature lies between all (some, no) points of the two pieces.
    fn neighbours(&self, piece: &Box2) -> ExcludedPart {
        let (i, j) = (piece.i as usize, piece.j as usize);
        if self.set.curve_of(i) != self.set.curve_of(j) {
            return ExcludedPart::No;
        }
        if self.exclusion.turns_between_at_least(self.set, i, j, PI) {
            return ExcludedPart::No;
        }
        let turning = |from, to| self.exclusion.turning_between(self.set, from, to);
        let (u, v) = (piece.u, piece.v);
        if turning((i, u[0]), (j, v[1])) < PI || turning((j, v[0]), (i, u[1])) < PI {
            ExcludedPart::Yes
        } else if turning((i, u[1]), (j, v[0])) < PI || turning((j, v[1]), (i, u[0])) < PI {
            ExcludedPart::Partly
        } else {
            ExcludedPart::No
        }
    }

    /// Newton's method for the distance inside the box from (u, v), with alternating projections where it fails; never
    /// farther than the start.
    fn polish(&self, piece: &Box2, u: f64, v: f64) -> (f64, f64, f64) {
        let origin = self.set.segments[piece.j as usize].b[0];
        let shift = |c: &Cubic| Cubic { b: c.b.map(|p| p - origin) };
        let (a, b) = (shift(&self.set.segments[piece.i as usize]), shift(&self.set.segments[piece.j as usize]));
        let clamp = |t: f64, range: [f64; 2]| t.clamp(range[0], range[1]);
        let (mut u, mut v) = (u, v);
        let mut distance = (b.point(v) - a.point(u)).norm();
        for _ in 0..MAX_STEPS {
            let ((pa, da, dda), (pb, db, ddb)) = (a.derivatives(u), b.derivatives(v));
            let w = pb - pa;
            let (gu, gv) = (-w.dot(&da), w.dot(&db));
            let (huu, hvv, huv) = (da.dot(&da) - w.dot(&dda), db.dot(&db) + w.dot(&ddb), -da.dot(&db));
            let det = huu * hvv - huv * huv;
            let newton = if det > SUM_ROUNDING * huu.abs() * hvv.abs() && huu > 0.0 {
                (clamp(u - (hvv * gu - huv * gv) / det, piece.u), clamp(v - (huu * gv - huv * gu) / det, piece.v))
            } else {
                // Flat along the line: projection only.
                (u, clamp(v - gv / hvv.abs().max(f64::MIN_POSITIVE), piece.v))
            };
            let next = (b.point(newton.1) - a.point(newton.0)).norm();
            if next >= distance || next.is_nan() {
                break;
            }
            (u, v, distance) = (newton.0, newton.1, next);
        }
        (distance, u, v)
    }
}
