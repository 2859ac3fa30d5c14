//! Columns that buckle: the straight path, its branch points, the buckled branches on both sides, by continuation.
//!
//!  * Euler's column (1744), length 1, clamped at its foot, free at its top, dead load P along it. Buckles at P = π²/4;
//!    with k = sin(α/2), α the angle of the top, P = K(k)², top at x = 2E(k)/K(k) − 1, y = 2k/K(k) (Love 1927, §263).
//!  * Upright column of weight q per length (Greenhill 1881): buckles at q = 7.8373474389; beyond, θ″ + q(1 − s) sin θ
//!    = 0, θ(0) = 0, θ′(1) = 0, integrated here from the top down by Runge–Kutta.
//!
//! B = 1; 24 cubic elements. EA = GA = 1e8 along Euler's branch, 1e7 in the second case; branch points of Euler's
//! column with EA = GA = 1e5: stretch and shear then cancel in its critical load (Reissner 1982), and rounding of the
//! tangent, which grows with EA, decides how well an eigenvalue's zero is known. Tolerances: branch points 1e-7
//! absolute or 2e-7 relative, branches 2e-6.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::{any_equilibrium, path_point, runge_kutta, threshold, to_branch_point, verify};
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, LineLoad, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Engine, FollowOptions, PathEnd, PointKind, Solver, Start};

/// Complete elliptic integrals K(k), E(k) by the arithmetic-geometric mean.
fn elliptic(k: f64) -> (f64, f64) {
    let (mut a, mut b, mut c) = (1.0f64, (1.0 - k * k).sqrt(), k);
    let (mut sum, mut power) = (0.5 * c * c, 0.5);
    while c.abs() > 1e-16 {
        (a, b, c) = (0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b));
        power *= 2.0;
        sum += power * c * c;
    }
    let first = FRAC_PI_2 / a;
    (first, first * (1.0 - sum))
}

fn column(rigid: f64, along: Vec3, planar: bool, weight: bool) -> Solver {
    let section = Section::isotropic(1.0, 1.3, rigid, rigid, 1e-3);
    let shape = Shape::Line { start: Vec3::zeros(), direction: along, length: 1.0 };
    let rod = Rod::new("column", &shape, RodMesh::open(24, 3), section, Natural::Straight).unwrap();
    let top = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let mut model = Model { contact: Contact::NONE, rods: vec![rod], planar, ..Model::default() };
    model.supports.push(Support::clamp(NodeRef { rod: 0, node: 0 }));
    if weight {
        model.line_loads.push(LineLoad::of_force(0, -along));
    } else {
        model.loads.push(NodeLoad { node: top, force: -along, moment: Vec3::zeros() });
    }
    Solver::new(model, any_equilibrium()).unwrap()
}

/// Position of the top and the angle there against the column's axis.
fn top(engine: &Engine, along: &Vec3) -> (Vec3, f64) {
    let direction = engine.frames(0).last().unwrap() * Vec3::z();
    (*engine.positions(0).last().unwrap(), direction.cross(along).norm().atan2(direction.dot(along)))
}

