//! A planar model is the model in space with what leaves the plane left out: the same states to rounding, wherever
//! leaving it costs energy.
//!
//! * Cantilevers, B = 1 and 2, L = 1, under a force and a moment at the tip: orders 1 to 3; straight, evenly curved or
//!   stress-free as shaped; sections with d1 or d2 normal to the plane, isotropic ones slanting.
//! * Two cantilevers, one pressed on the other along a line of contact.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::f64::consts::FRAC_PI_2;

use supercoil::internals::quaternion::spin;
use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, State, Status};

fn states(model: &Model) -> [State; 2] {
    [true, false].map(|planar| {
        let mut solver = Solver::new(Model { planar, ..model.clone() }, Options::default()).unwrap();
        let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
        assert_eq!(report.status, Status::Converged, "planar: {planar}");
        solver.engine().state().clone()
    })
}

fn assert_same([flat, space]: &[State; 2], tol: f64, what: &str) {
    for (a, b) in flat.positions().iter().zip(space.positions()) {
        assert!((a - b).norm() < tol, "{what}: {a} {b}");
        assert_eq!(a.z, 0.0);
    }
    for (a, b) in flat.frames().iter().zip(space.frames()) {
        assert!(a.angle_to(b) < 10.0 * tol, "{what}");
    }
}

fn tip_loads(rod: &Rod, force: Vec3, moment: f64) -> Vec<NodeLoad> {
    let node = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    vec![NodeLoad { node, force, moment: Vec3::z() * moment }]
}

#[test]
fn cantilevers_bend_as_in_space() {
    // the stiffer axis lies in the plane with d2 normal to it; turned by a quarter, across
    let flat = Section { bending: [2.0, 1.0], shearing: [3e3, 2e3], ..Section::isotropic(1.0, 0.8, 1e4, 2e3, 0.0) };
    let round = Section::isotropic(1.0, 0.8, 1e4, 2e3, 0.0);
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::new(0.8, 0.6, 0.0), length: 1.0 };
    let spun = |section: Section, natural: Natural, order: usize, angle: f64| {
        let mut rod = Rod::new("beam", &line, RodMesh::open(6, order), section, natural).unwrap();
        let d1_lies = (rod.frames[0] * Vec3::x()).z.abs() < 0.5;
        for frame in &mut rod.frames {
            *frame *= spin(angle + if d1_lies { FRAC_PI_2 } else { 0.0 });
        }
        rod
    };
    // stress-free although frames are off the tangent: sheared by nature
    let wavy = |mut rod: Rod| {
        rod.positions.iter_mut().skip(1).for_each(|r| r.y += 0.03 * (3.0 * r.x).sin());
        rod.natural = Natural::AsShaped;
        rod
    };
    for order in 1..=3 {
        let rods = [
            ("d1 normal", spun(flat, Natural::Straight, order, 0.0)),
            ("d2 normal", spun(flat, Natural::Straight, order, FRAC_PI_2)),
            ("slanting", spun(round, Natural::Straight, order, 0.7)),
            ("evenly curved", spun(flat, Natural::Uniform { kappa: [0.9, 0.0, 0.0] }, order, 0.0)),
            ("as shaped", wavy(spun(round, Natural::AsShaped, order, 0.3))),
        ];
        for (what, rod) in rods {
            let model = Model {
                supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
                loads: tip_loads(&rod, Vec3::new(-0.7, 0.9, 0.0), 0.6),
                rods: vec![rod],
                contact: Contact::NONE,
                ..Model::default()
            };
            let [flat, space] = states(&model);
            assert!((flat.positions().last().unwrap() - Vec3::new(0.8, 0.6, 0.0)).norm() > 0.2);
            assert_same(&[flat, space], 1e-11, &format!("{what}, order {order}"));
        }
    }
}

#[test]
fn strands_in_contact_press_as_in_space() {
    let radius = 0.02;
    let rod = |k: usize| {
        let line = Shape::Line { start: Vec3::y() * (2.02 * radius * k as f64), direction: Vec3::x(), length: 1.0 };
        let section = Section::isotropic(1.0, 0.8, 1e4, 1e4, radius);
        Rod::new(&format!("leaf {k}"), &line, RodMesh::open(16, 3), section, Natural::Straight).unwrap()
    };
    let rods = vec![rod(1), rod(0)];
    let model = Model {
        supports: (0..2).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect(),
        loads: tip_loads(&rods[0], Vec3::y() * -0.05, 0.0),
        rods,
        ..Model::default()
    };
    let [flat, space] = states(&model);
    let tip = flat.positions().last().unwrap();
    assert!(tip.y < -0.005, "the lower leaf is to be pressed down: {tip}");
    assert_same(&[flat, space], 1e-9, "two leaves");
}
