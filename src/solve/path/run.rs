//! Load stepping: runs the stages of a model with adaptive steps, each of which is brought to rest.

use std::ops::ControlFlow;

use crate::error::{InputError, SolveError};
use crate::math::Vec3;
use crate::math::parallel::in_pool;
use crate::math::quaternion::exp;
use crate::scene::model::{RemainingPath, unit};
use crate::scene::{ContactLaw, Model, Pose, Ramp, Stage};
use crate::solve::Options;
use crate::solve::load_step::predictor::{History, lifted};
use crate::solve::load_step::step_report::{Status, StepReport};
use crate::solve::path::failure::Failure;
use crate::solve::path::restart::{Place, Restart};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::problem_size::ProblemSize;
use crate::solve::problem::state::{Moved, PrescribedMotion, State, Target};
use crate::solve::search::newton::Workspace;
use crate::solve::search::timing::{Instant, Timings};

/// State after an accepted step, for the observer.
#[derive(Debug)]
pub struct Progress<'a> {
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
}

/// Engine and workspace: finds equilibria one after the other.
#[derive(Debug)]
pub struct Solver {
    pub(crate) engine: Engine,
    pub(crate) workspace: Workspace,
    pub(crate) options: Options,
    /// Motions of supports so far.
    pub(crate) moved: Moved,
    /// The attempt that ended the run.
    pub(crate) failure: Option<Failure>,
    /// The last accepted states, for predictions.
    pub(crate) history: History,
}

/// An accepted state that a run may be taken up from.
#[derive(Debug)]
pub struct Waypoint<'a> {
    solver: &'a Solver,
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
        self.settled.then(|| self.solver.to_restart(self.place))
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
    let mut solver = Solver::new(model, options.clone())?;
    let (mut place, mut status) = match from {
        None => solver.run_start(observer)?,
        Some(restart) => {
            let place = restart.place;
            for stage in stages.iter().take(place.stage) {
                solver.change_supports(&stage.ramps)?;
            }
            if let Some(stage) = stages.get(place.stage).filter(|_| place.fraction > 0.0) {
                solver.change_supports(&stage.ramps)?;
            }
            if place.stage >= stages.len().max(1) || !(0.0..=1.0).contains(&place.fraction) || place.step_size.is_nan()
            {
                let reason =
                    format!("stands in stage {} at {}, which is no place on this path", place.stage, place.fraction);
                return Err(InputError::Inconsistent { field: "restart".to_owned(), reason }.into());
            }
            solver.take_over(restart)?;
            solver.forget_the_way()?;
            (place, Status::Converged)
        }
    };
    for (index, stage) in stages.iter().enumerate().skip(place.stage) {
        if status != Status::Converged {
            break;
        }
        if index > place.stage {
            place = Place::start_of(index, place.num_steps, place.iterations);
        }
        status = solver.run_stage(stage, &mut place, observer)?;
    }
    let failure = solver.failure.take();
    Ok(Solution { status, solver, num_steps: place.num_steps, iterations: place.iterations, failure })
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

