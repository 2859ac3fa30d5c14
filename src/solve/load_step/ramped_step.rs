//! One load step as a caller asks for it: ramps become a target, the target is predicted, searched for and accepted.

use std::f64::consts::TAU;

use crate::error::{InputError, SolveError};
use crate::math::Vec3;
use crate::math::quaternion::exp;
use crate::scene::model::{RemainingPath, unit};
use crate::scene::{NodeRef, Pose, Ramp, Stage, SupportChange};
use crate::solve::load_step::energy_balance::{Departure, HALVINGS_OF_A_BEND};
use crate::solve::load_step::guess::Ahead;
use crate::solve::load_step::predictor::{FARTHEST, History, Prediction};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Status, StepReport};
use crate::solve::problem::prescribed_motion::{PrescribedMotion, Target, lifted};

impl Solver {
    /// Brings the present state to a stable equilibrium under the present loads, from where it is: as
    /// [`Solver::step_to`] without ramps, but not predicted from earlier steps.
    pub fn find_equilibrium(&mut self) -> StepReport {
        self.solve_step(&PrescribedMotion::default())
    }

    /// Moves all ramps to their targets in one step, without cut-back, from the present state; without ramps, settles.
    /// A step that may have lost its branch is made in parts.
    ///
    /// # Errors
    /// Ramps that do not fit the model, a [`Ramp::RotationAbout`] or a [`Ramp::Pose`] by more than [`Ramp::MAX_ROUND`].
    pub fn step_to(&mut self, ramps: &[Ramp]) -> Result<StepReport, InputError> {
        self.step_through(&Stage::new(ramps.to_vec(), 1))
    }

    /// As [`Solver::step_to`], for the ramps of a stage, whose changes of supports are made before; without either,
    /// settles.
    ///
    /// # Errors
    /// Those of [`Solver::step_to`]; changes of supports that do not fit the model.
    pub fn step_through(&mut self, stage: &Stage) -> Result<StepReport, InputError> {
        let ramps = &stage.ramps[..];
        if !ramps.is_empty() || !stage.supports.is_empty() {
            self.engine.model.check_stages(&[Stage { steps: 1, ..stage.clone() }])?;
        }
        self.change_supports(&stage.supports)
            .map_err(|error| InputError::Inconsistent { field: "ramp".to_owned(), reason: error.to_string() })?;
        self.count_motions_anew(&stage.supports);
        self.note_numbers(ramps);
        let round = self.largest_round(ramps);
        let allowed = "at most Ramp::MAX_ROUND (1/12) from where it is: go in more steps";
        InputError::check("ramp.rotation.turns", round, round <= Ramp::MAX_ROUND + 1e-9, allowed)?;
        let report = self.advance(ramps, 1.0);
        if report.status == Status::Converged {
            self.remember(&report);
        }
        Ok(report)
    }

    /// Takes ramps through the fraction `take` of their remaining change in one step, or in parts where it may have
    /// lost its branch, or an obstacle might pass a strand.
    pub(in crate::solve) fn advance(&mut self, ramps: &[Ramp], take: f64) -> StepReport {
        self.advance_halved(ramps, take, 0)
    }

    /// [`Solver::advance`] of a step that doubts have halved so many times.
    fn advance_halved(&mut self, ramps: &[Ramp], take: f64, halvings: usize) -> StepReport {
        let start = self.snapshot();
        let target = self.target(ramps, take);
        let leaps = self.leaps(&target);
        let mut spent = 0;
        if !leaps {
            let (report, is_doubtful) = self.attempt(&target, Some(halvings));
            if !is_doubtful {
                return report;
            }
            spent = report.iterations;
        }
        let (moved, history) = (self.moved.clone(), self.history.clone());
        let halvings = halvings + usize::from(!leaps);
        let mut parts = match self.restore(start.clone()) {
            Ok(()) => self.advance_halved(ramps, 0.5 * take, halvings),
            Err(error) => return StepReport::refused(error),
        };
        if parts.status == Status::Converged {
            self.remember(&parts);
            // of the change that is left
            parts.join(self.advance_halved(ramps, 0.5 * take / (1.0 - 0.5 * take), halvings));
        }
        parts.iterations += spent;
        if parts.status == Status::Converged {
            return parts;
        }
        (self.moved, self.history) = (moved, history);
        if let Err(error) = self.restore(start) {
            return StepReport::refused(error);
        }
        if parts.status == Status::Stopped || leaps {
            return parts;
        }
        // as a whole, then
        let (mut whole, _) = self.attempt(&target, None);
        whole.iterations += parts.iterations;
        whole
    }

