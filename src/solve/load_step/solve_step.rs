//! One load step: a stable equilibrium with contact enforced to the requested tolerance.
//!
//! The first try starts from the predicted state under the present law: put together, if a plectoneme grows between its
//! tails (`growth`), extrapolated otherwise (`predictor`). Without a reliable prediction a step with contact
//! begins under a core law, with offsets and tensions that balance the shape (`multiplier_estimate`), because plectonemes
//! would rewind by many turns if strands first sank into each other and then came apart. The requested law takes over the
//! pressures of the core law, after an intermediate law half as stiff in decades. Then the offsets of the augmented
//! Lagrangian are raised until no penetration beyond the tolerance is left. Unstable equilibria are left along their most
//! negative direction. Long plectonemes, long rods that snap into one, and large turns begin from a short rod or a coarse
//! mesh instead (`periodic_extension`, `short_rod`, `nested_iteration`), if these converge.

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::scene::ContactLaw;
use crate::solve::load_step::growth::{Grown, turned_end};
use crate::solve::load_step::multipliers::SecantSteps;
use crate::solve::load_step::predictor::Prediction;
use crate::solve::load_step::short_rod::Snapped;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Status, StepReport};
use crate::solve::options::Options;
use crate::solve::problem::assembly::Potential;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::contact_tangents::MaterialTangents;
use crate::solve::problem::moment_load::work_of_moments;
use crate::solve::problem::prescribed_motion::{Lifted, PrescribedMotion, lifted};
use crate::solve::problem::state::State;
use crate::solve::search::newton::{Iteration, NewtonReport, SearchOptions};
use crate::solve::search::trust_region::progress::stored_energy;
use crate::solve::search::workspace::Foretold;

/// Depth of the core law relative to the contact distance, because with .1 instead pUC19 with its whole link in one
/// step takes 464 iterations for 335, a minicircle 442 for 404, and tweezers do not converge.
const DEPTH: f64 = 0.4;
/// Overlap, over the contact radius, from which strands are first separated under a law without a core, because at 2
/// [`DEPTH`] the core's energy is infinite.
const TOO_DEEP: f64 = 0.8 * 2.0 * DEPTH;
/// Factor between the penalties that are tried if the mesh does not resolve the requested one.
const STIFFNESS_RATIO: f64 = 10.0;
/// Largest energy of contact in a predicted state, over that of the rods, because cables took hundreds of iterations a step from
/// states with more.
const MAX_CONTACT_ENERGY: f64 = 100.0;
/// Largest overlap of a shape, over the contact radius, whose pressures are estimated, because strands that are farther inside each
/// other are not in balance by any.
const MAX_OVERLAP_OF_SHAPE: f64 = 0.01;
/// Extent of the last step of a rough search, rad, because its end is only the start of the next one.
const ROUGH_EXTENT: f64 = 0.01;
/// Fall of the potential, over the energy stored, from which leaving an unstable equilibrium was worth the name.
const LEAST_FALL: f64 = 0.01;
/// Times that contact tangents are taken from the state at rest, because the second round corrects and the third confirms.
const MAX_TANGENT_ROUNDS: usize = 3;
/// Softer laws that are tried, each by [`STIFFNESS_RATIO`], because contact a thousand times softer than asked for is another problem.
const MAX_SOFTER_LAWS: usize = 3;
/// Largest turn of a seam in one search, turns. Larger ones are made in parts, because a flat ring with ten turns at once
/// would buckle into its tenth mode.
pub(in crate::solve) const TURNS_AT_ONCE: f64 = 1.0;

/// State and contact law, to which a failed step returns.
#[derive(Clone)]
pub(crate) struct Snapshot {
    state: State,
    contact: Option<(Law, ContactField, MaterialTangents)>,
}

impl Solver {
    /// Brings the present state to a stable equilibrium with contact enforced, applying `drive` on the way.
    pub(crate) fn solve_step(&mut self, drive: &PrescribedMotion) -> StepReport {
        self.solve_step_along(drive, None)
    }

