//! One case: its run and its rows.

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::InputError;
use crate::observe::ending;
use crate::observe::report::Observation;
use crate::scene::file::value_of;
use crate::solve::{self, Interrupt, RunError, Status};

use super::super::csv::Cell;
use super::super::run::{ReportedState, options, run_observed};
use super::super::table::Columns;
use super::columns::SweepTable;
use super::file::Rows;
use super::plan::{Case, Plan};

/// Column of the id.
pub(super) const ID: &str = "case";
/// Column of the status.
pub(super) const STATUS: &str = "status";
/// Column of the message of a case that did not converge.
pub(super) const MESSAGE: &str = "message";
/// Column of wall time, the only one that is not reproducible to the bit.
pub(super) const SECONDS: &str = "seconds";
/// Status of a case that converged.
pub(super) const CONVERGED: &str = "converged";

/// Result of a case.
struct CaseEnd {
    status: String,
    message: String,
}

impl Plan {
    /// Runs a case on one thread and gives its rows: id, values that are its own, status, message, and the columns of a
    /// run's table. A scene that is refused, numbers that break down and a run that does not converge are rows, too.
    /// `None` if `interrupt` stopped the run.
    #[must_use]
    pub fn run(&self, case: &Case, interrupt: &Interrupt) -> Option<SweepTable> {
        let (mut columns, mut steps) = (None, Vec::new());
        // a panic in one case must not end the others
        let end = catch_unwind(AssertUnwindSafe(|| self.solve(case, interrupt, &mut columns, &mut steps)));
        let end = match end {
            Ok(Ok(solution)) if solution.status == Status::Stopped && interrupt.is_raised() => return None,
            Ok(Ok(solution)) => {
                let status = ending(solution.status, steps.last());
                let reasons = || steps.last().filter(|_| status != CONVERGED).map(|last| last.notes.join("; "));
                let message = solution.failure.as_ref().map(ToString::to_string).or_else(reasons).unwrap_or_default();
                CaseEnd { status, message }
            }
            Ok(Err(RunError::Input(error))) => CaseEnd { status: "refused".to_owned(), message: error.to_string() },
            Ok(Err(RunError::Solve(error))) => CaseEnd { status: "broke down".to_owned(), message: error.to_string() },
            Err(_) => CaseEnd { status: "panicked".to_owned(), message: "a fault of the program".to_owned() },
        };
        if self.rows() == Rows::Last {
            steps.drain(..steps.len().saturating_sub(1));
        }
        Some(rows(case, &end, columns.as_ref(), &steps))
    }

    fn solve(
        &self,
        case: &Case,
        interrupt: &Interrupt,
        columns: &mut Option<Columns>,
        steps: &mut Vec<Observation>,
    ) -> Result<solve::Solution, RunError> {
        let scene = self.scene(case)?;
        if scene.follow.is_some() {
            let reason = "a sweep follows no paths: remove it, or run the scene alone".to_owned();
            return Err(InputError::Inconsistent { field: "stages.follow".to_owned(), reason }.into());
        }
        *columns = Some(Columns::of_scene(&scene));
        let mut options = options(&scene);
        options.newton.interrupt = interrupt.clone();
        options.threads = Some(1);
        run_observed(&scene, &options, (None, &[]), &mut |ReportedState { observation, .. }| {
            // sites have no columns
            steps.push(Observation { sites: Vec::new(), ..observation });
            ControlFlow::Continue(())
        })
    }
}

fn rows(case: &Case, end: &CaseEnd, columns: Option<&Columns>, steps: &[Observation]) -> SweepTable {
    let own: Vec<(&str, Cell)> = case.set.iter().filter_map(|assignment| value(assignment)).collect();
    let head = || {
        let end = [(STATUS, Cell::from(end.status.as_str())), (MESSAGE, Cell::from(end.message.as_str()))];
        [(ID, Cell::from(case.id.as_str()))].into_iter().chain(own.clone()).chain(end)
    };
    let is_there = |(_, cell): &(&str, Cell)| !matches!(cell, Cell::Missing) && *cell != Cell::from("");
    let mut table = SweepTable::default();
    for (columns, step) in steps.iter().filter_map(|step| Some((columns?, step))) {
        let cells = columns.names().into_iter().zip(columns.cells(step));
        table.push(head().chain(cells.filter(|(name, _)| *name != STATUS).filter(is_there)));
    }
    if steps.is_empty() {
        table.push(head());
    }
    table
}

/// Key and value of an assignment as column name and cell: a number, otherwise a string.
fn value(assignment: &str) -> Option<(&str, Cell)> {
    let (key, text) = assignment.split_once('=')?;
    let cell = match value_of(text) {
        toml::Value::Integer(value) => Cell::Number(value as f64),
        toml::Value::Float(value) => Cell::Number(value),
        toml::Value::String(word) => Cell::Text(word),
        other => Cell::Text(other.to_string()),
    };
    Some((key, cell))
}

/// Refuses an assignment whose key would hide a column of the table.
pub(super) fn check_key(assignment: &str) -> Result<(), InputError> {
    let key = assignment.split('=').next().unwrap_or_default();
    match [ID, STATUS, MESSAGE].contains(&key) {
        true => {
            let reason = "is no key of a scene, but a column of the table".to_owned();
            Err(InputError::Inconsistent { field: key.to_owned(), reason })
        }
        false => Ok(()),
    }
}