    /// Whether an obstacle moves so far at once that it might pass a strand: such steps are made in halves.
    fn leaps(&self, target: &Target) -> bool {
        let (model, state) = (&self.engine.model, self.engine.state());
        let mut after = state.placements().to_vec();
        target.placements.iter().for_each(|(obstacle, which, to)| after[*obstacle].set(*which, *to));
        let spacing = model.rods.iter().map(crate::rod::Rod::spacing).fold(0.0, f64::max);
        let moved = model.obstacles.iter().zip(state.placements().iter().zip(&after)).filter(|(_, (a, b))| a != b);
        moved.into_iter().any(|(obstacle, (from, to))| obstacle.leaps_over([from, to], state.positions(), spacing))
    }

    /// Predicts and searches for a target from the present state; prescribed motions count as made if it converges.
    /// They do not if it is doubtful whether the step, which doubts have halved so many times, has kept its branch: the
    /// second part of the result says so. Without a number there are no doubts.
    fn attempt(&mut self, target: &Target, halvings: Option<usize>) -> (StepReport, bool) {
        let lifted = lifted(&self.engine, self.engine.state(), &target.drive);
        if let Err(error) = self.engine.check_spun(&target.drive.seams, &lifted.spun) {
            return (StepReport::refused(error), false);
        }
        let changes = self.changes(target, &lifted);
        // work counts from an equilibrium
        let before = if self.history.ends_at(self.engine.state()) { self.balance(&changes) } else { None };
        let end = self.history.target(&self.engine, target, &lifted);
        let stride = end.as_ref().and_then(|end| self.history.stride(end));
        let last = self.history.work.zip(stride);
        let predicted = end.and_then(|end| self.history.predict(&self.engine, &end, &lifted.drive));
        let predicted = predicted.or_else(|| self.unpredicted(target, &lifted.drive));
        let ahead = predicted.map_or(Ahead::Unknown, Ahead::Predicted);
        self.engine.prescribe(target.values());
        if let Err(error) = self.engine.take_numbers() {
            return (StepReport::refused(SolveError::Symbolic { reason: error.to_string() }), false);
        }
        let mut report = self.in_own_pool(|solver| solver.load_step(&target.drive, &ahead));
        self.judge_turning(&mut report);
        if report.status == Status::Converged {
            let balance = before.zip(self.balance(&changes));
            let departure = balance.map(|(before, end)| before.departure(&end, last));
            let is_on_branch = report.is_predicted() || report.branch_ends;
            let is_too_long = stride.is_some_and(|stride| stride > FARTHEST);
            let is_met = || match &ahead {
                Ahead::Predicted(prediction) => prediction.is_met(&self.engine, &lifted.state),
                Ahead::Unknown | Ahead::Present => false,
            };
            let is_doubtful = |departure: Departure| {
                let may_bend = halvings.is_some_and(|halvings| halvings < HALVINGS_OF_A_BEND);
                let is_lost = !is_on_branch && departure.is_doubtful();
                is_too_long && is_lost || may_bend && departure.snaps_or_bends() && !is_met()
            };
            if halvings.is_some() && departure.is_some_and(is_doubtful) {
                return (report, true);
            }
            report.energy_released = departure.map_or(0.0, |departure| departure.released());
            self.history.work = balance.filter(|_| report.energy_released == 0.0).map(|(a, b)| [a.work, b.work]);
            self.moved.go_on(target, &lifted.spun);
        }
        (report, false)
    }

