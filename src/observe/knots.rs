//! Knot types and tightness of rods, and linking numbers of pairs of rods.

use crate::math::Vec3;
use crate::math::link::{KnotType, knot_type, linking_number};
use crate::math::signed_distance::Skeleton;
use crate::rod::Rod;
use crate::scene::{Model, NodeRef, Obstacle, ObstaclePose};
use crate::solve::Engine;

use super::report::{GapReport, Knot, Linking};

/// Largest number of nodes of a rod that is classified, because time grows with its square: a twentieth of a second
/// here.
pub(super) const MOST_NODES: usize = 2000;
/// Points per node segment, because chords must be nearer to the centreline than other strands.
const POINTS_PER_SEGMENT: usize = 2;
/// Points per node segment for lengths.
const POINTS_FOR_LENGTH: usize = 8;
/// Distance at which the ends of open rods are joined, over their extent: far beyond all strands.
const FAR: f64 = 10.0;
/// Sine of the angle between the ways outwards up to which they are one line, because any detour across that will do.
const ONE_LINE: f64 = 1e-6;

/// Points of the centreline of a rod as it was given: cubics through the nodes along their d3.
fn given_centerline(rod: &Rod) -> Vec<Vec3> {
    let count = rod.num_nodes();
    let point = |k: usize, u: f64| {
        let (a, b, v) = (k, (k + 1) % count, 1.0 - u);
        let [d_a, d_b] = [a, b].map(|node| rod.frames[node] * Vec3::z() * rod.spacing());
        rod.positions[a] * (v * v * (1.0 + 2.0 * u))
            + rod.positions[b] * (u * u * (1.0 + 2.0 * v))
            + (d_a * v - d_b * u) * (u * v)
    };
    let parts = (0..rod.num_segments() * POINTS_PER_SEGMENT).map(|k| (k / POINTS_PER_SEGMENT, k % POINTS_PER_SEGMENT));
    let mut points: Vec<Vec3> = parts.map(|(k, part)| point(k, part as f64 / POINTS_PER_SEGMENT as f64)).collect();
    if !rod.closed {
        points.extend(rod.positions.last());
    }
    points
}

/// Knots of the rods of a model as they were given, as [`knots`]: rod, determinant, |Δ(exp(2πi/3))|, name.
pub(super) fn given_knots(model: &Model) -> Vec<(usize, f64, f64, String)> {
    let start: Vec<ObstaclePose> = model.obstacles.iter().map(Obstacle::start).collect();
    let of = |rod: usize| {
        let mut points = given_centerline(&model.rods[rod]);
        if !model.rods[rod].closed {
            close(&mut points, grips(model, &start, rod));
        }
        let KnotType { name, alexander } = knot_type(&points)?;
        Some((rod, alexander.determinant.round(), alexander.at_third.round(), name))
    };
    looked_at(model).into_iter().filter_map(of).collect()
}

/// Linking numbers of the rods of a model as they were given, as [`linking`].
pub(super) fn given_linking(model: &Model) -> Vec<([usize; 2], f64)> {
    let closed = closed_rods(model);
    let curves: Vec<Vec<Vec3>> = closed.iter().map(|&rod| given_centerline(&model.rods[rod])).collect();
    let pairs = (0..closed.len()).flat_map(|a| (a + 1..closed.len()).map(move |b| (a, b)));
    let link = |(a, b): (usize, usize)| ([closed[a], closed[b]], linking_number(&curves[a], &curves[b]).round() + 0.0);
    pairs.map(link).collect()
}

/// Closed rods, if they are few and short enough.
fn closed_rods(model: &Model) -> Vec<usize> {
    let closed: Vec<usize> = (0..model.rods.len()).filter(|&rod| model.rods[rod].closed).collect();
    let count = closed.iter().map(|&rod| model.rods[rod].num_nodes()).sum::<usize>();
    if count > MOST_NODES { Vec::new() } else { closed }
}

/// Rods whose knots are looked at.
fn looked_at(model: &Model) -> Vec<usize> {
    let rods = &model.rods;
    let is_looked_at = |&rod: &usize| rods[rod].section.contact_radius > 0.0 && rods[rod].num_nodes() <= MOST_NODES;
    let all: Vec<usize> = (0..rods.len()).filter(is_looked_at).collect();
    let count = all.iter().map(|&rod| rods[rod].num_nodes()).sum::<usize>();
    if model.planar || count > MOST_NODES { Vec::new() } else { all }
}

/// Linking numbers of all pairs of closed rods that are few and short enough.
pub(super) fn linking(engine: &Engine) -> Vec<Linking> {
    let closed = closed_rods(engine.model());
    let curves: Vec<Vec<Vec3>> = closed.iter().map(|&rod| engine.centerline(rod, POINTS_PER_SEGMENT).0).collect();
    let pairs = (0..closed.len()).flat_map(|a| (a + 1..closed.len()).map(move |b| (a, b)));
    // + 0.0 turns −0 into 0
    let link = |(a, b): (usize, usize)| linking_number(&curves[a], &curves[b]).round() + 0.0;
    pairs.map(|(a, b)| Linking { rod_a: closed[a], rod_b: closed[b], link: link((a, b)) }).collect()
}

