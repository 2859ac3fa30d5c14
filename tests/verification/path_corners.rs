//! Paths of equilibria round corners where one contact of several begins or ends, there and back.
//!
//! **Stack.** A shallow arch snaps through under a load P at its apex, along an unstable path on which P falls, onto a
//! soft beam, which then comes down on a stiff one. Both beams run along z, the arch along x; all ends are clamped, all
//! bend in upright planes only, clear distances .05 and .01.
//!
//! ```text
//!         P
//!      ___↓___                  P
//!    /    ○    \    y = .1      |     /| stiff beam
//!   /           \               |    / | reached
//!  ⊥      ○      ⊥  y = .03     |   /    \ beam reached
//!         ●         y = 0       |  /      \/
//! ```
//!
//! L = 1 (beams) and span 1 (arch), B = 1 (arch), .2 and 5 (beams), EA = 1e4, contact diameter .02, 16 cubic elements
//! each. The soft beam only bends the path; at the stiff one, with the other contact under load, P turns back and a
//! contact force sets in. By geometry the apex stands .02 above the soft beam's rest at the first corner, and .01 lower
//! at the second. Independent of path following, load steps that prescribe the height of the apex (which the path
//! lowers all the way) must find the same P on both sides of both corners: they pass the limit point and the corners
//! without noticing.
//!
//! **Ring.** The closed twisted ring, L = 1, B = 1, C/B = 1.5, D/L = .03, EA = GA = 1e7 (which moves M₃L/2πB at first
//! contact by 4e-6), 96 cubic elements: from the root of the buckled branch on the flat circle over its fold to first
//! contact, round it and on to two and three contacts, and back. Reference for first contact and two → three: Kirchhoff
//! rod by shooting (`common/kirchhoff_ring.rs`). What a penalty κ makes of the latter is a matter of κ (the gap in the
//! middle is tiny between two points): its error must fall with κ. One → two is seen where the zone of contact parts in
//! two, which under a penalty is later than the point opens. Load steps to the same excess links on both sides of every
//! corner must give the same states.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on and tells what it found

use crate::common;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use common::cases::oval_ring;
use common::kirchhoff_ring::{Event, event_of};
use common::{any_equilibrium, path_point, to_branch_point, verify};
use supercoil::math::Vec3;
use supercoil::observe::{contact_sites, observe};
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, Options, PathEnd, PointKind, Solver, Start, State, Status};

const DIAMETER: f64 = 0.02;

/// An arch over two beams.
#[derive(Clone, Copy)]
struct Stack {
    name: &'static str,
    law: ContactLaw,
    /// Rise and stretching stiffness of the arch.
    rise: f64,
    stretch: f64,
    /// Height of the soft beam, clear distance from it to the stiff one, bending stiffness of both.
    height: f64,
    clear: f64,
    bending: [f64; 2],
    /// P where the way down ends.
    most: f64,
}

const STACK: Stack = Stack {
    name: "arch on two beams",
    law: ContactLaw::AugmentedLagrangian { stiffness: 100.0, tol_penetration: Contact::DEFAULT_TOL_PENETRATION },
    rise: 0.1,
    stretch: 1e4,
    height: 0.03,
    clear: 0.01,
    bending: [0.2, 5.0],
    most: 100.0,
};

impl Stack {
    fn model(&self) -> Model {
        let section = |b: f64| Section::isotropic(b, b, self.stretch, 1e5, 0.5 * DIAMETER);
        let points = (0..=32).map(|k| f64::from(k) / 32.0);
        let points = points.map(|x| Vec3::new(x, 0.5 * self.rise * (1.0 - (TAU * x).cos()), 0.0)).collect();
        let arch = Rod::new("arch", &Shape::Points(points), RodMesh::open(16, 3), section(1.0), Natural::AsShaped);
        let beam = |name: &str, y: f64, b: f64| {
            let line = Shape::Line { start: Vec3::new(0.5, y, -0.5), direction: Vec3::z(), length: 1.0 };
            Rod::new(name, &line, RodMesh::open(16, 3), section(b), Natural::Straight)
        };
        let soft = beam("soft", self.height, self.bending[0]);
        let stiff = beam("stiff", self.height - DIAMETER - self.clear, self.bending[1]);
        let rods: Vec<Rod> = [arch, soft, stiff].map(Result::unwrap).into();
        // bending in their planes alone: of an arch on a beam on a beam, each would slip off the other
        let held = |rod: usize, node: usize| {
            let ends = node == 0 || node == rods[rod].num_nodes() - 1;
            let plane = if rod == 0 { [false, false, true] } else { [true, false, false] };
            let within = plane.map(|out| !out);
            let node = NodeRef { rod, node };
            if ends { Support::clamp(node) } else { Support { node, position: plane, rotation: within } }
        };
        let supports = (0..3).flat_map(|rod| (0..rods[rod].num_nodes()).map(move |node| held(rod, node)));
        let contact = Contact { law: self.law };
        Model { supports: supports.collect(), contact, rods: rods.clone(), ..Model::default() }
    }
}

