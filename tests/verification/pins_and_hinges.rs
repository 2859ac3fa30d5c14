//! Rods joined by pins and hinges, against statics.
//!
//! * Two bars from pinned feet to a pinned top under a force F: by the height y of the top, N = EA (ℓ − L)/L, F = −2 N
//!   y/ℓ with ℓ² = a² + y². Bars stay straight.
//! * A three-hinged arch of two quarter circles under a force at its crown: thrust F/2 at each foot.
//! * A chain of four stiff links between hooks: their slopes are tan θ = V/H, V the vertical force in their middles.
//! * A pendulum of two links with a horizontal force f at its tip: tan θ₂ = f/(W/2), tan θ₁ = f/(3W/2).
//! * A cantilever with a hinge: moments across the axis pass, none about it.
//! * Forces of joints against those of statics.
//!
//! Stiff: B = 10⁶ and EA = 10⁸ where weights are 1, so that links deviate from rigid ones by 10⁻⁸.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::ops::ControlFlow;
use std::path::Path;

use crate::common::{run_to_end as run, verify, verify_point};
use supercoil::math::{Quat, Vec3};
use supercoil::observe::report::{JointForce, Observation};
use supercoil::scene::Scene;
use supercoil::solve::{self, Options, Restart, Solution, Status, run_from};

const STIFF: &str =
    "section = { bending = 1e6, twisting = 1e6, stretching = 1e8, shearing = 1e8, contact_radius = 0.0 }";

fn end_of(solution: &Solution, rod: usize) -> Vec3 {
    *solution.solver.engine().positions(rod).last().unwrap()
}

/// What the joints exert on a rod, about their nodes.
fn forces_on(seen: &Observation, rod: usize) -> Vec<&JointForce> {
    seen.joints.iter().filter(|at| at.rod == rod).collect()
}

fn line(name: &str, start: [f64; 3], direction: [f64; 3], length: f64, more: &str) -> String {
    format!(
        "[[rods]]\nname = \"{name}\"\nelements = 4\n{more}\nshape = {{ kind = \"line\", start = {start:?}, direction = \
         {direction:?}, length = {length:?} }}\n"
    )
}

fn joint(a: (&str, usize), b: (&str, usize), kind: &str) -> String {
    let [a, b] = [a, b].map(|(rod, at)| format!("{{ rod = \"{rod}\", at = {at} }}"));
    format!("[[joints]]\na = {a}\nb = {b}\n{kind}\n")
}

const PIN: &str = "kind = \"pin\"";
const END: usize = 12;

fn held(rod: &str, at: &str, more: &str) -> String {
    format!("[[supports]]\nrod = \"{rod}\"\nat = \"{at}\"\nposition = true\n{more}\n")
}

fn force(rod: &str, at: &str, force: [f64; 3]) -> String {
    format!("[[loads]]\nrod = \"{rod}\"\nat = \"{at}\"\nforce = {force:?}\n")
}

#[test]
fn two_bars_bear_a_force_by_their_stretch() {
    let (a, rise, stiffness) = (0.8, 0.6, 50.0);
    for height in [0.5, 0.42] {
        let length = f64::hypot(a, height);
        let tension = stiffness * (length - 1.0);
        let load = -2.0 * tension * height / length;
        let section =
            "section = { bending = 20.0, twisting = 1.0, stretching = 50.0, shearing = 50.0, contact_radius = 0.0 }";
        let text = [
            line("left", [-a, 0.0, 0.0], [a, 0.0, rise], 1.0, section),
            line("right", [a, 0.0, 0.0], [-a, 0.0, rise], 1.0, section),
            held("left", "start", ""),
            held("right", "start", ""),
            // out of the plane the top is free otherwise
            "[[supports]]\nrod = \"left\"\nat = \"end\"\nposition = [\"y\"]\n".to_owned(),
            joint(("left", END), ("right", END), PIN),
            force("left", "end", [0.0, 0.0, -load]),
            "[[stages]]\nramp = { load = 1.0 }\nsteps = 4\n".to_owned(),
        ];
        let (solution, seen) = run(&text.concat());
        verify_point("two bars", &end_of(&solution, 0), [0.0, 0.0, height], 1e-9);
        let along = Vec3::new(-a, 0.0, height) / length;
        let [of_right] = forces_on(&seen, 1)[..] else { panic!() };
        let exact = along * tension;
        verify_point("force of the pin on a bar", &Vec3::from(of_right.force), exact.into(), 1e-8);
        verify("two bars", "moment of the pin", Vec3::from(of_right.moment).norm(), 0.0, 1e-10);
    }
}

