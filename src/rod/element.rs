//! Energy, residual and tangent of one rod element.
//!
//! Inside an element r = Σ N_a r_a and z = Σ N_a q_a (nodal quaternions with aligned signs), frame q = z/|z|. Strains
//!
//! ```text
//! V_i = ⟨z e_i, r' z⟩ / |z|²        Γ = V − V_ref      shear (1, 2), extension (3)
//! K_i = 2 ⟨z e_i, z'⟩ / |z|²        K − K_ref          bending (1, 2), twist (3)
//! ```
//!
//! depend on the eleven numbers y = (r', z, z') as quadratic forms over |z|², which makes exact first and second
//! derivatives short: with f = P/|z|², ∇²f = (∇²P − f ∇²|z|² − ∇f⊗∇|z|² − ∇|z|²⊗∇f)/|z|². Left multiplication of all
//! q_a by one unit quaternion commutes with the interpolation, so the strains are objective. No increments are
//! interpolated, so they are path independent (cf. Crisfield & Jelenić 1999).
//!
//! Unknowns of a node are (δr, θ) with q ← exp(θ/2) q = q + ½θq − ⅛|θ|²q + …, so the Hessian in θ is TᵀHT plus the
//! diagonal −¼ (∂E/∂q · q) I.
//!
//! The stress inside the geometric part of the tangent may differ from C ε(x): mixed-integration-point Newton
//! (Magisano, Leonetti & Garcea 2017) passes the stress predicted by the previous linear solve.

use std::ops::Range;

use crate::math::shape_functions::ShapeTable;
use crate::rod::{Deformation, ElasticEnergies};
use blocks::{NodalGradient, NodeBlocks, SecondDerivative, ShapeAt, Slope};
use kinematics::{InPlane, Space, inner};
use material::MaterialLaw;

mod blocks;
mod kinematics;
mod material;

pub use kinematics::{NodeValues, RodPlane};
pub use material::{Material, stiffness};

/// Strains Γ1 Γ2 Γ3 K1 K2 K3 at an integration point: shear, shear, extension, bending, bending, twist. Γ is a number,
/// K is in 1/L.
pub type Strain = [f64; 6];

/// Stress resultants that do work on [`Strain`]: forces \[F\], then moments \[F·L\], in the material frame.
pub type Stress = [f64; 6];

/// Degrees of freedom of the largest element.
pub const MAX_DOF: usize = 24;

/// Nodal input of one element in space.
pub type ElementNodes = NodeValues<3, 4>;

/// Shape functions, length and material shared by the elements of a rod.
#[derive(Debug, Clone, Copy)]
pub struct ElementProperties<'a> {
    /// Shape functions.
    pub table: &'a ShapeTable,
    /// Reference length of an element \[L\].
    pub length: f64,
    /// The material matrix.
    pub material: Material<'a>,
    /// The plane of a rod that moves in one. Elements whose nodes are in it (positions in x and y, frames rotated about
    /// z) are computed in two dimensions, with the same results to rounding.
    pub plane: Option<&'a RodPlane>,
}

/// The interpolated numbers y = (r', z, z') at one integration point.
struct InterpolatedPoint<const R: usize, const Z: usize> {
    rp: [f64; R],
    z: [f64; Z],
    zp: [f64; Z],
    zz: f64,
}

fn interpolate<const R: usize, const Z: usize>(
    nodes: &NodeValues<R, Z>,
    n: &[f64; 4],
    d: &[f64; 4],
    num_nodes: usize,
    inv_length: f64,
) -> InterpolatedPoint<R, Z> {
    let (mut rp, mut z, mut zp) = ([0.0; R], [0.0; Z], [0.0; Z]);
    for a in 0..num_nodes {
        let slope = d[a] * inv_length;
        for k in 0..R {
            rp[k] += slope * nodes.r[a][k];
        }
        for k in 0..Z {
            z[k] += n[a] * nodes.q[a][k];
            zp[k] += slope * nodes.q[a][k];
        }
    }
    let zz = inner(&z, &z);
    InterpolatedPoint { rp, z, zp, zz }
}

