//! Growth of a plectoneme, the predicted state of a rod that is turned at its end.
//!
//! A plectoneme between two tails (magnetic tweezers) takes up rod from them while it is wound, and gives rod back
//! while it is unwound. Its end loop, its double helix, the transitions to the tails and the tails themselves stay what
//! they are; only their lengths change. No node moves along a smooth path meanwhile: those that enter the double helix
//! wind about each other by a whole turn a turn. So the state is not extrapolated node by node but put together from
//! the last one:
//!
//! ```text
//! tail | rest of the tail and transition, moved along the rod | longer double helix with its end loop | and back
//! ```
//!
//! How much longer the double helix is (`double_helix`) follows from the turn of the end, to which an element more of
//! it and one less of the tails contribute the same everywhere: not by a whole number of elements. Double helix and end
//! loop move by whole elements, because elements at rest are to stay so; the transitions and the tails, which bend
//! less, take up the rest. The longer tail gives first, because where the plectoneme lies between its tails costs next
//! to nothing, but its way from the end of a tail that is used up is long.

use std::f64::consts::TAU;

use crate::math::link::link_of_ends;
use crate::math::quaternion::spin;
use crate::math::{Quat, Vec3};
use crate::rod::{Natural, Rod};
use crate::solve::load_step::guess::{ContactOfGuess, Guess, LawInForce};
use crate::solve::load_step::plectoneme::double_helix::{DoubleHelix, NodeOrigin, turn_about_d3};
use crate::solve::measures::ARC;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, PrescribedMotion, lifted};
use crate::solve::problem::state::State;

/// Largest distance, over the contact distance, of a double helix from its screw motion, because meshes do not tell
/// them apart.
const MAX_MISFIT: f64 = 1e-3;
/// Gap, over the contact radius, of strands that form a double helix, because all segments as near as this are
/// candidates of contact.
const NEAR: f64 = 0.03;

