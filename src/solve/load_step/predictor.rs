//! Prediction of the next state from the last accepted ones, and prescribed motions lifted from supports to rods.
//!
//! The prediction is a polynomial through the last two or three states in the exponential coordinates of SE(3): each node
//! moves from its last pose along a screw whose velocity and rotation vector are polynomials. Their parameter is the
//! prescribed change: states count as long as their controls (seams, turns, displacements and poses of supports, load
//! factor, pressures, heights of planes) lie on one line with the target. So predictions do not depend on stages, and
//! single steps are predicted like those of a run. The prescribed spin of frames is removed first, so that only the
//! response of the rods is extrapolated. Centrelines may go round with the sections (strands of a cable whose end is
//! turned move on arcs, which chords leave by (2 sin ½φ)³ of the radius) or not (a rod that is twisted). Of the two
//! screws, with and without the prescribed spin, the one is used that predicts the last state better from the two before.
//!
//! Extrapolated strains are useless, because a parabola stretches a rod by the cube of its turn, times a large stiffness.
//! Shear forces and tension, the multipliers of nearly rigid constraints, are smooth along a path. They are extrapolated,
//! too, and the first linearisation uses them.

use std::collections::BTreeMap;

use crate::math::quaternion::{exp, nearest_turn, spin};
use crate::math::screw::{screw, unscrew};
use crate::math::shape_functions::lagrange_weight;
use crate::math::{Quat, Vec3};
use crate::solve::measures::{FARTHEST, FINE};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, Moved, PrescribedMotion, Target, spin_shares};
use crate::solve::problem::state::{State, seam_shares};
use crate::solve::search::step_bound::largest_turn;

/// Largest difference, rad, between a prediction and the one from a state less, which is of the order of its error. When
/// it was chosen, pUC19 in 20 steps took 859 iterations with this limit and 1027 with .15, because predictions that differ by
/// .12 to .145 failed after 30 to 50, and the thin rod of `tests/scenes` 2118 and 2438.
const UNCERTAIN: f64 = 0.1;

/// An accepted state with all prescribed values.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Visited {
    state: State,
    moved: Moved,
}

/// Key of a prescribed number: kind, index, component.
type Control = (u8, usize, usize);

