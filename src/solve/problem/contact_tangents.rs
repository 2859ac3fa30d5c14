//! Tangents of the contact centrelines at the nodes: the direction of r′ in the frame of the node.
//!
//! The contact centreline between two neighbouring nodes is the cubic between them with the tangents R v, R the frame
//! of a node, and handles as long as those of an arc (`math::handles`): along stretched rods these are as long as r′
//! says. v is e3 along rods that are hardly sheared: a shear γ that is left out makes ripples of ±0.1 γ h between nodes
//! h apart, whose mean is zero. Along others it is measured (`measured_tangents`). Like contact
//! pressures, v is held fixed while the potential falls, so that contact stays a function of positions and frames of
//! two nodes a segment.

use crate::contact::curve::Cubic;
use crate::math::Vec3;
use crate::math::handles::handle_length;
use crate::math::two_sum::two_sum;
use crate::solve::problem::state::State;

/// Per node: the unit tangent in the frame of the node.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MaterialTangents(pub(in crate::solve) Vec<Vec3>);

impl MaterialTangents {
    /// The directors d3.
    pub(in crate::solve) fn directors(num_nodes: usize) -> Self {
        Self(vec![Vec3::z(); num_nodes])
    }

    /// Whether any is not d3.
    pub(in crate::solve) fn are_sheared(&self) -> bool {
        self.0.iter().any(|tangent| *tangent != Vec3::z())
    }

    /// Tangent at a node \[1\].
    pub(in crate::solve) fn at(&self, state: &State, node: usize) -> Vec3 {
        state.frames[node] * self.0[node]
    }

    /// The contact centreline between two neighbouring nodes, and the rounding errors of its control points \[L\]. Its
    /// direction is continuous along the rod, which that of the elements' own Lagrange curve is not.
    pub(in crate::solve) fn cubic(&self, state: &State, [a, b]: [usize; 2]) -> (Cubic, [Vec3; 4]) {
        let (start, end) = (state.positions[a], state.positions[b]);
        let [lost_start, lost_end] = [state.remainders[a], state.remainders[b]];
        let tangents = [a, b].map(|node| self.at(state, node));
        let length = handle_length(&((end - start) + (lost_end - lost_start)), [&tangents[0], &tangents[1]]);
        let (after, lost_after) = two_sum(&start, &(tangents[0] * length));
        let (before, lost_before) = two_sum(&end, &(tangents[1] * -length));
        let lost = [lost_start, lost_start + lost_after, lost_end + lost_before, lost_end];
        (Cubic { b: [start, after, before, end] }, lost)
    }
}
