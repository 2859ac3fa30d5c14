//! Lee's frame (Lee, Manuel & Rossow 1968): two rods joined at a right angle, the load snaps through and back.
//!
//! Set-up: a column of length L = 120 from a hinge at the origin up to the corner, a beam of the same length from the
//! corner to a hinge at (L, L); rigid corner; A = 6, I = 2, ν = 0.3, so EA = 3 EI, GA = k EA/2.6; a dead load P
//! downwards on the beam, 24 from the corner. In the x-y plane. Followed by arc length from P = 0: P rises to a
//! maximum, falls below zero, rises for good. Reference: first maximum of P L²/EI = 18.54655874 (shear factor k = 1),
//! 18.54452709 (k = 5/6), from shooting on the continuous equations (all digits). Cubic elements. Tolerance: 1e-8
//! relative.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{any_equilibrium, fitted_order, path_point, verify};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Electrostatics, Joint, JointKind, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{FollowOptions, PathEnd, PointKind, Solver};

const LENGTH: f64 = 120.0;

fn frame(shear_factor: f64, elements: usize) -> Solver {
    let section = Section::isotropic(2.0, 2.0, 6.0, 6.0 * shear_factor / 2.6, 0.1);
    let corner = Vec3::y() * LENGTH;
    let line = |name: &str, start: Vec3, direction: Vec3| {
        let shape = Shape::Line { start, direction, length: LENGTH };
        Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
    };
    let rods = vec![line("column", Vec3::zeros(), Vec3::y()), line("beam", corner, Vec3::x())];
    let end = rods[0].num_nodes() - 1;
    let node = |rod, node| NodeRef { rod, node };
    let unit = 2.0 / LENGTH.powi(2);
    let model = Model {
        supports: vec![Support::pin(node(0, 0)), Support::pin(node(1, end))],
        joints: vec![Joint::rigid(node(0, end), node(1, 0))],
        loads: vec![NodeLoad { node: node(1, end / 5), force: -Vec3::y() * unit, moment: Vec3::zeros() }],
        contact: Contact::NONE,
        rods,
        planar: true,
        ..Model::default()
    };
    Solver::new(model, any_equilibrium()).unwrap()
}

/// Limit points on the way to a load far beyond them.
fn limits(shear_factor: f64, elements: usize) -> Vec<f64> {
    let mut found = Vec::new();
    let ramp = Ramp::Load { to: 50.0 };
    let report = frame(shear_factor, elements).follow(&ramp, &FollowOptions::default(), &mut |point| {
        println!("{}", path_point(point));
        if point.kind == PointKind::Limit {
            found.push(point.value);
        }
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    found
}

#[test]
fn limit_load() {
    for (factor, reference) in [(1.0, 18.546_558_74), (5.0 / 6.0, 18.544_527_09)] {
        let case = format!("Lee frame, shear factor {factor:.4}");
        let meshes = [5, 10, 20, 40];
        let errors = meshes.map(|elements| {
            let found = limits(factor, elements);
            assert_eq!(found.len(), 2, "one maximum, one minimum");
            let tolerance = if elements == 40 { 1e-8 * reference } else { 1e-3 * reference };
            verify(&case, &format!("limit load P L²/EI, {elements} elements a rod"), found[0], reference, tolerance);
            (found[0] - reference).abs()
        });
        // the finest mesh is as far from the reference as its last digit
        let order = fitted_order(&[1.0, 0.5, 0.25], &errors[..3]);
        verify(&case, "order of the limit load", order, 6.0, 0.3);
    }
}

/// Stable up to the maximum, one unstable direction between the limit points, stable again: load control would jump.
#[test]
fn stability_along_the_path() {
    let (mut counts, mut kinds) = (Vec::new(), 0);
    let ramp = Ramp::Load { to: 50.0 };
    let report = frame(1.0, 10).follow(&ramp, &FollowOptions::default(), &mut |point| {
        match point.kind {
            PointKind::Limit => kinds += 1,
            PointKind::Branch { .. } => panic!("no branches: {}", path_point(point)),
            _ => counts.push((kinds, point.num_unstable())),
        }
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    assert!(counts.iter().all(|&(limits, unstable)| unstable == [0, 1, 0][limits]), "{counts:?}");
}

/// The corner stays rigid: rods meet at a right angle in every state, and the hinges carry the load.
#[test]
fn the_corner_is_rigid_and_the_hinges_carry_the_load() {
    let mut checked = 0;
    let ramp = Ramp::Load { to: 50.0 };
    let report = frame(1.0, 10).follow(&ramp, &FollowOptions::default(), &mut |point| {
        let engine = point.engine();
        let (column, beam) = (engine.positions(0).last().unwrap(), engine.positions(1).first().unwrap());
        assert!((column - beam).norm() < 1e-12 * LENGTH);
        let along = [engine.frames(0).last().unwrap(), engine.frames(1).first().unwrap()].map(|q| q * Vec3::z());
        assert!(along[0].dot(&along[1]).abs() < 1e-12);
        let seen = observe(&point.progress);
        let carried: f64 = seen.reactions.iter().map(|r| r.force[1]).sum();
        let load = point.value * 2.0 / LENGTH.powi(2);
        assert!((carried - load).abs() < 1e-9, "{carried} {load}");
        checked += 1;
        ControlFlow::Continue(())
    });
    assert!(report.unwrap().end == PathEnd::Target && checked > 10);
}

/// Refuses: joined nodes that are apart, a frame that nothing holds, a joint moved by a ramp.
#[test]
fn bad_joints_are_refused() {
    let refusal = |model: &Model| model.check().unwrap_err().to_string();
    let good = frame(1.0, 5).engine().model().clone();
    let mut apart = good.clone();
    apart.joints[0].b.node = 1;
    assert!(refusal(&apart).contains("joints[0]") && refusal(&apart).contains("they must coincide"));
    let mut loose = good.clone();
    loose.supports.clear();
    assert!(refusal(&loose).contains("nothing holds it against the sum of its dead forces"));
    let mut touching = good.clone();
    touching.contact = Contact::default();
    assert_eq!(touching.check(), Ok(()));
    touching.electrostatics = Some(Electrostatics { strength: 1.0, debye_length: 0.1 });
    touching.rods.iter_mut().for_each(|rod| rod.section.contact_radius = 0.1);
    assert!(refusal(&touching).contains("joins two charged rods"), "{}", refusal(&touching));
    let mut held = good.clone();
    held.supports.push(Support::clamp(held.joints[0].a));
    let [a, b] = [held.joints[0].a, held.joints[0].b];
    let moves = |node: NodeRef| Ramp::Displacement { node, to: Vec3::x() };
    let check = |model: &Model, ramps: Vec<Ramp>| model.check_stages(&[Stage::new(ramps, 1)]);
    assert_eq!(check(&held, vec![moves(b)]), Ok(()));
    let twice = check(&held, vec![moves(a), moves(b)]).unwrap_err().to_string();
    assert!(twice.contains("the same quantity is ramped twice"), "{twice}");
    let turned = Ramp::Rotation { node: b, axis: Vec3::z(), to: 0.1 };
    assert_eq!(check(&held, vec![turned.clone()]), Ok(()));
    held.planar = false;
    held.joints[0].kind = JointKind::Hinge { axis: Vec3::z() };
    held.supports.push(Support::clamp(b));
    let hinged = check(&held, vec![turned]).unwrap_err().to_string();
    assert!(hinged.contains("hinges cannot be turned"), "{hinged}");
}
