//! Extremes: each test says whether the input is refused or what returns.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test stops where it cannot go on; rows for whoever asks

#[path = "../common/mod.rs"]
mod common;

mod extremes;
mod extremes_contact;
mod extremes_numbers;
mod extremes_unlike;
