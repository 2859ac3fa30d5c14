//! Second derivatives of an element's energy: by y = (r', z, z') at the integration points, then by the unknowns of pairs of nodes.
//!
//! With A = ∂²(energy density)/∂y² in blocks and r' = Σ N_a' r_a, z = Σ N_a q_a, z' = Σ N_a' q_a, the block of nodes a and c is
//!
//! ```text
//! r_a r_c   Σ_g w N_a' N_c' A_rr
//! r_a q_c   Σ_g w N_a' N_c  A_rz
//! q_a q_c   Σ_g w (N_a N_c A_zz + N_a N_c' A_zz' + N_a' N_c A_z'z + N_a' N_c' A_z'z')
//! ```
//!
//! because V does not depend on z' nor K on r', which leaves A_rz' = 0; the quaternions then give way to rotations, δq = Σ ½ θ_k e_k q.

use super::kinematics::{Point, Slopes, inner};
use super::{ElementTangent, Kinematics};

/// A at one integration point, times its weight. Rows and columns as the name says; d stands for z'.
#[derive(Clone, Copy)]
pub(super) struct Hessian<const R: usize, const Z: usize> {
    rr: [[f64; R]; R],
    rz: [[f64; Z]; R],
    zz: [[f64; Z]; Z],
    zd: [[f64; Z]; Z],
    dz: [[f64; Z]; Z],
    dd: [[f64; Z]; Z],
}

impl<const R: usize, const Z: usize> Default for Hessian<R, Z> {
    fn default() -> Self {
        let square = [[0.0; Z]; Z];
        Self { rr: [[0.0; R]; R], rz: [[0.0; Z]; R], zz: square, zd: square, dz: square, dd: square }
    }
}

/// Second derivatives of Σ S_i P_i, the quadratic forms that strains are ratios of; those that are not here are zero.
pub(super) struct Curvature<const R: usize, const Z: usize> {
    pub rz: [[f64; Z]; R],
    pub zz: [[f64; Z]; Z],
    pub zd: [[f64; Z]; Z],
}

impl<const R: usize, const Z: usize> Hessian<R, Z> {
    /// Σ_i S_i ∇²f_i + Σ_i C_i ∇f_i ⊗ ∇f_i with slopes ∇f_i, strains f_i, stresses S_i and stiffnesses C_i.
    #[inline(always)]
    pub(super) fn new<const S: usize, const T: usize, K: Kinematics<R, Z, S, T>>(
        p: &Point<R, Z>,
        slopes: &Slopes<R, Z, T>,
        strain: &[f64; S],
        stress: &[f64; S],
        stiffness: &[f64; S],
    ) -> Self {
        let inv = 1.0 / p.zz;
        let Curvature { rz, zz, zd } = K::curvature(p, &stress.map(|s| s * inv));
        let mut a = Self { rz, zz, zd, ..Self::default() };
        let force = slopes.gradient(stress);
        let shift = p.z.map(|x| 2.0 * inv * x);
        let work = 2.0 * inv * inner(stress, strain);
        for k in 0..Z {
            for l in 0..Z {
                a.zz[k][l] -= force.z[k] * shift[l] + shift[k] * force.z[l];
                a.zd[k][l] -= shift[k] * force.d[l];
            }
            a.zz[k][k] -= work;
        }
        for i in 0..R {
            let (c, by_r, by_z) = (stiffness[i], &slopes.v_r[i], &slopes.v_z[i]);
            for k in 0..R {
                let scaled = c * by_r[k];
                add(&mut a.rr[k], scaled, by_r);
                add(&mut a.rz[k], scaled, by_z);
            }
            for k in 0..Z {
                add(&mut a.zz[k], c * by_z[k], by_z);
            }
        }
        for k in 0..R {
            add(&mut a.rz[k], -force.r[k], &shift);
        }
        for i in 0..T {
            let (c, by_z, by_d) = (stiffness[R + i], &slopes.k_z[i], &slopes.k_d[i]);
            for k in 0..Z {
                let scaled = c * by_z[k];
                add(&mut a.zz[k], scaled, by_z);
                add(&mut a.zd[k], scaled, by_d);
                add(&mut a.dd[k], c * by_d[k], by_d);
            }
        }
        a.dz = std::array::from_fn(|k| std::array::from_fn(|l| a.zd[l][k]));
        a
    }
}

/// Writes the block of nodes a ≤ c of an element of `NODES` nodes into its tangent, from the second derivatives at the points, shape functions `n` and
/// their slopes by arc length `d` there, and the `ways` in which the quaternions of the two nodes move when they turn.
#[inline(always)]
pub(super) fn write<const R: usize, const Z: usize, const T: usize, const NODES: usize>(
    hessians: &[Hessian<R, Z>; 3],
    n: &[[f64; 4]; 3],
    d: &[[f64; 4]; 3],
    [a, c]: [usize; 2],
    ways: [&[[f64; T]; Z]; 2],
    tangent: &mut ElementTangent,
) {
    let (row, column) = (6 * a, 6 * c);
    let (turn_a, turn_c) = (row + 6 - T, column + 6 - T);
    for k in 0..R {
        let (mut rr, mut rq, mut qr) = ([0.0; R], [0.0; Z], [0.0; Z]);
        for g in 0..NODES - 1 {
            add(&mut rr, d[g][a] * d[g][c], &hessians[g].rr[k]);
            add(&mut rq, d[g][a] * n[g][c], &hessians[g].rz[k]);
            add(&mut qr, n[g][a] * d[g][c], &hessians[g].rz[k]);
        }
        tangent[row + k][column..column + R].copy_from_slice(&rr);
        tangent[row + k][turn_c..turn_c + T].copy_from_slice(&turned(&rq, ways[1]));
        for (l, value) in turned(&qr, ways[0]).into_iter().enumerate() {
            tangent[turn_a + l][column + k] = value;
        }
    }
    let mut half = [[0.0; Z]; T];
    for m in 0..Z {
        let mut qq = [0.0; Z];
        for g in 0..NODES - 1 {
            add(&mut qq, n[g][a] * n[g][c], &hessians[g].zz[m]);
            add(&mut qq, n[g][a] * d[g][c], &hessians[g].zd[m]);
            add(&mut qq, d[g][a] * n[g][c], &hessians[g].dz[m]);
            add(&mut qq, d[g][a] * d[g][c], &hessians[g].dd[m]);
        }
        for k in 0..T {
            add(&mut half[k], ways[0][m][k], &qq);
        }
    }
    for k in 0..T {
        tangent[turn_a + k][turn_c..turn_c + T].copy_from_slice(&turned(&half[k], ways[1]));
    }
}

/// A derivative by a quaternion as one by rotations.
#[inline(always)]
pub(super) fn turned<const Z: usize, const T: usize>(by: &[f64; Z], ways: &[[f64; T]; Z]) -> [f64; T] {
    let mut out = ways[0].map(|way| by[0] * way);
    for m in 1..Z {
        add(&mut out, by[m], &ways[m]);
    }
    out
}

/// sum += factor · row.
#[inline(always)]
fn add<const N: usize>(sum: &mut [f64; N], factor: f64, row: &[f64; N]) {
    for k in 0..N {
        sum[k] += factor * row[k];
    }
}
