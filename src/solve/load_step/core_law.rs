//! The contact law as a path: from a soft core to the requested law.
//!
//! Without a guess, plectonemes would rewind by many turns if strands first sank into each other and then came apart.
//! So a step begins under a core law, with offsets and tensions that balance the shape (`multiplier_estimate`). An
//! intermediate law half as stiff in decades takes over its pressures, then the requested law does. Where the mesh does
//! not resolve the requested law, a softer one stays.

use crate::contact::law::Law;
use crate::solve::load_step::multiplier_estimate::MultiplierEstimate;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Failed, Status, StepReport};
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::search::newton::SearchOptions;

/// Depth of the core law relative to the contact distance, because with 0.1 instead a minicircle takes 442 iterations
/// for 404, and tweezers do not converge.
const DEPTH: f64 = 0.4;
/// Overlap, over the contact radius, from which strands are first separated under a law without a core, because at 2
/// [`DEPTH`] the core's energy is infinite.
const TOO_DEEP: f64 = 0.8 * 2.0 * DEPTH;
/// Factor between the penalties that are tried if the mesh does not resolve the requested one.
const STIFFNESS_RATIO: f64 = 10.0;
/// Softer laws that are tried, each by [`STIFFNESS_RATIO`], because contact a thousand times softer than requested is
/// another problem.
const MAX_SOFTER_LAWS: usize = 3;
/// Largest overlap of a shape, over the contact radius, whose pressures are estimated, because strands that are farther
/// inside each other are not in balance by any.
const MAX_OVERLAP_OF_SHAPE: f64 = 0.01;
/// Extent of the last step of a rough search, rad, because its end is only the start of the next one.
const ROUGH_EXTENT: f64 = 0.01;
/// Largest turn of a seam in one search, turns. Larger ones are made in parts, because a flat ring with ten turns at
/// once would buckle into its tenth mode.
pub(in crate::solve) const TURNS_AT_ONCE: f64 = 1.0;

impl Solver {
    /// Applies the drive in parts, under the core law first where contact is augmented; the size of the last increment.
    pub(super) fn continue_over_laws(
        &mut self,
        drive: &PrescribedMotion,
        report: &mut StepReport,
    ) -> Result<f64, Failed> {
        let augments = self.augments();
        let mut forces = if augments { self.soften(report)? } else { Vec::new() };
        let (mut rough, mut increment) = (false, 0.0);
        for part in drive.parts(TURNS_AT_ONCE) {
            rough = augments && self.is_near_contact()?;
            let options = SearchOptions { rough: rough.then(|| self.rough_extent()), ..self.search_options() };
            increment = self.search(&part, &SearchOptions { forces: &forces, ..options }, report)?;
            forces.clear();
        }
        if !augments {
            return Ok(increment);
        }
        if self.is_near_contact()? {
            return self.raise_penalty(report);
        }
        self.change_law(Law::Linear { stiffness: self.engine.contact_stiffness() }, &[]);
        if rough { self.search_from_here(report) } else { Ok(increment) }
    }

    /// Puts the core law in force, with offsets such that the pressures of touching strands balance the state; the
    /// forces in the rods that go with them.
    fn soften(&mut self, report: &mut StepReport) -> Result<Vec<[[f64; 3]; 3]>, Failed> {
        let near = self.is_near_contact()?;
        let pressure = self.engine.pressure_scale();
        let core = Law::Core { pressure, depth: DEPTH };
        let overlap = if near { self.contact_errors().penetration } else { 0.0 };
        let mut estimate = MultiplierEstimate::default();
        if overlap >= TOO_DEEP {
            // strands deep inside each other are separated under a law without a core first, where its energy is
            // infinite
            self.start_under(Law::Linear { stiffness: self.core_stiffness() }, &[]);
            self.search_roughly(report)?;
            if self.contact_errors().penetration >= TOO_DEEP {
                return Err(Status::Penetration.into());
            }
        } else if near && overlap < MAX_OVERLAP_OF_SHAPE {
            estimate = self.multiplier_estimate(core, pressure)?;
        }
        self.start_under(core, &estimate.pressures);
        Ok(estimate.forces)
    }

    /// Pressure of the core law over its depth \[F/L²\].
    fn core_stiffness(&self) -> f64 {
        self.engine.pressure_scale() / (DEPTH * 2.0 * self.engine.contact.min_radius)
    }

    /// From the core law to the requested one, or to the stiffest softer law that the mesh resolves: on a mesh too
    /// coarse for its law lines of contact break up into points between nodes.
    fn raise_penalty(&mut self, report: &mut StepReport) -> Result<f64, Failed> {
        let asked = self.engine.contact_stiffness();
        // half way in decades; a law softer than the core is reached at once
        self.change_law_keeping_pressures(Law::Linear { stiffness: asked.min((asked * self.core_stiffness()).sqrt()) });
        self.search_roughly(report)?;
        let before = self.snapshot();
        let mut softer = 0;
        loop {
            self.change_law(Law::Linear { stiffness: asked / STIFFNESS_RATIO.powi(softer) }, &[]);
            let outcome = self.search_from_here(report);
            let is_stopped = matches!(&outcome, Err(failed) if failed.status == Status::Stopped);
            if outcome.is_ok() || is_stopped || softer as usize == MAX_SOFTER_LAWS {
                return outcome;
            }
            self.restore(before.clone())?;
            softer += 1;
        }
    }

    /// A rough search without any motion: its result is the start of the next one.
    fn search_roughly(&mut self, report: &mut StepReport) -> Result<f64, Failed> {
        let options = SearchOptions { rough: Some(self.rough_extent()), ..self.search_options() };
        self.search(&PrescribedMotion::default(), &options, report)
    }

    /// Extent of the last step of a rough search under the law in force, rad.
    fn rough_extent(&self) -> f64 {
        match self.engine.contact.law {
            Law::Core { depth, .. } => ROUGH_EXTENT.min(depth),
            _ => ROUGH_EXTENT,
        }
    }
}
