//! The solver driven by hand.

use std::ops::ControlFlow;
use std::sync::{Mutex, MutexGuard};

use pyo3::prelude::*;
use supercoil::io::run::options;
use supercoil::observe::observe;
use supercoil::scene;
use supercoil::solve::{self, FollowOptions, Interrupt, PathPoint, PointKind, Progress, Start, StepReport};

use crate::refuse;
use crate::scene::Scene;
use crate::state::State;
use crate::supervise::supervised;

/// A solver and the last thing it did.
struct Driven {
    solver: solve::Solver,
    step: usize,
    report: Option<StepReport>,
    seconds: f64,
}

/// A solver driven by hand.
#[pyclass(frozen, module = "supercoil._supercoil")]
pub struct Solver {
    driven: Mutex<Driven>,
    scene: scene::Scene,
    interrupt: Interrupt,
}

impl Solver {
    /// A solver in use by another thread is refused rather than waited for.
    fn lock(&self) -> PyResult<MutexGuard<'_, Driven>> {
        self.driven.try_lock().map_err(|_| refuse::damaged("solver", "is in use by another thread, or has panicked"))
    }
}

#[pymethods]
impl Solver {
    #[new]
    fn new(scene: &Scene, threads: Option<usize>) -> PyResult<Self> {
        let scene = scene.0.clone();
        let mut options = options(&scene);
        options.threads = threads.or(options.threads);
        let interrupt = options.newton.interrupt.clone();
        let solver = solve::Solver::new(scene.model.clone(), options).map_err(refuse::input)?;
        let driven = Mutex::new(Driven { solver, step: 0, report: None, seconds: 0.0 });
        Ok(Self { driven, scene, interrupt })
    }

    /// Moves the ramps of `[[stages]]` in `text` to their targets in one step; without text, settles. Returns status,
    /// error, iterations, augmentations, escapes, unstable directions.
    #[allow(clippy::type_complexity)]
    fn step_to(
        &self,
        py: Python,
        text: Option<&str>,
    ) -> PyResult<(String, Option<String>, usize, usize, usize, usize)> {
        let stages = text.map(|text| self.scene.stages_from_toml(text)).transpose().map_err(refuse::input)?;
        let mut whole = scene::Stage::new(Vec::new(), 1);
        for stage in stages.into_iter().flatten() {
            whole.supports.extend(stage.supports);
            whole.ramps.extend(stage.ramps);
        }
        let mut driven = self.lock()?;
        let driven = &mut *driven;
        let started = std::time::Instant::now();
        let work = |_: std::sync::mpsc::Sender<()>| driven.solver.step_through(&whole);
        let report = supervised(py, &self.interrupt, work, |()| Ok(()))?.map_err(refuse::input)?;
        driven.seconds = started.elapsed().as_secs_f64();
        driven.step += 1;
        let (status, error) = (report.status.to_string(), report.error.as_ref().map(ToString::to_string));
        let counts = (report.iterations, report.augmentations, report.escapes, report.num_unstable);
        driven.report = Some(report);
        Ok((status, error, counts.0, counts.1, counts.2, counts.3))
    }

    /// The present state; before the first step the start shape is settled.
    fn state(&self, py: Python) -> PyResult<State> {
        if self.lock()?.report.is_none() {
            self.step_to(py, None)?;
        }
        let driven = self.lock()?;
        let engine = driven.solver.engine();
        let report = driven.report.as_ref().ok_or_else(|| refuse::damaged("solver", "took no step"))?;
        let (step, seconds) = (driven.step, driven.seconds);
        py.detach(|| {
            let progress = Progress { given: None, engine, stage: 0, step, fraction: 1.0, report, seconds };
            Ok(State::of(engine, observe(&progress), &self.scene))
        })
    }

    /// Follows the path of equilibria with the first ramp of `[[stages]]` in `text` as its parameter. Returns how it
    /// ended, and of every point its kind, the parameter, unstable directions and the state.
    #[allow(clippy::type_complexity, clippy::too_many_arguments)]
    fn follow(
        &self,
        py: Python,
        text: &str,
        start: &str,
        steps: (f64, f64),
        max_points: usize,
    ) -> PyResult<(String, Vec<(&'static str, f64, usize, State)>)> {
        let stages = self.scene.stages_from_toml(text).map_err(refuse::input)?;
        if stages.iter().any(|stage| !stage.supports.is_empty()) {
            return Err(refuse::damaged("follow", "changes supports, which change in steps only (`step_to`, `run`)"));
        }
        let ramp = stages.into_iter().flat_map(|stage| stage.ramps).next();
        let ramp = ramp.ok_or_else(|| refuse::damaged("follow", "has no ramp"))?;
        let start = match start {
            "towards" => Start::Towards,
            "away" => Start::Away,
            "branch" => Start::Branch { forwards: true },
            "other-branch" => Start::Branch { forwards: false },
            _ => {
                return Err(refuse::damaged("start", "is none of \"towards\", \"away\", \"branch\", \"other-branch\""));
            }
        };
        let options = FollowOptions { start, step: steps.0, max_step: steps.1, max_points, ..FollowOptions::default() };
        if self.lock()?.report.is_none() {
            self.step_to(py, None)?;
        }
        let mut driven = self.lock()?;
        let (driven, interrupt, scene) = (&mut *driven, &self.interrupt, &self.scene);
        let mut points = Vec::new();
        let work = |_: std::sync::mpsc::Sender<()>| {
            driven.solver.follow(&ramp, &options, &mut |point: &PathPoint| {
                let state = State::of(point.engine(), observe(&point.progress), scene);
                points.push((kind(point.kind), point.value, point.num_unstable(), state));
                if interrupt.is_raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        };
        let report = supervised(py, &self.interrupt, work, |()| Ok(()))?.map_err(refuse::input)?;
        Ok((format!("{:?}", report.end), points))
    }

    /// Unstable directions of the present state.
    fn num_unstable(&self, py: Python) -> PyResult<usize> {
        let mut driven = self.lock()?;
        let driven = &mut *driven;
        py.detach(|| driven.solver.num_unstable()).map_err(refuse::solve)
    }
}

fn kind(kind: PointKind) -> &'static str {
    match kind {
        PointKind::Start => "start",
        PointKind::Regular => "regular",
        PointKind::Limit => "limit",
        PointKind::Branch { .. } => "branch",
        PointKind::Corner => "corner",
        PointKind::Target => "target",
    }
}
