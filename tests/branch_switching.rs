//! Branches entered without noise.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

mod common;

use common::{any_equilibrium, verify};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, LineLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, PathPoint, PointKind, Solver, Start};

fn show(point: &PathPoint) {
    println!("{:?} {:.9} arc {:.4} slope {:.3e} unstable {} iterations {}", point.kind, point.value, point.arc, point.slope, point.num_unstable(), point.progress.report.iterations);
}

/// Follows until the first branch point and stays there; its parameter.
fn to_branch_point(solver: &mut Solver, ramp: &Ramp) -> f64 {
    let report = solver.follow(ramp, &FollowOptions::default(), &mut |point| {
        show(point);
        match point.kind {
            PointKind::Branch { .. } => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    });
    let report = report.unwrap();
    println!("{report:?}");
    report.value
}

fn ring(ratio: f64, elements: usize) -> Solver {
    let section = Section::isotropic(1.0, ratio, 1e8, 1e8, 0.005);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, true, section, elements, 3, Natural::Straight).unwrap();
    let model = Model { contact: Contact::NONE, rods: vec![rod], ..Model::default() };
    Solver::new(model, any_equilibrium()).unwrap()
}

#[test]
fn ring_branches() {
    for ratio in [1.5] {
        let mut solver = ring(ratio, 24);
        let ramp = Ramp::ExcessLink { rod: 0, to: 2.0 };
        let value = to_branch_point(&mut solver, &ramp);
        let reference = 3f64.sqrt() / ratio;
        verify("ring", "branch", value, reference, 1e-2);
        let options = FollowOptions { start: Start::Branch { forwards: true }, max_points: 3, ..FollowOptions::default() };
        println!("{:?}", solver.follow(&ramp, &options, &mut |point| {
            show(point);
            let link = &supercoil::observe::observe(&point.progress).links[0];
            println!("     writhe {} link {} excess {}", link.writhe, link.link, link.excess_link);
            ControlFlow::Continue(())
        }));
    }
}

#[test]
fn column() {
    let section = Section::isotropic(1.0, 1.3, 1e6, 1e6, 1e-3);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::z(), length: 1.0 };
    let rod = Rod::new("column", &shape, false, section, 24, 3, Natural::Straight).unwrap();
    let model = Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        line_loads: vec![LineLoad { rod: 0, force: -Vec3::z() }],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    };
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    let ramp = Ramp::Load { to: 20.0 };
    to_branch_point(&mut solver, &ramp);
    let options = FollowOptions { start: Start::Branch { forwards: true }, max_points: 3, ..FollowOptions::default() };
    println!("{:?}", solver.follow(&ramp, &options, &mut |point| {
        show(point);
        ControlFlow::Continue(())
    }));
}
