//! Fields along the rods at the present state: the smooth centreline with its material direction, strains and contact
//! force at the nodes, twist.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::math::shape_functions::{ShapeTable, lagrange};
use crate::math::{Quat, Vec3};
use crate::rod::element::{ElementNodes, Strain, raw_strains};
use crate::solve::problem::engine::Engine;

/// Fields at the nodes of one rod.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NodalFields {
    /// Curvature √(K1² + K2²) of the present shape, natural curvature included \[1/L\].
    pub curvature: Vec<f64>,
    /// Twist K3 of the present shape a length, natural twist included \[rad/L\].
    pub twist_rate: Vec<f64>,
    /// Contact force on the rod per reference length \[F/L\]; times the node's share of the length it sums to the
    /// resultant.
    pub contact_force: Vec<Vec3>,
    /// Internal force n = Σ N_i d_i \[F\], in the global axes: that of the rod beyond the node on the rod before it, so
    /// tension points towards growing s.
    pub internal_force: Vec<Vec3>,
    /// Internal moment m = Σ M_i d_i \[F·L\], in the global axes: likewise.
    pub internal_moment: Vec<Vec3>,
}

/// Sums over the elements at a node.
#[derive(Clone, Default)]
struct NodeSum {
    /// How many there are.
    elements: f64,
    /// Reference length on both sides of the node.
    length: f64,
    curvature: f64,
    twist: f64,
    force: Vec3,
    moment: Vec3,
}

impl Engine {
    /// Elements of a rod, as indices into all elements.
    pub(crate) fn elements_of(&self, rod: usize) -> Range<usize> {
        let count = |r: usize| self.model.rods[r].num_elements;
        let first = (0..rod).map(count).sum();
        first..first + count(rod)
    }

    /// Points of the centreline \[L\] and the material direction d1 there, `per_segment` (at least 1) to each segment
    /// between neighbouring nodes.
    ///
    /// The points lie on the cubic Hermite curve of contact; d1 is that of the interpolated frame. Open rods end with
    /// their last node; of closed rods the last point is the one before the first, whose frame is met again turned by
    /// the seam angle.
    ///
    /// # Panics
    /// If there is no such rod.
    pub fn centerline(&self, rod: usize, per_segment: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        let per_segment = per_segment.max(1);
        let (order, closed) = (self.model.rods[rod].order, self.model.rods[rod].closed);
        let tangents = self.tangents_of(&self.state);
        let (mut points, mut directions) = (Vec::new(), Vec::new());
        for index in self.elements_of(rod) {
            let element = &self.elements[index];
            let nodes = self.element_nodes(&self.state, element);
            let mut add = |segment: usize, u: f64| {
                let ends = [element.nodes[segment], element.nodes[segment + 1]];
                let (cubic, _) = tangents.cubic(&self.state, ends);
                let (n, _) = lagrange(order, (segment as f64 + u) / order as f64);
                points.push(cubic.point(u));
                directions.push(interpolated_frame(&nodes, &n, order) * Vec3::x());
            };
            for segment in 0..order {
                (0..per_segment).for_each(|k| add(segment, k as f64 / per_segment as f64));
            }
            if !closed && index + 1 == self.elements_of(rod).end {
                add(order - 1, 1.0);
            }
        }
        (points, directions)
    }

    /// Twist of a rod in turns, by the elements' own quadrature (accurate to order 2p in the element size): of d1 about
    /// the centreline, Tw = (1/2π)∫ K3 + (Γ1 K1 + Γ2 K2)/Γ3 ds, and the part of (1/2π)∫K3 ds beyond the natural one,
    /// which costs energy.
    ///
    /// K3 counts turns about d3. Seen from the tangent, which shear tilts against d3 by the angles Γ1/Γ3 and Γ2/Γ3,
    /// there are more by the area between the tangent's and d3's paths on the unit sphere (Fuller 1978); given here to
    /// first order in the shear, so Tw is off by about the square of the shear angles.
    ///
    /// # Panics
    /// If there is no such rod.
    pub fn twist(&self, rod: usize) -> (f64, f64) {
        let weights = self.table(rod).rule.weights;
        let turns = self.element_length(rod) / TAU;
        let (mut twist, mut excess) = (0.0, 0.0);
        for e in self.elements_of(rod) {
            let natural = self.reference[rod].of(e);
            for (g, [v1, v2, v3, k1, k2, k3]) in self.raw_strain_of(e).into_iter().take(weights.len()).enumerate() {
                twist += weights[g] * (k3 + (v1 * k1 + v2 * k2) / v3);
                excess += weights[g] * (k3 - natural[g][5]);
            }
        }
        (twist * turns, excess * turns)
    }

