//! Contact sites for reports: the pieces of contact zones, segment by segment and seen from both strands, merged into
//! contacts.
//!
//! 1. Pieces of one strand that follow each other, and whose feet follow each other on the other strand, make a *zone*.
//!    Pieces that the potential subtracts (farthest points between two nearest ones, see
//!    [`zones`](crate::contact::zones)) make the zones on both sides of them one *fold*, so that forces of sites sum to
//!    those that the rods feel.
//! 2. Zones seen from strand a and zones seen from strand b that overlap on both strands are views of one *site*, and
//!    so are those of a fold. Its force is the sum over all its zones, because each view carries its share of it.
//! 3. Sites nearer to each other on both strands than the width of the contact law, or in a row of three or more each
//!    within an element of the next, are fragments of one; a short and weak one beside a strong one is a ripple of it
//!    (`fragments`).
//! 4. A site is a *line* if it is half again as long as a point can be under the contact law, see [`shortest_line`],
//!    and longer than an element: where in an element pressure gathers is not known.

use crate::contact::arc::{self, ascending, near};
use crate::contact::chain::{ChainPiece, TOL_FOOT, chains};
use crate::contact::curve::{CurveSet, angle};
use crate::contact::law::shortest_line;
use crate::contact::potential::{ContactPair, ZonePiece};
use crate::math::Vec3;

use super::report::{SiteKind, SiteReport};

mod by_place;
mod fragments;
mod lines;
mod subtracted;

use by_place::ByPlace;
pub(super) use lines::{lines, spread};

/// Largest relative gap of a zone that counts as going all round a closed strand.
const TOL_ARC: f64 = 1e-6;
/// Force of a site, over that of the strongest, that is none, because contact forces are known to 1e-6.
const CARRIES: f64 = 1e-6;
/// Length of the zone of a point contact that opens, over the spread of its pressure: 2a/√(∫ws² ds/∫w ds) of the
/// solution w in [`shortest_line`].
const ZONE_OVER_SPREAD: f64 = 4.369_219_575_688_655;

/// A piece or a zone as seen from strand a: arc lengths \[L\], not reduced to one period on closed curves.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SiteZone {
    curve_a: usize,
    /// Ascending.
    arc_a: [f64; 2],
    curve_b: usize,
    /// Feet of the ends of `arc_a`; descending where the strands are antiparallel.
    arc_b: [f64; 2],
    load: Load,
    gap: f64,
    /// Crossing angle where the gap is smallest, degrees.
    angle: f64,
    /// The share of the force on strand a that its strand integrates \[F\].
    push: Vec3,
    /// Its moment about `at` \[F·L\].
    torque: Vec3,
    /// The start of the zone's first segment \[L\].
    at: Vec3,
    /// Points of the centrelines of strands a and b where the gap is smallest \[L\].
    feet: [Vec3; 2],
}

impl SiteZone {
    /// Moment of the force on strand a about a point \[F·L\].
    fn torque_about(&self, point: &Vec3) -> Vec3 {
        self.torque + (self.at - point).cross(&self.push)
    }
}

/// A force distributed along a strand.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Load {
    /// Resultant \[F\].
    force: f64,
    /// Mean arc length, on the same branch as the zone's `arc_a` \[L\].
    center: f64,
    /// ∫p (s − center)² ds \[F·L²\].
    inertia: f64,
}

impl Load {
    /// The sum with `other`, whose arc lengths are increased by `shift`.
    fn with(self, other: Self, shift: f64) -> Self {
        let force = self.force + other.force;
        if force <= 0.0 {
            return Self { force, inertia: 0.0, ..self };
        }
        let lever = other.center + shift - self.center;
        let share = other.force / force;
        Self {
            force,
            center: self.center + share * lever,
            inertia: self.inertia + other.inertia + self.force * share * lever * lever,
        }
    }

    fn spread(&self) -> f64 {
        if self.force > 0.0 { (self.inertia / self.force).max(0.0).sqrt() } else { 0.0 }
    }
}