#[test]
fn a_three_hinged_arch_thrusts_by_half_its_load() {
    let arch = |name: &str, start: [f64; 3], towards: f64| {
        format!(
            "[[rods]]\nname = \"{name}\"\nelements = 6\nnatural = \"as-shaped\"\n\
             section = {{ bending = 1e6, twisting = 1e6, stretching = 1e9, shearing = 1e9, contact_radius = 0.0 }}\n\
             shape = {{ kind = \"arc\", radius = 1.0, turns = 0.25, start = {start:?}, tangent = [0, 0, 1], towards = \
             [{towards:?}, 0, 0] }}\n"
        )
    };
    let foot = |rod: &str| held(rod, "start", "rotation = [\"x\", \"z\"]");
    let hinge = "kind = \"hinge\"\naxis = [0.0, -2.0, 0.0]";
    let text = [
        arch("left", [-1.0, 0.0, 0.0], 1.0),
        arch("right", [1.0, 0.0, 0.0], -1.0),
        foot("left"),
        foot("right"),
        joint(("left", 18), ("right", 18), hinge),
        force("left", "end", [0.0, 0.0, -1.0]),
    ];
    let (_, seen) = run(&text.concat());
    verify_point("arch, left foot", &Vec3::from(seen.reactions[0].force), [0.5, 0.0, 0.5], 1e-5);
    verify_point("arch, right foot", &Vec3::from(seen.reactions[1].force), [-0.5, 0.0, 0.5], 1e-5);
    // the load acts on the left half
    let [of_right] = forces_on(&seen, 1)[..] else { panic!() };
    verify_point("arch, force of the hinge", &Vec3::from(of_right.force), [0.5, 0.0, -0.5], 1e-5);
    // strains rounded to 1e-16 times EA
    verify("arch", "moment of the hinge about its axis", of_right.moment[1], 0.0, 1e-7);
}

/// Links between the origin and (4, 0, 0), of weight 1 each.
fn chain(joints: &str, second_hook: &str) -> String {
    let links = (0..4).map(|k| {
        line(&format!("link{k}"), [k as f64, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0, &format!("{STIFF}\nweight = 1.0"))
    });
    let joints = (1..4).map(|k| joint((&format!("link{}", k - 1), END), (&format!("link{k}"), 0), joints));
    let rods: String = links.chain(joints).collect();
    format!("gravity = [0.0, 0.0, -1.0]\n{rods}{}{second_hook}", held("link0", "start", ""))
}

#[test]
fn a_chain_of_links_hangs_as_statics_has_it() {
    let hook = held("link3", "end", "");
    let moved =
        "[[stages]]\nramp = { displacement = { rod = \"link3\", at = \"end\", to = [-1.0, 0.0, 0.0] } }\nsteps = 4\n";
    // 2 cos θ₁ + 2 cos θ₂ = 3 with tan θ = 3/(2H), 1/(2H)
    let span = |h: f64| 2.0 * (1.5 / h).atan().cos() + 2.0 * (0.5 / h).atan().cos() - 3.0;
    let (mut low, mut high) = (0.1, 10.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if span(middle) < 0.0 { low = middle } else { high = middle }
    }
    let thrust = low;
    let [outer, inner] = [1.5, 0.5].map(|v| (v / thrust).atan());
    // hinges about an axis across the plane hold what pins let go, and the plane has no use for it
    for kind in [PIN, "kind = \"hinge\"\naxis = [0.0, 1.0, 0.0]"] {
        let (solution, seen) = run(&chain(kind, &format!("{hook}{moved}")));
        verify_point("chain, first hook", &Vec3::from(seen.reactions[0].force), [-thrust, 0.0, 2.0], 1e-6);
        verify_point("chain, end of a link", &end_of(&solution, 0), [outer.cos(), 0.0, -outer.sin()], 1e-6);
        let lowest = [outer.cos() + inner.cos(), 0.0, -outer.sin() - inner.sin()];
        verify_point("chain, lowest point", &end_of(&solution, 1), lowest, 1e-6);
        let [at_start, at_end] = forces_on(&seen, 1)[..] else { panic!() };
        verify_point("chain, force of a joint", &Vec3::from(at_start.force), [-thrust, 0.0, 1.0], 1e-6);
        verify_point("chain, force of a joint", &Vec3::from(at_end.force), [thrust, 0.0, 0.0], 1e-6);
        for at in &seen.joints {
            verify("chain", "moment of a joint", Vec3::from(at.moment).norm(), 0.0, 1e-6);
        }
    }
}

#[test]
fn a_chain_from_one_hook_hangs_straight_down() {
    let (solution, seen) = run(&chain(PIN, ""));
    for k in 0..4 {
        verify_point("chain from a hook", &end_of(&solution, k), [0.0, 0.0, -1.0 - k as f64], 1e-6);
    }
    verify_point("chain from a hook", &Vec3::from(seen.reactions[0].force), [0.0, 0.0, 4.0], 1e-7);
}

#[test]
fn a_pendulum_of_two_links_is_pushed_aside() {
    for direction in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.48, 0.6, 0.64]] {
        let way = Vec3::from(direction);
        let weighted = format!("{STIFF}\nweight = 1.0");
        let text = [
            "gravity = [0.0, 0.0, -1.0]\n".to_owned(),
            line("upper", [0.0; 3], direction, 1.0, &weighted),
            line("lower", way.into(), direction, 1.0, &weighted),
            held("upper", "start", ""),
            joint(("upper", END), ("lower", 0), PIN),
            force("lower", "end", [0.7, 0.0, 0.0]),
        ];
        let (solution, _) = run(&text.concat());
        let [upper, lower] = [0.7 / 1.5, 0.7 / 0.5].map(f64::atan);
        let knee = Vec3::new(upper.sin(), 0.0, -upper.cos());
        verify_point("double pendulum, knee", &end_of(&solution, 0), knee.into(), 1e-6);
        let tip = knee + Vec3::new(lower.sin(), 0.0, -lower.cos());
        verify_point("double pendulum, tip", &end_of(&solution, 1), tip.into(), 1e-6);
    }
}

