//! A scene and its run.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::mpsc::{Sender, channel};
use std::time::Instant;

use pyo3::prelude::*;
use supercoil::io::csv::Cell;
use supercoil::io::run::{ReportedState, options, run_observed};
use supercoil::io::table::Columns;
use supercoil::observe::report::Observation;
use supercoil::observe::{ending, estimate_error};
use supercoil::scene;
use supercoil::solve::Status;

use crate::refuse;
use crate::state::State;
use crate::supervise::supervised;

/// A scene that has been read and checked.
#[pyclass(frozen, module = "supercoil._supercoil")]
pub struct Scene(pub scene::Scene);

/// Final state, observations of all steps as JSON, status, failure, estimate of the error as JSON, wall time [s].
type Run = (State, String, String, Option<String>, Option<String>, f64);

#[pymethods]
impl Scene {
    /// Reads a scene from text; files named in it are found relative to `base_dir`.
    #[new]
    fn new(text: &str, base_dir: PathBuf) -> PyResult<Self> {
        scene::Scene::from_toml(text, &base_dir).map(Self).map_err(refuse::input)
    }

    #[getter]
    fn title(&self) -> &str {
        &self.0.title
    }

    /// Of every rod: name, closed, length, contact radius, number of nodes.
    fn rods(&self) -> Vec<(String, bool, f64, f64, usize)> {
        let head = |rod: &supercoil::rod::Rod| {
            (rod.name.clone(), rod.closed, rod.length, rod.section.contact_radius, rod.num_nodes())
        };
        self.0.model.rods.iter().map(head).collect()
    }

    /// Names of the units of length and force.
    fn units(&self) -> (&str, &str) {
        (&self.0.units.length, &self.0.units.force)
    }

    /// Temperature, K, and kT, pN nm, where units are nm and pN.
    fn thermal(&self) -> Option<(f64, f64)> {
        self.0.thermal()
    }

    /// Steps of each stage.
    fn stage_steps(&self) -> Vec<usize> {
        self.0.stages.iter().map(|stage| stage.steps).collect()
    }

    /// What to know of the scene, and what is probably not meant.
    fn remarks(&self) -> (Vec<String>, Vec<String>) {
        (self.0.notices.clone(), self.0.warnings())
    }

    /// Of the columns of `table.csv`: name, unit, meaning.
    fn columns(&self) -> Vec<(String, String, &'static str)> {
        let columns = Columns::of_scene(&self.0);
        columns.explained().map(|column| (column.name.clone(), column.unit.clone(), column.meaning)).collect()
    }

    /// The steps, given as JSON, in the columns of `table.csv`: JSON of pairs of a name and a list, null for a blank
    /// cell.
    fn table(&self, steps: &str) -> PyResult<String> {
        let damaged = |e| refuse::damaged("table", e);
        let steps: Vec<Observation> = serde_json::from_str(steps).map_err(damaged)?;
        let columns = Columns::of_scene(&self.0);
        let rows: Vec<Vec<Cell>> = steps.iter().map(|step| columns.cells(step)).collect();
        let value = |cell: &Cell| match cell {
            Cell::Number(value) => serde_json::json!(value),
            Cell::Count(value) => serde_json::json!(value),
            Cell::Text(value) => serde_json::json!(value),
            Cell::Missing => serde_json::Value::Null,
        };
        let column = |(k, name): (usize, &str)| (name.to_owned(), rows.iter().map(|row| value(&row[k])).collect());
        let table: Vec<(String, Vec<serde_json::Value>)> =
            columns.names().into_iter().enumerate().map(column).collect();
        serde_json::to_string(&table).map_err(damaged)
    }

    /// Runs all stages. `callback` sees every accepted state and stops the run by returning False.
    fn run(&self, py: Python, callback: Option<Py<PyAny>>, threads: Option<usize>) -> PyResult<Run> {
        let started = Instant::now();
        let mut options = options(&self.0);
        options.threads = threads.or(options.threads);
        let interrupt = options.newton.interrupt.clone();
        let (verdict, verdicts) = channel();
        let watched = callback.is_some();
        let scene = &self.0;
        let work = move |states: Sender<State>| {
            let mut steps: Vec<Observation> = Vec::new();
            let solution = run_observed(scene, &options, (None, &[]), &mut |reported: ReportedState| {
                let ReportedState { observation, engine, .. } = reported;
                steps.push(observation.clone());
                if !watched {
                    return ControlFlow::Continue(());
                }
                let sent = states.send(State::of(engine, observation, scene));
                // either channel closes when the caller has gone away
                let go_on = sent.is_ok() && verdicts.recv().unwrap_or(false);
                if go_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            })?;
            // the start state is seen whatever becomes of it
            let last = steps.last().cloned().map(|last| State::of(solution.solver.engine(), last, scene));
            let status = ending(solution.status, steps.last());
            let estimates = scene.output.error_estimate && solution.status == Status::Converged;
            let estimate = estimates.then(|| estimate_error(&solution.solver)).transpose()?;
            Ok((last, steps, status, solution.failure, estimate))
        };
        let answer = |state: State| {
            let go_on = Python::attach(|py| {
                py.check_signals()?;
                let Some(callback) = &callback else { return Ok(true) };
                let said = callback.call1(py, (state,))?;
                Ok(!said.bind(py).is(&*pyo3::types::PyBool::new(py, false)))
            });
            verdict.send(*go_on.as_ref().unwrap_or(&false)).ok();
            go_on.map(|_| ())
        };
        let (last, steps, status, failure, estimate) =
            supervised(py, &interrupt, work, answer)?.map_err(refuse::run)?;
        let last = last.ok_or_else(|| refuse::damaged("run", "no state was seen"))?;
        let damaged = |e| refuse::damaged("run", e);
        let steps = serde_json::to_string(&steps).map_err(damaged)?;
        let estimate = estimate.map(|estimate| serde_json::to_string(&estimate)).transpose().map_err(damaged)?;
        Ok((last, steps, status, failure.map(|f| f.to_string()), estimate, started.elapsed().as_secs_f64()))
    }
}
