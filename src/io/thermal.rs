//! The final state of a run at a thermal energy: standard deviations of observables, slopes of its free energy.

use super::comparison::bounds;
use super::final_state::FinalState;
use crate::error::InputError;
use crate::solve::RunError;
use crate::tangent::{ContactResponse, EquilibriumTangent, Observable, PrescribedNumber, ThermalSlope};

/// The final state of a run at a thermal energy. Of pairs the first one is with free contacts, the second one with
/// locked ones; `None` where it is not known.
#[derive(Debug, Clone, PartialEq)]
pub struct ThermalState {
    /// kT \[F·L\].
    pub thermal_energy: f64,
    /// Names of observables, their values, standard deviations.
    pub deviations: Vec<(String, f64, [Option<f64>; 2])>,
    /// Names of parameters, slopes of the free energy.
    pub slopes: Vec<(String, [Option<ThermalSlope>; 2])>,
}

const BOTH: [ContactResponse; 2] = [ContactResponse::Free, ContactResponse::Locked];

impl ThermalState {
    /// Standard deviations of observables, and slopes of the free energy with parameters, by their names, at kT \[F·L\]
    /// (that of the scene's temperature unless given).
    ///
    /// # Errors
    /// Names of observables and parameters that are none; units without a temperature and no kT; what is known neither
    /// with free contacts nor with locked ones, see [`EquilibriumTangent::covariance`],
    /// [`EquilibriumTangent::thermal_slope`].
    pub fn new(
        state: &mut FinalState,
        thermal_energy: Option<f64>,
        (of, to): (&[String], &[String]),
    ) -> Result<Self, RunError> {
        let thermal_energy = state.thermal_energy(thermal_energy)?;
        let (model, solver) = (&state.scene.model, &mut state.solver);
        let observables = of.iter().map(|name| Observable::parse(model, name)).collect::<Result<Vec<_>, _>>()?;
        let parameters = to.iter().map(|name| PrescribedNumber::parse(model, name)).collect::<Result<Vec<_>, _>>()?;
        let mut values = Vec::new();
        let both = BOTH.map(|contacts| -> Result<Vec<f64>, RunError> {
            let mut tangent = EquilibriumTangent::at(solver, contacts)?;
            values = observables.iter().map(|of| tangent.value(of)).collect::<Result<_, InputError>>()?;
            let covariance = tangent.covariance(&observables, thermal_energy)?;
            Ok(covariance.diagonal().iter().map(|variance| variance.sqrt()).collect())
        });
        let [free, locked] = if observables.is_empty() { [None, None] } else { known(both)? };
        let deviation = |all: &Option<Vec<f64>>, k: usize| Some(all.as_ref()?[k]);
        let named = of.iter().zip(values).enumerate();
        let deviations =
            named.map(|(k, (name, value))| (name.clone(), value, [deviation(&free, k), deviation(&locked, k)]));
        let deviations = deviations.collect();
        let mut slopes = Vec::new();
        for (name, parameter) in to.iter().zip(&parameters) {
            let slope = |contacts| EquilibriumTangent::thermal_slope(solver, parameter, (contacts, thermal_energy));
            slopes.push((name.clone(), known(BOTH.map(slope))?));
        }
        Ok(Self { thermal_energy, deviations, slopes })
    }
}

/// What is known of both; an error where that is none.
fn known<T>([free, locked]: [Result<T, RunError>; 2]) -> Result<[Option<T>; 2], RunError> {
    match (free, locked) {
        (Err(_), Err(error)) => Err(error),
        (free, locked) => Ok([free.ok(), locked.ok()]),
    }
}

impl std::fmt::Display for ThermalState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "at kT = {:.6e}", self.thermal_energy)?;
        for (name, value, deviations) in &self.deviations {
            let [free, locked] = deviations.map(|deviation| deviation.map(|deviation| format!("± {deviation:.4e}")));
            write!(f, "\n{name} = {value:.8e} {}", bounds(free, locked))?;
        }
        for (name, slopes) in &self.slopes {
            let shown = |slope: ThermalSlope| format!("{:.8e} ({:.4e} by heat)", slope.total(), slope.by_heat);
            let [free, locked] = slopes.map(|slope| slope.map(shown));
            write!(f, "\nd(free energy)/d({name}) = {}", bounds(free, locked))?;
        }
        Ok(())
    }
}
