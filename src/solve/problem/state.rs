//! The configuration of all rods and how it moves.

use std::collections::BTreeMap;

use nalgebra::Unit;

use crate::math::quaternion::{exp, spin};
use crate::math::two_sum::two_sum;
use crate::math::{Quat, Vec3};
use crate::rod::RodNumber;
use crate::scene::{ObstacleNumber, ObstaclePose};

/// Numbers of rods that have been ramped.
pub type Numbers = BTreeMap<(usize, RodNumber), f64>;

/// Numbers as a list: text formats have words for keys only.
#[cfg(feature = "serde")]
pub(crate) mod as_list {
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{Numbers, RodNumber};

    pub(crate) fn serialize<S: Serializer>(numbers: &Numbers, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(numbers)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Numbers, D::Error> {
        Vec::<((usize, RodNumber), f64)>::deserialize(deserializer).map(|list| list.into_iter().collect())
    }
}

/// Positions and frames of all nodes (rod after rod), seams and load levels. Only the problem makes one from nothing;
/// others make it from another state. [`Engine`](crate::solve::Engine) keeps joined nodes together in what it takes.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Node positions \[L\], rounded.
    pub(in crate::solve::problem) positions: Vec<Vec3>,
    /// Rounding errors of the positions \[L\]: nodes are at `positions + remainders`. Far from the origin
    /// neighbours are known to each other by it.
    pub(in crate::solve::problem) remainders: Vec<Vec3>,
    /// Node frames.
    pub(in crate::solve::problem) frames: Vec<Quat>,
    /// Per rod: angle of its seam, rad.
    pub(in crate::solve::problem) seams: Vec<f64>,
    /// Factor on dead loads.
    pub(in crate::solve::problem) load_factor: f64,
    /// Per rod: pressure \[F/L\].
    pub(in crate::solve::problem) pressures: Vec<f64>,
    /// Per obstacle: where it is.
    pub(in crate::solve::problem) placements: Vec<ObstaclePose>,
    /// Numbers of rods that ramps have changed.
    #[cfg_attr(feature = "serde", serde(with = "as_list"))]
    pub(in crate::solve::problem) numbers: Numbers,
}

/// A prescribed quantity of a state, with its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PrescribedValue {
    /// Factor on dead loads.
    Load(f64),
    /// Pressure on a rod \[F/L\].
    Pressure(usize, f64),
    /// Angle of the seam of a closed rod, rad.
    Seam(usize, f64),
    /// A number of an obstacle.
    Obstacle(usize, ObstacleNumber, f64),
    /// A number of a rod.
    Number(usize, RodNumber, f64),
}

impl State {
    /// Node positions \[L\], rounded, rod after rod.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Node frames, rod after rod.
    pub fn frames(&self) -> &[Quat] {
        &self.frames
    }

    /// Per rod: angle by which the frame at s = L is turned about d3 against the frame at s = 0, rad (closed rods).
    pub fn seams(&self) -> &[f64] {
        &self.seams
    }

    /// Factor on dead loads.
    pub fn load_factor(&self) -> f64 {
        self.load_factor
    }

    /// Per rod: pressure \[F/L\].
    pub fn pressures(&self) -> &[f64] {
        &self.pressures
    }

    /// Per obstacle: where it is.
    pub fn placements(&self) -> &[ObstaclePose] {
        &self.placements
    }

    /// Numbers of rods that ramps have changed.
    pub fn numbers(&self) -> &Numbers {
        &self.numbers
    }

    /// Gives prescribed quantities their values; nodes and frames stay.
    pub(crate) fn prescribe(&mut self, values: impl IntoIterator<Item = PrescribedValue>) {
        for value in values {
            match value {
                PrescribedValue::Load(factor) => self.load_factor = factor,
                PrescribedValue::Pressure(rod, pressure) => self.pressures[rod] = pressure,
                PrescribedValue::Seam(rod, angle) => self.seams[rod] = angle,
                PrescribedValue::Obstacle(obstacle, which, to) => self.placements[obstacle].set(which, to),
                PrescribedValue::Number(rod, which, to) => drop(self.numbers.insert((rod, which), to)),
            }
        }
    }

    /// Moves every node by `t` times its six increments (displacement, rotation vector; multiplicative update
    /// q ← exp(tθ/2) q). Joined nodes are moved by their own: [`Engine::retract`](crate::solve::Engine) joins them.
    pub(in crate::solve::problem) fn moved(&self, increment: &[f64], t: f64) -> Self {
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

    /// This state with nodes at these places \[L\], which are exact; their number may be another. What supports hold
    /// and joints join is for the caller to keep: the solver refuses a state with parted joints.
    #[must_use]
    pub fn with_nodes(&self, positions: Vec<Vec3>, frames: Vec<Quat>) -> Self {
        let remainders = vec![Vec3::zeros(); positions.len()];
        Self { positions, remainders, frames, ..self.clone() }
    }

    /// This state with nodes at these rounded places \[L\], remainders and frames as they are.
    pub(crate) fn with_positions(self, positions: Vec<Vec3>) -> Self {
        Self { positions, ..self }
    }

    /// This state on some of its nodes.
    pub(crate) fn on_nodes(&self, nodes: impl Iterator<Item = usize> + Clone) -> Self {
        let at = |list: &[Vec3]| nodes.clone().map(|node| list[node]).collect();
        let frames = nodes.clone().map(|node| self.frames[node]).collect();
        Self { positions: at(&self.positions), remainders: at(&self.remainders), frames, ..self.clone() }
    }

    /// Rounding errors of the positions \[L\].
    pub(crate) fn remainders(&self) -> &[Vec3] {
        &self.remainders
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
    pub(crate) fn increment_since(&self, before: &Self) -> Vec<f64> {
        let mut increment = Vec::with_capacity(6 * self.positions.len());
        for node in 0..self.positions.len() {
            let displacement =
                (self.positions[node] - before.positions[node]) + (self.remainders[node] - before.remainders[node]);
            let rotation = (self.frames[node] * before.frames[node].inverse()).scaled_axis();
            increment.extend(displacement.iter().chain(rotation.iter()));
        }
        increment
    }

    /// Spins the frame of a node about its own d3 by an angle, rad.
    pub(in crate::solve::problem) fn spin_frame(&mut self, node: usize, angle: f64) {
        let turned = self.frames[node] * spin(angle);
        self.frames[node] = Unit::new_normalize(turned.into_inner());
    }

    /// Frame at s = L of a closed rod whose first node is `first`.
    pub(crate) fn seam_frame(&self, rod: usize, first: usize) -> Quat {
        self.frames[first] * spin(self.seams[rod])
    }
}

#[cfg(test)]
impl State {
    /// Positions and frames, to be put where no solver would.
    pub(crate) fn nodes_mut(&mut self) -> (&mut [Vec3], &mut [Quat]) {
        (&mut self.positions, &mut self.frames)
    }
}
