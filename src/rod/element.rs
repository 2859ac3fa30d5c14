//! Energy, residual and tangent of one rod element.
//!
//! Inside an element r = Σ N_a r_a and z = Σ N_a q_a (nodal quaternions with aligned signs), frame q = z/|z|. Strains
//!
//! ```text
//! V_i = ⟨z e_i, r' z⟩ / |z|²        Γ = V − V_ref      shear (1, 2), extension (3)
//! K_i = 2 ⟨z e_i, z'⟩ / |z|²        K − K_ref          bending (1, 2), twist (3)
//! ```
//!
//! depend on the eleven numbers y = (r', z, z'), V on r' and z, K on z and z', as quadratic forms P over |z|², which makes exact first and second
//! derivatives short: with f = P/|z|², ∇²f = (∇²P − f ∇²|z|² − ∇f⊗∇|z|² − ∇|z|²⊗∇f)/|z|².
//! Left multiplication of all q_a by one unit quaternion commutes with the interpolation, so the strains are objective;
//! nothing incremental is interpolated, so they are path independent (cf. Crisfield & Jelenić 1999).
//!
//! Unknowns of a node are (δr, θ) with q ← exp(θ/2) q = q + ½θq − ⅛|θ|²q + …, so the Hessian in θ is TᵀHT plus the diagonal
//! −¼ (∂E/∂q · q) I.
//!
//! The stress inside the geometric part of the tangent may differ from C ε(x): mixed-integration-point Newton
//! (Magisano, Leonetti & Garcea 2017) passes the stress predicted by the previous linear solve.

use crate::math::shape_functions::Table;
use crate::rod::Section;
use hessian::{Curvature, Hessian, turned};
use kinematics::{InPlane, Point, Slopes, Space, inner};

mod hessian;
mod kinematics;

pub use kinematics::{Nodes, Plane};

/// Six numbers per integration point: shear, shear, extension, bending, bending, twist (strain or its stress).
pub type Six = [f64; 6];

/// Number of unknowns of the largest element.
pub const MAX_DOF: usize = 24;

/// Nodal input of one element in space.
pub type ElementNodes = Nodes<3, 4>;

/// What the elements of a rod have in common.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a> {
    /// Shape functions.
    pub table: &'a Table,
    /// Reference length of an element \[L\].
    pub length: f64,
    /// Diagonal of the material matrix.
    pub material: &'a Six,
    /// The plane that the rod moves in, if it moves in one: elements whose nodes are in it (positions in x and y, frames turned about z) are computed
    /// there, with the same results to rounding.
    pub plane: Option<&'a Plane>,
}

/// Diagonal of the material matrix, in the order of [`Six`].
pub fn stiffness(section: &Section) -> Six {
    [
        section.shearing[0],
        section.shearing[1],
        section.stretching,
        section.bending[0],
        section.bending[1],
        section.twisting,
    ]
}

/// The kernel for elements of an order, whose loops have fixed ends.
macro_rules! of_order {
    ($order:expr, $kinematics:ident::$kernel:ident) => {
        match $order {
            1 => $kinematics::$kernel::<2>,
            2 => $kinematics::$kernel::<3>,
            _ => $kinematics::$kernel::<4>,
        }
    };
}

/// Raw strains (V, K) at the integration points of an element of reference length `length` \[L\].
pub fn raw_strains(table: &Table, nodes: &ElementNodes, length: f64) -> [Six; 3] {
    of_order!(table.order, Space::strains)(table, nodes, length)
}

/// Slopes of the shape functions by arc length at the integration points. One place, so that all kernels see the same strains to the last bit: an axial
/// stiffness of 1e12 makes a stress of 1e-4 out of it.
#[inline(always)]
fn slopes_by_arc(table: &Table, length: f64) -> [[f64; 4]; 3] {
    let inv = 1.0 / length;
    table.d.map(|slopes| slopes.map(|x| x * inv))
}

impl Body<'_> {
    /// The plane and the nodes in it, if all are.
    fn flat(&self, nodes: &ElementNodes) -> Option<(&Plane, Nodes<2, 2>)> {
        let plane = self.plane?;
        Some((plane, plane.nodes(nodes, self.table.order + 1)?))
    }
}

