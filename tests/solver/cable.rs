//! Nodes carried round an axis together: what is turned whole keeps its shape, what is turned at one end is twisted by
//! whole turns.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use common::elastic_energy;
use nalgebra::Unit;
use supercoil::math::{Quat, Vec3};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Stage, Support};
use supercoil::solve::{Options, Solution, Solver, Status, run, run_from};

const LENGTH: f64 = 3.0;
/// Too weak for two turns to buckle a strand (Greenhill: 4π C < 8.99 B).
const TWISTING: f64 = 0.5;
const LAST: usize = 24;

/// Parallel strands through these points of the plane z = 0, clamped at both ends; the far ends slide along z where
/// they are pulled.
fn strands(points: &[Vec3], radius: f64, pull: f64) -> Model {
    let section = Section::isotropic(1.0, TWISTING, 1e4, 1e4, radius);
    let strand = |start: &Vec3| {
        let shape = Shape::Line { start: *start, direction: Vec3::z(), length: LENGTH };
        Rod::new("strand", &shape, RodMesh::open(LAST / 3, 3), section, Natural::Straight).unwrap()
    };
    let rods: Vec<Rod> = points.iter().map(strand).collect();
    let far = |rod| Support { position: [true, true, pull == 0.0], ..Support::clamp(NodeRef { rod, node: LAST }) };
    let supports = (0..rods.len()).flat_map(|rod| [Support::clamp(NodeRef { rod, node: 0 }), far(rod)]).collect();
    let load = |rod| {
        let node = NodeRef { rod, node: LAST };
        NodeLoad { node, force: Vec3::z() * pull, moment: Vec3::zeros() }
    };
    let loads = (0..rods.len()).filter(|_| pull > 0.0).map(load).collect();
    Model {
        rods,
        supports,
        loads,
        contact: if radius > 0.0 { Contact::default() } else { Contact::NONE },
        ..Model::default()
    }
}

fn triangle() -> Vec<Vec3> {
    (0..3).map(|k| f64::from(k) * TAU / 3.0).map(|a| Vec3::new(0.15 * a.cos() + 1.0, 0.15 * a.sin(), 0.0)).collect()
}

fn ran(model: Model, stages: &[Stage]) -> Solution {
    let solution = run(model, stages, &Options::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    solution
}

/// Largest distance of a clamp, and of its axes, from where a rotation and then a displacement take it.
fn off(solver: &Solver, nodes: &[usize], turn: (Vec3, Vec3, f64), by: &dyn Fn(usize) -> Vec3) -> f64 {
    let (axis, through, turns) = turn;
    let rotation = Quat::from_axis_angle(&Unit::new_normalize(axis), turns * TAU);
    let engine = solver.engine();
    let mut worst = 0.0f64;
    for (r, rod) in engine.model().rods.iter().enumerate() {
        for &node in nodes {
            let place = through + rotation * (rod.positions[node] - through) + by(r);
            worst = worst.max((engine.positions(r)[node] - place).norm());
            for along in [Vec3::x(), Vec3::y(), Vec3::z()] {
                let (here, due) = (engine.frames(r)[node] * along, rotation * rod.frames[node] * along);
                worst = worst.max((here - due).norm());
            }
        }
    }
    worst
}

/// Both ends of three straight strands, carried by 2⅜ turns round an axis of no particular direction that does not meet
/// them, and moved: a rigid motion, whatever steps are asked for.
#[test]
fn a_cable_turned_whole_keeps_its_shape() {
    let (axis, through, to, by) =
        (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.2, 0.4, -0.3), 2.375, Vec3::new(0.3, 0.2, -0.1));
    let model = strands(&triangle(), 0.0, 0.0);
    let ends = || (0..3).flat_map(|rod| [0, LAST].map(|node| NodeRef { rod, node }));
    let ramps: Vec<Ramp> = ends()
        .map(|node| Ramp::RotationAbout { node, axis, through, to })
        .chain(ends().map(|node| Ramp::Displacement { node, to: by }))
        .collect();
    for steps in [1, 40] {
        let solution = ran(model.clone(), &[Stage::new(ramps.clone(), steps)]);
        assert_eq!(solution.num_steps, if steps == 1 { 29 } else { 40 }, "a twelfth of a turn at most");
        let (clamps, inside) = (
            off(&solution.solver, &[0, LAST], (axis, through, to), &|_| by),
            off(&solution.solver, &[7, 12], (axis, through, to), &|_| by),
        );
        println!(
            "{steps} steps: clamps off by {clamps:.1e}, nodes by {inside:.1e}, energy {:.1e}",
            elastic_energy(&solution.solver)
        );
        assert!(clamps < 1e-12 && inside < 1e-9, "{clamps} {inside}");
        assert!(elastic_energy(&solution.solver) < 1e-15, "{}", elastic_energy(&solution.solver));
    }
}

