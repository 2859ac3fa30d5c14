//! Contact sites of rods with obstacles, and what obstacles exert in all.

use crate::contact::arc;
use crate::contact::curve::CurveSet;
use crate::contact::law::shortest_line;
use crate::contact::potential::surface::{SurfaceContact, SurfacePiece, surface_runs};
use crate::math::Vec3;
use crate::scene::ObstaclePose;

use super::report::{ObstacleReaction, ObstacleSite, SiteKind};
use super::sites::Layer;

/// Distance of two contacts along a rod, in layers (B/κ)^¼ of the contact law, up to which they are one, as between
/// rods.
const NEAR: f64 = 2.0;

/// Pieces of contact that follow each other on one rod and one obstacle, with the arc lengths that they span.
struct ObstacleRun {
    curve: usize,
    obstacle: usize,
    /// Ascending; over the seam of a closed rod beyond its length \[L\].
    arc: [f64; 2],
    pieces: Vec<SurfacePiece>,
}

/// The sites of a state, by obstacles, rods and arc lengths; `rods` holds the rod of each curve of `set`.
pub(super) fn obstacle_sites(
    set: &CurveSet,
    contacts: &[SurfaceContact],
    rods: &[usize],
    layer: &Layer,
) -> Vec<ObstacleSite> {
    let mut runs: Vec<ObstacleRun> = surface_runs(set, contacts).into_iter().map(|pieces| run(set, pieces)).collect();
    runs.sort_by(|x, y| (x.obstacle, x.curve).cmp(&(y.obstacle, y.curve)).then(x.arc[0].total_cmp(&y.arc[0])));
    let mut joined: Vec<ObstacleRun> = Vec::new();
    for run in runs {
        let near = |last: &ObstacleRun| {
            let reach = NEAR * layer.width_on_obstacle(run.curve);
            (last.obstacle, last.curve) == (run.obstacle, run.curve) && arc::apart(last.arc, run.arc, None) <= reach
        };
        match joined.last_mut().filter(|last| near(last)) {
            Some(last) => {
                last.arc[1] = last.arc[1].max(run.arc[1]);
                last.pieces.extend(run.pieces);
            }
            None => joined.push(run),
        }
    }
    joined.iter().map(|run| site(set, run, rods, layer)).collect()
}

fn run(set: &CurveSet, pieces: Vec<SurfacePiece>) -> ObstacleRun {
    let (first, last) = (pieces[0], pieces[pieces.len() - 1]);
    let curve = set.curve_of(first.segment);
    let start = set.arc_length(first.segment, first.zone.u[0]);
    let end = set.arc_length(last.segment, last.zone.u[1]);
    let end = if end < start { end + set.period(curve).unwrap_or(0.0) } else { end };
    ObstacleRun { curve, obstacle: first.surface, arc: [start, end], pieces }
}

fn site(set: &CurveSet, run: &ObstacleRun, rods: &[usize], layer: &Layer) -> ObstacleSite {
    let force: f64 = run.pieces.iter().map(|piece| piece.zone.moments[0]).sum();
    let deeper =
        |best: SurfacePiece, piece: &SurfacePiece| if piece.zone.min_gap < best.zone.min_gap { *piece } else { best };
    let nearest = run.pieces.iter().fold(run.pieces[0], deeper);
    let width = run.arc[1] - run.arc[0];
    let is_line = width > shortest_line(layer.stiffness, [layer.bending[run.curve], f64::INFINITY]);
    let period = set.period(run.curve);
    let around = |at: f64| period.map_or(at, |period| if at > period { at - period } else { at });
    // moments count from the start of each segment; arcs ascend from the start of the run
    let moment: f64 = run
        .pieces
        .iter()
        .map(|piece| {
            let [force, first, _] = piece.zone.moments;
            let start = set.arc_length(piece.segment, piece.zone.u[0]);
            let start = if start < run.arc[0] { start + period.unwrap_or(0.0) } else { start };
            force * (start - run.arc[0]) + (first - force * piece.zone.u[0]) * set.lengths[piece.segment]
        })
        .sum();
    let foot = set.segments[nearest.segment].point(nearest.zone.nearest);
    let torque =
        |piece: &SurfacePiece| piece.zone.torque + (set.segments[piece.segment].b[0] - foot).cross(&piece.zone.force);
    let center = if force > 0.0 { run.arc[0] + moment / force } else { 0.5 * (run.arc[0] + run.arc[1]) };
    ObstacleSite {
        obstacle: run.obstacle,
        rod: rods[run.curve],
        arc: [run.arc[0], around(run.arc[1])],
        kind: if is_line { SiteKind::Line } else { SiteKind::Point },
        gap: nearest.zone.min_gap,
        force,
        center: around(center),
        force_on_rod: run.pieces.iter().map(|piece| piece.zone.force).sum::<Vec3>().into(),
        moment_on_rod: run.pieces.iter().map(torque).sum::<Vec3>().into(),
        nearest: foot.into(),
    }
}

/// Force of each obstacle on all rods.
pub(super) fn obstacle_reactions(placements: Vec<ObstaclePose>, contacts: &[SurfaceContact]) -> Vec<ObstacleReaction> {
    let of = |(obstacle, placement): (usize, ObstaclePose)| {
        let of_this = contacts.iter().filter(|contact| contact.surface == obstacle);
        let (force, push) = of_this
            .flat_map(|contact| &contact.zones)
            .fold((0.0, Vec3::zeros()), |(force, push), zone| (force + zone.moments[0], push + zone.force));
        ObstacleReaction { obstacle, placement, force, force_on_rods: push.into() }
    };
    placements.into_iter().enumerate().map(of).collect()
}
