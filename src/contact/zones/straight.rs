//! Contact zones of a pair of straight segments in closed form, as [`SegmentPair`](super::SegmentPair) for cubics.
//!
//! ```text
//!  slave   a(u) = a₀ + u d        foot   v(u) = e·(r + u d)/e²
//!  from foot to slave point   x + u y   (orthogonal to e)
//!  master  b(v) = b₀ + v e        r = a₀ − b₀                         x = r − e (e·r)/e²,  y = d − e (e·d)/e²
//! ```
//!
//! At a kink the wedge between the planes orthogonal to both segments belongs to the corner itself: on the outside it
//! is the nearest point, on the inside a point between two feet that is subtracted.
//!
//! The foot leaves the master where a linear function of u vanishes, the distance passes the reach at the roots of a
//! quadratic.

use super::{Branch, BranchPiece, FootKind, NARROW, Projection, Sample, unit};
use crate::contact::curves::input::Strands;
use crate::contact::projection::same_direction;
use crate::math::Vec3;

/// A straight slave and a straight master, with the directions of the master's curve beyond its ends.
pub(in crate::contact) struct Lines {
    d: Vec3,
    e: Vec3,
    /// v(u) = `foot[0]` + u `foot[1]`.
    foot: [f64; 2],
    /// x and y.
    beside: [Vec3; 2],
    /// From the master's start and end to the slave's start.
    from: [Vec3; 2],
    /// On which side of the master's start and end the foot is: sign of c + u k, positive towards the end.
    sides: [[f64; 2]; 2],
    /// Whether the curve continues straight at this end. A foot there belongs to the later segment.
    joined: [bool; 2],
    open: [bool; 2],
    /// The same sign functions by the tangent of the curve beyond the end, at the kinks that this pair counts.
    kinks: [Option<[f64; 2]>; 2],
    reach: f64,
}

impl Lines {
    /// Two straight segments and a uniform reach \[L\]; `kinks`: the ends of the master whose kink counts here.
    pub(in crate::contact) fn new(
        strands: &Strands,
        slave: usize,
        master: usize,
        reach: f64,
        kinks: [bool; 2],
    ) -> Self {
        let ((a0, a1), (b0, b1)) = (strands.ends(slave), strands.ends(master));
        let (d, e, from) = (a1 - a0, b1 - b0, [a0 - b0, a0 - b1]);
        let beyond = [strands.prev(master), strands.next(master)];
        let ee = e.norm_squared();
        let foot = [e.dot(&from[0]) / ee, e.dot(&d) / ee];
        let mut lines = Self {
            d,
            e,
            foot,
            beside: [from[0] - e * foot[0], d - e * foot[1]],
            from,
            sides: [[0.0; 2]; 2],
            joined: [false; 2],
            open: beyond.map(|k| k.is_none()),
            kinks: [None; 2],
            reach,
        };
        for k in 0..2 {
            let chord = beyond[k].map(|k| strands.ends(k)).map(|(start, end)| end - start);
            let joint = [b0, b1][k];
            lines.joined[k] = chord.is_some_and(|chord| {
                let (first, second) = if k == 0 { (&chord, &e) } else { (&e, &chord) };
                same_direction(first, second, joint.amax())
            });
            // Both segments at a joint use the tangent of the first: the same bits.
            let tangent = if k == 0 && lines.joined[0] { chord.unwrap_or(e) } else { e };
            lines.sides[k] = lines.side(k, &tangent);
            if kinks[k] && !lines.joined[k] {
                lines.kinks[k] = chord.map(|chord| lines.side(k, &chord));
            }
        }
        lines
    }

    /// The sign function of one end. Values within rounding count as a foot on the joint.
    fn side(&self, k: usize, tangent: &Vec3) -> [f64; 2] {
        let (start, slope) = (self.from[k].dot(tangent), self.d.dot(tangent));
        if !self.joined[k] {
            return [start, slope];
        }
        let noise = 8.0 * f64::EPSILON * self.from[k].amax().max(self.d.amax()) * tangent.amax();
        if start.abs() <= noise && (start + slope).abs() <= noise { [0.0; 2] } else { [start, slope] }
    }

