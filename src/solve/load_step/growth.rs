//! Growth of a plectoneme, the predicted state of a rod that is turned at its end.
//!
//! A plectoneme between two tails (magnetic tweezers) takes up rod from them while it is wound, and gives rod back while it
//! is unwound. Its end loop, its double helix, the transitions to the tails and the tails themselves stay what they are;
//! only their lengths change. No node moves along a smooth path meanwhile: those that enter the double helix wind about
//! each other by a whole turn a turn. So the state is not extrapolated node by node but put together from the last one:
//!
//! ```text
//! tail | rest of the tail and transition, moved along the rod | longer double helix with its end loop | and back
//! ```
//!
//! How much longer the double helix is (`double_helix`) follows from the turn of the end, to which an element more of it
//! and one less of the tails contribute the same everywhere: not by a whole number of elements. Double helix and end loop
//! move by whole elements, because elements at rest are to stay so; the transitions and the tails, which bend less, take
//! up the rest. The longer tail gives first, because where the plectoneme lies between its tails costs next to nothing,
//! but its way from the end of a tail that is used up is long.

use std::f64::consts::TAU;

use crate::math::link::link_of_ends;
use crate::math::quaternion::{exp, spin};
use crate::math::{Quat, Vec3};
use crate::rod::{Natural, Rod};
use crate::solve::load_step::double_helix::{DoubleHelix, Origin, turn_about_d3};
use crate::solve::measures::{ARC, ROUGH, SAME};
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_side::contact_cubic;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, PrescribedMotion, lifted};
use crate::solve::problem::state::State;

/// A plectoneme of an open rod.
struct OpenPlectoneme {
    /// Nodes where the double helix begins and ends, towards the tails.
    ends: [usize; 2],
    helix: DoubleHelix,
}

/// Rod that a plectoneme takes up from its tails, in nodes; given back, if negative.
struct Exchange {
    /// Nodes of the new rod less those of the old one.
    extra: f64,
    /// Into each strand.
    strand: f64,
    tails: [Tail; 2],
    /// Twist of the tails, rad per node.
    twist: f64,
}

/// What becomes of a tail. Its outer half stays where it is along the rod. Nodes are counted from its end.
struct Tail {
    /// Nodes that it gives.
    taken: f64,
    /// Of the old rod.
    length: f64,
    /// Last node of the outer half. Beyond it straight rod is put in, if none is taken.
    cut: f64,
    /// Displacement of what is farther from the end when rod is taken or put in \[L\].
    by: Vec3,
    /// What the supports do not allow of it, taken back all along the tail \[L\].
    aside: Vec3,
    /// A node of straight rod \[L\].
    step: Vec3,
}

/// A predicted state with its contact offsets, and shear forces and tension of its elements.
pub(super) struct Grown {
    pub(super) state: State,
    pub(super) offsets: ContactField,
    pub(super) forces: Vec<[[f64; 3]; 3]>,
}

impl Grown {
    /// The state after a drive that turns one end and nothing else, with plectoneme and tails as long as that takes.
    pub(super) fn of(engine: &mut Engine, drive: &PrescribedMotion) -> Option<Self> {
        let to = turned_end(engine, drive)?;
        if !matches!(&engine.model.rods[..], [rod] if is_uniform(engine, rod)) {
            return None;
        }
        engine.update_contact(&engine.state.clone()).ok()?;
        let engine = &*engine;
        let plectoneme = OpenPlectoneme::find(engine)?;
        let angle = twist(&to) - twist(&engine.state);
        let exchange = Exchange::new(&plectoneme, engine, angle, 0)?;
        Self::made(engine, &plectoneme, &exchange, &to).filter(|made| made.has_turned(&engine.state, angle))
    }

    /// The state of a longer rod of the same kind whose ends are where those of `to` are, and turned against each other by
    /// an angle, rad, more than the short rod's.
    pub(super) fn longer(short: &Engine, to: &State, angle: f64) -> Option<Self> {
        let plectoneme = OpenPlectoneme::find(short)?;
        let extra = to.positions.len() - short.num_nodes();
        let exchange = Exchange::new(&plectoneme, short, angle, extra)?;
        Self::made(short, &plectoneme, &exchange, to).filter(|made| made.has_turned(&short.state, angle))
    }

