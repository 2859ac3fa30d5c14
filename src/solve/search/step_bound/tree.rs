//! Which fraction of a step lets no strand pass another: branch and bound over a tree of runs of segments.
//!
//! The tree halves each curve into runs. A pair of runs needs no further look if its largest approach, times the best
//! fraction known, is less than the distance of its boxes. Nor does it if both belong to one curve and the arc over
//! both cannot close: where a curve meets itself, the arc between is a loop with one corner, and such a loop turns by π
//! at least (Fenchel). The turning on the way is at most that of the present plus the relative rotations of the step,
//! so straight stretches cost nothing however far they swing. The result is the minimum over pairs of segments,
//! whatever the order in which they are met.

use std::f64::consts::PI;

use super::{Keep, SegmentMotion, relative_motion};
use crate::contact::capsule::{Capsule, distance_lower_bound_within};
use crate::contact::curve::CurveSet;
use crate::contact::exclusion::Exclusion;
use crate::math::{Vec3, parallel};
use crate::solve::measures::{ARC, AT_ONCE, ROUNDING};

/// Accuracy of bounds of the gap, over the part of the contact distance that is kept.
const BOUND_ACCURACY: f64 = 0.1;

/// Segments of the smallest runs.
const RUN: usize = 4;

/// A run of segments, or of whole curves.
struct SegmentRun {
    first: usize,
    end: usize,
    /// The curve, if it is one.
    curve: Option<usize>,
    /// The second of both parts; the first is the next run of the list. 0: no parts.
    second: usize,
    /// Box of the control points \[L\].
    bounds: [Vec3; 2],
    /// Box of their linear motions \[L\].
    motion: [Vec3; 2],
    second_order: f64,
    radius: f64,
}

/// Everything a step bound looks at.
pub(super) struct PassageTree<'a> {
    set: &'a CurveSet,
    exclusion: &'a Exclusion,
    motions: &'a [SegmentMotion],
    capsules: Vec<Capsule>,
    /// Turning on the way, accumulated along each curve: to the start and to the end of each segment, and per curve in
    /// all.
    turning: Vec<[f64; 2]>,
    totals: Vec<f64>,
    runs: Vec<SegmentRun>,
    keep: Keep,
}

impl<'a> PassageTree<'a> {
    /// `relative` are the relative rotations of the ends of each segment, rad; `exclusion` is that of the present
    /// geometry.
    pub(super) fn new(
        set: &'a CurveSet,
        exclusion: &'a Exclusion,
        motions: &'a [SegmentMotion],
        relative: &[f64],
        keep: Keep,
    ) -> Self {
        let capsules = parallel::map(set.segments.len(), parallel::CHEAP, &|k| Capsule::new(&set.segments[k]));
        let mut turning = Vec::with_capacity(set.len());
        let mut totals = Vec::with_capacity(set.curves.len());
        for (index, curve) in set.curves.iter().enumerate() {
            let mut added = 0.0;
            for k in curve.first..curve.first + curve.count {
                let [start, end] = exclusion.turning_at(k);
                turning.push([start + added, end + added + relative[k]]);
                added += relative[k];
            }
            totals.push(exclusion.turning_of(index) + added);
        }
        let runs = Vec::with_capacity(2 * set.len().div_ceil(RUN) + 2 * set.curves.len());
        let mut tree = Self { set, exclusion, motions, capsules, turning, totals, runs, keep };
        tree.add_curves(0, set.curves.len());
        tree
    }

    /// Appends the runs of the curves from `first` to before `end`, the run of all of them first; its index.
    fn add_curves(&mut self, first: usize, end: usize) -> usize {
        if end - first == 1 {
            let curve = &self.set.curves[first];
            return self.add_segments(first, curve.first, curve.first + curve.count);
        }
        let at = self.reserve(None, self.set.curves[first].first, 0);
        let middle = first + (end - first) / 2;
        let a = self.add_curves(first, middle);
        let b = self.add_curves(middle, end);
        self.join(at, a, b);
        at
    }

