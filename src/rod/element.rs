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
//! derivatives short: with f = P/|z|², ∇²f = (∇²P − f ∇²|z|² − ∇f⊗∇|z|² − ∇|z|²⊗∇f)/|z|².
//! Left multiplication of all q_a by one unit quaternion commutes with the interpolation, so the strains are objective;
//! nothing incremental is interpolated, so they are path independent (cf. Crisfield & Jelenić 1999).
//!
//! Unknowns of a node are (δr, θ) with q ← exp(θ/2) q = q + ½θq − ⅛|θ|²q + …, so the Hessian in θ is TᵀHT plus the diagonal
//! −¼ (∂E/∂q · q) I.
//!
//! The stress inside the geometric part of the tangent may differ from C ε(x): mixed-integration-point Newton
//! (Magisano, Leonetti & Garcea 2017) passes the stress predicted by the previous linear solve.

use crate::math::quaternion::{Q, dot, mul, mul_e1, mul_e2, mul_e3, mul_pure, pure_mul};
use crate::math::shape_functions::Table;
use crate::rod::Section;

/// Six numbers per integration point: shear, shear, extension, bending, bending, twist (strain or its stress).
pub type Six = [f64; 6];

/// Number of unknowns of the largest element.
pub const MAX_DOF: usize = 24;

/// Nodal input of one element: positions and sign-aligned quaternions; entries beyond order + 1 are ignored.
#[derive(Debug, Clone, Copy, Default)]
pub struct ElementNodes {
    /// Positions \[L\].
    pub r: [[f64; 3]; 4],
    /// Quaternions, each in the hemisphere of its predecessor.
    pub q: [Q; 4],
}

