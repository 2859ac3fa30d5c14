//! What the verification tests share: rows of the verification table, fitted orders, bisection on the inertia, strains.

#![allow(dead_code)] // every test file uses its part
#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::expect_used)] // helpers of tests

pub mod braid;
pub mod cases;
pub mod clamped_loop;
pub mod curvature;
pub mod fuzz;
pub mod kirchhoff_ring;
pub mod runge_kutta;
pub mod shooting;
pub mod two_ply;

use std::ops::ControlFlow;
use std::path::Path;

use supercoil::internals::element::{ElementNodes, Strain, raw_strains, stiffness};
use supercoil::internals::quaternion::to_array;
use supercoil::internals::shape_functions::ShapeTable;
use supercoil::math::{Quat, Vec3};
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::{Natural, Rod, Section};
use supercoil::scene::{Contact, Model, NodeLoad, NodeRef, Ramp, Scene, Support};
use supercoil::solve::{
    self, FollowOptions, Options, PathEnd, PathPoint, PointKind, Progress, Solution, Solver, Status, StepReport,
};

/// Prints a row of the verification table (seen with `--nocapture`) and asserts |measured − reference| ≤ tolerance.
pub fn verify(case: &str, quantity: &str, measured: f64, reference: f64, tolerance: f64) {
    let error = (measured - reference).abs();
    println!("| {case} | {quantity} | {measured:.12e} | {reference:.12e} | {error:.2e} | {tolerance:.1e} |");
    assert!(error <= tolerance, "{case}, {quantity}: {measured:.12e} is not {reference:.12e}, error {error:.3e}");
}

/// As [`verify`] for the three components of a point.
pub fn verify_point(case: &str, measured: &Vec3, reference: [f64; 3], tolerance: f64) {
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        verify(case, name, measured[k], reference[k], tolerance);
    }
}

/// Runs a scene whose files are in a folder: all its states, each with its certificate.
pub fn run(text: &str, folder: &Path, options: impl FnOnce(&Scene) -> Options) -> (Solution, Vec<Observation>) {
    let scene = Scene::from_toml(text, folder).unwrap();
    let options = options(&scene);
    let mut seen = Vec::new();
    let solution = solve::run(scene.model, &scene.stages, &options, &mut |progress| {
        seen.push(observe(progress));
        ControlFlow::Continue(())
    });
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged, "{:?}: {text}", solution.failure);
    for step in &seen {
        assert_eq!(step.status, "converged", "step {}: {}", step.step, step.certificate);
    }
    (solution, seen)
}

/// Runs a scene without files: its last state.
pub fn run_to_end(text: &str) -> (Solution, Observation) {
    let (solution, mut seen) = run(text, Path::new(""), |_| Options::default());
    (solution, seen.pop().unwrap())
}

/// Least-squares slope of log error against log size.
pub fn fitted_order(sizes: &[f64], errors: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = sizes.iter().zip(errors).map(|(h, e)| (h.ln(), e.ln())).collect();
    let count = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / count, m.1 + p.1 / count));
    let covariance: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    covariance / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// The load between `below` (where `unstable` is false) and `above` (true) at which it changes, halved until within
/// `tolerance`.
pub fn threshold(mut below: f64, mut above: f64, tolerance: f64, mut unstable: impl FnMut(f64) -> bool) -> f64 {
    assert!(!unstable(below), "already unstable at {below}");
    assert!(unstable(above), "still stable at {above}");
    while (above - below).abs() > tolerance {
        let middle = 0.5 * (below + above);
        *(if unstable(middle) { &mut above } else { &mut below }) = middle;
    }
    0.5 * (below + above)
}

