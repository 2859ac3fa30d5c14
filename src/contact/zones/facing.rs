//! Pairs of cubics where no point of the slave has more than one foot on the master: the results of [`SegmentPair`] for
//! a fraction of its work.
//!
//! With D(u, v) = ½|b(v) − a(u)|² the foot v(u) is a root of D_v. If D_vv > 0 on the whole square \[0, 1\]², shown by
//! its Bernstein coefficients, there is at most one for every u, so Newton's method needs no certificate. There is a
//! foot where the slave's point lies after the master's start and before its end. As in
//! [`clearance`](crate::contact::sites::clearance), with any map φ(u) into \[0, 1\], w(u) = a(u) − b(φ(u)) and Q(u) =
//! w·b′(φ(u)),
//!
//! ```text
//!     |w(u)|² − Q(u)²/min D_vv  ≤  d(u)²  ≤  |w(u)|²
//! ```
//!
//! With φ linear between the feet of the ends, |w|² is of degree six. Its coefficients usually show that a slave is
//! within reach throughout, or nowhere. [`SegmentPair`] handles the other pairs, folds and open ends.

use super::{Branch, BranchPiece, FootSide, NARROW, Projection, Sample, SegmentPair, unit};
use crate::contact::curves::curve::Cubic;
use crate::contact::curves::input::JOINT;
use crate::contact::measures::{COINCIDENT, LAST_STEP, MAX_STEPS, SUM_ROUNDING};
use crate::math::Vec3;
use crate::math::bernstein::{Roots, product_with_quadratic, roots};

/// Smallest ratio of the least D_vv to the largest, because below it feet move fast and Newton's method converges late.
const CONVEX: f64 = 0.05;

/// A master with D_vv > 0 for all points of a slave.
pub(in crate::contact) struct Facing {
    /// b(v) = Σ `power[k]` vᵏ.
    power: [Vec3; 4],
    /// Lower bound of D_vv \[L²\].
    convexity: f64,
    /// Whether the whole slave lies before the start, or beyond the end, of the master.
    misses: [bool; 2],
}

/// A foot with the master's first and second derivative.
struct FootDerivatives {
    v: f64,
    point: Vec3,
    tangent: Vec3,
    curvature: Vec3,
}

impl Facing {
    /// `None` if the bounds do not show D_vv > 0.
    pub(in crate::contact) fn new(slave: &Cubic, master: &Cubic) -> Option<Self> {
        let (b, e) = (&master.b, master.edges());
        let [least, most] = convexity(slave, master);
        let plain = least > CONVEX * most.max(-least) && most.is_finite();
        plain.then(|| Self {
            power: [b[0], e[0] * 3.0, (e[1] - e[0]) * 3.0, e[2] - e[1] * 2.0 + e[0]],
            convexity: 15.0 * least,
            misses: [beyond(slave, &b[0], &-e[0]), beyond(slave, &b[3], &e[2])],
        })
    }

    /// Whether the whole slave clearly lies before the start, or beyond the end, of the master.
    pub(in crate::contact) fn misses(&self) -> [bool; 2] {
        self.misses
    }

    /// The foot of x near `guess`; `None` if Newton's method does not find it on the master.
    fn foot(&self, x: &Vec3, guess: f64) -> Option<FootDerivatives> {
        let [c0, c1, c2, c3] = &self.power;
        let mut v = guess.clamp(0.0, 1.0);
        for _ in 0..MAX_STEPS {
            let point = c0 + (c1 + (c2 + c3 * v) * v) * v;
            let tangent = c1 + (c2 * 2.0 + c3 * (3.0 * v)) * v;
            let curvature = c2 * 2.0 + c3 * (6.0 * v);
            let chord = x - point;
            let step = chord.dot(&tangent) / (tangent.norm_squared() - chord.dot(&curvature));
            let next = (v + step).clamp(0.0, 1.0);
            let step = next - v;
            v = next;
            if step.abs() <= LAST_STEP {
                // the rest of the Taylor series is below rounding
                let point = point + (tangent + curvature * (0.5 * step)) * step;
                return Some(FootDerivatives {
                    v,
                    point,
                    tangent: tangent + curvature * step,
                    curvature: curvature + c3 * (6.0 * step),
                });
            }
        }
        None
    }

