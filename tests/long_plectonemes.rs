//! Long plectonemes that start from short ones at rest (`src/solve/short_first.rs`).
//!
//! ```text
//!     ⊂XXXXXXXXXXXXXXXXXXXXXXXXXXXXXX⊃    DNA at supercoiling density −0.06, D = 5 nm, nodes D/3 apart (units nm, pN)
//! ```
//!
//! Held against the same rod whose start differs from a uniform plectoneme by too much for that, which settles the slow way.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

mod common;

use common::observed;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Plectoneme, Rod, Section, Shape};
use supercoil::scene::{Model, Ramp};
use supercoil::solve::{Options, Solver, Status, StepReport};

const TURNS: f64 = -0.06 * LENGTH / (0.34 * 10.5);
const LENGTH: f64 = 5.0 * ELEMENTS as f64;
const ELEMENTS: usize = 960;

fn settled(nudge: f64) -> (Solver, StepReport) {
    let shape = Shape::Plectoneme(Plectoneme::of_link(LENGTH, 5.0, 205.7, 308.6, TURNS).unwrap());
    let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
    let mut rod = Rod::new("dna", &shape, true, section, ELEMENTS, 3, Natural::Straight).unwrap();
    rod.positions[3 * ELEMENTS / 4] += Vec3::new(0.0, nudge, 0.0);
    let rod = rod.with_excess_link(TURNS).unwrap();
    let mut solver = Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default()).unwrap();
    let report = solver.step_to(&[]).unwrap();
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0));
    (solver, report)
}

/// The same energies and the same link as the slow way, in a tenth of the iterations on the long rod; and the rod goes on from there like any other.
#[test]
fn long_plectonemes_rest_where_they_do_without_short_ones() {
    let ((mut short, quick), (slow, usual)) = (settled(0.0), settled(0.02));
    assert!(quick.short_iterations > 0 && quick.iterations <= 10, "{} {}", quick.short_iterations, quick.iterations);
    assert!(usual.short_iterations == 0 && usual.iterations > 3 * quick.iterations, "{}", usual.iterations);
    let potential = |report: &StepReport| report.history.last().unwrap().last().unwrap().potential;
    let (ours, theirs) = (potential(&quick), potential(&usual));
    assert!((ours / theirs - 1.0).abs() < 1e-7, "{ours} {theirs}");
    assert!(quick.penetration <= 1e-8);
    for solver in [&short, &slow] {
        let link = observed(solver, &quick).links[0].link;
        assert!((link - TURNS).abs() < 1e-9, "{link}");
    }
    let next = short.step_to(&[Ramp::ExcessLink { rod: 0, to: TURNS - 0.2 }]).unwrap();
    assert_eq!((next.status, next.num_unstable, next.short_iterations), (Status::Converged, 0, 0));
}