/// Taken up in the middle of a stage of more steps than were asked for, the run goes on with the same bits.
#[test]
fn a_run_taken_up_half_way_takes_the_same_steps() {
    let node = NodeRef { rod: 0, node: LAST };
    let turn = Ramp::RotationAbout { node, axis: Vec3::new(0.3, -0.1, 2.0), through: Vec3::x() * 1.01, to: 0.7 };
    let (model, stages) = (strands(&triangle(), 0.0, 0.0), [Stage::new(vec![turn], 2)]);
    let mut middle = None;
    let whole = run_from(model.clone(), &stages, &Options::default(), None, &mut |progress, waypoint| {
        if progress.step == 4 {
            middle = waypoint.restart();
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!((whole.status, whole.num_steps), (Status::Converged, 9));
    assert!(middle.is_some());
    let rest = run_from(model, &stages, &Options::default(), middle, &mut |_, _| ControlFlow::Continue(())).unwrap();
    assert_eq!((rest.status, rest.num_steps), (Status::Converged, 9));
    assert_eq!(whole.solver.engine().state(), rest.solver.engine().state());
}

/// One end of a strand on the axis is turned by two whole turns: they are all in its twist, to what eight elements
/// resolve of it (4e-6).
#[test]
fn whole_turns_count() {
    let turn =
        |to: f64| Ramp::RotationAbout { node: NodeRef { rod: 0, node: LAST }, axis: Vec3::z(), through: Vec3::z(), to };
    let model = strands(&[Vec3::zeros()], 0.0, 0.0);
    let stages = [1.0, 2.0].map(|to| Stage::new(vec![turn(to)], 12));
    let solution = ran(model.clone(), &stages);
    let exact = 0.5 * TWISTING * (2.0 * TAU).powi(2) / LENGTH;
    assert!(
        (elastic_energy(&solution.solver) / exact - 1.0).abs() < 1e-5,
        "{} {exact}",
        elastic_energy(&solution.solver)
    );
    let mut at_once = Solver::new(model, Options::default()).unwrap();
    let refusal = at_once.step_to(&[turn(2.0)]).unwrap_err().to_string();
    assert!(refusal.starts_with("ramp.rotation.turns = 2: must be at most"), "{refusal}");
    assert_eq!(at_once.step_to(&[turn(0.08)]).unwrap().status, Status::Converged);
}

/// Three pulled strands whose far ends are turned about their common axis wind about it by as much, held apart by
/// contact; the clamps end where the rotation says, free along the axis only.
#[test]
fn strands_are_wound_by_whole_turns() {
    let (axis, through, to) = (Vec3::z(), Vec3::x(), 1.0);
    let carried = |rod| Ramp::RotationAbout { node: NodeRef { rod, node: LAST }, axis, through, to };
    let stages = [Stage::new(vec![Ramp::Load { to: 1.0 }], 1), Stage::new((0..3).map(carried).collect(), 12)];
    let solution = ran(strands(&triangle(), 0.125, 40.0), &stages);
    let engine = solution.solver.engine();
    let slid = |rod: usize| Vec3::z() * (engine.positions(rod)[LAST].z - LENGTH);
    let clamps = off(&solution.solver, &[LAST], (axis, through, to), &slid);
    assert!(clamps < 1e-12, "{clamps}");
    for rod in 0..3 {
        assert!(slid(rod).z < -0.01, "rod {rod} is shorter along the axis: {}", slid(rod));
        let arms: Vec<Vec3> = engine.positions(rod).iter().map(|r| r - through).collect();
        let angle = |w: &[Vec3]| (w[0].x * w[1].y - w[0].y * w[1].x).atan2(w[0].xy().dot(&w[1].xy()));
        let turns = arms.windows(2).map(angle).sum::<f64>() / TAU;
        assert!((turns - to).abs() < 1e-12, "rod {rod} winds by {turns}");
    }
}

/// Refuses: an end that may move where it would be carried, one whose frame is free, one that is turned twice.
#[test]
fn what_is_not_held_cannot_be_carried() {
    let model = strands(&triangle(), 0.0, 1.0);
    let node = NodeRef { rod: 1, node: LAST };
    let about = |axis: Vec3| Ramp::RotationAbout { node, axis, through: Vec3::zeros(), to: 0.5 };
    let check = |ramps: Vec<Ramp>| {
        let stages = [Stage::new(ramps, 6)];
        model.check_stages(&stages).err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert_eq!(check(vec![about(Vec3::z())]), "");
    assert!(check(vec![about(Vec3::x())]).contains("is carried round in a direction that no support fixes"));
    let turn = Ramp::Rotation { node, axis: Vec3::z(), to: 1.0 };
    assert!(check(vec![about(Vec3::z()), turn]).contains("ramped twice"));
    let mut loose = model.clone();
    loose.supports[3].rotation = [true, true, false];
    let stages = [Stage::new(vec![about(Vec3::z())], 6)];
    assert!(loose.check_stages(&stages).unwrap_err().to_string().contains("add one with rotation = true"));
}
