//! Clamped beams in contact, against small-displacement closed forms.
//!
//! * Two beams crossing at right angles at mid-span, the ends of one lowered by δ after first touch: F = 96 B δ/L³.
//! * Two parallel beams a gap g apart, both pushed together by a line load q: they touch at mid-span at q₁ = 192 B g/L⁴
//!   (each bends by g/2), contact stays a point until 3 q₁, then a line grows.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{LineLoad, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Progress, Solver, Status};

const RADIUS: f64 = 0.01;

fn beam(name: &str, start: Vec3, direction: Vec3, elements: usize) -> Rod {
    let section = Section::isotropic(1.0, 1.0, 1e7, 1e7, RADIUS);
    let shape = Shape::Line { start, direction, length: 1.0 };
    Rod::new(name, &shape, false, section, elements, 3, Natural::Straight).unwrap()
}

fn clamped(rods: Vec<Rod>) -> Model {
    let supports = rods
        .iter()
        .enumerate()
        .flat_map(|(rod, r)| [0, r.num_nodes() - 1].map(|node| Support::clamp(NodeRef { rod, node })))
        .collect();
    Model { rods, supports, ..Model::default() }
}

fn to(solver: &mut Solver, ramps: &[Ramp]) -> Observation {
    let report = solver.step_to(ramps).unwrap();
    assert_eq!(report.status, Status::Converged);
    let progress =
        Progress { engine: solver.engine(), stage: 0, step: 0, fraction: 1.0, report: &report, seconds: 0.0 };
    observe(&progress)
}

#[test]
fn crossed_beams_press_with_the_exact_force() {
    for elements in [8, 9] {
        // with an odd number of elements the crossing lies inside a segment, not on a node
        let lower = beam("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), elements);
        let upper = beam("upper", Vec3::new(0.0, -0.5, 2.5 * RADIUS), Vec3::y(), elements);
        let last = upper.num_nodes() - 1;
        let mut solver = Solver::new(clamped(vec![lower, upper]), Options::default()).unwrap();
        let lowered = |by: f64| -> Vec<Ramp> {
            [0, last].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to: Vec3::z() * -by }).to_vec()
        };
        let touch = 0.5 * RADIUS;
        for deflection in [1e-4, 2e-4, 5e-4] {
            let seen = to(&mut solver, &lowered(touch + deflection));
            let exact = 96.0 * deflection;
            println!("δ {deflection}: force {} exact {exact}", seen.total_contact_force);
            assert_eq!(seen.sites.len(), 1);
            assert_eq!(seen.sites[0].kind, "point");
            assert!((seen.sites[0].angle - 90.0).abs() < 0.1);
            // stretching stiffens by (δ/2)²·EA/B-ish, shear softens by 1e-5: both below 1e-3 here for the first two
            let stretch = 1e7 * deflection * deflection / 40.0;
            let tolerance = 2e-3 + stretch;
            assert!((seen.total_contact_force / exact - 1.0).abs() < tolerance, "force {}", seen.total_contact_force);
            // the reactions of the upper beam balance the contact force
            let up: f64 = seen.reactions.iter().filter(|r| r.rod == 1).map(|r| r.force[2]).sum();
            assert!((up + seen.total_contact_force).abs() < 1e-6 * seen.total_contact_force, "reaction {up}");
        }
    }
}

/// The force of two crossing beams does not depend on the crossing angle, from nearly parallel to perpendicular.
#[test]
fn any_crossing_angle_gives_the_same_force() {
    let deflection = 1e-4;
    for degrees in [3.0f64, 10.0, 30.0, 60.0, 90.0] {
        let direction = Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
        let lower = beam("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), 24);
        let upper = beam("upper", Vec3::z() * (2.5 * RADIUS) - direction * 0.5, direction, 24);
        let last = upper.num_nodes() - 1;
        let mut solver = Solver::new(clamped(vec![lower, upper]), Options::default()).unwrap();
        let ramps = [0, last].map(|node| Ramp::Displacement {
            node: NodeRef { rod: 1, node },
            to: Vec3::z() * -(0.5 * RADIUS + deflection),
        });
        let seen = to(&mut solver, &ramps);
        let exact = 96.0 * deflection;
        println!("{degrees}°: force {} exact {exact}, {} site(s)", seen.total_contact_force, seen.sites.len());
        assert!((seen.total_contact_force / exact - 1.0).abs() < 5e-3, "force {}", seen.total_contact_force);
        assert!((seen.sites[0].angle - degrees).abs() < 0.1, "angle {}", seen.sites[0].angle);
    }
}

#[test]
fn parallel_beams_touch_in_a_point_then_along_a_line() {
    let gap = 1e-4;
    let lower = beam("lower", Vec3::zeros(), Vec3::x(), 24);
    let upper = beam("upper", Vec3::new(0.0, 2.0 * RADIUS + gap, 0.0), Vec3::x(), 24);
    let first = 192.0 * gap;
    let mut model = clamped(vec![lower, upper]);
    model.planar = true;
    model.line_loads = vec![LineLoad { rod: 0, force: Vec3::y() }, LineLoad { rod: 1, force: -Vec3::y() }];
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let mut at = |factor: f64| to(&mut solver, &[Ramp::Load { to: factor * first }]);
    let seen = at(0.98);
    assert!(seen.sites.is_empty(), "{:?}", seen.sites);
    for factor in [1.5, 2.0, 2.9] {
        let seen = at(factor);
        assert_eq!(seen.sites.len(), 1);
        // a clamped beam under q with a central force F deflects (q/384 − F/192) L⁴/B at mid-span = g/2
        let exact = 0.5 * factor * first - 96.0 * gap;
        println!("{factor} q1: force {} exact {exact}, zone {:?}", seen.total_contact_force, seen.sites[0].arc_a);
        assert!((seen.total_contact_force / exact - 1.0).abs() < 5e-3);
    }
    for factor in [6.0, 12.0, 24.0] {
        let seen = at(factor);
        let q = factor * first;
        // lift-off length ℓ at each end: the line spans L − 2ℓ and carries q plus end reactions qℓ/3... in all q(L − 2ℓ) + 2 qℓ/3
        let lift_off = (36.0 * gap / q).powf(0.25);
        let exact = q * (1.0 - 2.0 * lift_off) + 2.0 * q * lift_off / 3.0;
        let from = seen.sites.iter().map(|s| s.arc_a[0]).fold(f64::INFINITY, f64::min);
        let until = seen.sites.iter().map(|s| s.arc_a[1]).fold(0.0, f64::max);
        println!(
            "{factor} q1: force {} exact {exact}, line {from:.4}..{until:.4}, ℓ {lift_off:.4}",
            seen.total_contact_force
        );
        assert!((seen.total_contact_force / exact - 1.0).abs() < 1e-2);
        assert!((from - lift_off).abs() < 0.02 && (1.0 - until - lift_off).abs() < 0.02);
    }
}
