//! Contact zones of a pair of cubics: the exact sub-intervals of one curve (the slave) whose orthogonal projection on
//! the other (the master) is closer than a given reach.
//!
//! The contact potential is an integral along the slave over the parts where the gap is below a threshold. Integrand and
//! slope vanish at the ends of these parts, so a quadrature of gradient and Hessian between *exact* ends is consistent with
//! the potential, and Newton's method converges quadratically; with sloppy ends it does not (interval segmentation:
//! Meier, Popp & Wall 2016).
//!
//! A foot on the master moves along it as the slave parameter u moves: a branch v(u), f(u, v) = (a(u) − b(v))·b′(v) = 0. Branches are cut
//! * where the foot enters or leaves the master at v = 0 or 1: roots of f(u, 0), a cubic in u, likewise at 1;
//! * where distance − reach changes sign: bracketed by samples and by minima between samples, then by safeguarded Newton.
//!
//! At an open end of the master the end point itself is the foot on the far side (a spherical cap); the distance to a
//! curve is C¹ across that change.
//!
//! **What is counted.** A slave point x that lies farther than a centre of curvature from the master, or inside a kink, has farthest points between
//! its nearest ones, and feet appear and vanish in pairs (∂f/∂v = 0: a fold of the projection). Feet alone would make the potential jump there. So
//! farthest points within reach are counted off: with φ the potential of a distance,
//!
//! ```text
//! Σ_nearest φ(d) − Σ_farthest φ(d) = −∫₀^reach φ′(ρ) χ(ρ) dρ        χ(ρ): number of strands of the master in the ball of radius ρ about x
//! ```
//!
//! (Euler's characteristic of the part of the master in the ball; Morse theory.) A strand bent within the ball is one strand, not two; two that pass
//! through it are two; a closed curve that lies in it as a whole is one, so the farthest of its points is not counted off. Where the projection is unique
//! there is no farthest point, and this is the paper's functional; so it is wherever the master is curved less than 1 over the reach. The sum is C¹ in x:
//! where a nearest and a farthest point meet, their distances and normals do too, and corners of the master take over from its segments likewise (of
//! a closed curve in the ball it is continuous where two points are farthest). On the bisector of an acute notch a point is
//! pushed out unless it overlaps by more than .85 of the reach; deeper, it sees one strand.
//!
//! Pairs with ∂f/∂v < 0 throughout, which a bound of the control points tells at once, have one branch; the others are cut into cells.

mod cells;
pub(super) mod facing;
pub(super) mod straight;

use super::curve::Cubic;
use super::projection::smooth_joint;
use crate::math::Vec3;
use crate::math::bernstein::{Roots, roots};

/// Samples per branch interval; the bracketing misses only dips narrower than the wiggles of one cubic between them.
const NUM_SAMPLES: usize = 7;
/// Iterations of the safeguarded root finder; bisection alone ends after 53.
const MAX_ROOT_ITERATIONS: usize = 100;

/// Intervals of u narrower than this are rounding.
const NARROW: f64 = 16.0 * f64::EPSILON;

/// What the foot does along a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FootKind {
    /// Orthogonal projection on the interior of the master curve.
    Orthogonal,
    /// The open start of the master, or a kink there.
    Start,
    /// The open end of the master, or a kink there.
    End,
    /// The foot's parameter tells the slave's: a branch through a fold of the projection, nearest points before it and farthest after it (or the
    /// other way round), followed along the master.
    Fold,
    /// Feet that rounding cannot tell apart, all taken to be at one parameter.
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
    /// What a branch is followed by: v for a fold, otherwise u.
    t: f64,
    /// du/dt.
    rate: f64,
    /// d distance / dt \[L\].
    slope: f64,
    /// d² distance / dt² \[L\]; NaN for a fold.
    curvature: f64,
}

/// What a contact potential asks at one slave parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// Slave parameter.
    pub(super) u: f64,
    /// Foot parameter on the master.
    pub(super) v: f64,
    /// From foot to slave point \[L\].
    pub(super) distance: f64,
    /// Unit vector from foot to slave point; zero if they coincide.
    pub(super) normal: Vec3,
    /// First and second derivative of the master by its parameter, at the foot \[L\].
    pub(super) tangent: Vec3,
    pub(super) curvature: Vec3,
}

