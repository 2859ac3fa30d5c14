//! Pieces of farthest points, which the potential subtracts, as parts of zones.
//!
//! Where a strand is bent more tightly than within the contact distance, a point near its centre of curvature has two
//! nearest points on it and a farthest one between them. The two and the one subtracted push together as one strand
//! does. So the zones on either side of a subtracted piece, whose feet are the next ones along the strand, are a fold:
//! one contact, which reaches from one to the other. Left out, a rod kinked by a point force (shear F/GA) had its force
//! reported twice; in shares of two sites, tight knots had forces at arcs of neither of them.

use super::{CARRIES, Composed, SiteZone, class, piece};
use crate::contact::arc::{apart, near};
use crate::contact::chain::subtracted;
use crate::contact::curve::CurveSet;
use crate::contact::potential::ContactPair;

impl Composed {
    /// Takes the subtracted pieces from the zones beside them, which are folds.
    pub(super) fn subtract(&mut self, set: &CurveSet, terms: &[ContactPair]) {
        let zones = self.zones.clone();
        for link in subtracted(set, terms) {
            let piece = piece(set, &link);
            let beside = beside(set, &zones, &piece);
            // what carries less than is told of sites does not join them
            let told = |zone: usize| CARRIES * zones[zone].load.force;
            if let [before, after] = beside[..]
                && piece.push.norm() > told(before).min(told(after))
            {
                self.folds.push([before, after]);
            }
            // from the stronger, so that none is left with less than none
            let stronger = |x: &usize, y: &usize| zones[*x].load.force.total_cmp(&zones[*y].load.force);
            if let Some(zone) = beside.into_iter().max_by(stronger) {
                self.zones[zone].add(set, &piece);
                // a farthest point is no gap
                self.pieces[zone].push(SiteZone { gap: zones[zone].gap, ..piece });
            }
        }
    }
}

/// The zones with the next feet before and after those of a piece; one of them where there is no other. A farthest
/// point is pressed less than the nearest ones beside it, so a zone that carries less than the piece is not beside it,
/// however near.
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

impl SiteZone {
    /// Adds a piece that does not lengthen the zone.
    fn add(&mut self, set: &CurveSet, piece: &Self) {
        let shift = near(piece.load.center, self.load.center, set.period(self.curve_a)) - piece.load.center;
        self.load = self.load.with(piece.load, shift);
        self.torque += piece.torque_about(&self.at);
        self.push += piece.push;
    }
}
