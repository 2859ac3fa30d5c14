//! The twisted closed ring in self-contact as a Kirchhoff rod (inextensible, unshearable, B = 1, L = 1) with hard
//! contact, by shooting: the states at which its contact changes, to eleven digits.
//!
//! ```text
//!        z ▲   ___
//!          │ /     \  s = 1/4
//!          │ \     /
//!          │  \   /
//!          │   \ /      outer contact, s = b
//!          ├────X──── x middle contact, s = 0
//! ```
//!
//! States with three perpendicular twofold axes: x through the middle of the crossing, z through both loops' ends, y.
//! A quarter of the ring, 0 ≤ s ≤ 1/4, with r′ = t, t′ = M × t, M′ = n × t (M the internal moment, n the internal
//! force, constant between contacts) starts on the x axis, t_x = M_x = 0, and ends on the z axis, x = y = 0, t_z = M_z
//! = n_z = 0. The other strand of the crossing is (−x, −y, z), so the outer contacts lie where x² + y² has a minimum,
//! and the force there acts along (x, y, 0). Independent of the engine: its own unknowns, no mesh, no contact law.
//!
//! Whether the middle contact can carry what it does without opening is told by the Hessian of |r(s) − r(u)|², which is
//! singular at the events one point → two and three points → line.

#![allow(dead_code)] // one test file uses it

use std::f64::consts::{PI, TAU};

use super::runge_kutta::extrapolated_step;
use super::shooting::{cross, dot, zero_of};

/// r, t, M, n, and a direction carried along without turning about t.
type State = [f64; 15];

/// Steps of the integrator, of order five, on a quarter of the ring; a quarter as many before an outer contact; both
/// multiples of four.
const STEPS: usize = 1200;
/// C/B.
const TWIST_OVER_BEND: f64 = 1.5;

/// States along the path, from none to three contact points; those between the events at an excess link, for C = 1.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The strands touch in the middle without force.
    FirstContact,
    OnePoint(f64),
    /// One point, about to open into two.
    OneToTwo,
    TwoPoints(f64),
    /// Two points; the strands touch in the middle without force.
    TwoToThree,
    ThreePoints(f64),
    /// Three points, the middle one about to open into a line.
    ThreeToLine,
}

/// Numbers of a state, lengths in L, forces in B/L².
#[derive(Debug, Clone, Copy)]
pub struct Ring {
    pub writhe: f64,
    /// M₃L/(2πB).
    pub torque: f64,
    /// Bending energy over that of the circle.
    pub bending: f64,
    /// Smaller eigenvalue of the Hessian of |r(s) − r(u)| in the middle.
    pub curvature: f64,
    /// Contact force in the middle and at each outer point.
    pub middle: f64,
    pub outer: f64,
    /// Arc length from the middle to an outer point.
    pub place: f64,
    /// Largest residual of the boundary and contact conditions.
    pub residual: f64,
}

fn rate(y: &State) -> State {
    let (t, m, n) = (&y[3..6], &y[6..9], &y[9..12]);
    let (turn, moment) = (cross(m, t), cross(n, t));
    let along = -dot(&y[12..15], &turn);
    let mut rate = [0.0; 15];
    for k in 0..3 {
        (rate[k], rate[3 + k], rate[6 + k], rate[12 + k]) = (t[k], turn[k], moment[k], along * t[k]);
    }
    rate
}

/// The quarter ring: states at equal steps before and after the outer contact, if there is one.
fn quarter(start: State, place: Option<f64>, outer: f64) -> (Vec<State>, Vec<State>) {
    let run = |mut y: State, length: f64, steps: usize| {
        let mut all = vec![y];
        for _ in 0..steps {
            y = extrapolated_step(&rate, &y, length / steps as f64);
            all.push(y);
        }
        all
    };
    let Some(place) = place else { return (run(start, 0.25, STEPS), Vec::new()) };
    let first = run(start, place, STEPS / 4);
    let mut y = first[first.len() - 1];
    let distance = y[0].hypot(y[1]);
    // the other strand pushes outwards: n⁺ = n⁻ − force on the rod
    y[9] -= outer * y[0] / distance;
    y[10] -= outer * y[1] / distance;
    let second = run(y, 0.25 - place, STEPS);
    (first, second)
}

/// Unknowns: angle of the tangent at s = 0, M_y, M_z, n_y, n_z; then n_x where the middle carries force, or half the
/// distance there where it is open; then place and force of the outer contact.
struct Problem {
    diameter: f64,
    event: Event,
}

impl Problem {
    fn has_outer(&self) -> bool {
        matches!(self.event, Event::TwoPoints(_) | Event::TwoToThree | Event::ThreePoints(_) | Event::ThreeToLine)
    }

    fn presses(&self) -> bool {
        matches!(self.event, Event::OnePoint(_) | Event::OneToTwo | Event::ThreePoints(_) | Event::ThreeToLine)
    }

