//! What reduced scenes cost, relative to the full one: time per node and Newton iteration, entries of tangent and
//! factor per node.
//!
//! `cargo bench --bench reduced_scenes`. One problem for all: a leaf spring of two cantilevers, the one pressed on the
//! other by a load at its tip, or one of them alone; with and without out-of-plane unknowns, with contact in use, on
//! where nothing is near, or off; straight or curved by nature; with a stiffness that couples
//! strains, the same all along or from a table by arc length, with natural strains and radii. Each runs several times
//! in turn on one thread and the least time of the processor is kept, so that other work on the machine disturbs all
//! alike; only the ratios mean something. Parts on the clock: detection, assembly, factor with its analysis, solves.
//! `-- "planar, in contact"` runs the scenes of that name only, ten rounds: for a profiler.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::time::Instant;

use supercoil::math::Vec3;
use supercoil::rod::{Along, Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Support};
use supercoil::solve::{Options, Solver, Status, Timings};

/// Of all rods together.
const ELEMENTS: usize = 400;
const ROUNDS: usize = 3;
/// Nodes are two fifths of the contact distance apart.
const RADIUS: f64 = 0.002;
/// So small that the leaves, B = 1, L = 1, do not slide off each other sideways.
const FORCE: f64 = 1e-3;
/// Seconds that a case is timed for in a round.
const LONG_ENOUGH: f64 = 1.0;

struct Case {
    name: &'static str,
    planar: bool,
    rods: usize,
    contact: bool,
    natural: Natural,
    section: Given,
}

/// How the section is given.
#[derive(Clone, Copy, PartialEq)]
enum Given {
    /// Six numbers.
    Diagonal,
    /// A full stiffness, constant along the rod.
    Coupled,
    /// A full stiffness, natural strains and contact radii in pieces: a table by arc length.
    Table,
}

/// Pieces of a table.
const PIECES: usize = 100;

fn solver(case: &Case) -> Solver {
    let section = Section::isotropic(1.0, 0.8, 1e4, 1e4, RADIUS);
    let rod = |k: usize| {
        let line = Shape::Line { start: Vec3::y() * (2.02 * RADIUS * k as f64), direction: Vec3::x(), length: 1.0 };
        Rod::new(&format!("leaf {k}"), &line, RodMesh::open(ELEMENTS / case.rods, 3), section, case.natural.clone())
            .unwrap()
    };
    let mut stiffness = section.stiffness();
    (stiffness[(4, 5)], stiffness[(5, 4)]) = (0.3, 0.3);
    let ends: Vec<f64> = (1..=PIECES).map(|k| k as f64 / PIECES as f64).collect();
    let rod = |k: usize| match case.section {
        Given::Diagonal => rod(k),
        Given::Coupled => rod(k).with_stiffness(Along::constant(stiffness)).unwrap(),
        Given::Table => {
            let stiffnesses = (0..PIECES).map(|k| stiffness * (1.0 + 0.1 * (k as f64).sin())).collect();
            // equal ones: a strand that slides over steps asks for other iterations
            let radii = vec![RADIUS; PIECES];
            let rod = rod(k).with_stiffness(Along::pieces(ends.clone(), stiffnesses).unwrap()).unwrap();
            rod.with_contact_radii(Along::pieces(ends.clone(), radii).unwrap()).unwrap()
        }
    };
    let rods: Vec<Rod> = (0..case.rods).map(rod).collect();
    let tip = NodeRef { rod: case.rods - 1, node: rods[0].num_nodes() - 1 };
    let model = Model {
        supports: (0..case.rods).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect(),
        loads: vec![NodeLoad { node: tip, force: Vec3::y() * -FORCE, moment: Vec3::zeros() }],
        rods,
        contact: if case.contact { Contact::default() } else { Contact::NONE },
        planar: case.planar,
        ..Model::default()
    };
    Solver::new(model, Options { threads: Some(1), ..Options::default() }).unwrap()
}

/// Seconds of the processor that the process has taken so far, in hundredths, where the system tells them.
fn processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |k: usize| fields.get(k)?.parse::<f64>().ok();
    Some(0.01 * (ticks(11)? + ticks(12)?))
}

