//! Random supercoiling runs: closed rods of random thickness, C/B and excess link from randomly perturbed starts,
//! unknots and trefoils. Every run must keep its link and its knot, or say that it did not come to rest.
//!
//! The knot is watched by its determinant |Δ(−1)|, from the crossings of a projection: 1 for the unknot, 3 for the
//! trefoil. A passage of a strand through another changes the link by two, whatever it does to the knot.

// a test stops where it cannot go on; numbers for whoever asks with --nocapture
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::knots;
use crate::supercoiling;

use knots::determinant;
use supercoil::math::Vec3;
use supercoil::solve::{Options, Status};
use supercoiling::{Way, go, start};

#[test]
fn determinants_of_known_knots() {
    let knot = |p: f64, q: f64| -> Vec<Vec3> {
        let at = |k: usize| std::f64::consts::TAU * k as f64 / 300.0;
        let point = |t: f64| {
            Vec3::new((2.0 + (q * t).cos()) * (p * t).cos(), (2.0 + (q * t).cos()) * (p * t).sin(), (q * t).sin())
        };
        (0..300).map(|k| point(at(k))).collect()
    };
    for ((p, q), expected) in [
        ((1.0, 3.0), 1.0),
        ((2.0, 3.0), 3.0),
        ((2.0, 5.0), 5.0),
        ((2.0, 7.0), 7.0),
        ((3.0, 4.0), 3.0),
        ((3.0, 5.0), 1.0),
    ] {
        assert_eq!(determinant(&knot(p, q)), expected, "torus knot {p}, {q}");
    }
}

/// One run; whether it came to rest.
fn supercoil(seed: u64, way: Way) -> bool {
    let start = start(seed);
    let (diameter, ratio, from, to) = (start.diameter, start.ratio, start.rod.start_excess_link, start.to);
    let run = go(start, way, &Options::default());
    let [before, after] = run.knot;
    println!(
        "seed {seed}: D/L {diameter:.4} C/B {ratio:.2} knot {before} link {from:.2} → {to:.2}: {}, {} steps, {} \
         iterations (and {} on coarse meshes), link error {:.0e}, knot {after}",
        run.status, run.steps, run.iterations, run.elsewhere, run.link_error
    );
    assert_eq!(before, if seed % 4 == 3 { 3.0 } else { 1.0 });
    assert!(run.gap > -1e-6, "seed {seed}: gap {} diameters", run.gap);
    assert!(run.link_error < 1e-9, "seed {seed}: link off by {}", run.link_error);
    assert_eq!(before, after, "seed {seed}: the knot has changed");
    run.status == Status::Converged
}

fn all(seeds: std::ops::Range<u64>, way: Way) {
    let failed: Vec<u64> = seeds.filter(|&seed| !supercoil(seed, way)).collect();
    assert!(failed.is_empty(), "did not come to rest: {failed:?}");
}

#[test]
fn a_few_random_runs() {
    all(0..8, Way::TurnByTurn);
    all(0..8, Way::AtOnce);
}

#[test]
#[ignore = "slow: 200 runs, minutes"]
fn two_hundred_random_runs() {
    all(0..200, Way::TurnByTurn);
}

#[test]
#[ignore = "slow: 200 runs, minutes"]
fn two_hundred_random_runs_at_once() {
    all(0..200, Way::AtOnce);
}