/// Raw strains (V, K) at the integration points of an element of reference length `length` \[L\].
pub fn raw_strains(table: &ShapeTable, nodes: &ElementNodes, length: f64) -> [Strain; 3] {
    let mut out = [[0.0; 6]; 3];
    for g in 0..table.order {
        out[g] = Space::strain(&interpolate(nodes, &table.n[g], &table.d[g], table.order + 1, 1.0 / length));
    }
    out
}

impl ElementProperties<'_> {
    /// The shape functions at integration point `g`.
    fn shape_at(&self, g: usize) -> ShapeAt {
        let (table, length) = (self.table, self.length);
        let (n, d) = (table.n[g], table.d[g].map(|x| x / length));
        ShapeAt { n, d, weight: table.rule.weights[g] * length, num_nodes: table.order + 1 }
    }

    /// The plane, the nodes in it and the stiffnesses there, if all nodes are in it. Rods with a full material are
    /// computed in space.
    fn flat(&self, nodes: &ElementNodes) -> Option<(&RodPlane, NodeValues<2, 2>, [f64; 3])> {
        let (plane, Material::Diagonal(material)) = (self.plane?, self.material) else { return None };
        Some((plane, plane.nodes(nodes, self.table.order + 1)?, plane.material(material)))
    }
}

/// Strains P_i/|z|² of an element in space or in the plane: R components of r', Z of z, S strains.
///
/// Without these three lengths both would have those of space, and the plane would fill the first entries: cubic
/// elements then take 1.25 times as long in the plane and 1.12 times in space (residual and tangent, with five
/// lengths).
trait Kinematics<const R: usize, const Z: usize, const S: usize> {
    /// Kind of each strain.
    const KIND: [Deformation; S];
    /// The rotations among the six unknowns of a node; these begin with the R displacements.
    const ROTATIONS: Range<usize>;

    /// Strains (reference values not subtracted).
    fn strain(p: &InterpolatedPoint<R, Z>) -> [f64; S];

    /// ∇P_i.
    fn slopes(p: &InterpolatedPoint<R, Z>) -> [Slope<R, Z>; S];

    /// Σ S_i ∇²P_i.
    fn curvature(p: &InterpolatedPoint<R, Z>, stress: &[f64; S]) -> SecondDerivative<R, Z>;

    /// Derivative ½ e_k q of a node's quaternion by its k-th rotation.
    fn rotation(q: &[f64; Z], k: usize) -> [f64; Z];

    /// The derivatives by all rotations, with their places among the unknowns of the node.
    #[inline]
    fn rotations(q: &[f64; Z]) -> impl Iterator<Item = (usize, [f64; Z])> {
        Self::ROTATIONS.enumerate().map(|(k, unknown)| (unknown, Self::rotation(q, k)))
    }

    /// Linear change B δ of the strains at integration point `g` for an increment δ (displacement, rotation vector per
    /// node). Also returns raw strains and the rows of B.
    fn linear_change(
        table: &ShapeTable,
        nodes: &NodeValues<R, Z>,
        change: &NodeValues<R, Z>,
        length: f64,
        g: usize,
    ) -> ([f64; S], [f64; S], [Slope<R, Z>; S]) {
        let num_nodes = table.order + 1;
        let p = interpolate(nodes, &table.n[g], &table.d[g], num_nodes, 1.0 / length);
        let dp = interpolate(change, &table.n[g], &table.d[g], num_nodes, 1.0 / length);
        let raw = Self::strain(&p);
        let b = Self::gradients(&p, &raw);
        (raw, std::array::from_fn(|i| b[i].change(&dp)), b)
    }

