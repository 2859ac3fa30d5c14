//! Fixed-axis moments in three dimensions.
//!
//! A dead moment m does work m·δθ on spatial rotations but has no potential, and the exact derivative of its residual
//! is not symmetric: in the coordinates of the update q ← exp(θ/2) q the tangent at equilibrium is K − ½[m×] on the
//! rotations of the loaded node (Simo & Vu-Quoc 1986 on the lost symmetry of the tangent). The factorisation stays
//! symmetric; the few skew blocks are added by the Woodbury formula.

use nalgebra::{DMatrix, DVector};

use crate::math::Vec3;
use crate::solve::problem::engine::Engine;

/// Turns the solution `x` of K x = b into that of (K − ½[m×]) x = b; `solve` solves K x = b. Nothing happens without
/// moments or in planar scenes, where a moment has a potential.
pub(crate) fn add_moment_skew(engine: &Engine, x: &mut [f64], mut solve: impl FnMut(&[f64]) -> Vec<f64>) {
    if engine.is_conservative() {
        return;
    }
    let loaded = loaded_rotations(engine);
    let size = 3 * loaded.len();
    let mut skew = DMatrix::<f64>::zeros(size, size);
    let mut responses = Vec::with_capacity(size);
    for (k, (node, moment)) in loaded.iter().enumerate() {
        let block = moment.cross_matrix() * -0.5;
        skew.view_mut((3 * k, 3 * k), (3, 3)).copy_from(&block);
        for axis in 0..3 {
            let mut unit = vec![0.0; x.len()];
            unit[6 * node + 3 + axis] = 1.0;
            responses.push(solve(&unit));
        }
    }
    let rotation = |v: &[f64], i: usize| v[6 * loaded[i / 3].0 + 3 + i % 3];
    let compliance = DMatrix::from_fn(size, size, |i, j| rotation(&responses[j], i));
    let here = DVector::from_fn(size, |i, _| rotation(x, i));
    let system = DMatrix::identity(size, size) + &skew * compliance;
    // singular only where the loaded equilibrium is: then the symmetric step is as good as any
    let Some(weights) = system.lu().solve(&(&skew * here)) else { return };
    for (response, weight) in responses.iter().zip(weights.iter()) {
        for (x, r) in x.iter_mut().zip(response) {
            *x -= weight * r;
        }
    }
}

/// Work of the moments along an increment \[F·L\]. Rotations go about one axis each, so that it is m·θ even where
/// moments have no potential.
pub(crate) fn work_of_moments(engine: &Engine, increment: &[f64]) -> f64 {
    let rotation = |node: usize| Vec3::from_column_slice(&increment[6 * node + 3..6 * node + 6]);
    moments(engine).map(|(node, moment)| moment.dot(&rotation(node))).fold(0.0, |sum, work| sum + work)
}

/// Nodes with the moments that act on them at the present load factor, a node as often as it has moments.
fn moments(engine: &Engine) -> impl Iterator<Item = (usize, Vec3)> {
    let model = &engine.model;
    let at_nodes = model.loads.iter().map(|l| (engine.first_node[l.node.rod] + l.node.node, l.moment));
    let along = model.line_loads.iter().filter(|l| l.moment != Vec3::zeros());
    let along = along.flat_map(|l| engine.shares(l.rod).map(|(node, share)| (node, l.moment * share)));
    let acting = at_nodes.filter(|(_, moment)| *moment != Vec3::zeros()).chain(along);
    acting.map(|(node, moment)| (node, moment * engine.state.load_factor))
}

/// Nodes with a moment, and the moment at the present load factor.
fn loaded_rotations(engine: &Engine) -> Vec<(usize, Vec3)> {
    let mut loaded: Vec<(usize, Vec3)> = Vec::new();
    for (node, moment) in moments(engine) {
        match loaded.iter_mut().find(|(n, _)| *n == node) {
            Some((_, sum)) => *sum += moment,
            None => loaded.push((node, moment)),
        }
    }
    loaded
}
