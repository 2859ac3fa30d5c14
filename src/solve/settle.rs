//! Brings one state to rest: a stable equilibrium with contact enforced to the tolerance asked for.
//!
//! A load step with contact begins under a core law that strands may sink into. It is hardened in stages, each of which takes the pressures
//! of the one before for its own: the first step of a stage moves the strands to where the new law has them. Then the offsets of the
//! augmented Lagrangian are raised until no penetration beyond the tolerance is left. Unstable equilibria are left along
//! their most negative direction.

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::scene::ContactLaw;
use crate::solve::newton::{Iteration, NewtonReport};
use crate::solve::path::Solver;
use crate::solve::predictor::turned;
use crate::solve::state::{Drive, State};

/// Depths of the core law that a load step with contact goes through, over the contact distance.
const DEPTHS: [f64; 4] = [0.4, 0.08, 0.016, 0.004];
/// The one of them that a state is tried with first that nothing moves away from, and the iterations spent on each search then.
const SHALLOW: usize = 2;
const SHALLOW_ITERATIONS: usize = 200;
/// Overlap relative to the contact radius up to which pressures are taken for those of a state at rest.
const AT_REST: f64 = 1e-2;
/// Tolerance of the searches on the way.
const TOL_ON_THE_WAY: f64 = 1e-2;
/// Factor between the stiffnesses that are tried where the mesh does not carry the one asked for, and how often.
const SOFTENING: f64 = 10.0;
const MAX_SOFTER: i32 = 3;
/// Seams turned by more than this, in turns, are turned in parts, each brought to rest before the next: a flat ring given ten turns at
/// once would buckle into its tenth mode.
const TURNS_AT_ONCE: f64 = 1.0;
/// Iterations spent on a predicted state, and the largest rotation of a node for which the prediction is trusted, rad.
const PREDICTED_ITERATIONS: usize = 20;
const LARGEST_PREDICTED_TURN: f64 = 0.3;
/// Iterations spent on one hardening stage before it is given up.
const HARDENING_ITERATIONS: usize = 100;
/// Gap that an offset may hold open, relative to the contact radius: it makes the rod thicker by this much.
pub(super) const TOL_OPENING: f64 = 1e-6;

/// How a run or a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// Everything met its tolerance.
    Converged,
    /// Newton ran out of iterations.
    MaxIterations,
    /// In equilibrium, but with unstable directions that were not to be left or could not be.
    Unstable,
    /// The augmented Lagrangian loop ended above its penetration tolerance.
    Penetration,
    /// Numbers broke down; the step was given up.
    BrokeDown,
    /// The load step fell below its smallest size.
    StepTooSmall,
    /// The observer, or whoever raised the [`Interrupt`](super::Interrupt), asked to stop.
    Stopped,
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::MaxIterations => "Newton did not converge",
            Self::Unstable => "unstable equilibrium",
            Self::Penetration => "penetration above tolerance",
            Self::BrokeDown => "numbers broke down",
            Self::StepTooSmall => "load step too small",
            Self::Stopped => "stopped",
        })
    }
}

/// What one attempt at a load step did.
#[derive(Debug, Clone, PartialEq)]
pub struct StepReport {
    /// How it ended.
    pub status: Status,
    /// Newton iterations in all.
    pub iterations: usize,
    /// Augmentations of the contact offsets.
    pub augmentations: usize,
    /// How many times an unstable equilibrium was left.
    pub departures: usize,
    /// Unstable directions of the final state.
    pub num_unstable: usize,
    /// Worst penetration over the smallest contact radius; 0 without contact.
    pub penetration: f64,
    /// Factor by which the contact law stayed softer than asked for, because the mesh could not carry it; 1 otherwise. Gaps are enforced
    /// all the same; a point contact is spread wider by the cube root of it.
    pub softening: f64,
    /// The step settled at once from the state extrapolated from the steps before.
    pub predicted: bool,
    /// What broke down, if anything did.
    pub error: Option<SolveError>,
    /// All Newton iterations, one list per equilibrium search.
    pub history: Vec<Vec<Iteration>>,
}

impl StepReport {
    /// Of a state that is at rest without anything having been done.
    pub(crate) fn settled() -> Self {
        Self {
            status: Status::Converged,
            iterations: 0,
            augmentations: 0,
            departures: 0,
            num_unstable: 0,
            penetration: 0.0,
            softening: 1.0,
            predicted: false,
            error: None,
            history: Vec::new(),
        }
    }

    /// Of a step that was not even tried.
    pub(crate) fn refused(error: SolveError) -> Self {
        Self { status: Status::BrokeDown, error: Some(error), ..Self::settled() }
    }

