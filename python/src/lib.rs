//! The native half of the Python package: scenes, runs and states as classes, contact and topology as functions.
//! What users see is written in Python, in `supercoil/`; here is only what needs the crate.

// the command line, as it is
#[allow(dead_code)]
#[path = "../../src/main.rs"]
mod program;

mod files;
mod geometry;
mod refuse;
mod scene;
mod solver;
mod state;
mod supervise;
mod sweep;

use pyo3::prelude::*;

/// Native half of supercoil.
#[pymodule]
mod _supercoil {
    #[pymodule_export]
    use super::files::{export, program, schema, write_files, write_glb};
    #[pymodule_export]
    use super::geometry::{contact_diameter, detect, dna, excess_link, linking_number, writhe};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::solver::Solver;
    #[pymodule_export]
    use super::state::State;
    #[pymodule_export]
    use super::sweep::{Plan, table_columns};
}
