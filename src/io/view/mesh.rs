//! Tubes as triangles.

use crate::io::picture::span::{Node, Span};
use crate::math::Vec3;
use crate::math::direction::any_normal;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Largest turning of the tangent (rad) between two rings; with smooth normals only the outline shows the rings.
const TURNING: f64 = 0.15;
/// Largest turn of the stripe (rad) between two rings.
const TWISTING: f64 = 0.4;
/// Most rings between two nodes.
const MAX_RINGS: f64 = 16.0;
/// Half the angle of the stripe, rad, as in pictures.
const STRIPE: f64 = 0.3;
/// Rings of the round cap of an open end.
const CAP_RINGS: usize = 4;

/// Vertices of a tube, and the triangles between them.
#[derive(Default)]
pub(super) struct Mesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// Linear light.
    pub colors: Vec<Vec3>,
    pub indices: Vec<u32>,
}

/// Style of a tube.
pub(super) struct MeshStyle {
    pub closed: bool,
    pub seam_turns: f64,
    /// Sides of the cross-section in addition to the stripe.
    pub sides: usize,
    /// Colour of the stripe, linear light.
    pub stripe: Vec3,
}

/// Vertices of a ring: two of the stripe, and one more than there are sides.
pub(super) fn per_ring(sides: usize) -> usize {
    2 + sides + 1
}

/// Cross-sections along a tube through the nodes, ends of open tubes not rounded.
fn sections(nodes: &[Node], look: &MeshStyle) -> Vec<Node> {
    let count = if look.closed { nodes.len() } else { nodes.len().saturating_sub(1) };
    let mut all: Vec<Node> = nodes.first().copied().into_iter().collect();
    for i in 0..count {
        let seam = if i + 1 == nodes.len() { look.seam_turns } else { 0.0 };
        let span = Span::new(nodes[i], nodes[(i + 1) % nodes.len()], seam);
        let rings = (span.turning / TURNING).max(span.twist.abs() / TWISTING).clamp(1.0, MAX_RINGS).ceil();
        all.extend((1..=rings as usize).map(|k| span.at(k as f64 / rings)));
    }
    all
}

/// The tube through the nodes; fewer than two make none.
pub(super) fn tube(nodes: &[Node], look: &MeshStyle) -> Mesh {
    tube_of(&sections(nodes, look), look)
}

fn tube_of(sections: &[Node], look: &MeshStyle) -> Mesh {
    let mut mesh = Mesh::default();
    let (Some(first), Some(last), 2..) = (sections.first(), sections.last(), sections.len()) else { return mesh };
    // angle of a ring of a cap from the cross-section, rad
    let tilt = |k: usize| FRAC_PI_2 * k as f64 / CAP_RINGS as f64;
    if !look.closed {
        (1..=CAP_RINGS).rev().for_each(|k| mesh.ring(first, look, -tilt(k)));
    }
    sections.iter().for_each(|section| mesh.ring(section, look, 0.0));
    if !look.closed {
        (1..=CAP_RINGS).for_each(|k| mesh.ring(last, look, tilt(k)));
    }
    mesh.join(look.sides);
    mesh
}

/// The tube through the nodes as a closed surface: triangles with area, counter-clockwise seen from outside. Each edge
/// belongs to two of them.
pub(super) fn solid(nodes: &[Node], look: &MeshStyle) -> Vec<[Vec3; 3]> {
    let sections = sections(nodes, look);
    let mesh = tube_of(&if look.closed { meeting(sections) } else { sections }, look);
    let (per_ring, count) = (per_ring(look.sides), mesh.positions.len());
    // vertices that stand for one point: beside the stripe, and all of a pole
    let point_of = |vertex: u32| {
        let (ring, place) = (vertex as usize / per_ring, vertex as usize % per_ring);
        let is_pole = !look.closed && (ring == 0 || (ring + 1) * per_ring == count);
        ring * per_ring
            + match place {
                _ if is_pole || place + 1 == per_ring => 0,
                2 => 1,
                _ => place,
            }
    };
    let corners = mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(point_of));
    let has_area = |[a, b, c]: &[usize; 3]| a != b && b != c && c != a;
    corners.filter(has_area).map(|triangle| triangle.map(|vertex| mesh.positions[vertex])).collect()
}

/// Sections of a closed tube whose last ring is the first one: the angle by which the stripe misses itself is spread
/// evenly along the tube.
fn meeting(mut sections: Vec<Node>) -> Vec<Node> {
    let (Some(first), Some(last)) = (sections.first().copied(), sections.last().copied()) else { return sections };
    let missed = first.tangent.dot(&last.stripe.cross(&first.stripe)).atan2(last.stripe.dot(&first.stripe));
    let count = sections.len() - 1;
    for (k, section) in sections.iter_mut().enumerate() {
        let angle = missed * k as f64 / count as f64;
        let across = section.tangent.cross(&section.stripe);
        section.stripe = section.stripe * angle.cos() + across * angle.sin();
    }
    sections[count] = first;
    sections
}

impl Mesh {
    /// Adds a ring of a sphere about the section, `tilt` (rad) from its equator.
    fn ring(&mut self, section: &Node, look: &MeshStyle, tilt: f64) {
        let (sin, cos) = tilt.sin_cos();
        // without a direction (unknown, or d1 along the tangent) there is no stripe, and any direction serves
        let direction = section.stripe.try_normalize(0.5);
        let stripe = if direction.is_some() { look.stripe } else { section.color };
        let e1 = direction.unwrap_or_else(|| any_normal(section.tangent));
        let e2 = section.tangent.cross(&e1);
        let mut vertex = |angle: f64, color: Vec3| {
            let normal = (e1 * angle.cos() + e2 * angle.sin()) * cos + section.tangent * sin;
            self.positions.push(section.point + normal * section.radius);
            self.normals.push(normal);
            self.colors.push(color);
        };
        vertex(-STRIPE, stripe);
        vertex(STRIPE, stripe);
        for k in 0..=look.sides {
            vertex(STRIPE + (TAU - 2.0 * STRIPE) * k as f64 / look.sides as f64, section.color);
        }
    }

