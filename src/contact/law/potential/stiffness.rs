//! The second derivative of a pair's contact potential, summed over quadrature points in the coordinates of the caller.
//!
//! At a point with pressure p, stiffness k and weight W, δd = g·δx and δv = −h·δx/d_vv to first order in the
//! coordinates x, and
//!
//! ```text
//! K += W [(k + p/d) g gᵀ + p/d_vv h hᵀ − p/d Σ w_m w_n δx_m·δx_n]
//! ```
//!
//! Forces on the eight control points (slave's four, then the master's) are carried to the coordinates by the transpose
//! of the map δx ↦ control points, so each point adds two vectors of 24 numbers. The last term is summed over w alone
//! and added at the end.

use crate::contact::curves::curve::Cubic;
use crate::math::handles::{Handles, StretchTerms};
use crate::math::{Mat3, Vec3};

/// Coordinates that move the control points of slave and master, 24 in all.
#[derive(Clone, Copy)]
pub(in crate::contact) enum Coordinates {
    /// The control points themselves.
    Points,
    /// Displacement and rotation vector of the four ends (slave's start and end, then the master's), with the handles
    /// of slave and master.
    Ends([Handles; 2]),
}

/// Hessian with respect to eight control points (slave 0..4, master 4..8): blocks m ≤ n filled.
pub type Hessian = [[Mat3; 8]; 8];

/// Second derivative with respect to 24 coordinates: blocks of six rows p ≤ six columns q filled, those on the diagonal
/// in full.
pub(crate) type PairTangent = [[f64; 24]; 24];

/// Vectors collected before their products are added together, because a sum of products stays in registers.
const PENDING: usize = 10;

impl Coordinates {
    pub(in crate::contact) fn ends(slave: &Cubic, master: &Cubic) -> Self {
        Self::Ends([slave, master].map(|cubic| Handles::of(&cubic.b)))
    }

    /// Forces on the control points as forces on the coordinates.
    #[inline]
    pub(in crate::contact) fn pull(&self, forces: &[Vec3; 8]) -> [f64; 24] {
        let mut out = [0.0; 24];
        let mut put = |k: usize, v: &Vec3| out[k..k + 3].copy_from_slice(v.as_slice());
        match self {
            Self::Points => (0..8).for_each(|m| put(3 * m, &forces[m])),
            Self::Ends(handles) => {
                for (cubic, handles) in handles.iter().enumerate() {
                    let of_cubic = handles.pull(std::array::from_fn(|m| &forces[4 * cubic + m]));
                    out[12 * cubic..12 * cubic + 12].copy_from_slice(&of_cubic);
                }
            }
        }
        out
    }

    /// Σ w_m δx_m as weights of eight vectors: the control points, or motion of each end and of its handle.
    #[inline]
    fn weights(&self, w: &[f64; 8]) -> [f64; 8] {
        match self {
            Self::Points => *w,
            Self::Ends(_) => std::array::from_fn(|m| {
                let (own, held) = points(m / 2);
                if m % 2 == 0 { w[own] + w[held] } else { w[held] }
            }),
        }
    }
}

/// Control points at an end and at the tip of its handle.
fn points(end: usize) -> (usize, usize) {
    [(0, 1), (3, 2), (4, 5), (7, 6)][end]
}

/// The handles of the four ends.
fn of_ends(cubics: &[Handles; 2]) -> [Vec3; 4] {
    let [[a, b], [c, d]] = [cubics[0].of_ends, cubics[1].of_ends];
    [a, b, c, d]
}

/// Sum over the points of a pair, with either segment as the slave.
pub(in crate::contact) struct PairStiffness<'a> {
    coordinates: Coordinates,
    /// Whether forces and weights are given with the second segment of the coordinates as the slave.
    swapped: bool,
    sum: &'a mut PairTangent,
    /// Gradient with respect to the control points.
    forces: [Vec3; 8],
    /// Σ W p/d w_m w_n for m ≤ n.
    spread: [[f64; 8]; 8],
    /// What the stretch of handles adds.
    stretch: StretchTerms<2, 24>,
    pending: [[f64; 24]; PENDING],
    factors: [f64; PENDING],
    count: usize,
}

