//! A cantilever rolled into a full circle by an end moment 2πB/L, in ONE load step.
//!
//! Exact: the tip returns to the clamp. Orders 1, 2, 3; slenderness L/ε from 1e1 to 1e6 through
//! EA = 4B/ε², GA = 2B/ε² (a solid disc with E = 2G).

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

fn cantilever(order: usize, elements: usize, slenderness: f64) -> Model {
    let radius = 1.0 / slenderness;
    let section = Section::isotropic(1.0, 1.0, 4.0 / (radius * radius), 2.0 / (radius * radius), radius);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("cantilever", &shape, false, section, elements, order, Natural::Straight).unwrap();
    let tip = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: tip, force: Vec3::zeros(), moment: Vec3::z() * std::f64::consts::TAU }],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    }
}

#[test]
fn a_full_circle_takes_one_step_and_at_most_ten_iterations() {
    for (order, elements) in [(1, 16), (2, 8), (3, 4)] {
        for slenderness in [1e1, 1e2, 1e4, 1e6] {
            let mut solver = Solver::new(cantilever(order, elements, slenderness), Options::default()).unwrap();
            let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
            let tip = solver.engine().positions(0).last().unwrap().norm();
            println!(
                "order {order} slenderness {slenderness:e}: {} iterations, tip error {tip:.3e}",
                report.iterations
            );
            for h in &report.history {
                for i in h {
                    println!("   {i:?}");
                }
            }
            assert_eq!(report.status, Status::Converged);
            assert!(report.iterations <= 10);
        }
    }
}
