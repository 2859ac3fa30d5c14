//! The certificate: a state at rest has it; each break of a promise is reported by the check of its name.

use std::ops::ControlFlow;

use super::*;
use crate::math::Quat;
use crate::math::quaternion::exp;
use crate::rod::{Natural, RodMesh, Section, Shape};
use crate::scene::{ContactLaw, Joint, Model, NodeLoad, Obstacle, Ramp, Stage, Support};
use crate::solve::{self, Given, Options, State, StepReport};

const RADIUS: f64 = 0.02;
/// Rods of the scene, in order.
const UPPER: usize = 0;
const LOWER: usize = 1;
const ARM: usize = 2;
const HAND: usize = 3;
const RING: usize = 4;
const OTHER: usize = 5;

fn line(name: &str, start: [f64; 3], along: Vec3, contact_radius: f64) -> Rod {
    let shape = Shape::Line { start: start.into(), direction: along, length: 1.0 };
    let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, contact_radius);
    Rod::new(name, &shape, RodMesh::open(6, 3), section, Natural::Straight).unwrap()
}

fn ring(name: &str, center: [f64; 3]) -> Rod {
    let shape = Shape::Circle { length: 2.0, center: center.into(), normal: Vec3::z() };
    let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, RADIUS);
    Rod::new(name, &shape, RodMesh::closed(8, 3), section, Natural::Straight).unwrap()
}

/// A clamped rod pressed onto another one across it; an arm with a hand that bear nothing; two rings.
fn scene() -> (Model, Vec<Stage>) {
    let rods = vec![
        line("upper", [0.0, 0.0, 0.05], Vec3::x(), RADIUS),
        line("lower", [0.5, -0.5, 0.0], Vec3::y(), RADIUS),
        line("arm", [0.0, 5.0, 0.0], Vec3::x(), 0.0),
        line("hand", [1.0, 5.0, 0.0], Vec3::y(), 0.0),
        ring("ring", [0.0, -5.0, 0.0]),
        ring("other", [0.0, -5.0, 0.1]),
    ];
    let node = |rod, node| NodeRef { rod, node };
    let clamps = [(UPPER, 0), (UPPER, 18), (LOWER, 0), (LOWER, 18), (ARM, 0)];
    let supports = clamps.map(|(rod, at)| Support::clamp(node(rod, at))).to_vec();
    let joints = vec![Joint::rigid(node(ARM, 18), node(HAND, 0))];
    let loads = vec![NodeLoad { node: node(UPPER, 4), force: Vec3::new(0.0, 2.0, -1.0), moment: Vec3::zeros() }];
    let down = |at| Ramp::Displacement { node: node(UPPER, at), to: -Vec3::z() * 0.04 };
    let turn = Ramp::Rotation { node: node(LOWER, 18), axis: Vec3::new(0.3, 1.0, 0.0), to: 0.05 };
    let link = Ramp::ExcessLink { rod: RING, to: 0.25 };
    let ramps = vec![down(0), down(18), turn, link, Ramp::Load { to: 1.0 }];
    (Model { rods, supports, joints, loads, ..Model::default() }, vec![Stage::new(ramps, 3)])
}

/// A state at rest, with what is reported of it.
struct Resting {
    given: Given,
    state: State,
    model: Model,
    seen: Observation,
}

