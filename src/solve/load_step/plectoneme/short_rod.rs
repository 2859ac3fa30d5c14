//! Snap of a long straight rod into a plectoneme, made on a short one.
//!
//! Pulled and turned far enough, a straight rod snaps into a plectoneme between two straight tails (magnetic tweezers).
//! Its end loop and its transitions are the same on a rod of any length, its double helix and its tails are uniform. So
//! a piece of the rod is turned until it snaps, and brought to rest; then its double helix and its tails are lengthened
//! ([`Exchange`](super::growth)) to the length and the turns of the whole. The long rod converges from there like
//! from any other state, or says that it does not.

use crate::math::Vec3;
use crate::rod::{Placement, Rod};
use crate::scene::{Model, NodeRef};
use crate::solve::load_step::guess::Guess;
use crate::solve::load_step::plectoneme::growth::{longer, twist};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::Status;
use crate::solve::measures::{MAX_ROUNDS, NOTHING};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::{PrescribedValue, State};

/// Turn by which the short rod is turned farther, over its turn, until it snaps.
const MORE_TURN: f64 = 0.1;

/// Length of the short rod, in lengths (B/T)^½ over which tension T straightens a rod of bending stiffness B: a loop
/// and its transitions take some ten, and as many are to be left of each tail, along which bending decays by e per
/// length.
const LENGTHS: f64 = 30.0;

impl Solver {
    /// The plectoneme that a uniform rod snaps into whose end turns ([`turned_end`](super::growth::turned_end)); `None`
    /// if it is not straight, not long, stable, or if loads or obstacles make places of it differ, but for its ends.
    /// Iterations on the short rod are added to `elsewhere`.
    pub(super) fn snapped_short(&mut self, to: &State, elsewhere: &mut usize) -> Option<Guess> {
        let nodes = short_length(&self.engine)?;
        if !self.is_unstable(to)? {
            return None;
        }
        let mut short = self.piece(nodes)?;
        let mut iterations = 0;
        let mut turned = twist(short.engine.state());
        for round in 0..MAX_ROUNDS {
            let angle = if round == 0 { 0.0 } else { MORE_TURN * turned };
            let report = short.solve_step(&short.turn(angle));
            turned += angle;
            iterations += report.iterations;
            if report.status != Status::Converged || report.stiffness_reduction > 1.0 {
                return None;
            }
            if let Some(guess) = longer(&short.engine, to, twist(to) - turned) {
                *elsewhere += iterations;
                self.workspace.timings += short.workspace.timings;
                return Some(guess);
            }
        }
        None
    }

    /// Whether a state has unstable directions.
    pub(super) fn is_unstable(&mut self, state: &State) -> Option<bool> {
        let before = self.engine.exchange_state(state.clone());
        let unstable = self.workspace.count_unstable(&mut self.engine);
        self.engine.take_state(before);
        Some(unstable.ok()? > 0)
    }

    /// The first `nodes` of the rod, held and loaded as the whole.
    fn piece(&self, nodes: usize) -> Option<Self> {
        let (model, state) = (&self.engine.model, self.engine.state());
        let [rod] = &model.rods[..] else { return None };
        let number = |node: NodeRef| NodeRef { node: if node.node == 0 { 0 } else { nodes - 1 }, ..node };
        let mut supports = model.supports.clone();
        supports.iter_mut().for_each(|support| support.node = number(support.node));
        let mut loads = model.loads.clone();
        loads.iter_mut().for_each(|load| load.node = number(load.node));
        let length = rod.spacing() * (nodes - 1) as f64;
        let (positions, frames) = (state.positions()[..nodes].to_vec(), state.frames()[..nodes].to_vec());
        let placement = Placement { length, positions, frames, closed: false };
        let short = Rod::from_nodes(&rod.name, placement, rod.section, rod.order, rod.natural.clone()).ok()?;
        let (contact, electrostatics) = (model.contact, model.electrostatics);
        let model = Model { rods: vec![short], supports, loads, contact, electrostatics, ..Model::default() };
        let mut short = Self::new(model, self.options.clone()).ok()?;
        short.engine.prescribe([PrescribedValue::Load(state.load_factor())]);
        Some(short)
    }

    /// A drive that turns the last node about the rod by an angle, rad.
    fn turn(&self, angle: f64) -> PrescribedMotion {
        let state = self.engine.state();
        let last = state.positions().len() - 1;
        let about = state.frames()[last] * Vec3::z() * angle;
        PrescribedMotion { nodes: vec![(last, Vec3::zeros(), about)], seams: Vec::new() }
    }
}

