//! One load step: predict, correct, enforce contact, accept.
//!
//! | | |
//! |---|---|
//! | `solver` | [`Solver`](crate::solve::Solver): engine, workspace, all that one step leaves to the next |
//! | `ramped_step` | ramps become a target, which is predicted, searched for and accepted; begin here |
//! | `step` | the loop over starts |
//! | `guess` | a guess as a value; the start that makes it |
//! | `predictor` | the next state extrapolated from those before |
//! | `plectoneme` | guesses for plectonemes, made of shorter ones |
//! | `nested_iteration` | a guess from a coarse mesh |
//! | `core_law` | the contact law as a path, the last start; `multiplier_estimate` has the pressures that it begins with |
//! | `descent` | a search that leaves unstable equilibria |
//! | `enforce_contact` | the augmented Lagrangian; `multipliers`, `complementarity`: offsets raised and lowered until gaps and pressures fit |
//! | `refine` | the same state on a finer mesh or under a harder law |
//! | `energy_balance` | work done and energy kept: what a snap sets free |
//! | `step_report` | how the step ended |

mod complementarity;
mod core_law;
mod descent;
mod energy_balance;
pub(in crate::solve) mod enforce_contact;
mod guess;
mod multiplier_estimate;
pub(in crate::solve) mod multipliers;
mod nested_iteration;
mod plectoneme;
pub(in crate::solve) mod predictor;
mod ramped_step;
mod refine;
pub(in crate::solve) mod solver;
mod step;
pub(in crate::solve) mod step_report;
