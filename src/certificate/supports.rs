//! What is prescribed of nodes: supports hold them where stages have put them, joints hold them together, frames are
//! unit quaternions, and no frame turns past half a turn against its neighbour.
//!
//! ```text
//! supports   |x_k − x_k*|/h and the angle about axis k between q and q*, k held; x*, q* by the ramps from the start
//! joints     |(x_a − x_b) − (x_a − x_b)₀|/h
//!            rigid: angle between q̄_a q_b and (q̄_a q_b)₀; hinge: angle between both axes
//! frames     | |q| − 1 |
//! turning    angle between neighbours, turns, at most `MAX_TURN`
//! ```
//!
//! h is the node spacing. Positions have two parts, and each of the moves that led to a state is rounded in the second
//! one: tolerances are those of frames, products of unit quaternions.

use std::f64::consts::TAU;

use super::{Check, Subject, Worst, first_nodes, node_name};
use crate::math::quaternion::{exp, spin};
use crate::math::{Quat, Vec3};
use crate::rod::MAX_TURN;
use crate::scene::{JointKind, Model, NodeRef, Pose, Ramp, Stage, SupportChange};
use crate::solve::Given;

/// Largest deviation of a supported or joined node, node spacings or rad, because a frame is the product of one
/// rotation an iteration, each rounded to 1e-16, and the largest of all scenes' is 4e-12.
const TOL_POSE: f64 = 1e-10;
/// Largest deviation of a quaternion's length from 1, some units in the last place.
const TOL_UNIT: f64 = 1e-14;

pub(super) fn checks(subject: &Subject) -> Vec<Check> {
    let mut checks = vec![frames(subject), turning(subject)];
    checks.extend(supports(subject));
    checks.extend(joints(subject));
    checks
}

fn frames(subject: &Subject) -> Check {
    let mut worst = Worst::none();
    for_nodes(subject.model, |node, index| {
        worst.add((subject.state.frames()[index].norm() - 1.0).abs(), || node_name(subject.model, node));
    });
    Check::new("frames", worst.value, TOL_UNIT, worst.detail("| |q| − 1 |"))
}

fn turning(subject: &Subject) -> Check {
    let (model, state) = (subject.model, subject.state);
    let first = first_nodes(model);
    let mut worst = Worst::none();
    for (k, rod) in model.rods.iter().enumerate() {
        let frames = &state.frames()[first[k]..first[k + 1]];
        for node in 0..rod.num_segments() {
            let next = if node + 1 < frames.len() { frames[node + 1] } else { frames[0] * spin(state.seams()[k]) };
            let turns = frames[node].angle_to(&next) / TAU;
            worst.add(turns, || node_name(model, NodeRef { rod: k, node }));
        }
    }
    Check::new("turning", worst.value, MAX_TURN, worst.detail("turns to the next node"))
}

fn joints(subject: &Subject) -> Option<Check> {
    let (model, state) = (subject.model, subject.state);
    if model.joints.is_empty() {
        return None;
    }
    let first = first_nodes(model);
    let mut worst = Worst::none();
    for joint in &model.joints {
        let [a, b] = [joint.a, joint.b].map(|node| first[node.rod] + node.node);
        let given = |node: NodeRef| (model.rods[node.rod].positions[node.node], model.rods[node.rod].frames[node.node]);
        let ((x_a, q_a), (x_b, q_b)) = (given(joint.a), given(joint.b));
        let apart = (state.positions()[a] - state.positions()[b]) + (state.remainders()[a] - state.remainders()[b]);
        let spacing = model.rods[joint.a.rod].spacing().min(model.rods[joint.b.rod].spacing());
        let turned = match (joint.kind, model.hinge_axis(joint)) {
            (JointKind::Rigid, _) => (state.frames()[a].inverse() * state.frames()[b]).angle_to(&(q_a.inverse() * q_b)),
            (_, Some(axis)) => {
                let [of_a, of_b] =
                    [(a, q_a), (b, q_b)].map(|(at, given)| state.frames()[at] * (given.inverse() * axis));
                of_a.cross(&of_b).norm().atan2(of_a.dot(&of_b))
            }
            _ => 0.0,
        };
        let off = ((apart - (x_a - x_b)).norm() / spacing).max(turned);
        worst.add(off, || format!("{} and {}", node_name(model, joint.a), node_name(model, joint.b)));
    }
    Some(Check::new("joints", worst.value, TOL_POSE, worst.detail("node spacings or rad")))
}

fn supports(subject: &Subject) -> Option<Check> {
    let (given, stage, fraction) = subject.given?;
    let (model, state) = (subject.model, subject.state);
    let first = first_nodes(model);
    let mut worst = Worst::none();
    for support in &model.supports {
        let node = support.node;
        let Some(due) = Due::of(given, node, stage, fraction) else { continue };
        let index = first[node.rod] + node.node;
        let spacing = model.rods[node.rod].spacing();
        let off = (state.positions()[index] - due.position) + state.remainders()[index];
        let moved = (0..3).filter(|&k| support.position[k]).map(|k| off[k].abs() / spacing).fold(0.0, largest);
        let turned = due.turned_off(&state.frames()[index], model.fixed(node).1);
        worst.add(largest(moved, turned), || node_name(model, node));
    }
    Some(Check::new("supports", worst.value, TOL_POSE, worst.detail("node spacings or rad")))
}

