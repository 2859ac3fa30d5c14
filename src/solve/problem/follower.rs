//! A joined node but the master of its joint: where it is, by the state of its master.

use nalgebra::Unit;

use crate::math::Quat;
use crate::solve::problem::state::State;

/// A joined node that is not the master.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Follower {
    pub(super) node: usize,
    pub(super) master: usize,
    /// From the frame of the master to that of the node, as the joint was made.
    pub(super) turn: Quat,
}

impl Follower {
    /// All of them, by the frames of the start and the master of each node.
    pub(crate) fn all(frames: &[Quat], master: &[usize]) -> Vec<Self> {
        let follower = |(node, &master): (usize, &usize)| {
            let turn = Unit::new_normalize((frames[master].inverse() * frames[node]).into_inner());
            (master != node).then_some(Self { node, master, turn })
        };
        master.iter().enumerate().filter_map(follower).collect()
    }

    /// Puts the node where its master is.
    pub(crate) fn follow(&self, state: &mut State) {
        state.positions[self.node] = state.positions[self.master];
        state.remainders[self.node] = state.remainders[self.master];
        state.frames[self.node] = Unit::new_normalize((state.frames[self.master] * self.turn).into_inner());
    }
}
