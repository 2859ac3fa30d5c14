//! Rigid bodies that nodes carry: where they are, and which segments may touch them.
//!
//! A body has the pose of its node, so it has no unknowns of its own: what a strand exerts on it acts on the node.

use crate::contact::potential::surface::SurfaceContact;
use crate::math::Vec3;
use crate::math::signed_distance::Surface;
use crate::scene::{Obstacle, ObstaclePose};
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

impl Engine {
    /// Where all obstacles are in a state, those that nodes carry with these.
    pub(crate) fn placements(&self, state: &State) -> Vec<ObstaclePose> {
        let of = |(obstacle, placement): (&Obstacle, &ObstaclePose)| {
            let Some(at) = obstacle.carrier else { return *placement };
            let node = self.first_node[at.rod] + at.node;
            let turn = state.frames[node] * self.model.rods[at.rod].frames[at.node].inverse();
            obstacle.carried(placement, &(state.positions[node] + state.remainders[node]), turn.scaled_axis())
        };
        self.model.obstacles.iter().zip(&state.placements).map(of).collect()
    }

    /// Rods of a segment and of the node that carries the body which it touches; none where no node does.
    pub(in crate::solve) fn rods_at_body(&self, contact: &SurfaceContact) -> Option<[usize; 2]> {
        let side = &self.contact;
        let carrier = side.carriers[contact.surface].as_ref()?;
        Some([side.nodes[contact.segment][0], carrier.node].map(|node| self.rod_of(node)))
    }
}

impl ContactSide {
    /// The surface of an obstacle in a state.
    pub(in crate::solve) fn surface_in(&self, state: &State, index: usize) -> Surface {
        let (obstacle, placement) = (&self.obstacles[index], &state.placements[index]);
        match &self.carriers[index] {
            None => obstacle.placed(placement),
            Some(carrier) => {
                let place = (state.positions[carrier.node], state.remainders[carrier.node]);
                obstacle.surface(placement.level, place, &carrier.rotation(state))
            }
        }
    }

    /// Nodes that a term of a segment and an obstacle is of: the segment's, and that which carries the obstacle, if one
    /// does.
    pub(crate) fn nodes_at_surface(&self, segment: usize, surface: usize) -> ([usize; 3], usize) {
        let [a, b] = self.nodes[segment];
        match &self.carriers[surface] {
            None => ([a, b, b], 2),
            Some(carrier) => ([a, b, carrier.node], 3),
        }
    }
}

/// How a body moves in an increment: its point's displacement \[L\] and its rotation vector, rad.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::solve) struct BodyMotion {
    pub(in crate::solve) displacement: Vec3,
    pub(in crate::solve) rotation: Vec3,
}

impl BodyMotion {
    /// Of an obstacle; none of one that no node carries.
    pub(in crate::solve) fn of(side: &ContactSide, surface: usize, increment: &[f64]) -> Self {
        let six = |node: usize| [0, 3].map(|k| Vec3::from_column_slice(&increment[6 * node + k..6 * node + k + 3]));
        let [displacement, rotation] =
            side.carriers[surface].as_ref().map_or([Vec3::zeros(); 2], |carrier| six(carrier.node));
        Self { displacement, rotation }
    }

    /// A bound of what it adds to the motion of points within `far` of its own that move by `fast`, as they are seen
    /// from it \[L\]: its displacement, its rotation, and what a finite turn adds.
    pub(in crate::solve) fn fastest(&self, far: f64, fast: f64) -> f64 {
        let (moved, turn) = (self.displacement.norm(), self.rotation.norm());
        let fast = fast + moved;
        moved + turn * far + turn * (0.5 * turn * (far + fast) + fast)
    }

    /// Linear motion of what it carries along at a place relative to its point \[L\].
    pub(in crate::solve) fn at(&self, arm: &Vec3) -> Vec3 {
        self.displacement + self.rotation.cross(arm)
    }
}
