//! Large turns are made on a coarse mesh first.
//!
//! A step that turns a rod by several turns passes through equilibria that are not requested, and most of its
//! iterations are spent on these. A fine mesh is needed for lines of contact and for digits at the end, not on the way
//! there: strands coil as wide as they are thick or wider. So the step is made on every second to eighth node, on a
//! mesh no coarser than that of a draft ([`Fidelity::Draft`]). The nodes between are interpolated, contact offsets too,
//! and the whole mesh converges from there. If it does not, the step is made on the whole mesh alone.
//!
//! Smaller steps stay on the whole mesh. It would save a third of their work where they are not foreseen, too, but
//! branches would be chosen by the coarse mesh, and the ripples of its lines of contact show in the offsets (3e-3 of
//! the energy in a ply of three).
//!
//! No strand passes another when meshes are changed: strands in contact are two radii ε apart, and centrelines on the
//! two meshes, both piecewise cubic, are compared piece by piece and must agree to a tenth of ε.

use std::f64::consts::TAU;

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::math::Vec3;
use crate::rod::Natural;
use crate::scene::{ContactLaw, Fidelity};
use crate::solve::load_step::core_law::TURNS_AT_ONCE;
use crate::solve::load_step::guess::{ContactOfGuess, Guess};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::Status;
use crate::solve::options::Options;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::State;

/// Largest overlap, over the contact radius, from which a coarse mesh starts, because strands that are farther inside
/// each other are separated first.
const MAX_OVERLAP: f64 = 0.01;
/// Largest distance of the centrelines on two meshes, over the contact radius: strands in contact are two radii apart.
const SAME_CURVE: f64 = 0.1;

/// Factors between the elements of the mesh and of a coarse one.
const FACTORS: std::ops::RangeInclusive<usize> = 2..=8;

impl Solver {
    /// The equilibrium of a coarse mesh after several turns. Iterations there are added to `elsewhere`.
    ///
    /// # Errors
    /// Contact geometry that breaks down.
    pub(super) fn coarse_mesh_guess(
        &mut self,
        drive: &PrescribedMotion,
        elsewhere: &mut usize,
    ) -> Result<Option<Guess>, SolveError> {
        if drive.parts(TURNS_AT_ONCE).len() < 2 || !self.augments() {
            return Ok(None);
        }
        if self.is_near_contact()? && self.contact_errors().penetration > MAX_OVERLAP {
            return Ok(None);
        }
        let Some((factor, coarse)) = self.coarsest(drive) else { return Ok(None) };
        let Some(guess) = self.interpolated(coarse, factor, drive, elsewhere) else { return Ok(None) };
        let asked = Law::Linear { stiffness: self.engine.contact_stiffness() };
        if matches!(&guess.contact, ContactOfGuess::Known(contact) if contact.law != asked) {
            // a coarse mesh does not always carry the law
            self.take(&guess);
            self.engine.update_contact(&guess.state)?;
            self.change_law_keeping_pressures(asked);
            return Ok(Some(Guess { contact: ContactOfGuess::of(&self.engine), ..guess }));
        }
        Ok(Some(guess))
    }

    /// The equilibrium of a coarse mesh under the drive, interpolated to the nodes of this one.
    fn interpolated(
        &mut self,
        mut coarse: Self,
        factor: usize,
        drive: &PrescribedMotion,
        elsewhere: &mut usize,
    ) -> Option<Guess> {
        let node = |fine: usize| {
            let rod = self.engine.rod_of(fine);
            coarse.engine.first_node[rod] + (fine - self.engine.first_node[rod]) / factor
        };
        let nodes = drive.nodes.iter().map(|&(fine, by, turn)| (node(fine), by, turn)).collect();
        let made = coarse.solve_step(&PrescribedMotion { nodes, seams: drive.seams.clone() });
        *elsewhere += made.iterations;
        self.workspace.timings += coarse.workspace.timings;
        if made.status != Status::Converged || coarse.engine.check_turning().is_err() {
            return None;
        }
        let fine = coarse.refined(factor).ok()?;
        if !self.is_same(fine.engine.state(), &coarse.engine, factor) {
            return None;
        }
        let contact = ContactOfGuess::of(&fine.engine);
        Some(Guess { contact, escapes: made.escapes, ..Guess::of(fine.engine.state().clone()) })
    }

    /// The coarsest mesh that will do for the drive, with how many times fewer elements it has.
    fn coarsest(&self, drive: &PrescribedMotion) -> Option<(usize, Self)> {
        let needed: Option<Vec<usize>> =
            (0..self.engine.model.rods.len()).map(|rod| self.elements_needed(rod, drive)).collect();
        let needed = needed?;
        FACTORS.rev().find_map(|factor| {
            let enough = |(rod, &needed): (usize, &usize)| self.is_fine_enough(rod, factor, needed);
            needed.iter().enumerate().all(enough).then(|| Some((factor, self.coarse(factor)?)))?
        })
    }