    /// [`SegmentPair::project`] of an orthogonal branch.
    pub(in crate::contact) fn project(&self, pair: &SegmentPair, u: f64, guess: f64) -> Projection {
        let a = pair.slave.point(u);
        let Some(FootDerivatives { v, point, tangent, curvature }) = self.foot(&a, guess) else {
            return pair.project(u, guess, &Branch::ONLY).0;
        };
        let chord = a - point;
        let distance = chord.norm();
        Projection { u, v, distance, normal: unit(&chord, distance), tangent, curvature }
    }

    /// [`SegmentPair::pieces`] of this pair; false if the bounds do not decide and the general method is needed.
    /// Without `nearest`, [`BranchPiece::nearest`] is an end of the piece. The master must continue before its start
    /// and beyond its end.
    pub(in crate::contact) fn pieces(&self, pair: &SegmentPair, nearest: bool, out: &mut Vec<BranchPiece>) -> bool {
        let Some([start, end]) = between(&pair.sides()) else { return false };
        if end - start <= NARROW {
            return true;
        }
        let middle = 0.5 * (start + end);
        let (x, dx, _) = pair.slave.derivatives(middle);
        let chord = pair.master.chord();
        let guess = (x - pair.master.b[0]).dot(&chord) / chord.norm_squared();
        let Some(foot) = self.foot(&x, guess) else { return false };
        if !(JOINT..=1.0 - JOINT).contains(&foot.v) {
            return false;
        }
        if !nearest {
            let rate = dx.dot(&foot.tangent) / (foot.tangent.norm_squared() - (x - foot.point).dot(&foot.curvature));
            let at = |u: f64| self.sample(pair, u, foot.v + rate * (u - middle));
            let (Some(first), Some(last)) = (at(start), at(end)) else { return false };
            match self.in_reach(pair, &first, &last) {
                Some(true) => {
                    let nearest = if first.distance <= last.distance { first } else { last };
                    let (u, v) = ([start, end], [first.v, last.v]);
                    out.push(BranchPiece { u, v, branch: Branch::ONLY, nearest });
                    return true;
                }
                Some(false) => return true,
                None => {}
            }
        }
        pair.branch([start, end], foot.v, Branch::ONLY, out);
        true
    }

    fn sample(&self, pair: &SegmentPair, u: f64, guess: f64) -> Option<Sample> {
        let a = pair.slave.point(u);
        let foot = self.foot(&a, guess)?;
        let distance = (a - foot.point).norm();
        Some(Sample { u, v: foot.v, distance, t: u, rate: 1.0, slope: f64::NAN, curvature: f64::NAN })
    }

