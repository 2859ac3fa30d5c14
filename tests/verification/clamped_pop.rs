//! A long clamped rod, twisted and then slackened, buckles into a helix, winds it up at one place and pops into a loop
//! that touches itself (Coyne 1990; van der Heijden, Neukirch, Goss & Thompson 2003).
//!
//! ```text
//!   Φ ⤷|────────────────|   →   |──────∿∿──────|   →   |──────(loop, one contact)──────|
//!      taut, 8 turns            D < D*                 D > D*: pop
//! ```
//!
//! Set-up: L = B = C = 1, EA = GA = 1e7, contact radius .002, 96 cubic elements, both ends clamped along x; the right
//! one is pulled, turned by Φ = 8 turns and brought in by D. The buckled shape can turn about x while its sections roll
//! back, at no cost, and move along x at a cost of e^(−26): the middle node is kept in the plane z = 0 and half way
//! between the ends (its reaction must be nothing).
//!
//! References, with m = M/(2√(BT)):
//! * loss of stability of the straight rod: 2(b − a) sin(a/2) sin(b/2) = ab sin((b − a)/2), a, b = (M ± √(M² − 4BT))/2B
//!   (the linear equations B y⁗ − iM y‴ − T y″ = 0 with clamped ends, solved here); M² → 4BT for a long rod;
//! * after it, the localised state of an infinite rod (Coyne): Φ = ML/C + 4 arccos m, D = 4√(B/T)√(1 − m²), elastic
//!   energy M²L/2C + 4√(BT)√(1 − m²); its ends are e^(−L√(T(1 − m²)/B)/2) from straight;
//! * the pop: the largest D* that Φ allows on it; beyond, only the loop is left, which stays when the ends are moved
//!   back. The pop releases energy, the way back takes up the work of the end; Tw + Wr of the rod with straight tails
//!   stays Φ/2π, which a passage would change by 2.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // helpers of tests

use crate::common;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use common::{history, observed, root, verify};
use supercoil::math::Vec3;
use supercoil::math::link::writhe;
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Model, NodeRef, Ramp, Support};
use supercoil::solve::{FollowOptions, Options, PathEnd, PointKind, Solver, Status};

const TURNS: f64 = 8.0;
const PHI: f64 = TURNS * TAU;
const ELEMENTS: usize = 96;
const MIDDLE: NodeRef = NodeRef { rod: 0, node: 3 * ELEMENTS / 2 };
const END: NodeRef = NodeRef { rod: 0, node: 3 * ELEMENTS };
const STRETCHING: f64 = 1e7;

/// The end by so much, the middle by half of it.
fn bring(shortening: f64) -> [Ramp; 2] {
    [(END, 1.0), (MIDDLE, 0.5)].map(|(node, part)| Ramp::Displacement { node, to: -Vec3::x() * (part * shortening) })
}

/// The straight rod, pulled by more than it needs and turned.
fn taut(in_place: bool) -> Solver {
    let section = Section::isotropic(1.0, 1.0, STRETCHING, STRETCHING, 0.002);
    let shape = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("cable", &shape, RodMesh::open(ELEMENTS, 3), section, Natural::Straight).unwrap();
    let middle = Support { node: MIDDLE, position: [in_place, false, true], rotation: [false; 3] };
    let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 }), Support::clamp(END), middle];
    let mut solver = Solver::new(Model { rods: vec![rod], supports, ..Model::default() }, Options::default()).unwrap();
    let tension = 1.1 * PHI * PHI / 4.0;
    let bring = |by: f64| bring(by)[..if in_place { 2 } else { 1 }].to_vec();
    to(&mut solver, &bring(-tension / STRETCHING));
    for k in 1..=16 {
        let turned = TURNS * f64::from(k) / 16.0;
        to(&mut solver, &[Ramp::Rotation { node: END, axis: Vec3::x(), to: turned }]);
    }
    solver
}

/// Tension, twisting moment and what else there is to know of a state at rest.
struct Seen {
    tension: f64,
    moment: f64,
    energy: f64,
    link: f64,
    writhe: f64,
    all: Observation,
}

fn to(solver: &mut Solver, ramps: &[Ramp]) -> Seen {
    let report = solver.step_to(ramps).unwrap();
    assert_eq!((report.status, report.num_unstable), (Status::Converged, 0), "{ramps:?}: {}", history(&report));
    seen(observed(solver, &report), solver)
}

fn seen(all: Observation, solver: &Solver) -> Seen {
    let reaction = |node: NodeRef| all.reactions.iter().find(|r| r.node == node.node).unwrap();
    let (pin, tension) = (reaction(MIDDLE).force, reaction(END).force[0]);
    assert!(pin.iter().all(|f| f.abs() < 1e-5 * tension), "not held by its ends only: {pin:?}");
    let (mut points, _) = solver.engine().centerline(0, 16);
    let (first, last) = (points[0], points[points.len() - 1]);
    points.insert(0, first - Vec3::x() * 1e4);
    points.push(last + Vec3::x() * 1e4);
    let writhe = writhe(&points, false);
    Seen {
        tension,
        moment: reaction(END).moment[0],
        energy: all.energies.total,
        link: writhe + solver.engine().twist(0).0,
        writhe,
        all,
    }
}

