//! Newton's order of convergence in every state of contact: points, lines, points beside a line.
//!
//! ```text
//!   crossed beams   parallel beams   pressed ring    twisted ring, D/L = .03
//!        │            ___________      __      __      1 point   2 points   3 points   line + 2 points
//!    ────┼────        ‾‾‾‾‾‾‾‾‾‾‾     (__======__)     ΔLk 1.5   2.2        2.34       2.6
//! ```
//!
//! B = 1, EA = GA = 1e6 (parallel beams 100 along, so that bending does not stretch them), cubic elements. From a state
//! at rest under a penalty the load goes on by steps, each half the one before, each from that same state; the search
//! goes on down to increments of 1e-12. Increments e (largest displacement over node spacing, or rotation) obey e′ ≈ c
//! e²: the order is the slope of log e′ against log e. Beams and pressed ring: e the first increment of a search, e′
//! the second, five steps. Twisted ring: the least power in e′ = eᵖ of all pairs of six steps with 1e-5 < e < 1e-3, but
//! for the first of each: the first increment contains the turn of the seam, and what is left after it has a share of
//! 1e-4 that is linear and gone with the next. Near rest each step is corrected once or more on its own factorisation
//! by all that is out of balance after it: the order is 3 in places.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::cases::oval_ring;
use common::{fitted_order, history, sci, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status, StepReport};

/// Of the beams.
const RADIUS: f64 = 0.01;

fn penalty(kappa: f64, radius: f64) -> ContactLaw {
    ContactLaw::Penalty { stiffness: kappa * radius.powi(4) }
}

/// Increments below this are rounding, and those that a power is told from are between these.
const ROUNDING: f64 = 5e-12;
const LEAST: f64 = 1e-5;
const MOST: f64 = 1e-3;

/// Checks that an order is 2 or more.
fn quadratic(case: &str, decade: i32, order: f64, tolerance: f64) {
    let quantity = format!("order of Newton's increments (2 if more), κ = 1e{decade}");
    verify(case, &quantity, order.min(2.0), 2.0, tolerance);
}

/// The slope of the next increment over the one before.
fn order(pairs: &[[f64; 2]]) -> f64 {
    println!("  {}", pairs.iter().map(|p| sci(p)).collect::<Vec<_>>().join(", "));
    let (e, next): (Vec<f64>, Vec<f64>) = pairs.iter().map(|p| (p[0], p[1])).unzip();
    fitted_order(&e, &next)
}

fn increments(report: &StepReport) -> Vec<f64> {
    assert_eq!(report.status, Status::Converged, "{}", history(report));
    report.history.iter().flatten().map(|i| i.increment).collect()
}

/// The same problem and state under another law, at rest.
fn under(solver: &Solver, law: ContactLaw) -> Solver {
    let mut model = solver.engine().model().clone();
    model.contact.law = law;
    let mut other = Solver::new(model, Options::default()).unwrap();
    other.options_mut().newton.tol_increment = 1e-12;
    other.set_state(solver.engine().state().clone()).unwrap();
    let report = other.resettle();
    assert_eq!(report.status, Status::Converged, "{}", history(&report));
    other
}

/// Orders under laws that are raised from one to the next.
fn loaded(
    mut solver: Solver,
    radius: f64,
    decades: std::ops::RangeInclusive<i32>,
    ramp: &dyn Fn(f64) -> Ramp,
) -> Vec<f64> {
    let mut orders = Vec::new();
    for decade in decades {
        let law = penalty(10f64.powi(decade), radius);
        solver = under(&solver, law);
        let step = |k: i32| increments(&under(&solver, law).step_to(&[ramp(0.5f64.powi(k))]).unwrap());
        // the larger steps are not in the basin yet
        orders.push(order(&(3..8).map(step).map(|e| [e[0], e[1]]).collect::<Vec<_>>()));
    }
    orders
}