fn apex(model: &Model) -> NodeRef {
    NodeRef { rod: 0, node: model.rods[0].num_nodes() / 2 }
}

/// A point of the stack's path: what it is, P, height of the apex, contacts, slope.
#[derive(Debug, Clone, Copy)]
struct Seen {
    kind: PointKind,
    load: f64,
    height: f64,
    contacts: usize,
    slope: f64,
}

fn follow_stack(solver: &mut Solver, to: f64) -> Vec<Seen> {
    let node = solver.engine().model().rods[0].num_nodes() / 2;
    let mut seen = Vec::new();
    let report = solver.follow(&Ramp::Load { to }, &FollowOptions::default(), &mut |point| {
        println!("{}", path_point(point));
        let (height, contacts) = (point.engine().positions(0)[node].y, contact_sites(point.engine()).len());
        seen.push(Seen { kind: point.kind, load: point.value, height, contacts, slope: point.slope });
        ControlFlow::Continue(())
    });
    assert_eq!(report.unwrap().end, PathEnd::Target);
    seen
}

/// P at heights of the apex, in load steps that prescribe the height.
fn load_at_heights(stack: &Stack, heights: &[f64]) -> Vec<f64> {
    let mut model = stack.model();
    let node = apex(&model);
    let start = model.rods[0].positions[node.node].y;
    // the apex stays in the plane of symmetry, too: this path is left by others
    *model.supports.iter_mut().find(|support| support.node == node).unwrap() = Support::clamp(node);
    let mut solver = Solver::new(model, Options::default()).unwrap();
    let at = |height: &f64| {
        let to = Vec3::y() * (height - start);
        let report = solver.step_to(&[Ramp::Displacement { node, to }]).unwrap();
        assert_eq!(report.status, Status::Converged, "height {height}: {}", common::history(&report));
        let seen = common::observed(&solver, &report);
        -seen.reactions.iter().find(|r| r.rod == 0 && r.node == node.node).unwrap().force[1]
    };
    heights.iter().map(at).collect()
}

/// The path down and up with its corners checked.
fn down_and_up(stack: &Stack) -> [Vec<Seen>; 2] {
    let mut model = stack.model();
    model.loads = vec![NodeLoad { node: apex(&model), force: -Vec3::y(), moment: Vec3::zeros() }];
    let mut solver = Solver::new(model, any_equilibrium()).unwrap();
    let [down, up] = [stack.most, 1.0].map(|to| follow_stack(&mut solver, to));
    let corners =
        |path: &[Seen]| -> Vec<Seen> { path.iter().filter(|s| s.kind == PointKind::Corner).copied().collect() };
    let (there, mut back) = (corners(&down), corners(&up));
    back.reverse();
    // pressed harder, the beams touch on both sides of the middle, too
    assert!(there.len() >= 2 && there.len() == back.len(), "{there:?} {back:?}");
    let heights = [stack.height + DIAMETER, stack.height + DIAMETER - stack.clear];
    for (k, name) in ["first", "second"].into_iter().enumerate() {
        for (way, corner) in [("down", there[k]), ("up", back[k])] {
            let quantity = format!("height of the apex at the {name} corner, {way}");
            verify(stack.name, &quantity, corner.height, heights[k], 3e-6);
        }
        verify(stack.name, &format!("P up over P down, {name} corner"), back[k].load / there[k].load, 1.0, 3e-6);
    }
    // P falls until the stiff beam is reached, and rises from there on
    let after = down.iter().position(|s| s.kind == PointKind::Corner && s.load == there[1].load).unwrap() + 1;
    assert!(there[1].slope < 0.0 && down[after..].iter().all(|s| s.slope > 0.0));
    let on_both = |s: &&Seen| s.kind == PointKind::Regular && s.contacts >= 2;
    assert!(up.iter().filter(on_both).all(|s| s.slope < 0.0));
    [down, up]
}