    fn is_singular(&self) -> bool {
        matches!(self.event, Event::OneToTwo | Event::ThreeToLine)
    }

    fn excess_link(&self) -> Option<f64> {
        match self.event {
            Event::OnePoint(link) | Event::TwoPoints(link) | Event::ThreePoints(link) => Some(link),
            _ => None,
        }
    }

    fn parts(&self, x: &[f64]) -> (State, Option<f64>, f64) {
        let push = if self.presses() { x[5] } else { 0.0 };
        let half = if matches!(self.event, Event::TwoPoints(_)) { x[5] } else { 0.5 * self.diameter };
        let (sin, cos) = x[0].sin_cos();
        let start = [half, 0.0, 0.0, 0.0, sin, cos, 0.0, x[1], x[2], push, x[3], x[4], 1.0, 0.0, 0.0];
        if self.has_outer() { (start, Some(x[x.len() - 2]), x[x.len() - 1]) } else { (start, None, 0.0) }
    }

    fn residuals(&self, x: &[f64]) -> Vec<f64> {
        let (start, place, outer) = self.parts(x);
        let (first, second) = quarter(start, place, outer);
        let end = second.last().or(first.last()).copied().unwrap_or(start);
        // moments and forces scaled to lengths
        let mut all = vec![end[0], end[1], end[5], end[8] / TAU, end[11] / 40.0];
        if place.is_some() {
            let at = first[first.len() - 1];
            all.push(at[0].hypot(at[1]) - 0.5 * self.diameter);
            all.push((at[0] * at[3] + at[1] * at[4]) / self.diameter);
        }
        if let Some(link) = self.excess_link() {
            // up to a multiple of ½: that it is none is seen in the writhe of the result
            let ends = second.last().or(first.last()).map_or(0.0, ribbon_writhe);
            let off = 2.0 * (ends + dot(&start[6..9], &start[3..6]) / (TAU * TWIST_OVER_BEND) - link);
            all.push(0.5 * (off - off.round()));
        }
        if self.is_singular() {
            all.push(opening(&start));
        }
        all
    }
}

/// Smaller eigenvalue of the Hessian of ½|r(s) − r(u)|² at s = 0, where the other strand is (−x, −y, z)(u): |t|² + 2x
/// t′_x twice, and −(t_z² − t_y²).
fn opening(start: &State) -> f64 {
    let turn = cross(&start[6..9], &start[3..6]);
    let mixed = start[4] * start[4] - start[5] * start[5];
    1.0 + 2.0 * start[0] * turn[0] - mixed.abs()
}

/// Writhe of the whole ring. A direction that is x at s = 0, normal to t, and carried along without turning is off from
/// z, which is normal to t at s = 1/4, by an angle φ; by symmetry the ribbon that joins these directions has the twist
/// −4φ/2π, and a link that is a multiple of ½, told by a sum over pairs of points.
fn writhe(quarter: &[State]) -> f64 {
    let fraction = ribbon_writhe(&quarter[quarter.len() - 1]);
    let every = quarter.len() / 300;
    let turned = |y: &State, signs: [f64; 3]| -> [f64; 6] { std::array::from_fn(|k| y[k] * signs[k % 3]) };
    // turns about no axis, z (backwards), y, x (backwards), in the order along the ring
    let mut curve: Vec<[f64; 6]> = Vec::new();
    let sampled: Vec<&State> = quarter.iter().step_by(every).collect();
    curve.extend(sampled.iter().map(|y| turned(y, [1.0, 1.0, 1.0])));
    curve.extend(sampled.iter().rev().map(|y| turned(y, [-1.0, -1.0, 1.0])));
    curve.extend(sampled.iter().map(|y| turned(y, [-1.0, 1.0, -1.0])));
    curve.extend(sampled.iter().rev().map(|y| turned(y, [1.0, -1.0, -1.0])));
    let n = curve.len();
    let edge = |i: usize| -> [f64; 3] { std::array::from_fn(|k| curve[(i + 1) % n][k] - curve[i][k]) };
    let middle = |i: usize| -> [f64; 3] { std::array::from_fn(|k| 0.5 * (curve[(i + 1) % n][k] + curve[i][k])) };
    let mut rough = 0.0;
    for i in 0..n {
        for j in 0..i {
            let apart: [f64; 3] = std::array::from_fn(|k| middle(i)[k] - middle(j)[k]);
            let distance = dot(&apart, &apart).sqrt();
            if distance > 0.0 {
                rough += dot(&cross(&edge(i), &edge(j)), &apart) / distance.powi(3) / TAU;
            }
        }
    }
    let halves = (2.0 * (rough - fraction)).round();
    fraction + 0.5 * halves
}