    /// A solver for the same problem on every `factor`-th node, in the present state, if so few show it.
    fn coarse(&self, factor: usize) -> Option<Self> {
        let mut model = self.engine.model.coarsened(factor)?;
        // digits beyond a draft's are for the whole mesh
        if let ContactLaw::AugmentedLagrangian { tol_penetration, .. } = &mut model.contact.law {
            *tol_penetration = tol_penetration.max(Fidelity::Draft.accuracy().penetration);
        }
        // threads are those of this solver already
        let mut options = Options { threads: None, ..self.options.clone() };
        options.newton.tol_increment = options.newton.tol_increment.max(Fidelity::Draft.tol_increment());
        let mut coarse = Self::new(model, options).ok()?;
        let nodes = (0..self.engine.model.rods.len()).flat_map(|rod| self.engine.nodes(rod).step_by(factor));
        coarse.engine.set_state(self.engine.state().on_nodes(nodes)).ok()?;
        self.is_same(self.engine.state(), &coarse.engine, factor).then_some(coarse)
    }

    /// Cubic elements that a draft has where the drive leads, at most the largest number there is; `None` where nobody
    /// knows.
    fn elements_needed(&self, rod: usize, drive: &PrescribedMotion) -> Option<usize> {
        let engine = &self.engine;
        let body = &engine.model.rods[rod];
        let natural = match &body.natural {
            Natural::Straight => 0.0,
            Natural::Uniform { kappa } => Vec3::from(*kappa).norm() * body.length / TAU,
            Natural::AsShaped | Natural::Varying(_) => return None,
        };
        let link = (engine.state().seams()[rod] + drive.seams.get(rod).unwrap_or(&0.0)).abs() / TAU;
        let tangents: Vec<Vec3> = engine.frames(rod).iter().map(|frame| frame * Vec3::z()).collect();
        let bent = tangents.windows(2).map(|pair| pair[0].angle(&pair[1])).sum::<f64>() / TAU;
        let turns = bent.max(1.0 + link + natural);
        Some(Fidelity::Draft.elements(body.length, turns, body.section.contact_radius))
    }

    /// Whether every `factor`-th node of a rod is as many as `needed` cubic elements have, and says how frames turn.
    fn is_fine_enough(&self, rod: usize, factor: usize, needed: usize) -> bool {
        let engine = &self.engine;
        let body = &engine.model.rods[rod];
        body.num_segments() / (factor * Fidelity::ORDER) >= needed
            && body.can_be_coarsened(engine.frames(rod), engine.state().seams()[rod], factor)
    }

