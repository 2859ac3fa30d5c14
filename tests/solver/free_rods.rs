//! Several rods that nobody holds: what they do to each other is all that holds them.
//!
//! ```text
//!    ___   ___        ___ ___         _______
//!   /   \ /   \      /  _|_  \      /    _|_ \
//!   \___/ \___/      \__|___|/      \____|___|___    one strand of each hangs in the other
//!     apart            linked              |___|
//! ```
//!
//! Rings of B = C = 1, EA = GA = 1e4, contact radius 1, some drawn as stadia, relax to circles of energy 2π²B/L
//! wherever they have room to. Each of them can then move as a rigid body and spin about its centreline at no cost.
//! (Motions of all but one rod were held by springs of 1e-9 B/h³ before, and rounding decided: stadia 20 ε apart ended
//! as unstable after 59 iterations.)

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::{PI, TAU};

use common::{history, observed, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model};
use supercoil::solve::{Options, Solver, Status, StepReport};

const LAWS: [ContactLaw; 2] = [
    ContactLaw::Penalty { stiffness: 1e3 },
    ContactLaw::AugmentedLagrangian { stiffness: 100.0, tol_penetration: 1e-8 },
];

/// In the plane through its centre across z.
fn stadium(center: Vec3) -> Shape {
    let point = |k: usize| {
        let (angle, side) = (PI * (k % 16) as f64 / 16.0 - 0.5 * PI, if k < 16 { 1.0 } else { -1.0 });
        center + Vec3::new(2.0 + 4.0 * angle.cos(), 4.0 * angle.sin(), 0.0) * side
    };
    Shape::Points((0..32).map(point).collect())
}

fn circle(center: Vec3) -> Shape {
    Shape::Circle { length: 4.0 * TAU, center, normal: Vec3::y() }
}

fn rested(shapes: &[Shape], law: ContactLaw) -> (Solver, StepReport) {
    let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 1.0);
    let ring = |shape: &Shape| Rod::new("ring", shape, RodMesh::closed(24, 3), section, Natural::Straight).unwrap();
    let model = Model { rods: shapes.iter().map(ring).collect(), contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let report = solver.find_equilibrium();
    println!("{} iterations, residual {:.1e}", report.iterations, solver.engine().relative_residual());
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
    (solver, report)
}

/// Energy over that of circles.
fn energy(solver: &Solver, report: &StepReport) -> f64 {
    let seen = observed(solver, report);
    let circles: f64 = solver.engine().model().rods.iter().map(|rod| 2.0 * PI * PI / rod.length).sum();
    (seen.energies.total - seen.energies.contact) / circles
}

#[test]
fn apart_they_become_circles() {
    for law in LAWS {
        for count in [2, 5] {
            let shapes: Vec<Shape> =
                (0..count).map(|k| stadium(Vec3::new(0.0, 0.1, 1.0) * (20.0 * f64::from(k)))).collect();
            let (solver, report) = rested(&shapes, law);
            let case = format!("{count} free rings apart, {law:?}");
            verify(&case, "energy over that of circles", energy(&solver, &report), 1.0, 1e-6);
            assert!(report.iterations < 30, "{}", history(&report));
        }
    }
}

#[test]
fn linked_with_room_they_become_circles() {
    for law in LAWS {
        for centers in [vec![7.0], vec![-7.0, 7.0]] {
            let mut shapes: Vec<Shape> = centers.iter().map(|x| circle(Vec3::x() * *x)).collect();
            shapes.push(stadium(Vec3::zeros()));
            let (solver, report) = rested(&shapes, law);
            let case = format!("{} loosely linked rings, {law:?}", shapes.len());
            verify(&case, "energy over that of circles", energy(&solver, &report), 1.0, 1e-6);
        }
    }
}
