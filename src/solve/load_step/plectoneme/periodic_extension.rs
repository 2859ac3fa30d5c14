//! Periodic extension: the start of a long plectoneme from the equilibrium of a short one.
//!
//! A long plectoneme is uniform but near its end loops, and these are the same at any length. So where the start state
//! of a closed rod is a uniform double helix in the middle, elements are cut out of it, and the short rod is brought to
//! rest. Then the elements are put back, in the shape of the short rod's middle (`double_helix`), and the rod closes
//! again exactly. The short rod's link is chosen so that the long one keeps its own. The long rod then converges
//! from there like from any other state, or says that it does not.
//!
//! Pressures are smoothed on the short rod first ([`Solver::smooth_pressures`]). Otherwise ripples of elements that
//! face each other let strands slide along each other in waves: the curvature of the energy along these is negative by
//! some κa²/h², a the ripples' height, whatever the wave's length, while stretching holds them by EA q², from some
//! 3·10⁴ nodes on no longer.

use std::f64::consts::TAU;

use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::{Natural, Placement, Rod};
use crate::scene::{ContactLaw, Model};
use crate::solve::load_step::guess::{Ahead, ContactOfGuess, Guess, LawInForce};
use crate::solve::load_step::plectoneme::double_helix::{DoubleHelix, NodeOrigin, Screw};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::Status;
use crate::solve::measures::{MAX_ROUNDS, ROUNDING};
use crate::solve::problem::prescribed_motion::{PrescribedMotion, twist};
use crate::solve::problem::state::{PrescribedValue, State};
use crate::solve::search::timing::Timings;

/// Times that pressures are smoothed, because the second time corrects and the third confirms.
const SMOOTHINGS: usize = 3;
/// Link, turns, that may be missing on the long rod, because its twist takes up as little.
const SAME_LINK: f64 = 1e-3;
/// Distance over the node spacing, and turn, rad, up to which two states are the same, because meshes do not tell them
/// apart.
const SAME_SHAPE: f64 = 1e-3;

/// Turns of the superhelix that the short rod keeps. More are tried if it does not converge, because longer ones may.
const TURNS: [f64; 3] = [10.0, 16.0, 21.0];
/// Strand kept for each end loop, in contact distances, because the loop and its transition to the regular superhelix
/// must fit into it.
const LOOPS: f64 = 60.0;

/// A guess, and what was spent on the short rod.
struct Lengthened {
    guess: Guess,
    iterations: usize,
    timings: Timings,
}

/// Where elements are cut out of a long plectoneme, and how many.
struct Cut {
    /// Order of the elements.
    order: usize,
    /// Node after which they are taken from one strand, and before whose counterpart from the other.
    at: usize,
    /// Elements taken from each strand.
    elements: usize,
    /// Elements of the short rod.
    left: usize,
    /// Elements on either side of the cut over which the screw motion is measured.
    window: usize,
}

impl Cut {
    fn double_helix(&self, state: &State) -> Option<DoubleHelix> {
        DoubleHelix::measure(state, self.order, [self.at, state.positions().len() - self.at], self.window)
    }
}

/// Where the nodes of a closed rod come from with elements put into each strand (taken out, if negative).
fn origins(helix: &DoubleHelix, nodes: usize, elements: isize) -> Vec<NodeOrigin> {
    let strand = elements * helix.order as isize;
    (0..nodes.saturating_add_signed(2 * strand)).map(|n| helix.origin(n as f64, strand as f64)).collect()
}

/// A state of a closed rod with elements put into each strand (taken out, if negative).
fn changed(state: &State, helix: &DoubleHelix, elements: isize) -> State {
    let made = origins(helix, state.positions().len(), elements);
    let place = |node: f64| (state.positions()[node as usize], state.frames()[node as usize]);
    let (positions, frames) = helix.composed(&made, place);
    let mut out = state.with_nodes(positions, frames);
    let seam = state.seams()[0] + elements as f64 * (helix.screw.spins[0] + helix.screw.spins[1]);
    out.prescribe([PrescribedValue::Seam(0, seam)]);
    out
}

