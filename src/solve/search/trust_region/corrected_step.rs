//! Second-order correction of a step: back to the surface of nearly rigid stretch and contact, on the factorisation of
//! the step.

use super::gain;
use super::step::ModelStep;
use crate::error::SolveError;
use crate::rod::element::Stress;
use crate::solve::measures::{BALANCED, MAX_ROUNDS};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::moment_load::work_of_moments;
use crate::solve::problem::state::State;
use crate::solve::search::step_bound::largest_turn;
use crate::solve::search::timing::timed;
use crate::solve::search::workspace::Workspace;

/// Last correction, over the step, with which corrections have converged, because the next is as much smaller again.
const SETTLED: f64 = 0.01;
/// Largest ratio of two corrections in a row that converge. With 0.5 instead, corrections that hardly shrink go on: the
/// beam beside a clamp takes 2844 iterations instead of 709.
const CONTRACTION: f64 = 0.4;
/// Change of contact forces, over their size, and turn of a node, rad, up to which the linearisation of a step holds,
/// because its error is the square: a hundredth.
const GENTLE: f64 = 0.1;

/// A step after its corrections.
#[derive(Clone)]
pub(super) struct CorrectedStep {
    pub(super) increment: Vec<f64>,
    pub(super) state: State,
    /// Potential there, less the work of moments on the way \[F·L\].
    pub(super) potential: f64,
    /// Decrease that the quadratic model expects.
    pub(super) expected: f64,
    /// Decrease that it expects of the next step with the same factorisation, if that of this one is below the rounding
    /// of the potential; else infinite.
    pub(super) left: f64,
    pub(super) fraction: f64,
    pub(super) rounds: usize,
    /// Largest change of a contact force in the step, relative to the largest contact force.
    pub(super) contact_change: f64,
    /// The corrections shrank.
    pub(super) settled: bool,
    /// Why contact could not be resolved there, or at longer parts of the step that were tried before.
    pub(super) obstacle: Option<SolveError>,
    /// C e of the last correction. Its sum with the linear prediction are the stresses that balance the step.
    pub(super) excess: Option<Vec<[Stress; 3]>>,
}

impl CorrectedStep {
    /// Whether the step, of this size, is so small that its decrease and its corrections are rounding, whatever the
    /// tolerance.
    pub(super) fn is_rounding(&self, size: f64) -> bool {
        size <= BALANCED && self.potential.is_finite()
    }
}

/// The state from which a step is taken.
#[derive(Clone, Copy)]
pub(super) struct StepStart<'a> {
    pub(super) state: &'a State,
    pub(super) residual: &'a Residual,
    /// Supports move in the step. Contact is not corrected then: the potential may rise, because the supports do work.
    pub(super) pushed: bool,
}

/// The part of a step that is taken, as predicted.
struct LinearStep<'a> {
    from: StepStart<'a>,
    increment: Vec<f64>,
    /// This part over the step.
    fraction: f64,
    /// Δᵀ(K + τM)Δ of it.
    energy: f64,
}

impl LinearStep<'_> {
    /// Its state before any correction; the potential is not known yet.
    fn uncorrected(&self, engine: &Engine, step: &ModelStep) -> CorrectedStep {
        let fraction = self.fraction;
        CorrectedStep {
            state: engine.retract(self.from.state, &self.increment, 1.0),
            increment: self.increment.clone(),
            potential: f64::NAN,
            expected: -fraction * step.slope - 0.5 * fraction * fraction * step.curvature,
            left: f64::INFINITY,
            fraction,
            rounds: 0,
            contact_change: 0.0,
            settled: false,
            obstacle: None,
            excess: None,
        }
    }
}

impl Workspace {
    /// Corrects at most the fraction `longest` of a step for the errors of its linear prediction and evaluates the
    /// potential there.
    pub(super) fn trial(
        &mut self,
        engine: &mut Engine,
        from: StepStart,
        step: &ModelStep,
        longest: f64,
    ) -> Result<CorrectedStep, SolveError> {
        let StepStart { state, residual, .. } = from;
        let safe = timed(&mut self.timings.detection, || engine.step_fraction(state, &step.increment))?.min(longest);
        let work = step.curvature + self.shift * step.inertia;
        let increment = step.increment.iter().map(|x| x * safe).collect();
        let linear = LinearStep { from, increment, fraction: safe, energy: safe * safe * work };
        let mut trial = linear.uncorrected(engine, step);
        let mut last = f64::INFINITY;
        let mut best: Option<CorrectedStep> = None;
        while let Some(there) = self.evaluate(engine, residual, &mut trial) {
            if trial.settled || trial.rounds >= MAX_ROUNDS || !trial.potential.is_finite() {
                if trial.expected.abs() < residual.rounding {
                    trial.left = self.expected_decrease(engine, there);
                }
                break;
            }
            let (wanted, excess) = self.corrected(engine, &linear, &trial, there);
            let change: Vec<f64> = wanted.iter().zip(&trial.increment).map(|(w, x)| w - x).collect();
            let size = self.energy_norm_sq(engine, &change, self.shift) / linear.energy;
            if best.as_ref().is_none_or(|b| trial.potential < b.potential) {
                best = Some(trial.clone());
            }
            if size.is_nan() || size >= CONTRACTION * last {
                break;
            }
            last = size;
            trial.rounds += 1;
            trial.settled = size < SETTLED;
            trial.state = engine.retract(state, &wanted, 1.0);
            trial.increment = wanted;
            trial.excess = Some(excess);
        }
        timed(&mut self.timings.detection, || engine.update_contact(state))?;
        // if all differ by rounding only, the corrected state is the better one
        Ok(match best {
            Some(best) if !trial.settled && trial.expected > residual.rounding => best,
            _ => trial,
        })
    }

