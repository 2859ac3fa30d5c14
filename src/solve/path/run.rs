//! Load stepping: runs the stages of a model with adaptive steps, each of which is brought to rest.

use std::ops::ControlFlow;

use crate::error::{InputError, SolveError};
use crate::scene::{Model, Ramp, Stage};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Status, StepReport};
use crate::solve::measures::NOTHING;
use crate::solve::options::Options;
use crate::solve::path::failure::Failure;
use crate::solve::path::given::Given;
use crate::solve::path::restart::{Place, Restart};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::search::timing::Instant;

/// Part of a step up to which two steps end at the same place, because fractions are sums of halves.
const SAME_STEP: f64 = 1e-6;

/// State after an accepted step, for the observer.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// What was given; `None` for states that no stages led to.
    pub given: Option<&'a Given>,
    /// The engine in the accepted state.
    pub engine: &'a Engine,
    /// Stage index.
    pub stage: usize,
    /// Accepted steps so far (0 = start state).
    pub step: usize,
    /// Fraction of the stage done.
    pub fraction: f64,
    /// The step's report.
    pub report: &'a StepReport,
    /// Wall time of the step, failed attempts included \[s\].
    pub seconds: f64,
}

/// Result of a run.
#[derive(Debug)]
#[must_use]
pub struct Solution {
    /// How it ended.
    pub status: Status,
    /// The solver in its last accepted state.
    pub solver: Solver,
    /// Accepted steps.
    pub num_steps: usize,
    /// Newton iterations in all, failed attempts included.
    pub iterations: usize,
    /// The attempt that ended the run, if it ended neither at its target nor because it was asked to.
    pub failure: Option<Failure>,
    /// What was given.
    pub given: Given,
}

/// An accepted state that a run may be taken up from.
#[derive(Debug)]
pub struct Waypoint<'a> {
    solver: &'a Solver,
    given: &'a Given,
    place: Place,
    settled: bool,
}

impl Waypoint<'_> {
    /// Where the run stands.
    pub fn place(&self) -> Place {
        self.place
    }

    /// The restart from here for [`run_from`]; `None` if the start state did not converge.
    pub fn restart(&self) -> Option<Restart> {
        self.settled.then(|| self.solver.to_restart(self.place, self.given))
    }
}

/// Callback for the start state and after every accepted step.
pub type Observer<'a> = dyn FnMut(&Progress, &Waypoint) -> ControlFlow<()> + 'a;

