//! What is requested of the tangent at the final state: softest modes, parts of the free energy, sensitivities.

use serde::Serialize;

use crate::error::InputError;
use crate::scene::{Model, Scene};
use crate::solve::{RunError, Solver};
use crate::tangent::{ContactResponse, EquilibriumTangent, Harmonic, Modes, Observable, PrescribedNumber};

/// The questions.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    modes: usize,
    /// Masses per length of the rods, if all have one.
    densities: Option<Vec<f64>>,
    free_energy: bool,
    of: Vec<(String, Observable)>,
    to: Vec<(String, Towards)>,
    contacts: ContactResponse,
}

/// What an observable is differentiated with respect to.
#[derive(Debug, Clone)]
enum Towards {
    Number(PrescribedNumber),
    /// Each natural strain of each row of the table of a rod.
    Table(usize),
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
    /// The same with respect to rows of tables.
    pub tables: Vec<TableSensitivity>,
    /// Where derivatives hold on one side only.
    pub notes: Vec<String>,
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

/// Derivatives with respect to the six natural strains of each row of a table, or step of a sequence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableSensitivity {
    /// Name of the observable.
    pub of: String,
    /// Name of the table.
    pub to: String,
    /// Shape (rows, 6).
    pub rows: Vec<[f64; 6]>,
}

impl Towards {
    fn parse(model: &Model, name: &str) -> Result<Self, InputError> {
        match PrescribedNumber::parse_table(model, name)? {
            Some(rod) => Ok(Self::Table(rod)),
            None => Ok(Self::Number(PrescribedNumber::parse(model, name)?)),
        }
    }
}

impl Asked {
    /// What a scene asks for.
    ///
    /// # Errors
    /// Names of observables and parameters that are none.
    pub(super) fn of(scene: &Scene) -> Result<Self, InputError> {
        let output = &scene.output;
        let free_energy = output.free_energy;
        Ok(Self { free_energy, ..Self::new(scene, output.modes, &output.sensitivity_of, &output.sensitivity_to)? })
    }

    /// Modes and sensitivities.
    ///
    /// # Errors
    /// Names of observables and parameters that are none; the one without the other.
    pub fn new(scene: &Scene, modes: usize, of: &[String], to: &[String]) -> Result<Self, InputError> {
        let model = &scene.model;
        let observable = |name: &String| Ok((name.clone(), Observable::parse(model, name)?));
        let parameter = |name: &String| Ok((name.clone(), Towards::parse(model, name)?));
        if of.is_empty() != to.is_empty() {
            let reason = "and sensitivity_to belong together: what is differentiated, and with respect to what";
            return Err(InputError::inconsistent("output.sensitivity_of", reason));
        }
        Ok(Self {
            modes,
            densities: scene.masses(),
            free_energy: false,
            of: of.iter().map(observable).collect::<Result<_, InputError>>()?,
            to: to.iter().map(parameter).collect::<Result<_, InputError>>()?,
            contacts: ContactResponse::of_law(model.contact.law),
        })
    }

    /// The answers at a solver's state.
    ///
    /// # Errors
    /// As those of [`EquilibriumTangent`].
    pub fn answer(&self, solver: &mut Solver) -> Result<Answers, RunError> {
        let mut answers = Answers::default();
        if self.modes > 0 {
            let mut tangent = EquilibriumTangent::at(solver, ContactResponse::ByLaw)?;
            answers.modes = Some(match &self.densities {
                Some(densities) => tangent.vibrations(self.modes, densities)?,
                None => tangent.modes(self.modes)?,
            });
        }
        if self.free_energy {
            answers.harmonic = Some(EquilibriumTangent::both_bounds(solver)?);
        }
        if self.of.is_empty() {
            return Ok(answers);
        }
        let mut tangent = EquilibriumTangent::at(solver, self.contacts)?;
        answers.notes = tangent.one_sided();
        let (mut names, mut numbers, mut tables) = (Vec::new(), Vec::new(), Vec::new());
        for (name, towards) in &self.to {
            match towards {
                Towards::Number(number) => {
                    names.push(name);
                    numbers.push(number.clone());
                }
                Towards::Table(rod) => tables.push((name, *rod)),
            }
        }
        for (of, observable) in &self.of {
            let values = tangent.gradient(observable, &numbers)?;
            let named = names.iter().zip(values).map(|(to, value)| ((*to).clone(), value));
            answers.sensitivities.extend(named.map(|(to, value)| Sensitivity { of: of.clone(), to, value }));
            for (to, rod) in &tables {
                let rows = tangent.gradient_of_table(observable, *rod)?;
                answers.tables.push(TableSensitivity { of: of.clone(), to: (*to).clone(), rows });
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
        for TableSensitivity { of, to, rows } in &self.tables {
            writeln!(f, "d({of})/d({to}): {} rows of 6 in sensitivities.csv", rows.len())?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))
    }
}
