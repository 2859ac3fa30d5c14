//! Searches that leave unstable equilibria.
//!
//! An equilibrium with a negative eigenvalue is left along its most negative direction, and the search goes on
//! downhill. If the potential falls by no more than rounding the motion is neutral, such as the turning of the helix of
//! a ring with two bending stiffnesses, and the state counts as stable.

use crate::error::SolveError;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Failed, Status, StepReport};
use crate::solve::measures::HALVINGS;
use crate::solve::problem::assembly::Potential;
use crate::solve::problem::moment_load::work_of_moments;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::State;
use crate::solve::search::newton::{NewtonReport, SearchOptions};

/// Fall of the potential, over the energy stored, from which leaving an unstable equilibrium was worth the name.
const LEAST_FALL: f64 = 0.01;

/// Energy stored in rods and contact \[F·L\].
fn stored_energy(potential: &Potential) -> f64 {
    potential.elastic.total() + potential.contact.abs()
}

impl Solver {
    /// Equilibrium search that leaves unstable equilibria, from which the potential falls by more than rounding; the
    /// increment that is left, see [`increment_size`](crate::solve::search::newton::increment_size).
    pub(super) fn search(
        &mut self,
        drive: &PrescribedMotion,
        options: &SearchOptions,
        report: &mut StepReport,
    ) -> Result<f64, Failed> {
        // without a potential the inertia of the symmetric part does not decide stability
        let leaves = self.options.leave_unstable && self.engine.is_conservative();
        let options = SearchOptions { max_escapes: if leaves { options.max_escapes } else { 0 }, ..options.clone() };
        let mut outcome = self.equilibrate(drive, &options, report)?;
        // nothing is known of where a descent leads
        let options = options.without_foresight();
        let mut idle = 0;
        while options.is_at_rest(&outcome) && outcome.num_unstable > 0 && leaves {
            let may_leave = idle < options.max_escapes;
            let (before, potential) = (self.engine.state().clone(), self.engine.residual(self.engine.state()));
            let direction = self.workspace.negative_direction(&mut self.engine)?;
            let increment: Vec<f64> = direction.iter().map(|x| x * self.options.escape_step).collect();
            let still = PrescribedMotion::default();
            let fraction = self.first_fraction(&before, &increment)?;
            self.engine.take_state(self.engine.retract(&before, &increment, fraction));
            let work = work_of_moments(&self.engine, &increment) * fraction;
            let floor = potential.potential.total() + work - potential.rounding;
            let floor = if may_leave { f64::NEG_INFINITY } else { floor };
            let leaving = SearchOptions { leaving: Some(floor), ..options.clone() };
            let left = self.equilibrate(&still, &leaving, report)?;
            let end = self.engine.residual(self.engine.state()).potential.total() - work - left.work;
            let fall = potential.potential.total() - end;
            let is_neutral = left.converged && fall.abs() <= potential.rounding;
            if may_leave && !is_neutral {
                report.escapes += 1;
                idle = if fall > LEAST_FALL * stored_energy(&potential.potential) { 0 } else { idle + 1 };
                outcome = left;
                continue;
            }
            self.engine.take_state(before);
            self.engine.update_contact(&self.engine.state().clone())?;
            if !is_neutral {
                break;
            }
            outcome.num_unstable = 0;
        }
        report.num_unstable = outcome.num_unstable;
        if !outcome.converged {
            return Err(Failed { status: Status::MaxIterations, error: outcome.obstacle });
        }
        if options.is_at_rest(&outcome) && outcome.num_unstable > 0 && leaves {
            return Err(Status::Unstable.into());
        }
        Ok(outcome.left)
    }

    /// How far to go along an increment: strands pass nothing, nor are pressed deeper than the law has forces for.
    fn first_fraction(&mut self, from: &State, increment: &[f64]) -> Result<f64, SolveError> {
        let mut fraction = self.engine.step_fraction(from, increment)?;
        for _ in 0..HALVINGS {
            let there = self.engine.retract(from, increment, fraction);
            if self.engine.potential_at(&there).is_ok_and(|potential| potential.total().is_finite()) {
                break;
            }
            fraction *= 0.5;
        }
        Ok(fraction)
    }

    /// A search that ends at any equilibrium.
    fn equilibrate(
        &mut self,
        drive: &PrescribedMotion,
        options: &SearchOptions,
        report: &mut StepReport,
    ) -> Result<NewtonReport, Failed> {
        let outcome = self.workspace.equilibrate(&mut self.engine, drive, options)?;
        report.iterations += outcome.iterations.len();
        self.workspace.timings.node_iterations += outcome.iterations.len() * self.engine.num_nodes();
        report.history.push(outcome.iterations.clone());
        if outcome.interrupted { Err(Status::Stopped.into()) } else { Ok(outcome) }
    }
}
