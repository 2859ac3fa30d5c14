//! Broad phase: candidate segment pairs from a bounding-volume tree (`leaves`), kept while
//! nothing has moved far.
//!
//! The tree stores f32 boxes in coordinates relative to the set's centre and size, rounded *outward*: distance from the
//! origin and unit do not matter, and a pair is never lost. A leaf is a run of up to four consecutive segments of one
//! curve: curves are sorted by themselves, so the tree needs a quarter of the nodes, and two leaves are compared
//! segment by segment in vector lanes. Leaf pairs along a strand all of whose segments are excluded are dropped by one
//! comparison as the tree is traversed. The tree is refitted while its boxes stay as tight as when it was built; which
//! pairs are found does not depend on its shape.
//!
//! **When the list is kept.** It is built for curves that come within `range + margin` of touching. While no control
//! point has moved more than `margin`/2 since, no distance has shrunk by more than `margin`, so the list still holds
//! every pair within `range`. Exclusion by turning changes with the geometry too: the list is built with the limit π/2
//! lowered by 0.25 rad, and is kept only as long as every pair left out for that reason is still excluded by the
//! present [`Exclusion`] (an exact O(segments) check of how far each segment's exclusion reaches). So the list is
//! always a superset of the pairs that can be in contact; callers that must not see neighbours also test
//! [`Exclusion::excluded`].
//!
//! **Order.** Leaf pairs are compared in the order of the tree, in which neighbours in space follow one another, and
//! pass the capsule test while they are in the cache; the pairs of segments that remain are sorted by counting: the
//! same list for any number of threads.
//!
//! **Growth.** From 1e4 to 1e6 segments the time per segment grows by a half on crowded inputs: 1e4 segments fit into a
//! cache of 1 MB, 1e6 do not (a refit moves 200 bytes a segment, a search 60). Two alternatives were tried and
//! rejected, leaves of sixteen segments in two levels and leaves renumbered in the order of the tree: a search in a
//! crowd becomes 10 % faster, a refit as much slower, and plectonemes 15 % slower.
//!
//! Cost O(segments + pairs) on curves of bounded crowding (a new tree costs O(n log n)); memory about 70 bytes a
//! segment for boxes and tree, 8 a pair, and a copy of the control points if `margin` > 0.

use std::ops::Range;

use crate::contact::curves::curve::CurveSet;
use crate::contact::curves::input::{CurveShape, Strands};
use crate::contact::measures::SUM_ROUNDING;
use crate::contact::pairs::filter::keep_near;
use crate::contact::tree::boxes::{Block, WIDTH};
use crate::contact::tree::exclusion::{Exclusion, bytes};
use crate::contact::tree::leaves::Leaves;
use crate::error::InputError;
use crate::math::parallel::CHEAP;
use crate::math::{Vec3, parallel};

/// Finds candidate pairs and keeps them from one call to the next.
#[derive(Default)]
pub struct BroadPhase {
    built: Option<Built>,
    pairs: Vec<[u32; 2]>,
    bulges: Vec<f64>,
    /// Last segment of the same curve excluded with each segment; never decreases.
    far: Vec<u32>,
    leaves: Leaves,
    /// The list before the present one.
    earlier: Vec<[u32; 2]>,
    /// Scratch memory of the sort.
    starts: Vec<u32>,
    generation: u64,
}

impl std::fmt::Debug for BroadPhase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BroadPhase").field("pairs", &self.pairs.len()).field("generation", &self.generation).finish()
    }
}

/// The curves, radii and reach that the present list was built for.
#[derive(Default)]
struct Built {
    points: Vec<Vec3>,
    /// First segment, count, closed, largest radius.
    curves: Vec<(usize, usize, bool, f64)>,
    /// Radii given one by one, curve after curve.
    radii: Vec<f64>,
    reach: Vec<u32>,
    range: f64,
    margin: f64,
}

impl BroadPhase {
    /// An empty list.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Counter of changes of the list: equal numbers mean the same list.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The list as last built, without a check.
    #[must_use]
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// Whether the present list was built for this range and margin \[L\].
    #[must_use]
    pub(crate) fn is_for(&self, range: f64, margin: f64) -> bool {
        self.built.as_ref().is_some_and(|built| (built.range, built.margin) == (range, margin))
    }

    /// All pairs i < j of segments, sorted, that are not excluded as neighbours and whose curves may be within both
    /// radii + `range` \[L\] of each other. A pair up to `margin` \[L\] farther may be listed; a pair whose capsules
    /// are provably farther apart is not. `exclusion` must be up to date with `set`.
    ///
    /// A larger `margin` means fewer rebuilds and longer lists; 0 rebuilds at every call. Rebuilt also when `range`,
    /// `margin`, the number of segments or the curves (radii, closure) change. The result depends on the calls made,
    /// never on the number of threads.
    ///
    /// # Errors
    /// [`InputError`] for a control point that is not finite (naming curve and segment), or `range` (may be negative)
    /// or `margin` (≥ 0) not finite.
    pub fn candidates(
        &mut self,
        set: &CurveSet,
        exclusion: &Exclusion,
        range: f64,
        margin: f64,
    ) -> Result<&[[u32; 2]], InputError> {
        set.validate_geometry()?;
        self.candidates_of(&Strands::of_set(set), exclusion, range, margin)
    }

