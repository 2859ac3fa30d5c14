//! Joined nodes stay joined: states do not depend on the number of load steps, forwards and back.
//!
//! * A cantilever cut in two and joined, and cut in two with the second half at its own angle about the axis: its tip
//!   is that of the whole rod. (When predictions moved nodes one by one: −.1327, −.0748, −.0555, −.0361 in 1, 2, 3, 6
//!   steps.)
//! * Three rods joined at a point, at angles.
//! * A rod bent to a circle and joined to itself.
//! * A ring that is wound while it is joined to a clamped strut.
//! * A joint that stages displace, turn and bring to a pose.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use std::f64::consts::TAU;

use crate::common;

use common::{history, observed};
use std::ops::ControlFlow;
use std::path::Path;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};

use supercoil::observe::observe;
use supercoil::scene::{Contact, Joint, Model, NodeLoad, NodeRef, Pose, PosePath, Ramp, Scene, Stage, Support};
use supercoil::solve::{FollowOptions, Options, Solver, Status, run};

const STEPS: [usize; 5] = [1, 2, 3, 5, 6];

fn rod(name: &str, shape: &Shape, elements: usize) -> Rod {
    let closed = matches!(shape, Shape::Circle { .. });
    let section = Section::isotropic(1.0, 0.8, 1e5, 1e5, 0.0);
    Rod::new(name, shape, RodMesh { closed, num_elements: elements, order: 3 }, section, Natural::AsShaped).unwrap()
}

fn line(name: &str, start: Vec3, way: Vec3) -> Rod {
    rod(name, &Shape::Line { start, direction: way, length: way.norm() }, 4)
}

fn node(rod: usize, node: usize) -> NodeRef {
    NodeRef { rod, node }
}

/// Rods joined at nodes, the first clamped at its first node, a force at the end of the last.
fn model(rods: Vec<Rod>, joints: &[[NodeRef; 2]], force: Vec3) -> Model {
    let end = node(rods.len() - 1, rods[rods.len() - 1].num_nodes() - 1);
    Model {
        joints: joints.iter().map(|&[a, b]| Joint::rigid(a, b)).collect(),
        supports: vec![Support::clamp(node(0, 0))],
        loads: vec![NodeLoad { node: end, force, moment: Vec3::zeros() }],
        contact: Contact::NONE,
        rods,
        ..Model::default()
    }
}

fn place(solver: &Solver, at: NodeRef) -> (Vec3, Quat) {
    let engine = solver.engine();
    (engine.positions(at.rod)[at.node], engine.frames(at.rod)[at.node])
}

/// Energy and position of the last node at the end of a ramp from 0 in so many steps. Joined nodes coincide after each
/// step, their frames are as they were joined; back in as many steps the energy is 0 again.
fn end_in_steps(model: &Model, ramp: impl Fn(f64) -> Ramp, steps: usize) -> (f64, Vec3) {
    let mut solver = Solver::new(model.clone(), Options::default()).unwrap();
    let turned = |solver: &Solver, joint: &Joint| {
        let [(r, a), (s, b)] = [joint.a, joint.b].map(|at| place(solver, at));
        assert!((r - s).norm() < 1e-14, "{r} {s}");
        a.inverse() * b
    };
    let made: Vec<Quat> = model.joints.iter().map(|joint| turned(&solver, joint)).collect();
    let mut step = |part: f64| {
        let report = solver.step_to(&[ramp(part)]).unwrap();
        assert_eq!(report.status, Status::Converged, "{}", history(&report));
        for (joint, made) in model.joints.iter().zip(&made) {
            assert!(turned(&solver, joint).angle_to(made) < 1e-12);
        }
        let last = solver.engine().positions(model.rods.len() - 1).last().copied().unwrap();
        (observed(&solver, &report).energies.total, last)
    };
    let there = (1..=steps).map(|k| step(k as f64 / steps as f64)).last().unwrap();
    let back = (0..steps).rev().map(|k| step(k as f64 / steps as f64)).last().unwrap();
    assert!(back.0.abs() < 1e-9, "{steps}: {}", back.0);
    there
}

/// The ends in all numbers of steps agree; the first of them.
fn same_in_all(model: &Model, ramp: impl Fn(f64) -> Ramp) -> (f64, Vec3) {
    let ends = STEPS.map(|steps| end_in_steps(model, &ramp, steps));
    for (steps, end) in STEPS.iter().zip(&ends) {
        let (energy, moved) = ((end.0 - ends[0].0).abs(), (end.1 - ends[0].1).norm());
        assert!(energy < 1e-8 * ends[0].0 && moved < 1e-8, "{steps}: {energy:e} {moved:e}");
    }
    ends[0]
}