/// A maximal interval of one branch with distance < reach.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// Slave parameters of the ends.
    pub u: [f64; 2],
    /// Foot parameters at the ends.
    pub v: [f64; 2],
    /// The branch.
    pub branch: Branch,
    /// Where the distance is smallest inside the piece.
    pub nearest: Sample,
}

/// A way for the foot to go along with the slave's point.
#[derive(Debug, Clone, Copy)]
pub struct Branch {
    /// What the foot does.
    pub kind: FootKind,
    /// 1 for nearest points of the master; −1 for farthest ones between two nearest, which are counted off; of a fold the sign of ∂f/∂u.
    pub sign: f64,
    /// Where the only foot is sought: an interval of v, for a fold of u.
    within: [f64; 2],
}

impl Branch {
    pub(super) const ONLY: Self = Self { kind: FootKind::Orthogonal, sign: 1.0, within: [0.0, 1.0] };

    fn of(kind: FootKind, sign: f64) -> Self {
        Self { kind, sign, ..Self::ONLY }
    }

    /// Only farthest points, which are counted off.
    #[must_use]
    pub fn is_counted_off(&self) -> bool {
        self.sign < 0.0 && self.kind != FootKind::Fold
    }

    /// Whether held feet may stand for a stationary point at v.
    pub(super) fn may_be_at(&self, v: f64) -> bool {
        v >= self.within[0] && v <= self.within[1]
    }
}

/// A slave and a master segment with what their curves do at the master's ends.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// Slave segment.
    pub slave: &'a Cubic,
    /// Master segment.
    pub master: &'a Cubic,
    /// The master segment starts at an open end of its curve.
    pub open_start: bool,
    /// The master segment ends at an open end of its curve.
    pub open_end: bool,
    /// Reach at u = 0 and u = 1, linear between \[L\].
    pub reach: [f64; 2],
    /// Where the master continues smoothly before its start and beyond its end.
    pub joints: [Option<Joint>; 2],
    /// Tangents of the curve before the master's start and beyond its end, of any length, where it has a kink that this pair is to count.
    pub kinks: [Option<Vec3>; 2],
}

/// A smooth joint at an end of the master. A foot that rests on it all along belongs to the segment after it: rounding must neither lose it
/// nor count it twice, so both segments judge by one tangent, that of the segment before.
#[derive(Debug, Clone, Copy)]
pub struct Joint {
    /// Tangent of the curve there, of any length.
    pub tangent: Vec3,
}

impl Joint {
    /// Joints at the start and the end of `own`, whose curve goes on as `before` and `after`, none where it has a kink.
    ///
    /// All three relative to `origin` \[L\], the same for the segments that meet: each of them must find the same bits. (The rounding of the
    /// control points, which a smooth joint is known up to, is that of the coordinates they were given in.)
    pub(crate) fn both(before: Option<Cubic>, own: &Cubic, after: Option<Cubic>, origin: &Vec3) -> [Option<Self>; 2] {
        let of = |first: &Cubic, second: &Cubic| {
            let far = origin.amax() + first.b[3].amax();
            smooth_joint(first, second, far).then(|| Self { tangent: first.b[3] - first.b[2] })
        };
        [before.and_then(|before| of(&before, own)), after.and_then(|after| of(own, &after))]
    }
}

/// On which side of a point of the master the foot is, over the slave: the sign of a cubic in Bernstein form.
struct Side {
    coefficients: [f64; 4],
    joined: bool,
}

impl Side {
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

    /// The foot is after this point, which is the start of what is looked at. A foot that rests on a joint belongs to the segment after it.
    fn passed_start(&self, u: f64) -> bool {
        let f = self.at(u);
        f > 0.0 || self.joined && f == 0.0
    }

    /// The foot is after this point, which is the end of what is looked at.
    fn passed_end(&self, u: f64) -> bool {
        self.at(u) >= 0.0
    }
}

