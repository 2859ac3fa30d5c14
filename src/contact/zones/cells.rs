//! Pairs of cubics with folds: the square of parameters is cut into cells until each contains the feet of one branch
//! only.
//!
//! With f(u, v) = (a(u) − b(v))·b′(v), whose zeros are nearest (∂f/∂v < 0) and farthest points (∂f/∂v > 0) of the
//! master, a cell is
//! * discarded if its curves are farther apart than the reach, or f has one sign by its Bernstein coefficients;
//! * traced along the slave if ∂f/∂v has one sign: there is one foot at most for each u;
//! * traced along the master if ∂f/∂u = a′·b′ has one sign: there is one u for each v, through any folds;
//! * otherwise cut in two. When cells are too small or too many (slave points with an arc of the master at one
//!   distance), the foot is held at the middle of the cell, where the distance is correct to second order.

use std::collections::VecDeque;

use super::facing::convexity;
use super::piece::falling_root;
use super::{Branch, BranchPiece, FootKind, FootSide, NARROW, Sample, SegmentPair};
use crate::contact::curves::curve::Cubic;
use crate::contact::measures::{COINCIDENT, MAX_STEPS, SUM_ROUNDING};
use crate::contact::pairs::capsule;
use crate::contact::projection::stationarity;
use crate::math::Vec3;
use crate::math::bernstein::{Roots, roots};

/// Least slope of f over its largest in a cell, because the energy of random curves changes by 4e-8 at most where this
/// is halved or doubled.
const EVEN: f64 = 0.1;

/// Largest number of cells examined, because slave points with an arc of the master at one distance have cells without
/// end; the feet of the rest are held.
const MAX_CELLS: usize = 512;
/// Width of a cell, in both parameters, below which its foot is held, because the distance is then right to the
/// square of this.
const SMALLEST: f64 = 1.0 / 4096.0;

struct ParameterCell {
    u: [f64; 2],
    v: [f64; 2],
}

impl ParameterCell {
    /// A branch along the slave in this cell.
    fn branch(&self, kind: FootKind, sign: f64) -> Branch {
        Branch { kind, sign, within: self.v }
    }
}

enum BranchVerdict {
    Empty,
    /// One branch of this sign along the slave.
    Along(f64),
    /// One branch along the master; the sign of ∂f/∂u.
    Across(f64),
    Unclear,
}

/// Bounds of a function over a cell.
#[derive(Clone, Copy)]
struct FunctionBounds {
    low: f64,
    high: f64,
    /// Bound of the rounding.
    noise: f64,
}

impl FunctionBounds {
    fn of(values: impl IntoIterator<Item = f64>, noise: f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        values.into_iter().for_each(|x| (low, high) = (low.min(x), high.max(x)));
        Self { low, high, noise }
    }

    /// The sign of the function throughout, 0 if the bounds do not show one.
    fn sign(&self) -> f64 {
        if self.low > self.noise {
            1.0
        } else if self.high < -self.noise {
            -1.0
        } else {
            0.0
        }
    }

    /// Its least size over its largest, if it has one sign.
    fn evenness(&self) -> f64 {
        if self.sign() == 0.0 { 0.0 } else { (self.low / self.high).min(self.high / self.low) }
    }
}

fn largest(vectors: &[Vec3]) -> f64 {
    vectors.iter().map(Vec3::amax).fold(0.0, f64::max)
}

/// Bounds of ∂f/∂v = −D_vv, up to a factor.
fn sense(a: &Cubic, b: &Cubic) -> FunctionBounds {
    let [least, most] = convexity(a, b);
    let (size, edges) = (largest(&a.b).max(largest(&b.b)), largest(&b.edges()));
    FunctionBounds { low: -most, high: -least, noise: 100.0 * SUM_ROUNDING * edges * edges.max(size) }
}

/// `joined`: whether the part of the master ends at a smooth joint. The common tangent decides there, not the rounding
/// of one segment.
fn judge(a: &Cubic, b: &Cubic, joined: bool, reach: f64) -> BranchVerdict {
    if capsule::distance_lower_bound(a, b) > reach {
        return BranchVerdict::Empty;
    }
    let (p, e) = (a.edges(), b.edges());
    let size = largest(&a.b).max(largest(&b.b));
    let noise = 100.0 * SUM_ROUNDING * size * largest(&e);
    if !joined && FunctionBounds::of(a.b.iter().flat_map(|x| stationarity(b, x)), noise).sign() != 0.0 {
        return BranchVerdict::Empty;
    }
    let along = sense(a, b);
    if along.evenness() > EVEN {
        return BranchVerdict::Along(-along.sign());
    }
    // At a joint the tangents of the two segments may differ by the rounding of coordinates far from the origin.
    let noise = if joined { COINCIDENT } else { 10.0 * SUM_ROUNDING };
    let across =
        FunctionBounds::of(p.iter().flat_map(|p| e.iter().map(|e| p.dot(e))), noise * largest(&p) * largest(&e));
    if across.evenness() > EVEN {
        return BranchVerdict::Across(across.sign());
    }
    BranchVerdict::Unclear
}

