//! Prediction of the next state from the last accepted ones, and prescribed motions lifted from supports to rods.
//!
//! The prediction is a polynomial through the last two or three states in the exponential coordinates of SE(3): each
//! node moves from its last pose along a screw whose velocity and rotation vector are polynomials. Their parameter is
//! the prescribed change: states count as long as their controls (seams, turns, displacements and poses of supports,
//! load factor, pressures, placements of obstacles) lie on one line with the target. So predictions do not depend on
//! stages, and single steps are predicted like those of a run. The prescribed spin of frames is removed first, so that
//! only the response of the rods is extrapolated.
//!
//! The screw of a node is that of its surroundings: the rigid motion that leads a piece of the rod from one state
//! nearest to another. Its frame may turn within them, as that of a rod that is twisted does. So strands of a cable or
//! of a plectoneme go round each other on arcs, which chords would leave by (2 sin ½φ)³ of the radius, whatever their
//! sections do meanwhile.
//!
//! Extrapolated strains are useless, because a parabola stretches a rod by the cube of its turn, times a large
//! stiffness. Shear forces and tension, the multipliers of nearly rigid constraints, are smooth along a path. They are
//! extrapolated, too, and the first linearisation uses them.

use std::collections::BTreeMap;

use crate::math::quaternion::{exp, rotation_of, rotation_vector, spin};
use crate::math::screw::{screw, unscrew};
use crate::math::shape_functions::lagrange_weight;
use crate::math::{Mat3, Quat, Vec3};
use crate::rod::RodNumber;
use crate::scene::{ObstacleNumber, ObstaclePose};
use crate::solve::measures::{ARC, MAX_ROUNDS};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, Moved, PrescribedMotion, Target, seam_shares, spin_shares};
use crate::solve::problem::state::{PrescribedValue, State};

/// Relative difference up to which changes of prescribed values are parallel, because numbers are given with six
/// digits.
const SAME_LINE: f64 = 1e-6;
/// Bend, rad, below which the frame decides how a piece turns about itself.
const STRAIGHT: f64 = 1e-6;
/// Largest extrapolated step, over the last one, because an extrapolation to twice the distance of what is known has
/// twice to four times its error.
pub(super) const FARTHEST: f64 = 2.0;

/// Largest difference of a prediction from the one from a state less, rad, because linearisations about it err by the
/// square.
const MAX_UNCERTAINTY: f64 = 0.1;

/// Largest turn of a node from where it was foreseen, over the uncertainty, because that is the order of the error: the
/// difference of a parabola and a line.
const MET: f64 = 3.0;

/// An accepted state with all prescribed values.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Visited {
    state: State,
    moved: Moved,
}

/// A prescribed number, in the order in which they are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Control {
    /// Of a rod.
    Seam(usize),
    /// Of a node about an axis.
    Turns(usize),
    /// A component, of a node.
    Displacement(usize, usize),
    LoadFactor,
    /// Of a rod.
    Pressure(usize),
    /// A component of velocity or rotation towards a pose, of a node.
    Pose(usize, usize),
    /// A number of the placement of an obstacle.
    Placement(usize, usize),
    /// Of a rod.
    Number(usize, RodNumber),
}

impl Visited {
    fn controls(&self) -> BTreeMap<Control, f64> {
        let mut all = BTreeMap::new();
        let Self { state, moved } = self;
        all.extend(state.seams().iter().enumerate().map(|(rod, angle)| (Control::Seam(rod), *angle)));
        all.extend(moved.turned.iter().map(|(node, turns)| (Control::Turns(*node), *turns)));
        let displaced = moved.displaced.iter();
        all.extend(
            displaced
                .flat_map(|(node, by)| (0..3).map(|k| (Control::Displacement(*node, k), by[k])).collect::<Vec<_>>()),
        );
        let posed = moved.posed.iter();
        all.extend(
            posed
                .flat_map(|(node, by)| (0..6).map(|k| (Control::Pose(*node, k), by[k / 3][k % 3])).collect::<Vec<_>>()),
        );
        all.insert(Control::LoadFactor, state.load_factor());
        all.extend(state.pressures().iter().enumerate().map(|(rod, pressure)| (Control::Pressure(rod), *pressure)));
        let numbers = |placement: &ObstaclePose| ObstacleNumber::ALL.map(|which| placement.get(which));
        let placed = state.placements().iter().map(numbers).enumerate();
        all.extend(
            placed.flat_map(|(k, numbers)| (0..numbers.len()).map(move |i| (Control::Placement(k, i), numbers[i]))),
        );
        all.extend(state.numbers().iter().map(|((rod, which), value)| (Control::Number(*rod, *which), *value)));
        all
    }
}

