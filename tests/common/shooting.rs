//! For boundary value problems that tests solve by shooting: Newton's method with differences, products of vectors that
//! are parts of a state.

#![allow(dead_code)] // every test file uses its part

const MAX_NEWTON: usize = 60;

/// Solves a small system by elimination with row exchanges.
pub fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).fold(k, |best, i| if a[i][k].abs() > a[best][k].abs() { i } else { best });
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            for j in k..n {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - sum) / a[k][k];
    }
    b
}

/// Largest of some numbers, infinite where one is none.
pub fn size(r: &[f64]) -> f64 {
    r.iter().fold(0.0f64, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b.abs()) })
}

/// A zero of the residuals from a guess, and the largest residual left; steps are halved until the residual falls.
pub fn zero_of(residuals: impl Fn(&[f64]) -> Vec<f64>, guess: &[f64]) -> (Vec<f64>, f64) {
    let mut x = guess.to_vec();
    let mut r = residuals(&x);
    for _ in 0..MAX_NEWTON {
        let columns: Vec<Vec<f64>> = (0..x.len())
            .map(|j| {
                let h = 1e-6 * x[j].abs().max(1e-2);
                let moved = |by: f64| {
                    let mut y = x.clone();
                    y[j] += by;
                    residuals(&y)
                };
                moved(h).iter().zip(&moved(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
            })
            .collect();
        let rows = (0..r.len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect();
        let change = solve(rows, r.clone());
        let mut fraction = 1.0;
        loop {
            let trial: Vec<f64> = x.iter().zip(&change).map(|(x, c)| x - fraction * c).collect();
            let there = residuals(&trial);
            if size(&there) < size(&r) {
                (x, r) = (trial, there);
                break;
            }
            fraction *= 0.5;
            if fraction < 1e-6 {
                return (x, size(&r));
            }
        }
        if size(&r) < 1e-14 {
            break;
        }
    }
    let left = size(&r);
    (x, left)
}

/// a × b.
pub fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a · b.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
