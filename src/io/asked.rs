//! What a scene asks of the tangent at its final state: softest modes, parts of the free energy, sensitivities.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::record::read_summary;
use crate::error::InputError;
use crate::scene::Scene;
use crate::solve::{RunError, Solver};
use crate::tangent::{ContactResponse, EquilibriumTangent, Harmonic, Modes, Observable, PrescribedNumber};

/// The questions of a scene.
#[derive(Debug, Clone, Default)]
pub(super) struct Asked {
    modes: usize,
    free_energy: bool,
    of: Vec<(String, Observable)>,
    to: Vec<(String, PrescribedNumber)>,
    contacts: ContactResponse,
}

/// The answers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answers {
    /// The softest modes, under the contact law in force.
    pub modes: Option<Modes>,
    /// The parts of the harmonic free energy with free and with locked contacts.
    pub harmonic: Option<[Harmonic; 2]>,
    /// Derivatives of each observable with respect to each parameter.
    pub sensitivities: Vec<Sensitivity>,
}

/// A derivative.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Name of the observable.
    pub of: String,
    /// Name of the parameter.
    pub to: String,
    /// d(of)/d(to).
    pub value: f64,
}

impl Asked {
    /// # Errors
    /// Names of observables and parameters that are none.
    pub(super) fn of(scene: &Scene) -> Result<Self, InputError> {
        let (output, model) = (&scene.output, &scene.model);
        let observable = |name: &String| Ok((name.clone(), Observable::parse(model, name)?));
        let parameter = |name: &String| Ok((name.clone(), PrescribedNumber::parse(model, name)?));
        let (of, to) = (&output.sensitivity_of, &output.sensitivity_to);
        if of.is_empty() != to.is_empty() {
            let reason = "and sensitivity_to belong together: what is differentiated, and with respect to what";
            return Err(InputError::inconsistent("output.sensitivity_of", reason));
        }
        Ok(Self {
            modes: output.modes,
            free_energy: output.free_energy,
            of: of.iter().map(observable).collect::<Result<_, InputError>>()?,
            to: to.iter().map(parameter).collect::<Result<_, InputError>>()?,
            contacts: ContactResponse::of_law(model.contact.law),
        })
    }

    /// The answers at a solver's state.
    pub(super) fn answer(&self, solver: &mut Solver) -> Result<Answers, RunError> {
        let mut answers = Answers::default();
        if self.modes > 0 {
            answers.modes = Some(EquilibriumTangent::at(solver, ContactResponse::ByLaw)?.modes(self.modes)?);
        }
        if self.free_energy {
            let mut harmonic = |contacts| Ok::<_, RunError>(EquilibriumTangent::at(solver, contacts)?.harmonic());
            answers.harmonic = Some([harmonic(ContactResponse::Free)?, harmonic(ContactResponse::Locked)?]);
        }
        if !self.of.is_empty() {
            let mut tangent = EquilibriumTangent::at(solver, self.contacts)?;
            let parameters: Vec<PrescribedNumber> = self.to.iter().map(|(_, parameter)| parameter.clone()).collect();
            for (of, observable) in &self.of {
                let values = tangent.gradient(observable, &parameters)?;
                let rows = self.to.iter().zip(values).map(|((to, _), value)| (to.clone(), value));
                answers.sensitivities.extend(rows.map(|(to, value)| Sensitivity { of: of.clone(), to, value }));
            }
        }
        Ok(answers)
    }
}

impl std::fmt::Display for Answers {
    /// A line or more for each answer, none without any.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(modes) = &self.modes {
            writeln!(f, "{modes}")?;
        }
        for Sensitivity { of, to, value } in &self.sensitivities {
            writeln!(f, "d({of})/d({to}) = {value:.8e}")?;
        }
        Ok(())
    }
}

/// The free energy of the final state of a run less that of another one.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeEnergyDifference {
    /// kT \[F·L\].
    pub thermal_energy: f64,
    /// Difference of the potentials \[F·L\].
    pub potential: f64,
    /// Difference of the free energies with contacts free \[F·L\].
    pub free: f64,
    /// The same with contacts locked; `None` where they are lines.
    pub locked: Option<f64>,
}

/// The part of `summary.json`.
#[derive(Deserialize)]
struct HarmonicPart {
    harmonic: Option<[Harmonic; 2]>,
    thermal: Option<ThermalPart>,
}

#[derive(Deserialize)]
struct ThermalPart {
    #[serde(rename = "kT")]
    thermal_energy: f64,
}

/// The free energy of the run in a folder less that of the run in another, at kT \[F·L\] (that of the first run's
/// temperature unless given).
///
/// # Errors
/// Runs that did not finish, or without `free_energy` in their outputs; units without a temperature and no kT; states
/// that cannot be compared ([`Harmonic::relative_to`]).
pub fn free_energy_difference(
    dir: &Path,
    reference: &Path,
    thermal_energy: Option<f64>,
) -> Result<FreeEnergyDifference, InputError> {
    let of = |dir: &Path| -> Result<([Harmonic; 2], Option<f64>), InputError> {
        let summary: HarmonicPart = read_summary(dir)?;
        let reason =
            || "has no parts of a free energy: run its scene with free_energy = true under [output]".to_owned();
        let harmonic = summary.harmonic.ok_or_else(|| InputError::File { path: dir.to_owned(), reason: reason() })?;
        Ok((harmonic, summary.thermal.map(|thermal| thermal.thermal_energy)))
    };
    let ([free, locked], own) = of(dir)?;
    let ([free_there, locked_there], _) = of(reference)?;
    let unknown = || InputError::inconsistent("kT", "is not known, because units are not nm and pN: give it");
    let thermal_energy = thermal_energy.or(own).ok_or_else(unknown)?;
    Ok(FreeEnergyDifference {
        thermal_energy,
        potential: free.potential - free_there.potential,
        free: free.relative_to(&free_there, thermal_energy)?,
        locked: locked.relative_to(&locked_there, thermal_energy).ok(),
    })
}

impl std::fmt::Display for FreeEnergyDifference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kt = self.thermal_energy;
        write!(
            f,
            "in kT = {kt:.6e}: potential {:.4}, free energy {:.4} with free contacts",
            self.potential / kt,
            self.free / kt
        )?;
        match self.locked {
            Some(locked) if locked == self.free => Ok(()),
            Some(locked) => {
                write!(f, ", {:.4} with locked ones", locked / kt)?;
                let apart = (locked - self.free).abs() > kt;
                if apart { write!(f, "\nthe two differ by more than 1 kT: contact matters") } else { Ok(()) }
            }
            None => write!(f, "\ncontact along lines: it is not known with locked contacts"),
        }
    }
}
