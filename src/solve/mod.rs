//! Finds equilibria, from the outside in: [`path`] (load stepping), `predictor` (where it is heading), [`settle`] (one state brought to rest: contact enforced,
//! unstable states left), `short_first` (long plectonemes from short ones), `coarse_first` (large turns on a coarse mesh), [`newton`] (mixed-integration-point Newton), [`globalise`] (the guarded search near contact), `surprise` (what a step's linear prediction missed), [`step_bound`]
//! (no strand passes another), `turning` (no frame takes the other way round), [`continuation`] (paths through limit points, branch switching), [`stability`] (the way out of
//! unstable states), [`assembly`] (gradient and tangent), [`engine`] (the problem assembled), [`state`] (the configuration and how
//! it moves), [`restart`] (what a run needs to go on later), `refine` (the same state on a finer mesh or under a harder law), [`fields`] (what it looks like along the rods), [`footprint`] (what it takes).

pub mod assembly;
mod balance;
mod coarse_first;
pub mod continuation;
pub mod engine;
pub mod fields;
pub mod footprint;
pub mod globalise;
mod hardening;
mod held_open;
mod interrupt;
mod moment_load;
mod multipliers;
mod neutral;
pub mod newton;
pub mod path;
pub mod per_contact;
mod predictor;
mod refine;
pub mod restart;
pub mod settle;
mod short_first;
pub mod stability;
pub mod state;
pub mod step_bound;
mod surprise;
mod timing;
mod turning;

use crate::error::InputError;
use crate::scene::Fidelity;

pub use continuation::{FollowOptions, FollowReport, PathEnd, PathPoint, PointKind, Start};
pub use engine::Engine;
pub use fields::NodalFields;
pub use footprint::Footprint;
pub use interrupt::Interrupt;
pub use newton::NewtonOptions;
pub use path::{Progress, RunError, Solution, Solver, Waypoint, run, run_from};
pub use restart::Restart;
pub use settle::{Status, StepReport};
pub use state::{Drive, State};
pub use timing::Timings;

/// Choices of a run; the defaults suit DNA loops and cables alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Newton's choices.
    pub newton: NewtonOptions,
    /// Leave unstable equilibria along their most negative direction.
    pub leave_unstable: bool,
    /// Size of the step off an unstable equilibrium: largest rotation, rad. Legal: 0 < x ≤ 1.
    pub departure: f64,
    /// Departures allowed per load step.
    pub max_departures: usize,
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
            departure: 0.1,
            max_departures: 4,
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
        InputError::check("options.departure", self.departure, unit(self.departure), "in (0, 1] rad")?;
        InputError::check("options.min_step", self.min_step, unit(self.min_step), "in (0, 1]")?;
        let tol = self.newton.tol_increment;
        InputError::check("options.newton.tol_increment", tol, tol > 0.0 && tol < 1.0, "between 0 and 1")
    }
}
