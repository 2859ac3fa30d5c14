//! Forces of polylines and curved strands as a stepper sees them: the exact slope of the energy, also over kinks, and
//! the energy of the curve that a polyline stands for.
//!
//! ```text
//!        outside: the corner is nearest          inside: two feet, the corner counted off
//!              ∙ x                                    ╲   x   ╱
//!             ╱│╲                                      ╲ ╱│╲ ╱
//!            ╱ │ ╲                                      ╲ │ ╱
//!           ╱  ∧  ╲                                      ╲∨╱
//! ```

#![allow(clippy::unwrap_used)] // helpers of tests

use std::f64::consts::TAU;

use supercoil::contact::Want;
use supercoil::contact::{Curve, Detector, DetectorOptions, Law};
use supercoil::math::{Quat, Vec3};

use crate::random;
use random::Random;

const STIFFNESS: f64 = 40.0;

/// A zigzag with kinks up to a right angle, or a star-like closed one.
fn zigzag(random: &mut Random, closed: bool) -> Vec<Vec3> {
    if closed {
        let spoke = |k: usize, r: f64| {
            let (s, c) = (TAU * k as f64 / 9.0).sin_cos();
            Vec3::new(c, s, 0.0) * r
        };
        return (0..9).map(|k| spoke(k, 0.8 + 0.3 * random.unit()) + random.vector() * 0.1).collect();
    }
    (-4..=4).map(|k| Vec3::new(0.3 * f64::from(k), 0.0, 0.0) + random.vector() * 0.12).collect()
}

/// Slopes of the energy of two curves while the second is moved along and across the first without being bent.
#[test]
fn forces_on_kinked_polylines_are_the_slope_of_the_energy() {
    let mut random = Random(11);
    let (mut touching, mut detector) = (0, Detector::new(DetectorOptions::default()));
    for case in 0..1200 {
        let closed = case % 2 == 1;
        let radii = [[0.1, 0.1], [0.04, 0.15], [0.2, 0.25]][case % 3];
        let (own, other) = (zigzag(&mut random, closed), zigzag(&mut random, case % 4 == 3));
        let turn = Quat::from_scaled_axis(random.vector() * if case % 5 == 0 { 0.1 } else { 3.0 });
        let to = own[3] + random.vector().normalize() * (0.9 * (radii[0] + radii[1])) - turn * other[4];
        let mut at = |shift: Vec3| {
            let moved: Vec<Vec3> = other.iter().map(|x| turn * x + to + shift).collect();
            let mut curves = [Curve::polyline(&own, radii[0]), Curve::polyline(&moved, radii[1])];
            (curves[0].closed, curves[1].closed) = (closed, case % 4 == 3);
            detector.forces(&curves, STIFFNESS).unwrap().clone()
        };
        let here = at(Vec3::zeros());
        // deeper overlaps are beyond the quadrature
        if here.energy == 0.0 || here.min_gap < -0.3 * (radii[0] + radii[1]) {
            continue;
        }
        touching += 1;
        let force: Vec3 = here.forces[1].iter().sum();
        let size: f64 = here.forces[1].iter().map(|f| f.norm()).sum();
        assert!((force + here.forces[0].iter().sum::<Vec3>()).norm() < 1e-12 * size, "case {case}");
        let h = 1e-5;
        for axis in 0..3 {
            let step = Vec3::ith(axis, h);
            let slope = (at(step).energy - at(-step).energy) / (2.0 * h);
            assert!((slope + force[axis]).abs() < 1e-3 * size + 1e-6, "case {case} axis {axis}: {slope} {force}");
        }
    }
    assert!(touching > 150, "{touching}");
}

/// A polyline that touches itself: its tail is turned about one of its points, which stretches nothing.
#[test]
fn forces_of_a_polyline_on_itself_are_the_slope_of_the_energy() {
    let mut random = Random(12);
    let (mut touching, mut detector) = (0, Detector::new(DetectorOptions::default()));
    for case in 0..1000 {
        let mut points = vec![Vec3::zeros()];
        let mut heading = Quat::identity();
        for _ in 0..14 {
            points.push(points[points.len() - 1] + heading * Vec3::x() * 0.2);
            heading *= Quat::from_scaled_axis(Vec3::new(0.3 * random.unit(), 0.25 * random.unit(), 0.7) * 0.9);
        }
        let axis = random.vector();
        let radius = 0.06 + 0.04 * random.unit().abs();
        let mut at = |angle: f64| {
            let turn = Quat::from_scaled_axis(axis * angle);
            let moved: Vec<Vec3> = (0..points.len())
                .map(|k| if k < 7 { points[k] } else { points[7] + turn * (points[k] - points[7]) })
                .collect();
            (detector.forces(&[Curve::polyline(&moved, radius)], STIFFNESS).unwrap().clone(), moved)
        };
        let (here, moved) = at(0.0);
        if here.energy == 0.0 || here.min_gap < -0.6 * radius {
            continue;
        }
        touching += 1;
        let work = |k: usize| here.forces[0][k].dot(&axis.cross(&(moved[k] - moved[7])));
        let power: f64 = (8..moved.len()).map(work).sum();
        let size: f64 = here.forces[0].iter().map(|f| f.norm()).sum();
        let h = 1e-5;
        let slope = (at(h).0.energy - at(-h).0.energy) / (2.0 * h);
        assert!((slope + power).abs() < 1e-3 * size + 1e-6, "case {case}: {slope} {power}");
    }
    assert!(touching > 60, "{touching}");
}