    /// Another attempt from where the last one began: iterations stay counted.
    fn start_again(&mut self) {
        (self.status, self.num_unstable) = (Status::Converged, 0);
        (self.augmentations, self.departures, self.softening) = (0, 0, 1.0);
    }
}

/// Snapshot that a failed step returns to.
#[derive(Clone)]
pub(crate) struct Snapshot {
    stages_left: i32,
    state: State,
    contact: Option<(Law, Vec<f64>)>,
}

/// How far the contact conditions are from met, by nodes and in all.
#[derive(Debug, Default)]
pub(super) struct ContactErrors {
    /// Smallest gap near each node (window of one contact distance along its zone) \[L\]; infinite where nothing is in reach.
    pub(super) gaps: Vec<f64>,
    /// Worst penetration over the smallest contact radius.
    pub(super) penetration: f64,
    /// Worst gap that an offset holds open over the smallest contact radius.
    pub(super) opening: f64,
}

impl Solver {
    /// Brings the present state to a stable equilibrium with contact enforced, applying `drive` on the way.
    pub fn settle(&mut self, drive: &Drive) -> StepReport {
        self.settle_along(drive, None)
    }

    /// [`Solver::settle`], tried first from where the increment `predicted` leads.
    pub(crate) fn settle_along(&mut self, drive: &Drive, predicted: Option<Vec<f64>>) -> StepReport {
        let mut report = StepReport::settled();
        let settled = match predicted {
            Some(increment) => self.settle_predicted(drive, increment, &mut report),
            None => Ok(false),
        };
        let outcome = settled.and_then(|done| if done { Ok(()) } else { self.settle_into(drive, &mut report) });
        if let Err(error) = outcome {
            report.error = Some(error);
            report.status = Status::BrokeDown;
        }
        // whatever was made of a search that was cut short
        if std::mem::take(&mut self.workspace.interrupted) {
            report.error = None;
            report.status = Status::Stopped;
        }
        report
    }

    /// Tries the law as it is from the predicted state; true if the step settled there, otherwise the solver is back where it was.
    fn settle_predicted(
        &mut self,
        drive: &Drive,
        increment: Vec<f64>,
        report: &mut StepReport,
    ) -> Result<bool, SolveError> {
        let largest = increment.chunks(6).flat_map(|node| &node[3..]).fold(0.0f64, |a, b| a.max(b.abs()));
        if largest > LARGEST_PREDICTED_TURN {
            return Ok(false);
        }
        let before = self.snapshot();
        let patience = self.be_patient_for(PREDICTED_ITERATIONS);
        let outcome = self.search_predicted(drive, &increment, report);
        self.options.newton.max_iterations = patience;
        if outcome.is_ok() && report.status == Status::Converged && report.departures == 0 {
            report.predicted = true;
            return Ok(true);
        }
        self.restore(before)?;
        report.start_again();
        Ok(false)
    }

    fn search_predicted(
        &mut self,
        drive: &Drive,
        increment: &[f64],
        report: &mut StepReport,
    ) -> Result<(), SolveError> {
        let engine = &mut self.engine;
        let state = turned(engine, &engine.state, drive);
        engine.update_contact(&state)?;
        let fraction = engine.step_fraction(&state, increment)?;
        engine.state = state.retract(increment, fraction);
        self.search(&drive.scaled(1.0 - fraction), report)?;
        self.enforce_gaps(report)
    }

    /// A state that nothing moves away from is tried first with strands almost hard: a soft start would unwind and rewind long plectonemes
    /// by many turns.
    fn settle_into(&mut self, drive: &Drive, report: &mut StepReport) -> Result<(), SolveError> {
        if *drive == Drive::default() && self.augments() && self.is_near_contact()? {
            let before = self.snapshot();
            let patience = self.be_patient_for(SHALLOW_ITERATIONS);
            let outcome = self.approach(SHALLOW, drive, report);
            self.options.newton.max_iterations = patience;
            if outcome.is_ok() && report.status == Status::Converged || self.workspace.interrupted {
                return outcome.and_then(|()| self.enforce_gaps(report));
            }
            self.restore(before)?;
            report.start_again();
        }
        self.approach(0, drive, report)?;
        self.enforce_gaps(report)
    }

    /// Applies the drive under the core law of depth `DEPTHS[first]`, or a deeper one if strands overlap by more, and hardens it.
    fn approach(&mut self, first: usize, drive: &Drive, report: &mut StepReport) -> Result<(), SolveError> {
        let (mut index, mut rough) = (None, false);
        for part in drive.parts(TURNS_AT_ONCE) {
            let near = self.is_near_contact()?;
            if self.augments() {
                index = Some(self.soften(first, near, report)?);
            }
            rough = near && index.is_some();
            if report.status == Status::Converged {
                self.search_roughly(rough, &part, report)?;
            }
            if report.status != Status::Converged {
                return Ok(());
            }
        }
        let Some(index) = index else { return Ok(()) };
        if self.is_near_contact()? {
            return self.harden(&DEPTHS[index + 1..], report);
        }
        self.stages_left = 0;
        self.change_law(Law::Linear { stiffness: self.engine.contact_stiffness() }, true);
        if rough { self.search(&Drive::default(), report) } else { Ok(()) }
    }

