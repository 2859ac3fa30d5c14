//! From candidate pairs to terms of the contact potential: energy, gradient and symmetric Hessian with respect to the
//! control points of both cubics, and the zones for reports.
//!
//! ```text
//! U = Σ_ordered pairs w ∫_zone ± ½ κ ⟨c(s) − gap(s)⟩² ds        gap = |a(u) − b(v(u))| − ε_a − ε_b
//! ```
//!
//! Each strand integrates over its own length with its share w, ½ for equal strands; [`zones`](crate::contact::zones)
//! defines the parts with the sign −. With d the distance at the foot, n the unit normal from foot to slave point, w_m
//! the eight Bernstein weights (minus on the master): δd = n·Σ w_m δx_m (envelope theorem), and ∇²d = (I − n⊗n)/d on
//! w_m w_n minus q⊗q/d_vv, the Schur complement of the foot.

use crate::contact::curves::curve::{Cubic, CurveSet};
use crate::contact::curves::input::{CurveShape, Strands};
use crate::contact::law::Law;
use crate::contact::pairs::capsule::Capsule;
use crate::contact::projection::smooth_joint;
use crate::contact::tree::exclusion::Exclusion;
use crate::contact::zones::facing::Facing;
use crate::contact::zones::straight::Lines;
use crate::contact::zones::{BranchPiece, SegmentPair, SmoothJoint};
use crate::math::handles::Handles;
use crate::math::parallel::{CHEAP, DEAR};
use crate::math::{Vec3, parallel};
use integral::{PairIntegral, Projector};
pub use pressure::Offsets;
use pressure::PairLaw;
pub(crate) use pressure::Pressures;
pub use stiffness::Hessian;
use stiffness::{Coordinates, PairStiffness};
pub(crate) use term::{CandidateTerms, EndTerm, PairForce, Request};
pub use term::{ContactPair, PairTerm, Want, ZonePiece};

mod guess;
mod integral;
mod pressure;
mod rings;
pub(crate) mod second_order;
pub(crate) mod stiffness;
#[cfg(feature = "solver")]
pub(crate) mod surface;
mod term;

/// Terms of all candidate pairs in contact, with either segment as the slave, in the order of the candidates (slave i,
/// master j first).
///
/// `offset(slave, master)` is the offset c at both ends of a segment towards another one \[L\] (0 for a plain penalty);
/// it must be continuous where contact continues from one segment to the next, on either strand. Parallel over
/// candidates in the current rayon pool; the result does not depend on the number of threads.
pub fn evaluate(set: &CurveSet, candidates: &[[u32; 2]], law: Law, offset: &Offsets, want: Want) -> Vec<PairTerm> {
    evaluate_within(&ContactGeometry::of_set(set), candidates, &Pressures::of(law, offset), want)
}

/// The curves that terms are evaluated on.
pub(crate) struct ContactGeometry<'a> {
    strands: Strands<'a>,
    /// Reference length of each segment \[L\].
    lengths: &'a [f64],
    /// Capsule of each segment; empty if all curves are polylines.
    capsules: Vec<Capsule>,
    /// Whether the curve has a kink at the start of each segment; empty if all curves are polylines.
    kinked: Vec<bool>,
    /// Pairs excluded as neighbours, if the candidates leave these out.
    exclusion: Option<&'a Exclusion>,
    /// Remainders of the control points of each segment after rounding \[L\]; empty if they are not known.
    remainders: &'a [[Vec3; 4]],
    /// Bending stiffness of each curve \[F·L²\]; empty if they count as equal.
    bending: &'a [f64],
    /// Handles of each segment; empty if terms are wanted by control points alone.
    handles: Vec<Handles>,
}

impl<'a> ContactGeometry<'a> {
    /// The curves of a set.
    pub(crate) fn of_set(set: &'a CurveSet) -> Self {
        Self {
            remainders: &set.remainders,
            bending: &set.bending,
            ..Self::new(Strands::of_set(set), &set.lengths, None)
        }
    }

    /// The curves of a set, for terms by the ends of segments.
    pub(crate) fn by_ends(set: &'a CurveSet) -> Self {
        let mut geometry = Self::of_set(set);
        let handles = |k: usize| Handles::of(&geometry.near(k, &geometry.strands.ends(k).0).b);
        geometry.handles = parallel::map(set.segments.len(), CHEAP, &handles);
        geometry
    }

