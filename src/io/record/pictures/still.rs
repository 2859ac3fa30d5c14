//! A state reduced for a picture: few points for any number of nodes.

use serde::{Deserialize, Serialize};

use crate::io::detail::within;
use crate::math::Vec3;
use crate::observe::report::SiteReport;
use crate::scene::file::ColorBy;

use crate::io::record::rods::RodHead;
use crate::io::record::run::{RecordedFrame, RecordedRun, RodSnapshot};

/// Rods of more points than this are thinned out for the film strip.
const MAX_POINTS: usize = 4096;
/// Distance of a point that is left out from the line drawn, relative to the rod's extent: less than a sample of the
/// film strip.
const TOLERANCE: f64 = 1.0 / 2000.0;

/// Data of one picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(in crate::io::record) struct Still {
    pub step: usize,
    pub rods: Vec<StillRod>,
    /// Contact sites, and the radius of the rod there.
    pub spots: Vec<(Vec3, f64)>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(in crate::io::record) struct StillRod {
    pub points: Vec<Vec3>,
    /// Radius at each point of a rod along which it varies; empty for other rods.
    pub radii: Vec<f64>,
    /// d1 at each point; empty if too many points were left out to interpolate it.
    pub directions: Vec<Vec3>,
    /// Quantity that colours the rod, at each point; empty for colours by strand.
    pub values: Vec<f64>,
}

impl Still {
    /// A frame reduced for a picture; `thin` for small pictures.
    pub fn of(run: &RecordedRun, frame: &RecordedFrame, thin: bool) -> Self {
        let rod = |(index, rod): (usize, &RodSnapshot)| {
            let radii = &run.rods[index].radii;
            let values = values(rod, run.choice.color_by);
            if thin && rod.positions.len() > MAX_POINTS {
                let kept = few(&rod.positions);
                let values = kept.iter().filter_map(|&i| values.get(i).copied()).collect();
                let points = kept.iter().map(|&i| rod.positions[i]).collect();
                let radii = kept.iter().filter_map(|&i| radii.get(i).copied()).collect();
                return StillRod { points, radii, directions: Vec::new(), values };
            }
            let directions = rod.frames.iter().map(|q| q * Vec3::x()).collect();
            StillRod { points: rod.positions.clone(), radii: radii.clone(), directions, values }
        };
        let heads = run.heads(frame.step);
        let sites = &run.steps[frame.step].sites;
        let between = sites.iter().map(|site| (place(site, &heads, frame), radius_in(&heads[site.rod_a], site.arc_a)));
        let on_obstacles = &run.steps[frame.step].obstacle_sites;
        let on_obstacles =
            on_obstacles.iter().map(|site| (site.nearest.into(), radius_in(&heads[site.rod], [site.center; 2])));
        let spots = between.chain(on_obstacles).collect();
        Self { step: frame.step, rods: frame.rods.iter().enumerate().map(rod).collect(), spots }
    }
}

/// Quantity that colours pictures, at the nodes of a rod.
fn values(rod: &RodSnapshot, color_by: ColorBy) -> Vec<f64> {
    match color_by {
        ColorBy::Strand => Vec::new(),
        ColorBy::Pressure => rod.smoothed_contact_force.iter().map(Vec3::norm).collect(),
        ColorBy::Curvature => rod.fields.curvature.clone(),
        ColorBy::TwistRate => rod.fields.twist_rate.clone(),
    }
}

/// Radius that a rod is drawn with in the middle of an arc length interval.
fn radius_in(head: &RodHead, arcs: [f64; 2]) -> f64 {
    head.radius_at(middle(head, arcs).round() as usize % head.nodes.max(1))
}

/// Middle between the strands of a contact site.
fn place(site: &SiteReport, heads: &[RodHead], frame: &RecordedFrame) -> Vec3 {
    let at = |rod: usize, arcs: [f64; 2]| point_at(&heads[rod], &frame.rods[rod].positions, arcs);
    0.5 * (at(site.rod_a, site.arc_a) + at(site.rod_b, site.arc_b))
}

/// Middle of an arc length interval, which may lead over the seam, counted in nodes.
fn middle(head: &RodHead, arcs: [f64; 2]) -> f64 {
    let arc = if arcs[1] >= arcs[0] { 0.5 * (arcs[0] + arcs[1]) } else { 0.5 * (arcs[0] + arcs[1] + head.length) };
    (arc / head.spacing()).max(0.0)
}

/// Point in the middle of an arc length interval.
fn point_at(head: &RodHead, points: &[Vec3], arcs: [f64; 2]) -> Vec3 {
    let place = middle(head, arcs);
    let (index, fraction) = (place.floor() as usize, place.fract());
    let point = |i: usize| points[if head.closed { i % points.len() } else { i.min(points.len() - 1) }];
    point(index).lerp(&point(index + 1), fraction)
}

/// Indices of few enough points for every picture of a film.
fn few(points: &[Vec3]) -> Vec<usize> {
    let (low, high) = points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
    let mut tolerance = TOLERANCE * (high - low).norm();
    loop {
        let kept = within(points, tolerance, usize::MAX);
        if kept.len() <= 4 * MAX_POINTS || !(tolerance > 0.0 && tolerance.is_finite()) {
            return kept;
        }
        tolerance *= 2.0;
    }
}
