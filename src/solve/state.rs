//! The configuration of all rods and how it moves.

use nalgebra::Unit;
use serde::{Deserialize, Serialize};

use crate::math::quaternion::{exp, spin};
use crate::math::{Quat, Vec3};

/// Positions and frames of all nodes (rod after rod), seams and load levels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Node positions \[L\].
    pub positions: Vec<Vec3>,
    /// Node frames.
    pub frames: Vec<Quat>,
    /// Per rod: angle by which the frame at s = L is turned about d3 against the frame at s = 0, rad (closed rods).
    pub seams: Vec<f64>,
    /// Factor on dead loads.
    pub load_factor: f64,
    /// Per rod: pressure \[F/L\].
    pub pressures: Vec<f64>,
}

/// Prescribed changes for one load step: motions of supports are applied through the tangent of the first Newton steps, so
/// that the rods take them up everywhere at once; turns of seams are spread evenly along the rod beforehand.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Drive {
    /// (node, displacement \[L\], rotation vector \[rad\]) of supported nodes.
    pub nodes: Vec<(usize, Vec3, Vec3)>,
    /// Per rod: change of the seam angle, rad; empty if none changes.
    pub seams: Vec<f64>,
}

impl Drive {
    /// The supports' motions times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { nodes: self.nodes.iter().map(|&(n, d, r)| (n, d * factor, r * factor)).collect(), seams: Vec::new() }
    }
}

impl State {
    /// Moves every node by `t` times its six increments (displacement, rotation vector; multiplicative update
    /// q ← exp(tθ/2) q).
    pub fn retract(&self, increment: &[f64], t: f64) -> Self {
        let mut next = self.clone();
        for node in 0..self.positions.len() {
            let d = &increment[6 * node..6 * node + 6];
            next.positions[node] += Vec3::new(d[0], d[1], d[2]) * t;
            let turned = exp(&(Vec3::new(d[3], d[4], d[5]) * t)) * self.frames[node];
            // products drift off the unit sphere by rounding only
            next.frames[node] = Unit::new_normalize(turned.into_inner());
        }
        next
    }

    /// Turns the seam of a closed rod (nodes `nodes`) by `angle` and spreads the twist evenly: frames spin about their own d3, the
    /// centreline and with it all contact stay as they are. Exact equilibrium of an isotropic ring, a good start for others.
    pub fn twist(&mut self, rod: usize, nodes: std::ops::Range<usize>, angle: f64) {
        self.seams[rod] += angle;
        let count = nodes.len() as f64;
        for (k, node) in nodes.enumerate() {
            let turned = self.frames[node] * spin(angle * (k as f64 / count - 0.5));
            self.frames[node] = Unit::new_normalize(turned.into_inner());
        }
    }

    /// Frame at s = L of a closed rod whose first node is `first`.
    pub fn seam_frame(&self, rod: usize, first: usize) -> Quat {
        self.frames[first] * spin(self.seams[rod])
    }
}