/// D of the infinite rod's localised state at m, under Φ; and its tension.
fn localised(m: f64) -> (f64, f64) {
    let root = (PHI - 4.0 * m.acos()) / (2.0 * m);
    (4.0 / root * (1.0 - m * m).sqrt(), root * root)
}

/// m at the largest D.
fn fold() -> f64 {
    root(0.5, 0.9, |m| localised(m + 1e-5).0 - localised(m - 1e-5).0)
}

#[test]
fn the_straight_rod_buckles_where_the_linear_equations_say() {
    let mut solver = taut(false);
    let mut found = None;
    let report = solver.follow(&bring(1e-6)[0], &FollowOptions::default(), &mut |point| match point.kind {
        PointKind::Branch { .. } => {
            found = Some(observe(&point.progress));
            ControlFlow::Break(())
        }
        _ => ControlFlow::Continue(()),
    });
    assert_eq!(report.unwrap().end, PathEnd::Stopped);
    let at_branch = found.unwrap();
    let end = at_branch.reactions.iter().find(|reaction| reaction.node == END.node).unwrap();
    let (m, name) = (end.moment[0], "clamped rod, 8 turns");
    let tension = root(m * m / 4.0 - 20.0, m * m / 4.0 - 5.0, |t| {
        let root = (m * m - 4.0 * t).sqrt();
        let (a, b) = (0.5 * (m - root), 0.5 * (m + root));
        2.0 * (b - a) * (0.5 * a).sin() * (0.5 * b).sin() - a * b * (0.5 * (b - a)).sin()
    });
    verify(name, "tension at loss of stability, over the exact one", end.force[0] / tension, 1.0, 1e-6);
    println!("M²/4BT there: {:.5}", m * m / (4.0 * tension));
}

#[test]
fn slackened_it_localises_and_pops_into_a_loop() {
    let (most, m) = (localised(fold()).0, fold());
    println!("fold at m = {m:.6}, D = {most:.8}, T = {:.4}", localised(m).1);
    let mut solver = taut(true);
    let (mut before, mut reference) = (None, None);
    for share in [0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.96, 0.98, 0.99, 0.995, 0.997, 0.998] {
        let state = to(&mut solver, &bring(share * most));
        assert!(state.all.sites.is_empty());
        verify("slackened rod", &format!("Tw + Wr at {share} D*"), state.link, TURNS, 5e-5);
        if share >= 0.9 {
            // the rod is that much longer by its tension
            let shortening = share * most + state.tension / STRETCHING;
            let m = root(m, 0.9999, |m| localised(m).0 - shortening);
            let (tension, shape) = (localised(m).1, (1.0 - m * m).sqrt());
            let moment = 2.0 * m * tension.sqrt();
            let energy = 0.5 * moment * moment + 4.0 * tension.sqrt() * shape + 0.5 * tension * tension / STRETCHING;
            let case = format!("slackened rod, {share} D*, over Coyne's");
            verify(&case, "tension", state.tension / tension, 1.0, 1e-4);
            verify(&case, "twisting moment", state.moment / moment, 1.0, 5e-6);
            verify(&case, "elastic energy", state.energy / energy, 1.0, 1e-6);
        }
        let place = if share == 0.7 { &mut reference } else { &mut before };
        *place = Some(state);
    }
    let (before, reference) = (before.unwrap(), reference.unwrap());
    // beyond D* there is no such state; and the way back is another one
    let popped = to(&mut solver, &bring(1.001 * most));
    assert_eq!(popped.all.sites.len(), 1, "{:?}", popped.all.sites);
    assert!(popped.all.sites[0].kind == "point" && popped.writhe > 1.0, "{} {:?}", popped.writhe, popped.all.sites);
    verify("popped loop", "Tw + Wr", popped.link, TURNS, 5e-5);
    let loops: Vec<Seen> = [0.998, 0.94, 0.882].map(|share| to(&mut solver, &bring(share * most))).into();
    println!(
        "at 0.998 D*: energy {:.4} before the pop, {:.4} after, tension {:.2} and {:.2}",
        before.energy, loops[0].energy, before.tension, loops[0].tension
    );
    assert!(before.energy - loops[0].energy > 0.03 * before.energy, "what the pop releases");
    // what the loop takes up on the way back is the work of the end, by Simpson's rule
    let work = 0.116 * most / 6.0 * (loops[0].tension + 4.0 * loops[1].tension + loops[2].tension);
    verify(
        "popped loop",
        "energy taken up on the way back, over the work done",
        (loops[2].energy - loops[0].energy) / work,
        1.0,
        1e-3,
    );
    // far below D* it is still a loop
    let pulled = to(&mut solver, &bring(0.7 * most));
    assert_eq!(pulled.all.sites.len(), 1);
    verify("popped loop, pulled out to 0.7 D*", "Tw + Wr", pulled.link, TURNS, 5e-5);
    println!("at 0.7 D*: energy {:.4} of the loop, {:.4} of the helix", pulled.energy, reference.energy);
}
