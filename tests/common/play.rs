//! Scenes run within a limit of time, counted and checked: what `benches/families.rs`, `benches/standard.rs` and the
//! tests of the families print and judge by.

#![allow(dead_code)] // every user takes its part
#![allow(clippy::unwrap_used, clippy::expect_used)] // helpers of tests

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use supercoil::io::run::options;
use supercoil::observe::report::Observation;
use supercoil::observe::{EndLinks, observe};
use supercoil::scene::{ContactLaw, NodeRef, Ramp, Scene, Stage};
use supercoil::solve::{Engine, Interrupt, Progress, RunError, Solution, Status, StepReport, run_from};

use super::knots::Topology;

/// Largest difference of a closed rod's link from what was prescribed, turns.
const TOL_LINK: f64 = 1e-6;
/// Overlap that rounding may leave beside the tolerance of the contact law, over the smallest contact radius.
const TOL_GAP: f64 = 1e-6;
/// Largest force out of balance at rest, over the largest sum of contributions.
const TOL_BALANCE: f64 = 1e-4;

/// How a run went: a row of the table of all runs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Family, or another name for what is run.
    pub family: String,
    /// Case in the family.
    pub case: String,
    /// Came to rest at the end of all stages, and the checks found nothing.
    pub passed: bool,
    /// How the run ended, in the solver's words, or "out of time", "panicked", "refused".
    pub status: String,
    /// Accepted load steps, and those of the plan.
    pub steps: usize,
    pub planned: usize,
    /// Newton iterations, failed attempts included; those on coarser meshes and shorter rods.
    pub iterations: usize,
    pub elsewhere: usize,
    /// Newton iterations of the start, before any load step.
    pub start: usize,
    /// Load steps halved.
    pub cutbacks: usize,
    /// Time it took, see [`Clock`].
    pub seconds: f64,
    /// Of the last accepted state: energy, smallest gap over the smallest contact radius, contact sites, forces out of
    /// balance over what there is, largest curvature times contact radius, difference of link from what was prescribed.
    pub energy: f64,
    pub gap: Option<f64>,
    pub sites: usize,
    pub residual: f64,
    pub tightness: f64,
    pub link_error: Option<f64>,
    /// Knots and links of the last accepted state are those of the first.
    pub topology_kept: Option<bool>,
    /// Why the run did not pass.
    pub reason: String,
    /// Newton iterations of each accepted load step, the failed attempts before it included; separated by blanks.
    pub per_step: String,
}

impl Row {
    /// Newton iterations of each accepted load step.
    pub fn steps_taken(&self) -> Vec<usize> {
        self.per_step.split_whitespace().filter_map(|text| text.parse().ok()).collect()
    }

    fn refused(mut self, status: &str, reason: String) -> Self {
        (self.status, self.reason, self.passed) = (status.to_owned(), reason, false);
        self
    }
}

/// What is left in the hands of those who want to check more.
pub struct Played {
    pub row: Row,
    /// The last accepted state.
    pub seen: Option<Observation>,
}

/// How time is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Time of the processor that the whole process takes: other work on the machine does not count, other runs in the
    /// process do. Wall time where the system does not tell.
    Processor,
    /// Wall time.
    Wall,
}

/// Time since it was made.
#[derive(Debug, Clone, Copy)]
pub struct Watch {
    clock: Clock,
    started: Instant,
    before: Option<f64>,
}

impl Watch {
    pub fn new(clock: Clock) -> Self {
        Self { clock, started: Instant::now(), before: processor() }
    }

    pub fn seconds(&self) -> f64 {
        match (self.clock, self.before, processor()) {
            (Clock::Processor, Some(before), Some(now)) => now - before,
            _ => self.started.elapsed().as_secs_f64(),
        }
    }
}

/// Seconds of the processor that the process has taken so far, in hundredths, where the system tells them.
fn processor() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |k: usize| fields.get(k)?.parse::<f64>().ok();
    Some(0.01 * (ticks(11)? + ticks(12)?))
}

/// How long a run may take.
#[derive(Debug, Clone, Copy)]
pub struct Limit {
    pub seconds: f64,
    pub clock: Clock,
}

/// How often a run's time is looked at.
const TICK: Duration = Duration::from_millis(50);

/// Raises `interrupt` if `work` takes longer than its time.
fn within<R>(limit: f64, watch: Watch, interrupt: &Interrupt, work: impl FnOnce() -> R) -> R {
    let (done, wait) = channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || {
            while wait.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
                if watch.seconds() > limit {
                    return interrupt.raise();
                }
            }
        });
        let result = work();
        drop(done);
        result
    })
}

