//! Unstable equilibria: the direction that leaves them.

use crate::error::SolveError;
use crate::solve::engine::Engine;
use crate::solve::newton::{Workspace, for_each_mass};

impl Workspace {
    /// Direction of the most negative eigenvalue of the tangent at the engine's state (mass-weighted inverse iteration from a
    /// fixed start, so that runs repeat), scaled so that the largest rotation is 1 rad. Call after [`Workspace::count_unstable`].
    ///
    /// # Errors
    /// When no shift makes the tangent positive definite.
    pub fn negative_direction(&mut self, engine: &mut Engine) -> Result<Vec<f64>, SolveError> {
        let mut shift = 1.0;
        while self.factorise(engine, shift) != Some(0) {
            shift *= 2.0;
            if shift > 1e30 {
                return Err(SolveError::Factorisation { iteration: 0, shift });
            }
        }
        let mut mass = vec![0.0; 6 * engine.num_nodes()];
        for_each_mass(engine, |node, k, m| mass[6 * node + k] = m);
        let mut vector: Vec<f64> =
            (0..mass.len()).map(|i| ((i + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5).collect();
        for _ in 0..60 {
            let rhs: Vec<f64> = vector.iter().zip(&mass).map(|(x, m)| x * m).collect();
            vector = self.solve_last(engine, &rhs);
            let norm: f64 = vector.iter().zip(&mass).map(|(x, m)| x * x * m).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= norm);
        }
        let turn = vector.chunks(6).flat_map(|n| &n[3..]).fold(0.0f64, |a, b| a.max(b.abs()));
        let scale = if turn > 0.0 { 1.0 / turn } else { 1.0 };
        Ok(vector.into_iter().map(|x| x * scale).collect())
    }
}
