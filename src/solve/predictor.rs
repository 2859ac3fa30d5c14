//! Where a path is heading: the next state extrapolated from the last accepted ones.
//!
//! A polynomial through the last two or three states, in the fraction of the stage done, for positions and for
//! quaternions (as vectors of ℝ⁴ with aligned signs, normalised afterwards). Seams are turned to their target in all of
//! them first, so that only what the rods did in answer is extrapolated. Linear extrapolation stretches a rod that
//! rotates by the square of its turn; the parabola by the cube, which is what makes a prediction near contact worth its
//! price.

use nalgebra::Unit;

use crate::math::shape_functions::lagrange_weight;
use crate::math::{Quat, Vec3};
use crate::solve::engine::Engine;
use crate::solve::state::{Drive, State};

/// States kept.
const KEPT: usize = 3;

/// The last accepted states of a stage.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct History {
    /// Fraction of the stage done and the state there, oldest first.
    states: Vec<(f64, State)>,
}

impl History {
    /// Adds an accepted state.
    pub(crate) fn push(&mut self, fraction: f64, state: State) {
        if self.states.len() == KEPT {
            self.states.remove(0);
        }
        self.states.push((fraction, state));
    }

    /// Begins a stage at `state`.
    pub(crate) fn restart(&mut self, state: &State) {
        self.states.clear();
        self.states.push((0.0, state.clone()));
    }

    /// Forgets the way so far: the path has jumped.
    pub(crate) fn clear(&mut self) {
        self.states.clear();
    }

    /// All states kept.
    pub(crate) fn states(&self) -> impl Iterator<Item = &State> {
        self.states.iter().map(|(_, state)| state)
    }

    /// The increment from the engine's state with its seams turned by `drive` to the state predicted at `fraction`,
    /// supported unknowns moved by exactly what is prescribed. `None` until two states are known.
    pub(crate) fn predict(&self, engine: &Engine, drive: &Drive, fraction: f64) -> Option<Vec<f64>> {
        if self.states.len() < 2 {
            return None;
        }
        let present = turned(engine, &engine.state, drive);
        let mut predicted = present.clone();
        predicted.positions.iter_mut().chain(&mut predicted.remainders).for_each(|r| *r = Vec3::zeros());
        let mut frames = vec![nalgebra::Vector4::zeros(); present.frames.len()];
        for (index, (_, state)) in self.states.iter().enumerate() {
            let weight = lagrange_weight(self.states.len(), |k| self.states[k].0, index, fraction);
            let mut state = state.clone();
            for rod in 0..state.seams.len() {
                let nodes = engine.nodes(rod);
                state.twist(rod, nodes, present.seams[rod] - state.seams[rod]);
            }
            for (node, sum) in frames.iter_mut().enumerate() {
                predicted.positions[node] += state.positions[node] * weight;
                let q = state.frames[node].coords;
                let sign = if q.dot(&present.frames[node].coords) < 0.0 { -1.0 } else { 1.0 };
                *sum += q * (sign * weight);
            }
        }
        for (frame, sum) in predicted.frames.iter_mut().zip(frames) {
            *frame = Unit::new_normalize(*Quat::new_unchecked(nalgebra::Quaternion::from(sum)));
        }
        let mut increment = predicted.increment_since(&present);
        for (node, free) in engine.free.iter().enumerate() {
            for k in (0..6).filter(|&k| !free[k]) {
                increment[6 * node + k] = 0.0;
            }
        }
        drive.add_to(&mut increment);
        Some(increment)
    }
}

/// A state with all seams turned by the drive.
pub(crate) fn turned(engine: &Engine, state: &State, drive: &Drive) -> State {
    let mut state = state.clone();
    for (rod, &angle) in drive.seams.iter().enumerate() {
        state.twist(rod, engine.nodes(rod), angle);
    }
    state
}
