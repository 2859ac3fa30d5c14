//! Gaps of the elements' own centreline, by a search of its own.
//!
//! ```text
//! gap = |r(s) − r(t)| − ε_a − ε_b      at its local minima over s and t
//! at obstacles: the distance of r(s) from the surface, less ε
//! ```
//!
//! r is the polynomial of the element, which carries the energy, in arcs that turn so little that two of them have one
//! nearest pair of points. Pairs of arcs come from a grid; a bound of their distance by chords and sagittas leaves out
//! those that cannot be the nearest, Newton's method finds the nearest points of the others. Points of one rod nearer
//! along it than [`NEIGHBOURS`] of turning are no contact: a curve has to turn by π between two points whose connection
//! is normal to it at both (Fenchel). Joined rods overlap at their joint, as far as they did at the start.
//!
//! Contact closes gaps between curves that are smooth through the nodes. What these may lie beside an arc is the mesh's
//! resolution, by which strands may overlap.

use std::collections::HashMap;

use super::arcs::{Arc, Arcs};
use super::obstacles::at_obstacle;
use super::{Check, Subject};
use crate::math::{Vec3, parallel};
use crate::scene::model::overlaps;
use crate::scene::{ContactLaw, Model, Obstacle};

/// Turning, rad, of a rod between two points that may touch, half of what Fenchel asks for, because turning is known by
/// the arc only.
const NEIGHBOURS: f64 = std::f64::consts::FRAC_PI_2;
/// Largest gap that is looked for, in radii of the thinnest rod: two diameters.
const MAX_GAP: f64 = 4.0;
/// Newton steps, because each squares the error of points that chords give to a hundredth.
const MAX_STEPS: usize = 30;
/// Size of the last step, as a parameter of an arc, because gaps are known to its square.
const TOL_STEP: f64 = 1e-9;
/// Slope of the distance towards the next arc, relative, that counts as zero.
const LEVEL: f64 = 1e-7;
/// Accuracy of gaps, in radii of the thinnest rod.
const TOL_GAP: f64 = 1e-10;
/// Points of an arc among which the nearest to an obstacle is looked for, because arcs turn by little.
const POINTS: usize = 8;
/// Width of an interval, as a parameter of an arc, in which the nearest point is known, because gaps are known to its
/// square.
const TOL_PLACE: f64 = 1e-6;
/// Part of an interval that golden sections leave.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// Overlap, in radii of the thinnest rod, that no mesh explains: drafts have 0.02.
const MOST_BESIDE: f64 = 0.05;

/// The smallest gap between strands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OwnGap {
    /// \[L\]
    pub(crate) gap: f64,
    /// Accuracy of it \[L\].
    pub(crate) accuracy: f64,
    pub(crate) rods: [usize; 2],
    /// Arc lengths \[L\].
    pub(crate) arcs: [f64; 2],
}

impl Arcs {
    /// Whether two arcs are near a joint of their rods.
    fn are_joined(&self, model: &Model, joined: &Joined, a: &Arc, b: &Arc) -> bool {
        let is_in = |arc: &Arc, piece: [f64; 2]| {
            let rod = &model.rods[arc.rod];
            overlaps(&[piece], [arc.arc[0], arc.arc[0] + arc.arc[1]], if rod.closed { rod.length } else { 0.0 })
        };
        let near = |rods: [usize; 2]| joined.get(&rods).into_iter().flatten();
        near([a.rod, b.rod]).any(|[of_a, of_b]| is_in(a, *of_a) && is_in(b, *of_b))
            || near([b.rod, a.rod]).any(|[of_b, of_a]| is_in(a, *of_a) && is_in(b, *of_b))
    }

    fn are_neighbours(&self, a: &Arc, b: &Arc) -> bool {
        a.rod == b.rod && self.strands[a.rod].as_ref().is_none_or(|s| s.between(a.index, b.index) < NEIGHBOURS)
    }

