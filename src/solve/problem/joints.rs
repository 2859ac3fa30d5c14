//! Joined nodes: the one place that says where they are.
//!
//! Joined nodes share unknowns of the first of them: their position, and of their rotation all (rigid joints), none
//! (pins) or what is not about an axis (hinges). [`Engine::retract`] puts the other nodes of a joint where the first
//! one is, and turns their frames with it, so that no increment can part them. States made otherwise come into force by
//! [`Engine::take_state`], which does the same with nodes that they part, or by [`Engine::set_state`], which refuses
//! these.
//!
//! The rotations of hinged nodes have three components in one basis (p, q, e), e the axis in space: those about p and q
//! are shared, that about e is each node's own. A node b that follows a has R_b = R_a T exp(θ ē), so a motion by the
//! rotation vectors a and b = a + φe, φ = (b − a)·e, makes
//!
//! ```text
//! exp(a) exp(φe) R_b = exp(a + φe + ½φ a × e + …) R_b
//! ```
//!
//! The last term does work ½φ M·(a × e) with the moment M that the potential's gradient has at b: it belongs to the
//! tangent.

use crate::error::InputError;
use crate::math::Vec3;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::follower::{Follower, Turning};
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::Bases;
use crate::sparse::Pattern;

/// Largest distance over the node spacing, and turn, rad, of joined nodes, because numbers are given with six digits.
const MAX_GAP: f64 = 1e-6;

impl Engine {
    /// Moves every node by `t` times its six increments; joined nodes by those they share.
    pub(crate) fn retract(&self, state: &State, increment: &[f64], t: f64) -> State {
        let mut next = state.moved(increment, t);
        self.sharing.follow(&mut next);
        next
    }

    /// Puts a state of the same nodes in force. Joined nodes that it parts are joined where the first of them is.
    pub(crate) fn take_state(&mut self, state: State) {
        drop(self.exchange_state(state));
    }

    /// [`Engine::take_state`], which returns the state of before.
    pub(crate) fn exchange_state(&mut self, mut state: State) -> State {
        debug_assert_eq!(state.positions.len(), self.num_nodes());
        if self.parted(&state).is_some() {
            self.sharing.follow(&mut state);
        }
        std::mem::replace(&mut self.state, state)
    }

    /// Gives joined nodes the increments that they share, at a state.
    pub(crate) fn join_increment(&self, state: &State, increment: &mut [f64]) {
        let rotation = |all: &[f64], node: usize| Vec3::from_column_slice(&all[6 * node + 3..6 * node + 6]);
        for Follower { node, master, turning } in &self.sharing.followers {
            increment.copy_within(6 * master..6 * master + 3, 6 * node);
            let turn = match turning {
                Turning::Own => continue,
                Turning::With { node: other, .. } => rotation(increment, *other),
                Turning::About { node: other, axis, .. } => {
                    let (axis, shared) = (state.frames[*node] * axis, rotation(increment, *other));
                    shared + axis * axis.dot(&(rotation(increment, *node) - shared))
                }
            };
            increment[6 * node + 3..6 * node + 6].copy_from_slice(turn.as_slice());
        }
    }

    /// Moves the forces and moments on joined nodes, six numbers a node, to the owners of the unknowns in the engine's
    /// state.
    pub(crate) fn give_to_masters(&self, forces: &mut [f64]) {
        if !self.sharing.followers.is_empty() {
            self.bases(&self.state).give_to_masters(&self.sharing, forces);
        }
    }