impl<'a> PairStiffness<'a> {
    /// Starts a sum, which overwrites `sum`.
    pub(in crate::contact) fn new(coordinates: Coordinates, sum: &'a mut PairTangent) -> Self {
        sum.iter_mut().enumerate().for_each(|(row, entries)| entries[row / 6 * 6..].fill(0.0));
        Self {
            coordinates,
            swapped: false,
            sum,
            forces: [Vec3::zeros(); 8],
            spread: [[0.0; 8]; 8],
            stretch: StretchTerms::ZERO,
            pending: [[0.0; 24]; PENDING],
            factors: [0.0; PENDING],
            count: 0,
        }
    }

    /// From now on the slave is the second segment of the coordinates, or the first.
    pub(in crate::contact) fn swap(&mut self, swapped: bool) {
        self.swapped = swapped;
    }

    /// Eight things by control points (slave's four first), in the order of the coordinates.
    #[inline]
    fn ordered<T: Copy>(&self, of_points: &[T; 8]) -> [T; 8] {
        if self.swapped { std::array::from_fn(|m| of_points[(m + 4) % 8]) } else { *of_points }
    }

    /// Adds to the gradient with respect to the control points; handles that turn with the ends add its second-order
    /// part.
    pub(in crate::contact) fn add_gradient(&mut self, gradient: &[Vec3; 8]) {
        let gradient = self.ordered(gradient);
        self.forces.iter_mut().zip(&gradient).for_each(|(sum, force)| *sum += force);
    }

    /// Adds factor × f fᵀ, f the forces on the control points.
    pub(in crate::contact) fn add_product(&mut self, forces: &[Vec3; 8], factor: f64) {
        if self.count == PENDING {
            self.flush();
        }
        self.pending[self.count] = self.coordinates.pull(&self.ordered(forces));
        self.factors[self.count] = factor;
        self.count += 1;
    }

    /// Subtracts factor × the product of Σ w_m δx_m with itself.
    pub(in crate::contact) fn subtract_spread(&mut self, w: &[f64; 8], factor: f64) {
        let w = self.coordinates.weights(&self.ordered(w));
        for m in 0..8 {
            let scaled = factor * w[m];
            for n in 0..8 {
                self.spread[m][n] += scaled * w[n];
            }
        }
    }