    /// Puts the core law in force that is deep enough for the overlaps there are (none unless strands are `near` each other), and returns its
    /// index in [`DEPTHS`].
    fn soften(&mut self, first: usize, near: bool, report: &mut StepReport) -> Result<usize, SolveError> {
        let pressure = self.engine.pressure_scale();
        let overlap = if near { self.contact_errors().penetration } else { 0.0 };
        let fits = |overlap: f64| (0..=first).rev().find(|&k| overlap < 0.8 * 2.0 * DEPTHS[k]);
        let at_rest = overlap < AT_REST;
        let mut index = fits(overlap);
        if index.is_none() {
            // strands deep inside each other come apart under a law without a core first
            let radius = self.engine.contact.as_ref().map_or(1.0, |side| side.min_radius);
            self.change_law(Law::Linear { stiffness: pressure / (DEPTHS[0] * 2.0 * radius) }, false);
            self.search_roughly(true, &Drive::default(), report)?;
            index = fits(self.contact_errors().penetration);
        }
        if index.is_none() && report.status == Status::Converged {
            report.status = Status::Penetration;
        }
        let index = index.unwrap_or(0);
        self.change_law(Law::Core { pressure, depth: DEPTHS[index] }, at_rest);
        Ok(index)
    }

    /// Augmented Lagrangian loop: offsets are raised until no penetration (and no gap held open) beyond the tolerance is left.
    fn enforce_gaps(&mut self, report: &mut StepReport) -> Result<(), SolveError> {
        let ContactLaw::AugmentedLagrangian { tol_penetration, .. } = self.engine.model.contact.law else {
            report.penetration = self.contact_errors().penetration;
            return Ok(());
        };
        while report.status == Status::Converged {
            let errors = self.contact_errors();
            report.penetration = errors.penetration;
            if errors.penetration <= tol_penetration && errors.opening <= tol_penetration.max(TOL_OPENING) {
                break;
            }
            if report.augmentations >= self.options.max_augmentations {
                report.status = Status::Penetration;
                break;
            }
            self.augment(&errors.gaps);
            report.augmentations += 1;
            self.search(&Drive::default(), report)?;
        }
        Ok(())
    }

    /// From the soft core law to the law asked for, or to one that is softer by as little as the mesh needs: where it is too coarse, lines
    /// of contact break up into points between nodes.
    fn harden(&mut self, depths: &[f64], report: &mut StepReport) -> Result<(), SolveError> {
        let pressure = self.engine.pressure_scale();
        for depth in depths {
            self.change_law(Law::Core { pressure, depth: *depth }, true);
            self.search_roughly(true, &Drive::default(), report)?;
            if report.status != Status::Converged {
                return Ok(());
            }
        }
        let before = self.snapshot();
        for softer in 0..=MAX_SOFTER {
            self.stages_left = softer;
            report.softening = SOFTENING.powi(softer);
            self.change_law(Law::Linear { stiffness: self.engine.contact_stiffness() / report.softening }, true);
            let patience = self.be_patient_for(HARDENING_ITERATIONS);
            let outcome = self.search(&Drive::default(), report);
            self.options.newton.max_iterations = patience;
            if outcome.is_ok() && report.status == Status::Converged || softer == MAX_SOFTER {
                return outcome;
            }
            self.restore(before.clone())?;
            (report.status, report.num_unstable) = (Status::Converged, 0);
        }
        Ok(())
    }

    /// Allows searches at most so many iterations, never more than the caller does, and returns what the caller allows.
    fn be_patient_for(&mut self, iterations: usize) -> usize {
        let allowed = self.options.newton.max_iterations;
        self.options.newton.max_iterations = allowed.min(iterations);
        allowed
    }

    /// A search that only prepares the next one.
    fn search_roughly(&mut self, rough: bool, drive: &Drive, report: &mut StepReport) -> Result<(), SolveError> {
        let fine = self.options.newton.tol_increment;
        if rough {
            self.options.newton.tol_increment = fine.max(TOL_ON_THE_WAY);
        }
        let outcome = self.search(drive, report);
        self.options.newton.tol_increment = fine;
        outcome
    }