    /// [`Solver::solve_step`], tried first from the predicted state.
    pub(crate) fn solve_step_along(&mut self, drive: &PrescribedMotion, predicted: Option<Prediction>) -> StepReport {
        let mut report = StepReport::settled();
        self.engine.take_tangents();
        if let Err(error) = self.linearise_about_harder_law() {
            return StepReport::refused(error);
        }
        let outcome = self.solve_from_elsewhere(drive, predicted, &mut report).and_then(|done| {
            if done {
                return Ok(());
            }
            self.approach(drive, &mut report).and_then(|()| self.enforce_gaps(&mut report))
        });
        if let Err(error) = outcome {
            report.error = Some(error);
            report.status = Status::BrokeDown;
        }
        report.stiffness_reduction = self.engine.stiffness_reduction();
        // an interrupted search may have ended in any way
        if std::mem::take(&mut self.workspace.interrupted) {
            report.error = None;
            report.status = Status::Stopped;
        }
        report
    }

    /// Tries states that are nearer to the target than the present one, as long as none converges; true if one did.
    fn solve_from_elsewhere(
        &mut self,
        drive: &PrescribedMotion,
        predicted: Option<Prediction>,
        report: &mut StepReport,
    ) -> Result<bool, SolveError> {
        let foreseen = self.solve_from_grown(drive, report)?
            || match predicted {
                Some(prediction) => self.solve_from_prediction(drive, &prediction, report)?,
                None => self.solve_from_short(drive, report)?,
            };
        Ok(foreseen || self.solve_from_snapped(drive, report)? || self.solve_from_coarse(drive, report)?)
    }

    /// Tries the present law from the predicted state, unless its strands are pressed into each other so far that the energy
    /// of the rods is less than a hundredth of that; true if the step converged, otherwise the solver's state is as before.
    pub(in crate::solve) fn solve_from_prediction(
        &mut self,
        drive: &PrescribedMotion,
        prediction: &Prediction,
        report: &mut StepReport,
    ) -> Result<bool, SolveError> {
        self.try_predicted(report, |solver, report| {
            let engine = &mut solver.engine;
            let Lifted { state, drive, .. } = lifted(engine, &engine.state, drive);
            let fraction = engine.free_fraction(&state, &prediction.increment)?;
            engine.state = engine.retract(&state, &prediction.increment, fraction);
            if engine.contact.is_some() {
                let Potential { contact, elastic, .. } = engine.potential_at(&engine.state.clone())?;
                if contact > MAX_CONTACT_ENERGY * elastic.iter().sum::<f64>() {
                    report.status = Status::MaxIterations;
                    return Ok(());
                }
            }
            solver.search_along_branch(&drive.scaled(1.0 - fraction), prediction.foretold.clone(), report)
        })
    }

    /// The state with the drive lifted, if growth and snaps of plectonemes may be put together: it turns an end of a uniform
    /// rod, and contact is augmented.
    fn turned_end(&self, drive: &PrescribedMotion) -> Option<State> {
        if self.augments() { turned_end(&self.engine, drive) } else { None }
    }

    /// Tries the present law from the state in which a plectoneme has grown or shrunk as the drive asks; true if the step
    /// converged, otherwise the solver's state is as before.
    fn solve_from_grown(&mut self, drive: &PrescribedMotion, report: &mut StepReport) -> Result<bool, SolveError> {
        let Some(turned) = self.turned_end(drive) else { return Ok(false) };
        let Some(grown) = Grown::of(&mut self.engine, &turned) else { return Ok(false) };
        self.solve_from_composed(&turned, grown, report)
    }

    /// Tries the plectoneme that a short piece of a long straight rod snaps into; true if the step converged, otherwise
    /// the solver's state is as before.
    fn solve_from_snapped(&mut self, drive: &PrescribedMotion, report: &mut StepReport) -> Result<bool, SolveError> {
        let Some(turned) = self.turned_end(drive) else { return Ok(false) };
        let Some(Snapped { grown, iterations, timings }) = self.snapped_short(&turned) else { return Ok(false) };
        report.iterations_on_other_meshes += iterations;
        self.workspace.timings += timings;
        let done = self.solve_from_composed(&turned, grown, report)?;
        report.predicted = false;
        // the straight rod was unstable
        report.escapes += usize::from(done);
        report.branch_ends |= done;
        Ok(done)
    }