/// A plectoneme of an open rod.
struct OpenPlectoneme {
    /// Nodes where the double helix begins and ends, towards the tails.
    ends: [usize; 2],
    helix: DoubleHelix,
    /// From node to node \[L\].
    spacing: f64,
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

/// The state of the same rod with plectoneme and tails as long as the turn of an end takes ([`turned_end`]).
pub(super) fn grown(engine: &mut Engine, to: &State) -> Option<Guess> {
    engine.update_contact(&engine.state().clone()).ok()?;
    longer(engine, to, twist(to) - twist(engine.state()))
}

/// The state of a rod of the same kind, longer or not, whose ends are where those of `to` are, and turned against each
/// other by an angle, rad, more than this one's.
pub(super) fn longer(short: &Engine, to: &State, angle: f64) -> Option<Guess> {
    let plectoneme = OpenPlectoneme::find(short)?;
    let extra = to.positions().len() - short.num_nodes();
    let exchange = Exchange::new(&plectoneme, short, angle, extra)?;
    composed(short, &plectoneme, &exchange, to).filter(|made| has_turned(&made.state, short.state(), angle))
}

/// Whether the link of the ends differs by this angle, rad, from that of another state: a strand that passed through
/// another, or over an end, would change it by two turns.
fn has_turned(state: &State, from: &State, angle: f64) -> bool {
    (link(state) - link(from) - angle / TAU).abs() < 1.0
}

/// The state of a rod whose ends are where those of `to` are.
fn composed(engine: &Engine, plectoneme: &OpenPlectoneme, exchange: &Exchange, to: &State) -> Option<Guess> {
    let last = to.positions().len() - 1;
    let origins: Vec<NodeOrigin> = (0..=last).map(|n| plectoneme.origin(exchange, n as f64, last as f64)).collect();
    let (mut positions, mut frames) = plectoneme.helix.composed(&origins, |node| placed(engine, node));
    // from where the first node was to where supports hold the rod
    let held = if is_held(engine, 0) { 0 } else { last };
    let back = to.positions()[held] - positions[held];
    positions.iter_mut().for_each(|x| *x += back);
    let spun = turn_about_d3(frames[0].inverse() * to.frames()[0]);
    frames.iter_mut().for_each(|frame| *frame *= spin(spun));
    for end in [0, last] {
        frames[end] = to.frames()[end];
    }
    let side = &engine.contact;
    let offsets = side.offsets.moved(origins.iter().map(nearest));
    let forces = moved_forces(engine, plectoneme.helix.order, &origins);
    let contact = ContactOfGuess::Known(LawInForce { law: side.law, offsets, before: None });
    Some(Guess { contact, forces, ..Guess::of(to.with_nodes(positions, frames)) })
}

/// The state with a drive lifted that turns an end of a uniform rod and does nothing else.
pub(super) fn turned_end(engine: &Engine, drive: &PrescribedMotion) -> Option<State> {
    if !matches!(&engine.model.rods[..], [rod] if is_uniform(engine, rod)) {
        return None;
    }
    let Lifted { state, drive: left, spun } = lifted(engine, engine.state(), drive);
    let last = state.positions().len() - 1;
    let is_turned = matches!(spun[..], [(node, _)] if node == 0 || node == last);
    (is_turned && left.nodes.is_empty()).then_some(state)
}

/// Link of the ends, turns.
pub(super) fn link(state: &State) -> f64 {
    let d1: Vec<Vec3> = state.frames().iter().map(|frame| frame * Vec3::x()).collect();
    let along = |node: usize| state.frames()[node] * Vec3::z();
    link_of_ends(state.positions(), &d1, along(0) + along(d1.len() - 1))
}

/// Sum of the turns about d3 from node to node, rad.
pub(super) fn twist(state: &State) -> f64 {
    state.frames().windows(2).map(|pair| turn_about_d3(pair[0].inverse() * pair[1])).sum()
}

fn nearest(origin: &NodeOrigin) -> usize {
    origin.node.round() as usize
}

/// Shear forces and tension of the elements that new ones come from, in frames that have spun.
fn moved_forces(engine: &Engine, order: usize, origins: &[NodeOrigin]) -> Vec<[[f64; 3]; 3]> {
    let stress = engine.actual_stress(engine.state());
    let of_element = |origin: &NodeOrigin| {
        let old = &stress[(nearest(origin) / order).min(stress.len() - 1)];
        let (sin, cos) = origin.spin.sin_cos();
        std::array::from_fn(|point| {
            let [first, second, tension, ..] = old[point];
            [cos * first + sin * second, cos * second - sin * first, tension]
        })
    };
    origins[..origins.len() - 1].iter().step_by(order).map(of_element).collect()
}

/// Position and frame at a node, which need not be whole.
fn placed(engine: &Engine, node: f64) -> (Vec3, Quat) {
    let (positions, frames) = (engine.state().positions(), engine.state().frames());
    let (first, part) = (node.floor() as usize, node.fract());
    if part == 0.0 {
        return (positions[first], frames[first]);
    }
    engine.model.rods[0].between((positions, frames), 0.0, first, part)
}

fn is_held(engine: &Engine, node: usize) -> bool {
    engine.free[node][..3] == [false; 3]
}

/// Whether a rod is uniform and clamped at its ends, one of which may slide. Loads may differ along it: they make the
/// prediction worse, not wrong.
fn is_uniform(engine: &Engine, rod: &Rod) -> bool {
    let (model, last) = (&engine.model, rod.num_nodes() - 1);
    let is_alike = || rod.stiffness.is_none() && rod.contact_radii.is_none() && rod.section.is_isotropic();
    let is_clamped = |n: usize| engine.free[n][3..] == [false; 3];
    !rod.closed
        && rod.natural == Natural::Straight
        && !model.planar
        && model.joints.is_empty()
        && is_alike()
        && is_clamped(0)
        && is_clamped(last)
        && is_held(engine, 0) != is_held(engine, last)
        && (1..last).all(|n| engine.free[n] == [true; 6])
}

/// Nodes of the longest double helix with those opposite, whose neighbours follow each other backwards. It depends on
/// the state alone: all segments as near as this are candidates of contact.
fn longest_double_helix(engine: &Engine, rod: &Rod) -> Option<Vec<[usize; 2]>> {
    let (side, state) = (&engine.contact, engine.state());
    let near = (2.0 + NEAR) * side.min_radius;
    let mut opposite: Vec<Option<(f64, [usize; 2])>> = vec![None; state.positions().len()];
    for pair in side.broad_phase.pairs() {
        let (first, second) = (pair[0].min(pair[1]) as usize, pair[0].max(pair[1]) as usize);
        let curve = side.cubic(state, second);
        for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let distance = (curve.point(part) - state.positions()[first]).norm();
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
        let place = |nodes: f64| placed(engine, end as f64 + sign * nodes).0;
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

    /// Share of a node in what the tail moves aside, and how much that grows to the next node. It begins and ends
    /// without a slope.
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
        let state = engine.state();
        let last = state.positions().len() - 1;
        let OpenPlectoneme { ends, helix: DoubleHelix { order, middle, screw }, .. } = plectoneme;
        let (p, extra) = (*order as f64, extra as f64);
        let lengths = [ends[0], last - ends[1]];
        let spun = |n: usize| turn_about_d3(state.frames()[n].inverse() * state.frames()[n + 1]);
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
    /// The longest double helix of a uniform rod, between two tails.
    fn find(engine: &Engine) -> Option<Self> {
        let rod = &engine.model.rods[0];
        let run = longest_double_helix(engine, rod)?;
        let middle = run[run.len() / 2];
        // the middle half of the double helix, because its ends are transitions
        let count = run.len() / (4 * rod.order);
        if count == 0 {
            return None;
        }
        let helix = DoubleHelix::measure(engine.state(), rod.order, middle, count)?;
        let same = MAX_MISFIT * 2.0 * engine.contact.min_radius;
        let fits = helix.screw.misfit(engine.state(), rod.order, middle, count) <= same;
        fits.then_some(Self { ends: run[0], helix, spacing: rod.spacing() })
    }

    /// Where node `n` of the new state comes from, whose last node is `last`.
    fn origin(&self, exchange: &Exchange, n: f64, last: f64) -> NodeOrigin {
        let Exchange { extra, strand, tails: [left, right], twist } = exchange;
        let ([near, slope], [far, back]) = (left.share(n), right.share(last - n));
        let aside = left.aside * near - right.aside * (1.0 - far);
        let slope = (left.aside * slope - right.aside * back) / self.spacing;
        let origin = self.helix.origin(n + left.taken, *strand);
        // displacement and spin of all that is between the cuts
        let inner = (left.by, -left.taken * twist);
        let (node, (by, spin)) = if n + left.taken < self.helix.middle[0] as f64 {
            let (node, straight, is_inner) = left.origin(n);
            (node, if is_inner { inner } else { (left.step * straight, straight * twist) })
        } else if n - right.taken - extra >= self.helix.middle[1] as f64 {
            let (node, straight, is_inner) = right.origin(last - n);
            let by = inner.0 - right.by + right.step * straight;
            let outer = (by, inner.1 - (right.taken + straight) * twist);
            (last - extra - node, if is_inner { inner } else { outer })
        } else {
            (origin.node, inner)
        };
        NodeOrigin { node, spin: origin.spin + spin, shift: by + aside, slope, ..origin }
    }
}

#[cfg(test)]
pub(super) mod tests;
