//! One equilibrium search: from a state to the next at which the gradient vanishes.
//!
//! | | |
//! |---|---|
//! | `workspace` | linearisation, factorisation, inertia |
//! | `equilibrate` | a search from start to end; begin here |
//! | `newton` | the plain search |
//! | `trust_region` | the guarded search: corrected steps that the potential confirms |
//! | `contact_balance` | whether contact is in balance after a search |
//! | `second_order` | forces that a step's linear prediction missed |
//! | `step_bound` | the longest step in which no strand passes another |
//! | `stability` | unstable directions of a state |
//! | `interrupt`, `timing` | a request to stop; where the time went |

pub(in crate::solve) mod contact_balance;
mod equilibrate;
pub(in crate::solve) mod interrupt;
pub(in crate::solve) mod newton;
mod second_order;
mod stability;
pub(in crate::solve) mod step_bound;
pub(in crate::solve) mod timing;
pub(in crate::solve) mod trust_region;
pub(in crate::solve) mod workspace;
