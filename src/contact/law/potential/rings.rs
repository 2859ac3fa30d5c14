//! Closed curves that lie entirely within reach of a point of another strand.

use super::ContactGeometry;
use super::integral::Projector;
use super::pressure::PairLaw;
use crate::contact::measures::COINCIDENT;
use crate::contact::projection::{smooth_joint, stationarity};
use crate::contact::zones::{BranchPiece, FootKind};
use crate::math::Vec3;
use crate::math::bernstein::{Roots, roots};

impl ContactGeometry<'_> {
    /// A closed curve that lies entirely within reach of a slave point counts as one strand there, although it has as
    /// many farthest points as nearest ones: the farthest of all is not subtracted.
    pub(super) fn keep_rings(
        &self,
        [slave, master]: [usize; 2],
        pair_law: &PairLaw,
        project: &Projector,
        pieces: &mut Vec<BranchPiece>,
    ) {
        let off = |piece: &BranchPiece| piece.branch.is_subtracted() || piece.branch.kind == FootKind::Fold;
        if !self.may_be_ring(slave, master) || !pieces.iter().any(off) {
            return;
        }
        let curve = self.strands.curve_of(master);
        let reach = pair_law.reach[0].max(pair_law.reach[1]);
        let own = self.strands.cubic(slave);
        let farthest_of_all = |piece: &BranchPiece, fraction: f64| {
            let [t, other] = piece.along().map(|ends| ends[0] + (ends[1] - ends[0]) * fraction);
            let (touch, weight) = project(t, other, &piece.branch);
            let foot = own.point(touch.u) - touch.normal * touch.distance;
            let here = |(segment, v): (usize, f64)| match piece.branch.kind {
                FootKind::Held => segment == master && piece.branch.may_be_at(v),
                _ => (self.strands.cubic(segment).point(v) - foot).norm() <= COINCIDENT * reach,
            };
            weight < 0.0 && self.farthest(&own.point(touch.u), curve, reach).is_some_and(here)
        };
        let mut kept = Vec::new();
        for piece in pieces.iter() {
            if off(piece) {
                piece.parts_without(|fraction| farthest_of_all(piece, fraction), |part| kept.push(part));
            } else {
                kept.push(*piece);
            }
        }
        *pieces = kept;
    }

    /// Whether the master's curve could lie entirely within reach of a point of the slave.
    pub(super) fn may_be_ring(&self, slave: usize, master: usize) -> bool {
        let curve = self.strands.curve_of(master);
        self.strands.curves[curve].closed && curve != self.strands.curve_of(slave)
    }

    /// Segment and parameter of the point of a closed curve that is farthest from x (the first of equals); `None` if it
    /// is beyond the reach.
    fn farthest(&self, x: &Vec3, curve: usize, reach: f64) -> Option<(usize, f64)> {
        let strand = &self.strands.curves[curve];
        let segments = strand.first..strand.first + strand.count;
        if segments.clone().any(|k| (self.strands.ends(k).0 - x).norm() >= reach) {
            return None;
        }
        let mut points = Vec::new();
        for k in segments {
            let cubic = self.strands.cubic(k);
            let before = self.strands.prev(k).map(|k| self.strands.cubic(k));
            if before.is_some_and(|before| !smooth_joint(&before, &cubic, cubic.b[0].amax())) {
                points.push((k, 0.0, (cubic.b[0] - x).norm()));
            }
            let mut found = Roots::new();
            roots(&stationarity(&cubic, x), &mut found);
            points.extend(found.as_slice().iter().map(|&v| (k, v, (cubic.point(v) - x).norm())));
        }
        let farthest = points.iter().map(|p| p.2).fold(0.0, f64::max);
        let first = points.iter().find(|p| p.2 >= farthest - COINCIDENT * reach)?;
        (farthest < reach).then_some((first.0, first.1))
    }
}
