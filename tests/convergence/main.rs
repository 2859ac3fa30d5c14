//! Orders of convergence, fitted.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
#[allow(dead_code)] // each module uses its part
mod common;

mod convergence_orders;
mod incremental_interpolation;
mod newton_orders;