    /// Whether the link of the ends differs by this angle, rad, from that of another state: a strand that passed through
    /// another, or over an end, would change it by two turns.
    fn has_turned(&self, from: &State, angle: f64) -> bool {
        (link(&self.state) - link(from) - angle / TAU).abs() < 1.0
    }

    /// The state of a rod whose ends are where those of `to` are.
    fn made(engine: &Engine, plectoneme: &OpenPlectoneme, exchange: &Exchange, to: &State) -> Option<Self> {
        let last = to.positions.len() - 1;
        let origins: Vec<Origin> = (0..=last).map(|n| plectoneme.origin(exchange, n as f64, last as f64)).collect();
        let (positions, frames) =
            plectoneme.helix.composed(&origins, engine.model.rods[0].spacing(), |node| between(engine, node));
        let mut new = State { positions, frames, remainders: vec![Vec3::zeros(); last + 1], ..to.clone() };
        // from where the first node was to where supports hold the rod
        let held = if is_held(engine, 0) { 0 } else { last };
        let back = to.positions[held] - new.positions[held];
        new.positions.iter_mut().for_each(|x| *x += back);
        let spun = turn_about_d3(new.frames[0].inverse() * to.frames[0]);
        new.frames.iter_mut().for_each(|frame| *frame *= spin(spun));
        for end in [0, last] {
            new.frames[end] = to.frames[end];
        }
        let offsets = engine.contact.as_ref()?.offsets.moved(origins.iter().map(nearest));
        let forces = moved_forces(engine, plectoneme.helix.order, &origins);
        Some(Self { state: new, offsets, forces })
    }
}

/// The state with a drive lifted that turns an end of the rod and does nothing else.
pub(super) fn turned_end(engine: &Engine, drive: &PrescribedMotion) -> Option<State> {
    let Lifted { state, drive: left, spun } = lifted(engine, &engine.state, drive);
    let last = state.positions.len() - 1;
    let is_turned = matches!(spun[..], [(node, _)] if node == 0 || node == last);
    (is_turned && left.nodes.is_empty()).then_some(state)
}

/// Link of the ends, turns.
pub(super) fn link(state: &State) -> f64 {
    let d1: Vec<Vec3> = state.frames.iter().map(|frame| frame * Vec3::x()).collect();
    let along = |node: usize| state.frames[node] * Vec3::z();
    link_of_ends(&state.positions, &d1, along(0) + along(d1.len() - 1))
}

/// Sum of the turns about d3 from node to node, rad.
pub(super) fn twist(state: &State) -> f64 {
    state.frames.windows(2).map(|pair| turn_about_d3(pair[0].inverse() * pair[1])).sum()
}

fn nearest(origin: &Origin) -> usize {
    origin.node.round() as usize
}

/// Shear forces and tension of the elements that new ones come from, in frames that have spun.
fn moved_forces(engine: &Engine, order: usize, origins: &[Origin]) -> Vec<[[f64; 3]; 3]> {
    let stress = engine.actual_stress(&engine.state);
    let of_element = |origin: &Origin| {
        let old = &stress[(nearest(origin) / order).min(stress.len() - 1)];
        let (sin, cos) = origin.spin.sin_cos();
        std::array::from_fn(|point| {
            let [first, second, tension, ..] = old[point];
            [cos * first + sin * second, cos * second - sin * first, tension]
        })
    };
    origins[..origins.len() - 1].iter().step_by(order).map(of_element).collect()
}

/// Position and frame between two nodes.
fn between(engine: &Engine, node: f64) -> (Vec3, Quat) {
    let state = &engine.state;
    let (first, part) = (node.floor() as usize, node.fract());
    if part == 0.0 {
        return (state.positions[first], state.frames[first]);
    }
    let position = contact_cubic(state, [first, first + 1], engine.model.rods[0].spacing()).point(part);
    let [from, to] = [first, first + 1].map(|n| state.frames[n]);
    (position, from * exp(&((from.inverse() * to).scaled_axis() * part)))
}

fn is_held(engine: &Engine, node: usize) -> bool {
    engine.free[node][..3] == [false; 3]
}