    /// Linear change of nodal positions and quaternions for an increment.
    fn nodal_change(nodes: &NodeValues<R, Z>, increment: &[f64; MAX_DOF], num_nodes: usize) -> NodeValues<R, Z> {
        let mut change = NodeValues::default();
        for a in 0..num_nodes {
            change.r[a].copy_from_slice(&increment[6 * a..6 * a + R]);
            for (unknown, way) in Self::rotations(&nodes.q[a]) {
                let turn = increment[6 * a + unknown];
                for l in 0..Z {
                    change.q[a][l] += turn * way[l];
                }
            }
        }
        change
    }

    fn predict(
        body: &ElementProperties,
        nodes: &NodeValues<R, Z>,
        material: &impl MaterialLaw<S>,
        reference: &[[f64; S]; 3],
        increment: &[f64; MAX_DOF],
    ) -> [[f64; S]; 3] {
        let change = Self::nodal_change(nodes, increment, body.table.order + 1);
        let mut out = [[0.0; S]; 3];
        for g in 0..body.table.order {
            let (raw, linear, _) = Self::linear_change(body.table, nodes, &change, body.length, g);
            out[g] = material.stress(g, &std::array::from_fn(|i| raw[i] - reference[g][i] + linear[i]));
        }
        out
    }

    fn second_order(
        body: &ElementProperties,
        nodes: &NodeValues<R, Z>,
        moved: &NodeValues<R, Z>,
        material: &impl MaterialLaw<S>,
        increment: &[f64; MAX_DOF],
    ) -> ([[f64; S]; 3], [f64; MAX_DOF]) {
        let (table, length) = (body.table, body.length);
        let num_nodes = table.order + 1;
        let change = Self::nodal_change(nodes, increment, num_nodes);
        let mut excess = [[0.0; S]; 3];
        let mut nodal = NodalGradient::default();
        for g in 0..table.order {
            let (raw, linear, b) = Self::linear_change(table, nodes, &change, length, g);
            let after = Self::strain(&interpolate(moved, &table.n[g], &table.d[g], num_nodes, 1.0 / length));
            excess[g] = material.stress(g, &std::array::from_fn(|i| after[i] - raw[i] - linear[i]));
            nodal.add(&Slope::sum(&excess[g], &b), &body.shape_at(g));
        }
        (excess, Self::forces(nodes, &nodal, num_nodes))
    }

    /// Derivatives with respect to the unknowns of the nodes.
    fn forces(nodes: &NodeValues<R, Z>, gradient: &NodalGradient<R, Z>, num_nodes: usize) -> [f64; MAX_DOF] {
        let mut out = [0.0; MAX_DOF];
        for a in 0..num_nodes {
            out[6 * a..6 * a + R].copy_from_slice(&gradient.r[a]);
            for (unknown, way) in Self::rotations(&nodes.q[a]) {
                out[6 * a + unknown] = inner(&way, &gradient.q[a]);
            }
        }
        out
    }

    /// First derivatives of the strains with respect to y = (r', z, z'): ∇f = (∇P − f ∇|z|²)/|z|².
    #[inline]
    fn gradients(p: &InterpolatedPoint<R, Z>, strain: &[f64; S]) -> [Slope<R, Z>; S] {
        let inv = 1.0 / p.zz;
        let mut b = Self::slopes(p);
        for i in 0..S {
            for k in 0..Z {
                b[i].z[k] -= 2.0 * strain[i] * p.z[k];
            }
            b[i] = b[i].times(inv);
        }
        b
    }