#[test]
fn the_straight_column_passes_two_branch_points() {
    let mut solver = column(1e5, Vec3::x(), true, false);
    let mut found = Vec::new();
    let report = solver.follow(&Ramp::Load { to: 30.0 }, &FollowOptions::default(), &mut |point| {
        if let PointKind::Branch { multiplicity } = point.kind {
            found.push(point.value);
            assert_eq!(multiplicity, 1);
        }
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    assert_eq!(found.len(), 2);
    for (mode, load) in [1.0f64, 3.0].into_iter().zip(&found) {
        let reference = (mode * FRAC_PI_2).powi(2);
        verify("Euler's column", &format!("branch point {mode}"), *load, reference, 2e-7 * reference);
    }
    assert_eq!(solver.num_unstable().unwrap(), 2);
}

#[test]
fn euler_elastica_on_both_sides() {
    let mut ends = Vec::new();
    for forwards in [true, false] {
        let mut solver = column(1e8, Vec3::x(), true, false);
        let ramp = Ramp::Load { to: 20.0 };
        to_branch_point(&mut solver, &ramp);
        let options = FollowOptions { start: Start::Branch { forwards }, ..FollowOptions::default() };
        let mut worst = [0.0f64; 3];
        let report = solver.follow(&ramp, &options, &mut |point| {
            println!("{}", path_point(point));
            let (position, angle) = top(point.engine(), &Vec3::x());
            let k = (0.5 * angle).sin();
            let (first, second) = elliptic(k);
            let errors = [
                point.value - first * first,
                position.x - (2.0 * second / first - 1.0),
                position.y.abs() - 2.0 * k / first,
            ];
            (0..3).for_each(|i| worst[i] = worst[i].max(errors[i].abs()));
            assert_eq!(point.num_unstable(), 0, "the buckled column is stable");
            ControlFlow::Continue(())
        });
        let report = report.unwrap();
        assert!(report.end == PathEnd::Target && report.num_points > 10);
        let case = format!("Euler's elastica, {}", if forwards { "forwards" } else { "backwards" });
        for (name, error) in ["load", "height of the top", "deflection of the top"].into_iter().zip(worst) {
            verify(&case, &format!("largest error along the branch, {name}"), error, 0.0, 2e-6);
        }
        ends.push(top(solver.engine(), &Vec3::x()).0);
    }
    assert!((ends[0].y + ends[1].y).abs() < 1e-7 && ends[0].y.abs() > 0.1, "mirror images: {ends:?}");
}

/// Back along the branch, through its root, onto the other side: there the load turns and no eigenvalue changes sign.
/// (A column ten times as slender has a hundred times the rounding: its root moves by some 1e-7 with the order in which
/// its elements add up.)
#[test]
fn the_root_seen_from_the_branch() {
    let mut solver = column(1e4, Vec3::x(), true, false);
    let ramp = Ramp::Load { to: 20.0 };
    to_branch_point(&mut solver, &ramp);
    let out = FollowOptions { start: Start::Branch { forwards: true }, max_points: 6, ..FollowOptions::default() };
    assert_eq!(solver.follow(&ramp, &out, &mut |_| ControlFlow::Continue(())).unwrap().end, PathEnd::MaxPoints);
    let side = top(solver.engine(), &Vec3::x()).0.y;
    let mut roots = Vec::new();
    let back = FollowOptions { start: Start::Away, ..FollowOptions::default() };
    let report = solver.follow(&ramp, &back, &mut |point| {
        println!("{}", path_point(point));
        if !matches!(point.kind, PointKind::Regular | PointKind::Start | PointKind::Target) {
            roots.push((point.kind, point.value));
        }
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    assert!(side * top(solver.engine(), &Vec3::x()).0.y < 0.0, "came out on the same side");
    assert!(matches!(roots[..], [(PointKind::Branch { multiplicity: 0 }, _)]), "{roots:?}");
    verify("Euler's elastica", "load at the root, seen from the branch", roots[0].1, PI * PI / 4.0, 1e-7);
}

/// Angle at the foot of the heavy column whose top is turned by `angle` under the weight q.
fn foot_angle(angle: f64, weight: f64) -> f64 {
    // s is carried along as a third unknown
    let rate = |y: &[f64; 3]| [y[1], -weight * (1.0 - y[2]) * y[0].sin(), 1.0];
    runge_kutta::along(rate, [angle, 0.0, 1.0], -1.0, 2000)[0]
}

#[test]
fn column_under_its_own_weight() {
    let mut solver = column(1e7, Vec3::z(), false, true);
    let ramp = Ramp::Load { to: 20.0 };
    let root = to_branch_point(&mut solver, &ramp);
    verify("self-weight column", "q L³/B at the branch point", root, 7.837_347_438_9, 5e-6);
    let options = FollowOptions { start: Start::Branch { forwards: true }, ..FollowOptions::default() };
    let mut points = 0;
    let report = solver.follow(&ramp, &options, &mut |point| {
        println!("{}", path_point(point));
        assert_eq!(point.num_unstable(), 0, "round: it may turn about its axis at no cost, and that is not unstable");
        assert!(!matches!(point.kind, PointKind::Branch { .. } | PointKind::Limit));
        let angle = top(point.engine(), &Vec3::z()).1;
        let reference = threshold(7.83, 30.0, 1e-10, |weight| foot_angle(angle, weight) < 0.0);
        let case = "self-weight column, buckled";
        verify(case, &format!("q L³/B at a top angle of {angle:.3}"), point.value, reference, 1e-5 * reference);
        points += 1;
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    assert!(points > 10);
}
