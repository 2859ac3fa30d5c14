//! Tangents of the contact centrelines at the nodes: r′ in the frame of the node.
//!
//! The contact centreline between two neighbouring nodes is the cubic Hermite curve through them with the tangents R v,
//! R the frame of a node. v is e3 along rods that are hardly sheared or stretched. A shear γ that is left out makes
//! ripples of ±0.1 γ h between nodes h apart, whose mean is zero; a stretch λ moves points between nodes by up to (λ −
//! 1) κ (λh)²/8 to the inside of a bend κ. Along others it is measured (`measured_tangents`). Like contact pressures, v
//! is held fixed while the potential falls, so that contact stays a function of positions and frames of two nodes a
//! segment. A handle that gets longer moves along the rod, on which forces along normals do no work.

use nalgebra::Vector2;

use crate::contact::curve::Cubic;
use crate::math::Vec3;
use crate::math::two_sum::two_sum;
use crate::solve::problem::state::State;

/// Per node: the derivative of the centreline by the reference arc length, in the frame of the node \[1\].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MaterialTangents(pub(in crate::solve) Vec<Vec3>);

/// Whether a tangent is not along d3.
pub(in crate::solve::problem) fn is_sheared(tangent: &Vec3) -> bool {
    tangent.xy() != Vector2::zeros()
}

impl MaterialTangents {
    /// The directors d3.
    pub(in crate::solve) fn directors(num_nodes: usize) -> Self {
        Self(vec![Vec3::z(); num_nodes])
    }

    /// Whether any is not along d3.
    pub(in crate::solve) fn are_sheared(&self) -> bool {
        self.0.iter().any(is_sheared)
    }

    /// Tangent at a node \[1\].
    pub(in crate::solve) fn at(&self, state: &State, node: usize) -> Vec3 {
        state.frames[node] * self.0[node]
    }

    /// Its length \[1\].
    pub(in crate::solve) fn length(&self, node: usize) -> f64 {
        self.0[node].norm()
    }

    /// The contact centreline between two neighbouring nodes, `length` apart along the rod, and the rounding errors of
    /// its control points \[L\]. It is C¹ along the rod, which the elements' own Lagrange curve is not.
    pub(in crate::solve) fn cubic(&self, state: &State, [a, b]: [usize; 2], length: f64) -> (Cubic, [Vec3; 4]) {
        let handle = |n: usize| self.at(state, n) * (length / 3.0);
        let (start, end) = (state.positions[a], state.positions[b]);
        let (after, lost_after) = two_sum(&start, &handle(a));
        let (before, lost_before) = two_sum(&end, &-handle(b));
        let [lost_start, lost_end] = [state.remainders[a], state.remainders[b]];
        let lost = [lost_start, lost_start + lost_after, lost_end + lost_before, lost_end];
        (Cubic { b: [start, after, before, end] }, lost)
    }
}
