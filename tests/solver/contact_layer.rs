//! A law sets in over a layer (B/κ)^¼ along lines of contact. Where the mesh resolves it, nodes no more than 1.4 layers
//! apart, the twisting moment of a long plectoneme depends on neither law nor mesh; where it does not, the pressure
//! gathers between nodes and the moment swings with the number of elements (`docs/ACCURACY.md`).
//!
//! pUC19: 2686 base pairs, link lowered by fifteen, from a plectoneme. Limit of 640 to 1024 elements at κ' = 100 and
//! 10³: M = −3.95355 pN nm to 1e-5.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::observed;
use supercoil::dna;
use supercoil::rod::{Natural, Plectoneme, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model};
use supercoil::solve::{Options, Solver, Status};

const LENGTH: f64 = 2686.0 * dna::RISE;
const EXCESS_LINK: f64 = -15.0;
const RADIUS: f64 = 2.5;
const LIMIT: f64 = -3.95355;

fn twisting_moment(elements: usize, stiffness: f64) -> f64 {
    let (bending, twisting, stretching) = (dna::BENDING_STIFFNESS, dna::TWIST_STIFFNESS, dna::STRETCH_MODULUS);
    let section = Section::isotropic(bending, twisting, stretching, stretching, RADIUS);
    let shape = Shape::Plectoneme(Plectoneme::of_link(LENGTH, 5.1, bending, twisting, EXCESS_LINK).unwrap());
    let rod = Rod::new("dna", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    let rods = vec![rod.with_excess_link(EXCESS_LINK).unwrap()];
    let law = ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-8 };
    let model = Model { rods, contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let report = solver.step_to(&[]).unwrap();
    assert_eq!(report.status, Status::Converged, "{elements} elements, κ' {stiffness}");
    observed(&solver, &report).links[0].seam_moment
}

#[test]
fn a_resolved_layer_gives_the_same_moment_under_any_law() {
    for (elements, stiffness, allowed) in [(240, 10.0, 1.2e-4), (384, 100.0, 6e-5), (480, 1e3, 6e-5)] {
        let apart = LENGTH / f64::from(3 * elements) / (RADIUS * f64::powf(stiffness, -0.25));
        let error = twisting_moment(elements as usize, stiffness) / LIMIT - 1.0;
        println!("{elements} elements, κ' {stiffness}, nodes {apart:.2} layers apart: moment off by {error:.1e}");
        assert!(apart < 1.45 && error.abs() < allowed, "{elements} elements, κ' {stiffness}: {error:e}");
    }
}