    /// Curves with the reference lengths of their segments \[L\], and the pairs excluded from the candidates.
    pub(crate) fn new(strands: Strands<'a>, lengths: &'a [f64], exclusion: Option<&'a Exclusion>) -> Self {
        let mut capsules = Vec::new();
        if strands.curves.iter().any(|c| matches!(c.shape, CurveShape::Cubics(_))) {
            let capsule = |k: usize| Capsule::new(&strands.cubic(k));
            capsules = parallel::map(strands.len(), CHEAP, &capsule);
        }
        let mut kinked = Vec::new();
        if !capsules.is_empty() {
            let kink = |k: usize| {
                let own = strands.cubic(k);
                let before = strands.prev(k).map(|before| strands.cubic(before));
                before.is_some_and(|before| !smooth_joint(&before, &own, own.b[0].amax()))
            };
            kinked = parallel::map(strands.len(), CHEAP, &kink);
        }
        Self { strands, lengths, capsules, kinked, exclusion, remainders: &[], bending: &[], handles: Vec::new() }
    }
}

/// [`evaluate`] for callers that evaluate the candidates in parts.
pub(crate) fn evaluate_within(
    geometry: &ContactGeometry,
    candidates: &[[u32; 2]],
    pressures: &Pressures,
    want: Want,
) -> Vec<PairTerm> {
    let chunks = in_chunks(candidates, PairSearch::new(pressures, true), |pair, search, out| {
        geometry.each(pair, search, |found| out.push(found.pair_term(want)));
    });
    chunks.into_iter().flatten().collect()
}

/// The terms of [`evaluate_within`] with respect to the segments' ends, chunk by chunk.
pub(crate) fn evaluate_ends(
    geometry: &ContactGeometry,
    candidates: &[[u32; 2]],
    pressures: &Pressures,
    request: Request,
) -> Vec<Vec<EndTerm>> {
    in_chunks(candidates, PairSearch::new(pressures, request.zones), |pair, search, out| {
        geometry.each(pair, search, |found| out.push(geometry.end_term(found, request, None)));
    })
}

/// The terms of some candidates with their second derivatives, in `out`, one for each.
pub(crate) fn evaluate_tangents(
    geometry: &ContactGeometry,
    candidates: &[[u32; 2]],
    pressures: &Pressures,
    out: &mut [CandidateTerms],
) {
    parallel::each_part(out, DEAR, &|first, part| {
        let mut search = PairSearch::new(pressures, false);
        for (k, terms) in part.iter_mut().enumerate() {
            geometry.candidate_terms(candidates[first + k].map(|k| k as usize), &mut search, terms);
        }
    });
}

/// A search for the contacts of pairs, one after the other.
#[derive(Clone)]
pub(crate) struct PairSearch<'a> {
    pressures: &'a Pressures<'a>,
    /// Whether pieces are given their nearest points.
    nearest: bool,
    /// Scratch.
    pieces: Vec<BranchPiece>,
}

impl<'a> PairSearch<'a> {
    pub(crate) fn new(pressures: &'a Pressures<'a>, nearest: bool) -> Self {
        Self { pressures, nearest, pieces: Vec::new() }
    }
}

/// Calls `add(pair, search, out)` for every pair; returns its output chunk by chunk, in the order of the pairs.
fn in_chunks<T: Send>(
    candidates: &[[u32; 2]],
    search: PairSearch,
    add: impl Fn([usize; 2], &mut PairSearch, &mut Vec<T>) + Sync,
) -> Vec<Vec<T>> {
    parallel::map_ranges(candidates.len(), DEAR, &|range| {
        let (mut found, mut search) = (Vec::new(), search.clone());
        candidates[range].iter().for_each(|pair| add(pair.map(|k| k as usize), &mut search, &mut found));
        found
    })
}

