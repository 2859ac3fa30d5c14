//! From candidate pairs to terms of the contact potential: energy, gradient and symmetric Hessian with respect to the
//! control points of both cubics, and the zones for reports.
//!
//! ```text
//! U = Σ_ordered pairs ½ ∫_zone ± ½ κ ⟨c(s) − gap(s)⟩² ds        gap = |a(u) − b(v(u))| − ε_a − ε_b
//! ```
//!
//! Each strand integrates over its own length with factor ½; what is counted off (−) tells [`zone`](super::zone). With d the distance at the foot, n the
//! unit normal from foot to slave point, w_m the eight Bernstein weights (minus on the master):
//! δd = n·Σ w_m δx_m (envelope theorem), and ∇²d = (I − n⊗n)/d on w_m w_n minus q⊗q/d_vv, the Schur complement of the foot.

use rayon::prelude::*;

use super::capsule::Capsule;
use super::curve::{Cubic, CurveSet};
use super::exclusion::Exclusion;
use super::input::{Shape, Strands};
use super::law::{Law, Response};
use super::projection::{smooth_joint, stationarity};
use super::zone::facing::Facing;
use super::zone::straight::Lines;
use super::zone::{Branch, FootKind, Joint, Pair, Piece, Touch};
use crate::math::bernstein::{Roots, roots};
use crate::math::quadrature::gauss;
use crate::math::{Mat3, Vec3};
use guess::Interpolation;
use stiffness::{Blocks, Coordinates, Stiffness};
use surprise::Touched;

mod guess;
pub(crate) mod stiffness;
pub(crate) mod surprise;

/// Points of the Gauss rule on each piece of a zone.
const POINTS_PER_PIECE: usize = 5;
/// Distances that differ relatively by less are the same.
const TIE: f64 = 1e-9;
/// Points that differ by less of the reach are the same.
const SAME: f64 = 1e-6;
/// Longest pieces of straight pairs, in contact distances, that fewer points integrate as well: polylines have many.
const FEWER_POINTS: [(f64, usize); 2] = [(1.0 / 32.0, 2), (0.25, 3)];
/// Parts that a piece through a fold is divided into: there and back on the slave.
const PARTS_OF_FOLD: f64 = 4.0;

/// Hessian with respect to eight control points (slave 0..4, master 4..8): blocks m ≤ n filled.
pub type Hessian = [[Mat3; 8]; 8];

/// One piece of a contact zone, for reports and multiplier updates.
#[derive(Debug, Clone, Copy)]
pub struct ZonePiece {
    /// Geometry of the piece.
    pub piece: Piece,
    /// Smallest gap inside \[L\].
    pub min_gap: f64,
    /// ½∫p ds \[F\]: this strand's half of the contact force; negative where it is counted off.
    pub half_force: f64,
    /// ½∫p u ds and ½∫p u² ds \[F\], u the slave parameter: where in the piece the force sits.
    pub half_moments: [f64; 2],
}

/// Contribution of one ordered pair (slave, master) that is in contact.
#[derive(Debug, Clone)]
pub struct PairTerm {
    /// Slave segment.
    pub slave: usize,
    /// Master segment.
    pub master: usize,
    /// Energy \[F·L\].
    pub energy: f64,
    /// ∂U/∂(control points): slave's four, master's four \[F\].
    pub gradient: [Vec3; 8],
    /// Symmetric Hessian \[F/L\]; empty unless asked for.
    pub hessian: Option<Box<Hessian>>,
    /// Zones of this pair.
    pub zones: Vec<ZonePiece>,
    /// Points in contact, if the solver asks for the tangent.
    pub(crate) touched: Vec<Touched>,
}

impl PairTerm {
    /// The gradient with respect to the ends of two *straight* segments: slave's start and end, master's start and end \[F\].
    #[must_use]
    pub fn point_gradient(&self) -> [Vec3; 4] {
        let ends = |g: &[Vec3]| [g[0] + (g[1] * 2.0 + g[2]) / 3.0, (g[1] + g[2] * 2.0) / 3.0 + g[3]];
        let ([a0, a1], [b0, b1]) = (ends(&self.gradient[..4]), ends(&self.gradient[4..]));
        [a0, a1, b0, b1]
    }