pub(super) fn centre(state: &State) -> Vec3 {
    state.positions().iter().sum::<Vec3>() / state.positions().len() as f64
}

/// A state moved so that its centre is there.
fn moved(state: State, there: &Vec3) -> State {
    let shift = there - centre(&state);
    let positions = state.positions().iter().map(|x| x + shift).collect();
    state.with_positions(positions)
}

impl Solver {
    /// Where a state of the only rod is a long plectoneme that nothing holds: one whose ends are at rest, with the
    /// contact offsets that hold them there. None where it is not, or where the short rod does not converge. Iterations
    /// on the short rod are added to `elsewhere`.
    pub(super) fn periodic_extension(&mut self, whole: &State, elsewhere: &mut usize) -> Option<Guess> {
        let found = TURNS.iter().find_map(|turns| self.lengthened_from(whole, *turns));
        let Lengthened { guess, iterations, timings } = found?;
        *elsewhere += iterations;
        self.workspace.timings += timings;
        Some(guess)
    }

    fn lengthened_from(&self, whole: &State, turns: f64) -> Option<Lengthened> {
        let rod = self.free_uniform_ring()?;
        let cut = self.cut((rod, whole), turns)?;
        let mut short = self.shortened((rod, whole), &cut)?;
        let mut iterations = short.comes_to_rest(&PrescribedMotion::default(), &Ahead::Unknown)?;
        for _ in 0..SMOOTHINGS {
            short.smooth_pressures();
            iterations += short.comes_to_rest(&PrescribedMotion::default(), &Ahead::Present)?;
        }
        let wanted = whole.seams()[0] / TAU;
        // links of the long rod per link of the short one, a secant's slope from the second round on
        let mut slope = 1.0 + 2.0 * cut.elements as f64 / cut.left as f64;
        let mut before: Option<[f64; 2]> = None;
        for _ in 0..MAX_ROUNDS {
            let state = short.engine.state();
            let helix = cut.double_helix(state)?;
            let link = state.seams()[0] / TAU;
            let long = self.extended(rod, state, &cut, &helix)?;
            let missing = wanted - long.seams()[0] / TAU;
            if missing.abs() <= SAME_LINK {
                let made = origins(&helix, state.positions().len(), cut.elements as isize);
                return self.in_contact_as(&short, (whole, long), &made, iterations);
            }
            if let Some([link_before, missing_before]) = before {
                slope = (missing_before - missing) / (link - link_before);
            }
            before = Some([link, missing]);
            let drive = PrescribedMotion { seams: vec![TAU * missing / slope], ..PrescribedMotion::default() };
            iterations += short.comes_to_rest(&drive, &Ahead::Present)?;
        }
        None
    }

    /// The only rod, if it is a uniform ring that nothing but its own contact holds, and no offsets of contact are
    /// known.
    pub(super) fn free_uniform_ring(&self) -> Option<&Rod> {
        let (model, state) = (&self.engine.model, self.engine.state());
        let side = &self.engine.contact;
        let [rod] = &model.rods[..] else { return None };
        let free = model.supports.is_empty() && state.pressures()[0] == 0.0 && !model.planar;
        let unloaded = model.loads.is_empty() && model.line_loads.is_empty() && model.obstacles.is_empty();
        let uniform =
            rod.closed && rod.stiffness.is_none() && rod.section.is_isotropic() && rod.natural == Natural::Straight;
        (free && unloaded && uniform && side.offsets.values.iter().all(|c| *c == 0.0)).then_some(rod)
    }

