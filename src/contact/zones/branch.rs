//! One branch of the projection: its foot traced along the slave, cut where distance − reach changes sign.

use super::piece::{NUM_SAMPLES, falling_root};
use super::{Branch, BranchPiece, FootKind, Projection, Sample, SegmentPair, unit};
use crate::contact::curves::input::JOINT;
use crate::contact::measures::MAX_STEPS;
use crate::math::Vec3;

/// Newton step, of a segment's parameter, below which a step that does not shrink by much is rounding, because where
/// the connection is longer than the segment, rounding keeps the last steps above a few units in the last place.
const STALLED: f64 = 1e-12;

/// Function whose root is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RootOf {
    /// distance − reach.
    Excess,
    /// Its slope in u.
    ExcessSlope,
    /// Slope of the distance in u.
    Slope,
}

impl SegmentPair<'_> {
    /// The projection at parameter `t` of a branch, from a guess of the other parameter, and du/dt, u the slave's
    /// parameter; negative where the branch is subtracted.
    pub(in crate::contact) fn project(&self, t: f64, guess: f64, branch: &Branch) -> (Projection, f64) {
        let (u, v, rate) = if branch.kind == FootKind::Fold {
            let u = self.slave_of(t, guess, branch);
            (u, t, self.rate(u, t))
        } else {
            (t, self.foot_of(&self.slave.point(t), guess, branch), 1.0)
        };
        let (b, tangent, curvature) = self.master.derivatives(v);
        let chord = self.slave.point(u) - b;
        let distance = chord.norm();
        (Projection { u, v, distance, normal: unit(&chord, distance), tangent, curvature }, branch.sign * rate)
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
    pub(super) fn sample(&self, t: f64, guess: f64, branch: &Branch) -> Sample {
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

    /// Newton's method for f from a near guess; bisection if it leaves the interval or f has the wrong slope for the
    /// branch.
    fn foot(&self, a: &Vec3, guess: f64, branch: &Branch) -> f64 {
        let [low, high] = branch.within;
        let border = JOINT * (high - low);
        let mut v = guess;
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
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
            let noise = step.abs() < STALLED && step.abs() >= 0.25 * last;
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

    /// Pieces of a branch over a range of parameters, from a guess of the other parameter in the middle.
    pub(super) fn branch(&self, [start, end]: [f64; 2], guess: f64, branch: Branch, out: &mut Vec<BranchPiece>) {
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
                crossings[count] = Some(self.root(s0, s1, &branch, RootOf::Excess));
                count += 1;
            } else {
                let (d0, d1) = (self.excess_slope(s0), self.excess_slope(s1));
                if (h0 >= 0.0 && d0 < 0.0 && d1 > 0.0) || (h0 < 0.0 && d0 > 0.0 && d1 < 0.0) {
                    let extremum = self.root(s0, s1, &branch, RootOf::ExcessSlope);
                    if (self.excess(&extremum) < 0.0) != (h0 < 0.0) {
                        crossings[count] = Some(self.root(s0, &extremum, &branch, RootOf::Excess));
                        crossings[count + 1] = Some(self.root(&extremum, s1, &branch, RootOf::Excess));
                        count += 2;
                    }
                }
            }
        }
        let mut open = if self.excess(&samples[0]) < 0.0 { Some(samples[0]) } else { None };
        for crossing in crossings.iter().take(count).flatten() {
            open = match open {
                Some(first) => {
                    self.finish([&first, crossing], &samples, branch, out);
                    None
                }
                None => Some(*crossing),
            };
        }
        if let Some(first) = open {
            self.finish([&first, &samples[NUM_SAMPLES - 1]], &samples, branch, out);
        }
    }

    fn excess_slope(&self, sample: &Sample) -> f64 {
        sample.slope - self.reach_slope() * sample.rate
    }

    fn excess(&self, sample: &Sample) -> f64 {
        sample.distance - self.reach_at(sample.u)
    }

    /// Root of the target between two samples where it has opposite signs: Newton's method inside a shrinking bracket.
    fn root(&self, s0: &Sample, s1: &Sample, branch: &Branch, target: RootOf) -> Sample {
        let value = |s: &Sample| match target {
            RootOf::Excess => (self.excess(s), self.excess_slope(s)),
            RootOf::ExcessSlope => (self.excess_slope(s), s.curvature),
            RootOf::Slope => (s.slope, s.curvature),
        };
        let (mut low, mut high) = (*s0, *s1);
        let sign = value(&low).0 < 0.0;
        let mut sample = if value(&low).0.abs() < value(&high).0.abs() { low } else { high };
        // as many Newton steps as bisections
        for _ in 0..2 * f64::MANTISSA_DIGITS {
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

    /// The piece between two ends, with its nearest point.
    fn finish(&self, [first, last]: [&Sample; 2], samples: &[Sample], branch: Branch, out: &mut Vec<BranchPiece>) {
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
                let minimum = self.root(&previous, sample, &branch, RootOf::Slope);
                if minimum.distance < nearest.distance {
                    nearest = minimum;
                }
            }
            previous = *sample;
        }
        out.push(BranchPiece { u: [first.u, last.u], v: [first.v, last.v], branch, nearest });
    }
}
