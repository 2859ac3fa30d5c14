//! Strains as quadratic forms over |z|², in space and in a plane.
//!
//! In space r' has three components, z is a quaternion and there are six strains. In a plane all frames of an element
//! are one constant frame rotated about the normal: z = w q with a constant q and a complex w = c + is. With r' = x +
//! iy,
//!
//! ```text
//! V = w̄² r' / |w|²  (extension, shear)        K = 2 Im(w̄ w') / |w|²
//! ```

use super::{InterpolatedPoint, Kinematics};
use crate::math::quaternion::{Q, dot, mul, mul_e1, mul_e2, mul_e3, mul_pure, pure_mul};

/// Largest 1 − |w|², a quarter of the squared tilt, of a node whose frame is in the plane to rounding.
const TOL_TILT: f64 = 1e-14;

/// Nodal input of one element: positions and sign-aligned quaternions (four components, or two in a plane); entries
/// beyond order + 1 are ignored.
#[derive(Debug, Clone, Copy)]
pub struct NodeValues<const R: usize, const Z: usize> {
    /// Positions \[L\].
    pub r: [[f64; R]; 4],
    /// Quaternions, each in the hemisphere of its predecessor.
    pub q: [[f64; Z]; 4],
}

impl<const R: usize, const Z: usize> Default for NodeValues<R, Z> {
    fn default() -> Self {
        Self { r: [[0.0; R]; 4], q: [[0.0; Z]; 4] }
    }
}

impl<const R: usize, const Z: usize> NodeValues<R, Z> {
    /// Flips quaternions so that neighbours have a non-negative inner product.
    pub fn align_signs(&mut self, num_nodes: usize) {
        for a in 1..num_nodes {
            if inner(&self.q[a - 1], &self.q[a]) < 0.0 {
                self.q[a] = self.q[a].map(|x| -x);
            }
        }
    }
}

/// Inner product.
#[inline]
pub(super) fn inner<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = a[0] * b[0];
    for k in 1..N {
        sum += a[k] * b[k];
    }
    sum
}

pub(super) struct Space;

impl Kinematics<3, 4, 6, 11, 3> for Space {
    const KIND: [usize; 6] = [1, 1, 0, 2, 2, 3];
    const FIRST_ROTATION: usize = 3;

    fn strain(p: &InterpolatedPoint<3, 4>) -> [f64; 6] {
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

    fn slopes(p: &InterpolatedPoint<3, 4>) -> [[f64; 11]; 6] {
        let mut b = [[0.0; 11]; 6];
        let u = pure_mul(&p.rp, &p.z);
        let w = [mul_e1(&p.z), mul_e2(&p.z), mul_e3(&p.z)];
        let ue = [mul_e1(&u), mul_e2(&u), mul_e3(&u)];
        let ze = [mul_e1(&p.zp), mul_e2(&p.zp), mul_e3(&p.zp)];
        let conj = [p.z[0], -p.z[1], -p.z[2], -p.z[3]];
        for i in 0..3 {
            let director = mul(&w[i], &conj);
            b[i][..3].copy_from_slice(&director[1..]);
            for k in 0..4 {
                b[i][3 + k] = -2.0 * ue[i][k];
                b[3 + i][3 + k] = -2.0 * ze[i][k];
                b[3 + i][7 + k] = 2.0 * w[i][k];
            }
        }
        b
    }

    fn curvature(p: &InterpolatedPoint<3, 4>, stress: &[f64; 6]) -> [[f64; 11]; 11] {
        const UNIT: [Q; 4] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let mut h = [[0.0; 11]; 11];
        let force = [stress[0], stress[1], stress[2]];
        let moment = [stress[3], stress[4], stress[5]];
        let zn = mul_pure(&p.z, &force);
        for k in 0..3 {
            let mixed = mul(&UNIT[k + 1], &zn);
            for l in 0..4 {
                h[k][3 + l] = -2.0 * mixed[l];
                h[3 + l][k] = h[k][3 + l];
            }
        }
        for k in 0..4 {
            let column = mul_pure(&pure_mul(&p.rp, &UNIT[k]), &force);
            let row = mul_pure(&UNIT[k], &moment);
            for l in 0..4 {
                h[3 + l][3 + k] = -2.0 * column[l];
                h[3 + k][7 + l] = 2.0 * row[l];
                h[7 + l][3 + k] = h[3 + k][7 + l];
            }
        }
        h
    }

    fn rotations(q: &Q) -> [Q; 3] {
        [
            [-0.5 * q[1], 0.5 * q[0], -0.5 * q[3], 0.5 * q[2]],
            [-0.5 * q[2], 0.5 * q[3], 0.5 * q[0], -0.5 * q[1]],
            [-0.5 * q[3], -0.5 * q[2], 0.5 * q[1], 0.5 * q[0]],
        ]
    }
}

/// Strains: extension, shear, bending.
pub(super) struct InPlane;

impl Kinematics<2, 2, 3, 6, 1> for InPlane {
    const KIND: [usize; 3] = [0, 1, 2];
    const FIRST_ROTATION: usize = 5;

