//! Double helices that become longer or shorter by the screw motion of their elements.
//!
//! The screw motion S that takes each element of one strand to the next takes each of the other to the one before. So a
//! double helix between nodes c and o opposite each other goes on with k elements more of each strand as
//!
//! ```text
//! … c | S⁰ … S^(k−1) of the element at c | S^k (c … o) | S^k … S¹ of the element at o | o …
//! ```
//!
//! and what is beyond it on either side stays where it is. k need not be a whole number, nor positive.

use std::f64::consts::TAU;

use nalgebra::Unit;

use crate::math::quaternion::{exp, rotation_of, spin};
use crate::math::{Mat3, Quat, Vec3};
use crate::solve::problem::state::State;

/// Turn about d3, rad, that is left of a rotation given in the frame's own axes.
pub(super) fn turn_about_d3(q: Quat) -> f64 {
    wrapped(2.0 * q.k.atan2(q.w))
}

/// An angle less whole turns, rad.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// The screw motion from an element of the first strand of a double helix to the next, and how much frames spin about
/// themselves beyond it along either strand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Screw {
    pub(super) axis: Unit<Vec3>,
    pub(super) point: Vec3,
    pub(super) angle: f64,
    pub(super) rise: f64,
    pub(super) spins: [f64; 2],
}

impl Screw {
    /// Least squares over `count` elements of order `p` on either side of two nodes, one of each strand, which are
    /// opposite each other; `None` where that is no screw motion.
    pub(super) fn measure(state: &State, p: usize, [at, opposite]: [usize; 2], count: usize) -> Option<Self> {
        let nodes = state.positions().len();
        let around = |node: usize| node.checked_sub(count * p).map(|first| first..node + count * p);
        let (here, there) = (around(at)?, around(opposite)?);
        if here.end + p > there.start || there.end + p >= nodes {
            return None;
        }
        // from, to: forward along the first strand, backward along the second
        let pairs: Vec<[usize; 2]> =
            here.clone().map(|i| [i, i + p]).chain(there.clone().map(|i| [i + p, i])).collect();
        let of = |k: usize| pairs.iter().map(move |pair| state.positions()[pair[k]]);
        let [from, to] = [0, 1].map(|k| of(k).sum::<Vec3>() / pairs.len() as f64);
        let spread: Mat3 = of(0).zip(of(1)).map(|(a, b)| (b - to) * (a - from).transpose()).sum();
        let rotation = rotation_of(&spread)?;
        let (axis, angle) = rotation.axis_angle()?;
        let shift = to - rotation * from;
        let rise = shift.dot(&axis);
        let across = shift - axis.into_inner() * rise;
        let point = (across + axis.cross(&across) / (0.5 * angle).tan()) * 0.5;
        let mean = |range: std::ops::Range<usize>, turn: Quat| {
            let spun = |i: usize| turn_about_d3((turn * state.frames()[i]).inverse() * state.frames()[i + p]);
            let first = spun(range.start);
            let beyond = |i: usize| wrapped(spun(i) - first);
            first + range.clone().map(beyond).sum::<f64>() / range.len() as f64
        };
        let spins = [mean(here, rotation), mean(there, rotation.inverse())].map(wrapped);
        Some(Self { axis, point, angle, rise, spins })
    }

    /// Largest distance \[L\] by which the motion misses the nodes that it was measured on.
    pub(super) fn misfit(&self, state: &State, p: usize, [at, opposite]: [usize; 2], count: usize) -> f64 {
        let (motion, _) = self.power(1.0);
        let missed = |[from, to]: [usize; 2]| (motion(&state.positions()[from]) - state.positions()[to]).norm();
        let around = |node: usize| node - count * p..node + count * p;
        let pairs = around(at).map(|i| [i, i + p]).chain(around(opposite).map(|i| [i + p, i]));
        pairs.map(missed).fold(0.0, f64::max)
    }

    /// The motion to a power, and the turn in it.
    pub(super) fn power(&self, k: f64) -> (impl Fn(&Vec3) -> Vec3 + use<>, Quat) {
        let turn = Quat::from_axis_angle(&self.axis, self.angle * k);
        let (point, shift) = (self.point, self.axis.into_inner() * (self.rise * k));
        (move |x: &Vec3| point + turn * (x - point) + shift, turn)
    }
}

/// A double helix in a state.
#[derive(Debug, Clone, Copy)]
pub(super) struct DoubleHelix {
    /// Order of the elements.
    pub(super) order: usize,
    /// Nodes opposite each other at which it becomes longer or shorter.
    pub(super) middle: [usize; 2],
    pub(super) screw: Screw,
}

/// Where a node of a state that is put together comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeOrigin {
    /// Number of the old node, not whole between nodes.
    pub(super) node: f64,
    /// Power of the screw motion.
    pub(super) power: f64,
    /// Angle about d3, rad.
    pub(super) spin: f64,
    /// Displacement after the screw motion \[L\].
    pub(super) shift: Vec3,
    /// Slope of the displacement along the rod.
    pub(super) slope: Vec3,
}

impl DoubleHelix {
    /// See [`Screw::measure`].
    pub(super) fn measure(state: &State, order: usize, middle: [usize; 2], count: usize) -> Option<Self> {
        Screw::measure(state, order, middle, count).map(|screw| Self { order, middle, screw })
    }

    /// Where a node comes from if the strands become longer by `strand` nodes each; `n` counts nodes from where the
    /// first one was before. Both together are whole numbers.
    pub(super) fn origin(&self, n: f64, strand: f64) -> NodeOrigin {
        let [from, to] = self.middle.map(|node| node as f64);
        let [first, second] = self.screw.spins;
        let (p, elements) = (self.order as f64, strand / self.order as f64);
        let (node, back, forth) = if n < from {
            (n, elements, 0.0)
        } else if n >= to + 2.0 * strand {
            (n - 2.0 * strand, 0.0, elements)
        } else {
            let old = (n - strand).round();
            let back = ((from - old) / p).ceil().max(0.0);
            let forth = ((old - to) / p).floor().max(0.0);
            (old + (back - forth) * p, back, forth)
        };
        let spin = (elements - back) * first + forth * second;
        NodeOrigin { node, power: elements - back - forth, spin, shift: Vec3::zeros(), slope: Vec3::zeros() }
    }

    /// Positions \[L\] and frames of nodes that come from places of a rod.
    pub(super) fn composed(
        &self,
        origins: &[NodeOrigin],
        place: impl Fn(f64) -> (Vec3, Quat),
    ) -> (Vec<Vec3>, Vec<Quat>) {
        let moved = |origin: &NodeOrigin| {
            let (position, frame) = place(origin.node);
            let (motion, turn) = self.screw.power(origin.power);
            let frame = turn * frame * spin(origin.spin);
            let tilt = exp(&(frame * Vec3::z()).cross(&origin.slope));
            (motion(&position) + origin.shift, tilt * frame)
        };
        origins.iter().map(moved).unzip()
    }
}