#[test]
fn one_contact_after_the_other() {
    let [down, _] = down_and_up(&STACK);
    let regular: Vec<Seen> = down.iter().filter(|s| s.kind == PointKind::Regular).copied().collect();
    for contacts in 0..=2 {
        assert!(regular.iter().filter(|s| s.contacts == contacts).count() > 5);
    }
    let sample: Vec<Seen> = regular.iter().step_by(4).copied().collect();
    let stepped = load_at_heights(&STACK, &sample.iter().map(|s| s.height).collect::<Vec<_>>());
    for (point, load) in sample.iter().zip(stepped) {
        let quantity =
            format!("P at the height {:.6}, contacts: {}, over that of load steps", point.height, point.contacts);
        // under offsets for gaps a state depends a little on how it was come to
        verify(STACK.name, &quantity, point.load / load, 1.0, if point.contacts == 0 { 1e-9 } else { 1e-6 });
    }
}

/// Harder laws; a stiffer arch; and beams close together under a load from which long steps back would skip both
/// corners and go on along the path of the arch alone.
#[test]
fn other_stacks() {
    let hard = ContactLaw::AugmentedLagrangian { stiffness: 1e5, tol_penetration: 1e-9 };
    let stacks = [
        Stack { name: "arch on two beams, hard offsets", law: hard, ..STACK },
        Stack { name: "arch on two beams, penalty", law: ContactLaw::Penalty { stiffness: 1e7 }, ..STACK },
        Stack { name: "arch on two beams close together", clear: 1e-3, bending: [2.0, 5.0], most: 200.0, ..STACK },
        Stack {
            name: "stiff arch on two beams",
            rise: 0.08,
            stretch: 1e5,
            height: 0.0,
            bending: [0.2, 50.0],
            most: 200.0,
            ..STACK
        },
    ];
    for stack in stacks {
        down_and_up(&stack);
    }
}

const RING: f64 = 0.03;

fn ring(kappa: f64, options: Options) -> Solver {
    let section = Section::isotropic(1.0, 1.5, 1e7, 1e7, 0.5 * RING);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, RodMesh::closed(96, 3), section, Natural::Straight).unwrap();
    let law = ContactLaw::Penalty { stiffness: kappa * (0.5 * RING).powi(4) };
    Solver::new(Model { contact: Contact { law }, rods: vec![rod], ..Model::default() }, options).unwrap()
}

/// ΔLk, writhe, M₃L/2πB and contact force of a state.
type Numbers = [f64; 4];

/// Follows the ring through the links in turn; corners, numbers and states at the links.
fn follow_ring(solver: &mut Solver, start: Start, links: &[f64]) -> (Vec<Numbers>, Vec<Numbers>, Vec<State>) {
    let (mut corners, mut numbers_there, mut states) = (Vec::new(), Vec::new(), Vec::new());
    for (leg, &to) in links.iter().enumerate() {
        let start = if leg == 0 { start } else { Start::Towards };
        let report = solver.follow(
            &Ramp::ExcessLink { rod: 0, to },
            &FollowOptions { start, ..FollowOptions::default() },
            &mut |point| {
                println!("{}", path_point(point));
                let seen = observe(&point.progress);
                let numbers =
                    [point.value, seen.links[0].writhe, seen.links[0].seam_moment / TAU, seen.total_contact_force];
                match point.kind {
                    PointKind::Corner => corners.push(numbers),
                    PointKind::Target => {
                        numbers_there.push(numbers);
                        states.push(point.progress.engine.state().clone());
                    }
                    _ => {}
                }
                ControlFlow::Continue(())
            },
        );
        assert_eq!(report.unwrap().end, PathEnd::Target);
    }
    (corners, numbers_there, states)
}

/// What the ripple of the mesh makes of force and writhe if a load step shifts the loop by some hundredths of an
/// element; where on its mesh the loop lies is decided at the branch point, by rounding. A twentieth of an element
/// makes 1e-6 to 3e-6.
const RIPPLE: f64 = 2e-6;

