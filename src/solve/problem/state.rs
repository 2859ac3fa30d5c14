//! The configuration of all rods and how it moves.

use std::collections::BTreeMap;

use nalgebra::Unit;

use crate::math::quaternion::{exp, spin};
use crate::math::two_sum::two_sum;
use crate::math::{Quat, Vec3};
use crate::solve::problem::changes::Numbers;

/// Positions and frames of all nodes (rod after rod), seams and load levels.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Node positions \[L\], rounded.
    pub positions: Vec<Vec3>,
    /// Rounding errors of the positions \[L\]: nodes are at `positions + remainders`. Far from the origin
    /// neighbours are known to each other by it.
    pub remainders: Vec<Vec3>,
    /// Node frames.
    pub frames: Vec<Quat>,
    /// Per rod: angle by which the frame at s = L is turned about d3 against the frame at s = 0, rad (closed rods).
    pub seams: Vec<f64>,
    /// Factor on dead loads.
    pub load_factor: f64,
    /// Per rod: pressure \[F/L\].
    pub pressures: Vec<f64>,
    /// Per plane: how far it has been moved along its normal \[L\].
    pub plane_heights: Vec<f64>,
    /// Numbers of rods that ramps have changed.
    #[cfg_attr(feature = "serde", serde(with = "crate::solve::problem::changes::as_list"))]
    pub numbers: Numbers,
}

/// Prescribed changes for one load step: motions of supports are applied through the tangent of the first Newton steps,
/// so that the rods take them up everywhere at once; turns of seams are spread evenly along the rod beforehand.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PrescribedMotion {
    /// (node, displacement \[L\], rotation vector \[rad\]) of supported nodes.
    pub nodes: Vec<(usize, Vec3, Vec3)>,
    /// Per rod: change of the seam angle, rad; empty if none changes.
    pub seams: Vec<f64>,
}

/// Where one load step leads.
#[derive(Debug, Clone, Default)]
pub(crate) struct Target {
    pub(crate) drive: PrescribedMotion,
    pub(crate) load_factor: Option<f64>,
    /// By rod \[F/L\].
    pub(crate) pressures: Vec<(usize, f64)>,
    /// By plane \[L\].
    pub(crate) plane_heights: Vec<(usize, f64)>,
    /// Numbers of rods.
    pub(crate) numbers: Numbers,
    /// Turns that supports make, by node.
    pub(crate) turned: Vec<(usize, f64)>,
    /// Displacements that supports make, by node \[L\].
    pub(crate) displaced: Vec<(usize, Vec3)>,
    /// Motions of nodes towards poses: velocity \[L\] and rotation vector, rad, see `Way::controls`.
    pub(crate) posed: Vec<(usize, [Vec3; 2])>,
}

impl Target {
    /// Puts loads, pressures, planes and numbers of rods in force.
    pub(crate) fn load(&self, state: &mut State) {
        if let Some(factor) = self.load_factor {
            state.load_factor = factor;
        }
        for &(rod, pressure) in &self.pressures {
            state.pressures[rod] = pressure;
        }
        for &(plane, height) in &self.plane_heights {
            state.plane_heights[plane] = height;
        }
        state.numbers.extend(&self.numbers);
    }
}

/// Motions of supports so far, by node.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Moved {
    /// Turns.
    pub(crate) turned: BTreeMap<usize, f64>,
    /// Displacements \[L\].
    pub(crate) displaced: BTreeMap<usize, Vec3>,
    /// Angles by which rods were spun about their own tangents, rad.
    pub(crate) spun: BTreeMap<usize, f64>,
    /// Sums of the constant rates of each path to a pose: velocity \[L\] and rotation vector, rad.
    pub(crate) posed: BTreeMap<usize, [Vec3; 2]>,
}

impl Moved {
    /// After a step to a target on which these nodes were spun.
    pub(crate) fn go_on(&mut self, target: &Target, spun: &[(usize, f64)]) {
        for &(node, turns) in &target.turned {
            *self.turned.entry(node).or_insert(0.0) += turns;
        }
        for &(node, by) in &target.displaced {
            *self.displaced.entry(node).or_default() += by;
        }
        for &(node, by) in &target.posed {
            let sums = self.posed.entry(node).or_default();
            sums.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
        }
        for &(node, angle) in spun {
            *self.spun.entry(node).or_insert(0.0) += angle;
        }
    }

