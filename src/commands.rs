//! The commands: each file has the arguments of one, or of two that share their work, and does it. A command returns
//! the exit code.

pub mod answers;
pub mod check;
mod execution;
pub mod export;
pub mod help;
pub mod new;
pub mod plot;
mod print;
mod progress;
pub mod resume;
pub mod run;
mod signals;
pub mod sweep;
pub mod temperature;
pub mod view;

use supercoil::InputError;
use supercoil::solve::RunError;

pub const CONVERGED: u8 = 0;
pub const NOT_CONVERGED: u8 = 1;
pub const BAD_INPUT: u8 = 2;
pub const NOT_WRITTEN: u8 = 3;
pub const OVERLAPS: u8 = 4;
pub const CHECK_FAILS: u8 = 5;
pub const INTERRUPTED: u8 = 130;

fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "a number expected".to_owned())?;
    if seconds >= 0.0 { Ok(seconds) } else { Err("must be at least 0".to_owned()) }
}

/// The exit code of work without steps.
fn code_of(result: Result<(), RunError>) -> Result<u8, InputError> {
    match result {
        Ok(()) => Ok(CONVERGED),
        Err(RunError::Input(error)) => Err(error),
        Err(error) => {
            eprintln!("error: {error}");
            Ok(NOT_CONVERGED)
        }
    }
}