impl SegmentPair<'_> {
    /// Whether no slave point has more than one foot on the master, by a bound. It succeeds where the curvature of the
    /// master is less than 1 over the distance.
    pub(super) fn has_one_branch(&self) -> bool {
        sense(self.slave, self.master).sign() < 0.0
    }

    /// Pieces of all feet, cell by cell.
    pub(super) fn cells(&self, sides: &[FootSide; 2], out: &mut Vec<BranchPiece>) {
        let reach = self.reach[0].max(self.reach[1]);
        let mut queue = VecDeque::from([ParameterCell { u: [0.0, 1.0], v: [0.0, 1.0] }]);
        let mut seen = 0;
        while let Some(cell) = queue.pop_front() {
            seen += 1;
            let (a, b) = (self.slave.restrict(cell.u[0], cell.u[1]), self.master.restrict(cell.v[0], cell.v[1]));
            let joined = sides[0].joined && cell.v[0] == 0.0 || sides[1].joined && cell.v[1] == 1.0;
            let [du, dv] = [cell.u, cell.v].map(|r| r[1] - r[0]);
            match judge(&a, &b, joined, reach) {
                BranchVerdict::Empty => {}
                BranchVerdict::Along(sign) => {
                    self.follow_in(&cell, sides, cell.branch(FootKind::Orthogonal, sign), out)
                }
                BranchVerdict::Across(sign) => self.fold(&cell, &b, sign, out),
                BranchVerdict::Unclear => {
                    if seen + queue.len() >= MAX_CELLS || du.max(dv) <= SMALLEST {
                        self.follow_in(&cell, sides, cell.branch(FootKind::Held, 1.0), out);
                        continue;
                    }
                    // The longer side, but no side much smaller than the other.
                    let long = largest(&a.edges()) > largest(&b.edges());
                    let halves = |r: [f64; 2]| [[r[0], 0.5 * (r[0] + r[1])], [0.5 * (r[0] + r[1]), r[1]]];
                    if dv <= 0.125 * du || long && du > 0.125 * dv {
                        queue.extend(halves(cell.u).map(|u| ParameterCell { u, v: cell.v }));
                    } else {
                        queue.extend(halves(cell.v).map(|v| ParameterCell { u: cell.u, v }));
                    }
                }
            }
        }
    }

    /// Traces the branch of one cell along the slave. Cells that meet at a v use the same function there.
    fn follow_in(&self, cell: &ParameterCell, sides: &[FootSide; 2], branch: Branch, out: &mut Vec<BranchPiece>) {
        let border = |v: f64| {
            let (point, tangent, _) = self.master.derivatives(v);
            FootSide::new(self.slave, &point, &tangent, true)
        };
        let inner = cell.v.map(|v| (v > 0.0 && v < 1.0).then(|| border(v)));
        let sides = [inner[0].as_ref().unwrap_or(&sides[0]), inner[1].as_ref().unwrap_or(&sides[1])];
        self.follow(sides, cell.u, branch, out);
    }

    /// Traces the branch of one cell along the master, whose part there is `part`.
    fn fold(&self, cell: &ParameterCell, part: &Cubic, sign: f64, out: &mut Vec<BranchPiece>) {
        let [v0, v1] = cell.v;
        let ends = cell.u.map(|u| stationarity(part, &self.slave.point(u)));
        let mut breaks = vec![0.0, 1.0];
        for end in &ends {
            let mut found = Roots::new();
            roots(end, &mut found);
            breaks.extend_from_slice(found.as_slice());
        }
        breaks.sort_unstable_by(f64::total_cmp);
        let branch = Branch { kind: FootKind::Fold, sign, within: cell.u };
        for window in breaks.windows(2).filter(|w| w[1] - w[0] > NARROW) {
            let [start, end] = [window[0], window[1]].map(|t| v0 + (v1 - v0) * t);
            let middle = 0.5 * (start + end);
            let [f0, f1] = cell.u.map(|u| self.f(u, middle) * sign);
            // f rises with u times the sign
            if f0 < 0.0 && f1 >= 0.0 {
                self.branch([start, end], 0.5 * (cell.u[0] + cell.u[1]), branch, out);
            }
        }
    }

    fn f(&self, u: f64, v: f64) -> f64 {
        let (b, db, _) = self.master.derivatives(v);
        (self.slave.point(u) - b).dot(&db)
    }

    /// du/dv along a fold, −∂f/∂v ÷ ∂f/∂u.
    pub(super) fn rate(&self, u: f64, v: f64) -> f64 {
        let (a, da, _) = self.slave.derivatives(u);
        let (b, db, ddb) = self.master.derivatives(v);
        (db.norm_squared() - (a - b).dot(&ddb)) / da.dot(&db)
    }

    /// The slave parameter whose foot is at v, on a fold: Newton's method, or bisection if it leaves the interval.
    pub(super) fn slave_of(&self, v: f64, guess: f64, branch: &Branch) -> f64 {
        let [low, high] = branch.within;
        let (b, db, _) = self.master.derivatives(v);
        let mut u = guess.clamp(low, high);
        for _ in 0..MAX_STEPS {
            let (a, da, _) = self.slave.derivatives(u);
            let step = -(a - b).dot(&db) / da.dot(&db);
            u += step;
            // Written so that NaN ends the search.
            let inside = u >= low - NARROW && u <= high + NARROW;
            if !inside {
                break;
            }
            if step.abs() <= 4.0 * f64::EPSILON {
                return u.clamp(low, high);
            }
        }
        falling_root(branch.within, |u| -branch.sign * (self.slave.point(u) - b).dot(&db))
    }

    pub(super) fn sample_of_fold(&self, v: f64, guess: f64, branch: &Branch) -> Sample {
        let u = self.slave_of(v, guess, branch);
        let (a, da, _) = self.slave.derivatives(u);
        let chord = a - self.master.point(v);
        let distance = chord.norm();
        let rate = self.rate(u, v);
        Sample { u, v, distance, t: v, rate, slope: chord.dot(&da) / distance * rate, curvature: f64::NAN }
    }
}
