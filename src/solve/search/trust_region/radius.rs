//! Radius of the trust region, by the outcome of the last steps.

use super::RAISING;
use crate::solve::measures::{ARC, MAX_ROUNDS};

/// Smallest first radius, rad, because a prediction is not known to be better than it was for the last state.
const SMALLEST_FIRST: f64 = 0.01;

/// Largest radius, rad.
pub(super) const LARGEST: f64 = 2.0;
/// Radius after a step that the model predicted well, relative to the extent taken.
const GROWTH: f64 = 3.0;
/// Decrease of the potential relative to the expected one, in which the model counts as right. Below one over its end
/// the radius shrinks.
const FORESEEN: std::ops::Range<f64> = 0.75..4.0;

/// Outcome of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepOutcome {
    /// Extent of the whole step: the largest rotation, rad, or relative displacement of strands in contact over their
    /// contact distance.
    pub(super) extent: f64,
    /// Fraction of it that was taken.
    pub(super) fraction: f64,
    /// Correction rounds.
    pub(super) rounds: usize,
    /// Decrease of the potential relative to the expected one; `None` below rounding, where a step counts as good.
    pub(super) gain: Option<f64>,
}

#[derive(Debug)]
pub(super) struct TrustRegion {
    /// Largest extent of a step.
    pub(super) radius: f64,
}

impl TrustRegion {
    /// At first as large as the end of the search is uncertain (rad).
    pub(super) fn new(uncertainty: f64) -> Self {
        Self { radius: uncertainty.clamp(SMALLEST_FIRST, ARC) }
    }

    /// After an accepted step.
    pub(super) fn accept(&mut self, step: StepOutcome) {
        let taken = step.fraction * step.extent;
        // half of the rounds allowed: with three, a knot that slides through itself repeats the same small step for
        // hundreds of iterations; without a bound steps under a hard penalty alternate
        if step.gain.is_none_or(|gain| step.rounds <= MAX_ROUNDS / 2 && FORESEEN.contains(&gain)) {
            self.radius = self.radius.max(GROWTH * taken).min(LARGEST);
        } else if step.gain.is_some_and(|gain| gain < 1.0 / FORESEEN.end) {
            self.radius = 0.5 * taken;
        } else if step.fraction < 1.0 {
            self.radius = taken;
        }
    }

    /// After a step of this extent was rejected.
    pub(super) fn reject(&mut self, extent: f64) {
        self.radius = self.radius.min(extent) / RAISING;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: StepOutcome = StepOutcome { extent: 0.1, fraction: 1.0, rounds: 1, gain: Some(1.0) };

    #[test]
    fn what_was_foreseen_makes_it_larger() {
        let mut trust = TrustRegion::new(f64::INFINITY);
        trust.reject(0.01);
        assert_eq!(trust.radius, 0.0025);
        trust.accept(StepOutcome { extent: 0.0025, ..STEP });
        assert_eq!(trust.radius, 0.0075);
        trust.accept(StepOutcome { extent: 10.0, ..STEP });
        assert_eq!(trust.radius, LARGEST);
    }

    #[test]
    fn it_begins_as_large_as_the_end_is_uncertain() {
        let begins = |uncertainty: f64| TrustRegion::new(uncertainty).radius;
        assert_eq!([1e-9, 0.03, f64::INFINITY].map(begins), [SMALLEST_FIRST, 0.03, ARC]);
    }

    #[test]
    fn what_was_not_foreseen_makes_it_smaller() {
        let after = |step: StepOutcome| {
            let mut trust = TrustRegion::new(f64::INFINITY);
            trust.accept(step);
            trust.radius
        };
        assert_eq!(after(STEP), 0.5); // larger than three times what was taken
        assert_eq!(after(StepOutcome { gain: Some(0.1), ..STEP }), 0.05);
        assert_eq!(after(StepOutcome { gain: Some(0.5), fraction: 0.2, ..STEP }), 0.2 * 0.1);
        assert_eq!(after(StepOutcome { gain: Some(0.5), ..STEP }), 0.5);
        assert_eq!(after(StepOutcome { gain: Some(1.0), rounds: 9, fraction: 0.5, ..STEP }), 0.05);
        assert_eq!(after(StepOutcome { gain: None, rounds: 9, ..STEP }), 0.5);
    }
}
