//! No frame may turn so far against its neighbour that elements would take the other way round.
//!
//! Elements interpolate along the shorter way between two frames. Past half a turn that is the other one: a rod twisted
//! further would come out as one untwisted by the rest, with a smaller moment, in equilibrium, and nothing would look
//! wrong.

use std::f64::consts::TAU;

use crate::error::SolveError;
use crate::math::Vec3;
use crate::rod::MAX_TURN;
use crate::solve::engine::Engine;
use crate::solve::state::Drive;

/// Turns between neighbouring nodes that one load step may add, on average over the nodes between what is turned and
/// what is held: more could take a segment past half a turn and out on the other side.
const MAX_ADDED: f64 = 0.3;

impl Engine {
    /// Refuses the present state if frames of neighbouring nodes have turned too far against each other.
    pub(crate) fn check_turning(&self) -> Result<(), SolveError> {
        for element in &self.elements {
            let (rod, order) = (element.rod, self.model.rods[element.rod].order);
            for a in 0..order {
                let [here, next] = [element.nodes[a], element.nodes[a + 1]];
                let closing = element.closes && a + 1 == order;
                let frame = if closing { self.state.seam_frame(rod, next) } else { self.state.frames[next] };
                let turns = self.state.frames[here].angle_to(&frame) / TAU;
                if turns.is_nan() || turns > MAX_TURN {
                    return Err(self.too_twisted(rod, here, next, turns, MAX_TURN));
                }
            }
        }
        Ok(())
    }

    /// Refuses what would turn neighbouring nodes too far at once.
    pub(crate) fn check_drive(&self, drive: &Drive) -> Result<(), SolveError> {
        for (rod, angle) in drive.seams.iter().enumerate() {
            let turns = angle.abs() / TAU / self.model.rods[rod].num_segments() as f64;
            if turns > MAX_ADDED {
                let first = self.first_node[rod];
                return Err(self.too_twisted(rod, first, first + 1, turns, MAX_ADDED));
            }
        }
        for (node, _, rotation) in drive.nodes.iter().filter(|(_, _, rotation)| *rotation != Vec3::zeros()) {
            let rod = self.rod_of(*node);
            let turns = rotation.norm() / TAU / self.segments_to_held(rod, *node) as f64;
            if turns > MAX_ADDED {
                let last = *node + 1 == self.first_node[rod + 1];
                let (a, b) = if last { (*node - 1, *node) } else { (*node, *node + 1) };
                return Err(self.too_twisted(rod, a, b, turns, MAX_ADDED));
            }
        }
        Ok(())
    }

    /// Segments between a node and the next on its rod whose rotation is held; all of the rod if there is none.
    fn segments_to_held(&self, rod: usize, node: usize) -> usize {
        let held = |other: &usize| *other != node && self.free[*other][3..] != [true; 3];
        let distance = |other: usize| other.abs_diff(node);
        let nearest = self.nodes(rod).filter(held).map(distance).min();
        nearest.unwrap_or(self.model.rods[rod].num_segments())
    }

    fn too_twisted(&self, rod: usize, node: usize, next: usize, turns: f64, limit: f64) -> SolveError {
        let first = self.first_node[rod];
        SolveError::TooTwisted { rod, node: node - first, next: next - first, turns, limit }
    }
}