    /// Whether the centrelines of rods that take part in contact are the same in a state of this mesh and on one of
    /// `factor` times fewer elements.
    fn is_same(&self, state: &State, coarse: &Engine, factor: usize) -> bool {
        let side = &self.engine.contact;
        let [own, of_coarse] = [self.engine.tangents_of(state), coarse.tangents_of(coarse.state())];
        let deviation = |rod: usize, segment: usize| {
            let joined = |engine: &Engine, k: usize| {
                let (first, count) = (engine.first_node[rod], engine.nodes(rod).len());
                [first + k, first + (k + 1) % count]
            };
            let whole = of_coarse.cubic(coarse.state(), joined(coarse, segment)).0;
            let at = |k: usize| k as f64 / factor as f64;
            let parts = (0..factor).map(|k| {
                let part = whole.restrict(at(k), at(k + 1));
                let fine = own.cubic(state, joined(&self.engine, factor * segment + k)).0;
                part.b.iter().zip(&fine.b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
            });
            parts.fold(0.0, f64::max)
        };
        side.rods.iter().all(|&rod| {
            (0..coarse.model.rods[rod].num_segments()).all(|k| deviation(rod, k) <= SAME_CURVE * side.min_radius)
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rod::{Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};
    use crate::solve::load_step::guess::Ahead;
    use crate::solve::load_step::step_report::Origin;

    /// A flat ring of 64 elements, D/L = 0.02.
    fn ring(supports: Vec<Support>) -> Solver {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.01);
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let rod = Rod::new("ring", &shape, RodMesh::closed(64, 3), section, Natural::Straight).unwrap();
        Solver::new(Model { rods: vec![rod], supports, ..Model::default() }, Options::default()).unwrap()
    }

    pub(in crate::solve::load_step) fn turns(turns: f64) -> PrescribedMotion {
        PrescribedMotion { seams: vec![turns * TAU], ..PrescribedMotion::default() }
    }

    pub(in crate::solve::load_step) fn energy(solver: &Solver) -> f64 {
        solver.engine.residual(solver.engine.state()).potential.elastic.total()
    }

    /// The state is the one that the long way leads to: on a mesh that carries its lines of contact by what the
    /// augmented Lagrangian leaves open there. One node is held, so that supports are found on the coarse mesh, too.
    #[test]
    fn large_turns_end_where_the_long_way_does() {
        let held = Support { node: NodeRef { rod: 0, node: 64 }, position: [true; 3], rotation: [false; 3] };
        let [mut quick, mut slow] = [(); 2].map(|()| ring(vec![held]));
        let (drive, at) = (turns(-3.0), quick.engine.state().positions()[64]);
        let short = quick.solve_step(&drive);
        let long = slow.load_step_from(&[Origin::CoreLaw], &drive, &Ahead::Unknown);
        for report in [&short, &long] {
            assert_eq!((report.status, report.num_unstable), (Status::Converged, 0));
            assert!(report.penetration <= 1e-8, "{}", report.penetration);
        }
        assert!(short.iterations_on_other_meshes > 0 && long.iterations_on_other_meshes == 0);
        assert!(2 * short.iterations < long.iterations, "{} {}", short.iterations, long.iterations);
        assert!((energy(&quick) / energy(&slow) - 1.0).abs() < 1e-4, "{} {}", energy(&quick), energy(&slow));
        assert_eq!(quick.engine.state().seams(), slow.engine.state().seams());
        assert!((quick.engine.state().positions()[64] - at).norm() < 1e-12);
    }

    /// A report says how much softer than requested the law in force is, whichever search the step converged by:
    /// one that goes on from the state before says so, too. (Only the search that had softened it did.)
    #[test]
    fn softened_laws_are_told() {
        let mut solver = ring(vec![]);
        let asked = solver.engine.contact_stiffness();
        let in_force = |solver: &Solver| solver.engine.contact.law;
        assert_eq!(solver.solve_step(&turns(-3.0)).stiffness_reduction, 1.0);
        assert_eq!(in_force(&solver), Law::Linear { stiffness: asked });
        solver.harden_contact(0.1);
        let report = solver.resettle();
        assert_eq!((report.status, report.start), (Status::Converged, Some(Origin::Present)));
        assert_eq!(in_force(&solver), Law::Linear { stiffness: 0.1 * asked });
        assert!((report.stiffness_reduction - 10.0).abs() < 1e-12, "{}", report.stiffness_reduction);
    }

    /// A step stays on the whole mesh where the coarse one would miss something: a bend or a turn of frames between its
    /// nodes, supports there, more turns than it can bear. Steps of one turn are not worth it.
    #[test]
    fn what_a_coarse_mesh_does_not_see_is_left_alone() {
        let drive = turns(3.0);
        let factor = |solver: &Solver, drive: &PrescribedMotion| solver.coarsest(drive).map(|(factor, _)| factor);
        assert_eq!(factor(&ring(vec![]), &drive), Some(4));
        assert_eq!(factor(&ring(vec![]), &turns(7.0)), Some(2));
        assert_eq!(factor(&ring(vec![]), &turns(20.0)), None);
        let held = |node: usize| Support { node: NodeRef { rod: 0, node }, position: [true; 3], rotation: [false; 3] };
        assert_eq!(factor(&ring(vec![held(66)]), &drive), Some(2));
        assert_eq!(factor(&ring(vec![held(67)]), &drive), None);
        for (by, found) in [(0.5, Some(4)), (1.5, None)] {
            let mut bent = ring(vec![]);
            bent.engine.state_mut().nodes_mut().0[101].z += by * SAME_CURVE * 0.01;
            assert_eq!(factor(&bent, &drive), found);
        }
        for (by, found) in [(0.15, Some(4)), (0.25, Some(2)), (0.45, None)] {
            let mut twisted = ring(vec![]);
            for k in 0..4 {
                let turn = crate::math::quaternion::spin(TAU * by * (1.0 - (k as f64 - 2.0).abs() / 2.0));
                let frame = &mut twisted.engine.state_mut().nodes_mut().1[100 + k];
                *frame *= turn;
            }
            assert_eq!(factor(&twisted, &drive), found);
        }
        let report = ring(vec![]).solve_step(&turns(0.9));
        assert_eq!((report.status, report.iterations_on_other_meshes), (Status::Converged, 0));
    }

    /// A wish to stop is heeded on the coarse mesh.
    #[test]
    fn large_turns_are_interrupted() {
        let mut solver = ring(vec![]);
        solver.options.newton.interrupt.raise();
        let before = solver.engine.state().positions().to_vec();
        let report = solver.solve_step(&turns(3.0));
        assert_eq!(report.status, Status::Stopped);
        assert!(report.iterations_on_other_meshes <= 1 && report.iterations <= 1, "{report:?}");
        assert_eq!(solver.engine.state().positions(), before);
    }
}
