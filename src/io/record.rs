//! Files of a run: tables, final state, VTK, pictures, summary; written from snapshots.

mod files;
mod modes;
mod pictures;
mod still;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::dna::base_pairs::{AtRest, BasePairs};
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::observe::ErrorEstimate;
use crate::observe::report::{Energies, LineSample, Observation, SiteReport};
use crate::scene::file::{OutputChoice, PictureChoice};
use crate::scene::{Obstacle, ObstaclePose, Scene, Units};
use crate::solve::NodalFields;
use crate::tangent::Harmonic;

use super::asked::{Answers, Sensitivity, TableSensitivity};
use super::csv::{RodState, state_text, write_state};
use super::detail::{every, within};
use super::fingerprint::Fingerprint;
use super::picture::obstacle::placed_lines;
use super::table::{Columns, Named, ResultantsOf, write_joints, write_lines, write_resultants, write_sites};
use super::view;
use super::vtk::{PvdWriter, VtkRod, VtkStep, write_obstacle_lines, write_vtp};
pub(super) use files::{BASE_PAIRS, FINAL_STATE_BITS, VIEW, check_finished, read_summary, step_of};
use still::Still;

/// Geometry and nodal fields of one rod in one state.
#[derive(Debug, Clone, Default)]
pub struct RodSnapshot {
    /// Node positions \[L\].
    pub positions: Vec<Vec3>,
    /// Node frames.
    pub frames: Vec<Quat>,
    /// Fields at the nodes.
    pub fields: NodalFields,
    /// Contact force per length at the nodes as it is shown, see [`smoothed_contact_forces`](crate::observe::smoothed_contact_forces) \[F/L\].
    pub smoothed_contact_force: Vec<Vec3>,
}

/// Data of each rod for the record.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct RodHead {
    pub name: String,
    length: f64,
    contact_radius: f64,
    /// Contact radius at each node of a rod along which it varies; empty for other rods.
    #[serde(skip)]
    radii: Vec<f64>,
    pub closed: bool,
    elements: usize,
    order: usize,
    nodes: usize,
    /// Turns of the double helix that the frames leave out, if any.
    #[serde(default, skip_serializing_if = "is_zero")]
    turns_left_out: f64,
    /// Stiffnesses at the start; none of a rod that has a full matrix of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stiffness: Option<SectionStiffness>,
}

fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Stiffnesses of a section.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct SectionStiffness {
    /// EI about d1 and d2 \[F·L²\].
    bending: [f64; 2],
    /// GJ \[F·L²\].
    twisting: f64,
    /// EA \[F\].
    stretching: f64,
    /// GA along d1 and d2 \[F\].
    shearing: [f64; 2],
}

impl RodHead {
    fn of(rod: &crate::rod::Rod) -> Self {
        Self {
            name: rod.name.clone(),
            length: rod.length,
            contact_radius: rod.section.contact_radius,
            radii: rod.contact_radii.as_ref().map_or_else(Vec::new, |radii| {
                (0..rod.num_nodes()).map(|node| radii.at(node as f64 * rod.spacing())).collect()
            }),
            closed: rod.closed,
            elements: rod.num_elements,
            order: rod.order,
            nodes: rod.num_nodes(),
            turns_left_out: rod.turns_left_out,
            stiffness: rod.stiffness.is_none().then_some(SectionStiffness {
                bending: rod.section.bending,
                twisting: rod.section.twisting,
                stretching: rod.section.stretching,
                shearing: rod.section.shearing,
            }),
        }
    }

    /// Reference length between neighbouring nodes.
    fn spacing(&self) -> f64 {
        self.length / (self.elements * self.order) as f64
    }

    /// Reference arc lengths of its first `count` nodes.
    fn arc_lengths(&self, count: usize) -> Vec<f64> {
        (0..count).map(|node| self.spacing() * node as f64).collect()
    }

    /// Largest radius it is drawn with; a rod without a contact radius is a thin line.
    pub fn radius(&self) -> f64 {
        if self.contact_radius > 0.0 { self.contact_radius } else { 2e-3 * self.length }
    }