/// Ratio of two changes of controls; `None` if they are not parallel.
fn multiple(change: &BTreeMap<Control, f64>, of: &BTreeMap<Control, f64>) -> Option<f64> {
    let at = |map: &BTreeMap<Control, f64>, key: &Control| map.get(key).copied().unwrap_or(0.0);
    let (key, _) = of.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let ratio = at(change, key) / at(of, key);
    let keys = of.keys().chain(change.keys());
    let along = |key: &Control| {
        let (here, there) = (at(change, key), ratio * at(of, key));
        (here - there).abs() <= SAME_LINE * (here.abs() + there.abs())
    };
    (ratio.is_finite() && ratio > 0.0 && keys.into_iter().all(along)).then_some(ratio)
}

fn change(to: &BTreeMap<Control, f64>, from: &BTreeMap<Control, f64>) -> BTreeMap<Control, f64> {
    let mut all = to.clone();
    for (key, value) in from {
        *all.entry(*key).or_insert(0.0) -= value;
    }
    all.retain(|_, value| *value != 0.0);
    all
}

/// A motion that leads to a predicted state.
#[derive(Debug, Clone)]
pub(crate) struct Prediction {
    /// From the state with its turns [lifted](lifted) to the predicted one; supports move as prescribed.
    pub(crate) increment: Vec<f64>,
    /// Shear forces and tension there, per element and integration point \[F\]; empty: not known.
    pub(crate) forces: Vec<[[f64; 3]; 3]>,
    /// Rotations, rad, from there to the equilibrium, by the order of magnitude; infinite: not known.
    pub(crate) uncertainty: f64,
}

impl Prediction {
    /// Whether the engine's state is where it leads from a state with its turns lifted, but for a few times its
    /// uncertainty.
    pub(crate) fn is_met(&self, engine: &Engine, lifted: &State) -> bool {
        let foreseen = engine.retract(lifted, &self.increment, 1.0);
        let frames = foreseen.frames().iter().zip(engine.state().frames());
        self.uncertainty.is_finite() && frames.map(|(a, b)| a.angle_to(b)).fold(0.0, f64::max) <= MET * self.uncertainty
    }

    /// No motion.
    pub(crate) fn still(engine: &Engine) -> Self {
        Self { increment: vec![0.0; 6 * engine.num_nodes()], forces: Vec::new(), uncertainty: f64::INFINITY }
    }
}

/// The last accepted states.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct History {
    /// Oldest first.
    visited: Vec<Visited>,
    /// Work of the last step under the forces at its start and at its end \[F·L\]; none after a snap.
    pub(crate) work: Option<[f64; 2]>,
}

impl History {
    /// Adds an accepted state.
    pub(crate) fn push(&mut self, state: &State, moved: &Moved) {
        let new = Visited { state: state.clone(), moved: moved.clone() };
        if self.visited.last() == Some(&new) {
            return;
        }
        // a parabola needs three
        if let [_, _, _] = self.visited[..] {
            self.visited.remove(0);
        }
        self.visited.push(new);
    }

    /// Forgets all states, after a jump.
    pub(crate) fn clear(&mut self) {
        self.visited.clear();
    }

    /// Whether the last state is this one.
    pub(crate) fn ends_at(&self, state: &State) -> bool {
        self.visited.last().is_some_and(|last| last.state.positions() == state.positions())
    }

    /// All states kept.
    pub(crate) fn states(&self) -> impl Iterator<Item = &State> {
        self.visited.iter().map(|visited| &visited.state)
    }

    /// The state before the step to a target, with the controls of the target, whose drive is `lifted`.
    pub(crate) fn target(&self, engine: &Engine, target: &Target, lifted: &Lifted) -> Option<Visited> {
        let last = self.visited.last().filter(|_| self.ends_at(engine.state()))?;
        let mut moved = last.moved.clone();
        moved.go_on(target, &lifted.spun);
        let mut state = last.state.clone();
        state.prescribe(lifted.state.seams().iter().enumerate().map(|(rod, &angle)| PrescribedValue::Seam(rod, angle)));
        state.prescribe(target.values());
        Some(Visited { state, moved })
    }