    /// Adds to the tangent what the rotations of hinged nodes do in second order to a gradient of forces and moments on
    /// nodes.
    pub(in crate::solve) fn add_hinges(
        &self,
        gradient: &[f64],
        (pattern, bases): (&Pattern, &Bases),
        values: &mut [f64],
    ) {
        for hinged in &self.sharing.hinged {
            for &node in hinged.nodes.iter().filter(|node| **node != hinged.first) {
                if self.sharing.owner[node][5] == hinged.first {
                    continue;
                }
                let axis = bases.axis(node);
                let moment = Vec3::from_column_slice(&gradient[6 * node + 3..6 * node + 6]);
                let across = axis.cross(&moment);
                for (at, sign) in [(node, 0.5), (hinged.first, -0.5)] {
                    bases.add_block(pattern, values, (at, at), |i, j| {
                        let product = |i: usize, j: usize| axis[i - 3] * across[j - 3];
                        if i < 3 || j < 3 { 0.0 } else { sign * (product(i, j) + product(j, i)) }
                    });
                }
            }
        }
    }

    /// Motions of nodes, and those of the nodes joined to them: all move along, rigidly joined ones turn along.
    pub(crate) fn with_joined(&self, motions: &[(usize, Vec3, Vec3)]) -> Vec<(usize, Vec3, Vec3)> {
        let owner = &self.sharing.owner;
        let mut all = Vec::new();
        for &(node, by, turn) in motions {
            let [position, .., rotation] = owner[node];
            let followers = self.sharing.followers.iter().map(|follower| follower.node);
            let joined = followers.filter(|&other| owner[other][0] == position && other != position);
            for other in std::iter::once(position).chain(joined) {
                let turns = if owner[other][5] == rotation { turn } else { Vec3::zeros() };
                all.push((other, by, turns));
            }
        }
        all
    }

    /// Whether rigid joints or hinges make a node turn with another.
    pub(crate) fn is_turning_joined(&self, node: usize) -> bool {
        let is_with = |follower: &Follower| match follower.turning {
            Turning::Own => false,
            Turning::With { node: other, .. } | Turning::About { node: other, .. } => {
                follower.node == node || other == node
            }
        };
        self.sharing.followers.iter().any(is_with)
    }

    /// The first joined node that a state puts [`MAX_GAP`] × node spacing from where it belongs, or turns [`MAX_GAP`]
    /// rad from how it was joined.
    fn parted(&self, state: &State) -> Option<&Follower> {
        self.sharing.followers.iter().find(|follower| {
            let apart = state.chord(follower.master, follower.node).norm() / self.scales.lever;
            let turned = follower.turned_off(state);
            // not a number is parted, too
            !(apart <= MAX_GAP && turned <= MAX_GAP)
        })
    }

