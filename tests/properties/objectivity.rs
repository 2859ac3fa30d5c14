//! Objectivity and path independence (Crisfield & Jelenić 1999).
//!
//! Strains and energy do not change under a rigid motion put on top; the end state depends on the ends of the path
//! only: on where the clamps are and how often they were turned, not on the order or the number of the steps.
//!
//! Set-up: (1) rods of order 1, 2, 3 in arbitrary strained states, moved rigidly; (2) a rod of length 1 along x,
//! clamped at both ends, its far clamp pushed in, moved sideways and turned about x, in different orders and steps, and
//! back again; (3) the same rod turned about space axes by many turns of both clamps, loaded by a dead force.
//! References: the same state before and after. Tolerance: 1e-13 relative for (1); for (2) and (3) what rounding makes
//! of lengths with EA/B = 1e4, 1e-11.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;
use crate::random;

use common::{elastic_energy, end_of, history, strains, strains_of, verify};
use random::Random;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

const START: NodeRef = NodeRef { rod: 0, node: 0 };

fn beam(order: usize, elements: usize) -> Rod {
    let section =
        Section { shearing: [8e3, 6e3], stretching: 1e4, bending: [1.0, 2.0], twisting: 1.3, contact_radius: 0.01 };
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    Rod::new("beam", &shape, RodMesh::open(elements, order), section, Natural::Straight).unwrap()
}

#[test]
fn strains_and_energy_do_not_see_rigid_motions() {
    let mut next = Random(7);
    let mut worst = [0.0f64; 2];
    for order in 1..=3 {
        for _ in 0..100 {
            let rod = beam(order, 3);
            let mut vector = |size: f64| next.vector() * size;
            let positions: Vec<Vec3> = rod.positions.iter().map(|r| r + vector(0.02)).collect();
            let frames: Vec<Quat> = rod.frames.iter().map(|q| Quat::from_scaled_axis(vector(0.5)) * q).collect();
            let (turn, shift) = (Quat::from_scaled_axis(vector(40.0)), vector(1.0));
            let moved: Vec<Vec3> = positions.iter().map(|r| turn * r + shift).collect();
            let turned: Vec<Quat> = frames.iter().map(|q| turn * q).collect();
            let (before, after) = (strains(&rod, &positions, &frames), strains(&rod, &moved, &turned));
            let size = before.iter().flatten().fold(0.0f64, |a, x| a.max(x.abs()));
            let pairs = || before.iter().flatten().zip(after.iter().flatten());
            worst[0] = worst[0].max(pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size);
            let energies = [&before, &after].map(|s| s.iter().flatten().map(|x| x * x).sum::<f64>());
            worst[1] = worst[1].max((energies[1] / energies[0] - 1.0).abs());
        }
    }
    verify("objectivity", "change of strains under rigid motions", worst[0], 0.0, 1e-13);
    verify("objectivity", "change of energy under rigid motions", worst[1], 0.0, 1e-13);
}

