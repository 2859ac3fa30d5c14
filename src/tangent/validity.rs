//! How far harmonic terms hold: the energy along the softest modes against the quadratic one.
//!
//! A mode v is followed along the parabola x + t v + ½ t² w, K w = −∂²r/∂t², on which stiff strains (stretch, shear)
//! stay as they are to second order. Where kT/2 would take it, ½ t² vᵀKv = kT/2, the potential is compared with kT/2.
//! Contacts that open or close on the way show, as saddles do. What stretch and shear store there is taken from a short
//! way along the parabola: the strains of higher order that it has farther on are its own, not those of a rod that
//! fluctuates, and the energy of a rod of DNA of 200 base pairs in them is a hundred kT.

use super::EquilibriumTangent;
use crate::error::InputError;
use crate::solve::problem::assembly::Potential;
use crate::solve::problem::linearised::dot;
use crate::solve::{RunError, State};

/// Deviation from the quadratic energy beyond which harmonic terms are void: a Gaussian integral is then off by the
/// same order, half a kT a mode.
pub const VOID: f64 = 0.5;
/// Step of second differences of the residual, over the mode's largest rotation (rad): half the digits.
const STEP: f64 = 1e-4;

/// Part of the way to the amplitude over which stretch and shear are followed, because what the parabola strains them
/// by is of third order, and rounding is divided by its square.
const SHORT_WAY: f64 = 0.05;

/// Changes of the potential \[F·L\]: without what stretch and shear store, and of that.
fn changes_of(there: &Potential, here: &Potential) -> [f64; 2] {
    let soft = there.without_stretch_and_shear() - here.without_stretch_and_shear();
    [soft, there.total() - here.total() - soft]
}

impl EquilibriumTangent<'_> {
    /// Of each of the `count` softest modes, |ΔΠ/(kT/2) − 1| at the amplitude of kT/2, the larger one of both sides.
    /// Above [`VOID`] harmonic terms mean nothing: free energies, covariances.
    ///
    /// # Errors
    /// An unstable state; as [`EquilibriumTangent::modes`]; contact geometry that breaks down.
    pub fn anharmonicity(&mut self, count: usize, thermal_energy: f64) -> Result<Vec<f64>, RunError> {
        InputError::positive("thermal_energy", thermal_energy)?;
        if self.num_unstable() > 0 {
            return Err(InputError::inconsistent("state", "is unstable: nothing fluctuates about it").into());
        }
        let modes = self.modes(count)?;
        let state = self.engine.state().clone();
        let here = self.engine.potential_at(&state)?;
        let mut all = Vec::new();
        for mode in &modes.modes {
            let both = mode.displacements.iter().zip(&mode.rotations);
            let shape: Vec<f64> = both.flat_map(|(d, r)| [d.x, d.y, d.z, r.x, r.y, r.z]).collect();
            let stiffness = mode.eigenvalue * self.total_mass();
            let amplitude = (thermal_energy / stiffness).sqrt();
            let bend = self.bend_of(&state, &shape);
            let mut changes = |part: f64| {
                let t = part * amplitude;
                let way: Vec<f64> = shape.iter().zip(&bend).map(|(v, w)| t * v + 0.5 * t * t * w).collect();
                let there = self.engine.retract(&state, &way, 1.0);
                self.engine.potential_at(&there).map(|there| changes_of(&there, &here))
            };
            let [[_, ahead], [_, behind]] = [changes(SHORT_WAY)?, changes(-SHORT_WAY)?];
            let [odd, even] = [ahead - behind, ahead + behind].map(|sum| 0.5 * sum);
            let mut worst = 0.0_f64;
            for side in [1.0, -1.0] {
                let [soft, _] = changes(side)?;
                let change = soft + side * odd / SHORT_WAY + even / (SHORT_WAY * SHORT_WAY);
                worst = worst.max((change / (0.5 * thermal_energy) - 1.0).abs());
            }
            all.push(worst);
        }
        self.engine.update_contact(&state)?;
        Ok(all)
    }

    /// vᵀMv of modes.
    fn total_mass(&self) -> f64 {
        self.engine.model().rods.iter().map(|rod| rod.length).sum()
    }

    /// w: the response to the change of the residual of second order along a shape.
    fn bend_of(&mut self, state: &State, shape: &[f64]) -> Vec<f64> {
        let lever = self.engine.scales.lever;
        let size = |(i, x): (usize, &f64)| if i % 6 < 3 { x.abs() / lever } else { x.abs() };
        let step = STEP / shape.iter().enumerate().map(size).fold(f64::MIN_POSITIVE, f64::max);
        let mut at = |t: f64| {
            let there = self.engine.retract(state, shape, t);
            self.engine.residual_without_contact(&there).gradient
        };
        let [before, here, after] = [-step, 0.0, step].map(&mut at);
        let forces: Vec<f64> =
            (0..here.len()).map(|i| -(after[i] + before[i] - 2.0 * here[i]) / (step * step)).collect();
        let mut bend = self.linearised.solve(self.engine, &forces);
        // rigid motions of the second order cost nothing
        for motion in &self.linearised.zero_energy {
            let part = dot(motion, &bend) / dot(motion, motion);
            bend.iter_mut().zip(motion).for_each(|(x, v)| *x -= part * v);
        }
        bend
    }
}
