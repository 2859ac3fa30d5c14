//! Long supercoiled rods: what a Newton iteration costs, part by part, and how many a plectoneme start takes to come to
//! rest.
//!
//! ```text
//! cargo bench --bench long_rods                       # iterations at 1e3 … 1e5 nodes, rest at 1e3
//! cargo bench --bench long_rods -- --max 1000000 --rest 10000
//! ```
//!
//! Per part: microseconds a node and iteration on one core, the share of that, and how many times as fast all threads
//! are. DNA in closed plectonemes at supercoiling density −0.06, D = 5 nm, nodes a third of D apart
//! (`examples/ecoli_length.toml` is one of 1e6 nodes). An iteration's cost is the mean over the first iterations from
//! the start shape, symbolic analysis included as often as it is made. Times on the clock.
//! Writes `target/long_rods/long_rods.csv`.

#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

mod fit;

use std::path::Path;
use std::time::{Duration, Instant};

use fit::exponent;
use supercoil::rod::{Natural, Plectoneme, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model};
use supercoil::solve::{NewtonOptions, Options, Solver, Status};

/// Iterations that are timed.
const ITERATIONS: usize = 4;
const SPACING: f64 = 5.0 / 3.0;

/// `nudged`: a node out of place by a thousandth of D keeps the rod from being started from a short one at rest, so
/// that the long one's first iterations are ordinary ones.
fn solver(nodes: usize, max_iterations: usize, nudged: bool, threads: Option<usize>) -> Solver {
    let elements = nodes / 3;
    let length = SPACING * (3 * elements) as f64;
    let turns = -0.06 * length / (0.34 * 10.5);
    let plectoneme = Plectoneme::of_link(length, 5.0, 205.7, 308.6, turns).unwrap();
    let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
    let mut rod =
        Rod::new("dna", &Shape::Plectoneme(plectoneme), RodMesh::closed(elements, 3), section, Natural::Straight)
            .unwrap();
    if nudged {
        rod.positions[3 * (elements / 4)].y += 5e-3;
    }
    let rod = rod.with_excess_link(turns).unwrap();
    let newton = NewtonOptions { max_iterations, ..NewtonOptions::default() };
    // the contact layer (B/κ)^¼ as wide as the nodes are apart
    let law = ContactLaw::AugmentedLagrangian { stiffness: 10.0, tol_penetration: 1e-8 };
    let model = Model { rods: vec![rod], contact: Contact { law }, ..Model::default() };
    Solver::new(model, Options { newton, threads, ..Options::default() }).unwrap()
}

const PARTS: [&str; 7] = ["detection", "assembly", "symbolic", "factor", "solve", "rest", "all"];

/// Times of the parts, in microseconds a node and iteration.
fn microseconds(nodes: usize, threads: Option<usize>) -> [f64; 7] {
    let mut solver = solver(nodes, ITERATIONS, true, threads);
    let started = Instant::now();
    let _ = solver.step_to(&[]).unwrap();
    let all = started.elapsed();
    let timings = solver.timings();
    // iterations of all searches, those of starts that led nowhere included
    let each = |time: Duration| time.as_secs_f64() * 1e6 / timings.node_iterations as f64;
    let parts = [timings.detection, timings.assembly, timings.symbolic, timings.factor, timings.solve];
    let [detection, assembly, symbolic, factor, solve] = parts;
    [detection, assembly, symbolic, factor, solve, all - timings.total(), all].map(each)
}

/// Peak memory of the process so far, MiB; 0 where the system does not tell.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse::<f64>().ok()).map_or(0.0, |kib| kib / 1024.0)
}

fn main() {
    let list: Vec<String> = std::env::args().collect();
    let number = |name: &str, default: usize| -> usize {
        let value = list.iter().position(|a| a == name).and_then(|k| list.get(k + 1));
        value.map_or(default, |v| v.parse().unwrap())
    };
    let (max, rest) = (number("--max", 100_000), number("--rest", 1000));
    let sizes: Vec<usize> =
        [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000].into_iter().filter(|n| *n <= max).collect();
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    println!("the first {ITERATIONS} iterations from a plectoneme, µs a node and iteration\n");
    println!(
        "{:>9} {:>10} {:>9} {:>7} {:>18}",
        "nodes",
        "part",
        "one core",
        "share",
        format!("gain by {threads} threads")
    );
    let mut rows: Vec<(usize, [f64; 7])> = Vec::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/long_rods");
    std::fs::create_dir_all(&folder).unwrap();
    let mut csv = csv::Writer::from_path(folder.join("long_rods.csv")).unwrap();
    csv.write_record(["nodes", "part", "threads", "microseconds_per_node_and_iteration"]).unwrap();
    for nodes in sizes {
        let (alone, shared) = (microseconds(nodes, Some(1)), microseconds(nodes, Some(threads)));
        for (k, part) in PARTS.iter().enumerate() {
            let (share, gain) = (100.0 * alone[k] / alone[6], alone[k] / shared[k]);
            println!("{nodes:>9} {part:>10} {:>9.2} {share:>6.0}% {gain:>18.2}", alone[k]);
            for (threads, time) in [(1, alone[k]), (threads, shared[k])] {
                csv.write_record([nodes.to_string(), (*part).to_owned(), threads.to_string(), time.to_string()])
                    .unwrap();
            }
        }
        println!("{nodes:>9} {:>10} {:>9.0} MiB\n", "peak", peak_memory());
        rows.push((nodes, alone));
    }
    for (k, part) in PARTS.iter().enumerate().filter(|_| rows.len() > 1) {
        let points: Vec<(f64, f64)> = rows.iter().map(|(n, row)| (*n as f64, row[k])).collect();
        println!("exponent {part}: {:.2}", exponent(&points));
    }
    println!();
    for nodes in [1_000, 3_000, 10_000, 100_000, 1_000_000].into_iter().filter(|n| *n <= rest) {
        let mut solver = solver(nodes, NewtonOptions::default().max_iterations, false, None);
        let started = Instant::now();
        let report = solver.step_to(&[]).unwrap();
        let taken = started.elapsed().as_secs_f64();
        let residual = solver.engine().relative_residual();
        println!(
            "rest of {nodes} nodes: {}, {} iterations in {} searches ({} on a shorter rod), relative residual \
             {residual:.1e}, penetration {:.1e} radii, {taken:.1} s",
            report.status,
            report.iterations,
            report.history.len(),
            report.iterations_on_other_meshes,
            report.penetration
        );
        assert_eq!(report.status, Status::Converged);
        let wanted = solver.engine().state().seams()[0];
        assert!(wanted.is_finite() && report.penetration < 1e-7);
    }
}