    /// The cut that leaves so many turns and the end loops; `None` unless at least half of the rod is cut out, because
    /// less is not worth it.
    fn cut(&self, (rod, whole): (&Rod, &State), turns: f64) -> Option<Cut> {
        let side = &self.engine.contact;
        let (order, elements) = (rod.order, rod.num_elements);
        let pitch = Screw::measure(whole, order, [elements / 4 * order, (elements - elements / 4) * order], 1)?;
        let per_turn = TAU / pitch.angle;
        let loops = LOOPS * 2.0 * side.min_radius * elements as f64 / rod.length;
        let left = (2.0 * turns * per_turn + loops).ceil() as usize;
        let left = left + (elements - left.min(elements)) % 2;
        let cut = elements.saturating_sub(left) / 2;
        // over a quarter of the turns kept ripples of elements average out
        let window = (0.125 * turns * per_turn).ceil() as usize;
        (2 * cut >= left).then_some(Cut { order, at: left / 4 * order, elements: cut, left, window })
    }

    /// The short rod; `None` where the long one is not the short one with elements put in: it is not uniform.
    fn shortened(&self, (rod, whole): (&Rod, &State), cut: &Cut) -> Option<Self> {
        let by = cut.elements as isize;
        let helix = cut.double_helix(whole)?;
        let start = changed(whole, &helix, -by);
        let again = changed(&start, &DoubleHelix { middle: [cut.at, start.positions().len() - cut.at], ..helix }, by);
        is_same(&again, whole, rod.spacing()).then(|| self.solver_of(&start, rod).ok())?
    }

    /// The long rod made of a state of the short one, with the link of its own shape.
    fn extended(&self, rod: &Rod, short: &State, cut: &Cut, helix: &DoubleHelix) -> Option<State> {
        let mut long = changed(short, helix, cut.elements as isize);
        let whole = self.rod_of_state(&long, rod).ok()?.start_link();
        let seam = long.seams()[0] + TAU * (whole - long.seams()[0] / TAU).round();
        long.prescribe([PrescribedValue::Seam(0, seam)]);
        Some(long)
    }

    /// The long rod `made` of the short one, moved to where it was and twisted to its own link, with the short one's
    /// contact.
    fn in_contact_as(
        &self,
        short: &Self,
        (before, long): (&State, State),
        made: &[NodeOrigin],
        iterations: usize,
    ) -> Option<Lengthened> {
        let mut long = moved(long, &centre(before));
        let angle = before.seams()[0] - long.seams()[0];
        twist(&self.engine, &mut long, 0, angle);
        let side = &short.engine.contact;
        let offsets = side.offsets.moved(made.iter().map(|origin| origin.node as usize));
        let contact = ContactOfGuess::Known(LawInForce { law: side.law, offsets, before: None });
        Some(Lengthened { guess: Guess { contact, ..Guess::of(long) }, iterations, timings: short.workspace.timings })
    }

    /// Newton iterations that [`Solver::load_step`] takes; `None` where it does not converge.
    fn comes_to_rest(&mut self, drive: &PrescribedMotion, ahead: &Ahead) -> Option<usize> {
        let report = self.load_step(drive, ahead);
        (report.status == Status::Converged).then_some(report.iterations)
    }

    /// A rod of the same kind with the nodes of a state.
    fn rod_of_state(&self, state: &State, rod: &Rod) -> Result<Rod, InputError> {
        let length = rod.length * state.positions().len() as f64 / rod.num_nodes() as f64;
        let (positions, frames) = (state.positions().to_vec(), state.frames().to_vec());
        let nodes = Placement { length, positions, frames, closed: true };
        Rod::from_nodes(&rod.name, nodes, rod.section, rod.order, rod.natural.clone())
    }

    fn solver_of(&self, state: &State, rod: &Rod) -> Result<Self, InputError> {
        let rod = self.rod_of_state(state, rod)?;
        let mut contact = self.engine.model.contact;
        if let ContactLaw::AugmentedLagrangian { tol_penetration, .. } = &mut contact.law {
            // what is left of it in the middle is out of balance all along the long rod
            *tol_penetration = tol_penetration.min(ROUNDING);
        }
        let electrostatics = self.engine.model.electrostatics;
        Self::new(Model { rods: vec![rod], contact, electrostatics, ..Model::default() }, self.options.clone())
    }
}

