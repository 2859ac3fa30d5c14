//! Clamped nodes taken to poses: where they arrive, the way they take, link put in by whole turns, runs taken up
//! half-way.

#![allow(clippy::unwrap_used)] // helpers of tests

use crate::common;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::path::Path;

use common::elastic_energy;
use supercoil::math::{Quat, Vec3};
use supercoil::observe::observe;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeRef, Pose, PosePath, Ramp, Scene, Stage, Support};
use supercoil::solve::{Options, Solution, Solver, Status, run, run_from};

const LAST: usize = 24;
const LENGTH: f64 = 2.0;
const END: NodeRef = NodeRef { rod: 0, node: LAST };
const START: NodeRef = NodeRef { rod: 0, node: 0 };

/// A straight rod clamped at both ends.
fn clamped() -> Model {
    let line = Shape::Line { start: Vec3::new(0.3, -0.1, 0.2), direction: Vec3::new(1.0, 2.0, -1.0), length: LENGTH };
    let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.0);
    let rod = Rod::new("rod", &line, RodMesh::open(LAST / 3, 3), section, Natural::Straight).unwrap();
    let supports = vec![Support::clamp(START), Support::clamp(END)];
    Model { rods: vec![rod], supports, contact: Contact::NONE, ..Model::default() }
}

fn pose(position: Vec3, frame: Quat, path: PosePath) -> Pose {
    Pose { position: Some(position), frame: Some(frame), path, turns: None, half_turn: Vec3::zeros() }
}

