//! Snaps tell the energy that they set free: a clamped strut, pressed, in steps and at once, beyond its Euler load.

use crate::common;

use std::ops::ControlFlow;

use common::verify;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{Options, Status, run};

const STRETCHING: f64 = 1e4;

/// The states of a strut of length and bending stiffness 1 whose end comes nearer by `by`.
fn pressed(by: f64, steps: usize) -> Vec<Observation> {
    let section = Section::isotropic(1.0, 1.0, STRETCHING, STRETCHING, 0.01);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rods = vec![Rod::new("strut", &shape, RodMesh::open(16, 3), section, Natural::Straight).unwrap()];
    let end = NodeRef { rod: 0, node: 48 };
    let supports = [NodeRef { rod: 0, node: 0 }, end].map(Support::clamp).to_vec();
    let contact = Contact::NONE;
    let model = Model { rods, supports, contact, ..Model::default() };
    let stage = Stage { ramps: vec![Ramp::Displacement { node: end, to: -Vec3::x() * by }], steps };
    let mut states = Vec::new();
    let solution = run(model, &[stage], &Options::default(), &mut |progress| {
        states.push(observe(progress));
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged);
    states
}

#[test]
fn a_snap_tells_its_energy() {
    let by = 0.02;
    let end = pressed(by, 1).pop().unwrap();
    let straight = 0.5 * STRETCHING * by * by;
    verify("strut pressed at once", "energy set free, B/L", end.energy_released, straight - end.energies.total, 1e-7);
    assert!(end.energy_released > 1.0, "{}", end.energy_released);
    assert!(end.notes.iter().any(|note| note.starts_with("snap")), "{:?}", end.notes);
}

/// The Euler load is 4π² B/L², at a shortening of .00395.
#[test]
fn a_stable_path_sets_nothing_free() {
    let states = pressed(0.0038, 2);
    assert!(states.iter().all(|state| state.energy_released == 0.0 && state.notes.is_empty()));
    let released: Vec<f64> = pressed(0.02, 10).iter().map(|state| state.energy_released).collect();
    assert_eq!(released.iter().filter(|released| **released > 0.0).count(), 1, "{released:?}");
}
