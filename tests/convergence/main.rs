//! Orders of convergence, fitted.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
mod common;

mod convergence_orders;
mod incremental_interpolation;
mod newton_orders;
