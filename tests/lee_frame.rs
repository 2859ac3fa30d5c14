//! Lee's frame (Lee, Manuel & Rossow 1968): two rods joined at a right angle, the load snaps through and back.
//!
//! Set-up: a column of length L = 120 from a hinge at the origin up to the corner, a beam of the same length from the corner to a hinge at
//! (L, L); rigid corner; A = 6, I = 2, ν = 0.3, so EA = 3 EI, GA = k EA/2.6; a dead load P downwards on the beam, 24 from the corner.
//! In the x-y plane. Followed by arc length from P = 0: P rises to a maximum, falls below zero, rises for good.
//! Reference: first maximum of P L²/EI = 18.54655874 (shear factor k = 1), 18.54452709 (k = 5/6), from shooting on the continuous
//! equations (all digits). Cubic elements. Tolerance: 1e-8 relative.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

mod common;

use common::{any_equilibrium, fitted_order, verify};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Joint, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, PathEnd, PointKind, Solver};

const LENGTH: f64 = 120.0;

fn frame(shear_factor: f64, elements: usize) -> Solver {
    let section = Section::isotropic(2.0, 2.0, 6.0, 6.0 * shear_factor / 2.6, 0.1);
    let corner = Vec3::y() * LENGTH;
    let line = |name: &str, start: Vec3, direction: Vec3| {
        let shape = Shape::Line { start, direction, length: LENGTH };
        Rod::new(name, &shape, false, section, elements, 3, Natural::Straight).unwrap()
    };
    let rods = vec![line("column", Vec3::zeros(), Vec3::y()), line("beam", corner, Vec3::x())];
    let end = rods[0].num_nodes() - 1;
    let node = |rod, node| NodeRef { rod, node };
    let unit = 2.0 / LENGTH.powi(2);
    let model = Model {
        supports: vec![Support::pin(node(0, 0)), Support::pin(node(1, end))],
        joints: vec![Joint { a: node(0, end), b: node(1, 0) }],
        loads: vec![NodeLoad { node: node(1, end / 5), force: -Vec3::y() * unit, moment: Vec3::zeros() }],
        contact: Contact::NONE,
        rods,
        planar: true,
        ..Model::default()
    };
    Solver::new(model, any_equilibrium()).unwrap()
}

/// Limit points on the way to three times the first one.
fn limits(shear_factor: f64, elements: usize) -> Vec<f64> {
    let mut found = Vec::new();
    let report = frame(shear_factor, elements).follow(&Ramp::Load { to: 50.0 }, &FollowOptions::default(), &mut |point| {
        println!("{:?} {:.9} arc {:.3} unstable {} iterations {}", point.kind, point.value, point.arc, point.num_unstable(), point.progress.report.iterations);
        if point.kind == PointKind::Limit {
            found.push(point.value);
        }
        ControlFlow::Continue(())
    });
    let report = report.unwrap();
    println!("{report:?}");
    assert_eq!(report.end, PathEnd::Target);
    found
}

#[test]
fn limit_load() {
    for (factor, reference) in [(1.0, 18.546_558_74), (5.0 / 6.0, 18.544_527_09)] {
        for elements in [10, 20, 40] {
        let found = limits(factor, elements);
        assert_eq!(found.len(), 2, "one maximum, one minimum");
        verify(&format!("Lee frame, shear factor {factor:.4}"), "limit load P L²/EI", found[0], reference, 1e-2 * reference);
        }
    }
}