/// Knots of the rods that take part in contact.
pub(super) fn knots(engine: &Engine, gap: Option<&GapReport>) -> Vec<Knot> {
    let rods = &engine.model().rods;
    let placements = engine.placements(engine.state());
    let of = |rod: usize| {
        let (mut points, _) = engine.centerline(rod, POINTS_PER_SEGMENT);
        if !rods[rod].closed {
            close(&mut points, grips(engine.model(), &placements, rod));
        }
        let KnotType { name, alexander } = knot_type(&points)?;
        let is_one_tube = rods[rod].closed && rods[rod].contact_radii.is_none() && rods.len() == 1;
        let ropelength = gap.filter(|_| is_one_tube).map(|gap| ropelength(engine, rod, gap));
        let [determinant, at_third] = [alexander.determinant, alexander.at_third].map(f64::round);
        Some(Knot { rod, name, determinant, at_third, ropelength })
    };
    looked_at(engine.model()).into_iter().filter_map(of).collect()
}

/// A rigid capsule that prolongs a rod: its direction and its length \[L\], none if it is endless.
type Grip = (Vec3, Option<f64>);

/// The grips at the first and the last node of a rod, with obstacles where they are placed.
fn grips(model: &Model, placements: &[ObstaclePose], rod: usize) -> [Option<Grip>; 2] {
    [0, model.rods[rod].num_nodes() - 1].map(|node| {
        let mut carried =
            model.obstacles.iter().zip(placements).filter(|(o, _)| o.carrier == Some(NodeRef { rod, node }));
        let grip = |(obstacle, placement): (&Obstacle, &ObstaclePose)| match obstacle.placed(placement).skeleton {
            Skeleton::Piece { axis, length, .. } => Some((axis, length)),
            _ => None,
        };
        carried.find_map(grip)
    })
}

/// Joins the ends of an open rod far away from all strands: along the grips that prolong it, and then outwards. Along
/// endless grips the knot is what no motion changes that takes nothing through rod or grips.
fn close(points: &mut Vec<Vec3>, grips: [Option<Grip>; 2]) {
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return };
    let along = |end: Vec3, grip: Option<Grip>| grip.map_or(end, |(axis, length)| end + axis * length.unwrap_or(0.0));
    let tips = [along(first, grips[0]), along(last, grips[1])];
    let middle = points.iter().sum::<Vec3>() / points.len() as f64;
    let extent = points.iter().chain(&tips).map(|point| (point - middle).norm()).fold(0.0, f64::max);
    let outwards = |k: usize| match grips[k] {
        Some((axis, None)) => axis,
        _ => (tips[k] - middle).try_normalize(0.0).unwrap_or(Vec3::x()),
    };
    let (before, after) = (outwards(0), outwards(1));
    // a detour across both, because the straight connection may pass through the rod
    let across = before.cross(&after).try_normalize(ONE_LINE);
    let aside = across.unwrap_or_else(|| before.cross(&Vec3::ith(before.iamin(), 1.0)).normalize());
    let far = FAR * extent;
    let detour = [tips[1], tips[1] + after * far, middle + aside * (2.0 * far), tips[0] + before * far, tips[0]];
    // without a grip of some length the tip is the rod's own end
    points.extend(detour.into_iter().filter(|point| *point != first && *point != last));
}

/// Length of a closed rod over the diameter of the thickest tube about it: the gap limits the distance of strands, the
/// tube's radius limits the curvature.
fn ropelength(engine: &Engine, rod: usize, gap: &GapReport) -> f64 {
    let (points, _) = engine.centerline(rod, POINTS_FOR_LENGTH);
    let length: f64 = (0..points.len()).map(|k| (points[(k + 1) % points.len()] - points[k]).norm()).sum();
    let by_strands = 2.0 * engine.model().rods[rod].section.contact_radius + gap.lower;
    let by_bends = 2.0 / engine.largest_curvature(rod)[0];
    length / by_strands.min(by_bends)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symptom: a knot between endless grips was reported as 3_1 for 5_1, where an end had swung round, and the loops
    /// lay about its grip. Mechanism: ends were joined outwards from the middle of the rod, not along its grips.
    ///
    /// The trefoil of three polynomials is cut where its tail still is among its loops.
    #[test]
    fn knots_are_closed_along_grips() {
        let point = |t: f64| Vec3::new(t.powi(3) - 3.0 * t, t.powi(4) - 4.0 * t * t, t.powi(5) / 5.0 - 2.0 * t);
        let knot = |[from, to]: [f64; 2], gripped: bool| {
            let at = |k: usize| point(from + (to - from) * k as f64 / 300.0);
            let mut points: Vec<Vec3> = (0..=300).map(at).collect();
            let grip = |a: usize, b: usize| gripped.then(|| ((at(b) - at(a)).normalize(), None));
            close(&mut points, [grip(1, 0), grip(299, 300)]);
            knot_type(&points).unwrap().name
        };
        assert_eq!([4.0, 1.8].map(|t| knot([-t, t], true)), ["3_1"; 2]);
        assert_eq!([4.0, 1.8].map(|t| knot([-t, t], false)), ["3_1", "0_1"]);
    }
}