fn load(to: f64) -> Ramp {
    Ramp::Load { to }
}

#[test]
fn a_cantilever_cut_in_two_is_a_cantilever() {
    let force = Vec3::new(0.0, 0.0, -0.05);
    let cut =
        |second: Rod| model(vec![line("a", Vec3::zeros(), Vec3::x()), second], &[[node(0, 12), node(1, 0)]], force);
    let whole = rod("whole", &Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 }, 8);
    let (energy, tip) = end_in_steps(&model(vec![whole], &[], force), load, 1);
    assert!((tip.z + 0.1327).abs() < 1e-4, "{tip}");
    // turned about its axis by a third of a turn
    let mut turned = line("b", Vec3::x(), Vec3::x());
    turned.frames.iter_mut().for_each(|frame| *frame *= Quat::from_axis_angle(&Vec3::z_axis(), TAU / 3.0));
    for second in [line("b", Vec3::x(), Vec3::x()), turned] {
        let (joined, end) = same_in_all(&cut(second), load);
        assert!((joined / energy - 1.0).abs() < 1e-7 && (end - tip).norm() < 1e-7, "{joined} {energy} {end} {tip}");
    }
}

#[test]
fn three_rods_meet_at_angles() {
    let o = Vec3::x();
    let rods = vec![line("a", Vec3::zeros(), o), line("b", o, Vec3::y()), line("c", o, Vec3::new(0.5, -0.3, 1.0))];
    let (at, force) = ([node(0, 12), node(1, 0), node(2, 0)], Vec3::new(0.2, 0.9, -0.4));
    let (energy, _) = same_in_all(&model(rods, &[[at[0], at[1]], [at[1], at[2]]], force), load);
    assert!(energy > 0.1, "{energy}");
}

/// The end of an arc of a whole turn meets its start, which is joined to a clamped strut.
#[test]
fn a_rod_is_joined_to_itself() {
    let radius = 0.3;
    let arc = Shape::Arc { start: Vec3::x(), tangent: Vec3::x(), towards: Vec3::y(), radius, angle: TAU };
    let rods = vec![line("strut", Vec3::zeros(), Vec3::x()), rod("loop", &arc, 12)];
    let (at, end) = ([node(0, 12), node(1, 0)], node(1, 36));
    let mut model = model(rods, &[at, [at[1], end]], Vec3::zeros());
    model.loads = vec![NodeLoad { node: node(1, 18), force: Vec3::new(1.0, 0.5, 2.0), moment: Vec3::zeros() }];
    let (energy, _) = same_in_all(&model, load);
    assert!(energy > 0.1, "{energy}");
}

/// Turns of the seam are spread over the ring, not into the joint; the ring is joined at its first node or another.
#[test]
fn a_joined_ring_is_wound() {
    let circle = Shape::Circle { length: 2.0, center: Vec3::zeros(), normal: Vec3::z() };
    let wound = |rod: usize| move |part: f64| Ramp::ExcessLink { rod, to: 0.6 * part };
    let alone = Model { rods: vec![rod("ring", &circle, 12)], contact: Contact::NONE, ..Model::default() };
    // held at one node and free otherwise, the strut carries nothing
    let (free, _) = end_in_steps(&alone, wound(0), 3);
    assert!(free > 1.0, "{free}");
    for joined in [0, 13] {
        let ring = rod("ring", &circle, 12);
        let outward = ring.positions[joined] * 2.0;
        let mut rods = vec![line("strut", ring.positions[joined] + outward, -outward)];
        rods.push(ring);
        let model = model(rods, &[[node(0, 12), node(1, joined)]], Vec3::zeros());
        let model = Model { loads: vec![], ..model };
        let (energy, _) = same_in_all(&model, wound(1));
        assert!((energy / free - 1.0).abs() < 1e-7, "{joined}: {energy} {free}");
    }
}

/// A ramp of a node, by a part of its way, a displacement and an axis.
type Moves = fn(NodeRef, f64, [Vec3; 2]) -> Ramp;

