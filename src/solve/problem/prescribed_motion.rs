//! Prescribed motions: of supports and seams, in one load step and so far; lifted from supports to rods.

use std::collections::BTreeMap;

use crate::math::Vec3;
use crate::scene::ObstacleNumber;
use crate::solve::measures::NOTHING;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::{Numbers, PrescribedValue, State};

/// Prescribed changes for one load step: motions of supports are applied through the tangent of the first Newton steps,
/// so that the rods take them up everywhere at once; turns of seams are spread evenly along the rod beforehand.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PrescribedMotion {
    /// (node, displacement \[L\], rotation vector \[rad\]) of supported nodes.
    pub nodes: Vec<(usize, Vec3, Vec3)>,
    /// Per rod: change of the seam angle, rad; empty if none changes.
    pub seams: Vec<f64>,
}

/// Where one load step leads.
#[derive(Debug, Clone, Default)]
pub(crate) struct Target {
    pub(crate) drive: PrescribedMotion,
    pub(crate) load_factor: Option<f64>,
    /// By rod \[F/L\].
    pub(crate) pressures: Vec<(usize, f64)>,
    /// Numbers of obstacles.
    pub(crate) placements: Vec<(usize, ObstacleNumber, f64)>,
    /// Numbers of rods.
    pub(crate) numbers: Numbers,
    /// Turns that supports make, by node.
    pub(crate) turned: Vec<(usize, f64)>,
    /// Displacements that supports make, by node \[L\].
    pub(crate) displaced: Vec<(usize, Vec3)>,
    /// Motions of nodes towards poses: velocity \[L\] and rotation vector, rad, see `RemainingPath::controls`.
    pub(crate) posed: Vec<(usize, [Vec3; 2])>,
}

impl Target {
    /// Adds a motion of a node: a displacement \[L\], a rotation vector, rad, and the turns that these count as.
    pub(crate) fn rotate(&mut self, node: usize, turns: f64, displacement: Vec3, vector: Vec3) {
        self.drive.nodes.push((node, displacement, vector));
        self.turned.push((node, turns));
    }

    /// Loads, pressures, numbers of obstacles and rods.
    pub(crate) fn values(&self) -> impl Iterator<Item = PrescribedValue> {
        let load = self.load_factor.map(PrescribedValue::Load).into_iter();
        let pressures = self.pressures.iter().map(|&(rod, to)| PrescribedValue::Pressure(rod, to));
        let placements =
            self.placements.iter().map(|&(which, number, to)| PrescribedValue::Obstacle(which, number, to));
        let numbers = self.numbers.iter().map(|(&(rod, which), &to)| PrescribedValue::Number(rod, which, to));
        load.chain(pressures).chain(placements).chain(numbers)
    }
}

/// Motions of supports so far, by node.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Moved {
    /// Turns.
    pub(crate) turned: BTreeMap<usize, f64>,
    /// Displacements \[L\].
    pub(crate) displaced: BTreeMap<usize, Vec3>,
    /// Angles by which rods were spun about their own tangents, rad.
    pub(crate) spun: BTreeMap<usize, f64>,
    /// Sums of the constant rates of each path to a pose: velocity \[L\] and rotation vector, rad.
    pub(crate) posed: BTreeMap<usize, [Vec3; 2]>,
}

impl Moved {
    /// After a step to a target on which these nodes were spun.
    pub(crate) fn go_on(&mut self, target: &Target, spun: &[(usize, f64)]) {
        for &(node, turns) in &target.turned {
            *self.turned.entry(node).or_insert(0.0) += turns;
        }
        for &(node, by) in &target.displaced {
            *self.displaced.entry(node).or_default() += by;
        }
        for &(node, by) in &target.posed {
            let sums = self.posed.entry(node).or_default();
            sums.iter_mut().zip(by).for_each(|(sum, by)| *sum += by);
        }
        for &(node, angle) in spun {
            *self.spun.entry(node).or_insert(0.0) += angle;
        }
    }

