//! Dead forces and moments, line loads, pressure.

use super::scatter::Blocks;
use super::{Residual, Sink};
use crate::math::Vec3;
use crate::math::quadrature::gauss;
use crate::math::shape_functions::lagrange;
use crate::scene::LineLoad;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

impl Engine {
    /// Dead forces and moments, line loads, pressure.
    pub(in crate::solve) fn add_loads(&self, state: &State, out: &mut Residual, mut sink: Option<&mut Sink>) {
        let factor = state.load_factor;
        for load in &self.model.loads {
            let node = self.first_node[load.node.rod] + load.node.node;
            for k in 0..3 {
                add_load(out, 6 * node + k, factor * load.force[k]);
                add_load(out, 6 * node + 3 + k, factor * load.moment[k]);
            }
            out.potential.load -= factor * load.force.dot(&state.positions[node]);
        }
        for load in &self.model.line_loads {
            self.add_line_load(load, factor, state, out);
        }
        for rod in (0..state.pressures.len()).filter(|&rod| state.pressures[rod] != 0.0) {
            self.add_pressure(rod, state, out, sink.as_deref_mut());
        }
    }

    fn add_line_load(&self, load: &LineLoad, factor: f64, state: &State, out: &mut Residual) {
        for (node, share) in self.shares(load.rod) {
            let (force, moment) = (load.force * factor * share, load.moment * factor * share);
            for k in 0..3 {
                add_load(out, 6 * node + k, force[k]);
                add_load(out, 6 * node + 3 + k, moment[k]);
            }
            out.potential.load -= force.dot(&state.positions[node]);
        }
    }

    /// Nodes of a rod, element by element, with their shares ∫N_a ds \[L\] of a line load.
    pub(crate) fn shares(&self, rod: usize) -> impl Iterator<Item = (usize, f64)> {
        let order = self.model.rods[rod].order;
        let (weights, length) = (integrals(order).0, self.element_length(rod));
        let elements = self.elements.iter().filter(move |e| e.rod == rod);
        elements.flat_map(move |e| (0..=order).map(move |a| (e.nodes[a], weights[a] * length)))
    }

    /// Pressure p on a closed planar rod has the potential p × enclosed area, ±½∮(x dy − y dx): minus for rods that
    /// start clockwise.
    fn add_pressure(&self, rod: usize, state: &State, out: &mut Residual, mut sink: Option<&mut Sink>) {
        let order = self.model.rods[rod].order;
        let pressure = state.pressures[rod] * turning(&self.model.rods[rod].positions);
        let skew = integrals(order).1;
        for element in self.elements.iter().filter(|e| e.rod == rod) {
            let mut blocks: Blocks = [[0.0; 24]; 24];
            for a in 0..=order {
                for c in 0..=order {
                    // ½ p (N_a N_c' − N_a' N_c) x_a y_c
                    let factor = 0.5 * pressure * skew[a][c];
                    let (p, q) = (element.nodes[a], element.nodes[c]);
                    let (x, y) = (state.positions[p].x, state.positions[q].y);
                    out.potential.load += factor * x * y;
                    out.gradient[6 * p] += factor * y;
                    out.magnitude[6 * p] += (factor * y).abs();
                    out.gradient[6 * q + 1] += factor * x;
                    out.magnitude[6 * q + 1] += (factor * x).abs();
                    blocks[6 * a][6 * c + 1] += factor;
                    blocks[6 * c + 1][6 * a] += factor;
                }
            }
            if let Some(sink) = &mut sink {
                sink.add(&element.nodes[..=order], &blocks);
            }
        }
    }
}

/// 1 for a closed polygon in the x-y plane that runs counter-clockwise, −1 for a clockwise one.
fn turning(polygon: &[Vec3]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    // about one of its points, because areas far from the origin cancel
    let area = polygon.iter().zip(next).map(|(a, b)| (a - polygon[0]).xy().perp(&(b - polygon[0]).xy())).sum::<f64>();
    area.signum()
}

fn add_load(out: &mut Residual, unknown: usize, force: f64) {
    out.gradient[unknown] -= force;
    out.magnitude[unknown] += force.abs();
}

/// ∫N_a dξ and ∫(N_a N_c' − N_a' N_c) dξ on the unit element.
fn integrals(order: usize) -> ([f64; 4], [[f64; 4]; 4]) {
    let rule = gauss(5);
    let (mut mass, mut skew) = ([0.0; 4], [[0.0; 4]; 4]);
    for (&xi, &w) in rule.points.iter().zip(rule.weights) {
        let (n, d) = lagrange(order, xi);
        for a in 0..=order {
            mass[a] += w * n[a];
            for c in 0..=order {
                skew[a][c] += w * (n[a] * d[c] - d[a] * n[c]);
            }
        }
    }
    (mass, skew)
}