    fn augments(&self) -> bool {
        matches!(self.engine.model.contact.law, ContactLaw::AugmentedLagrangian { .. }) && self.engine.contact.is_some()
    }

    fn is_near_contact(&mut self) -> Result<bool, SolveError> {
        let state = self.engine.state.clone();
        self.engine.update_contact(&state)?;
        Ok(self.engine.contact.as_ref().is_some_and(|side| !side.broad_phase.pairs().is_empty()))
    }

    /// Replaces the law, without offsets; `carry` the pressures of a state at rest over to it.
    fn change_law(&mut self, law: Law, carry: bool) {
        if let Some(side) = &mut self.engine.contact {
            side.change_law(law, vec![0.0; side.offsets.len()]);
            if !carry {
                side.before = None;
            }
        }
    }

    /// One equilibrium search, leaving unstable equilibria.
    fn search(&mut self, drive: &Drive, report: &mut StepReport) -> Result<(), SolveError> {
        let mut outcome = self.equilibrate(drive, false, report)?;
        // without a potential the inertia of the symmetric part decides nothing
        let leaves = self.options.leave_unstable && self.engine.is_conservative();
        while outcome.converged && outcome.num_unstable > 0 && leaves {
            if report.departures >= self.options.max_departures {
                break;
            }
            report.departures += 1;
            let direction = self.workspace.negative_direction(&mut self.engine)?;
            let increment: Vec<f64> = direction.iter().map(|x| x * self.options.departure).collect();
            let still = Drive::default();
            let state = self.engine.state.clone();
            let fraction = self.engine.step_fraction(&state, &increment)?;
            self.engine.state = state.retract(&increment, fraction);
            outcome = self.equilibrate(&still, true, report)?;
        }
        report.num_unstable = outcome.num_unstable;
        report.status = match (outcome.converged, outcome.num_unstable) {
            (false, _) => Status::MaxIterations,
            (true, 0) => Status::Converged,
            (true, _) if !leaves => Status::Converged,
            (true, _) => Status::Unstable,
        };
        Ok(())
    }

    fn equilibrate(
        &mut self,
        drive: &Drive,
        leaving: bool,
        report: &mut StepReport,
    ) -> Result<NewtonReport, SolveError> {
        let outcome = self.workspace.equilibrate(&mut self.engine, drive, &self.options.newton, leaving)?;
        report.iterations += outcome.iterations.len();
        report.history.push(outcome.iterations.clone());
        Ok(outcome)
    }

    /// How far the contact conditions are from met.
    pub(super) fn contact_errors(&self) -> ContactErrors {
        let Some(side) = &self.engine.contact else { return ContactErrors::default() };
        let residual = self.engine.residual(&self.engine.state);
        let mut gaps = vec![f64::INFINITY; side.offsets.len()];
        let mut touched = vec![false; side.offsets.len()];
        for term in &residual.terms {
            side.nodes[term.slave].iter().for_each(|&node| touched[node] = true);
            let window = side.set.radius_of(term.slave) + side.set.radius_of(term.master);
            for gap in term.zones.iter().map(|z| z.min_gap) {
                for forward in [true, false] {
                    side.spread(term.slave, window, forward, |node| gaps[node] = gaps[node].min(gap));
                }
            }
        }
        let penetration = gaps.iter().map(|g| -g).fold(0.0, f64::max) / side.min_radius;
        let held = (0..gaps.len()).filter(|&n| touched[n] && gaps[n].is_finite() && side.offsets[n] > 0.0);
        let opening = held.map(|n| gaps[n]).fold(0.0, f64::max) / side.min_radius;
        ContactErrors { gaps, penetration, opening }
    }

    /// Raises the contact offsets by the smallest gap found around each node, never below zero.
    pub(super) fn augment(&mut self, gaps: &[f64]) {
        let Some(side) = &mut self.engine.contact else { return };
        for (offset, gap) in side.offsets.iter_mut().zip(gaps) {
            *offset = if gap.is_finite() { (*offset - gap).max(0.0) } else { 0.0 };
        }
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            stages_left: self.stages_left,
            state: self.engine.state.clone(),
            contact: self.engine.contact.as_ref().map(|side| (side.law, side.offsets.clone())),
        }
    }

    /// Goes back to a snapshot, contact geometry included.
    pub(crate) fn restore(&mut self, snapshot: Snapshot) -> Result<(), SolveError> {
        self.stages_left = snapshot.stages_left;
        self.engine.state = snapshot.state;
        if let (Some(side), Some((law, offsets))) = (&mut self.engine.contact, snapshot.contact) {
            side.law = law;
            side.offsets = offsets;
            side.before = None;
        }
        let state = self.engine.state.clone();
        self.engine.update_contact(&state).map(|_| ())
    }
}