    /// Whether one of two points is the end of an open rod and the other less than half a turn about the rod's radius
    /// from it: the rounded end of a rod is in the tube next to it, which is no overlap of the tube.
    fn is_end_beside(&self, a: &Arc, b: &Arc, [u, v]: [f64; 2]) -> bool {
        let is_end = |arc: &Arc, t: f64| {
            let [before, after] = self.beyond(arc);
            t == 0.0 && before.is_none() || t == 1.0 && after.is_none()
        };
        let along = (a.arc[0] + u * a.arc[1] - b.arc[0] - v * b.arc[1]).abs();
        a.rod == b.rod && (is_end(a, u) || is_end(b, v)) && along < std::f64::consts::PI * a.radius
    }

    /// Lower bound of the gap of two arcs \[L\].
    fn bound(&self, [i, j]: [u32; 2]) -> f64 {
        let (a, b) = (&self.all[i as usize], &self.all[j as usize]);
        let (u, v) = nearest_of_chords(a, b);
        let chord = (a.from + (a.end() - a.from) * u) - (b.from + (b.end() - b.from) * v);
        chord.norm() - a.sagitta - b.sagitta - a.radius - b.radius
    }

    /// Nearest points of two arcs, if they are nearest on the arcs beyond, too.
    fn nearest(&self, a: &Arc, b: &Arc) -> Option<(f64, [f64; 2])> {
        let [u, v] = minimum(a, b);
        let w = a.point(u) - b.point(v);
        let slopes = |arc: &Arc, t: f64, sign: f64| {
            let [before, after] = self.beyond(arc);
            let scale = arc.c[0].norm() * w.norm();
            // the distance must not fall beyond an end
            let falls_before = t == 0.0
                && before
                    .is_some_and(|o| sign * w.dot(&o.slope(1.0)) * arc.c[0].norm() > LEVEL * scale * o.c[0].norm());
            let falls_after = t == 1.0
                && after
                    .is_some_and(|o| sign * w.dot(&o.slope(0.0)) * arc.c[0].norm() < -LEVEL * scale * o.c[0].norm());
            falls_before || falls_after
        };
        (!slopes(a, u, 1.0) && !slopes(b, v, -1.0)).then(|| (w.norm() - a.radius - b.radius, [u, v]))
    }
}

/// Parameters of the nearest points of two chords (Ericson 2004, 5.1.9).
fn nearest_of_chords(a: &Arc, b: &Arc) -> (f64, f64) {
    let (d, e, r) = (a.end() - a.from, b.end() - b.from, a.from - b.from);
    let (dd, ee, de, dr, er) = (d.dot(&d), e.dot(&e), d.dot(&e), d.dot(&r), e.dot(&r));
    let det = dd * ee - de * de;
    let u = if det > f64::EPSILON * dd * ee { ((de * er - dr * ee) / det).clamp(0.0, 1.0) } else { 0.5 };
    let v = (de * u + er) / ee;
    if v < 0.0 {
        ((-dr / dd).clamp(0.0, 1.0), 0.0)
    } else if v > 1.0 {
        (((de - dr) / dd).clamp(0.0, 1.0), 1.0)
    } else {
        (u, v)
    }
}

/// Parameters of the nearest points of two arcs: Newton's method for ½|a(u) − b(v)|² in the unit square.
fn minimum(a: &Arc, b: &Arc) -> [f64; 2] {
    let (u, v) = nearest_of_chords(a, b);
    let mut x = [u, v];
    let half_square = |x: [f64; 2]| 0.5 * (a.point(x[0]) - b.point(x[1])).norm_squared();
    let mut here = half_square(x);
    for _ in 0..MAX_STEPS {
        let w = a.point(x[0]) - b.point(x[1]);
        let (da, db) = (a.slope(x[0]), b.slope(x[1]));
        let g = [w.dot(&da), -w.dot(&db)];
        let h = [da.norm_squared() + w.dot(&a.bend(x[0])), -da.dot(&db), db.norm_squared() - w.dot(&b.bend(x[1]))];
        let step = newton_step(x, g, h, [da.norm_squared(), db.norm_squared()]);
        let mut part = 1.0;
        let (next, there) = loop {
            let next = [0, 1].map(|k| (x[k] + part * step[k]).clamp(0.0, 1.0));
            let there = half_square(next);
            if there <= here || part < TOL_STEP {
                break (next, there);
            }
            part *= 0.5;
        };
        let moved = (next[0] - x[0]).abs().max((next[1] - x[1]).abs());
        if there <= here {
            (x, here) = (next, there);
        }
        if moved < TOL_STEP {
            break;
        }
    }
    x
}

