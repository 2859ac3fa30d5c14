//! The trust-region search: Newton steps that the potential confirms.
//!
//! A rod is nearly inextensible and contact is nearly rigid: both confine the motion to a curved surface in the space
//! of configurations. A straight Newton step leaves that surface by second order, which the large stiffnesses turn into
//! a potential that does not measure the step (Maratos effect). So each step Δ is first brought back: with e = ε(x ⊕
//! Δ) − ε(x) − BΔ the strain it made beyond its linear prediction and s the forces of gaps that did the same, it is
//! corrected by −K⁻¹(BᵀC e + s) on the factorisation at hand, a few times. After that the potential is meaningful and
//! the step is accepted like any trust-region step, by comparing its decrease with the model's. Where contact opens or
//! closes along the step the corrections may not converge; then the state of lowest potential among them is taken if it
//! lies low enough. The trust region is a radius in rotations and in sliding at contacts, held by the shift τ in K +
//! τM: at least so large that no negative eigenvalue is left, larger until the step is within the radius. Then the step
//! goes on, along what the shift held back, to where the quadratic model is lowest within the radius: a shift that one
//! unstable direction asks for would keep all others short, and a valley that hardly falls takes hundreds of steps
//! where a few will do.
//!
//! A search continues as long as it gets anywhere ([`progress`]).

mod convergence;
mod corrected_step;
mod progress;
mod radius;
mod step;

use crate::error::SolveError;
use crate::rod::element::Stress;
use crate::solve::measures::HALVINGS;
use crate::solve::problem::assembly::{Potential, Residual};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::moment_load::work_of_moments;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::State;
use crate::solve::search::newton::{Iteration, NewtonReport, SearchOptions, increment_size, relative_residual};
use crate::solve::search::workspace::{Workspace, neutral_shift};
use convergence::{Accepted, Convergence};
use corrected_step::{CorrectedStep, StepStart};
use progress::SearchProgress;
use radius::{LARGEST, StepOutcome, TrustRegion};
use step::ModelStep;

/// Smallest fraction that is tried of a step which supports push, because less is no motion on a mesh.
const SHORTEST_PUSH: f64 = 1e-3;

/// Fractions of a step that are tried before the shift is raised, because a fraction costs an evaluation, a shift a
/// factorisation.
const SHORTER: [f64; 3] = [0.5, 0.2, 0.06];
/// Factor on the shift after a rejected step, at least, and by which the radius shrinks, because a step that is hardly
/// shorter is rejected again.
const RAISING: f64 = 4.0;
/// Decrease of the potential, over the expected one, with which a step is accepted. With 0.1 instead, a rod a million
/// times as long as thick does not converge under its whole load at once.
const LEAST: f64 = 0.05;

/// State of a search.
struct Search {
    state: State,
    /// Stresses of the next linearisation, three per element.
    stress: Vec<[Stress; 3]>,
    /// Remaining part of prescribed motions.
    remaining: f64,
    trust: TrustRegion,
    rest: Convergence,
    progress: SearchProgress,
    /// Steps rejected or stuck in a row.
    rejections: usize,
    report: NewtonReport,
}

/// How an attempt to go on from a state ends.
enum Advance {
    /// With an accepted step, or at rest.
    Done,
    /// Without any step that the potential confirms.
    NoFarther,
    Interrupted,
}

impl Search {
    fn new(engine: &Engine, drive: &PrescribedMotion, options: &SearchOptions) -> Self {
        let newton = &options.newton;
        let state = engine.state().clone();
        let stress = engine.stress_with(&state, options.forces);
        let remaining = if drive.nodes.is_empty() { 0.0 } else { 1.0 };
        let progress = SearchProgress::new(newton.max_iterations, &state);
        let rest = Convergence::new(newton.tol_increment, options.rough);
        Self {
            state,
            stress,
            remaining,
            trust: TrustRegion::new(options.uncertainty),
            rest,
            progress,
            rejections: 0,
            report: NewtonReport::default(),
        }
    }

    /// The potential at a state of the search, less the work of moments on the way.
    fn potential(&self, residual: &Residual) -> Potential {
        Potential { load: residual.potential.load - self.report.work, ..residual.potential }
    }

    /// Whether supports are still to move. Their motion does work, so the potential may rise.
    fn is_pushed(&self) -> bool {
        self.remaining > 0.0
    }