fn is_same(a: &State, b: &State, spacing: f64) -> bool {
    let near = |(p, q): (&Vec3, &Vec3)| (p - q).norm() <= SAME_SHAPE * spacing;
    let aligned = |(p, q): (&Quat, &Quat)| p.angle_to(q) <= SAME_SHAPE;
    a.positions().iter().zip(b.positions()).all(near) && a.frames().iter().zip(b.frames()).all(aligned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Plectoneme, RodMesh, Section, Shape};
    use crate::solve::options::Options;

    fn plectoneme(elements: usize, angle: f64) -> Solver {
        let section = Section::isotropic(1.0, 1.5, 1e3, 1e3, 0.5);
        let length = elements as f64;
        let shape = Shape::Plectoneme(Plectoneme { length, ..Plectoneme::of_angle(200.0, 1.0, angle).unwrap() });
        let rod = Rod::new("ply", &shape, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap();
        Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default()).unwrap()
    }

    /// The plectoneme of another length at the same angle results from putting elements into the middle of one, or from
    /// taking them out; so does its link.
    #[test]
    fn plectonemes_of_two_lengths_become_each_other() {
        for (angle, elements, other) in [(0.3, 200, 140), (-0.4, 151, 231), (0.25, 200, 260)] {
            let [from, to] = [elements, other].map(|n| plectoneme(n, angle));
            let state = from.engine.state();
            let at = elements.min(other) / 4 * 3;
            let helix = DoubleHelix::measure(state, 3, [at, state.positions().len() - at], 10).unwrap();
            let by = (other as isize - elements as isize) / 2;
            let mut made = changed(state, &helix, by);
            let exact = to.engine.state();
            assert_eq!(made.positions().len(), exact.positions().len());
            // the same up to where they lie
            for (i, j) in [(0, 7), (at, at + 40), (3, 3 * other / 2), (30, 3 * other - 12)] {
                let [ours, theirs] = [&made, exact].map(|s| (s.positions()[i] - s.positions()[j]).norm());
                assert!((ours - theirs).abs() < 1e-8, "{i} {j} {ours} {theirs}");
            }
            let rod = from.rod_of_state(&made, &from.engine.model.rods[0]).unwrap();
            let turned = made.seams()[0] / TAU - rod.start_link();
            assert!((turned - turned.round()).abs() < 1e-7, "{turned}");
            made.prescribe([PrescribedValue::Seam(0, TAU * rod.start_link())]);
            // frames without twist: the link is the writhe
            assert!((made.seams()[0] - exact.seams()[0]).abs() < 1e-4, "{} {}", made.seams()[0], exact.seams()[0]);
        }
    }

    /// Curved axes, or a single node out of place anywhere in what would be cut out, are not taken for uniform.
    #[test]
    fn what_is_not_uniform_is_left_alone() {
        let mut solver = plectoneme(900, 0.3);
        solver.engine.state_mut().nodes_mut().0[3 * 250] += Vec3::new(0.0, 0.01, 0.0);
        let bent = solver.engine.state().clone();
        assert!(solver.periodic_extension(&bent, &mut 0).is_none());
    }

    /// Work per length² that strands do against each other while they slide along each other by unit length (K v · v
    /// over the middle), by differences of gradients: negative where ripples of elements that face each other let the
    /// energy fall.
    fn stiffness_of_sliding(solver: &mut Solver) -> f64 {
        let engine = &mut solver.engine;
        let state = engine.state().clone();
        let nodes = state.positions().len();
        let screw = Screw::measure(&state, 3, [nodes / 12 * 3, nodes - nodes / 12 * 3], nodes / 24).unwrap();
        let along = |i: usize| {
            let back = 2 * i >= nodes;
            let way = screw.axis.into_inner() * if back { -1.0 } else { 1.0 };
            let moved = way * screw.rise + way.cross(&(state.positions()[i] - screw.point)) * screw.angle;
            let turned = way * screw.angle + state.frames()[i] * Vec3::z() * screw.spins[usize::from(back)];
            [moved, turned]
        };
        let v: Vec<f64> = (0..nodes).flat_map(along).flat_map(|part| [part.x, part.y, part.z]).collect();
        let step = 1e-4;
        let [ahead, behind] = [step, -step].map(|t| {
            let there = engine.retract(&state, &v, t);
            engine.update_contact(&there).unwrap();
            engine.residual(&there).gradient
        });
        let middle = [nodes / 6..nodes / 3, 2 * nodes / 3..5 * nodes / 6].into_iter().flatten();
        middle.flat_map(|i| 6 * i..6 * i + 6).map(|m| v[m] * (ahead[m] - behind[m]) / (2.0 * step)).sum()
    }

    /// DNA of supercoiling density −0.06 (nm, pN), one node moved by `nudge` \[L\].
    fn dna(nudge: f64) -> Solver {
        let length = 4800.0;
        let turns = -0.06 * length / (0.34 * 10.5);
        let shape = Shape::Plectoneme(Plectoneme::of_link(length, 5.0, 205.7, 308.6, turns).unwrap());
        let section = Section::isotropic(205.7, 308.6, 1100.0, 1100.0, 2.5);
        let mut rod = Rod::new("dna", &shape, RodMesh::closed(960, 3), section, Natural::Straight).unwrap();
        rod.positions[720] += Vec3::new(0.0, nudge, 0.0);
        let rod = rod.with_excess_link(turns).unwrap();
        Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default()).unwrap()
    }

    /// The state a long plectoneme settles in from a short one is that in which it rests the slow way, its start too
    /// far from uniform to be shortened, once its pressures are as smooth.
    #[test]
    fn lengthened_rods_rest_where_they_do_alone() {
        let [mut quick, mut slow] = [0.0, 0.02].map(dna);
        let [short, usual] = [&mut quick, &mut slow].map(|solver| solver.solve_step(&PrescribedMotion::default()));
        assert!(short.iterations_on_other_meshes > 0 && usual.iterations_on_other_meshes == 0);
        assert!(short.iterations <= 10 && usual.iterations > 3 * short.iterations, "{}", usual.iterations);
        let energy = |solver: &Solver| solver.engine.residual(solver.engine.state()).potential.elastic.total();
        for _ in 0..SMOOTHINGS {
            slow.smooth_pressures();
            let report = slow.resettle();
            assert_eq!((report.status, report.num_unstable), (Status::Converged, 0));
        }
        assert!((energy(&quick) / energy(&slow) - 1.0).abs() < 1e-7, "{} {}", energy(&quick), energy(&slow));
    }

    /// As far from the origin as the ends of a rod of a million nodes reach; it stays where it is.
    #[test]
    fn rods_far_from_the_origin_come_to_rest() {
        let mut solver = dna(0.0);
        let (far, before) = (Vec3::new(4e5, 0.0, 0.0), centre(solver.engine.state()));
        solver.engine.state_mut().nodes_mut().0.iter_mut().for_each(|x| *x += far);
        let report = solver.solve_step(&PrescribedMotion::default());
        assert_eq!((report.status, report.num_unstable), (Status::Converged, 0));
        assert!(
            report.iterations_on_other_meshes > 0 && report.iterations <= 10,
            "{} {}",
            report.iterations_on_other_meshes,
            report.iterations
        );
        assert!((centre(solver.engine.state()) - before - far).norm() < 1.0);
    }

    #[test]
    fn strands_under_smooth_pressures_do_not_want_to_slide() {
        // at this angle a search ends on a crest of the mesh's ripples; at 0.29 in a trough
        let mut solver = plectoneme(240, 0.31);
        assert_eq!(solver.solve_step(&PrescribedMotion::default()).status, Status::Converged);
        let before = stiffness_of_sliding(&mut solver);
        assert!(before < 0.0, "{before}");
        for _ in 0..SMOOTHINGS {
            solver.smooth_pressures();
            assert_eq!(solver.resettle().status, Status::Converged);
        }
        let after = stiffness_of_sliding(&mut solver);
        assert!(after > -0.05 * before, "{before} {after}");
    }
}
