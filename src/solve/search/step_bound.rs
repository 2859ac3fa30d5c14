//! How far a step may go: no strand may pass through another, no element may turn too far.
//!
//! Control points move by at most the chord of their linear motion plus the second-order part of the rotation, and the
//! relative motion of two cubics is bounded by that of their control points (convex hulls). A step fraction t keeps
//! every pair of strands apart if t × (bound of the relative motion) is less than their present distance. Pairs are
//! looked for in a `tree`, which settles parts that move together, are far from each other or lie along an arc too
//! straight to close as a whole: where nothing is near, a step of any length is free. `isotopy` joins such steps to a
//! path from one state to another. Obstacles, which move with nodes that carry them only, are looked at in
//! `surfaces`.

mod isotopy;
mod surfaces;
mod tree;

use std::f64::consts::TAU;

use self::tree::PassageTree;
use crate::error::SolveError;
use crate::math::Vec3;
use crate::math::handles::Handles;
use crate::math::parallel::{self, in_pool};
use crate::solve::measures::MAX_ROUNDS;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

/// Part of the increment below which the advance of a bound ends, because the rest is not worth another bound.
const LEAST_PROGRESS: f64 = 0.01;

/// Distances and angles that a step must keep.
#[derive(Debug, Clone, Copy)]
struct Keep {
    /// Fraction of the contact distance.
    distance: f64,
    /// Fraction of their distance that strands already closer than that may lose.
    deep: f64,
    /// Largest relative rotation of neighbouring nodes, rad: interpolation needs less than π between them.
    rotation: f64,
    /// Largest angle between frames of neighbouring nodes that a step may lead to, rad: below half a turn.
    turned: f64,
}

/// Bounds for a step before it is corrected.
const STEP: Keep = Keep { distance: 0.5, deep: 0.25, rotation: 1.0, turned: 0.45 * TAU };
/// Bounds for a corrected step, because corrections may use half of the room that the step left.
const CORRECTED: Keep = Keep { distance: 0.25, deep: 0.5, rotation: 1.5, turned: 0.48 * TAU };
/// Bounds for a predicted state, because it may turn strands in contact round each other, but not press them together.
const PREDICTED: Keep = Keep { distance: 0.9, ..STEP };

impl Engine {
    /// Largest t ≤ 1 for which the step from `state` is safe. Contact geometry must be that of `state`.
    pub(crate) fn step_fraction(&mut self, state: &State, increment: &[f64]) -> Result<f64, SolveError> {
        self.fraction_keeping(state, increment, STEP)
    }

    /// Whether a step that was within the bound before its corrections still lets no strand pass another. Contact
    /// geometry must be that of `state`.
    pub(crate) fn keeps_apart(&mut self, state: &State, increment: &[f64]) -> Result<bool, SolveError> {
        Ok(self.fraction_keeping(state, increment, CORRECTED)? == 1.0)
    }

    fn fraction_keeping(&self, state: &State, increment: &[f64], keep: Keep) -> Result<f64, SolveError> {
        let t = rotation_fraction(self, state, increment, keep);
        Ok(t.min(self.install(|| self.contact.passage_fraction(state, increment, keep))?))
    }

    /// Largest t ≤ 1 up to which strands keep apart along an increment, by conservative advancement: the rest of the
    /// increment is bounded anew from the state that the bound before allows, so that strands which turn round each
    /// other in contact are free. Afterwards contact geometry is that of some state on the way.
    pub(crate) fn free_fraction(&mut self, state: &State, increment: &[f64]) -> Result<f64, SolveError> {
        self.advance(state, increment, PREDICTED)
    }

    fn advance(&mut self, state: &State, increment: &[f64], keep: Keep) -> Result<f64, SolveError> {
        let longest = rotation_fraction(self, state, increment, keep);
        let mut t = 0.0;
        for _ in 0..MAX_ROUNDS {
            let here = self.retract(state, increment, t);
            self.place_curves(&here)?;
            let side = &self.contact;
            let rest: Vec<f64> = increment.iter().map(|x| x * (1.0 - t)).collect();
            let part = self.install(|| side.passage_fraction(&here, &rest, keep))?;
            if part == 1.0 {
                return Ok(longest);
            }
            t += part * (1.0 - t);
            if t >= longest {
                return Ok(longest);
            }
            if part * (1.0 - t) < LEAST_PROGRESS {
                break;
            }
        }
        Ok(t)
    }

