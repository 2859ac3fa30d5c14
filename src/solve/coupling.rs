//! From control points of contact curves to unknowns of nodes.
//!
//! Between nodes a, b: b0 = r_a, b1 = r_a + λ d3_a, b2 = r_b − λ d3_b, b3 = r_b with λ = ℓ/3. With δd3 = θ × d3 and
//! δ²d3 = θ×(θ×d3) for q ← exp(θ/2) q, a force f on d3 gives the moment d3 × f and adds ½(f⊗d3 + d3⊗f) − (f·d3) I to the
//! rotation block.

use crate::contact::detect::Hessian;
use crate::math::{Mat3, Vec3};

/// Tangents and lever of one segment's two nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SegmentFrame {
    pub(crate) tangents: [Vec3; 2],
    pub(crate) lever: f64,
}

/// Gradient of four nodes (slave a, b; master a, b), six each.
pub(crate) type NodalGradient = [f64; 24];
/// Symmetric tangent of four nodes; blocks (node p ≤ node q) filled in full.
pub(crate) type NodalTangent = [[f64; 24]; 24];

fn levers(side: &SegmentFrame) -> [(usize, f64); 4] {
    // control point → (local node, factor on d3)
    [(0, 0.0), (0, side.lever), (1, -side.lever), (1, 0.0)]
}

/// Maps the gradient.
pub(crate) fn nodal_gradient(gradient: &[Vec3; 8], sides: &[SegmentFrame; 2]) -> NodalGradient {
    let mut out = [0.0; 24];
    for (s, side) in sides.iter().enumerate() {
        for (m, (node, lever)) in levers(side).into_iter().enumerate() {
            let force = gradient[4 * s + m];
            let moment = side.tangents[node].cross(&force) * lever;
            let base = 6 * (2 * s + node);
            for k in 0..3 {
                out[base + k] += force[k];
                out[base + 3 + k] += moment[k];
            }
        }
    }
    out
}

/// δx_m = δr + λ θ × d3 = [I, −λ [d3]×] (δr, θ); returns −λ [d3]×.
fn rotation_map(side: &SegmentFrame, node: usize, lever: f64) -> Mat3 {
    side.tangents[node].cross_matrix() * -lever
}

/// Maps Hessian and the gradient's second-order part.
pub(crate) fn nodal_tangent(gradient: &[Vec3; 8], hessian: &Hessian, sides: &[SegmentFrame; 2]) -> Box<NodalTangent> {
    let mut out = Box::new([[0.0; 24]; 24]);
    let maps: [(usize, Mat3, bool); 8] = std::array::from_fn(|m| {
        let side = &sides[m / 4];
        let (node, lever) = levers(side)[m % 4];
        (2 * (m / 4) + node, rotation_map(side, node, lever), lever != 0.0)
    });
    for m in 0..8 {
        for n in 0..8 {
            let block = if m <= n { hessian[m][n] } else { hessian[n][m].transpose() };
            let ((p, jm, turns_m), (q, jn, turns_n)) = (maps[m], maps[n]);
            if p > q {
                continue;
            }
            add(&mut out, 6 * p, 6 * q, &block);
            if turns_n {
                add(&mut out, 6 * p, 6 * q + 3, &(block * jn));
            }
            if turns_m {
                let left = jm.transpose() * block;
                add(&mut out, 6 * p + 3, 6 * q, &left);
                if turns_n {
                    add(&mut out, 6 * p + 3, 6 * q + 3, &(left * jn));
                }
            }
        }
    }
    for (s, side) in sides.iter().enumerate() {
        for (m, (node, lever)) in levers(side).into_iter().enumerate().filter(|(_, (_, lever))| *lever != 0.0) {
            let force = gradient[4 * s + m] * lever;
            let d = side.tangents[node];
            let second = (force * d.transpose() + d * force.transpose()) * 0.5 - Mat3::identity() * force.dot(&d);
            let base = 6 * (2 * s + node) + 3;
            add(&mut out, base, base, &second);
        }
    }
    out
}

fn add(out: &mut NodalTangent, row: usize, col: usize, block: &Mat3) {
    for i in 0..3 {
        for j in 0..3 {
            out[row + i][col + j] += block[(i, j)];
        }
    }
}
