//! What the two contact laws cost in accuracy: the penalty's error against its stiffness, the augmented Lagrangian's
//! freedom from it.
//!
//! * Point: two clamped beams of length L = 1, B = 1, crossing at right angles, pressed into each other by δ = .01 L.
//!   In an overlap c two round rods share a zone of length ∝ √c, so F ∝ κ c^{3/2}: penetration and error of the force
//!   fall as κ^(−2/3).
//! * Line: two parallel clamped beams pushed together along most of their length by a line load q (see `beams`). In the
//!   middle the penetration is q/κ; at the ends of the line the end force qℓ/3 spreads over (B/κ)^¼, so it falls as
//!   κ^(−3/4) only.
//!
//! ```text
//!        ‖               ▌‾‾╲___________╱‾‾▐
//!   ═════╬═════          ▌__╱‾‾‾‾‾‾‾‾‾‾‾╲__▐
//!        ‖
//! ```
//!
//! The augmented Lagrangian is asked for a penetration of 1e-9 contact distances. What is left of κ in its resultants
//! is the width over which a point is spread, second order in it.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::{fitted_order, history, observed, verify};
use supercoil::math::Vec3;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status, StepReport};

const RADIUS: f64 = 0.01;
const RADIUS_4: f64 = RADIUS * RADIUS * RADIUS * RADIUS;

fn penalty(kappa: f64) -> ContactLaw {
    ContactLaw::Penalty { stiffness: kappa * RADIUS_4 }
}

/// To 1e-9 contact distances.
fn augmented(kappa: f64) -> ContactLaw {
    ContactLaw::AugmentedLagrangian { stiffness: kappa * RADIUS_4, tol_penetration: 2e-9 }
}

fn beam(name: &str, start: Vec3, direction: Vec3, elements: usize) -> Rod {
    let section = Section::isotropic(1.0, 1.0, 1e2, 1e8, RADIUS);
    Rod::new(
        name,
        &Shape::Line { start, direction, length: 1.0 },
        RodMesh::open(elements, 3),
        section,
        Natural::Straight,
    )
    .unwrap()
}

fn model(rods: Vec<Rod>, law: ContactLaw) -> Model {
    let supports = rods.iter().enumerate();
    let supports = supports
        .flat_map(|(rod, r)| [0, r.num_nodes() - 1].map(|node| Support::clamp(NodeRef { rod, node })))
        .collect();
    Model { rods, supports, contact: Contact { law }, ..Model::default() }
}

fn see(solver: &Solver, report: &StepReport) -> Observation {
    assert_eq!(report.status, Status::Converged, "{}", history(report));
    observed(solver, report)
}