    /// The like at a node.
    fn radius_at(&self, node: usize) -> f64 {
        self.radii.get(node).copied().unwrap_or_else(|| self.radius())
    }
}

/// `summary.json`.
#[derive(Debug, Clone, Serialize)]
struct SummaryFile<'a> {
    program: &'a str,
    /// See [`Fingerprint::model_hash`].
    model_hash: &'a str,
    /// Threads that the run was allowed.
    threads: usize,
    title: &'a str,
    units: &'a Units,
    rods: &'a [RodHead],
    #[serde(skip_serializing_if = "<[Obstacle]>::is_empty")]
    obstacles: &'a [Obstacle],
    converged: bool,
    status: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<&'a str>,
    seconds: f64,
    #[serde(rename = "final")]
    last: Option<&'a Observation>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimate: Option<&'a ErrorEstimate>,
    #[serde(skip_serializing_if = "Option::is_none")]
    modes: Option<modes::ModesPart>,
    #[serde(skip_serializing_if = "Option::is_none")]
    harmonic: Option<&'a [Harmonic; 2]>,
    #[serde(skip_serializing_if = "<[Sensitivity]>::is_empty")]
    sensitivities: &'a [Sensitivity],
    #[serde(skip_serializing_if = "<[TableSensitivity]>::is_empty")]
    table_sensitivities: &'a [TableSensitivity],
    #[serde(skip_serializing_if = "Option::is_none")]
    thermal: Option<Thermal>,
    steps: &'a [Observation],
}

/// Energies in units of kT, where units are nm and pN.
#[derive(Debug, Clone, Serialize)]
struct Thermal {
    /// K
    temperature: f64,
    /// pN·nm
    #[serde(rename = "kT")]
    thermal_energy: f64,
    /// Energies of every step, in kT.
    energies: Vec<Energies>,
}

/// Most frames kept for the film strip; then every other one is dropped.
const MAX_FILM: usize = 48;

/// Contact sites listed for each step; more are counted, and listed for the final state in a file of their own.
pub const MAX_SITES: usize = 100;

#[derive(Debug, Clone)]
struct RecordedFrame {
    step: usize,
    rods: Vec<RodSnapshot>,
    sites: Vec<SiteReport>,
}