/// Whether a rod is uniform and clamped at its ends, one of which may slide. Loads may differ along it: they make the
/// prediction worse, not wrong.
pub(super) fn is_uniform(engine: &Engine, rod: &Rod) -> bool {
    let (model, last) = (&engine.model, rod.num_nodes() - 1);
    let free_between = (1..last).all(|n| engine.free[n] == [true; 6]) && model.joints.is_empty() && !model.planar;
    let clamped = [0, last].iter().all(|&n| engine.free[n][3..] == [false; 3]);
    let slides = is_held(engine, 0) != is_held(engine, last);
    let uniform = rod.stiffness.is_none() && rod.contact_radii.is_none() && rod.section.is_isotropic();
    !rod.closed && free_between && clamped && slides && uniform && rod.natural == Natural::Straight
}

/// Nodes of the longest double helix with those opposite, whose neighbours follow each other backwards. It depends on the
/// state alone: all segments as near as this are candidates of contact.
fn longest_double_helix(engine: &Engine, rod: &Rod) -> Option<Vec<[usize; 2]>> {
    let (side, state) = (engine.contact.as_ref()?, &engine.state);
    let near = (2.0 + 3.0 * ROUGH) * side.min_radius;
    let mut opposite: Vec<Option<(f64, [usize; 2])>> = vec![None; state.positions.len()];
    for pair in side.broad_phase.pairs() {
        let (first, second) = (pair[0].min(pair[1]) as usize, pair[0].max(pair[1]) as usize);
        let curve = contact_cubic(state, [second, second + 1], rod.spacing());
        for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let distance = (curve.point(part) - state.positions[first]).norm();
            if distance < near && opposite[first].is_none_or(|(known, _)| distance < known) {
                opposite[first] = Some((distance, [first, second + usize::from(part > 0.5)]));
            }
        }
    }
    let pairs: Vec<Option<[usize; 2]>> = opposite.iter().map(|found| found.map(|(_, pair)| pair)).collect();
    let goes_on = |x: &Option<[usize; 2]>, y: &Option<[usize; 2]>| {
        x.zip(*y).is_some_and(|([a, b], [c, d])| (a + b).abs_diff(c + d) <= rod.order)
    };
    let longest = pairs.chunk_by(goes_on).max_by_key(|run| run.iter().flatten().count())?;
    longest.iter().copied().collect()
}

impl Tail {
    /// A tail whose end is a node, which gives so many nodes; `None` if it has not twice as many.
    fn new(engine: &Engine, end: usize, length: usize, taken: f64) -> Option<Self> {
        let length = length as f64;
        let inner = if taken > 0.0 { 0.5 * (length + taken) } else { 0.5 * length }.floor();
        let cut = if taken > 0.0 { (inner - taken).floor() } else { inner };
        if inner > length || cut < 1.0 {
            return None;
        }
        let sign = if end == 0 { 1.0 } else { -1.0 };
        let place = |nodes: f64| between(engine, end as f64 + sign * nodes).0;
        // as the rod goes on there
        let step = place(cut) - place(cut - 1.0);
        let by = if taken > 0.0 { place(cut) - place(cut + taken) } else { step * -taken };
        let moving = if is_held(engine, 0) { engine.num_nodes() - 1 } else { 0 };
        let aside = Vec3::from_fn(|k, _| if engine.free[moving][k] { 0.0 } else { -by[k] });
        Some(Self { taken, length, cut, by, aside, step })
    }

    /// A node of the tail, counted from its end: the old one, how many nodes of straight rod farther, and whether it is
    /// beyond what was taken or put in.
    fn origin(&self, n: f64) -> (f64, f64, bool) {
        let put = (-self.taken).max(0.0);
        match n - self.cut {
            beyond if beyond <= 0.0 => (n, 0.0, false),
            beyond if beyond < put => (self.cut, beyond, false),
            _ => (n + self.taken, 0.0, true),
        }
    }

    /// Share of a node in what the tail moves aside, and how much that grows to the next node. It begins and ends without a
    /// slope.
    fn share(&self, n: f64) -> [f64; 2] {
        let length = self.length - self.taken;
        let x = (n / length).clamp(0.0, 1.0);
        [x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x) / length]
    }
}

