//! The twisted ring's buckled branch (Zajac 1962): entered at Michell's instability without noise, subcritical and
//! supercritical, its fold.
//!
//! Set-up: a closed flat circle of length 1, isotropic, B = 1, C/B = 1 or 1.5, nothing held, no contact; its excess
//! link is the parameter of the path. At ΔLk = √3·B/C two modes (one shape, anywhere along the ring) become unstable;
//! the path along the flat circle is left along one of them. Reference: the moment M3 of the buckled rod as a function
//! of its writhe does not depend on C, and near the circle M3 L/2πB = √3 − (11/8) Wr, since ΔLk = Wr + (M3 L/2πB)·(B/C)
//! rises with Wr exactly when C/B > 11/8. So dΔLk/dWr = 1 − (11/8)·B/C at the root: −3/8 for C/B = 1, 1/12 for 1.5. For
//! C/B = 1.5 the branch folds at ΔLk = 1.16279433, Wr = 0.18733722 (Kirchhoff rod, all digits).
//!
//! With contact the unstable branch beyond the fold ends where the ring first touches itself, and with it turns the
//! path: ΔLk rises again, the ring is stable. Writhe, moment and bending energy there, and ΔLk from them, for D/L = .01
//! and .03: Kirchhoff rod by shooting (`common/kirchhoff_ring.rs`). EA = GA = 1e8 lowers the energy by 4e-6.
//!
//! EA = GA = 1e8, for the fold extrapolated from 1e6 and 1e7 (stretch lowers its ΔLk by 3e-6 at 1e7; rounding of the
//! tangent, which grows with EA, decides how well its place is known); 48 cubic elements. Tolerances: root 1e-6, slope
//! 2e-6, fold 3e-8 in ΔLk and 1e-5 in Wr (ΔLk is stationary there).

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use common::kirchhoff_ring::{Event, event_of};
use common::{any_equilibrium, path_point, to_branch_point, verify};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use supercoil::math::Vec3;
use supercoil::observe::{contact_sites, observe};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, Ramp};
use supercoil::solve::{FollowOptions, Options, PathEnd, PathPoint, PointKind, Solver, Start, Status};

const RAMP: Ramp = Ramp::ExcessLink { rod: 0, to: 2.0 };

/// The flat ring at the point of instability.
fn ring_at_the_root(ratio: f64, rigid: f64, contact: Contact, diameter: f64) -> Solver {
    let section = Section::isotropic(1.0, ratio, rigid, rigid, 0.5 * diameter);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(48, 3), section, Natural::Straight).unwrap();
    let model = Model { contact, rods: vec![rod], ..Model::default() };
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    let root = to_branch_point(&mut solver, &RAMP);
    verify(
        &format!("twisted ring, C/B = {ratio}, EA = {rigid:.0e}"),
        "ΔLk at the branch point",
        root,
        3f64.sqrt() / ratio,
        100.0 / rigid,
    );
    solver
}

fn writhe(point: &PathPoint) -> f64 {
    observe(&point.progress).links[0].writhe
}