    /// Moves the curves to a state and updates their turning, which the bound needs; not the candidates.
    fn place_curves(&mut self, state: &State) -> Result<(), SolveError> {
        in_pool(self.pool.as_ref(), || {
            self.contact.place(state);
            self.contact.exclusion.update(&self.contact.set)
        })
    }
}

/// Largest t ≤ 1 for which no frame turns against its neighbour by more than `keep.rotation` in the step, nor, if it
/// turns on, to more than `keep.turned` in all: past half a turn it would count as turned the other way.
fn rotation_fraction(engine: &Engine, state: &State, increment: &[f64], keep: Keep) -> f64 {
    let mut t = 1.0f64;
    for element in &engine.elements {
        let order = engine.model.rods[element.rod].order;
        for a in 1..=order {
            let [before, node] = [element.nodes[a - 1], element.nodes[a]];
            let relative = rotation(increment, node) - rotation(increment, before);
            let size = relative.norm();
            if size > keep.rotation {
                t = t.min(keep.rotation / size);
            }
            let closing = element.closes && a == order;
            let frame = if closing { state.seam_frame(element.rod, node) } else { state.frames()[node] };
            let turned = state.frames()[before].angle_to(&frame);
            if turned + size > keep.turned
                && (frame * state.frames()[before].inverse()).scaled_axis().dot(&relative) > 0.0
            {
                t = t.min((keep.turned - turned).max(0.0) / size);
            }
        }
    }
    t
}

/// Displacement of a node in an increment \[L\].
pub(super) fn displacement(increment: &[f64], node: usize) -> Vec3 {
    Vec3::new(increment[6 * node], increment[6 * node + 1], increment[6 * node + 2])
}

/// Rotation of a node in an increment, rad.
fn rotation(increment: &[f64], node: usize) -> Vec3 {
    Vec3::new(increment[6 * node + 3], increment[6 * node + 4], increment[6 * node + 5])
}

/// Largest rotation of a node in an increment, rad.
pub(in crate::solve) fn largest_turn(increment: &[f64]) -> f64 {
    (0..increment.len() / 6).map(|node| rotation(increment, node).norm()).fold(0.0, f64::max)
}

/// Linear motion of the four control points of a segment, and the bound of its second-order part.
pub(in crate::solve) struct SegmentMotion {
    pub(in crate::solve) linear: [Vec3; 4],
    second_order: f64,
}

impl SegmentMotion {
    /// A bound of the motion of its points \[L\].
    fn fastest(&self) -> f64 {
        self.linear.iter().map(Vec3::norm_squared).fold(0.0, f64::max).sqrt() + self.second_order
    }
}

impl ContactSide {
    fn passage_fraction(&self, state: &State, increment: &[f64], keep: Keep) -> Result<f64, SolveError> {
        if self.is_empty() {
            return Ok(1.0);
        }
        let nodes = &self.nodes;
        let motions = parallel::map(nodes.len(), parallel::CHEAP, &|k| self.motion(state, increment, k));
        let not_finite =
            |m: &SegmentMotion| !(m.linear.iter().all(|x| x.amax().is_finite()) && m.second_order.is_finite());
        if let Some(index) = motions.iter().position(not_finite) {
            return Err(SolveError::NotFinite { iteration: 0, quantity: "increment", index, value: f64::NAN });
        }
        let relative: Vec<f64> =
            nodes.iter().map(|&[a, b]| (rotation(increment, a) - rotation(increment, b)).norm()).collect();
        let tree = PassageTree::new(&self.set, &self.exclusion, &motions, &relative, keep);
        #[cfg(test)]
        assert_eq!(tree.fraction(), tree.fraction_by_all_pairs(), "the tree against all pairs");
        Ok(tree.fraction().min(surfaces::fraction(self, increment, &motions, keep)))
    }