    /// Fields at the nodes of a rod. Contact must be up to date, as it is in every state that a solver hands out.
    ///
    /// Strains are extrapolated from the integration points (a polynomial through them) and averaged between elements.
    ///
    /// # Panics
    /// If there is no such rod.
    pub fn nodal_fields(&self, rod: usize) -> NodalFields {
        self.fields_of(rod, &self.residual(&self.state).contact_gradient)
    }

    /// [`Engine::nodal_fields`] of every rod for the price of one look at the contacts.
    pub fn all_nodal_fields(&self) -> Vec<NodalFields> {
        let gradient = self.residual(&self.state).contact_gradient;
        (0..self.model.rods.len()).map(|rod| self.fields_of(rod, &gradient)).collect()
    }

    fn fields_of(&self, rod: usize, contact_gradient: &[f64]) -> NodalFields {
        let (order, count) = (self.model.rods[rod].order, self.model.rods[rod].num_nodes());
        let (first, spacing) = (self.first_node[rod], self.element_length(rod) / order as f64);
        let extrapolation = extrapolation(self.table(rod));
        let mut sums = vec![NodeSum::default(); count];
        for e in self.elements_of(rod) {
            let strains = self.raw_strain_of(e);
            let resultants = self.resultants_of(e);
            for a in 0..=order {
                let kappa: [f64; 3] =
                    std::array::from_fn(|k| (0..order).map(|g| extrapolation[a][g] * strains[g][3 + k]).sum());
                let resultant =
                    |which: usize| (0..order).map(|g| extrapolation[a][g] * resultants[g][which]).sum::<Vec3>();
                let share = if a == 0 || a == order { 0.5 } else { 1.0 };
                let sum = &mut sums[self.elements[e].nodes[a] - first];
                sum.elements += 1.0;
                sum.length += share * spacing;
                sum.curvature += kappa[0].hypot(kappa[1]);
                sum.twist += kappa[2];
                sum.force += resultant(0);
                sum.moment += resultant(1);
            }
        }
        let contact_force =
            |node: usize| -Vec3::from_row_slice(&contact_gradient[6 * (first + node)..][..3]) / sums[node].length;
        NodalFields {
            curvature: sums.iter().map(|s| s.curvature / s.elements).collect(),
            twist_rate: sums.iter().map(|s| s.twist / s.elements).collect(),
            contact_force: (0..count).map(contact_force).collect(),
            internal_force: sums.iter().map(|s| s.force / s.elements).collect(),
            internal_moment: sums.iter().map(|s| s.moment / s.elements).collect(),
        }
    }

    /// Force and moment at the integration points of an element, in the global axes.
    fn resultants_of(&self, e: usize) -> [[Vec3; 2]; 3] {
        let element = &self.elements[e];
        let (table, nodes) = (self.table(element.rod), self.element_nodes(&self.state, element));
        let (strain, material) = (self.element_strain(e, &self.state), self.body(e).material);
        let mut out = [[Vec3::zeros(); 2]; 3];
        for g in 0..table.order {
            let stress = material.stress(g, &strain[g]);
            let frame = interpolated_frame(&nodes, &table.n[g], table.order);
            out[g] = [0, 3].map(|k| frame * Vec3::new(stress[k], stress[k + 1], stress[k + 2]));
        }
        out
    }

