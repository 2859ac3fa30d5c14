//! What the writers of a record read: the problem, the accepted steps, the last state, the end.

use std::path::{Path, PathBuf};

use crate::error::InputError;
use crate::io::asked::Answers;
use crate::io::detail::{every, within};
use crate::io::table::Columns;
use crate::math::{Quat, Vec3};
use crate::observe::ErrorEstimate;
use crate::observe::report::{LineSample, Observation, SiteReport};
use crate::scene::file::{OutputChoice, PictureChoice};
use crate::scene::{Obstacle, ObstaclePose, Scene, Units};
use crate::solve::NodalFields;

use super::rods::RodHead;

/// Contact sites listed for each step; more are counted, and listed for the final state in a file of their own.
pub const MAX_SITES: usize = 100;

/// Geometry and nodal fields of one rod in one state.
#[derive(Debug, Clone, Default)]
pub struct RodSnapshot {
    /// Node positions \[L\].
    pub positions: Vec<Vec3>,
    /// Node frames.
    pub frames: Vec<Quat>,
    /// Fields at the nodes.
    pub fields: NodalFields,
    /// Contact force per length at the nodes as it is shown, see
    /// [`smoothed_contact_forces`](crate::observe::smoothed_contact_forces) \[F/L\].
    pub smoothed_contact_force: Vec<Vec3>,
}

/// An accepted state, with all of its contact sites.
#[derive(Debug, Clone)]
pub(super) struct RecordedFrame {
    pub step: usize,
    /// In the order of the scene.
    pub rods: Vec<RodSnapshot>,
    pub sites: Vec<SiteReport>,
}

/// What is known at the end of a run only.
#[derive(Debug, Default)]
pub(super) struct Ending {
    pub converged: bool,
    pub status: String,
    pub seconds: f64,
    /// Why the run ended early.
    pub failure: Option<String>,
    /// Pressure along lines of contact in the final state.
    pub lines: Vec<LineSample>,
    /// An estimate of the final state's error.
    pub error_estimate: Option<ErrorEstimate>,
    /// What the tangent at the final state says.
    pub answers: Answers,
}

/// A run as its record sees it.
#[derive(Debug)]
pub(super) struct RecordedRun {
    pub dir: PathBuf,
    pub title: String,
    pub units: Units,
    pub output: OutputChoice,
    pub choice: PictureChoice,
    pub planar: bool,
    /// The rods at the start; see [`RecordedRun::head`].
    pub rods: Vec<RodHead>,
    pub obstacles: Vec<Obstacle>,
    /// Numbers of a step, for the table and as field data of VTK files.
    pub columns: Columns,
    /// Each with its strongest contact sites only.
    pub steps: Vec<Observation>,
    pub last: Option<RecordedFrame>,
    pub ending: Ending,
}

impl RecordedRun {
    /// A run of `scene` after these steps, in the folder `dir`, which is created if need be.
    ///
    /// # Errors
    /// [`InputError::Write`] if the folder cannot be created.
    pub fn open(scene: &Scene, dir: &Path, steps: Vec<Observation>) -> Result<Self, InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: dir.to_owned(), reason: e.to_string() };
        std::fs::create_dir_all(dir).map_err(refuse)?;
        Ok(Self {
            dir: dir.to_owned(),
            title: scene.title.clone(),
            units: scene.units.clone(),
            output: scene.output.clone(),
            choice: scene.picture.clone(),
            planar: scene.model.planar,
            rods: (0..scene.model.rods.len()).map(|rod| RodHead::of(scene, rod)).collect(),
            obstacles: scene.model.obstacles.clone(),
            columns: Columns::of_scene(scene),
            steps,
            last: None,
            ending: Ending::default(),
        })
    }

    /// Adds the report of an accepted state; its frame.
    pub fn add(&mut self, mut observation: Observation, rods: Vec<RodSnapshot>) -> RecordedFrame {
        let sites = std::mem::take(&mut observation.sites);
        observation.sites = strongest(&sites);
        let frame = RecordedFrame { step: self.steps.len(), rods, sites };
        self.steps.push(observation);
        frame
    }

    /// A rod with its length and radius in a step.
    pub fn head(&self, rod: usize, step: usize) -> RodHead {
        let mut head = self.rods[rod].clone();
        if let Some(size) = self.steps.get(step).and_then(|step| step.sizes.get(rod)) {
            (head.length, head.contact_radius) = (size.length, size.contact_radius);
        }
        head
    }

    /// All rods in a step.
    pub fn heads(&self, step: usize) -> Vec<RodHead> {
        (0..self.rods.len()).map(|rod| self.head(rod, step)).collect()
    }

    /// Nodes of a rod that go into a VTK file.
    pub fn vtk_nodes(&self, head: &RodHead, rod: &RodSnapshot) -> Vec<usize> {
        match self.output.node_tolerance {
            Some(tolerance) => within(&rod.positions, tolerance, self.output.node_every),
            None => every(rod.positions.len(), self.output.node_every, head.closed),
        }
    }
}

/// Where obstacles are in a step.
pub(in crate::io) fn placements(step: &Observation) -> Vec<ObstaclePose> {
    step.obstacle_reactions.iter().map(|reaction| reaction.placement).collect()
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
