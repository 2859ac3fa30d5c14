//! A rod between coaxial clamps, bowed, brought together and turned, as a Kirchhoff rod (inextensible, unshearable, L =
//! B = 1) with hard contact, by shooting.
//!
//! ```text
//!              _____
//!            /       \
//!            \       /           y ▲
//!             \     /              │
//!  ▌───────────╲───╱───────────▐   └──▶ x      the flip about y, through the middle of the rod, maps it onto itself
//! ```
//!
//! r′ = t, t′ = M × t, d1′ = (M + (1/C − 1)(M·t) t) × d1, M′ = n × t, with M the internal moment and n the internal
//! force, constant between contacts. The shape is its own image under half a turn about y, so half of the rod is
//! integrated, from its middle (r = 0; t, M, n normal to y; d1 = y) to the clamp (on the x axis' parallel through the
//! other clamp: z = 0, x half the distance, t = x, d1 turned by half of the turns). The partner of a point is its image
//! (−x, y, −z); where they touch, x² + z² has a minimum and the force acts along (x, 0, z).
//!
//! Independent of the engine: its own unknowns, no mesh, no contact law.

#![allow(dead_code)] // every test file uses its part

use std::f64::consts::{PI, TAU};

use super::runge_kutta::extrapolated_step;
use super::shooting::{cross, dot, zero_of};

/// r, t, d1, M, n.
type State = [f64; 15];

/// Angle of t in the middle, n_x, n_z, M_x, M_z there, turns; place and force of the contact, if there is one.
type Unknowns = Vec<f64>;

/// What is prescribed.
#[derive(Debug, Clone, Copy)]
enum Control {
    Turns(f64),
    Force(f64),
}

/// Forces over this are of the order of turns and lengths [B/L²].
const SCALE: f64 = 40.0;

/// Steps of the integrator, of order five, before and after a contact.
const STEPS: usize = 400;

/// A rod: C/B, contact distance, distance of the clamps.
#[derive(Debug, Clone, Copy)]
pub struct ClampedLoop {
    pub twisting: f64,
    pub diameter: f64,
    pub distance: f64,
}

/// A state, in L and B/L².
#[derive(Debug, Clone, Copy)]
pub struct Found {
    pub turns: f64,
    /// Force along x and moment about x that hold the turned clamp.
    pub force: f64,
    pub moment: f64,
    /// Contact force; 0 without contact.
    pub contact: f64,
    /// Elastic energy.
    pub energy: f64,
    /// Largest residual of boundary and contact conditions.
    pub residual: f64,
}

impl ClampedLoop {
    fn rate(&self, y: &State) -> State {
        let (t, d1, m, n) = (&y[3..6], &y[6..9], &y[9..12], &y[12..15]);
        let more = (1.0 / self.twisting - 1.0) * dot(m, t);
        let spin = [0, 1, 2].map(|k| m[k] + more * t[k]);
        let (turn, carried, moment) = (cross(m, t), cross(&spin, d1), cross(n, t));
        let mut rate = [0.0; 15];
        for k in 0..3 {
            (rate[k], rate[3 + k], rate[6 + k], rate[9 + k]) = (t[k], turn[k], carried[k], moment[k]);
        }
        rate
    }

    /// States at equal steps before the contact, and from it on, which is in the middle of the half if there is none.
    fn half(&self, x: &Unknowns) -> (Vec<State>, Vec<State>) {
        let run = |mut y: State, length: f64| {
            let mut all = vec![y];
            for _ in 0..STEPS {
                y = extrapolated_step(&|y| self.rate(y), &y, length / STEPS as f64);
                all.push(y);
            }
            all
        };
        let (sin, cos) = x[0].sin_cos();
        let middle = [0.0, 0.0, 0.0, cos, 0.0, sin, 0.0, 1.0, 0.0, x[3], 0.0, x[4], x[1], 0.0, x[2]];
        let [place, push] = x.get(6..8).map_or([0.25, 0.0], |contact| [contact[0], contact[1]]);
        let before = run(middle, place);
        let mut at = before[STEPS];
        let apart = at[0].hypot(at[2]);
        at[12] -= push * at[0] / apart;
        at[14] -= push * at[2] / apart;
        let after = run(at, 0.5 - place);
        (before, after)
    }

    fn residuals(&self, x: &Unknowns, control: Control) -> Vec<f64> {
        let (before, after) = self.half(x);
        let (at, end) = (&before[STEPS], &after[STEPS]);
        let off = end[8].atan2(end[7]) / PI - x[5];
        let controlled = match control {
            Control::Turns(turns) => x[5] - turns,
            Control::Force(force) => (end[12] - force) / SCALE,
        };
        let mut all = vec![end[0] - 0.5 * self.distance, end[2], end[4], end[5], off - off.round(), controlled];
        if x.len() == 8 {
            all.push(at[0].hypot(at[2]) - 0.5 * self.diameter);
            all.push((at[0] * at[3] + at[2] * at[5]) / self.diameter);
        }
        all
    }