    /// Σ_i S_i ∇²f_i and Σ S_i ∇f_i.
    #[inline]
    fn geometric(
        p: &InterpolatedPoint<R, Z>,
        strain: &[f64; S],
        b: &[Slope<R, Z>; S],
        stress: &[f64; S],
    ) -> (SecondDerivative<R, Z>, Slope<R, Z>) {
        let inv = 1.0 / p.zz;
        let g = Slope::sum(stress, b);
        let mut work = 0.0;
        for i in 0..S {
            work += stress[i] * strain[i];
        }
        let mut h = Self::curvature(p, stress);
        for l in 0..Z {
            for k in 0..R {
                h.rz[k][l] = (h.rz[k][l] - 2.0 * g.r[k] * p.z[l]) * inv;
            }
            for k in 0..Z {
                h.zz[k][l] = (h.zz[k][l] - 2.0 * (g.z[k] * p.z[l] + p.z[k] * g.z[l])) * inv;
                h.zzp[l][k] = (h.zzp[l][k] - 2.0 * p.z[l] * g.zp[k]) * inv;
                h.zpz[k][l] = h.zzp[l][k];
            }
            h.zz[l][l] -= 2.0 * work * inv;
        }
        (h, g)
    }

    fn evaluate(
        body: &ElementProperties,
        nodes: &NodeValues<R, Z>,
        material: &impl MaterialLaw<S>,
        given: &PointValues<S>,
        tangent: Option<&mut ElementTangent>,
    ) -> ElementOutput {
        let (table, length) = (body.table, body.length);
        let num_nodes = table.order + 1;
        let mut out = ElementOutput::default();
        let mut nodal = NodalGradient::default();
        let mut blocks = tangent.is_some().then(NodeBlocks::<R, Z>::default);
        for g in 0..table.order {
            let shape = body.shape_at(g);
            let p = interpolate(nodes, &table.n[g], &table.d[g], num_nodes, 1.0 / length);
            let raw = Self::strain(&p);
            let b = Self::gradients(&p, &raw);
            let strain: [f64; S] = std::array::from_fn(|i| raw[i] - given.reference[g][i]);
            let stress = material.stress(g, &strain);
            let mut energy = ElasticEnergies::default();
            for i in 0..S {
                energy.add(Self::KIND[i], stress[i] * strain[i]);
            }
            out.energy += energy.scaled(0.5 * shape.weight);
            nodal.add(&Slope::sum(&stress, &b), &shape);
            let Some(blocks) = &mut blocks else { continue };
            let (mut h, grad) = Self::geometric(&p, &raw, &b, given.predicted.map_or(&stress, |s| &s[g]));
            blocks.gradient.add(&grad, &shape);
            for (scaled, b) in material.of_slopes(g, &b).iter().zip(&b) {
                h.add_product(scaled, b);
            }
            blocks.add(&h, &shape);
        }
        out.residual = Self::forces(nodes, &nodal, num_nodes);
        let (Some(blocks), Some(tangent)) = (blocks, tangent) else { return out };
        for a in 0..num_nodes {
            for c in a..num_nodes {
                Self::write(&blocks, tangent, [a, c], nodes);
            }
            let correction = -0.25 * inner(&blocks.gradient.q[a], &nodes.q[a]);
            for k in Self::ROTATIONS {
                tangent[6 * a + k][6 * a + k] += correction;
            }
        }
        out
    }

    /// Transforms the blocks of nodes a ≤ c to the unknowns (δr, θ).
    fn write(blocks: &NodeBlocks<R, Z>, tangent: &mut ElementTangent, [a, c]: [usize; 2], nodes: &NodeValues<R, Z>) {
        let (row, col) = (6 * a, 6 * c);
        for k in 0..R {
            for l in 0..R {
                tangent[row + k][col + l] = blocks.rr[a][c][k][l];
            }
            for (unknown, way) in Self::rotations(&nodes.q[c]) {
                tangent[row + k][col + unknown] = inner(&blocks.rq[a][c][k], &way);
            }
            for (unknown, way) in Self::rotations(&nodes.q[a]) {
                tangent[row + unknown][col + k] = inner(&blocks.rq[c][a][k], &way);
            }
        }
        for (first, way) in Self::rotations(&nodes.q[a]) {
            let mut product = [0.0; Z];
            for m in 0..Z {
                for l in 0..Z {
                    product[l] += way[m] * blocks.qq[a][c][m][l];
                }
            }
            for (second, way) in Self::rotations(&nodes.q[c]) {
                tangent[row + first][col + second] = inner(&product, &way);
            }
        }
    }
}

