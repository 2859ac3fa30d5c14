//! Greenhill's problem (1883): a straight rod under twist and tension loses stability.
//!
//! Set-up: a rod of length L = 1 along x, its first end clamped; its last end kept on the axis, its frame turned about
//! the axis by a prescribed angle, free to slide along the axis, with a dead tension T along it. Isotropic, B = 1, C =
//! 1.3; stretch and shear stiffness 1e8 B/L², so that the section is that of an inextensible rod. On the straight
//! branch the moment is M = C · angle/L. 24 cubic elements. Reference: M L/B at which the first bending mode becomes
//! unstable, for TL²/B from −30 to 100, from the buckling determinant of the clamped rod (all digits). Found by
//! bisection on the number of unstable directions. Tolerance: 1e-5 relative.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{any_equilibrium, end_of, history, threshold, verify};
use std::f64::consts::TAU;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Solver, State, Status};

const TWISTING: f64 = 1.3;
const RIGID: f64 = 1e8;

/// Under a part of the tension.
fn rod_under(tension: f64, load: f64) -> (Solver, NodeRef) {
    let section = Section::isotropic(1.0, TWISTING, RIGID, RIGID, 0.01);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("rod", &shape, RodMesh::open(24, 3), section, Natural::Straight).unwrap();
    let end = end_of(&rod);
    let sliding = Support { node: end, position: [false, true, true], rotation: [true; 3] };
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 }), sliding],
        loads: vec![NodeLoad { node: end, force: Vec3::x() * tension, moment: Vec3::zeros() }],
        load,
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    (Solver::new(model, any_equilibrium()).unwrap(), end)
}

/// The straight state: twisted evenly, stretched by T/EA. Exact for the discrete rod too.
fn straight(solver: &Solver, moment: f64, tension: f64) -> State {
    let state = solver.engine().state();
    let (start, last) = (state.frames()[0], state.frames().len() - 1);
    let along = (0..=last).map(|i| i as f64 / last as f64);
    let positions = along.clone().map(|s| Vec3::x() * (s * (1.0 + tension / RIGID))).collect();
    let frames = along.map(|s| Quat::from_scaled_axis(Vec3::x() * (s * moment / TWISTING)) * start).collect();
    state.with_nodes(positions, frames)
}

/// Twisting moment at which the straight rod becomes unstable: inertia of the tangent at the exact straight state. (A
/// search that close to the critical moment would only amplify rounding.)
fn critical_moment(tension: f64, guess: f64) -> f64 {
    let (mut solver, _) = rod_under(tension, 1.0);
    let mut unstable = |moment: f64| {
        let state = straight(&solver, moment, tension);
        solver.set_state(state).unwrap();
        solver.num_unstable().unwrap() > 0
    };
    threshold(0.98 * guess, 1.02 * guess, 1e-7 * guess, &mut unstable)
}

/// The solver itself, turning the end, arrives at that straight state, stable below the critical moment and unstable
/// above.
#[test]
fn the_solver_finds_the_straight_state() {
    let (tension, critical) = (5.0, 9.717_748);
    for (part, count) in [(0.5, 0), (0.99, 0), (1.01, 2)] {
        let (mut solver, end) = rod_under(tension, 0.0);
        let turns = part * critical / (TWISTING * TAU);
        let ramps = [Ramp::Rotation { node: end, axis: Vec3::x(), to: turns }, Ramp::Load { to: 1.0 }];
        let report = solver.step_to(&ramps).unwrap();
        assert_eq!((report.status, report.num_unstable), (Status::Converged, count), "{}", history(&report));
        let exact = straight(&solver, part * critical, tension);
        let pairs = solver.engine().positions(0).iter().zip(exact.positions());
        let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        verify("Greenhill, TL²/B = 5", &format!("straight state at {part} of the critical moment"), error, 0.0, 1e-9);
    }
}

#[test]
fn without_tension() {
    let reference = 8.986_818_916;
    verify("Greenhill, T = 0", "M L/B", critical_moment(0.0, reference), reference, 1e-5 * reference);
}

#[test]
fn under_tension() {
    for (tension, reference) in
        [(1.0, 9.134_730), (5.0, 9.717_748), (10.0, 10.428_856), (50.0, 15.589_324), (100.0, 20.983_501)]
    {
        let found = critical_moment(tension, reference);
        verify(&format!("Greenhill, TL²/B = {tension}"), "M L/B", found, reference, 1e-5 * reference);
    }
}

#[test]
fn under_compression() {
    for (tension, reference) in [(-5.0, 8.232_811), (-10.0, 7.451_016), (-20.0, 5.771_136), (-30.0, 3.800_430)] {
        let found = critical_moment(tension, reference);
        verify(&format!("Greenhill, TL²/B = {tension}"), "M L/B", found, reference, 1e-5 * reference);
    }
}