/// Data that distinguish points from lines: stiffnesses of contact and strands.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    /// Contact stiffness κ \[F/L²\].
    pub(super) stiffness: f64,
    /// Smaller bending stiffness of each curve \[F·L²\].
    pub(super) bending: Vec<f64>,
    /// Length of the elements of each curve \[L\].
    pub(super) elements: Vec<f64>,
}

impl Layer {
    /// Width (B/κ)^¼ of the contact layer along a line, for the softer strand \[L\].
    fn width(&self, a: usize, b: usize) -> f64 {
        (self.bending[a].min(self.bending[b]) / self.stiffness).powf(0.25)
    }

    /// The same of a strand on an obstacle.
    pub(super) fn width_on_obstacle(&self, curve: usize) -> f64 {
        (self.bending[curve] / self.stiffness).powf(0.25)
    }

    /// Length over which pressure is known, along strand `a` \[L\]: the law spreads it over the layer, and elements
    /// gather it. Smoothed with a Gaussian of half an element, what varies from element to element is reduced to 2
    /// exp(−π²/2) = 1.4 %.
    pub(super) fn resolution(&self, a: usize, b: usize) -> f64 {
        self.width(a, b).max(0.5 * self.elements[a])
    }

    fn shortest_line(&self, a: usize, b: usize) -> f64 {
        shortest_line(self.stiffness, [self.bending[a], self.bending[b]])
    }
}

/// Sites of all terms, sorted by place; `rods` holds the rod of each curve of `set`.
pub(super) fn sites(set: &CurveSet, terms: &[ContactPair], rods: &[usize], layer: &Layer) -> Vec<SiteReport> {
    let Composed { zones, folds, .. } = composed(set, terms);
    let contacts = contacts(set, &zones, &folds, layer);
    let of = |members: &Vec<(usize, bool)>| site(ContactZones { set, zones: &zones, members }, rods, layer).0;
    let mut sites: Vec<SiteReport> = contacts.iter().map(of).collect();
    let strongest = strongest(sites.iter());
    sites.retain(|site| touches(site, strongest));
    sites.sort_by(by_arcs);
    sites
}

/// Whether strands touch at a site, where the strongest carries a force: one that carries nothing and is open is only
/// within the law's reach.
fn touches(site: &SiteReport, strongest: f64) -> bool {
    // of a folded contact the parts may have opposite signs: none is left out that acts on the rods
    let carried = site.force.abs().max(Vec3::from(site.force_on_a).norm());
    carried > CARRIES * strongest || site.gap <= 0.0
}

/// The largest force of sites.
fn strongest<'a>(sites: impl Iterator<Item = &'a SiteReport>) -> f64 {
    sites.map(|site| site.force).fold(0.0, f64::max)
}

/// Groups of zones, one for each contact; fragments of a line are in one group.
fn contacts(set: &CurveSet, zones: &[SiteZone], folds: &[[usize; 2]], layer: &Layer) -> Vec<Vec<(usize, bool)>> {
    fragments::joined(set, zones, views(set, zones, folds), layer)
}

fn by_arcs(x: &SiteReport, y: &SiteReport) -> std::cmp::Ordering {
    let key = |s: &SiteReport| (s.rod_a, s.rod_b);
    key(x).cmp(&key(y)).then(x.arc_a[0].total_cmp(&y.arc_a[0])).then(x.arc_b[0].total_cmp(&y.arc_b[0]))
}

fn contact_distance(set: &CurveSet, zone: &SiteZone) -> f64 {
    set.curves[zone.curve_a].radius + set.curves[zone.curve_b].radius
}

fn order(x: &SiteZone, y: &SiteZone) -> std::cmp::Ordering {
    let pair = |z: &SiteZone| (z.curve_a, z.curve_b);
    pair(x).cmp(&pair(y)).then(x.arc_a[0].total_cmp(&y.arc_a[0])).then(x.arc_b[0].total_cmp(&y.arc_b[0]))
}