    /// The step to a target over the last step, if it goes on in the same direction.
    pub(crate) fn stride(&self, target: &Visited) -> Option<f64> {
        self.line(target).map(|(place, _)| place)
    }

    /// The target's place, and the states that lie on one line with it with their places, newest first. Places are
    /// distances from the last state in units of the last step.
    fn line(&self, target: &Visited) -> Option<(f64, Vec<(f64, &Visited)>)> {
        let [.., before, last] = &self.visited[..] else { return None };
        let controls = last.controls();
        let step = change(&controls, &before.controls());
        let place = multiple(&change(&target.controls(), &controls), &step)?;
        let mut line = vec![(0.0, last), (-1.0, before)];
        if let [first, _, _] = &self.visited[..]
            && let Some(ratio) = multiple(&change(&before.controls(), &first.controls()), &step)
        {
            line.push((-1.0 - ratio, first));
        }
        Some((place, line))
    }

    /// [`History::line`], unless the target is too far to be predicted.
    fn line_to_extrapolate(&self, target: &Visited) -> Option<(f64, Vec<(f64, &Visited)>)> {
        // steps are doubled after a cut-back
        self.line(target).filter(|(place, _)| *place <= FARTHEST * (1.0 + SAME_LINE))
    }

    /// The predicted state at a target, to which supports still make the motions of `drive`; `None` without a reliable
    /// prediction.
    pub(crate) fn predict(&self, engine: &Engine, target: &Visited, drive: &PrescribedMotion) -> Option<Prediction> {
        // forces under other stiffnesses cannot be extrapolated
        if self.visited.iter().any(|visited| visited.state.numbers() != target.state.numbers()) {
            return None;
        }
        let (place, line) = self.line_to_extrapolate(target)?;
        let mut increment = extrapolated(engine, target, place, &line);
        let forces = extrapolated_forces(engine, place, &line);
        let simpler = extrapolated(engine, target, place, &line[..line.len() - 1]);
        // of the order of the error
        let uncertainty = largest_difference(&increment, &simpler);
        if uncertainty > MAX_UNCERTAINTY {
            return None;
        }
        for (node, free) in engine.free.iter().enumerate() {
            for k in (0..6).filter(|&k| !free[k]) {
                increment[6 * node + k] = 0.0;
            }
        }
        drive.add_to(&mut increment);
        engine.join_increment(&line[0].1.state, &mut increment);
        Some(Prediction { increment, forces, uncertainty })
    }
}

/// The increment from the last state of a line, its frames spun as the target's are, to where the polynomial through
/// the line's states leads at a place.
fn extrapolated(engine: &Engine, target: &Visited, place: f64, line: &[(f64, &Visited)]) -> Vec<f64> {
    let last = line[0].1;
    let present: Vec<Quat> = spun(last.state.frames(), &last.spins_to(engine, target));
    // velocity and rotation of the surroundings, and the frame's rotation within them
    let mut sums = vec![[Vec3::zeros(); 3]; present.len()];
    let mut rotations = vec![[Vec3::zeros(); 2]; present.len()];
    for (index, (at, visited)) in line.iter().enumerate().skip(1) {
        let weight = lagrange_weight(line.len(), |k| line[k].0, index, place);
        // whole turns go on from state to state
        let farther = if index > 1 { at / line[index - 1].0 } else { 0.0 };
        let frames = spun(visited.state.frames(), &visited.spins_to(engine, target));
        let surroundings = surroundings(engine, &last.state, &visited.state);
        for (node, (sum, rotations)) in sums.iter_mut().zip(&mut rotations).enumerate() {
            let within = surroundings[node].inverse() * frames[node] * present[node].inverse();
            let both = [surroundings[node], within];
            *rotations = std::array::from_fn(|k| rotation_vector(&both[k], &(rotations[k] * farther)));
            let state = &visited.state;
            let displacement = (state.positions()[node] - last.state.positions()[node])
                + (state.remainders()[node] - last.state.remainders()[node]);
            sum[0] += weight * unscrew(&rotations[0], &displacement);
            sum[1] += weight * rotations[0];
            sum[2] += weight * rotations[1];
        }
    }
    let mut increment = Vec::with_capacity(6 * present.len());
    for [velocity, around, within] in &sums {
        let displacement = screw(around, velocity);
        let rotation = rotation_vector(&(exp(around) * exp(within)), &(around + within));
        increment.extend(displacement.iter().chain(rotation.iter()));
    }
    increment
}