/// A step that decreases a function with gradient `g` and second derivatives `h` (uu, uv, vv) within the unit square;
/// `scale` are second derivatives without curvature.
fn newton_step(x: [f64; 2], g: [f64; 2], h: [f64; 3], scale: [f64; 2]) -> [f64; 2] {
    // a parameter at its bound, towards which the function falls, stays there
    let held = [0, 1].map(|k| x[k] <= 0.0 && g[k] > 0.0 || x[k] >= 1.0 && g[k] < 0.0);
    let diagonal = [h[0], h[2]];
    let single = |k: usize| -g[k] / if diagonal[k] > 0.1 * scale[k] { diagonal[k] } else { scale[k] };
    match held {
        [true, true] => [0.0; 2],
        [true, false] => [0.0, single(1)],
        [false, true] => [single(0), 0.0],
        [false, false] => {
            let det = h[0] * h[2] - h[1] * h[1];
            if h[0] > 0.0 && det > 1e-10 * scale[0] * scale[1] {
                [(h[1] * g[1] - h[2] * g[0]) / det, (h[1] * g[0] - h[0] * g[1]) / det]
            } else {
                // along parallel arcs either parameter alone
                [0.5 * single(0), 0.5 * single(1)]
            }
        }
    }
}

/// Arc lengths of pieces near joints, by rods.
type Joined = HashMap<[usize; 2], Vec<[[f64; 2]; 2]>>;

fn near_joints(model: &Model) -> Joined {
    let mut joined = Joined::new();
    for pair in model.joint_surroundings() {
        let arcs = pair.map(|piece| piece.arc(&model.rods[piece.rod()]));
        joined.entry(pair.map(|piece| piece.rod())).or_default().push(arcs);
    }
    joined
}

/// Pairs of arcs whose balls are nearer than a distance, by a grid of cells.
fn pairs(arcs: &Arcs, reach: f64) -> Vec<[u32; 2]> {
    let balls: Vec<(Vec3, f64)> = arcs.all.iter().map(Arc::ball).collect();
    let largest = balls.iter().zip(&arcs.all).map(|(ball, arc)| ball.1 + arc.radius).fold(0.0, f64::max);
    let cell = 2.0 * largest + reach;
    let place = |x: &Vec3| [0, 1, 2].map(|k| (x[k] / cell).floor() as i64);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut found = Vec::new();
    for (i, (center, radius)) in balls.iter().enumerate() {
        let here = place(center);
        for n in 0..27 {
            let at = [here[0] + n % 3 - 1, here[1] + n / 3 % 3 - 1, here[2] + n / 9 - 1];
            for &j in grid.get(&at).into_iter().flatten() {
                let (a, b) = (&arcs.all[i], &arcs.all[j as usize]);
                let far = radius + balls[j as usize].1 + a.radius + b.radius + reach;
                let near = (center - balls[j as usize].0).norm_squared() < far * far;
                if near && !arcs.are_neighbours(a, b) {
                    found.push([j, i as u32]);
                }
            }
        }
        grid.entry(here).or_default().push(i as u32);
    }
    found
}