/// Size of a full step of each stage, in fractions of it: rotations about an axis may want more steps than were asked.
fn full_steps(stages: &[Stage]) -> Vec<f64> {
    let mut turned: BTreeMap<NodeRef, f64> = BTreeMap::new();
    let of_stage = |stage: &Stage| {
        let mut round = 0.0f64;
        for ramp in &stage.ramps {
            if let Ramp::RotationAbout { node, to, .. } | Ramp::Rotation { node, to, .. } = ramp {
                let before = turned.insert(*node, *to).unwrap_or(0.0);
                if matches!(ramp, Ramp::RotationAbout { .. }) {
                    round = round.max((to - before).abs());
                }
            }
        }
        1.0 / (stage.steps as f64).max((round / Ramp::MAX_ROUND - 1e-6).ceil())
    };
    stages.iter().map(of_stage).collect()
}

/// Counts along the way.
struct Counter {
    full: Vec<f64>,
    /// Stage, fraction and size of the last accepted step.
    stage: usize,
    fraction: f64,
    size: f64,
    cutbacks: usize,
    elsewhere: usize,
    start: usize,
    per_step: Vec<usize>,
    iterations: usize,
    last: Option<StepReport>,
}

impl Counter {
    fn new(full: Vec<f64>) -> Self {
        let size = full.first().copied().unwrap_or(1.0);
        Self {
            full,
            size,
            stage: 0,
            fraction: 0.0,
            cutbacks: 0,
            elsewhere: 0,
            start: 0,
            per_step: Vec::new(),
            iterations: 0,
            last: None,
        }
    }

    /// Halvings between the step first tried and one of size `taken`.
    fn halvings(&self, taken: f64) -> usize {
        let tried = (2.0 * self.size).min(self.full[self.stage]).min(1.0 - self.fraction);
        (tried / taken).log2().round().max(0.0) as usize
    }

    fn enter(&mut self, stage: usize) {
        if stage != self.stage {
            (self.stage, self.fraction) = (stage, 0.0);
            self.size = self.full[stage];
        }
    }

    fn accepted(&mut self, progress: &Progress, iterations: usize) {
        self.elsewhere += progress.report.iterations_on_other_meshes;
        if progress.step == 0 {
            self.start = iterations;
        } else {
            self.enter(progress.stage);
            let taken = progress.fraction - self.fraction;
            self.cutbacks += self.halvings(taken);
            (self.fraction, self.size) = (progress.fraction, taken);
            self.per_step.push(iterations - self.iterations);
        }
        self.iterations = iterations;
        self.last = Some(progress.report.clone());
    }
}

/// Runs a scene on one thread, for at most so long, and checks what it comes to.
pub fn play(family: &str, case: &str, scene: Scene, limit: Limit) -> Played {
    play_watched(family, case, scene, limit, &mut |_| {})
}

/// As [`play`]; `watch` sees every accepted step.
pub fn play_watched(family: &str, case: &str, scene: Scene, limit: Limit, watch: &mut dyn FnMut(&Progress)) -> Played {
    let full = full_steps(&scene.stages);
    let planned = full.iter().map(|size| size.recip().round() as usize).sum();
    let row = Row { family: family.to_owned(), case: case.to_owned(), planned, ..Row::default() };
    let mut options = options(&scene);
    options.threads = Some(1);
    let interrupt = Interrupt::default();
    options.newton.interrupt = interrupt.clone();
    let law = scene.model.contact.law;
    let targets = link_targets(&scene);
    let ends = EndLinks::new(&scene.model, &scene.stages);
    let mut start: Option<Observation> = None;
    let before = Engine::new(scene.model.clone(), Some(1)).ok().map(|engine| Topology::of(&engine));
    let mut counter = Counter::new(full);
    let clock = Watch::new(limit.clock);
    let result = within(limit.seconds, clock, &interrupt, || {
        catch_unwind(AssertUnwindSafe(|| {
            run_from(scene.model, &scene.stages, &options, None, &mut |progress, waypoint| {
                counter.accepted(progress, waypoint.place().iterations);
                start.get_or_insert_with(|| observe(progress));
                watch(progress);
                ControlFlow::Continue(())
            })
        }))
    });
    let row = Row {
        seconds: clock.seconds(),
        steps: counter.per_step.len(),
        start: counter.start,
        elsewhere: counter.elsewhere,
        iterations: counter.iterations,
        cutbacks: counter.cutbacks,
        per_step: counter.per_step.iter().map(usize::to_string).collect::<Vec<_>>().join(" "),
        ..row
    };
    let solution = match result {
        Err(_) => return Played { row: row.refused("panicked", "the solver panicked".to_owned()), seen: None },
        Ok(Err(error @ RunError::Input(_))) => {
            return Played { row: row.refused("refused", error.to_string()), seen: None };
        }
        Ok(Err(error)) => return Played { row: row.refused("numbers broke down", error.to_string()), seen: None },
        Ok(Ok(solution)) => solution,
    };
    let due = Due { before: before.as_ref(), law, targets, ends, start };
    judge(row, &solution, &mut counter, &due, interrupt.is_raised())
}

