//! Chains of pieces of contact zones: one contact as seen from one strand.
//!
//! Zones are cut at the joints of segments of either strand. Pieces belong together if they are consecutive along the
//! slave and their feet along the master.

use crate::contact::curves::arc::near;
use crate::contact::curves::curve::CurveSet;
use crate::contact::law::potential::{ContactPair, ZonePiece};
use crate::contact::measures::COINCIDENT;

/// Largest distance of the feet of the ends of consecutive pieces on the master, over the contact distance, because
/// feet are less accurate than the ends where the distance hardly changes along the master.
pub(crate) const TOL_FOOT: f64 = 1e-2;

/// A piece with its place on both strands, the slave's first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChainPiece<'a> {
    pub(crate) segments: [usize; 2],
    pub(crate) curves: [usize; 2],
    /// Arc lengths of both ends \[L\], ascending on the slave; then of their feet, descending where the strands run in
    /// opposite directions.
    pub(crate) arcs: [[f64; 2]; 2],
    pub(crate) zone: &'a ZonePiece,
}

impl ChainPiece<'_> {
    /// Whether it consists of farthest points, which the potential subtracts, or of a fold of which the farthest points
    /// carry nearly as much as the nearest or more: then little is left of the force, and the resultant is larger than
    /// that.
    fn is_subtracted(&self) -> bool {
        self.zone.piece.branch.is_subtracted() || self.zone.push.norm() > 2.0 * self.zone.force
    }
}

/// All contacts as seen from either strand, each a chain of pieces in the order of the slave's arc length, without
/// subtracted pieces.
pub(crate) fn chains<'a>(set: &'a CurveSet, terms: &'a [ContactPair]) -> Vec<Vec<ChainPiece<'a>>> {
    let links = links(set, terms);
    let next = successors(set, &links);
    let mut follows = vec![false; links.len()];
    next.iter().flatten().for_each(|&j| follows[j] = true);
    let mut used = vec![false; links.len()];
    let mut chains = Vec::new();
    // open chains from their first piece, then the rest: zones all round a closed strand
    let starts = (0..links.len()).filter(|&i| !follows[i]).chain((0..links.len()).filter(|&i| follows[i]));
    for start in starts {
        let mut chain = Vec::new();
        let mut last = Some(start);
        while let Some(piece) = last.filter(|&j| !used[j]) {
            used[piece] = true;
            chain.push(links[piece]);
            last = next[piece];
        }
        if !chain.is_empty() {
            chains.push(chain);
        }
    }
    chains
}

/// The pieces of one pair, without subtracted ones.
pub(crate) fn pieces<'a>(set: &'a CurveSet, term: &'a ContactPair) -> impl Iterator<Item = ChainPiece<'a>> {
    placed(set, term).filter(|piece| !piece.is_subtracted())
}

/// The pieces that the potential subtracts.
pub(crate) fn subtracted<'a>(set: &'a CurveSet, terms: &'a [ContactPair]) -> impl Iterator<Item = ChainPiece<'a>> {
    terms.iter().flat_map(|term| placed(set, term)).filter(ChainPiece::is_subtracted)
}

fn placed<'a>(set: &'a CurveSet, term: &'a ContactPair) -> impl Iterator<Item = ChainPiece<'a>> {
    let segments = [term.slave, term.master];
    term.zones.iter().map(move |zone| {
        let arcs = [(term.slave, zone.piece.u), (term.master, zone.piece.v)];
        let arcs = arcs.map(|(segment, ends)| ends.map(|u| set.arc_length(segment, u)));
        ChainPiece { segments, curves: segments.map(|k| set.curve_of(k)), arcs, zone }
    })
}

fn links<'a>(set: &'a CurveSet, terms: &'a [ContactPair]) -> Vec<ChainPiece<'a>> {
    let mut links: Vec<ChainPiece> = terms.iter().flat_map(|term| pieces(set, term)).collect();
    let place = |x: &ChainPiece| [x.arcs[0][0], x.arcs[1][0]];
    links.sort_by(|x, y| {
        let ([a, b], [c, d]) = (place(x), place(y));
        x.curves.cmp(&y.curves).then(a.total_cmp(&c)).then(b.total_cmp(&d))
    });
    links
}

/// For each piece the next one of its chain.
fn successors(set: &CurveSet, links: &[ChainPiece]) -> Vec<Option<usize>> {
    let mut taken = vec![false; links.len()];
    let mut successors = Vec::with_capacity(links.len());
    let mut first = 0;
    for same in links.chunk_by(|x, y| x.curves == y.curves) {
        for link in same {
            let distance = link.segments.map(|k| set.radius_of(k)).iter().sum::<f64>();
            let (tol_arc, tol_foot) = (COINCIDENT * distance, TOL_FOOT * distance);
            let [period_a, period_b] = link.curves.map(|curve| set.period(curve));
            let mut best: Option<(f64, usize)> = None;
            for shift in [Some(0.0), period_a].into_iter().flatten() {
                let end = link.arcs[0][1] - shift;
                let from = same.partition_point(|x| x.arcs[0][0] < end - tol_arc);
                let meets = |x: &&ChainPiece| x.arcs[0][0] <= end + tol_arc;
                for (k, other) in same[from..].iter().take_while(meets).enumerate() {
                    let jump = (near(other.arcs[1][0], link.arcs[1][1], period_b) - link.arcs[1][1]).abs();
                    let index = first + from + k;
                    if jump <= tol_foot && !taken[index] && best.is_none_or(|(least, _)| jump < least) {
                        best = Some((jump, index));
                    }
                }
            }
            if let Some((_, j)) = best {
                taken[j] = true;
            }
            successors.push(best.map(|(_, j)| j));
        }
        first += same.len();
    }
    successors
}
