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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Quat;
    use crate::math::quaternion::exp;

    const LEVER: f64 = 0.37;

    fn wave(k: usize) -> f64 {
        (1.3 + 2.1 * k as f64).sin()
    }

    fn vector(k: usize) -> Vec3 {
        Vec3::new(wave(3 * k), wave(3 * k + 1), wave(3 * k + 2))
    }

    /// Control points of both cubics from positions and frames of the four nodes.
    fn controls(r: &[Vec3; 4], q: &[Quat; 4]) -> [Vec3; 8] {
        std::array::from_fn(|m| {
            let node = 2 * (m / 4) + usize::from(m % 4 >= 2);
            let lever = [0.0, LEVER, -LEVER, 0.0][m % 4];
            r[node] + (q[node] * Vec3::z()) * lever
        })
    }

    /// A quadratic potential of the control points, U = Σ g·x + ½ Σ xᵀ A x, mapped to the nodes: gradient and every entry of the
    /// tangent, second-order part of the rotations included, against differences along the update.
    #[test]
    fn mapped_gradient_and_tangent_match_finite_differences() {
        let linear: [Vec3; 8] = std::array::from_fn(|m| vector(m) * 3.0);
        let block = |m: usize, n: usize| Mat3::from_fn(|i, j| wave(31 * m + 7 * n + 5 * i + j));
        // filled for m ≤ n, diagonal blocks symmetric, as contact terms are
        let hessian: Hessian = std::array::from_fn(|m| {
            std::array::from_fn(|n| if m == n { block(m, m) + block(m, m).transpose() } else { block(m, n) })
        });
        let full = |m: usize, n: usize| if m <= n { hessian[m][n] } else { hessian[n][m].transpose() };
        let gradient = |x: &[Vec3; 8]| -> [Vec3; 8] {
            std::array::from_fn(|m| linear[m] + (0..8).map(|n| full(m, n) * x[n]).sum::<Vec3>())
        };
        let r: [Vec3; 4] = std::array::from_fn(|a| vector(a + 20));
        let q: [Quat; 4] = std::array::from_fn(|a| exp(&vector(a + 40)));
        let potential = |step: &[f64; 24]| {
            let part = |a: usize, k: usize| Vec3::new(step[6 * a + k], step[6 * a + k + 1], step[6 * a + k + 2]);
            let x = controls(
                &std::array::from_fn(|a| r[a] + part(a, 0)),
                &std::array::from_fn(|a| exp(&part(a, 3)) * q[a]),
            );
            let g = gradient(&x);
            x.iter().zip(&g).zip(&linear).map(|((x, g), l)| 0.5 * x.dot(&(g + l))).sum::<f64>()
        };
        let d3 = |a: usize| q[a] * Vec3::z();
        let sides = [0, 2].map(|a| SegmentFrame { tangents: [d3(a), d3(a + 1)], lever: LEVER });
        let g = gradient(&controls(&r, &q));
        let (mapped, tangent) = (nodal_gradient(&g, &sides), nodal_tangent(&g, &hessian, &sides));
        let along = |i: usize, a: f64, j: usize, b: f64| {
            let mut step = [0.0; 24];
            step[i] += a;
            step[j] += b;
            potential(&step)
        };
        for i in 0..24 {
            let h = 1e-5;
            let slope = (along(i, h, i, 0.0) - along(i, -h, i, 0.0)) / (2.0 * h);
            assert!((slope - mapped[i]).abs() < 1e-7, "{i}: {slope} {}", mapped[i]);
            for j in i..24 {
                let h = 1e-3;
                let second = |h: f64| {
                    (along(i, h, j, h) - along(i, h, j, -h) - along(i, -h, j, h) + along(i, -h, j, -h)) / (4.0 * h * h)
                };
                let difference = (4.0 * second(h) - second(2.0 * h)) / 3.0;
                assert!((difference - tangent[i][j]).abs() < 1e-6, "({i},{j}): {difference} {}", tangent[i][j]);
            }
        }
    }
}