/// Index range of the zones of strand `a` against strand `b` in a sorted list.
fn class(zones: &[SiteZone], a: usize, b: usize) -> std::ops::Range<usize> {
    let start = zones.partition_point(|z| (z.curve_a, z.curve_b) < (a, b));
    start..zones.partition_point(|z| (z.curve_a, z.curve_b) <= (a, b))
}

/// Zones, sorted, and what they are made of.
struct Composed {
    zones: Vec<SiteZone>,
    /// For each zone the pieces that it is the sum of, those with a negative force subtracted.
    pieces: Vec<Vec<SiteZone>>,
    /// Pairs of zones with a subtracted piece between them.
    folds: Vec<[usize; 2]>,
}

fn composed(set: &CurveSet, terms: &[ContactPair]) -> Composed {
    let mut all: Vec<(SiteZone, Vec<SiteZone>)> = chains(set, terms).iter().map(|chain| zone(set, chain)).collect();
    all.sort_by(|x, y| order(&x.0, &y.0));
    let (zones, pieces) = all.into_iter().unzip();
    let mut composed = Composed { zones, pieces, folds: Vec::new() };
    composed.subtract(set, terms);
    composed
}

/// The zone of a chain, and its pieces.
fn zone(set: &CurveSet, chain: &[ChainPiece]) -> (SiteZone, Vec<SiteZone>) {
    let pieces: Vec<SiteZone> = chain.iter().map(|link| piece(set, link)).collect();
    let mut zone = pieces[0];
    pieces[1..].iter().for_each(|piece| append(set, &mut zone, piece));
    (zone, pieces)
}

fn piece(set: &CurveSet, link: &ChainPiece) -> SiteZone {
    let (zone, [curve_a, curve_b], [arc_a, arc_b]) = (link.zone, link.curves, link.arcs);
    let nearest = zone.piece.nearest;
    let (foot_a, tangent_a, _) = set.segments[link.segments[0]].derivatives(nearest.u);
    let (foot_b, tangent_b, _) = set.segments[link.segments[1]].derivatives(nearest.v);
    let crossing = angle(&tangent_a, &tangent_b).to_degrees();
    SiteZone {
        curve_a,
        arc_a,
        curve_b,
        arc_b,
        load: load(zone, arc_a),
        gap: zone.min_gap,
        angle: crossing.min(180.0 - crossing),
        push: zone.push,
        torque: zone.torque,
        at: set.segments[link.segments[0]].b[0],
        feet: [foot_a, foot_b],
    }
}

/// The force on the slave side of a piece that spans `arc`.
fn load(zone: &ZonePiece, arc: [f64; 2]) -> Load {
    let (force, [first, second]) = (zone.force, zone.moments);
    let u = zone.piece.u;
    if force == 0.0 || u[1] <= u[0] {
        return Load { force, center: 0.5 * (arc[0] + arc[1]), inertia: 0.0 };
    }
    let scale = (arc[1] - arc[0]) / (u[1] - u[0]);
    let mean = first / force;
    // of the sign of the force
    let inertia = force.signum() * (force.signum() * (second - mean * first)).max(0.0) * scale * scale;
    Load { force, center: arc[0] + (mean - u[0]) * scale, inertia }
}

fn append(set: &CurveSet, zone: &mut SiteZone, piece: &SiteZone) {
    zone.load = zone.load.with(piece.load, zone.arc_a[1] - piece.arc_a[0]);
    zone.push += piece.push;
    zone.torque += piece.torque_about(&zone.at);
    zone.arc_a[1] += piece.arc_a[1] - piece.arc_a[0];
    let start = near(piece.arc_b[0], zone.arc_b[1], set.period(zone.curve_b));
    zone.arc_b[1] = start + piece.arc_b[1] - piece.arc_b[0];
    if piece.gap < zone.gap {
        (zone.gap, zone.angle, zone.feet) = (piece.gap, piece.angle, piece.feet);
    }
}

