//! Files of a run: tables, final state, VTK, pictures, summary. Each kind has a `Writer` in a file of its own.

mod base_pairs;
mod files;
mod final_state;
mod interactions;
mod modes;
mod page;
mod pictures;
mod resultants;
mod rods;
mod run;
mod sensitivities;
mod summary;
mod table;
mod vtk;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::observe::ErrorEstimate;
use crate::observe::report::{LineSample, Observation, SiteReport};
use crate::scene::Scene;

use super::asked::Answers;
use super::csv::state_text;
use super::view::GlbOptions;
pub(super) use files::{BASE_PAIRS, FINAL_STATE_BITS, VIEW, check_finished, read_summary, step_of};
use pictures::still::Still;
pub(super) use rods::RodHead;
pub(super) use run::placements;
pub use run::{MAX_SITES, RodSnapshot};
use run::{RecordedFrame, RecordedRun};

/// Writes the files of one kind.
trait Writer: fmt::Debug + Send + Sync {
    /// After each accepted state.
    fn step(&mut self, _run: &RecordedRun, _frame: &RecordedFrame) -> Result<(), InputError> {
        Ok(())
    }

    /// At the end of the run, even if no state was accepted.
    fn end(&mut self, _run: &RecordedRun) -> Result<(), InputError> {
        Ok(())
    }

    /// At the end of the run, of the last accepted state.
    fn last(&mut self, _run: &RecordedRun, _last: &RecordedFrame) -> Result<(), InputError> {
        Ok(())
    }

    /// Puts into `state` what the writer needs to be resumed.
    fn save(&self, _state: &mut RecordState) {}
}

/// The writers of a run, in the order in which they write. The page is the last, because it shows files of the others.
fn writers(scene: &Scene, dir: &Path, state: RecordState) -> Vec<Box<dyn Writer>> {
    vec![
        Box::new(table::TableWriter),
        Box::new(summary::SummaryWriter::new(scene)),
        Box::new(base_pairs::BasePairsWriter::new(scene)),
        Box::new(final_state::FinalStateWriter),
        Box::new(resultants::ResultantsWriter),
        Box::new(interactions::InteractionsWriter),
        Box::new(vtk::VtkWriter::new(&scene.units, dir, state.last_written, state.collection)),
        Box::new(modes::ModesWriter),
        Box::new(sensitivities::SensitivitiesWriter),
        Box::new(pictures::PictureWriter),
        Box::new(pictures::FilmStripWriter::new(state.film, state.stride)),
        Box::new(pictures::WrithePlotWriter),
        Box::new(page::PageWriter),
    ]
}

/// Data of a record from which it can be resumed; the default is a record without steps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordState {
    steps: Vec<Observation>,
    film: Vec<Still>,
    /// Steps from one frame of the film to the next.
    stride: usize,
    /// Last step with a VTK file.
    last_written: Option<usize>,
    /// Entries of the `.pvd` collection.
    collection: String,
}

/// Writes the files of a run into a folder, which is created if need be:
///
/// | file | content |
/// |---|---|
/// | `step_0000.vtp` …, `run.pvd` | centrelines for ParaView: at the nodes frame, arc length, radius, curvature, twist rate, contact force, internal force and moment; as field data the numbers of the table's line, `TimeValue` (the first quantity that stages ramp), `units` |
/// | `obstacles_0000.vtp` … | lines that show planes and obstacles where they are, the second part of `run.pvd`; cell data `obstacle` is the index |
/// | `table.csv` | one line per accepted step |
/// | `final_state.csv` | positions and quaternions of all nodes |
/// | `resultants.csv` | internal forces and moments at the nodes of the final state, in their frames |
/// | `sites.csv` | all contact sites of the final state |
/// | `lines.csv` | lines of contact in the final state: pressure and gap along them |
/// | `joints.csv` | forces and moments of joints on the rods in the final state, a line for each joined node |
/// | `base_pairs.csv` | of rods with a sequence: the bases, their places on the rod and the steps between them at rest, for [`export`](super::export) |
/// | `table_columns.csv`, `final_state_columns.csv`, `resultants_columns.csv`, `sites_columns.csv`, `lines_columns.csv`, `joints_columns.csv` | name, unit and meaning of the columns of each table |
/// | `scene_as_run.toml` | a copy of the scene file, with its path and the program's version (written by [`SceneRun::start`](super::run::SceneRun::start)) |
/// | `summary.json` | version, model hash, threads, rods with their stiffnesses; every observation of every step, and the final state (with an estimate of its error if requested; energies also in kT where units are nm and pN, see [`Scene::thermal`]); of contact sites the [`MAX_SITES`] strongest |
/// | `picture.png`, `filmstrip.png` | final shape; six states on the way |
/// | `final_state.bin` | the final state bit for bit, for `supercoil modes`, `sensitivity`, `free-energy`, `j-factor` |
/// | `modes.vtp`, `modes.png`, `modes.html` | if requested: the softest modes of the final state, at the nodes the displacements `mode_1` … and rotations `mode_1_rotation` …; eigenvalues as field data; a picture of each; a page that shows them swing |
/// | `sensitivities.csv` | if requested: derivatives of observables |
/// | `view.html` | a page for the browser: the run to turn and to step through (from the `.vtp` files: without them there is none) |
/// | `writhe.svg` | writhe and twist against excess link, where a closed rod's changes |
#[derive(Debug)]
pub struct Record {
    run: RecordedRun,
    writers: Vec<Box<dyn Writer>>,
}

