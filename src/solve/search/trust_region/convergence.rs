//! When a guarded search has come to rest.

use super::corrected_step::CorrectedStep;
use super::step::ModelStep;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;

/// Change of contact forces in the last step, over the largest force, up to which a state is at rest. Lightly loaded
/// contact feels increments far below the tolerance.
const TOL_CONTACT_CHANGE: f64 = 1e-6;
/// The same for a search that only prepares the next one.
const STEADY: f64 = 0.3;
/// Increment, over the tolerance, below which a state is at rest although contact forces still change: strands that
/// touch without load press by rounding alone. Forces must be nearly balanced, or contact unloaded.
const IMMOBILE: f64 = 1e-4;
/// Change and imbalance of contact forces, relative, up to which they are nearly balanced.
const NEARLY_BALANCED: f64 = 1e-3;
/// Rotation, rad, that the largest contact force can cause, up to which contact is unloaded.
const UNLOADED: f64 = 1e-6;
/// Relative residual below which shifted steps that stay tiny mean rest at a saddle.
const TOL_SADDLE: f64 = 1e-8;
/// Ratio of expected decreases over three steps. Decreases too small for the potential that fall by less (or, under a
/// shift, grow by less than the inverse) are rounding.
const SETTLING: f64 = 0.1;

/// A step that was accepted, in numbers.
pub(super) struct Accepted {
    /// Its increment, see [`increment_size`](crate::solve::search::newton::increment_size).
    pub(super) size: f64,
    /// Relative residual before it.
    pub(super) unbalanced: f64,
    /// Changes of the potential that rounding makes.
    pub(super) noise: f64,
    /// Shift that it was made with.
    pub(super) shift: f64,
    /// Supports have farther to go after it.
    pub(super) goes_on: bool,
}

/// What tells rest, over the steps of a search.
pub(super) struct Convergence {
    tol_increment: f64,
    /// Extent of a step with which a search ends that only prepares the next one.
    rough: Option<f64>,
    /// Tiny shifted steps in a row.
    at_saddle: usize,
    /// Decreases that were expected of full steps in a row, too small for the potential to tell.
    decrements: Vec<f64>,
}

impl Convergence {
    pub(super) fn new(tol_increment: f64, rough: Option<f64>) -> Self {
        Self { tol_increment, rough, at_saddle: 0, decrements: Vec::new() }
    }

    /// Below the tolerance rounding decides over decrease and corrections.
    pub(super) fn is_tiny(&self, size: f64, trial: &CorrectedStep) -> bool {
        size <= self.tol_increment && trial.potential.is_finite()
    }

    /// Whether an accepted step goes nowhere though forces are out of balance: its shift makes it shorter than the
    /// tolerance, and so acceptable, when nothing longer was. Where strands have no room left that goes on for ever.
    pub(super) fn is_stuck(&self, accepted: &Accepted) -> bool {
        accepted.shift > 0.0 && accepted.size <= self.tol_increment && accepted.unbalanced > NEARLY_BALANCED
    }

    /// Whether the search has come to rest with an accepted step from where `residual` is.
    pub(super) fn is_reached(
        &mut self,
        engine: &Engine,
        residual: &Residual,
        (step, trial): (&ModelStep, &CorrectedStep),
        accepted: &Accepted,
    ) -> bool {
        let tiny = self.is_tiny(accepted.size, trial);
        let indefinite = accepted.shift > 0.0;
        let still = match self.rough {
            None => tiny && self.balances(engine, residual, trial, accepted),
            // relative motion decides, for a long rod swings far by little, once forces have found their places: the
            // end of a line of contact moves by about a layer (B/κ)^¼ an iteration, so it has less far to go under the
            // softer law
            Some(tol) => step.extent <= tol && (tiny || trial.contact_change <= STEADY),
        };
        // shifted steps that stay tiny have come to a saddle: whoever asked decides whether to leave it
        // (large shifts make any step tiny: the residual must have gone too)
        let balanced = accepted.unbalanced <= TOL_SADDLE;
        self.at_saddle = if tiny && indefinite && balanced { self.at_saddle + 1 } else { 0 };
        // what keeps moving without a change of the potential or a force is rounding along motions that nothing resists
        let expected = trial.expected.abs();
        if expected >= accepted.noise || trial.fraction < 1.0 || accepted.goes_on {
            self.decrements.clear();
        } else {
            self.decrements.push(expected);
        }
        // what leaves a saddle grows, by far more than that in three steps
        let stays = |last: f64, before: f64| last > SETTLING * before && (!indefinite || SETTLING * last < before);
        let idle = balanced && matches!(self.decrements[..], [.., before, _, _, last] if stays(last, before));
        trial.fraction == 1.0 && (still && !indefinite || self.at_saddle >= 3 || idle)
    }

    /// Whether contact forces are those of rest after a tiny step.
    fn balances(&self, engine: &Engine, residual: &Residual, trial: &CorrectedStep, accepted: &Accepted) -> bool {
        let nearly = trial.contact_change <= NEARLY_BALANCED && accepted.unbalanced <= NEARLY_BALANCED;
        let light =
            accepted.size <= IMMOBILE * self.tol_increment && (nearly || contact_bends(engine, residual) <= UNLOADED);
        light || trial.contact_change <= TOL_CONTACT_CHANGE.max(10.0 * self.tol_increment)
    }
}

/// Size of the rotations, rad, that the largest contact force makes: F L²/B.
fn contact_bends(engine: &Engine, residual: &Residual) -> f64 {
    let force = residual.contact_gradient.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    force * engine.scales.length.powi(2) / engine.scales.bending
}