    /// As [`BroadPhase::candidates`] for borrowed curves, whose points must be finite.
    pub(crate) fn candidates_of(
        &mut self,
        strands: &Strands,
        exclusion: &Exclusion,
        range: f64,
        margin: f64,
    ) -> Result<&[[u32; 2]], InputError> {
        InputError::check("range", range, true, "finite")?;
        InputError::check("margin", margin, margin >= 0.0, "finite and at least 0")?;
        let kept = self.built.as_ref().is_some_and(|b| b.still_holds(strands, exclusion, range, margin));
        if !kept {
            std::mem::swap(&mut self.pairs, &mut self.earlier);
            self.refit(strands, 0.5 * (range + margin));
            self.search(strands, exclusion, Some(range + margin));
            // a new list may equal the old one, for example an empty one
            self.generation += u64::from(self.pairs != self.earlier || self.generation == 0);
            if margin > 0.0 {
                self.built.get_or_insert_default().remember(strands, exclusion, range, margin);
            } else {
                self.built = None;
            }
        }
        Ok(&self.pairs)
    }

    /// Memory, bytes, without the scratch of the tree's library (a second copy of its nodes).
    pub(crate) fn memory(&self) -> usize {
        let built = self.built.as_ref().map_or(0, |b| bytes(&b.points) + bytes(&b.radii) + bytes(&b.reach));
        let lists = bytes(&self.pairs) + bytes(&self.bulges) + bytes(&self.far) + bytes(&self.starts);
        built + lists + self.leaves.memory()
    }

    /// Boxes, inflated by the radius and `inflate`, and the tree.
    pub(crate) fn refit(&mut self, strands: &Strands, inflate: f64) {
        self.leaves.refit(strands, inflate);
        self.bulges.clear();
        if strands.curves.iter().any(|c| matches!(c.shape, CurveShape::Cubics(_))) {
            let bulge = |i| if strands.is_straight(i) { 0.0 } else { strands.cubic(i).bulge() };
            self.bulges.resize(strands.len(), 0.0);
            parallel::each(&mut self.bulges, CHEAP, &|k, place| *place = bulge(k));
        }
    }

    /// Fills the list from the tree: pairs not excluded whose boxes overlap and, if `reach` is given, whose capsules
    /// may be within both radii + `reach`.
    pub(crate) fn search(&mut self, strands: &Strands, exclusion: &Exclusion, reach: Option<f64>) {
        let reaches = exclusion.reduced_reach();
        self.far.clear();
        for curve in &strands.curves {
            // Pairs across the seam of a closed curve are tested one by one.
            let last = curve.first + curve.count - 1;
            self.far.extend((curve.first..=last).map(|i| (i + (last - i).min(reaches[i] as usize)) as u32));
        }
        let leaf_pairs = self.leaves.pairs(&self.far);
        let compare = LeafComparison {
            strands,
            exclusion,
            seams: strands.curves.iter().any(|c| c.closed),
            reach,
            firsts: &self.leaves.firsts,
            blocks: &self.leaves.blocks,
            far: &self.far,
            bulges: &self.bulges,
        };
        let num_leaves = self.leaves.blocks.len();
        let mut lists = parallel::map_ranges(num_leaves, CHEAP, &|leaves| {
            let mut found = Vec::new();
            leaves.for_each(|p| compare.within(p, &mut found));
            compare.near(&found)
        });
        lists.extend(parallel::map_ranges(leaf_pairs.len(), CHEAP, &|pairs| {
            let mut found = Vec::new();
            leaf_pairs[pairs].iter().for_each(|&[p, q]| compare.leaves(p as usize, q as usize, u32::MAX, &mut found));
            compare.near(&found)
        }));
        sort_pairs(&lists, strands.len(), &mut self.starts, &mut self.pairs);
    }
}

/// Data for the comparison of two leaves.
struct LeafComparison<'a> {
    strands: &'a Strands<'a>,
    exclusion: &'a Exclusion,
    seams: bool,
    reach: Option<f64>,
    firsts: &'a [u32],
    blocks: &'a [Block],
    far: &'a [u32],
    bulges: &'a [f64],
}

