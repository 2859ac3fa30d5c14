//! Runs a scene and writes its record to a folder. Silent; a callback reports progress. A stopped or killed run resumes
//! from its last checkpoint and ends with the same bits.

mod observed;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::error::InputError;
use crate::math::Vec3;
use crate::observe::report::Observation;
use crate::observe::{self, ErrorEstimate, smoothed_contact_forces};
use crate::scene::{Scene, Stage};
use crate::solve::{
    self, Engine, Failure, Interrupt, NewtonOptions, NodalFields, Options, Restart, RunError, Status, Waypoint,
};

use super::asked::{Answers, Asked};
use super::checkpoint::{Checkpoint, FILE_NAME};
use super::fingerprint::Fingerprint;
use super::folder;
use super::record::{FINAL_STATE_BITS, Record, RecordState, RodSnapshot};

pub use observed::{ReportedState, run_observed};

/// Result of a run.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct Outcome {
    /// How the run ended.
    pub status: Status,
    /// Accepted steps, the start and those before a resumption included, each with its strongest contact sites only.
    pub steps: Vec<Observation>,
    /// Wall time of all parts of the run \[s\].
    pub seconds: f64,
    /// The checkpoint from which an unfinished run can resume.
    pub checkpoint: Option<PathBuf>,
    /// Reason of the end, if the run neither converged nor was stopped.
    pub failure: Option<Failure>,
    /// An estimate of the final state's error, if the scene asks for it and the run converged.
    pub error_estimate: Option<ErrorEstimate>,
    /// What the scene asks of the tangent at the final state, if the run converged.
    pub answers: Answers,
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

/// Callback for every accepted step; may stop the run.
pub type Watch<'a> = dyn FnMut(&Observation) -> ControlFlow<()> + 'a;

/// Runs `scene` and writes its outputs to the folder `dir`: [`SceneRun::start`].
///
/// # Errors
/// As there.
pub fn run_scene(scene: Scene, dir: &Path, watch: &mut Watch) -> Result<Outcome, RunError> {
    SceneRun::new(scene, dir).start(watch)
}

/// Resumes the run in the folder `dir`, whose scene file must not have moved: [`SceneRun::resume`].
///
/// # Errors
/// As there; a scene without a file, or whose file cannot be read.
pub fn resume(dir: &Path, watch: &mut Watch) -> Result<Outcome, RunError> {
    let scene = scene_of(&Checkpoint::read(&dir.join(FILE_NAME))?)?;
    SceneRun::new(scene, dir).resume(watch)
}

/// The scene of a checkpoint, read from its file.
///
/// # Errors
/// A scene without a file, or whose file cannot be read.
pub fn scene_of(checkpoint: &Checkpoint) -> Result<Scene, InputError> {
    let Some(path) = &checkpoint.scene else {
        let reason = "its scene came from no file: give the scene to go on with".to_owned();
        return Err(InputError::Inconsistent { field: "checkpoint".to_owned(), reason });
    };
    Scene::read_with(path, &checkpoint.set)
}

/// A scene and the folder for its run.
#[derive(Debug, Clone)]
pub struct SceneRun {
    /// The scene.
    pub scene: Scene,
    /// Folder of the outputs.
    pub dir: PathBuf,
    /// Stops the run between two Newton iterations.
    pub interrupt: Interrupt,
    /// Whether results of another scene in the folder may be replaced; otherwise they are an error.
    pub force: bool,
}

impl Outcome {
    /// Whether the run converged and all checks of the certificate of its final state hold.
    pub fn holds(&self) -> bool {
        let last = self.steps.last();
        self.status == Status::Converged && last.is_none_or(|last| !last.overlaps() && !last.fails())
    }

    /// Whether tubes overlap in the final equilibrium where contact does not resist it.
    pub fn overlaps(&self) -> bool {
        self.status == Status::Converged && self.steps.last().is_some_and(Observation::overlaps)
    }
}

impl SceneRun {
    /// A run without an interrupt.
    pub fn new(scene: Scene, dir: &Path) -> Self {
        Self { scene, dir: dir.to_owned(), interrupt: Interrupt::default(), force: false }
    }

