//! Guesses of feet along a piece of contact, from those found so far: projections start near their end.

use super::integral::POINTS_PER_PIECE;

/// Both ends of a piece and all points of its rule.
const MAX_PLACES: usize = POINTS_PER_PIECE + 2;

/// A polynomial through known places, up to a few, to guess the next.
pub(super) struct Interpolation {
    u: [f64; MAX_PLACES],
    /// Divided differences of the last place and those before.
    slopes: [f64; MAX_PLACES],
    count: usize,
}

impl Interpolation {
    /// The line through two places (u, v).
    pub(super) fn between(first: [f64; 2], last: [f64; 2]) -> Self {
        let mut line = Self { u: [0.0; MAX_PLACES], slopes: [0.0; MAX_PLACES], count: 0 };
        line.add(first[0], first[1]);
        line.add(last[0], last[1]);
        line
    }

    /// The guess at u.
    pub(super) fn at(&self, u: f64) -> f64 {
        (0..self.count).rev().fold(0.0, |sum, k| self.slopes[k] + sum * (u - self.u[k]))
    }

    /// Adds a place; one that is known already tells nothing new (pieces of no width, where strands just touch).
    pub(super) fn add(&mut self, u: f64, v: f64) {
        if self.u[..self.count].contains(&u) {
            return;
        }
        let mut slope = v;
        for k in 0..self.count {
            slope = (slope - self.slopes[k]) / (u - self.u[k]);
        }
        (self.u[self.count], self.slopes[self.count]) = (u, slope);
        self.count += 1;
    }
}
