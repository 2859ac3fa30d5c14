//! Contact zones of a pair of cubics: the exact sub-intervals of one curve (the slave) whose orthogonal projection on
//! the other (the master) is closer than a given reach.
//!
//! The contact potential is an integral along the slave over the parts where the gap is below a threshold. Integrand
//! and slope vanish at the ends of these parts. So a quadrature of gradient and Hessian between *exact* ends is
//! consistent with the potential, and Newton's method converges quadratically; between approximate ends it does not
//! (interval segmentation: Meier, Popp & Wall 2016).
//!
//! A foot on the master moves along it as the slave parameter u moves: a branch v(u), f(u, v) = (a(u) − b(v))·b′(v)
//! = 0. Branches are cut
//! * where the foot enters or leaves the master at v = 0 or 1: roots of f(u, 0), a cubic in u, likewise at 1;
//! * where distance − reach changes sign: bracketed by samples and by minima between samples, then by safeguarded
//!   Newton.
//!
//! At an open end of the master the end point itself is the foot on the far side (a spherical cap); the distance to a
//! curve is C¹ across that change.
//!
//! **Counting.** A slave point x that lies farther than a centre of curvature from the master, or inside a kink, has
//! farthest points between its nearest ones, and feet appear and vanish in pairs (∂f/∂v = 0: a fold of the projection).
//! Feet alone would make the potential jump there. So farthest points within reach are subtracted: with φ the potential
//! of a distance,
//!
//! ```text
//! Σ_nearest φ(d) − Σ_farthest φ(d) = −∫₀^reach φ′(ρ) χ(ρ) dρ
//! χ(ρ): number of strands of the master in the ball of radius ρ about x
//! ```
//!
//! (Euler's characteristic of the part of the master in the ball; Morse theory.) A strand bent within the ball is one
//! strand, not two; two that pass through it are two; a closed curve that lies in it as a whole is one, so the farthest
//! of its points is not subtracted. Where the projection is unique there is no farthest point, and this is the
//! functional of Meier et al.; that holds wherever the curvature of the master is less than 1 over the reach. The sum
//! is C¹ in x: where a nearest and a farthest point meet, their distances and normals do too, and corners of the master
//! take over from its segments likewise (of a closed curve in the ball it is continuous where two points are farthest).
//! On the bisector of an acute notch a point is pushed out unless it overlaps by more than 0.85 of the reach; deeper,
//! it sees one strand.
//!
//! Pairs with ∂f/∂v < 0 throughout, shown by a bound of the control points, have one branch; the others are cut into
//! cells.

mod branch;
mod cells;
pub(super) mod facing;
pub mod interval;
mod piece;
pub(super) mod straight;

use crate::contact::curves::curve::Cubic;
use crate::contact::projection::smooth_joint;
use crate::math::Vec3;
use crate::math::bernstein::{Roots, roots};

pub(super) use piece::Projection;
pub use piece::{Branch, BranchPiece, FootKind, Sample};

/// Width of an interval of u that counts as rounding, because its ends are rounded by as much.
const NARROW: f64 = 16.0 * f64::EPSILON;

/// A slave and a master segment, and the continuation of the master's curve at both ends.
#[derive(Debug, Clone, Copy)]
pub struct SegmentPair<'a> {
    /// Slave segment.
    pub slave: &'a Cubic,
    /// Master segment.
    pub master: &'a Cubic,
    /// Whether the master segment starts at an open end of its curve.
    pub open_start: bool,
    /// Whether the master segment ends at an open end of its curve.
    pub open_end: bool,
    /// Reach at u = 0 and u = 1, linear between \[L\].
    pub reach: [f64; 2],
    /// Where the master continues smoothly before its start and beyond its end.
    pub joints: [Option<SmoothJoint>; 2],
    /// Tangents of the curve before the master's start and beyond its end, of any length, where it has a kink that this
    /// pair counts.
    pub kinks: [Option<Vec3>; 2],
}

/// A smooth joint at an end of the master. A foot that stays on it belongs to the segment after it. Rounding must
/// neither lose it nor count it twice, so both segments use one tangent, that of the segment before.
#[derive(Debug, Clone, Copy)]
pub struct SmoothJoint {
    /// Tangent of the curve there, of any length.
    pub tangent: Vec3,
}

impl SmoothJoint {
    /// Joints at the start and the end of `own`, whose curve continues as `before` and `after`; `None` at a kink.
    ///
    /// All three relative to `origin` \[L\], the same for the segments that meet: each of them must compute the same
    /// bits. (The rounding of the control points, which a smooth joint is known up to, is that of the coordinates they
    /// were given in.)
    pub(crate) fn both(before: Option<Cubic>, own: &Cubic, after: Option<Cubic>, origin: &Vec3) -> [Option<Self>; 2] {
        let of = |first: &Cubic, second: &Cubic| {
            let far = origin.amax() + first.b[3].amax();
            smooth_joint(first, second, far).then(|| Self { tangent: first.b[3] - first.b[2] })
        };
        [before.and_then(|before| of(&before, own)), after.and_then(|after| of(own, &after))]
    }
}

/// The side of a point of the master on which the foot is, over the slave: the sign of a cubic in Bernstein form.
struct FootSide {
    coefficients: [f64; 4],
    joined: bool,
}