    /// The Hessian with respect to the ends of two *straight* segments, in the order of [`PairTerm::point_gradient`]: all 16 blocks \[F/L\]; zero
    /// if it was not asked for.
    #[must_use]
    pub fn point_hessian(&self) -> [[Mat3; 4]; 4] {
        // Parts that the ends have in the control points of a straight segment.
        const PARTS: [[f64; 4]; 2] = [[1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0], [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]];
        let mut sum = [[Mat3::zeros(); 4]; 4];
        let Some(hessian) = &self.hessian else { return sum };
        for (m, n) in (0..8).flat_map(|m| (0..8).map(move |n| (m, n))) {
            let block = if m <= n { hessian[m][n] } else { hessian[n][m].transpose() };
            for (p, q) in (0..2).flat_map(|p| (0..2).map(move |q| (p, q))) {
                sum[p + 2 * (m / 4)][q + 2 * (n / 4)] += block * (PARTS[p][m % 4] * PARTS[q][n % 4]);
            }
        }
        sum
    }
}

/// What [`evaluate`] computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Want {
    /// Energy, gradient, zones.
    Gradient,
    /// Also the Hessian.
    Hessian,
}

/// Offsets c at both ends of a segment (the first, the slave), towards another one \[L\].
pub type Offsets<'a> = dyn Fn(usize, usize) -> [f64; 2] + Sync + 'a;

/// What decides over pressures.
#[derive(Clone, Copy)]
pub(crate) struct Pressures<'a> {
    pub(crate) law: Law,
    pub(crate) offset: &'a Offsets<'a>,
    /// The law that the present pressures come from, if it has just been replaced: they are kept, and linearised is the new law about
    /// the overlap at which it has the same pressure. A Newton step then moves the strands there.
    pub(crate) before: Option<(Law, &'a Offsets<'a>)>,
}

impl Pressures<'_> {
    /// Where pressure ends, at both ends of a segment, from another one's centreline \[L\].
    fn reach(&self, slave: usize, master: usize, contact_distance: f64) -> [f64; 2] {
        let offset = self.before.map_or(self.offset, |(_, offset)| offset);
        offset(slave, master).map(|c| contact_distance + c)
    }
}

/// Terms of all candidate pairs in contact, both ways round, in the order of the candidates (slave i, master j first).
///
/// `offset(slave, master)` is the offset c at both ends of a segment towards another one \[L\] (0 for a plain penalty); where contact goes on from one
/// segment to the next, on either strand, it is to do so too. Parallel over candidates in the current rayon
/// pool; the result does not depend on the number of threads.
pub fn evaluate(set: &CurveSet, candidates: &[[u32; 2]], law: Law, offset: &Offsets, want: Want) -> Vec<PairTerm> {
    evaluate_within(&Ground::of_set(set), candidates, &Pressures { law, offset, before: None }, want)
}

/// The curves that terms are evaluated on.
pub(crate) struct Ground<'a> {
    strands: Strands<'a>,
    /// Reference length of each segment \[L\].
    lengths: &'a [f64],
    /// Capsule of each segment; none if all curves are polylines.
    capsules: Vec<Capsule>,
    /// Whether the curve has a kink at the start of each segment; none if all curves are polylines.
    kinked: Vec<bool>,
    /// Which pairs are left out as neighbours, if the candidates are those that are not.
    exclusion: Option<&'a Exclusion>,
    /// What rounding took from the control points of each segment \[L\]; none if nothing is known of that.
    remainders: &'a [[Vec3; 4]],
}

impl<'a> Ground<'a> {
    /// The curves of a set.
    pub(crate) fn of_set(set: &'a CurveSet) -> Self {
        Self { remainders: &set.remainders, ..Self::new(Strands::of_set(set), &set.lengths, None) }
    }