/// Groups zones into sites: the indices of its zones, true for those that see it from the other strand than the first.
fn views(set: &CurveSet, zones: &[SiteZone], folds: &[[usize; 2]]) -> Vec<Vec<(usize, bool)>> {
    let places = ByPlace::new(set, zones);
    let mut folded: Vec<Vec<usize>> = vec![Vec::new(); zones.len()];
    for &[x, y] in folds {
        folded[x].push(y);
        folded[y].push(x);
    }
    let mut used = vec![false; zones.len()];
    let mut groups = Vec::new();
    for start in 0..zones.len() {
        if used[start] {
            continue;
        }
        used[start] = true;
        let mut group = vec![(start, false)];
        let mut next = 0;
        while let Some(&(member, flipped)) = group.get(next) {
            let others = counterparts(set, zones, &places, member).into_iter().map(|other| (other, !flipped));
            for (other, turned) in others.chain(folded[member].iter().map(|&other| (other, flipped))) {
                if !used[other] {
                    used[other] = true;
                    group.push((other, turned));
                }
            }
            next += 1;
        }
        groups.push(group);
    }
    groups
}

/// Indices of the zones that see the same contact from the other strand.
fn counterparts(set: &CurveSet, zones: &[SiteZone], places: &ByPlace, index: usize) -> Vec<usize> {
    let pad = pad(set, &zones[index]);
    let mut near = places.near((zones[index].curve_b, zones[index].curve_a), zones[index].arc_b, pad);
    near.retain(|&other| sees(set, &zones[index], &zones[other], pad) && other != index);
    near
}

/// Largest distance between the views of one contact \[L\].
fn pad(set: &CurveSet, zone: &SiteZone) -> f64 {
    TOL_FOOT * contact_distance(set, zone)
}

/// Whether two zones, each on the other's partner strand, overlap on both strands.
fn sees(set: &CurveSet, zone: &SiteZone, other: &SiteZone, pad: f64) -> bool {
    let meet = |curve: usize, x, y| arc::apart(ascending(x), ascending(y), set.period(curve)) <= pad;
    meet(zone.curve_b, zone.arc_b, other.arc_a) && meet(zone.curve_a, zone.arc_a, other.arc_b)
}

/// The smallest arc over all `arcs` (the first decides the period), or the whole of a closed curve, within
/// [0, length\].
fn hull(arcs: impl Iterator<Item = [f64; 2]>, period: Option<f64>) -> [f64; 2] {
    let all = arcs.map(ascending).reduce(|sum, arc| arc::joined(sum, arc, period));
    let arc = all.unwrap_or_default();
    let width = arc[1] - arc[0];
    match period {
        None => arc,
        Some(period) if width >= period * (1.0 - TOL_ARC) => [0.0, period],
        Some(period) => {
            let start = arc[0].rem_euclid(period);
            let end = start + width;
            [start, if end > period { end - period } else { end }]
        }
    }
}

/// Zones that see one contact, each with whether it sees it from the other strand than the first.
#[derive(Clone, Copy)]
struct ContactZones<'a> {
    set: &'a CurveSet,
    zones: &'a [SiteZone],
    members: &'a [(usize, bool)],
}

