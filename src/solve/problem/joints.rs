//! Joined nodes: the one place that says where they are.
//!
//! Joined nodes share the unknowns of the first of them, their master. Every state in which nodes have moved is made by
//! [`Engine::retract`] or taken by [`Engine::set_state`]. Both put the other nodes of a joint where its master is, and turn their
//! frames with the master's, so that no increment can part them.

use crate::error::InputError;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::follower::Follower;
use crate::solve::problem::state::State;

/// Largest distance over the node spacing, and turn, rad, of joined nodes, because numbers are given with six digits.
const MAX_GAP: f64 = 1e-6;

impl Engine {
    /// Moves every node by `t` times its six increments; joined nodes by those of their master.
    pub(crate) fn retract(&self, state: &State, increment: &[f64], t: f64) -> State {
        let mut next = state.moved(increment, t);
        self.followers.iter().for_each(|follower| follower.follow(&mut next));
        next
    }

    /// Gives joined nodes the increments of their master.
    pub(crate) fn join_increment(&self, increment: &mut [f64]) {
        for follower in &self.followers {
            let first = 6 * follower.master;
            increment.copy_within(first..first + 6, 6 * follower.node);
        }
    }

    /// Whether a node is joined to another.
    pub(crate) fn is_joined_node(&self, node: usize) -> bool {
        self.followers.iter().any(|follower| follower.node == node || follower.master == node)
    }

    /// Refuses a state whose joined nodes are [`MAX_GAP`] × node spacing apart, or [`MAX_GAP`] rad from how they were joined.
    pub(crate) fn check_joined(&self, state: &State) -> Result<(), InputError> {
        let parted = |follower: &&Follower| {
            let apart = state.chord(follower.master, follower.node).norm() / self.scales.lever;
            let turned = state.frames[follower.node].angle_to(&(state.frames[follower.master] * follower.turn));
            // not a number is parted, too
            !(apart <= MAX_GAP && turned <= MAX_GAP)
        };
        let Some(follower) = self.followers.iter().find(parted) else { return Ok(()) };
        let [a, b] = [follower.master, follower.node].map(|node| {
            let rod = self.rod_of(node);
            format!("node {} of rod \"{}\"", node - self.first_node[rod], self.model.rods[rod].name)
        });
        let reason = format!("parts joined nodes: {a} and {b} must coincide, and their frames be as they were joined");
        Err(InputError::inconsistent("state", reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::math::quaternion::exp;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Contact, Joint, Model, NodeRef, Support};

    /// Three rods at angles, joined at the origin; the first is clamped at its other end.
    fn star() -> Engine {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.0);
        let rod = |name: &str, from: Vec3, to: Vec3| {
            let shape = Shape::Line { start: from, direction: to - from, length: (to - from).norm() };
            Rod::new(name, &shape, RodMesh::open(4, 3), section, Natural::Straight).unwrap()
        };
        let o = Vec3::zeros();
        let rods = vec![rod("a", -Vec3::x(), o), rod("b", o, Vec3::y()), rod("c", o, Vec3::new(1.0, 0.0, 1.0))];
        let [a, b, c] = [(0, 12), (1, 0), (2, 0)].map(|(rod, node)| NodeRef { rod, node });
        let joints = vec![Joint { a, b }, Joint { a: b, b: c }];
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
        Engine::new(Model { rods, joints, supports, contact: Contact::NONE, ..Model::default() }, None).unwrap()
    }

    /// No increment parts joined nodes, whatever it has for each of them.
    #[test]
    fn joined_nodes_move_as_their_master() {
        let engine = star();
        assert_eq!(engine.followers.len(), 2);
        let before = engine.state.clone();
        let wild: Vec<f64> = (0..6 * engine.num_nodes()).map(|k| (1.7 * k as f64).sin()).collect();
        let after = engine.retract(&engine.retract(&before, &wild, 1.0), &wild, 0.3);
        let joined = [12, 13, 26];
        let turn = after.frames[12] * before.frames[12].inverse();
        for node in joined {
            assert_eq!(after.chord(12, node), Vec3::zeros());
            assert!(after.frames[node].angle_to(&(turn * before.frames[node])) < 1e-15, "{node}");
        }
        assert!(after.chord(12, 14).norm() > 0.1);
        engine.check_joined(&after).unwrap();
    }

    /// States that part joined nodes are refused, by position and by frame.
    #[test]
    fn states_that_part_joined_nodes_are_refused() {
        let mut engine = star();
        let whole = engine.state.clone();
        engine.set_state(whole.clone()).unwrap();
        let mut shifted = whole.clone();
        shifted.positions[13].y += 1e-3;
        let mut turned = whole.clone();
        turned.frames[26] = exp(&Vec3::new(0.0, 0.0, 1e-3)) * turned.frames[26];
        for (parted, name) in [(shifted, "node 0 of rod \"b\""), (turned, "node 0 of rod \"c\"")] {
            let message = engine.set_state(parted).unwrap_err().to_string();
            assert!(
                message.contains("parts joined nodes: node 12 of rod \"a\"") && message.contains(name),
                "{message}"
            );
        }
        assert_eq!(engine.state, whole);
    }
}