/// The larger of two numbers; NaN if one is.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Calls `visit(node, global index)` for all nodes.
fn for_nodes(model: &Model, mut visit: impl FnMut(NodeRef, usize)) {
    let mut index = 0;
    for (rod, of) in model.rods.iter().enumerate() {
        for node in 0..of.num_nodes() {
            visit(NodeRef { rod, node }, index);
            index += 1;
        }
    }
}

/// Where a supported node is due.
#[derive(Debug, Clone)]
struct Due {
    position: Vec3,
    /// Where its rotation is held altogether or about two axes.
    frame: Quat,
    /// Frame that it was given.
    start: Quat,
    /// Displacement and turns by ramps so far.
    displaced: Vec3,
    turned: f64,
    /// Whether stages turn the node, hold it or bring it to a pose.
    is_moved: bool,
}

impl Due {
    /// Of a node after a fraction of a stage; `None` where that is not known: the node was held on the way of another
    /// run, or is joined to one that is brought to a pose, or pinned to one that is carried round an axis.
    fn of(given: &Given, node: NodeRef, stage: usize, fraction: f64) -> Option<Self> {
        let rod = given.model.rods.get(node.rod)?;
        let (position, frame) = (*rod.positions.get(node.node)?, *rod.frames.get(node.node)?);
        let (displaced, turned) = (Vec3::zeros(), 0.0);
        let mut due = Self { position, frame, start: frame, displaced, turned, is_moved: false };
        let joined = [given.model.joined_nodes(node), given.model.turning_nodes(node)];
        for (k, of) in given.stages.iter().enumerate().take(stage + 1) {
            let part = if k < stage { 1.0 } else { fraction };
            if k < stage || part > 0.0 {
                due.go_through(given, of, (node, &joined), part)?;
            }
        }
        Some(due)
    }

    fn go_through(
        &mut self,
        given: &Given,
        stage: &Stage,
        (node, [joined, turning]): (NodeRef, &[Vec<NodeRef>; 2]),
        part: f64,
    ) -> Option<()> {
        let is_held =
            |change: &SupportChange| matches!(change, SupportChange::Hold(support) if joined.contains(&support.node));
        if stage.supports.iter().any(is_held) {
            let (position, frame) = *given.held.get(&node)?;
            (self.position, self.frame, self.is_moved) = (position, frame, true);
        }
        for change in &stage.supports {
            let SupportChange::Hold(support) = change else { continue };
            let [places, frames] = given.model.moved_with(support);
            self.displaced = if places.contains(&node) { Vec3::zeros() } else { self.displaced };
            self.turned = if frames.contains(&node) { 0.0 } else { self.turned };
        }
        for ramp in &stage.ramps {
            match ramp {
                Ramp::Displacement { node: at, to } if joined.contains(at) => {
                    let by = (to - self.displaced) * part;
                    self.position += by;
                    self.displaced += by;
                }
                _ => {}
            }
        }
        for ramp in &stage.ramps {
            match ramp {
                Ramp::Rotation { node: at, axis, to } if turning.contains(at) => {
                    self.turn(axis, (to - self.turned) * part)
                }
                Ramp::RotationAbout { node: at, axis, through, to } if joined.contains(at) => {
                    if !turning.contains(at) {
                        return None;
                    }
                    let turns = (to - self.turned) * part;
                    let by = exp(&(axis.normalize() * (TAU * turns)));
                    // the axis moves with the displacements of the node
                    let arm = self.position - self.displaced - through;
                    self.position += by * arm - arm;
                    self.turn(axis, turns);
                }
                Ramp::Pose { node: at, pose } if joined.contains(at) => {
                    if *at != node {
                        return None;
                    }
                    self.approach(pose, part);
                }
                _ => {}
            }
        }
        Some(())
    }

    fn turn(&mut self, axis: &Vec3, turns: f64) {
        self.frame = exp(&(axis.normalize() * (TAU * turns))) * self.frame;
        self.turned += turns;
        self.is_moved |= turns != 0.0;
    }

    fn approach(&mut self, pose: &Pose, part: f64) {
        let way = pose.remaining_path(&self.position, &Vec3::zeros(), &self.frame, self.turned);
        self.position += way.displacement(part);
        self.frame = exp(&(way.rotation * part)) * self.frame * spin(TAU * way.turns * part);
        self.turned += way.turns * part;
        self.is_moved = true;
    }

    /// Angle by which a frame is turned about axes that are held, rad.
    fn turned_off(&self, frame: &Quat, held: [bool; 3]) -> f64 {
        match held.iter().filter(|held| **held).count() {
            0 => 0.0,
            3 => frame.angle_to(&self.frame),
            // a ramp about one of two held axes, or a hold: the other motion is not known
            _ if self.is_moved => 0.0,
            2 => {
                let turn = (frame * self.frame.inverse()).scaled_axis();
                (0..3).filter(|&k| held[k]).map(|k| turn[k].abs()).fold(0.0, largest)
            }
            _ => {
                let turn = (frame * self.start.inverse()).imag();
                (0..3).filter(|&k| held[k]).map(|k| 2.0 * turn[k].abs()).fold(0.0, largest)
            }
        }
    }
}