impl Exchange {
    /// What an end turned against the other by an angle takes, rad, on a rod of so many nodes more; `None` if there is
    /// not as much.
    fn new(plectoneme: &OpenPlectoneme, engine: &Engine, angle: f64, extra: usize) -> Option<Self> {
        let state = &engine.state;
        let last = state.positions.len() - 1;
        let OpenPlectoneme { ends, helix: DoubleHelix { order, middle, screw } } = plectoneme;
        let (p, extra) = (*order as f64, extra as f64);
        let lengths = [ends[0], last - ends[1]];
        let spun = |n: usize| turn_about_d3(state.frames[n].inverse() * state.frames[n + 1]);
        let outer = (0..lengths[0] / 2).chain(last - lengths[1] / 2..last);
        let twist = outer.clone().map(spun).sum::<f64>() / outer.count() as f64;
        let strand = (angle - extra * twist) / ((screw.spins[0] + screw.spins[1]) / p - 2.0 * twist);
        // the longer tail gives first
        let most = strand.abs().max(0.5 * extra);
        let longer = (0.5 * (lengths[0] as f64 - lengths[1] as f64)).clamp(-most, most);
        // end loop and double helix move by whole elements
        let moved = ((0.5 * extra - longer) / p).round() * p;
        let taken = [strand - moved, strand + moved - extra];
        let is_enough = strand.is_finite() && -strand <= 0.5 * (middle[0] - ends[0]) as f64;
        let tail = |side: usize| Tail::new(engine, [0, last][side], lengths[side], taken[side]);
        let tails = [tail(0).filter(|_| is_enough)?, tail(1)?];
        let sum = |part: fn(&Tail) -> Vec3| tails.iter().map(|tail| part(tail).norm()).sum::<f64>();
        let is_straight = sum(|tail| tail.aside) <= ARC * sum(|tail| tail.by);
        is_straight.then_some(Self { extra, strand, tails, twist })
    }
}

impl OpenPlectoneme {
    /// The longest double helix of an open rod that is held at its ends only, between two tails.
    fn find(engine: &Engine) -> Option<Self> {
        let [rod] = &engine.model.rods[..] else { return None };
        if !is_uniform(engine, rod) {
            return None;
        }
        let run = longest_double_helix(engine, rod)?;
        let middle = run[run.len() / 2];
        // the middle half of the double helix, because its ends are transitions
        let count = run.len() / (4 * rod.order);
        if count == 0 {
            return None;
        }
        let helix = DoubleHelix::measure(&engine.state, rod.order, middle, count)?;
        let same = SAME * 2.0 * engine.contact.as_ref()?.min_radius;
        let fits = helix.screw.misfit(&engine.state, rod.order, middle, count) <= same;
        fits.then_some(Self { ends: run[0], helix })
    }