impl FootSide {
    fn new(slave: &Cubic, foot: &Vec3, tangent: &Vec3, joined: bool) -> Self {
        let mut coefficients = slave.b.map(|p| (p - foot).dot(tangent));
        let size = slave.b.iter().fold(foot.amax(), |size, p| size.max(p.amax()));
        let noise = 8.0 * f64::EPSILON * size * tangent.amax();
        if joined && coefficients.iter().all(|c| c.abs() <= noise) {
            coefficients = [0.0; 4];
        }
        Self { coefficients, joined }
    }

    fn at(&self, u: f64) -> f64 {
        let [mut a, mut b, mut c, d] = self.coefficients;
        let mix = |x: f64, y: f64| x + (y - x) * u;
        (a, b, c) = (mix(a, b), mix(b, c), mix(c, d));
        (a, b) = (mix(a, b), mix(b, c));
        mix(a, b)
    }

    /// Whether the foot is after this point, the start of a part of the master. A foot on a joint belongs to the
    /// segment after it.
    fn passed_start(&self, u: f64) -> bool {
        let f = self.at(u);
        f > 0.0 || self.joined && f == 0.0
    }

    /// Whether the foot is after this point, the end of a part of the master.
    fn passed_end(&self, u: f64) -> bool {
        self.at(u) >= 0.0
    }
}

impl SegmentPair<'_> {
    fn reach_at(&self, u: f64) -> f64 {
        self.reach[0] + (self.reach[1] - self.reach[0]) * u
    }

    fn reach_slope(&self) -> f64 {
        self.reach[1] - self.reach[0]
    }

    /// All pieces of this pair, appended to `out`.
    pub fn pieces(&self, out: &mut Vec<BranchPiece>) {
        let sides = self.sides();
        if self.has_one_branch() {
            self.follow([&sides[0], &sides[1]], [0.0, 1.0], Branch::ONLY, out);
        } else {
            self.cells(&sides, out);
        }
        self.ends(&sides, out);
    }

    /// Pieces over slave parameters in `range` of the feet between two points of the master.
    fn follow(&self, sides: [&FootSide; 2], range: [f64; 2], branch: Branch, out: &mut Vec<BranchPiece>) {
        let (breaks, count) = breaks(range, sides);
        for window in breaks[..count].windows(2) {
            let (start, end) = (window[0], window[1]);
            if end - start <= NARROW {
                continue;
            }
            let middle = 0.5 * (start + end);
            let passed = [sides[0].passed_start(middle), sides[1].passed_end(middle)];
            // The foot enters the interval as a nearest point, or as a farthest one.
            let sign = f64::from(i8::from(passed[0]) - i8::from(passed[1]));
            let held = branch.kind == FootKind::Held;
            if sign == branch.sign || held && sign != 0.0 {
                let guess = 0.5 * (branch.within[0] + branch.within[1]);
                self.branch([start, end], guess, Branch { sign, ..branch }, out);
            }
        }
    }

    /// Pieces whose foot is an end of the master: caps of open ends, and wedges of kinks.
    fn ends(&self, sides: &[FootSide; 2], out: &mut Vec<BranchPiece>) {
        let open = [self.open_start, self.open_end];
        let points = [self.master.b[0], self.master.b[3]];
        for (k, kind) in [FootKind::Start, FootKind::End].into_iter().enumerate() {
            let beyond = self.kinks[k].map(|tangent| FootSide::new(self.slave, &points[k], &tangent, false));
            if !open[k] && beyond.is_none() {
                continue;
            }
            let (breaks, count) = breaks([0.0, 1.0], [&sides[k], beyond.as_ref().unwrap_or(&sides[k])]);
            for window in breaks[..count].windows(2) {
                let (start, end) = (window[0], window[1]);
                if end - start <= NARROW {
                    continue;
                }
                let middle = 0.5 * (start + end);
                let own = sides[k].at(middle);
                let sign = match &beyond {
                    Some(beyond) => {
                        let beyond = beyond.at(middle);
                        let [before, after] = if k == 0 { [beyond, own] } else { [own, beyond] };
                        f64::from(i8::from(before >= 0.0) - i8::from(after > 0.0))
                    }
                    None => f64::from(i8::from(if k == 0 { own <= 0.0 } else { own >= 0.0 })),
                };
                if sign != 0.0 {
                    self.branch([start, end], k as f64, Branch::of(kind, sign), out);
                }
            }
        }
    }

    fn sides(&self) -> [FootSide; 2] {
        let b = &self.master.b;
        let own = [(b[0], self.master.start_tangent()), (b[3], self.master.end_tangent())];
        std::array::from_fn(|k| {
            let (foot, tangent) = own[k];
            let joint = self.joints[k];
            FootSide::new(self.slave, &foot, &joint.map_or(tangent, |j| j.tangent), joint.is_some())
        })
    }
}

/// A vector of the given length, normalised; zero stays zero.
fn unit(v: &Vec3, length: f64) -> Vec3 {
    if length > 0.0 { v / length } else { Vec3::zeros() }
}

/// The ends of a range and the slave parameters in it whose foot passes one of two points of the master, ascending.
fn breaks(range: [f64; 2], sides: [&FootSide; 2]) -> ([f64; 8], usize) {
    let mut breaks = [range[0]; 8];
    let mut count = 1;
    for side in sides {
        let mut found = Roots::new();
        roots(&side.coefficients, &mut found);
        for &u in found.as_slice().iter().filter(|u| (range[0]..=range[1]).contains(*u)) {
            breaks[count] = u;
            count += 1;
        }
    }
    breaks[count] = range[1];
    count += 1;
    breaks[..count].sort_unstable_by(f64::total_cmp);
    (breaks, count)
}

#[cfg(test)]
mod tests;
