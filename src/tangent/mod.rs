//! What the tangent K = ∂²Π/∂x² says at an equilibrium, by a factorisation and a few solves.
//!
//! | | |
//! |---|---|
//! | `modes` | [`EquilibriumTangent::modes`], [`EquilibriumTangent::vibrations`]: the softest modes, K v = λ M v |
//! | `contact` | [`ContactResponse`]: contact as the law in force has it, locked, or free |
//! | `masses` | M: the mass of lines and of the tubes about them |
//! | `free_energy` | [`EquilibriumTangent::harmonic`], [`EquilibriumTangent::covariance`]: the Gaussian integral about the equilibrium |
//! | `observables` | [`Observable`]: numbers of a state and their gradients |
//! | `sensitivity` | [`EquilibriumTangent::gradient`]: their derivatives with respect to what is prescribed, [`PrescribedNumber`] |
//! | `tables` | [`EquilibriumTangent::gradient_of_table`]: the same with respect to each row of a table, each step of a sequence |
//! | `thermal_slope` | [`EquilibriumTangent::thermal_slope`]: slopes of free energies: extension, torque at a thermal energy |
//! | `validity` | [`EquilibriumTangent::anharmonicity`]: how far harmonic terms hold |
//! | `krylov` | the softest eigenvalues of a pencil: block Lanczos on the inverse |
//!
//! Zero-energy modes (rigid motions of free bodies, spin of round rods, sliding of uniform rings) are no modes here:
//! all that is computed is orthogonal to them.

mod contact;
mod free_energy;
mod krylov;
mod masses;
mod modes;
mod observables;
mod sensitivity;
mod tables;
mod thermal_slope;
mod validity;

pub use contact::ContactResponse;
pub use free_energy::{Harmonic, ZeroMode};
pub use modes::{Mode, Modes, Participation};
pub use observables::Observable;
pub use sensitivity::PrescribedNumber;
pub use thermal_slope::ThermalSlope;
pub use validity::VOID;

use contact::{ClosedPoint, GapRate, Touching};
use sensitivity::ClosedResponses;

use crate::error::{InputError, SolveError};
use crate::scene::Model;
use crate::solve::problem::linearised::Linearised;
use crate::solve::{Engine, RunError, Solver};

/// The factorised tangent at an equilibrium.
#[derive(Debug)]
pub struct EquilibriumTangent<'a> {
    engine: &'a mut Engine,
    linearised: Linearised,
    contacts: Vec<Touching>,
    rates: Vec<Vec<GapRate>>,
    choice: ContactResponse,
    /// Points of contact that stay closed, of [`ContactResponse::Locked`].
    closed: Vec<ClosedPoint>,
    responses: Option<ClosedResponses>,
}

impl<'a> EquilibriumTangent<'a> {
    /// The tangent at the present state of a solver, which is to be an equilibrium (nothing is searched for).
    ///
    /// # Errors
    /// `InputError::Inconsistent` where dead moments act in space, because they have no potential and the tangent is
    /// not symmetric; contact geometry that breaks down; a factorisation that does not fit into memory or has a pivot
    /// that vanishes.
    pub fn at(solver: &'a mut Solver, choice: ContactResponse) -> Result<Self, RunError> {
        if !solver.engine.is_conservative() {
            let reason = "has moments of fixed direction, which have no potential: its tangent is not symmetric";
            return Err(InputError::inconsistent("loads", reason).into());
        }
        let engine = &mut solver.engine;
        let state = engine.state().clone();
        engine.update_contact(&state)?;
        let zones = engine.residual(&state);
        let contacts = contact::contacts(engine, &zones);
        let coupled = if choice == ContactResponse::ByLaw { Vec::new() } else { contact::coupled(engine, &contacts) };
        let mut rates = Vec::new();
        let linearised = Linearised::at(engine, &coupled, |engine, residual| {
            rates = contact::gap_rates(engine, &contacts, residual);
            let changes = contact::changes(choice, &contacts, &rates);
            changes.into_iter().map(|change| (change.rate, change.stiffness)).collect()
        })?;
        let closed = match choice {
            ContactResponse::Locked => contact::closed_points(engine, &contacts, &rates, &zones),
            ContactResponse::ByLaw | ContactResponse::Free => Vec::new(),
        };
        Ok(Self { engine, linearised, contacts, rates, choice, closed, responses: None })
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model {
        self.engine.model()
    }

    /// Unstable directions: negative eigenvalues of the tangent.
    #[must_use]
    pub fn num_unstable(&self) -> usize {
        self.linearised.num_negative
    }

    /// Zero-energy modes that were left out.
    #[must_use]
    pub fn num_zero_energy(&self) -> usize {
        self.linearised.zero_energy.len()
    }
}

/// Why modes could not be found.
pub(crate) fn not_found(iterations: usize) -> SolveError {
    SolveError::Eigenvalues { iterations }
}
