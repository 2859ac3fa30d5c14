//! Finds equilibria. From the outside in:
//!
//! | | |
//! |---|---|
//! | `path` | load stepping: [`run`], [`Solver`]; `predictor` says where it is heading, `restart` what a run needs to go on later |
//! | `continuation` | paths through limit points, onto branches, round the corners of contact: [`Solver::follow`] |
//! | `settle` | one state brought to rest: contact enforced, unstable states left (`stability`); the outcome is a [`StepReport`] |
//! | `short_first`, `coarse_first` | long plectonemes from short ones, large turns on a coarse mesh |
//! | `balance`, `hardening` | pressures that a search begins with: of a start shape, of a law softer than the next |
//! | `multipliers`, `per_contact`, `held_open` | the augmented Lagrangian and its offsets |
//! | `newton`, `globalise` | mixed-integration-point Newton; the guarded search near contact |
//! | `surprise`, `step_bound`, `turning` | what a step's linear prediction missed; no strand passes another; no frame takes the other way round |
//! | `neutral` | motions that nothing resists |
//! | `assembly`, `engine`, `contact_side`, `state` | gradient and tangent; the problem assembled; contact in it; the configuration and how it moves |
//! | `changes` | numbers of rods that are ramped, supports that are set and taken away |
//! | `failure` | why a run went no further |
//! | `fields`, `footprint`, `timing`, `refine` | what a state looks like along the rods; what it takes; the same on a finer mesh or under a harder law |

pub(crate) mod assembly;
mod balance;
mod changes;
mod coarse_first;
pub(crate) mod contact_side;
mod continuation;
pub(crate) mod engine;
mod failure;
mod fields;
mod footprint;
mod globalise;
mod hardening;
mod held_open;
mod interrupt;
mod moment_load;
mod multipliers;
mod neutral;
mod newton;
mod path;
mod per_contact;
mod predictor;
mod refine;
mod restart;
mod settle;
mod short_first;
mod stability;
mod state;
mod step_bound;
mod step_report;
mod surprise;
pub(crate) mod swivel;
mod timing;
mod turning;

use crate::error::InputError;
use crate::scene::Fidelity;

pub use changes::Numbers;
pub use continuation::{FollowOptions, FollowReport, PathEnd, PathPoint, PointKind, Start};
pub use engine::Engine;
pub use failure::{Failure, Overlap, Spot};
pub use fields::NodalFields;
pub use footprint::Footprint;
pub use interrupt::Interrupt;
pub use newton::{Iteration, NewtonOptions};
pub use path::{Progress, RunError, Solution, Solver, Waypoint, run, run_from};
pub use restart::{Place, Restart};
pub use state::State;
pub use step_report::{Status, StepReport};
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