impl ElementNodes {
    /// Flips quaternions so that neighbours have a non-negative inner product.
    pub fn align_signs(&mut self, num_nodes: usize) {
        for a in 1..num_nodes {
            if dot(&self.q[a - 1], &self.q[a]) < 0.0 {
                self.q[a] = self.q[a].map(|x| -x);
            }
        }
    }
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

/// The eleven interpolated numbers at one integration point.
struct Point {
    rp: [f64; 3],
    z: Q,
    zp: Q,
    zz: f64,
}

fn interpolate(nodes: &ElementNodes, n: &[f64; 4], d: &[f64; 4], num_nodes: usize, inv_length: f64) -> Point {
    let (mut rp, mut z, mut zp) = ([0.0; 3], [0.0; 4], [0.0; 4]);
    for a in 0..num_nodes {
        let slope = d[a] * inv_length;
        for k in 0..3 {
            rp[k] += slope * nodes.r[a][k];
        }
        for k in 0..4 {
            z[k] += n[a] * nodes.q[a][k];
            zp[k] += slope * nodes.q[a][k];
        }
    }
    let zz = dot(&z, &z);
    Point { rp, z, zp, zz }
}

/// V and K (reference values not subtracted).
fn raw_strain(p: &Point) -> Six {
    let w = [mul_e1(&p.z), mul_e2(&p.z), mul_e3(&p.z)];
    let u = pure_mul(&p.rp, &p.z);
    let inv = 1.0 / p.zz;
    [
        dot(&w[0], &u) * inv,
        dot(&w[1], &u) * inv,
        dot(&w[2], &u) * inv,
        2.0 * dot(&w[0], &p.zp) * inv,
        2.0 * dot(&w[1], &p.zp) * inv,
        2.0 * dot(&w[2], &p.zp) * inv,
    ]
}

/// Raw strains (V, K) at the integration points of an element of reference length `length` \[L\].
pub fn raw_strains(table: &Table, nodes: &ElementNodes, length: f64) -> [Six; 3] {
    let mut out = [[0.0; 6]; 3];
    for g in 0..table.order {
        out[g] = raw_strain(&interpolate(nodes, &table.n[g], &table.d[g], table.order + 1, 1.0 / length));
    }
    out
}

/// Change of the six strains at integration point `g` that a linear step δ (displacement, rotation vector per node) predicts: B δ.
/// Also returns raw strains and B's rows.
fn linear_change(
    table: &Table,
    nodes: &ElementNodes,
    change: &ElementNodes,
    length: f64,
    g: usize,
) -> (Six, Six, [[f64; 11]; 6]) {
    let num_nodes = table.order + 1;
    let p = interpolate(nodes, &table.n[g], &table.d[g], num_nodes, 1.0 / length);
    let dp = interpolate(change, &table.n[g], &table.d[g], num_nodes, 1.0 / length);
    let raw = raw_strain(&p);
    let b = gradients(&p, &raw);
    let mut linear = [0.0; 6];
    for i in 0..6 {
        for k in 0..3 {
            linear[i] += b[i][k] * dp.rp[k];
        }
        for k in 0..4 {
            linear[i] += b[i][3 + k] * dp.z[k] + b[i][7 + k] * dp.zp[k];
        }
    }
    (raw, linear, b)
}

/// Nodal rates of change of positions and quaternions for an increment.
fn nodal_change(nodes: &ElementNodes, increment: &[f64; MAX_DOF], num_nodes: usize) -> ElementNodes {
    let mut change = ElementNodes::default();
    for a in 0..num_nodes {
        for k in 0..3 {
            change.r[a][k] = increment[6 * a + k];
        }
        let turn = [increment[6 * a + 3], increment[6 * a + 4], increment[6 * a + 5]];
        change.q[a] = pure_mul(&turn, &nodes.q[a]).map(|x| 0.5 * x);
    }
    change
}

/// Stresses C(ε + B δ) at the integration points for nodal increments δ (displacement, rotation vector per node): what the
/// mixed-integration-point step predicts.
pub fn predicted_stress(
    table: &Table,
    nodes: &ElementNodes,
    length: f64,
    material: &Six,
    reference: &[Six; 3],
    increment: &[f64; MAX_DOF],
) -> [Six; 3] {
    let change = nodal_change(nodes, increment, table.order + 1);
    let mut out = [[0.0; 6]; 3];
    for g in 0..table.order {
        let (raw, linear, _) = linear_change(table, nodes, &change, length, g);
        for i in 0..6 {
            out[g][i] = material[i] * (raw[i] - reference[g][i] + linear[i]);
        }
    }
    out
}

/// Stresses C e of the strain that a finite step made beyond its linear prediction, e = ε(moved) − ε(nodes) − B δ, and their nodal
/// forces Bᵀ C e, with B at the start of the step.
pub fn surprise_force(
    table: &Table,
    nodes: &ElementNodes,
    moved: &ElementNodes,
    length: f64,
    material: &Six,
    increment: &[f64; MAX_DOF],
) -> ([Six; 3], [f64; MAX_DOF]) {
    let num_nodes = table.order + 1;
    let change = nodal_change(nodes, increment, num_nodes);
    let mut excess = [[0.0; 6]; 3];
    let (mut grad_r, mut grad_q) = ([[0.0; 3]; 4], [[0.0; 4]; 4]);
    for g in 0..table.order {
        let (raw, linear, b) = linear_change(table, nodes, &change, length, g);
        let after = raw_strain(&interpolate(moved, &table.n[g], &table.d[g], num_nodes, 1.0 / length));
        let mut grad = [0.0; 11];
        for i in 0..6 {
            let stress = material[i] * (after[i] - raw[i] - linear[i]);
            excess[g][i] = stress;
            for k in 0..11 {
                grad[k] += stress * b[i][k];
            }
        }
        let d = table.d[g].map(|x| x / length);
        add_nodal_gradient(&grad, &table.n[g], &d, table.rule.weights[g] * length, num_nodes, &mut grad_r, &mut grad_q);
    }
    let mut out = [0.0; MAX_DOF];
    for a in 0..num_nodes {
        let half = rotation_basis(&nodes.q[a]);
        for k in 0..3 {
            out[6 * a + k] = grad_r[a][k];
            out[6 * a + 3 + k] = dot(&half[k], &grad_q[a]);
        }
    }
    (excess, out)
}

/// First derivatives of the six strains with respect to y = (r', z, z'); b[i][0..3], [3..7], [7..11].
fn gradients(p: &Point, strain: &Six) -> [[f64; 11]; 6] {
    let mut b = [[0.0; 11]; 6];
    let inv = 1.0 / p.zz;
    let u = pure_mul(&p.rp, &p.z);
    let w = [mul_e1(&p.z), mul_e2(&p.z), mul_e3(&p.z)];
    let ue = [mul_e1(&u), mul_e2(&u), mul_e3(&u)];
    let ze = [mul_e1(&p.zp), mul_e2(&p.zp), mul_e3(&p.zp)];
    let conj = [p.z[0], -p.z[1], -p.z[2], -p.z[3]];
    for i in 0..3 {
        let director = mul(&w[i], &conj);
        for k in 0..3 {
            b[i][k] = director[k + 1] * inv;
        }
        for k in 0..4 {
            b[i][3 + k] = (-2.0 * ue[i][k] - 2.0 * strain[i] * p.z[k]) * inv;
            b[3 + i][3 + k] = (-2.0 * ze[i][k] - 2.0 * strain[3 + i] * p.z[k]) * inv;
            b[3 + i][7 + k] = 2.0 * w[i][k] * inv;
        }
    }
    b
}

/// Adds Σ_i S_i ∇²f_i to `h` (11×11, symmetric); returns g = Σ S_i ∇f_i.
fn add_geometric(p: &Point, strain: &Six, b: &[[f64; 11]; 6], stress: &Six, h: &mut [[f64; 11]; 11]) -> [f64; 11] {
    let inv = 1.0 / p.zz;
    let mut g = [0.0; 11];
    let mut work = 0.0;
    for i in 0..6 {
        work += stress[i] * strain[i];
        for k in 0..11 {
            g[k] += stress[i] * b[i][k];
        }
    }
    let force = [stress[0], stress[1], stress[2]];
    let moment = [stress[3], stress[4], stress[5]];
    let zn = mul_pure(&p.z, &force);
    const UNIT: [Q; 4] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    for k in 0..3 {
        let mixed = mul(&UNIT[k + 1], &zn);
        for l in 0..4 {
            let value = (-2.0 * mixed[l] - 2.0 * g[k] * p.z[l]) * inv;
            h[k][3 + l] += value;
            h[3 + l][k] += value;
        }
    }
    for k in 0..4 {
        let column = mul_pure(&pure_mul(&p.rp, &UNIT[k]), &force);
        for l in 0..4 {
            h[3 + l][3 + k] += (-2.0 * column[l] - 2.0 * (g[3 + l] * p.z[k] + p.z[l] * g[3 + k])) * inv;
        }
        h[3 + k][3 + k] -= 2.0 * work * inv;
        let row = mul_pure(&UNIT[k], &moment);
        for l in 0..4 {
            let value = (2.0 * row[l] - 2.0 * p.z[k] * g[7 + l]) * inv;
            h[3 + k][7 + l] += value;
            h[7 + l][3 + k] += value;
        }
    }
    g
}

/// Result of [`evaluate`]: overwritten, not accumulated.
#[derive(Debug, Clone)]
pub struct ElementOutput {
    /// Energies \[F·L\]: stretch, shear, bend, twist.
    pub energy: [f64; 4],
    /// ∂E/∂(δr, θ), six per node.
    pub residual: [f64; MAX_DOF],
    /// Symmetric tangent; only the blocks a ≤ b (node a row, node b column) are filled, in full.
    pub tangent: [[f64; MAX_DOF]; MAX_DOF],
    /// Strains minus reference at the integration points.
    pub strain: [Six; 3],
}

impl Default for ElementOutput {
    fn default() -> Self {
        Self { energy: [0.0; 4], residual: [0.0; MAX_DOF], tangent: [[0.0; MAX_DOF]; MAX_DOF], strain: [[0.0; 6]; 3] }
    }
}

/// What [`evaluate`] computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// Energy, strains, residual.
    Residual,
    /// Also the tangent.
    Tangent,
}

