//! Strains and stress resultants of elements, by formulas of their own.
//!
//! ```text
//! r = Σ N_a r_a      z = Σ N_a q_a      R = rotation of z/|z|
//! Γ = Rᵀ r′          K = 2 vec(z̄ z′)/|z|²                      n = R C_Γ(ε − ε₀)      m = R C_K(ε − ε₀)
//! ```

use nalgebra::Quaternion;

use crate::math::quadrature::{Rule, gauss};
use crate::math::quaternion::spin;
use crate::math::shape_functions::lagrange;
use crate::math::{Quat, Vec3};
use crate::rod::{Natural, Rod};
use crate::solve::State;

/// Nodes of an element: positions relative to its first one \[L\], quaternions of one sign.
#[derive(Debug, Clone)]
pub(super) struct PlacedNodes {
    /// Indices along the rod.
    pub(super) index: [usize; 4],
    pub(super) r: [Vec3; 4],
    pub(super) q: [Quaternion<f64>; 4],
}

/// An integration point.
#[derive(Debug, Clone, Copy)]
pub(super) struct StrainPoint {
    /// Weight times the element's length \[L\].
    pub(super) weight: f64,
    pub(super) n: [f64; 4],
    /// dN/ds \[1/L\].
    pub(super) dn: [f64; 4],
    pub(super) slope: Vec3,
    pub(super) z: Quaternion<f64>,
    pub(super) dz: Quaternion<f64>,
}

/// Positions and frames of the nodes of one rod.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedRod<'a> {
    pub(super) rod: &'a Rod,
    pub(super) positions: &'a [Vec3],
    /// Rounding errors of the positions; empty if there are none.
    pub(super) remainders: &'a [Vec3],
    pub(super) frames: &'a [Quat],
    /// Turn of the frame at s = L against that at s = 0, rad.
    pub(super) seam: f64,
}

impl<'a> PlacedRod<'a> {
    /// Of a rod whose first node is `first`, in a state.
    pub(super) fn of(state: &'a State, rod: (usize, &'a Rod), first: usize) -> Self {
        let nodes = first..first + rod.1.num_nodes();
        Self {
            rod: rod.1,
            positions: &state.positions()[nodes.clone()],
            remainders: &state.remainders()[nodes.clone()],
            frames: &state.frames()[nodes],
            seam: state.seams()[rod.0],
        }
    }

    pub(super) fn nodes(&self, element: usize) -> PlacedNodes {
        let (order, count) = (self.rod.order, self.positions.len());
        let index: [usize; 4] = std::array::from_fn(|a| (element * order + a.min(order)) % count);
        let lost = |k: usize| self.remainders.get(k).copied().unwrap_or_default();
        let r = index.map(|k| (self.positions[k] - self.positions[index[0]]) + (lost(k) - lost(index[0])));
        let closes = self.rod.closed && element + 1 == self.rod.num_elements;
        let frame = |a: usize| {
            let frame = self.frames[index[a]];
            if closes && a >= order { frame * spin(self.seam) } else { frame }.into_inner()
        };
        let mut q: [Quaternion<f64>; 4] = std::array::from_fn(frame);
        for a in 1..4 {
            if q[a].dot(&q[a - 1]) < 0.0 {
                q[a] = -q[a];
            }
        }
        PlacedNodes { index, r, q }
    }
}

/// Rule by which the elements of a rod are integrated.
pub(super) fn rule(rod: &Rod) -> Rule {
    gauss(rod.order)
}

/// Reference length of an element \[L\].
pub(super) fn element_length(rod: &Rod) -> f64 {
    rod.length / rod.num_elements as f64
}

impl PlacedNodes {
    /// The element at ξ ∈ [0, 1] of its reference length \[L\].
    pub(super) fn at(&self, order: usize, length: f64, xi: f64, weight: f64) -> StrainPoint {
        let (n, slopes) = lagrange(order, xi);
        let dn = slopes.map(|d| d / length);
        let (mut slope, mut z, mut dz) =
            (Vec3::zeros(), Quaternion::from_imag(Vec3::zeros()), Quaternion::from_imag(Vec3::zeros()));
        for a in 0..=order {
            slope += self.r[a] * dn[a];
            z += self.q[a] * n[a];
            dz += self.q[a] * dn[a];
        }
        StrainPoint { weight: weight * length, n, dn, slope, z, dz }
    }
}

