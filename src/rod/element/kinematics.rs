//! Strains as quadratic forms over |z|², in space and in a plane.
//!
//! In space r' has three components, z is a quaternion and there are six strains. Where all frames of an element are turned from one by angles about the
//! normal of a plane, z = w q with one constant q and complex w = c + is, which leaves r' = x + iy, w and w' to tell
//!
//! ```text
//! V = w̄² r' / |w|²  (extension, shear)        K = 2 Im(w̄ w') / |w|²
//! ```

use super::Kinematics;
use super::hessian::Curvature;
use crate::math::quaternion::{Q, dot, mul, mul_e1, mul_e2, mul_e3, mul_pure, pure_mul};

/// Nodes that have their frames in the plane to rounding: 1 − |w|² at most, a quarter of the square of the tilt.
const TOL_TILT: f64 = 1e-14;

/// Nodal input of one element: positions and sign-aligned quaternions (four components, or two in a plane); entries beyond order + 1 are ignored.
#[derive(Debug, Clone, Copy)]
pub struct Nodes<const R: usize, const Z: usize> {
    /// Positions \[L\].
    pub r: [[f64; R]; 4],
    /// Quaternions, each in the hemisphere of its predecessor.
    pub q: [[f64; Z]; 4],
}

impl<const R: usize, const Z: usize> Default for Nodes<R, Z> {
    fn default() -> Self {
        Self { r: [[0.0; R]; 4], q: [[0.0; Z]; 4] }
    }
}

impl<const R: usize, const Z: usize> Nodes<R, Z> {
    /// Flips quaternions so that neighbours have a non-negative inner product.
    pub fn align_signs(&mut self, num_nodes: usize) {
        for a in 1..num_nodes {
            if inner(&self.q[a - 1], &self.q[a]) < 0.0 {
                self.q[a] = self.q[a].map(|x| -x);
            }
        }
    }
}

