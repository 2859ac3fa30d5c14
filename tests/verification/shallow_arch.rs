//! The shallow pinned arch: its symmetric path loses stability at a branch point, before its limit point.
//!
//! Set-up: a circular arc of radius 5 and length 1, stress-free, in a plane, pinned at both ends; B = 1, EA = GA = 1e5;
//! a dead load at the apex; 20 cubic elements. Reference: the load in steps, up to which the arch does not snap
//! through. At the branch point the tangent is singular: steps of any length along the path must find the same place,
//! to 1e-6.

use crate::common;

use common::{any_equilibrium, history, threshold, to_branch_point_by, verify};
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

fn arch(options: Options) -> Solver {
    let (radius, length) = (5.0, 1.0);
    let tangent = Vec3::new(1.0, 0.1, 0.0).normalize();
    let towards = Vec3::new(0.1, -1.0, 0.0).normalize();
    let shape = Shape::Arc { start: Vec3::zeros(), tangent, towards, radius, angle: length / radius };
    let section = Section::isotropic(1.0, 1.0, 1e5, 1e5, 0.0);
    let rod = Rod::new("arch", &shape, RodMesh::open(20, 3), section, Natural::AsShaped).unwrap();
    let node = |node| NodeRef { rod: 0, node };
    let supports = vec![Support::pin(node(0)), Support::pin(node(rod.num_nodes() - 1))];
    let loads = vec![NodeLoad { node: node(rod.num_nodes() / 2), force: -Vec3::y(), moment: Vec3::zeros() }];
    let model = Model { supports, loads, contact: Contact::NONE, rods: vec![rod], planar: true, ..Model::default() };
    Solver::new(model, options).unwrap()
}

#[test]
fn steps_of_any_length_find_the_same_branch_point() {
    let reference = threshold(4.0, 4.3, 1e-4, |load| {
        let mut solver = arch(Options::default());
        let heights = [0.9, 1.0].map(|part| {
            let report = solver.step_to(&[Ramp::Load { to: part * load }]).unwrap();
            assert_eq!(report.status, Status::Converged, "{}", history(&report));
            let nodes = solver.engine().positions(0);
            nodes[nodes.len() / 2].y
        });
        heights[1] < 0.5 * heights[0]
    });
    let found = [0.05, 0.01, 0.002].map(|step| {
        let found = to_branch_point_by(&mut arch(any_equilibrium()), &Ramp::Load { to: 200.0 }, step);
        verify("shallow pinned arch", &format!("load at the branch point, steps of {step}"), found, reference, 2e-4);
        found
    });
    assert!(found.iter().all(|at| (at - found[0]).abs() < 4e-6), "{found:?}");
}