    /// Adds a second derivative with respect to the control points, in the order of the coordinates: blocks m ≤ n, each
    /// symmetric.
    pub(in crate::contact) fn add_hessian(&mut self, hessian: &Hessian) {
        let block = |m: usize, n: usize| if m <= n { hessian[m][n] } else { hessian[n][m] };
        let mut add = |row: usize, col: usize, part: &Mat3| {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                self.sum[row + i][col + j] += part[(i, j)];
            }
        };
        match self.coordinates {
            Coordinates::Points => {
                (0..8).flat_map(|m| (m..8).map(move |n| (m, n))).for_each(|(m, n)| add(3 * m, 3 * n, &block(m, n)));
            }
            Coordinates::Ends(cubics) => {
                let handles = of_ends(&cubics);
                for (p, q) in (0..4).flat_map(|p| (p..4).map(move |q| (p, q))) {
                    let ((own, held), (own_q, held_q)) = (points(p), points(q));
                    let (right, left, both) = (block(own, held_q), block(held, own_q), block(held, held_q));
                    let (turn_p, turn_q) = (handles[p].cross_matrix(), handles[q].cross_matrix());
                    add(6 * p, 6 * q, &(block(own, own_q) + right + left + both));
                    add(6 * p, 6 * q + 3, &-((right + both) * turn_q));
                    add(6 * p + 3, 6 * q, &(turn_p * (left + both)));
                    add(6 * p + 3, 6 * q + 3, &-(turn_p * both * turn_q));
                }
                for (p, q) in (0..4).flat_map(|p| (0..4).map(move |q| (p, q))) {
                    let ((_, held), (own_q, held_q)) = (points(p), points(q));
                    let of_held = block(held, held_q).transpose() * handles[p];
                    let of_own = block(held, own_q).transpose() * handles[p];
                    self.stretch.add_motion([p, q], &handles[q], [&(of_own + of_held), &of_held]);
                }
            }
        }
    }

    fn flush(&mut self) {
        for row in 0..24 {
            match row / 6 {
                0 => self.flush_row::<0, 24>(row),
                1 => self.flush_row::<6, 18>(row),
                2 => self.flush_row::<12, 12>(row),
                _ => self.flush_row::<18, 6>(row),
            }
        }
        self.count = 0;
    }

    #[inline]
    fn flush_row<const FIRST: usize, const LEN: usize>(&mut self, row: usize) {
        let mut sum = [0.0; LEN];
        for (vector, factor) in self.pending[..self.count].iter().zip(&self.factors) {
            let scaled = factor * vector[row];
            for (s, v) in sum.iter_mut().zip(&vector[FIRST..FIRST + LEN]) {
                *s += scaled * v;
            }
        }
        for (total, s) in self.sum[row][FIRST..FIRST + LEN].iter_mut().zip(&sum) {
            *total += s;
        }
    }

    /// Completes the sum.
    pub(in crate::contact) fn finish(mut self) {
        self.flush();
        match self.coordinates {
            Coordinates::Points => {
                for (m, n) in (0..8).flat_map(|m| (m..8).map(move |n| (m, n))) {
                    (0..3).for_each(|k| self.sum[3 * m + k][3 * n + k] -= self.spread[m][n]);
                }
            }
            Coordinates::Ends(cubics) => {
                let handles = of_ends(&cubics);
                for (p, q) in (0..4).flat_map(|p| (p..4).map(move |q| (p, q))) {
                    self.subtract_ends(p, q, &handles[p], &handles[q]);
                }
                for (p, q) in (0..4).flat_map(|p| (0..4).map(move |q| (p, q))) {
                    let [moved, turned] = [0, 1].map(|k| handles[p] * -self.spread[2 * p + 1][2 * q + k]);
                    self.stretch.add_motion([p, q], &handles[q], [&moved, &turned]);
                }
                for (end, handle) in handles.iter().enumerate() {
                    let force = self.forces[points(end).1];
                    self.add_turning(end, handle, &force);
                    self.stretch.add_force(end, handle, &force);
                }
                self.stretch.each_entry([&cubics[0], &cubics[1]], |row, col, value| {
                    if row / 6 <= col / 6 {
                        self.sum[row][col] += value;
                    }
                });
            }
        }
    }

    /// The block of two ends: (δr_p A + θ_p × h_p B)·(δr_q C + θ_q × h_q D).
    fn subtract_ends(&mut self, p: usize, q: usize, hp: &Vec3, hq: &Vec3) {
        let s = |i: usize, j: usize| self.spread[2 * p + i][2 * q + j];
        let (both, right, left, turned) = (s(0, 0), s(0, 1), s(1, 0), s(1, 1));
        let (row, col) = (6 * p, 6 * q);
        let (cross_p, cross_q, dot) = (hp.cross_matrix(), hq.cross_matrix(), hp.dot(hq));
        for i in 0..3 {
            self.sum[row + i][col + i] -= both;
            self.sum[row + 3 + i][col + 3 + i] -= turned * dot;
            for j in 0..3 {
                self.sum[row + i][col + 3 + j] += right * cross_q[(i, j)];
                self.sum[row + 3 + i][col + j] -= left * cross_p[(i, j)];
                self.sum[row + 3 + i][col + 3 + j] += turned * hq[i] * hp[j];
            }
        }
    }

    /// A handle h under a force f moves by θ × h + ½θ × (θ × h) + …, which gives ½(f hᵀ + h fᵀ) − (f·h) I.
    fn add_turning(&mut self, end: usize, handle: &Vec3, force: &Vec3) {
        let (first, dot) = (6 * end + 3, force.dot(handle));
        for i in 0..3 {
            self.sum[first + i][first + i] -= dot;
            for j in 0..3 {
                self.sum[first + i][first + j] += 0.5 * (force[i] * handle[j] + handle[i] * force[j]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
