//! Budget of a search: iterations without progress.

use crate::solve::problem::assembly::Potential;

/// Decrease of the potential over the stored energy, or advance of a motion over its remainder, that counts as
/// progress, because a snap of magnetic tweezers descends for 700 iterations by as much in a hundred.
const PROGRESS: f64 = 0.01;

/// Energy stored in rods and contact.
pub(in crate::solve) fn stored_energy(potential: &Potential) -> f64 {
    potential.elastic.total() + potential.contact.abs()
}

/// Iterations since the last progress.
#[derive(Debug)]
pub(super) struct SearchProgress {
    allowed: usize,
    idle: usize,
    potential: f64,
    remaining: f64,
}

impl SearchProgress {
    /// With this number of iterations allowed without progress.
    pub(super) fn new(allowed: usize) -> Self {
        Self { allowed, idle: 0, potential: f64::INFINITY, remaining: 1.0 }
    }

    /// Records the state before an iteration. Progress is a decrease of the potential by a hundredth of the stored
    /// energy, because a snap of magnetic tweezers descends for 700 iterations by as much in a hundred, or as large an
    /// advance of a prescribed motion, relative to its remainder.
    pub(super) fn see(&mut self, potential: &Potential, remaining: f64) {
        let total = potential.total();
        let falls = total < self.potential - PROGRESS * stored_energy(potential);
        let advances = remaining < (1.0 - PROGRESS) * self.remaining;
        if falls || advances {
            (self.idle, self.potential, self.remaining) = (0, total, remaining);
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
    use crate::rod::ElasticEnergies;

    fn at(potential: f64) -> Potential {
        Potential {
            elastic: ElasticEnergies { stretching: 1.0, ..ElasticEnergies::default() },
            load: potential - 1.0,
            ..Potential::default()
        }
    }

    #[test]
    fn descent_goes_on_and_standstill_does_not() {
        let mut progress = SearchProgress::new(3);
        for k in 0..100 {
            progress.see(&at(-0.01 * f64::from(k)), 0.0);
            assert!(!progress.is_over(), "{k}");
            progress.count();
        }
        (0..2).for_each(|_| progress.count());
        progress.see(&at(-0.99 - 1e-4), 0.0);
        assert!(progress.is_over());
    }

    #[test]
    fn a_push_that_advances_is_progress() {
        let mut progress = SearchProgress::new(2);
        for k in 1..100 {
            progress.see(&at(f64::from(k)), 0.99f64.powi(k));
            assert!(!progress.is_over(), "{k}");
            progress.count();
        }
    }
}
