//! Parts of contact zones: branches of the projection, their pieces within reach, points of these.

use crate::contact::measures::COINCIDENT;
use crate::math::Vec3;

/// Samples per branch interval, because bracketing then misses only dips narrower than the oscillations of a cubic
/// between two samples.
pub(super) const NUM_SAMPLES: usize = 7;

/// Kind of foot along a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FootKind {
    /// Orthogonal projection on the interior of the master curve.
    Orthogonal,
    /// The open start of the master, or a kink there.
    Start,
    /// The open end of the master, or a kink there.
    End,
    /// A branch through a fold of the projection, traced along the master: nearest points before the fold and farthest
    /// after it, or the reverse.
    Fold,
    /// Feet that rounding cannot separate, all held at one parameter.
    Held,
}

/// Master and slave at one slave parameter.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Slave parameter.
    pub u: f64,
    /// Foot parameter on the master.
    pub v: f64,
    /// |a(u) − b(v)| \[L\].
    pub distance: f64,
    /// The parameter of the branch: v for a fold, otherwise u.
    pub(super) t: f64,
    /// du/dt.
    pub(super) rate: f64,
    /// d distance / dt \[L\].
    pub(super) slope: f64,
    /// d² distance / dt² \[L\]; NaN for a fold.
    pub(super) curvature: f64,
}

/// Closest-point projection of the slave's point at one parameter on the master.
#[derive(Debug, Clone, Copy)]
pub(in crate::contact) struct Projection {
    /// Slave parameter.
    pub(in crate::contact) u: f64,
    /// Foot parameter on the master.
    pub(in crate::contact) v: f64,
    /// From foot to slave point \[L\].
    pub(in crate::contact) distance: f64,
    /// Unit vector from foot to slave point; zero if they coincide.
    pub(in crate::contact) normal: Vec3,
    /// First and second derivative of the master by its parameter, at the foot \[L\].
    pub(in crate::contact) tangent: Vec3,
    pub(in crate::contact) curvature: Vec3,
}

/// A maximal interval of one branch with distance < reach.
#[derive(Debug, Clone, Copy)]
pub struct BranchPiece {
    /// Slave parameters of the ends.
    pub u: [f64; 2],
    /// Foot parameters at the ends.
    pub v: [f64; 2],
    /// The branch.
    pub branch: Branch,
    /// The point of smallest distance inside the piece.
    pub nearest: Sample,
}

/// A branch of the projection: a foot as a function of the slave's point.
#[derive(Debug, Clone, Copy)]
pub struct Branch {
    /// Kind of the foot.
    pub kind: FootKind,
    /// 1 for nearest points of the master; −1 for farthest ones between two nearest, which are subtracted; for a fold
    /// the sign of ∂f/∂u.
    pub sign: f64,
    /// Interval that contains the only foot: of v, for a fold of u.
    pub(super) within: [f64; 2],
}

impl Branch {
    pub(in crate::contact) const ONLY: Self = Self { kind: FootKind::Orthogonal, sign: 1.0, within: [0.0, 1.0] };

    pub(super) fn of(kind: FootKind, sign: f64) -> Self {
        Self { kind, sign, ..Self::ONLY }
    }

    /// Whether the branch consists of farthest points, which are subtracted.
    #[must_use]
    pub fn is_subtracted(&self) -> bool {
        self.sign < 0.0 && self.kind != FootKind::Fold
    }

    /// Whether held feet may stand for a stationary point at v.
    pub(in crate::contact) fn may_be_at(&self, v: f64) -> bool {
        v >= self.within[0] && v <= self.within[1]
    }
}

impl BranchPiece {
    /// The parameter of the branch at its ends, and the other parameter there.
    pub(in crate::contact) fn along(&self) -> [[f64; 2]; 2] {
        if self.branch.kind == FootKind::Fold { [self.v, self.u] } else { [self.u, self.v] }
    }

    /// The same with u ascending.
    pub(in crate::contact) fn ascending(&self) -> Self {
        let turn = |[a, b]: [f64; 2]| if self.u[0] > self.u[1] { [b, a] } else { [a, b] };
        Self { u: turn(self.u), v: turn(self.v), ..*self }
    }

    /// The part between two fractions of the piece.
    fn part(&self, from: f64, to: f64) -> Self {
        let between = |ends: [f64; 2]| [from, to].map(|x| ends[0] + (ends[1] - ends[0]) * x);
        Self { u: between(self.u), v: between(self.v), ..*self }
    }

    /// Calls `keep` with the parts on which a condition does not hold. The condition is evaluated at samples; bisection
    /// locates its changes between them.
    pub(in crate::contact) fn parts_without(&self, holds: impl Fn(f64) -> bool, mut keep: impl FnMut(Self)) {
        let at = |k: usize| (k as f64 / NUM_SAMPLES as f64).clamp(COINCIDENT, 1.0 - COINCIDENT);
        let mut before = holds(at(0));
        let mut start = if before { None } else { Some(0.0) };
        for k in 1..=NUM_SAMPLES {
            let after = holds(at(k));
            if after != before {
                let signed = |x: f64| if holds(x) == before { 1.0 } else { -1.0 };
                let change = falling_root([at(k - 1), at(k)], signed);
                if let Some(from) = start.take() {
                    keep(self.part(from, change));
                } else {
                    start = Some(change);
                }
            }
            before = after;
        }
        if let Some(from) = start {
            keep(self.part(from, 1.0));
        }
    }
}

impl Sample {
    /// The parameter other than that of the branch.
    pub(super) fn other(&self, branch: &Branch) -> f64 {
        if branch.kind == FootKind::Fold { self.u } else { self.v }
    }
}

/// The root of a function that falls over an interval, by bisection; the nearer end if there is none.
pub(super) fn falling_root([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let start = f(low);
    if start <= 0.0 || start.is_nan() {
        return low;
    }
    if f(high) >= 0.0 {
        return high;
    }
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if f(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
}