    /// Runs the scene from its start; `watch` sees every accepted step and may stop the run.
    ///
    /// The record of accepted steps is written also if the run is stopped, does not converge or breaks down.
    /// Checkpoints are written after steps according to the scene's output choices, and when the run is stopped; a
    /// finished run removes its own. A checkpoint of an earlier run in the folder is renamed to `checkpoint.bin.old`.
    ///
    /// # Errors
    /// [`RunError`]: input refused (files that cannot be written included), a folder in which another run is writing or
    /// which holds the results of another scene, or numbers that broke down.
    pub fn start(self, watch: &mut Watch) -> Result<Outcome, RunError> {
        // before files of an earlier run are removed
        Asked::of(&self.scene)?;
        let _lock = folder::lock(&self.dir)?;
        if !self.force {
            folder::check(&self.dir, &self.scene)?;
        }
        let record = Record::new(&self.scene, &self.dir)?;
        folder::describe(&self.dir, &self.scene)?;
        let path = self.dir.join(FILE_NAME);
        if path.exists() {
            let refuse = |e: std::io::Error| InputError::Write { path: path.clone(), reason: e.to_string() };
            std::fs::rename(&path, self.dir.join(format!("{FILE_NAME}.old"))).map_err(refuse)?;
        }
        self.go(record, None, 0.0, watch)
    }

    /// Resumes from the checkpoint in the folder. The remaining steps, the final state and all tables are those of an
    /// uninterrupted run, bit for bit, except wall times; `watch` sees the remaining steps.
    ///
    /// # Errors
    /// As [`SceneRun::start`]; a checkpoint that is missing, damaged or of another version, or that was written for
    /// another scene (title, outputs and threads may differ).
    pub fn resume(self, watch: &mut Watch) -> Result<Outcome, RunError> {
        let path = self.dir.join(FILE_NAME);
        // a missing folder is not created
        let _lock = path.exists().then(|| folder::lock(&self.dir)).transpose()?;
        let checkpoint = Checkpoint::read(&path)?;
        checkpoint.check_scene(&self.scene)?;
        let Checkpoint { restart, record, seconds, .. } = checkpoint;
        let record = Record::resume(&self.scene, &self.dir, record)?;
        self.go(record, Some(restart), seconds, watch)
    }

    fn go(
        self,
        record: Record,
        from: Option<Restart>,
        seconds_before: f64,
        watch: &mut Watch,
    ) -> Result<Outcome, RunError> {
        let mut options = options(&self.scene);
        options.newton.interrupt = self.interrupt.clone();
        let asked = Asked::of(&self.scene)?;
        let mut keeper = Keeper::new(&self, record, from.clone(), (seconds_before, asked));
        let mut failed: Option<InputError> = None;
        let before = keeper.record.steps().to_vec();
        let result = run_observed(&self.scene, &options, (from, &before), &mut |reported: ReportedState| {
            let seen = watch(&reported.observation);
            match keeper.take_in(reported) {
                Ok(()) => seen,
                Err(error) => {
                    failed = Some(error);
                    ControlFlow::Break(())
                }
            }
        });
        match failed {
            Some(error) => Err(error.into()),
            None => keeper.finish(result),
        }
    }
}

/// Writer of record and checkpoints of a run.
struct Keeper {
    record: Record,
    dir: PathBuf,
    path: PathBuf,
    stages: Vec<Stage>,
    scene: Option<PathBuf>,
    set: Vec<String>,
    fingerprint: Fingerprint,
    steps: Option<usize>,
    seconds: f64,
    /// Whether a checkpoint of this run is on the disk.
    on_disk: bool,
    /// When the last one was written.
    last: Instant,
    /// State from which the run could resume.
    latest: Option<Restart>,
    started: Instant,
    seconds_before: f64,
    /// Whether the error of the final state is to be estimated.
    estimates: bool,
    /// What is asked of the tangent at the final state.
    asked: Asked,
}

impl Keeper {
    fn new(run: &SceneRun, record: Record, from: Option<Restart>, (seconds_before, asked): (f64, Asked)) -> Self {
        let (scene, started) = (&run.scene, Instant::now());
        Self {
            record,
            dir: run.dir.clone(),
            path: run.dir.join(FILE_NAME),
            stages: scene.stages.clone(),
            scene: scene.path.clone(),
            set: scene.set.clone(),
            fingerprint: Fingerprint::of(scene),
            steps: scene.output.checkpoint_steps,
            seconds: scene.output.checkpoint_seconds,
            on_disk: from.is_some(),
            last: started,
            latest: from,
            started,
            seconds_before,
            estimates: scene.output.error_estimate,
            asked,
        }
    }

