//! No frame may turn so far against its neighbour that elements would take the other way round.
//!
//! Elements interpolate along the shorter way between two frames. Past half a turn that is the other one: a rod twisted
//! further would come out as one untwisted by the rest, with a smaller moment, in equilibrium, and nothing would look
//! wrong.

use std::f64::consts::TAU;

use crate::error::SolveError;
use crate::rod::MAX_TURN;
use crate::solve::problem::engine::Engine;

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
                    return Err(self.too_twisted(rod, here, next, turns));
                }
            }
        }
        Ok(())
    }

    /// Refuses turns of seams and [spins](crate::solve::load_step::predictor::lifted) of nodes that could take some
    /// pair of neighbouring nodes farther than an accepted state may have them: spread over the rod at once, they could
    /// go past half a turn unseen.
    pub(crate) fn check_spun(&self, seams: &[f64], spun: &[(usize, f64)]) -> Result<(), SolveError> {
        let per_segment = |angle: f64, segments: usize| angle.abs() / TAU / segments as f64;
        let of_seams = seams.iter().enumerate().map(|(rod, &angle)| {
            let segments = self.model.rods[rod].num_segments();
            (rod, per_segment(angle, segments))
        });
        let of_nodes = spun.iter().map(|&(node, angle)| {
            let rod = self.rod_of(node);
            (rod, per_segment(angle, self.segments_to_held(rod, node)))
        });
        for (rod, added) in of_seams.chain(of_nodes).filter(|(_, added)| *added > 0.0) {
            let nodes = self.nodes(rod);
            let turned = |k: usize| self.state.frames[k].angle_to(&self.state.frames[k + 1]) / TAU;
            let (turns, most) = (nodes.start..nodes.end - 1)
                .map(|k| (turned(k), k))
                .fold((0.0, nodes.start), |most, this| if this.0 > most.0 { this } else { most });
            let turns = turns + added;
            if turns > MAX_TURN {
                return Err(self.too_twisted(rod, most, most + 1, turns));
            }
        }
        Ok(())
    }

    /// Segments between a node and the next on its rod whose rotation is held; all of the rod if there is none.
    fn segments_to_held(&self, rod: usize, node: usize) -> usize {
        let held = |other: &usize| *other != node && self.is_turning_held(*other);
        let distance = |other: usize| other.abs_diff(node);
        let nearest = self.nodes(rod).filter(held).map(distance).min();
        nearest.unwrap_or(self.model.rods[rod].num_segments())
    }

    fn too_twisted(&self, rod: usize, node: usize, next: usize, turns: f64) -> SolveError {
        let first = self.first_node[rod];
        SolveError::TooTwisted { rod, node: node - first, next: next - first, turns, limit: MAX_TURN }
    }
}