    /// Curves with the reference lengths of their segments \[L\], and the neighbours that are not among the candidates.
    pub(crate) fn new(strands: Strands<'a>, lengths: &'a [f64], exclusion: Option<&'a Exclusion>) -> Self {
        let mut capsules = Vec::new();
        if strands.curves.iter().any(|c| matches!(c.shape, Shape::Cubics(_))) {
            let capsule = |k: usize| Capsule::new(&strands.cubic(k));
            (0..strands.len()).into_par_iter().with_min_len(256).map(capsule).collect_into_vec(&mut capsules);
        }
        let mut kinked = Vec::new();
        if !capsules.is_empty() {
            let kink = |k: usize| {
                let own = strands.cubic(k);
                let before = strands.prev(k).map(|before| strands.cubic(before));
                before.is_some_and(|before| !smooth_joint(&before, &own, own.b[0].amax()))
            };
            (0..strands.len()).into_par_iter().with_min_len(256).map(kink).collect_into_vec(&mut kinked);
        }
        Self { strands, lengths, capsules, kinked, exclusion, remainders: &[] }
    }
}

/// [`evaluate`] for callers that go through the candidates in parts.
pub(crate) fn evaluate_within(
    ground: &Ground,
    candidates: &[[u32; 2]],
    pressures: &Pressures,
    want: Want,
) -> Vec<PairTerm> {
    let add =
        |pair, pieces: &mut _, out: &mut Vec<_>| ground.terms(pair, pressures, want, pieces, |term| out.push(term));
    in_chunks(candidates, add).into_iter().flatten().collect()
}

/// Where one ordered pair (slave, master) is in contact: what is kept of its term once that is summed.
#[derive(Debug, Clone)]
pub struct Meeting {
    /// Slave segment.
    pub slave: usize,
    /// Master segment.
    pub master: usize,
    /// Zones of this pair; none unless asked for.
    pub zones: Box<[ZonePiece]>,
    /// Points in contact; none unless the tangent was asked for.
    pub(crate) touched: Box<[Touched]>,
}

impl From<PairTerm> for Meeting {
    fn from(PairTerm { slave, master, zones, touched, .. }: PairTerm) -> Self {
        Self { slave, master, zones: zones.into(), touched: touched.into() }
    }
}

/// A term with respect to the ends of both segments, of which the control points next to them are turning handles: six coordinates each (displacement,
/// rotation vector), slave's start and end, master's start and end.
pub(crate) struct EndTerm {
    pub(crate) meeting: Meeting,
    /// Energy \[F·L\].
    pub(crate) energy: f64,
    pub(crate) gradient: [f64; 24],
    /// Second derivative; none unless asked for.
    pub(crate) tangent: Option<Box<Blocks>>,
}

/// What is computed besides energy and gradient.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Besides {
    pub(crate) tangent: bool,
    pub(crate) zones: bool,
}

/// The terms of [`evaluate_within`] with respect to the segments' ends, in parts: they are large, and moved no more than need be.
pub(crate) fn evaluate_ends(
    ground: &Ground,
    candidates: &[[u32; 2]],
    pressures: &Pressures,
    besides: Besides,
) -> Vec<Vec<EndTerm>> {
    in_chunks(candidates, |pair, pieces, out| {
        ground.each(pair, pressures, besides.zones, pieces, |found| out.push(ground.end_term(found, besides)));
    })
}

/// Calls `add(pair, scratch, out)` for every pair; what is put out, in the order of the pairs, in parts.
fn in_chunks<T: Send>(
    candidates: &[[u32; 2]],
    add: impl Fn([usize; 2], &mut Vec<Piece>, &mut Vec<T>) + Sync,
) -> Vec<Vec<T>> {
    const CHUNK: usize = 64;
    let chunk = |chunk: &[[u32; 2]]| {
        let (mut found, mut pieces) = (Vec::new(), Vec::new());
        chunk.iter().for_each(|pair| add(pair.map(|k| k as usize), &mut pieces, &mut found));
        found
    };
    candidates.par_chunks(CHUNK).map(chunk).collect()
}

