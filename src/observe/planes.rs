//! Contact sites of rods with planes, and what planes exert in all.

use crate::contact::arc;
use crate::contact::curve::CurveSet;
use crate::contact::law::shortest_line;
use crate::contact::potential::plane::{HalfSpace, PlaneContact, PlanePiece, plane_runs};
use crate::math::Vec3;

use super::report::{PlaneReaction, PlaneSite, SiteKind};
use super::sites::Layer;

/// Distance of two contacts along a rod, in layers (B/κ)^¼ of the contact law, up to which they are one, as between rods.
const NEAR: f64 = 2.0;

/// Pieces of contact that follow each other on one rod and one plane, with the arc lengths that they span.
struct PlaneRun {
    curve: usize,
    plane: usize,
    /// Ascending; over the seam of a closed rod beyond its length \[L\].
    arc: [f64; 2],
    pieces: Vec<PlanePiece>,
}

/// The sites of a state, by planes, rods and arc lengths; `rods` holds the rod of each curve of `set`.
pub(super) fn plane_sites(
    set: &CurveSet,
    planes: &[HalfSpace],
    contacts: &[PlaneContact],
    rods: &[usize],
    layer: &Layer,
) -> Vec<PlaneSite> {
    let mut runs: Vec<PlaneRun> = plane_runs(set, contacts).into_iter().map(|pieces| run(set, pieces)).collect();
    runs.sort_by(|x, y| (x.plane, x.curve).cmp(&(y.plane, y.curve)).then(x.arc[0].total_cmp(&y.arc[0])));
    let mut joined: Vec<PlaneRun> = Vec::new();
    for run in runs {
        let near = |last: &PlaneRun| {
            let reach = NEAR * layer.width_on_plane(run.curve);
            (last.plane, last.curve) == (run.plane, run.curve) && arc::apart(last.arc, run.arc, None) <= reach
        };
        match joined.last_mut().filter(|last| near(last)) {
            Some(last) => {
                last.arc[1] = last.arc[1].max(run.arc[1]);
                last.pieces.extend(run.pieces);
            }
            None => joined.push(run),
        }
    }
    joined.iter().map(|run| site(set, planes, run, rods, layer)).collect()
}

fn run(set: &CurveSet, pieces: Vec<PlanePiece>) -> PlaneRun {
    let (first, last) = (pieces[0], pieces[pieces.len() - 1]);
    let curve = set.curve_of(first.segment);
    let start = set.arc_length(first.segment, first.zone.u[0]);
    let end = set.arc_length(last.segment, last.zone.u[1]);
    let end = if end < start { end + set.period(curve).unwrap_or(0.0) } else { end };
    PlaneRun { curve, plane: first.plane, arc: [start, end], pieces }
}

fn site(set: &CurveSet, planes: &[HalfSpace], run: &PlaneRun, rods: &[usize], layer: &Layer) -> PlaneSite {
    let force: f64 = run.pieces.iter().map(|piece| piece.zone.moments[0]).sum();
    let deeper =
        |best: PlanePiece, piece: &PlanePiece| if piece.zone.min_gap < best.zone.min_gap { *piece } else { best };
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
    let arm = |piece: &PlanePiece| piece.zone.arm + (set.segments[piece.segment].b[0] - foot) * piece.zone.moments[0];
    let torque = run.pieces.iter().map(arm).sum::<Vec3>().cross(&planes[run.plane].normal);
    let center = if force > 0.0 { run.arc[0] + moment / force } else { 0.5 * (run.arc[0] + run.arc[1]) };
    PlaneSite {
        plane: run.plane,
        rod: rods[run.curve],
        arc: [run.arc[0], around(run.arc[1])],
        kind: if is_line { SiteKind::Line } else { SiteKind::Point },
        gap: nearest.zone.min_gap,
        force,
        center: around(center),
        force_on_rod: (planes[run.plane].normal * force).into(),
        moment_on_rod: torque.into(),
        nearest: foot.into(),
    }
}

/// Force of each plane on all rods.
pub(super) fn plane_reactions(planes: &[HalfSpace], contacts: &[PlaneContact]) -> Vec<PlaneReaction> {
    let of = |(index, plane): (usize, &HalfSpace)| {
        let zones = contacts.iter().filter(|contact| contact.plane == index).flat_map(|contact| &contact.zones);
        PlaneReaction {
            plane: index,
            displacement: plane.height,
            force: zones.fold(0.0, |sum, zone| sum + zone.moments[0]),
        }
    };
    planes.iter().enumerate().map(of).collect()
}