    /// Adds the accepted state to those from which the next one is predicted.
    pub(in crate::solve) fn remember(&mut self, report: &StepReport) {
        if report.escapes > 0 {
            self.history.clear();
        }
        self.history.push(self.engine.state(), &self.moved);
    }

    /// A state whose elements may have taken the other way round is no equilibrium of the rod.
    pub(in crate::solve) fn judge_turning(&self, report: &mut StepReport) {
        if report.status != Status::Converged {
            return;
        }
        if let Err(error) = self.engine.check_turning() {
            (report.status, report.error) = (Status::BrokeDown, Some(error));
        }
    }

    /// Turns of a node by ramps so far; joined nodes that turn as one are one.
    fn turned(&self, node: usize) -> f64 {
        let [.., turning] = self.engine.sharing.owner[node];
        self.moved.turned.get(&turning).copied().unwrap_or(0.0)
    }

    fn turns_left(&self, node: usize, to: f64) -> f64 {
        to - self.turned(node)
    }

    /// Displacement \[L\] of a node by ramps so far; joined nodes are one.
    fn displaced(&self, node: usize) -> Vec3 {
        let [place, ..] = self.engine.sharing.owner[node];
        self.moved.displaced.get(&place).copied().unwrap_or_default()
    }

    /// A node relative to a point of the axis it is turned about \[L\]; the axis moves with the node's displacements.
    fn arm(&self, node: usize, through: &Vec3) -> Vec3 {
        let state = self.engine.state();
        (state.positions()[node] - through - self.displaced(node)) + state.remainders()[node]
    }

    /// The way from where a node is to a pose.
    fn remaining_path(&self, node: usize, pose: &Pose) -> RemainingPath {
        let state = self.engine.state();
        pose.remaining_path(
            &state.positions()[node],
            &state.remainders()[node],
            &state.frames()[node],
            self.turned(node),
        )
    }

    /// Turns by which the ramps will carry a node round an axis or to a pose, at most.
    pub(in crate::solve) fn largest_round(&self, ramps: &[Ramp]) -> f64 {
        let round = |ramp: &Ramp| match ramp {
            Ramp::RotationAbout { node, to, .. } => {
                self.turns_left(self.engine.first_node[node.rod] + node.node, *to).abs()
            }
            Ramp::Pose { node, pose } => {
                let way = self.remaining_path(self.engine.first_node[node.rod] + node.node, pose);
                way.rotation.norm() / TAU
            }
            _ => 0.0,
        };
        ramps.iter().map(round).fold(0.0, f64::max)
    }

