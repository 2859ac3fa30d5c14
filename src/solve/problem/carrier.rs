//! A node that carries a rigid body, and which segments next to it do not touch the body.
//!
//! The strand that carries a body is left out next to the node, as far as it may need to leave the body
//! ([`Obstacle::surroundings`]), whole segments at a time: the part that is left out does not change with the shape, so
//! the energy is as smooth as without it.

use std::ops::Range;

use crate::math::Quat;
use crate::math::signed_distance::Surface;
use crate::scene::model::overlaps;
use crate::scene::{Model, NodeRef, Obstacle};
use crate::solve::problem::state::State;

/// A node that carries an obstacle.
#[derive(Debug, Clone)]
pub(crate) struct Carrier {
    /// Among all nodes.
    pub(crate) node: usize,
    /// Its frame at the start.
    start: Quat,
    /// Where it is on the rods that take part in contact.
    own: Vec<OwnPlace>,
}

/// The place of a carrying node on a rod.
#[derive(Debug, Clone)]
struct OwnPlace {
    /// Of the rod, among all.
    segments: Range<usize>,
    /// Of a segment \[L\].
    spacing: f64,
    /// Length of a closed rod, 0 of an open one \[L\].
    round: f64,
    /// Arc length of the node \[L\].
    arc: f64,
    /// Largest contact radius of the rod \[L\].
    radius: f64,
}

impl OwnPlace {
    /// Whether a segment is so near to the node along the rod that it does not touch a body of this level.
    fn leaves_out(&self, segment: usize, level: f64) -> bool {
        let reach = Obstacle::surroundings(level, self.radius);
        let ends = || [0, 1].map(|k| self.spacing * (segment + k - self.segments.start) as f64);
        self.segments.contains(&segment) && overlaps(&[[self.arc - reach, self.arc + reach]], ends(), self.round)
    }
}

impl Carrier {
    /// The carrier of each obstacle; segments are those of the rods `touching`, in their order.
    pub(crate) fn all(model: &Model, first_node: &[usize], touching: &[usize]) -> Vec<Option<Self>> {
        let of = |obstacle: &Obstacle| {
            let at = obstacle.carrier?;
            let start = model.rods[at.rod].frames[at.node];
            let own = model.joined_nodes(at).iter().filter_map(|at| own_place(model, *at, touching)).collect();
            Some(Self { node: first_node[at.rod] + at.node, start, own })
        };
        model.obstacles.iter().map(of).collect()
    }

    /// Whether a segment is so near to the node along its rod that it does not touch a body of this level.
    pub(super) fn leaves_out(&self, segment: usize, level: f64) -> bool {
        self.own.iter().any(|place| place.leaves_out(segment, level))
    }

    /// Rotation since the start.
    pub(super) fn rotation(&self, state: &State) -> Quat {
        state.frames[self.node] * self.start.inverse()
    }
}

/// The place of a node on its rod; none of a rod that takes no part in contact.
fn own_place(model: &Model, at: NodeRef, touching: &[usize]) -> Option<OwnPlace> {
    let index = touching.iter().position(|rod| *rod == at.rod)?;
    let first: usize = touching[..index].iter().map(|&rod| model.rods[rod].num_segments()).sum();
    let rod = &model.rods[at.rod];
    Some(OwnPlace {
        segments: first..first + rod.num_segments(),
        spacing: rod.spacing(),
        round: if rod.closed { rod.length } else { 0.0 },
        arc: rod.spacing() * at.node as f64,
        radius: rod.thickest(),
    })
}

/// Whether a segment can touch an obstacle at all: it is not next to the node that carries it.
pub(in crate::solve) fn can_touch(
    carriers: &[Option<Carrier>],
    surfaces: &[Surface],
    [segment, surface]: [usize; 2],
) -> bool {
    carriers[surface].as_ref().is_none_or(|carrier| !carrier.leaves_out(segment, surfaces[surface].level))
}
