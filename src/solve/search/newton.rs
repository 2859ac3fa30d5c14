//! Mixed-integration-point Newton with an inertia-controlled shift and a passage-free step bound.

use crate::error::SolveError;
use crate::rod::element::Stress;
use crate::solve::load_step::predictor::{Lifted, lifted};
use crate::solve::problem::assembly::{Residual, Tangent};
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::{PrescribedMotion, State};
use crate::solve::problem::swivel::Bases;
use crate::solve::problem::zero_energy::ZeroEnergyModes;
use crate::solve::search::interrupt::Interrupt;
use crate::solve::search::timing::{Timings, timed};
use crate::sparse::{Factor, Pattern};

/// Options of an equilibrium search; lengths are relative to the node spacing, rotations in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct NewtonOptions {
    /// Converged when a full step moves no node by more than this × node spacing and turns none by more (rad).
    pub tol_increment: f64,
    /// Largest number of iterations in a row without progress (decrease of the potential by 1e-2 of the stored energy).
    /// For searches without a potential: largest number of iterations.
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
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub(crate) struct NewtonReport {
    /// Whether the tolerance was met.
    pub(crate) converged: bool,
    /// All iterations.
    pub(crate) iterations: Vec<Iteration>,
    /// Unstable directions of the last tangent (without shift).
    pub(crate) num_unstable: usize,
}

/// Matrix, factorisation and other data that searches share.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pattern: Option<Pattern>,
    factor: Option<Factor>,
    pub(crate) tangent: Tangent,
    /// Neutral motions at the last linearisation.
    pub(crate) zero_energy: ZeroEnergyModes,
    border: Option<Border>,
    /// Generation of the candidates that the pattern belongs to.
    generation: u64,
    pub(crate) shift: f64,
    /// Diagonal of the tangent while a shift is in it.
    unshifted: Vec<f64>,
    /// Last estimate of the softest direction.
    pub(crate) softest: Vec<f64>,
    /// Times of the parts of all searches.
    pub(crate) timings: Timings,
    /// Extent of the last step of a rough search, whose result is the start of the next one; `None`: not rough.
    pub(crate) rough: Option<f64>,
    /// Shear forces and tension, per element and integration point, of the first linearisation of the next search;
    /// empty: those of the state.
    pub(crate) start_forces: Vec<[[f64; 3]; 3]>,
    /// The next search starts from an equilibrium under slightly different pressures: its first steps are plain.
    pub(crate) near_rest: bool,
    /// Bases of the unknowns of the last linearisation.
    bases: Bases,
    /// A search was interrupted.
    pub(crate) interrupted: bool,
}

/// Prescribed motions, and the shear forces and the tension of the first linearisation (empty: those of the state).
type SearchStart<'a> = (&'a PrescribedMotion, &'a [[[f64; 3]; 3]]);

/// Largest number of iterations of the plain search.
const MAX_DIRECT: usize = 15;
/// Ratio of two increments above which Newton's method does not converge yet. Near a state at rest, two such ratios in
/// a row end the plain search.
const CONTRACTION: f64 = 0.5;

