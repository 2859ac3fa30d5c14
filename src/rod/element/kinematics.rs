//! Strains as quadratic forms over |z|², in space and in a plane.
//!
//! In space r' has three components, z is a quaternion and there are six strains. In a plane all frames of an element
//! are one constant frame rotated about the normal: z = w q with a constant q and a complex w = c + is. With r' = x +
//! iy,
//!
//! ```text
//! V = w̄² r' / |w|²  (extension, shear)        K = 2 Im(w̄ w') / |w|²
//! ```

use std::ops::Range;

use super::blocks::{SecondDerivative, Slope};
use super::{InterpolatedPoint, Kinematics};
use crate::math::quaternion::{Q, dot, mul, mul_e1, mul_e2, mul_e3, mul_pure, pure_mul};
use crate::rod::Deformation;

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

impl Kinematics<3, 4, 6> for Space {
    const KIND: [Deformation; 6] = Deformation::OF_STRAINS;
    const ROTATIONS: Range<usize> = 3..6;

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

    fn slopes(p: &InterpolatedPoint<3, 4>) -> [Slope<3, 4>; 6] {
        let mut b = [Slope::ZERO; 6];
        let u = pure_mul(&p.rp, &p.z);
        let w = [mul_e1(&p.z), mul_e2(&p.z), mul_e3(&p.z)];
        let ue = [mul_e1(&u), mul_e2(&u), mul_e3(&u)];
        let ze = [mul_e1(&p.zp), mul_e2(&p.zp), mul_e3(&p.zp)];
        let conj = [p.z[0], -p.z[1], -p.z[2], -p.z[3]];
        for i in 0..3 {
            let director = mul(&w[i], &conj);
            b[i].r.copy_from_slice(&director[1..]);
            b[i].z = ue[i].map(|x| -2.0 * x);
            b[3 + i].z = ze[i].map(|x| -2.0 * x);
            b[3 + i].zp = w[i].map(|x| 2.0 * x);
        }
        b
    }

    fn curvature(p: &InterpolatedPoint<3, 4>, &[s1, s2, n, m1, m2, t]: &[f64; 6]) -> SecondDerivative<3, 4> {
        const UNIT: [Q; 4] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        let mut h = SecondDerivative::ZERO;
        let (force, moment) = ([s1, s2, n], [m1, m2, t]);
        let zn = mul_pure(&p.z, &force);
        for k in 0..3 {
            h.rz[k] = mul(&UNIT[k + 1], &zn).map(|x| -2.0 * x);
        }
        for k in 0..4 {
            let column = mul_pure(&pure_mul(&p.rp, &UNIT[k]), &force);
            for l in 0..4 {
                h.zz[l][k] = -2.0 * column[l];
            }
            h.zzp[k] = mul_pure(&UNIT[k], &moment).map(|x| 2.0 * x);
        }
        h
    }

    #[inline]
    fn rotation(q: &Q, k: usize) -> Q {
        match k {
            0 => [-0.5 * q[1], 0.5 * q[0], -0.5 * q[3], 0.5 * q[2]],
            1 => [-0.5 * q[2], 0.5 * q[3], 0.5 * q[0], -0.5 * q[1]],
            _ => [-0.5 * q[3], -0.5 * q[2], 0.5 * q[1], 0.5 * q[0]],
        }
    }
}

/// Strains: extension, shear, bending.
pub(super) struct InPlane;

impl Kinematics<2, 2, 3> for InPlane {
    const KIND: [Deformation; 3] = [Deformation::Stretching, Deformation::Shearing, Deformation::Bending];
    const ROTATIONS: Range<usize> = 5..6;

    fn strain(p: &InterpolatedPoint<2, 2>) -> [f64; 3] {
        let ([x, y], [c, s], [dc, ds], inv) = (p.rp, p.z, p.zp, 1.0 / p.zz);
        let (cos, sin) = (c * c - s * s, 2.0 * c * s);
        [(cos * x + sin * y) * inv, (cos * y - sin * x) * inv, 2.0 * (c * ds - s * dc) * inv]
    }

    fn slopes(p: &InterpolatedPoint<2, 2>) -> [Slope<2, 2>; 3] {
        let ([x, y], [c, s], [dc, ds]) = (p.rp, p.z, p.zp);
        let (cos, sin) = (c * c - s * s, 2.0 * c * s);
        let (along, across) = (2.0 * (c * x + s * y), 2.0 * (c * y - s * x));
        [
            Slope { r: [cos, sin], z: [along, across], zp: [0.0; 2] },
            Slope { r: [-sin, cos], z: [across, -along], zp: [0.0; 2] },
            Slope { r: [0.0; 2], z: [2.0 * ds, -2.0 * dc], zp: [-2.0 * s, 2.0 * c] },
        ]
    }

    fn curvature(p: &InterpolatedPoint<2, 2>, &[n, t, m]: &[f64; 3]) -> SecondDerivative<2, 2> {
        let ([x, y], [c, s]) = (p.rp, p.z);
        let (a, b) = (2.0 * (c * n - s * t), 2.0 * (s * n + c * t));
        let (push, shift) = (2.0 * (x * n + y * t), 2.0 * (y * n - x * t));
        let m = 2.0 * m;
        SecondDerivative {
            rz: [[a, -b], [b, a]],
            zz: [[push, shift], [shift, -push]],
            zzp: [[0.0, m], [-m, 0.0]],
            ..SecondDerivative::ZERO
        }
    }

    #[inline]
    fn rotation(q: &[f64; 2], _: usize) -> [f64; 2] {
        [-0.5 * q[1], 0.5 * q[0]]
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
