//! Contact zones of a pair of cubics: the exact sub-intervals of one curve (the slave) whose orthogonal projection on
//! the other (the master) is closer than a given reach.
//!
//! The contact potential is an integral along the slave over the parts where the gap is below a threshold. Integrand and
//! slope vanish at the ends of these parts, so a quadrature of gradient and Hessian between *exact* ends is consistent with
//! the potential, and Newton's method converges quadratically; with sloppy ends it does not (interval segmentation:
//! Meier, Popp & Wall 2016).
//!
//! A foot on the master moves along it as the slave parameter u moves: a branch v(u). Branches are cut
//! * where the foot enters or leaves the master at v = 0 or 1: roots of (a(u) − b(0))·b'(0), a cubic in u, likewise at 1;
//! * where distance − reach changes sign: bracketed by samples and by minima between samples, then by safeguarded Newton.
//!
//! At an open end of the master the end point itself is the foot on the far side (a spherical cap); the distance to a
//! curve is C¹ across that change.

pub(super) mod facing;
pub(super) mod straight;

use super::curve::Cubic;
use super::projection::{Feet, local_minima, smooth_joint};
use crate::math::Vec3;
use crate::math::bernstein::{Roots, roots};

/// Samples per branch interval; the bracketing misses only dips narrower than the wiggles of one cubic between them.
const NUM_SAMPLES: usize = 7;
/// Iterations of the safeguarded root finder; bisection alone ends after 53.
const MAX_ROOT_ITERATIONS: usize = 100;

/// What the foot does along a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FootKind {
    /// Orthogonal projection on the interior of the master curve.
    Orthogonal,
    /// The open start of the master.
    Start,
    /// The open end of the master.
    End,
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
    /// d distance / du \[L\].
    slope: f64,
    /// d² distance / du² \[L\].
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
    /// What the foot does.
    pub kind: FootKind,
    /// Where the distance is smallest inside the piece.
    pub nearest: Sample,
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

/// Feet nearer to a joint than this (in v) are given to a segment by the joint's tangent.
const NEAR_JOINT: f64 = 1e-7;

/// On which side of an end of the master the foot is, over the slave: the sign of a cubic in Bernstein form.
struct Side {
    coefficients: [f64; 4],
    joined: bool,
    tangent_norm_sq: f64,
}

impl Side {
    fn new(slave: &Cubic, foot: &Vec3, tangent: &Vec3, joined: bool) -> Self {
        let mut coefficients = slave.b.map(|p| (p - foot).dot(tangent));
        let size = slave.b.iter().fold(foot.amax(), |size, p| size.max(p.amax()));
        let noise = 8.0 * f64::EPSILON * size * tangent.amax();
        if joined && coefficients.iter().all(|c| c.abs() <= noise) {
            coefficients = [0.0; 4];
        }
        Self { coefficients, joined, tangent_norm_sq: tangent.norm_squared() }
    }

    fn at(&self, u: f64) -> f64 {
        let [mut a, mut b, mut c, d] = self.coefficients;
        let mix = |x: f64, y: f64| x + (y - x) * u;
        (a, b, c) = (mix(a, b), mix(b, c), mix(c, d));
        (a, b) = (mix(a, b), mix(b, c));
        mix(a, b)
    }
}

