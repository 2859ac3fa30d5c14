//! The twisted ring (Michell 1889, Zajac 1962): a naturally straight rod, bent to a closed circle, twisted, buckles.
//!
//! Set-up: a closed flat circle of length 1, isotropic, B = 1, C/B = 1.0, 1.5, 2.0, nothing held; the excess link is
//! raised. The rod spins about its own centreline freely, so the twist is even and the circle stays an equilibrium.
//! Reference: unstable from ΔLk = √3·B/C on, by two modes at once (out-of-plane cos 2φ, sin 2φ with one frequency; they
//! are the same shape moved along the ring). Exact for an inextensible, unshearable rod; stretch and shear stiffness
//! 1e8 B/L². Found by bisection on the number of unstable directions. Tolerance: 1e-5 with 24 cubic elements (required:
//! 1e-3 with 64).

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{any_equilibrium, history, threshold, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, Ramp};
use supercoil::solve::{Solver, Status};

fn ring(ratio: f64, order: usize, elements: usize) -> Solver {
    let section = Section::isotropic(1.0, ratio, 1e8, 1e8, 0.005);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(elements, order), section, Natural::Straight).unwrap();
    let model = Model { contact: Contact::NONE, rods: vec![rod], ..Model::default() };
    Solver::new(model, any_equilibrium()).unwrap()
}

/// Unstable directions of the flat ring at an excess link.
fn count(ratio: f64, to: f64) -> usize {
    let mut solver = ring(ratio, 3, 24);
    let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
    assert_eq!(report.status, Status::Converged, "{}", history(&report));
    let off = solver.engine().positions(0).iter().map(|r| r.z.abs()).fold(0.0, f64::max);
    assert!(off < 1e-6, "left the plane by {off:e}");
    solver.num_unstable().unwrap()
}

#[test]
fn threshold_of_three_stiffness_ratios() {
    for ratio in [1.0, 1.5, 2.0] {
        let reference = 3f64.sqrt() / ratio;
        let found = threshold(0.95 * reference, 1.05 * reference, 2e-6, |link| count(ratio, link) > 0);
        verify(&format!("Michell-Zajac, C/B = {ratio}"), "ΔLk", found, reference, 1e-5);
        for sign in [1.0, -1.0] {
            let counts = [0.99, 1.01].map(|part| count(ratio, sign * part * reference));
            println!("C/B = {ratio}: unstable directions around {}: {counts:?}", sign * reference);
            assert!(counts[0] == 0 && counts[1] > 0);
        }
    }
}
