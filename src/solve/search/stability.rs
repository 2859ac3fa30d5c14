//! Shifts that leave no negative eigenvalue, the lowest eigenvalue, and the direction in which an unstable equilibrium
//! is left.

use crate::error::SolveError;
use crate::solve::measures::MAX_ITERATIONS;
use crate::solve::problem::engine::Engine;
use crate::solve::search::workspace::Workspace;

impl Workspace {
    /// Factorises with `shift`, raised by factors of `climbing` until no eigenvalue is negative; the shift then.
    ///
    /// # Errors
    /// When no shift makes the tangent positive definite.
    pub(super) fn convex_shift(
        &mut self,
        engine: &Engine,
        mut shift: f64,
        climbing: f64,
        iteration: usize,
    ) -> Result<f64, SolveError> {
        // a matrix that is not positive definite with so much more has broken down
        let most = shift / f64::EPSILON.powi(2);
        while shift <= most {
            if self.factorise(engine, shift) == Some(0) {
                return Ok(shift);
            }
            shift *= climbing;
        }
        Err(SolveError::Factorisation { iteration, shift })
    }

    /// Lowest eigenvalue of the factorised (positive definite) tangent + shift × mass, from above, by a few inverse
    /// iterations that start from the last such vector.
    pub(crate) fn lowest_above(&mut self, engine: &Engine, rounds: usize) -> f64 {
        let mass = &engine.metric;
        if self.softest.len() != mass.len() {
            // a fixed start with components everywhere, so that runs repeat; displacements in lengths of the rod, so
            // that of several critical directions it finds the same one in every unit
            let size = |i: usize| if i % 6 < 3 { engine.scales.length } else { 1.0 };
            let start = |i: usize| (((i + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5) * size(i);
            self.softest = (0..mass.len()).map(start).collect();
        }
        let mut lowest = f64::INFINITY;
        for _ in 0..rounds {
            let norm: f64 = self.softest.iter().zip(mass).map(|(x, m)| x * x * m).sum::<f64>().sqrt();
            self.softest.iter_mut().for_each(|x| *x /= norm);
            let rhs: Vec<f64> = self.softest.iter().zip(mass).map(|(x, m)| x * m).collect();
            let next = self.solve_last(&rhs);
            // Rayleigh quotient of the inverse
            lowest = 1.0 / next.iter().zip(&rhs).map(|(x, r)| x * r).sum::<f64>();
            self.softest = next;
        }
        lowest
    }

    /// Direction of the most negative eigenvalue of the tangent at the engine's state (mass-weighted inverse iteration
    /// from a fixed start, so that runs repeat), scaled so that the largest rotation is 1 rad. Call after
    /// [`Workspace::count_unstable`].
    ///
    /// # Errors
    /// When no shift makes the tangent positive definite.
    pub(crate) fn negative_direction(&mut self, engine: &mut Engine) -> Result<Vec<f64>, SolveError> {
        // finely, because the nearer the shift is to the lowest eigenvalue, the better that one stands out
        self.convex_shift(engine, 1.0, 2.0, 0)?;
        // from the fixed start, whatever the searches before have left
        self.softest.clear();
        // so few rounds that something of other modes stays in it: a direction converged to rounding has the symmetry
        // of the state, and rounding would decide which of two mirror images comes next
        self.lowest_above(engine, MAX_ITERATIONS);
        let turn = self.softest.chunks(6).flat_map(|n| &n[3..]).fold(0.0f64, |a, b| a.max(b.abs()));
        let scale = if turn > 0.0 { 1.0 / turn } else { 1.0 };
        Ok(self.softest.iter().map(|x| x * scale).collect())
    }
}