/// Energy, residual and (if wanted) tangent of an element.
///
/// `length` reference length \[L\]; `material` diagonal of C; `reference` raw strains of the natural state per point;
/// `predicted` stresses for the geometric part of the tangent per point (`None`: C ε(x)).
#[allow(clippy::too_many_arguments)] // geometry, material, what is wanted, where it goes
pub fn evaluate(
    table: &Table,
    nodes: &ElementNodes,
    length: f64,
    material: &Six,
    reference: &[Six; 3],
    predicted: Option<&[Six; 3]>,
    want: Want,
    out: &mut ElementOutput,
) {
    let num_nodes = table.order + 1;
    out.energy = [0.0; 4];
    let mut grad_r = [[0.0; 3]; 4];
    let mut grad_q = [[0.0; 4]; 4];
    let mut grad_q_predicted = [[0.0; 4]; 4];
    let mut rr = [[[[0.0; 3]; 3]; 4]; 4];
    let mut rq = [[[[0.0; 4]; 3]; 4]; 4];
    let mut qq = [[[[0.0; 4]; 4]; 4]; 4];
    for g in 0..table.order {
        let weight = table.rule.weights[g] * length;
        let n = &table.n[g];
        let d = table.d[g].map(|x| x / length);
        let p = interpolate(nodes, n, &table.d[g], num_nodes, 1.0 / length);
        let raw = raw_strain(&p);
        let b = gradients(&p, &raw);
        let mut strain = [0.0; 6];
        let mut stress = [0.0; 6];
        for i in 0..6 {
            strain[i] = raw[i] - reference[g][i];
            stress[i] = material[i] * strain[i];
        }
        out.strain[g] = strain;
        out.energy[0] += 0.5 * weight * stress[2] * strain[2];
        out.energy[1] += 0.5 * weight * (stress[0] * strain[0] + stress[1] * strain[1]);
        out.energy[2] += 0.5 * weight * (stress[3] * strain[3] + stress[4] * strain[4]);
        out.energy[3] += 0.5 * weight * stress[5] * strain[5];
        let mut grad = [0.0; 11];
        for i in 0..6 {
            for k in 0..11 {
                grad[k] += stress[i] * b[i][k];
            }
        }
        add_nodal_gradient(&grad, n, &d, weight, num_nodes, &mut grad_r, &mut grad_q);
        if want == Want::Residual {
            continue;
        }
        let mut h = [[0.0; 11]; 11];
        let predicted_stress = predicted.map_or(&stress, |s| &s[g]);
        let grad_predicted = add_geometric(&p, &raw, &b, predicted_stress, &mut h);
        let mut unused = [[0.0; 3]; 4];
        add_nodal_gradient(&grad_predicted, n, &d, weight, num_nodes, &mut unused, &mut grad_q_predicted);
        for i in 0..6 {
            for k in 0..11 {
                let scaled = material[i] * b[i][k];
                for l in 0..11 {
                    h[k][l] += scaled * b[i][l];
                }
            }
        }
        for a in 0..num_nodes {
            for c in a..num_nodes {
                accumulate_blocks(&h, (n[a], d[a]), (n[c], d[c]), weight, &mut rr[a][c], &mut rq[a][c], &mut qq[a][c]);
                if a != c {
                    accumulate_rq(&h, (n[c], d[c]), (n[a], d[a]), weight, &mut rq[c][a]);
                }
            }
        }
    }
    let half: [[Q; 3]; 4] = std::array::from_fn(|a| rotation_basis(&nodes.q[a]));
    for a in 0..num_nodes {
        for k in 0..3 {
            out.residual[6 * a + k] = grad_r[a][k];
            out.residual[6 * a + 3 + k] = dot(&half[a][k], &grad_q[a]);
        }
    }
    if want == Want::Tangent {
        for a in 0..num_nodes {
            for c in a..num_nodes {
                write_block(&mut out.tangent, a, c, &rr[a][c], &rq[a][c], &rq[c][a], &qq[a][c], &half);
            }
            let correction = -0.25 * dot(&grad_q_predicted[a], &nodes.q[a]);
            for k in 3..6 {
                out.tangent[6 * a + k][6 * a + k] += correction;
            }
        }
    }
}