/// Where `f` changes sign between `low` and `high`, to rounding.
pub fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let sign = f(low).signum();
    assert!(f(high).signum() != sign, "no change of sign between {low} and {high}");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if f(middle).signum() == sign { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// Any equilibrium, stable or not: for staying on a branch beyond its loss of stability.
pub fn any_equilibrium() -> Options {
    let mut options = Options { leave_unstable: false, ..Options::default() };
    options.newton.stable_only = false;
    options
}

/// Last node of a rod of the model.
pub fn end_of(rod: &Rod) -> NodeRef {
    NodeRef { rod: 0, node: rod.num_nodes() - 1 }
}

/// A rod without contact, clamped at its first node, with a dead force and a dead moment at its last.
pub fn cantilever(rod: Rod, force: Vec3, moment: Vec3) -> Model {
    Model {
        supports: vec![Support::clamp(NodeRef { rod: 0, node: 0 })],
        loads: vec![NodeLoad { node: end_of(&rod), force, moment }],
        contact: Contact::NONE,
        rods: vec![rod],
        ..Model::default()
    }
}

/// What is observed of the solver's state after a step.
pub fn observed(solver: &Solver, report: &StepReport) -> Observation {
    observe(&Progress { given: None, engine: solver.engine(), stage: 0, step: 0, fraction: 1.0, report, seconds: 0.0 })
}

/// Position of the last node of rod 0.
pub fn tip(solver: &Solver) -> Vec3 {
    *solver.engine().positions(0).last().unwrap()
}

/// Strains (reference subtracted) at the integration points of rod 0, element by element, for an open rod.
pub fn strains(rod: &Rod, positions: &[Vec3], frames: &[Quat]) -> Vec<Strain> {
    let table = ShapeTable::new(rod.order);
    let length = rod.length / rod.num_elements as f64;
    let raw = |positions: &[Vec3], frames: &[Quat], element: usize| {
        let mut nodes = ElementNodes::default();
        for a in 0..=rod.order {
            let node = element * rod.order + a;
            nodes.r[a] = positions[node].into();
            nodes.q[a] = to_array(&frames[node]);
        }
        nodes.align_signs(rod.order + 1);
        raw_strains(&table, &nodes, length)
    };
    let mut all = Vec::new();
    for element in 0..rod.num_elements {
        let now = raw(positions, frames, element);
        let natural = match &rod.natural {
            Natural::Straight => [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]; 3],
            Natural::Uniform { kappa } => [[0.0, 0.0, 1.0, kappa[0], kappa[1], kappa[2]]; 3],
            Natural::Varying(along) => {
                let at = |g: usize| along.at((element as f64 + table.rule.points[g.min(rod.order - 1)]) * length);
                std::array::from_fn(|g| at(g).into())
            }
            Natural::AsShaped => raw(&rod.positions, &rod.frames, element),
        };
        all.extend((0..rod.order).map(|g| std::array::from_fn(|i| now[g][i] - natural[g][i])));
    }
    all
}

/// Strains of rod 0 in the solver's state.
pub fn strains_of(solver: &Solver) -> Vec<Strain> {
    strains(&solver.engine().model().rods[0], solver.engine().positions(0), solver.engine().frames(0))
}

/// Elastic energy of rod 0 in the solver's state.
pub fn elastic_energy(solver: &Solver) -> f64 {
    let rod = &solver.engine().model().rods[0];
    let (material, table) = (stiffness(&rod.section), ShapeTable::new(rod.order));
    let length = rod.length / rod.num_elements as f64;
    let density = |strain: &Strain| 0.5 * (0..6).map(|i| material[i] * strain[i] * strain[i]).sum::<f64>();
    let points = strains_of(solver);
    points.iter().enumerate().map(|(i, s)| table.rule.weights[i % rod.order] * length * density(s)).sum()
}

/// A solid disc of slenderness L/ε with E = 2G, no shear correction, L = 1 and bending stiffness 1: EA = 4/ε², GA =
/// 2/ε².
pub fn slender_disc(slenderness: f64) -> Section {
    let radius = 1.0 / slenderness;
    Section::isotropic(1.0, 1.0, 4.0 / (radius * radius), 2.0 / (radius * radius), radius)
}

/// The iterations of a report on one line, for messages.
pub fn history(report: &StepReport) -> String {
    let line = |i: &supercoil::solve::Iteration| format!("{:.1e}({:.2})", i.increment, i.fraction);
    let searches = report.history.iter().map(|h| h.iter().map(line).collect::<Vec<_>>().join(" "));
    format!("{:?} {}: {}", report.status, report.iterations, searches.collect::<Vec<_>>().join(" | "))
}

/// Numbers in short scientific form, for messages.
pub fn sci(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:.2e}")).collect::<Vec<_>>().join(" ")
}

/// Follows a ramp from the present state to the first branch point and stays there; the parameter there.
pub fn to_branch_point(solver: &mut Solver, ramp: &Ramp) -> f64 {
    to_branch_point_by(solver, ramp, FollowOptions::default().step)
}

/// The same by first steps of another length.
pub fn to_branch_point_by(solver: &mut Solver, ramp: &Ramp, step: f64) -> f64 {
    let report =
        solver.follow(ramp, &FollowOptions { step, ..FollowOptions::default() }, &mut |point| match point.kind {
            PointKind::Branch { .. } => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        });
    let report = report.unwrap();
    assert_eq!(report.end, PathEnd::Stopped, "no branch point before {}", report.value);
    report.value
}

/// A line on a point of a path, for messages.
pub fn path_point(point: &PathPoint) -> String {
    let (unstable, iterations) = (point.num_unstable(), point.progress.report.iterations);
    format!("{:?} {:.9} arc {:.3} unstable {unstable} iterations {iterations}", point.kind, point.value, point.arc)
}
