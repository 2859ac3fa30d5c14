//! Finds equilibria. From the outside in:
//!
//! | | |
//! |---|---|
//! | `path` | load stepping: [`run`], [`Solver`]; paths through limit points: [`Solver::follow`] |
//! | `load_step` | one step brought to rest: predict, correct, enforce contact, accept; the outcome is a [`StepReport`] |
//! | `search` | one equilibrium search: Newton steps within a trust region, none of which takes a strand through another |
//! | `problem` | the problem assembled: unknowns, gradient, tangent, contact, motions that nothing resists |

mod load_step;
mod measures;
mod options;
mod path;
pub(crate) mod problem;
mod search;

pub use load_step::solver::Solver;
pub use load_step::step_report::{Attempt, Origin, Status, StepReport};
pub use options::Options;
pub use path::continuation::{FollowOptions, FollowReport, PathEnd, PathPoint, PointKind, Start};
pub use path::failure::{Failure, Overlap, RodPoint, TightBend};
pub use path::given::Given;
pub(crate) use path::given::GivenTopology;
pub use path::restart::{Equilibrium, Place, Restart};
pub use path::run::{Progress, RunError, Solution, Waypoint, run, run_from, solver_at};
pub use problem::engine::Engine;
pub use problem::fields::NodalFields;
pub use problem::problem_size::ProblemSize;
pub use problem::state::{Numbers, State};
pub use search::interrupt::Interrupt;
pub use search::newton::{Iteration, NewtonOptions};
pub use search::timing::Timings;