    /// The same of nodes that are called by other numbers.
    pub(crate) fn on_nodes(&self, number: impl Fn(usize) -> usize) -> Self {
        Self {
            turned: self.turned.iter().map(|(&node, &turns)| (number(node), turns)).collect(),
            displaced: self.displaced.iter().map(|(&node, &by)| (number(node), by)).collect(),
            spun: self.spun.iter().map(|(&node, &angle)| (number(node), angle)).collect(),
            posed: self.posed.iter().map(|(&node, &by)| (number(node), by)).collect(),
        }
    }

    /// All nodes that supports have moved.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = usize> {
        self.turned.keys().chain(self.displaced.keys()).chain(self.spun.keys()).chain(self.posed.keys()).copied()
    }
}

impl PrescribedMotion {
    /// The drive in equal parts in none of which a seam turns by more than `turns` turns. Supports move in the first
    /// part.
    pub(crate) fn parts(&self, turns: f64) -> Vec<Self> {
        let largest = self.seams.iter().fold(0.0f64, |a, b| a.max(b.abs())) / std::f64::consts::TAU;
        let count = (largest / turns - 1e-9).ceil().clamp(1.0, 1000.0);
        let seams: Vec<f64> = self.seams.iter().map(|angle| angle / count).collect();
        let first = Self { nodes: self.nodes.clone(), seams: seams.clone() };
        let rest = Self { nodes: Vec::new(), seams };
        std::iter::once(first).chain(std::iter::repeat_n(rest, count as usize - 1)).collect()
    }

    /// Adds the supports' motions to an increment (six per node).
    pub(crate) fn add_to(&self, increment: &mut [f64]) {
        for &(node, displacement, rotation) in &self.nodes {
            for k in 0..3 {
                increment[6 * node + k] += displacement[k];
                increment[6 * node + 3 + k] += rotation[k];
            }
        }
    }

    /// The supports' motions times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self { nodes: self.nodes.iter().map(|&(n, d, r)| (n, d * factor, r * factor)).collect(), seams: Vec::new() }
    }
}

/// Shares of the nodes of a closed rod in the turn of its seam, which twists it evenly.
pub(crate) fn seam_shares(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| k as f64 / count as f64 - 0.5)
}

impl State {
    /// Moves every node by `t` times its six increments (displacement, rotation vector; multiplicative update
    /// q ← exp(tθ/2) q).
    pub fn retract(&self, increment: &[f64], t: f64) -> Self {
        let mut next = self.clone();
        for node in 0..self.positions.len() {
            let d = &increment[6 * node..6 * node + 6];
            next.displace(node, &(Vec3::new(d[0], d[1], d[2]) * t));
            let turned = exp(&(Vec3::new(d[3], d[4], d[5]) * t)) * self.frames[node];
            // products drift off the unit sphere by rounding only
            next.frames[node] = Unit::new_normalize(turned.into_inner());
        }
        next
    }

    /// Moves a node \[L\].
    fn displace(&mut self, node: usize, by: &Vec3) {
        let (sum, lost) = two_sum(&self.positions[node], by);
        (self.positions[node], self.remainders[node]) = two_sum(&sum, &(self.remainders[node] + lost));
    }

    /// From one node to another \[L\], right to rounding of the distance however far from the origin they are.
    pub(crate) fn chord(&self, from: usize, to: usize) -> Vec3 {
        (self.positions[to] - self.positions[from]) + (self.remainders[to] - self.remainders[from])
    }

    /// The increment whose retraction takes `before` to this state: displacements \[L\] and rotation vectors of at most
    /// half a turn, rad.
    pub fn increment_since(&self, before: &Self) -> Vec<f64> {
        let mut increment = Vec::with_capacity(6 * self.positions.len());
        for node in 0..self.positions.len() {
            let displacement =
                (self.positions[node] - before.positions[node]) + (self.remainders[node] - before.remainders[node]);
            let rotation = (self.frames[node] * before.frames[node].inverse()).scaled_axis();
            increment.extend(displacement.iter().chain(rotation.iter()));
        }
        increment
    }

    /// Turns the seam of a closed rod (nodes `nodes`) by `angle` and spreads the twist evenly: frames spin about their
    /// own d3, the centreline and with it all contact stay as they are. Exact equilibrium of an isotropic ring, a good
    /// start for others.
    pub fn twist(&mut self, rod: usize, nodes: std::ops::Range<usize>, angle: f64) {
        self.seams[rod] += angle;
        for (share, node) in seam_shares(nodes.len()).zip(nodes) {
            let turned = self.frames[node] * spin(angle * share);
            self.frames[node] = Unit::new_normalize(turned.into_inner());
        }
    }

    /// Frame at s = L of a closed rod whose first node is `first`.
    pub fn seam_frame(&self, rod: usize, first: usize) -> Quat {
        self.frames[first] * spin(self.seams[rod])
    }
}
