//! One load step: a stable equilibrium with contact enforced to the requested tolerance.
//!
//! [`Solver::load_step`] is the whole of it. It goes through an ordered list of starts ([`Origin::all`]); each that
//! applies makes a guess, a value. The first guess from which a search converges, and from which contact can be
//! enforced there, ends the step. A search from a guess follows the branch: it leaves no unstable equilibrium. From a
//! guess whose contact is not known, a shape, the search goes over the laws ([`Solver::continue_over_laws`]). So it
//! does from the present state, the last start: it always applies, and descends from unstable equilibria.

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::scene::ContactLaw;
use crate::solve::load_step::guess::{Ahead, ContactOfGuess, Guess, Task};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Attempt, Failed, Origin, Status, StepReport};
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_tangents::MaterialTangents;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::State;
use crate::solve::search::newton::SearchOptions;

/// State and contact law, to which a failed step returns.
#[derive(Debug, Clone)]
pub(crate) struct Snapshot {
    state: State,
    contact: (Law, ContactField, MaterialTangents),
}

impl Solver {
    /// A load step of whose end nothing is known, see [`Solver::load_step`].
    pub(crate) fn solve_step(&mut self, drive: &PrescribedMotion) -> StepReport {
        self.load_step(drive, &Ahead::Unknown)
    }

    /// Brings the present state to a stable equilibrium with contact enforced, applying `drive` on the way.
    pub(in crate::solve) fn load_step(&mut self, drive: &PrescribedMotion, ahead: &Ahead) -> StepReport {
        self.load_step_from(&Origin::all(), drive, ahead)
    }

    /// [`Solver::load_step`] from these starts only. The engine ends in the equilibrium, or where the last start has
    /// led.
    pub(in crate::solve) fn load_step_from(
        &mut self,
        starts: &[Origin],
        drive: &PrescribedMotion,
        ahead: &Ahead,
    ) -> StepReport {
        let mut report = StepReport::settled();
        self.engine.take_tangents();
        let from = self.snapshot();
        let mut ended = Err(Failed::from(Status::MaxIterations));
        for &origin in starts {
            let outcome = self.start(origin, Task { drive, ahead }, &from, &mut report);
            let Some(outcome) = outcome.transpose() else { continue };
            let max_escapes = self.max_escapes(origin);
            ended = outcome.and_then(|increment| self.enforce_contact(increment, max_escapes, &mut report));
            let Err(failed) = &ended else {
                report.start = Some(origin);
                break;
            };
            report.attempts.push(Attempt { origin, status: failed.status });
            let is_stopped = failed.status == Status::Stopped;
            if origin == Origin::CoreLaw && !is_stopped {
                break;
            }
            report.start_again();
            if let Err(error) = self.restore(from.clone()) {
                return StepReport::refused(error);
            }
            if is_stopped {
                break;
            }
        }
        self.accept(ended, report)
    }

    /// The search from one start, if it applies; the size of its last increment.
    fn start(
        &mut self,
        origin: Origin,
        task: Task,
        from: &Snapshot,
        report: &mut StepReport,
    ) -> Result<Option<f64>, Failed> {
        if origin == Origin::CoreLaw {
            return self.continue_over_laws(task.drive, report).map(Some);
        }
        let guess = self.guess(origin, task, &mut report.iterations_on_other_meshes)?;
        let Some(guess) = guess else { return Ok(None) };
        self.take(&guess);
        if !self.is_promising(&guess)? {
            self.restore(from.clone())?;
            return Ok(None);
        }
        report.escapes += guess.escapes;
        if matches!(guess.contact, ContactOfGuess::Unknown) {
            return self.continue_over_laws(&guess.drive, report).map(Some);
        }
        let Guess { drive, forces, uncertainty, .. } = &guess;
        let (max_escapes, uncertainty) = (self.max_escapes(origin), *uncertainty);
        let options = SearchOptions { max_escapes, forces, uncertainty, ..self.search_options() };
        self.search(drive, &options, report).map(Some)
    }

    /// Unstable equilibria that a step from a start may leave in a row: none along a branch, at whose end the descent
    /// begins from the last stable state.
    fn max_escapes(&self, origin: Origin) -> usize {
        if origin == Origin::CoreLaw { self.options.max_escapes } else { 0 }
    }