impl Pair<'_> {
    fn reach_at(&self, u: f64) -> f64 {
        self.reach[0] + (self.reach[1] - self.reach[0]) * u
    }

    fn reach_slope(&self) -> f64 {
        self.reach[1] - self.reach[0]
    }

    /// What a potential asks where a branch has come to `t`, what it is followed by, from a guess of the other parameter; and how fast the slave's
    /// parameter changes with it, less than nothing where it is counted off.
    pub(super) fn touch(&self, t: f64, guess: f64, branch: &Branch) -> (Touch, f64) {
        let (u, v, rate) = if branch.kind == FootKind::Fold {
            let u = self.slave_of(t, guess, branch);
            (u, t, self.rate(u, t))
        } else {
            (t, self.foot_of(&self.slave.point(t), guess, branch), 1.0)
        };
        let (b, tangent, curvature) = self.master.derivatives(v);
        let chord = self.slave.point(u) - b;
        let distance = chord.norm();
        (Touch { u, v, distance, normal: unit(&chord, distance), tangent, curvature }, branch.sign * rate)
    }

    fn foot_of(&self, a: &Vec3, guess: f64, branch: &Branch) -> f64 {
        match branch.kind {
            FootKind::Start => 0.0,
            FootKind::End => 1.0,
            FootKind::Orthogonal => self.foot(a, guess, branch),
            FootKind::Held | FootKind::Fold => guess,
        }
    }

    /// Follows the branch to parameter `t`, starting from a guess of the other parameter.
    fn sample(&self, t: f64, guess: f64, branch: &Branch) -> Sample {
        if branch.kind == FootKind::Fold {
            return self.sample_of_fold(t, guess, branch);
        }
        let u = t;
        let (a, da, dda) = self.slave.derivatives(u);
        let v = self.foot_of(&a, guess, branch);
        let (b, db, ddb) = self.master.derivatives(v);
        let chord = a - b;
        let distance = chord.norm();
        let normal = chord / distance;
        let slope = normal.dot(&da);
        let mut curvature = (da.norm_squared() - slope * slope) / distance + normal.dot(&dda);
        if branch.kind == FootKind::Orthogonal {
            let d_vv = db.norm_squared() / distance - normal.dot(&ddb);
            let d_uv = da.dot(&db) / distance;
            curvature -= d_uv * d_uv / d_vv;
        }
        Sample { u, v, distance, t, rate: 1.0, slope, curvature }
    }

    /// Newton on f from a near guess; if it leaves the interval or the sense of the branch, bisection.
    fn foot(&self, a: &Vec3, guess: f64, branch: &Branch) -> f64 {
        let [low, high] = branch.within;
        let border = 1e-9 * (high - low);
        let mut v = guess;
        let mut last = f64::INFINITY;
        for _ in 0..12 {
            let (b, db, ddb) = self.master.derivatives(v);
            let f = (a - b).dot(&db);
            let slope = (a - b).dot(&ddb) - db.norm_squared();
            let step = -f / slope;
            if !step.is_finite() || slope * branch.sign >= 0.0 {
                break;
            }
            v += step;
            if v < low - border || v > high + border {
                break;
            }
            // Where the connection is longer than the segment, rounding keeps the last steps above a few ulp: they only stop shrinking.
            let noise = step.abs() < 1e-12 && step.abs() >= 0.25 * last;
            if step.abs() <= 4.0 * f64::EPSILON || noise {
                return v.clamp(low, high);
            }
            last = step.abs();
        }
        let f = |v: f64| {
            let (b, db, _) = self.master.derivatives(v);
            (a - b).dot(&db) * branch.sign
        };
        falling_root(branch.within, f)
    }

    /// All pieces of this pair, appended to `out`.
    pub fn pieces(&self, out: &mut Vec<Piece>) {
        let sides = self.sides();
        if self.has_one_branch() {
            self.follow([&sides[0], &sides[1]], [0.0, 1.0], Branch::ONLY, out);
        } else {
            self.cells(&sides, out);
        }
        self.ends(&sides, out);
    }

    /// Pieces over slave parameters in `range` of the feet between two points of the master.
    fn follow(&self, sides: [&Side; 2], range: [f64; 2], branch: Branch, out: &mut Vec<Piece>) {
        let (breaks, count) = breaks(range, sides);
        for window in breaks[..count].windows(2) {
            let (start, end) = (window[0], window[1]);
            if end - start <= NARROW {
                continue;
            }
            let middle = 0.5 * (start + end);
            let passed = [sides[0].passed_start(middle), sides[1].passed_end(middle)];
            // Into the interval as a nearest point, or as a farthest one.
            let sign = f64::from(i8::from(passed[0]) - i8::from(passed[1]));
            let held = branch.kind == FootKind::Held;
            if sign == branch.sign || held && sign != 0.0 {
                let guess = 0.5 * (branch.within[0] + branch.within[1]);
                self.branch(start, end, guess, Branch { sign, ..branch }, out);
            }
        }
    }

    /// Pieces whose foot is an end of the master: caps of open ends, and wedges of kinks.
    fn ends(&self, sides: &[Side; 2], out: &mut Vec<Piece>) {
        let open = [self.open_start, self.open_end];
        let points = [self.master.b[0], self.master.b[3]];
        for (k, kind) in [FootKind::Start, FootKind::End].into_iter().enumerate() {
            let beyond = self.kinks[k].map(|tangent| Side::new(self.slave, &points[k], &tangent, false));
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
                    self.branch(start, end, k as f64, Branch::of(kind, sign), out);
                }
            }
        }
    }

    fn sides(&self) -> [Side; 2] {
        let b = &self.master.b;
        let own = [(b[0], self.master.start_tangent()), (b[3], self.master.end_tangent())];
        std::array::from_fn(|k| {
            let (foot, tangent) = own[k];
            let joint = self.joints[k];
            Side::new(self.slave, &foot, &joint.map_or(tangent, |j| j.tangent), joint.is_some())
        })
    }

    /// Pieces of a branch over parameters [start, end], from a guess of the other parameter in the middle.
    fn branch(&self, start: f64, end: f64, guess: f64, branch: Branch, out: &mut Vec<Piece>) {
        let none = Sample { u: 0.0, v: 0.0, distance: 0.0, t: 0.0, rate: 0.0, slope: 0.0, curvature: 0.0 };
        let mut samples = [none; NUM_SAMPLES];
        let half = NUM_SAMPLES / 2;
        let at = |k: usize| {
            if k == NUM_SAMPLES - 1 { end } else { start + (end - start) * k as f64 / (NUM_SAMPLES - 1) as f64 }
        };
        samples[half] = self.sample(at(half), guess, &branch);
        for k in (0..half).rev() {
            samples[k] = self.sample(at(k), samples[k + 1].other(&branch), &branch);
        }
        for k in half + 1..NUM_SAMPLES {
            samples[k] = self.sample(at(k), samples[k - 1].other(&branch), &branch);
        }
        let mut crossings: [Option<Sample>; 2 * NUM_SAMPLES] = [None; 2 * NUM_SAMPLES];
        let mut count = 0;
        for k in 0..NUM_SAMPLES - 1 {
            let (s0, s1) = (&samples[k], &samples[k + 1]);
            let (h0, h1) = (self.excess(s0), self.excess(s1));
            if (h0 < 0.0) != (h1 < 0.0) {
                crossings[count] = Some(self.root(s0, s1, &branch, Target::Excess));
                count += 1;
            } else {
                let (d0, d1) = (self.excess_slope(s0), self.excess_slope(s1));
                if (h0 >= 0.0 && d0 < 0.0 && d1 > 0.0) || (h0 < 0.0 && d0 > 0.0 && d1 < 0.0) {
                    let extremum = self.root(s0, s1, &branch, Target::ExcessSlope);
                    if (self.excess(&extremum) < 0.0) != (h0 < 0.0) {
                        crossings[count] = Some(self.root(s0, &extremum, &branch, Target::Excess));
                        crossings[count + 1] = Some(self.root(&extremum, s1, &branch, Target::Excess));
                        count += 2;
                    }
                }
            }
        }
        let mut open = if self.excess(&samples[0]) < 0.0 { Some(samples[0]) } else { None };
        for crossing in crossings.iter().take(count).flatten() {
            open = match open {
                Some(first) => {
                    self.finish(&first, crossing, &samples, branch, out);
                    None
                }
                None => Some(*crossing),
            };
        }
        if let Some(first) = open {
            self.finish(&first, &samples[NUM_SAMPLES - 1], &samples, branch, out);
        }
    }

    fn excess_slope(&self, sample: &Sample) -> f64 {
        sample.slope - self.reach_slope() * sample.rate
    }

    fn excess(&self, sample: &Sample) -> f64 {
        sample.distance - self.reach_at(sample.u)
    }

    /// Root of the target between two samples where it has opposite signs: Newton kept inside a shrinking bracket.
    fn root(&self, s0: &Sample, s1: &Sample, branch: &Branch, target: Target) -> Sample {
        let value = |s: &Sample| match target {
            Target::Excess => (self.excess(s), self.excess_slope(s)),
            Target::ExcessSlope => (self.excess_slope(s), s.curvature),
            Target::Slope => (s.slope, s.curvature),
        };
        let (mut low, mut high) = (*s0, *s1);
        let sign = value(&low).0 < 0.0;
        let mut sample = if value(&low).0.abs() < value(&high).0.abs() { low } else { high };
        for _ in 0..MAX_ROOT_ITERATIONS {
            let (f, df) = value(&sample);
            if (f < 0.0) == sign {
                low = sample;
            } else {
                high = sample;
            }
            let (left, right) = (low.t.min(high.t), low.t.max(high.t));
            let mut next = sample.t - f / df;
            if !(next > left && next < right) {
                if f == 0.0 || (next - sample.t).abs() <= f64::EPSILON {
                    return sample;
                }
                next = 0.5 * (left + right);
                if next <= left || next >= right {
                    return sample;
                }
            }
            let done = (next - sample.t).abs() <= 2.0 * f64::EPSILON;
            sample = self.sample(next, sample.other(branch), branch);
            if done {
                return sample;
            }
        }
        sample
    }

    fn finish(&self, first: &Sample, last: &Sample, samples: &[Sample], branch: Branch, out: &mut Vec<Piece>) {
        if last.t - first.t <= 0.0 {
            return;
        }
        let inside = samples.iter().filter(|s| s.t > first.t && s.t < last.t);
        let mut nearest = if first.distance <= last.distance { *first } else { *last };
        let mut previous = *first;
        for sample in inside.chain(std::iter::once(last)) {
            if sample.distance < nearest.distance {
                nearest = *sample;
            }
            if previous.slope < 0.0 && sample.slope > 0.0 {
                let minimum = self.root(&previous, sample, &branch, Target::Slope);
                if minimum.distance < nearest.distance {
                    nearest = minimum;
                }
            }
            previous = *sample;
        }
        out.push(Piece { u: [first.u, last.u], v: [first.v, last.v], branch, nearest });
    }
}

