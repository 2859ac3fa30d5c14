//! The linearised problem that all searches share: its factorisation, its inertia, responses to forces.

use crate::error::SolveError;
use crate::rod::element::Stress;
use crate::solve::problem::assembly::{Places, Residual, Tangent};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::moment_load::add_moment_skew;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::reduction::Reduction;
use crate::solve::problem::sliding_constraint::SlidingConstraint;
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::Bases;
use crate::solve::problem::zero_energy::ZeroEnergyModes;
use crate::solve::search::timing::{Timings, timed};
use crate::sparse::{Factor, Pattern};

/// Eigenvalues above minus this (in units of B/L⁴) count as neutral, because rigid motions and sliding of a uniform
/// ring along itself are neutral but for rounding and discretisation.
pub(crate) const NEUTRAL_SHIFT: f64 = 1e-7;

/// The same where a motion may cost next to nothing that neither springs hold nor elasticity. Of several rods, one that
/// others push converges where it just touches them without force; what force the tolerance leaves (1e-8 B/L²)
/// makes rolling off along them unstable by that over the strands' distance. A closed rod clamped at a node swings
/// about its tangent there and spins back, which loads resist by as little as they are. The softest bending of a rod
/// has 12 and more. These motions are not left out of the count for good: with a load on it, a ring that stands upright
/// on its clamp falls (`tests/solver/held_motions.rs`).
const LOOSE: f64 = 1e-3;

/// Matrix, factorisation and other data that searches share.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    pattern: Option<Pattern>,
    factor: Option<Factor>,
    pub(crate) tangent: Tangent,
    /// Neutral motions at the last linearisation.
    pub(crate) zero_energy: ZeroEnergyModes,
    border: Option<SlidingConstraint>,
    /// Generation of the candidates that the pattern belongs to.
    generation: u64,
    pub(crate) shift: f64,
    /// Shift of the factor at hand.
    pub(crate) factorised: f64,
    /// Negative eigenvalues of the tangent with it; `None` if a pivot vanished, and without a factor.
    num_negative: Option<usize>,
    /// Diagonal of the tangent while a shift is in it.
    unshifted: Vec<f64>,
    /// Last estimate of the softest direction.
    pub(crate) softest: Vec<f64>,
    /// Times of the parts of all searches.
    pub(crate) timings: Timings,
    /// Bases of the unknowns of the last linearisation.
    bases: Bases,
}

impl Workspace {
    /// Sum over free unknowns of step × f.
    pub(crate) fn free_dot(&self, engine: &Engine, step: &[f64], f: impl Fn(usize) -> f64) -> f64 {
        let free = |i: usize| engine.free[i / 6][i % 6];
        (0..step.len()).filter(|&i| free(i)).map(|i| step[i] * f(i)).sum()
    }