/// The writhe up to a multiple of ½, from the end of the quarter.
fn ribbon_writhe(end: &State) -> f64 {
    let (t, carried) = (&end[3..6], &end[12..15]);
    let z = [0.0, 0.0, 1.0];
    let angle = dot(&cross(carried, &z), t).atan2(dot(carried, &z));
    -4.0 * angle / TAU
}

/// A state: events of a thick ring from a guess, of thinner ones by lowering the diameter from there, states between
/// events by changing the link from the next event.
pub fn event_of(event: Event, diameter: f64) -> Ring {
    match event {
        Event::OnePoint(link) => at_link(link, diameter, Event::OneToTwo, &Event::OnePoint, |_| {}),
        Event::TwoPoints(link) => {
            at_link(link, diameter, Event::TwoToThree, &Event::TwoPoints, |x| x.insert(5, 0.5 * diameter))
        }
        Event::ThreePoints(link) => at_link(link, diameter, Event::ThreeToLine, &Event::ThreePoints, |_| {}),
        _ => from_guess(event, diameter).0,
    }
}

fn from_guess(event: Event, diameter: f64) -> (Ring, Vec<f64>) {
    const GUESSED: f64 = 0.03;
    const LOWERINGS: i32 = 8;
    let guess: &[f64] = match event {
        Event::FirstContact => &[-0.7, -1.1, 1.3, -85.0, 0.0],
        Event::OneToTwo => &[-0.4, -12.0, 1.0, -60.0, 0.0, -140.0],
        Event::TwoToThree => &[-0.36, -9.7, 2.9, -196.0, 0.0, 0.036, 299.0],
        _ => &[-0.36, -9.8, 3.0, -204.0, 0.0, -15.0, 0.039, 311.0],
    };
    let (mut ring, mut x) = solve_from(event, GUESSED, guess);
    let mut before = x.clone();
    let steps = if diameter == GUESSED { 0 } else { LOWERINGS };
    for k in 1..=steps {
        let lowered = GUESSED * (diameter / GUESSED).powf(f64::from(k) / f64::from(steps));
        let ahead: Vec<f64> = x.iter().zip(&before).map(|(x, b)| 2.0 * x - b).collect();
        before = x;
        (ring, x) = solve_from(event, lowered, &ahead);
    }
    (ring, x)
}

/// From the event nearby, its unknowns made those of `state`, to an excess link.
fn at_link(
    link: f64,
    diameter: f64,
    nearby: Event,
    state: &dyn Fn(f64) -> Event,
    adapt: impl Fn(&mut Vec<f64>),
) -> Ring {
    const STEP: f64 = 0.03;
    let (mut ring, mut x) = from_guess(nearby, diameter);
    adapt(&mut x);
    let mut before = x.clone();
    let from = ring.writhe + ring.torque / TWIST_OVER_BEND;
    let steps = ((link - from).abs() / STEP).ceil();
    for k in 1..=steps as i32 {
        let to = from + (link - from) * f64::from(k) / steps;
        let ahead: Vec<f64> = x.iter().zip(&before).map(|(x, b)| 2.0 * x - b).collect();
        before = x;
        (ring, x) = solve_from(state(to), diameter, &ahead);
    }
    ring
}

/// The state found from a guess.
fn solve_from(event: Event, diameter: f64, guess: &[f64]) -> (Ring, Vec<f64>) {
    let problem = Problem { diameter, event };
    let (x, left) = zero_of(|x| problem.residuals(x), guess);
    (numbers(&problem, &x, left), x)
}

fn numbers(problem: &Problem, x: &[f64], residual: f64) -> Ring {
    let (start, place, outer) = problem.parts(x);
    let (first, second) = quarter(start, place, outer);
    // Boole's rule of 4κ² = 4(|M|² − M₃²)
    let torque = dot(&start[6..9], &start[3..6]);
    let boole = |states: &[State], length: f64| {
        let n = states.len() - 1;
        let weight = |i: usize| match i % 4 {
            0 if i == 0 || i == n => 7.0,
            0 => 14.0,
            2 => 12.0,
            _ => 32.0,
        };
        let f = |y: &State| dot(&y[6..9], &y[6..9]) - torque * torque;
        states.iter().enumerate().map(|(i, y)| weight(i) * f(y)).sum::<f64>() * 2.0 * length / (45.0 * n as f64)
    };
    let energy = match place {
        None => boole(&first, 0.25),
        Some(place) => boole(&first, place) + boole(&second, 0.25 - place),
    };
    let mut curve = first;
    curve.extend(second.into_iter().skip(1));
    Ring {
        writhe: writhe(&curve),
        torque: torque / TAU,
        bending: 4.0 * 0.5 * energy / (2.0 * PI * PI),
        curvature: opening(&start) / (2.0 * start[0]),
        middle: if problem.presses() { 2.0 * x[5].abs() } else { 0.0 },
        outer,
        place: place.unwrap_or(0.0),
        residual,
    }
}
