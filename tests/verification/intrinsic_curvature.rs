//! Rods curved and twisted by nature: the free state, and the state straightened by constant moments.
//!
//! Set-up: a rod of length 1 with intrinsic curvature and twist u0 = (2.0, −1.5, 4.0) in its own frame, anisotropic
//! section K = diag(1, 2.5, 1.6), EA = GA = 1e6.
//!  * clamped at one end only it takes the stress-free helix R(s) = exp(s u0×), r(s) = ∫R e3 ds (closed form: rotation
//!    by |u0| s about u0);
//!  * held straight and untwisted by clamps at both ends, the material moment is −K u0 at every point and the force is
//!    0;
//!  * the same end moment −K u0, dead, straightens the free rod again.
//!
//! All closed form. Tolerances: discretisation (16 cubic elements) for the helix, rounding for the straight states.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{cantilever, elastic_energy, end_of, fitted_order, history, sci, strains_of, tip, verify, verify_point};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

const NATURAL: [f64; 3] = [2.0, -1.5, 4.0];
const STIFFNESS: [f64; 3] = [1.0, 2.5, 1.6];

fn rod(elements: usize, order: usize) -> Rod {
    let section = Section {
        shearing: [1e6; 2],
        stretching: 1e6,
        bending: [STIFFNESS[0], STIFFNESS[1]],
        twisting: STIFFNESS[2],
        contact_radius: 0.01,
    };
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::z(), length: 1.0 };
    Rod::new("curl", &shape, RodMesh::open(elements, order), section, Natural::Uniform { kappa: NATURAL }).unwrap()
}

/// Dead end moment that balances the straight rod: −K u0 in the frame of the straight rod.
fn straightening_moment(rod: &Rod) -> Vec3 {
    rod.frames[0] * Vec3::from_fn(|i, _| -STIFFNESS[i] * NATURAL[i])
}

/// End of the stress-free helix that starts with the frame of the rod.
fn helix_end(rod: &Rod) -> Vec3 {
    let (u, e3) = (Vec3::from(NATURAL), Vec3::z());
    let (angle, axis) = (u.norm(), u.normalize());
    let along = axis * axis.dot(&e3);
    let end = along + (e3 - along) * (angle.sin() / angle) + axis.cross(&e3) * ((1.0 - angle.cos()) / angle);
    rod.frames[0] * end
}

/// From the straight start, in one step, to the free helix.
fn relaxed(elements: usize, order: usize) -> Solver {
    let rod = rod(elements, order);
    let moment = straightening_moment(&rod);
    let mut solver = Solver::new(cantilever(rod, Vec3::zeros(), moment), Options::default()).unwrap();
    let report = solver.step_to(&[Ramp::Load { to: 0.0 }]).unwrap();
    println!("order {order}, {elements} elements: {}", history(&report));
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
    solver
}

#[test]
fn the_free_rod_takes_its_helix() {
    let solver = relaxed(16, 3);
    verify_point("intrinsic curvature, free end", &tip(&solver), helix_end(&rod(16, 3)).into(), 1e-8);
    verify("intrinsic curvature, free rod", "elastic energy", elastic_energy(&solver), 0.0, 1e-20);
    for order in 1..=3 {
        let meshes = [16, 32, 64].map(|n| n / order);
        let errors = meshes.map(|n| (tip(&relaxed(n, order)) - helix_end(&rod(n, order))).norm());
        let fitted = fitted_order(&meshes.map(|n| 1.0 / n as f64), &errors);
        println!("order {order}: errors {}", sci(&errors));
        verify(
            "intrinsic curvature, free rod",
            &format!("order of the end, p = {order}"),
            fitted,
            2.0 * order as f64,
            0.2,
        );
    }
}

#[test]
fn held_straight_the_moment_is_constant_and_the_force_zero() {
    for order in 1..=3 {
        // frames that do not turn: its natural twist taken out
        let rod = rod(6, order).with_twist(-NATURAL[2] / std::f64::consts::TAU).unwrap();
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 }), Support::clamp(end_of(&rod))];
        let straight = rod.positions.clone();
        let model = Model { supports, contact: Contact::NONE, rods: vec![rod], ..Model::default() };
        let mut solver = Solver::new(model, common::any_equilibrium()).unwrap();
        let report = solver.find_equilibrium();
        assert_eq!(report.status, Status::Converged, "{}", history(&report));
        assert!(report.history[0].len() <= 2, "already in equilibrium: {}", history(&report));
        let moved = solver.engine().positions(0).iter().zip(&straight).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        verify("intrinsic curvature, held straight", &format!("displacement, p = {order}"), moved, 0.0, 1e-13);
        for strain in strains_of(&solver) {
            for i in 0..3 {
                let (force, moment) = (1e6 * strain[i], STIFFNESS[i] * strain[i + 3]);
                assert!(force.abs() < 1e-8, "order {order}: force {force:e}");
                assert!((moment + STIFFNESS[i] * NATURAL[i]).abs() < 1e-12, "order {order}: moment {moment}");
            }
        }
    }
}

/// The helix is straightened by dead moments at its end. They have no potential, so the load goes up in a few steps.
#[test]
fn an_end_moment_straightens_the_helix() {
    let mut solver = relaxed(8, 3);
    *solver.options_mut() = common::any_equilibrium();
    for i in 1..=10 {
        let report = solver.step_to(&[Ramp::Load { to: f64::from(i) / 10.0 }]).unwrap();
        println!("{i}: {}", history(&report));
        assert_eq!(report.status, Status::Converged, "{}", history(&report));
    }
    verify_point("intrinsic curvature, straightened", &tip(&solver), [0.0, 0.0, 1.0], 1e-9);
    let energy: f64 = (0..3).map(|i| 0.5 * STIFFNESS[i] * NATURAL[i].powi(2)).sum();
    verify("intrinsic curvature, straightened", "elastic energy", elastic_energy(&solver), energy, 1e-9);
}