    fn add_segments(&mut self, curve: usize, first: usize, end: usize) -> usize {
        let at = self.reserve(Some(curve), first, end);
        if end - first > RUN {
            // all runs but the last are full
            let middle = first + (end - first).div_ceil(2).next_multiple_of(RUN);
            let a = self.add_segments(curve, first, middle);
            let b = self.add_segments(curve, middle, end);
            self.join(at, a, b);
            return at;
        }
        let run = &mut self.runs[at];
        for k in first..end {
            widen(&mut run.bounds, &self.set.segments[k].b);
            widen(&mut run.motion, &self.motions[k].linear);
            run.second_order = run.second_order.max(self.motions[k].second_order);
            run.radius = run.radius.max(self.set.radius_of(k));
        }
        at
    }

    fn reserve(&mut self, curve: Option<usize>, first: usize, end: usize) -> usize {
        let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
        let (second_order, radius) = (0.0, 0.0);
        let run = SegmentRun { first, end, curve, second: 0, bounds: nothing, motion: nothing, second_order, radius };
        self.runs.push(run);
        self.runs.len() - 1
    }

    fn join(&mut self, at: usize, a: usize, b: usize) {
        for part in [a, b] {
            let SegmentRun { end, bounds, motion, second_order, radius, .. } = self.runs[part];
            let run = &mut self.runs[at];
            widen(&mut run.bounds, &bounds);
            widen(&mut run.motion, &motion);
            run.second_order = run.second_order.max(second_order);
            run.radius = run.radius.max(radius);
            run.end = end;
        }
        self.runs[at].second = b;
    }

    /// Largest t ≤ 1 for which no pair of strands comes nearer than is to be kept.
    pub(super) fn fraction(&self) -> f64 {
        // a small set is not shared out: deepest first a small fraction, which spares other pairs a look, is known
        // sooner
        let enough = if self.set.len() <= AT_ONCE { usize::MAX } else { AT_ONCE };
        // shares are the same for any number of threads, and so is the minimum
        let (shares, t) = self.descend(vec![[0, 0]], enough, 1.0);
        let fractions = parallel::map(shares.len(), 1, &|k| self.descend(vec![shares[k]], usize::MAX, t).1);
        fractions.into_iter().fold(t, f64::min)
    }

    /// Works off pairs of runs, deepest first, until none is left; or, broadest first, until `enough` are open. Those
    /// and the fraction so far.
    fn descend(&self, mut open: Vec<[usize; 2]>, enough: usize, mut t: f64) -> (Vec<[usize; 2]>, f64) {
        let mut at = 0;
        while at < open.len() && open.len() - at < enough {
            let [a, b] = if enough == usize::MAX {
                match open.pop() {
                    Some(pair) => pair,
                    None => break,
                }
            } else {
                at += 1;
                open[at - 1]
            };
            let (p, q) = (&self.runs[a], &self.runs[b]);
            if self.cannot_close(p, q) || a != b && self.far_apart(p, q, t) {
                continue;
            }
            if a == b {
                if p.second == 0 {
                    t = self.within(p, t);
                } else {
                    open.extend([[a + 1, a + 1], [p.second, p.second], [a + 1, p.second]]);
                }
            } else if p.second == 0 && q.second == 0 {
                t = self.between(p, q, t);
            } else if q.second == 0 || p.second != 0 && p.end - p.first >= q.end - q.first {
                open.extend([[a + 1, b], [p.second, b]]);
            } else {
                open.extend([[a, b + 1], [a, q.second]]);
            }
        }
        (open.split_off(at.min(open.len())), t)
    }

    fn cannot_close(&self, p: &SegmentRun, q: &SegmentRun) -> bool {
        let (Some(curve), true) = (p.curve, p.curve == q.curve) else { return false };
        self.arc_is_open(curve, p.first, q.end - 1)
            || p.end <= q.first && self.arc_around_is_open(curve, p.end - 1, q.first)
    }

