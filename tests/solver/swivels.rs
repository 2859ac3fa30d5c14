//! A support that holds rotation about one axis: the rod may tilt there, and twist does not leak out.
//!
//! ```text
//!            __ .--.__
//!   (o)-----'         '--▒      end carried round a square across the axis, so that the start tilts round a cone
//! ```
//!
//! * A rod between such a support and a clamp, with .6 turns of twist, L = 1, B = 1, C = 1.5. Its end goes up, aside,
//!   down and back. The state is a function of where the end is, so the energy comes back too. (Held by increments
//!   that do not turn about the axis, it falls to a tenth before the first corner and by 6 % a round.)
//! * A rod twisted between two of them on one axis: what goes in on one side comes out on the other, and the bent rod
//!   turns for nothing. It comes to rest all the same, after pushing the ends together.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use common::{history, observed};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status, StepReport};

fn rod() -> Rod {
    let section = Section::isotropic(1.0, 1.5, 1e5, 1e5, 0.01);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    Rod::new("rod", &shape, RodMesh::open(24, 3), section, Natural::Straight).unwrap()
}

const START: NodeRef = NodeRef { rod: 0, node: 0 };

fn solver(supports: Vec<Support>, law: ContactLaw) -> Solver {
    let model = Model { rods: vec![rod()], supports, contact: Contact { law }, ..Model::default() };
    Solver::new(model, Options::default()).unwrap()
}

fn step(solver: &mut Solver, ramp: Ramp) -> StepReport {
    let report = solver.step_to(&[ramp]).unwrap();
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", history(&report));
    report
}

#[test]
fn energy_comes_back_with_the_end_of_the_rod() {
    let end = NodeRef { rod: 0, node: rod().num_nodes() - 1 };
    let swivel = Support { node: START, position: [true; 3], rotation: [true, false, false] };
    let mut solver = solver(vec![swivel, Support::clamp(end)], ContactLaw::None);
    step(&mut solver, Ramp::Displacement { node: end, to: Vec3::new(-0.1, 0.0, 0.0) });
    step(&mut solver, Ramp::Rotation { node: end, axis: Vec3::x(), to: 0.6 });
    let energy = |solver: &Solver, report: &StepReport| observed(solver, report).energies.total;
    let mut corners = Vec::new();
    for round in 0..2 {
        for (y, z) in [(0.3, 0.0), (0.3, 0.3), (0.0, 0.3), (0.0, 0.0)] {
            let report = step(&mut solver, Ramp::Displacement { node: end, to: Vec3::new(-0.1, y, z) });
            corners.push(energy(&solver, &report));
        }
        println!("round {round}: {:?}", &corners[4 * round..]);
    }
    for k in 0..4 {
        let change = (corners[k + 4] / corners[k] - 1.0).abs();
        assert!(change < 1e-9, "corner {k}: {} and {}", corners[k], corners[k + 4]);
    }
}

#[test]
fn two_on_one_axis_let_the_rod_turn() {
    let end = NodeRef { rod: 0, node: rod().num_nodes() - 1 };
    let swivel = |node| Support { node, position: [true; 3], rotation: [true, false, false] };
    let mut solver = solver(vec![swivel(START), swivel(end)], ContactLaw::None);
    // the first step buckles, from a straight rod to far out, in 41 iterations
    for (by, most) in [(-0.1, 60), (-0.3, 10), (-0.5, 10)] {
        let report = step(&mut solver, Ramp::Displacement { node: end, to: Vec3::new(by, 0.0, 0.0) });
        println!("{by}: {} iterations", report.iterations);
        assert!(report.iterations <= most, "{}", history(&report));
    }
}
