//! Gauss–Legendre rules on [0, 1].

/// A quadrature rule on [0, 1]: points and weights (weights sum to 1).
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// Points in (0, 1), ascending.
    pub points: &'static [f64],
    /// Weights.
    pub weights: &'static [f64],
}

const P1: [f64; 1] = [0.5];
const W1: [f64; 1] = [1.0];
const P2: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
const W2: [f64; 2] = [0.5, 0.5];
const P3: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];
const W3: [f64; 3] = [0.277_777_777_777_777_8, 0.444_444_444_444_444_4, 0.277_777_777_777_777_8];
const P5: [f64; 5] =
    [0.046_910_077_030_668, 0.230_765_344_947_158_5, 0.5, 0.769_234_655_052_841_5, 0.953_089_922_969_332];
const W5: [f64; 5] = [
    0.118_463_442_528_094_54,
    0.239_314_335_249_683_23,
    0.284_444_444_444_444_44,
    0.239_314_335_249_683_23,
    0.118_463_442_528_094_54,
];

/// The rule with 1, 2, 3 or 5 points; exact for polynomials of degree 2n − 1.
///
/// # Panics
/// For any other number of points (a programming error).
pub fn gauss(num_points: usize) -> Rule {
    match num_points {
        1 => Rule { points: &P1, weights: &W1 },
        2 => Rule { points: &P2, weights: &W2 },
        3 => Rule { points: &P3, weights: &W3 },
        5 => Rule { points: &P5, weights: &W5 },
        _ => panic!("no Gauss rule with {num_points} points is tabulated"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_polynomials_exactly() {
        for n in [1, 2, 3, 5] {
            let rule = gauss(n);
            for degree in 0..2 * n {
                let sum: f64 = rule.points.iter().zip(rule.weights).map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (degree + 1) as f64).abs() < 4e-16, "n {n} degree {degree}: {sum}");
            }
        }
    }
}
