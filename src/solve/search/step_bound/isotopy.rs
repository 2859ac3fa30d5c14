//! An isotopy between two states: a path from one to the other on which no strand passes through another.
//!
//! The path turns every chord between nodes as its frames turn, so that rods keep their lengths on it however far they
//! swing (a straight line between the states would squeeze a rod that rolls up to nothing), in parts of so small
//! rotations that each is nearly a straight line. Any free path is a proof that knots and links are kept.

use std::f64::consts::PI;

use super::{STEP, displacement, rotation};
use crate::error::SolveError;
use crate::math::quaternion::{exp, nearest_turn};
use crate::math::{Quat, Vec3};
use crate::solve::measures::{ARC, NOTHING};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

/// Largest number of parts, because each takes a look at all pairs. Longer motions are refused without one.
const MAX_PARTS: f64 = 64.0;

impl Engine {
    /// Whether no strand passes another on the path from `start` to the engine's state; contact
    /// geometry is that of the engine's state afterwards.
    ///
    /// # Errors
    /// Contact geometry that breaks down at the engine's state.
    pub(crate) fn is_path_free(&mut self, start: &State) -> Result<bool, SolveError> {
        let end = self.state().clone();
        // curves too coarse for contact on the path say nothing about its end
        let free = self.is_free_between(start, &end).unwrap_or(false);
        self.update_contact(&end)?;
        Ok(free)
    }

    fn is_free_between(&mut self, start: &State, end: &State) -> Result<bool, SolveError> {
        let increment = self.swings(start, end);
        let largest = (0..self.num_nodes()).map(|n| rotation(&increment, n).norm()).fold(0.0, f64::max);
        let parts = (largest / ARC).ceil().max(1.0);
        if parts.is_nan() || parts > MAX_PARTS {
            return Ok(false);
        }
        let mut state = start.clone();
        for part in 1..=parts as usize {
            let to = self.between(start, end, &increment, part as f64 / parts);
            let rest = to.increment_since(&state);
            if self.advance(&state, &rest, STEP)? < 1.0 {
                return Ok(false);
            }
            state = to;
        }
        Ok(true)
    }

    /// The increment between the states with the rotations that turn tangents only, whole turns added where those of
    /// neighbouring nodes would be more than half a turn apart. Spin about the tangent moves no strand.
    fn swings(&self, start: &State, end: &State) -> Vec<f64> {
        let mut increment = Vec::with_capacity(6 * self.num_nodes());
        for rod in 0..self.model.rods.len() {
            let mut before = Vec3::zeros();
            for node in self.nodes(rod) {
                let [from, to] = [start, end].map(|s| s.frames()[node] * Vec3::z());
                let mut swing = Quat::rotation_between(&from, &to).map_or(before, |q| q.scaled_axis());
                let angle = swing.norm();
                let axis = if angle > NOTHING { swing / angle } else { before.normalize() };
                if (before - swing).norm() > PI {
                    swing = nearest_turn(&axis, angle, &before);
                }
                increment.extend((end.positions()[node] - start.positions()[node]).iter().chain(swing.iter()));
                before = swing;
            }
        }
        increment
    }

    /// The state at t between 0 and 1 on the path.
    fn between(&self, start: &State, end: &State, increment: &[f64], t: f64) -> State {
        let moved = self.retract(start, increment, t);
        let mut positions = moved.positions().to_vec();
        for (index, rod) in self.model.rods.iter().enumerate() {
            let first = self.first_node[index];
            let count = rod.num_segments();
            let node = |k: usize| first + k % rod.num_nodes();
            let mut offsets = vec![Vec3::zeros()];
            for k in 0..count {
                let (a, b) = (node(k), node(k + 1));
                let mean = (rotation(increment, a) + rotation(increment, b)) * 0.5;
                let chords = [start, end].map(|s| s.positions()[b] - s.positions()[a]);
                let back = exp(&-mean) * chords[1];
                offsets.push(offsets[k] + exp(&(mean * t)) * (chords[0] * (1.0 - t) + back * t));
            }
            // what is held at both ends stays so
            let held = rod.closed || self.free[node(count)][..3] == [false; 3];
            let straight = |k: usize| start.positions()[node(k)] + displacement(increment, node(k)) * t;
            let miss = if held { straight(count) - straight(0) - offsets[count] } else { Vec3::zeros() };
            for k in 0..rod.num_nodes() {
                positions[node(k)] = straight(0) + offsets[k] + miss * (k as f64 / count as f64);
            }
        }
        moved.with_positions(positions)
    }
}