impl Record {
    /// A record of `scene` in the folder `dir`. Files of these names from an earlier run are removed, because a folder
    /// holds one run.
    ///
    /// # Errors
    /// [`InputError::Write`] if the folder cannot be created, or a file of an earlier run cannot be removed.
    pub fn new(scene: &Scene, dir: &Path) -> Result<Self, InputError> {
        let record = Self::resume(scene, dir, RecordState::default())?;
        files::remove_all(dir)?;
        Ok(record)
    }

    /// Resumes the record of an earlier run of the same scene.
    ///
    /// # Errors
    /// [`InputError::Write`] if the folder cannot be created.
    pub fn resume(scene: &Scene, dir: &Path, mut state: RecordState) -> Result<Self, InputError> {
        let run = RecordedRun::open(scene, dir, std::mem::take(&mut state.steps))?;
        Ok(Self { run, writers: writers(scene, dir, state) })
    }

    /// The input of [`Record::resume`].
    pub fn state(&self) -> RecordState {
        let mut state = RecordState { steps: self.run.steps.clone(), ..RecordState::default() };
        self.writers.iter().for_each(|writer| writer.save(&mut state));
        state
    }

    /// The steps so far.
    pub fn steps(&self) -> &[Observation] {
        &self.run.steps
    }

    /// Whether the last state has no overlaps and all checks of its certificate hold.
    pub fn holds(&self) -> bool {
        self.run.steps.last().is_none_or(|last| !last.overlaps() && !last.fails())
    }

