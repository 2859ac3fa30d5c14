//! One load step: predict, correct, enforce contact, accept.
//!
//! | | |
//! |---|---|
//! | `solve_step` | the step from start to end; begin here |
//! | `predictor` | the next state extrapolated from those before |
//! | `multipliers`, `complementarity` | the augmented Lagrangian: offsets raised and lowered until gaps and pressures fit |
//! | `penalty_continuation`, `multiplier_estimate` | pressures that a search begins with: of a softer law, of a start shape |
//! | `nested_iteration`, `periodic_extension` | a start from a coarse mesh, from a short plectoneme |
//! | `refine` | the same state on a finer mesh or under a harder law |
//! | `step_report` | how the step ended |

mod complementarity;
mod multiplier_estimate;
pub(in crate::solve) mod multipliers;
mod nested_iteration;
mod penalty_continuation;
mod periodic_extension;
pub(in crate::solve) mod predictor;
mod refine;
pub(in crate::solve) mod solve_step;
pub(in crate::solve) mod step_report;