    /// Where node `n` of the new state comes from, whose last node is `last`.
    fn origin(&self, exchange: &Exchange, n: f64, last: f64) -> Origin {
        let Exchange { extra, strand, tails: [left, right], twist } = exchange;
        let ([near, slope], [far, back]) = (left.share(n), right.share(last - n));
        let aside = left.aside * near - right.aside * (1.0 - far);
        let slope = left.aside * slope - right.aside * back;
        let origin = self.helix.origin(n + left.taken, *strand);
        let (by, spin, node) = if n + left.taken < self.helix.middle[0] as f64 {
            let (node, straight, is_inner) = left.origin(n);
            if is_inner { (left.by, -left.taken * twist, node) } else { (left.step * straight, straight * twist, node) }
        } else if n - right.taken - extra >= self.helix.middle[1] as f64 {
            let (node, straight, is_inner) = right.origin(last - n);
            let node = last - extra - node;
            let (by, spin) = (left.by, -left.taken * twist);
            if is_inner {
                (by, spin, node)
            } else {
                (by - right.by + right.step * straight, spin - (right.taken + straight) * twist, node)
            }
        } else {
            (left.by, -left.taken * twist, origin.node)
        };
        Origin { node, spin: origin.spin + spin, shift: by + aside, slope, ..origin }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rod::{RodMesh, Section, Shape};
    use crate::scene::{Model, NodeLoad, NodeRef, Support};
    use crate::solve::load_step::solver::Solver;
    use crate::solve::load_step::step_report::{Status, StepReport};
    use crate::solve::options::Options;

    /// DNA (nm, pN) that 4 pN pull; `sliding` is its end that may slide and bears the load.
    pub(crate) fn dna(elements: usize, sliding: usize) -> Solver {
        let section = Section::isotropic(205.7, 411.4, 1100.0, 1100.0, 2.5);
        let length = 2.5 * elements as f64;
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length };
        let rod = Rod::new("dna", &line, RodMesh::open(elements, 3), section, Natural::Straight).unwrap();
        let ends = [0, 3 * elements].map(|node| NodeRef { rod: 0, node });
        let mut supports = ends.map(Support::clamp);
        supports[sliding].position[0] = false;
        let force = Vec3::x() * if sliding == 0 { -4.0 } else { 4.0 };
        let loads = vec![NodeLoad { node: ends[sliding], force, moment: Vec3::zeros() }];
        let model = Model { rods: vec![rod], supports: supports.to_vec(), loads, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        solver.engine.state.load_factor = 1.0;
        assert_eq!(solver.find_equilibrium().status, Status::Converged);
        solver
    }

    /// A drive that turns an end (0 or 1) about the axis by an angle, rad.
    pub(crate) fn turn(solver: &Solver, end: usize, angle: f64) -> PrescribedMotion {
        let node = end * (solver.engine.num_nodes() - 1);
        PrescribedMotion { nodes: vec![(node, Vec3::zeros(), Vec3::x() * angle)], seams: Vec::new() }
    }

    /// Turned until it snapped into a plectoneme.
    fn snapped(elements: usize, sliding: usize, turned: usize) -> Solver {
        let mut solver = dna(elements, sliding);
        let sign = if turned == 0 { -1.0 } else { 1.0 };
        for _ in 0..8 {
            let report = solver.solve_step(&turn(&solver, turned, sign * 0.02 * 2.5 * elements as f64));
            assert_eq!(report.status, Status::Converged, "{report:?}");
        }
        assert!(OpenPlectoneme::find(&solver.engine).is_some());
        solver
    }

    fn potential(solver: &mut Solver, state: &State) -> f64 {
        let before = std::mem::replace(&mut solver.engine.state, state.clone());
        solver.engine.update_contact(state).unwrap();
        let potential = solver.engine.residual(state).potential.total();
        solver.engine.state = before;
        potential
    }

    /// Elastic energy, and potential with that of loads and contact.
    pub(crate) fn energies(solver: &Solver) -> [f64; 2] {
        let potential = solver.engine.residual(&solver.engine.state).potential;
        [potential.elastic.iter().sum(), potential.total()]
    }

    /// Wound and unwound, at either end of a rod either of whose ends slides: soon at rest, and where it rests the slow
    /// way, from the last state under the core law, but for how the mesh holds strands.
    #[test]
    fn plectonemes_grow_to_where_they_rest() {
        for (sliding, turned, angle) in [(1, 1, 5.0), (1, 0, 4.0), (0, 0, -3.0)] {
            let mut solver = snapped(100, sliding, turned);
            let before = solver.snapshot();
            let drive = turn(&solver, turned, angle);
            let mut slow = StepReport::settled();
            solver.approach(&drive, &mut slow).unwrap();
            solver.enforce_gaps(&mut slow).unwrap();
            assert_eq!((slow.status, slow.num_unstable), (Status::Converged, 0));
            let ([scale, known], turned_link) = (energies(&solver), link(&solver.engine.state));
            solver.restore(before).unwrap();
            let quick = solver.solve_step(&drive);
            assert!(quick.predicted && quick.num_unstable == 0, "{sliding} {turned} {angle}");
            assert!(3 * quick.iterations < slow.iterations, "{} {}", quick.iterations, slow.iterations);
            let [_, found] = energies(&solver);
            assert!((found - known).abs() < 1e-3 * scale, "{angle}: {found} {known} of {scale}");
            assert!((link(&solver.engine.state) - turned_link).abs() < 1e-9);
        }
    }

    /// The prediction meets the supports, hardly overlaps, and has the energy of rest but for a hundredth.
    #[test]
    fn predictions_are_nearly_at_rest() {
        for angle in [4.0, -3.0, 0.3] {
            let mut solver = snapped(100, 1, 1);
            let drive = turn(&solver, 1, angle);
            let to = turned_end(&solver.engine, &drive).unwrap();
            let Grown { state, offsets, .. } = Grown::of(&mut solver.engine, &drive).unwrap();
            let last = state.positions.len() - 1;
            assert_eq!((state.frames[0], state.frames[last]), (to.frames[0], to.frames[last]));
            assert_eq!(state.positions[0], to.positions[0]);
            assert!(state.positions[last].yz().norm() < 1e-9, "{}", state.positions[last]);
            solver.engine.contact.as_mut().unwrap().offsets = offsets;
            let predicted = potential(&mut solver, &state);
            assert_eq!(solver.solve_step(&drive).status, Status::Converged);
            let [scale, rest] = energies(&solver);
            assert!(predicted > rest && predicted - rest < 1e-2 * scale, "{angle}: {predicted} {rest} of {scale}");
        }
    }

    /// No turn, no change: every node comes from itself.
    #[test]
    fn no_turn_leaves_all_in_place() {
        let mut solver = snapped(100, 1, 1);
        let (state, drive) = (solver.engine.state.clone(), turn(&solver, 1, 1e-9));
        let Grown { state: same, .. } = Grown::of(&mut solver.engine, &drive).unwrap();
        let apart = state.positions.iter().zip(&same.positions).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let turned = state.frames.iter().zip(&same.frames).map(|(a, b)| a.angle_to(b)).fold(0.0, f64::max);
        assert!(apart < 1e-7 && turned < 1e-7, "{apart:e} {turned:e}");
    }

    /// A state put together is refused if a strand has passed through another.
    #[test]
    fn other_links_are_refused() {
        let mut solver = snapped(100, 1, 1);
        let (before, drive) = (solver.engine.state.clone(), turn(&solver, 1, 3.0));
        let grown = Grown::of(&mut solver.engine, &drive).unwrap();
        assert!(grown.has_turned(&before, 3.0));
        assert!(!grown.has_turned(&before, 3.0 + 2.0 * TAU) && !grown.has_turned(&before, 3.0 - 2.0 * TAU));
    }

    /// Rods that are not straight by nature, hinges, ends that are both held or turned about another axis, straight rods:
    /// no such prediction.
    #[test]
    fn other_rods_are_left_alone() {
        let mut solver = snapped(100, 1, 1);
        let drive = turn(&solver, 1, 1.0);
        let across = PrescribedMotion { nodes: vec![(300, Vec3::zeros(), Vec3::y())], seams: Vec::new() };
        let moved = PrescribedMotion { nodes: vec![(300, Vec3::x(), Vec3::x())], seams: Vec::new() };
        assert!(Grown::of(&mut solver.engine, &across).is_none() && Grown::of(&mut solver.engine, &moved).is_none());
        let mut straight = dna(100, 1);
        assert!(Grown::of(&mut straight.engine, &drive).is_none());
        let known = Grown::of(&mut solver.engine, &drive).unwrap().state;
        let changed = |change: fn(&mut Model)| {
            let mut model = solver.engine.model.clone();
            change(&mut model);
            let mut other = Solver::new(model, Options::default()).unwrap();
            other.engine.state = solver.engine.state.clone();
            Grown::of(&mut other.engine, &drive)
        };
        assert!(changed(|_| ()).unwrap().state == known, "another solver of the same state");
        let changed = |change: fn(&mut Model)| changed(change).is_some();
        assert!(!changed(|model| model.rods[0].natural = Natural::Uniform { kappa: [0.01, 0.0, 0.0] }));
        assert!(!changed(|model| model.supports[1].position[0] = true));
        assert!(!changed(|model| model.supports[0].rotation[1] = false));
        assert!(!changed(|model| model.supports.push(Support::pin(NodeRef { rod: 0, node: 120 }))));
    }
}