/// What one candidate pair does to the control points of both segments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairForce {
    /// Energy \[F·L\], both ways round.
    pub(crate) energy: f64,
    /// Smallest gap \[L\]; infinite if the pair is not in contact.
    pub(crate) min_gap: f64,
    /// −∂U/∂(control points) of i and of j \[F\]; of a straight segment its two ends, in the first and last place.
    pub(crate) force: [[Vec3; 4]; 2],
}

impl PairForce {
    pub(crate) const NONE: Self =
        Self { energy: 0.0, min_gap: f64::INFINITY, force: [[Vec3::new(0.0, 0.0, 0.0); 4]; 2] };
}

/// Where one ordered pair is in contact.
struct Found<'a> {
    slave: usize,
    master: usize,
    local: &'a Local<'a>,
    pieces: &'a [Piece],
    touch: &'a Follow<'a>,
}

/// The geometry of a branch at the parameter it is followed by, from a guess of the other, and by what the slave's parameter changes with that: less than
/// nothing where it is counted off.
type Follow<'a> = dyn Fn(f64, f64, &Branch) -> (Touch, f64) + 'a;

impl Ground<'_> {
    /// The terms of one candidate pair, either way round. `pieces` is scratch.
    fn terms(
        &self,
        pair: [usize; 2],
        pressures: &Pressures,
        want: Want,
        pieces: &mut Vec<Piece>,
        mut found: impl FnMut(PairTerm),
    ) {
        self.each(pair, pressures, true, pieces, |place| found(place.pair_term(want)));
    }

    /// The contacts of one candidate pair, either way round. `pieces` is scratch; where they are nearest they tell only if that is asked for.
    fn each(
        &self,
        [i, j]: [usize; 2],
        pressures: &Pressures,
        nearest: bool,
        pieces: &mut Vec<Piece>,
        mut found: impl FnMut(&Found),
    ) {
        let contact_distance = self.strands.radius_of(i) + self.strands.radius_of(j);
        let distance = self.nearest(i, j);
        for (slave, master) in [(i, j), (j, i)] {
            let reach = pressures.reach(slave, master, contact_distance);
            if distance >= reach[0].max(reach[1]) {
                continue;
            }
            let local = self.local(slave, master, reach, contact_distance, pressures);
            pieces.clear();
            let mut collect = |touch: &Follow, pieces: &mut Vec<Piece>| {
                self.keep_rings([slave, master], &local, touch, pieces);
                if !pieces.is_empty() {
                    found(&Found { slave, master, local: &local, pieces, touch });
                }
            };
            if let Some(lines) = self.lines(slave, master, &local) {
                lines.pieces(|piece| pieces.push(piece));
                collect(&|u, _, branch| lines.touch(u, branch), pieces);
                continue;
            }
            self.with_pair(slave, master, local.reach, |pair, facing| match facing {
                Some(facing) if facing.pieces(pair, nearest, pieces) => {
                    collect(&|u, guess, _| (facing.touch(pair, u, guess), 1.0), pieces);
                }
                _ => {
                    pair.pieces(pieces);
                    collect(&|t, guess, branch| pair.touch(t, guess, branch), pieces);
                }
            });
        }
    }

    /// A segment as seen from a point.
    fn near(&self, segment: usize, origin: &Vec3) -> Cubic {
        let mut cubic = self.strands.cubic(segment).relative_to(origin);
        if let Some(lost) = self.remainders.get(segment) {
            cubic.b.iter_mut().zip(lost).for_each(|(point, lost)| *point += lost);
        }
        cubic
    }

    fn end_term(&self, found: &Found, besides: Besides) -> EndTerm {
        let origin = self.strands.ends(found.slave).0;
        let coordinates = Coordinates::ends(&self.near(found.slave, &origin), &self.near(found.master, &origin));
        let mut stiffness = besides.tangent.then(|| Stiffness::new(coordinates));
        let term = found.sum(besides, stiffness.as_mut());
        EndTerm {
            energy: term.energy,
            gradient: coordinates.pull(&term.gradient),
            tangent: stiffness.map(|s| s.finish(&term.gradient)),
            meeting: term.into(),
        }
    }

    /// The sum of [`Ground::terms`] without the terms.
    pub(crate) fn force(&self, [i, j]: [usize; 2], pressures: &Pressures, pieces: &mut Vec<Piece>) -> PairForce {
        let mut sum = PairForce::NONE;
        if !(self.strands.is_straight(i) && self.strands.is_straight(j)) {
            self.terms([i, j], pressures, Want::Gradient, pieces, |term| {
                sum.add_term(&self.strands, &term, term.slave != i)
            });
            return sum;
        }
        let contact_distance = self.strands.radius_of(i) + self.strands.radius_of(j);
        for (slave, master) in [(i, j), (j, i)] {
            let reach = pressures.reach(slave, master, contact_distance);
            if reach[0].max(reach[1]) <= 0.0 {
                continue;
            }
            let local = self.local(slave, master, reach, contact_distance, pressures);
            let Some(lines) = self.lines(slave, master, &local) else { continue };
            if !self.may_be_ring(slave, master) {
                lines.pieces(|piece| sum.add_lines(&lines, &piece, &local, slave != i));
                continue;
            }
            pieces.clear();
            lines.pieces(|piece| pieces.push(piece));
            self.keep_rings([slave, master], &local, &|u, _, branch| lines.touch(u, branch), pieces);
            pieces.iter().for_each(|piece| sum.add_lines(&lines, piece, &local, slave != i));
        }
        sum
    }

    /// A closed curve that lies in the ball about a slave point as a whole is a strand there, though its nearest and farthest points are as many:
    /// the farthest of all is not counted off.
    fn keep_rings(&self, [slave, master]: [usize; 2], local: &Local, touch: &Follow, pieces: &mut Vec<Piece>) {
        let off = |piece: &Piece| piece.branch.is_counted_off() || piece.branch.kind == FootKind::Fold;
        if !self.may_be_ring(slave, master) || !pieces.iter().any(off) {
            return;
        }
        let curve = self.strands.curve_of(master);
        let reach = local.reach[0].max(local.reach[1]);
        let own = self.strands.cubic(slave);
        let farthest_of_all = |piece: &Piece, fraction: f64| {
            let [t, other] = piece.along().map(|ends| ends[0] + (ends[1] - ends[0]) * fraction);
            let (touch, weight) = touch(t, other, &piece.branch);
            let foot = own.point(touch.u) - touch.normal * touch.distance;
            let here = |(segment, v): (usize, f64)| match piece.branch.kind {
                FootKind::Held => segment == master && piece.branch.may_be_at(v),
                _ => (self.strands.cubic(segment).point(v) - foot).norm() <= SAME * reach,
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

    /// Whether the master's curve could lie in the ball about a point of the slave as a whole.
    fn may_be_ring(&self, slave: usize, master: usize) -> bool {
        let curve = self.strands.curve_of(master);
        self.strands.curves[curve].closed && curve != self.strands.curve_of(slave)
    }

    /// Segment and parameter of the point of a closed curve that is farthest from x, of equals the first; none if that is beyond the reach.
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
        let first = points.iter().find(|p| p.2 >= farthest * (1.0 - TIE))?;
        (farthest < reach).then_some((first.0, first.1))
    }

    /// Lower bound of the distance \[L\]. Straight segments tell their intervals faster than this would save.
    fn nearest(&self, i: usize, j: usize) -> f64 {
        if self.capsules.is_empty() { 0.0 } else { self.capsules[i].distance_lower_bound(&self.capsules[j]) }
    }

    /// What holds all along the slave.
    fn local<'a>(
        &self,
        slave: usize,
        master: usize,
        reach: [f64; 2],
        contact_distance: f64,
        pressures: &'a Pressures<'a>,
    ) -> Local<'a> {
        let (length, offset) = (self.lengths[slave], (pressures.offset)(slave, master));
        let straight = self.strands.is_straight(slave) && self.strands.is_straight(master);
        let span = if straight {
            let (start, end) = self.strands.ends(slave);
            (end - start).norm()
        } else {
            length
        };
        Local { pressures, contact_distance, reach, offset, length, straight, span }
    }

    /// The pair as lines, if both are straight and the reach does not vary along the slave.
    fn lines(&self, slave: usize, master: usize, local: &Local) -> Option<Lines> {
        let lines = local.straight && local.reach[0] == local.reach[1];
        lines.then(|| Lines::new(&self.strands, slave, master, local.reach[0], self.kinks(slave, master)))
    }

    /// At which ends a kink of the master counts for this pair: at its start, and at its end if the next segment is left out as a neighbour of the
    /// slave.
    fn kinks(&self, slave: usize, master: usize) -> [bool; 2] {
        let left_out = |next: usize| self.exclusion.is_some_and(|e| !wanted(&self.strands, e, [slave, next]));
        [true, self.strands.next(master).is_some_and(left_out)]
    }

    /// Calls `with` the pair as cubics near the origin, and as facing ones if it is seen to be that, unless it is seen to have no foot: far from the origin
    /// the ends of zones would be lost in rounding, and looked for in vain. The same origin for every master, so that two that meet at a joint find the same
    /// bits there.
    fn with_pair(&self, slave: usize, master: usize, reach: [f64; 2], with: impl FnOnce(&Pair, Option<&Facing>)) {
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
        let joints = Joint::both(before, &foreign, after, &origin);
        let tangents = [before.map(|before| before.end_tangent()), after.map(|after| after.start_tangent())];
        let pair = Pair {
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

impl PairForce {
    /// Adds a term; `swapped` if its slave is j.
    fn add_term(&mut self, strands: &Strands, term: &PairTerm, swapped: bool) {
        self.energy += term.energy;
        self.min_gap = term.zones.iter().map(|zone| zone.min_gap).fold(self.min_gap, f64::min);
        let ends = term.point_gradient();
        for (side, segment) in [term.slave, term.master].into_iter().enumerate() {
            let force = &mut self.force[side ^ usize::from(swapped)];
            if strands.is_straight(segment) {
                force[0] -= ends[2 * side];
                force[3] -= ends[2 * side + 1];
            } else {
                (0..4).for_each(|m| force[m] -= term.gradient[4 * side + m]);
            }
        }
    }

    /// Adds one piece of a pair of lines; `swapped` if the slave is j.
    fn add_lines(&mut self, lines: &Lines, piece: &Piece, local: &Local, swapped: bool) {
        // ∫p n ds, and the same weighted by u and by v
        let (mut plain, mut at_u, mut at_v) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        local.integrate(piece, |u, _, weight| {
            let (touch, sign) = lines.touch(u, &piece.branch);
            let weight = weight * sign;
            let (law, _) = local.response(u, touch.distance);
            if without_limit(&law, weight) {
                return touch.v;
            }
            self.energy += weight * law.energy;
            let push = touch.normal * (weight * law.pressure);
            plain += push;
            at_u += push * u;
            at_v += push * touch.v;
            touch.v
        });
        self.min_gap = self.min_gap.min(piece.nearest.distance - local.contact_distance);
        let [own, other] = if swapped { [1, 0] } else { [0, 1] };
        self.force[own][0] += plain - at_u;
        self.force[own][3] += at_u;
        self.force[other][0] -= plain - at_v;
        self.force[other][3] -= at_v;
    }
}

/// What holds all along the slave of an ordered pair.
struct Local<'a> {
    pressures: &'a Pressures<'a>,
    contact_distance: f64,
    /// Of the slave \[L\].
    length: f64,
    /// Where the pressure ends, at both ends of the slave: contact distance + offset \[L\].
    reach: [f64; 2],
    offset: [f64; 2],
    /// Both are straight.
    straight: bool,
    /// Length of the slave as it is, if that is known \[L\].
    span: f64,
}

impl Found<'_> {
    fn pair_term(&self, want: Want) -> PairTerm {
        let mut stiffness = (want == Want::Hessian).then(|| Stiffness::new(Coordinates::Points));
        let mut term = self.sum(Besides { zones: true, tangent: false }, stiffness.as_mut());
        term.hessian = stiffness.map(|stiffness| {
            let sum = stiffness.finish(&term.gradient);
            let block = |m: usize, n: usize| Mat3::from_fn(|i, j| if m <= n { sum[3 * m + i][3 * n + j] } else { 0.0 });
            Box::new(std::array::from_fn(|m| std::array::from_fn(|n| block(m, n))))
        });
        term
    }

    /// The integral over the pieces, its second derivative in `stiffness`; with the tangent, the points in contact.
    fn sum(&self, besides: Besides, mut stiffness: Option<&mut Stiffness>) -> PairTerm {
        let mut term = PairTerm {
            slave: self.slave,
            master: self.master,
            energy: 0.0,
            gradient: [Vec3::zeros(); 8],
            hessian: None,
            zones: Vec::new(),
            touched: Vec::new(),
        };
        for piece in self.pieces {
            // ½∫p uᵏ ds
            let mut moments = [0.0; 3];
            let kind = piece.branch.kind;
            self.local.integrate(piece, |t, guess, weight| {
                let (touch, rate) = (self.touch)(t, guess, &piece.branch);
                let weight = weight * rate;
                let force = weight * add_touch(&mut term, stiffness.as_deref_mut(), kind, &touch, weight, self.local);
                // farthest points, counted off, are followed by no one
                if besides.tangent && weight > 0.0 {
                    let (law, carried) = self.local.response(touch.u, touch.distance);
                    let known = carried > 0.0 && law.stiffness.is_finite();
                    let point = Touched { u: touch.u, v: touch.v, kind, stiffness: weight * law.stiffness };
                    term.touched.extend(known.then_some(point));
                }
                moments[0] += force;
                moments[1] += force * touch.u;
                moments[2] += force * touch.u * touch.u;
                if kind == FootKind::Fold { touch.u } else { touch.v }
            });
            if besides.zones {
                let [half_force, first, second] = moments;
                let min_gap = piece.nearest.distance - self.local.contact_distance;
                let piece = piece.ascending();
                term.zones.push(ZonePiece { piece, min_gap, half_force, half_moments: [first, second] });
            }
        }
        term
    }
}