impl ContactGeometry<'_> {
    /// The contacts of one candidate pair, with either segment as the slave.
    fn each(&self, [i, j]: [usize; 2], search: &mut PairSearch, mut found: impl FnMut(&PairIntegral)) {
        let PairSearch { pressures, nearest, pieces } = search;
        let contact_distance = self.strands.radius_of(i) + self.strands.radius_of(j);
        let distance = self.nearest(i, j);
        if distance >= contact_distance + pressures.largest_offset {
            return;
        }
        for (slave, master) in [(i, j), (j, i)] {
            let reach = pressures.reach(slave, master, contact_distance);
            if distance >= reach[0].max(reach[1]) {
                continue;
            }
            let pair_law = self.pair_law([slave, master], reach, pressures);
            pieces.clear();
            let mut collect = |project: &Projector, pieces: &mut Vec<BranchPiece>| {
                self.keep_rings([slave, master], &pair_law, project, pieces);
                if !pieces.is_empty() {
                    let own = self.near(slave, &self.strands.ends(slave).0);
                    found(&PairIntegral { slave, master, pair_law: &pair_law, pieces, project, own });
                }
            };
            if let Some(lines) = self.lines(slave, master, &pair_law) {
                lines.pieces(|piece| pieces.push(piece));
                collect(&|u, _, branch| lines.project(u, branch), pieces);
                continue;
            }
            self.with_pair(slave, master, pair_law.reach, |pair, facing| match facing {
                Some(facing) if facing.pieces(pair, *nearest, pieces) => {
                    collect(&|u, guess, _| (facing.project(pair, u, guess), 1.0), pieces);
                }
                _ => {
                    pair.pieces(pieces);
                    collect(&|t, guess, branch| pair.project(t, guess, branch), pieces);
                }
            });
        }
    }

    /// A segment relative to a point.
    fn near(&self, segment: usize, origin: &Vec3) -> Cubic {
        let mut cubic = self.strands.cubic(segment).relative_to(origin);
        if let Some(lost) = self.remainders.get(segment) {
            cubic.b.iter_mut().zip(lost).for_each(|(point, lost)| *point += lost);
        }
        cubic
    }

    fn end_term(&self, found: &PairIntegral, request: Request, stiffness: Option<&mut PairStiffness>) -> EndTerm {
        let coordinates = self.coordinates([found.slave, found.master]);
        let term = found.sum(request, stiffness);
        EndTerm { energy: term.energy, gradient: coordinates.pull(&term.gradient), pair: term.into() }
    }

    /// The ends of two segments.
    fn coordinates(&self, segments: [usize; 2]) -> Coordinates {
        Coordinates::Ends(segments.map(|k| self.handles[k]))
    }

    /// The terms of a pair with their second derivative.
    fn candidate_terms(&self, pair: [usize; 2], search: &mut PairSearch, out: &mut CandidateTerms) {
        let CandidateTerms { terms, tangent } = out;
        *terms = [None, None];
        let (mut unused, mut stiffness) = (Some(tangent), None);
        let request = Request { zones: false, tangent: true };
        self.each(pair, search, |found| {
            let swapped = found.slave != pair[0];
            if let Some(tangent) = unused.take() {
                stiffness = Some(PairStiffness::new(self.coordinates(pair), tangent));
            }
            stiffness.iter_mut().for_each(|stiffness| stiffness.swap(swapped));
            terms[usize::from(swapped)] = Some(self.end_term(found, request, stiffness.as_mut()));
        });
        if let Some(stiffness) = stiffness {
            stiffness.finish();
        }
    }

    /// The sum of the terms of one candidate pair, without the terms.
    pub(crate) fn force(&self, [i, j]: [usize; 2], search: &mut PairSearch) -> PairForce {
        let mut sum = PairForce::NONE;
        if !(self.strands.is_straight(i) && self.strands.is_straight(j)) {
            self.each([i, j], search, |found| {
                sum.add_term(&self.strands, &found.pair_term(Want::Gradient), found.slave != i);
            });
            return sum;
        }
        let PairSearch { pressures, pieces, .. } = search;
        let contact_distance = self.strands.radius_of(i) + self.strands.radius_of(j);
        for (slave, master) in [(i, j), (j, i)] {
            let reach = pressures.reach(slave, master, contact_distance);
            if reach[0].max(reach[1]) <= 0.0 {
                continue;
            }
            let pair_law = self.pair_law([slave, master], reach, pressures);
            let Some(lines) = self.lines(slave, master, &pair_law) else { continue };
            if !self.may_be_ring(slave, master) {
                lines.pieces(|piece| sum.add_lines(&lines, &piece, &pair_law, slave != i));
                continue;
            }
            pieces.clear();
            lines.pieces(|piece| pieces.push(piece));
            self.keep_rings([slave, master], &pair_law, &|u, _, branch| lines.project(u, branch), pieces);
            pieces.iter().for_each(|piece| sum.add_lines(&lines, piece, &pair_law, slave != i));
        }
        sum
    }

    /// Lower bound of the distance \[L\]; 0 for straight segments, whose intervals cost less than the bound.
    fn nearest(&self, i: usize, j: usize) -> f64 {
        if self.capsules.is_empty() { 0.0 } else { self.capsules[i].distance_lower_bound(&self.capsules[j]) }
    }

    /// The law along the slave.
    fn pair_law<'a>(&self, [slave, master]: [usize; 2], reach: [f64; 2], pressures: &'a Pressures<'a>) -> PairLaw<'a> {
        let contact_distance = self.strands.radius_of(slave) + self.strands.radius_of(master);
        let (length, offset) = (self.lengths[slave], (pressures.offset)(slave, master));
        let straight = self.strands.is_straight(slave) && self.strands.is_straight(master);
        let span = if straight {
            let (start, end) = self.strands.ends(slave);
            (end - start).norm()
        } else {
            length
        };
        PairLaw { share: self.share(slave, master), pressures, contact_distance, reach, offset, length, straight, span }
    }

    /// The share of a pair's contact that is integrated along the slave: its part of both compliances. Along the stiff
    /// one of a pair the integral loses its second derivative where the soft one winds about it, because the centre of
    /// curvature of the soft one then lies on the stiff one. Powers of ten, so that equal strands share alike to the
    /// last bit and derivatives by a stiffness do not see it.
    fn share(&self, slave: usize, master: usize) -> f64 {
        let bending = |segment: usize| self.bending.get(self.strands.curve_of(segment)).copied().unwrap_or(1.0);
        let (own, other) = (bending(slave), bending(master));
        if own == other { 0.5 } else { 1.0 / (1.0 + 10f64.powf((own / other).log10().round())) }
    }

    /// The pair as lines, if both are straight and the reach does not vary along the slave.
    fn lines(&self, slave: usize, master: usize, pair_law: &PairLaw) -> Option<Lines> {
        let lines = pair_law.straight && pair_law.reach[0] == pair_law.reach[1];
        lines.then(|| Lines::new(&self.strands, slave, master, pair_law.reach[0], self.kinks(slave, master)))
    }

    /// The ends of the master whose kink this pair counts: the start, and the end if the next segment is excluded as a
    /// neighbour of the slave.
    fn kinks(&self, slave: usize, master: usize) -> [bool; 2] {
        let left_out = |next: usize| self.exclusion.is_some_and(|e| !wanted(&self.strands, e, [slave, next]));
        [true, self.strands.next(master).is_some_and(left_out)]
    }

    /// Calls `with` for the pair as cubics near the origin, because far from it rounding would hide the ends of zones.
    /// [`Facing`] is passed if the pair is shown to have one foot for each slave point; a pair shown to have no foot is
    /// skipped. All masters use the same origin, so that two that meet at a joint compute the same bits there.
    fn with_pair(
        &self,
        slave: usize,
        master: usize,
        reach: [f64; 2],
        with: impl FnOnce(&SegmentPair, Option<&Facing>),
    ) {
        let origin = self.strands.ends(slave).0;
        let near = |k: usize| self.near(k, &origin);
        let (own, foreign) = (near(slave), near(master));
        let beyond = [self.strands.prev(master), self.strands.next(master)];
        let goes_on = beyond.map(|k| k.is_some());
        let counted = self.kinks(slave, master);
        let kinked = [master, beyond[1].unwrap_or(master)].map(|k| self.kinked.get(k) != Some(&false));
        let counted: [bool; 2] = std::array::from_fn(|k| goes_on[k] && kinked[k] && counted[k]);
        let facing = Facing::new(&own, &foreign);
        if facing.as_ref().is_some_and(|facing| (0..2).any(|k| goes_on[k] && !counted[k] && facing.misses()[k])) {
            return;
        }
        let [before, after] = beyond.map(|k| k.map(near));
        let joints = SmoothJoint::both(before, &foreign, after, &origin);
        let tangents = [before.map(|before| before.end_tangent()), after.map(|after| after.start_tangent())];
        let pair = SegmentPair {
            slave: &own,
            master: &foreign,
            open_start: !goes_on[0],
            open_end: !goes_on[1],
            reach,
            joints,
            kinks: std::array::from_fn(|k| tangents[k].filter(|_| counted[k] && joints[k].is_none())),
        };
        with(&pair, facing.as_ref().filter(|_| goes_on == [true; 2] && counted == [false; 2]));
    }
}

/// Whether a pair is not one of neighbours along a curve.
pub(crate) fn wanted(strands: &Strands, exclusion: &Exclusion, [i, j]: [usize; 2]) -> bool {
    !exclusion.excluded(i, j) && !strands.adjacent(i, j)
}

#[cfg(test)]
mod fold_tests;
#[cfg(test)]
mod tests;
