//! Interpolation of a fixed high degree on [−1, 1]: points, quadrature and differentiation for smooth functions.

use std::f64::consts::PI;

/// Polynomial degree; the points include both ends.
pub(crate) const DEGREE: usize = 8;

/// Chebyshev points on [−1, 1] with Clenshaw–Curtis weights and differentiation matrix (Trefethen 2000, ch. 6, 12).
pub(crate) struct ChebyshevRule {
    pub nodes: [f64; DEGREE + 1],
    pub weights: [f64; DEGREE + 1],
    pub derivative: [[f64; DEGREE + 1]; DEGREE + 1],
}

impl ChebyshevRule {
    pub fn new() -> Self {
        let angle = |k: usize| PI * k as f64 / DEGREE as f64;
        let nodes = std::array::from_fn(|k| -angle(k).cos());
        let end = |k: usize| if k == 0 || k == DEGREE { 2.0 } else { 1.0 };
        let weights = std::array::from_fn(|k| {
            let term = |j: usize| {
                let b = if 2 * j == DEGREE { 1.0 } else { 2.0 };
                b * (2.0 * j as f64 * angle(k)).cos() / (4 * j * j - 1) as f64
            };
            (1.0 - (1..=DEGREE / 2).map(term).sum::<f64>()) * 2.0 / (end(k) * DEGREE as f64)
        });
        let mut derivative = [[0.0; DEGREE + 1]; DEGREE + 1];
        for i in 0..=DEGREE {
            for j in (0..=DEGREE).filter(|&j| j != i) {
                let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
                derivative[i][j] = sign * end(i) / (end(j) * (nodes[i] - nodes[j]));
                derivative[i][i] -= derivative[i][j];
            }
        }
        Self { nodes, weights, derivative }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_and_slopes_are_exact_for_polynomials() {
        let rule = ChebyshevRule::new();
        for power in 0..=DEGREE as i32 {
            let sum: f64 = (0..=DEGREE).map(|k| rule.weights[k] * rule.nodes[k].powi(power)).sum();
            let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
            assert!((sum - exact).abs() < 1e-14);
            for i in 0..=DEGREE {
                let slope: f64 = (0..=DEGREE).map(|j| rule.derivative[i][j] * rule.nodes[j].powi(power)).sum();
                let exact = if power == 0 { 0.0 } else { f64::from(power) * rule.nodes[i].powi(power - 1) };
                assert!((slope - exact).abs() < 1e-12);
            }
        }
    }
}
