//! Mixed-integration-point Newton with an inertia-controlled shift and a passage-free step bound.

use crate::error::SolveError;
use crate::rod::element::Stress;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::search::interrupt::Interrupt;
use crate::solve::search::workspace::Workspace;

/// Largest ratio of two steps in a row of a search that converges near an equilibrium, because with less gain the trust
/// region does better.
const CONTRACTION: f64 = 0.4;
/// Steps in a row that were cut, or hardly shrank, after which a plain search gives up, because the first may be
/// chance.
const BAD_STEPS: usize = 2;

/// Options of an equilibrium search; lengths are relative to the node spacing, rotations in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct NewtonOptions {
    /// Converged when a full step moves no node by more than this × node spacing and turns none by more (rad).
    pub tol_increment: f64,
    /// Largest number of iterations in which no node goes farther than the node spacing, nor turns by more than 1 rad,
    /// while the potential falls. For searches without a potential: largest number of iterations.
    pub max_iterations: usize,
    /// Search for minima, with the tangent shifted until it has no negative eigenvalue. Off: for any equilibrium.
    pub stable_only: bool,
    /// Stops the search between two iterations.
    pub interrupt: Interrupt,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self { tol_increment: 1e-8, max_iterations: 500, stable_only: true, interrupt: Interrupt::default() }
    }
}

/// One Newton iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Size of the full increment: largest of displacement / node spacing and rotation (rad).
    pub increment: f64,
    /// Largest |residual| over the size of its contributions.
    pub residual: f64,
    /// Fraction of the step taken.
    pub fraction: f64,
    /// Shift used, in units of B/L⁴ per length.
    pub shift: f64,
    /// Total potential before the step.
    pub potential: f64,
    /// Correction rounds spent on the step's factorisation.
    pub rounds: usize,
}

/// Result of an equilibrium search.
#[derive(Debug, Clone, Default, PartialEq)]
#[must_use]
pub(crate) struct NewtonReport {
    /// Whether the tolerance was met.
    pub(crate) converged: bool,
    /// Size of the increment that is left then, at most; 0 where more is rounding.
    pub(crate) left: f64,
    /// All iterations.
    pub(crate) iterations: Vec<Iteration>,
    /// Unstable directions where the search ended; 0 too where it ended before an equilibrium was reached, see
    /// [`SearchOptions::is_at_rest`].
    pub(crate) num_unstable: usize,
    /// Work of moments along the search, by the steps of the trust region \[F·L\].
    pub(crate) work: f64,
    /// What kept the last step from being taken as a whole, if the search did not converge.
    pub(crate) obstacle: Option<SolveError>,
    /// Whether an [`Interrupt`] ended it.
    pub(crate) interrupted: bool,
}

impl NewtonReport {
    /// Converged with an increment of this size left.
    pub(super) fn end_with(&mut self, left: f64) {
        (self.converged, self.left) = (true, left);
    }
}

impl Iteration {
    /// A step that is not yet known, from a state with this residual.
    fn from(engine: &Engine, residual: &Residual) -> Self {
        let (unbalanced, potential) = (relative_residual(engine, residual), residual.potential.total());
        Self { increment: f64::NAN, residual: unbalanced, fraction: 0.0, shift: 0.0, potential, rounds: 0 }
    }
}

/// Options of one search, and what is known of its end beforehand.
#[derive(Debug, Clone)]
pub(crate) struct SearchOptions<'a> {
    /// Newton's choices, with the tolerance of this search.
    pub(crate) newton: NewtonOptions,
    /// Unstable equilibria that may be left in a row while the potential hardly falls.
    pub(crate) max_escapes: usize,
    /// Extent of the last step of a rough search, whose result is the start of the next one; `None`: not rough.
    pub(crate) rough: Option<f64>,
    /// The search starts from an equilibrium under slightly different pressures: its first steps are plain.
    pub(crate) near_rest: bool,
    /// For a search that leaves an unstable equilibrium: the potential \[F·L\] below which it ends, not converged,
    /// which is enough to know that the motion is not neutral.
    pub(crate) leaving: Option<f64>,
    /// Shear forces and tension of the first linearisation, per element and integration point \[F\]; empty: those of
    /// the state.
    pub(crate) forces: &'a [[[f64; 3]; 3]],
    /// Rotations, rad, from the start to the end, by the order of magnitude; infinite: not known.
    pub(crate) uncertainty: f64,
}

impl SearchOptions<'_> {
    /// Whether a search ended in an equilibrium, not only near enough for the next one.
    pub(crate) fn is_at_rest(&self, report: &NewtonReport) -> bool {
        report.converged && (self.rough.is_none() || report.left <= self.newton.tol_increment)
    }

    /// The same of a search of whose end nothing is known.
    pub(crate) fn without_foresight(&self) -> SearchOptions<'static> {
        let Self { newton, max_escapes, rough, near_rest, leaving, .. } = self.clone();
        SearchOptions { newton, max_escapes, rough, near_rest, leaving, forces: &[], uncertainty: f64::INFINITY }
    }
}