/// Rotations of the surroundings of each node from one state to another: of as much of the rod to either side as it
/// takes that chords do not stand for its arcs, at least an element and at most [`MAX_ROUNDS`]. The frame decides how a
/// piece that is straight to six digits turns about itself.
fn surroundings(engine: &Engine, from: &State, to: &State) -> Vec<Quat> {
    let mut all = Vec::with_capacity(engine.num_nodes());
    for (index, rod) in engine.model.rods.iter().enumerate() {
        let (nodes, order) = (engine.nodes(index), rod.order as isize);
        let turns = turns(&from.positions()[nodes.clone()], rod.closed);
        let count = nodes.len() as isize;
        for n in 0..count {
            let here = nodes.start + n as usize;
            let (mut spread, mut size, mut turned) = (Mat3::zeros(), 0.0, 0.0);
            for reach in 1..=(MAX_ROUNDS as isize * order).min(count / 2) {
                for k in [n - reach, n + reach] {
                    let k = if rod.closed { k.rem_euclid(count) } else { k };
                    if !(0..count).contains(&k) {
                        continue;
                    }
                    let [before, after] =
                        [from, to].map(|s| s.positions()[nodes.start + k as usize] - s.positions()[here]);
                    spread += after * before.transpose();
                    size += before.norm_squared();
                    turned += turns[k as usize];
                }
                if reach >= order && turned >= 2.0 * ARC {
                    break;
                }
            }
            let [before, after] = [from, to].map(|state| state.frames()[here].to_rotation_matrix());
            spread += after.matrix() * before.matrix().transpose() * (STRAIGHT.powi(2) * size);
            all.push(rotation_of(&spread).unwrap_or(to.frames()[here] * from.frames()[here].inverse()));
        }
    }
    all
}

/// Largest angle, rad, between the frames to which two increments turn a node.
fn largest_difference(increment: &[f64], other: &[f64]) -> f64 {
    let angle = |node: usize| {
        let [a, b] = [increment, other].map(|of| exp(&Vec3::from_column_slice(&of[6 * node + 3..6 * node + 6])));
        a.angle_to(&b)
    };
    (0..increment.len() / 6).map(angle).fold(0.0, f64::max)
}

/// Turns of a curve at its nodes, rad.
fn turns(positions: &[Vec3], closed: bool) -> Vec<f64> {
    let count = positions.len();
    let turn = |k: usize| match k {
        _ if !closed && (k == 0 || k + 1 == count) => 0.0,
        _ => {
            let [before, after] = [(k + count - 1) % count, (k + 1) % count].map(|other| positions[other]);
            (positions[k] - before).angle(&(after - positions[k]))
        }
    };
    (0..count).map(turn).collect()
}

/// Frames spun about their own d3 by angles, rad.
fn spun(frames: &[Quat], angles: &[f64]) -> Vec<Quat> {
    frames.iter().zip(angles).map(|(frame, angle)| frame * spin(*angle)).collect()
}

/// Shear forces and tension of the polynomial through states at places on a line, at another place.
fn extrapolated_forces(engine: &Engine, place: f64, line: &[(f64, &Visited)]) -> Vec<[[f64; 3]; 3]> {
    let mut forces = vec![[[0.0; 3]; 3]; engine.elements.len()];
    for (index, (_, visited)) in line.iter().enumerate() {
        let weight = lagrange_weight(line.len(), |k| line[k].0, index, place);
        for (sum, stress) in forces.iter_mut().zip(engine.actual_stress(&visited.state)) {
            for (sum, stress) in sum.iter_mut().zip(stress) {
                sum.iter_mut().zip(stress).for_each(|(sum, x)| *sum += weight * x);
            }
        }
    }
    forces
}

