//! Energy stored against work done, by what is reported along a run in small steps.
//!
//! ```text
//! E(1) − E(0) = Σ ½ (F₀ + F₁)·Δx + ½ (M₀ + M₁)·Δφ        over steps, supports, loads and seams
//! ```
//!
//! F and M are reactions, dead loads or the moment of a seam, Δx and Δφ the motion of their node between two states.
//! The trapezoidal rule errs by the square of the step: runs of n and 2n steps are extrapolated.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use supercoil::math::{Quat, Vec3};
use supercoil::observe::observe;
use supercoil::observe::report::Observation;
use supercoil::rod::Rod;
use supercoil::scene::{ContactLaw, Model, NodeRef, Ramp, Stage};
use supercoil::solve::{Progress, Status, run};

use super::measure::options;
use super::motion::Problem;

/// Steps of a stage.
const STEPS: usize = 6;

/// What is known of a state: places of nodes, load factor, report.
struct Record {
    positions: Vec<Vec<Vec3>>,
    frames: Vec<Vec<Quat>>,
    factor: f64,
    seen: Observation,
}

/// A force and a moment on a node.
struct Pull {
    node: NodeRef,
    force: Vec3,
    moment: Vec3,
}

/// Part of the work that is not in the energy, or of an energy `least` where work is less; `None` where the first stage
/// already does work in another way, or a step jumps.
pub fn missing(problem: &Problem, least: f64) -> Option<f64> {
    let is_whole = |stage: &&Stage| stage.supports.is_empty() && stage.ramps.iter().all(is_followed);
    let stages: Vec<Stage> = problem.stages.iter().take_while(is_whole).cloned().collect();
    let [coarse, fine] = [STEPS, 2 * STEPS].map(|steps| balance(problem, &stages, steps));
    let ((coarse, _), (fine, size)) = (coarse?, fine?);
    Some((4.0 * fine - coarse).abs() / (3.0 * size.max(least)))
}

/// Whether nodes, loads and seams are all that moves.
fn is_followed(ramp: &Ramp) -> bool {
    matches!(
        ramp,
        Ramp::Load { .. }
            | Ramp::ExcessLink { .. }
            | Ramp::Rotation { .. }
            | Ramp::RotationAbout { .. }
            | Ramp::Displacement { .. }
            | Ramp::Pose { .. }
    )
}

/// Energy gained less work, and the size of both.
fn balance(problem: &Problem, stages: &[Stage], steps: usize) -> Option<(f64, f64)> {
    let model = &problem.model;
    let stages: Vec<Stage> = stages.iter().map(|stage| Stage { steps, ..stage.clone() }).collect();
    let (mut records, mut jumps): (Vec<Record>, bool) = (Vec::new(), false);
    let solution = run(model.clone(), &stages, &options(), &mut |progress| {
        jumps |= progress.report.energy_released > 0.0 || progress.report.escapes > 0;
        records.push(record(progress, &stages));
        ControlFlow::Continue(())
    });
    let converged = solution.is_ok_and(|it| it.status == Status::Converged);
    if jumps || !converged || stages.is_empty() {
        return None;
    }
    let is_penalty = matches!(model.contact.law, ContactLaw::Penalty { .. });
    let energy = |at: &Record| {
        let e = at.seen.energies;
        if is_penalty { e.total } else { e.total - e.contact }
    };
    let gained = energy(records.last()?) - energy(&records[0]);
    let parts = records.windows(2).map(|pair| work(model, &pair[0], &pair[1]));
    let (work, size) = parts.fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Some((gained - work, size))
}

fn record(progress: &Progress, stages: &[Stage]) -> Record {
    let rods = || 0..progress.engine.model().rods.len();
    let mut factor = 0.0;
    for (k, stage) in stages.iter().enumerate().take(progress.stage + 1) {
        let part = if k < progress.stage { 1.0 } else { progress.fraction };
        for ramp in &stage.ramps {
            if let Ramp::Load { to } = ramp {
                factor += (to - factor) * part;
            }
        }
    }
    Record {
        positions: rods().map(|rod| progress.engine.positions(rod).to_vec()).collect(),
        frames: rods().map(|rod| progress.engine.frames(rod).to_vec()).collect(),
        factor,
        seen: observe(progress),
    }
}

/// Work between two states, and the size of its parts.
fn work(model: &Model, before: &Record, after: &Record) -> (f64, f64) {
    let done = |from: &Pull, to: &Pull| {
        let NodeRef { rod, node } = from.node;
        let moved = after.positions[rod][node] - before.positions[rod][node];
        let turned = (after.frames[rod][node] * before.frames[rod][node].inverse()).scaled_axis();
        0.5 * ((from.force + to.force).dot(&moved) + (from.moment + to.moment).dot(&turned))
    };
    let [first, second] = [before, after].map(|at| pulls(model, at));
    let of_nodes = first.iter().zip(&second).map(|(from, to)| done(from, to));
    let links = before.seen.links.iter().zip(&after.seen.links);
    let of_seams =
        links.map(|(from, to)| 0.5 * (from.seam_moment + to.seam_moment) * TAU * (to.excess_link - from.excess_link));
    of_nodes.chain(of_seams).fold((0.0, 0.0), |sum, work| (sum.0 + work, sum.1 + work.abs()))
}

/// All that pulls at nodes in a state.
fn pulls(model: &Model, at: &Record) -> Vec<Pull> {
    let reactions = at.seen.reactions.iter().map(|it| Pull {
        node: NodeRef { rod: it.rod, node: it.node },
        force: it.force.into(),
        moment: it.moment.into(),
    });
    let factor = at.factor;
    let loads =
        model.loads.iter().map(|it| Pull { node: it.node, force: it.force * factor, moment: it.moment * factor });
    let along = model.line_loads.iter().flat_map(|load| {
        let shares = shares(&model.rods[load.rod]).into_iter().enumerate();
        shares.map(move |(node, share)| Pull {
            node: NodeRef { rod: load.rod, node },
            force: load.force * (factor * share),
            moment: load.moment * (factor * share),
        })
    });
    reactions.chain(loads).chain(along).collect()
}

/// ∫ N_a ds of the nodes of a rod (Newton–Cotes).
fn shares(rod: &Rod) -> Vec<f64> {
    let weights: &[f64] = match rod.order {
        1 => &[0.5, 0.5],
        2 => &[1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0],
        _ => &[0.125, 0.375, 0.375, 0.125],
    };
    let (count, length) = (rod.num_nodes(), rod.length / rod.num_elements as f64);
    let mut all = vec![0.0; count];
    for element in 0..rod.num_elements {
        weights.iter().enumerate().for_each(|(a, weight)| all[(element * rod.order + a) % count] += weight * length);
    }
    all
}