    /// All pieces of this pair: those of feet ascending in u, then those of kinks.
    pub(in crate::contact) fn pieces(&self, mut push: impl FnMut(BranchPiece)) {
        let [[s0, k0], [s1, k1]] = self.sides;
        let whole = [0.0, 1.0];
        // Feet of this pair lie after the start and before the end, not on the joint at the end or on a kink.
        let resting = |k: usize, joined: bool| self.sides[k] == [0.0; 2] && !joined;
        let empty = [1.0, 0.0];
        let mut middle = cut(cut(whole, s0, k0), -s1, -k1);
        if resting(0, self.joined[0]) || resting(1, false) {
            middle = empty;
        }
        let start = if self.open[0] { cut(whole, -s0, -k0) } else { empty };
        let end = if self.open[1] { cut(whole, s1, k1) } else { empty };
        let mut ranges = [(start, FootKind::Start), (middle, FootKind::Orthogonal), (end, FootKind::End)];
        if self.foot[1] < 0.0 {
            ranges.swap(0, 2);
        }
        for (range, kind) in ranges {
            self.within_reach(range, kind, 1.0, &mut push);
        }
        for (k, kind) in [FootKind::Start, FootKind::End].into_iter().enumerate() {
            let Some(beyond) = self.kinks[k] else { continue };
            let [before, after] = if k == 0 { [beyond, self.sides[0]] } else { [self.sides[1], beyond] };
            // Usual case: past the corner, or before it, by both tangents at both ends of the slave.
            let ends = |[start, slope]: [f64; 2]| [start, start + slope];
            let ([b0, b1], [a0, a1]) = (ends(before), ends(after));
            if (b0 >= 0.0 || b1 >= 0.0) && (a0 <= 0.0 || a1 <= 0.0) {
                let outside = cut(cut(whole, before[0], before[1]), -after[0], -after[1]);
                self.within_reach(outside, kind, 1.0, &mut push);
            }
            if (b0 < 0.0 || b1 < 0.0) && (a0 > 0.0 || a1 > 0.0) {
                let inside = cut(cut(whole, -before[0], -before[1]), after[0], after[1]);
                self.within_reach(inside, kind, -1.0, &mut push);
            }
        }
    }

    fn within_reach(&self, range: [f64; 2], kind: FootKind, sign: f64, push: &mut impl FnMut(BranchPiece)) {
        // Written so that NaN is an empty range.
        let wide = range[1] - range[0] > NARROW;
        if !wide {
            return;
        }
        let [x, y] = self.connection(kind);
        let Some(inside) = chord(&x, &y, self.reach) else { return };
        let u = [inside[0].max(range[0]), inside[1].min(range[1])];
        if u[1] > u[0] {
            // Parallel lines have a constant distance.
            let nearest = if inside[0].is_finite() { 0.5 * (inside[0] + inside[1]) } else { u[0] };
            let nearest = nearest.clamp(u[0], u[1]);
            let branch = Branch::of(kind, sign);
            push(BranchPiece { u, v: u.map(|u| self.foot(u, kind)), branch, nearest: self.sample(nearest, kind) });
        }
    }

    /// From foot to slave point as x + u y.
    fn connection(&self, kind: FootKind) -> [Vec3; 2] {
        match kind {
            FootKind::Orthogonal | FootKind::Fold | FootKind::Held => self.beside,
            FootKind::Start => [self.from[0], self.d],
            FootKind::End => [self.from[1], self.d],
        }
    }

    fn foot(&self, u: f64, kind: FootKind) -> f64 {
        match kind {
            FootKind::Orthogonal | FootKind::Fold | FootKind::Held => (self.foot[0] + u * self.foot[1]).clamp(0.0, 1.0),
            FootKind::Start => 0.0,
            FootKind::End => 1.0,
        }
    }

    fn sample(&self, u: f64, kind: FootKind) -> Sample {
        let [x, y] = self.connection(kind);
        let w = x + y * u;
        let distance = w.norm();
        let slope = w.dot(&y) / distance;
        let curvature = (y.norm_squared() - slope * slope) / distance;
        Sample { u, v: self.foot(u, kind), distance, t: u, rate: 1.0, slope, curvature }
    }

    /// The projection of the slave's point at parameter `u`, and its sign in the potential.
    pub(in crate::contact) fn project(&self, u: f64, branch: &Branch) -> (Projection, f64) {
        let [x, y] = self.connection(branch.kind);
        let w = x + y * u;
        let distance = w.norm();
        let v = self.foot(u, branch.kind);
        let project =
            Projection { u, v, distance, normal: unit(&w, distance), tangent: self.e, curvature: Vec3::zeros() };
        (project, branch.sign)
    }
}

/// The part of a range with c + u k ≥ 0; empty (its end before its start) if there is none.
pub(in crate::contact) fn cut(range: [f64; 2], c: f64, k: f64) -> [f64; 2] {
    let root = -c / k;
    if k > 0.0 {
        [range[0].max(root), range[1]]
    } else if k < 0.0 {
        [range[0], range[1].min(root)]
    } else if c >= 0.0 {
        range
    } else {
        [1.0, 0.0]
    }
}

/// {u : |x + u y| ≤ reach}, for a reach of at least 0.
pub(in crate::contact) fn chord(x: &Vec3, y: &Vec3, reach: f64) -> Option<[f64; 2]> {
    let yy = y.norm_squared();
    if yy == 0.0 {
        return (x.norm_squared() <= reach * reach).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let middle = -x.dot(y) / yy;
    let left = reach * reach - (x + y * middle).norm_squared();
    let half = (left.max(0.0) / yy).sqrt();
    (left >= 0.0).then_some([middle - half, middle + half])
}