/// R components of r', Z of z, S strains: V by R first, then K by T = S − R, as many as a node has rotations. Strains are P_i/|z|². `NODES` is the order + 1.
trait Kinematics<const R: usize, const Z: usize, const S: usize, const T: usize>: Sized {
    /// The energy that a strain belongs to: stretch, shear, bend, twist.
    const KIND: [usize; S];
    /// The first of the rotations among the six unknowns of a node, which begin with the R displacements.
    const FIRST_ROTATION: usize = 6 - T;

    /// P_i, as products whose terms cancel exactly where they should: in a planar state out-of-plane strains are zero, not 1e-17.
    fn forms(p: &Point<R, Z>) -> [f64; S];

    /// ∇P_i.
    fn slopes(p: &Point<R, Z>) -> Slopes<R, Z, T>;

    /// Σ S_i ∇²P_i.
    fn curvature(p: &Point<R, Z>, stress: &[f64; S]) -> Curvature<R, Z>;

    /// The directions in which the quaternion moves when the node turns, ½ e_k q, as columns.
    fn rotations(q: &[f64; Z]) -> [[f64; T]; Z];

    /// Strains (reference values not subtracted) and their first derivatives ∇f = (∇P − f ∇|z|²)/|z|².
    #[inline(always)]
    fn strain(p: &Point<R, Z>) -> ([f64; S], Slopes<R, Z, T>) {
        let inv = 1.0 / p.zz;
        let mut b = Self::slopes(p);
        let strain = Self::forms(p).map(|form| form * inv);
        for i in 0..R {
            b.v_r[i] = b.v_r[i].map(|x| x * inv);
            for k in 0..Z {
                b.v_z[i][k] = (b.v_z[i][k] - 2.0 * strain[i] * p.z[k]) * inv;
            }
        }
        for i in 0..T {
            b.k_d[i] = b.k_d[i].map(|x| x * inv);
            for k in 0..Z {
                b.k_z[i][k] = (b.k_z[i][k] - 2.0 * strain[R + i] * p.z[k]) * inv;
            }
        }
        (strain, b)
    }

    fn strains<const NODES: usize>(table: &Table, nodes: &Nodes<R, Z>, length: f64) -> [[f64; S]; 3] {
        let d = slopes_by_arc(table, length);
        let mut out = [[0.0; S]; 3];
        for g in 0..NODES - 1 {
            out[g] = Self::strain(&Point::new::<NODES>(nodes, &table.n[g], &d[g])).0;
        }
        out
    }

    /// Nodal rates of change of positions and quaternions for an increment.
    #[inline(always)]
    fn nodal_change<const NODES: usize>(nodes: &Nodes<R, Z>, increment: &[f64; MAX_DOF]) -> Nodes<R, Z> {
        let mut change = Nodes::default();
        for a in 0..NODES {
            change.r[a].copy_from_slice(&increment[6 * a..6 * a + R]);
            let turn: [f64; T] = std::array::from_fn(|k| increment[6 * a + Self::FIRST_ROTATION + k]);
            change.q[a] = Self::rotations(&nodes.q[a]).map(|way| inner(&way, &turn));
        }
        change
    }

    /// Raw strains at a point, their change B δ that a linear step predicts, and ∇f.
    #[inline(always)]
    fn linear_change<const NODES: usize>(
        nodes: &Nodes<R, Z>,
        change: &Nodes<R, Z>,
        n: &[f64; 4],
        d: &[f64; 4],
    ) -> ([f64; S], [f64; S], Slopes<R, Z, T>) {
        let change = Point::new::<NODES>(change, n, d);
        let (raw, b) = Self::strain(&Point::new::<NODES>(nodes, n, d));
        let mut linear = b.along(&change.rp, &change.zp);
        for (i, by_z) in b.v_z.iter().chain(&b.k_z).enumerate() {
            linear[i] += inner(by_z, &change.z);
        }
        (raw, linear, b)
    }