    /// Completes the report of a step by its end.
    fn accept(&self, ended: Result<(), Failed>, mut report: StepReport) -> StepReport {
        let failed = ended.err();
        let is_broken = failed.as_ref().is_some_and(|failed| failed.status == Status::BrokeDown);
        // the augmented Lagrangian that has converged knows it
        let is_known = failed.is_none() && self.augments();
        if !is_known && !is_broken {
            report.penetration = self.contact_errors().penetration;
        }
        report.stiffness_reduction = self.engine.stiffness_reduction();
        let snapped = matches!(report.start, Some(Origin::ShortRod | Origin::ClosedPlectoneme)) && report.escapes > 0;
        report.branch_ends =
            snapped || report.attempts.iter().any(|a| a.origin != Origin::CoreLaw && a.status == Status::Unstable);
        if let Some(Failed { status, error }) = failed {
            (report.status, report.error) = (status, error);
        }
        report
    }

    /// Of a search to the full tolerance, of whose end nothing is known.
    pub(super) fn search_options(&self) -> SearchOptions<'static> {
        SearchOptions {
            newton: self.options.newton.clone(),
            max_escapes: self.options.max_escapes,
            rough: None,
            near_rest: false,
            leaving: None,
            forces: &[],
            uncertainty: f64::INFINITY,
        }
    }

    /// A search to the full tolerance without any motion.
    pub(super) fn search_from_here(&mut self, report: &mut StepReport) -> Result<f64, Failed> {
        self.search(&PrescribedMotion::default(), &self.search_options(), report)
    }

    pub(in crate::solve) fn augments(&self) -> bool {
        matches!(self.engine.model.contact.law, ContactLaw::AugmentedLagrangian { .. })
            && !self.engine.contact.is_empty()
    }

    pub(in crate::solve) fn is_near_contact(&mut self) -> Result<bool, SolveError> {
        let state = self.engine.state().clone();
        self.engine.update_contact(&state)?;
        Ok(self.engine.contact.is_near())
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        let side = &self.engine.contact;
        let contact = (side.law, side.offsets.clone(), side.tangents.clone());
        Snapshot { state: self.engine.state().clone(), contact }
    }

    /// Restores a snapshot, contact geometry included.
    pub(crate) fn restore(&mut self, snapshot: Snapshot) -> Result<(), SolveError> {
        self.engine.take_state(snapshot.state);
        // with the numbers of rods that it was made under
        self.engine.take_numbers().map_err(|error| SolveError::Symbolic { reason: error.to_string() })?;
        let side = &mut self.engine.contact;
        (side.law, side.offsets, side.tangents) = snapshot.contact;
        side.before = None;
        let state = self.engine.state().clone();
        self.engine.update_contact(&state).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};
    use crate::solve::load_step::predictor::Prediction;
    use crate::solve::options::Options;

    /// Symptom: cables took hundreds of iterations a step from predicted states in which contact had hundreds of times
    /// the energy of the rods.
    #[test]
    fn a_prediction_that_presses_strands_together_is_no_start() {
        // two rods, twisted, side by side
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.02);
        let rod = |name: &str, start: Vec3| {
            let shape = Shape::Line { start, direction: Vec3::x(), length: 1.0 };
            Rod::new(name, &shape, RodMesh::open(12, 3), section, Natural::Straight).unwrap()
        };
        let rods = vec![rod("lower", Vec3::zeros()), rod("upper", Vec3::z() * 0.0401)];
        let ends = [(0, 0), (0, 36), (1, 0), (1, 36)].map(|(rod, node)| NodeRef { rod, node });
        let model = Model { rods, supports: ends.map(Support::clamp).to_vec(), ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let last = solver.engine.num_nodes() - 1;
        let twist = PrescribedMotion { nodes: vec![(last, Vec3::zeros(), Vec3::x() * 0.3)], seams: Vec::new() };
        assert_eq!(solver.solve_step(&twist).status, Status::Converged);
        for (down, is_tried) in [(2e-4, true), (3e-3, false)] {
            let mut prediction = Prediction::still(&solver.engine);
            for k in 0..=36 {
                let part = (std::f64::consts::PI * k as f64 / 36.0).sin().powi(2);
                prediction.increment[6 * (37 + k) + 2] = -down * part;
            }
            let before = solver.engine.state().clone();
            let (still, ahead) = (PrescribedMotion::default(), Ahead::Predicted(prediction));
            let report = solver.load_step_from(&[Origin::Prediction], &still, &ahead);
            let done = report.status == Status::Converged;
            assert_eq!((done, report.iterations > 0), (is_tried, is_tried), "{down}");
            assert!(is_tried || *solver.engine.state() == before);
        }
    }
}
