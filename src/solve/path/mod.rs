//! Paths of equilibria: load stepping, and continuation through limit points.
//!
//! | | |
//! |---|---|
//! | `run` | stages, steps, halved steps |
//! | `given` | the problem as it was given |
//! | `restart` | all that a run needs to go on later |
//! | `failure` | why a run went no further |
//! | `continuation` | along a path by its arc length |

pub(in crate::solve) mod continuation;
pub(in crate::solve) mod failure;
pub(in crate::solve) mod given;
pub(in crate::solve) mod restart;
pub(in crate::solve) mod run;
