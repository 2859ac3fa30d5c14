//! First linearisation after the penalty was raised.
//!
//! The rods hardly notice the change of a law, so a point of contact keeps its force F ∝ κδ^{3/2}, δ the penetration,
//! while its strands move apart by some d and its zone narrows. If each place is linearised about the overlap that
//! gives its *own* pressure, as [`Pressures`](crate::contact::potential::Pressures) does for all laws, the first step
//! closes 0.6 of δ when κ rises tenfold, and the force of the point is two and a half times too large, so that the
//! tangent may be indefinite. Here d follows from the force of the point, and the new law is linearised about strands
//! moved apart by d. Lines of contact keep their pressure, F ∝ κδ, so there each place keeps its own.

use crate::contact::law::{Law, shortest_line};
use crate::error::SolveError;
use crate::solve::load_step::solver::Solver;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_side::ContactSide;

/// Evaluations of the law at lowered offsets, because the second measures the exponent, the third confirms it.
const ROUNDS: usize = 3;

/// Exponent of F in δ at a point of contact that is far from opening, because its zone grows as √δ.
const AT_POINTS: f64 = 1.5;

/// A run of segments of one strand that touch another.
#[derive(Debug)]
struct ContactRun {
    segments: Vec<usize>,
    /// Length of the zone \[L\].
    length: f64,
    /// Force \[F\].
    force: f64,
    /// Largest overlap \[L\].
    depth: f64,
    /// Length from which it is a line under a contact stiffness of 1 \[L\].
    shortest_line: f64,
}

impl Solver {
    /// After a penalty was raised: linearises the new law about the overlaps for which contact keeps its forces.
    pub(in crate::solve) fn linearise_about_harder_law(&mut self) -> Result<(), SolveError> {
        let side = &self.engine.contact;
        let (Law::Linear { stiffness }, Some((Law::Linear { stiffness: before }, offsets))) = (side.law, &side.before)
        else {
            return Ok(());
        };
        let (law, before, ratio, own) = (side.law, *before, stiffness / before, side.offsets.clone());
        if ratio <= 1.0 || *offsets != own {
            return Ok(());
        }
        let state = self.engine.state().clone();
        self.engine.update_contact(&state)?;
        let overlaps = self.overlaps();
        let runs = self.runs(&overlaps);
        if runs.iter().any(|run| run.length > run.shortest_line / before.powf(0.25)) {
            return Ok(());
        }
        let mut left: Vec<f64> = runs.iter().map(|run| run.depth * ratio.powf(-1.0 / AT_POINTS)).collect();
        let mut last: Vec<[f64; 2]> = runs.iter().map(|run| [run.depth, run.force]).collect();
        // the second evaluation measures the exponent of F in δ, the third confirms it
        for _ in 0..ROUNDS {
            self.set_offsets(lowered(&self.engine.contact, &own, &runs, &left));
            let there = self.overlaps();
            self.set_offsets(own.clone());
            for (k, run) in runs.iter().enumerate() {
                let force: f64 = run.segments.iter().map(|&segment| there[segment].force).sum();
                let exponent = (force / last[k][1]).ln() / (left[k] / last[k][0]).ln();
                let exponent = if exponent.is_finite() { exponent.clamp(1.0, 2.0) } else { AT_POINTS };
                last[k] = [left[k], force];
                let wanted = left[k] * (run.force / ratio / force).powf(1.0 / exponent);
                left[k] = if wanted.is_finite() { wanted.clamp(0.0, run.depth) } else { run.depth };
            }
        }
        let lowered = lowered(&self.engine.contact, &own, &runs, &left);
        self.engine.contact.before = Some((law, lowered));
        Ok(())
    }

    fn set_offsets(&mut self, offsets: ContactField) {
        self.engine.contact.offsets = offsets;
    }

    /// Contact of each segment as a slave and with obstacles, in the engine's state.
    fn overlaps(&self) -> Vec<Felt> {
        let side = &self.engine.contact;
        let mut felt = vec![Felt::default(); side.set.len()];
        let residual = self.engine.residual(self.engine.state());
        for term in residual.contact_pairs {
            let here = &mut felt[term.slave];
            let offset = side.offset(term.slave, term.master);
            let rod = |segment: usize| &self.engine.model.rods[self.engine.rod_of(side.nodes[segment][0])];
            let bending = [term.slave, term.master].map(|segment| rod(segment).section.smaller_bending());
            here.shortest_line = shortest_line(1.0, bending);
            for zone in &term.zones {
                here.force += zone.force;
                here.length += (zone.piece.u[1] - zone.piece.u[0]) * side.set.lengths[term.slave];
                here.depth = here.depth.max(offset[0].max(offset[1]) - zone.min_gap);
            }
        }
        for contact in residual.surface_contacts {
            let here = &mut felt[contact.segment];
            let offset = side.offset_to_surface(contact.segment, contact.surface);
            let rod = &self.engine.model.rods[self.engine.rod_of(side.nodes[contact.segment][0])];
            here.shortest_line = shortest_line(1.0, [rod.section.smaller_bending(), f64::INFINITY]);
            for zone in &contact.zones {
                here.force += zone.moments[0];
                here.length += (zone.u[1] - zone.u[0]) * side.set.lengths[contact.segment];
                here.depth = here.depth.max(offset[0].max(offset[1]) - zone.min_gap);
            }
        }
        felt
    }

    /// Runs of segments that touch.
    fn runs(&self, felt: &[Felt]) -> Vec<ContactRun> {
        let side = &self.engine.contact;
        let touches = |segment: usize| felt[segment].depth > 0.0;
        let begins = |segment: &usize| touches(*segment) && !side.set.prev(*segment).is_some_and(touches);
        let run = |first: usize| {
            let shortest_line = felt[first].shortest_line;
            let mut run = ContactRun { segments: vec![first], length: 0.0, force: 0.0, depth: 0.0, shortest_line };
            while let Some(next) = side.set.next(run.segments[run.segments.len() - 1]).filter(|k| touches(*k)) {
                run.segments.push(next);
            }
            for &k in &run.segments {
                run.length += felt[k].length;
                run.force += felt[k].force;
                run.depth = run.depth.max(felt[k].depth);
            }
            run
        };
        (0..felt.len()).filter(begins).map(run).collect()
    }
}

/// Contact of a segment as a slave.
#[derive(Debug, Clone, Copy, Default)]
struct Felt {
    force: f64,
    length: f64,
    depth: f64,
    /// Length from which it is a line under a contact stiffness of 1 \[L\].
    shortest_line: f64,
}

/// Offsets lowered by as much as the strands of each run move apart.
fn lowered(side: &ContactSide, own: &ContactField, runs: &[ContactRun], left: &[f64]) -> ContactField {
    let mut offsets = own.clone();
    for (run, left) in runs.iter().zip(left) {
        for node in run.segments.iter().flat_map(|&segment| side.nodes[segment]) {
            for k in own.of_node(node) {
                offsets.values[k] = offsets.values[k].min(own.values[k] - (run.depth - left));
            }
        }
    }
    offsets
}