impl Visited {
    /// Angles about d3, rad, by which seams and supports spin the frames of the nodes on the way to another state.
    fn spins_to(&self, engine: &Engine, target: &Self) -> Vec<f64> {
        let mut spins = vec![0.0; engine.num_nodes()];
        for (rod, (from, to)) in self.state.seams().iter().zip(target.state.seams()).enumerate() {
            seam_shares(engine, rod).for_each(|(node, share)| spins[node] += (to - from) * share);
        }
        for (&node, angle) in &target.moved.spun {
            let by = angle - self.moved.spun.get(&node).copied().unwrap_or(0.0);
            for (other, share) in spin_shares(engine, node) {
                spins[other] += by * share;
            }
        }
        spins
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quaternion::exp;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeRef, Ramp, Stage, Support};
    use crate::solve::load_step::solver::Solver;
    use crate::solve::path::run::run;
    use crate::solve::problem::prescribed_motion::spin_evenly;
    use crate::solve::{Options, Status};

    fn clamped(closed: bool) -> Model {
        let section = Section::isotropic(1.0, 1.5, 1e6, 1e6, 0.02);
        let line = Shape::Line { start: Vec3::zeros(), direction: Vec3::x(), length: 1.0 };
        let circle = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
        let shape = if closed { circle } else { line };
        let rods = vec![
            Rod::new("rod", &shape, RodMesh { closed, num_elements: 12, order: 3 }, section, Natural::Straight)
                .unwrap(),
        ];
        let ends = if closed { vec![] } else { vec![0, 36] };
        let supports = ends.into_iter().map(|node| Support::clamp(NodeRef { rod: 0, node })).collect();
        Model { rods, supports, ..Model::default() }
    }

    fn missed(engine: &Engine, at: impl Fn(f64) -> Visited) -> f64 {
        let [first, before, last, next] = [0.0, 1.0, 2.0, 3.0].map(at);
        let line = [(0.0, &last), (-1.0, &before), (-2.0, &first)];
        let increment = extrapolated(engine, &next, 1.0, &line);
        let mut lifted = last.state.clone();
        let by = |visited: &Visited| visited.moved.spun.get(&36).copied().unwrap_or(0.0);
        if by(&next) != 0.0 {
            spin_evenly(engine, &mut lifted, 36, by(&next) - by(&last));
        }
        let there = engine.retract(&lifted, &increment, 1.0);
        there.increment_since(&next.state).iter().fold(0.0f64, |a, x| a.max(x.abs()))
    }

    /// A rod that turns about an axis as a whole, by more than half a turn in two steps, its sections about themselves
    /// besides, is predicted to the weight of frames in its surroundings; a straight one that is only spun stays in
    /// place.
    #[test]
    fn rods_that_go_round_are_foretold_on_arcs() {
        let engine = Engine::new(clamped(true), None).unwrap();
        let through = Vec3::new(0.0, 0.3, -0.2);
        let axis = Vec3::new(1.0, 2.0, 2.0) / 3.0;
        let goes_round = |step: f64| {
            let mut state = engine.state().clone();
            let (positions, frames) = state.nodes_mut();
            let turn = exp(&(axis * (2.5 * step)));
            for node in 0..36 {
                positions[node] = through + turn * (engine.state().positions()[node] - through);
                frames[node] = turn * engine.state().frames()[node] * spin(-2.1 * step);
            }
            Visited { state, moved: Moved::default() }
        };
        let missed_round = missed(&engine, goes_round);
        assert!(missed_round < 1e-9, "{missed_round:e}");
        let engine = Engine::new(clamped(false), None).unwrap();
        let is_spun = |step: f64| {
            let mut state = engine.state().clone();
            let angle = 2.6 * step;
            spin_evenly(&engine, &mut state, 36, angle);
            Visited { state, moved: Moved { spun: [(36, angle)].into(), ..Moved::default() } }
        };
        assert!(missed(&engine, is_spun) < 1e-12);
    }