impl Piece {
    /// What the branch is followed by, at its ends, and the other parameter there.
    pub(super) fn along(&self) -> [[f64; 2]; 2] {
        if self.branch.kind == FootKind::Fold { [self.v, self.u] } else { [self.u, self.v] }
    }

    /// The same with u ascending.
    pub(super) fn ascending(&self) -> Self {
        let turn = |[a, b]: [f64; 2]| if self.u[0] > self.u[1] { [b, a] } else { [a, b] };
        Self { u: turn(self.u), v: turn(self.v), ..*self }
    }

    /// The part between two fractions of the way.
    fn part(&self, from: f64, to: f64) -> Self {
        let between = |ends: [f64; 2]| [from, to].map(|x| ends[0] + (ends[1] - ends[0]) * x);
        Self { u: between(self.u), v: between(self.v), ..*self }
    }

    /// Calls `keep` with the parts on which a condition does not hold; it is asked at samples and where it changes between them.
    pub(super) fn parts_without(&self, holds: impl Fn(f64) -> bool, mut keep: impl FnMut(Self)) {
        let at = |k: usize| (k as f64 / NUM_SAMPLES as f64).clamp(1e-6, 1.0 - 1e-6);
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
    /// The parameter that the branch is not followed by.
    fn other(&self, branch: &Branch) -> f64 {
        if branch.kind == FootKind::Fold { self.u } else { self.v }
    }
}

/// The root of a function that falls over an interval, by bisection; the nearer end if there is none.
fn falling_root([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
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

/// A vector of this length as a unit vector; zero stays zero.
fn unit(v: &Vec3, length: f64) -> Vec3 {
    if length > 0.0 { v / length } else { Vec3::zeros() }
}

/// The ends of a range and the slave parameters in it whose foot passes one of two points of the master, ascending.
fn breaks(range: [f64; 2], sides: [&Side; 2]) -> ([f64; 8], usize) {
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

/// Function whose root is sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    /// distance − reach.
    Excess,
    /// Its slope in u.
    ExcessSlope,
    /// Slope of the distance in u.
    Slope,
}

#[cfg(test)]
mod tests {
    use super::super::projection::{Feet, local_minima};
    use super::*;
    use crate::math::random::Random;

    fn line(from: [f64; 3], to: [f64; 3]) -> Cubic {
        Cubic::straight(Vec3::from(from), Vec3::from(to))
    }

    fn pair<'a>(slave: &'a Cubic, master: &'a Cubic, reach: f64) -> Pair<'a> {
        Pair {
            slave,
            master,
            open_start: false,
            open_end: false,
            reach: [reach; 2],
            joints: [None; 2],
            kinks: [None; 2],
        }
    }

    /// Perpendicular straight strands at height h: the zone is |x| < √(reach² − h²), exactly.
    #[test]
    fn perpendicular_lines_have_the_chord_of_a_circle_as_zone() {
        let (a, b) = (line([-1.0, 0.0, 0.3], [1.0, 0.0, 0.3]), line([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]));
        let mut pieces = Vec::new();
        pair(&a, &b, 0.5).pieces(&mut pieces);
        assert_eq!(pieces.len(), 1);
        let half = 0.5 * 0.4;
        assert!((pieces[0].u[0] - (0.5 - half)).abs() < 1e-15);
        assert!((pieces[0].u[1] - (0.5 + half)).abs() < 1e-15);
        assert!((pieces[0].nearest.u - 0.5).abs() < 1e-15 && (pieces[0].nearest.distance - 0.3).abs() < 1e-15);
    }

    #[test]
    fn parallel_lines_are_cut_where_the_foot_leaves_the_master() {
        let (a, b) = (line([0.0, 0.2, 0.0], [4.0, 0.2, 0.0]), line([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]));
        let mut pieces = Vec::new();
        pair(&a, &b, 0.3).pieces(&mut pieces);
        assert_eq!(pieces.len(), 1);
        assert!((pieces[0].u[0] - 0.25).abs() < 1e-15 && (pieces[0].u[1] - 0.5).abs() < 1e-15);
        let open = Pair { open_start: true, open_end: true, ..pair(&a, &b, 0.3) };
        pieces.clear();
        open.pieces(&mut pieces);
        pieces.sort_by(|p, q| p.u[0].total_cmp(&q.u[0]));
        assert_eq!(pieces.len(), 3);
        let cap = (0.09f64 - 0.04).sqrt();
        assert_eq!(pieces[0].branch.kind, FootKind::Start);
        assert!((pieces[0].u[0] - (1.0 - cap) / 4.0).abs() < 1e-15);
        assert_eq!(pieces[2].branch.kind, FootKind::End);
        assert!((pieces[2].u[1] - (2.0 + cap) / 4.0).abs() < 1e-15);
    }

    /// A dip between two samples must not be missed.
    #[test]
    fn a_shallow_dip_between_samples_is_found() {
        let (a, b) = (line([-1.0, 0.0, 0.3], [1.1, 0.0, 0.3]), line([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]));
        let mut pieces = Vec::new();
        pair(&a, &b, 0.3 * (1.0 + 1e-9)).pieces(&mut pieces);
        assert_eq!(pieces.len(), 1);
        assert!((pieces[0].nearest.u - 1.0 / 2.1).abs() < 1e-14);
    }

    /// A slave that crosses right above a joint of the master, in any attitude and to rounding on either side of it: together the two
    /// segments cover the zone once.
    #[test]
    fn a_zone_whose_foot_rests_on_a_joint_is_covered_once() {
        let mut numbers = Random(99);
        let mut random = || 0.5 * numbers.unit();
        let exact = 2.0 * (0.25f64 - 0.09).sqrt();
        for trial in 0..3000 {
            let axis = Vec3::new(random(), random(), random());
            let turn = nalgebra::Rotation3::new(axis * 6.0);
            let [t, n, m] = [Vec3::x(), Vec3::y(), Vec3::z()].map(|e| turn * e);
            let joint = Vec3::new(random(), random(), random()) * 5.0;
            let bend = n * 0.3 + m * 0.1;
            let before = Cubic::from_hermite(joint - t + bend, t, joint, t);
            let after = Cubic::from_hermite(joint, t * 0.7, joint + t + bend, t);
            let off = t * [0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-12, -1e-9][trial % 7];
            let slave = Cubic::straight(joint + off + m * 0.3 - n, joint + off + m * 0.3 + n);
            let shared = Some(Joint { tangent: before.b[3] - before.b[2] });
            let mut pieces = Vec::new();
            Pair { joints: [None, shared], ..pair(&slave, &before, 0.5) }.pieces(&mut pieces);
            Pair { joints: [shared, None], ..pair(&slave, &after, 0.5) }.pieces(&mut pieces);
            let covered: f64 = pieces.iter().map(|p| 2.0 * p.branch.sign * (p.u[1] - p.u[0])).sum();
            assert!((covered - exact).abs() < 0.02, "trial {trial}: {covered} {exact} {pieces:?}");
        }
    }

    /// Against brute force: curved strands, the excess is negative exactly inside the pieces.
    #[test]
    fn curved_pairs_agree_with_dense_sampling() {
        let mut numbers = Random(12345);
        let mut random = || 0.5 * numbers.unit();
        let mut num_pieces = 0;
        for _ in 0..300 {
            let mut point =
                |x: f64, y: f64, z: f64| Vec3::new(x + 0.3 * random(), y + 0.3 * random(), z + 0.2 * random());
            let a =
                Cubic { b: [point(-1.0, 0.0, 0.2), point(-0.3, 0.0, 0.2), point(0.3, 0.0, 0.2), point(1.0, 0.0, 0.2)] };
            let b = Cubic {
                b: [point(-0.7, -0.7, 0.0), point(-0.2, -0.2, 0.0), point(0.2, 0.2, 0.0), point(0.7, 0.7, 0.0)],
            };
            let p = Pair { open_end: true, reach: [0.25, 0.35], ..pair(&a, &b, 0.0) };
            let mut pieces = Vec::new();
            p.pieces(&mut pieces);
            num_pieces += pieces.len();
            for k in 0..=400 {
                let u = (k as f64 + 0.123) / 401.0;
                let x = a.point(u);
                let mut feet = Feet::new();
                local_minima(&b, &x, f64::INFINITY, &mut feet);
                let mut expected =
                    feet.as_slice().iter().filter(|f| f.u > 0.0 && f.u < 1.0 && f.distance < p.reach_at(u)).count();
                let end = x - b.b[3];
                expected += usize::from(end.dot(&(b.b[3] - b.b[2])) > 0.0 && end.norm() < p.reach_at(u));
                let found = pieces.iter().filter(|piece| piece.u[0] < u && u < piece.u[1]).count();
                assert_eq!(found, expected, "u = {u}");
            }
        }
        assert!(num_pieces > 100, "the case must have contact: {num_pieces}");
    }
}