/// Two rings in one plane that overlap all round, as polygons: what the outer one feels of the corners it sees from
/// outside, and the inner one of those it sees from inside, is neither lost nor counted twice.
#[test]
fn polygons_have_the_energy_of_the_rings_they_stand_for() {
    let (inner, outer, radius) = (1.0, 1.15, 0.1);
    let energies = |n: usize, phase: f64| {
        let ring = |r: f64, phase: f64| -> Vec<Vec3> {
            // of the area of the circle, so that sides and corners are off by as little
            let r = r * (TAU / n as f64 / (TAU / n as f64).sin()).sqrt();
            let at = |k: usize| (TAU * k as f64 / n as f64 + phase).sin_cos();
            (0..n).map(at).map(|(s, c)| Vec3::new(c, s, 0.0) * r).collect()
        };
        let (a, b) = (ring(inner, 0.0), ring(outer, phase));
        let curves = [Curve::polyline(&a, radius).closed(), Curve::polyline(&b, radius).closed()];
        let terms = Detector::new(DetectorOptions::default()).terms(&curves, STIFFNESS, Want::Gradient).unwrap();
        [true, false].map(|first| terms.iter().filter(|t| (t.slave < n) == first).map(|t| t.energy).sum::<f64>())
    };
    for (side, r) in [inner, outer].into_iter().enumerate() {
        let exact = 0.5 * (0.5 * STIFFNESS * 0.05_f64.powi(2)) * TAU * r;
        for phase in [0.0, 0.3] {
            let error = |n: usize| (energies(n, phase * TAU / n as f64)[side] / exact - 1.0).abs();
            let errors = [60, 120, 240].map(error);
            assert!(errors[2] < 2e-3 && errors[2] < 0.4 * errors[1] && errors[1] < 0.4 * errors[0], "{errors:?}");
        }
    }
}

/// The other law: C¹ through corners as well, its forces the slope of its energy; without limit at its depth; bad
/// numbers refused by name.
#[test]
fn any_law_may_be_given() {
    let own = [Vec3::new(-1.0, 0.1, 0.0), Vec3::zeros(), Vec3::new(1.0, 0.2, 0.1)];
    let rod = [Vec3::new(0.02, -0.3, -1.0), Vec3::new(0.05, -0.13, 0.7)];
    let law = Law::Core { pressure: 2.0, depth: 0.6 };
    let mut detector = Detector::new(DetectorOptions::default());
    let mut at = |shift: Vec3, law: Law| {
        let moved = rod.map(|x| x + shift);
        detector.forces(&[Curve::polyline(&own, 0.1), Curve::polyline(&moved, 0.12)], law).cloned()
    };
    let here = at(Vec3::zeros(), law).unwrap();
    let force: Vec3 = here.forces[1].iter().sum();
    assert!(force.norm() > 1e-3, "{force}");
    for axis in 0..3 {
        let step = Vec3::ith(axis, 1e-5);
        let slope = (at(step, law).unwrap().energy - at(-step, law).unwrap().energy) / 2e-5;
        assert!((slope + force[axis]).abs() < 1e-3 * force.norm(), "{axis}: {slope} {force}");
    }
    let through = at(Vec3::y() * 0.18, law).unwrap();
    assert_eq!(through.energy, f64::INFINITY, "{}", through.min_gap);
    for (bad, name) in [
        (Law::Linear { stiffness: -1.0 }, "stiffness"),
        (Law::Core { pressure: f64::NAN, depth: 0.5 }, "pressure"),
        (Law::Core { pressure: 1.0, depth: 0.0 }, "depth"),
    ] {
        assert!(at(Vec3::zeros(), bad).unwrap_err().to_string().contains(name));
    }
}