impl Local<'_> {
    /// Calls `add(t, guess of the other parameter, weight)` for the points of the quadrature ½∫dt of a piece, t what it is followed by, which returns the
    /// other parameter; long pieces are divided so that each part is shorter than the contact distance. Guesses are interpolated between the ends of the
    /// piece and what was returned.
    fn integrate(&self, piece: &Piece, mut add: impl FnMut(f64, f64, f64) -> f64) {
        let [t, other] = piece.along();
        let width = t[1] - t[0];
        let extent = width * self.span / self.contact_distance;
        let parts = match piece.branch.kind {
            FootKind::Fold => PARTS_OF_FOLD,
            _ => extent.ceil().clamp(1.0, 64.0),
        };
        let points = FEWER_POINTS.iter().find(|(longest, _)| self.straight && extent <= *longest);
        let rule = gauss(points.map_or(POINTS_PER_PIECE, |(_, points)| *points));
        let mut last = [t[0], other[0]];
        for part in 0..parts as usize {
            let mut known = Interpolation::between(last, [t[1], other[1]]);
            for (&x, &w) in rule.points.iter().zip(rule.weights) {
                let t = t[0] + width * (part as f64 + x) / parts;
                let other = add(t, known.at(t), 0.5 * w * width * self.length / parts);
                known.add(t, other);
                last = [t, other];
            }
        }
    }

    /// The response at a slave parameter and distance \[L\], and the pressure that the geometric stiffness belongs to.
    fn response(&self, u: f64, distance: f64) -> (Response, f64) {
        let between = |ends: [f64; 2]| ends[0] + (ends[1] - ends[0]) * u;
        let law = &self.pressures.law;
        let Some((before, _)) = self.pressures.before else {
            let response = law.response(between(self.reach) - distance, self.contact_distance);
            return (response, response.pressure);
        };
        let pressure = before.response(between(self.reach) - distance, self.contact_distance).pressure;
        let overlap = law.overlap(pressure, self.contact_distance);
        let there = law.response(overlap, self.contact_distance);
        let way = self.contact_distance + between(self.offset) - distance - overlap;
        let response = Response {
            energy: there.energy + (pressure + 0.5 * there.stiffness * way) * way,
            pressure: pressure + there.stiffness * way,
            stiffness: there.stiffness,
        };
        (response, pressure)
    }
}