    /// Tries a state that was put together, if its potential, without stretch and shear, is below that of the present one
    /// with the drive's turn spread along the rod (`turned`).
    fn solve_from_composed(
        &mut self,
        turned: &State,
        Grown { state, offsets, forces }: Grown,
        report: &mut StepReport,
    ) -> Result<bool, SolveError> {
        let highest = self.engine.potential_at(turned)?.without_stretch_and_shear();
        self.try_predicted(report, |solver, report| {
            if let Some(side) = &mut solver.engine.contact {
                (side.offsets, side.before) = (offsets, None);
            }
            if solver.engine.potential_at(&state)?.without_stretch_and_shear() >= highest {
                // no better start than the present state
                report.status = Status::MaxIterations;
                return Ok(());
            }
            solver.engine.state = state;
            solver.engine.take_tangents();
            solver.search_along_branch(&PrescribedMotion::default(), Foretold::forces(forces), report)
        })
    }

    /// Makes a search from a predicted state; true if the step converged, otherwise the solver's state is as before.
    fn try_predicted(
        &mut self,
        report: &mut StepReport,
        search: impl FnOnce(&mut Self, &mut StepReport) -> Result<(), SolveError>,
    ) -> Result<bool, SolveError> {
        let before = self.snapshot();
        let outcome = search(self, report);
        if outcome.is_ok() && report.status == Status::Converged {
            report.predicted = true;
            return Ok(true);
        }
        report.branch_ends |= report.status == Status::Unstable;
        self.restore(before)?;
        report.start_again();
        Ok(false)
    }

    /// A search that leaves no unstable equilibrium: at the end of a branch the descent begins from the last stable state.
    fn search_along_branch(
        &mut self,
        drive: &PrescribedMotion,
        foretold: Foretold,
        report: &mut StepReport,
    ) -> Result<(), SolveError> {
        let max_escapes = 0;
        self.search(drive, &SearchOptions { max_escapes, foretold, ..self.search_options() }, report)?;
        self.enforce_gaps_within(max_escapes, report)
    }

    /// Of a search to the full tolerance.
    fn search_options(&self) -> SearchOptions {
        let Options { newton, max_escapes, .. } = &self.options;
        SearchOptions {
            newton: newton.clone(),
            max_escapes: *max_escapes,
            rough: None,
            near_rest: false,
            foretold: Foretold::default(),
        }
    }

    /// Tries the present law from the present state; true if it converged, otherwise the solver's state is as before.
    pub(in crate::solve) fn solve_from_present(&mut self, report: &mut StepReport) -> Result<bool, SolveError> {
        let still = Prediction::still(&self.engine);
        let settled = self.solve_from_prediction(&PrescribedMotion::default(), &still, report);
        report.predicted = false;
        settled
    }

    /// Tries to start a long plectoneme from the equilibrium of a short one; true if it converged, otherwise the solver's
    /// state is as before.
    fn solve_from_short(&mut self, drive: &PrescribedMotion, report: &mut StepReport) -> Result<bool, SolveError> {
        let still = drive.nodes.is_empty() && drive.seams.iter().all(|angle| *angle == 0.0);
        if !(still && self.augments()) {
            return Ok(false);
        }
        let Some(lengthened) = self.lengthened() else { return Ok(false) };
        let start = self.snapshot();
        self.start_from(lengthened, report);
        let settled = self.solve_from_present(report);
        if settled == Ok(false) {
            self.restore(start)?;
        }
        settled
    }

    /// Applies the drive under the core law, then raises the penalty.
    pub(in crate::solve) fn approach(
        &mut self,
        drive: &PrescribedMotion,
        report: &mut StepReport,
    ) -> Result<(), SolveError> {
        let mut foretold = if self.augments() { self.soften(report)? } else { Foretold::default() };
        let mut rough = false;
        for part in drive.parts(TURNS_AT_ONCE) {
            rough = self.augments() && self.is_near_contact()?;
            if report.status == Status::Converged {
                self.search_roughly((rough, std::mem::take(&mut foretold)), &part, report)?;
            }
            if report.status != Status::Converged {
                return Ok(());
            }
        }
        if !self.augments() {
            return Ok(());
        }
        if self.is_near_contact()? {
            return self.raise_penalty(report);
        }
        self.change_law(Law::Linear { stiffness: self.engine.contact_stiffness() }, &[]);
        if rough { self.search_from_here(report) } else { Ok(()) }
    }