    /// Adds an accepted state and writes its VTK file if due; `rods` in the order of the scene.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn push(&mut self, observation: Observation, rods: Vec<RodSnapshot>) -> Result<(), InputError> {
        let frame = self.run.add(observation, rods);
        self.writers.iter_mut().try_for_each(|writer| writer.step(&self.run, &frame))?;
        self.run.last = Some(frame);
        Ok(())
    }

    /// Sets the last state of a resumed record without new states.
    pub(super) fn set_last(&mut self, rods: impl FnOnce() -> (Vec<RodSnapshot>, Vec<SiteReport>)) {
        if let (None, Some(step)) = (&self.run.last, self.run.steps.len().checked_sub(1)) {
            let (rods, sites) = rods();
            self.run.last = Some(RecordedFrame { step, rods, sites });
        }
    }

    /// Sets the pressure along lines of contact in the final state.
    pub(crate) fn set_lines(&mut self, lines: Vec<LineSample>) {
        self.run.ending.lines = lines;
    }

    /// Sets the reason why the run ended early, for the summary.
    pub fn set_failure(&mut self, failure: Option<String>) {
        self.run.ending.failure = failure;
    }

    /// Sets an estimate of the final state's error, for the summary.
    pub(crate) fn set_error_estimate(&mut self, estimate: ErrorEstimate) {
        self.run.ending.error_estimate = Some(estimate);
    }

    /// Sets what the tangent at the final state says.
    pub(crate) fn set_answers(&mut self, answers: Answers) {
        self.run.ending.answers = answers;
    }

    /// Writes the remaining files; `status` describes how the run ended.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn finish(&mut self, converged: bool, status: &str, seconds: f64) -> Result<(), InputError> {
        let ending = &mut self.run.ending;
        (ending.converged, ending.status, ending.seconds) = (converged, status.to_owned(), seconds);
        let Self { run, writers } = self;
        writers.iter_mut().try_for_each(|writer| writer.end(run))?;
        let Some(last) = &run.last else { return Ok(()) };
        writers.iter_mut().try_for_each(|writer| writer.last(run, last))
    }

    /// The last state as text, see [`state_text`].
    pub(crate) fn nodal_state(&self) -> Result<String, InputError> {
        let last = self.run.last.as_ref();
        state_text(&last.map_or_else(Vec::new, |last| final_state::rod_states(&self.run, last)))
    }

    /// Writes answers for the final state of a run, whose other files stay as they are, and with `glb` the modes as a
    /// binary glTF file. Returns their paths.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn write_answers(
        scene: &Scene,
        dir: &Path,
        rods: Vec<RodSnapshot>,
        (answers, glb): (Answers, Option<&Path>),
    ) -> Result<Vec<PathBuf>, InputError> {
        let mut run = RecordedRun::open(scene, dir, Vec::new())?;
        run.ending.answers = answers;
        let frame = RecordedFrame { step: 0, rods, sites: Vec::new() };
        let mut written = modes::write(&run, &frame)?;
        if let (Some(file), Some(modes)) = (glb, &run.ending.answers.modes) {
            modes::film(&run, &frame, modes).save_glb(file, &GlbOptions::default())?;
            written.push(file.to_owned());
        }
        written.extend(sensitivities::write(&run)?);
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::observation;
    use super::*;
    use crate::math::Vec3;
    use crate::observe::report::SiteKind;
    use crate::solve::NodalFields;

    const SCENE: &str = r#"
        title = "record"
        [[rods]]
        name = "ring"
        closed = true
        shape = { kind = "circle", length = 6.0 }
        section = { bending = 1.0, twisting = 1.0, stretching = 1.0, shearing = 1.0, contact_radius = 0.1 }
        elements = 10
        order = 2
        [[stages]]
        ramp = { excess_link = { to = 1.0 } }
        steps = 100
        [output]
        every = 40
    "#;

    #[test]
    fn a_run_leaves_its_files() {
        let dir = std::env::temp_dir().join(format!("supercoil_record_{}", std::process::id()));
        let scene = Scene::from_toml(SCENE, Path::new("")).unwrap();
        let mut record = Record::new(&scene, &dir).unwrap();
        let rod = &scene.model.rods[0];
        let snapshot = RodSnapshot {
            positions: rod.positions.clone(),
            frames: rod.frames.clone(),
            fields: NodalFields {
                curvature: vec![1.0; 20],
                twist_rate: vec![0.0; 20],
                contact_force: vec![Vec3::zeros(); 20],
                internal_force: vec![Vec3::zeros(); 20],
                internal_moment: vec![Vec3::zeros(); 20],
            },
            smoothed_contact_force: vec![Vec3::zeros(); 20],
        };
        let site = SiteReport {
            rod_a: 0,
            arc_a: [5.9, 0.1],
            rod_b: 0,
            arc_b: [3.0, 3.1],
            kind: SiteKind::Point,
            gap: 0.0,
            force: 1.0,
            center: [0.0, 3.05],
            spread: [0.05, 0.02],
            angle: 90.0,
            force_on_a: [0.0, 0.0, 1.0],
            moment_on_a: [0.0; 3],
            feet: [[0.0; 3]; 2],
        };
        for step in 0..100 {
            let sites = vec![site.clone()];
            record.push(Observation { sites, num_sites: 1, ..observation(step) }, vec![snapshot.clone()]).unwrap();
        }
        record.finish(true, "converged", 1.0).unwrap();
        let names = ["step_0000.vtp", "step_0040.vtp", "step_0080.vtp", "step_0099.vtp", "run.pvd", "table.csv"];
        for name in
            names.into_iter().chain(["final_state.csv", "summary.json", "picture.png", "filmstrip.png", "writhe.svg"])
        {
            assert!(dir.join(name).metadata().unwrap().len() > 100, "{name}");
        }
        let film: Vec<usize> = record.state().film.iter().map(|still| still.step).collect();
        assert_eq!(film, (0..100).step_by(4).collect::<Vec<_>>());
        let text = std::fs::read_to_string(dir.join("summary.json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(json["steps"].as_array().unwrap().len(), 100);
        assert_eq!((json["final"]["step"].as_u64(), json["rods"][0]["nodes"].as_u64()), (Some(99), Some(20)));
        // the next run in the folder starts with none of them, but with what others have put there; one that goes on
        // keeps them
        let foreign = ["notes.txt", "step_1.vtp", "step_0001.vtp.bak"];
        foreign.iter().for_each(|name| std::fs::write(dir.join(name), "mine").unwrap());
        let names = || {
            let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
            std::fs::read_dir(&dir).unwrap().map(name).collect::<std::collections::BTreeSet<_>>()
        };
        let before = names();
        let _ = Record::resume(&scene, &dir, RecordState::default()).unwrap();
        assert_eq!(names(), before);
        let _ = Record::new(&scene, &dir).unwrap();
        assert_eq!(names(), foreign.map(String::from).into());
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