    /// Triangles between all neighbouring rings, counter-clockwise seen from outside.
    fn join(&mut self, sides: usize) {
        let per_ring = per_ring(sides);
        let columns = || std::iter::once(0).chain(2..2 + sides);
        for ring in 1..self.positions.len() / per_ring {
            for column in columns() {
                let [a, b] = [(ring - 1) * per_ring + column, ring * per_ring + column].map(|i| i as u32);
                self.indices.extend([a, a + 1, b, b, a + 1, b + 1]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::picture::span::tangents;

    fn nodes(points: &[Vec3], closed: bool) -> Vec<Node> {
        let node = |(&point, tangent)| Node { point, tangent, radius: 0.1, color: Vec3::x(), stripe: Vec3::z() };
        points.iter().zip(tangents(points, closed)).map(node).collect()
    }

    /// Volume enclosed by the triangles: positive only if all face outwards.
    fn volume(mesh: &Mesh) -> f64 {
        let p = |i: u32| mesh.positions[i as usize];
        mesh.indices.chunks_exact(3).map(|t| p(t[0]).dot(&p(t[1]).cross(&p(t[2]))) / 6.0).sum()
    }

    #[test]
    fn tubes_enclose_the_volume_of_tori_and_capsules() {
        let look = |closed| MeshStyle { closed, seam_turns: 0.0, sides: 40, stripe: Vec3::y() };
        let circle: Vec<Vec3> =
            (0..64).map(|i| TAU * i as f64 / 64.0).map(|t| Vec3::new(t.cos(), t.sin(), 0.0)).collect();
        let torus = tube(&nodes(&circle, true), &look(true));
        let exact = 2.0 * std::f64::consts::PI.powi(2) * 0.01;
        assert!((volume(&torus) / exact - 1.0).abs() < 0.02, "{} {exact}", volume(&torus));
        let line = [Vec3::zeros(), Vec3::x(), 2.0 * Vec3::x()];
        let capsule = tube(&nodes(&line, false), &look(false));
        let exact = std::f64::consts::PI * (0.01 * 2.0 + 4.0 / 3.0 * 0.001);
        assert!((volume(&capsule) / exact - 1.0).abs() < 0.03, "{} {exact}", volume(&capsule));
        let mut nodes = nodes(&line, false);
        nodes.iter_mut().enumerate().for_each(|(k, node)| node.radius = 0.1 + 0.05 * k as f64);
        let cone = tube(&nodes, &look(false));
        let exact = std::f64::consts::PI * (2.0 * (0.01 + 0.02 + 0.04) / 3.0 + 2.0 / 3.0 * (0.001 + 0.008));
        assert!((volume(&cone) / exact - 1.0).abs() < 0.03, "{} {exact}", volume(&cone));
    }

    /// Edges of a solid are met once in either direction, so nothing leaks, whatever the seam and the ends.
    #[test]
    fn solids_are_closed() {
        let circle: Vec<Vec3> = (0..16)
            .map(|i| TAU * i as f64 / 16.0)
            .map(|t| Vec3::new(t.cos(), t.sin(), 0.1 * (2.0 * t).sin()))
            .collect();
        for (closed, seam_turns) in [(false, 0.0), (true, 0.0), (true, 1.25), (true, -0.4)] {
            let look = MeshStyle { closed, seam_turns, sides: 24, stripe: Vec3::zeros() };
            let triangles = solid(&nodes(&circle, closed), &look);
            let bits = |p: &Vec3| [p.x, p.y, p.z].map(|x| (x as f32).to_bits());
            let mut edges = std::collections::HashMap::new();
            for t in &triangles {
                for k in 0..3 {
                    let (a, b) = (bits(&t[k]), bits(&t[(k + 1) % 3]));
                    assert!(a != b, "an edge without length");
                    *edges.entry((a, b)).or_insert(0) += 1;
                }
            }
            let is_met = |&(a, b): &([u32; 3], [u32; 3])| edges.get(&(b, a)) == Some(&1);
            assert!(edges.iter().all(|(edge, count)| *count == 1 && is_met(edge)), "{closed} {seam_turns}");
            let volume: f64 = triangles.iter().map(|t| t[0].dot(&t[1].cross(&t[2])) / 6.0).sum();
            assert!(volume > 0.15, "outwards: {volume}");
        }
    }

    /// A seam of 1¼ turns on a flat ring: the stripe arrives a quarter turn from where it has left.
    #[test]
    fn the_stripe_turns_into_the_seam() {
        let circle: Vec<Vec3> =
            (0..16).map(|i| TAU * i as f64 / 16.0).map(|t| Vec3::new(t.cos(), t.sin(), 0.0)).collect();
        let look = MeshStyle { closed: true, seam_turns: 1.25, sides: 6, stripe: Vec3::y() };
        let sections = sections(&nodes(&circle, true), &look);
        let (first, last) = (sections[0], sections[sections.len() - 1]);
        let turned = first.tangent.cross(&first.stripe);
        assert!((last.point - first.point).norm() < 1e-14 && (last.stripe - turned).norm() < 1e-12);
        // nowhere by more than is allowed between two rings, to which the tangent's turning adds a little
        assert!(sections.windows(2).all(|w| w[0].stripe.angle(&w[1].stripe) < 1.1 * TWISTING));
    }
}