/// Infinite, and to be counted off: it is infinite already at the nearer points that a farthest one lies between.
fn without_limit(law: &Response, weight: f64) -> bool {
    weight < 0.0 && law.energy == f64::INFINITY
}

/// Whether a pair is not one of neighbours along a curve.
pub(super) fn wanted(strands: &Strands, exclusion: &Exclusion, [i, j]: [usize; 2]) -> bool {
    !exclusion.excluded(i, j) && !strands.adjacent(i, j)
}

fn bernstein_weights(u: f64) -> [f64; 4] {
    let t = 1.0 - u;
    [t * t * t, 3.0 * t * t * u, 3.0 * t * u * u, u * u * u]
}

fn bernstein_slopes(u: f64) -> [f64; 4] {
    let t = 1.0 - u;
    [-3.0 * t * t, 3.0 * t * (t - 2.0 * u), 3.0 * u * (2.0 * t - u), 3.0 * u * u]
}

/// Adds weight × the law at one point, its second derivative to `stiffness`; returns the pressure.
fn add_touch(
    term: &mut PairTerm,
    stiffness: Option<&mut Stiffness>,
    kind: FootKind,
    touch: &Touch,
    weight: f64,
    local: &Local,
) -> f64 {
    let Touch { u, v, distance, normal, tangent: db, curvature: ddb } = *touch;
    let (law, carried) = local.response(u, distance);
    if carried == 0.0 || without_limit(&law, weight) {
        return 0.0;
    }
    term.energy += weight * law.energy;
    // Where the centrelines cross, the force has no direction.
    if distance == 0.0 {
        return law.pressure;
    }
    let (wa, wb) = (bernstein_weights(u), bernstein_weights(v));
    let w: [f64; 8] = std::array::from_fn(|m| if m < 4 { wa[m] } else { -wb[m - 4] });
    let push = normal * (weight * law.pressure);
    for m in 0..8 {
        term.gradient[m] -= push * w[m];
    }
    let Some(stiffness) = stiffness else { return law.pressure };
    let over_d = carried / distance;
    stiffness.add_product(&w.map(|w| normal * w), weight * (law.stiffness + over_d));
    stiffness.subtract_spread(&w, weight * over_d);
    if matches!(kind, FootKind::Orthogonal | FootKind::Fold) {
        let d_vv = db.norm_squared() / distance - normal.dot(&ddb);
        let slopes = bernstein_slopes(v);
        let along = db / -distance;
        let way = |m: usize| if m < 4 { along * w[m] } else { along * w[m] - normal * slopes[m - 4] };
        stiffness.add_product(&std::array::from_fn(way), weight * carried / d_vv);
    }
    law.pressure
}

#[cfg(test)]
mod folds;
#[cfg(test)]
mod tests;