impl StrainPoint {
    /// Γ and K.
    pub(super) fn strain(&self) -> [f64; 6] {
        let frame = self.frame();
        let gamma = frame.inverse() * self.slope;
        let kappa = (self.z.conjugate() * self.dz).imag() * (2.0 / self.z.norm_squared());
        [gamma.x, gamma.y, gamma.z, kappa.x, kappa.y, kappa.z]
    }

    pub(super) fn frame(&self) -> Quat {
        Quat::new_normalize(self.z)
    }

    /// Force and moment of a node by a variation δr_a, θ_a of it, of the energy n·(δr′ − φ × r′) + m·φ′ a length, φ the
    /// rotation of the interpolated frame: φ = Σ N_a (c_a θ_a + θ_a × v_a)/|z|² with c_a + v_a = q_a z̄.
    pub(super) fn node_force(&self, a: usize, q: &Quaternion<f64>, force: &Vec3, moment: &Vec3) -> (Vec3, Vec3) {
        let (zz, dzz) = (self.z.norm_squared(), 2.0 * self.z.dot(&self.dz));
        let (here, rate) = (q * self.z.conjugate(), q * self.dz.conjugate());
        // the transpose of θ → c θ + θ × v
        let pull = |by: &Quaternion<f64>, x: &Vec3| x * by.w + by.imag().cross(x);
        let turning = pull(&here, &(moment * (self.dn[a] / zz - self.n[a] * dzz / (zz * zz))))
            + pull(&rate, &(moment * (self.n[a] / zz)));
        let of_force = pull(&here, &(self.slope.cross(force) * (self.n[a] / zz)));
        (force * (self.dn[a] * self.weight), (turning - of_force) * self.weight)
    }
}

/// Natural strains ε₀ and stiffness C of a rod at its integration points.
pub(super) struct MaterialMatrix<'a> {
    rod: &'a Rod,
    /// Frames of the start, and the turn of its seam, of a rod that is stress-free as shaped.
    start: Option<(Vec<Quat>, f64)>,
}

impl<'a> MaterialMatrix<'a> {
    pub(super) fn of(rod: &'a Rod) -> Self {
        let as_shaped = matches!(rod.natural, Natural::AsShaped);
        let start = as_shaped.then(|| {
            let turn = std::f64::consts::TAU * rod.twist_put_in;
            let share = turn / rod.num_segments() as f64;
            let untwisted = rod.frames.iter().enumerate().map(|(k, frame)| frame * spin(-share * k as f64));
            let seam = std::f64::consts::TAU * rod.shape_link;
            (untwisted.collect(), seam)
        });
        Self { rod, start }
    }

    /// n and m of a strain at a point of an element in the rod's own axes, and the elastic part ε − ε₀ of the strain.
    pub(super) fn stress(&self, element: usize, g: usize, strain: &[f64; 6]) -> ([f64; 6], [f64; 6]) {
        let natural = self.natural(element, g);
        let e: [f64; 6] = std::array::from_fn(|k| strain[k] - natural[k]);
        let stress = match &self.rod.stiffness {
            None => {
                let s = &self.rod.section;
                let c = [s.shearing[0], s.shearing[1], s.stretching, s.bending[0], s.bending[1], s.twisting];
                std::array::from_fn(|k| c[k] * e[k])
            }
            Some(along) => {
                let c = self.rod.on_element(along, if along.is_constant() { 0 } else { element })[g];
                std::array::from_fn(|i| (0..6).map(|j| 0.5 * (c[(i, j)] + c[(j, i)]) * e[j]).sum())
            }
        };
        (stress, e)
    }

    fn natural(&self, element: usize, g: usize) -> [f64; 6] {
        let curved = |k: [f64; 3]| [0.0, 0.0, 1.0, k[0], k[1], k[2]];
        match (&self.rod.natural, &self.start) {
            (Natural::Straight, _) => curved([0.0; 3]),
            (Natural::Uniform { kappa }, _) => curved(*kappa),
            (Natural::Varying(along), _) => self.rod.natural_on_element(along, element)[g],
            (Natural::AsShaped, Some((frames, seam))) => {
                let shape =
                    PlacedRod { rod: self.rod, positions: &self.rod.positions, remainders: &[], frames, seam: *seam };
                shape
                    .nodes(element)
                    .at(self.rod.order, element_length(self.rod), rule(self.rod).points[g], 1.0)
                    .strain()
            }
            (Natural::AsShaped, None) => [f64::NAN; 6],
        }
    }
}
