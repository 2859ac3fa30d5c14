//! The law by the mesh, by what touches.
//!
//! Lines of contact limit its stiffness from above, points from below: their forces have an error of κ^(−2/3)
//! ([`ContactLaw::ByMesh`](crate::scene::ContactLaw::ByMesh)). Which there are is known when a state has been found. So a state that
//! touches at points only is settled once more under the law of points, one with lines under that of lines. The next step begins
//! under the law that the last one ended with.

use crate::contact::law::Law;
use crate::solve::load_step::guess::Ahead;
use crate::solve::load_step::penalty_continuation::AT_POINTS;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::{Origin, Status, StepReport};
use crate::solve::problem::contact_side::Touching;
use crate::solve::problem::prescribed_motion::PrescribedMotion;

impl Solver {
    /// Settles an accepted state under the law of its contacts, if another one is in force. Where that fails, or leads to
    /// lines again, the state stays as it was.
    pub(in crate::solve) fn settle_under_own_law(&mut self, report: &mut StepReport) {
        if report.status != Status::Converged {
            return;
        }
        let Some(before) = self.engine.contact.as_ref().map(|side| side.touching) else { return };
        let of_lines = self.engine.model.contact.law;
        if self.engine.law_where(Touching::Points, of_lines) == of_lines {
            return;
        }
        let touching = if self.kinks_at_points() { Touching::Lines } else { self.touching() };
        if touching == before {
            return;
        }
        let snapshot = self.snapshot();
        let settled = self.settle_under(touching);
        let is_at_rest = settled.status == Status::Converged;
        if is_at_rest && (touching == Touching::Lines || self.touching() == touching) {
            // it came from where it came from
            let start = report.start;
            report.join(settled);
            report.start = start;
            return;
        }
        report.iterations += settled.iterations;
        if let Err(error) = self.restore(snapshot) {
            *report = StepReport::refused(error);
        }
    }

    /// Whether a point of contact kinks a rod: its shear F/GA then decides where it lies, and its share of bending is felt over
    /// (B/GA)^½ on either side.
    fn kinks_at_points(&self) -> bool {
        self.engine.model.rods.iter().any(|rod| {
            let section = &rod.section;
            section.smaller_bending() > section.shearing[0].min(section.shearing[1]) * section.contact_radius.powi(2)
        })
    }

    /// A search from the present state under the law for what strands touch at. Forces of contact stay.
    fn settle_under(&mut self, touching: Touching) -> StepReport {
        let before = self.engine.contact_stiffness();
        let pressures = self.pressures();
        self.choose_law_for(touching);
        let stiffness = self.engine.contact_stiffness();
        let grown = match touching {
            // p = κδ at F ∝ κδ^1.5
            Touching::Points => (stiffness / before).powf(1.0 - 1.0 / AT_POINTS),
            Touching::Lines => 1.0,
        };
        self.change_law_to(Law::Linear { stiffness }, &pressures.map(|_, pressure| grown * pressure));
        self.forget_pressures();
        self.load_step_from(&[Origin::Present], &PrescribedMotion::default(), &Ahead::Present)
    }

    /// Makes the law requested that for what strands touch at; the one in force stays.
    pub(super) fn choose_law_for(&mut self, touching: Touching) {
        self.engine.contact.iter_mut().for_each(|side| side.touching = touching);
    }
}
