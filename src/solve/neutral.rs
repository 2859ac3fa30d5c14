//! Motions that cost nothing: rigid motions of rods nobody holds, and the spin of an isotropic closed rod about its own
//! centreline. The user never has to know of them.
//!
//! The tangent is singular along them; the residual has no component there. Springs added to the tangent at a few unknowns make it
//! regular and stay unstretched, so the increment is one of the exact solutions and the inertia is that of the tangent on
//! the rest; then the increment's neutral part is taken out, which leaves the shortest of all solutions.

use crate::math::Vec3;
use crate::solve::engine::Engine;
use crate::solve::state::State;
use crate::sparse::Pattern;

/// Rods with other free rods around them have rigid motions that contact may resist: their springs are only this strong,
/// a proximal term that shortens steps a little.
const SHARED: f64 = 1e-9;

fn is_free(engine: &Engine, rod: usize) -> bool {
    let wanted = if engine.model.planar { 3 } else { 6 };
    engine.free[engine.first_node[rod]..engine.first_node[rod + 1]].iter().all(|f| f.iter().filter(|x| **x).count() == wanted)
}

fn spins(engine: &Engine, rod: usize) -> bool {
    let data = &engine.model.rods[rod];
    let straight = matches!(data.natural, crate::rod::Natural::Straight)
        || matches!(data.natural, crate::rod::Natural::Uniform { kappa } if kappa[0] == 0.0 && kappa[1] == 0.0);
    data.closed && data.section.is_isotropic() && straight && !engine.model.planar
}

fn tangent_of(state: &State, node: usize) -> Vec3 {
    state.frames[node] * Vec3::z()
}

/// Adds the springs of all free rods to the tangent.
pub(crate) fn add_pins(engine: &Engine, state: &State, pattern: &Pattern, values: &mut [f64]) {
    for (index, rod) in engine.model.rods.iter().enumerate().filter(|(index, _)| is_free(engine, *index)) {
        let nodes = engine.first_node[index]..engine.first_node[index + 1];
        let factor = if engine.model.rods.len() == 1 { 1.0 } else { SHARED };
        let spacing = rod.length / (rod.num_elements * rod.order) as f64;
        let spring = factor * rod.section.bending[0] / spacing.powi(3);
        let turning = factor * rod.section.twisting / spacing;
        let first = nodes.start;
        pattern.add_block(values, first, first, |i, j| if i != j { 0.0 } else if i < 3 { spring } else { turning });
        if spins(engine, index) {
            // the node whose tangent is farthest from the first one's: there spin and rigid rotation differ most
            let axis = tangent_of(state, first);
            let along = |n: usize| tangent_of(state, n).dot(&axis);
            let other = nodes.min_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap_or(first);
            let d = tangent_of(state, other);
            let stiffness = rod.section.twisting / spacing;
            pattern.add_block(values, other, other, |i, j| {
                if i >= 3 && j >= 3 { stiffness * d[i - 3] * d[j - 3] } else { 0.0 }
            });
        }
    }
}

/// Takes the neutral part out of an increment (least squares, positions weighed against rotations by the rod's size). Only
/// where the motions are neutral for certain: a single free rod.
pub(crate) fn remove(engine: &Engine, state: &State, step: &mut [f64]) {
    if engine.model.rods.len() != 1 || !is_free(engine, 0) {
        return;
    }
    let num_nodes = engine.num_nodes();
    let centre = state.positions.iter().sum::<Vec3>() / num_nodes as f64;
    // displacements first: a rigid rotation taken out of a pure twist would stretch the rod by second order
    let lever = 1e-3 * engine.scales.length;
    let weight = |i: usize| if i % 6 < 3 { 1.0 } else { lever * lever };
    let mut modes: Vec<Vec<f64>> = Vec::new();
    let axes: &[Vec3] = if engine.model.planar { &[Vec3::new(0.0, 0.0, 1.0)] } else { &[Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)] };
    let dims = if engine.model.planar { 2 } else { 3 };
    let mode = |f: &dyn Fn(usize) -> (Vec3, Vec3)| -> Vec<f64> {
        (0..num_nodes)
            .flat_map(|n| {
                let (d, r) = f(n);
                [d.x, d.y, d.z, r.x, r.y, r.z]
            })
            .collect()
    };
    for k in 0..dims {
        modes.push(mode(&|_| (Vec3::ith(k, 1.0), Vec3::zeros())));
    }
    for axis in axes {
        modes.push(mode(&|n| (axis.cross(&(state.positions[n] - centre)), *axis)));
    }
    if spins(engine, 0) {
        modes.push(mode(&|n| (Vec3::zeros(), tangent_of(state, n))));
    }
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).enumerate().map(|(i, (x, y))| weight(i) * x * y).sum() };
    for k in 0..modes.len() {
        let (done, rest) = modes.split_at_mut(k);
        let current = &mut rest[0];
        for earlier in done.iter() {
            let part = dot(current, earlier);
            subtract(current, earlier, part);
        }
        let norm = dot(current, current).sqrt();
        if norm > 0.0 {
            current.iter_mut().for_each(|x| *x /= norm);
        }
        let part = dot(step, current);
        subtract(step, current, part);
    }
}

fn subtract(x: &mut [f64], direction: &[f64], amount: f64) {
    for (a, b) in x.iter_mut().zip(direction) {
        *a -= amount * b;
    }
}
