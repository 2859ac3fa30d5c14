//! A joined node but the first of its joint: where it is, by the states of the nodes it follows.

use nalgebra::Unit;

use crate::math::{Mat3, Quat, Vec3};
use crate::scene::{Model, NodeRef};
use crate::solve::problem::state::State;

/// Tilt of a hinged frame, rad, that is rounding, because a state whose nodes are joined must keep its bits when it is
/// put in force again.
const LEVEL: f64 = 8.0 * f64::EPSILON;

/// How a node turns with another one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Turning {
    /// On its own.
    Own,
    /// As the other does.
    With {
        node: usize,
        /// From the frame of the other node to its own, as the joint was made.
        turn: Quat,
    },
    /// As the other does, and on its own about an axis.
    About {
        node: usize,
        /// From the frame of the other node to its own, as the joint was made.
        turn: Quat,
        /// Unit vector, in its own frame.
        axis: Vec3,
    },
}

/// A joined node that is not the first.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Follower {
    pub(super) node: usize,
    /// The node that its position is of.
    pub(super) master: usize,
    pub(super) turning: Turning,
}

/// Nodes joined by hinges: they share their rotation but about one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Hinged {
    /// All of them, ascending.
    pub(super) nodes: Vec<usize>,
    /// That which the others turn with.
    pub(super) first: usize,
    /// Orthonormal basis in its frame; the third vector is the axis.
    basis: Mat3,
}

impl Hinged {
    /// The basis in space.
    pub(super) fn basis(&self, state: &State) -> Mat3 {
        state.frames[self.first].to_rotation_matrix() * self.basis
    }
}

/// What nodes share with others.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sharing {
    /// Per node and unknown, six a node: the node whose unknown it is, itself unless joined. Third rotations of hinged
    /// nodes are those about the axis.
    pub(crate) owner: Vec<[usize; 6]>,
    /// Those that share something, in an order in which none follows a later one.
    pub(crate) followers: Vec<Follower>,
    pub(crate) hinged: Vec<Hinged>,
}

impl Sharing {
    /// Of a model whose rods begin at these nodes. Of hinged nodes the first one is one that supports hold, if there is
    /// any.
    pub(crate) fn of(model: &Model, first_node: &[usize]) -> Self {
        let num_nodes = first_node[model.rods.len()];
        let mut sharing = Self { owner: (0..num_nodes).map(|node| [node; 6]).collect(), ..Self::default() };
        let index = |at: &NodeRef| first_node[at.rod] + at.node;
        let frame = |node: usize| {
            let rod = first_node.partition_point(|&first| first <= node) - 1;
            model.rods[rod].frames[node - first_node[rod]]
        };
        let least = |nodes: &[NodeRef]| nodes.iter().map(index).min();
        for at in model.joints.iter().flat_map(|joint| [joint.a, joint.b]) {
            let node = index(&at);
            let (joined, hinged) = (model.joined_nodes(at), model.hinged_nodes(at));
            let is_held = |other: &&NodeRef| model.fixed(**other).1 == [true; 3];
            let held: Vec<NodeRef> = hinged.iter().filter(is_held).copied().collect();
            let leading = model.turning_nodes(
                *held.iter().min_by_key(|at| index(at)).or(hinged.iter().min_by_key(|at| index(at))).unwrap_or(&at),
            );
            let of = |nodes: &[NodeRef]| least(nodes).unwrap_or(node);
            let (position, first, own) = (of(&joined), of(&leading), of(&model.turning_nodes(at)));
            sharing.owner[node] = [position, position, position, first, first, own];
            let axis =
                model.joints.iter().find_map(|joint| model.hinge_axis(joint).filter(|_| hinged.contains(&joint.a)));
            if let Some(axis) = axis.filter(|_| first == node) {
                let mut nodes: Vec<usize> = hinged.iter().map(index).collect();
                nodes.sort_unstable();
                let own = frame(node).inverse() * axis;
                let across = Vec3::ith(own.iamin(), 1.0).cross(&own).normalize();
                let basis = Mat3::from_columns(&[across, own.cross(&across), own]);
                sharing.hinged.push(Hinged { nodes, first, basis });
            }
            let turn = |other: usize| Unit::new_normalize((frame(other).inverse() * frame(node)).into_inner());
            let turning = match (own == node, first == node, axis) {
                (false, ..) => Turning::With { node: own, turn: turn(own) },
                (true, false, Some(axis)) => {
                    Turning::About { node: first, turn: turn(first), axis: (frame(node).inverse() * axis).normalize() }
                }
                _ => Turning::Own,
            };
            if position != node || turning != Turning::Own {
                sharing.followers.push(Follower { node, master: position, turning });
            }
        }
        sharing.hinged.sort_by_key(|hinged| hinged.first);
        sharing.hinged.dedup();
        sharing.followers.sort_by_key(|follower| follower.node);
        sharing.followers.dedup();
        sharing
    }

    /// Puts the nodes where those are that they follow.
    pub(crate) fn follow(&self, state: &mut State) {
        self.followers.iter().for_each(|follower| follower.follow(state));
    }

    /// Moves sizes of forces, or masses, six a node, to the owners of the unknowns. What hinged nodes share is left
    /// with each.
    pub(crate) fn give_sizes(&self, values: &mut [f64]) {
        for node in self.followers.iter().map(|follower| follower.node) {
            for k in 0..6 {
                let to = self.owner[node][if k < 3 { k } else { 5 }];
                let share = std::mem::take(&mut values[6 * node + k]);
                values[6 * to + k] += share;
            }
        }
    }
}

/// The part of a rotation about an axis, rad, and how far the axis is tilted, rad.
pub(super) fn about(rotation: &Quat, axis: &Vec3) -> (Quat, f64) {
    let along = rotation.imag().dot(axis);
    let twist = nalgebra::Quaternion::from_parts(rotation.w, axis * along);
    // a tilt by half a turn has none
    let twist = if twist.norm() > 0.0 { Unit::new_normalize(twist) } else { Quat::identity() };
    let tilt = (rotation * axis).cross(axis).norm().atan2((rotation * axis).dot(axis));
    (twist, tilt)
}

impl Follower {
    /// Puts the node where those are that it follows. Its turn about a hinge's axis is that of its own frame.
    fn follow(&self, state: &mut State) {
        state.positions[self.node] = state.positions[self.master];
        state.remainders[self.node] = state.remainders[self.master];
        match &self.turning {
            Turning::Own => {}
            Turning::With { node, turn } => {
                state.frames[self.node] = Unit::new_normalize((state.frames[*node] * turn).into_inner());
            }
            Turning::About { node, turn, axis } => {
                let rest = state.frames[*node] * turn;
                let (twist, tilt) = about(&(rest.inverse() * state.frames[self.node]), axis);
                // not a number is tilted, too
                if tilt.is_nan() || tilt > LEVEL {
                    state.frames[self.node] = Unit::new_normalize((rest * twist).into_inner());
                }
            }
        }
    }

    /// By how much its frame is off what the joint permits, rad.
    pub(super) fn turned_off(&self, state: &State) -> f64 {
        let own = state.frames[self.node];
        match &self.turning {
            Turning::Own => 0.0,
            Turning::With { node, turn } => own.angle_to(&(state.frames[*node] * turn)),
            Turning::About { node, turn, axis } => about(&((state.frames[*node] * turn).inverse() * own), axis).1,
        }
    }
}
