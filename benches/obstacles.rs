//! What obstacles cost: Newton iterations of a rod of 10⁵ segments with ten of them, and without. The pass over all segments is
//! linear; it should take no more than a twentieth of an iteration.
//!
//! ```text
//! cargo bench --bench obstacles                     # 1e5 segments
//! cargo bench --bench obstacles -- --segments 10000
//! ```
//!
//! A straight rod lies on spheres and cylinders that it overlaps a little where they are. Which nodes are pushed is verified
//! against brute force over points of all segments. Then the obstacles are ten radii below it, so that they cost their detection
//! only. A load along the rod gives the searches something to do. Times are those of the processor with one thread, the least of
//! some runs.

#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Obstacle, Side, Support};
use supercoil::solve::{NewtonOptions, Options, Solver};

/// Iterations that are timed.
const ITERATIONS: usize = 4;
/// Runs of which the least time counts, because other work on the machine only adds.
const RUNS: usize = 3;
const OBSTACLES: usize = 10;
const RADIUS: f64 = 1.0;
/// Radius of the obstacles.
const SIZE: f64 = 30.0;
/// Overlap at the start where answers are verified, less than what is refused.
const OVERLAP: f64 = 0.05;
/// Overlap where costs are counted: none by far, because contact changes the search as well.
const APART: f64 = -10.0;
/// Points of a segment that brute force looks at.
const POINTS: usize = 64;

/// Ten obstacles along a rod on the x axis, spheres and cylinders in turn.
fn obstacles(length: f64, overlap: f64) -> Vec<Obstacle> {
    let made = |k: usize| {
        let x = length * (k as f64 + 0.5) / OBSTACLES as f64;
        let below = Vec3::new(x, 0.0, -(SIZE + RADIUS - overlap));
        let (name, size) = (format!("obstacle{k}"), (SIZE, Side::Outside));
        if k.is_multiple_of(2) {
            Obstacle::sphere(name, below, size)
        } else {
            Obstacle::cylinder(name, [below, Vec3::new(0.2, 1.0, 0.0)], size)
        }
    };
    (0..OBSTACLES).map(made).collect()
}

fn solver(segments: usize, overlap: Option<f64>) -> Solver {
    let elements = segments / 3;
    let length = RADIUS * (3 * elements) as f64;
    let section = Section::isotropic(1.0, 1.0, 10.0, 10.0, RADIUS);
    let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length };
    let rod = Rod::new("rod", &line, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
    let obstacles = overlap.map_or_else(Vec::new, |overlap| obstacles(length, overlap));
    let law = ContactLaw::Penalty { stiffness: 10.0 };
    let ends = [0, rod.num_nodes() - 1];
    let mut model = Model { rods: vec![rod], obstacles, contact: Contact { law }, ..Model::default() };
    model.line_loads.push(LineLoad { rod: 0, force: Vec3::x() * 1e-6, moment: Vec3::zeros() });
    model.supports.extend(ends.map(|node| Support::clamp(NodeRef { rod: 0, node })));
    let newton = NewtonOptions { max_iterations: ITERATIONS, ..NewtonOptions::default() };
    Solver::new(model, Options { newton, threads: Some(1), ..Options::default() }).unwrap()
}

/// Seconds of the processor that the process has taken so far, in hundredths.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = text.rsplit(')').next().unwrap().split_whitespace().collect();
    let ticks = |k: usize| fields[k].parse::<f64>().unwrap();
    0.01 * (ticks(11) + ticks(12))
}

/// Nodes that are pushed are the ends of the segments that brute force finds to overlap an obstacle.
fn verify(solver: &mut Solver) -> usize {
    // contact is looked for where a state is given
    solver.set_state(solver.engine().state().clone()).unwrap();
    let engine = solver.engine();
    let points = engine.centerline(0, POINTS).0;
    let nodes = engine.state().positions.len();
    let length = engine.model().rods[0].length;
    let overlap = |x: &Vec3| {
        let below = |k: usize| length * (k as f64 + 0.5) / OBSTACLES as f64;
        let depth = |k: usize| {
            let r = x - Vec3::new(below(k), 0.0, -(SIZE + RADIUS - OVERLAP));
            let axis = Vec3::new(0.2, 1.0, 0.0).normalize();
            let distance = if k.is_multiple_of(2) { r.norm() } else { r.cross(&axis).norm() };
            SIZE + RADIUS - distance
        };
        (0..OBSTACLES).map(depth).fold(f64::NEG_INFINITY, f64::max)
    };
    let deepest: Vec<f64> = (0..nodes - 1)
        .map(|k| points[k * POINTS..=(k + 1) * POINTS].iter().map(overlap).fold(f64::NEG_INFINITY, f64::max))
        .collect();
    let forces = engine.nodal_fields(0).contact_force;
    let mut pushed = 0;
    for (node, force) in forces.iter().enumerate() {
        let beside = deepest[node.saturating_sub(1)..(node + 1).min(deepest.len())].iter();
        let depth = beside.fold(f64::NEG_INFINITY, |most, depth| most.max(*depth));
        // between the points of brute force it may be deeper by the square of their distance
        if depth.abs() > 1e-5 {
            assert_eq!(force.norm() > 0.0, depth > 0.0, "node {node}: {depth}, {force:?}");
        }
        pushed += usize::from(force.norm() > 0.0);
    }
    pushed
}

/// Processor time of an iteration.
fn iteration(segments: usize, overlap: Option<f64>) -> f64 {
    let mut solver = solver(segments, overlap);
    let before = processor_time();
    let report = solver.step_to(&[]).unwrap();
    (processor_time() - before) / report.iterations as f64
}

fn main() {
    let list: Vec<String> = std::env::args().collect();
    let segments =
        list.iter().position(|a| a == "--segments").map_or(100_000, |k| list[k + 1].parse::<usize>().unwrap());
    let mut least = [f64::INFINITY; 2];
    let pushed = verify(&mut solver(segments, Some(OVERLAP)));
    for _ in 0..RUNS {
        for (least, overlap) in least.iter_mut().zip([None, Some(APART)]) {
            *least = least.min(iteration(segments, overlap));
        }
    }
    let [without, with] = least;
    println!(
        "{segments} segments: {:.1} ms an iteration without obstacles, {:.1} ms with {OBSTACLES}, {:.1} % more; {pushed} nodes pushed, as \
         brute force finds",
        1e3 * without,
        1e3 * with,
        100.0 * (with / without - 1.0)
    );
}