fn ran(stages: &[Stage]) -> Solution {
    let solution = run(clamped(), stages, &Options::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    solution
}

/// Distance of a node from a position, and angle of its frame from another.
fn off(solver: &Solver, node: usize, position: &Vec3, frame: &Quat) -> f64 {
    let engine = solver.engine();
    (engine.positions(0)[node] - position).norm() + engine.frames(0)[node].angle_to(frame)
}

/// Both ends are taken where a rigid motion takes them: the rod goes with them and is at rest without stress. On screws
/// it is so at every step.
#[test]
fn ends_taken_by_one_motion_carry_the_rod() {
    let turn = Quat::from_scaled_axis(Vec3::new(0.8, -1.5, 1.0));
    let by = Vec3::new(0.5, 2.0, -0.7);
    let model = clamped();
    let moved = |node: usize| (turn * model.rods[0].positions[node] + by, turn * model.rods[0].frames[node]);
    for path in [PosePath::Screw, PosePath::Straight] {
        let ramp = |node: NodeRef| {
            let (position, frame) = moved(node.node);
            Ramp::Pose { node, pose: pose(position, frame, path) }
        };
        let stage = Stage::new(vec![ramp(START), ramp(END)], 2);
        let (mut steps, mut worst) = (0, 0.0f64);
        let solution = run(clamped(), &[stage], &Options::default(), &mut |progress| {
            steps += 1;
            worst = worst.max(supercoil::observe::observe(progress).energies.total);
            ControlFlow::Continue(())
        })
        .unwrap();
        assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
        assert_eq!(steps, 1 + 4, "0.32 turns take four steps of at most a twelfth");
        assert!(path == PosePath::Straight || worst < 1e-16, "{worst:e}");
        assert!(elastic_energy(&solution.solver) < 1e-16);
        for node in 0..=LAST {
            let (position, frame) = moved(node);
            assert!(off(&solution.solver, node, &position, &frame) < 1e-9, "{path:?} {node}");
        }
    }
}

/// Whole turns do not show in the frame of the end; they are twist, as a rotation by as many turns puts it in.
#[test]
fn extra_turns_are_twist() {
    let model = clamped();
    let (position, frame) = (model.rods[0].positions[LAST], model.rods[0].frames[LAST]);
    // short of what buckles the rod: 8.99 B/(2π C) turns (Greenhill)
    let turns = Pose { turns: Some(-1.0), ..pose(position, frame, PosePath::Straight) };
    let posed = ran(&[Stage::new(vec![Ramp::Pose { node: END, pose: turns }], 1)]).solver;
    let exact = 0.5 * TAU * TAU / LENGTH;
    assert!((elastic_energy(&posed) / exact - 1.0).abs() < 1e-6, "{}", elastic_energy(&posed));
    assert!(off(&posed, LAST, &position, &frame) < 1e-9);
    // what a rotation has turned counts: nothing is left to do
    let rotation = Ramp::Rotation { node: END, axis: frame * Vec3::z(), to: -1.0 };
    let stages = [rotation, Ramp::Pose { node: END, pose: turns }].map(|ramp| Stage::new(vec![ramp], 1));
    let rotated = ran(&stages).solver;
    assert!((elastic_energy(&rotated) / exact - 1.0).abs() < 1e-6);
    // and no more than that is done by a pose that says nothing of turns
    let plain = Ramp::Pose { node: END, pose: Pose { turns: None, ..turns } };
    let stages = [vec![Ramp::Pose { node: END, pose: turns }], vec![plain]].map(|ramps| Stage::new(ramps, 1));
    assert!((elastic_energy(&ran(&stages).solver) / exact - 1.0).abs() < 1e-6);
}

/// A clamp turned over on a screw, the other moved on a straight line, tilted and turned by a whole turn.
fn bent() -> Vec<Stage> {
    let model = clamped();
    let half = Quat::from_scaled_axis(Vec3::y() * PI) * model.rods[0].frames[LAST];
    let to = Pose { half_turn: Vec3::y(), ..pose(Vec3::new(0.9, 0.4, 0.5), half, PosePath::Screw) };
    let first = Stage::new(vec![Ramp::Pose { node: END, pose: to }], 24);
    let turn = Quat::from_scaled_axis(Vec3::new(0.4, 0.2, 0.9)) * model.rods[0].frames[0];
    let start = Pose { turns: Some(1.0), ..pose(Vec3::new(0.1, 0.1, 0.0), turn, PosePath::Straight) };
    vec![first, Stage::new(vec![Ramp::Pose { node: START, pose: start }], 20)]
}

/// Steps but the first ones of a stage are predicted; the path ends in the poses.
#[test]
fn ways_to_poses_are_predicted() {
    let (mut predicted, mut steps) = (0, 0);
    let solution = run(clamped(), &bent(), &Options::default(), &mut |progress| {
        steps += 1;
        predicted += usize::from(progress.report.is_predicted());
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}", solution.failure);
    assert!(steps == 1 + 24 + 20 && 4 * predicted >= 3 * steps, "{predicted} of {steps}");
    for (stage, node) in [(0, LAST), (1, 0)] {
        let Ramp::Pose { pose, .. } = bent()[stage].ramps[0] else { unreachable!() };
        assert!(off(&solution.solver, node, &pose.position.unwrap(), &pose.frame.unwrap()) < 1e-9);
    }
}

/// Taken up after any step, a run ends with the same bits.
#[test]
fn runs_on_the_way_to_a_pose_can_be_taken_up() {
    let options = Options::default();
    let mut kept = Vec::new();
    let whole = run_from(clamped(), &bent(), &options, None, &mut |_, waypoint| {
        kept.extend(waypoint.restart());
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(whole.status, Status::Converged);
    for restart in kept {
        let step = restart.place.num_steps;
        let again =
            run_from(clamped(), &bent(), &options, Some(restart), &mut |_, _| ControlFlow::Continue(())).unwrap();
        assert_eq!(again.num_steps, whole.num_steps);
        assert!(again.solver.engine().state() == whole.solver.engine().state(), "from step {step}");
    }
}

/// Poses that a model cannot take: refused before the first step, with the reason.
#[test]
fn poses_need_a_clamp_and_whole_turns() {
    let there = pose(Vec3::x(), Quat::identity(), PosePath::Straight);
    let refused = |model: &Model, pose: Pose| {
        let stage = Stage::new(vec![Ramp::Pose { node: END, pose }], 1);
        model.check_stages(&[stage]).unwrap_err().to_string()
    };
    let half = refused(&clamped(), Pose { turns: Some(0.5), ..there });
    assert!(half.contains("extra_turns = 0.5") && half.contains("whole number"), "{half}");
    let nowhere = refused(&clamped(), Pose { position: None, frame: None, ..there });
    assert!(nowhere.contains("give a position, a rotation"), "{nowhere}");
    let far = refused(&clamped(), Pose { position: Some(Vec3::new(0.0, f64::NAN, 0.0)), ..there });
    assert!(far.contains("stages[0].ramp.pose.position"), "{far}");
    let mut model = clamped();
    model.supports[1] = Support::pin(END);
    let pinned = refused(&model, there);
    assert!(pinned.contains("is not clamped at this node"), "{pinned}");
    let twice = vec![Ramp::Pose { node: END, pose: there }, Ramp::Displacement { node: END, to: Vec3::x() }];
    let error = clamped().check_stages(&[Stage::new(twice, 1)]).unwrap_err().to_string();
    assert!(error.contains("ramped twice"), "{error}");
}

/// Displacements and turns count from where a stage holds a node. Symptom: of an end that was displaced, let go, held
/// and displaced again, the way of the first stage was taken off the second's, while tables told the second's; a turn
/// likewise. Taken up after any step the run ends with the same bits.
#[test]
fn motions_count_from_where_a_stage_holds() {
    let text = r#"
        load = 1.0
        [[rods]]
        shape = { kind = "line", direction = [1, 0, 0], length = 1.0 }
        section = { bending = 1.0, twisting = 1.0, stretching = 2e4, shearing = 2e4, contact_radius = 0.006 }
        elements = 8
        [[supports]]
        at = "start"
        position = true
        rotation = true
        [[supports]]
        at = "end"
        position = true
        rotation = true
        [[loads]]
        at = "end"
        force = [0, 0, -1.0]
        [[stages]]
        ramp.displacement = { at = "end", to = [-0.1, 0, 0.1] }
        ramp.rotation = { at = "end", axis = [1, 0, 0], turns = 0.2 }
        steps = 2
        [[stages]]
        release = [{ at = "end", position = true, rotation = true }]
        [[stages]]
        hold = [{ at = "end", position = true, rotation = true }]
        [[stages]]
        ramp.displacement = { at = "end", to = [-0.05, 0, -0.1] }
        ramp.rotation = { at = "end", axis = [1, 0, 0], turns = 0.1 }
        steps = 2"#;
    let scene = Scene::from_toml(text, Path::new("")).unwrap();
    let options = Options::default();
    let (mut places, mut kept) = (Vec::new(), Vec::new());
    let whole = run_from(scene.model.clone(), &scene.stages, &options, None, &mut |progress, waypoint| {
        let engine = progress.engine;
        places.push((progress.stage, progress.fraction, engine.positions(0)[24], engine.frames(0)[24]));
        assert_eq!(observe(progress).status, "converged");
        kept.extend(waypoint.restart());
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(whole.status, Status::Converged);
    let (_, _, held, frame) = *places.iter().rfind(|(stage, ..)| *stage == 2).unwrap();
    for (_, fraction, position, turned) in places.iter().filter(|(stage, ..)| *stage == 3) {
        let way = Vec3::new(-0.05, 0.0, -0.1) * *fraction;
        assert!((position - held - way).norm() < 1e-12, "{position} {held}");
        assert!((turned.angle_to(&frame) - 0.1 * fraction * TAU).abs() < 1e-12);
    }
    for restart in kept {
        let again =
            run_from(
                scene.model.clone(),
                &scene.stages,
                &options,
                Some(restart),
                &mut |_, _| ControlFlow::Continue(()),
            )
            .unwrap();
        assert!(again.solver.engine().state() == whole.solver.engine().state());
    }
}