/// A joint that stages move, held and named by either of its nodes, is a node of the whole rod, whose ends are clamped.
#[test]
fn a_joint_is_moved_like_a_node_of_a_rod() {
    let whole = rod("whole", &Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 2.0 }, 8);
    let halves = vec![line("a", Vec3::zeros(), Vec3::x()), line("b", Vec3::x(), Vec3::x())];
    let held = |rods: Vec<Rod>, joints: &[[NodeRef; 2]], middle: NodeRef| {
        let last = node(rods.len() - 1, rods[rods.len() - 1].num_nodes() - 1);
        let supports = [node(0, 0), middle, last].map(Support::clamp).to_vec();
        Model { supports, loads: vec![], ..model(rods, joints, Vec3::zeros()) }
    };
    let (aside, axis) = (Vec3::new(-0.05, 0.2, 0.1), Vec3::new(0.2, 0.1, 1.0));
    let ramps: [Moves; 4] = [
        |node, part, [aside, _]| Ramp::Displacement { node, to: aside * part },
        |node, part, [_, axis]| Ramp::Rotation { node, axis, to: 0.1 * part },
        // about the rods' own tangent, too
        |node, part, _| Ramp::Rotation { node, axis: Vec3::x(), to: 0.3 * part },
        |node, part, [aside, axis]| Ramp::RotationAbout { node, axis, through: Vec3::x() + aside, to: 0.1 * part },
    ];
    for (k, ramp) in ramps.iter().enumerate() {
        let at = |node: NodeRef| move |part: f64| ramp(node, part, [aside, axis]);
        let (energy, _) = end_in_steps(&held(vec![whole.clone()], &[], node(0, 12)), at(node(0, 12)), 3);
        assert!(energy > 0.1, "{k}: {energy}");
        let [a, b] = [node(0, 12), node(1, 0)];
        for (held_at, moved_at) in [(a, a), (a, b), (b, a)] {
            let (joined, _) = end_in_steps(&held(halves.clone(), &[[a, b]], held_at), at(moved_at), 3);
            assert!((joined / energy - 1.0).abs() < 1e-7, "{k}: {joined} {energy}");
        }
    }
}

