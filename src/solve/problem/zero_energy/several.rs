//! Motions of several rods that cost nothing: the rigid ones of each group of free rods that touch each other but
//! nothing else, and the spin of each free isotropic closed rod about its centreline, which contact without friction
//! does not feel; of groups that are held somewhere, those of these motions that their supports let pass (two linked
//! rings, one of them clamped at a node, swing about its tangent there while the clamped one spins back). Sliding of
//! closed rods along themselves is left to the mesh's ripple. What pins and hinges let turn: see
//! [`hinged`](super::hinged).

use super::hinged::part_rotations;
use super::{
    Supports, displacement_at, holds_all, is_falling, is_free, is_round, least_size, left_alone, loads_at,
    rigid_motions, spin_of, subtract, subtract_force, touched_by,
};
use crate::math::Vec3;
use crate::math::groups::Groups;
use crate::solve::measures::NOTHING;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;
use crate::solve::problem::zero_energy::TOLERANCE;

/// Six numbers for each node of some rods, rod by rod; with the rod.
type NodalMotions = Vec<(usize, Vec<f64>)>;

/// The motions at one state.
#[derive(Debug, Default)]
pub(super) struct Several {
    /// Orthonormal in the product with these weights of displacements and rotations.
    motions: Vec<NodalMotions>,
    weights: [f64; 2],
    first_node: Vec<usize>,
    /// One rod of each group that moves freely.
    pub(super) anchors: Vec<usize>,
    /// Motions that each group's supports and loads permit, with their nodes.
    pub(super) held: Vec<(Vec<usize>, Vec<Vec<f64>>)>,
    /// Rods of groups whose free rods bear loads.
    pub(super) falling: Vec<usize>,
}

impl Several {
    /// Of a model where strands touch as in a residual.
    pub(super) fn of(engine: &Engine, state: &State, residual: &Residual, weights: [f64; 2]) -> Self {
        let mut several = Self { weights, first_node: engine.first_node.clone(), ..Self::default() };
        for group in groups(engine, residual) {
            let start = several.motions.len();
            // loads do work on some of the motions of such a group, which are then left to them
            let falls = group.iter().any(|&rod| is_falling(engine, rod));
            let floats = |rod: usize| !falls && is_free(engine, rod);
            // an open rod alone spins as it turns
            let rolls = |rod: usize| {
                let own = engine.model.rods[rod].closed || group.len() > 1 || !floats(rod);
                own && is_round(engine, rod) && !holds_all(engine, rod)
            };
            for &rod in group.iter().filter(|rod| floats(**rod) && rolls(**rod)) {
                several.add(start, vec![(rod, spin_of(engine, state, rod, engine.nodes(rod)))], 0.0);
            }
            if falls {
                several.falling.extend(&group);
            }
            let is_held = group.iter().any(|&rod| holds_all(engine, rod));
            let nodes: Vec<usize> = group.iter().flat_map(|rod| engine.nodes(*rod)).collect();
            let touched = touched_by(engine, residual, &group);
            let rigid = if is_held { Vec::new() } else { rigid_motions(engine, state, &nodes, &touched) };
            if group.iter().all(|rod| floats(*rod)) {
                if touched.is_empty() {
                    several.anchors.push(group[0]);
                }
                rigid.iter().for_each(|motion| several.add(start, by_rods(engine, &group, motion), 0.0));
                continue;
            }
            // spins of the rods that are held may make up for what supports hold
            let held = group.iter().filter(|rod| !floats(**rod) && rolls(**rod));
            let spins = held.map(|&rod| spin_of(engine, state, rod, nodes.iter().copied()));
            let mut motions: Vec<Vec<f64>> = rigid.into_iter().chain(spins).collect();
            let parts = part_rotations(engine, (state, residual), &group, &nodes);
            if motions.is_empty() && parts.is_empty() {
                continue;
            }
            let supports = Supports::of(engine, state, &nodes);
            supports.size(&mut motions);
            let least = least_size(weights, motions.iter().chain(parts.iter().map(|part| &part.motion)));
            let passing = left_alone(engine, state, &nodes, (supports.all_that_pass(&motions), parts));
            let before = several.motions.len();
            passing.iter().for_each(|motion| several.add(start, by_rods(engine, &group, motion), least));
            // what is left of a motion beside a spin may be so small that loads do work on it
            let loads = if state.load_factor == 0.0 { Vec::new() } else { loads_at(engine, &nodes) };
            let mut added: Vec<Vec<f64>> = Vec::new();
            for motion in several.motions.split_off(before) {
                let whole: Vec<f64> = motion.iter().flat_map(|(_, values)| values).copied().collect();
                if !does_work(&loads, &whole) {
                    added.push(whole);
                    several.motions.push(motion);
                }
            }
            if !added.is_empty() {
                several.held.push((nodes, added));
            }
        }
        several
    }