impl Workspace {
    /// Plain mixed-integration-point Newton: no shift, no descent test.
    pub(super) fn direct(
        &mut self,
        engine: &mut Engine,
        drive: &PrescribedMotion,
        search: &SearchOptions,
        may_give_up: bool,
    ) -> Result<NewtonReport, SolveError> {
        let options = &search.newton;
        let mut report = NewtonReport::default();
        let mut remaining = 1.0;
        let mut divergence = Divergence { cut_steps: 0, growing: 0, last: f64::INFINITY };
        let mut state = engine.state().clone();
        let mut stress = engine.stress_with(&state, search.forces);
        for iteration in 0..options.max_iterations {
            if options.interrupt.is_raised() {
                report.interrupted = true;
                return Ok(report);
            }
            self.refresh(engine, &state)?;
            let drive_now = drive.scaled(remaining);
            let residual = self.linearise(engine, &state, &stress, &drive_now);
            if self.factorise(engine, 0.0).is_none() {
                return Err(SolveError::Factorisation { iteration, shift: 0.0 });
            }
            let step = self.solve_step(engine, &residual, &drive_now, iteration)?;
            let increment = increment_size(engine, &step);
            let fraction = engine.step_fraction(&state, &step)?;
            blend(&mut stress, &engine.predicted_stress(&state, &step), fraction);
            report.iterations.push(Iteration { increment, fraction, ..Iteration::from(engine, &residual) });
            state = engine.retract(&state, &step, fraction);
            remaining *= 1.0 - fraction;
            engine.take_state(state.clone());
            // pressures of the law before are used in the first step under a new one only
            engine.contact.before = None;
            if fraction == 1.0
                && increment <= options.tol_increment
                && self.balances_contact(engine, (&residual, &state), (increment, options.tol_increment))?
            {
                report.end_with(increment);
                break;
            }
            // a search that diverges ends early if another one can follow
            if divergence.shows(increment, fraction, search.near_rest) && may_give_up {
                return Ok(report);
            }
        }
        self.finish(engine, search, report)
    }

    /// Brings contact up to date with the state where a search ended, and counts the unstable directions there.
    pub(super) fn finish(
        &mut self,
        engine: &mut Engine,
        search: &SearchOptions,
        mut report: NewtonReport,
    ) -> Result<NewtonReport, SolveError> {
        // the tangent of a state no farther away than the tolerance need not be made anew
        let is_near = report.converged && report.left <= search.newton.tol_increment;
        let is_known = !report.iterations.is_empty() && is_near && self.is_known_stable();
        let state = engine.state().clone();
        self.refresh(engine, &state)?;
        if search.is_at_rest(&report) && !is_known {
            report.num_unstable = self.count_unstable(engine)?;
        }
        Ok(report)
    }
}

/// Signs of divergence over the steps of a search.
struct Divergence {
    /// Steps in a row of which a part was taken.
    cut_steps: usize,
    /// Steps in a row that hardly shrank.
    growing: usize,
    /// Size of the last step.
    last: f64,
}

impl Divergence {
    /// Whether a search diverges, the step of this size and fraction included; near rest full steps must shrink, too.
    fn shows(&mut self, increment: f64, fraction: f64, near_rest: bool) -> bool {
        self.cut_steps = if fraction < 1.0 { self.cut_steps + 1 } else { 0 };
        self.growing = if increment > CONTRACTION * self.last { self.growing + 1 } else { 0 };
        self.last = increment;
        self.cut_steps >= BAD_STEPS || near_rest && self.growing >= BAD_STEPS
    }
}

/// Moves stresses by a fraction of their way to the predicted ones.
fn blend(stress: &mut [[Stress; 3]], predicted: &[[Stress; 3]], fraction: f64) {
    for (old, new) in stress.iter_mut().flatten().flatten().zip(predicted.iter().flatten().flatten()) {
        *old += fraction * (new - *old);
    }
}

/// Largest displacement over the node spacing, or rotation (rad), of an increment.
pub(crate) fn increment_size(engine: &Engine, step: &[f64]) -> f64 {
    step.iter().enumerate().map(|(i, x)| x.abs() / lever(engine, i)).fold(0.0, |a, b| {
        // NaN must not be swallowed by max
        if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
    })
}

/// Largest free |gradient| over the largest sum of contributions; forces and moments are compared over the node
/// spacing, so that pure bending, where all forces are rounding, is judged by its moments. 0 where there is nothing.
pub(crate) fn relative_residual(engine: &Engine, residual: &Residual) -> f64 {
    let sizes = residual.magnitude.iter().enumerate().map(|(i, size)| size * lever(engine, i));
    let magnitude = sizes.fold(0.0, f64::max);
    let nothing = engine.scales.nothing * engine.scales.lever;
    if magnitude > nothing { unbalanced(engine, residual) / magnitude } else { 0.0 }
}

/// Largest free |gradient|, forces times the node spacing \[F L\].
pub(super) fn unbalanced(engine: &Engine, residual: &Residual) -> f64 {
    let gradient = residual.bases.without_reactions(&residual.gradient);
    let free = gradient.iter().enumerate().filter(|(i, _)| engine.free[i / 6][i % 6]);
    free.map(|(i, x)| x.abs() * lever(engine, i)).fold(0.0, f64::max)
}

/// The node spacing for a force, 1 for a moment.
fn lever(engine: &Engine, unknown: usize) -> f64 {
    if unknown % 6 < 3 { engine.scales.lever } else { 1.0 }
}