fn crossed(law: ContactLaw) -> (Solver, [Ramp; 2]) {
    let lower = beam("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x(), 16);
    let upper = beam("upper", Vec3::new(0.0, -0.5, 2.5 * RADIUS), Vec3::y(), 16);
    let last = upper.num_nodes() - 1;
    let to = Vec3::z() * -(0.5 * RADIUS + 0.01);
    let ramps = [0, last].map(|node| Ramp::Displacement { node: NodeRef { rod: 1, node }, to });
    (Solver::new(model(vec![lower, upper], law), Options::default()).unwrap(), ramps)
}

const GAP: f64 = 1e-4;

/// Line load that presses beams `gap` apart together along 7/12 of their length.
fn load(gap: f64) -> f64 {
    12.0 * 192.0 * gap
}

fn parallel(gap: f64, law: ContactLaw) -> (Solver, [Ramp; 1]) {
    let rods = vec![
        beam("lower", Vec3::zeros(), Vec3::x(), 96),
        beam("upper", Vec3::y() * (2.0 * RADIUS + gap), Vec3::x(), 96),
    ];
    let mut model = Model { planar: true, ..model(rods, law) };
    model.line_loads = vec![LineLoad::of_force(0, Vec3::y()), LineLoad::of_force(1, -Vec3::y())];
    (Solver::new(model, Options::default()).unwrap(), [Ramp::Load { to: load(gap) }])
}

/// Penetration and force over decades of the penalty.
fn decades(case: (Solver, impl AsRef<[Ramp]>), range: std::ops::RangeInclusive<i32>) -> Vec<[f64; 3]> {
    let (mut solver, ramps) = case;
    let mut report = solver.step_to(ramps.as_ref()).unwrap();
    let mut rows = Vec::new();
    for decade in range {
        solver.set_contact_law(penalty(10f64.powi(decade))).unwrap();
        report = solver.find_equilibrium();
        let seen = see(&solver, &report);
        println!(
            "κ 1e{decade}: penetration/D {:.4e}, force {:.12}, {} iterations",
            0.5 * report.penetration,
            seen.total_contact_force,
            report.iterations
        );
        rows.push([10f64.powi(decade), 0.5 * report.penetration, seen.total_contact_force]);
    }
    let _ = report;
    rows
}

fn slope(rows: &[[f64; 3]], value: impl Fn(&[f64; 3]) -> f64) -> f64 {
    fitted_order(&rows.iter().map(|r| r[0]).collect::<Vec<_>>(), &rows.iter().map(value).collect::<Vec<_>>())
}

#[test]
fn penalty_errors_at_a_point_fall_with_two_thirds_of_a_power() {
    let rows = decades(crossed(penalty(1e6)), 7..=14);
    let hard = rows[rows.len() - 1][2];
    let rows = &rows[..rows.len() - 3];
    verify("penalty, crossed beams", "exponent of the penetration", slope(rows, |r| r[1]), -2.0 / 3.0, 0.01);
    verify("penalty, crossed beams", "exponent of the force's error", slope(rows, |r| hard - r[2]), -2.0 / 3.0, 0.02);
}

#[test]
fn penalty_errors_along_a_line_fall_with_the_first_power() {
    let (mut solver, ramps) = parallel(GAP, penalty(1e5));
    let _ = solver.step_to(&ramps).unwrap();
    let mut rows = Vec::new();
    for decade in 6..=9 {
        let kappa = 10f64.powi(decade);
        solver.set_contact_law(penalty(kappa)).unwrap();
        let report = solver.find_equilibrium();
        let seen = see(&solver, &report);
        let middle = [0, 1].map(|rod| solver.engine().positions(rod)[144]);
        let depth = 2.0 * RADIUS - (middle[1] - middle[0]).norm();
        println!(
            "κ 1e{decade}: penetration/D {:.4e}, in the middle {:.4e}, force {:.12}, {} iterations",
            0.5 * report.penetration,
            0.5 * depth / RADIUS,
            seen.total_contact_force,
            report.iterations
        );
        rows.push([kappa, depth, report.penetration]);
    }
    let name = "penalty, parallel beams";
    for row in &rows[1..] {
        verify(
            name,
            &format!("penetration in the middle, κ = {:e}", row[0]),
            row[1],
            load(GAP) / row[0],
            0.01 * load(GAP) / row[0],
        );
    }
    verify(name, "exponent of the penetration in the middle", slope(&rows[1..], |r| r[1]), -1.0, 0.01);
    verify(name, "exponent of the penetration at the ends", slope(&rows[1..], |r| r[2]), -0.75, 0.02);
}

/// Augmented Lagrangians of all stiffnesses, each from the penalty state of the same stiffness: outer loops, inner
/// iterations, penetration, and what the supports of rod 1 carry, whose change from κ = 10^`decades`\[0\] on and from
/// 10^`decades`\[1\] on is verified.
fn augmented_over(name: &str, case: (Solver, impl AsRef<[Ramp]>), decades: [i32; 3], tolerances: [f64; 2]) {
    let (mut solver, ramps) = case;
    let _ = solver.step_to(ramps.as_ref()).unwrap();
    let mut resultants = Vec::new();
    for decade in decades[0]..=decades[2] {
        let kappa = 10f64.powi(decade);
        solver.set_contact_law(penalty(kappa)).unwrap();
        let report = solver.find_equilibrium();
        assert_eq!(report.status, Status::Converged, "{}", history(&report));
        solver.set_contact_law(augmented(kappa)).unwrap();
        let report = solver.find_equilibrium();
        let seen = see(&solver, &report);
        let carried: f64 = seen.reactions.iter().filter(|r| r.rod == 1).map(|r| r.force[1] + r.force[2]).sum();
        println!(
            "κ 1e{decade}: penetration/D {:.1e}, supports {carried:.12}, ∫p {:.12}, outer {}, inner {}, softened {}",
            0.5 * report.penetration,
            seen.total_contact_force,
            report.augmentations,
            report.iterations,
            report.stiffness_reduction
        );
        assert!(report.penetration <= 2e-9);
        resultants.push(carried);
    }
    let last = resultants[resultants.len() - 1];
    for (from, tolerance) in decades.into_iter().zip(tolerances) {
        let rest = &resultants[(from - decades[0]) as usize..];
        let worst = rest.iter().map(|f| (f / last - 1.0).abs()).fold(0.0, f64::max);
        verify(name, &format!("change of the resultant, κ = 1e{from} … 1e{}", decades[2]), worst, 0.0, tolerance);
    }
}

#[test]
fn augmented_resultant_of_a_point_does_not_depend_on_the_stiffness() {
    let case = crossed(penalty(1e6));
    augmented_over("augmented Lagrangian, crossed beams", case, [6, 8, 12], [3e-5, 1e-6]);
}

/// Six decades along a line. Softer laws take longer, as an augmentation mends only a share κ/(κ + Bq⁴) of wave number
/// q (κ = 1e7: 12; 1e6, a layer (B/κ)^¼ longer than the contact distance: more than 40). The stiffest law is given by
/// rounding: gaps are known to 1e-16 L, so pressures to 1e-16 κL, here 1e-3 of the load at κ = 1e14. The spacing of the
/// nodes, .0035, as long as the layer at 1e10, sets no limit.
#[test]
fn augmented_resultant_of_a_line_does_not_depend_on_the_stiffness() {
    let case = parallel(50.0 * GAP, penalty(1e5));
    augmented_over("augmented Lagrangian, parallel beams", case, [8, 9, 14], [1e-4, 1e-5]);
}

/// A minicircle whose line of contact ends between two nodes: the gap that stays at its edge must not lower the offset
/// there for ever, little by little.
#[test]
fn a_gap_at_the_edge_of_a_zone_gives_way() {
    let shape = Shape::Circle { length: 114.24, center: Vec3::zeros(), normal: Vec3::z() };
    let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
    for (elements, stiffness, steps, last) in [(48, 100.0, 17, -2.55), (32, 10.0, 19, -2.85)] {
        let rod = Rod::new("dna", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
        let law = ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-8 };
        let model = Model { rods: vec![rod], contact: Contact { law }, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        for step in 1..=steps {
            let to = last * f64::from(step) / f64::from(steps);
            let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
            println!("{elements} elements at {to:.2}: {} augmentations, {}", report.augmentations, history(&report));
            assert_eq!(report.status, Status::Converged, "{elements} elements at {to}");
            assert!(report.augmentations <= 20 && report.penetration <= 1e-8, "{report:?}");
        }
    }
}