/// Data of a record from which it can be resumed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct RecordState {
    steps: Vec<Observation>,
    film: Vec<Still>,
    stride: usize,
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
    dir: PathBuf,
    title: String,
    model_hash: String,
    threads: usize,
    units: Units,
    /// Temperature, K, and kT at it, pN·nm, where units are nm and pN.
    thermal: Option<(f64, f64)>,
    base_pairs: Vec<Option<AtRest>>,
    output: OutputChoice,
    choice: PictureChoice,
    planar: bool,
    rods: Vec<RodHead>,
    columns: Columns,
    /// Units of the arrays at the points of VTK files.
    point_units: [(&'static str, String); 9],
    steps: Vec<Observation>,
    film: Vec<Still>,
    stride: usize,
    last: Option<RecordedFrame>,
    lines: Vec<LineSample>,
    last_written: Option<usize>,
    pvd: PvdWriter,
    error_estimate: Option<ErrorEstimate>,
    answers: Answers,
    failure: Option<String>,
    obstacles: Vec<Obstacle>,
}

impl Record {
    /// A record of `scene` in the folder `dir`. Files of these names from an earlier run are removed, because a folder
    /// holds one run.
    ///
    /// # Errors
    /// [`InputError::Write`] if the folder cannot be created, or a file of an earlier run cannot be removed.
    pub fn new(scene: &Scene, dir: &Path) -> Result<Self, InputError> {
        let record = Self::open(scene, dir)?;
        files::remove_all(dir)?;
        Ok(record)
    }

    fn open(scene: &Scene, dir: &Path) -> Result<Self, InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: dir.to_owned(), reason: e.to_string() };
        std::fs::create_dir_all(dir).map_err(refuse)?;
        Ok(Self {
            point_units: point_units(&scene.units),
            dir: dir.to_owned(),
            title: scene.title.clone(),
            model_hash: Fingerprint::of(scene).model_hash(),
            threads: scene.solver.threads.unwrap_or_else(all_threads),
            units: scene.units.clone(),
            thermal: scene.thermal(),
            base_pairs: scene.base_pairs.clone(),
            output: scene.output.clone(),
            choice: scene.picture.clone(),
            planar: scene.model.planar,
            obstacles: scene.model.obstacles.clone(),
            rods: scene.model.rods.iter().map(RodHead::of).collect(),
            columns: Columns::of_scene(scene),
            steps: Vec::new(),
            film: Vec::new(),
            stride: 1,
            last: None,
            lines: Vec::new(),
            last_written: None,
            pvd: PvdWriter::new(dir.join(files::COLLECTION)),
            error_estimate: None,
            answers: Answers::default(),
            failure: None,
        })
    }

    /// Resumes the record of an earlier run of the same scene.
    ///
    /// # Errors
    /// [`InputError::Write`] if the folder cannot be created.
    pub fn resume(scene: &Scene, dir: &Path, state: RecordState) -> Result<Self, InputError> {
        let fresh = Self::open(scene, dir)?;
        let RecordState { steps, film, stride, last_written, collection } = state;
        let pvd = PvdWriter::resume(dir.join(files::COLLECTION), collection);
        Ok(Self { steps, film, stride: stride.max(1), last_written, pvd, ..fresh })
    }

    /// The input of [`Record::resume`].
    pub fn state(&self) -> RecordState {
        RecordState {
            steps: self.steps.clone(),
            film: self.film.clone(),
            stride: self.stride,
            last_written: self.last_written,
            collection: self.pvd.entries().to_owned(),
        }
    }

    /// The steps so far.
    pub fn steps(&self) -> &[Observation] {
        &self.steps
    }

    /// Whether the last state has no overlaps and all checks of its certificate hold.
    pub fn holds(&self) -> bool {
        self.steps.last().is_none_or(|last| !last.overlaps() && !last.fails())
    }

    /// A rod with its length and radius in a step.
    fn head(&self, rod: usize, step: usize) -> RodHead {
        let head = self.rods[rod].clone();
        match self.steps.get(step).and_then(|step| step.sizes.get(rod)) {
            Some(size) => RodHead { length: size.length, contact_radius: size.contact_radius, ..head },
            None => head,
        }
    }

    /// Adds an accepted state and writes its VTK file if due; `rods` in the order of the scene.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn push(&mut self, mut observation: Observation, rods: Vec<RodSnapshot>) -> Result<(), InputError> {
        let sites = std::mem::take(&mut observation.sites);
        observation.sites = strongest(&sites);
        let frame = RecordedFrame { step: self.steps.len(), rods, sites };
        self.steps.push(observation);
        if self.output.vtk && frame.step.is_multiple_of(self.output.every) {
            self.write_vtk(&frame)?;
        }
        if self.output.picture && frame.step.is_multiple_of(self.stride) {
            self.film.push(self.still(&frame, true));
            if self.film.len() == MAX_FILM {
                self.stride *= 2;
                self.film.retain(|kept| kept.step.is_multiple_of(self.stride));
            }
        }
        self.last = Some(frame);
        Ok(())
    }

    /// Sets the last state of a resumed record without new states.
    pub(super) fn set_last(&mut self, rods: impl FnOnce() -> (Vec<RodSnapshot>, Vec<SiteReport>)) {
        if let (None, Some(step)) = (&self.last, self.steps.len().checked_sub(1)) {
            let (rods, sites) = rods();
            self.last = Some(RecordedFrame { step, rods, sites });
        }
    }

    /// Sets the pressure along lines of contact in the final state.
    pub(crate) fn set_lines(&mut self, lines: Vec<LineSample>) {
        self.lines = lines;
    }

    /// Sets the reason why the run ended early, for the summary.
    pub fn set_failure(&mut self, failure: Option<String>) {
        self.failure = failure;
    }

    /// Sets an estimate of the final state's error, for the summary.
    pub(crate) fn set_error_estimate(&mut self, estimate: ErrorEstimate) {
        self.error_estimate = Some(estimate);
    }

    /// Sets what the tangent at the final state says.
    pub(crate) fn set_answers(&mut self, answers: Answers) {
        self.answers = answers;
    }

    /// Writes the remaining files; `status` describes how the run ended.
    ///
    /// # Errors
    /// [`InputError::Write`] if a file cannot be written.
    pub fn finish(&mut self, converged: bool, status: &str, seconds: f64) -> Result<(), InputError> {
        let names: Vec<String> = self.rods.iter().map(|rod| rod.name.clone()).collect();
        self.columns.write(&self.dir.join(files::TABLE), &self.steps)?;
        self.write_summary(converged, status, seconds)?;
        self.write_base_pairs()?;
        let Some(last) = self.last.take() else { return Ok(()) };
        write_state(&self.dir.join(files::FINAL_STATE), &self.rod_states(&last), &self.units)?;
        self.write_resultants(&last)?;
        let lengths: Vec<f64> = (0..self.rods.len()).map(|rod| self.head(rod, last.step).length).collect();
        let on_obstacles = self.steps.get(last.step).map_or(&[][..], |step| &step.obstacle_sites);
        let obstacles: Vec<String> = self.obstacles.iter().map(|obstacle| obstacle.name.clone()).collect();
        let named = Named { rods: &names, lengths: &lengths, obstacles: &obstacles, units: &self.units };
        write_sites(&self.dir.join(files::SITES), &last.sites, on_obstacles, named)?;
        if !self.lines.is_empty() {
            write_lines(&self.dir.join(files::LINES), &self.lines, named)?;
        }
        let joints = self.steps.get(last.step).map_or(&[][..], |step| &step.joints);
        if !joints.is_empty() {
            let arcs: Vec<Vec<f64>> = (0..self.rods.len()).map(|rod| self.arcs(rod, last.step)).collect();
            write_joints(&self.dir.join(files::JOINTS), joints, &arcs, named)?;
        }
        if self.output.vtk && self.last_written != Some(last.step) {
            self.write_vtk(&last)?;
        }
        self.write_modes(&last)?;
        self.write_sensitivities()?;
        if self.output.picture {
            self.write_pictures(&last)?;
        }
        if self.output.vtk && self.output.view {
            let rods: Vec<RodHead> = (0..self.rods.len()).map(|rod| self.head(rod, last.step)).collect();
            let (title, units) = (self.title.as_str(), &self.units);
            let run = view::Parts { title, units, rods: &rods, obstacles: &self.obstacles, steps: &self.steps };
            view::film(&self.dir, &run, view::MAX_NODES)?.save_page(&self.dir.join(files::VIEW))?;
        }
        self.last = Some(last);
        Ok(())
    }

    /// Arc lengths of the nodes of a rod in a step.
    fn arcs(&self, rod: usize, step: usize) -> Vec<f64> {
        let head = self.head(rod, step);
        head.arc_lengths(head.nodes)
    }

    fn write_base_pairs(&self) -> Result<(), InputError> {
        let rods = self.base_pairs.iter().enumerate();
        let rods: Vec<_> = rods.filter_map(|(rod, pairs)| Some((rod, pairs.as_ref()?))).collect();
        if rods.is_empty() {
            return Ok(());
        }
        BasePairs::write(&self.dir.join(files::BASE_PAIRS), AtRest::table(rods.into_iter()))
    }

    fn write_summary(&self, converged: bool, status: &str, seconds: f64) -> Result<(), InputError> {
        let path = self.dir.join(files::SUMMARY);
        let (title, units, rods, steps) = (&self.title, &self.units, &self.rods, &self.steps);
        let (last, error_estimate) = (steps.last(), self.error_estimate.as_ref());
        let failure = self.failure.as_deref();
        let program = env!("CARGO_PKG_VERSION");
        let thermal = self.thermal.map(|(temperature, thermal_energy)| {
            let energies = steps.iter().map(|step| step.energies.over(thermal_energy)).collect();
            Thermal { temperature, thermal_energy, energies }
        });
        let summary = SummaryFile {
            program,
            model_hash: &self.model_hash,
            threads: self.threads,
            title,
            units,
            rods,
            obstacles: &self.obstacles,
            converged,
            status,
            failure,
            seconds,
            last,
            error_estimate,
            modes: self.answers.modes.as_ref().map(modes::ModesPart::of),
            harmonic: self.answers.harmonic.as_ref(),
            sensitivities: &self.answers.sensitivities,
            table_sensitivities: &self.answers.tables,
            thermal,
            steps,
        };
        let refuse = |reason: String| InputError::Write { path: path.clone(), reason };
        let text = serde_json::to_string_pretty(&summary).map_err(|e| refuse(e.to_string()))?;
        std::fs::write(&path, text).map_err(|e| refuse(e.to_string()))
    }

    /// The last state as text, see [`state_text`].
    pub(crate) fn nodal_state(&self) -> Result<String, InputError> {
        state_text(&self.last.as_ref().map_or_else(Vec::new, |last| self.rod_states(last)))
    }

    fn write_resultants(&self, last: &RecordedFrame) -> Result<(), InputError> {
        let rods = last.rods.iter().enumerate().filter(|(_, rod)| !rod.fields.curvature.is_empty());
        let rods: Vec<ResultantsOf> = rods
            .map(|(index, rod)| ResultantsOf {
                name: &self.rods[index].name,
                arc_lengths: self.head(index, last.step).arc_lengths(rod.frames.len()),
                frames: &rod.frames,
                fields: &rod.fields,
                contact_force: &rod.smoothed_contact_force,
            })
            .collect();
        write_resultants(&self.dir.join(files::RESULTANTS), &rods, &self.units)
    }

    fn rod_states(&self, last: &RecordedFrame) -> Vec<RodState> {
        let state = |(index, rod): (usize, &RodSnapshot)| {
            let head = self.head(index, last.step);
            RodState {
                arc_lengths: head.arc_lengths(head.nodes),
                positions: rod.positions.clone(),
                frames: rod.frames.clone(),
            }
        };
        last.rods.iter().enumerate().map(state).collect()
    }

    fn write_vtk(&mut self, frame: &RecordedFrame) -> Result<(), InputError> {
        let vtk = |(index, rod): (usize, &RodSnapshot)| {
            let head = self.head(index, frame.step);
            let kept = self.vtk_nodes(&head, rod);
            let axis = |axis: Vec3| kept.iter().map(|&i| rod.frames[i] * axis).collect::<Vec<_>>();
            let scalar = |values: &[f64]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
            let vector = |values: &[Vec3]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
            let (fields, spacing) = (&rod.fields, head.spacing());
            let is_end = |i: usize| !head.closed && (i == 0 || i + 1 == head.nodes);
            let share = |i: usize| if is_end(i) { 0.5 * spacing } else { spacing };
            let vectors = vec![
                ("d1", axis(Vec3::x())),
                ("d2", axis(Vec3::y())),
                ("d3", axis(Vec3::z())),
                ("smoothed_contact_force_per_length", vector(&rod.smoothed_contact_force)),
                ("contact_force_on_node", kept.iter().map(|&i| fields.contact_force[i] * share(i)).collect()),
                ("internal_force", vector(&fields.internal_force)),
                ("internal_moment", vector(&fields.internal_moment)),
            ];
            let scalars = vec![
                ("arc_length", kept.iter().map(|&i| spacing * i as f64).collect()),
                ("radius", kept.iter().map(|&i| head.radius_at(i)).collect()),
                ("curvature", scalar(&fields.curvature)),
                ("twist_rate", scalar(&fields.twist_rate)),
            ];
            (vector(&rod.positions), VtkRod { points: &[], closed: head.closed, scalars, vectors })
        };
        let (points, rods): (Vec<Vec<Vec3>>, Vec<VtkRod>) = frame.rods.iter().enumerate().map(vtk).unzip();
        let rods: Vec<VtkRod> = points.iter().zip(rods).map(|(points, rod)| VtkRod { points, ..rod }).collect();
        let path = self.dir.join(files::of_step(frame.step));
        write_vtp(&path, &rods, &self.vtk_step(&self.steps[frame.step]))?;
        self.last_written = Some(frame.step);
        let mut paths = vec![path];
        if !self.obstacles.is_empty() {
            paths.push(self.dir.join(files::of_obstacles(frame.step)));
            let points = || frame.rods.iter().flat_map(|rod| &rod.positions);
            let placed = self.obstacles.iter().zip(placements(&self.steps[frame.step])).enumerate();
            let lines: Vec<(usize, [Vec3; 2])> = placed
                .flat_map(|(k, (obstacle, pose))| {
                    placed_lines(obstacle, &pose, points()).into_iter().map(move |line| (k, line))
                })
                .collect();
            write_obstacle_lines(&paths[1], &lines, &VtkStep::default())?;
        }
        let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
        self.pvd.push(frame.step as f64, &paths)
    }

    /// Field data of a step's VTK file: the numbers of the table, how far the run is, units.
    fn vtk_step<'a>(&'a self, step: &'a Observation) -> VtkStep<'a> {
        let (time, value) = self.columns.progress(step);
        let mut told = VtkStep { numbers: vec![("TimeValue", value)], units: vec![("TimeValue", time)] };
        for (name, unit, value) in self.columns.numbers(step) {
            told.numbers.push((name, value));
            told.units.extend((!unit.is_empty()).then_some((name, unit)));
        }
        told.units.extend(self.point_units.iter().map(|(name, unit)| (*name, unit.as_str())));
        told
    }

    /// Nodes that go into a VTK file.
    fn vtk_nodes(&self, head: &RodHead, rod: &RodSnapshot) -> Vec<usize> {
        match self.output.node_tolerance {
            Some(tolerance) => within(&rod.positions, tolerance, self.output.node_every),
            None => every(rod.positions.len(), self.output.node_every, head.closed),
        }
    }
}

