//! Planar rods up to their first self-touch, against shooting on the continuous equations (inextensible, unshearable).
//!
//! * Elastica of length L, both ends clamped along x and brought together: end shortening over L and end force P L²/B when
//!   it first touches itself, for diameters D/L = .01 and .02.
//! * Ring of radius R under uniform pressure p: p R³/B when opposite sides first touch, for D/R = .01, .05 and .1.
//!
//! The touch is found by the secant method on the certified gap, from the side without contact.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Progress, Solver, Status};

fn to(solver: &mut Solver, ramp: Ramp) -> Observation {
    let report = solver.step_to(&[ramp]).unwrap();
    assert_eq!(report.status, Status::Converged);
    let progress =
        Progress { engine: solver.engine(), stage: 0, step: 0, fraction: 1.0, report: &report, seconds: 0.0 };
    observe(&progress)
}

/// Drives a parameter from `from` towards the value where the gap closes; returns it and the last state.
fn touch(mut at: impl FnMut(f64) -> Observation, from: f64, step: f64) -> (f64, Observation) {
    let gap = |seen: &Observation| seen.min_gap.map_or(f64::INFINITY, |g| g.upper);
    let mut previous = (from, gap(&at(from)));
    let mut value = from + step;
    for _ in 0..200 {
        let seen = at(value);
        let here = (value, gap(&seen));
        if here.1 < 1e-8 {
            return (value, seen);
        }
        let slope = (here.1 - previous.1) / (here.0 - previous.0);
        let root = here.0 - here.1 / slope;
        // never beyond the touch: a hair before it, and no farther than the predictor can be trusted
        let next = if slope.is_finite() && slope < 0.0 { root - 1e-4 * (root - here.0) } else { f64::INFINITY };
        previous = here;
        value = next.min(value + step);
    }
    panic!("no touch found");
}

#[test]
fn clamped_elastica_touches_itself() {
    for (diameter, shortening, force) in [(0.01, 0.836607567, 71.28305966), (0.02, 0.824512192, 70.39908508)] {
        let section = Section::isotropic(1.0, 1.0, 1e7, 1e7, 0.5 * diameter);
        let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rod = Rod::new("elastica", &shape, false, section, 32, 3, Natural::Straight).unwrap();
        let last = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 }), Support::clamp(last)];
        let model = Model { rods: vec![rod], supports, planar: true, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let bring = |by: f64| Ramp::Displacement { node: last, to: -Vec3::x() * by };
        // just past the Euler load 4π² B/L², where only the first mode is unstable, then on
        for by in [5e-6, 1e-3, 0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7] {
            to(&mut solver, bring(by));
        }
        let (found, seen) = touch(|by| to(&mut solver, bring(by)), 0.75, 2e-3);
        let push = seen.reactions.iter().find(|r| r.node == last.node).unwrap().force[0].abs();
        println!("D/L {diameter}: shortening {found:.7} ({shortening}), force {push:.5} ({force})");
        assert!((found - shortening).abs() < 2e-5, "shortening {found}");
        assert!((push / force - 1.0).abs() < 2e-4, "force {push}");
    }
}

#[test]
fn ring_under_pressure_touches_itself() {
    for (diameter, pressure) in [(0.01, 5.2174186), (0.05, 5.1031792), (0.1, 4.9681208)] {
        let section = Section::isotropic(1.0, 1.0, 1e6, 1e6, 0.5 * diameter);
        let shape = Shape::Circle { length: std::f64::consts::TAU, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, true, section, 32, 3, Natural::Straight).unwrap();
        let model = Model { rods: vec![rod], planar: true, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let press = |to: f64| Ramp::Pressure { rod: 0, to };
        for p in [2.5, 3.1, 3.3, 3.6, 3.9, 4.2, 4.5, 4.7] {
            to(&mut solver, press(p));
        }
        let (found, _) = touch(|p| to(&mut solver, press(p)), 4.8, 5e-3);
        println!("D/R {diameter}: pressure {found:.6} ({pressure})");
        assert!((found / pressure - 1.0).abs() < 1e-4, "pressure {found}");
    }
}