impl Visited {
    fn controls(&self) -> BTreeMap<Control, f64> {
        let mut all = BTreeMap::new();
        let Self { state, moved } = self;
        all.extend(state.seams.iter().enumerate().map(|(rod, angle)| ((0, rod, 0), *angle)));
        all.extend(moved.turned.iter().map(|(node, turns)| ((1, *node, 0), *turns)));
        let displaced = moved.displaced.iter();
        all.extend(displaced.flat_map(|(node, by)| (0..3).map(|k| ((2, *node, k), by[k])).collect::<Vec<_>>()));
        let posed = moved.posed.iter();
        all.extend(posed.flat_map(|(node, by)| (0..6).map(|k| ((5, *node, k), by[k / 3][k % 3])).collect::<Vec<_>>()));
        all.insert((3, 0, 0), state.load_factor);
        all.extend(state.pressures.iter().enumerate().map(|(rod, pressure)| ((4, rod, 0), *pressure)));
        all.extend(state.plane_heights.iter().enumerate().map(|(plane, height)| ((6, plane, 0), *height)));
        all.extend(state.numbers.iter().map(|((rod, which), value)| ((7, *rod, *which as usize), *value)));
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
        (here - there).abs() <= FINE * (here.abs() + there.abs())
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

/// A predicted state.
#[derive(Debug, Clone)]
pub(crate) struct Prediction {
    /// From the state with its turns [lifted](lifted) to the predicted one; supports move as prescribed.
    pub(crate) increment: Vec<f64>,
    /// Shear forces and tension at the points of each element \[F\].
    pub(crate) forces: Vec<[[f64; 3]; 3]>,
}

impl Prediction {
    /// The present state.
    pub(crate) fn still(engine: &Engine) -> Self {
        Self { increment: vec![0.0; 6 * engine.num_nodes()], forces: Vec::new() }
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
        self.visited.last().is_some_and(|last| last.state.positions == state.positions)
    }

    /// All states kept.
    pub(crate) fn states(&self) -> impl Iterator<Item = &State> {
        self.visited.iter().map(|visited| &visited.state)
    }

    /// The state before the step to a target, with the controls of the target, whose drive is `lifted`.
    pub(crate) fn target(&self, engine: &Engine, target: &Target, lifted: &Lifted) -> Option<Visited> {
        let last = self.visited.last().filter(|_| self.ends_at(&engine.state))?;
        let mut moved = last.moved.clone();
        moved.go_on(target, &lifted.spun);
        let mut state = State { seams: lifted.state.seams.clone(), ..last.state.clone() };
        target.load(&mut state);
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
        self.line(target).filter(|(place, _)| *place <= FARTHEST * (1.0 + FINE))
    }

    /// The predicted state at a target, to which supports still make the motions of `drive`; `None` without a reliable
    /// prediction.
    pub(crate) fn predict(&self, engine: &Engine, target: &Visited, drive: &PrescribedMotion) -> Option<Prediction> {
        // forces under other stiffnesses cannot be extrapolated
        if self.visited.iter().any(|visited| visited.state.numbers != target.state.numbers) {
            return None;
        }
        let (place, line) = self.line_to_extrapolate(target)?;
        let turning = matches!(line[..], [(_, last), (before, middle), (first, earliest)]
            if goes_round(engine, last, -before, &[(0.0, middle), (first - before, earliest)]));
        let mut increment = extrapolated(engine, target, place, &line, turning);
        let forces = extrapolated_forces(engine, place, &line);
        let simpler = extrapolated(engine, target, place, &line[..line.len() - 1], turning);
        let apart: Vec<f64> = increment.iter().zip(&simpler).map(|(a, b)| a - b).collect();
        if largest_turn(&apart) > UNCERTAIN {
            return None;
        }
        for (node, free) in engine.free.iter().enumerate() {
            for k in (0..6).filter(|&k| !free[k]) {
                increment[6 * node + k] = 0.0;
            }
        }
        drive.add_to(&mut increment);
        Some(Prediction { increment, forces })
    }
}

/// Whether centrelines go round with the sections: whether that predicts a state better from those before it.
fn goes_round(engine: &Engine, target: &Visited, place: f64, line: &[(f64, &Visited)]) -> bool {
    let [error, turning] = [false, true].map(|turning| {
        let increment = extrapolated(engine, target, place, line, turning);
        let missed = |node: usize| {
            let by = target.state.positions[node] - line[0].1.state.positions[node];
            (by - Vec3::from_column_slice(&increment[6 * node..6 * node + 3])).norm_squared()
        };
        (0..engine.num_nodes()).map(missed).sum::<f64>()
    });
    turning < error
}

/// The increment from the last state of a line, its frames spun as the target's are, to where the polynomial through the
/// line's states leads at a place; on screws with the spin in them if centrelines go round (`turning`) with the sections.
fn extrapolated(engine: &Engine, target: &Visited, place: f64, line: &[(f64, &Visited)], turning: bool) -> Vec<f64> {
    let last = line[0].1;
    let ahead = last.spins_to(engine, target);
    let present: Vec<Quat> = spun(&last.state.frames, &ahead);
    let mut screws = vec![[Vec3::zeros(); 2]; present.len()];
    for (index, (_, visited)) in line.iter().enumerate().skip(1) {
        let weight = lagrange_weight(line.len(), |k| line[k].0, index, place);
        let spins = visited.spins_to(engine, target);
        let frames = spun(&visited.state.frames, &spins);
        for (node, sum) in screws.iter_mut().enumerate() {
            let mut rotation = (frames[node] * present[node].inverse()).scaled_axis();
            if turning {
                let about = rotation + present[node] * Vec3::z() * (ahead[node] - spins[node]);
                let raw = (visited.state.frames[node] * last.state.frames[node].inverse()).scaled_axis();
                let angle = raw.norm();
                rotation = if angle == 0.0 { raw } else { nearest_turn(&(raw / angle), angle, &about) };
            }
            let state = &visited.state;
            let displacement = (state.positions[node] - last.state.positions[node])
                + (state.remainders[node] - last.state.remainders[node]);
            sum[0] += weight * unscrew(&rotation, &displacement);
            sum[1] += weight * rotation;
        }
    }
    let mut increment = Vec::with_capacity(6 * present.len());
    for (node, [velocity, rotation]) in screws.iter().enumerate() {
        let displacement = screw(rotation, velocity);
        let rotation = match turning {
            true => (exp(rotation) * last.state.frames[node] * present[node].inverse()).scaled_axis(),
            false => *rotation,
        };
        increment.extend(displacement.iter().chain(rotation.iter()));
    }
    increment
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
        for (rod, (from, to)) in self.state.seams.iter().zip(&target.state.seams).enumerate() {
            let nodes = engine.nodes(rod);
            for (node, share) in nodes.clone().zip(seam_shares(nodes.len())) {
                spins[node] += (to - from) * share;
            }
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

    /// A rod that turns about an axis as a whole is predicted to rounding; one that is only spun stays in place.
    #[test]
    fn rods_that_go_round_are_foretold_on_arcs() {
        let engine = Engine::new(clamped(false), None).unwrap();
        let through = Vec3::new(0.0, 0.3, -0.2);
        let at = |step: f64, goes_round: bool| {
            let angle = 0.6 * step;
            let mut state = engine.state.clone();
            for node in 0..=36 {
                let turn = exp(&(Vec3::x() * (angle * node as f64 / 36.0)));
                if goes_round {
                    state.positions[node] = through + turn * (engine.state.positions[node] - through);
                }
                state.frames[node] = turn * engine.state.frames[node];
            }
            Visited { state, moved: Moved { spun: [(36, angle)].into(), ..Moved::default() } }
        };
        for round in [true, false] {
            let [first, before, last, next] = [0.0, 1.0, 2.0, 3.0].map(|step| at(step, round));
            assert_eq!(goes_round(&engine, &last, 1.0, &[(0.0, &before), (-1.0, &first)]), round);
            let line = [(0.0, &last), (-1.0, &before), (-2.0, &first)];
            let increment = extrapolated(&engine, &next, 1.0, &line, round);
            let mut lifted = last.state.clone();
            spin_evenly(&engine, &mut lifted, 36, 0.6);
            let there = lifted.retract(&increment, 1.0);
            let missed = there.increment_since(&next.state).iter().fold(0.0f64, |a, x| a.max(x.abs()));
            assert!(missed < 1e-12, "{round} {missed:e}");
        }
    }

    /// Predictions follow prescribed values: not other loads, not backwards, not much farther than the last step.
    #[test]
    fn ways_go_on_along_their_line() {
        let at = |seam: f64, load: f64| {
            let engine = Engine::new(clamped(true), None).unwrap();
            let state = State { seams: vec![seam], load_factor: load, ..engine.state };
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

    /// One stage, three, or single steps: the same predictions in as many iterations (but where the ring buckles, which
    /// takes some 65 that rounding of what is prescribed may change), the same states.
    #[test]
    fn a_path_does_not_know_its_stages() {
        let options = Options::default();
        let stage = |to: f64, steps: usize| Stage { ramps: vec![Ramp::ExcessLink { rod: 0, to }], steps };
        let path = |stages: &[Stage]| {
            let mut seen = Vec::new();
            let solution = run(clamped(true), stages, &options, &mut |progress| {
                seen.push((progress.report.iterations, progress.report.predicted));
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
            assert_eq!(solution.status, Status::Converged);
            (seen, solution.solver.engine.state)
        };
        let (whole, state) = path(&[stage(1.8, 9)]);
        assert!(whole.iter().filter(|(_, predicted)| *predicted).count() >= 4, "{whole:?}");
        let (parts, other) = path(&[stage(0.8, 4), stage(1.4, 3), stage(1.8, 2)]);
        let same = |a: &[(usize, bool)], b: &[(usize, bool)]| {
            let alike = |(a, b): (&(usize, bool), &(usize, bool))| a.1 == b.1 && (a.0 == b.0 || a.0.min(b.0) > 30);
            assert!(a.len() == b.len() && a.iter().zip(b).all(alike), "{a:?} {b:?}");
        };
        same(&whole, &parts);
        let mut solver = Solver::new(clamped(true), options.clone()).unwrap();
        let mut single = vec![{
            let start = solver.step_to(&[]).unwrap();
            (start.iterations, start.predicted)
        }];
        for k in 1..=9 {
            let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: 0.2 * f64::from(k) }]).unwrap();
            single.push((report.iterations, report.predicted));
        }
        same(&whole, &single);
        // where its loop lies on the mesh is decided as the ring buckles, by rounding of what is prescribed
        let energy = |state: &State| solver.engine.residual(state).potential.total();
        for end in [&other, &solver.engine.state] {
            let apart = energy(end) / energy(&state) - 1.0;
            assert!(apart.abs() < 1e-7, "{apart:e}");
        }
    }
}