impl Pair<'_> {
    fn reach_at(&self, u: f64) -> f64 {
        self.reach[0] + (self.reach[1] - self.reach[0]) * u
    }

    fn reach_slope(&self) -> f64 {
        self.reach[1] - self.reach[0]
    }

    /// The branch at slave parameter `u`, starting from foot `guess`.
    pub(super) fn touch(&self, u: f64, guess: f64, kind: FootKind) -> Touch {
        let a = self.slave.point(u);
        let v = self.foot_of(&a, guess, kind);
        let (b, tangent, curvature) = self.master.derivatives(v);
        let chord = a - b;
        let distance = chord.norm();
        Touch { u, v, distance, normal: unit(&chord, distance), tangent, curvature }
    }

    fn foot_of(&self, a: &Vec3, guess: f64, kind: FootKind) -> f64 {
        match kind {
            FootKind::Start => 0.0,
            FootKind::End => 1.0,
            FootKind::Orthogonal => self.foot(a, guess),
        }
    }

    /// Follows the branch to slave parameter `u`, starting from foot `guess`.
    pub fn sample(&self, u: f64, guess: f64, kind: FootKind) -> Sample {
        let (a, da, dda) = self.slave.derivatives(u);
        let v = self.foot_of(&a, guess, kind);
        let (b, db, ddb) = self.master.derivatives(v);
        let chord = a - b;
        let distance = chord.norm();
        let normal = chord / distance;
        let slope = normal.dot(&da);
        let mut curvature = (da.norm_squared() - slope * slope) / distance + normal.dot(&dda);
        if kind == FootKind::Orthogonal {
            let d_vv = db.norm_squared() / distance - normal.dot(&ddb);
            let d_uv = da.dot(&db) / distance;
            curvature -= d_uv * d_uv / d_vv;
        }
        Sample { u, v, distance, slope, curvature }
    }

    /// Newton on (a − b(v))·b'(v) from a near guess; if it leaves the segment, the certified projection decides.
    fn foot(&self, a: &Vec3, guess: f64) -> f64 {
        let mut v = guess;
        let mut last = f64::INFINITY;
        for _ in 0..12 {
            let (b, db, ddb) = self.master.derivatives(v);
            let f = (a - b).dot(&db);
            let slope = (a - b).dot(&ddb) - db.norm_squared();
            let step = -f / slope;
            if !step.is_finite() || slope >= 0.0 {
                break;
            }
            v += step;
            if !(-0.5..=1.5).contains(&v) {
                break;
            }
            // Where the connection is longer than the segment, rounding keeps the last steps above a few ulp: they only stop shrinking.
            let noise = step.abs() < 1e-12 && step.abs() >= 0.25 * last;
            if step.abs() <= 4.0 * f64::EPSILON || noise {
                return v.clamp(0.0, 1.0);
            }
            last = step.abs();
        }
        let mut feet = Feet::new();
        local_minima(self.master, a, f64::INFINITY, &mut feet);
        let nearest = feet.as_slice().iter().min_by(|x, y| (x.u - guess).abs().total_cmp(&(y.u - guess).abs()));
        nearest.map_or(v.clamp(0.0, 1.0), |foot| foot.u)
    }

    /// All pieces of this pair, appended to `out`.
    pub fn pieces(&self, out: &mut Vec<Piece>) {
        let sides = self.sides();
        let (breaks, count) = breaks(&sides);
        for window in breaks[..count].windows(2) {
            let (start, end) = (window[0], window[1]);
            if end - start <= 16.0 * f64::EPSILON {
                continue;
            }
            let middle = 0.5 * (start + end);
            let a = self.slave.point(middle);
            let mut feet = Feet::new();
            local_minima(self.master, &a, f64::INFINITY, &mut feet);
            // ours are feet after the start and before the end
            let ours = [sides[0].at(middle) >= 0.0, sides[1].at(middle) < 0.0];
            let near = |v: f64| [v < NEAR_JOINT, v > 1.0 - NEAR_JOINT];
            let foreign = |v: f64, k: usize| near(v)[k] && sides[k].joined && !ours[k];
            let inside = |v: &f64| {
                let within = [sides[0].joined && ours[0] || *v > 0.0, sides[1].joined && ours[1] || *v < 1.0];
                within == [true; 2] && !foreign(*v, 0) && !foreign(*v, 1)
            };
            let mut seen = [false; 2];
            for v in feet.as_slice().iter().map(|f| f.u).filter(inside) {
                seen = [seen[0] || near(v)[0], seen[1] || near(v)[1]];
                self.branch(start, end, v, FootKind::Orthogonal, out);
            }
            for k in 0..2 {
                if sides[k].joined && ours[k] && !seen[k] && self.rests_on_joint(&sides[k], middle, k as f64) {
                    self.branch(start, end, k as f64, FootKind::Orthogonal, out);
                }
            }
            let (b0, db0, _) = self.master.derivatives(0.0);
            if self.open_start && (a - b0).dot(&db0) <= 0.0 {
                self.branch(start, end, 0.0, FootKind::Start, out);
            }
            let (b1, db1, _) = self.master.derivatives(1.0);
            if self.open_end && (a - b1).dot(&db1) >= 0.0 {
                self.branch(start, end, 1.0, FootKind::End, out);
            }
        }
    }

    /// The end of the master at v is a foot of the slave's point at u to rounding, and a local minimum of the distance.
    fn rests_on_joint(&self, side: &Side, u: f64, v: f64) -> bool {
        let a = self.slave.point(u);
        let (b, db, ddb) = self.master.derivatives(v);
        let tangent = side.tangent_norm_sq;
        side.at(u).abs() <= NEAR_JOINT * tangent && db.norm_squared() > (a - b).dot(&ddb)
    }

    fn sides(&self) -> [Side; 2] {
        let b = &self.master.b;
        let own = [(b[0], b[1] - b[0]), (b[3], b[3] - b[2])];
        std::array::from_fn(|k| {
            let (foot, tangent) = own[k];
            let joint = self.joints[k];
            Side::new(self.slave, &foot, &joint.map_or(tangent, |j| j.tangent), joint.is_some())
        })
    }

    /// Pieces of the branch over [start, end] whose foot at the middle is `v_middle`.
    fn branch(&self, start: f64, end: f64, v_middle: f64, kind: FootKind, out: &mut Vec<Piece>) {
        let mut samples = [Sample { u: 0.0, v: 0.0, distance: 0.0, slope: 0.0, curvature: 0.0 }; NUM_SAMPLES];
        let half = NUM_SAMPLES / 2;
        let at = |k: usize| {
            if k == NUM_SAMPLES - 1 { end } else { start + (end - start) * k as f64 / (NUM_SAMPLES - 1) as f64 }
        };
        samples[half] = self.sample(at(half), v_middle, kind);
        for k in (0..half).rev() {
            samples[k] = self.sample(at(k), samples[k + 1].v, kind);
        }
        for k in half + 1..NUM_SAMPLES {
            samples[k] = self.sample(at(k), samples[k - 1].v, kind);
        }
        let mut crossings: [Option<Sample>; 2 * NUM_SAMPLES] = [None; 2 * NUM_SAMPLES];
        let mut count = 0;
        for k in 0..NUM_SAMPLES - 1 {
            let (s0, s1) = (&samples[k], &samples[k + 1]);
            let (h0, h1) = (self.excess(s0), self.excess(s1));
            if (h0 < 0.0) != (h1 < 0.0) {
                crossings[count] = Some(self.root(s0, s1, kind, Target::Excess));
                count += 1;
            } else {
                let (d0, d1) = (s0.slope - self.reach_slope(), s1.slope - self.reach_slope());
                if (h0 >= 0.0 && d0 < 0.0 && d1 > 0.0) || (h0 < 0.0 && d0 > 0.0 && d1 < 0.0) {
                    let extremum = self.root(s0, s1, kind, Target::ExcessSlope);
                    if (self.excess(&extremum) < 0.0) != (h0 < 0.0) {
                        crossings[count] = Some(self.root(s0, &extremum, kind, Target::Excess));
                        crossings[count + 1] = Some(self.root(&extremum, s1, kind, Target::Excess));
                        count += 2;
                    }
                }
            }
        }
        let mut open = if self.excess(&samples[0]) < 0.0 { Some(samples[0]) } else { None };
        for crossing in crossings.iter().take(count).flatten() {
            open = match open {
                Some(first) => {
                    self.finish(&first, crossing, &samples, kind, out);
                    None
                }
                None => Some(*crossing),
            };
        }
        if let Some(first) = open {
            self.finish(&first, &samples[NUM_SAMPLES - 1], &samples, kind, out);
        }
    }

    fn excess(&self, sample: &Sample) -> f64 {
        sample.distance - self.reach_at(sample.u)
    }

    /// Root of the target between two samples where it has opposite signs: Newton kept inside a shrinking bracket.
    fn root(&self, s0: &Sample, s1: &Sample, kind: FootKind, target: Target) -> Sample {
        let value = |s: &Sample| match target {
            Target::Excess => (self.excess(s), s.slope - self.reach_slope()),
            Target::ExcessSlope => (s.slope - self.reach_slope(), s.curvature),
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
            let (left, right) = (low.u.min(high.u), low.u.max(high.u));
            let mut next = sample.u - f / df;
            if !(next > left && next < right) {
                if f == 0.0 || (next - sample.u).abs() <= f64::EPSILON {
                    return sample;
                }
                next = 0.5 * (left + right);
                if next <= left || next >= right {
                    return sample;
                }
            }
            let done = (next - sample.u).abs() <= 2.0 * f64::EPSILON;
            sample = self.sample(next, sample.v, kind);
            if done {
                return sample;
            }
        }
        sample
    }

    fn finish(&self, first: &Sample, last: &Sample, samples: &[Sample], kind: FootKind, out: &mut Vec<Piece>) {
        if last.u - first.u <= 0.0 {
            return;
        }
        let inside = samples.iter().filter(|s| s.u > first.u && s.u < last.u);
        let mut nearest = if first.distance <= last.distance { *first } else { *last };
        let mut previous = *first;
        for sample in inside.chain(std::iter::once(last)) {
            if sample.distance < nearest.distance {
                nearest = *sample;
            }
            if previous.slope < 0.0 && sample.slope > 0.0 {
                let minimum = self.root(&previous, sample, kind, Target::Slope);
                if minimum.distance < nearest.distance {
                    nearest = minimum;
                }
            }
            previous = *sample;
        }
        out.push(Piece { u: [first.u, last.u], v: [first.v, last.v], kind, nearest });
    }
}