/// What a state is judged by.
struct Due<'a> {
    before: Option<&'a Topology>,
    law: ContactLaw,
    /// See [`link_targets`].
    targets: BTreeMap<usize, f64>,
    ends: EndLinks,
    start: Option<Observation>,
}

/// Excess link that each closed rod must have in the end, where the scene prescribes it.
fn link_targets(scene: &Scene) -> BTreeMap<usize, f64> {
    let ramps = scene.stages.iter().flat_map(|stage| &stage.ramps);
    ramps.filter_map(|ramp| if let Ramp::ExcessLink { rod, to } = ramp { Some((*rod, *to)) } else { None }).collect()
}

fn judge(mut row: Row, solution: &Solution, counter: &mut Counter, due: &Due, out_of_time: bool) -> Played {
    row.iterations = solution.iterations;
    row.status = solution.status.to_string();
    if let Some(failure) = &solution.failure {
        if let Some(stage) = failure.stage {
            counter.enter(stage);
            row.cutbacks += counter.halvings(failure.span[1] - failure.span[0]) + 1;
        }
        row.reason = failure.to_string();
    }
    let engine = solution.solver.engine();
    let Some(report) = &counter.last else { return Played { row, seen: None } };
    let seen = observe(&Progress {
        given: Some(&solution.given),
        engine,
        stage: counter.stage,
        step: row.steps,
        fraction: 1.0,
        report,
        seconds: row.seconds,
    });
    let radii = engine.model().rods.iter().map(|rod| rod.section.contact_radius).filter(|r| *r > 0.0);
    let smallest = radii.fold(f64::INFINITY, f64::min);
    row.energy = seen.energies.total - seen.energies.contact;
    row.gap = seen.contact_gap.map(|gap| gap.lower / smallest);
    row.sites = seen.num_sites;
    row.residual = engine.relative_residual();
    let rods = engine.model().rods.iter().enumerate();
    row.tightness =
        rods.map(|(k, rod)| engine.largest_curvature(k)[0] * rod.section.contact_radius).fold(0.0, f64::max);
    let converged = solution.status == Status::Converged;
    let link_due = |rod: usize, prescribed: f64| {
        if converged { due.targets.get(&rod).copied().unwrap_or(prescribed) } else { prescribed }
    };
    let natural = |rod: usize| engine.model().rods[rod].natural_link();
    let off =
        seen.links.iter().map(|link| (link.link - natural(link.rod) - link_due(link.rod, link.excess_link)).abs());
    row.link_error = off.reduce(f64::max);
    row.topology_kept = due.before.map(|before| before.is_kept_in(&Topology::of(engine)));
    if out_of_time && solution.status == Status::Stopped {
        row.status = "out of time".to_owned();
        let (stage, done) = (counter.stage + 1, 100.0 * counter.fraction);
        row.reason = format!("stage {stage} at {done:.1} % when time was up");
    } else if converged {
        row.reason = objections(&row, due, &seen).join("; ");
        row.passed = row.reason.is_empty();
    }
    Played { row, seen: Some(seen) }
}

/// Whether a number is small enough; one that is no number is not.
pub fn within_limit(x: f64, limit: f64) -> bool {
    x <= limit
}

/// What speaks against a state that the solver calls converged.
fn objections(row: &Row, due: &Due, seen: &Observation) -> Vec<String> {
    let mut found = due.ends.notes(seen, due.start.as_ref());
    let left = match due.law {
        ContactLaw::AugmentedLagrangian { tol_penetration, .. } | ContactLaw::ByMesh { tol_penetration, .. } => {
            tol_penetration
        }
        _ => f64::INFINITY,
    };
    // what a run only notes, the rounded end of a rod beside itself, is no overlap of tubes
    if let Some(gap) = row.gap.filter(|gap| *gap < -(2.0 * left + TOL_GAP) && seen.overlaps()) {
        found.push(format!("strands are {:.1e} contact radii inside each other", -gap));
    }
    if let Some(error) = row.link_error.filter(|error| !within_limit(*error, TOL_LINK)) {
        found.push(format!("link is off by {error:.1e}"));
    }
    if row.topology_kept == Some(false) {
        found.push("a knot or link has changed".to_owned());
    }
    if !within_limit(row.residual, TOL_BALANCE) {
        found.push(format!("forces are out of balance by {:.1e}", row.residual));
    }
    if row.tightness > 1.0 {
        found.push(format!("bent {:.2} times as tightly as a contact radius allows", row.tightness));
    }
    if seen.num_unstable > 0 {
        found.push(format!("{} unstable directions", seen.num_unstable));
    }
    found
}
