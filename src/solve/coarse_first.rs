//! Large turns are made on a coarse mesh first.
//!
//! A step that turns a rod by several turns passes through equilibria that nobody asked for, and most of its iterations are spent on these. What a mesh is fine for are
//! lines of contact and digits at the end of the way, not the way: strands coil as wide as they are thick or wider. So the step is made on every eighth, fourth or second
//! node, as far as that is as fine as a draft would be ([`Fidelity::Draft`]). The nodes between are interpolated in what comes of it, with contact law and
//! offsets, and this settles on the whole mesh like any other state: it ends in equilibrium, or the step is made the long way.
//!
//! No strand passes another when meshes are changed: strands in contact are two radii ε apart, and centrelines on the two meshes, both
//! piecewise cubic, are compared piece by piece and must agree to a tenth of ε.

use std::f64::consts::TAU;

use crate::error::SolveError;
use crate::math::Vec3;
use crate::rod::Natural;
use crate::scene::Fidelity;
use crate::solve::Options;
use crate::solve::engine::{Engine, contact_cubic};
use crate::solve::path::Solver;
use crate::solve::settle::{AT_REST, HARDENING_ITERATIONS, Status, StepReport, TURNS_AT_ONCE};
use crate::solve::state::{Drive, State};

/// How many times fewer elements a coarse mesh has, tried in this order.
const FACTORS: [usize; 3] = [8, 4, 2];
/// How far centrelines on two meshes may be from each other, contact radii.
const SAME: f64 = 0.1;

impl Solver {
    /// Tries to settle a step of several turns from where it leads on a coarse mesh; true if it did, otherwise the solver is back where it was.
    pub(crate) fn settle_from_coarse(&mut self, drive: &Drive, report: &mut StepReport) -> Result<bool, SolveError> {
        if drive.parts(TURNS_AT_ONCE).len() < 2 || !self.augments() {
            return Ok(false);
        }
        if self.is_near_contact()? && self.contact_errors().penetration > AT_REST {
            return Ok(false);
        }
        let Some((factor, coarse)) = FACTORS.iter().find_map(|&factor| Some((factor, self.coarse(factor, drive)?)))
        else {
            return Ok(false);
        };
        let start = self.snapshot();
        let settled = self.settle_by(coarse, factor, drive, report);
        if !matches!(settled, Ok(true)) {
            self.restore(start)?;
            report.start_again();
        }
        settled
    }

    fn settle_by(
        &mut self,
        mut coarse: Self,
        factor: usize,
        drive: &Drive,
        report: &mut StepReport,
    ) -> Result<bool, SolveError> {
        let node = |fine: usize| {
            let rod = self.engine.rod_of(fine);
            coarse.engine.first_node[rod] + (fine - self.engine.first_node[rod]) / factor
        };
        let nodes = drive.nodes.iter().map(|&(fine, by, turn)| (node(fine), by, turn)).collect();
        let made = coarse.settle(&Drive { nodes, seams: drive.seams.clone() });
        report.coarse_iterations += made.iterations;
        self.workspace.interrupted |= made.status == Status::Stopped;
        if made.status != Status::Converged || coarse.engine.check_turning().is_err() {
            return Ok(false);
        }
        let again = |fine| (1..factor.ilog2()).try_fold(fine, |fine: Self, _| fine.refined());
        let Ok(fine) = coarse.refined().and_then(again) else { return Ok(false) };
        if !self.is_same(&fine.engine.state, &coarse.engine, factor) {
            return Ok(false);
        }
        if let (Some(side), Some(from)) = (&mut self.engine.contact, fine.engine.contact) {
            (side.law, side.offsets, side.before) = (from.law, from.offsets, None);
        }
        self.stages_left = fine.stages_left;
        self.engine.state = fine.engine.state;
        let still = vec![0.0; 6 * self.engine.num_nodes()];
        let settled = self.settle_predicted(&Drive::default(), still, HARDENING_ITERATIONS, report)?;
        report.predicted = false;
        Ok(settled)
    }

    /// A solver for the same problem on every `factor`-th node, in the present state, if that mesh is fine enough for the drive.
    fn coarse(&self, factor: usize, drive: &Drive) -> Option<Self> {
        if !(0..self.engine.model.rods.len()).all(|rod| self.is_fine_enough(rod, factor, drive)) {
            return None;
        }
        let model = self.engine.model.coarsened(factor)?;
        // threads are those of this solver already
        let mut coarse = Self::new(model, Options { threads: None, ..self.options.clone() }).ok()?;
        let nodes = || (0..self.engine.model.rods.len()).flat_map(|rod| self.engine.nodes(rod).step_by(factor));
        let all = &self.engine.state;
        let state = State {
            positions: nodes().map(|node| all.positions[node]).collect(),
            remainders: nodes().map(|node| all.remainders[node]).collect(),
            frames: nodes().map(|node| all.frames[node]).collect(),
            ..all.clone()
        };
        coarse.engine.set_state(state).ok()?;
        self.is_same(&self.engine.state, &coarse.engine, factor).then_some(coarse)
    }

    /// Whether a mesh of so many times fewer elements is as fine as a draft where the drive leads.
    fn is_fine_enough(&self, rod: usize, factor: usize, drive: &Drive) -> bool {
        let engine = &self.engine;
        let body = &engine.model.rods[rod];
        let natural = match body.natural {
            Natural::Straight => 0.0,
            Natural::Uniform { kappa } => Vec3::from(kappa).norm() * body.length / TAU,
            Natural::AsShaped => return false,
        };
        let link = (engine.state.seams[rod] + drive.seams.get(rod).unwrap_or(&0.0)).abs() / TAU;
        let tangents: Vec<Vec3> = engine.frames(rod).iter().map(|frame| frame * Vec3::z()).collect();
        let bent = tangents.windows(2).map(|pair| pair[0].angle(&pair[1])).sum::<f64>() / TAU;
        let turns = bent.max(1.0 + link + natural);
        let needed = Fidelity::ORDER * Fidelity::Draft.elements(body.length, turns, body.section.contact_radius);
        body.num_segments() >= factor * needed
    }

    /// Whether the centrelines of rods that take part in contact are the same in a state of this mesh and on one of `factor` times fewer elements.
    fn is_same(&self, state: &State, coarse: &Engine, factor: usize) -> bool {
        let Some(side) = &self.engine.contact else { return true };
        let deviation = |rod: usize, segment: usize| {
            let joined = |engine: &Engine, k: usize| {
                let (first, count) = (engine.first_node[rod], engine.nodes(rod).len());
                [first + k, first + (k + 1) % count]
            };
            let spacing = self.engine.model.rods[rod].spacing();
            let whole = contact_cubic(&coarse.state, joined(coarse, segment), spacing * factor as f64);
            let at = |k: usize| k as f64 / factor as f64;
            let parts = (0..factor).map(|k| {
                let part = whole.restrict(at(k), at(k + 1));
                let fine = contact_cubic(state, joined(&self.engine, factor * segment + k), spacing);
                part.b.iter().zip(&fine.b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
            });
            parts.fold(0.0, f64::max)
        };
        side.rods
            .iter()
            .all(|&rod| (0..coarse.model.rods[rod].num_segments()).all(|k| deviation(rod, k) <= SAME * side.min_radius))
    }
}