    fn strain(p: &InterpolatedPoint<2, 2>) -> [f64; 3] {
        let ([x, y], [c, s], [dc, ds], inv) = (p.rp, p.z, p.zp, 1.0 / p.zz);
        let (cos, sin) = (c * c - s * s, 2.0 * c * s);
        [(cos * x + sin * y) * inv, (cos * y - sin * x) * inv, 2.0 * (c * ds - s * dc) * inv]
    }

    fn slopes(p: &InterpolatedPoint<2, 2>) -> [[f64; 6]; 3] {
        let ([x, y], [c, s], [dc, ds]) = (p.rp, p.z, p.zp);
        let (cos, sin) = (c * c - s * s, 2.0 * c * s);
        let (along, across) = (2.0 * (c * x + s * y), 2.0 * (c * y - s * x));
        [
            [cos, sin, along, across, 0.0, 0.0],
            [-sin, cos, across, -along, 0.0, 0.0],
            [0.0, 0.0, 2.0 * ds, -2.0 * dc, -2.0 * s, 2.0 * c],
        ]
    }

    fn curvature(p: &InterpolatedPoint<2, 2>, &[n, t, m]: &[f64; 3]) -> [[f64; 6]; 6] {
        let ([x, y], [c, s]) = (p.rp, p.z);
        let (a, b) = (2.0 * (c * n - s * t), 2.0 * (s * n + c * t));
        let (push, shift) = (2.0 * (x * n + y * t), 2.0 * (y * n - x * t));
        let m = 2.0 * m;
        [
            [0.0, 0.0, a, -b, 0.0, 0.0],
            [0.0, 0.0, b, a, 0.0, 0.0],
            [a, b, push, shift, 0.0, m],
            [-b, a, shift, -push, -m, 0.0],
            [0.0, 0.0, 0.0, -m, 0.0, 0.0],
            [0.0, 0.0, m, 0.0, 0.0, 0.0],
        ]
    }

    fn rotations(q: &[f64; 2]) -> [[f64; 2]; 1] {
        [[-0.5 * q[1], 0.5 * q[0]]]
    }
}

/// The x-y plane of one rod: the reference frame with its tangent along x; the rod's frames are this one rotated about
/// z.
#[derive(Debug, Clone, Copy)]
pub struct RodPlane {
    /// The reference frame, and the same rotated by half a turn: the real and the imaginary unit.
    units: [Q; 2],
    /// Components of the axes y and z along d1 and d2 of the reference frame.
    across: [f64; 2],
    normal: [f64; 2],
}

impl RodPlane {
    /// The plane of a rod with the given frame, whose tangent is normal to z.
    pub fn new(frame: &Q) -> Self {
        let conj = [frame[0], -frame[1], -frame[2], -frame[3]];
        let tangent = mul(&mul_e3(frame), &conj);
        let half = -0.5 * tangent[2].atan2(tangent[1]);
        let start = mul(&[half.cos(), 0.0, 0.0, half.sin()], frame);
        let conj = [start[0], -start[1], -start[2], -start[3]];
        let (d1, d2) = (mul(&mul_e1(&start), &conj), mul(&mul_e2(&start), &conj));
        Self { units: [start, pure_mul(&[0.0, 0.0, 1.0], &start)], across: [d1[2], d2[2]], normal: [d1[3], d2[3]] }
    }

    /// The nodes in the plane; `None` if a frame is rotated out of it.
    pub(super) fn nodes(&self, nodes: &NodeValues<3, 4>, num_nodes: usize) -> Option<NodeValues<2, 2>> {
        let mut flat = NodeValues::default();
        for a in 0..num_nodes {
            flat.r[a] = [nodes.r[a][0], nodes.r[a][1]];
            flat.q[a] = self.units.map(|unit| dot(&unit, &nodes.q[a]));
            let length_sq = inner(&flat.q[a], &flat.q[a]);
            if (dot(&nodes.q[a], &nodes.q[a]) - length_sq).abs() > TOL_TILT {
                return None;
            }
        }
        Some(flat)
    }

    /// Stiffnesses against extension, shear and bending in the plane. Sections are isotropic or have an axis normal to
    /// it.
    pub(super) fn material(&self, material: &[f64; 6]) -> [f64; 3] {
        let weighted = |first: usize, [a, b]: [f64; 2]| material[first] * a * a + material[first + 1] * b * b;
        [material[2], weighted(0, self.across), weighted(3, self.normal)]
    }

    /// The components in the plane of six strains or stresses.
    pub(super) fn part(&self, six: &[f64; 6]) -> [f64; 3] {
        [six[2], inner(&self.across, &[six[0], six[1]]), inner(&self.normal, &[six[3], six[4]])]
    }

    /// The six components of strains or stresses in the plane.
    pub(super) fn six(&self, [n, t, m]: &[f64; 3]) -> [f64; 6] {
        [self.across[0] * t, self.across[1] * t, *n, self.normal[0] * m, self.normal[1] * m, 0.0]
    }
}