/// ½ e_k q for k = 1, 2, 3: the directions in which the quaternion moves when the node turns.
fn rotation_basis(q: &Q) -> [Q; 3] {
    [
        [-0.5 * q[1], 0.5 * q[0], -0.5 * q[3], 0.5 * q[2]],
        [-0.5 * q[2], 0.5 * q[3], 0.5 * q[0], -0.5 * q[1]],
        [-0.5 * q[3], -0.5 * q[2], 0.5 * q[1], 0.5 * q[0]],
    ]
}

fn add_nodal_gradient(
    grad: &[f64; 11],
    n: &[f64; 4],
    d: &[f64; 4],
    weight: f64,
    num_nodes: usize,
    grad_r: &mut [[f64; 3]; 4],
    grad_q: &mut [[f64; 4]; 4],
) {
    for a in 0..num_nodes {
        let (na, da) = (weight * n[a], weight * d[a]);
        for k in 0..3 {
            grad_r[a][k] += da * grad[k];
        }
        for k in 0..4 {
            grad_q[a][k] += na * grad[3 + k] + da * grad[7 + k];
        }
    }
}

#[inline]
fn accumulate_blocks(
    h: &[[f64; 11]; 11],
    (na, da): (f64, f64),
    (nc, dc): (f64, f64),
    weight: f64,
    rr: &mut [[f64; 3]; 3],
    rq: &mut [[f64; 4]; 3],
    qq: &mut [[f64; 4]; 4],
) {
    let dd = weight * da * dc;
    for k in 0..3 {
        for l in 0..3 {
            rr[k][l] += dd * h[k][l];
        }
    }
    accumulate_rq(h, (na, da), (nc, dc), weight, rq);
    let (nn, nd, dn) = (weight * na * nc, weight * na * dc, weight * da * nc);
    for k in 0..4 {
        for l in 0..4 {
            qq[k][l] += nn * h[3 + k][3 + l] + nd * h[3 + k][7 + l] + dn * h[7 + k][3 + l] + dd * h[7 + k][7 + l];
        }
    }
}