impl LeafComparison<'_> {
    /// Pairs within one leaf.
    fn within(&self, p: usize, found: &mut Vec<[u32; 2]>) {
        if self.firsts[p + 1] - 1 > self.far[self.firsts[p] as usize] {
            // Bit 4c + d for lanes c < d.
            self.leaves(p, p, 0b0000_1000_1100_1110, found);
        }
    }

    /// Pairs of overlapping boxes of two leaves that are not neighbours.
    #[inline(always)]
    fn leaves(&self, p: usize, q: usize, lanes: u32, found: &mut Vec<[u32; 2]>) {
        let mut mask = self.blocks[p].overlaps_all(&self.blocks[q]) & lanes;
        while mask != 0 {
            let bit = mask.trailing_zeros();
            mask &= mask - 1;
            let (i, j) = (self.firsts[p] + bit / WIDTH as u32, self.firsts[q] + bit % WIDTH as u32);
            let (a, b) = (i as usize, j as usize);
            let wanted = j > self.far[a] && !self.exclusion.are_joined(a, b);
            if wanted && (!self.seams || !self.exclusion.excluded_reduced(a, b)) {
                found.push([i, j]);
            }
        }
    }

    /// Pairs whose capsules may be near enough.
    fn near(&self, found: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let mut list = Vec::with_capacity(found.len());
        match self.reach {
            Some(reach) => keep_near(self.strands, self.bulges, reach, found, &mut list),
            None => list.extend_from_slice(found),
        }
        list
    }
}

/// All pairs of the lists, sorted: counting by the first index (below `rows`), then each row by the second. `starts` is
/// scratch.
fn sort_pairs(lists: &[Vec<[u32; 2]>], rows: usize, starts: &mut Vec<u32>, sorted: &mut Vec<[u32; 2]>) {
    starts.clear();
    starts.resize(rows + 1, 0);
    for &[i, _] in lists.iter().flatten() {
        starts[i as usize + 1] += 1;
    }
    for k in 1..=rows {
        starts[k] += starts[k - 1];
    }
    // Every place is written below.
    sorted.resize(starts[rows] as usize, [0; 2]);
    for &[i, j] in lists.iter().flatten() {
        let place = &mut starts[i as usize];
        sorted[*place as usize] = [i, j];
        *place += 1;
    }
    // `starts[k]` has become the end of row k.
    let mut first = 0;
    for &end in &starts[..rows] {
        let row = &mut sorted[first..end as usize];
        if row.len() > 1 {
            row.sort_unstable_by_key(|p| p[1]);
        }
        first = end as usize;
    }
}

impl Built {
    fn still_holds(&self, strands: &Strands, exclusion: &Exclusion, range: f64, margin: f64) -> bool {
        // Rounded down: a few ulp less than half the margin (no movement is always allowed).
        let allowed = 0.5 * margin * (1.0 - SUM_ROUNDING);
        let near = |(then, now): (&Vec3, &Vec3)| then == now || (now - then).norm() <= allowed;
        let same_curves = self.curves.iter().copied().eq(curves_of(strands));
        let same_curves = same_curves && self.radii.iter().eq(radii_of(strands));
        if self.range != range || self.margin != margin || !same_curves || !exclusion.covers(&self.reach) {
            return false;
        }
        let mut rest = self.points.as_slice();
        for run in strands.control_points() {
            if run.len() > rest.len() {
                return false;
            }
            let (then, after) = rest.split_at(run.len());
            rest = after;
            let still = |part: Range<usize>| then[part.clone()].iter().zip(&run[part]).all(near);
            if !parallel::all(run.len(), CHEAP, &still) {
                return false;
            }
        }
        rest.is_empty()
    }

    fn remember(&mut self, strands: &Strands, exclusion: &Exclusion, range: f64, margin: f64) {
        self.points.clear();
        for run in strands.control_points() {
            self.points.extend_from_slice(run);
        }
        self.curves.clear();
        self.curves.extend(curves_of(strands));
        self.radii.clear();
        self.radii.extend(radii_of(strands));
        self.reach.clear();
        self.reach.extend_from_slice(exclusion.reduced_reach());
        (self.range, self.margin) = (range, margin);
    }
}

fn curves_of<'a>(strands: &'a Strands) -> impl Iterator<Item = (usize, usize, bool, f64)> + 'a {
    strands.curves.iter().map(|c| (c.first, c.count, c.closed, c.radius.largest()))
}

fn radii_of<'a>(strands: &'a Strands) -> impl Iterator<Item = &'a f64> + 'a {
    strands.curves.iter().flat_map(|c| c.radius.list().unwrap_or_default())
}

/// The pairs that [`BroadPhase::candidates`] must contain, by the capsule bound of every pair: not excluded, possibly
/// within radius_i + radius_j + `range`. For tests; O(n²).
#[doc(hidden)]
#[must_use]
pub fn brute_force_candidates(set: &CurveSet, exclusion: &Exclusion, range: f64) -> Vec<[u32; 2]> {
    use crate::contact::pairs::capsule::Capsule;
    let capsules: Vec<Capsule> = set.segments.iter().map(Capsule::new).collect();
    let near = |i: usize, j: usize| {
        let limit = set.radius_of(i) + set.radius_of(j) + range;
        capsules[i].distance_lower_bound(&capsules[j]) <= limit
    };
    let n = set.len();
    (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .filter(|&(i, j)| !exclusion.excluded(i, j) && near(i, j))
        .map(|(i, j)| [i as u32, j as u32])
        .collect()
}