impl Workspace {
    /// Finds an equilibrium from the engine's state with the motions of `drive`; the engine keeps the last iterate.
    ///
    /// A plain mixed Newton search comes first where nothing is near contact: it takes a rod through a full circle in
    /// one step, across indefinite tangents between two stable states. It comes first, too, near an equilibrium. The
    /// trust-region search follows if it does not converge, if strands would touch or pass each other, and when leaving
    /// an unstable state (`leaving`). It ends, not converged, when the potential falls below the value of `leaving`, which
    /// is enough to know that a motion is not neutral.
    ///
    /// # Errors
    /// Numerical breakdown; the report says whether the search converged.
    pub(crate) fn equilibrate(
        &mut self,
        engine: &mut Engine,
        drive: &PrescribedMotion,
        options: &NewtonOptions,
        leaving: Option<f64>,
    ) -> Result<NewtonReport, SolveError> {
        let Lifted { state: mut start, drive, .. } = lifted(engine, &engine.state, drive);
        engine.swivels.iter().for_each(|swivel| swivel.restore(&mut start));
        let drive = &drive;
        let forces = std::mem::take(&mut self.start_forces);
        engine.state = start.clone();
        self.refresh(engine, &start)?;
        let near_contact = engine.contact.as_ref().is_some_and(|side| side.may_push());
        let mut spent = Vec::new();
        if options.stable_only && leaving.is_none() && engine.contact.is_some() && (self.near_rest || !near_contact) {
            let plain = if near_contact { Self::direct_in_contact } else { Self::direct_apart };
            if let Some(report) = plain(self, engine, (drive, &forces), options, &mut spent)? {
                return Ok(report);
            }
            engine.state = start.clone();
            self.refresh(engine, &start)?;
        }
        if !options.stable_only || !(engine.contact.is_some() || leaving.is_some()) {
            let direct = NewtonOptions {
                stable_only: false,
                max_iterations: if options.stable_only { MAX_DIRECT } else { options.max_iterations },
                ..options.clone()
            };
            match self.direct(engine, (drive, &forces), &direct, options.stable_only) {
                Ok(report) if !options.stable_only || report.converged => return Ok(report),
                Ok(report) => spent = report.iterations,
                Err(_) if options.stable_only => {}
                Err(error) => return Err(error),
            }
            engine.state = start;
        }
        let mut report =
            self.trust_region_search(engine, drive, options, (&forces, leaving.unwrap_or(f64::NEG_INFINITY)))?;
        spent.append(&mut report.iterations);
        report.iterations = spent;
        Ok(report)
    }

    /// The plain search without contact, for rods that are apart. Its result counts if nothing touches there and a path
    /// without passage leads there; otherwise its iterations are added to `spent`.
    fn direct_apart(
        &mut self,
        engine: &mut Engine,
        start: SearchStart,
        options: &NewtonOptions,
        spent: &mut Vec<Iteration>,
    ) -> Result<Option<NewtonReport>, SolveError> {
        let before = engine.state.clone();
        let direct = NewtonOptions { stable_only: false, max_iterations: MAX_DIRECT, ..options.clone() };
        let side = engine.contact.take();
        let outcome = self.direct(engine, start, &direct, true);
        engine.contact = side;
        // after a breakdown the other searches begin from the start
        let Ok(mut report) = outcome else { return Ok(None) };
        if report.converged
            && timed(&mut self.timings.detection, || engine.is_path_free(&before)).unwrap_or(false)
            && !engine.is_touching()
        {
            if engine.contact.as_ref().is_some_and(ContactSide::is_near) {
                report.num_unstable = self.count_unstable(engine)?;
            }
            return Ok(Some(report));
        }
        spent.append(&mut report.iterations);
        Ok(None)
    }

    /// The plain search with contact: where pressures hardly change, its steps are as good as those of the trust region
    /// at a third of the cost. Its result counts if it is stable; otherwise its iterations are added to `spent`.
    fn direct_in_contact(
        &mut self,
        engine: &mut Engine,
        start: SearchStart,
        options: &NewtonOptions,
        spent: &mut Vec<Iteration>,
    ) -> Result<Option<NewtonReport>, SolveError> {
        let before = engine.contact.as_ref().and_then(|side| side.before.clone());
        let direct = NewtonOptions { stable_only: false, max_iterations: MAX_DIRECT, ..options.clone() };
        // after a breakdown the trust-region search begins from the start
        if let Ok(mut report) = self.direct(engine, start, &direct, true) {
            if report.converged && report.num_unstable == 0 {
                return Ok(Some(report));
            }
            spent.append(&mut report.iterations);
        }
        if let Some(side) = &mut engine.contact {
            side.before = before;
        }
        Ok(None)
    }