    /// Whether a trial decreases the potential enough (or, where supports push, its corrections shrank) and takes no
    /// strand through another.
    fn accepts(
        &self,
        engine: &mut Engine,
        residual: &Residual,
        trial: &CorrectedStep,
        size: f64,
    ) -> Result<bool, SolveError> {
        let acceptable = if trial.is_rounding(size) {
            true
        } else if self.is_pushed() {
            trial.settled
        } else {
            gain(residual, trial) >= LEAST * trial.expected - residual.rounding
        };
        Ok(acceptable && (trial.rounds == 0 || engine.keeps_apart(&self.state, &trial.increment)?))
    }
}

impl Workspace {
    /// Searches for an equilibrium. Below the potential `options.leaving` the search ends, not converged.
    pub(crate) fn trust_region_search(
        &mut self,
        engine: &mut Engine,
        drive: &PrescribedMotion,
        options: &SearchOptions,
    ) -> Result<NewtonReport, SolveError> {
        let floor = options.leaving.unwrap_or(f64::NEG_INFINITY);
        let mut search = Search::new(engine, drive, options);
        // a search knows nothing of the one before
        self.softest.clear();
        while !search.report.converged && !search.progress.is_over() {
            self.refresh(engine, &search.state)?;
            let drive_now = drive.scaled(search.remaining);
            let residual = self.linearise(engine, &search.state, &search.stress, &drive_now);
            if let Some(rod) = engine.falling_for_ever(&search.state, &residual) {
                return Err(SolveError::Falls { rod: engine.model.rods[rod].name.clone() });
            }
            let potential = search.potential(&residual);
            if potential.total() < floor {
                break;
            }
            // without a potential a search may go round in circles, on each of which moments do work
            let potential = if engine.is_conservative() { potential.total() } else { 0.0 };
            search.progress.see(engine, &search.state, &residual, (potential, search.remaining));
            match self.advance(engine, &mut search, (&residual, &drive_now), options)? {
                Advance::Done => {}
                Advance::NoFarther => break,
                Advance::Interrupted => return Ok(NewtonReport { interrupted: true, ..search.report }),
            }
        }
        self.end(engine, options, search)
    }

    /// Tries steps, each shorter than the one before, until one is accepted.
    fn advance(
        &mut self,
        engine: &mut Engine,
        search: &mut Search,
        (residual, drive): (&Residual, &PrescribedMotion),
        options: &SearchOptions,
    ) -> Result<Advance, SolveError> {
        let unbalanced = relative_residual(engine, residual);
        let mut longest = 1.0;
        // no step knows the shift of the one before: contact that was put right asks for none any more
        self.shift = 0.0;
        loop {
            if options.newton.interrupt.is_raised() {
                return Ok(Advance::Interrupted);
            }
            let within = if search.is_pushed() { f64::INFINITY } else { search.trust.radius };
            let at = search.report.iterations.len();
            let step = self.step_within(engine, (residual, drive), within, at)?;
            let size = increment_size(engine, &step.increment);
            let trial = self.try_step(engine, (search, residual), &step, (size, longest))?;
            let shift = self.shift;
            let is_accepted = search.accepts(engine, residual, &trial, size)?;
            search.report.obstacle.clone_from(&trial.obstacle);
            search.progress.count();
            search.report.iterations.push(Iteration {
                increment: size,
                residual: unbalanced,
                fraction: if is_accepted { trial.fraction } else { 0.0 },
                shift,
                potential: residual.potential.total(),
                rounds: trial.rounds,
            });
            if is_accepted {
                let is_indefinite = shift > neutral_shift(engine);
                let accepted = Accepted { size, unbalanced, noise: residual.rounding, is_indefinite, goes_on: false };
                return self.accept(engine, search, (residual, accepted), (&step, trial));
            }
            // the decrease that is left in a full step is below the rounding of the potential: no search gets
            // farther (a step that was cut short shows nothing)
            let unseen = trial.expected.abs() < residual.rounding * trial.fraction * (2.0 - trial.fraction);
            if shift == 0.0 && !search.is_pushed() && unseen {
                search.report.end_with(0.0);
                return Ok(Advance::Done);
            }
            search.rejections += 1;
            let ends = search.rejections > HALVINGS || search.progress.is_over();
            if ends || !self.shorten(search, &step, trial.fraction, &mut longest) {
                return Ok(Advance::NoFarther);
            }
        }
    }