    /// All motions, with this many numbers.
    pub(super) fn all(&self, len: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
        self.motions.iter().map(move |motion| {
            let mut whole = vec![0.0; len];
            motion.iter().for_each(|(rod, values)| whole[self.range(*rod)].copy_from_slice(values));
            whole
        })
    }

    /// Takes the neutral part out of an increment.
    pub(super) fn remove(&self, step: &mut [f64]) {
        for motion in &self.motions {
            let part: f64 = motion.iter().map(|(rod, values)| self.dot(&step[self.range(*rod)], values)).sum();
            motion.iter().for_each(|(rod, values)| subtract(&mut step[self.range(*rod)], values, part));
        }
    }

    /// Takes out of a gradient what these forces do work on the motions.
    pub(super) fn remove_forces(&self, forces: &[f64], gradient: &mut [f64]) {
        for motion in &self.motions {
            let of_rod = |(rod, values): &(usize, Vec<f64>)| -> f64 {
                forces[self.range(*rod)].iter().zip(values).map(|(g, v)| g * v).sum()
            };
            let work: f64 = motion.iter().map(of_rod).sum();
            for (rod, values) in motion {
                subtract_force(&mut gradient[self.range(*rod)], values, work, self.weights);
            }
        }
    }

    fn range(&self, rod: usize) -> std::ops::Range<usize> {
        6 * self.first_node[rod]..6 * self.first_node[rod + 1]
    }

    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        super::weighted(self.weights, a, b)
    }

    /// Orthonormalises a motion against those from `start` on, which its rods may share, and adds it if it is no
    /// combination of them, nor smaller than `least`.
    fn add(&mut self, start: usize, mut motion: NodalMotions, least: f64) {
        let size = |motion: &NodalMotions, several: &Self| {
            motion.iter().map(|(_, values)| several.dot(values, values)).sum::<f64>().sqrt()
        };
        let before = size(&motion, self);
        // twice is enough
        for _ in 0..2 {
            for earlier in &self.motions[start..] {
                let place = |rod: usize| motion.binary_search_by_key(&rod, |piece| piece.0).ok();
                let shared: Vec<(usize, &[f64])> =
                    earlier.iter().filter_map(|(rod, values)| Some((place(*rod)?, &values[..]))).collect();
                let part: f64 = shared.iter().map(|(at, values)| self.dot(&motion[*at].1, values)).sum();
                shared.into_iter().for_each(|(at, values)| subtract(&mut motion[at].1, values, part));
            }
        }
        let norm = size(&motion, self);
        if norm <= least.max(TOLERANCE * before) {
            return;
        }
        motion.iter_mut().flat_map(|(_, values)| values).for_each(|x| *x /= norm);
        self.motions.push(motion);
    }
}

/// Whether forces, each with the place of its node, do work on a motion of unit size.
fn does_work(loads: &[(usize, Vec3, Vec3)], motion: &[f64]) -> bool {
    let work: f64 = loads.iter().map(|(place, force, _)| force.dot(&displacement_at(motion, *place))).sum();
    work.abs() > NOTHING * loads.iter().map(|(_, force, _)| force.norm()).sum::<f64>()
}

/// A motion of the nodes of some rods, rod by rod.
fn by_rods(engine: &Engine, rods: &[usize], motion: &[f64]) -> NodalMotions {
    let mut rest = motion;
    let piece = |&rod: &usize| {
        let (own, others) = rest.split_at(6 * engine.nodes(rod).len());
        rest = others;
        (rod, own.to_vec())
    };
    rods.iter().map(piece).collect()
}

/// Rods that touch each other, or bodies that they carry, or are joined, directly or by others; each group and the
/// groups in the order of their first rods.
fn groups(engine: &Engine, residual: &Residual) -> Vec<Vec<usize>> {
    let mut scratch = Vec::new();
    let mut touching = Groups::apart(engine.model.rods.len(), &mut scratch);
    engine.model.joints.iter().for_each(|joint| touching.join(joint.a.rod, joint.b.rod));
    let side = &engine.contact;
    for pair in &residual.contact_pairs {
        let [a, _, b, _] = side.nodes_of(pair).map(|node| engine.rod_of(node));
        touching.join(a, b);
    }
    let at_bodies = residual.surface_contacts.iter().filter_map(|contact| engine.rods_at_body(contact));
    at_bodies.for_each(|[a, b]| touching.join(a, b));
    let mut groups: Vec<Vec<usize>> = vec![Vec::new(); engine.model.rods.len()];
    (0..groups.len()).for_each(|rod| groups[touching.first(rod)].push(rod));
    groups.retain(|group| !group.is_empty());
    groups
}
