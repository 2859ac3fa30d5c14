//! Screened electrostatics beside hard contact: strands that cross, that lie side by side, and a ring.
//!
//! Energy A exp(−r/λ)/r per product of lengths. References:
//!  * crossing at an angle β and a distance d: 2πA λ exp(−d/λ)/sin β, less a part exp(d/λ − 9) by the range;
//!  * parallel strands repel by q = 2A K₁(d/λ)/λ per length. Clamped at both ends each gives way by q L⁴/384B (and q
//!    L²/8GA by shear) in the middle, if that is little against λ. At the ends the other strand is missing on one side,
//!    which changes the clamps' load over a length λ: a part (λ/L)² of the deflection;
//!  * ring: A L ∫ w(s) (exp(−c/λ)/c − exp(−s/λ)/s) ds over half of it, c = 2R sin(s/2R), w(s) from 0 at 4 λ to 1 at 8
//!    λ; off by A L exp(−9)/9, the energy of a straight rod beyond the range.
//!
//! Integrals by Simpson's rule.

use crate::common;

use common::{history, verify};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Electrostatics, Model, NodeRef, Support};
use supercoil::solve::{self, Options, Solver, Status};

const CHARGES: Electrostatics = Electrostatics { strength: 2.0, debye_length: 1.5 };

fn integral(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    const N: usize = 20_000;
    let h = end / N as f64;
    let weight = |k: usize| if k == 0 || k == N { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    (0..=N).map(|k| weight(k) * f(k as f64 * h)).sum::<f64>() * h / 3.0
}

fn line(name: &str, middle: Vec3, direction: Vec3, length: f64, bending: f64) -> Rod {
    let shape = Shape::Line { start: middle - direction * (0.5 * length), direction, length };
    let section = Section::isotropic(bending, bending, bending, bending, 0.5);
    Rod::new(name, &shape, RodMesh::open(40, 3), section, Natural::Straight).unwrap()
}

fn clamped(rods: Vec<Rod>) -> Model {
    let ends = |(rod, r): (usize, &Rod)| [0, r.num_nodes() - 1].map(|node| Support::clamp(NodeRef { rod, node }));
    let supports = rods.iter().enumerate().flat_map(ends).collect();
    Model { rods, supports, electrostatics: Some(CHARGES), ..Model::default() }
}

/// What is observed of a model at rest.
fn at_rest(model: Model) -> Observation {
    let mut last = None;
    let solution = solve::run(model, &[], &Options::default(), &mut |progress| {
        last = Some(observe(progress));
        ControlFlow::Continue(())
    });
    assert_eq!(solution.unwrap().status, Status::Converged);
    last.unwrap()
}

#[test]
fn strands_that_cross_have_the_energy_of_the_closed_form() {
    for (degrees, distance) in [(90f64, 1.2), (90.0, 4.0), (45.0, 2.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let lower = line("lower", Vec3::zeros(), Vec3::x(), 60.0, 1e9);
        let upper = line("upper", Vec3::z() * distance, Vec3::new(cos, sin, 0.0), 60.0, 1e9);
        let seen = at_rest(clamped(vec![lower, upper]));
        let expected = TAU * CHARGES.strength * CHARGES.debye_length * (-distance / CHARGES.debye_length).exp() / sin;
        let tolerance = expected * (2e-4 + (distance / CHARGES.debye_length - 9.0).exp());
        let case = format!("strands {distance} apart crossing at {degrees}°");
        verify(&case, "electrostatic energy", seen.energies.electrostatic, expected, tolerance);
        assert!(seen.sites.is_empty() && seen.energies.contact == 0.0);
    }
}

#[test]
fn parallel_strands_bend_away_from_each_other() {
    let (length, distance, bending) = (100.0, 3.0, 1e10);
    let strands = ["a", "b"].iter().zip([0.0, distance]);
    let rods = strands.map(|(name, y)| line(name, Vec3::y() * y, Vec3::x(), length, bending)).collect();
    let mut solver = Solver::new(clamped(rods), Options::default()).unwrap();
    let report = solver.find_equilibrium();
    assert_eq!(report.status, Status::Converged, "{}", history(&report));
    let found = -solver.engine().positions(0)[60].y;
    let x = distance / CHARGES.debye_length;
    let bessel_k1 = integral(12.0, |t| (-x * t.cosh()).exp() * t.cosh());
    let push = 2.0 * CHARGES.strength * bessel_k1 / CHARGES.debye_length;
    let expected = push * length.powi(2) / bending * (length.powi(2) / 384.0 + 0.125);
    let tolerance = expected * (CHARGES.debye_length / length).powi(2);
    verify("parallel strands, clamped", "deflection in the middle", found, expected, tolerance);
}

#[test]
fn a_ring_has_the_energy_of_its_integral() {
    let (radius, lambda) = (5.0, CHARGES.debye_length);
    let circle = Shape::Circle { length: TAU * radius, center: Vec3::zeros(), normal: Vec3::z() };
    let section = Section::isotropic(1e6, 1e6, 1e6, 1e6, 0.5);
    let rod = Rod::new("ring", &circle, RodMesh::closed(40, 3), section, Natural::Straight).unwrap();
    let seen = at_rest(Model { rods: vec![rod], electrostatics: Some(CHARGES), ..Model::default() });
    let phi = |r: f64| (-r / lambda).exp() / r;
    let density = integral(PI * radius, |s| {
        let t = (s / lambda / 4.0 - 1.0).clamp(0.0, 1.0);
        let weight = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        if weight == 0.0 { 0.0 } else { weight * (phi(2.0 * radius * (0.5 * s / radius).sin()) - phi(s)) }
    });
    let expected = CHARGES.strength * TAU * radius * density;
    let range = CHARGES.strength * TAU * radius * (-9f64).exp() / 9.0;
    verify("ring of radius 3.3 Debye lengths", "electrostatic energy", seen.energies.electrostatic, expected, range);
}