impl<'a> ContactZones<'a> {
    fn first(self) -> &'a SiteZone {
        &self.zones[self.members[0].0]
    }

    /// Strands a and b of the first zone.
    fn curves(self) -> [usize; 2] {
        [self.first().curve_a, self.first().curve_b]
    }

    fn seen_from(self, strand: usize) -> impl Iterator<Item = &'a SiteZone> {
        self.members.iter().filter(move |m| m.1 == (strand == 1)).map(move |m| &self.zones[m.0])
    }

    /// Arcs on strands a and b on which it acts: of points and of feet.
    fn arcs(self) -> [[f64; 2]; 2] {
        [0, 1].map(|strand| {
            let on = |&(zone, flipped): &(usize, bool)| {
                let zone = &self.zones[zone];
                if flipped == (strand == 1) { zone.arc_a } else { zone.arc_b }
            };
            hull(self.members.iter().map(on), self.set.period(self.curves()[strand]))
        })
    }

    /// The force that a strand sees.
    fn load(self, strand: usize) -> Load {
        let period = self.set.period(self.curves()[strand]);
        self.seen_from(strand).map(|z| z.load).fold(Load::default(), |sum, load| {
            let shift = if sum.force > 0.0 { near(load.center, sum.center, period) - load.center } else { 0.0 };
            sum.with(load, shift)
        })
    }

    /// The zone of the smallest gap, and the points of strands a and b there \[L\].
    fn nearest(self) -> (&'a SiteZone, [Vec3; 2]) {
        let zones = self.zones;
        let closer =
            |best: (usize, bool), m: &(usize, bool)| if zones[m.0].gap < zones[best.0].gap { *m } else { best };
        let (nearest, flipped) = self.members.iter().fold(self.members[0], closer);
        let [foot, other] = zones[nearest].feet;
        (&zones[nearest], if flipped { [other, foot] } else { [foot, other] })
    }

    /// Force on strand a \[F\].
    fn push(self) -> Vec3 {
        self.seen_from(0).map(|z| z.push).sum::<Vec3>() - self.seen_from(1).map(|z| z.push).sum::<Vec3>()
    }

    /// Moment of the force on strand a about a point \[F·L\].
    fn torque_about(self, point: &Vec3) -> Vec3 {
        let seen = |strand: usize| self.seen_from(strand).map(|z| z.torque_about(point)).sum::<Vec3>();
        seen(0) - seen(1)
    }

    /// Whether it is long enough for a line: by its spread, so that what a mesh leaves of pressure beside a point
    /// hardly counts.
    fn kind(self, layer: &Layer, spread: f64) -> SiteKind {
        let [a, b] = self.curves();
        let length = ZONE_OVER_SPREAD * spread;
        let element = layer.elements[a].max(layer.elements[b]);
        if length > layer.shortest_line(a, b).max(element) { SiteKind::Line } else { SiteKind::Point }
    }
}

/// The site of a contact, and whether its strand b is the first zone's own.
fn site(contact: ContactZones, rods: &[usize], layer: &Layer) -> (SiteReport, bool) {
    let (curves, first) = (contact.curves(), contact.first());
    let [arc_a, arc_b] = contact.arcs();
    let loads = [0, 1].map(|strand| contact.load(strand));
    let center = |strand: usize, feet: [f64; 2]| {
        let center = if loads[strand].force > 0.0 { loads[strand].center } else { 0.5 * (feet[0] + feet[1]) };
        contact.set.period(curves[strand]).map_or(center, |p| center.rem_euclid(p))
    };
    let (nearest, feet) = contact.nearest();
    let push = contact.push();
    let spreads = loads.map(|load| load.spread());
    let a = (rods[curves[0]], arc_a, center(0, first.arc_a), spreads[0]);
    let b = (rods[curves[1]], arc_b, center(1, first.arc_b), spreads[1]);
    let swapped = (b.0, b.1[0]) < (a.0, a.1[0]);
    let (a, b) = if swapped { (b, a) } else { (a, b) };
    let (push, feet) = if swapped { (-push, [feet[1], feet[0]]) } else { (push, feet) };
    let torque = contact.torque_about(&feet[0]) * if swapped { -1.0 } else { 1.0 };
    let report = SiteReport {
        rod_a: a.0,
        arc_a: a.1,
        rod_b: b.0,
        arc_b: b.1,
        kind: contact.kind(layer, 0.5 * (spreads[0] + spreads[1])),
        gap: nearest.gap,
        force: loads[0].force + loads[1].force,
        center: [a.2, b.2],
        spread: [a.3, b.3],
        angle: nearest.angle,
        force_on_a: push.into(),
        moment_on_a: torque.into(),
        feet: feet.map(Into::into),
    };
    (report, swapped)
}

#[cfg(test)]
mod tests;