impl Solver {
    /// Builds the engine.
    ///
    /// # Errors
    /// Refused input; a rod so far from the origin that rounding moves its nodes by a thousandth of their spacing.
    pub fn new(model: Model, options: Options) -> Result<Self, InputError> {
        options.check()?;
        let engine = Engine::new(model, options.threads)?;
        engine.check_resolution()?;
        Ok(Self {
            engine,
            workspace: Workspace::default(),
            options,
            moved: Moved::default(),
            failure: None,
            history: History::default(),
        })
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Brings the present state to a stable equilibrium under the present loads, from where it is: as
    /// [`Solver::step_to`] without ramps, but not predicted from earlier steps.
    pub fn find_equilibrium(&mut self) -> StepReport {
        self.solve_step(&PrescribedMotion::default())
    }

    /// Changes the contact law, for example to raise a penalty in steps; offsets are kept for the augmented Lagrangian
    /// and dropped for a penalty.
    ///
    /// # Errors
    /// A law out of range; a change from or to no contact, which needs a new solver.
    pub fn set_contact_law(&mut self, law: ContactLaw) -> Result<(), InputError> {
        self.engine.set_contact_law(law)
    }

    /// Replaces the configuration: by a start shape of one's own, or by the state of the same rods under other loads or
    /// supports.
    ///
    /// # Errors
    /// `InputError::Inconsistent` when the sizes do not match the model.
    pub fn set_state(&mut self, state: State) -> Result<(), InputError> {
        self.engine.set_state(state)
    }

    /// Sizes of the problem with the contact candidates of the present state; analyses the pattern of the tangent anew,
    /// which takes about as long as a Newton iteration.
    ///
    /// # Errors
    /// Contact geometry that breaks down, a factorisation that does not fit into memory.
    pub fn problem_size(&mut self) -> Result<ProblemSize, SolveError> {
        self.engine.problem_size()
    }

    /// The solver's options.
    pub fn options_mut(&mut self) -> &mut Options {
        &mut self.options
    }

    /// Moves all ramps to their targets in one step, without cut-back, from the present state; without ramps, settles.
    ///
    /// # Errors
    /// Ramps that do not fit the model, a [`Ramp::RotationAbout`] or a [`Ramp::Pose`] by more than [`Ramp::MAX_ROUND`].
    pub fn step_to(&mut self, ramps: &[Ramp]) -> Result<StepReport, InputError> {
        if !ramps.is_empty() {
            self.engine.model.check_stages(&[Stage { ramps: ramps.to_vec(), steps: 1 }])?;
        }
        self.change_supports(ramps)
            .map_err(|error| InputError::Inconsistent { field: "ramp".to_owned(), reason: error.to_string() })?;
        self.note_numbers(ramps);
        let round = self.largest_round(ramps);
        let allowed = "at most Ramp::MAX_ROUND (1/12) from where it is: go in more steps";
        InputError::check("ramp.rotation.turns", round, round <= Ramp::MAX_ROUND + 1e-9, allowed)?;
        let target = self.target(ramps, 1.0);
        let report = self.attempt(&target);
        if report.status == Status::Converged {
            self.remember(&report);
        }
        Ok(report)
    }

    /// Where the time of all searches of this solver went.
    pub fn timings(&self) -> Timings {
        self.workspace.timings
    }

    /// Number of unstable directions at the present state.
    ///
    /// # Errors
    /// When the tangent cannot be factorised.
    pub fn num_unstable(&mut self) -> Result<usize, SolveError> {
        self.workspace.count_unstable(&mut self.engine)
    }

    /// Brings the start state to rest.
    fn run_start(&mut self, observer: &mut Observer) -> Result<(Place, Status), RunError> {
        let started = Instant::now();
        let mut report = self.in_own_pool(|solver| solver.solve_step(&PrescribedMotion::default()));
        self.judge_turning(&mut report);
        let place = Place::start_of(0, 0, report.iterations);
        let settled = report.status == Status::Converged;
        if settled {
            self.remember(&report);
            self.forget_the_way()?;
        } else if report.status != Status::Stopped {
            self.failure = Some(Failure::of(&self.engine, &report, &self.options.newton));
        }
        let progress = Progress {
            engine: &self.engine,
            stage: 0,
            step: 0,
            fraction: 0.0,
            report: &report,
            seconds: started.elapsed().as_secs_f64(),
        };
        let seen = observer(&progress, &Waypoint { solver: self, place, settled });
        Ok((place, if seen.is_break() { Status::Stopped } else { report.status }))
    }

    fn run_stage(&mut self, stage: &Stage, place: &mut Place, observer: &mut Observer) -> Result<Status, RunError> {
        // of the whole stage, also where it is taken up half-way
        let rounds = self.largest_round(&stage.ramps) / (1.0 - place.fraction) / Ramp::MAX_ROUND;
        let full = 1.0 / (stage.steps as f64).max((rounds - 1e-6).ceil());
        let mut size = place.step_size.min(full);
        self.change_supports(&stage.ramps)?;
        self.note_numbers(&stage.ramps);
        let mut started = Instant::now();
        let mut failed_iterations = 0;
        while place.fraction < 1.0 - 1e-12 {
            let done = place.fraction;
            // of the rest: ramps are measured from where they are
            // after a step that was halved the next ends where it would have ended
            let planned = ((done / full + 1e-6).floor() + 1.0) * full - done;
            let here = size.min(planned);
            let take = (here / (1.0 - done)).min(1.0);
            let take = if 1.0 - done - here < 1e-9 { 1.0 } else { take };
            let snapshot = self.snapshot();
            let target = self.target(&stage.ramps, take);
            let advance = take * (1.0 - done);
            let mut report = self.attempt(&target);
            place.iterations += report.iterations;
            if report.status != Status::Converged {
                failed_iterations += report.iterations;
                size = 0.5 * here;
                let gives_up = size < full * self.options.min_step;
                let failed = gives_up && report.status != Status::Stopped;
                let failure = failed.then(|| Failure::of(&self.engine, &report, &self.options.newton));
                self.restore(snapshot)?;
                if let Some(failure) = failure {
                    let is_load = |ramp: &Ramp| matches!(ramp, Ramp::Load { .. } | Ramp::Pressure { .. });
                    let ramps_loads = stage.ramps.iter().any(is_load);
                    let (stage, span) = (Some(place.stage), [done, done + advance]);
                    let failure = failure.from_state(&self.engine);
                    self.failure = Some(Failure { stage, span, ramps_loads, ..failure });
                }
                if report.status == Status::Stopped || gives_up {
                    if let Some(error @ SolveError::TooTwisted { .. }) = report.error {
                        return Err(error.into()); // what is wrong is the mesh
                    }
                    let tight = self.failure.as_ref().is_some_and(|failure| failure.bend.is_some());
                    return Ok(match report.status {
                        Status::BrokeDown | Status::MaxIterations | Status::Penetration if tight => Status::TooTight,
                        Status::BrokeDown | Status::MaxIterations => Status::StepTooSmall,
                        other => other,
                    });
                }
                continue;
            }
            size = (2.0 * size).min(full);
            place.fraction += advance;
            place.step_size = size;
            place.num_steps += 1;
            report.iterations += std::mem::take(&mut failed_iterations);
            self.remember(&report);
            self.forget_the_way()?;
            let progress = Progress {
                engine: &self.engine,
                stage: place.stage,
                step: place.num_steps,
                fraction: place.fraction,
                report: &report,
                seconds: started.elapsed().as_secs_f64(),
            };
            if observer(&progress, &Waypoint { solver: self, place: *place, settled: true }).is_break() {
                return Ok(Status::Stopped);
            }
            started = Instant::now();
        }
        Ok(Status::Converged)
    }

    /// Adds the accepted state to those from which the next one is predicted.
    fn remember(&mut self, report: &StepReport) {
        if report.escapes > 0 {
            self.history.clear();
        }
        self.history.push(&self.engine.state, &self.moved);
    }

    fn turns_left(&self, node: usize, to: f64) -> f64 {
        to - self.moved.turned.get(&node).copied().unwrap_or(0.0)
    }

    /// The way from where a node is to a pose.
    fn way_left(&self, node: usize, pose: &Pose) -> RemainingPath {
        let state = &self.engine.state;
        let turned = self.moved.turned.get(&node).copied().unwrap_or(0.0);
        pose.remaining_path(&state.positions[node], &state.remainders[node], &state.frames[node], turned)
    }

    /// Turns by which the ramps will carry a node round an axis or to a pose, at most.
    fn largest_round(&self, ramps: &[Ramp]) -> f64 {
        let round = |ramp: &Ramp| match ramp {
            Ramp::RotationAbout { node, to, .. } => {
                self.turns_left(self.engine.first_node[node.rod] + node.node, *to).abs()
            }
            Ramp::Pose { node, pose } => {
                let way = self.way_left(self.engine.first_node[node.rod] + node.node, pose);
                way.rotation.norm() / std::f64::consts::TAU
            }
            _ => 0.0,
        };
        ramps.iter().map(round).fold(0.0, f64::max)
    }

    /// The target when every ramp takes the fraction `take` of its remaining change.
    fn target(&self, ramps: &[Ramp], take: f64) -> Target {
        let mut target = Target::default();
        let node_of = |n: &crate::scene::NodeRef| self.engine.first_node[n.rod] + n.node;
        for ramp in ramps {
            match ramp {
                Ramp::ExcessLink { rod, to } => {
                    let seams = &mut target.drive.seams;
                    seams.resize(self.engine.model.rods.len(), 0.0);
                    let link = to + self.engine.model.rods[*rod].natural_link();
                    seams[*rod] = (link * std::f64::consts::TAU - self.engine.state.seams[*rod]) * take;
                }
                Ramp::Rotation { node, axis, to } => {
                    let node = node_of(node);
                    let change = self.turns_left(node, *to) * take;
                    let vector = unit(axis) * (change * std::f64::consts::TAU);
                    target.drive.nodes.push((node, Vec3::zeros(), vector));
                    target.turned.push((node, change));
                }
                Ramp::RotationAbout { node, axis, through, to } => {
                    let node = node_of(node);
                    let change = self.turns_left(node, *to) * take;
                    let vector = unit(axis) * (change * std::f64::consts::TAU);
                    let state = &self.engine.state;
                    let displaced = self.moved.displaced.get(&node).copied().unwrap_or_default();
                    let arm = (state.positions[node] - through - displaced) + state.remainders[node];
                    target.drive.nodes.push((node, exp(&vector) * arm - arm, vector));
                    target.turned.push((node, change));
                }
                Ramp::Displacement { node, to } => {
                    let node = node_of(node);
                    let change = (to - self.moved.displaced.get(&node).copied().unwrap_or_default()) * take;
                    target.drive.nodes.push((node, change, Vec3::zeros()));
                    target.displaced.push((node, change));
                }
                Ramp::Pose { node, pose } => {
                    let node = node_of(node);
                    let (position, way) = (self.engine.state.positions[node], self.way_left(node, pose));
                    target.drive.nodes.push((node, way.displacement(take), way.rotation * take));
                    if way.turns != 0.0 {
                        // a second motion of the node: the rod takes it by itself, being about its tangent
                        let angle = way.turns * take * std::f64::consts::TAU;
                        let tangent = self.engine.state.frames[node] * Vec3::z();
                        target.drive.nodes.push((node, Vec3::zeros(), tangent * angle));
                        target.turned.push((node, way.turns * take));
                    }
                    target.posed.push((node, way.controls(&position).map(|v| v * take)));
                }
                Ramp::Load { to } => {
                    let now = self.engine.state.load_factor;
                    target.load_factor = Some(now + (to - now) * take);
                }
                Ramp::Pressure { rod, to } => {
                    let now = self.engine.state.pressures[*rod];
                    target.pressures.push((*rod, now + (to - now) * take));
                }
                Ramp::Plane { plane, to } => {
                    let now = self.engine.state.plane_heights[*plane];
                    target.plane_heights.push((*plane, now + (to - now) * take));
                }
                Ramp::Number { rod, which, to } => {
                    let now = self.engine.model.rods[*rod].number(*which);
                    target.numbers.insert((*rod, *which), if take == 1.0 { *to } else { now + (to - now) * take });
                }
                // done before the stage's first step
                Ramp::Hold(_) | Ramp::Release(_) => {}
            }
        }
        target
    }

    /// A state whose elements may have taken the other way round is no equilibrium of the rod.
    fn judge_turning(&self, report: &mut StepReport) {
        if report.status != Status::Converged {
            return;
        }
        if let Err(error) = self.engine.check_turning() {
            (report.status, report.error) = (Status::BrokeDown, Some(error));
        }
    }

    /// Runs `work` in the solver's own pool, if it has one, because to enter the pool for every sum takes longer than a
    /// small sum.
    fn in_own_pool<R: Send>(&mut self, work: impl FnOnce(&mut Self) -> R + Send) -> R {
        let pool = self.engine.pool.take();
        let result = in_pool(pool.as_ref(), || work(self));
        self.engine.pool = pool;
        result
    }

    fn attempt(&mut self, target: &Target) -> StepReport {
        let spun = lifted(&self.engine, &self.engine.state, &target.drive).spun;
        if let Err(error) = self.engine.check_spun(&target.drive.seams, &spun) {
            return StepReport::refused(error);
        }
        let predicted = self.history.predict(&self.engine, target).or_else(|| self.unforeseen(target));
        target.load(&mut self.engine.state);
        if let Err(error) = self.engine.take_numbers() {
            return StepReport::refused(SolveError::Symbolic { reason: error.to_string() });
        }
        let mut report = self.in_own_pool(|solver| solver.solve_step_along(&target.drive, predicted));
        self.judge_turning(&mut report);
        if report.status == Status::Converged {
            self.moved.go_on(target, &spun);
        }
        report
    }
}
