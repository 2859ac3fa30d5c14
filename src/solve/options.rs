//! Choices of a run.

use crate::error::InputError;
use crate::scene::Fidelity;
use crate::solve::search::newton::NewtonOptions;

/// Choices of a run; the defaults suit DNA loops and cables alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Newton's choices.
    pub newton: NewtonOptions,
    /// Leave unstable equilibria along their most negative direction.
    pub leave_unstable: bool,
    /// Size of the step off an unstable equilibrium: largest rotation, rad. Legal: 0 < x ≤ 1.
    pub escape_step: f64,
    /// Unstable equilibria that a search may leave in a row while hardly any energy is set free (less than 1e-2 of what
    /// is stored).
    pub max_escapes: usize,
    /// Augmentations of the contact offsets allowed per load step.
    pub max_augmentations: usize,
    /// Smallest load step tried, relative to the stage's own step. Legal: 0 < x ≤ 1.
    pub min_step: f64,
    /// Threads; `None` uses the caller's rayon pool. Results do not depend on it.
    pub threads: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            newton: NewtonOptions::default(),
            leave_unstable: true,
            escape_step: 0.1,
            max_escapes: 4,
            max_augmentations: 40,
            min_step: 1.0 / 256.0,
            threads: None,
        }
    }
}

impl From<Fidelity> for Options {
    /// The defaults with the preset's tolerance of increments.
    fn from(fidelity: Fidelity) -> Self {
        let newton = NewtonOptions { tol_increment: fidelity.tol_increment(), ..NewtonOptions::default() };
        Self { newton, ..Self::default() }
    }
}

impl Options {
    /// Refuses options outside their legal ranges.
    ///
    /// # Errors
    /// Names the field and the value.
    pub fn check(&self) -> Result<(), InputError> {
        let unit = |x: f64| x > 0.0 && x <= 1.0;
        InputError::check("options.escape_step", self.escape_step, unit(self.escape_step), "in (0, 1] rad")?;
        InputError::check("options.min_step", self.min_step, unit(self.min_step), "in (0, 1]")?;
        let tol = self.newton.tol_increment;
        InputError::check("options.newton.tol_increment", tol, tol > 0.0 && tol < 1.0, "between 0 and 1")
    }
}
