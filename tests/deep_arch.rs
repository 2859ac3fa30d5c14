//! The deep clamped-hinged arch (DaDeppo & Schmidt 1975): a limit point of the load.
//!
//! Set-up: a circular arch of radius R = 100 that opens over 215°, stress-free, in the x-y plane; clamped at one end, pinned at the other;
//! bending stiffness EI = 1e6; a dead load P at the apex, downwards. Load control ends at the limit point; the path goes on.
//! Reference: the first maximum of P by shooting on the continuous equations (8th-order Runge–Kutta, tolerance 1e-13; P as a function of the
//! apex' height, maximum of a Chebyshev interpolant): 897.3089970 for an inextensible arch, 897.2891338 with EA = GA = 1e8.
//! (Values 6e-5 higher, 897.3090536 and 897.2891905, were given to this project; shooting and these elements agree on the lower ones.)
//! Cubic elements. Tolerance on the finest mesh: 2e-9 relative.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

mod common;

use common::{any_equilibrium, fitted_order, path_point, verify};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, PathEnd, PointKind, Solver};

const ELASTIC: f64 = 897.289_133_84;
const RIGID: f64 = 897.308_996_97;

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

/// Limit points on the way to P = 1000: a maximum and a minimum.
fn limits(rigid: f64, elements: usize) -> Vec<f64> {
    let mut found = Vec::new();
    let ramp = Ramp::Load { to: 1000.0 };
    let report = arch(rigid, elements).follow(&ramp, &FollowOptions::default(), &mut |point| {
        println!("{}", path_point(point));
        if point.kind == PointKind::Limit {
            found.push(point.value);
        }
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    assert_eq!(found.len(), 2);
    found
}

#[test]
fn limit_load() {
    let meshes = [16, 32, 96];
    let errors = meshes.map(|elements| {
        let found = limits(1e8, elements)[0];
        let tolerance = [1e-4, 1e-6, 2e-9][meshes.iter().position(|&n| n == elements).unwrap()] * ELASTIC;
        verify("deep arch, EA = GA = 1e8", &format!("limit load, {elements} elements"), found, ELASTIC, tolerance);
        (found - ELASTIC).abs()
    });
    verify("deep arch, EA = GA = 1e8", "order of the limit load", fitted_order(&[1.0, 0.5], &errors[..2]), 6.0, 0.3);
}

/// The effect of stretch and shear is linear in 1/EA to all digits wanted: two stiffnesses give the limit.
#[test]
fn inextensible_limit_load() {
    let [soft, hard] = [1e8, 1e9].map(|rigid| limits(rigid, 96)[0]);
    let found = (10.0 * hard - soft) / 9.0;
    verify("deep arch, inextensible", "limit load, extrapolated from EA = 1e8, 1e9", found, RIGID, 1e-8 * RIGID);
}