/// Two rods along x, the first clamped, a force at the end of the second.
fn cantilever(joined: &str, loads: &str) -> String {
    let section = "section = { bending = 1.0, twisting = 0.8, stretching = 1e5, shearing = 1e5, contact_radius = 0.0 }";
    [
        line("a", [0.0; 3], [1.0, 0.0, 0.0], 1.0, section),
        line("b", [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0, section),
        held("a", "start", "rotation = true"),
        joint(("a", END), ("b", 0), joined),
        loads.to_owned(),
    ]
    .concat()
}

#[test]
fn a_hinge_passes_moments_across_its_axis_only() {
    let hinge = "kind = \"hinge\"\naxis = [0.0, 0.0, 1.0]";
    let down = force("b", "end", [0.0, 0.0, -0.2]);
    let (whole, _) = run(&cantilever("kind = \"rigid\"", &down));
    let (hinged, seen) = run(&cantilever(hinge, &down));
    let tip = end_of(&whole, 1);
    assert!(tip.z < -0.4, "{tip}");
    verify_point("hinged cantilever, tip", &end_of(&hinged, 1), tip.into(), 1e-9);
    // the moment across is that of the force about the joint
    let arm = tip - end_of(&whole, 0);
    let [of_b] = forces_on(&seen, 1)[..] else { panic!() };
    let exact = -arm.cross(&Vec3::new(0.0, 0.0, -0.2));
    verify_point("hinged cantilever, moment", &Vec3::from(of_b.moment), exact.into(), 1e-8);
    // pushed aside, it swings about the axis, which the bent first rod tilts
    let both = force("b", "end", [0.1, 0.3, -0.2]);
    let (solution, seen) = run(&cantilever(hinge, &both));
    let engine = solution.solver.engine();
    let axes = [(0, END), (1, 0)].map(|(rod, node)| {
        let start = engine.model().rods[rod].frames[node];
        engine.frames(rod)[node] * start.inverse() * Vec3::z()
    });
    verify("hinge", "angle between its axes on both rods", axes[0].cross(&axes[1]).norm(), 0.0, 1e-12);
    let [of_b] = forces_on(&seen, 1)[..] else { panic!() };
    let moment = Vec3::from(of_b.moment);
    verify("hinge", "moment about its axis", moment.dot(&axes[1]), 0.0, 1e-9);
    assert!(moment.norm() > 0.1, "{moment}");
    let arm = end_of(&solution, 1) - end_of(&solution, 0);
    verify_point("hinge, moment", &moment, (-arm.cross(&Vec3::new(0.1, 0.3, -0.2))).into(), 1e-8);
}

/// A frame of all kinds of joints, turned: two legs, a beam, an arm, a brace.
fn frame(turn: &Quat, order: [usize; 4]) -> String {
    let turned = |v: [f64; 3]| <[f64; 3]>::from(turn * Vec3::from(v));
    let section = "section = { bending = 1.0, twisting = 0.7, stretching = 1e4, shearing = 4e3, contact_radius = 0.0 }";
    let rod = |name: &str, start, way: [f64; 3], length| line(name, turned(start), turned(way), length, section);
    let rods = [
        rod("leg", [0.0; 3], [0.0, 0.0, 1.0], 1.0),
        rod("other", [0.75, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0),
        rod("beam", [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], 0.75),
        rod("arm", [0.75, 0.0, 1.0], [0.0, 1.0, 0.0], 0.5),
    ];
    let hinge = format!("kind = \"hinge\"\naxis = {:?}", turned([0.0, 1.0, 0.0]));
    let rest = [
        held("leg", "start", "rotation = true"),
        held("other", "start", "rotation = true"),
        joint(("leg", END), ("beam", 0), &hinge),
        joint(("other", END), ("beam", END), PIN),
        joint(("arm", 0), ("other", END), "kind = \"rigid\""),
        force("arm", "end", turned([0.3, -0.1, -0.4])),
        force("beam", "end", turned([0.4, 0.1, -0.8])),
        "[[stages]]\nramp = { load = 1.0 }\nsteps = 2\n".to_owned(),
    ];
    order.map(|k| rods[k].clone()).concat() + &rest.concat()
}

#[test]
fn neither_axes_nor_the_order_of_rods_matter() {
    let (solution, seen) = run(&frame(&Quat::identity(), [0, 1, 2, 3]));
    let tip = end_of(&solution, 3);
    assert!((tip - Vec3::new(0.75, 0.5, 1.0)).norm() > 0.1, "{tip}");
    let turn = Quat::from_scaled_axis(Vec3::new(0.4, -1.1, 0.8));
    for (turn, order) in [(turn, [0, 1, 2, 3]), (Quat::identity(), [3, 2, 1, 0]), (turn, [2, 0, 3, 1])] {
        let (other, again) = run(&frame(&turn, order));
        verify("frame", "energy", again.energies.total, seen.energies.total, 1e-9);
        for k in 0..4 {
            let exact = turn * end_of(&solution, order[k]);
            verify_point("frame, end of a rod", &end_of(&other, k), exact.into(), 1e-8);
        }
        for at in &again.joints {
            let same = seen.joints.iter().find(|it| (it.rod, it.node) == (order[at.rod], at.node)).unwrap();
            verify_point(
                "frame, force of a joint",
                &Vec3::from(at.force),
                (turn * Vec3::from(same.force)).into(),
                1e-7,
            );
            verify_point(
                "frame, moment of a joint",
                &Vec3::from(at.moment),
                (turn * Vec3::from(same.moment)).into(),
                1e-7,
            );
        }
    }
}

/// A run that is taken up half-way ends in the same state, to the rounding of frames that are put together at hinges; a
/// finer mesh has the same joints.
#[test]
fn joints_outlast_restarts_and_refinement() {
    let scene = Scene::from_toml(&frame(&Quat::identity(), [1, 0, 2, 3]), Path::new(".")).unwrap();
    let go = |from: Option<Restart>, kept: &mut Vec<Restart>| {
        let run = run_from(scene.model.clone(), &scene.stages, &Options::default(), from, &mut |_, waypoint| {
            kept.extend(waypoint.restart());
            ControlFlow::Continue(())
        });
        run.unwrap()
    };
    let mut kept = Vec::new();
    let whole = go(None, &mut kept);
    assert_eq!(whole.status, Status::Converged);
    let resumed = go(Some(kept[1].clone()), &mut Vec::new());
    for rod in 0..4 {
        verify_point("resumed frame, end of a rod", &end_of(&resumed, rod), end_of(&whole, rod).into(), 1e-13);
    }
    let mut fine = whole.solver.refined(2).unwrap();
    assert_eq!(fine.resettle().status, Status::Converged);
    let kinds =
        |solution: &solve::Solver| solution.engine().model().joints.iter().map(|joint| joint.kind).collect::<Vec<_>>();
    assert_eq!(kinds(&fine), kinds(&whole.solver));
    for rod in 0..4 {
        let end = *fine.engine().positions(rod).last().unwrap();
        verify_point("refined frame, end of a rod", &end, end_of(&whole, rod).into(), 1e-4);
    }
    let joined = |rod: usize, at: usize| fine.engine().positions(rod)[at];
    assert!((joined(1, 2 * END) - joined(2, 0)).norm() < 1e-14);
}
