//! One search from start to end: plain Newton where it is safe, then the trust region.

use crate::error::SolveError;
use crate::solve::measures::MAX_ITERATIONS;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, PrescribedMotion, lifted};
use crate::solve::search::newton::{Iteration, NewtonOptions, NewtonReport, SearchOptions};
use crate::solve::search::timing::timed;
use crate::solve::search::workspace::Workspace;

impl Workspace {
    /// Finds an equilibrium from the engine's state with the motions of `drive`; the engine keeps the last iterate.
    ///
    /// A plain mixed Newton search comes first where nothing is near contact: it takes a rod through a full circle in
    /// one step, across indefinite tangents between two stable states. It comes first, too, near an equilibrium. The
    /// trust-region search follows if it does not converge, if strands would touch or pass each other, and when leaving
    /// an unstable state (`options.leaving`).
    ///
    /// # Errors
    /// Numerical breakdown; the report says whether the search converged.
    pub(crate) fn equilibrate(
        &mut self,
        engine: &mut Engine,
        drive: &PrescribedMotion,
        options: &SearchOptions,
    ) -> Result<NewtonReport, SolveError> {
        let leaving = options.leaving;
        let Lifted { state: mut start, drive, .. } = lifted(engine, engine.state(), drive);
        engine.swivels.iter().for_each(|swivel| swivel.restore(&mut start));
        let drive = &drive;
        engine.take_state(start.clone());
        self.refresh(engine, &start)?;
        let near_contact = engine.contact.may_push();
        let mut spent = Vec::new();
        let stable_only = options.newton.stable_only;
        let newton = NewtonOptions { stable_only: false, max_iterations: MAX_ITERATIONS, ..options.newton.clone() };
        let direct = SearchOptions { newton, ..options.clone() };
        if stable_only && leaving.is_none() && !engine.contact.is_empty() && (options.near_rest || !near_contact) {
            let plain = if near_contact { Self::direct_in_contact } else { Self::direct_apart };
            if let Some(report) = plain(self, engine, drive, &direct, &mut spent)? {
                return Ok(report);
            }
            engine.take_state(start.clone());
            self.refresh(engine, &start)?;
        }
        if !stable_only || engine.contact.is_empty() && leaving.is_none() {
            let direct = if stable_only { &direct } else { options };
            match self.direct(engine, drive, direct, stable_only) {
                Ok(report) if !stable_only || report.converged || report.interrupted => return Ok(report),
                Ok(report) => spent = report.iterations,
                Err(_) if stable_only => {}
                Err(error) => return Err(error),
            }
            engine.take_state(start);
        }
        let mut report = self.trust_region_search(engine, drive, options)?;
        spent.append(&mut report.iterations);
        report.iterations = spent;
        Ok(report)
    }

    /// The plain search without contact, for rods that are apart. Its result counts if nothing touches there and a path
    /// without passage leads there; otherwise its iterations are added to `spent`.
    fn direct_apart(
        &mut self,
        engine: &mut Engine,
        drive: &PrescribedMotion,
        options: &SearchOptions,
        spent: &mut Vec<Iteration>,
    ) -> Result<Option<NewtonReport>, SolveError> {
        let before = engine.state().clone();
        let side = std::mem::replace(&mut engine.contact, ContactSide::none());
        let outcome = self.direct(engine, drive, options, true);
        engine.contact = side;
        // after a breakdown the other searches begin from the start
        let Ok(mut report) = outcome else { return Ok(None) };
        if report.interrupted {
            return Ok(Some(report));
        }
        if report.converged
            && timed(&mut self.timings.detection, || engine.is_path_free(&before)).unwrap_or(false)
            && !engine.is_touching()
        {
            if engine.contact.is_near() {
                report.num_unstable = self.count_unstable(engine)?;
            }
            return Ok(Some(report));
        }
        spent.append(&mut report.iterations);
        Ok(None)
    }

    /// The plain search with contact: where pressures hardly change, its steps are as good as those of the trust region
    /// at a third of the cost. Its result counts if it is stable; otherwise its iterations are added to `spent`.
    fn direct_in_contact(
        &mut self,
        engine: &mut Engine,
        drive: &PrescribedMotion,
        options: &SearchOptions,
        spent: &mut Vec<Iteration>,
    ) -> Result<Option<NewtonReport>, SolveError> {
        let before = engine.contact.before.clone();
        // after a breakdown the trust-region search begins from the start
        if let Ok(mut report) = self.direct(engine, drive, options, true) {
            if report.interrupted || report.converged && report.num_unstable == 0 {
                return Ok(Some(report));
            }
            spent.append(&mut report.iterations);
        }
        engine.contact.before = before;
        Ok(None)
    }
}