#[test]
fn twisted_ring() {
    let radius = 0.015;
    let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, radius);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(96, 3), section, Natural::Straight).unwrap();
    let contact = Contact { law: penalty(1e9, radius) };
    let mut soft = Solver::new(Model { rods: vec![rod], contact, ..Model::default() }, Options::default()).unwrap();
    let states: [(&[f64], f64, &str); 4] = [
        (&[1.1, 1.2, 1.3], 1.5, "one point"),
        (&[1.7, 1.8, 1.9, 2.0, 2.1], 2.2, "two points"),
        (&[2.3], 2.34, "three points"),
        (&[2.45], 2.6, "line between two points"),
    ];
    for (way, link, name) in states {
        for &to in way.iter().chain([&link]) {
            assert_eq!(soft.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap().status, Status::Converged);
        }
        let mut solver = under(&soft, penalty(1e10, radius));
        for decade in 11..=13 {
            let law = penalty(10f64.powi(decade), radius);
            solver = under(&solver, law);
            let step = |k: i32| {
                let to = link + 4e-3 * 0.5f64.powi(k);
                let report = under(&solver, law).step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
                increments(&report)
            };
            // the larger steps are not in the basin yet
            let searches: Vec<Vec<f64>> = (2..8).map(step).collect();
            let later = searches.iter().flat_map(|e| e[1..].windows(2)).filter(|e| (LEAST..MOST).contains(&e[0]));
            let power = later.map(|e| e[1].max(ROUNDING).ln() / e[0].ln()).fold(f64::INFINITY, f64::min);
            for e in &searches {
                println!("  {}", sci(e));
            }
            quadratic(&format!("twisted ring, {name}"), decade, power, 0.5);
        }
    }
}

#[test]
fn ring_under_pressure() {
    let diameter = 0.01;
    let mut solver =
        Solver::new(oval_ring(64, diameter, 1e6, penalty(1e5, 0.5 * diameter)), Options::default()).unwrap();
    for p in [3.3, 3.6, 4.0, 4.4, 4.8, 5.1, 5.3, 6.0, 8.0, 10.0, 12.0] {
        assert_eq!(solver.step_to(&[Ramp::Pressure { rod: 0, to: p }]).unwrap().status, Status::Converged);
    }
    let name = "ring under pressure, line";
    let orders = loaded(solver, 0.5 * diameter, 6..=8, &|share| Ramp::Pressure { rod: 0, to: 12.0 + 0.1 * share });
    for (decade, order) in (6..).zip(orders) {
        quadratic(name, decade, order, 0.1);
    }
}

/// Two clamped beams, pressed together by line loads along `push`.
fn beams(start: Vec3, direction: Vec3, push: Vec3, stretching: f64) -> Solver {
    let section = Section::isotropic(1.0, 1.0, stretching, 1e6, RADIUS);
    let beam = |name: &str, start: Vec3, direction: Vec3| {
        let shape = Shape::Line { start, direction, length: 1.0 };
        Rod::new(name, &shape, RodMesh::open(32, 3), section, Natural::Straight).unwrap()
    };
    let rods = vec![beam("lower", Vec3::zeros(), Vec3::x()), beam("upper", start, direction)];
    let last = rods[0].num_nodes() - 1;
    let supports = (0..2).flat_map(|rod| [0, last].map(|node| Support::clamp(NodeRef { rod, node }))).collect();
    let line_loads = vec![LineLoad::of_force(0, push), LineLoad::of_force(1, -push)];
    let contact = Contact { law: penalty(1e5, RADIUS) };
    let planar = direction == Vec3::x();
    Solver::new(Model { rods, supports, line_loads, contact, planar, ..Model::default() }, Options::default()).unwrap()
}

#[test]
fn crossed_beams() {
    let mut solver = beams(Vec3::new(0.5, -0.5, 0.021), Vec3::y(), Vec3::z(), 1e6);
    assert_eq!(solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap().status, Status::Converged);
    let name = "crossed beams, point";
    let orders = loaded(solver, RADIUS, 6..=10, &|share| Ramp::Load { to: 1.0 + 0.2 * share });
    for (decade, order) in (6..).zip(orders) {
        quadratic(name, decade, order, 0.1);
    }
}

#[test]
fn parallel_beams() {
    let first = 192e-4;
    let mut solver = beams(Vec3::y() * (2.0 * RADIUS + 1e-4), Vec3::x(), Vec3::y(), 1e2);
    assert_eq!(solver.step_to(&[Ramp::Load { to: 12.0 * first }]).unwrap().status, Status::Converged);
    let orders = loaded(solver, RADIUS, 6..=9, &|share| Ramp::Load { to: (12.0 + share) * first });
    for (decade, order) in (6..).zip(orders) {
        quadratic("parallel beams, line", decade, order, 0.1);
    }
}