/// A vector of this length as a unit vector; zero stays zero.
fn unit(v: &Vec3, length: f64) -> Vec3 {
    if length > 0.0 { v / length } else { Vec3::zeros() }
}

/// 0, 1 and the slave parameters whose foot passes an end of the master, ascending.
fn breaks(sides: &[Side; 2]) -> ([f64; 8], usize) {
    let mut breaks = [0.0; 8];
    let mut count = 1;
    for side in sides {
        let mut found = Roots::new();
        roots(&side.coefficients, &mut found);
        for &u in found.as_slice() {
            breaks[count] = u;
            count += 1;
        }
    }
    breaks[count] = 1.0;
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
    use super::*;
    use crate::math::random::Random;

    fn line(from: [f64; 3], to: [f64; 3]) -> Cubic {
        Cubic::straight(Vec3::from(from), Vec3::from(to))
    }

    fn pair<'a>(slave: &'a Cubic, master: &'a Cubic, reach: f64) -> Pair<'a> {
        Pair { slave, master, open_start: false, open_end: false, reach: [reach; 2], joints: [None; 2] }
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
        assert_eq!(pieces.len(), 3);
        let cap = (0.09f64 - 0.04).sqrt();
        assert_eq!(pieces[0].kind, FootKind::Start);
        assert!((pieces[0].u[0] - (1.0 - cap) / 4.0).abs() < 1e-15);
        assert_eq!(pieces[2].kind, FootKind::End);
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
            let covered: f64 = pieces.iter().map(|p| 2.0 * (p.u[1] - p.u[0])).sum();
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
