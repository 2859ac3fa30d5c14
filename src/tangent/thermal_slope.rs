//! Slopes of free energies: what is extended, and what is borne, at a thermal energy.
//!
//! ```text
//! dF/dp = dΠ/dp + ½ kT d ln det K/dp
//! ```
//!
//! −dF/dT is the extension under a tension T, with its thermal shortening; dF/dn over n turns is 2π × the torque, with
//! the softening by fluctuations. Both are differences of the equilibria beside the present one.

use super::{ContactResponse, EquilibriumTangent, Harmonic, PrescribedNumber};
use crate::error::InputError;
use crate::solve::{RunError, Solver, State, Status};

/// Step of differences of loads, over all of them, and of pressures and displacements, over their scales: with it the
/// error of second order is 1e-6, and that of the equilibria, 1e-9, is as small.
const STEP: f64 = 1e-3;

/// The slope of a free energy with a parameter, \[F·L\] over the parameter's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalSlope {
    /// dΠ/dp.
    pub of_potential: f64,
    /// What heat adds to it.
    pub by_heat: f64,
}

impl ThermalSlope {
    /// dF/dp.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.of_potential + self.by_heat
    }
}

impl EquilibriumTangent<'_> {
    /// dF/dp at a solver's state, contacts as chosen, at a thermal energy kT \[F·L\]. The solver is left in this state.
    ///
    /// # Errors
    /// A parameter that the model does not have; equilibria beside the state that are not found; as
    /// [`Harmonic::free_energy`].
    pub fn thermal_slope(
        solver: &mut Solver,
        parameter: &PrescribedNumber,
        (contacts, thermal_energy): (ContactResponse, f64),
    ) -> Result<ThermalSlope, RunError> {
        parameter.check(&solver.engine)?;
        // with the present number, so that the model gets it back
        let here = parameter.changed(&solver.engine, 0.0);
        let step = step(solver, parameter);
        let states = [step, -step].map(|by| {
            let there = parameter.changed(&solver.engine, by);
            let Some((node, displacement, rotation)) = parameter.motion(&solver.engine) else { return there };
            let mut way = vec![0.0; 6 * solver.engine.num_nodes()];
            way[6 * node..6 * node + 3].copy_from_slice(displacement.as_slice());
            way[6 * node + 3..6 * node + 6].copy_from_slice(rotation.as_slice());
            solver.engine.retract(&there, &way, by)
        });
        let beside = states.map(|there| harmonic_at(solver, there, contacts));
        settle(solver, here)?;
        let [after, before] = beside;
        let (after, before) = (after?, before?);
        let of_potential = (after.potential - before.potential) / (2.0 * step);
        let total = after.relative_to(&before, thermal_energy)? / (2.0 * step);
        Ok(ThermalSlope { of_potential, by_heat: total - of_potential })
    }
}

fn step(solver: &Solver, parameter: &PrescribedNumber) -> f64 {
    match parameter {
        PrescribedNumber::Load => STEP,
        PrescribedNumber::Pressure { .. } => STEP * parameter.step(&solver.engine, None),
        PrescribedNumber::Displacement { .. } => STEP * solver.engine.scales.lever,
        _ => parameter.step(&solver.engine, None),
    }
}

/// Lets a state come to its equilibrium.
fn settle(solver: &mut Solver, state: State) -> Result<(), RunError> {
    solver.set_state(state)?;
    let status = solver.resettle().status;
    if status == Status::Converged {
        return Ok(());
    }
    let reason = format!("has no equilibrium beside it by which its free energy has a slope: {status}");
    Err(InputError::inconsistent("state", reason).into())
}

fn harmonic_at(solver: &mut Solver, state: State, contacts: ContactResponse) -> Result<Harmonic, RunError> {
    settle(solver, state)?;
    Ok(EquilibriumTangent::at(solver, contacts)?.harmonic())
}