/// (Wr, ΔLk, unstable directions) of the first points of the branch.
fn branch(solver: &mut Solver, forwards: bool, points: usize) -> Vec<(f64, f64, usize)> {
    let start = Start::Branch { forwards };
    let options = FollowOptions { start, max_points: points, max_step: 0.05, ..FollowOptions::default() };
    let mut found = Vec::new();
    let report = solver.follow(&RAMP, &options, &mut |point| {
        println!("{}", path_point(point));
        if point.kind == PointKind::Regular {
            found.push((writhe(point), point.value, point.num_unstable()));
        }
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().num_points, points);
    found
}

/// Value and slope at Wr = 0 of the polynomial of least degree through the points.
fn at_zero(points: &[(f64, f64, usize)]) -> [f64; 2] {
    let count = points.len();
    let powers = nalgebra::DMatrix::from_fn(count, count, |i, k| points[i].0.powi(k as i32));
    let values = nalgebra::DVector::from_fn(count, |i, _| points[i].1);
    let c = powers.lu().solve(&values).unwrap();
    [c[0], c[1]]
}

#[test]
fn subcritical_and_supercritical() {
    for (ratio, unstable) in [(1.0, 1), (1.5, 0)] {
        let root = ring_at_the_root(ratio, 1e8, Contact::NONE, 0.01);
        let state = root.engine().state().clone();
        let mut solver = root;
        for forwards in [true, false] {
            solver.set_state(state.clone()).unwrap();
            let points = branch(&mut solver, forwards, 7);
            let case = format!("twisted ring, C/B = {ratio}, {}", if forwards { "forwards" } else { "backwards" });
            let [value, slope] = at_zero(&points[1..]);
            verify(&case, "ΔLk of the branch at Wr → 0", value, 3f64.sqrt() / ratio, 2e-6);
            verify(&case, "dΔLk/dWr of the branch at Wr → 0", slope, 1.0 - 11.0 / 8.0 / ratio, 2e-6);
            assert!(points.iter().all(|p| p.2 == unstable), "{points:?}");
        }
    }
}

/// ΔLk and Wr at the fold of the branch, C/B = 1.5.
fn fold_with(rigid: f64) -> [f64; 2] {
    let mut solver = ring_at_the_root(1.5, rigid, Contact::NONE, 0.01);
    let options = FollowOptions { start: Start::Branch { forwards: true }, ..FollowOptions::default() };
    let mut fold = None;
    let report = solver.follow(&RAMP, &options, &mut |point| {
        println!("{}", path_point(point));
        if point.kind != PointKind::Limit {
            return ControlFlow::Continue(());
        }
        fold = Some([point.value, writhe(point)]);
        ControlFlow::Break(())
    });
    fold.unwrap_or_else(|| panic!("{report:?}"))
}

/// The effect of stretch is linear in 1/EA: two stiffnesses give the Kirchhoff limit.
#[test]
fn fold() {
    let [soft, hard] = [1e6, 1e7].map(fold_with);
    let [link, writhe] = std::array::from_fn(|i| (10.0 * hard[i] - soft[i]) / 9.0);
    verify("twisted ring, C/B = 1.5, extrapolated from EA = 1e6, 1e7", "ΔLk at the fold", link, 1.162_794_33, 3e-8);
    verify("twisted ring, C/B = 1.5, extrapolated from EA = 1e6, 1e7", "Wr at the fold", writhe, 0.187_337_22, 1e-5);
}

/// What is looked at along a path with contact: ΔLk, writhe, M3 L/2πB, contact force, bending energy over that of the
/// ring.
fn numbers(point: &PathPoint) -> [f64; 5] {
    let seen = observe(&point.progress);
    let moment = seen.links[0].seam_moment / TAU;
    [point.value, seen.links[0].writhe, moment, seen.total_contact_force, seen.energies.bending / (0.5 * TAU * TAU)]
}

/// From the flat ring over the fold to first contact, round it and on; and back round it from the other side.
#[test]
fn first_contact_turns_the_path_round() {
    for diameter in [0.01, 0.03] {
        let exact = event_of(Event::FirstContact, diameter);
        let mut solver = ring_at_the_root(1.5, 1e8, Contact::default(), diameter);
        let case = format!("twisted ring with contact, D/L = {diameter}");
        let options = FollowOptions { start: Start::Branch { forwards: true }, ..FollowOptions::default() };
        let (mut corner, mut last) = (None, [0.0; 5]);
        let report = solver.follow(&Ramp::ExcessLink { rod: 0, to: 1.6 }, &options, &mut |point| {
            println!("{}", path_point(point));
            let before = last;
            last = numbers(point);
            if point.kind == PointKind::Corner {
                corner = Some(last);
                assert!(before[3] == 0.0 && point.slope < 0.0 && point.num_unstable() == 1);
            } else if point.kind != PointKind::Limit {
                assert_eq!(
                    (last[3] > 0.0, point.num_unstable() == 0),
                    (corner.is_some(), corner.is_some() || last[1] < 0.18)
                );
            }
            ControlFlow::Continue(())
        });
        assert_eq!(report.unwrap().end, PathEnd::Target);
        let followed = solver.engine().state().clone();
        let touch = corner.unwrap();
        verify(&case, "Wr at first contact", touch[1], exact.writhe, 1e-6);
        verify(&case, "M3 L/2πB at first contact", touch[2], exact.torque, 1e-6);
        verify(&case, "bending energy at first contact, over that of the ring", touch[4], exact.bending, 1e-5);
        verify(&case, "ΔLk at first contact", touch[0], exact.writhe + exact.torque / 1.5, 1e-6);

        // the way back, until the branch without contact rises well above its lowest ΔLk
        let mut back = None;
        let options = FollowOptions::default();
        let report = solver.follow(&Ramp::ExcessLink { rod: 0, to: 1.0 }, &options, &mut |point| {
            println!("{}", path_point(point));
            if point.kind == PointKind::Corner {
                back = Some(numbers(point));
                assert!(point.slope < 0.0 && point.num_unstable() == 0);
            } else if back.is_some() {
                assert_eq!((numbers(point)[3], point.num_unstable()), (0.0, 1));
            }
            if back.is_some() && point.value > 1.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(report.unwrap().end, PathEnd::Stopped);
        verify(&case, "ΔLk where contact ends, over that where it begins", back.unwrap()[0] / touch[0], 1.0, 1e-6);

        // the state at 1.6 is the one that load steps arrive at, as far as gaps are known: offsets may hold strands
        // 1e-6 radii apart; from where the loop lies on its mesh, which rounding decides at the branch point: elsewhere
        // on it the ripple of the mesh makes 1e-5 of the force
        let mut stepped = ring_at_the_root(1.5, 1e8, Contact::default(), diameter);
        *stepped.options_mut() = Options::default();
        stepped.set_state(followed).unwrap();
        for to in [1.7, 1.6] {
            let step = stepped.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
            assert_eq!((step.status, step.num_unstable), (Status::Converged, 0));
        }
        let force: f64 = contact_sites(stepped.engine()).iter().map(|site| site.force).sum();
        verify(&case, "contact force at ΔLk = 1.6, over that of load steps", last[3] / force, 1.0, 5e-6);
    }
}
