//! Lagrange shape functions on [0, 1] with equally spaced nodes, orders 1 to 3.

use crate::math::quadrature::{Rule, gauss};

/// Lagrange basis polynomial of the knot `index` at `x`, of degree count − 1: 1 at that knot and 0 at the others. The
/// `count` knots `knot(0)`, `knot(1)` … differ.
pub fn lagrange_weight(count: usize, knot: impl Fn(usize) -> f64, index: usize, x: f64) -> f64 {
    let here = knot(index);
    (0..count).filter(|&other| other != index).map(|other| (x - knot(other)) / (here - knot(other))).product()
}

/// Values and slopes dN/dξ of the order + 1 shape functions at ξ ∈ [0, 1]; unused entries are 0.
pub fn lagrange(order: usize, xi: f64) -> ([f64; 4], [f64; 4]) {
    let p = order as f64;
    let (mut n, mut d) = ([0.0; 4], [0.0; 4]);
    for a in 0..=order {
        let mut value = 1.0;
        let mut slope = 0.0;
        for b in (0..=order).filter(|&b| b != a) {
            let width = (a as f64 - b as f64) / p;
            let factor = (xi - b as f64 / p) / width;
            slope = slope * factor + value / width;
            value *= factor;
        }
        n[a] = value;
        d[a] = slope;
    }
    (n, d)
}

/// Shape functions of one order tabulated at its integration points (`order` Gauss points: one fewer than
/// nodes, so that thin elements lock neither in shear nor in membrane action).
#[derive(Debug, Clone)]
pub struct ShapeTable {
    /// Order p.
    pub order: usize,
    /// The rule.
    pub rule: Rule,
    /// N at each point.
    pub n: [[f64; 4]; 3],
    /// dN/dξ at each point, ξ ∈ [0, 1].
    pub d: [[f64; 4]; 3],
}

impl ShapeTable {
    /// Tabulates order 1, 2 or 3.
    pub fn new(order: usize) -> Self {
        let rule = gauss(order);
        let (mut n, mut d) = ([[0.0; 4]; 3], [[0.0; 4]; 3]);
        for (g, &xi) in rule.points.iter().enumerate() {
            (n[g], d[g]) = lagrange(order, xi);
        }
        Self { order, rule, n, d }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_functions_interpolate_and_slopes_match_differences() {
        for order in 1..=3 {
            for node in 0..=order {
                let (n, _) = lagrange(order, node as f64 / order as f64);
                for (a, &value) in n.iter().enumerate().take(order + 1) {
                    assert!((value - f64::from(u8::from(a == node))).abs() < 1e-15);
                }
            }
            let (xi, step) = (0.37, 1e-6);
            let (_, d) = lagrange(order, xi);
            let (plus, minus) = (lagrange(order, xi + step).0, lagrange(order, xi - step).0);
            for a in 0..4 {
                assert!((d[a] - (plus[a] - minus[a]) / (2.0 * step)).abs() < 1e-8);
            }
        }
    }
}
