//! Screened repulsion against closed forms, brute force and differences.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::contact::curve::{Cubic, CurveInput};

const LAW: Screened = Screened { strength: 7.0, debye_length: 3.0 };

/// Segments of a curve given by position and derivative by a parameter from 0 to 1.
fn curve(count: usize, closed: bool, length: f64, of: impl Fn(f64) -> (Vec3, Vec3)) -> CurveInput {
    let segment = |k: usize| {
        let [(p, m), (q, n)] = [k, k + 1].map(|k| of(k as f64 / count as f64));
        Cubic::from_hermite(p, m / count as f64, q, n / count as f64)
    };
    let lengths = vec![length / count as f64; count];
    CurveInput { segments: (0..count).map(segment).collect(), lengths, closed, radius: 1.0 }
}

fn line(middle: Vec3, direction: Vec3, length: f64) -> CurveInput {
    let at = |u: f64| (middle + direction * (length * (u - 0.5)), direction * length);
    curve(length.ceil() as usize, false, length, at)
}

fn ring(radius: f64, count: usize) -> CurveInput {
    let at = |u: f64| {
        let (sin, cos) = (TAU * u).sin_cos();
        (Vec3::new(cos, sin, 0.0) * radius, Vec3::new(-sin, cos, 0.0) * (TAU * radius))
    };
    let mut ring = curve(count, true, TAU * radius, at);
    ring.segments[count - 1].b[3] = ring.segments[0].b[0];
    ring
}

/// Length that three Gauss points resolve, as scenes have it.
fn piece(set: &CurveSet) -> f64 {
    let least = set.curves.iter().map(|curve| curve.radius).fold(f64::INFINITY, f64::min);
    (1.5 * least).min(2.0 * LAW.debye_length)
}

fn terms(curves: Vec<CurveInput>) -> Vec<Term> {
    let set = CurveSet::new(curves).unwrap();
    let mut repulsion = Repulsion::new(LAW, &set, piece(&set));
    repulsion.update(&set).unwrap();
    repulsion.terms(&set, repulsion.pairs(), true).into_iter().flatten().collect()
}

fn energy(curves: Vec<CurveInput>) -> f64 {
    terms(curves).iter().map(|term| term.energy).sum()
}

/// ∫ f from 0 to `end` by Simpson's rule.
fn integral(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    const N: usize = 20_000;
    let h = end / N as f64;
    let weight = |k: usize| if k == 0 || k == N { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    (0..=N).map(|k| weight(k) * f(k as f64 * h)).sum::<f64>() * h / 3.0
}

/// The modified Bessel function K₀.
fn bessel_k0(x: f64) -> f64 {
    integral(12.0, |t| (-x * t.cosh()).exp())
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found} {expected} {:e}", found / expected - 1.0);
}

#[test]
fn derivatives_of_the_law_are_those_of_its_energy() {
    let h = 1e-4;
    for r in [0.7, 5.0, 26.0, 27.6, 28.5, 29.7] {
        let (before, here, after) = (LAW.at(r - h), LAW.at(r), LAW.at(r + h));
        let scale = here.energy.abs();
        assert!((after.energy - before.energy - 2.0 * h * here.slope).abs() < 1e-6 * h * scale.max(1e-3), "{r}");
        assert!((after.slope - before.slope - 2.0 * h * here.curvature).abs() < 1e-6 * h * scale.max(1e-3), "{r}");
    }
    assert_eq!(LAW.at(30.0), PairEnergy::default());
}

/// Two parallel lines: 2A K₀(d/λ) per length. The error of the range is as the header says: 6.6e-5 and 2.3e-3 were
/// found.
#[test]
fn parallel_strands_repel_as_bessel_says() {
    let both = |distance: f64| {
        // a short strand in the middle of a long one sees an endless one
        let (long, short) = (line(Vec3::zeros(), Vec3::x(), 100.0), line(Vec3::y() * distance, Vec3::x(), 20.0));
        energy(vec![long, short]) / 20.0
    };
    for (distance, tolerance) in [(2.0, 1e-4), (6.0, 1e-4), (15.0, 3e-3)] {
        close(both(distance), 2.0 * LAW.strength * bessel_k0(distance / LAW.debye_length), tolerance);
    }
}

/// Two lines that cross at an angle β: 2πA λ exp(−d/λ)/sin β.
#[test]
fn crossed_strands_repel_as_the_closed_form_says() {
    for (angle, distance) in [(90f64, 2.0), (90.0, 8.0), (40.0, 3.0)] {
        // the tail is a part exp(−9.3 + d/λ) of the energy
        let tolerance = 1e-4 + (distance / LAW.debye_length - 9.0).exp();
        let (sin, cos) = angle.to_radians().sin_cos();
        let other = line(Vec3::z() * distance, Vec3::new(cos, sin, 0.0), 140.0);
        let found = energy(vec![line(Vec3::zeros(), Vec3::x(), 140.0), other]);
        let expected = TAU * LAW.strength * LAW.debye_length * (-distance / LAW.debye_length).exp() / sin;
        close(found, expected, tolerance);
    }
}

/// A ring: A L ∫ w(s) (φ(chord) − φ(s)) ds over half of it, chord = 2R sin(s/2R).
#[test]
fn a_ring_has_the_energy_of_its_integral() {
    for (radius, count) in [(8.0, 50), (12.0, 60), (30.0, 120)] {
        let found = energy(vec![ring(radius, count)]);
        let phi = |r: f64| LAW.at(r).energy;
        let per_length = integral(PI * radius, |s| {
            let [weight, ..] = smooth_step((s / LAW.debye_length - 4.0) / 4.0);
            if weight == 0.0 { 0.0 } else { weight * (phi(2.0 * radius * (0.5 * s / radius).sin()) - phi(s)) }
        });
        close(found, TAU * radius * per_length, 1e-4);
    }
}

#[test]
fn a_straight_strand_does_not_feel_itself() {
    let found = terms(vec![line(Vec3::new(0.3, 0.1, 0.2), Vec3::new(0.6, 0.0, 0.8), 90.0)]);
    let largest = found.iter().map(|term| term.energy.abs()).fold(0.0, f64::max);
    assert!(found.len() > 1000 && largest < 1e-14, "{} {largest:e}", found.len());
}

/// No pair within range is lost, and forces balance.
#[test]
fn the_sum_is_that_over_all_points() {
    let curves = || vec![ring(11.0, 50), line(Vec3::new(0.0, 0.0, 2.5), Vec3::new(0.6, 0.64, 0.48), 40.0)];
    let set = CurveSet::new(curves()).unwrap();
    let repulsion = Repulsion::new(LAW, &set, piece(&set));
    let mut sum = 0.0;
    for i in 0..set.len() {
        for j in 0..i {
            for p in &repulsion.points[set.curve_of(i)] {
                for q in &repulsion.points[set.curve_of(j)] {
                    let Some((weight, straight)) = repulsion.weight(&set, [i, j], [p.u, q.u]) else { continue };
                    let r = (set.segments[i].point(p.u) - set.segments[j].point(q.u)).norm();
                    sum += weight * p.weight * q.weight * (LAW.at(r).energy - straight);
                }
            }
        }
    }
    let found = terms(curves());
    close(found.iter().map(|term| term.energy).sum::<f64>(), sum, 1e-12);
    let mut force = Vec3::zeros();
    for end in found.iter().flat_map(|term| term.gradient.chunks_exact(6)) {
        force += Vec3::new(end[0], end[1], end[2]);
    }
    assert!(force.norm() < 1e-12, "{force:?}");
}
