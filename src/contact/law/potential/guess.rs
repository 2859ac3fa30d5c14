//! Guesses of feet along a piece of contact, extrapolated from those found so far, so that projections need few
//! iterations.

/// A polynomial through at most `N` known points, which extrapolates to the next.
pub(super) struct Interpolation<const N: usize> {
    u: [f64; N],
    /// Divided differences of the last point and those before.
    slopes: [f64; N],
    count: usize,
}

impl<const N: usize> Interpolation<N> {
    /// The line through two points (u, v).
    pub(super) fn between(first: [f64; 2], last: [f64; 2]) -> Self {
        let mut line = Self { u: [0.0; N], slopes: [0.0; N], count: 0 };
        line.add(first[0], first[1]);
        line.add(last[0], last[1]);
        line
    }

    /// The guess at u.
    pub(super) fn at(&self, u: f64) -> f64 {
        (0..self.count).rev().fold(0.0, |sum, k| self.slopes[k] + sum * (u - self.u[k]))
    }

    /// Adds a point. A point that is known already is skipped (pieces of no width, where strands just touch).
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
