//! Contact enforced: the loop of the augmented Lagrangian.

use crate::scene::ContactLaw;
use crate::solve::load_step::multipliers::SecantSteps;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Failed, Status, StepReport};
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::search::newton::SearchOptions;

/// Times that contact tangents are taken from the state at rest, because the second round corrects and the third
/// confirms.
pub(in crate::solve) const MAX_TANGENT_ROUNDS: usize = 3;

impl Solver {
    /// Raises and lowers offsets until penetrations and gaps open under force are within the tolerance, and the
    /// tangents of the contact centrelines are those of the state. From a search whose last increment is this; by
    /// searches that leave unstable equilibria so often.
    pub(super) fn enforce_contact(
        &mut self,
        mut increment: f64,
        max_escapes: usize,
        report: &mut StepReport,
    ) -> Result<(), Failed> {
        let mut secant_steps = match self.engine.model.contact.law {
            ContactLaw::AugmentedLagrangian { tol_penetration, .. } => Some(SecantSteps::new(tol_penetration)),
            _ => None,
        };
        let mut num_followed = 0;
        loop {
            if num_followed < MAX_TANGENT_ROUNDS && self.engine.follow_tangents() {
                num_followed += 1;
                increment = self.search_nearly(max_escapes, report)?;
                continue;
            }
            let outstanding =
                secant_steps.as_mut().and_then(|steps| Some((self.outstanding_in(report, steps)?, steps)));
            match outstanding {
                None if increment <= self.options.newton.tol_increment => return Ok(()),
                None => {
                    let options = SearchOptions { max_escapes, ..self.search_options() };
                    self.search(&PrescribedMotion::default(), &options, report)?;
                    // to the full tolerance
                    increment = 0.0;
                }
                Some(_) if report.augmentations >= self.options.max_augmentations => {
                    return Err(Status::Penetration.into());
                }
                Some((gaps, steps)) => {
                    self.augment(&gaps, steps);
                    report.augmentations += 1;
                    increment = self.search_nearly(max_escapes, report)?;
                }
            }
        }
    }

    /// Gaps that are to be closed or released, with what is left noted in the report; `None` at the end.
    fn outstanding_in(&self, report: &mut StepReport, secant_steps: &mut SecantSteps) -> Option<ContactField> {
        let outstanding = self.outstanding(secant_steps);
        report.penetration = outstanding.penetration;
        report.complementarity = outstanding.complementarity.unwrap_or(report.complementarity);
        outstanding.gaps
    }

    /// A search between two augmentations. Newton's method converges quadratically, so after a last increment of √tol
    /// the error is of the order of tol; the last search of all uses the tolerance itself.
    fn search_nearly(&mut self, max_escapes: usize, report: &mut StepReport) -> Result<f64, Failed> {
        let mut options = SearchOptions { max_escapes, near_rest: true, ..self.search_options() };
        if self.augments() && self.is_near_contact()? {
            options.newton.tol_increment = options.newton.tol_increment.sqrt();
        }
        self.search(&PrescribedMotion::default(), &options, report)
    }
}
