//! Long plectonemes that start from short ones at rest (`src/solve/short_first.rs`).
//!
//! ```text
//!     ⊂XXXXXXXXXXXXXXXXXXXXXXXXXXXXXX⊃    DNA at supercoiling density −0.06, D = 5 nm, nodes D/3 apart (units nm, pN)
//! ```
//!
//! That this is where the same rod settles the slow way is held there.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

mod common;

use common::observed;
use supercoil::rod::{Natural, Plectoneme, Rod, Section, Shape};
use supercoil::scene::{Model, Ramp};
use supercoil::solve::{Options, Solver, Status};

const TURNS: f64 = -0.06 * LENGTH / (0.34 * 10.5);
const LENGTH: f64 = 5.0 * ELEMENTS as f64;
const ELEMENTS: usize = 960;

/// At rest in a few iterations on the long rod, with the link that was asked for; and the rod goes on from there like
/// any other.
#[test]
fn long_plectonemes_rest_after_short_ones() {
    let shape = Shape::Plectoneme(Plectoneme::of_link(LENGTH, 5.0, 205.7, 308.6, TURNS).unwrap());
    let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
    let rod = Rod::new("dna", &shape, true, section, ELEMENTS, 3, Natural::Straight).unwrap();
    let rod = rod.with_excess_link(TURNS).unwrap();
    let mut solver = Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default()).unwrap();
    let report = solver.step_to(&[]).unwrap();
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0));
    assert!(
        report.iterations_elsewhere > 0 && report.iterations <= 10,
        "{} {}",
        report.iterations_elsewhere,
        report.iterations
    );
    assert!(report.penetration <= 1e-8);
    let link = observed(&solver, &report).links[0].link;
    assert!((link - TURNS).abs() < 1e-9, "{link}");
    let next = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: TURNS - 0.2 }]).unwrap();
    assert_eq!((next.status, next.num_unstable, next.iterations_elsewhere), (Status::Converged, 0, 0));
}
