//! Natural states that are ramped by the part of them that is in force.
//!
//! * A straight rod, L = 60, clamped at one end, whose natural state is straight up to 20 and from there on a coil of
//!   curvature .5 and twist .15 (the tip of a catheter, mm and N), in 16 steps from `binding` 0 to 1. The coil is free
//!   of stress: the energy is 0 at 1.
//! * Halfway the natural curvature is half of it: without contact an arc of curvature ½κ, free of stress, too.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;

use crate::common::verify;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::rod::{Along, Binding, NaturalStrains, Rod, RodMesh, RodNumber, Section, Shape};
use supercoil::scene::{Contact, Model, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{self, Options, Status};

fn rod(bound: Along<NaturalStrains>, length: f64, elements: usize) -> Model {
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length };
    let free = Along::constant([0.0, 0.0, 1.0, 0.0, 0.0, 0.0].into());
    let binding = Binding { free, bound, part: 0.0 };
    let section = Section::isotropic(1200.0, 928.0, 3e4, 1e4, 0.4);
    let mut rod = Rod::new("tip", &shape, RodMesh::open(elements, 3), section, binding.natural()).unwrap();
    rod.binding = Some(binding);
    let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
    Model { rods: vec![rod], supports, ..Model::default() }
}

fn bind(model: Model, to: f64, steps: usize) -> (solve::Solution, f64) {
    let ramps = vec![Ramp::Number { rod: 0, which: RodNumber::Binding, to }];
    let mut energy = f64::NAN;
    let solution = solve::run(model, &[Stage::new(ramps, steps)], &Options::default(), &mut |progress| {
        energy = observe(progress).energies.total;
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    (solution, energy)
}

#[test]
fn a_tip_coils_up_free_of_stress() {
    let coil = |kappa: f64, twist: f64| NaturalStrains::from([0.0, 0.0, 1.0, kappa, 0.0, twist]);
    let bound = Along::pieces(vec![20.0, 60.0], vec![coil(0.0, 0.0), coil(0.5, 0.15)]).unwrap();
    let (_, energy) = bind(rod(bound, 60.0, 60), 1.0, 16);
    verify("coil of a tip", "energy at binding 1", energy, 0.0, 1e-6);
}

#[test]
fn half_bound_is_half_as_curved() {
    let bound = Along::constant([0.0, 0.0, 1.0, 0.2, 0.0, 0.0].into());
    let model = Model { contact: Contact::NONE, ..rod(bound, 10.0, 10) };
    let (solution, energy) = bind(model, 0.5, 1);
    verify("half bound", "energy", energy, 0.0, 1e-9);
    let end = *solution.solver.engine().positions(0).last().unwrap();
    verify("half bound", "distance of the ends", end.norm(), 2.0 / 0.1 * 0.5f64.sin(), 1e-7);
}