    /// Strains (Γ + e3, K) at the integration points, reference not subtracted.
    fn raw_strain_of(&self, e: usize) -> [Strain; 3] {
        let element = &self.elements[e];
        raw_strains(
            self.table(element.rod),
            &self.element_nodes(&self.state, element),
            self.element_length(element.rod),
        )
    }
}

/// The frame at a place of an element where its shape functions are `n`.
fn interpolated_frame(nodes: &ElementNodes, n: &[f64; 4], order: usize) -> Quat {
    let q: [f64; 4] = std::array::from_fn(|k| (0..=order).map(|a| n[a] * nodes.q[a][k]).sum());
    Quat::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]))
}

/// Value at node a of the polynomial that is 1 at integration point g and 0 at the others: `[a][g]`.
fn extrapolation(table: &ShapeTable) -> [[f64; 3]; 4] {
    let (order, points) = (table.order, table.rule.points);
    let mut out = [[0.0; 3]; 4];
    for a in 0..=order {
        let xi = a as f64 / order as f64;
        for g in 0..order {
            let others = (0..order).filter(|&h| h != g);
            out[a][g] = others.map(|h| (xi - points[h]) / (points[g] - points[h])).product();
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::Model;

    fn helix(order: usize) -> Engine {
        let shape = Shape::Helix { center: Vec3::zeros(), axis: Vec3::z(), radius: 1.0, pitch: TAU, turns: 1.0 };
        let section = Section::isotropic(1.0, 1.0, 1.0, 1.0, 0.0);
        let rod = Rod::new("helix", &shape, RodMesh::open(24, order), section, Natural::Straight).unwrap();
        Engine::new(Model { rods: vec![rod], ..Model::default() }, None).unwrap()
    }

    /// A helix of radius 1 and pitch 2π has curvature ½ and, with twist-free frames, no K3.
    #[test]
    fn fields_of_a_helix() {
        for (order, tol) in [(1, 1e-2), (2, 1e-2), (3, 1e-3)] {
            let fields = helix(order).nodal_fields(0);
            assert_eq!(fields.curvature.len(), 24 * order + 1);
            assert!(fields.curvature.iter().all(|k| (k - 0.5).abs() < tol), "{order}: {:?}", fields.curvature);
            assert!(fields.twist_rate.iter().all(|k| k.abs() < tol), "{order}: {:?}", fields.twist_rate);
            assert!(fields.contact_force.iter().all(|f| *f == Vec3::zeros()));
        }
    }

    /// A rod bent into an arc of radius r bears the moment EI/r and no force.
    #[test]
    fn resultants_of_an_arc_bent_by_moments() {
        let shape =
            Shape::Arc { start: Vec3::zeros(), tangent: Vec3::x(), towards: Vec3::y(), radius: 2.0, angle: 1.0 };
        let section = Section::isotropic(3.0, 1.0, 50.0, 50.0, 0.0);
        let rod = Rod::new("arc", &shape, RodMesh::open(8, 3), section, Natural::Straight).unwrap();
        let engine = Engine::new(Model { rods: vec![rod], ..Model::default() }, None).unwrap();
        let fields = engine.nodal_fields(0);
        for (force, moment) in fields.internal_force.iter().zip(&fields.internal_moment) {
            // EI/r about the axis of bending, from x towards y; nothing else
            assert!(force.norm() < 1e-4 && (moment - 1.5 * Vec3::z()).norm() < 1e-4, "{force:?} {moment:?}");
        }
    }

    #[test]
    fn the_centreline_passes_the_nodes_and_stays_on_the_curve() {
        let engine = helix(3);
        let (points, directions) = engine.centerline(0, 4);
        assert_eq!((points.len(), directions.len()), (72 * 4 + 1, 72 * 4 + 1));
        for (node, position) in engine.positions(0).iter().enumerate() {
            assert!((points[4 * node] - position).norm() < 1e-15);
            assert!((directions[4 * node] - engine.frames(0)[node] * Vec3::x()).norm() < 1e-14);
        }
        let off = |p: &Vec3| (p.x.hypot(p.y) - 1.0).abs();
        assert!(points.iter().map(off).fold(0.0, f64::max) < 1e-5);
    }
}
