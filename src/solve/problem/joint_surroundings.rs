//! Where rods that are joined overlap for good: contact is left out between their segments near the joint.
//!
//! Strands that leave a joint at an angle α are s sin α apart at arc s, so they overlap up to (ε_a + ε_b)/sin α, and no bending
//! of theirs, only their angle, tells how far. A joint is rigid: what is within that distance at the start stays there.
//! From [`CLEAR`] times the sum of the radii on they can touch only by bending, and contact acts.

use crate::math::Vec3;
use crate::scene::{Model, NodeRef};

/// Distance of two strands over the sum of their contact radii from which contact acts, because at 1 they would touch where it
/// begins.
const CLEAR: f64 = 1.5;

/// A rod from a node on, one way.
struct Arm {
    /// Segments, of all.
    segments: Vec<usize>,
    /// Positions of the nodes between, the joint's first \[L\].
    points: Vec<Vec3>,
}

/// Pairs i < j of segments of rods that take part in contact, near a joint of these. Segments are numbered rod by rod, in the
/// order of `touching`.
pub(super) fn joint_surroundings(model: &Model, touching: &[usize]) -> Vec<[u32; 2]> {
    let mut pairs = Vec::new();
    for joint in &model.joints {
        let nodes = model.joined_nodes(joint.a);
        for (k, a) in nodes.iter().enumerate() {
            for b in &nodes[k + 1..] {
                add_between(model, touching, [*a, *b], &mut pairs);
            }
        }
    }
    pairs
}

fn add_between(model: &Model, touching: &[usize], ends: [NodeRef; 2], pairs: &mut Vec<[u32; 2]>) {
    let [a, b] = ends.map(|end| arms(model, touching, end));
    let reach = CLEAR * ends.iter().map(|end| model.rods[end.rod].section.contact_radius).sum::<f64>();
    for one in &a {
        for other in &b {
            let [near, near_other] = [one.within(other, reach), other.within(one, reach)];
            for &i in &one.segments[..near] {
                pairs.extend(other.segments[..near_other].iter().map(|&j| [i.min(j) as u32, i.max(j) as u32]));
            }
        }
    }
}

/// Both ways along a rod from a node, half of a closed one each; none of a rod that takes no part in contact.
fn arms(model: &Model, touching: &[usize], at: NodeRef) -> Vec<Arm> {
    let Some(place) = touching.iter().position(|rod| *rod == at.rod) else { return Vec::new() };
    let first: usize = touching[..place].iter().map(|&rod| model.rods[rod].num_segments()).sum();
    let rod = &model.rods[at.rod];
    let (nodes, count) = (rod.num_nodes(), rod.num_segments());
    let (ahead, back) = if rod.closed { (count / 2, count / 2) } else { (count - at.node, at.node) };
    let point = |node: usize| rod.positions[node % nodes];
    let forward = Arm {
        segments: (0..ahead).map(|k| first + (at.node + k) % count).collect(),
        points: (0..=ahead).map(|k| point(at.node + k)).collect(),
    };
    let backward = Arm {
        segments: (0..back).map(|k| first + (at.node + count - 1 - k) % count).collect(),
        points: (0..=back).map(|k| point(at.node + nodes - k)).collect(),
    };
    vec![forward, backward]
}

impl Arm {
    /// Number of segments up to the first node that is farther than `reach` from another arm.
    fn within(&self, other: &Self, reach: f64) -> usize {
        let is_clear = |point: &Vec3| other.points.windows(2).all(|ends| distance(point, ends) >= reach);
        self.points.iter().skip(1).position(is_clear).map_or(self.segments.len(), |k| k + 1)
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
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::Joint;

    /// Two rods that cross at right angles in their middle nodes, .1 apart; contact radii .02: arms are clear at .06.
    #[test]
    fn a_cross_leaves_out_its_middle() {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.02);
        let rod = |name: &str, direction: Vec3| {
            let shape = Shape::Line { start: -direction * 0.4, direction, length: 0.8 };
            Rod::new(name, &shape, RodMesh::open(8, 1), section, Natural::Straight).unwrap()
        };
        let joint = Joint { a: NodeRef { rod: 0, node: 4 }, b: NodeRef { rod: 1, node: 4 } };
        let rods = vec![rod("a", Vec3::x()), rod("b", Vec3::y())];
        let model = Model { rods, joints: vec![joint], ..Model::default() };
        let mut pairs = joint_surroundings(&model, &[0, 1]);
        pairs.sort_unstable();
        assert_eq!(pairs, [[3, 11], [3, 12], [4, 11], [4, 12]]);
        assert!(joint_surroundings(&model, &[0]).is_empty());
    }
}
