//! Which contacts a state has: strands touch in pieces, segment by segment and seen from both strands. Those that meet
//! are one contact; under an augmented Lagrangian also contacts that its offsets do not resolve.

use crate::contact::arc::{self, ascending};
use crate::contact::chain::{ChainPiece, pieces};
use crate::contact::curve::CurveSet;
use crate::math::groups::Groups;
use crate::solve::load_step::solver::Solver;
use crate::solve::problem::engine::Engine;

/// Distance along the rods, over the contact radius, within which two sites are one contact, because a foot is known no
/// better where the distance hardly changes along it.
const REACH: f64 = 0.01;

/// Arcs on two strands, each with its curve; ends ascending \[L\].
#[derive(Debug, Clone, Copy)]
struct ArcPair {
    curves: [usize; 2],
    arcs: [[f64; 2]; 2],
}

/// The contacts of a state.
#[derive(Debug, Clone, Default)]
pub(super) struct LabelledContacts {
    /// Pieces with the contact that each belongs to.
    places: Vec<(ArcPair, usize)>,
    /// Candidate pairs with the contact that each belongs to (the last, if several do).
    pairs: Vec<([u32; 2], usize)>,
    count: usize,
}

impl LabelledContacts {
    /// Of the engine's state, for which contact must be up to date.
    pub(super) fn of(solver: &Solver) -> Self {
        let engine = &solver.engine;
        let side = &engine.contact;
        if side.broad_phase.pairs().is_empty() {
            return Self::default();
        }
        let terms = engine.residual(engine.state()).contact_pairs;
        // a foot is known no better where the distance hardly changes along it
        let (mut places, mut pairs, mut reach) = (Vec::new(), Vec::new(), REACH * side.min_radius);
        let augments = solver.augments();
        for term in &terms {
            if augments {
                reach = reach.max(solver.window(side, term.slave, Some(term.master)));
            }
            let ends = [term.slave as u32, term.master as u32];
            for ChainPiece { curves, arcs, .. } in pieces(&side.set, term) {
                places.push(ArcPair { curves, arcs: arcs.map(ascending) });
                pairs.push([ends[0].min(ends[1]), ends[0].max(ends[1])]);
            }
        }
        let groups = groups(&side.set, &places, reach);
        let count = groups.iter().max().map_or(0, |last| last + 1);
        let places = places.into_iter().zip(groups.iter().copied()).collect();
        let pairs = pairs.into_iter().zip(groups).collect();
        Self { places, pairs, count }
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// For each contact whether `others` have one that comes within `reach` \[L\] of it on both strands.
    pub(super) fn found_among(&self, others: &Self, set: &CurveSet, reach: f64) -> Vec<bool> {
        let mut found = vec![false; self.count];
        for (place, contact) in &self.places {
            let meets = |(other, _): &(ArcPair, usize)| {
                near(set, place, other, reach) || near(set, place, &transposed(other), reach)
            };
            found[*contact] = found[*contact] || others.places.iter().any(meets);
        }
        found
    }

    /// The chosen contacts alone.
    pub(super) fn only(&self, chosen: &[bool]) -> Self {
        let places = self.places.iter().filter(|(_, contact)| chosen[*contact]).copied().collect();
        let pairs = self.pairs.iter().filter(|(_, contact)| chosen[*contact]).copied().collect();
        Self { places, pairs, count: self.count }
    }

    /// Gradient of the contact potential, of the chosen contacts only, in the state that these are of.
    pub(super) fn gradient(&self, engine: &Engine, chosen: &[bool]) -> Vec<f64> {
        let mut out = vec![0.0; 6 * engine.num_nodes()];
        let mut pairs: Vec<[u32; 2]> = self.pairs.iter().filter(|(_, contact)| chosen[*contact]).map(|p| p.0).collect();
        pairs.sort_unstable();
        pairs.dedup();
        engine.add_contact_of(&pairs, |_| true, &mut out);
        out
    }
}

fn transposed(place: &ArcPair) -> ArcPair {
    let ([a, b], [x, y]) = (place.curves, place.arcs);
    ArcPair { curves: [b, a], arcs: [y, x] }
}

/// Whether two places come within `reach` of each other on both strands, taken in their order.
fn near(set: &CurveSet, x: &ArcPair, y: &ArcPair, reach: f64) -> bool {
    let close = |k: usize| arc::apart(x.arcs[k], y.arcs[k], set.period(x.curves[k])) <= reach;
    x.curves == y.curves && close(0) && close(1)
}

/// Numbers of the groups of places that are connected by steps of no more than `reach`, counted from 0.
fn groups(set: &CurveSet, places: &[ArcPair], reach: f64) -> Vec<usize> {
    // along their first strand, seen both ways round; closed strands go on beyond their seam by as much as can matter
    let longest = places.iter().flat_map(|p| p.arcs).map(|arc| arc[1] - arc[0]).fold(0.0, f64::max) + reach;
    let mut along: Vec<(ArcPair, usize)> = Vec::new();
    for (index, place) in places.iter().enumerate() {
        for seen in [*place, transposed(place)] {
            along.push((seen, index));
            if let Some(period) = set.period(seen.curves[0]).filter(|_| seen.arcs[0][0] <= longest) {
                let arcs = [seen.arcs[0].map(|s| s + period), seen.arcs[1]];
                along.push((ArcPair { arcs, ..seen }, index));
            }
        }
    }
    along.sort_by(|x, y| x.0.curves.cmp(&y.0.curves).then(x.0.arcs[0][0].total_cmp(&y.0.arcs[0][0])));
    let mut scratch = Vec::new();
    let mut groups = Groups::apart(places.len(), &mut scratch);
    for (k, (place, index)) in along.iter().enumerate() {
        let end = place.arcs[0][1] + reach;
        let in_reach = |other: &&(ArcPair, usize)| other.0.curves == place.curves && other.0.arcs[0][0] <= end;
        for (other, partner) in along[k + 1..].iter().take_while(in_reach) {
            if near(set, place, other, reach) {
                groups.join(*index, *partner);
            }
        }
    }
    let mut numbers = vec![0; places.len()];
    let mut count = 0;
    for index in 0..places.len() {
        let first = groups.first(index);
        if first == index {
            numbers[index] = count;
            count += 1;
        } else {
            numbers[index] = numbers[first];
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// A closed and an open strand, ten segments of length 1 each.
    fn strands() -> CurveSet {
        let points: Vec<Vec3> = (0..=10).map(|k| Vec3::x() * f64::from(k)).collect();
        let [closed, open] = [(&points[..10], true), (&points[..], false)];
        let mut set = CurveSet::from_polylines(&[(closed.0, 0.1, closed.1), (open.0, 0.1, open.1)]).unwrap();
        set.set_lengths(&[1.0; 20]);
        set
    }

    fn place(curves: [usize; 2], arcs: [[f64; 2]; 2]) -> ArcPair {
        ArcPair { curves, arcs }
    }

    /// Groups against all pairs; over the seam, from both strands, within reach and not beyond it.
    #[test]
    fn what_meets_is_one_contact() {
        let set = strands();
        let places = [
            place([0, 0], [[9.8, 10.0], [4.0, 4.2]]), // goes on over the seam in the next
            place([0, 0], [[0.0, 0.3], [3.8, 4.0]]),
            place([0, 0], [[3.9, 4.1], [9.9, 10.0]]), // the same seen from the other side
            place([0, 0], [[0.45, 0.5], [3.7, 3.75]]), // beyond reach
            place([0, 1], [[0.0, 0.3], [3.8, 4.0]]),  // another strand
            place([1, 0], [[0.1, 0.2], [9.9, 10.0]]), // an open strand has no seam
            place([1, 0], [[9.9, 10.0], [0.0, 0.1]]),
        ];
        assert_eq!(groups(&set, &places, 0.1), [0, 0, 0, 1, 2, 3, 4]);
        assert_eq!(groups(&set, &places, 0.2), [0, 0, 0, 0, 1, 2, 3]);
        assert_eq!(groups(&set, &[], 0.1), [0usize; 0]);
    }

    #[test]
    fn contacts_are_found_again() {
        let set = strands();
        let contacts = |places: &[ArcPair]| {
            let numbered = places.iter().copied().zip(groups(&set, places, 0.01));
            let pairs = vec![([0, 1], 0)];
            LabelledContacts { places: numbered.collect(), pairs, count: places.len() }
        };
        let some = contacts(&[place([0, 0], [[1.0, 1.1], [5.0, 5.1]]), place([0, 1], [[1.0, 1.1], [5.0, 5.1]])]);
        let moved = contacts(&[place([0, 0], [[5.15, 5.2], [1.05, 1.2]])]);
        assert_eq!(some.found_among(&moved, &set, 0.1), [true, false]);
        assert_eq!(some.found_among(&moved, &set, 0.01), [false, false]);
        assert_eq!(some.only(&[false, true]).found_among(&some, &set, 0.0), [false, true]);
    }
}