fn at_rest(model: Model, stages: &[Stage]) -> Resting {
    let mut seen = Vec::new();
    let solution = solve::run(model, stages, &Options::default(), &mut |progress| {
        seen.push(observe(progress));
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged);
    for step in &seen {
        assert!(step.certificate.holds() && step.status == "converged", "step {}: {}", step.step, step.certificate);
    }
    let engine = solution.solver.engine();
    let (state, model) = (engine.state().clone(), engine.model().clone());
    Resting { given: solution.given, state, model, seen: seen.pop().unwrap() }
}

impl Resting {
    /// Names of the checks that fail for a changed state and changed reports.
    fn failing(&self, change: impl FnOnce(&mut State, &mut Observation)) -> Vec<String> {
        let (mut state, mut seen) = (self.state.clone(), self.seen.clone());
        change(&mut state, &mut seen);
        let mut engine = Engine::new(self.model.clone(), None).unwrap();
        engine.set_state(self.state.clone()).unwrap();
        // past the engine, which would refuse or mend it
        *engine.state_mut() = state;
        let report = StepReport { num_unstable: seen.num_unstable, ..StepReport::settled() };
        let given = Some(&self.given);
        let progress =
            Progress { given, engine: &engine, stage: 0, step: 3, fraction: 1.0, report: &report, seconds: 0.0 };
        let sites = (&seen.sites[..], &seen.obstacle_sites[..]);
        let (mut certificate, _) = certificate(&progress, sites, (&seen.reactions, &seen.joints), &seen.energies);
        certificate.checks.extend(topology::kept(&progress, &seen.links, &seen.linking, &seen.knots).0);
        certificate.checks.extend(stability(&progress));
        certificate.failures().map(|check| check.name.clone()).collect()
    }

    fn first(&self, rod: usize) -> usize {
        self.model.rods[..rod].iter().map(Rod::num_nodes).sum()
    }

    /// Moves a rod as a whole: turns it about its first node and displaces it.
    fn carried(&self, state: &mut State, rod: usize, turn: &Quat, by: &Vec3) {
        let nodes = self.first(rod)..self.first(rod + 1);
        let (positions, frames) = state.nodes_mut();
        let pivot = positions[nodes.start];
        for node in nodes {
            positions[node] = pivot + turn * (positions[node] - pivot) + by;
            frames[node] = turn * frames[node];
        }
    }
}

#[test]
fn each_broken_promise_fails_its_check_and_no_other() {
    let (model, stages) = scene();
    let rest = at_rest(model, &stages);
    assert!(rest.seen.sites.len() == 1 && rest.seen.sites[0].force > 1.0, "{:?}", rest.seen.sites);
    assert_eq!(rest.failing(|_, _| ()), Vec::<String>::new());
    let none = Quat::identity();
    let tilt = exp(&(Vec3::z() * 1e-6));

    // the arm is displaced with its hand, and turned; the hand is displaced, and turned
    for (turn, by) in [(none, Vec3::z() * 1e-8), (tilt, Vec3::zeros())] {
        let broken = rest.failing(|state, _| {
            rest.carried(state, HAND, &turn, &(by + (turn * Vec3::x() - Vec3::x())));
            rest.carried(state, ARM, &turn, &by);
        });
        assert_eq!(broken, ["supports"]);
        assert_eq!(rest.failing(|state, _| rest.carried(state, HAND, &turn, &by)), ["joints"]);
    }
    // a quaternion that is too long, where all are equal and its length does nothing else
    let long = rest.failing(|state, _| {
        let q = &mut state.nodes_mut().1[rest.first(ARM) + 5];
        *q = Quat::new_unchecked(q.into_inner() * (1.0 + 1e-9));
    });
    assert_eq!(long, ["frames"]);
    let turned = rest.failing(|state, _| state.nodes_mut().1[rest.first(HAND) + 18] *= exp(&(Vec3::z() * 2.9)));
    assert_eq!(turned, ["turning", "balance of nodes", "energies"], "a twisted rod bears a moment");

    // a node out of balance, whose body is in balance; reports that are wrong
    let moved = rest.failing(|state, _| state.nodes_mut().0[rest.first(LOWER) + 4].x += 1e-6);
    assert_eq!(moved, ["balance of nodes", "energies"]);
    let both = ["balance of nodes", "balance of bodies"];
    let twice = rest.failing(|_, seen| {
        let site = &mut seen.sites[0];
        site.force_on_a = site.force_on_a.map(|x| 2.0 * x);
        site.moment_on_a = site.moment_on_a.map(|x| 2.0 * x);
    });
    assert_eq!(twice, ["balance of nodes", "balance of bodies", "normals"]);
    // along the rod, which slides, and in the direction of a force that pulls
    for (axis, turns) in [(Vec3::y(), 0.1), (Vec3::x(), 0.5)] {
        let tilted = rest.failing(|_, seen| {
            let site = &mut seen.sites[0];
            site.force_on_a = (exp(&(axis * (TAU * turns))) * Vec3::from(site.force_on_a)).into();
        });
        assert_eq!(tilted, ["balance of nodes", "balance of bodies", "normals"]);
    }
    assert_eq!(
        rest.failing(|_, seen| seen.sites[0].force *= 0.99),
        ["normals"],
        "pressure carries less than the force"
    );
    assert_eq!(rest.failing(|_, seen| seen.energies.bending *= 1.0 + 1e-9), ["energies"]);
    assert_eq!(rest.failing(|_, seen| seen.energies.stretching = 0.0), ["energies"]);
    assert_eq!(rest.failing(|_, seen| seen.sites[0].feet[0][0] += 2e-2), both, "a force on another line");
    assert_eq!(rest.failing(|_, seen| seen.sites.clear()), both);
    assert_eq!(rest.failing(|_, seen| seen.reactions[0].moment[1] += 1.0), both);

    // a ring lowered into the other one
    let pushed = rest.failing(|state, _| rest.carried(state, OTHER, &none, &(Vec3::z() * -0.062)));
    assert_eq!(pushed, ["gaps"]);
    let near = rest.failing(|state, _| rest.carried(state, OTHER, &none, &(Vec3::z() * -0.0598)));
    assert_eq!(near, Vec::<String>::new());

    assert_eq!(rest.failing(|_, seen| seen.num_unstable = 1), ["stability"]);

    // another link, linking number or knot
    assert_eq!(rest.failing(|_, seen| seen.links[0].link += 1.0), ["topology"]);
    assert_eq!(rest.failing(|_, seen| seen.linking[0].link += 1.0), ["topology"]);
    assert_eq!(rest.failing(|_, seen| seen.knots.iter_mut().for_each(|k| k.name = "3_1".to_owned())), ["topology"]);
}

/// Without contact what a search leaves is rounding, and a hundred-thousandth of a force is seen. Moments of fixed
/// direction in space have no potential by which stability could be judged.
#[test]
fn without_contact_balance_is_sharp() {
    let rods = vec![line("arm", [0.0; 3], Vec3::x(), RADIUS)];
    let [start, end] = [0, 18].map(|node| NodeRef { rod: 0, node });
    let loads = vec![NodeLoad { node: end, force: Vec3::new(0.3, 2.0, -1.0), moment: Vec3::x() * 0.1 }];
    let model = Model { rods, supports: vec![Support::clamp(start)], loads, ..Model::default() };
    let rest = at_rest(model, &[Stage::new(vec![Ramp::Load { to: 1.0 }], 3)]);
    let broken = rest.failing(|_, seen| seen.reactions[0].force[1] *= 1.0 + 1e-5);
    assert_eq!(broken, ["balance of nodes", "balance of bodies"]);
    assert_eq!(rest.failing(|_, seen| seen.num_unstable = 1), Vec::<String>::new());
}

/// Without contact strands may pass through each other, and a knot may slip off an open rod: that is noted, and no
/// check fails.
#[test]
fn what_nothing_hinders_is_noted() {
    let (mut model, stages) = scene();
    model.contact.law = ContactLaw::None;
    let rest = at_rest(model, &stages);
    let report = StepReport::settled();
    let mut engine = Engine::new(rest.model.clone(), None).unwrap();
    engine.set_state(rest.state.clone()).unwrap();
    let progress = Progress {
        given: Some(&rest.given),
        engine: &engine,
        stage: 0,
        step: 3,
        fraction: 1.0,
        report: &report,
        seconds: 0.0,
    };
    let mut seen = rest.seen.clone();
    let told = |seen: &Observation| topology::kept(&progress, &seen.links, &seen.linking, &seen.knots);
    assert!(told(&seen).1.is_empty());
    seen.links[0].link -= 2.0;
    seen.knots.iter_mut().filter(|knot| knot.rod == LOWER).for_each(|knot| knot.name = "3_1".to_owned());
    let (checks, notes) = told(&seen);
    assert!(checks.iter().all(|check| check.holds));
    assert!(notes.len() == 2 && notes[0].contains("2.0000 turns less than prescribed"), "{notes:?}");
    assert!(notes[1].contains("\"lower\" is 3_1, not 0_1 as given"), "{notes:?}");
}

/// A clamped rod whose bead lies on another one: what the strand is reported to bear acts on the rod of the bead, about
/// its node, and no strand may be in the bead.
#[test]
fn what_a_bead_bears_is_balanced_and_its_gap_is_kept() {
    let rods =
        vec![line("arm", [0.0, 0.0, 0.13], Vec3::x(), RADIUS), line("beam", [1.0, -0.5, 0.0], Vec3::y(), RADIUS)];
    let node = |rod, node| NodeRef { rod, node };
    let supports = [(0, 0), (1, 0), (1, 18)].map(|(rod, at)| Support::clamp(node(rod, at))).to_vec();
    let obstacles = vec![Obstacle::bead("bead", &rods, node(0, 18), 0.1)];
    let down = Ramp::Displacement { node: node(0, 0), to: -Vec3::z() * 0.04 };
    let model = Model { rods, supports, obstacles, ..Model::default() };
    let rest = at_rest(model, &[Stage::new(vec![down], 2)]);
    assert!(rest.seen.obstacle_sites.len() == 1 && rest.seen.sites.is_empty(), "{:?}", rest.seen.obstacle_sites);
    assert!(rest.seen.obstacle_sites[0].force > 0.05, "{:?}", rest.seen.obstacle_sites);
    assert_eq!(rest.failing(|_, _| ()), Vec::<String>::new());
    let weaker = rest.failing(|_, seen| {
        let site = &mut seen.obstacle_sites[0];
        site.force *= 0.99;
        site.force_on_rod.iter_mut().for_each(|f| *f *= 0.99);
    });
    assert_eq!(weaker, ["balance of nodes", "balance of bodies"]);
    let slanted = rest.failing(|_, seen| seen.obstacle_sites[0].force_on_rod[0] += 0.01 * seen.obstacle_sites[0].force);
    assert!(slanted.contains(&"normals".to_owned()), "{slanted:?}");
    // the beam is raised into the bead
    let raised = rest.failing(|state, _| rest.carried(state, 1, &Quat::identity(), &(Vec3::z() * 2e-4)));
    assert!(raised.contains(&"gaps".to_owned()), "{raised:?}");
}