    fn take_in(&mut self, ReportedState { observation, engine, waypoint }: ReportedState) -> Result<(), InputError> {
        self.record.push(observation, snapshots(engine))?;
        // no checkpoint is written along a path: a resumed run follows it from its beginning
        self.latest = waypoint.and_then(Waypoint::restart);
        let Some(waypoint) = waypoint else { return Ok(()) };
        let by_steps = self.steps.is_some_and(|every| waypoint.place().num_steps.is_multiple_of(every));
        // an interval beyond the range of Duration never ends
        let interval = Duration::try_from_secs_f64(self.seconds).unwrap_or(Duration::MAX);
        if by_steps || self.last.elapsed() >= interval { self.write() } else { Ok(()) }
    }

    /// Writes a checkpoint of the last accepted state, if there is any.
    fn write(&mut self) -> Result<(), InputError> {
        let Some(restart) = &self.latest else { return Ok(()) };
        let checkpoint = self.checkpoint(restart, self.record.state())?;
        checkpoint.write(&self.path)?;
        (self.on_disk, self.last) = (true, Instant::now());
        Ok(())
    }

    fn checkpoint(&self, restart: &Restart, record: RecordState) -> Result<Checkpoint, InputError> {
        Ok(Checkpoint {
            nodes: self.record.nodal_state()?,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            scene: self.scene.clone(),
            set: self.set.clone(),
            fingerprint: self.fingerprint,
            seconds: self.elapsed(),
            restart: restart.clone(),
            record,
        })
    }

    /// Writes the final state for [`FinalState`](super::final_state::FinalState), without the record of the steps.
    fn write_final(&self, restart: &Restart) -> Result<(), InputError> {
        self.checkpoint(restart, RecordState::default())?.write(&self.dir.join(FINAL_STATE_BITS))
    }

    fn elapsed(&self) -> f64 {
        self.seconds_before + self.started.elapsed().as_secs_f64()
    }

    fn finish(mut self, mut result: Result<solve::Solution, RunError>) -> Result<Outcome, RunError> {
        let seconds = self.elapsed();
        let (converged, status) = match &result {
            Ok(solution) => {
                let converged = solution.status == Status::Converged;
                (converged, observe::ending(solution.status, self.record.steps().last()))
            }
            Err(error) => (false, error.to_string()),
        };
        if let Ok(solution) = &result {
            let engine = solution.solver.engine();
            self.record.set_last(|| (snapshots(engine), observe::contact_sites(engine)));
            self.record.set_lines(observe::contact_lines(engine));
            self.record.set_failure(solution.failure.as_ref().map(Failure::to_string));
            // before the outputs, which take time
            if solution.status == Status::Stopped || (self.on_disk && !converged) {
                self.write()?;
            }
        }
        let ended = result.as_mut().ok().filter(|_| converged);
        let answers = ended.map(|solution| self.asked.answer(&mut solution.solver)).transpose();
        if let Ok(Some(answers)) = &answers {
            self.record.set_answers(answers.clone());
        }
        if let Some(solution) = result.as_ref().ok().filter(|_| converged) {
            self.write_final(&solution.restart(&self.stages))?;
        }
        let wanted = result.as_ref().ok().filter(|_| converged && self.estimates);
        let estimated = wanted.map(|solution| observe::estimate_error(&solution.solver)).transpose();
        if let Ok(Some(estimate)) = &estimated {
            self.record.set_error_estimate(estimate.clone());
        }
        // also without an estimate: the run itself has converged
        self.record.finish(converged && self.record.holds(), &status, seconds)?;
        let (error_estimate, answers) = (estimated?, answers?.unwrap_or_default());
        if converged && self.on_disk {
            // the outputs are complete; a checkpoint that cannot be removed does no harm
            std::fs::remove_file(&self.path).ok();
            self.on_disk = false;
        }
        let checkpoint = self.on_disk.then_some(self.path);
        result.map(|solution| Outcome {
            status: solution.status,
            failure: solution.failure,
            steps: self.record.steps().to_vec(),
            seconds,
            checkpoint,
            error_estimate,
            answers,
        })
    }
}

/// Geometry and fields of all rods, for files.
pub fn snapshots(engine: &Engine) -> Vec<RodSnapshot> {
    let fields = engine.all_nodal_fields();
    let smoothed = smoothed_contact_forces(engine, &fields);
    let snapshot = |(rod, (fields, smoothed_contact_force)): (usize, (NodalFields, Vec<Vec3>))| RodSnapshot {
        positions: engine.positions(rod).to_vec(),
        frames: engine.frames(rod).to_vec(),
        fields,
        smoothed_contact_force,
    };
    fields.into_iter().zip(smoothed).enumerate().map(snapshot).collect()
}
