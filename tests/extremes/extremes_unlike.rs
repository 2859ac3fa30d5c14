//! Unlike rods in contact: each case says *returns* (to which accuracy) or *refuses* (by which status), and holds it.
//!
//! ```text
//!        b  |            two beams, clamped at both ends, cross at their middles; the ends of b are pushed on by δ
//!  a ───────┼───────     F = 192 δ / (L_a³/B_a + L_b³/B_b)     (small displacements; each gives way by its share)
//!           |
//! ```
//!
//! B_a = 1, L_a = 1, ε_a = .02, δ = 2e-4; EA = 1e4 B/L², GA = 1e6 B/L², which shear makes softer by 5e-5; 16 cubic
//! elements unless said.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::observed;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

/// Of beam b.
#[derive(Clone, Copy, Debug)]
struct Beam {
    bending: f64,
    length: f64,
    radius: f64,
    elements: usize,
}

const LIKE: Beam = Beam { bending: 1.0, length: 1.0, radius: 0.02, elements: 16 };
const PUSH: f64 = 2e-4;

struct Outcome {
    status: Status,
    /// Of the contact force, relative to the closed form.
    error: f64,
    /// What is out of balance at rest, over the largest contribution.
    residual: f64,
    /// How far a's middle has moved, over its share of the push, less 1.
    shape: f64,
}

fn rod(name: &str, beam: &Beam, direction: Vec3, height: f64) -> Rod {
    let Beam { bending: b, length, radius, elements } = *beam;
    let per_area = b / (length * length);
    let section = Section::isotropic(b, 0.8 * b, 1e4 * per_area, 1e6 * per_area, radius);
    let shape = Shape::Line { start: Vec3::z() * height - direction * (0.5 * length), direction, length };
    Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
}

fn push(other: &Beam, stiffness: f64) -> Outcome {
    let touching = LIKE.radius + other.radius;
    let rods = vec![rod("a", &LIKE, Vec3::x(), 0.0), rod("b", other, Vec3::y(), 1.01 * touching)];
    let lasts = [0, 1].map(|k: usize| rods[k].num_nodes() - 1);
    let supports = (0..2).flat_map(|rod| [0, lasts[rod]].map(|node| Support::clamp(NodeRef { rod, node }))).collect();
    let law = ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-8 };
    let model = Model { rods, supports, contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let to = -Vec3::z() * (0.01 * touching + PUSH);
    let ramps = [0, lasts[1]].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to });
    let report = solver.step_to(&ramps).unwrap();
    let exact = 192.0 * PUSH / (1.0 + other.length.powi(3) / other.bending);
    let middle = solver.engine().positions(0)[lasts[0] / 2].z;
    let outcome = Outcome {
        status: report.status,
        error: observed(&solver, &report).total_contact_force / exact - 1.0,
        residual: solver.engine().relative_residual(),
        shape: -middle * 192.0 / exact - 1.0,
    };
    let Outcome { status, error, residual, shape } = &outcome;
    println!(
        "{other:?}, κ' {stiffness:e}: {status:?}, force off by {error:.1e}, shape by {shape:.1e}, residual \
         {residual:.1e}"
    );
    outcome
}

fn assert_returns(other: &Beam, stiffness: f64) {
    let outcome = push(other, stiffness);
    assert_eq!(outcome.status, Status::Converged, "{other:?}");
    assert!(outcome.error.abs() < 1e-4, "{other:?}: {:e}", outcome.error);
}

/// *Returns* from 1e-8 to 1e8 times the stiffness: the law goes by the softer one.
#[test]
fn one_far_stiffer_than_the_other() {
    for decade in [-8, -4, -1, 1, 4, 8] {
        assert_returns(&Beam { bending: 10f64.powi(decade), ..LIKE }, 1e2);
    }
}

/// *Returns* where one is up to 1e4 times as long, of the same stiffness at its middle.
#[test]
fn one_far_longer_than_the_other() {
    for length in [10.0f64, 1e2, 1e4] {
        assert_returns(&Beam { length, bending: length.powi(3), ..LIKE }, 1e2);
    }
}

/// *Returns* on meshes of 2 to 1024 elements against 16.
#[test]
fn one_far_finer_than_the_other() {
    for elements in [2, 4, 128, 1024] {
        assert_returns(&Beam { elements, ..LIKE }, 1e2);
    }
}

/// One far thinner than the other, ε_b = 10 to 1e-6 times ε_a. The law goes by the thinner one, κ = κ'B/ε_b⁴, and a
/// force light for it, here 1e-13 B/ε_b² at 1e-4, overlaps the strands by no more than (.53 F/κ√d)^⅔ = 5e-18, d their
/// contact distance: less than frames tell. At 1e-3 it is 2.4e-15, of which rounding of gaps, two or three units in the
/// last place of d, takes 4e-3, and of the force half as much again. Down to 1e-2 force and shape *return*, at 1e-3 the
/// force to 6e-3, at 1e-4 to 2e-2 or not at all, at 1e-6 it is *refused* by `MaxIterations`. A softer law brings it
/// back.
#[test]
fn one_far_thinner_than_the_other() {
    let thin = |decade: i32| Beam { radius: LIKE.radius * 10f64.powi(decade), ..LIKE };
    for decade in [1, -1, -2] {
        assert_returns(&thin(decade), 1e2);
    }
    let outcome = push(&thin(-3), 1e2);
    assert_eq!(outcome.status, Status::Converged);
    assert!(outcome.shape.abs() < 1e-4, "{:e}", outcome.shape);
    assert!(outcome.error.abs() < 1e-4 + 20.0 * outcome.residual, "{:e} unannounced", outcome.error);
    assert!(outcome.error.abs() < 6e-3, "{:e}", outcome.error);
    assert_returns(&thin(-3), 1e-2);
    assert_returns(&thin(-4), 1e-6);
    // at the edge rounding decides whether it is refused; what returns is as right as its residual, at most 1e-3, says
    let edge = push(&thin(-4), 1e2);
    match edge.status {
        Status::Converged => assert!(edge.error.abs() < 1e-4 + 20.0 * edge.residual.min(1e-3), "{:e}", edge.error),
        status => assert_eq!(status, Status::MaxIterations),
    }
    assert_eq!(push(&thin(-6), 1e2).status, Status::MaxIterations);
}