    /// Brings contact candidates, pattern and symbolic analysis up to date with a state.
    pub(crate) fn refresh(&mut self, engine: &mut Engine, state: &State) -> Result<(), SolveError> {
        timed(&mut self.timings.detection, || engine.update_contact(state))?;
        // without contact, or with contact left out for now, the present pattern is valid
        let generation = if engine.contact.is_empty() { self.generation } else { engine.contact.generation() };
        if self.pattern.is_none() || generation != self.generation {
            // freed first, because they are the largest allocations
            (self.factor, self.num_negative, self.pattern) = (None, None, None);
            self.tangent.places = Places::default();
            engine.check_memory()?;
            timed(&mut self.timings.symbolic, || {
                let (pattern, factor) = Factor::of(engine.node_graph())?;
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
            timed(&mut self.timings.assembly, || engine.linearise(state, Some(stress), drive, (pattern, tangent)));
        self.zero_energy = ZeroEnergyModes::at(engine, state, &residual);
        self.bases.clone_from(&residual.bases);
        self.zero_energy.add_pins(engine, state, (pattern, &self.bases), &mut self.tangent.values);
        self.zero_energy.remove_forces(&mut residual);
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

    /// A raw step without its neutral parts and with the prescribed motion.
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
        let mut step = self.solve_last(&rhs);
        add_moment_skew(engine, &mut step, |forces| self.solve_last(forces));
        step
    }

    /// Response of all unknowns to forces by the last factorisation, moments' skew part included, neutral parts taken
    /// out.
    pub(crate) fn respond(&mut self, engine: &Engine, forces: &[f64]) -> Vec<f64> {
        let mut response = self.solve_last(forces);
        add_moment_skew(engine, &mut response, |forces| self.solve_last(forces));
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
        self.factorised = shift;
        let inertia = timed(&mut self.timings.factor, || engine.install(|| factor.factorise(pattern, values)));
        for (eq, value) in self.unshifted.iter().enumerate() {
            values[pattern.diagonal(eq)] = *value;
        }
        self.num_negative = None;
        let negative = inertia?.num_negative;
        self.border = None;
        self.num_negative = match self.zero_energy.sliding_constraint() {
            None => Some(negative),
            Some(constraint) => {
                let response = self.solve_unconstrained(&constraint);
                Some(self.border.insert(SlidingConstraint::new(constraint, response)).num_negative(negative))
            }
        };
        self.num_negative
    }

    /// Whether the factor at hand shows that [`Workspace::count_unstable`] would count none where its tangent was made.
    pub(super) fn is_known_stable(&self) -> bool {
        self.num_negative == Some(0) && self.factorised <= NEUTRAL_SHIFT
    }

    /// Rounding error of a zero eigenvalue (of the tangent over the masses, in units of B/L⁴): a few units in the last
    /// place of the largest eigenvalue.
    pub(crate) fn rounding_of_eigenvalues(&self, engine: &Engine) -> f64 {
        let Some(pattern) = &self.pattern else { return 0.0 };
        let quotient = |(i, mass): (usize, &f64)| {
            let diagonal = pattern.equation(i / 6, i % 6).map(|eq| self.tangent.values[pattern.diagonal(eq)]);
            diagonal.map_or(0.0, |d| d.abs() / mass)
        };
        let own = |(i, _): &(usize, &f64)| engine.sharing.owner[i / 6][i % 6] == i / 6;
        4.0 * f64::EPSILON * engine.metric.iter().enumerate().filter(own).map(quotient).fold(0.0, f64::max)
    }

    /// Product of a matrix of the tangent's pattern with an increment (supported unknowns give and take nothing).
    pub(crate) fn multiply(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let Some(pattern) = &self.pattern else { return Vec::new() };
        let reduction = Reduction { pattern, bases: &self.bases };
        reduction.motion_of_nodes(x.len(), &pattern.multiply(values, &reduction.motion(x)))
    }

    /// Solves with the last factorisation for all unknowns, without sliding of a uniform closed rod along itself.
    pub(crate) fn solve_last(&mut self, rhs_nodes: &[f64]) -> Vec<f64> {
        let mut x = self.solve_unconstrained(rhs_nodes);
        self.border.iter().for_each(|border| border.apply(&mut x));
        x
    }

    fn solve_unconstrained(&mut self, rhs_nodes: &[f64]) -> Vec<f64> {
        let (Some(pattern), Some(factor)) = (&self.pattern, &mut self.factor) else { return Vec::new() };
        let reduction = Reduction { pattern, bases: &self.bases };
        let mut rhs = reduction.forces(rhs_nodes);
        timed(&mut self.timings.solve, || factor.solve(&mut rhs));
        reduction.motion_of_nodes(rhs_nodes.len(), &rhs)
    }

    /// Linearises at the engine's state with its actual stresses and counts negative eigenvalues.
    pub(crate) fn count_unstable(&mut self, engine: &mut Engine) -> Result<usize, SolveError> {
        let state = engine.state().clone();
        self.refresh(engine, &state)?;
        let stress = engine.actual_stress(&state);
        self.linearise(engine, &state, &stress, &PrescribedMotion::default());
        let shift = neutral_shift(engine);
        self.factorise(engine, shift).ok_or(SolveError::Factorisation { iteration: 0, shift })
    }
}

/// Shift up to which eigenvalues count as neutral \[B/L⁴\].
pub(super) fn neutral_shift(engine: &Engine) -> f64 {
    if has_loose_motions(engine) { LOOSE } else { NEUTRAL_SHIFT }
}

/// Whether one of several rods is clamped and joined nowhere, so that others may move it as a whole, or a closed one
/// bears loads. What joints let turn is held by nothing but loads, however stiff the rods are.
fn has_loose_motions(engine: &Engine) -> bool {
    let rods = 0..engine.model.rods.len();
    let is_loose = |rod: usize| !engine.is_clamped(rod) && !engine.is_joined(rod);
    let pushed = rods.len() > 1 && rods.clone().any(is_loose);
    pushed || rods.into_iter().any(|rod| engine.model.rods[rod].closed && engine.bears_loads(rod))
}
