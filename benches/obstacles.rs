//! What obstacles cost: Newton iterations of a hundred rods, 10⁵ segments, with ten of them, and without. The pass over
//! all segments is linear; it should take no more than a twentieth of an iteration.
//!
//! ```text
//! cargo bench --bench obstacles                     # 1e5 segments
//! cargo bench --bench obstacles -- --segments 10000
//! ```
//!
//! Straight rods lie side by side on spheres and cylinders that they overlap a little where they are. Which nodes are
//! pushed is verified against brute force over points of all segments. Then the obstacles are ten radii below them, so
//! that they cost their detection only. A load upwards gives the searches something to do. Times are those of the
//! processor with one thread, the least of some runs.

#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, RodMesh, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, LineLoad, Model, NodeRef, Obstacle, Ramp, Side, Support};
use supercoil::solve::{NewtonOptions, Options, Solver};

/// Iterations that are timed.
const ITERATIONS: usize = 4;
/// Runs of which the least time counts, because other work on the machine only adds.
const RUNS: usize = 3;
const OBSTACLES: usize = 10;
/// Segments of a rod: of a single one of 10⁵ segments bending would be below the rounding of stretch.
const OF_A_ROD: usize = 999;
/// Distance of neighbouring rods, in which they do not touch.
const BESIDE: f64 = 4.0;
const RADIUS: f64 = 1.0;
/// Radius of the obstacles.
const SIZE: f64 = 30.0;
/// Overlap at the start where answers are verified, less than what is refused.
const OVERLAP: f64 = 0.05;
/// Overlap where costs are counted: none by far, because contact changes the search as well.
const APART: f64 = -10.0;
/// Points of a segment that brute force looks at.
const POINTS: usize = 64;

/// Length of a rod.
const LENGTH: f64 = RADIUS * OF_A_ROD as f64;

/// The middle of an obstacle: ten along the first rod.
fn middle(k: usize, overlap: f64) -> Vec3 {
    Vec3::new(LENGTH * (k as f64 + 0.5) / OBSTACLES as f64, 0.0, -(SIZE + RADIUS - overlap))
}

/// Along the cylinders, which pass under all rods.
fn axis() -> Vec3 {
    Vec3::new(0.2, 1.0, 0.0)
}

/// Spheres and cylinders in turn.
fn obstacles(overlap: f64) -> Vec<Obstacle> {
    let made = |k: usize| {
        let (name, size) = (format!("obstacle{k}"), (SIZE, Side::Outside));
        if k.is_multiple_of(2) {
            Obstacle::sphere(name, middle(k, overlap), size)
        } else {
            Obstacle::cylinder(name, [middle(k, overlap), axis()], size)
        }
    };
    (0..OBSTACLES).map(made).collect()
}

fn solver(segments: usize, overlap: Option<f64>) -> Solver {
    let section = Section::isotropic(1.0, 1.0, 10.0, 10.0, RADIUS);
    let rod = |k: usize| {
        let start = Vec3::y() * (BESIDE * RADIUS * k as f64);
        let line = Shape::Line { start, direction: Vec3::x(), length: LENGTH };
        Rod::new(&format!("rod{k}"), &line, RodMesh::open(OF_A_ROD / 3, 3), section, Natural::Straight).unwrap()
    };
    let rods: Vec<Rod> = (0..segments.div_ceil(OF_A_ROD)).map(rod).collect();
    let law = ContactLaw::Penalty { stiffness: 10.0 };
    let mut model = Model { contact: Contact { law }, ..Model::default() };
    model.obstacles = overlap.map_or_else(Vec::new, obstacles);
    for rod in 0..rods.len() {
        model.line_loads.push(LineLoad::of_force(rod, Vec3::z() * 1e-8));
        model.supports.extend([0, OF_A_ROD].map(|node| Support::clamp(NodeRef { rod, node })));
    }
    model.rods = rods;
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

/// Nodes that are pushed are the ends of the segments that brute force finds to overlap an obstacle; how many there
/// are.
fn verify(solver: &mut Solver) -> usize {
    // looks for candidates
    solver.problem_size().unwrap();
    let engine = solver.engine();
    let along = axis().normalize();
    let overlap = |x: &Vec3| {
        let depth = |k: usize| {
            let r = x - middle(k, OVERLAP);
            SIZE + RADIUS - if k.is_multiple_of(2) { r.norm() } else { r.cross(&along).norm() }
        };
        (0..OBSTACLES).map(depth).fold(f64::NEG_INFINITY, f64::max)
    };
    let mut pushed = 0;
    for (rod, fields) in engine.all_nodal_fields().iter().enumerate() {
        let points = engine.centerline(rod, POINTS).0;
        let deepest: Vec<f64> = (0..OF_A_ROD)
            .map(|k| points[k * POINTS..=(k + 1) * POINTS].iter().map(overlap).fold(f64::NEG_INFINITY, f64::max))
            .collect();
        for (node, force) in fields.contact_force.iter().enumerate() {
            let beside = deepest[node.saturating_sub(1)..(node + 1).min(deepest.len())].iter();
            let depth = beside.fold(f64::NEG_INFINITY, |most, depth| most.max(*depth));
            // between the points of brute force it may be deeper by the square of their distance
            if depth.abs() > 1e-5 {
                assert_eq!(force.norm() > 0.0, depth > 0.0, "node {node} of rod {rod}: {depth}, {force:?}");
            }
            pushed += usize::from(force.norm() > 0.0);
        }
    }
    pushed
}

/// Processor time of an iteration.
fn iteration(segments: usize, overlap: Option<f64>) -> f64 {
    let mut solver = solver(segments, overlap);
    let before = processor_time();
    let report = solver.step_to(&[Ramp::Load { to: 1.0 }]).unwrap();
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
        "{segments} segments: {:.1} ms an iteration without obstacles, {:.1} ms with {OBSTACLES}, {:.1} % more; \
         {pushed} nodes pushed, as brute force finds",
        1e3 * without,
        1e3 * with,
        100.0 * (with / without - 1.0)
    );
}