    fn predict<const NODES: usize>(
        body: &Body,
        nodes: &Nodes<R, Z>,
        material: &[f64; S],
        reference: &[[f64; S]; 3],
        increment: &[f64; MAX_DOF],
    ) -> [[f64; S]; 3] {
        let change = Self::nodal_change::<NODES>(nodes, increment);
        let d = slopes_by_arc(body.table, body.length);
        let mut out = [[0.0; S]; 3];
        for g in 0..NODES - 1 {
            let (raw, linear, _) = Self::linear_change::<NODES>(nodes, &change, &body.table.n[g], &d[g]);
            out[g] = std::array::from_fn(|i| material[i] * (raw[i] - reference[g][i] + linear[i]));
        }
        out
    }

    fn surprise<const NODES: usize>(
        body: &Body,
        nodes: &Nodes<R, Z>,
        moved: &Nodes<R, Z>,
        material: &[f64; S],
        increment: &[f64; MAX_DOF],
    ) -> ([[f64; S]; 3], [f64; MAX_DOF]) {
        let (n, d) = (&body.table.n, slopes_by_arc(body.table, body.length));
        let change = Self::nodal_change::<NODES>(nodes, increment);
        let mut excess = [[0.0; S]; 3];
        let mut force = Nodes::default();
        for g in 0..NODES - 1 {
            let (raw, linear, b) = Self::linear_change::<NODES>(nodes, &change, &n[g], &d[g]);
            let (after, _) = Self::strain(&Point::new::<NODES>(moved, &n[g], &d[g]));
            excess[g] = std::array::from_fn(|i| material[i] * (after[i] - raw[i] - linear[i]));
            let weight = body.table.rule.weights[g] * body.length;
            force.add::<NODES>(&b.gradient(&excess[g].map(|s| s * weight)), &n[g], &d[g]);
        }
        let mut out = [0.0; MAX_DOF];
        Self::unknowns::<NODES>(&force, &nodes.q.each_ref().map(Self::rotations), &mut out);
        (excess, out)
    }

    /// A derivative by positions and quaternions of the nodes as one by displacements and rotations.
    #[inline(always)]
    fn unknowns<const NODES: usize>(by: &Nodes<R, Z>, ways: &[[[f64; T]; Z]; 4], out: &mut [f64; MAX_DOF]) {
        for a in 0..NODES {
            out[6 * a..6 * a + R].copy_from_slice(&by.r[a]);
            out[6 * a + Self::FIRST_ROTATION..6 * a + 6].copy_from_slice(&turned(&by.q[a], &ways[a]));
        }
    }

    fn evaluate<const NODES: usize>(
        body: &Body,
        nodes: &Nodes<R, Z>,
        material: &[f64; S],
        reference: &[[f64; S]; 3],
        predicted: Option<&[[f64; S]; 3]>,
        tangent: Option<&mut ElementTangent>,
        out: &mut ElementOutput,
    ) {
        let (n, d) = (&body.table.n, slopes_by_arc(body.table, body.length));
        *out = ElementOutput::default();
        let (mut force, mut predicted_force) = (Nodes::default(), Nodes::default());
        let mut hessians = [Hessian::default(); 3];
        for g in 0..NODES - 1 {
            let p = Point::new::<NODES>(nodes, &n[g], &d[g]);
            let (raw, slopes) = Self::strain(&p);
            let weight = body.table.rule.weights[g] * body.length;
            let stiffness = material.map(|c| weight * c);
            let mut stress = [0.0; S];
            for i in 0..S {
                let strain = raw[i] - reference[g][i];
                stress[i] = stiffness[i] * strain;
                out.energy[Self::KIND[i]] += 0.5 * stress[i] * strain;
            }
            force.add::<NODES>(&slopes.gradient(&stress), &n[g], &d[g]);
            if tangent.is_some() {
                let stress = predicted.map_or(stress, |s| s[g].map(|s| weight * s));
                predicted_force.add::<NODES>(&slopes.gradient(&stress), &n[g], &d[g]);
                hessians[g] = Hessian::new::<S, T, Self>(&p, &slopes, &raw, &stress, &stiffness);
            }
        }
        let ways = nodes.q.each_ref().map(Self::rotations);
        Self::unknowns::<NODES>(&force, &ways, &mut out.residual);
        let Some(tangent) = tangent else { return };
        for a in 0..NODES {
            for c in a..NODES {
                hessian::write::<R, Z, T, NODES>(&hessians, n, &d, [a, c], [&ways[a], &ways[c]], tangent);
            }
            let correction = -0.25 * inner(&predicted_force.q[a], &nodes.q[a]);
            for k in 6 * a + Self::FIRST_ROTATION..6 * a + 6 {
                tangent[k][k] += correction;
            }
        }
    }
}

