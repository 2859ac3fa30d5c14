//! What the tangent K = ∂²Π/∂x² says at an equilibrium, by a factorisation and a few solves.
//!
//! | | |
//! |---|---|
//! | `modes` | [`Tangent::modes`], [`Tangent::vibrations`]: the softest modes, K v = λ M v |
//! | `masses` | M: the mass of lines and of the tubes about them |
//! | `krylov` | the softest eigenvalues of a pencil: block Lanczos on the inverse |
//!
//! Zero-energy modes (rigid motions of free bodies, spin of round rods, sliding of uniform rings) are no modes here: all
//! that is computed is orthogonal to them.

mod krylov;
mod masses;
mod modes;

pub use modes::{Mode, Modes, Participation};

use crate::error::{InputError, SolveError};
use crate::solve::problem::linearised::Linearised;
use crate::solve::{Engine, RunError, Solver};

/// The factorised tangent at an equilibrium.
#[derive(Debug)]
pub struct Tangent<'a> {
    engine: &'a Engine,
    linearised: Linearised,
}

impl<'a> Tangent<'a> {
    /// The tangent at the present state of a solver, which is to be an equilibrium (nothing is searched for).
    ///
    /// # Errors
    /// `InputError::Inconsistent` where dead moments act in space, because they have no potential and the tangent is not
    /// symmetric; contact geometry that breaks down; a factorisation that does not fit into memory or has a pivot that
    /// vanishes.
    pub fn at(solver: &'a mut Solver) -> Result<Self, RunError> {
        if !solver.engine.is_conservative() {
            let reason = "has moments of fixed direction, which have no potential: its tangent is not symmetric";
            return Err(InputError::inconsistent("loads", reason).into());
        }
        let linearised = Linearised::at(&mut solver.engine, &[], |_, _| Vec::new())?;
        Ok(Self { engine: &solver.engine, linearised })
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