    /// A helix that is wound up by 0.6 rad a step at its end keeps its radius to 3 % of what it loses where nodes go on
    /// along parabolas.
    #[test]
    fn helices_are_wound_on_arcs() {
        let engine = Engine::new(clamped(false), None).unwrap();
        let at = |step: f64| {
            let mut state = engine.state().clone();
            let (positions, frames) = state.nodes_mut();
            let angle = 12.0 + 0.6 * step;
            for node in 0..=36 {
                let along = node as f64 / 36.0;
                let turn = exp(&(Vec3::x() * (angle * along)));
                positions[node] = Vec3::new(along, 0.0, 0.0) + turn * Vec3::new(0.0, 0.1, 0.0);
                let tangent = Vec3::new(1.0, 0.0, 0.0) + turn * Vec3::new(0.0, 0.0, 0.1 * angle);
                let tilt = Quat::rotation_between(&(turn * Vec3::x()), &tangent).unwrap();
                frames[node] = tilt * turn * engine.state().frames()[node];
            }
            Visited { state, moved: Moved::default() }
        };
        let [first, before, last, next] = [0.0, 1.0, 2.0, 3.0].map(at);
        let increment = extrapolated(&engine, &next, 1.0, &[(0.0, &last), (-1.0, &before), (-2.0, &first)]);
        let there = engine.retract(&last.state, &increment, 1.0);
        let lost = |x: &Vec3| (x.yz().norm() - 0.1).abs();
        let [on_arcs, on_parabolas] = (0..=36).fold([0.0f64; 2], |[arcs, parabolas], node| {
            let [a, b, c] = [&first, &before, &last].map(|visited| visited.state.positions()[node]);
            [arcs.max(lost(&there.positions()[node])), parabolas.max(lost(&(a - b * 3.0 + c * 3.0)))]
        });
        assert!(on_arcs < 0.03 * on_parabolas, "{on_arcs:e} {on_parabolas:e}");
    }

    /// Predictions follow prescribed values: not other loads, not backwards, not much farther than the last step.
    #[test]
    fn ways_go_on_along_their_line() {
        let at = |seam: f64, load: f64| {
            let engine = Engine::new(clamped(true), None).unwrap();
            let mut state = engine.state().clone();
            state.prescribe([PrescribedValue::Seam(0, seam), PrescribedValue::Load(load)]);
            Visited { state, moved: Moved::default() }
        };
        let mut history = History::default();
        for seam in [0.0, 0.2, 0.5] {
            let Visited { state, moved } = at(seam, 0.0);
            history.push(&state, &moved);
        }
        let place = |seam: f64, load: f64| {
            history.line_to_extrapolate(&at(seam, load)).map(|(place, line)| (place, line.len()))
        };
        let (ahead, count) = place(0.8, 0.0).unwrap();
        assert!((ahead - 1.0).abs() < 1e-12 && count == 3);
        assert_eq!(place(0.8, 0.1), None);
        assert_eq!(place(0.4, 0.0), None);
        assert_eq!(place(1.2, 0.0), None);
        assert_eq!(place(1.1, 0.0).unwrap().1, 3);
    }

    /// One stage, three, or single steps, of values that no rounding distinguishes: the same predictions in as many
    /// iterations, the same states to the last bit.
    #[test]
    fn a_path_does_not_know_its_stages() {
        let options = Options::default();
        let stage = |to: f64, steps: usize| Stage::new(vec![Ramp::ExcessLink { rod: 0, to }], steps);
        let path = |stages: &[Stage]| {
            let mut seen = Vec::new();
            let solution = run(clamped(true), stages, &options, &mut |progress| {
                seen.push((progress.report.iterations, progress.report.is_predicted()));
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
            assert_eq!(solution.status, Status::Converged);
            (seen, solution.solver.engine.state().clone())
        };
        let (whole, state) = path(&[stage(2.0, 8)]);
        assert!(whole.iter().filter(|(_, predicted)| *predicted).count() >= 4, "{whole:?}");
        let (parts, other) = path(&[stage(1.0, 4), stage(1.5, 2), stage(2.0, 2)]);
        assert_eq!(whole, parts);
        let mut solver = Solver::new(clamped(true), options.clone()).unwrap();
        let mut single = vec![{
            let start = solver.step_to(&[]).unwrap();
            (start.iterations, start.is_predicted())
        }];
        for k in 1..=8 {
            let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: 0.25 * f64::from(k) }]).unwrap();
            single.push((report.iterations, report.is_predicted()));
        }
        assert_eq!(whole, single);
        for end in [&other, solver.engine.state()] {
            assert_eq!(end.positions(), state.positions());
            assert_eq!(end.frames(), state.frames());
        }
    }
}