    /// Arc length from the middle, and distance, where the shape comes nearest to its image.
    fn nearest(&self, x: &Unknowns) -> Option<(f64, f64)> {
        let (before, after) = self.half(x);
        let all: Vec<f64> = before.iter().chain(&after[1..]).map(|y| 2.0 * y[0].hypot(y[2])).collect();
        let k = (1..all.len() - 1).find(|&k| all[k] < all[k - 1] && all[k] <= all[k + 1])?;
        Some((k as f64 * 0.25 / STEPS as f64, all[k]))
    }

    fn found(&self, x: &Unknowns, residual: f64) -> Found {
        let (before, after) = self.half(x);
        let density = |y: &State| {
            let torsion = dot(&y[9..12], &y[3..6]);
            0.5 * (dot(&y[9..12], &y[9..12]) - torsion * torsion + torsion * torsion / self.twisting)
        };
        let simpson = |states: &[State]| {
            let weight = |k: usize| if k == 0 || k == STEPS { 1.0 } else { [2.0, 4.0][k % 2] };
            states.iter().enumerate().map(|(k, y)| weight(k) * density(y)).sum::<f64>() / (3.0 * STEPS as f64)
        };
        let [place, contact] = x.get(6..8).map_or([0.25, 0.0], |contact| [contact[0], contact[1]]);
        let end = &after[STEPS];
        Found {
            turns: x[5],
            force: end[12],
            moment: end[9],
            contact,
            energy: 2.0 * (place * simpson(&before) + (0.5 - place) * simpson(&after)),
            residual,
        }
    }

    /// The planar bow.
    fn bow(&self) -> Unknowns {
        // a little off straight, y = ½a(1 − cos 2πs), then brought together in steps
        const FIRST: f64 = 0.01;
        const STEPS: i32 = 30;
        let mut x = vec![0.0, -TAU * TAU, 0.0, 0.0, -4.0 * PI * FIRST.sqrt(), 0.0];
        for k in 0..=STEPS {
            let shortening = FIRST + (1.0 - self.distance - FIRST) * f64::from(k) / f64::from(STEPS);
            let bow = Self { distance: 1.0 - shortening, ..*self };
            let in_plane = |y: &[f64]| {
                let all = bow.residuals(&vec![0.0, y[0], 0.0, 0.0, y[1], 0.0], Control::Turns(0.0));
                vec![all[0], all[2]]
            };
            let (y, _) = zero_of(in_plane, &[x[1], x[4]]);
            (x[1], x[4]) = (y[0], y[1]);
        }
        x
    }

    /// From a state to a value of the control in steps, each predicted from the last two, until `stop`; the largest
    /// residual of the last.
    fn go(
        &self,
        x: &mut Unknowns,
        control: impl Fn(f64) -> Control,
        [from, to, step]: [f64; 3],
        stop: impl Fn(&Unknowns) -> bool,
    ) -> f64 {
        let (mut before, mut left) = (x.clone(), 0.0);
        let steps = ((to - from) / step).ceil().max(1.0);
        for k in 1..=steps as usize {
            let value = from + (to - from) * k as f64 / steps;
            let ahead: Vec<f64> = x.iter().zip(&before).map(|(x, b)| 2.0 * x - b).collect();
            before.clone_from(x);
            (*x, left) = zero_of(|y| self.residuals(&y.to_vec(), control(value)), &ahead);
            if stop(x) {
                break;
            }
        }
        left
    }

    /// States in contact at the turns, in ascending order. The open branch turns back before it touches: it is followed
    /// by its force to the touch, then by the turns again.
    pub fn touching(&self, turns: &[f64]) -> Vec<Found> {
        let mut x = self.bow();
        let _ = self.go(&mut x, Control::Turns, [0.0, 1.0, 0.02], |_| false);
        let force = self.found(&x, 0.0).force;
        let touches = |x: &Unknowns| self.nearest(x).is_some_and(|(_, apart)| apart < self.diameter);
        let _ = self.go(&mut x, Control::Force, [force, force + 200.0, 0.2], touches);
        let (place, _) = self.nearest(&x).unwrap();
        x.extend([place, 0.0]);
        self.at(x, turns)
    }

    /// States without contact at the turns, in ascending order, from the planar bow on.
    pub fn open(&self, turns: &[f64]) -> Vec<Found> {
        self.at(self.bow(), turns)
    }

    fn at(&self, mut x: Unknowns, turns: &[f64]) -> Vec<Found> {
        let state = |&to: &f64| {
            let now = x[5];
            let left = self.go(&mut x, Control::Turns, [now, to, 0.02], |_| false);
            self.found(&x, left)
        };
        turns.iter().map(state).collect()
    }
}
