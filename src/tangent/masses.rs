//! The mass matrix M of rods: lumped at the nodes.
//!
//! A rod has the line density μ. The tube about it, a solid cylinder of the contact radius ε, resists rotations: μ ε²/4
//! about its diameters, μ ε²/2 about its axis. A rod without a contact radius is a line without rotary inertia.

use crate::math::Vec3;
use crate::solve::Engine;

/// Mass of each node.
pub(super) struct Masses {
    nodes: Vec<NodeMass>,
}

/// Mass of a node \[mass\], about a diameter and about the axis \[mass·L²\].
#[derive(Clone, Copy, Default)]
struct NodeMass {
    line: f64,
    across: f64,
    along: f64,
}

impl Masses {
    /// Of rods with these line densities.
    pub(super) fn of(engine: &Engine, densities: &[f64]) -> Self {
        let mut nodes = vec![NodeMass::default(); engine.num_nodes()];
        for (rod, density) in densities.iter().enumerate() {
            let data = &engine.model().rods[rod];
            for (node, share) in engine.shares(rod) {
                let local = (node - engine.first_node[rod]) as f64;
                let radius = data
                    .contact_radii
                    .as_ref()
                    .map_or(data.section.contact_radius, |radii| radii.at(local * data.spacing()));
                let mass = &mut nodes[node];
                mass.line += density * share;
                mass.across += density * share * radius * radius / 4.0;
                mass.along += density * share * radius * radius / 2.0;
            }
        }
        Self { nodes }
    }

    /// That of all nodes \[mass\].
    pub(super) fn total(&self) -> f64 {
        self.nodes.iter().map(|node| node.line).sum()
    }

    /// M v, six numbers a node; joined nodes' share is the first one's.
    pub(super) fn multiply(&self, engine: &Engine, motion: &[f64]) -> Vec<f64> {
        let mut product = Vec::with_capacity(motion.len());
        for ((mass, v), frame) in self.nodes.iter().zip(motion.chunks_exact(6)).zip(engine.state().frames()) {
            let axis = frame * Vec3::z();
            let turn = Vec3::new(v[3], v[4], v[5]);
            let spin = turn * mass.across + axis * ((mass.along - mass.across) * axis.dot(&turn));
            product.extend([v[0] * mass.line, v[1] * mass.line, v[2] * mass.line, spin.x, spin.y, spin.z]);
        }
        engine.give_to_masters(&mut product);
        product
    }
}