    /// Refuses a state that parts joined nodes.
    pub(crate) fn check_joined(&self, state: &State) -> Result<(), InputError> {
        let Some(follower) = self.parted(state) else { return Ok(()) };
        let [a, b] = [follower.master, follower.node].map(|node| {
            let rod = self.rod_of(node);
            format!("node {} of rod \"{}\"", node - self.first_node[rod], self.model.rods[rod].name)
        });
        let how = match follower.turning {
            Turning::Own => "",
            Turning::With { .. } => ", and their frames be as they were joined",
            Turning::About { .. } => ", and their frames turn about the axis of their hinge only",
        };
        Err(InputError::inconsistent("state", format!("parts joined nodes: {a} and {b} must coincide{how}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::math::quaternion::exp;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Contact, Joint, JointKind, Model, NodeRef, Support};
    use crate::solve::problem::assembly::Tangent;
    use crate::solve::problem::prescribed_motion::{PrescribedMotion, lifted};
    use crate::solve::problem::reduction::Reduction;

    /// Three rods at angles, joined at the origin; the first is clamped at its other end.
    fn star(kinds: [JointKind; 2]) -> Engine {
        let section = Section::isotropic(1.0, 1.0, 30.0, 20.0, 0.0);
        let rod = |name: &str, from: Vec3, to: Vec3| {
            let shape = Shape::Line { start: from, direction: to - from, length: (to - from).norm() };
            Rod::new(name, &shape, RodMesh::open(4, 3), section, Natural::Straight).unwrap()
        };
        let o = Vec3::zeros();
        let rods = vec![rod("a", -Vec3::x(), o), rod("b", o, Vec3::y()), rod("c", o, Vec3::new(1.0, 0.0, 1.0))];
        let [a, b, c] = [(0, 12), (1, 0), (2, 0)].map(|(rod, node)| NodeRef { rod, node });
        let joints = vec![Joint { a, b, kind: kinds[0] }, Joint { a: b, b: c, kind: kinds[1] }];
        let supports = vec![Support::clamp(NodeRef { rod: 0, node: 0 })];
        Engine::new(Model { rods, joints, supports, contact: Contact::NONE, ..Model::default() }, None).unwrap()
    }

    /// Symptom: a run with hinges that was taken up from a checkpoint ended with other last bits: frames were put in
    /// place again, and rounded again.
    #[test]
    fn joined_states_keep_their_bits() {
        let hinge = JointKind::Hinge { axis: Vec3::new(0.3, -0.5, 0.8) };
        for kinds in [[hinge, JointKind::Pin], [JointKind::Rigid, hinge], [hinge, hinge]] {
            let mut engine = star(kinds);
            for round in 1..200 {
                let at = |i: usize| 0.3 * ((1 + i * round) as f64).sin();
                let increment: Vec<f64> = (0..6 * engine.num_nodes()).map(at).collect();
                let state = engine.retract(engine.state(), &increment, 1.0);
                let mut again = state.clone();
                engine.sharing.follow(&mut again);
                assert!(again == state, "{round}");
                engine.take_state(state);
            }
        }
    }

    /// No increment parts joined nodes, whatever it has for each of them.
    #[test]
    fn joined_nodes_move_as_their_master() {
        let engine = star([JointKind::Rigid; 2]);
        assert_eq!(engine.sharing.followers.len(), 2);
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

    /// A joint that turns about the tangent of one of its rods turns all of them: no frames are spun beforehand.
    #[test]
    fn a_joint_is_not_spun_with_one_rod() {
        let engine = star([JointKind::Rigid; 2]);
        let nodes = engine.with_joined(&[(13, Vec3::zeros(), Vec3::x() * 0.3)]);
        assert!(nodes.iter().map(|motion| motion.0).eq([12, 13, 26]) && nodes.iter().all(|n| n.2 == nodes[0].2));
        let drive = PrescribedMotion { nodes, seams: Vec::new() };
        let made = lifted(&engine, &engine.state, &drive);
        engine.check_joined(&made.state).unwrap();
        assert!(made.spun.is_empty() && made.drive == drive);
    }

    fn hinge() -> JointKind {
        JointKind::Hinge { axis: Vec3::new(0.3, -0.7, 0.9) }
    }

    /// Six numbers a node without a rule.
    fn wild(engine: &Engine) -> Vec<f64> {
        (0..6 * engine.num_nodes()).map(|k| (1.7 * k as f64 + 0.3 * (k * k) as f64).sin()).collect()
    }

    /// Whatever an increment has for each of them, nodes at a pin stay together, at a hinge also the axis on both rods.
    #[test]
    fn pins_and_hinges_stay_together() {
        let (rigid, pin, hinge) = (JointKind::Rigid, JointKind::Pin, hinge());
        for kinds in [[pin, pin], [pin, rigid], [hinge, pin], [hinge, rigid], [rigid, hinge], [hinge, hinge]] {
            let engine = star(kinds);
            let (before, increment) = (engine.state.clone(), wild(&engine));
            let after = engine.retract(&engine.retract(&before, &increment, 0.8), &increment, 0.3);
            engine.check_joined(&after).unwrap();
            let turns = [12, 13, 26].map(|node| after.frames[node] * before.frames[node].inverse());
            for (k, kind) in kinds.iter().enumerate() {
                assert_eq!(after.chord(12 + k, [13, 26][k]), Vec3::zeros());
                let between = turns[k].inverse() * turns[k + 1];
                match kind {
                    JointKind::Rigid => assert!(between.angle() < 1e-15, "{}", between.angle()),
                    JointKind::Pin => assert!(between.angle() > 0.1),
                    JointKind::Hinge { axis } => {
                        assert!(between.angle() > 0.1 && between.imag().cross(axis).norm() < 1e-15, "{between}");
                    }
                }
            }
        }
    }

    /// Along a motion of the unknowns the gradient is the first derivative of the potential, the tangent the second.
    #[test]
    fn the_tangent_is_the_second_derivative() {
        let (rigid, pin, hinge) = (JointKind::Rigid, JointKind::Pin, hinge());
        for kinds in
            [[rigid, rigid], [pin, pin], [pin, rigid], [hinge, pin], [hinge, rigid], [rigid, hinge], [hinge, hinge]]
        {
            let engine = star(kinds);
            let state = engine.retract(&engine.state, &wild(&engine), 0.05);
            let pattern = engine.node_graph().natural();
            let mut tangent = Tangent::default();
            let at = engine.linearise(&state, None, &PrescribedMotion::default(), (&pattern, &mut tangent));
            let reduction = Reduction { pattern: &pattern, bases: &at.bases };
            let unknowns: Vec<f64> = (0..pattern.num_equations()).map(|k| (2.3 * k as f64).cos()).collect();
            let motion = reduction.motion_of_nodes(6 * engine.num_nodes(), &unknowns);
            let along = |t: f64| engine.residual(&engine.retract(&state, &motion, t)).potential.total();
            let dot = |x: &[f64]| x.iter().zip(&unknowns).map(|(a, b)| a * b).sum::<f64>();
            let (slope, h) = (dot(&reduction.forces(&at.gradient)), 1e-4);
            let measured = (along(h) - along(-h)) / (2.0 * h);
            assert!((slope / measured - 1.0).abs() < 1e-5, "{kinds:?}: {slope} {measured}");
            let curvature = dot(&pattern.multiply(&tangent.values, &unknowns));
            let measured = (along(h) + along(-h) - 2.0 * along(0.0)) / (h * h);
            assert!((curvature / measured - 1.0).abs() < 1e-5, "{kinds:?}: {curvature} {measured}");
            // element by element the material part is the same
            let mut besides = Tangent::default();
            engine.linearise_besides_material(&state, &engine.actual_stress(&state), (&pattern, &mut besides));
            let mut parts = pattern.multiply(&besides.values, &unknowns);
            let material = reduction.forces(&engine.material_product(&state, &motion));
            parts.iter_mut().zip(&material).for_each(|(part, material)| *part += material);
            let whole = pattern.multiply(&tangent.values, &unknowns);
            let largest = whole.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            let apart = whole.iter().zip(&parts).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-13 * largest, "{kinds:?}: {apart} of {largest}");
            // forces on nodes do the work of those on unknowns
            let work: f64 = at.gradient.iter().zip(&motion).map(|(a, b)| a * b).sum();
            assert!((work / slope - 1.0).abs() < 1e-12, "{kinds:?}: {work} {slope}");
        }
    }

    /// States that part joined nodes are refused, by position and by frame.
    #[test]
    fn states_that_part_joined_nodes_are_refused() {
        let mut engine = star([JointKind::Rigid; 2]);
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

    /// A state put in force has its joined nodes where the first one is; one that parts none stays as it is to the last
    /// bit.
    #[test]
    fn states_in_force_are_joined() {
        let mut engine = star([JointKind::Rigid, hinge()]);
        let wild: Vec<f64> = (0..6 * engine.num_nodes()).map(|k| (1.7 * k as f64).sin()).collect();
        let whole = engine.retract(&engine.state, &wild, 0.4);
        engine.take_state(whole.clone());
        assert_eq!(engine.state, whole);
        let mut parted = whole.clone();
        parted.positions[13].y += 1e-3;
        parted.frames[26] = exp(&Vec3::new(0.1, 0.0, 0.0)) * parted.frames[26];
        assert!(engine.check_joined(&parted).is_err());
        assert_eq!(engine.exchange_state(parted), whole);
        engine.check_joined(&engine.state).unwrap();
        assert_eq!(engine.state.positions, whole.positions);
    }
}
