//! Derivatives with respect to nodal unknowns, from those at integration points.

use super::ElementTangent;
use super::kinematics::inner;

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

/// Adds a gradient with respect to y = (r', z, z') at a point to the gradient with respect to nodal positions and
/// quaternions.
pub(super) fn add_nodal_gradient<const R: usize, const Z: usize, const N: usize>(
    grad: &[f64; N],
    &ShapeAt { n, d, weight, num_nodes }: &ShapeAt,
    grad_r: &mut [[f64; R]; 4],
    grad_q: &mut [[f64; Z]; 4],
) {
    for a in 0..num_nodes {
        let (na, da) = (weight * n[a], weight * d[a]);
        for k in 0..R {
            grad_r[a][k] += da * grad[k];
        }
        for k in 0..Z {
            grad_q[a][k] += na * grad[R + k] + da * grad[R + Z + k];
        }
    }
}

/// ∂²E/∂(r, q)² by pairs of nodes, and ∂E/∂q of the stresses in its geometric part.
pub(super) struct NodeBlocks<const R: usize, const Z: usize> {
    rr: [[[[f64; R]; R]; 4]; 4],
    rq: [[[[f64; Z]; R]; 4]; 4],
    qq: [[[[f64; Z]; Z]; 4]; 4],
    pub(super) grad_q: [[f64; Z]; 4],
}

impl<const R: usize, const Z: usize> Default for NodeBlocks<R, Z> {
    fn default() -> Self {
        Self {
            rr: [[[[0.0; R]; R]; 4]; 4],
            rq: [[[[0.0; Z]; R]; 4]; 4],
            qq: [[[[0.0; Z]; Z]; 4]; 4],
            grad_q: [[0.0; Z]; 4],
        }
    }
}

impl<const R: usize, const Z: usize> NodeBlocks<R, Z> {
    /// Adds the second derivative with respect to y at a point.
    #[inline]
    pub(super) fn add<const N: usize>(&mut self, h: &[[f64; N]; N], &ShapeAt { n, d, weight, num_nodes }: &ShapeAt) {
        for a in 0..num_nodes {
            for c in a..num_nodes {
                let (nn, nd, dn, dd) =
                    (weight * n[a] * n[c], weight * n[a] * d[c], weight * d[a] * n[c], weight * d[a] * d[c]);
                for k in 0..R {
                    for l in 0..R {
                        self.rr[a][c][k][l] += dd * h[k][l];
                    }
                    for l in 0..Z {
                        self.rq[a][c][k][l] += dn * h[k][R + l] + dd * h[k][R + Z + l];
                    }
                }
                for k in 0..Z {
                    for l in 0..Z {
                        self.qq[a][c][k][l] += nn * h[R + k][R + l]
                            + nd * h[R + k][R + Z + l]
                            + dn * h[R + Z + k][R + l]
                            + dd * h[R + Z + k][R + Z + l];
                    }
                }
                if a != c {
                    let (nd, dd) = (weight * d[c] * n[a], weight * d[c] * d[a]);
                    for k in 0..R {
                        for l in 0..Z {
                            self.rq[c][a][k][l] += nd * h[k][R + l] + dd * h[k][R + Z + l];
                        }
                    }
                }
            }
        }
    }

    /// Transforms the blocks of nodes a ≤ c to the unknowns (δr, θ).
    pub(super) fn write<const T: usize>(
        &self,
        tangent: &mut ElementTangent,
        [a, c]: [usize; 2],
        first_rotation: usize,
        ways: &[[[f64; Z]; T]; 4],
    ) {
        let (row, col) = (6 * a, 6 * c);
        for k in 0..R {
            for l in 0..R {
                tangent[row + k][col + l] = self.rr[a][c][k][l];
            }
            for l in 0..T {
                tangent[row + k][col + first_rotation + l] = inner(&self.rq[a][c][k], &ways[c][l]);
                tangent[row + first_rotation + l][col + k] = inner(&self.rq[c][a][k], &ways[a][l]);
            }
        }
        for k in 0..T {
            let mut product = [0.0; Z];
            for m in 0..Z {
                for l in 0..Z {
                    product[l] += ways[a][k][m] * self.qq[a][c][m][l];
                }
            }
            for l in 0..T {
                tangent[row + first_rotation + k][col + first_rotation + l] = inner(&product, &ways[c][l]);
            }
        }
    }
}