    /// Residual of a trial, and its potential and change of contact. `None` where contact cannot be resolved: the step
    /// is too long.
    fn evaluate(&mut self, engine: &mut Engine, before: &Residual, trial: &mut CorrectedStep) -> Option<Residual> {
        trial.obstacle = timed(&mut self.timings.detection, || engine.update_contact(&trial.state)).err();
        if trial.obstacle.is_some() {
            return None;
        }
        let there = timed(&mut self.timings.assembly, || engine.residual_of_trial(&trial.state));
        trial.potential = there.potential.total() - work_of_moments(engine, &trial.increment);
        trial.contact_change = relative_change(before, &there);
        // below the rounding of the potential corrections are rounding, unless the potential rises by more
        let noise = before.rounding;
        trial.settled |= trial.expected.abs() < noise && gain(before, trial) >= -noise;
        Some(there)
    }

    /// Decrease that a full step expects from a state of this residual, with the factorisation at hand.
    fn expected_decrease(&mut self, engine: &Engine, mut there: Residual) -> f64 {
        self.zero_energy.remove_forces(&mut there);
        let step = self.solve_last(&there.gradient);
        0.5 * self.free_dot(engine, &step, |i| there.gradient[i]).abs()
    }

    /// The increment after the next correction, and C e of it: K⁻¹ times the second-order forces, BᵀC e of the rods and
    /// Σ k e ∂gap/∂x of contact, is taken from the linear step. `there` is the residual at the trial.
    fn corrected(
        &mut self,
        engine: &Engine,
        linear: &LinearStep,
        trial: &CorrectedStep,
        there: Residual,
    ) -> (Vec<f64>, Vec<[Stress; 3]>) {
        let StepStart { state, residual, pushed } = linear.from;
        // near equilibrium the whole residual is corrected (a chord step)
        let gentle = self.shift == 0.0 && linear.fraction == 1.0 && !pushed && trial.contact_change <= GENTLE;
        let with_contact = !(pushed || gentle);
        let (excess, mut second_order) = engine.elastic_second_order(state, &trial.state, &trial.increment);
        if with_contact {
            engine.add_contact_second_order((state, &trial.increment), residual, &there, &mut second_order);
        }
        let (from, mut correction) = if gentle {
            let mut unbalanced = there;
            self.zero_energy.remove_forces(&mut unbalanced);
            (&trial.increment, self.solve_last(&unbalanced.gradient))
        } else {
            (&linear.increment, self.solve_last(&second_order))
        };
        let is_first = trial.rounds == 0 && with_contact;
        if is_first && self.localise(engine, linear, &correction) {
            correction = self.solve_last(&second_order);
        }
        (from.iter().zip(&correction).map(|(b, c)| b - c).collect(), excess)
    }

    /// Factorises with a larger shift if the correction of a step, of more energy than the step, is not small beside
    /// it, so that another one moves less; whether it did. The correction of least energy slides strands in contact
    /// along each other, and rods along what is soft in them, by as much as the step does, because that costs nothing,
    /// and leaves errors as large as those it mends. A correction should be a tenth of the step ([`GENTLE`]); without
    /// contact this holds for steps that turn no node by more than a tenth of a radian only, because a correction is
    /// the second order of its step. The shift is at most that of bends as wide as the contact distance d, or, without
    /// contact, as the node spacing, B/d⁴: with more of it strands would evade each other by kinks.
    fn localise(&mut self, engine: &Engine, linear: &LinearStep, correction: &[f64]) -> bool {
        let is_in_contact = !linear.from.residual.contact_pairs.is_empty();
        if !is_in_contact && largest_turn(&linear.increment) > GENTLE {
            return false;
        }
        let width = if engine.contact.is_empty() { engine.scales.lever } else { 2.0 * engine.contact.min_radius };
        let energy = self.energy_norm_sq(engine, correction, self.shift);
        if energy <= linear.energy {
            return false;
        }
        let [step, moved] = [&linear.increment, correction].map(|x| self.inertia(engine, x));
        let shorter = (moved / step).sqrt() / GENTLE;
        let stiffness = energy / moved;
        let largest = (engine.scales.length / width).powi(4);
        // that of a single mode of this stiffness, shift included
        let shift = (self.shift + stiffness * (shorter - 1.0)).min(largest);
        let is_larger = shorter > 1.0 && shift > self.factorised;
        if is_larger {
            self.factorise(engine, shift);
        }
        is_larger
    }
}

/// Largest change of a contact force relative to the largest before; 0 if none changes.
fn relative_change(before: &Residual, after: &Residual) -> f64 {
    let both = before.contact_forces().zip(after.contact_forces());
    let change = both.fold(0.0f64, |a, (x, y)| a.max((x - y).abs()));
    if change == 0.0 { 0.0 } else { change / before.largest_contact_force() }
}
