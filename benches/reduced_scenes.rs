//! What reduced scenes cost, relative to the full one: time per node and Newton iteration, entries of tangent and factor per node.
//!
//! `cargo bench --bench reduced_scenes`. One problem for all: a cantilever under a load at its tip, with and without
//! out-of-plane unknowns, with and without contact, straight or curved by nature. Each is timed several times in turn and the fastest kept, so
//! that other work on the machine disturbs all alike; only the ratios mean something.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::time::Instant;

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status};

const ELEMENTS: usize = 2000;
const ROUNDS: usize = 5;

struct Case {
    name: &'static str,
    planar: bool,
    contact: bool,
    natural: Natural,
}

fn solver(case: &Case) -> Solver {
    let section = Section::isotropic(1.0, 0.8, 1e4, 1e4, 1e-3);
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
    let rod = Rod::new("beam", &line, false, section, ELEMENTS, 3, case.natural).unwrap();
    let tip = NodeRef { rod: 0, node: rod.num_nodes() - 1 };
    let contact = if case.contact { Contact::default() } else { Contact::NONE };
    let model = Model {
        rods: vec![rod],
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: tip, force: Vec3::y() * 2.0, moment: Vec3::zeros() }],
        contact,
        planar: case.planar,
        ..Model::default()
    };
    Solver::new(model, Options { threads: Some(1), ..Options::default() }).unwrap()
}

/// Seconds per Newton iteration and node.
fn time(case: &Case) -> f64 {
    let mut solver = solver(case);
    let started = Instant::now();
    let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
    assert_eq!(report.status, Status::Converged, "{}", case.name);
    started.elapsed().as_secs_f64() / (report.iterations * solver.engine().num_nodes()) as f64
}

fn main() {
    let straight = Natural::Straight;
    let cases = [
        Case { name: "full: in space, contact on", planar: false, contact: true, natural: straight },
        Case { name: "no contact", planar: false, contact: false, natural: straight },
        Case { name: "no contact, as shaped", planar: false, contact: false, natural: Natural::AsShaped },
        Case { name: "planar, contact on", planar: true, contact: true, natural: straight },
        Case { name: "planar, no contact", planar: true, contact: false, natural: straight },
    ];
    let mut best = vec![f64::INFINITY; cases.len()];
    for _ in 0..ROUNDS {
        for (best, case) in best.iter_mut().zip(&cases) {
            *best = best.min(time(case));
        }
    }
    println!(
        "{:<28} {:>10} {:>6} {:>9} {:>9} {:>9} {:>6}",
        "scene", "µs/node/it", "rel.", "unknowns", "tangent", "factor", "rel."
    );
    let mut full = 0.0;
    for (case, seconds) in cases.iter().zip(&best) {
        let mut solver = solver(case);
        let size = solver.engine_mut().footprint().unwrap();
        let per_node = |count: usize| count as f64 / size.nodes as f64;
        // tangent with row indices, the part of contact where strands are near each other, factor
        let entry = if size.candidates > 0 { 20.0 } else { 12.0 };
        let bytes = entry * per_node(size.tangent_entries) + 8.0 * per_node(size.factor_entries);
        if full == 0.0 {
            full = bytes;
        }
        println!(
            "{:<28} {:>10.3} {:>6.2} {:>9.2} {:>9.1} {:>9.1} {:>6.2}",
            case.name,
            seconds * 1e6,
            seconds / best[0],
            per_node(size.unknowns),
            per_node(size.tangent_entries),
            per_node(size.factor_entries),
            bytes / full
        );
    }
}
