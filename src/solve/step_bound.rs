//! How far a step may go: no strand may pass through another, no element may turn too far.
//!
//! Control points move by at most the chord of their linear motion plus the second-order part of the rotation, and the
//! relative motion of two cubics is bounded by that of their control points (convex hulls). A step fraction t keeps
//! every pair of strands apart if t × (bound of the relative motion) is less than their present distance; pairs too far
//! apart to meet are not looked at.

use rayon::prelude::*;

use crate::contact::capsule::{Capsule, distance_lower_bound_within};
use crate::error::SolveError;
use crate::math::Vec3;
use crate::solve::engine::{ContactSide, Engine};
use crate::solve::state::State;

/// What strands must keep between them within one step.
#[derive(Debug, Clone, Copy)]
struct Keep {
    /// Fraction of the contact distance.
    distance: f64,
    /// Strands already closer than that may lose this fraction of what is between them.
    deep: f64,
    /// Largest relative rotation of neighbouring nodes, rad: interpolation needs less than π between them.
    rotation: f64,
    /// Longest motion, in contact radii; steps beyond it are cut before pairs are looked at.
    longest: f64,
}

/// For a step before it is corrected for curvature.
const STEP: Keep = Keep { distance: 0.5, deep: 0.25, rotation: 1.0, longest: 16.0 };
/// For the step as it is taken: corrections may use up half of what the step left.
const CORRECTED: Keep = Keep { distance: 0.25, deep: 0.5, rotation: 1.5, longest: 32.0 };
/// How well the distance of a pair that could meet is known, relative to the contact distance. A segment of a thin rod bulges by much
/// more than the rod's thickness: with that for an error no step near contact would be left.
const TOL_DISTANCE: f64 = 0.05;
impl Engine {
    /// Largest t ≤ 1 for which the step from `state` is safe. Contact geometry must be that of `state`.
    pub(crate) fn step_fraction(&mut self, state: &State, increment: &[f64]) -> Result<f64, SolveError> {
        self.fraction_keeping(state, increment, STEP)
    }

    /// Whether a step that was within the bound before its corrections still lets no strand pass another. Contact geometry must be that of
    /// `state`.
    pub(crate) fn keeps_apart(&mut self, state: &State, increment: &[f64]) -> Result<bool, SolveError> {
        Ok(self.fraction_keeping(state, increment, CORRECTED)? == 1.0)
    }

    fn fraction_keeping(&mut self, state: &State, increment: &[f64], keep: Keep) -> Result<f64, SolveError> {
        let mut t = rotation_fraction(self, increment, keep.rotation);
        if let Some(mut side) = self.contact.take() {
            let pool = self.pool.take();
            let bound =
                crate::solve::assembly::in_pool(pool.as_ref(), || side.passage_fraction(state, increment, keep));
            self.pool = pool;
            self.contact = Some(side);
            t = t.min(bound?);
        }
        Ok(t)
    }
}

fn rotation_fraction(engine: &Engine, increment: &[f64], limit: f64) -> f64 {
    let rotation = |node: usize| Vec3::new(increment[6 * node + 3], increment[6 * node + 4], increment[6 * node + 5]);
    let mut largest = 0.0f64;
    for element in &engine.elements {
        let order = engine.model.rods[element.rod].order;
        for a in 1..=order {
            let relative = rotation(element.nodes[a]) - rotation(element.nodes[a - 1]);
            largest = largest.max(relative.norm());
        }
    }
    if largest > limit { limit / largest } else { 1.0 }
}

/// Linear motion of the four control points of a segment and the bound of what is left out.
pub(super) struct Motion {
    pub(super) linear: [Vec3; 4],
    second_order: f64,
}