    /// Plain mixed-integration-point Newton: no shift, no descent test.
    fn direct(
        &mut self,
        engine: &mut Engine,
        (drive, forces): SearchStart,
        options: &NewtonOptions,
        may_give_up: bool,
    ) -> Result<NewtonReport, SolveError> {
        let mut report = NewtonReport { converged: false, iterations: Vec::new(), num_unstable: 0 };
        let (mut remaining, mut cut_steps, mut growing, mut last) = (1.0, 0, 0, f64::INFINITY);
        let mut state = engine.state.clone();
        let mut stress = engine.stress_with(&state, forces);
        for iteration in 0..options.max_iterations {
            if self.must_stop(options) {
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
            let predicted = engine.predicted_stress(&state, &step);
            for (old, new) in stress.iter_mut().flatten().flatten().zip(predicted.iter().flatten().flatten()) {
                *old += fraction * (new - *old);
            }
            report.iterations.push(Iteration {
                increment,
                residual: relative_residual(engine, &residual),
                fraction,
                shift: 0.0,
                potential: residual.potential.total(),
                rounds: 0,
            });
            state = state.retract(&step, fraction);
            remaining *= 1.0 - fraction;
            engine.state = state.clone();
            if let Some(side) = &mut engine.contact {
                // pressures of the law before are used in the first step under a new one only
                side.before = None;
            }
            if fraction == 1.0 && increment <= options.tol_increment {
                report.converged = true;
                break;
            }
            // a search that diverges ends early if another one can follow
            cut_steps = if fraction < 1.0 { cut_steps + 1 } else { 0 };
            growing = if increment > CONTRACTION * last { growing + 1 } else { 0 };
            last = increment;
            if may_give_up && (cut_steps >= 2 || self.near_rest && growing >= 2) {
                return Ok(report);
            }
        }
        self.refresh(engine, &state)?;
        report.num_unstable = self.count_unstable(engine)?;
        Ok(report)
    }

    /// Whether the search is to stop; kept until the caller resets it.
    pub(crate) fn must_stop(&mut self, options: &NewtonOptions) -> bool {
        self.interrupted |= options.interrupt.is_raised();
        self.interrupted
    }

    /// Sum over free unknowns of step × f.
    pub(crate) fn free_dot(&self, engine: &Engine, step: &[f64], f: impl Fn(usize) -> f64) -> f64 {
        let free = |i: usize| engine.free[i / 6][i % 6];
        (0..step.len()).filter(|&i| free(i)).map(|i| step[i] * f(i)).sum()
    }

    /// Brings contact candidates, pattern and symbolic analysis up to date with a state.
    pub(crate) fn refresh(&mut self, engine: &mut Engine, state: &State) -> Result<(), SolveError> {
        timed(&mut self.timings.detection, || engine.update_contact(state))?;
        // without contact, or with contact left out for now, the present pattern is valid
        let generation = engine.contact.as_ref().map_or(self.generation, |side| side.generation());
        if self.pattern.is_none() || generation != self.generation {
            // freed first, because they are the largest allocations
            (self.factor, self.pattern) = (None, None);
            timed(&mut self.timings.symbolic, || {
                let (pattern, factor) = Factor::of(engine.build_pattern())?;
                (self.pattern, self.factor) = (Some(pattern), Some(factor));
                Ok(())
            })?;
            self.generation = generation;
        }
        Ok(())
    }

    pub(crate) fn linearise(
        &mut self,
        engine: &Engine,
        state: &State,
        stress: &[[Stress; 3]],
        drive: &PrescribedMotion,
    ) -> Residual {
        let Some(pattern) = &self.pattern else { return Residual::default() };
        let tangent = &mut self.tangent;
        let mut residual =
            timed(&mut self.timings.assembly, || engine.linearise(state, Some(stress), drive, pattern, tangent));
        self.zero_energy = ZeroEnergyModes::at(engine, state, &residual);
        self.bases.clone_from(&residual.bases);
        self.zero_energy.add_pins(engine, state, (pattern, &self.bases), &mut self.tangent.values);
        self.zero_energy.remove_sliding_force(&mut residual.gradient);
        residual
    }

    /// Increment of all unknowns from the last factorisation, prescribed parts included, neutral parts taken out.
    pub(crate) fn solve_step(
        &mut self,
        engine: &Engine,
        residual: &Residual,
        drive: &PrescribedMotion,
        iteration: usize,
    ) -> Result<Vec<f64>, SolveError> {
        let raw = self.raw_step(engine, residual);
        self.finished_step(raw, drive, iteration)
    }

    /// A raw step with its neutral parts taken out and what is prescribed put in.
    pub(crate) fn finished_step(
        &self,
        mut step: Vec<f64>,
        drive: &PrescribedMotion,
        iteration: usize,
    ) -> Result<Vec<f64>, SolveError> {
        self.zero_energy.remove(&mut step);
        drive.add_to(&mut step);
        match step.iter().position(|x| !x.is_finite()) {
            Some(index) => Err(SolveError::NotFinite { iteration, quantity: "increment", index, value: step[index] }),
            None => Ok(step),
        }
    }

    /// Increment from the last factorisation with some neutral motion in it.
    pub(crate) fn raw_step(&mut self, engine: &Engine, residual: &Residual) -> Vec<f64> {
        let rhs: Vec<f64> = residual.gradient.iter().zip(&self.tangent.drive).map(|(g, d)| -g - d).collect();
        let mut step = self.solve_last(engine, &rhs);
        self.add_moment_skew(engine, &mut step);
        step
    }

    /// Response of all unknowns to forces by the last factorisation, moments' skew part included, neutral parts taken
    /// out.
    pub(crate) fn respond(&mut self, engine: &Engine, forces: &[f64]) -> Vec<f64> {
        let mut response = self.solve_last(engine, forces);
        self.add_moment_skew(engine, &mut response);
        self.zero_energy.remove(&mut response);
        response
    }

    /// Factorises tangent + shift × mass; number of negative eigenvalues, `None` if a pivot vanished.
    pub(crate) fn factorise(&mut self, engine: &Engine, shift: f64) -> Option<usize> {
        let (Some(pattern), Some(factor)) = (&self.pattern, &mut self.factor) else { return None };
        let values = &mut self.tangent.values;
        self.unshifted.clear();
        if shift != 0.0 {
            self.unshifted.extend((0..pattern.num_equations()).map(|eq| values[pattern.diagonal(eq)]));
            for (i, mass) in engine.metric.iter().enumerate() {
                if let Some(eq) = pattern.equation(i / 6, i % 6) {
                    values[pattern.diagonal(eq)] += shift * mass;
                }
            }
        }
        let inertia = timed(&mut self.timings.factor, || factor.factorise(pattern, values));
        for (eq, value) in self.unshifted.iter().enumerate() {
            values[pattern.diagonal(eq)] = *value;
        }
        let negative = inertia?.num_negative;
        self.border = None;
        let Some(constraint) = self.zero_energy.sliding_constraint() else { return Some(negative) };
        let response = self.solve_unconstrained(engine, &constraint);
        let compliance: f64 = constraint.iter().zip(&response).map(|(c, w)| c * w).sum();
        self.border = Some(Border { constraint, response, compliance });
        // inertia of the tangent on the motions that do not slide (Haynsworth)
        Some(negative - usize::from(negative > 0 && compliance < 0.0))
    }

    /// Rounding error of a zero eigenvalue (of the tangent over the masses, in units of B/L⁴): a few units in the last
    /// place of the largest eigenvalue.
    pub(crate) fn rounding_of_eigenvalues(&self, engine: &Engine) -> f64 {
        let Some(pattern) = &self.pattern else { return 0.0 };
        let quotient = |(i, mass): (usize, &f64)| {
            let diagonal = pattern.equation(i / 6, i % 6).map(|eq| self.tangent.values[pattern.diagonal(eq)]);
            diagonal.map_or(0.0, |d| d.abs() / mass)
        };
        let own = |(i, _): &(usize, &f64)| engine.master[i / 6] == i / 6;
        4.0 * f64::EPSILON * engine.metric.iter().enumerate().filter(own).map(quotient).fold(0.0, f64::max)
    }

    /// Product of a matrix of the tangent's pattern with an increment (supported unknowns give and take nothing).
    pub(crate) fn multiply(&self, engine: &Engine, values: &[f64], x: &[f64]) -> Vec<f64> {
        let Some(pattern) = &self.pattern else { return Vec::new() };
        let mut reduced = vec![0.0; pattern.num_equations()];
        for (i, x) in self.bases.resolved(x).iter().enumerate() {
            if let Some(eq) = pattern.equation(i / 6, i % 6) {
                reduced[eq] = *x;
            }
        }
        self.expand(engine, pattern, &pattern.multiply(values, &reduced))
    }

    /// Solves with the last factorisation for all unknowns, without sliding of a uniform closed rod along itself.
    pub(crate) fn solve_last(&mut self, engine: &Engine, rhs_nodes: &[f64]) -> Vec<f64> {
        let mut x = self.solve_unconstrained(engine, rhs_nodes);
        if let Some(border) = &self.border {
            let part: f64 = border.constraint.iter().zip(&x).map(|(c, x)| c * x).sum();
            for (x, w) in x.iter_mut().zip(&border.response) {
                *x -= part / border.compliance * w;
            }
        }
        x
    }

    fn solve_unconstrained(&mut self, engine: &Engine, rhs_nodes: &[f64]) -> Vec<f64> {
        let (Some(pattern), Some(factor)) = (&self.pattern, &mut self.factor) else { return Vec::new() };
        let mut rhs = vec![0.0; pattern.num_equations()];
        for (i, x) in self.bases.resolved(rhs_nodes).iter().enumerate() {
            if let Some(eq) = pattern.equation(i / 6, i % 6) {
                rhs[eq] += x;
            }
        }
        timed(&mut self.timings.solve, || factor.solve(&mut rhs));
        self.expand(engine, pattern, &rhs)
    }

    /// Six numbers a node from those of the equations.
    fn expand(&self, engine: &Engine, pattern: &Pattern, reduced: &[f64]) -> Vec<f64> {
        let number = |i: usize| pattern.equation(i / 6, i % 6).map_or(0.0, |eq| reduced[eq]);
        let mut all: Vec<f64> = (0..6 * engine.num_nodes()).map(number).collect();
        self.bases.compose(&mut all);
        all
    }

    /// Linearises at the engine's state with its actual stresses and counts negative eigenvalues.
    pub(crate) fn count_unstable(&mut self, engine: &mut Engine) -> Result<usize, SolveError> {
        let state = engine.state.clone();
        self.refresh(engine, &state)?;
        let stress = engine.actual_stress(&state);
        self.linearise(engine, &state, &stress, &PrescribedMotion::default());
        let shift = if has_loose_motions(engine) { LOOSE } else { NEUTRAL_SHIFT };
        self.factorise(engine, shift).ok_or(SolveError::Factorisation { iteration: 0, shift })
    }
}

/// A constraint that holds the neutral sliding motion, with its response K⁻¹c.
#[derive(Debug)]
struct Border {
    constraint: Vec<f64>,
    response: Vec<f64>,
    compliance: f64,
}

/// Eigenvalues above minus this (in units of B/L⁴) count as neutral: rigid motions and sliding of a uniform ring along
/// itself are neutral but for rounding and discretisation.
pub(crate) const NEUTRAL_SHIFT: f64 = 1e-7;

/// The same where a motion may cost next to nothing that neither springs hold nor elasticity. Of several rods, one that
/// others push comes to rest where it just touches them without force; what force the tolerance leaves (1e-8 B/L²)
/// makes rolling off along them unstable by that over the strands' distance. A closed rod clamped at a node swings
/// about its tangent there and spins back, which loads resist by as little as they are. The softest bending of a rod
/// has 12 and more. These motions are not left out of the count for good: with a load on it, a ring that stands upright
/// on its clamp falls (`tests/solver/held_motions.rs`).
const LOOSE: f64 = 1e-3;

/// Whether one of several rods is clamped nowhere, so that others may move it as a whole, or a closed one bears loads.
fn has_loose_motions(engine: &Engine) -> bool {
    let rods = 0..engine.model.rods.len();
    let pushed = rods.len() > 1 && rods.clone().any(|rod| !engine.is_clamped(rod));
    pushed || rods.into_iter().any(|rod| engine.model.rods[rod].closed && engine.bears_loads(rod))
}

pub(crate) fn increment_size(engine: &Engine, step: &[f64]) -> f64 {
    let lever = engine.scales.lever;
    step.iter().enumerate().map(|(i, x)| if i % 6 < 3 { x.abs() / lever } else { x.abs() }).fold(0.0, |a, b| {
        // NaN must not be swallowed by max
        if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
    })
}

/// Largest free |gradient| over the largest sum of contributions; forces and moments are compared over the node
/// spacing, so that pure bending, where all forces are rounding, is judged by its moments.
pub(crate) fn relative_residual(engine: &Engine, residual: &Residual) -> f64 {
    let scale = |k: usize| if k < 3 { engine.scales.lever } else { 1.0 };
    let unbalanced = residual.bases.without_reactions(&residual.gradient);
    let (mut gradient, mut magnitude) = (0.0f64, 0.0f64);
    for node in 0..engine.num_nodes() {
        for k in 0..6 {
            magnitude = magnitude.max(residual.magnitude[6 * node + k] * scale(k));
            if engine.free[node][k] {
                gradient = gradient.max(unbalanced[6 * node + k].abs() * scale(k));
            }
        }
    }
    if magnitude > 0.0 { gradient / magnitude } else { 0.0 }
}