    /// Puts the core law in force, with offsets such that the pressures of touching strands balance the state; the forces
    /// in the rods that go with them.
    fn soften(&mut self, report: &mut StepReport) -> Result<Foretold, SolveError> {
        let near = self.is_near_contact()?;
        let pressure = self.engine.pressure_scale();
        let core = Law::Core { pressure, depth: DEPTH };
        let overlap = if near { self.contact_errors().penetration } else { 0.0 };
        let (mut pressures, mut foretold) = (Vec::new(), Foretold::default());
        if overlap >= TOO_DEEP {
            // strands deep inside each other are separated under a law without a core first
            self.start_under(Law::Linear { stiffness: self.core_stiffness() }, &[]);
            self.search_roughly((true, Foretold::default()), &PrescribedMotion::default(), report)?;
            report.penetration = self.contact_errors().penetration;
            if report.status == Status::Converged && report.penetration >= TOO_DEEP {
                report.status = Status::Penetration;
            }
            if report.status != Status::Converged {
                // the core's energy would be infinite here
                return Ok(foretold);
            }
        } else if near && overlap < MAX_OVERLAP_OF_SHAPE {
            let multiplier_estimate = self.multiplier_estimate(core, pressure)?;
            pressures = multiplier_estimate.pressures;
            foretold = Foretold::forces(multiplier_estimate.forces);
        }
        self.start_under(core, &pressures);
        Ok(foretold)
    }

    /// Pressure of the core law over its depth \[F/L²\].
    fn core_stiffness(&self) -> f64 {
        let radius = self.engine.contact.as_ref().map_or(1.0, |side| side.min_radius);
        self.engine.pressure_scale() / (DEPTH * 2.0 * radius)
    }

    /// Augmented Lagrangian loop: until penetrations and gaps held open are within the tolerance, and the tangents of the
    /// contact centrelines are those of the state.
    pub(in crate::solve) fn enforce_gaps(&mut self, report: &mut StepReport) -> Result<(), SolveError> {
        self.enforce_gaps_within(self.options.max_escapes, report)
    }

    /// [`Solver::enforce_gaps`] by searches that leave unstable equilibria so often.
    fn enforce_gaps_within(&mut self, max_escapes: usize, report: &mut StepReport) -> Result<(), SolveError> {
        let tol = match self.engine.model.contact.law {
            ContactLaw::AugmentedLagrangian { tol_penetration, .. } => Some(tol_penetration),
            _ => None,
        };
        let mut secant_steps = SecantSteps::default();
        let mut at_rest = self.ended_at_rest(report);
        let mut num_followed = 0;
        while report.status == Status::Converged {
            if num_followed < MAX_TANGENT_ROUNDS && self.engine.follow_tangents() {
                num_followed += 1;
                self.search_nearly(max_escapes, report)?;
                at_rest = self.ended_at_rest(report);
                continue;
            }
            match tol.and_then(|tol| self.outstanding_in(report, tol, &mut secant_steps)) {
                None if at_rest => break,
                None => {
                    let options = SearchOptions { max_escapes, ..self.search_options() };
                    self.search(&PrescribedMotion::default(), &options, report)?;
                    at_rest = true;
                }
                Some(_) if report.augmentations >= self.options.max_augmentations => {
                    report.status = Status::Penetration;
                }
                Some(gaps) => {
                    self.augment(&gaps, &mut secant_steps);
                    report.augmentations += 1;
                    self.search_nearly(max_escapes, report)?;
                    at_rest = self.ended_at_rest(report);
                }
            }
        }
        if tol.is_none() {
            report.penetration = self.contact_errors().penetration;
        }
        Ok(())
    }