    /// The same of nodes that are called by other numbers.
    pub(crate) fn on_nodes(&self, number: impl Fn(usize) -> usize) -> Self {
        Self {
            turned: self.turned.iter().map(|(&node, &turns)| (number(node), turns)).collect(),
            displaced: self.displaced.iter().map(|(&node, &by)| (number(node), by)).collect(),
            spun: self.spun.iter().map(|(&node, &angle)| (number(node), angle)).collect(),
            posed: self.posed.iter().map(|(&node, &by)| (number(node), by)).collect(),
        }
    }

    /// All nodes that supports have moved.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = usize> {
        self.turned.keys().chain(self.displaced.keys()).chain(self.spun.keys()).chain(self.posed.keys()).copied()
    }
}

impl PrescribedMotion {
    /// The drive in equal parts in none of which a seam turns by more than `turns` turns. Supports move in the first
    /// part.
    pub(crate) fn parts(&self, turns: f64) -> Vec<Self> {
        let largest = self.seams.iter().fold(0.0f64, |a, b| a.max(b.abs())) / std::f64::consts::TAU;
        let count = (largest / turns - NOTHING).ceil().clamp(1.0, 1000.0);
        let seams: Vec<f64> = self.seams.iter().map(|angle| angle / count).collect();
        let first = Self { nodes: self.nodes.clone(), seams: seams.clone() };
        let rest = Self { nodes: Vec::new(), seams };
        std::iter::once(first).chain(std::iter::repeat_n(rest, count as usize - 1)).collect()
    }

    /// Adds the supports' motions to an increment (six per node).
    pub(crate) fn add_to(&self, increment: &mut [f64]) {
        for &(node, displacement, rotation) in &self.nodes {
            for k in 0..3 {
                increment[6 * node + k] += displacement[k];
                increment[6 * node + 3 + k] += rotation[k];
            }
        }
    }

    /// The supports' motions times a factor.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self { nodes: self.nodes.iter().map(|&(n, d, r)| (n, d * factor, r * factor)).collect(), seams: Vec::new() }
    }
}

/// A prescribed motion lifted from supports to rods.
#[derive(Debug, Clone)]
pub(crate) struct Lifted {
    pub(crate) state: State,
    /// The part that supports are still to make.
    pub(crate) drive: PrescribedMotion,
    /// Nodes that were spun about their tangents, with the angles, rad.
    pub(crate) spun: Vec<(usize, f64)>,
}

/// Turns seams, and the supports that turn a rod about its own tangent, with the rod: frames between them spin evenly.
/// Every centreline stays as it is, and contact with it, so the whole of such a drive can be taken at once.
pub(crate) fn lifted(engine: &Engine, state: &State, drive: &PrescribedMotion) -> Lifted {
    let mut state = state.clone();
    for (rod, &angle) in drive.seams.iter().enumerate() {
        twist(engine, &mut state, rod, angle);
    }
    let (mut left, mut spun) = (PrescribedMotion::default(), Vec::new());
    for &(node, displacement, rotation) in &drive.nodes {
        let tangent = state.frames[node] * Vec3::z();
        let angle = rotation.dot(&tangent);
        let about_tangent = (rotation - tangent * angle).norm() <= NOTHING * rotation.norm();
        let is_other_rods = engine.is_turning_joined(node);
        if !about_tangent || is_other_rods || engine.model.rods[engine.rod_of(node)].closed {
            left.nodes.push((node, displacement, rotation));
            continue;
        }
        if angle != 0.0 {
            spin_evenly(engine, &mut state, node, angle);
            spun.push((node, angle));
        }
        if displacement != Vec3::zeros() {
            left.nodes.push((node, displacement, Vec3::zeros()));
        }
    }
    Lifted { state, drive: left, spun }
}

/// Turns the seam of a closed rod by `angle` and spreads the twist evenly: frames spin about their own d3, the
/// centreline and with it all contact stay as they are. Exact equilibrium of an isotropic ring, a good start for
/// others.
pub(in crate::solve) fn twist(engine: &Engine, state: &mut State, rod: usize, angle: f64) {
    state.seams[rod] += angle;
    seam_shares(engine, rod).for_each(|(node, share)| state.spin_frame(node, angle * share));
}

