//! Rotations of parts of joined rods about the pins and hinges that the others hold them by: a bar of a mobile turns
//! about the plumb line through its pin, a bar between two pins about the line through these.
//!
//! A part is what a point, pinned or hinged, holds and no support, obstacle or other contact: it turns about that
//! point, at a hinge about the axis, and the force of the joint does no work. A body that only pins and supports of
//! positions hold, all on one line, turns about that line. Parts are nested or disjoint, because the body that is held
//! first, or else the first one, is in none of them.

use std::collections::BTreeMap;

use super::{is_turned_by, motion_of};
use crate::math::Vec3;
use crate::math::groups::Groups;
use crate::scene::{JointKind, NodeRef};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

/// A rotation of some rods of a group, as a motion of its nodes.
pub(super) struct PartRotation {
    pub(super) motion: Vec<f64>,
    /// Rotation vector.
    pub(super) turn: Vec3,
    /// Whether a node of the group takes part.
    pub(super) moves: Vec<bool>,
    pub(super) count: usize,
}

/// Points where bodies of a group are joined, other than rigidly.
struct JointPoint {
    node: NodeRef,
    /// Bodies that meet there, without repetition.
    bodies: Vec<usize>,
    /// Axis in space, of a point where all is hinged.
    axis: Option<Vec3>,
}

/// The rotations of the parts of a group of rods, whose nodes these are.
pub(super) fn part_rotations(
    engine: &Engine,
    (state, residual): (&State, &Residual),
    group: &[usize],
    nodes: &[usize],
) -> Vec<PartRotation> {
    let model = &engine.model;
    let is_here = |rod: &usize| group.binary_search(rod).is_ok();
    if model.planar || !model.joints.iter().any(|joint| joint.kind != JointKind::Rigid && is_here(&joint.a.rod)) {
        return Vec::new();
    }
    let (body, touched) = bodies(engine, residual);
    let mut held = vec![false; model.rods.len()];
    let by_supports = model.supports.iter().map(|support| support.node.rod);
    touched.iter().copied().chain(by_supports).for_each(|rod| held[body[rod]] = true);
    let points = points(engine, state, &body, is_here);
    let root = (0..model.rods.len()).find(|rod| is_here(rod) && held[body[*rod]]).unwrap_or(group[0]);
    let mut found = Vec::new();
    let mut add = |within: &dyn Fn(usize) -> bool, center: Vec3, turn: Vec3| {
        let moves: Vec<bool> = nodes.iter().map(|&node| within(body[engine.rod_of(node)])).collect();
        let count = moves.iter().filter(|moves| **moves).count();
        let motion = motion_of(state, (nodes, &moves), center, turn);
        found.push(PartRotation { motion, turn, moves, count });
    };
    for (index, point) in points.iter().enumerate() {
        let center = state.positions[engine.index(point.node)];
        let mut scratch = Vec::new();
        let mut parts = Groups::apart(model.rods.len(), &mut scratch);
        for (_, other) in points.iter().enumerate().filter(|(k, _)| *k != index) {
            other.bodies.windows(2).for_each(|pair| parts.join(pair[0], pair[1]));
        }
        let part_of: Vec<usize> = (0..model.rods.len()).map(|rod| parts.first(rod)).collect();
        let is_held = |part: usize| group.iter().any(|&rod| part_of[body[rod]] == part && held[body[rod]]);
        let mut done = vec![part_of[body[root]]];
        for part in point.bodies.iter().map(|&body| part_of[body]) {
            if done.contains(&part) || is_held(part) {
                continue;
            }
            done.push(part);
            let turns = point.axis.map_or(vec![Vec3::x(), Vec3::y(), Vec3::z()], |axis| vec![axis]);
            turns.into_iter().for_each(|turn| add(&|body| part_of[body] == part, center, turn));
        }
    }
    // where pins and supports of positions hold a body
    let mut ends: BTreeMap<usize, Vec<Vec3>> = BTreeMap::new();
    let mut turns = vec![true; model.rods.len()];
    touched.iter().for_each(|rod| turns[body[*rod]] = false);
    for point in &points {
        let at = state.positions[engine.index(point.node)];
        for &body in &point.bodies {
            turns[body] &= point.axis.is_none();
            ends.entry(body).or_default().push(at);
        }
    }
    for support in model.supports.iter().filter(|support| is_here(&support.node.rod)) {
        let own = body[support.node.rod];
        turns[own] &= support.position == [true; 3] && support.rotation == [false; 3];
        ends.entry(own).or_default().push(state.positions[engine.index(support.node)]);
    }
    for (own, mut ends) in ends.into_iter().filter(|(own, _)| turns[*own]) {
        let least = super::TOLERANCE * engine.scales.length;
        let from = ends[0];
        ends.retain(|end| (end - from).norm() > least);
        let Some(to) = ends.first() else { continue };
        let turn = (to - from).normalize();
        if ends.iter().all(|end| turn.cross(&(end - from)).norm() <= least * super::TOLERANCE) {
            add(&|body| body == own, from, turn);
        }
    }
    found
}

/// The body of each rod, by the first of those that are joined rigidly; rods that touch something.
fn bodies(engine: &Engine, residual: &Residual) -> (Vec<usize>, Vec<usize>) {
    let (model, count) = (&engine.model, engine.model.rods.len());
    let mut scratch = Vec::new();
    let mut bodies = Groups::apart(count, &mut scratch);
    let rigid = model.joints.iter().filter(|joint| joint.kind == JointKind::Rigid);
    rigid.for_each(|joint| bodies.join(joint.a.rod, joint.b.rod));
    let mut touching = Vec::new();
    let side = &engine.contact;
    touching.extend(residual.contact_pairs.iter().map(|pair| {
        let [a, _, b, _] = side.nodes_of(pair).map(|node| engine.rod_of(node));
        [a, b]
    }));
    for contact in &residual.surface_contacts {
        let on = engine.rod_of(side.nodes[contact.segment][0]);
        touching.push(engine.rods_at_body(contact).unwrap_or([on; 2]));
    }
    let body = (0..count).map(|rod| bodies.first(rod)).collect();
    (body, touching.into_iter().flatten().collect())
}

fn points(engine: &Engine, state: &State, body: &[usize], is_here: impl Fn(&usize) -> bool) -> Vec<JointPoint> {
    let model = &engine.model;
    let bases = engine.bases(state);
    let mut points: Vec<JointPoint> = Vec::new();
    let mut seen: Vec<NodeRef> = Vec::new();
    for joint in model.joints.iter().filter(|joint| is_here(&joint.a.rod)) {
        if seen.contains(&joint.a) {
            continue;
        }
        let nodes = model.joined_nodes(joint.a);
        seen.extend(&nodes);
        let mut bodies: Vec<usize> = nodes.iter().map(|node| body[node.rod]).collect();
        bodies.sort_unstable();
        bodies.dedup();
        if bodies.len() > 1 {
            let hinged = model.hinged_nodes(joint.a).len() == nodes.len();
            let axis = (hinged && is_turned_by(engine, &nodes)).then(|| bases.axis(engine.index(joint.a)));
            points.push(JointPoint { node: joint.a, bodies, axis });
        }
    }
    points
}
