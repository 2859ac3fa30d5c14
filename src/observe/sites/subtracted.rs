//! Pieces of farthest points, which the potential subtracts, as parts of zones.
//!
//! Where a strand is bent more tightly than within the contact distance, a point near its centre of curvature has two nearest
//! points on it and a farthest one between them. The two and the one subtracted push together as one strand does. So the
//! subtracted piece belongs to the zones on either side of it, whose feet are the next ones along the strand. Left out, one
//! contact counts as two: a rod kinked by a point force (shear F/GA) had its force reported twice.

use super::{Composed, SiteZone, class, piece};
use crate::contact::arc::{apart, near};
use crate::contact::chain::subtracted;
use crate::contact::curve::CurveSet;
use crate::contact::potential::ContactPair;

/// Takes the subtracted pieces from the sorted zones beside them.
pub(super) fn take_from(set: &CurveSet, terms: &[ContactPair], all: &mut [Composed]) {
    let zones: Vec<SiteZone> = all.iter().map(|composed| composed.zone).collect();
    for link in subtracted(set, terms) {
        let piece = piece(set, &link);
        let beside = beside(set, &zones, &piece);
        // as their forces are, so that none is left with less than none
        let sum: f64 = beside.iter().map(|&zone| zones[zone].load.force).sum();
        for &zone in &beside {
            let share = if sum > 0.0 { zones[zone].load.force / sum } else { 1.0 / beside.len() as f64 };
            all[zone].add(set, piece.times(share));
        }
    }
}

/// The zones with the next feet before and after those of a piece; one of them where there is no other. A farthest point is
/// pressed less than the nearest ones beside it, so a zone that carries less than the piece is not beside it, however near.
fn beside(set: &CurveSet, zones: &[SiteZone], piece: &SiteZone) -> Vec<usize> {
    let [own, other] = [piece.curve_a, piece.curve_b].map(|curve| set.period(curve));
    let middle = |arc: [f64; 2]| 0.5 * (arc[0] + arc[1]);
    let distance = |k: &usize| apart(zones[*k].arc_a, piece.arc_a, own).max(0.0);
    let ahead = |k: &usize| {
        let zone = &zones[*k];
        let length = zone.arc_a[1] - zone.arc_a[0];
        let along = near(middle(piece.arc_a), middle(zone.arc_a), own) - zone.arc_a[0];
        let share = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.5 };
        let foot = zone.arc_b[0] + share * (zone.arc_b[1] - zone.arc_b[0]);
        near(foot, middle(piece.arc_b), other) - middle(piece.arc_b)
    };
    let class = class(zones, piece.curve_a, piece.curve_b);
    let strongest = class.clone().map(|k| zones[k].load.force).fold(0.0, f64::max);
    let carries = |k: &usize| zones[*k].load.force >= strongest.min(-piece.load.force);
    let nearest = class.clone().filter(carries).map(|k| distance(&k)).fold(f64::INFINITY, f64::min);
    let over = || class.clone().filter(carries).filter(|k| distance(k) <= nearest);
    let closer = |x: &usize, y: &usize| ahead(x).abs().total_cmp(&ahead(y).abs());
    let before = over().filter(|k| ahead(k) < 0.0).min_by(closer);
    let after = over().filter(|k| ahead(k) >= 0.0).min_by(closer);
    before.into_iter().chain(after).collect()
}

impl Composed {
    /// Adds a piece that does not lengthen the zone.
    fn add(&mut self, set: &CurveSet, piece: SiteZone) {
        let zone = &mut self.zone;
        let shift = near(piece.load.center, zone.load.center, set.period(zone.curve_a)) - piece.load.center;
        zone.load = zone.load.with(piece.load, shift);
        zone.torque += piece.torque_about(&zone.at);
        zone.push += piece.push;
        // a farthest point is no gap
        self.pieces.push(SiteZone { gap: zone.gap, ..piece });
    }
}

impl SiteZone {
    /// The piece with a part of its force.
    fn times(mut self, share: f64) -> Self {
        self.load.force *= share;
        self.load.inertia *= share;
        self.push *= share;
        self.torque *= share;
        self
    }
}