    /// The target when every ramp takes the fraction `take` of its remaining change.
    pub(in crate::solve) fn target(&self, ramps: &[Ramp], take: f64) -> Target {
        let mut target = Target::default();
        let state = self.engine.state();
        let between = |now: f64, to: f64| now + (to - now) * take;
        let node_of = |n: &NodeRef| self.engine.first_node[n.rod] + n.node;
        // joined nodes move as one, which is called by its first
        let owner = |n: &NodeRef| self.engine.sharing.owner[node_of(n)];
        for ramp in ramps {
            match ramp {
                Ramp::ExcessLink { rod, to } => {
                    let seams = &mut target.drive.seams;
                    seams.resize(self.engine.model.rods.len(), 0.0);
                    let link = to + self.engine.model.rods[*rod].natural_link();
                    seams[*rod] = (link * TAU - state.seams()[*rod]) * take;
                }
                Ramp::Rotation { node, axis, to } => {
                    let [.., node] = owner(node);
                    let change = self.turns_left(node, *to) * take;
                    target.rotate(node, change, Vec3::zeros(), unit(axis) * (change * TAU));
                }
                Ramp::RotationAbout { node, axis, through, to } => {
                    let [.., node] = owner(node);
                    let change = self.turns_left(node, *to) * take;
                    let (vector, arm) = (unit(axis) * (change * TAU), self.arm(node, through));
                    target.rotate(node, change, exp(&vector) * arm - arm, vector);
                }
                Ramp::Displacement { node, to } => {
                    let [node, ..] = owner(node);
                    let change = (to - self.displaced(node)) * take;
                    target.drive.nodes.push((node, change, Vec3::zeros()));
                    target.displaced.push((node, change));
                }
                Ramp::Pose { node, pose } => self.add_pose(node_of(node), pose, take, &mut target),
                Ramp::Load { to } => target.load_factor = Some(between(state.load_factor(), *to)),
                Ramp::Pressure { rod, to } => target.pressures.push((*rod, between(state.pressures()[*rod], *to))),
                Ramp::Obstacle { obstacle, which, to } => {
                    let now = state.placements()[*obstacle].get(*which);
                    target.placements.push((*obstacle, *which, between(now, *to)));
                }
                Ramp::Number { rod, which, to } => {
                    let now = self.engine.model.rods[*rod].number(*which);
                    target.numbers.insert((*rod, *which), if take == 1.0 { *to } else { between(now, *to) });
                }
            }
        }
        target.drive.nodes = self.engine.with_joined(&target.drive.nodes);
        target
    }

    /// Adds the motion of a node over a part of its way to a pose.
    fn add_pose(&self, node: usize, pose: &Pose, take: f64, target: &mut Target) {
        let state = self.engine.state();
        let way = self.remaining_path(node, pose);
        target.drive.nodes.push((node, way.displacement(take), way.rotation * take));
        if way.turns != 0.0 {
            // a second motion of the node: the rod takes it by itself, being about its tangent
            let (change, tangent) = (way.turns * take, state.frames()[node] * Vec3::z());
            target.rotate(node, change, Vec3::zeros(), tangent * (change * TAU));
        }
        target.posed.push((node, way.controls(&state.positions()[node]).map(|v| v * take)));
    }

    /// Notes the present values of numbers that ramps are about to move, so that a step that fails goes back to them.
    pub(in crate::solve) fn note_numbers(&mut self, ramps: &[Ramp]) {
        for ramp in ramps {
            if let Ramp::Number { rod, which, .. } = ramp {
                self.engine.note_number(*rod, *which);
            }
        }
    }

    /// Sets and takes away supports as a stage says, before its first step: nodes are held where they are.
    ///
    /// # Errors
    /// Contact geometry that breaks down.
    pub(in crate::solve) fn change_supports(&mut self, changes: &[SupportChange]) -> Result<(), SolveError> {
        if !self.engine.model.change_supports(changes) {
            return Ok(());
        }
        self.engine.find_unknowns();
        self.history = History::default();
        self.forget_path()
    }

    /// Counts displacements and turns from here of nodes that a stage holds, before its first step.
    pub(in crate::solve) fn count_motions_anew(&mut self, changes: &[SupportChange]) {
        for change in changes {
            let SupportChange::Hold(support) = change else { continue };
            let [places, frames] = self.engine.model.moved_with(support);
            for node in places {
                self.moved.displaced.remove(&self.engine.index(node));
            }
            for node in frames {
                self.moved.turned.remove(&self.engine.index(node));
            }
            // states before do not lie on one line with those to come
            self.history = History::default();
        }
    }

    /// Where a step leads that changes numbers: nowhere by itself, supports move as prescribed.
    fn unpredicted(&self, target: &Target, drive: &PrescribedMotion) -> Option<Prediction> {
        let changes = target.numbers.iter().any(|(key, value)| self.engine.state().numbers().get(key) != Some(value));
        changes.then(|| {
            let mut still = Prediction::still(&self.engine);
            drive.add_to(&mut still.increment);
            still
        })
    }
}