impl<const R: usize, const Z: usize> Nodes<R, Z> {
    /// Adds what a derivative by y at a point is by the first `NODES` nodes.
    #[inline(always)]
    pub(super) fn add<const NODES: usize>(&mut self, by: &Gradient<R, Z>, n: &[f64; 4], d: &[f64; 4]) {
        for a in 0..NODES {
            for k in 0..R {
                self.r[a][k] += d[a] * by.r[k];
            }
            for k in 0..Z {
                self.q[a][k] += n[a] * by.z[k] + d[a] * by.d[k];
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

/// The interpolated numbers y = (r', z, z') at one integration point.
pub(super) struct Point<const R: usize, const Z: usize> {
    pub rp: [f64; R],
    pub z: [f64; Z],
    pub zp: [f64; Z],
    pub zz: f64,
}

impl<const R: usize, const Z: usize> Point<R, Z> {
    /// From shape functions `n` and their slopes by arc length `d` at the first `NODES` nodes.
    #[inline(always)]
    pub(super) fn new<const NODES: usize>(nodes: &Nodes<R, Z>, n: &[f64; 4], d: &[f64; 4]) -> Self {
        let (mut rp, mut z, mut zp) = ([0.0; R], [0.0; Z], [0.0; Z]);
        for a in 0..NODES {
            for k in 0..R {
                rp[k] += d[a] * nodes.r[a][k];
            }
            for k in 0..Z {
                z[k] += n[a] * nodes.q[a][k];
                zp[k] += d[a] * nodes.q[a][k];
            }
        }
        Point { rp, z, zp, zz: inner(&z, &z) }
    }
}

/// First derivatives: of V by r' and z, of K by z and z' (d); the others are zero.
pub(super) struct Slopes<const R: usize, const Z: usize, const T: usize> {
    pub v_r: [[f64; R]; R],
    pub v_z: [[f64; Z]; R],
    pub k_z: [[f64; Z]; T],
    pub k_d: [[f64; Z]; T],
}

/// A derivative by y = (r', z, z').
pub(super) struct Gradient<const R: usize, const Z: usize> {
    pub r: [f64; R],
    pub z: [f64; Z],
    pub d: [f64; Z],
}

impl<const R: usize, const Z: usize, const T: usize> Slopes<R, Z, T> {
    /// Σ over r' or z' of the derivatives by them.
    #[inline(always)]
    pub(super) fn along<const S: usize>(&self, rp: &[f64; R], zp: &[f64; Z]) -> [f64; S] {
        std::array::from_fn(|i| if i < R { inner(&self.v_r[i], rp) } else { inner(&self.k_d[i - R], zp) })
    }

    /// Σ S_i ∇f_i.
    #[inline(always)]
    pub(super) fn gradient<const S: usize>(&self, stress: &[f64; S]) -> Gradient<R, Z> {
        let mut out = Gradient { r: [0.0; R], z: [0.0; Z], d: [0.0; Z] };
        for i in 0..R {
            for k in 0..R {
                out.r[k] += stress[i] * self.v_r[i][k];
            }
            for k in 0..Z {
                out.z[k] += stress[i] * self.v_z[i][k];
            }
        }
        for i in 0..T {
            for k in 0..Z {
                out.z[k] += stress[R + i] * self.k_z[i][k];
                out.d[k] += stress[R + i] * self.k_d[i][k];
            }
        }
        out
    }
}

pub(super) struct Space;

impl Kinematics<3, 4, 6, 3> for Space {
    const KIND: [usize; 6] = [1, 1, 0, 2, 2, 3];

    #[inline(always)]
    fn slopes(p: &Point<3, 4>) -> Slopes<3, 4, 3> {
        let double = |q: Q, factor: f64| q.map(|x| factor * x);
        let u = pure_mul(&p.rp, &p.z);
        let conj = [p.z[0], -p.z[1], -p.z[2], -p.z[3]];
        let director = |w: Q| {
            let [_, x, y, z] = mul(&w, &conj);
            [x, y, z]
        };
        Slopes {
            v_r: [director(mul_e1(&p.z)), director(mul_e2(&p.z)), director(mul_e3(&p.z))],
            v_z: [double(mul_e1(&u), -2.0), double(mul_e2(&u), -2.0), double(mul_e3(&u), -2.0)],
            k_z: [double(mul_e1(&p.zp), -2.0), double(mul_e2(&p.zp), -2.0), double(mul_e3(&p.zp), -2.0)],
            k_d: [double(mul_e1(&p.z), 2.0), double(mul_e2(&p.z), 2.0), double(mul_e3(&p.z), 2.0)],
        }
    }

    #[inline(always)]
    fn forms(p: &Point<3, 4>) -> [f64; 6] {
        let (w, u) = ([mul_e1(&p.z), mul_e2(&p.z), mul_e3(&p.z)], pure_mul(&p.rp, &p.z));
        std::array::from_fn(|i| if i < 3 { dot(&w[i], &u) } else { 2.0 * dot(&w[i - 3], &p.zp) })
    }

    /// Σ F_i P_i = ⟨z F, r' z⟩ and Σ M_i P_i = 2⟨z M, z'⟩ as matrices.
    #[inline(always)]
    fn curvature(p: &Point<3, 4>, stress: &[f64; 6]) -> Curvature<3, 4> {
        let [f1, f2, f3, m1, m2, m3] = stress.map(|s| 2.0 * s);
        let [x, y, z] = p.rp;
        let (a, b, c) = (x * f1, y * f2, z * f3);
        let (ab, ac, bc) = (x * f2 + y * f1, x * f3 + z * f1, y * f3 + z * f2);
        let (i, j, k) = (f2 * z - f3 * y, f3 * x - f1 * z, f1 * y - f2 * x);
        let [w, p, q, r] = mul_pure(&p.z, &[f1, f2, f3]);
        Curvature {
            rz: [[p, -w, r, -q], [q, -r, -w, p], [r, q, -p, -w]],
            zz: [[a + b + c, i, j, k], [i, a - b - c, ab, ac], [j, ab, b - a - c, bc], [k, ac, bc, c - a - b]],
            zd: [[0.0, m1, m2, m3], [-m1, 0.0, -m3, m2], [-m2, m3, 0.0, -m1], [-m3, -m2, m1, 0.0]],
        }
    }

    #[inline(always)]
    fn rotations(q: &Q) -> [[f64; 3]; 4] {
        let [w, x, y, z] = q.map(|component| 0.5 * component);
        [[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]]
    }
}

/// Strains: extension, shear, bending.
pub(super) struct InPlane;

impl Kinematics<2, 2, 3, 1> for InPlane {
    const KIND: [usize; 3] = [0, 1, 2];

    #[inline(always)]
    fn slopes(p: &Point<2, 2>) -> Slopes<2, 2, 1> {
        let ([x, y], [c, s], [dc, ds]) = (p.rp, p.z, p.zp);
        let (cos, sin) = (c * c - s * s, 2.0 * c * s);
        let (along, across) = (2.0 * (c * x + s * y), 2.0 * (c * y - s * x));
        Slopes {
            v_r: [[cos, sin], [-sin, cos]],
            v_z: [[along, across], [across, -along]],
            k_z: [[2.0 * ds, -2.0 * dc]],
            k_d: [[-2.0 * s, 2.0 * c]],
        }
    }

    #[inline(always)]
    fn forms(p: &Point<2, 2>) -> [f64; 3] {
        let ([x, y], [c, s], [dc, ds]) = (p.rp, p.z, p.zp);
        let (cos, sin) = (c * c - s * s, 2.0 * c * s);
        [cos * x + sin * y, cos * y - sin * x, 2.0 * (c * ds - s * dc)]
    }

    #[inline(always)]
    fn curvature(p: &Point<2, 2>, &[n, t, m]: &[f64; 3]) -> Curvature<2, 2> {
        let ([x, y], [c, s]) = (p.rp, p.z);
        let (a, b) = (2.0 * (c * n - s * t), 2.0 * (s * n + c * t));
        let (push, shift) = (2.0 * (x * n + y * t), 2.0 * (y * n - x * t));
        let m = 2.0 * m;
        Curvature { rz: [[a, -b], [b, a]], zz: [[push, shift], [shift, -push]], zd: [[0.0, m], [-m, 0.0]] }
    }

    #[inline(always)]
    fn rotations(q: &[f64; 2]) -> [[f64; 1]; 2] {
        [[-0.5 * q[1]], [0.5 * q[0]]]
    }
}

/// The x-y plane as one rod lies in it: the frame whose tangent is along x, from which its frames are turned about z.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// That frame, and half a turn further: the real and the imaginary unit.
    units: [Q; 2],
    /// Components of y and of z on d1 and d2 of that frame.
    across: [f64; 2],
    normal: [f64; 2],
}

impl Plane {
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

    /// The nodes in the plane, unless one's frame is tilted or spun out of it.
    pub(super) fn nodes(&self, nodes: &Nodes<3, 4>, num_nodes: usize) -> Option<Nodes<2, 2>> {
        let mut flat = Nodes::default();
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

    /// Stiffnesses against extension, shear and bending in the plane. Sections are isotropic or have an axis normal to it.
    pub(super) fn material(&self, material: &[f64; 6]) -> [f64; 3] {
        let weighted = |first: usize, [a, b]: [f64; 2]| material[first] * a * a + material[first + 1] * b * b;
        [material[2], weighted(0, self.across), weighted(3, self.normal)]
    }

    /// The part in the plane of six strains or stresses.
    pub(super) fn part(&self, six: &[f64; 6]) -> [f64; 3] {
        [six[2], inner(&self.across, &[six[0], six[1]]), inner(&self.normal, &[six[3], six[4]])]
    }

    /// Strains or stresses in the plane as six.
    pub(super) fn six(&self, [n, t, m]: &[f64; 3]) -> [f64; 6] {
        [self.across[0] * t, self.across[1] * t, *n, self.normal[0] * m, self.normal[1] * m, 0.0]
    }
}