    /// Gaps that are to be closed or released, with what is left told in the report; `None` at the end.
    fn outstanding_in(
        &self,
        report: &mut StepReport,
        tol: f64,
        secant_steps: &mut SecantSteps,
    ) -> Option<ContactField> {
        let outstanding = self.outstanding(tol, secant_steps);
        report.penetration = outstanding.penetration;
        report.complementarity = outstanding.complementarity.unwrap_or(report.complementarity);
        outstanding.gaps
    }

    /// A search between two augmentations. Newton's method converges quadratically, so after a last increment of √tol
    /// the error is of the order of tol; the last search of all uses the tolerance itself.
    fn search_nearly(&mut self, max_escapes: usize, report: &mut StepReport) -> Result<(), SolveError> {
        let mut options = SearchOptions { max_escapes, near_rest: true, ..self.search_options() };
        if self.augments() && self.is_near_contact()? {
            options.newton.tol_increment = options.newton.tol_increment.sqrt();
        }
        self.search(&PrescribedMotion::default(), &options, report)
    }

    /// A search to the full tolerance without any motion.
    fn search_from_here(&mut self, report: &mut StepReport) -> Result<(), SolveError> {
        self.search(&PrescribedMotion::default(), &self.search_options(), report)
    }

    /// Whether the last search met the full tolerance.
    fn ended_at_rest(&self, report: &StepReport) -> bool {
        let last = report.history.last().and_then(|search| search.last());
        last.is_none_or(|iteration| iteration.increment <= self.options.newton.tol_increment)
    }

    /// From the core law to the requested one, or to the stiffest softer law that the mesh resolves: on a mesh too coarse
    /// for its law lines of contact break up into points between nodes.
    fn raise_penalty(&mut self, report: &mut StepReport) -> Result<(), SolveError> {
        let asked = self.engine.contact_stiffness();
        // half way in decades; a law softer than the core is reached at once
        self.change_law_keeping_pressures(Law::Linear { stiffness: asked.min((asked * self.core_stiffness()).sqrt()) });
        self.search_roughly((true, Foretold::default()), &PrescribedMotion::default(), report)?;
        if report.status != Status::Converged {
            return Ok(());
        }
        let before = self.snapshot();
        for softer in 0..=MAX_SOFTER_LAWS {
            self.change_law(Law::Linear { stiffness: asked / STIFFNESS_RATIO.powi(softer as i32) }, &[]);
            let outcome = self.search_from_here(report);
            if outcome.is_ok() && report.status == Status::Converged || softer == MAX_SOFTER_LAWS {
                return outcome;
            }
            self.restore(before.clone())?;
            (report.status, report.num_unstable) = (Status::Converged, 0);
        }
        Ok(())
    }

    /// A rough search: its result is the start of the next one.
    fn search_roughly(
        &mut self,
        (rough, foretold): (bool, Foretold),
        drive: &PrescribedMotion,
        report: &mut StepReport,
    ) -> Result<(), SolveError> {
        let deep = match self.engine.contact.as_ref().map(|side| side.law) {
            Some(Law::Core { depth, .. }) => depth,
            _ => 1.0,
        };
        let rough = rough.then_some(ROUGH_EXTENT.min(deep));
        self.search(drive, &SearchOptions { rough, foretold, ..self.search_options() }, report)
    }

    pub(in crate::solve) fn augments(&self) -> bool {
        matches!(self.engine.model.contact.law, ContactLaw::AugmentedLagrangian { .. }) && self.engine.contact.is_some()
    }

    pub(in crate::solve) fn is_near_contact(&mut self) -> Result<bool, SolveError> {
        let state = self.engine.state.clone();
        self.engine.update_contact(&state)?;
        Ok(self.engine.contact.as_ref().is_some_and(ContactSide::is_near))
    }

