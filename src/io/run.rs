//! Runs a scene and leaves its record in a folder; silent, progress goes through a callback.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use crate::error::InputError;
use crate::observe;
use crate::observe::report::Observation;
use crate::scene::Scene;
use crate::solve::{self, NewtonOptions, NodalFields, Options, Progress, RunError, Status};

use super::record::{Record, RodSnapshot};

/// How a run went.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Outcome {
    /// How the run ended.
    pub status: Status,
    /// Accepted steps, the start included.
    pub steps: Vec<Observation>,
    /// Wall time \[s\].
    pub seconds: f64,
}

/// Solver options of a scene: its choices over the defaults.
pub fn options(scene: &Scene) -> Options {
    let (choice, default) = (&scene.solver, NewtonOptions::default());
    let newton = NewtonOptions {
        tol_increment: choice.tol_increment.unwrap_or(default.tol_increment),
        max_iterations: choice.max_iterations.unwrap_or(default.max_iterations),
        ..default
    };
    Options { newton, threads: choice.threads, ..Options::default() }
}

/// Runs `scene` and writes its outputs to the folder `dir` (see [`Record`]); `watch` sees every accepted step and may stop
/// the run. The record of what was accepted is written also when the run stops, does not converge or breaks down.
///
/// # Errors
/// [`RunError`]: input refused (files that cannot be written included), or numbers that broke down.
pub fn run_scene(
    scene: Scene,
    dir: &Path,
    watch: &mut dyn FnMut(&Observation) -> ControlFlow<()>,
) -> Result<Outcome, RunError> {
    let started = Instant::now();
    let mut record = Record::new(&scene, dir)?;
    let options = options(&scene);
    let mut failed: Option<InputError> = None;
    let mut observer = |progress: &Progress| {
        let observation = observe::observe(progress);
        let seen = watch(&observation);
        match record.push(observation, snapshots(progress)) {
            Ok(()) => seen,
            Err(error) => {
                failed = Some(error);
                ControlFlow::Break(())
            }
        }
    };
    let result = solve::run(scene.model, &scene.stages, &options, &mut observer);
    let seconds = started.elapsed().as_secs_f64();
    if let Some(error) = failed {
        return Err(error.into());
    }
    let (converged, status) = match &result {
        Ok(solution) => (solution.status == Status::Converged, solution.status.to_string()),
        Err(error) => (false, error.to_string()),
    };
    record.finish(converged, &status, seconds)?;
    result.map(|solution| Outcome { status: solution.status, steps: record.steps().to_vec(), seconds })
}

fn snapshots(progress: &Progress) -> Vec<RodSnapshot> {
    let engine = progress.engine;
    let snapshot = |(rod, fields): (usize, NodalFields)| RodSnapshot {
        positions: engine.positions(rod).to_vec(),
        frames: engine.frames(rod).to_vec(),
        curvature: fields.curvature,
        twist: fields.twist,
        contact_force: fields.contact_force,
    };
    engine.all_nodal_fields().into_iter().enumerate().map(snapshot).collect()
}