    /// Whether the slave is within reach throughout between two samples (true) or nowhere (false); `None` if the bounds
    /// do not decide.
    fn in_reach(&self, pair: &SegmentPair, first: &Sample, last: &Sample) -> Option<bool> {
        let (a, b) = (pair.slave.restrict(first.u, last.u), pair.master.restrict(first.v, last.v));
        let w: [Vec3; 4] = std::array::from_fn(|k| a.b[k] - b.b[k]);
        let d = |i: usize, j: usize| w[i].dot(&w[j]);
        let squares = [
            d(0, 0),
            d(0, 1),
            (2.0 * d(0, 2) + 3.0 * d(1, 1)) / 5.0,
            (d(0, 3) + 9.0 * d(1, 2)) / 10.0,
            (2.0 * d(1, 3) + 3.0 * d(2, 2)) / 5.0,
            d(2, 3),
            d(3, 3),
        ];
        let (least, largest) = squares.iter().fold((f64::INFINITY, 0.0f64), |(lo, hi), &c| (lo.min(c), hi.max(c)));
        let reach = [pair.reach_at(first.u), pair.reach_at(last.u)];
        let (shortest, longest) = (reach[0].min(reach[1]), reach[0].max(reach[1]));
        if shortest > 0.0 && largest < shortest * shortest * (1.0 - SUM_ROUNDING) {
            return Some(true);
        }
        if least <= longest * longest {
            return None;
        }
        // ⟨w, b′⟩ in degree five, b′ by the parameter of the master
        let [_, c1, c2, c3] = &self.power;
        let (v, mean) = ([first.v, last.v], 0.5 * (first.v + last.v));
        let blossom = |mean: f64, product: f64| c1 + c2 * (2.0 * mean) + c3 * (3.0 * product);
        let slope = [blossom(v[0], v[0] * v[0]), blossom(mean, v[0] * v[1]), blossom(v[1], v[1] * v[1])];
        let products = product_with_quadratic(|i, j| w[i].dot(&slope[j]));
        let harm = products.iter().fold(0.0f64, |most, c| most.max(c.abs()));
        (least * (1.0 - SUM_ROUNDING) - harm * harm / self.convexity > longest * longest).then_some(false)
    }
}

/// Bounds of D_vv/15 \[L²\], by Bernstein coefficients: (b − x)·b′/3 = own − foreign·x of degree five, x at the slave's
/// control points.
pub(super) fn convexity(slave: &Cubic, master: &Cubic) -> [f64; 2] {
    let (b, e) = (&master.b, master.edges());
    let own = product_with_quadratic(|i, j| b[i].dot(&e[j]));
    let foreign = [
        e[0],
        (e[1] * 2.0 + e[0] * 3.0) / 5.0,
        (e[2] + e[1] * 6.0 + e[0] * 3.0) / 10.0,
        (e[2] * 3.0 + e[1] * 6.0 + e[0]) / 10.0,
        (e[2] * 3.0 + e[1] * 2.0) / 5.0,
        e[2],
    ];
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..5 {
        let (constant, slope) = (own[k + 1] - own[k], foreign[k + 1] - foreign[k]);
        for x in &slave.b {
            let value = constant - slope.dot(x);
            least = least.min(value);
            most = most.max(value);
        }
    }
    [least, most]
}

/// Whether the whole curve lies clearly beyond a point along a direction.
fn beyond(curve: &Cubic, point: &Vec3, along: &Vec3) -> bool {
    let least = COINCIDENT * COINCIDENT * along.norm_squared();
    curve.b.iter().all(|p| {
        let from = p - point;
        let way = from.dot(along);
        way > 0.0 && way * way > least * from.norm_squared()
    })
}

/// The interval of slave parameters after the master's start and before its end; of no width if it is empty. `None`
/// unless the signs of the coefficients show that it is one interval.
fn between(sides: &[FootSide; 2]) -> Option<[f64; 2]> {
    let mut range = [0.0f64, 1.0f64];
    for (k, side) in sides.iter().enumerate() {
        let c = &side.coefficients;
        // the interval is where the first is positive and the second negative
        let ours = c.map(|c| if k == 0 { c > 0.0 } else { c < 0.0 });
        if c.contains(&0.0) || ours.windows(2).filter(|w| w[0] != w[1]).count() > 1 {
            return None;
        }
        match (ours[0], ours[3]) {
            (true, true) => {}
            (false, false) => return Some([0.0; 2]),
            (enters, _) => {
                let mut found = Roots::new();
                roots(c, &mut found);
                let &[at] = found.as_slice() else { return None };
                if enters { range[1] = range[1].min(at) } else { range[0] = range[0].max(at) }
            }
        }
    }
    Some(range)
}

#[cfg(test)]
mod tests;