#[test]
fn ring_from_no_contact_to_three_and_back() {
    let links = [1.2, 1.88, 1.97, 2.3, 2.36];
    let mut found = Vec::new();
    for kappa in [1e10, 1e11] {
        let mut solver = ring(kappa, any_equilibrium());
        to_branch_point(&mut solver, &Ramp::ExcessLink { rod: 0, to: 2.0 });
        let (there, numbers_there, states) = follow_ring(&mut solver, Start::Branch { forwards: true }, &links);
        let way_back: Vec<f64> = links[..4].iter().rev().copied().collect();
        let (mut back, mut numbers_back, _) = follow_ring(&mut solver, Start::Towards, &way_back);
        back.reverse();
        numbers_back.reverse();
        let case = format!("twisted ring, D/L = {RING}, κ = {kappa:.0e}");
        assert_eq!((there.len(), back.len()), (3, 2), "{there:?} {back:?}");
        let exact = [Event::FirstContact, Event::TwoToThree].map(|event| event_of(event, RING));
        verify(&case, "Wr at the corner where contact begins", there[0][1], exact[0].writhe, 1e-5);
        verify(&case, "M₃L/2πB at the corner where contact begins", there[0][2], exact[0].torque, 1e-5);
        found.push(there[2]);
        for (k, name) in [(1, "one → two"), (2, "two → three")] {
            verify(&case, &format!("ΔLk at {name}, back over there"), back[k - 1][0] / there[k][0], 1.0, 1e-6);
        }
        for (k, numbers) in numbers_back.iter().enumerate() {
            verify(
                &case,
                &format!("contact force at ΔLk = {}, back over there", links[k]),
                numbers[3] / numbers_there[k][3],
                1.0,
                1e-8,
            );
        }
        // each step from where the loop of the path lay on its mesh
        for (k, to) in links.into_iter().enumerate() {
            let mut stepped = ring(kappa, Options::default());
            stepped.set_state(states[k.saturating_sub(1)].clone()).unwrap();
            let report = stepped.step_to(&[Ramp::ExcessLink { rod: 0, to }]).unwrap();
            assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{}", common::history(&report));
            let seen = common::observed(&stepped, &report);
            assert_eq!(seen.sites.len(), [1, 1, 2, 2, 3][k]);
            verify(
                &case,
                &format!("contact force at ΔLk = {to}, path over load steps"),
                numbers_there[k][3] / seen.total_contact_force,
                1.0,
                RIPPLE,
            );
            verify(
                &case,
                &format!("writhe at ΔLk = {to}, path over load steps"),
                numbers_there[k][1] / seen.links[0].writhe,
                1.0,
                RIPPLE,
            );
        }
    }
    // at points what a penalty is off by falls as κ^(−2/3)
    let factor = 10f64.powf(2.0 / 3.0) - 1.0;
    let exact = event_of(Event::TwoToThree, RING);
    for (k, quantity, exact) in [(1, "Wr", exact.writhe), (2, "M₃L/2πB", exact.torque)] {
        let hard = found[1][k] + (found[1][k] - found[0][k]) / factor;
        let quantity = format!("{quantity} at the corner two → three, extrapolated from κ = 1e10, 1e11");
        verify("twisted ring, D/L = 0.03", &quantity, hard, exact, 2e-4);
    }
}

/// A planar ring under pressure, D/R = .05, over its first touch into contact and back: p R³/B there by shooting
/// (`tests/verification/planar_touch.rs`).
#[test]
fn ring_under_pressure_there_and_back() {
    let mut solver = Solver::new(oval_ring(48, 0.05, 1e6, Contact::default().law), Options::default()).unwrap();
    assert_eq!(solver.step_to(&[Ramp::Pressure { rod: 0, to: 3.3 }]).unwrap().status, Status::Converged);
    for (way, to) in [("there", 8.0), ("back", 3.3)] {
        let mut corners = Vec::new();
        let report = solver.follow(&Ramp::Pressure { rod: 0, to }, &FollowOptions::default(), &mut |point| {
            println!("{}", path_point(point));
            if point.kind == PointKind::Corner {
                corners.push(point.value);
            }
            ControlFlow::Continue(())
        });
        assert_eq!((report.unwrap().end, corners.len()), (PathEnd::Target, 1));
        verify(
            "ring under pressure, D/R = 0.05",
            &format!("p R³/B at the corner, {way}"),
            corners[0],
            5.103_179_2,
            1e-4,
        );
        if to > 8.0 - 1e-9 {
            let force: f64 = contact_sites(solver.engine()).iter().map(|site| site.force).sum();
            let report = solver.find_equilibrium();
            assert_eq!(report.status, Status::Converged);
            let settled: f64 = contact_sites(solver.engine()).iter().map(|site| site.force).sum();
            verify(
                "ring under pressure, D/R = 0.05",
                "contact force at p = 8, over that of a load step",
                force / settled,
                1.0,
                1e-6,
            );
        }
    }
}