    /// Whether the arc from the start of segment i to the end of segment j ≥ i turns by too little to close it: by less
    /// than π minus the turning of cubics beyond that of the frames at their nodes.
    fn arc_is_open(&self, curve: usize, i: usize, j: usize) -> bool {
        self.turning[j][1] - self.turning[i][0] < PI - ARC - self.rounding(curve)
    }

    /// Whether the arc of a closed curve from the start of segment j through the seam to the end of segment i < j does.
    fn arc_around_is_open(&self, curve: usize, i: usize, j: usize) -> bool {
        let around = self.turning[i][1] + self.totals[curve] - self.turning[j][0];
        self.set.curves[curve].closed && around < PI - ARC - self.rounding(curve)
    }

    fn rounding(&self, curve: usize) -> f64 {
        ROUNDING * (1.0 + self.totals[curve])
    }

    fn far_apart(&self, p: &SegmentRun, q: &SegmentRun, t: f64) -> bool {
        let apart = |[lo, hi]: &[Vec3; 2], [other_lo, other_hi]: &[Vec3; 2]| {
            (lo - other_hi).sup(&(other_lo - hi)).sup(&Vec3::zeros()).norm()
        };
        let ([lo, hi], [other_lo, other_hi]) = (&p.motion, &q.motion);
        let approach = (hi - other_lo).sup(&(other_hi - lo)).norm() + p.second_order + q.second_order;
        approach * t <= self.allowed(apart(&p.bounds, &q.bounds), p.radius + q.radius)
    }

    /// Part of its distance that a pair may lose.
    fn allowed(&self, distance: f64, contact_distance: f64) -> f64 {
        (distance - self.keep.distance * contact_distance).max(self.keep.deep * distance)
    }

    fn within(&self, run: &SegmentRun, mut t: f64) -> f64 {
        for i in run.first..run.end {
            for j in i + 1..run.end {
                t = self.pair(i, j, t);
            }
        }
        t
    }

    fn between(&self, p: &SegmentRun, q: &SegmentRun, mut t: f64) -> f64 {
        for i in p.first..p.end {
            for j in q.first..q.end {
                t = self.pair(i, j, t);
            }
        }
        t
    }

    /// The fraction t, or less if this pair needs it.
    fn pair(&self, i: usize, j: usize, t: f64) -> f64 {
        let set = self.set;
        if set.next(i) == Some(j) || set.next(j) == Some(i) || self.exclusion.are_joined(i, j) {
            // joined for good; the limit on rotations keeps them from folding
            return t;
        }
        let approach = relative_motion(&self.motions[i], &self.motions[j]);
        let contact_distance = set.radius_of(i) + set.radius_of(j);
        let (a, b) = (&self.capsules[i], &self.capsules[j]);
        let mut allowed = self.allowed(a.distance_lower_bound(b), contact_distance);
        // How well the distance of a pair that could meet is known: a segment of a thin rod bulges by much more than
        // its thickness, with that for an error no step near contact would be left.
        let tol = BOUND_ACCURACY * self.keep.distance * contact_distance;
        if approach * t <= allowed {
            return t;
        }
        let curve = set.curve_of(i);
        if curve == set.curve_of(j) && (self.arc_is_open(curve, i, j) || self.arc_around_is_open(curve, i, j)) {
            return t;
        }
        if a.bulge + b.bulge > tol {
            let distance = distance_lower_bound_within(&set.segments[i], &set.segments[j], tol);
            allowed = self.allowed(distance, contact_distance);
        }
        if approach * t > allowed { allowed / approach } else { t }
    }
}

#[cfg(test)]
impl PassageTree<'_> {
    /// The same by looking at every pair of segments.
    pub(super) fn fraction_by_all_pairs(&self) -> f64 {
        let n = self.set.len();
        (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).fold(1.0, |t, (i, j)| self.pair(i, j, t))
    }
}

fn widen(bounds: &mut [Vec3; 2], points: &[Vec3]) {
    for point in points {
        bounds[0] = bounds[0].inf(point);
        bounds[1] = bounds[1].sup(point);
    }
}