impl ContactSide {
    fn passage_fraction(&mut self, state: &State, increment: &[f64], keep: Keep) -> Result<f64, SolveError> {
        let lengths = &self.set.lengths;
        let nodes = &self.nodes;
        let motions: Vec<Motion> = (0..nodes.len())
            .into_par_iter()
            .with_min_len(256)
            .map(|k| motion(state, increment, nodes[k], lengths[k] / 3.0))
            .collect();
        let mean = motions.iter().fold(Vec3::zeros(), |sum, m| sum + m.linear[0]) / motions.len() as f64;
        let farthest = motions
            .iter()
            .map(|m| m.linear.iter().map(|x| (x - mean).norm()).fold(0.0, f64::max) + m.second_order)
            .fold(0.0, f64::max);
        if !farthest.is_finite() {
            return Err(SolveError::NotFinite { iteration: 0, quantity: "increment", index: 0, value: farthest });
        }
        // beyond this range pairs cannot meet; very long steps are first cut to a few contact distances
        let longest = keep.longest * self.min_radius;
        let cut = if farthest > longest { longest / farthest } else { 1.0 };
        let range = 2.0 * farthest * cut;
        let pairs = self.step_search.candidates(&self.set, &self.exclusion, range, 0.0).map_err(|_| {
            SolveError::NotFinite { iteration: 0, quantity: "contact geometry", index: 0, value: f64::NAN }
        })?;
        let set = &self.set;
        let capsules: Vec<Capsule> = set.segments.par_iter().with_min_len(256).map(Capsule::new).collect();
        let t = pairs
            .par_iter()
            .with_min_len(256)
            .map(|&[i, j]| {
                let (i, j) = (i as usize, j as usize);
                if set.next(i) == Some(j) || set.next(j) == Some(i) {
                    // joined for good; the limit on rotations keeps them from folding
                    return cut;
                }
                let approach = relative_motion(&motions[i], &motions[j]);
                let contact_distance = set.radius_of(i) + set.radius_of(j);
                let allowed = |distance: f64| (distance - keep.distance * contact_distance).max(keep.deep * distance);
                let mut distance = capsules[i].distance_lower_bound(&capsules[j]);
                let tol = TOL_DISTANCE * contact_distance;
                if approach * cut > allowed(distance) && capsules[i].bulge + capsules[j].bulge > tol {
                    distance = distance_lower_bound_within(&set.segments[i], &set.segments[j], tol);
                }
                let allowed = allowed(distance);
                if approach * cut > allowed { allowed / approach } else { cut }
            })
            .reduce(|| cut, f64::min);
        Ok(t)
    }
}

pub(super) fn motion(state: &State, increment: &[f64], [a, b]: [usize; 2], lever: f64) -> Motion {
    let part = |n: usize, k: usize| Vec3::new(increment[6 * n + k], increment[6 * n + k + 1], increment[6 * n + k + 2]);
    let (da, db, ta, tb) = (part(a, 0), part(b, 0), part(a, 3), part(b, 3));
    let d3 = |n: usize| state.frames[n] * Vec3::z();
    let linear = [da, da + ta.cross(&d3(a)) * lever, db - tb.cross(&d3(b)) * lever, db];
    Motion { linear, second_order: 0.5 * lever * ta.norm_squared().max(tb.norm_squared()) }
}

fn relative_motion(a: &Motion, b: &Motion) -> f64 {
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
    use crate::rod::{Natural, Rod, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};

    /// A rod above another at right angles, `height` radii apart.
    fn crossing(height: f64) -> Engine {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.01);
        let rod = |name: &str, start: Vec3, direction: Vec3| {
            let shape = Shape::Line { start, direction, length: 1.0 };
            Rod::new(name, &shape, false, section, 9, 3, Natural::Straight).unwrap()
        };
        let rods = vec![
            rod("lower", Vec3::new(-0.5, 0.0, 0.0), Vec3::x()),
            rod("upper", Vec3::new(0.0, -0.5, 0.01 * height), Vec3::y()),
        ];
        let supports = (0..2).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect();
        let mut engine = Engine::new(Model { rods, supports, ..Model::default() }, None).unwrap();
        let state = engine.state.clone();
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

    /// However long the step, the strands stay on their sides all along the part that is allowed, and most of the way is.
    #[test]
    fn no_step_takes_a_strand_through_another() {
        for height in [0.3, 2.0, 2.5, 5.0, 40.0] {
            for by in [1e-3, 0.02, 0.1, 3.0, 1e6] {
                for turn in [0.0, 0.5] {
                    let mut engine = crossing(height);
                    let state = engine.state.clone();
                    let step = downward(&engine, by, turn);
                    let t = engine.step_fraction(&state, &step).unwrap();
                    assert!(t > 0.0 && t <= 1.0);
                    let side = engine.contact.as_mut().unwrap();
                    for k in 0..=50 {
                        side.place(&state.retract(&step, t * f64::from(k) / 50.0));
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

    /// Far from contact the bound is not felt, nor by motions of both strands together.
    #[test]
    fn far_or_common_motion_is_not_cut() {
        let mut engine = crossing(40.0);
        let state = engine.state.clone();
        let step = downward(&engine, 0.1, 0.0);
        assert_eq!(engine.step_fraction(&state, &step).unwrap(), 1.0);
        let mut engine = crossing(2.0);
        let state = engine.state.clone();
        let mut step = vec![0.0; 6 * engine.num_nodes()];
        step.chunks_mut(6).for_each(|node| node[0] = 0.1);
        assert_eq!(engine.step_fraction(&state, &step).unwrap(), 1.0);
    }
}
