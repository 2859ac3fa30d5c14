//! Clearance on contact lines: certified to 1e-9 of the radius, and fast.

use super::*;
use crate::contact::curves::curve::CurveInput;
use crate::math::Vec3;

fn hermite(n: usize, span: f64, closed: bool, radius: f64, f: impl Fn(f64) -> (Vec3, Vec3)) -> CurveInput {
    let h = span / n as f64;
    let at = |i: usize| f(h * if closed { (i % n) as f64 } else { i as f64 });
    let segments: Vec<Cubic> =
        (0..n).map(|i| Cubic::from_hermite(at(i).0, at(i).1 * h, at(i + 1).0, at(i + 1).1 * h)).collect();
    let lengths = segments.iter().map(|s| s.chord().norm()).collect();
    CurveInput { segments, lengths, closed, radius }
}

/// Strand of a straight double helix of radius 1 around z, starting at angle `phase`.
fn strand(n: usize, length: f64, phase: f64, radius: f64) -> CurveInput {
    let k = 1.2;
    hermite(n, length, false, radius, move |t| {
        let (s, c) = (phase + k * t).sin_cos();
        (Vec3::new(c, s, t), Vec3::new(-s * k, c * k, 1.0))
    })
}

/// One closed curve whose two strands wind `q` (odd) half turns round a circle of radius `big` at distance 1 from it.
fn supercoiled_ring(n: usize, big: f64, q: f64) -> CurveSet {
    let f = |t: f64| {
        let (st, ct) = (q * t / 2.0).sin_cos();
        let (s, c) = t.sin_cos();
        let (rho, drho) = (big + ct, -st * q / 2.0);
        (Vec3::new(rho * c, rho * s, st), Vec3::new(drho * c - rho * s, drho * s + rho * c, ct * q / 2.0))
    };
    CurveSet::new(vec![hermite(n, 4.0 * PI, true, 0.9, f)]).unwrap()
}

fn exclusion(set: &CurveSet) -> Exclusion {
    let mut e = Exclusion::new();
    e.update(set).unwrap();
    e
}

fn check(set: &CurveSet, tol: f64) -> Clearance {
    let start = std::time::Instant::now();
    let c = smallest_clearance(set, &exclusion(set), 1.0, tol).unwrap();
    println!("{} segments: {:?}, width {:.2e}, {:?}", set.len(), c, c.upper - c.lower, start.elapsed());
    assert!(c.upper - c.lower <= tol * 1.000001);
    let d = (set.segments[c.segment_a].point(c.u_a) - set.segments[c.segment_b].point(c.u_b)).norm();
    assert!((d - set.radius_of(c.segment_a) - set.radius_of(c.segment_b) - c.upper).abs() < 1e-13);
    c
}

#[test]
fn crossing_lines() {
    let a = [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0)];
    let b = [Vec3::new(0.3, -1.0, 0.5), Vec3::new(0.3, 2.0, 0.5)];
    let set = CurveSet::from_polylines(&[(&a, 0.1, false), (&b, 0.15, false)]).unwrap();
    let c = check(&set, 1e-12);
    assert!((c.upper - 0.25).abs() < 1e-14);
    assert!((c.u_a - 0.65).abs() < 1e-7 && (c.u_b - 1.0 / 3.0).abs() < 1e-7);
    assert!(smallest_clearance(&set, &exclusion(&set), 0.2, 1e-9).is_none());
}

#[test]
fn straight_double_helix_is_flat_and_fast() {
    for n in [120, 300] {
        let set = CurveSet::new(vec![strand(n, 100.0, 0.0, 0.9), strand(n, 100.0, PI, 0.9)]).unwrap();
        check(&set, 0.9e-9);
    }
}

#[test]
fn supercoiled_ring_is_fast() {
    for n in [100, 300] {
        check(&supercoiled_ring(n, 30.0, 31.0), 0.9e-9);
    }
}

#[test]
fn a_flat_ring_has_no_near_parts() {
    let circle = hermite(40, 2.0 * PI, true, 0.05, |t| {
        let (s, c) = t.sin_cos();
        (Vec3::new(c, s, 0.0), Vec3::new(-s, c, 0.0))
    });
    let set = CurveSet::new(vec![circle]).unwrap();
    assert!(smallest_clearance(&set, &exclusion(&set), 1.0, 1e-9).is_none());
    let start = std::time::Instant::now();
    let c = smallest_clearance(&set, &exclusion(&set), 5.0, 1e-3).unwrap();
    println!("{c:?} {:?}", start.elapsed());
    assert!(c.lower <= 1.9 + 1e-4 && c.upper >= 1.9 - 1e-4);
}
