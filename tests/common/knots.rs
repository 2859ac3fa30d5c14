//! Which knot and which link rods make: numbers that change only where strands pass through each other.

#![allow(dead_code)] // every user takes its part

use nalgebra::{DMatrix, Rotation3};
use supercoil::math::Vec3;
use supercoil::math::link::linking_number;
use supercoil::scene::{NodeRef, Obstacle, Skeleton};
use supercoil::solve::Engine;

/// Sine of the angle between two edges that are parallel.
const PARALLEL: f64 = 1e-12;

/// |Δ(−1)| of a closed polygon: the minor of the colouring matrix, one row per crossing (twice the arc above minus both
/// arcs below). 1 for the unknot, 3 for the trefoil.
pub fn determinant(points: &[Vec3]) -> f64 {
    let turn = Rotation3::from_euler_angles(0.3217, 1.1113, 2.0071);
    let p: Vec<Vec3> = points.iter().map(|x| turn * x).collect();
    let n = p.len();
    let cross = |a: Vec3, b: Vec3| a.x * b.y - a.y * b.x;
    // position of each undercrossing along the curve, and of the crossing on the strand above
    let mut crossings: Vec<(f64, f64)> = Vec::new();
    for i in 0..n {
        for j in i + 2..n {
            if i == 0 && j == n - 1 {
                continue;
            }
            let (a, d, b, e) = (p[i], p[(i + 1) % n] - p[i], p[j], p[(j + 1) % n] - p[j]);
            let area = cross(d, e);
            // of edges on one line rounding alone makes a crossing
            if area.abs() <= PARALLEL * d.xy().norm() * e.xy().norm() {
                continue;
            }
            let (s, t) = (cross(b - a, e) / area, cross(b - a, d) / area);
            if (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t) {
                let (here, there) = (i as f64 + s, j as f64 + t);
                let above = a.z + s * d.z > b.z + t * e.z;
                crossings.push(if above { (there, here) } else { (here, there) });
            }
        }
    }
    crossings.sort_by(|x, y| x.0.total_cmp(&y.0));
    let count = crossings.len();
    if count < 2 {
        return 1.0;
    }
    // arc k runs from undercrossing k − 1 to undercrossing k
    let arc_at = |s: f64| crossings.partition_point(|c| c.0 < s) % count;
    let mut matrix = DMatrix::<f64>::zeros(count, count);
    for (k, &(_, over)) in crossings.iter().enumerate() {
        matrix[(k, arc_at(over))] += 2.0;
        matrix[(k, k)] -= 1.0;
        matrix[(k, (k + 1) % count)] -= 1.0;
    }
    matrix.view((0, 0), (count - 1, count - 1)).into_owned().lu().determinant().abs().round()
}

/// An open rod between ends on the x axis, closed far away.
pub fn closed_far_away(points: &[Vec3]) -> Vec<Vec3> {
    closed_along(points, [-Vec3::x(), Vec3::x()])
}

/// An open rod prolonged along unit vectors from both ends, closed far away by a detour across both.
fn closed_along(points: &[Vec3], [before, after]: [Vec3; 2]) -> Vec<Vec3> {
    let (first, last) = (points[0], points[points.len() - 1]);
    let size = 100.0 * points.iter().map(|p| (p - first).norm()).fold(0.0, f64::max);
    let across = before.cross(&after).try_normalize(PARALLEL);
    let out = across.unwrap_or_else(|| before.cross(&Vec3::ith(before.iamin(), 1.0)).normalize());
    let (left, right, detour) = (first + before * size, last + after * size, first + out * (2.0 * size));
    [left].into_iter().chain(points.iter().copied()).chain([right, detour]).collect()
}

/// Ways on which the ends of a rod go on: along their tangents where grips prolong them, otherwise along x.
fn ways_out(engine: &Engine, rod: usize) -> [Vec3; 2] {
    let last = engine.positions(rod).len() - 1;
    let way = |(node, sign): (usize, f64)| {
        let is_gripped = |body: &Obstacle| {
            let is_endless = matches!(body.skeleton, Skeleton::Piece { length: None, .. });
            is_endless && body.carrier == Some(NodeRef { rod, node })
        };
        let tangent = engine.frames(rod)[node] * Vec3::z();
        (if engine.model().obstacles.iter().any(is_gripped) { tangent } else { Vec3::x() }) * sign
    };
    [(0, -1.0), (last, 1.0)].map(way)
}

/// Rods of more nodes are not looked at: it takes too long.
const MOST_NODES: usize = 4000;

/// Knots of all rods and links of all pairs of closed rods.
///
/// An open rod counts as closed far away: along the endless grips that prolong it, otherwise along the x axis. Where it
/// starts as a knot without grips, its tails must lie along x.
#[derive(Debug, Clone, PartialEq)]
pub struct Topology {
    knots: Vec<f64>,
    links: Vec<f64>,
    closed: Vec<bool>,
}

impl Topology {
    /// Of the engine's present state.
    pub fn of(engine: &Engine) -> Self {
        let rods = &engine.model().rods;
        let closed: Vec<bool> = rods.iter().map(|rod| rod.closed).collect();
        let knot = |rod: usize| {
            let points = engine.positions(rod);
            match (points.len() > MOST_NODES, closed[rod]) {
                (true, _) => 1.0,
                (false, true) => determinant(points),
                (false, false) => determinant(&closed_along(points, ways_out(engine, rod))),
            }
        };
        let knots = (0..rods.len()).map(knot).collect();
        let pairs = (0..rods.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        let links = pairs
            .filter(|&(a, b)| closed[a] && closed[b])
            .map(|(a, b)| linking_number(engine.positions(a), engine.positions(b)).round())
            .collect();
        Self { knots, links, closed }
    }

    /// Whether a state that came from this one has its knots and links. A loop of an open rod that starts without a
    /// knot may slip over the rod's ends.
    pub fn is_kept_in(&self, later: &Self) -> bool {
        let kept = |k: usize| self.knots[k] == later.knots[k] || (!self.closed[k] && self.knots[k] == 1.0);
        self.links == later.links && (0..self.knots.len()).all(kept)
    }
}
