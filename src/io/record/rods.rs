//! Each rod as the files of a record name it.

use serde::{Deserialize, Serialize};

use crate::scene::Scene;

/// Data of each rod for the record.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::io) struct RodHead {
    pub name: String,
    pub(super) length: f64,
    pub(super) contact_radius: f64,
    /// Contact radius at each node of a rod along which it varies; empty for other rods.
    #[serde(skip)]
    pub(super) radii: Vec<f64>,
    pub closed: bool,
    elements: usize,
    order: usize,
    pub(super) nodes: usize,
    /// Turns of the double helix that the frames leave out, if any.
    #[serde(default, skip_serializing_if = "is_zero")]
    turns_left_out: f64,
    /// Base pairs of a rod that is DNA.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    base_pairs: Option<usize>,
    /// Base pairs a turn of the relaxed molecule.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    helical_repeat: Option<f64>,
    /// Stiffnesses at the start; none of a rod that has a full matrix of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stiffness: Option<SectionStiffness>,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Stiffnesses of a section.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct SectionStiffness {
    /// EI about d1 and d2 \[F·L²\].
    bending: [f64; 2],
    /// GJ \[F·L²\].
    twisting: f64,
    /// EA \[F\].
    stretching: f64,
    /// GA along d1 and d2 \[F\].
    shearing: [f64; 2],
}

impl RodHead {
    pub(super) fn of(scene: &Scene, index: usize) -> Self {
        let rod = &scene.model.rods[index];
        let (base_pairs, helical_repeat) = scene.double_helix(index).unzip();
        Self {
            base_pairs,
            helical_repeat,
            name: rod.name.clone(),
            length: rod.length,
            contact_radius: rod.section.contact_radius,
            radii: rod.contact_radii.as_ref().map_or_else(Vec::new, |radii| {
                (0..rod.num_nodes()).map(|node| radii.at(node as f64 * rod.spacing())).collect()
            }),
            closed: rod.closed,
            elements: rod.num_elements,
            order: rod.order,
            nodes: rod.num_nodes(),
            turns_left_out: rod.turns_left_out,
            stiffness: rod.stiffness.is_none().then_some(SectionStiffness {
                bending: rod.section.bending,
                twisting: rod.section.twisting,
                stretching: rod.section.stretching,
                shearing: rod.section.shearing,
            }),
        }
    }

    /// Reference length between neighbouring nodes.
    pub(super) fn spacing(&self) -> f64 {
        self.length / (self.elements * self.order) as f64
    }

    /// Reference arc lengths of all nodes.
    pub(super) fn arc_lengths(&self) -> Vec<f64> {
        (0..self.nodes).map(|node| self.spacing() * node as f64).collect()
    }

    /// Largest radius it is drawn with; a rod without a contact radius is a thin line.
    pub fn radius(&self) -> f64 {
        if self.contact_radius > 0.0 { self.contact_radius } else { 2e-3 * self.length }
    }

    /// The like at a node.
    pub(super) fn radius_at(&self, node: usize) -> f64 {
        self.radii.get(node).copied().unwrap_or_else(|| self.radius())
    }
}