    /// Shortens the next try after a step of which a fraction was rejected; whether there is a shorter one. `longest`
    /// is the fraction that is tried of a step that supports push.
    fn shorten(&mut self, search: &mut Search, step: &ModelStep, fraction: f64, longest: &mut f64) -> bool {
        let limit = match search.is_pushed() {
            // no motion of a support leads that far: the tangent is nearly singular
            true if step.extent > LARGEST => LARGEST,
            // shifts do not shorten prescribed motions
            true => {
                *longest = SHORTER[0] * fraction;
                return *longest >= SHORTEST_PUSH;
            }
            false => {
                search.trust.reject(step.extent);
                search.trust.radius
            }
        };
        self.shift = self.shift_for(step, step.extent / limit).max(RAISING * self.shift);
        true
    }

    /// A step after its corrections. If these neither converge nor decrease the potential enough, a fraction of the
    /// step, which costs no factorisation. At most the fraction `longest` of the step, whose size is `size`.
    fn try_step(
        &mut self,
        engine: &mut Engine,
        (search, residual): (&Search, &Residual),
        step: &ModelStep,
        (size, longest): (f64, f64),
    ) -> Result<CorrectedStep, SolveError> {
        let from = StepStart { state: &search.state, residual, pushed: search.is_pushed() };
        let mut trial = self.trial(engine, from, step, longest)?;
        for &shorter in if from.pushed { [].as_slice() } else { &SHORTER } {
            let falls = gain(residual, &trial) >= LEAST * trial.expected - residual.rounding;
            if trial.settled || falls || trial.is_rounding(size) {
                break;
            }
            let obstacle = trial.obstacle;
            trial = self.trial(engine, from, step, shorter)?;
            trial.obstacle = trial.obstacle.or(obstacle);
        }
        Ok(trial)
    }

    /// Moves to the state of an accepted step, and says whether the search has converged there.
    fn accept(
        &mut self,
        engine: &mut Engine,
        search: &mut Search,
        (residual, accepted): (&Residual, Accepted),
        (step, trial): (&ModelStep, CorrectedStep),
    ) -> Result<Advance, SolveError> {
        search.remaining *= 1.0 - trial.fraction;
        let accepted = Accepted { goes_on: search.is_pushed(), ..accepted };
        if let Some(left) = search.rest.left(engine, residual, (step, &trial), &accepted) {
            search.report.end_with(left);
        }
        search.rejections = if search.rest.is_stuck(&accepted) { search.rejections + 1 } else { 0 };
        self.move_to(engine, search, residual, (step, trial));
        Ok(if search.rejections > HALVINGS { Advance::NoFarther } else { Advance::Done })
    }

    /// Takes over the state of a trial, and what the step predicts for the next one.
    fn move_to(
        &mut self,
        engine: &mut Engine,
        search: &mut Search,
        residual: &Residual,
        (step, trial): (&ModelStep, CorrectedStep),
    ) {
        let hardened = engine.contact.before.take().is_some();
        let unseen = trial.expected.abs() <= residual.rounding;
        search.trust.accept(StepOutcome {
            extent: step.extent,
            fraction: trial.fraction,
            rounds: trial.rounds,
            gain: (!unseen).then_some(gain(residual, &trial) / trial.expected),
        });
        if hardened {
            // under a new law the first step is the longest: its extent bounds the next ones
            search.trust.radius = search.trust.radius.min(step.extent);
        }
        // the geometric stiffness is that of the stresses which the linear solve balanced, not of the stresses off the
        // constraint surface
        search.stress = engine.predicted_stress(&search.state, &trial.increment);
        for (total, excess) in search.stress.iter_mut().zip(trial.excess.iter().flatten()) {
            for (t, e) in total.iter_mut().flatten().zip(excess.iter().flatten()) {
                *t += e;
            }
        }
        search.report.work += work_of_moments(engine, &trial.increment);
        search.state = trial.state;
        engine.take_state(search.state.clone());
    }

    fn end(
        &mut self,
        engine: &mut Engine,
        options: &SearchOptions,
        search: Search,
    ) -> Result<NewtonReport, SolveError> {
        let mut report = search.report;
        report.obstacle = report.obstacle.filter(|_| !report.converged);
        engine.take_state(search.state);
        engine.contact.before = None;
        self.finish(engine, options, report)
    }
}

/// Decrease of the potential less the work of moments.
fn gain(residual: &Residual, trial: &CorrectedStep) -> f64 {
    residual.potential.total() - trial.potential
}