/// Nodes of the short rod, if the rod is straight, under the same tension all along, and longer.
fn short_length(engine: &Engine) -> Option<usize> {
    let (model, rod) = (&engine.model, &engine.model.rods[0]);
    let x = engine.state().positions();
    let last = x.len() - 1;
    let is_end = |node: usize| node == 0 || node == last;
    // what the ends carry is far from where a piece snaps
    let at_ends = model.obstacles.iter().all(|obstacle| obstacle.carrier.is_some_and(|at| is_end(at.node)));
    let even = model.line_loads.is_empty() && at_ends && model.loads.iter().all(|l| is_end(l.node.node));
    let along: f64 = x.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let is_straight = (x[last] - x[0]).norm() >= (1.0 - NOTHING) * along;
    let tension = engine.actual_stress(engine.state())[rod.num_elements / 2][0][2];
    if !(even && is_straight && tension > 0.0) {
        return None;
    }
    let length = LENGTHS * (rod.section.bending[0] / tension).sqrt();
    let elements = (length / (rod.spacing() * rod.order as f64)).ceil();
    (elements < rod.num_elements as f64).then_some(elements as usize * rod.order + 1)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::scene::{LineLoad, NodeLoad, Obstacle};
    use crate::solve::load_step::guess::Ahead;
    use crate::solve::load_step::plectoneme::growth::tests::{dna, energies, turn};
    use crate::solve::load_step::plectoneme::growth::{link, turned_end};
    use crate::solve::load_step::step_report::Origin;

    /// A straight rod of `elements` that turns just before it snaps, and the drive on which it does.
    fn about_to_snap(elements: usize, sliding: usize) -> (Solver, PrescribedMotion) {
        let mut solver = dna(elements, sliding);
        // 2 (B T)^½/C = .1395 per nm
        let [before, after] = [0.13, 0.02].map(|part| part * 2.5 * elements as f64);
        let report = solver.solve_step(&turn(&solver, 1, before));
        assert_eq!((report.status, report.iterations_on_other_meshes), (Status::Converged, 0));
        let drive = turn(&solver, 1, after);
        (solver, drive)
    }

    /// A long rod converges with its link, and where it does the slow way, from the straight rod under the core
    /// law, in a small part of the iterations.
    #[test]
    fn long_rods_snap_as_short_ones_do() {
        // of 240 elements the slow way a loop passes over the end that slides
        let (mut solver, drive) = about_to_snap(220, 1);
        let before = solver.snapshot();
        let [quick, found] = snaps_by_a_piece(&mut solver, &drive);
        solver.restore(before).unwrap();
        let slow = solver.load_step_from(&[Origin::CoreLaw], &drive, &Ahead::Unknown);
        assert_eq!((slow.status, slow.num_unstable), (Status::Converged, 0));
        assert!(slow.iterations as f64 > 3.0 * quick, "{} {quick}", slow.iterations);
        let [scale, known] = energies(&solver);
        assert!((found - known).abs() < 1e-3 * scale, "{found} {known} of {scale}");
    }

    /// With the other end held; the slow way, a loop passes over the end that slides.
    #[test]
    fn no_loop_passes_over_an_end() {
        let (mut solver, drive) = about_to_snap(240, 0);
        snaps_by_a_piece(&mut solver, &drive);
    }

    /// Iterations on the whole rod, and the potential at rest.
    fn snaps_by_a_piece(solver: &mut Solver, drive: &PrescribedMotion) -> [f64; 2] {
        let report = solver.solve_step(drive);
        assert_eq!((report.status, report.num_unstable, report.start), (Status::Converged, 0, Some(Origin::ShortRod)));
        assert!(report.iterations_on_other_meshes > 0 && report.iterations < 100, "{}", report.iterations);
        let turned = 0.15 * 2.5 * solver.engine.model.rods[0].num_elements as f64 / TAU;
        assert!((link(solver.engine.state()) - turned).abs() < 1e-4, "{} {turned}", link(solver.engine.state()));
        [report.iterations as f64, energies(solver)[1]]
    }

    fn snaps(solver: &mut Solver, drive: &PrescribedMotion) -> bool {
        let to = turned_end(&solver.engine, drive).unwrap();
        solver.snapped_short(&to, &mut 0).is_some()
    }

    /// What is stable stays straight, what is short has no shorter piece, what is bent is not straight, and where loads
    /// are spread a piece is not like the whole.
    #[test]
    fn other_rods_snap_by_themselves() {
        let (mut solver, drive) = about_to_snap(240, 1);
        assert!(snaps(&mut solver, &drive) && short_length(&solver.engine).is_some());
        let little = turn(&solver, 1, 0.1);
        assert!(!snaps(&mut solver, &little), "stable");
        let mut model = solver.engine.model.clone();
        model.loads.push(NodeLoad { node: NodeRef { rod: 0, node: 300 }, ..model.loads[0] });
        assert!(!snaps(&mut as_loaded(&solver, model), &drive), "pulled in between");
        let mut model = solver.engine.model.clone();
        let force = Vec3::x() * 1e-3;
        model.line_loads.push(LineLoad { rod: 0, force, moment: Vec3::zeros() });
        assert!(!snaps(&mut as_loaded(&solver, model), &drive), "pulled all along");
        for (node, at_end) in [(0, true), (300, false)] {
            let mut model = solver.engine.model.clone();
            model.obstacles = vec![Obstacle::bead("bead", &model.rods, NodeRef { rod: 0, node }, 20.0)];
            let mut carrying = as_loaded(&solver, model);
            assert_eq!(snaps(&mut carrying, &drive), at_end, "a bead at node {node}");
        }
        solver.engine.state_mut().nodes_mut().0[300].y += 1e-3;
        assert!(!snaps(&mut solver, &drive), "bent");
        let (short, _) = about_to_snap(80, 1);
        assert_eq!(short_length(&short.engine), None, "short");
        let (mut slack, drive) = about_to_snap(240, 1);
        slack.engine.prescribe([PrescribedValue::Load(0.0)]);
        assert_eq!(slack.find_equilibrium().status, Status::Converged);
        assert!(!snaps(&mut slack, &drive), "without tension");
    }

    /// A solver of another model in the same state.
    fn as_loaded(solver: &Solver, model: Model) -> Solver {
        let mut other = Solver::new(model, solver.options.clone()).unwrap();
        let state = solver.engine.state();
        other.engine.take_state(other.engine.state().with_nodes(state.positions().to_vec(), state.frames().to_vec()));
        other.engine.prescribe([PrescribedValue::Load(state.load_factor())]);
        other
    }
}