/// Shares, by node, of a closed rod in the turn of its seam, which twists it evenly. Nodes whose rotation is held, by a
/// support or a joint, are not spun: the seam is between the last and the first of them, so that piece takes the twist.
pub(in crate::solve) fn seam_shares(engine: &Engine, rod: usize) -> impl Iterator<Item = (usize, f64)> {
    let nodes = engine.nodes(rod);
    let (first, count) = (nodes.start, nodes.len());
    let held = |n: &usize| engine.is_turning_held(*n);
    let ends = nodes.clone().find(held).zip(nodes.clone().rev().find(held)).map(|(a, b)| (a - first, b - first));
    let share = move |k: usize| match ends {
        None => k as f64 / count as f64 - 0.5,
        Some((a, b)) => (k as f64 - k.clamp(a, b) as f64) / (count - (b - a)) as f64,
    };
    (0..count).map(move |k| (first + k, share(k)))
}

/// Spins the frames of an open rod about their tangents: those of `node` by an angle, the others by shares that fall
/// evenly to zero at the next nodes on both sides whose rotation is held.
pub(in crate::solve) fn spin_evenly(engine: &Engine, state: &mut State, node: usize, angle: f64) {
    spin_shares(engine, node)
        .filter(|(_, share)| *share != 0.0)
        .for_each(|(k, share)| state.spin_frame(k, angle * share));
}

/// Shares, by node, of the rod in a spin of one of its nodes.
pub(in crate::solve) fn spin_shares(engine: &Engine, node: usize) -> impl Iterator<Item = (usize, f64)> {
    let nodes = engine.nodes(engine.rod_of(node));
    let held = |n: &usize| engine.is_turning_held(*n);
    let before = (nodes.start..node).rev().find(held);
    let after = (node + 1..nodes.end).find(held);
    let share = move |k: usize| match (k.cmp(&node), before, after) {
        (std::cmp::Ordering::Less, Some(held), _) => (k.saturating_sub(held)) as f64 / (node - held) as f64,
        (std::cmp::Ordering::Greater, _, Some(held)) => (held.saturating_sub(k)) as f64 / (held - node) as f64,
        _ => 1.0,
    };
    nodes.map(move |k| (k, share(k)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quaternion::exp;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};

    /// A turn of a clamp about the tangent is taken by the whole rod: the node is where the drive takes it, its
    /// neighbours turn by even shares, nothing is left to be pushed; a turn about another axis is left as it is.
    #[test]
    fn turns_about_tangents_are_lifted() {
        let engine = Engine::new(clamped(), None).unwrap();
        let drive = |axis: Vec3| PrescribedMotion { nodes: vec![(36, Vec3::zeros(), axis * 2.0)], seams: Vec::new() };
        let Lifted { state, drive: left, spun } = lifted(&engine, &engine.state, &drive(Vec3::x()));
        assert!(left.nodes.is_empty());
        assert_eq!(spun.len(), 1);
        for node in 0..=36 {
            let wanted = exp(&(Vec3::x() * (2.0 * node as f64 / 36.0))) * engine.state.frames[node];
            assert!(state.frames[node].angle_to(&wanted) < 1e-12, "{node}");
        }
        assert_eq!(state.positions, engine.state.positions);
        let Lifted { state, drive: left, spun } = lifted(&engine, &engine.state, &drive(Vec3::y()));
        assert_eq!((left.nodes.len(), spun.len()), (1, 0));
        assert_eq!(state, engine.state);
    }

    fn clamped() -> Model {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.02);
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let rods = vec![Rod::new("rod", &line, RodMesh::open(12, 3), section, Natural::Straight).unwrap()];
        let supports = [0, 36].map(|node| Support::clamp(NodeRef { rod: 0, node })).to_vec();
        Model { rods, supports, ..Model::default() }
    }
}