/// Units of the arrays at the points of VTK files.
fn point_units(units: &Units) -> [(&'static str, String); 9] {
    const DIMENSIONS: [(&str, &str); 9] = [
        ("Points", "L"),
        ("arc_length", "L"),
        ("radius", "L"),
        ("curvature", "1/L"),
        ("twist_rate", "rad/L"),
        ("smoothed_contact_force_per_length", "F/L"),
        ("contact_force_on_node", "F"),
        ("internal_force", "F"),
        ("internal_moment", "F L"),
    ];
    DIMENSIONS.map(|(name, dimension)| (name, units.of(dimension)))
}

/// Where obstacles are in a step.
pub(super) fn placements(step: &Observation) -> Vec<ObstaclePose> {
    step.obstacle_reactions.iter().map(|reaction| reaction.placement).collect()
}

/// Threads of a run that says nothing about them.
fn all_threads() -> usize {
    if cfg!(feature = "parallel") { std::thread::available_parallelism().map_or(1, usize::from) } else { 1 }
}

/// The [`MAX_SITES`] sites with the largest forces, in their original order.
fn strongest(sites: &[SiteReport]) -> Vec<SiteReport> {
    let mut order: Vec<usize> = (0..sites.len()).collect();
    if sites.len() > MAX_SITES {
        order.sort_by(|&i, &j| sites[j].force.total_cmp(&sites[i].force).then(i.cmp(&j)));
        order.truncate(MAX_SITES);
        order.sort_unstable();
    }
    order.into_iter().map(|i| sites[i].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::table::tests::observation;
    use super::*;
    use crate::observe::report::{SiteKind, SiteReport};

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
        let last = record.still(record.last.as_ref().unwrap(), true);
        assert_eq!(record.strip(&last).iter().map(|f| f.step).collect::<Vec<_>>(), [0, 20, 40, 60, 80, 99]);
        assert!(record.film.len() < MAX_FILM);
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
