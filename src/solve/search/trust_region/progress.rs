//! Budget of a search: iterations in which it gets nowhere.

use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;
use crate::solve::search::newton::increment_size;

/// Displacement of a node over the node spacing, or rotation in rad, that counts as progress if the potential falls,
/// because the rods then lie elsewhere on the mesh. The potential alone does not tell: rods of a heap slide for
/// thousands of iterations by 1e-4 of the energy that is bent into its rings.
const ELSEWHERE: f64 = 1.0;
/// Advance of a prescribed motion, over its remainder, that counts as progress, because a hundred of them make most of
/// it.
const PROGRESS: f64 = 0.01;

/// Iterations since the last progress.
#[derive(Debug)]
pub(super) struct SearchProgress {
    allowed: usize,
    idle: usize,
    /// Where the search was at the last progress.
    state: State,
    last: Sight,
}

/// What a search sees of itself before an iteration.
#[derive(Debug, Clone, Copy)]
struct Sight {
    /// Potential \[F·L\]; always the same where there is none.
    potential: f64,
    /// Its rounding error \[F·L\].
    rounding: f64,
    /// Remaining part of prescribed motions.
    remaining: f64,
}

impl Sight {
    /// Whether it is progress over an earlier one, after nodes have moved as far as this, see [`increment_size`].
    fn is_beyond(&self, earlier: &Self, moved: f64) -> bool {
        let falls = self.potential < earlier.potential - self.rounding;
        falls && moved > ELSEWHERE || self.remaining < (1.0 - PROGRESS) * earlier.remaining
    }
}

impl SearchProgress {
    /// With this number of iterations allowed without progress, from a state.
    pub(super) fn new(allowed: usize, state: &State) -> Self {
        let last = Sight { potential: f64::INFINITY, rounding: 0.0, remaining: 1.0 };
        Self { allowed, idle: 0, state: state.clone(), last }
    }

    /// Records the state before an iteration, its potential \[F·L\] and the remaining part of prescribed motions.
    pub(super) fn see(&mut self, engine: &Engine, state: &State, residual: &Residual, at: (f64, f64)) {
        let sight = Sight { potential: at.0, rounding: residual.rounding, remaining: at.1 };
        let moved = increment_size(engine, &state.increment_since(&self.state));
        if self.last.potential.is_infinite() || sight.is_beyond(&self.last, moved) {
            self.idle = 0;
            self.state.clone_from(state);
            self.last = sight;
        }
    }

    /// Counts an iteration.
    pub(super) fn count(&mut self) {
        self.idle += 1;
    }

    /// Whether the budget is spent.
    pub(super) fn is_over(&self) -> bool {
        self.idle >= self.allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Sight = Sight { potential: 1.0, rounding: 1e-12, remaining: 1.0 };

    #[test]
    fn a_descent_that_leads_elsewhere_is_progress_and_no_other() {
        let lower = Sight { potential: 1.0 - 1e-9, ..START };
        assert!(lower.is_beyond(&START, 1.1));
        assert!(!lower.is_beyond(&START, 0.9));
        assert!(!START.is_beyond(&START, 100.0), "a motion that costs nothing");
        assert!(!Sight { potential: 1.0 - 1e-13, ..START }.is_beyond(&START, 100.0), "rounding");
    }

    #[test]
    fn a_push_that_advances_is_progress() {
        assert!(Sight { potential: 2.0, remaining: 0.98, ..START }.is_beyond(&START, 0.0));
        assert!(!Sight { potential: 2.0, remaining: 0.995, ..START }.is_beyond(&START, 10.0));
    }
}