/// Seconds per Newton iteration and node, iterations of a run and where the time of the last went.
fn time(case: &Case) -> (f64, usize, Timings) {
    let (mut seconds, mut work) = (0.0, 0);
    loop {
        let mut solver = solver(case);
        let (started, before) = (Instant::now(), processor());
        let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
        seconds += match (before, processor()) {
            (Some(before), Some(after)) => after - before,
            _ => started.elapsed().as_secs_f64(),
        };
        assert_eq!(report.status, Status::Converged, "{}", case.name);
        work += report.iterations * solver.engine().num_nodes();
        if seconds >= LONG_ENOUGH {
            return (seconds / work as f64, report.iterations, solver.timings());
        }
    }
}

fn main() {
    let case = |name, planar, rods, contact| Case {
        name,
        planar,
        rods,
        contact,
        natural: Natural::Straight,
        section: Given::Diagonal,
    };
    let pieces = (1..=PIECES).map(|k| k as f64 / PIECES as f64).collect();
    let strains = (0..PIECES).map(|k| [0.0, 0.0, 1.0, 0.01 * (k as f64).sin(), 0.0, 0.0].into()).collect();
    let table = Natural::Varying(Along::pieces(pieces, strains).unwrap());
    let cases = [
        case("in space, in contact", false, 2, true),
        case("in space, contact on", false, 1, true),
        case("in space, no contact", false, 1, false),
        Case { natural: Natural::AsShaped, ..case("no contact, as shaped", false, 1, false) },
        Case { section: Given::Coupled, ..case("no contact, coupled", false, 1, false) },
        Case { section: Given::Table, natural: table.clone(), ..case("no contact, table", false, 1, false) },
        Case { section: Given::Table, natural: table, ..case("in contact, table", false, 2, true) },
        case("planar, in contact", true, 2, true),
        case("planar, contact on", true, 1, true),
        case("planar, no contact", true, 1, false),
    ];
    let only = std::env::args().skip(1).find(|arg| !arg.starts_with('-'));
    let cases: Vec<Case> =
        cases.into_iter().filter(|case| only.as_ref().is_none_or(|only| case.name == only)).collect();
    let rounds = if only.is_some() { 10 } else { ROUNDS };
    let mut best = vec![(f64::INFINITY, 0, Timings::default()); cases.len()];
    for _ in 0..rounds {
        for (best, case) in best.iter_mut().zip(&cases) {
            let now = time(case);
            if now.0 < best.0 {
                *best = now;
            }
        }
    }
    println!(
        "{:<24} {:>10} {:>10} {:>6} {:>9} {:>9} {:>9} {:>6}   detection assembly factor solve, % on the clock",
        "scene", "iterations", "µs/node/it", "rel.", "unknowns", "tangent", "factor", "rel.",
    );
    let mut full = 0.0;
    for (case, (seconds, iterations, parts)) in cases.iter().zip(&best) {
        let mut solver = solver(case);
        let size = solver.problem_size().unwrap();
        let per_node = |count: usize| count as f64 / size.nodes as f64;
        // tangent with row indices, the part of contact where strands are near each other, factor
        let entry = if size.candidates > 0 { 20.0 } else { 12.0 };
        let bytes = entry * per_node(size.tangent_entries) + 8.0 * per_node(size.factor_entries);
        if full == 0.0 {
            full = bytes;
        }
        let clock = seconds * (iterations * size.nodes) as f64;
        let part = |part: std::time::Duration| 100.0 * part.as_secs_f64() / clock;
        println!(
            "{:<24} {iterations:>10} {:>10.3} {:>6.2} {:>9.2} {:>9.1} {:>9.1} {:>6.2}   {:.0} {:.0} {:.0} {:.0}",
            case.name,
            seconds * 1e6,
            seconds / best[0].0,
            per_node(size.unknowns),
            per_node(size.tangent_entries),
            per_node(size.factor_entries),
            bytes / full,
            part(parts.detection),
            part(parts.assembly),
            part(parts.symbolic + parts.factor),
            part(parts.solve)
        );
    }
}
