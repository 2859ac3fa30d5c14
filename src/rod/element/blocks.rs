//! Derivatives with respect to y = (r', z, z') at an integration point, and those with respect to nodal unknowns.

use super::InterpolatedPoint;

/// Shape functions at one integration point of an element.
pub(super) struct ShapeAt {
    /// Values N_a.
    pub(super) n: [f64; 4],
    /// Slopes dN_a/ds \[1/L\].
    pub(super) d: [f64; 4],
    /// Weight of the point times the element's length \[L\].
    pub(super) weight: f64,
    pub(super) num_nodes: usize,
}

/// Derivative by y.
#[derive(Clone, Copy)]
pub(super) struct Slope<const R: usize, const Z: usize> {
    pub(super) r: [f64; R],
    pub(super) z: [f64; Z],
    pub(super) zp: [f64; Z],
}

impl<const R: usize, const Z: usize> Slope<R, Z> {
    pub(super) const ZERO: Self = Self { r: [0.0; R], z: [0.0; Z], zp: [0.0; Z] };

    #[inline]
    pub(super) fn times(&self, x: f64) -> Self {
        Self { r: self.r.map(|d| x * d), z: self.z.map(|d| x * d), zp: self.zp.map(|d| x * d) }
    }

    /// Adds x times another.
    #[inline]
    pub(super) fn add(&mut self, x: f64, other: &Self) {
        for k in 0..R {
            self.r[k] += x * other.r[k];
        }
        for k in 0..Z {
            self.z[k] += x * other.z[k];
            self.zp[k] += x * other.zp[k];
        }
    }

    /// Σ x_i b_i.
    #[inline]
    pub(super) fn sum<const S: usize>(x: &[f64; S], b: &[Self; S]) -> Self {
        let mut sum = Self::ZERO;
        for i in 0..S {
            sum.add(x[i], &b[i]);
        }
        sum
    }

    /// Change of the function for a small change of y.
    #[inline]
    pub(super) fn change(&self, y: &InterpolatedPoint<R, Z>) -> f64 {
        let mut sum = 0.0;
        for k in 0..R {
            sum += self.r[k] * y.rp[k];
        }
        for k in 0..Z {
            sum += self.z[k] * y.z[k] + self.zp[k] * y.zp[k];
        }
        sum
    }
}

/// Second derivative by y; the blocks below the diagonal that no node needs are left out.
pub(super) struct SecondDerivative<const R: usize, const Z: usize> {
    pub(super) rr: [[f64; R]; R],
    pub(super) rz: [[f64; Z]; R],
    pub(super) rzp: [[f64; Z]; R],
    pub(super) zz: [[f64; Z]; Z],
    pub(super) zzp: [[f64; Z]; Z],
    pub(super) zpz: [[f64; Z]; Z],
    pub(super) zpzp: [[f64; Z]; Z],
}

impl<const R: usize, const Z: usize> SecondDerivative<R, Z> {
    pub(super) const ZERO: Self = Self {
        rr: [[0.0; R]; R],
        rz: [[0.0; Z]; R],
        rzp: [[0.0; Z]; R],
        zz: [[0.0; Z]; Z],
        zzp: [[0.0; Z]; Z],
        zpz: [[0.0; Z]; Z],
        zpzp: [[0.0; Z]; Z],
    };

    /// Adds the product a bᵀ of two derivatives.
    #[inline]
    pub(super) fn add_product(&mut self, a: &Slope<R, Z>, b: &Slope<R, Z>) {
        add_outer(&mut self.rr, &a.r, &b.r);
        add_outer(&mut self.rz, &a.r, &b.z);
        add_outer(&mut self.rzp, &a.r, &b.zp);
        add_outer(&mut self.zz, &a.z, &b.z);
        add_outer(&mut self.zzp, &a.z, &b.zp);
        add_outer(&mut self.zpz, &a.zp, &b.z);
        add_outer(&mut self.zpzp, &a.zp, &b.zp);
    }
}

#[inline]
fn add_outer<const A: usize, const B: usize>(sum: &mut [[f64; B]; A], a: &[f64; A], b: &[f64; B]) {
    for k in 0..A {
        for l in 0..B {
            sum[k][l] += a[k] * b[l];
        }
    }
}

/// Derivative by the positions and quaternions of the nodes.
pub(super) struct NodalGradient<const R: usize, const Z: usize> {
    pub(super) r: [[f64; R]; 4],
    pub(super) q: [[f64; Z]; 4],
}

impl<const R: usize, const Z: usize> Default for NodalGradient<R, Z> {
    fn default() -> Self {
        Self { r: [[0.0; R]; 4], q: [[0.0; Z]; 4] }
    }
}

impl<const R: usize, const Z: usize> NodalGradient<R, Z> {
    /// Adds the derivative by y at a point.
    #[inline]
    pub(super) fn add(&mut self, slope: &Slope<R, Z>, &ShapeAt { n, d, weight, num_nodes }: &ShapeAt) {
        for a in 0..num_nodes {
            let (na, da) = (weight * n[a], weight * d[a]);
            for k in 0..R {
                self.r[a][k] += da * slope.r[k];
            }
            for k in 0..Z {
                self.q[a][k] += na * slope.z[k] + da * slope.zp[k];
            }
        }
    }
}

/// ∂²E/∂(r, q)² by pairs of nodes, and ∂E/∂(r, q) of the stresses in its geometric part.
pub(super) struct NodeBlocks<const R: usize, const Z: usize> {
    pub(super) rr: [[[[f64; R]; R]; 4]; 4],
    pub(super) rq: [[[[f64; Z]; R]; 4]; 4],
    pub(super) qq: [[[[f64; Z]; Z]; 4]; 4],
    pub(super) gradient: NodalGradient<R, Z>,
}

impl<const R: usize, const Z: usize> Default for NodeBlocks<R, Z> {
    fn default() -> Self {
        Self {
            rr: [[[[0.0; R]; R]; 4]; 4],
            rq: [[[[0.0; Z]; R]; 4]; 4],
            qq: [[[[0.0; Z]; Z]; 4]; 4],
            gradient: NodalGradient::default(),
        }
    }
}

impl<const R: usize, const Z: usize> NodeBlocks<R, Z> {
    /// Adds the second derivative by y at a point.
    #[inline]
    pub(super) fn add(&mut self, h: &SecondDerivative<R, Z>, &ShapeAt { n, d, weight, num_nodes }: &ShapeAt) {
        for a in 0..num_nodes {
            for c in a..num_nodes {
                let (nn, nd, dn, dd) =
                    (weight * n[a] * n[c], weight * n[a] * d[c], weight * d[a] * n[c], weight * d[a] * d[c]);
                for k in 0..R {
                    for l in 0..R {
                        self.rr[a][c][k][l] += dd * h.rr[k][l];
                    }
                    for l in 0..Z {
                        self.rq[a][c][k][l] += dn * h.rz[k][l] + dd * h.rzp[k][l];
                    }
                }
                for k in 0..Z {
                    for l in 0..Z {
                        self.qq[a][c][k][l] +=
                            nn * h.zz[k][l] + nd * h.zzp[k][l] + dn * h.zpz[k][l] + dd * h.zpzp[k][l];
                    }
                }
                if a != c {
                    let (nd, dd) = (weight * d[c] * n[a], weight * d[c] * d[a]);
                    for k in 0..R {
                        for l in 0..Z {
                            self.rq[c][a][k][l] += nd * h.rz[k][l] + dd * h.rzp[k][l];
                        }
                    }
                }
            }
        }
    }
}