/// The smallest gap between strands, if it is below two diameters, and the check of all gaps.
pub(crate) fn gaps(subject: &Subject, arcs: &Arcs) -> (Option<OwnGap>, Option<Check>) {
    let (model, state) = (subject.model, subject.state);
    let least = arcs.all.iter().map(|arc| arc.radius).fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        return (None, None);
    }
    let mut bounded: Vec<(f64, [u32; 2])> = {
        let pairs = pairs(arcs, MAX_GAP * least);
        let bound = |k: usize| (arcs.bound(pairs[k]), pairs[k]);
        parallel::map(pairs.len(), parallel::CHEAP, &bound)
    };
    bounded.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let tolerated = allowed(&model.contact.law, subject.penetration) * least;
    let joined = near_joints(model);
    let mut nearest: Option<OwnGap> = None;
    let mut worst = (0.0, tolerated / least, "contact radii".to_owned());
    let mut take = |gap: f64, beside: f64, place: &dyn Fn() -> String| {
        let (overlap, tol) = (-gap / least, tolerated / least + (beside / least).min(MOST_BESIDE));
        if overlap / tol > worst.0 / worst.1 {
            worst = (overlap, tol, format!("contact radii, {}", place()));
        }
    };
    for (bound, [i, j]) in bounded {
        if bound > nearest.map_or(MAX_GAP * least, |found| found.gap.max(0.0)) {
            break;
        }
        let (a, b) = (&arcs.all[i as usize], &arcs.all[j as usize]);
        if arcs.are_joined(model, &joined, a, b) {
            continue;
        }
        let Some((gap, [u, v])) = arcs.nearest(a, b) else { continue };
        let at = [a.arc[0] + u * a.arc[1], b.arc[0] + v * b.arc[1]];
        let place = || {
            let names = [a.rod, b.rod].map(|rod| &model.rods[rod].name);
            format!("rod \"{}\" at arc {:.4} and rod \"{}\" at arc {:.4}", names[0], at[0], names[1], at[1])
        };
        if !arcs.is_end_beside(a, b, [u, v]) {
            take(gap, a.beside + b.beside, &place);
        }
        if gap < nearest.map_or(MAX_GAP * least, |found| found.gap) {
            nearest = Some(OwnGap { gap, accuracy: TOL_GAP * least, rods: [a.rod, b.rod], arcs: at });
        }
    }
    for (k, obstacle) in model.obstacles.iter().enumerate() {
        let at = at_obstacle(subject, k);
        let own: Vec<Vec<[f64; 2]>> =
            (0..model.rods.len()).map(|rod| beside_node(model, (obstacle, state.placements()[k].level), rod)).collect();
        let round = |rod: usize| if model.rods[rod].closed { model.rods[rod].length } else { 0.0 };
        let touches = |arc: &&Arc| !overlaps(&own[arc.rod], [arc.arc[0], arc.arc[0] + arc.arc[1]], round(arc.rod));
        for arc in arcs.all.iter().filter(touches) {
            let (t, gap) = lowest(&|t| at(&arc.point(t)).0);
            let place = || {
                let at = arc.arc[0] + t * arc.arc[1];
                let names = [&model.rods[arc.rod].name, &obstacle.name];
                format!("rod \"{}\" at arc {at:.4} and {} \"{}\"", names[0], obstacle.kind(), names[1])
            };
            take(gap - arc.radius, arc.beside, &place);
        }
    }
    let (overlap, tol, detail) = worst;
    (nearest, Some(Check::new("gaps", overlap, tol, detail)))
}

/// Arc lengths of a rod \[L\] next to a node that carries an obstacle of this level, within which a rod that turns by
/// half a turn may still be in it; contact leaves out whole segments.
fn beside_node(model: &Model, (obstacle, level): (&Obstacle, f64), rod: usize) -> Vec<[f64; 2]> {
    let spacing = model.rods[rod].spacing();
    let widened = |[from, to]: [f64; 2]| [from - spacing, to + spacing];
    model.left_out(obstacle, level, rod).into_iter().map(widened).collect()
}

/// Overlap that the law leaves, in radii of the thinnest rod: twice its tolerance, and what a penalty is reported to
/// leave.
fn allowed(law: &ContactLaw, penetration: f64) -> f64 {
    match law {
        ContactLaw::AugmentedLagrangian { tol_penetration, .. } | ContactLaw::ByMesh { tol_penetration, .. } => {
            2.0 * tol_penetration
        }
        ContactLaw::Penalty { .. } | ContactLaw::None => 2.0 * penetration,
    }
}

/// Place and value of the minimum of a function on \[0, 1\]: the lowest of some points, then golden sections about it.
fn lowest(f: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let at = |k: usize| k as f64 / POINTS as f64;
    let mut best =
        (0..=POINTS).map(|k| (at(k), f(at(k)))).fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
    let (mut low, mut high) = ((best.0 - at(1)).max(0.0), (best.0 + at(1)).min(1.0));
    while high - low > TOL_PLACE {
        let [a, b] = [1.0 - GOLDEN, GOLDEN].map(|part| low + part * (high - low));
        let [left, right] = [(a, f(a)), (b, f(b))];
        best = [left, right].into_iter().fold(best, |best, new| if new.1 < best.1 { new } else { best });
        (low, high) = if left.1 < right.1 { (low, b) } else { (a, high) };
    }
    best
}