/// Stresses C(ε + B δ) at the integration points for nodal increments δ (displacement, rotation vector per node): what the
/// mixed-integration-point step predicts.
pub fn predicted_stress(
    body: &Body,
    nodes: &ElementNodes,
    reference: &[Six; 3],
    increment: &[f64; MAX_DOF],
) -> [Six; 3] {
    match body.flat(nodes) {
        Some((plane, flat)) => {
            let (material, reference) = (plane.material(body.material), reference.map(|six| plane.part(&six)));
            let predict = of_order!(body.table.order, InPlane::predict);
            predict(body, &flat, &material, &reference, increment).map(|s| plane.six(&s))
        }
        None => {
            let predict = of_order!(body.table.order, Space::predict);
            predict(body, nodes, body.material, reference, increment)
        }
    }
}

/// Stresses C e of the strain that a finite step made beyond its linear prediction, e = ε(moved) − ε(nodes) − B δ, and their nodal
/// forces Bᵀ C e, with B at the start of the step.
pub fn surprise_force(
    body: &Body,
    nodes: &ElementNodes,
    moved: &ElementNodes,
    increment: &[f64; MAX_DOF],
) -> ([Six; 3], [f64; MAX_DOF]) {
    match (body.flat(nodes), body.flat(moved)) {
        (Some((plane, flat)), Some((_, moved))) => {
            let material = plane.material(body.material);
            let surprise = of_order!(body.table.order, InPlane::surprise);
            let (stress, force) = surprise(body, &flat, &moved, &material, increment);
            (stress.map(|s| plane.six(&s)), force)
        }
        _ => {
            let surprise = of_order!(body.table.order, Space::surprise);
            surprise(body, nodes, moved, body.material, increment)
        }
    }
}

/// Result of [`evaluate`] without the tangent: overwritten, not accumulated.
#[derive(Debug, Clone, Default)]
pub struct ElementOutput {
    /// Energies \[F·L\]: stretch, shear, bend, twist.
    pub energy: [f64; 4],
    /// ∂E/∂(δr, θ), six per node; of an element in a plane the others are zero.
    pub residual: [f64; MAX_DOF],
}

/// Symmetric tangent of an element; only the blocks a ≤ b (node a row, node b column) are filled, of an element in a plane only the displacements
/// in x and y and the rotation about z of them.
pub type ElementTangent = [[f64; MAX_DOF]; MAX_DOF];

/// Energy, residual and (if wanted) tangent of an element; what is not filled stays as it was.
///
/// `reference` raw strains of the natural state per point; `predicted` stresses for the geometric part of the tangent per point (`None`: C ε(x)).
pub fn evaluate(
    body: &Body,
    nodes: &ElementNodes,
    reference: &[Six; 3],
    predicted: Option<&[Six; 3]>,
    tangent: Option<&mut ElementTangent>,
    out: &mut ElementOutput,
) {
    match body.flat(nodes) {
        Some((plane, flat)) => {
            let (material, reference) = (plane.material(body.material), reference.map(|six| plane.part(&six)));
            let predicted = predicted.map(|stress| stress.map(|six| plane.part(&six)));
            let predicted = predicted.as_ref();
            let evaluate = of_order!(body.table.order, InPlane::evaluate);
            evaluate(body, &flat, &material, &reference, predicted, tangent, out);
        }
        None => {
            let evaluate = of_order!(body.table.order, Space::evaluate);
            evaluate(body, nodes, body.material, reference, predicted, tangent, out);
        }
    }
}

#[cfg(test)]
mod tests;
