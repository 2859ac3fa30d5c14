//! The run of a scene with the report of every accepted state: that of the program, of sweeps and of Python.

use std::ops::ControlFlow;

use crate::error::InputError;
use crate::observe::report::{Linking, Observation};
use crate::observe::{EndLinks, mesh_note, observe};
use crate::scene::file::{FollowChoice, FollowStart};
use crate::scene::{Ramp, Scene, Stage};
use crate::solve::{
    self, Engine, FollowOptions, Options, PathEnd, PathPoint, PointKind, Progress, Restart, RunError, Solution, Start,
    Status, Waypoint,
};

/// An accepted state of the run of a scene.
#[derive(Debug)]
pub struct ReportedState<'a> {
    /// Its report, with all notes.
    pub observation: Observation,
    /// The problem in this state.
    pub engine: &'a Engine,
    /// From where the run may be taken up; `None` on a path that is followed.
    pub waypoint: Option<&'a Waypoint<'a>>,
}

/// Runs the stages of a scene, the last one as a path if the scene follows it; `see` is called for the start and every
/// accepted state. A run is taken up at `from`, after the states with the reports `before`.
///
/// # Errors
/// As [`solve::run_from`]; a stage that is followed, but is more than one ramp.
pub fn run_observed(
    scene: &Scene,
    options: &Options,
    (from, before): (Option<Restart>, &[Observation]),
    see: &mut dyn FnMut(ReportedState) -> ControlFlow<()>,
) -> Result<Solution, RunError> {
    let path = FollowedStage::of(scene)?;
    let stepped = path.as_ref().map_or(&scene.stages[..], |path| &scene.stages[..path.index]);
    let mut reporter = StateReporter {
        scene,
        links: EndLinks::new(&scene.model, &scene.stages),
        first: before.first().cloned(),
        num_steps: before.len(),
    };
    let mut solution = solve::run_from(scene.model.clone(), stepped, options, from, &mut |progress, waypoint| {
        let observation = reporter.report(observe(progress), None);
        see(ReportedState { observation, engine: progress.engine, waypoint: Some(waypoint) })
    })?;
    if let Some(path) = path.filter(|_| solution.status == Status::Converged) {
        path.follow(&mut solution, &mut reporter, see)?;
    }
    Ok(solution)
}

/// A last stage whose path is followed.
struct FollowedStage<'a> {
    index: usize,
    choice: FollowChoice,
    ramp: &'a Ramp,
}

impl<'a> FollowedStage<'a> {
    /// The last stage of a scene, if the scene follows it.
    fn of(scene: &'a Scene) -> Result<Option<Self>, InputError> {
        let (Some(choice), Some(last)) = (scene.follow, scene.stages.last()) else { return Ok(None) };
        let index = scene.stages.len() - 1;
        let reason = "follows one ramp; nodes are held and released by a stage of their own";
        let refused = || InputError::inconsistent(format!("stages[{index}].follow"), reason);
        let ramp = last.only_ramp().ok_or_else(refused)?;
        Ok(Some(Self { index, choice, ramp }))
    }

    /// Follows the path from a solution.
    fn follow(
        &self,
        solution: &mut Solution,
        reporter: &mut StateReporter,
        see: &mut dyn FnMut(ReportedState) -> ControlFlow<()>,
    ) -> Result<(), RunError> {
        let Self { index, choice, ramp } = self;
        let before = reporter.num_steps;
        let options = FollowOptions {
            start: match choice.start {
                FollowStart::Towards => Start::Towards,
                FollowStart::Away => Start::Away,
                FollowStart::Branch => Start::Branch { forwards: true },
                FollowStart::OtherBranch => Start::Branch { forwards: false },
            },
            step: choice.step,
            max_step: choice.max_step,
            max_points: choice.max_points,
            ..FollowOptions::default()
        };
        let mut given = solution.given.clone();
        given.only_stable = false;
        given.stages.push(Stage::new(vec![(*ramp).clone()], 1));
        let report = solution.solver.follow(ramp, &options, &mut |point: &PathPoint| {
            // the start is the final state of the stages before
            if point.kind == PointKind::Start {
                return ControlFlow::Continue(());
            }
            let progress = Progress { given: Some(&given), stage: *index, ..point.progress };
            let observation = Observation { step: reporter.num_steps, ..observe(&progress) };
            let observation = reporter.report(observation, kind_in_words(point));
            see(ReportedState { observation, engine: point.engine(), waypoint: None })
        })?;
        solution.status = match report.end {
            PathEnd::Target | PathEnd::MaxPoints => Status::Converged,
            PathEnd::Stopped => Status::Stopped,
            _ => Status::StepTooSmall,
        };
        solution.num_steps += reporter.num_steps - before;
        solution.iterations += report.iterations;
        Ok(())
    }
}

/// Adds the notes that need more than one state.
struct StateReporter<'a> {
    scene: &'a Scene,
    links: EndLinks,
    /// Of the start.
    first: Option<Observation>,
    num_steps: usize,
}

impl StateReporter<'_> {
    fn report(&mut self, mut now: Observation, kind: Option<String>) -> Observation {
        let notes = self.links.notes(&now, self.first.as_ref());
        now.notes.extend(notes);
        now.notes.extend(self.scene.fidelity.and_then(|fidelity| mesh_note(fidelity, &now)));
        now.notes.extend(kind);
        if let Some(first) = &self.first {
            let changed = self.changes(first, &now);
            now.notes.extend(changed);
        }
        self.num_steps += 1;
        self.first.get_or_insert_with(|| now.clone());
        now
    }

    /// Knots and links of rods that are no longer those of the start, in words.
    fn changes(&self, first: &Observation, now: &Observation) -> Vec<String> {
        let name = |rod: usize| self.scene.model.rods[rod].name.as_str();
        let knots = now.knots.iter().filter_map(|knot| {
            let before = first.knots.iter().find(|before| before.rod == knot.rod)?;
            let kept = (before.determinant, before.at_third) == (knot.determinant, knot.at_third);
            (!kept).then(|| format!("rod \"{}\" was the knot {} and is {} now", name(knot.rod), before.name, knot.name))
        });
        let linking = now.linking.iter().filter_map(|pair| {
            let is_it = |other: &&Linking| (other.rod_a, other.rod_b) == (pair.rod_a, pair.rod_b);
            let before = first.linking.iter().find(is_it)?;
            let (a, b) = (name(pair.rod_a), name(pair.rod_b));
            (before.link != pair.link).then(|| {
                format!("rods \"{a}\" and \"{b}\" were linked {} times and are {} now", before.link, pair.link)
            })
        });
        knots.chain(linking).collect()
    }
}

/// Note on the kind of a point of a path, if it is special.
fn kind_in_words(point: &PathPoint) -> Option<String> {
    let value = point.value;
    match point.kind {
        PointKind::Limit => Some(format!("limit point: what is ramped turns back at {value:.6}")),
        PointKind::Branch { .. } => Some(format!("branch point: other paths cross at {value:.6}")),
        PointKind::Corner => Some(format!("corner: a contact begins, ends, splits or joins at {value:.6}")),
        PointKind::Start | PointKind::Regular | PointKind::Target => None,
    }
}
