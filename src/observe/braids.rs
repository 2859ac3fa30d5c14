//! Turns of open rods about each other: what ends prescribe, and what strands have.
//!
//! Rods whose ends are held with parallel tangents are extended by straight lines along these. The Gauss integral
//!
//! ```text
//! W = (1/4π) ∫∫ (r_a′ × r_b′)·(r_a − r_b)/|r_a − r_b|³ ds dt
//! ```
//!
//! of both is then the number of turns that they make about each other. It changes with the turns of their ends about
//! each other, and by whole turns where a strand passes over an end of the other rod, or through it.

use std::f64::consts::TAU;

use super::knots::MOST_NODES;
use super::state::PARALLEL;
use crate::math::Vec3;
use crate::scene::{Model, NodeRef, Ramp};
use crate::solve::{Given, Progress};

/// Length of the extensions over the extent of both rods, because what lies beyond adds less than 1e-2 turns.
const FAR: f64 = 100.0;
/// Largest distance of a deviation from whole turns.
const TOL_TURNS: f64 = 0.25;

/// Two rods whose turns about each other are known, and the turns themselves.
pub(super) type Turns = ([usize; 2], f64);

/// Turns of all pairs of rods in contact whose ends are held with parallel tangents.
pub(super) fn given_turns(model: &Model) -> Vec<Turns> {
    let held: Vec<usize> = (0..model.rods.len()).filter(|&rod| is_held(model, rod)).collect();
    if held.iter().map(|&rod| model.rods[rod].num_nodes()).sum::<usize>() > MOST_NODES {
        return Vec::new();
    }
    let pairs = held.iter().enumerate().flat_map(|(k, &a)| held[k + 1..].iter().map(move |&b| [a, b]));
    let turns = |pair: [usize; 2]| {
        let rods = pair.map(|rod| &model.rods[rod]);
        let tangents = rods.map(|rod| [0, rod.num_nodes() - 1].map(|node| rod.frames[node] * Vec3::z()));
        Some((pair, turns_of(rods.map(|rod| &rod.positions[..]), tangents)?))
    };
    pairs.filter_map(turns).collect()
}

/// Notes of pairs whose turns are no longer those that were given, and prescribed since.
pub(super) fn notes(progress: &Progress, given: &Given, start: &[Turns]) -> Vec<String> {
    let engine = progress.engine;
    let note = |(pair, before): &Turns| {
        let due = before + prescribed(given, *pair, progress.stage, progress.fraction)?;
        let positions = pair.map(|rod| engine.positions(rod));
        let tangents = pair.map(|rod| {
            let frames = engine.frames(rod);
            [0, frames.len() - 1].map(|node| frames[node] * Vec3::z())
        });
        let off = turns_of(positions, tangents)? - due;
        let whole = off.round();
        (whole != 0.0 && (off - whole).abs() < TOL_TURNS).then(|| {
            let [a, b] = pair.map(|rod| &engine.model().rods[rod].name);
            let than = if whole < 0.0 { "less" } else { "more" };
            format!(
                "rods \"{a}\" and \"{b}\" make {} turns {than} about each other than prescribed: a strand has passed \
                 over an end of the other rod, where nothing is in its way, or through it",
                whole.abs()
            )
        })
    };
    start.iter().filter_map(note).collect()
}

/// Whether a rod has two ends that hold their frames.
fn is_held(model: &Model, rod: usize) -> bool {
    let of = &model.rods[rod];
    let ends = [0, of.num_nodes() - 1].map(|node| NodeRef { rod, node });
    !of.closed && of.section.contact_radius > 0.0 && ends.iter().all(|&end| model.fixed(end).1 == [true; 3])
}

/// Turns that ramps let the ends of two rods make about each other: where both ends of one side go round one axis, or
/// none; `None` where ramps do anything else with them.
fn prescribed(given: &Given, pair: [usize; 2], stage: usize, fraction: f64) -> Option<f64> {
    let model = &given.model;
    let mut sum = 0.0;
    for (side, sign) in [(0, -1.0), (1, 1.0)] {
        let ends = pair.map(|rod| NodeRef { rod, node: side * (model.rods[rod].num_nodes() - 1) });
        let tangent = model.rods[pair[0]].frames[ends[0].node] * Vec3::z();
        let [a, b] = ends.map(|end| carried(given, end, &tangent, stage, fraction));
        let (a, b) = (a?, b?);
        if (a - b).abs() > PARALLEL {
            return None;
        }
        sum += sign * a;
    }
    Some(sum)
}