    /// Motion of a segment in an increment from a state.
    pub(in crate::solve) fn motion(&self, state: &State, increment: &[f64], segment: usize) -> SegmentMotion {
        let [a, b] = self.nodes[segment];
        let (da, db) = (displacement(increment, a), displacement(increment, b));
        let (ta, tb) = (rotation(increment, a), rotation(increment, b));
        let handles = Handles::of(&self.cubic(state, segment).b);
        let stretch = handles.rate_in([&da, &db], [&ta, &tb]);
        let [after, before] = handles.of_ends;
        let linear = [da, da + ta.cross(&after) + after * stretch, db + tb.cross(&before) + before * stretch, db];
        SegmentMotion { linear, second_order: handles.beyond_linear([&da, &db], [&ta, &tb]) }
    }
}

fn relative_motion(a: &SegmentMotion, b: &SegmentMotion) -> f64 {
    let mut largest = 0.0f64;
    for x in &a.linear {
        for y in &b.linear {
            largest = largest.max((x - y).norm_squared());
        }
    }
    largest.sqrt() + a.second_order + b.second_order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::link::{linking_number, writhe};
    use crate::math::quaternion::{exp, spin};
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape, TorusKnot};
    use crate::scene::{Model, NodeRef, Obstacle, Side, Support};

    /// A rod above another at right angles, `height` radii apart.
    fn crossing(height: f64) -> Engine {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.01);
        let rod = |name: &str, start: Vec3, direction: Vec3| {
            let shape = Shape::Line { start, direction, length: 1.0 };
            Rod::new(name, &shape, RodMesh::open(9, 3), section, Natural::Straight).unwrap()
        };
        let rods = vec![
            rod("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x()),
            rod("upper", Vec3::new(0.0, -0.5, 0.01 * height), Vec3::y()),
        ];
        let supports = (0..2).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect();
        let mut engine = Engine::new(Model { rods, supports, ..Model::default() }, None).unwrap();
        let state = engine.state().clone();
        engine.update_contact(&state).unwrap();
        engine
    }

    fn downward(engine: &Engine, by: f64, turn: f64) -> Vec<f64> {
        let mut step = vec![0.0; 6 * engine.num_nodes()];
        for node in engine.first_node[1]..engine.first_node[2] {
            step[6 * node + 2] = -by;
            step[6 * node + 3] = turn;
        }
        step
    }

    /// However long the step, the strands stay on their sides all along the part that is allowed, and most of the way
    /// is.
    #[test]
    fn no_step_takes_a_strand_through_another() {
        for height in [0.3, 2.0, 2.5, 5.0, 40.0] {
            for by in [1e-3, 0.02, 0.1, 3.0, 1e6] {
                for turn in [0.0, 0.5] {
                    let mut engine = crossing(height);
                    let state = engine.state().clone();
                    let step = downward(&engine, by, turn);
                    let t = engine.step_fraction(&state, &step).unwrap();
                    assert!(t > 0.0 && t <= 1.0);
                    for k in 0..=50 {
                        let there = engine.retract(&state, &step, t * f64::from(k) / 50.0);
                        let side = &mut engine.contact;
                        side.place(&there);
                        let middle = |c: usize| {
                            let info = side.set.curves[c];
                            side.set.segments[info.first + info.count / 2].point(0.5)
                        };
                        assert!(middle(1).z > middle(0).z, "height {height} by {by} turn {turn}: passed at {k}");
                    }
                }
            }
        }
    }

    /// A closed trefoil of `elements` cubic elements, and a ring through it if `with_ring`; sections tilted by an
    /// angle.
    fn knot(elements: usize, with_ring: bool, tilt: f64) -> Engine {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.008);
        let knot = Shape::TorusKnot(TorusKnot::new(1.0, [2, 3]));
        let mut rods = vec![Rod::new("knot", &knot, RodMesh::closed(elements, 3), section, Natural::Straight).unwrap()];
        if with_ring {
            let center = rods[0].positions[0];
            let ring = Shape::Circle { length: 0.4, center, normal: rods[0].frames[0] * Vec3::x() };
            rods.push(Rod::new("ring", &ring, RodMesh::closed(8, 3), section, Natural::Straight).unwrap());
        }
        let mut engine = Engine::new(Model { rods, ..Model::default() }, None).unwrap();
        let tilted = exp(&(Vec3::x() * tilt));
        engine.state_mut().nodes_mut().1.iter_mut().for_each(|frame| *frame *= tilted);
        engine.take_tangents();
        let state = engine.state().clone();
        engine.update_contact(&state).unwrap();
        engine
    }

    /// A step of waves along the rods: displacements up to about `by`, rotations up to about `turn`.
    fn waves(engine: &Engine, seed: f64, by: f64, turn: f64) -> Vec<f64> {
        (0..6 * engine.num_nodes())
            .map(|i| {
                let (node, k) = ((i / 6) as f64, (i % 6) as f64);
                let wave = |n: f64| (seed * (n + 1.3) * (k + 0.7) + 0.05 * n * (1.0 + seed.sin().abs()) * node).sin();
                0.5 * (wave(1.0) + wave(2.0) + wave(3.0)) * if k < 3.0 { by } else { turn }
            })
            .collect()
    }

    /// Writhe and link of the contact curves: each passage changes one of them by 2 or 1 at once.
    fn topology(engine: &mut Engine, state: &State) -> f64 {
        let side = &mut engine.contact;
        side.place(state);
        let curve = |info: &crate::contact::curve::CurveInfo| -> Vec<Vec3> {
            let segments = &side.set.segments[info.first..info.first + info.count];
            segments.iter().flat_map(|s| [0.0, 0.25, 0.5, 0.75].map(|u| s.point(u))).collect()
        };
        let curves: Vec<Vec<Vec3>> = side.set.curves.iter().map(curve).collect();
        let link = if let [a, b] = &curves[..] { 2.0 * linking_number(a, b) } else { 0.0 };
        curves.iter().map(|c| writhe(c, true)).sum::<f64>() + link
    }

    /// Whether writhe or link jump along the fraction t of a step.
    fn passes(engine: &mut Engine, state: &State, step: &[f64], t: f64) -> bool {
        let count = 60;
        let at = |k: i32| t * f64::from(k) / f64::from(count);
        let along: Vec<f64> = (0..=count)
            .map(|k| {
                let there = engine.retract(state, step, at(k));
                topology(engine, &there)
            })
            .collect();
        along.windows(2).any(|pair| (pair[1] - pair[0]).abs() > 1.0)
    }

    /// Curves in no order at all, moved by wild steps: what is allowed of them passes nothing, though the whole steps
    /// do. Every fraction is compared with that of all pairs on the way (see `passage_fraction`).
    #[test]
    fn wild_steps_pass_nothing() {
        let (mut allowed, mut wild) = (0, 0);
        for (with_ring, tilt) in [(false, 0.0), (true, 0.0), (true, 0.6)] {
            let mut engine = knot(20, with_ring, tilt);
            for seed in 1..=3 {
                for (by, turn) in [(0.003, 0.03), (0.03, 0.2), (0.3, 1.5)] {
                    let state = engine.state().clone();
                    engine.update_contact(&state).unwrap();
                    let step = waves(&engine, f64::from(seed), by, turn);
                    let t = engine.step_fraction(&state, &step).unwrap();
                    assert!(t > 0.0);
                    assert!(
                        !passes(&mut engine, &state, &step, t),
                        "ring {with_ring}, tilt {tilt}, seed {seed}, {by}, {turn}: {t}"
                    );
                    allowed += usize::from(t > 0.2);
                    wild += usize::from(passes(&mut engine, &state, &step, 1.0));
                }
            }
        }
        assert!(allowed >= 4 && wild >= 4, "{allowed} {wild}");
    }

    /// The linear motion of a segment is the rate of its control points, of sheared rods, too.
    #[test]
    fn motions_are_rates_of_control_points() {
        for tilt in [0.0, 0.6] {
            let engine = knot(8, true, tilt);
            let (state, step) = (engine.state().clone(), waves(&engine, 1.0, 0.3, 0.7));
            let side = &engine.contact;
            let h = 1e-6;
            for segment in 0..side.nodes.len() {
                let [up, down] = [h, -h].map(|t| side.cubic(&engine.retract(&state, &step, t), segment));
                for (m, rate) in side.motion(&state, &step, segment).linear.iter().enumerate() {
                    let difference = (up.b[m] - down.b[m]) / (2.0 * h);
                    assert!((rate - difference).norm() < 1e-8, "{tilt} {segment} {m}: {rate} {difference}");
                }
            }
        }
    }

    /// A rod that rolls up through a whole circle is free to do so; one that comes through another is not, however far
    /// behind it ends.
    #[test]
    fn ways_are_free_or_not() {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 1e-3);
        let line = |name: &str, start: Vec3, direction: Vec3, elements: usize| {
            let shape = Shape::Line { start, direction, length: 1.0 };
            Rod::new(name, &shape, RodMesh::open(elements, 3), section, Natural::Straight).unwrap()
        };
        for (bar, angle, free) in [(false, 6.1, true), (false, -3.0, true), (true, 3.0, false), (true, -3.0, true)] {
            let mut rods = vec![line("swings", Vec3::zeros(), Vec3::x(), 9)];
            if bar {
                rods.push(line("bar", Vec3::new(0.6, 0.3, -0.5), Vec3::z(), 9));
            }
            let supports = (0..rods.len()).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect();
            let mut engine = Engine::new(Model { rods, supports, ..Model::default() }, None).unwrap();
            let start = engine.state().clone();
            let (positions, frames) = engine.state_mut().nodes_mut();
            for node in 0..28 {
                let (s, turn) = (node as f64 / 27.0, angle * node as f64 / 27.0);
                let radius = 1.0 / angle;
                positions[node] = Vec3::new(turn.sin(), 1.0 - turn.cos(), 0.0) * radius;
                // spun by some turns about its own axis on top
                let frame = exp(&(Vec3::z() * turn)) * frames[node];
                frames[node] = frame * spin(20.0 * s);
            }
            assert_eq!(engine.is_path_free(&start).unwrap(), free, "bar {bar}, {angle} rad");
        }
    }

    /// Frames that are 0.4 turns apart turn on by no more than 0.05 turns in a step, and back by any step.
    #[test]
    fn frames_do_not_turn_past_half_a_turn() {
        let mut engine = crossing(40.0);
        let mut state = engine.state().clone();
        state.nodes_mut().1[1] = state.frames()[0] * spin(0.4 * TAU);
        let tangent = state.frames()[0] * Vec3::z();
        for (angle, expected) in [(0.9, 0.05 * TAU / 0.9), (0.3, 1.0), (-0.9, 1.0)] {
            let mut step = vec![0.0; 6 * engine.num_nodes()];
            // all other nodes on the rod turn along
            for node in 1..engine.first_node[1] {
                (0..3).for_each(|k| step[6 * node + 3 + k] = angle * tangent[k]);
            }
            let t = engine.step_fraction(&state, &step).unwrap();
            assert!((t - expected).abs() < 1e-12, "{angle}: {t} {expected}");
        }
    }

    /// Far from contact the bound is not felt, nor by motions of both strands together.
    #[test]
    fn far_or_common_motion_is_not_cut() {
        let mut engine = crossing(40.0);
        let state = engine.state().clone();
        let step = downward(&engine, 0.1, 0.0);
        assert_eq!(engine.step_fraction(&state, &step).unwrap(), 1.0);
        let mut engine = crossing(2.0);
        let state = engine.state().clone();
        let mut step = vec![0.0; 6 * engine.num_nodes()];
        step.chunks_mut(6).for_each(|node| node[0] = 0.1);
        assert_eq!(engine.step_fraction(&state, &step).unwrap(), 1.0);
    }

    /// A bent rod above a plane, moved by steps that would take it far through: every point stays above the plane all
    /// along the part that is allowed, and nearly as much is allowed as can be.
    #[test]
    fn no_step_takes_a_strand_through_a_plane() {
        let radius = 0.01;
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, radius);
        // coarse: control points are far below the curve
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::y() };
        let rod = Rod::new("ring", &shape, RodMesh::closed(6, 1), section, Natural::Straight).unwrap();
        let lowest = -1.0 / TAU;
        for height in [1.0, 1.5, 3.0, 20.0] {
            let point = Vec3::new(7.0, -5.0, lowest - height * radius);
            let obstacles = vec![Obstacle::plane("floor", point, Vec3::z())];
            let mut engine =
                Engine::new(Model { rods: vec![rod.clone()], obstacles, ..Model::default() }, None).unwrap();
            let state = engine.state().clone();
            for (by, turn) in [(1e-3, 0.0), (0.05, 0.02), (10.0, 0.0), (1e6, 0.0), (0.05, 0.9)] {
                engine.update_contact(&state).unwrap();
                let mut step = waves(&engine, 1.3, 0.1 * by, turn);
                step.chunks_mut(6).for_each(|node| node[2] -= by);
                let t = engine.step_fraction(&state, &step).unwrap();
                let mut least = |t: f64| {
                    let there = engine.retract(&state, &step, t);
                    let side = &mut engine.contact;
                    side.place(&there);
                    let points = side.set.segments.iter().flat_map(|s| (0..=40).map(|k| s.point(f64::from(k) / 40.0)));
                    points.map(|r| r.z - point.z).fold(f64::INFINITY, f64::min)
                };
                let start = least(0.0);
                let kept = (0.5 * radius).min(0.75 * start);
                for k in 0..=20 {
                    let here = least(t * f64::from(k) / 20.0);
                    assert!(here >= kept - 1e-9, "{height} {by} {turn}: {here} of {start} at {k}/20 of {t}");
                }
                // without rotations the bound is exact, but for handles that grow with their chords, and for the points
                // looked at here
                let beyond = least(1.02 * t);
                assert!(turn > 0.0 || t == 1.0 || beyond <= kept + 3e-3 * radius, "{height} {by}: {beyond} {t}");
            }
        }
    }

    /// Rods around a thin post, and inside a tube and a ball, moved by steps that would take them far through, past it
    /// or round it: every point stays on its side all along the part that is allowed, and sliding round is free.
    #[test]
    fn no_step_takes_a_strand_through_a_curved_surface() {
        let radius = 0.01;
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, radius);
        let size = 1.0 / TAU;
        let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::y() };
        for (elements, side, gap) in [(6, 1.0, 1.0), (12, 1.0, 2.5), (6, -1.0, 1.0), (12, -1.0, 1.6), (24, -1.0, 9.0)] {
            let rod = Rod::new("ring", &shape, RodMesh::closed(elements, 1), section, Natural::Straight).unwrap();
            let level = size - side * gap * radius;
            let of_side = (level, if side > 0.0 { Side::Outside } else { Side::Inside });
            for obstacle in [
                Obstacle::cylinder("round", [Vec3::y() * 3.0, Vec3::y()], of_side),
                Obstacle::sphere("ball", Vec3::zeros(), of_side),
            ] {
                // the curve is inside the circle by a little
                let obstacles = vec![Obstacle { radius: level - 1e-3 * size, ..obstacle }];
                let obstacles =
                    if side > 0.0 { obstacles } else { vec![Obstacle { radius: level, ..obstacles[0].clone() }] };
                let model = Model { rods: vec![rod.clone()], obstacles, ..Model::default() };
                let mut engine = Engine::new(model, None).unwrap();
                let state = engine.state().clone();
                for (by, turn) in [(1e-3, 0.0), (0.05, 0.02), (10.0, 0.0), (1e6, 0.0), (0.05, 0.9)] {
                    engine.update_contact(&state).unwrap();
                    let mut step = waves(&engine, 1.3, 0.1 * by, turn);
                    step.chunks_mut(6).for_each(|node| node[2] -= by);
                    let t = engine.step_fraction(&state, &step).unwrap();
                    assert!(t > 0.0, "{elements} {side} {by}");
                    let mut least = |t: f64| {
                        let there = engine.retract(&state, &step, t);
                        let side = &mut engine.contact;
                        side.place(&there);
                        let surface = side.surfaces[0];
                        let points =
                            side.set.segments.iter().flat_map(|s| (0..=40).map(|k| s.point(f64::from(k) / 40.0)));
                        points.map(|r| surface.distance(&(r - surface.point()))).fold(f64::INFINITY, f64::min)
                    };
                    let start = least(0.0);
                    assert!(start > 0.0);
                    let kept = (0.5 * radius).min(0.75 * start) - 0.06 * radius;
                    for k in 0..=20 {
                        let here = least(t * f64::from(k) / 20.0);
                        assert!(here >= kept, "{elements} {side} {by} {turn}: {here} of {start} at {k}/20 of {t}");
                    }
                    // what is allowed is most of what could be
                    assert!(
                        turn > 0.0 || t == 1.0 || least(1.25 * t) < 0.6 * radius,
                        "{side} {by}: {} {t}",
                        least(1.25 * t)
                    );
                }
            }
        }
    }

    /// A ring that a body threads, carried by the end of a rod that moves and turns by itself, or while the ring does:
    /// no point of the ring comes nearer than it may, all along the part that is allowed.
    #[test]
    fn no_step_takes_a_carried_body_through_a_strand() {
        let (radius, size) = (0.01, 1.0 / TAU);
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, radius);
        let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let line = Shape::Line { start: Vec3::new(0.0, 0.0, -1.5), direction: Vec3::z(), length: 1.0 };
        let rod = |name: &str, shape: &Shape, mesh| Rod::new(name, shape, mesh, section, Natural::Straight).unwrap();
        let rods = vec![rod("ring", &circle, RodMesh::closed(12, 1)), rod("arm", &line, RodMesh::open(4, 1))];
        let end = NodeRef { rod: 1, node: 4 };
        let thick =
            |level: f64, length: Option<f64>| Obstacle { radius: level, ..Obstacle::grip("grip", &rods, end, length) };
        for obstacle in [thick(0.5 * size, None), thick(0.1 * size, Some(0.8)), thick(0.9 * size, Some(0.4))] {
            let model = Model { rods: rods.clone(), obstacles: vec![obstacle], ..Model::default() };
            let mut engine = Engine::new(model, None).unwrap();
            let state = engine.state().clone();
            for (by, turn, spin, ring) in [
                (0.5, 0.0, 0.0, 0.0),
                (0.0, 0.7, 0.0, 0.0),
                (0.02, 0.3, 2.0, 0.3),
                // a turn about the axis moves no surface; from 2 rad on the bound of the rod's own handles would count
                (0.0, 0.0, 1.0, 0.0),
                (3.0, 0.9, 0.5, 1.0),
            ] {
                engine.update_contact(&state).unwrap();
                let mut step = waves(&engine, 0.7, 0.1 * ring, 0.1 * ring);
                for node in engine.first_node[1]..engine.first_node[2] {
                    step[6 * node..6 * node + 6].copy_from_slice(&[by, 0.0, 0.3 * by, 0.0, turn, spin]);
                }
                let t = engine.step_fraction(&state, &step).unwrap();
                let mut least = |t: f64| {
                    let there = engine.retract(&state, &step, t);
                    let side = &mut engine.contact;
                    side.place(&there);
                    let (surface, count) = (side.surfaces[0], side.set.curves[0].count);
                    let points =
                        side.set.segments[..count].iter().flat_map(|s| (0..=40).map(|k| s.point(f64::from(k) / 40.0)));
                    points.map(|r| surface.distance(&(r - surface.point()))).fold(f64::INFINITY, f64::min)
                };
                let start = least(0.0);
                let kept = (0.5 * radius).min(0.75 * start) - 0.06 * radius;
                assert!(
                    t > 0.0 && start > 0.0 && (by + turn + ring > 0.0 || t == 1.0),
                    "{by} {turn} {spin} {ring}: {t}"
                );
                for k in 0..=40 {
                    let here = least(t * f64::from(k) / 40.0);
                    assert!(here >= kept, "{by} {turn} {spin} {ring}: {here} of {start} at {k}/40 of {t}");
                }
            }
        }
    }
}
