//! Loss of stability under dead forces: a strip tips over, a column falls under its own weight.
//!
//!  * Cantilever strip of length 1 along x, tip force P along −z, soft bending B = 1 in y, stiff bending 1e7 in z, GJ =
//!    0.6: P L²/√(B GJ) = 4.0125993436 (Prandtl, Michell 1899), for a strip that does not bend before it tips over.
//!  * Upright column of length 1, isotropic, clamped at its foot, weight q per length: q L³/B = 7.8373474389 (Greenhill
//!    1881).
//!
//! Found by bisection on the number of unstable directions. Tolerance: 1e-5 relative; 24 cubic elements; stretch and
//! shear stiffness 1e6 and more.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{any_equilibrium, cantilever, history, threshold, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, LineLoad, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Solver, Status};

/// Load factor at which the number of unstable directions leaves zero, near `guess`; also that number just above.
fn critical_factor(model: Model, guess: f64) -> (f64, usize) {
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    let mut count = |factor: f64| {
        let report = solver.step_to(&[Ramp::Load { to: factor }]).unwrap();
        assert_eq!(report.status, Status::Converged, "{}", history(&report));
        solver.num_unstable().unwrap()
    };
    let critical = threshold(0.97 * guess, 1.03 * guess, 1e-7 * guess, |factor| count(factor) > 0);
    (critical, count(critical * 1.001))
}

#[test]
fn strip() {
    let (soft, twisting, reference) = (1.0, 0.6f64, 4.012_599_343_6);
    // d1 along z, d2 along −y: bending about d2 moves the rod along z
    let section = Section { shearing: [1e9; 2], stretching: 1e9, bending: [soft, 1e7], twisting, contact_radius: 1e-3 };
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("strip", &shape, RodMesh::open(24, 3), section, Natural::Straight).unwrap();
    let unit = (soft * twisting).sqrt();
    let (factor, count) = critical_factor(cantilever(rod, Vec3::z() * -unit, Vec3::zeros()), reference);
    verify("lateral buckling of a strip", "P L²/√(B GJ)", factor, reference, 1e-5 * reference);
    assert_eq!(count, 1, "tips over to either side of one plane");
}

#[test]
fn column_under_its_own_weight() {
    let reference = 7.837_347_438_9;
    let section = Section::isotropic(1.0, 1.3, 1e6, 1e6, 1e-3);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::z(), length: 1.0 };
    let rod = Rod::new("column", &shape, RodMesh::open(24, 3), section, Natural::Straight).unwrap();
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        line_loads: vec![LineLoad::of_force(0, -Vec3::z())],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    let (factor, count) = critical_factor(model, reference);
    verify("self-weight column", "q L³/B", factor, reference, 1e-5 * reference);
    assert_eq!(count, 2, "isotropic: two planes at once");
}
