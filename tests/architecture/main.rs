//! What the sources and dependencies may and may not contain.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

mod architecture;
mod documents;
mod supply_chain;