/// A pin that is displaced takes both rods along; what turns one of them leaves the other alone. A rigid joint turns
/// with either. Nodes brought to a pose take joined ones along. The certificate holds.
#[test]
fn pins_and_poses_move() {
    let halves = vec![line("a", Vec3::zeros(), Vec3::x()), line("b", Vec3::x(), Vec3::y())];
    let [a, b, end] = [node(0, 12), node(1, 0), node(1, 12)];
    let supports = [node(0, 0), a, end].map(Support::clamp).to_vec();
    let rigid = Model { supports, loads: vec![], ..model(halves, &[[a, b]], Vec3::zeros()) };
    let pinned = Model { joints: vec![Joint::pin(a, b)], ..rigid.clone() };
    let run = |model: &Model, ramps: &[Ramp]| {
        let stages: Vec<Stage> = ramps.iter().map(|ramp| Stage::new(vec![ramp.clone()], 3)).collect();
        let mut seen = None;
        let ended = run(model.clone(), &stages, &Options::default(), &mut |progress| {
            seen = Some(observe(progress));
            ControlFlow::Continue(())
        });
        let (solver, state) = (ended.unwrap().solver, seen.unwrap());
        assert!(state.certificate.holds(), "{:?}", state.certificate);
        [a, b].map(|at| place(&solver, at))
    };
    let (by, axis) = (Vec3::new(0.1, -0.1, 0.2), Vec3::z());
    let hinged = Model { joints: vec![Joint::hinge(a, b, axis)], ..rigid.clone() };
    let moved = run(&hinged, &[a, b].map(|node| Ramp::Displacement { node, to: by }));
    moved.iter().for_each(|(r, _)| assert!((r - Vec3::x() - by).norm() < 1e-12, "{r}"));
    // what holds the other rod at a pin is not turned
    let mut both_held = pinned.clone();
    both_held.supports.push(Support::clamp(b));
    run(&both_held, &[Ramp::Rotation { node: a, axis, to: 0.05 }]);
    // both rods of a pin at once: one place cannot go to two
    let round = |node| Ramp::RotationAbout { node, axis, through: Vec3::zeros(), to: 0.1 };
    let twice = [Stage::new(vec![round(a), round(b)], 1)];
    let refused = both_held.check_stages(&twice).unwrap_err().to_string();
    assert!(refused.contains("the same quantity is ramped twice"), "{refused}");
    for model in [&rigid, &pinned] {
        let before = [a, b].map(|at| model.rods[at.rod].frames[at.node]);
        // the way counts from the start, whichever rod names it
        let displaced = run(model, &[a, b].map(|node| Ramp::Displacement { node, to: by }));
        displaced.iter().for_each(|(r, _)| assert!((r - Vec3::x() - by).norm() < 1e-12, "{r}"));
        // the second axis is the tangent of one rod
        for axis in [axis, Vec3::x()] {
            let turned = run(model, &[Ramp::Rotation { node: a, axis, to: 0.05 }]);
            let angles: Vec<f64> = turned.iter().zip(&before).map(|((_, q), given)| q.angle_to(given)).collect();
            assert!((angles[0] - 0.05 * TAU).abs() < 1e-12, "{angles:?}");
            assert_eq!((angles[1] - angles[0]).abs() < 1e-12, std::ptr::eq(model, &rigid), "{angles:?}");
        }
        if std::ptr::eq(model, &rigid) {
            let again = run(model, &[(a, 0.05), (b, 0.03)].map(|(node, to)| Ramp::Rotation { node, axis, to }));
            let angle = again[0].1.angle_to(&before[0]);
            assert!((angle - 0.03 * TAU).abs() < 1e-12, "{angle}");
        }
        let mut solver = Solver::new((*model).clone(), Options::default()).unwrap();
        let along = Ramp::Displacement { node: b, to: by };
        let refused = solver.follow(&along, &FollowOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap_err();
        assert!(refused.to_string().contains("moves joined nodes"), "{refused}");
        let frame = Quat::from_scaled_axis(axis * 0.4) * before[0];
        let (path, half_turn) = (PosePath::Straight, Vec3::zeros());
        let pose = Pose { position: Some(Vec3::x() + by), frame: Some(frame), path, turns: None, half_turn };
        let [(r, q), (s, _)] = run(model, &[Ramp::Pose { node: a, pose }]);
        assert!((r - Vec3::x() - by).norm() < 1e-12 && r == s && q.angle_to(&frame) < 1e-12, "{r} {s}");
    }
}

/// Reactions sum to what rods bear, also where several joined nodes are supported. Symptom: each of them was told the
/// reaction of all, so that two rods of weight 1 stood on 4. Each bears what its own rod needs, the first what rods
/// without a support there need, too; whichever components they hold.
#[test]
fn supports_of_joined_nodes_share_the_reaction() {
    let clamp = "position = true\nrotation = true";
    let (along, across) = ("position = [\"x\", \"y\"]\nrotation = true", "position = [\"y\", \"z\"]");
    for (supports, expected) in [
        (vec![("a", clamp)], vec![3.0]),
        (vec![("a", clamp), ("b", clamp)], vec![2.0, 1.0]),
        (vec![("b", clamp), ("c", clamp)], vec![2.0, 1.0]),
        (vec![("a", clamp), ("b", clamp), ("c", clamp)], vec![1.0; 3]),
        (vec![("a", along), ("b", across)], vec![0.0, 3.0]),
    ] {
        let mut text = "gravity = [0, 0, -9.81]\n".to_owned();
        for (name, way) in [("a", "[1, 0, 0]"), ("b", "[0, 1, 0]"), ("c", "[-1, 0, 0]")] {
            text += &format!(
                "[[rods]]\nname = \"{name}\"\nshape = {{ kind = \"line\", direction = {way}, length = 1.0 }}\n\
                 section = {{ bending = 1.0, twisting = 1.0, stretching = 1e4, shearing = 1e4, \
                 contact_radius = 0.01 }}\n\
                 elements = 4\nweight = 1.0\n"
            );
        }
        for other in ["b", "c"] {
            let ends = ["a", other].map(|rod| format!("{{ rod = \"{rod}\", at = \"start\" }}"));
            text += &format!("[[joints]]\nkind = \"rigid\"\na = {}\nb = {}\n", ends[0], ends[1]);
        }
        for (rod, holds) in &supports {
            text += &format!("[[supports]]\nrod = \"{rod}\"\nat = \"start\"\n{holds}\n");
        }
        let scene = Scene::from_toml(&text, Path::new("")).unwrap();
        let mut last = None;
        let solution = run(scene.model, &scene.stages, &Options::default(), &mut |progress| {
            last = Some(observe(progress));
            ControlFlow::Continue(())
        })
        .unwrap();
        let last = last.unwrap();
        assert_eq!((solution.status, last.status.as_str()), (Status::Converged, "converged"), "{:?}", last.certificate);
        let vertical: Vec<f64> = last.reactions.iter().map(|reaction| reaction.force[2]).collect();
        let near = |(found, expected): (&f64, &f64)| (found - expected).abs() < 1e-9;
        assert!(
            vertical.len() == expected.len() && vertical.iter().zip(&expected).all(near),
            "{supports:?} {vertical:?}"
        );
        // the arms along x balance each other, that along y turns by its weight times half its length
        let about: [f64; 2] = std::array::from_fn(|k| last.reactions.iter().map(|reaction| reaction.moment[k]).sum());
        assert!(about[1].abs() < 1e-9 && (about[0] - 0.5).abs() < 0.02, "{supports:?} {about:?}");
    }
}
