//! Rods far from the origin come to rest as exactly as rods at it. A long rod reaches far from wherever the origin is.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::observed;
use supercoil::math::Vec3;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Plectoneme, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Options, Solver, Status};

/// Relative residual at rest of a rod whose nodes are moved so many node spacings, and what is seen of it.
fn rest(rod: &Rod, law: ContactLaw, spacings: f64, links: &[f64]) -> (f64, Observation) {
    let shift = Vec3::new(1.0, -0.4, 0.7).normalize() * (spacings * rod.spacing());
    let mut rod = rod.clone();
    rod.positions.iter_mut().for_each(|x| *x += shift);
    let model = Model { rods: vec![rod], contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let mut last = None;
    for &to in links {
        let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
        assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{spacings}");
        last = Some(observed(&solver, &report));
    }
    (solver.engine().relative_residual(), last.unwrap())
}

/// At the origin and a million node spacings away: residual at rest within a factor of 3 (where both are above `floor`,
/// the rounding of forces that no coordinate has a part in), contact force and twisting moment as the start shape is
/// the same to the rounding of its coordinates.
fn compare(name: &str, rod: &Rod, law: ContactLaw, links: &[f64]) {
    let [(near, here), (far, there)] = [0.0, 1e6].map(|spacings| rest(rod, law, spacings, links));
    println!("{name}: relative residual {near:.1e} at the origin, {far:.1e} a million node spacings away");
    assert!(far <= 3.0 * near.max(1e-12), "{near:e} {far:e}");
    for of in [|o: &Observation| o.total_contact_force, |o: &Observation| o.links[0].seam_moment] {
        assert!((of(&there) / of(&here) - 1.0).abs() < 1e-6, "{} {}", of(&here), of(&there));
    }
}

#[test]
fn a_ring_in_contact() {
    let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.01);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let ring = Rod::new("ring", &shape, RodMesh::closed(32, 3), section, Natural::Straight).unwrap();
    compare("ring", &ring, ContactLaw::Penalty { stiffness: 100.0 }, &[0.9, 1.3]);
    compare("ring", &ring, Contact::default().law, &[0.9, 1.3]);
}

#[test]
fn a_plectoneme() {
    let length = 1000.0;
    let turns = -0.06 * length / (0.34 * 10.5);
    let shape = Shape::Plectoneme(Plectoneme::of_link(length, 5.0, 205.7, 308.6, turns).unwrap());
    let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
    let rod = Rod::new("dna", &shape, RodMesh::closed(200, 3), section, Natural::Straight).unwrap();
    let rod = rod.with_excess_link(turns).unwrap();
    let law = ContactLaw::AugmentedLagrangian { stiffness: 10.0, tol_penetration: 1e-8 };
    compare("plectoneme", &rod, law, &[turns]);
}
