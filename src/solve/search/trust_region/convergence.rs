//! Convergence of the trust-region search.

use super::corrected_step::CorrectedStep;
use super::step::ModelStep;
use crate::solve::measures::BALANCED;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::search::contact_balance::is_light;

/// Largest change of contact forces in the last step of a rough search, over their size, because the next step then
/// changes them by less than a fifth.
const CONTACT_FOUND: f64 = 0.4;
/// Change of contact forces, over their size, with which they have converged, because they are known no better than
/// gaps are.
const CONTACT_BALANCED: f64 = 1e-6;
/// Change of contact forces and residual, over their sizes, and increment over the tolerance, that together show a
/// balance which rounding hides.
const NEARLY: f64 = 1e-3;
/// Ratio of the decrease that is left after a step to that of the step, in which the step was rounding, because a
/// search that converges leaves far less, and one that leaves a saddle several times as much.
const STAYS: std::ops::Range<f64> = 0.1..2.0;

/// Sizes of an accepted step.
pub(super) struct Accepted {
    /// Size of the increment, see [`increment_size`](crate::solve::search::newton::increment_size).
    pub(super) size: f64,
    /// Relative residual before it.
    pub(super) unbalanced: f64,
    /// Rounding error of the potential.
    pub(super) noise: f64,
    /// Whether the tangent was shifted by more than what counts as neutral.
    pub(super) is_indefinite: bool,
    /// Whether supports are still to move after it.
    pub(super) goes_on: bool,
}

/// Convergence test over the steps of a search.
pub(super) struct Convergence {
    tol_increment: f64,
    /// Extent of the last step of a rough search.
    rough: Option<f64>,
}

impl Convergence {
    pub(super) fn new(tol_increment: f64, rough: Option<f64>) -> Self {
        Self { tol_increment, rough }
    }

    /// Whether a step is below the tolerance.
    fn is_tiny(&self, size: f64, trial: &CorrectedStep) -> bool {
        size <= self.tol_increment && trial.potential.is_finite()
    }

    /// Whether the search is stuck: the shift made the step shorter than the tolerance, although forces are out of
    /// balance. Without this test it would not end where strands have no room left.
    pub(super) fn is_stuck(&self, accepted: &Accepted) -> bool {
        accepted.is_indefinite && accepted.size <= self.tol_increment && accepted.unbalanced > NEARLY
    }

    /// Size of the increment that is left after an accepted step from the state of `residual`, if the search has
    /// converged with it; 0 where the step was rounding.
    pub(super) fn left(
        &self,
        engine: &Engine,
        residual: &Residual,
        (step, trial): (&ModelStep, &CorrectedStep),
        accepted: &Accepted,
    ) -> Option<f64> {
        let tiny = self.is_tiny(accepted.size, trial);
        let indefinite = accepted.is_indefinite;
        let still = match self.rough {
            None => tiny && self.balances(engine, residual, trial, accepted),
            // relative motion decides, for a long rod swings far by little, once forces have found their places: the
            // end of a line of contact moves by about a layer (B/κ)^¼ an iteration, so it has less far to go under the
            // softer law
            Some(tol) => step.extent <= tol && (tiny || trial.contact_change <= CONTACT_FOUND),
        };
        // motions that change neither potential nor forces are rounding along neutral directions: the next step would
        // be like this one
        let expected = trial.expected.abs();
        let ratio = if expected < accepted.noise { trial.left / expected } else { 0.0 };
        let stays = ratio > STAYS.start && (!indefinite || ratio < STAYS.end);
        let idle = stays && accepted.unbalanced <= BALANCED && !accepted.goes_on;
        if trial.fraction < 1.0 {
            None
        } else if still && !indefinite {
            Some(accepted.size)
        } else {
            idle.then_some(0.0)
        }
    }

    /// Whether contact forces have converged after a tiny step.
    fn balances(&self, engine: &Engine, residual: &Residual, trial: &CorrectedStep, accepted: &Accepted) -> bool {
        let nearly = trial.contact_change <= NEARLY && accepted.unbalanced <= NEARLY;
        residual.largest_contact_force() * (1.0 + trial.contact_change) <= engine.scales.nothing
            || nearly && accepted.size <= NEARLY * self.tol_increment
            || is_light(engine, residual, accepted.size, self.tol_increment)
            || trial.contact_change <= CONTACT_BALANCED.max(10.0 * self.tol_increment)
    }
}