/// Values at the integration points of an element.
struct PointValues<'a, const S: usize> {
    /// Raw strains of the natural state.
    reference: &'a [[f64; S]; 3],
    /// Stresses for the geometric part of the tangent; `None`: C ε(x).
    predicted: Option<&'a [[f64; S]; 3]>,
}

/// Stresses C(ε + B δ) at the integration points for nodal increments δ (displacement, rotation vector per node): the
/// prediction of the mixed-integration-point step.
pub fn predicted_stress(
    body: &ElementProperties,
    nodes: &ElementNodes,
    reference: &[Strain; 3],
    increment: &[f64; MAX_DOF],
) -> [Strain; 3] {
    match (body.flat(nodes), body.material) {
        (Some((plane, flat, material)), _) => {
            let reference = reference.map(|six| plane.part(&six));
            InPlane::predict(body, &flat, &material, &reference, increment).map(|s| plane.six(&s))
        }
        (None, Material::Diagonal(material)) => Space::predict(body, nodes, material, reference, increment),
        (None, Material::Full(material)) => Space::predict(body, nodes, material, reference, increment),
    }
}

/// Stresses C e of the second-order strain of a finite step, e = ε(moved) − ε(nodes) − B δ, and their nodal forces Bᵀ C
/// e, with B at the start of the step.
pub fn second_order_force(
    body: &ElementProperties,
    nodes: &ElementNodes,
    moved: &ElementNodes,
    increment: &[f64; MAX_DOF],
) -> ([Strain; 3], [f64; MAX_DOF]) {
    match (body.flat(nodes), body.flat(moved), body.material) {
        (Some((plane, flat, material)), Some((_, moved, _)), _) => {
            let (stress, force) = InPlane::second_order(body, &flat, &moved, &material, increment);
            (stress.map(|s| plane.six(&s)), force)
        }
        (.., Material::Diagonal(material)) => Space::second_order(body, nodes, moved, material, increment),
        (.., Material::Full(material)) => Space::second_order(body, nodes, moved, material, increment),
    }
}

/// Result of [`evaluate`] without the tangent.
#[derive(Debug, Clone, Default)]
pub struct ElementOutput {
    /// Energies \[F·L\].
    pub energy: ElasticEnergies,
    /// ∂E/∂(δr, θ), six per node; of an element in a plane the others are zero.
    pub residual: [f64; MAX_DOF],
}

/// Symmetric tangent of an element; only the blocks a ≤ b (node a row, node b column) are filled, of an element in a
/// plane only the displacements in x and y and the rotation about z of them.
pub type ElementTangent = [[f64; MAX_DOF]; MAX_DOF];

/// Energy, residual and, on request, tangent of an element. Entries of `tangent` that are not filled stay as they were.
///
/// `reference` raw strains of the natural state per point; `predicted` stresses for the geometric part of the tangent
/// per point (`None`: C ε(x)).
pub fn evaluate(
    body: &ElementProperties,
    nodes: &ElementNodes,
    reference: &[Strain; 3],
    predicted: Option<&[Stress; 3]>,
    tangent: Option<&mut ElementTangent>,
) -> ElementOutput {
    let given = PointValues { reference, predicted };
    match (body.flat(nodes), body.material) {
        (Some((plane, flat, material)), _) => {
            let reference = reference.map(|six| plane.part(&six));
            let predicted = predicted.map(|stress| stress.map(|six| plane.part(&six)));
            let given = PointValues { reference: &reference, predicted: predicted.as_ref() };
            InPlane::evaluate(body, &flat, &material, &given, tangent)
        }
        (None, Material::Diagonal(material)) => Space::evaluate(body, nodes, material, &given, tangent),
        (None, Material::Full(material)) => Space::evaluate(body, nodes, material, &given, tangent),
    }
}

#[cfg(test)]
mod tests;
