//! Brings one state to rest: a stable equilibrium with contact enforced to the tolerance asked for.
//!
//! A load step with contact begins under a softened law, which is hardened in stages; then the offsets of the augmented
//! Lagrangian are raised until no penetration beyond the tolerance is left. Unstable equilibria are left along their most
//! negative direction.

use crate::contact::detect::LawParameters;
use crate::error::SolveError;
use crate::scene::ContactLaw;
use crate::solve::newton::{Iteration, NewtonReport};
use crate::solve::path::Solver;
use crate::solve::predictor::turned;
use crate::solve::state::{Drive, State};

/// Stages of a softened law at the start of a load step, and the factor between them.
const SOFT_STAGES: i32 = 3;
const SOFTENING: f64 = 10.0;
/// Seams turned by more than this, in turns, are turned in parts, each brought to rest before the next: a flat ring given ten turns at
/// once would buckle into its tenth mode.
const TURNS_AT_ONCE: f64 = 1.0;
/// Iterations spent on a predicted state, and the largest rotation of a node for which the prediction is trusted, rad.
const PREDICTED_ITERATIONS: usize = 20;
const LARGEST_PREDICTED_TURN: f64 = 0.3;
/// Iterations spent on one hardening stage before it is given up.
const HARDENING_ITERATIONS: usize = 100;
/// Augmentations under the soft law, and the gap error relative to the radius at which they end: hardening keeps gaps.
const SOFT_AUGMENTATIONS: usize = 4;
const TOL_SOFT: f64 = 1e-3;
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

/// Snapshot that a failed step returns to.
pub(crate) struct Snapshot {
    stages_left: i32,
    state: State,
    contact: Option<(LawParameters, Vec<f64>)>,
}

/// How far the contact conditions are from met, by nodes and in all.
#[derive(Debug, Default)]
pub(super) struct ContactErrors {
    /// Smallest gap near each node (window of one contact distance along its zone) \[L\]; infinite where nothing is in reach.
    pub(super) gaps: Vec<f64>,
    /// Whether a zone lies in a segment that meets at the node.
    touched: Vec<bool>,
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
        let mut report = StepReport {
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
        };
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
        let patience = std::mem::replace(&mut self.options.newton.max_iterations, PREDICTED_ITERATIONS);
        let outcome = self.search_predicted(drive, &increment, report);
        self.options.newton.max_iterations = patience;
        if outcome.is_ok() && report.status == Status::Converged && report.departures == 0 {
            report.predicted = true;
            return Ok(true);
        }
        self.restore(before)?;
        (report.status, report.num_unstable) = (Status::Converged, 0);
        (report.augmentations, report.departures) = (0, 0);
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

    fn settle_into(&mut self, drive: &Drive, report: &mut StepReport) -> Result<(), SolveError> {
        let mut softened = false;
        for part in drive.parts(TURNS_AT_ONCE) {
            if self.softens()? {
                self.scale_contact(SOFTENING.powi(self.stages_left - SOFT_STAGES));
                self.stages_left = SOFT_STAGES;
                softened = true;
            }
            self.search(&part, report)?;
            if report.status != Status::Converged {
                break;
            }
        }
        if softened {
            let outcome = self.harden(report);
            report.softening = SOFTENING.powi(self.stages_left);
            outcome?;
        }
        self.enforce_gaps(report)
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

    /// Hardens the softened law in stages. Under a soft law strands slide several zone widths per iteration; hardening keeps gaps, so
    /// these are closed before. Where the mesh is too coarse for the hard law (lines of contact break up into points between
    /// nodes) hardening ends early.
    fn harden(&mut self, report: &mut StepReport) -> Result<(), SolveError> {
        for _ in 0..SOFT_AUGMENTATIONS {
            let errors = self.contact_errors();
            if report.status != Status::Converged || errors.penetration.max(errors.opening) < TOL_SOFT {
                break;
            }
            self.augment(&errors.gaps);
            self.search(&Drive::default(), report)?;
        }
        while report.status == Status::Converged && self.stages_left > 0 {
            let before = self.snapshot();
            self.scale_contact(SOFTENING);
            let patience = std::mem::replace(&mut self.options.newton.max_iterations, HARDENING_ITERATIONS);
            let outcome = self.search(&Drive::default(), report);
            self.options.newton.max_iterations = patience;
            if outcome.is_err() || report.status != Status::Converged {
                self.restore(before)?;
                report.status = Status::Converged;
                report.num_unstable = 0;
                return Ok(());
            }
            self.stages_left -= 1;
        }
        Ok(())
    }

    /// Whether load steps begin under a softened law: an augmented Lagrangian with strands near each other.
    fn softens(&mut self) -> Result<bool, SolveError> {
        if !matches!(self.engine.model.contact.law, ContactLaw::AugmentedLagrangian { .. }) {
            return Ok(false);
        }
        let state = self.engine.state.clone();
        self.engine.update_contact(&state)?;
        Ok(self.engine.contact.as_ref().is_some_and(|side| !side.broad_phase.pairs().is_empty()))
    }

    fn scale_contact(&mut self, factor: f64) {
        let touched = self.contact_errors().touched;
        if let Some(side) = &mut self.engine.contact {
            let line = side.nodes_on_lines(&touched);
            side.scale_stiffness(factor, &line);
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
        ContactErrors { gaps, touched, penetration, opening }
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
        }
        let state = self.engine.state.clone();
        self.engine.update_contact(&state).map(|_| ())
    }
}