/// The rod between two clamps.
fn clamped(order: usize, elements: usize) -> Solver {
    let rod = beam(order, elements);
    let supports = vec![Support::clamp(START), Support::clamp(end_of(&rod))];
    let model = Model { supports, contact: Contact::NONE, rods: vec![rod], ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

/// Moves ramps to their targets in `steps` equal steps from the fractions `from` to `to` of their way.
fn go(solver: &mut Solver, ramps: &[Ramp], from: f64, to: f64, steps: usize) {
    for i in 1..=steps {
        let fraction = from + (to - from) * (i as f64 / steps as f64);
        let partly = |ramp: &Ramp| match ramp {
            Ramp::Rotation { node, axis, to } => Ramp::Rotation { node: *node, axis: *axis, to: to * fraction },
            Ramp::Displacement { node, to } => Ramp::Displacement { node: *node, to: to * fraction },
            Ramp::Load { to } => Ramp::Load { to: to * fraction },
            other => other.clone(),
        };
        let ramps: Vec<Ramp> = ramps.iter().map(partly).collect();
        let report = solver.step_to(&ramps).unwrap();
        assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{fraction}: {}", history(&report));
    }
}

/// Largest distance of nodes plus largest angle between frames of two states.
fn distance(a: &Solver, b: &Solver) -> f64 {
    let (a, b) = (a.engine(), b.engine());
    let far = a.positions(0).iter().zip(b.positions(0)).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
    // 2 |vec(p* q)|: an angle below 1e-8 is lost in the real part
    let angle = |p: &Quat, q: &Quat| 2.0 * (p.inverse() * q).imag().norm();
    far + a.frames(0).iter().zip(b.frames(0)).map(|(p, q)| angle(p, q)).fold(0.0, f64::max)
}

#[test]
fn the_end_state_does_not_depend_on_the_path() {
    for (order, elements) in [(1, 24), (2, 12), (3, 8)] {
        let straight = clamped(order, elements);
        let end = end_of(&beam(order, elements));
        let turn = [Ramp::Rotation { node: end, axis: Vec3::x(), to: 0.25 }];
        let push = [Ramp::Displacement { node: end, to: Vec3::new(-0.03, 0.2, 0.1) }];
        let both = [turn[0].clone(), push[0].clone()];
        let mut together = clamped(order, elements);
        go(&mut together, &both, 0.0, 1.0, 1);
        let mut slowly = clamped(order, elements);
        go(&mut slowly, &both, 0.0, 1.0, 16);
        let mut turned_first = clamped(order, elements);
        go(&mut turned_first, &turn, 0.0, 1.0, 3);
        go(&mut turned_first, &push, 0.0, 1.0, 5);
        let mut pushed_first = clamped(order, elements);
        go(&mut pushed_first, &push, 0.0, 1.0, 4);
        go(&mut pushed_first, &turn, 0.0, 1.0, 2);
        for (name, other) in [("16 steps", &slowly), ("turn first", &turned_first), ("push first", &pushed_first)] {
            let what = format!("order {order}: one step against {name}");
            verify("path independence", &what, distance(&together, other), 0.0, 1e-11);
        }
        go(&mut turned_first, &both, 1.0, 0.0, 7);
        let what = format!("order {order}: there and back");
        verify("path independence", &what, distance(&straight, &turned_first), 0.0, 1e-11);
    }
}

/// Turning both clamps about the line through them turns the strained rod like a rigid body.
#[test]
fn a_strained_rod_turned_by_many_turns_keeps_its_energy() {
    let mut solver = clamped(3, 8);
    let end = end_of(&beam(3, 8));
    go(&mut solver, &[Ramp::Displacement { node: end, to: Vec3::new(-0.2, 0.0, 0.0) }], 0.0, 1.0, 4);
    let (energy, before) = (elastic_energy(&solver), strains_of(&solver));
    assert!(energy > 1.0, "buckled: {energy}");
    let mut start = clamped(3, 8);
    start.set_state(solver.engine().state().clone()).unwrap();
    let turns = |to: f64| [START, end].map(|node| Ramp::Rotation { node, axis: Vec3::x(), to });
    let mut worst = [0.0f64; 2];
    for i in 1..=56 {
        go(&mut solver, &turns(f64::from(i) / 8.0), 0.0, 1.0, 1);
        let strains = strains_of(&solver);
        let change =
            strains.iter().flatten().zip(before.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        worst = [worst[0].max((elastic_energy(&solver) / energy - 1.0).abs()), worst[1].max(change)];
    }
    verify("path independence", "energy during 7 turns of both clamps", worst[0], 0.0, 1e-11);
    verify("path independence", "strains during 7 turns of both clamps", worst[1], 0.0, 1e-10);
    verify("path independence", "state after 7 turns of both clamps", distance(&start, &solver), 0.0, 1e-10);
}

/// A cantilever under a dead force too weak to make it bistable, its clamp turned about two axes.
#[test]
fn turns_of_a_loaded_cantilever_leave_no_trace() {
    for axis in [Vec3::x(), Vec3::y(), Vec3::new(1.0, -2.0, 0.5)] {
        let build = || {
            let rod = beam(3, 8);
            let load = NodeLoad { node: end_of(&rod), force: Vec3::new(0.3, -0.5, 1.2), moment: Vec3::zeros() };
            let supports = vec![Support::clamp(START)];
            let model =
                Model { supports, loads: vec![load], contact: Contact::NONE, rods: vec![rod], ..Model::default() };
            let mut solver = Solver::new(model, Options::default()).unwrap();
            go(&mut solver, &[Ramp::Load { to: 1.0 }], 0.0, 1.0, 1);
            solver
        };
        let (still, mut turned) = (build(), build());
        go(&mut turned, &[Ramp::Rotation { node: START, axis, to: 5.0 }], 0.0, 1.0, 60);
        let what = format!("cantilever turned 5 times about ({}, {}, {})", axis.x, axis.y, axis.z);
        verify("path independence", &what, distance(&still, &turned), 0.0, 1e-11);
    }
}

/// Half a turn of a pushed clamp at once: the rod passes tangents that are nearly singular, on all meshes and about all
/// axes.
#[test]
fn half_a_turn_of_a_clamp_comes_to_rest_in_one_step() {
    for (order, elements) in [(1, 12), (2, 6), (3, 4), (3, 8), (3, 16)] {
        for axis in [Vec3::z(), Vec3::x(), Vec3::y()] {
            let mut solver = clamped(order, elements);
            let end = end_of(&beam(order, elements));
            for turn in [0.0, 0.25, -0.25] {
                let push = Ramp::Displacement { node: end, to: Vec3::new(-0.05, 0.2, -0.1) };
                let report = solver.step_to(&[Ramp::Rotation { node: end, axis, to: turn }, push]).unwrap();
                assert_eq!(report.status, Status::Converged, "order {order}, {elements} elements, {axis:?} to {turn}");
            }
        }
    }
}
