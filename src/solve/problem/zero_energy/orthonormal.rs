//! Motions as vectors, six numbers a node: their product, an orthonormal basis, and what is taken out of others.

use super::TOLERANCE;
use crate::math::parallel;

/// The weighted product of two motions, six numbers a node: displacements and rotations have a weight each.
pub(super) fn weighted(weights: [f64; 2], a: &[f64], b: &[f64]) -> f64 {
    parallel::sum(a.len() / 6, parallel::CHEAP, &|nodes| {
        let part = 6 * nodes.start..6 * nodes.end;
        let numbers = a[part.clone()].iter().zip(&b[part]).enumerate();
        numbers.map(|(i, (x, y))| weights[usize::from(i % 6 >= 3)] * x * y).sum()
    })
}

/// Size below which a combination of motions is none: a straight rod between coaxial clamps turns back as much as it
/// turns.
pub(super) fn least_size<'a>(weights: [f64; 2], motions: impl Iterator<Item = &'a Vec<f64>>) -> f64 {
    let size = |motion: &Vec<f64>| weighted(weights, motion, motion).sqrt();
    TOLERANCE * motions.map(size).fold(f64::INFINITY, f64::min)
}

/// Orthonormalises a motion against those of a basis and adds it; false if it depends on them, or is none.
pub(super) fn add(weights: [f64; 2], basis: &mut Vec<Vec<f64>>, mut motion: Vec<f64>, least: f64) -> bool {
    let before = weighted(weights, &motion, &motion).sqrt();
    // twice is enough
    for _ in 0..2 {
        for earlier in basis.iter() {
            let part = weighted(weights, &motion, earlier);
            subtract(&mut motion, earlier, part);
        }
    }
    let norm = weighted(weights, &motion, &motion).sqrt();
    if norm <= least.max(TOLERANCE * before) {
        return false;
    }
    motion.iter_mut().for_each(|x| *x /= norm);
    basis.push(motion);
    true
}

/// Takes the force out of a gradient that does this work on a motion.
pub(super) fn subtract_force(gradient: &mut [f64], motion: &[f64], work: f64, weights: [f64; 2]) {
    for (i, (g, v)) in gradient.iter_mut().zip(motion).enumerate() {
        *g -= work * weights[usize::from(i % 6 >= 3)] * v;
    }
}

/// Takes so much of a direction out of a vector.
pub(super) fn subtract(x: &mut [f64], direction: &[f64], amount: f64) {
    parallel::each_part(x, 6 * parallel::CHEAP, &|first, part| {
        part.iter_mut().zip(&direction[first..]).for_each(|(a, b)| *a -= amount * b);
    });
}
