//! One load step: predict, correct, enforce contact, accept.
//!
//! | | |
//! |---|---|
//! | `solver` | [`Solver`](crate::solve::Solver): engine, workspace, all that one step leaves to the next |
//! | `ramped_step` | ramps become a target, which is predicted, searched for and accepted; begin here |
//! | `solve_step` | the search for a target from start to end |
//! | `predictor` | the next state extrapolated from those before |
//! | `multipliers`, `complementarity` | the augmented Lagrangian: offsets raised and lowered until gaps and pressures fit |
//! | `penalty_continuation`, `multiplier_estimate` | pressures that a search begins with: of a softer law, of a start shape |
//! | `double_helix`, `growth` | double helices made longer by whole turns; a plectoneme that takes up rod from its tails |
//! | `nested_iteration`, `periodic_extension`, `short_rod` | a start from a coarse mesh, from a short plectoneme, from a short rod that snapped |
//! | `refine` | the same state on a finer mesh or under a harder law |
//! | `energy_balance` | work done and energy kept: what a snap sets free |
//! | `step_report` | how the step ended |

mod complementarity;
mod double_helix;
mod energy_balance;
mod growth;
mod multiplier_estimate;
pub(in crate::solve) mod multipliers;
mod nested_iteration;
mod penalty_continuation;
mod periodic_extension;
pub(in crate::solve) mod predictor;
mod ramped_step;
mod refine;
mod short_rod;
pub(in crate::solve) mod solve_step;
pub(in crate::solve) mod solver;
pub(in crate::solve) mod step_report;
