//! Budget of a search: iterations without progress.

use crate::solve::measures::NOTHING;
use crate::solve::problem::assembly::Potential;

/// Decrease of the potential over the stored energy, or advance of a motion over its remainder, that counts as
/// progress, because a snap of magnetic tweezers descends for 700 iterations by as much in a hundred.
const PROGRESS: f64 = 0.01;

/// Fall in the second half of the iterations allowed, over that in the first, with which a search goes on, because one
/// that leaves a saddle falls faster and faster: rods of a heap that roll off each other, by 1e-4 of the energy of its
/// rings. At most some thirty times in a row, by as many factors of two.
const FASTER: f64 = 2.0;

/// Energy stored in rods and contact.
pub(in crate::solve) fn stored_energy(potential: &Potential) -> f64 {
    potential.elastic.total() + potential.contact.abs()
}

/// Iterations since the last progress.
#[derive(Debug)]
pub(super) struct SearchProgress {
    allowed: usize,
    idle: usize,
    /// At the last progress, half of the allowed iterations later, and now \[F·L\].
    potential: f64,
    halfway: f64,
    last: f64,
    /// Fall that is none \[F·L\].
    unseen: f64,
    remaining: f64,
}

impl SearchProgress {
    /// With this number of iterations allowed without progress.
    pub(super) fn new(allowed: usize) -> Self {
        let none = f64::INFINITY;
        Self { allowed, idle: 0, potential: none, halfway: none, last: none, unseen: 0.0, remaining: 1.0 }
    }

    /// Records the state before an iteration. Progress is a decrease of the potential by a hundredth of the stored
    /// energy, or as large an advance of a prescribed motion, relative to its remainder; when the budget is spent, a
    /// fall that becomes faster.
    pub(super) fn see(&mut self, potential: &Potential, remaining: f64) {
        let total = potential.total();
        let falls = total < self.potential - PROGRESS * stored_energy(potential);
        let advances = remaining < (1.0 - PROGRESS) * self.remaining;
        if falls || advances || self.idle >= self.allowed && self.falls_faster() {
            (self.idle, self.potential, self.remaining) = (0, total, remaining);
        }
        if 2 * self.idle <= self.allowed {
            self.halfway = total;
        }
        (self.last, self.unseen) = (total, NOTHING * stored_energy(potential));
    }

    fn falls_faster(&self) -> bool {
        let (first, second) = (self.potential - self.halfway, self.halfway - self.last);
        first > self.unseen && second > FASTER * first
    }

    /// Counts an iteration.
    pub(super) fn count(&mut self) {
        self.idle += 1;
    }

    /// Whether the budget is spent.
    pub(super) fn is_over(&self) -> bool {
        self.idle >= self.allowed && !self.falls_faster()
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

    /// As from a saddle: little, but more and more, until it falls evenly.
    #[test]
    fn a_descent_that_becomes_faster_goes_on() {
        let mut progress = SearchProgress::new(10);
        let mut fall = 1e-8;
        for k in 0..60 {
            progress.see(&at(-fall), 0.0);
            assert!(!progress.is_over(), "{k}");
            progress.count();
            fall *= 1.2;
        }
        let over = (0..30).position(|k| {
            progress.see(&at(-fall * (1.0 + 1e-3 * f64::from(k))), 0.0);
            progress.count();
            progress.is_over()
        });
        assert!(over.is_some_and(|k| k < 25), "{over:?}");
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
