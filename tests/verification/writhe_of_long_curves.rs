//! Writhe of long closed curves: crossings of one projection against the exact double sum; a published value; the
//! growth of the cost.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use crate::inputs;
use crate::plectoneme;

use crate::common;
use crate::random;

use std::f64::consts::TAU;
use std::time::Instant;

use common::verify;
use inputs::Kind;
use plectoneme::plectoneme;
use random::Random;
use supercoil::math::Vec3;
use supercoil::math::link::{writhe, writhe_smooth};

/// The exact double sum over all pairs of edges: the closed polygon walked round once as an open one.
fn double_sum(points: &[Vec3]) -> f64 {
    let round: Vec<Vec3> = points.iter().chain([&points[0]]).copied().collect();
    writhe(&round, false)
}

fn torus_knot(p: f64, q: f64, n: usize) -> Vec<Vec3> {
    let at = |t: f64| {
        let rho = 2.0 + (q * t).cos();
        Vec3::new(rho * (p * t).cos(), rho * (p * t).sin(), (q * t).sin())
    };
    (0..n).map(|i| at(TAU * i as f64 / n as f64)).collect()
}

/// A walk of `n` unit steps of random direction, closed by a steady drift.
fn random_walk(n: usize, seed: u64) -> Vec<Vec3> {
    let mut numbers = Random(seed);
    let mut points = vec![Vec3::zeros()];
    for k in 0..n {
        points.push(points[k] + numbers.vector().normalize());
    }
    let drift = points[n] / n as f64;
    (0..n).map(|k| points[k] - drift * k as f64).collect()
}

/// Walks that cross themselves everywhere, tight plectonemes, knots: the two ways agree to rounding, |error| ≤ 1e-10
/// turns.
#[test]
fn crossings_agree_with_the_double_sum() {
    let mut curves: Vec<(String, Vec<Vec3>)> = Vec::new();
    for seed in 1..=6 {
        curves.push((format!("random walk {seed}"), random_walk(1500, seed)));
    }
    for (radius, swing) in [(1.0, 0.02), (0.3, 0.0), (0.02, 0.01)] {
        curves.push((format!("plectoneme, radius {radius}"), plectoneme(2500, radius, swing)));
    }
    for (p, q) in [(2.0, 3.0), (3.0, 7.0), (5.0, 13.0)] {
        curves.push((format!("torus knot ({p}, {q})"), torus_knot(p, q, 1800)));
    }
    for kind in Kind::ALL {
        curves.push((kind.name().to_owned(), kind.points(2000)));
    }
    for (name, points) in &curves {
        verify(name, "Wr by crossings", writhe(points, true), double_sum(points), 1e-10);
    }
}

/// The smooth (2, 3) torus knot ((2 + cos 3t) cos 2t, (2 + cos 3t) sin 2t, sin 3t); the reference by the Gauss
/// integral, spectrally converged.
#[test]
fn torus_knot_to_ten_digits() {
    let sample = |u: f64| {
        let t = TAU * u;
        let rho = 2.0 + (3.0 * t).cos();
        let (sin, cos) = (2.0 * t).sin_cos();
        let slope = -3.0 * (3.0 * t).sin();
        let point = Vec3::new(rho * cos, rho * sin, (3.0 * t).sin());
        (point, Vec3::new(slope * cos - 2.0 * rho * sin, slope * sin + 2.0 * rho * cos, 3.0 * (3.0 * t).cos()))
    };
    verify("(2,3) torus knot", "|Wr|", writhe_smooth(&sample, 60).abs(), 3.518_239_231_04, 1e-10);
}

/// Time grows about as the number of edges; exponents are seen with `--ignored --nocapture`.
#[test]
#[ignore = "slow: up to a million edges, measures time"]
fn growth_of_the_cost() {
    type Shape<'a> = (&'a str, &'a dyn Fn(usize) -> Vec<Vec3>);
    let shapes: [Shape; 6] = [
        ("closed plectoneme", &|n| plectoneme(n, 1.0, 0.02)),
        ("random walk", &|n| random_walk(n, 1)),
        ("plecto", &|n| Kind::Plecto.points(n)),
        ("plectocoil", &|n| Kind::Plectocoil.points(n)),
        ("wlc", &|n| Kind::Wlc.points(n)),
        ("packed", &|n| Kind::Packed.points(n)),
    ];
    for (name, shape) in shapes {
        let sizes = [10_000, 100_000, 1_000_000];
        let times = sizes.map(|n| {
            let points = shape(n);
            let started = Instant::now();
            let value = writhe(&points, true);
            let seconds = started.elapsed().as_secs_f64();
            println!("{name:>18} {n:>8} edges: {seconds:.3} s, Wr = {value:.9}");
            seconds
        });
        let exponent = common::fitted_order(&sizes.map(|n| n as f64), &times);
        println!("{name:>18} exponent {exponent:.3}");
        // 2 by pairs of edges; caches, and other work on the machine, make it more than 1
        assert!(exponent < 1.5, "{name}: time grows with the exponent {exponent}");
    }
}