#[inline]
fn accumulate_rq(h: &[[f64; 11]; 11], (_, da): (f64, f64), (nc, dc): (f64, f64), weight: f64, rq: &mut [[f64; 4]; 3]) {
    let (dn, dd) = (weight * da * nc, weight * da * dc);
    for k in 0..3 {
        for l in 0..4 {
            rq[k][l] += dn * h[k][3 + l] + dd * h[k][7 + l];
        }
    }
}

/// Turns ∂²/∂(r,q)² blocks of nodes a ≤ c into the 6×6 block in (δr, θ).
#[allow(clippy::too_many_arguments)]
fn write_block(
    tangent: &mut [[f64; MAX_DOF]; MAX_DOF],
    a: usize,
    c: usize,
    rr: &[[f64; 3]; 3],
    rq_ac: &[[f64; 4]; 3],
    rq_ca: &[[f64; 4]; 3],
    qq: &[[f64; 4]; 4],
    half: &[[Q; 3]; 4],
) {
    let (row, col) = (6 * a, 6 * c);
    for k in 0..3 {
        for l in 0..3 {
            tangent[row + k][col + l] = rr[k][l];
            tangent[row + k][col + 3 + l] = dot(&rq_ac[k], &half[c][l]);
            tangent[row + 3 + k][col + l] = dot(&rq_ca[l], &half[a][k]);
        }
        let mut product = [0.0; 4];
        for m in 0..4 {
            for l in 0..4 {
                product[l] += half[a][k][m] * qq[m][l];
            }
        }
        for l in 0..3 {
            tangent[row + 3 + k][col + 3 + l] = dot(&product, &half[c][l]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quaternion::{exp, to_array};
    use crate::math::{Quat, Vec3};

    struct Case {
        r: Vec<Vec3>,
        q: Vec<Quat>,
        length: f64,
        material: Six,
        reference: [Six; 3],
    }

    /// A strongly bent, twisted, stretched element; fixed numbers, no randomness.
    fn case(order: usize) -> Case {
        let r = (0..=order)
            .map(|a| {
                let s = a as f64 / order as f64;
                Vec3::new(0.3 * s + 0.1 * (3.0 * s).sin(), 0.2 * s * s - 0.05 * s, 1.1 * s - 0.2 * s * s * s)
            })
            .collect();
        let q = (0..=order)
            .map(|a| {
                let s = a as f64 / order as f64;
                exp(&Vec3::new(0.3 - 0.8 * s, 0.5 * s * s, 0.9 * s + 0.2)) * exp(&Vec3::new(0.1, 0.2 * s, -0.3))
            })
            .collect();
        let material = [3.0, 4.0, 50.0, 1.5, 2.5, 0.9];
        let reference =
            [[0.01, -0.02, 1.0, 0.2, 0.1, -0.3], [0.0, 0.05, 1.0, 0.1, 0.0, 0.3], [0.0, 0.0, 1.0, 0.0, 0.3, 0.0]];
        Case { r, q, length: 0.8, material, reference }
    }

    fn nodes_of(case: &Case) -> ElementNodes {
        let mut nodes = ElementNodes::default();
        for a in 0..case.r.len() {
            nodes.r[a] = case.r[a].into();
            nodes.q[a] = to_array(&case.q[a]);
        }
        nodes.align_signs(case.r.len());
        nodes
    }

    fn run(order: usize, case: &Case) -> ElementOutput {
        let mut out = ElementOutput::default();
        let table = Table::new(order);
        evaluate(&table, &nodes_of(case), case.length, &case.material, &case.reference, None, Want::Tangent, &mut out);
        out
    }

    fn moved(case: &Case, dof: usize, step: f64) -> Case {
        let (mut r, mut q) = (case.r.clone(), case.q.clone());
        let (a, k) = (dof / 6, dof % 6);
        if k < 3 {
            r[a][k] += step;
        } else {
            let mut theta = Vec3::zeros();
            theta[k - 3] = step;
            q[a] = exp(&theta) * q[a];
        }
        Case { r, q, length: case.length, material: case.material, reference: case.reference }
    }

    #[test]
    fn residual_is_the_gradient_of_the_energy() {
        for order in 1..=3 {
            let case = case(order);
            let out = run(order, &case);
            for dof in 0..6 * (order + 1) {
                let h = 1e-5;
                let energy = |step: f64| run(order, &moved(&case, dof, step)).energy.iter().sum::<f64>();
                let difference = (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) / (12.0 * h);
                assert!(
                    (difference - out.residual[dof]).abs() < 1e-8,
                    "order {order} dof {dof}: {difference} {}",
                    out.residual[dof]
                );
            }
        }
    }

    #[test]
    fn tangent_is_the_symmetric_second_derivative_of_the_energy_along_the_update() {
        for order in 1..=3 {
            let case = case(order);
            let out = run(order, &case);
            let dofs = 6 * (order + 1);
            let h = 2e-4;
            // second difference of the energy in a combined direction: the update is exp of the summed increments
            let energy = |i: usize, j: usize, a: f64, b: f64| {
                let (ni, nj) = (i / 6, j / 6);
                let both_rotate_one_node = ni == nj && i % 6 >= 3 && j % 6 >= 3;
                if both_rotate_one_node {
                    let mut c = moved(&case, i, 0.0);
                    let mut theta = Vec3::zeros();
                    theta[i % 6 - 3] += a;
                    theta[j % 6 - 3] += b;
                    c.q[ni] = exp(&theta) * c.q[ni];
                    run(order, &c).energy.iter().sum::<f64>()
                } else {
                    run(order, &moved(&moved(&case, i, a), j, b)).energy.iter().sum::<f64>()
                }
            };
            for i in 0..dofs {
                for j in i..dofs {
                    let second = |h: f64| {
                        (energy(i, j, h, h) - energy(i, j, h, -h) - energy(i, j, -h, h) + energy(i, j, -h, -h))
                            / (4.0 * h * h)
                    };
                    let difference = (4.0 * second(h) - second(2.0 * h)) / 3.0;
                    let ours = out.tangent[i][j];
                    assert!(
                        (difference - ours).abs() < 2e-5 * (1.0 + ours.abs()),
                        "order {order} ({i},{j}): {difference} {ours}"
                    );
                }
            }
        }
    }

    #[test]
    fn strains_do_not_change_under_rigid_motion() {
        let case = case(3);
        let before = run(3, &case);
        for angle in [0.4, 2.9, 3.3, 6.0] {
            let rotation = exp(&(Vec3::new(1.0, -2.0, 0.5).normalize() * angle));
            let shift = Vec3::new(3.0, -1.0, 2.0);
            let turned = Case {
                r: case.r.iter().map(|r| rotation * r + shift).collect(),
                q: case.q.iter().map(|q| rotation * q).collect(),
                length: case.length,
                material: case.material,
                reference: case.reference,
            };
            let after = run(3, &turned);
            for g in 0..3 {
                for i in 0..6 {
                    assert!((after.strain[g][i] - before.strain[g][i]).abs() < 1e-13 * 10.0);
                }
            }
            let (e0, e1): (f64, f64) = (before.energy.iter().sum(), after.energy.iter().sum());
            assert!((e0 - e1).abs() < 1e-13 * e0.abs() * 10.0);
        }
    }
}