/// Runs all stages of a model; the observer is called for the start state (step 0) and after every accepted step.
///
/// # Errors
/// Bad input, or numbers that break down in a way that no smaller step mends. A run that does not converge is a
/// [`Status`] in the solution.
pub fn run(
    model: Model,
    stages: &[Stage],
    options: &Options,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Solution, RunError> {
    run_from(model, stages, options, None, &mut |progress, _| observer(progress))
}

/// As [`run`], with an observer that may keep a [`Restart`] of what it sees, or taking up a run where an earlier one
/// left it: with the same model, stages and options the steps that follow are the same, bit for bit, as if it had gone
/// on. The observer is not called again for the state the run is taken up from.
///
/// # Errors
/// As [`run`]; a restart that belongs to another model or other stages.
pub fn run_from(
    model: Model,
    stages: &[Stage],
    options: &Options,
    from: Option<Restart>,
    observer: &mut Observer,
) -> Result<Solution, RunError> {
    model.check_stages(stages)?;
    let given = Given::new(&model, stages, options);
    let solver = Solver::new(model, options.clone())?;
    let mut run = LoadStepping { solver, given, place: Place::start_of(0, 0, 0), failure: None, observer };
    let mut status = match from {
        None => run.find_start()?,
        Some(restart) => run.resume(restart, stages)?,
    };
    for (index, stage) in stages.iter().enumerate().skip(run.place.stage) {
        if status != Status::Converged {
            break;
        }
        if index > run.place.stage {
            run.place = Place::start_of(index, run.place.num_steps, run.place.iterations);
        }
        status = run.run_stage(stage)?;
    }
    let LoadStepping { solver, given, place, failure, .. } = run;
    Ok(Solution { status, solver, num_steps: place.num_steps, iterations: place.iterations, failure, given })
}

/// The solver in the state of a restart of a run of these stages; no step is taken.
///
/// # Errors
/// As [`run_from`].
pub fn solver_at(model: Model, stages: &[Stage], options: &Options, restart: Restart) -> Result<Solver, RunError> {
    model.check_stages(stages)?;
    let mut solver = Solver::new(model, options.clone())?;
    take_up(&mut solver, restart, stages)?;
    Ok(solver)
}

#[cfg(feature = "runs")]
impl Solution {
    /// The restart from the state in which a run of these stages ended, a last one whose path was followed included.
    pub(crate) fn restart(&self, stages: &[Stage]) -> Restart {
        let place =
            Place { fraction: 1.0, ..Place::start_of(stages.len().saturating_sub(1), self.num_steps, self.iterations) };
        self.solver.to_restart(place, &self.given)
    }
}

/// Why a run could not go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// Refused input.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Numbers that broke down.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// A run under way.
struct LoadStepping<'a, 'o> {
    solver: Solver,
    given: Given,
    /// Where it stands.
    place: Place,
    /// The attempt that ended it.
    failure: Option<Failure>,
    observer: &'a mut Observer<'o>,
}

/// Part of a stage that one attempt is to do.
struct Portion {
    /// Fractions of the stage, from where to where.
    span: [f64; 2],
    /// Fraction of the stage.
    size: f64,
    /// Fraction of the remaining change of each ramp.
    take: f64,
}

impl Portion {
    /// The next of at most `size` of the stage. After a step that was halved it ends where that one would have ended,
    /// on the grid of steps `full`.
    fn next(done: f64, size: f64, full: f64) -> Self {
        let planned = ((done / full + SAME_STEP).floor() + 1.0) * full - done;
        let size = size.min(planned);
        // ramps are measured from where they are
        let take = (size / (1.0 - done)).min(1.0);
        let take = if 1.0 - done - size < NOTHING { 1.0 } else { take };
        Self { span: [done, done + take * (1.0 - done)], size, take }
    }
}

impl LoadStepping<'_, '_> {
    /// Brings the start state to rest.
    fn find_start(&mut self) -> Result<Status, RunError> {
        let started = Instant::now();
        let mut report = self.solver.in_own_pool(|solver| solver.solve_step(&PrescribedMotion::default()));
        self.solver.judge_turning(&mut report);
        self.place.iterations = report.iterations;
        if let Some(error) = wrong_mesh(&report) {
            return Err(error.into());
        }
        let settled = report.status == Status::Converged;
        if settled {
            self.solver.remember(&report);
            self.solver.forget_path()?;
        } else if report.status != Status::Stopped {
            self.failure = Some(self.failure_of(&report));
        }
        Ok(if self.show(&report, started).is_break() { Status::Stopped } else { report.status })
    }

    /// Takes up a run where an earlier one left it.
    fn resume(&mut self, restart: Restart, stages: &[Stage]) -> Result<Status, RunError> {
        self.place = restart.place;
        self.given.held.extend(restart.held());
        take_up(&mut self.solver, restart, stages)?;
        Ok(Status::Converged)
    }

    /// Runs a stage from where it stands, in steps that are halved where they fail.
    fn run_stage(&mut self, stage: &Stage) -> Result<Status, RunError> {
        // of the whole stage, also where it is taken up half-way
        let rounds = self.solver.largest_round(&stage.ramps) / (1.0 - self.place.fraction) / Ramp::MAX_ROUND;
        let full = 1.0 / (stage.steps as f64).max((rounds - SAME_STEP).ceil());
        let mut size = self.place.step_size.min(full);
        self.solver.change_supports(&stage.supports)?;
        if self.place.fraction == 0.0 {
            self.solver.count_motions_anew(&stage.supports);
            self.given.note_held(&stage.supports, &self.solver.engine);
        }
        self.solver.note_numbers(&stage.ramps);
        let mut started = Instant::now();
        let mut failed_iterations = 0;
        while self.place.fraction < 1.0 - NOTHING {
            let portion = Portion::next(self.place.fraction, size, full);
            let snapshot = self.solver.snapshot();
            let mut report = self.solver.advance(&stage.ramps, portion.take);
            self.place.iterations += report.iterations;
            if report.status != Status::Converged {
                failed_iterations += report.iterations;
                size = 0.5 * portion.size;
                let gives_up = size < full * self.solver.options.min_step;
                let failed = gives_up && report.status != Status::Stopped;
                let failure = failed.then(|| self.failure_in(stage, &portion, &report));
                self.solver.restore(snapshot)?;
                self.failure = failure.map(|failure| failure.failing_from(&self.solver.engine));
                if report.status == Status::Stopped || gives_up {
                    return ending(&report, self.failure.as_ref());
                }
                continue;
            }
            size = (2.0 * size).min(full);
            self.place.fraction = portion.span[1];
            self.place.step_size = size;
            self.place.num_steps += 1;
            report.iterations += std::mem::take(&mut failed_iterations);
            self.solver.remember(&report);
            self.solver.forget_path()?;
            if self.show(&report, started).is_break() {
                return Ok(Status::Stopped);
            }
            started = Instant::now();
        }
        Ok(Status::Converged)
    }

    /// Calls the observer.
    fn show(&mut self, report: &StepReport, started: Instant) -> ControlFlow<()> {
        let (solver, place) = (&self.solver, self.place);
        let progress = Progress {
            given: Some(&self.given),
            engine: &solver.engine,
            stage: place.stage,
            step: place.num_steps,
            fraction: place.fraction,
            report,
            seconds: started.elapsed().as_secs_f64(),
        };
        let settled = report.status == Status::Converged;
        (self.observer)(&progress, &Waypoint { solver, given: &self.given, place, settled })
    }

    fn failure_of(&self, report: &StepReport) -> Failure {
        Failure::of(&self.solver.engine, report, &self.solver.options.newton)
    }

    fn failure_in(&self, stage: &Stage, portion: &Portion, report: &StepReport) -> Failure {
        let is_load = |ramp: &Ramp| matches!(ramp, Ramp::Load { .. } | Ramp::Pressure { .. });
        Failure {
            stage: Some(self.place.stage),
            span: portion.span,
            ramps_loads: stage.ramps.iter().any(is_load),
            ..self.failure_of(report)
        }
    }
}

/// Puts a solver in the state of a restart.
fn take_up(solver: &mut Solver, restart: Restart, stages: &[Stage]) -> Result<(), RunError> {
    let place = restart.place;
    for stage in stages.iter().take(place.stage) {
        solver.change_supports(&stage.supports)?;
    }
    if let Some(stage) = stages.get(place.stage).filter(|_| place.fraction > 0.0) {
        solver.change_supports(&stage.supports)?;
    }
    if place.stage >= stages.len().max(1) || !(0.0..=1.0).contains(&place.fraction) || place.step_size.is_nan() {
        let reason = format!("stands in stage {} at {}, which is no place on this path", place.stage, place.fraction);
        return Err(InputError::Inconsistent { field: "restart".to_owned(), reason }.into());
    }
    solver.take_over(restart)?;
    Ok(solver.forget_path()?)
}

/// How a run ends with an attempt that failed and is not halved any more.
fn ending(report: &StepReport, failure: Option<&Failure>) -> Result<Status, RunError> {
    if let Some(error) = wrong_mesh(report) {
        return Err(error.into());
    }
    let is_tight = failure.is_some_and(Failure::is_too_tight);
    Ok(match report.status {
        Status::BrokeDown | Status::MaxIterations | Status::Penetration if is_tight => Status::TooTight,
        Status::BrokeDown | Status::MaxIterations => Status::StepTooSmall,
        other => other,
    })
}

/// The error that no smaller step mends, because the mesh is too coarse or too fine.
fn wrong_mesh(report: &StepReport) -> Option<SolveError> {
    let is = |error: &SolveError| {
        matches!(error, SolveError::TooTwisted { .. } | SolveError::Memory { .. } | SolveError::Symbolic { .. })
    };
    report.error.clone().filter(is)
}