    /// Equilibrium search that leaves unstable equilibria, from which the potential falls by more than rounding.
    fn search(
        &mut self,
        drive: &PrescribedMotion,
        options: &SearchOptions,
        report: &mut StepReport,
    ) -> Result<(), SolveError> {
        let mut outcome = self.equilibrate(drive, (options, None), report)?;
        // nothing is known of where a descent leads
        let options = options.unforetold();
        // without a potential the inertia of the symmetric part does not decide stability
        let leaves = self.options.leave_unstable && self.engine.is_conservative();
        let mut idle = 0;
        while outcome.converged && outcome.num_unstable > 0 && leaves && !ended_roughly(&options, &outcome) {
            let may_leave = idle < options.max_escapes;
            let (before, potential) = (self.engine.state.clone(), self.engine.residual(&self.engine.state));
            let direction = self.workspace.negative_direction(&mut self.engine)?;
            let increment: Vec<f64> = direction.iter().map(|x| x * self.options.escape_step).collect();
            let still = PrescribedMotion::default();
            let fraction = self.engine.step_fraction(&before, &increment)?;
            self.engine.state = self.engine.retract(&before, &increment, fraction);
            let work = work_of_moments(&self.engine, &increment) * fraction;
            let floor = potential.potential.total() + work - potential.rounding;
            let floor = if may_leave { f64::NEG_INFINITY } else { floor };
            let left = self.equilibrate(&still, (&options, Some(floor)), report)?;
            let end = self.engine.residual(&self.engine.state).potential.total() - work - left.work;
            let fall = potential.potential.total() - end;
            // a motion without energy, such as the turning of the helix of a ring with two bending stiffnesses
            let is_neutral = left.converged && fall.abs() <= potential.rounding;
            if may_leave && !is_neutral {
                report.escapes += 1;
                idle = if fall > LEAST_FALL * stored_energy(&potential.potential) { 0 } else { idle + 1 };
                outcome = left;
                continue;
            }
            self.engine.state = before;
            self.engine.update_contact(&self.engine.state.clone())?;
            if !is_neutral {
                break;
            }
            outcome.num_unstable = 0;
        }
        report.num_unstable = outcome.num_unstable;
        report.error.clone_from(&outcome.obstacle);
        report.status = match (outcome.converged, outcome.num_unstable) {
            (false, _) => Status::MaxIterations,
            (true, 0) => Status::Converged,
            (true, _) if !leaves || ended_roughly(&options, &outcome) => Status::Converged,
            (true, _) => Status::Unstable,
        };
        Ok(())
    }

    fn equilibrate(
        &mut self,
        drive: &PrescribedMotion,
        (options, leaving): (&SearchOptions, Option<f64>),
        report: &mut StepReport,
    ) -> Result<NewtonReport, SolveError> {
        let outcome = self.workspace.equilibrate(&mut self.engine, drive, options, leaving)?;
        report.iterations += outcome.iterations.len();
        self.workspace.timings.node_iterations += outcome.iterations.len() * self.engine.num_nodes();
        report.history.push(outcome.iterations.clone());
        Ok(outcome)
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.engine.state.clone(),
            contact: self.engine.contact.as_ref().map(|side| (side.law, side.offsets.clone(), side.tangents.clone())),
        }
    }

    /// Restores a snapshot, contact geometry included.
    pub(crate) fn restore(&mut self, snapshot: Snapshot) -> Result<(), SolveError> {
        self.engine.state = snapshot.state;
        // with the numbers of rods that it was made under
        self.engine.take_numbers().map_err(|error| SolveError::Symbolic { reason: error.to_string() })?;
        if let (Some(side), Some((law, offsets, tangents))) = (&mut self.engine.contact, snapshot.contact) {
            (side.law, side.offsets, side.tangents) = (law, offsets, tangents);
            side.before = None;
        }
        let state = self.engine.state.clone();
        self.engine.update_contact(&state).map(|_| ())
    }
}

/// Whether a rough search ended before convergence, so not at a saddle.
fn ended_roughly(options: &SearchOptions, outcome: &NewtonReport) -> bool {
    let is_unfinished = |last: &Iteration| last.increment > options.newton.tol_increment;
    options.rough.is_some() && outcome.iterations.last().is_some_and(is_unfinished)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};

    /// Symptom: cables took hundreds of iterations a step from predicted states in which contact had hundreds of times the
    /// energy of the rods.
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
            let mut report = StepReport::settled();
            let before = solver.engine.state.clone();
            let done = solver.solve_from_prediction(&PrescribedMotion::default(), &prediction, &mut report).unwrap();
            assert_eq!((done, report.iterations > 0), (is_tried, is_tried), "{down}");
            assert!(is_tried || solver.engine.state == before);
        }
    }
}
