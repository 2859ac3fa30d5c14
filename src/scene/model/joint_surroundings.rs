//! Where rods that are joined overlap: contact is left out between their segments near the joint.
//!
//! Strands that leave a joint at an angle α are s sin α apart at arc s, so they overlap up to (ε_a + ε_b)/sin α, and no
//! bending of theirs, only their angle, says how far. What is within that distance at the start is left out. From
//! [`CLEAR`] times the sum of the radii on contact acts: rods that a rigid joint holds can touch there only by bending,
//! those that turn about a pin or a hinge stop at sin α = 1/[`CLEAR`].

use super::{Model, NodeRef};
use crate::math::Vec3;
use crate::rod::Rod;

/// Distance of two strands over the sum of their contact radii from which contact acts, because at 1 they would touch
/// where it begins.
const CLEAR: f64 = 1.5;

/// A rod from a joined node on, one way.
#[derive(Debug, Clone)]
struct Arm {
    at: NodeRef,
    forward: bool,
    /// Positions of the nodes between segments, the joint's first \[L\].
    points: Vec<Vec3>,
}

/// Segments of a rod from a joined node on, one way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surrounding {
    at: NodeRef,
    forward: bool,
    count: usize,
}

impl Surrounding {
    pub(crate) fn rod(&self) -> usize {
        self.at.rod
    }

    /// Its segments, on the rod.
    pub(crate) fn segments(self, rod: &Rod) -> impl Iterator<Item = usize> {
        let (node, all) = (self.at.node, rod.num_segments());
        (0..self.count).map(move |k| if self.forward { (node + k) % all } else { (node + all - 1 - k) % all })
    }

    /// Arc lengths between which it is, which may be below 0 or above the length of a closed rod \[L\].
    pub(crate) fn arc(&self, rod: &Rod) -> [f64; 2] {
        let (at, length) = (rod.spacing() * self.at.node as f64, rod.spacing() * self.count as f64);
        if self.forward { [at, at + length] } else { [at - length, at] }
    }
}

impl Model {
    /// Pairs of pieces of rods between which contact is left out, because they overlap at joints of these.
    pub(crate) fn joint_surroundings(&self) -> Vec<[Surrounding; 2]> {
        let (mut pairs, mut done): (Vec<[Surrounding; 2]>, Vec<NodeRef>) = Default::default();
        for joint in &self.joints {
            if done.contains(&joint.a) {
                continue;
            }
            let nodes = self.joined_nodes(joint.a);
            for (k, a) in nodes.iter().enumerate() {
                nodes[k + 1..].iter().for_each(|b| self.add_between([*a, *b], &mut pairs));
            }
            done.extend(nodes);
        }
        pairs
    }

    fn add_between(&self, ends: [NodeRef; 2], pairs: &mut Vec<[Surrounding; 2]>) {
        let radii = ends.map(|end| self.rods[end.rod].section.contact_radius);
        if radii.contains(&0.0) {
            return;
        }
        let [a, b] = ends.map(|end| arms(&self.rods[end.rod], end));
        let reach = CLEAR * (radii[0] + radii[1]);
        for one in &a {
            for other in &b {
                pairs.push([one.within(other, reach), other.within(one, reach)]);
            }
        }
    }
}

/// Both ways along a rod from a node, half of a closed one each.
fn arms(rod: &Rod, at: NodeRef) -> [Arm; 2] {
    let (nodes, count) = (rod.num_nodes(), rod.num_segments());
    let (ahead, back) = if rod.closed { (count / 2, count / 2) } else { (count - at.node, at.node) };
    let point = |node: usize| rod.positions[node % nodes];
    [
        Arm { at, forward: true, points: (0..=ahead).map(|k| point(at.node + k)).collect() },
        Arm { at, forward: false, points: (0..=back).map(|k| point(at.node + nodes - k)).collect() },
    ]
}

impl Arm {
    /// The segments up to the first node that is farther than `reach` from another arm.
    fn within(&self, other: &Self, reach: f64) -> Surrounding {
        let is_clear = |point: &Vec3| other.points.windows(2).all(|ends| distance(point, ends) >= reach);
        let count = self.points.iter().skip(1).position(is_clear).map_or(self.points.len() - 1, |k| k + 1);
        Surrounding { at: self.at, forward: self.forward, count }
    }
}

/// Distance of a point from a straight segment \[L\].
fn distance(point: &Vec3, ends: &[Vec3]) -> f64 {
    let (along, from) = (ends[1] - ends[0], point - ends[0]);
    let u = (from.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (from - along * u).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, RodMesh, Section, Shape};
    use crate::scene::Joint;

    /// Two rods that cross at right angles in their middle nodes, 0.1 apart; contact radii 0.02: arms are clear at
    /// 0.06.
    #[test]
    fn a_cross_leaves_out_its_middle() {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.02);
        let rod = |name: &str, direction: Vec3| {
            let shape = Shape::Line { start: -direction * 0.4, direction, length: 0.8 };
            Rod::new(name, &shape, RodMesh::open(8, 1), section, Natural::Straight).unwrap()
        };
        let joint = Joint::rigid(NodeRef { rod: 0, node: 4 }, NodeRef { rod: 1, node: 4 });
        let rods = vec![rod("a", Vec3::x()), rod("b", Vec3::y())];
        let model = Model { rods, joints: vec![joint], ..Model::default() };
        let pairs = model.joint_surroundings();
        let mut segments: Vec<[usize; 2]> = Vec::new();
        for [a, b] in &pairs {
            let [of_a, of_b] = [a, b].map(|piece| piece.segments(&model.rods[piece.rod()]).collect::<Vec<_>>());
            segments.extend(of_a.iter().flat_map(|i| of_b.iter().map(move |j| [*i, *j])));
        }
        segments.sort_unstable();
        assert_eq!(segments, [[3, 3], [3, 4], [4, 3], [4, 4]]);
        assert_eq!(pairs[0][0].arc(&model.rods[0]), [0.4, 0.5]);
        let thin = Rod { section: Section { contact_radius: 0.0, ..section }, ..model.rods[1].clone() };
        let model = Model { rods: vec![model.rods[0].clone(), thin], ..model };
        assert!(model.joint_surroundings().is_empty());
    }
}
