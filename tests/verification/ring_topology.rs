//! How the contact of the closed twisted ring looks as its link is raised: one point, two, three, a line between two
//! points.
//!
//! ```text
//!    _  _        _  _          _   _          _   _
//!   / \/ \      / \/ \        / \_/ \        / \_/ \
//!   \_/\_/      \_/\_/        \_/ \_/        \_/ \_/
//!   1 point     2 points      3 points       line + 2 points
//! ```
//!
//! L = 1, B = 1, C = 1.5, EA = GA = 1e7 B/L², cubic elements, D/L = .01 and .03. Reported points and lines must be
//! those of hard contact: the events lie at ΔLk = 1.9464, 2.4593, 2.5814 (D/L = .01) and 1.9126, 2.3205, 2.3804 (.03),
//! from writhe and torque of the Kirchhoff rod (Coleman & Swigon 2000; values recomputed by shooting). Under laws of
//! very different stiffness: what is a point must not depend on it.
//!
//! Second: a ring under pressure. The zone of its point contact at the load at which it opens into a line (10.336033
//! B/R³ for no thickness, 10.32919 for D/R = .001, `tests/verification/planar_touch.rs`) must be 2 · 1.0955 (2B/κ)^¼
//! long (see `observe::sites`), whatever κ.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::TAU;

use common::cases::oval_ring;
use common::{history, observed, verify};
use supercoil::math::Vec3;
use supercoil::observe::report::{Observation, SiteReport};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Options, Solver, Status, StepReport};

fn penalty(kappa: f64, diameter: f64) -> ContactLaw {
    ContactLaw::Penalty { stiffness: kappa * (0.5 * diameter).powi(4) }
}

fn seen(solver: &Solver, report: &StepReport) -> Observation {
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(report));
    observed(solver, report)
}

/// "P" and "L" for point and line, along the rod from the seam.
fn topology(sites: &[SiteReport]) -> String {
    sites.iter().map(|site| if site.kind == "line" { 'L' } else { 'P' }).collect()
}

fn ring(elements: usize, diameter: f64, law: ContactLaw) -> Solver {
    let section = Section::isotropic(1.0, 1.5, 1e7, 1e7, 0.5 * diameter);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
    Solver::new(Model { rods: vec![rod], contact: Contact { law }, ..Model::default() }, Options::default()).unwrap()
}

/// Excess links with the topology there.
type Expected<'a> = &'a [(f64, &'a str)];

const THIN: Expected = &[
    (1.1, ""),
    (1.3, "P"),
    (1.6, "P"),
    (1.9, "P"),
    (2.0, "PP"),
    (2.3, "PP"),
    (2.44, "PP"),
    (2.48, "PPP"),
    (2.56, "PPP"),
    (2.62, "PLP"),
    (2.8, "PLP"),
    (3.0, "PLP"),
];
const THICK: Expected = &[
    (1.1, ""),
    (1.3, "P"),
    (1.6, "P"),
    (1.88, "P"),
    (2.0, "PP"),
    (2.3, "PP"),
    (2.34, "PPP"),
    (2.37, "PPP"),
    (2.41, "PLP"),
    (2.6, "PLP"),
    (3.0, "PLP"),
];

/// The topology under a penalty raised from 1e8 in decades, at each of the decades `looked_at`.
fn under_penalties(elements: usize, diameter: f64, expected: Expected, looked_at: std::ops::RangeInclusive<i32>) {
    let mut solver = ring(elements, diameter, penalty(1e8, diameter));
    for &(excess_link, wanted) in expected {
        solver.set_contact_law(penalty(1e8, diameter)).unwrap();
        let mut report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: excess_link }]).unwrap();
        for decade in 9..=*looked_at.end() {
            solver.set_contact_law(penalty(10f64.powi(decade), diameter)).unwrap();
            report = solver.find_equilibrium();
            if looked_at.contains(&decade) {
                let found = topology(&seen(&solver, &report).sites);
                println!("D/L {diameter}, ΔLk {excess_link}, κ = 1e{decade}: {found}");
                assert_eq!(found, wanted, "ΔLk {excess_link}, κ = 1e{decade}");
            }
        }
        seen(&solver, &report);
    }
}

#[test]
fn thin_ring_under_penalties() {
    under_penalties(128, 0.01, THIN, 11..=12);
}

#[test]
fn thick_ring_under_penalties() {
    under_penalties(128, 0.03, THICK, 11..=11);
}

/// The default law: gaps closed to 1e-8 ε by offsets. κ ε⁴/B = 100: 1.6e11 B/L⁴ for the thin ring, 2e9 for the thick
/// one.
fn under_the_default_law(elements: usize, diameter: f64, expected: Expected) {
    let mut solver = ring(elements, diameter, Contact::default().law);
    let (mut iterations, mut augmentations) = (0, 0);
    for &(excess_link, wanted) in expected {
        let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: excess_link }]).unwrap();
        let found = topology(&seen(&solver, &report).sites);
        println!(
            "D/L {diameter}, ΔLk {excess_link}: {found}, {} iterations, {} augmentations",
            report.iterations, report.augmentations
        );
        iterations += report.iterations;
        augmentations += report.augmentations;
        assert_eq!(found, wanted, "ΔLk {excess_link}");
    }
    println!("{iterations} iterations, {augmentations} augmentations");
}

#[test]
fn thin_ring_under_the_default_law() {
    under_the_default_law(128, 0.01, THIN);
}

/// Middle contacts within two contact distances of the outer ones: nothing else may be reported beside them.
#[test]
fn thick_ring_under_the_default_law() {
    // at 2.41 the line is .010 L long: under κ' = 100 the longest point is .018 L; by the mesh κ' = 10⁴ and it is .006
    // L
    under_the_default_law(128, 0.03, THICK);
}

#[test]
fn a_point_opens_when_its_zone_is_as_long_as_predicted() {
    let diameter = 1e-3;
    let model = oval_ring(96, diameter, 1e8, penalty(1e6, diameter));
    let mut solver = Solver::new(model, Options::default()).unwrap();
    for p in [3.3, 3.6, 4.0, 4.4, 4.8, 5.1, 5.3, 6.0, 7.0, 8.0, 9.0, 9.8, 10.32919] {
        let report = solver.step_to(&[Ramp::Pressure { rod: 0, to: p }]).unwrap();
        seen(&solver, &report);
    }
    // nodes are .022 apart: beyond 1e7 the elements cannot bend within a layer (B/κ)^¼
    for kappa in [1e6, 3e6, 1e7] {
        solver.set_contact_law(penalty(kappa, diameter)).unwrap();
        let report = solver.find_equilibrium();
        let seen = seen(&solver, &report);
        assert_eq!(topology(&seen.sites), "P");
        let [from, to] = seen.sites[0].arc_a;
        let length = (to - from).rem_euclid(TAU);
        let predicted = 2.0 * 1.095544 * (2.0 / kappa).powf(0.25);
        verify(
            "ring under pressure, D/R = .001, at 10.32919 B/R³",
            &format!("length of the point's zone over that predicted, κ = {kappa:e}"),
            length / predicted,
            1.0,
            0.02,
        );
    }
}
