//! The crate's errors as Python's exceptions; their classes stand in `supercoil/errors.py`.

use pyo3::prelude::*;
use supercoil::solve::RunError;
use supercoil::{InputError, SolveError};

fn raise(class: &str, text: String) -> PyErr {
    Python::attach(|py| {
        let error = py.import("supercoil.errors").and_then(|errors| errors.getattr(class)?.call1((text,)));
        error.map_or_else(|e| e, PyErr::from_value)
    })
}

/// `supercoil.InputError`.
pub fn input(error: InputError) -> PyErr {
    raise("InputError", error.to_string())
}

/// `supercoil.SolveError`.
pub fn solve(error: SolveError) -> PyErr {
    raise("SolveError", error.to_string())
}

/// Either of both.
pub fn run(error: RunError) -> PyErr {
    match error {
        RunError::Input(error) => input(error),
        RunError::Solve(error) => solve(error),
    }
}

/// Bytes or text that the package itself has written, and that something else has changed.
pub fn damaged(what: &str, reason: impl std::fmt::Display) -> PyErr {
    raise("InputError", format!("{what}: {reason}"))
}