/// Turns by which ramps carry a node round an axis along a tangent; `None` if they move it otherwise.
fn carried(given: &Given, node: NodeRef, tangent: &Vec3, stage: usize, fraction: f64) -> Option<f64> {
    let mut turned = 0.0;
    for (k, of) in given.stages.iter().enumerate().take(stage + 1) {
        let part = if k < stage { 1.0 } else { fraction };
        if of.supports.iter().any(|change| change.support().node == node) {
            return None;
        }
        for ramp in &of.ramps {
            match ramp {
                Ramp::RotationAbout { node: at, axis, to, .. } if *at == node => {
                    let along = axis.normalize().dot(tangent);
                    if along.abs() < 1.0 - PARALLEL {
                        return None;
                    }
                    turned += (to * along.signum() - turned) * part;
                }
                Ramp::Displacement { node: at, to }
                    if *at == node && to.cross(tangent).norm() > PARALLEL * to.norm() =>
                {
                    return None;
                }
                Ramp::Pose { node: at, .. } if *at == node => return None,
                _ => {}
            }
        }
    }
    Some(turned)
}

/// Turns of two strands about each other; `None` unless the tangents of all ends are parallel.
fn turns_of(strands: [&[Vec3]; 2], tangents: [[Vec3; 2]; 2]) -> Option<f64> {
    let along = tangents[0][0];
    let parallel = tangents.iter().flatten().all(|tangent| tangent.angle(&along) < PARALLEL);
    if !parallel {
        return None;
    }
    let middle = strands.iter().copied().flatten().sum::<Vec3>() / (strands[0].len() + strands[1].len()) as f64;
    let extent = strands.iter().copied().flatten().map(|x| (x - middle).norm()).fold(0.0, f64::max);
    let extended = strands.map(|points| {
        let ends = points
            .first()
            .zip(points.last())
            .map(|(first, last)| [first - along * (FAR * extent), last + along * (FAR * extent)]);
        ends.map(|[before, after]| [&[before], points, &[after]].concat()).unwrap_or_default()
    });
    let [a, b] = &extended;
    let sum: f64 =
        a.windows(2).map(|x| b.windows(2).map(|y| solid_angle([x[0], x[1]], [y[0], y[1]])).sum::<f64>()).sum();
    Some(sum / (2.0 * TAU))
}

/// Gauss integral of two straight segments, times 4π (Klenin & Langowski 2000, eq. 15 and 16).
fn solid_angle([p, q]: [Vec3; 2], [r, s]: [Vec3; 2]) -> f64 {
    let (pr, ps, qr, qs) = (r - p, s - p, r - q, s - q);
    let normals = [pr.cross(&ps), ps.cross(&qs), qs.cross(&qr), qr.cross(&pr)];
    let Some(n) = normals.iter().map(|n| n.try_normalize(0.0)).collect::<Option<Vec<Vec3>>>() else { return 0.0 };
    let angle = |a: &Vec3, b: &Vec3| a.dot(b).clamp(-1.0, 1.0).asin();
    let area = angle(&n[0], &n[1]) + angle(&n[1], &n[2]) + angle(&n[2], &n[3]) + angle(&n[3], &n[0]);
    let side = (s - r).cross(&(q - p)).dot(&pr);
    if side == 0.0 { 0.0 } else { area * side.signum() }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Two helices of a number of turns about each other, right-handed, along z.
    fn helices(turns: f64) -> [Vec<Vec3>; 2] {
        let point = |k: usize, phase: f64| {
            let t = k as f64 / 200.0;
            let angle = TAU * turns * t + phase;
            Vec3::new(angle.cos(), angle.sin(), 20.0 * t)
        };
        [0.0, PI].map(|phase| (0..=200).map(|k| point(k, phase)).collect())
    }

    #[test]
    fn helices_make_their_turns_about_each_other() {
        for turns in [0.0, 0.3, 3.0, -2.25, 5.88] {
            let [a, b] = helices(turns);
            let found = turns_of([&a, &b], [[Vec3::z(); 2]; 2]).unwrap();
            assert!((found - turns).abs() < 1e-2, "{found} {turns}");
        }
        let [a, b] = helices(1.0);
        assert_eq!(turns_of([&a, &b], [[Vec3::z(), Vec3::x()], [Vec3::z(); 2]]), None);
    }
}
