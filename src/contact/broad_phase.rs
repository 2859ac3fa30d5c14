//! Broad phase: candidate segment pairs from a tree along the curves, kept while nothing has moved far.
//!
//! The tree stores f32 boxes in coordinates relative to the set's centre and size, rounded *outward*: far offsets and odd units cost
//! nothing, a pair is never lost. The capsule bound per pair is f64.
//!
//! **When the list is kept.** It is built for curves that come within `range + margin` of touching. While no control
//! point has moved more than `margin`/2 since, no distance has shrunk by more than `margin`, so the list still holds every pair within
//! `range`. Exclusion by turning changes with the geometry too: the list is built with the limit π/2 lowered by 0.25 rad, and is kept
//! only as long as every pair left out for that reason is still excluded by the present [`Exclusion`] (an exact O(segments) check of how far
//! each segment's exclusion reaches). So the list is always a superset of the pairs that can hold contact; users still ask
//! [`Exclusion::excluded`] per pair where they must not see neighbours.
//!
//! **Order.** Each task of the tree owns up to 16384 consecutive segments and finds their partners further on; its pairs pass the capsule test while
//! they are in the cache, are sorted by counting, and the tasks' lists follow one another: sorted, and the same for any number of threads.
//! Cost O(segments + pairs) on curves of bounded crowding; memory 32 bytes a segment for the tree, 8 a pair, and a copy of the
//! control points if `margin` > 0.

use std::ops::Range;

use rayon::prelude::*;

use super::chain_tree::{Box3, ChainTree};
use super::curve::CurveSet;
use super::exclusion::Exclusion;
use super::input::{Shape, Strands, lower, upper};
use super::pair_filter::keep_near;
use crate::error::InputError;
use crate::math::Vec3;

/// Segments per parallel piece of work.
const MIN_LEN: usize = 4096;

/// Finds candidate pairs and keeps them from one call to the next.
#[derive(Default)]
pub struct BroadPhase {
    built: Option<Built>,
    pairs: Vec<[u32; 2]>,
    bulges: Vec<f64>,
    /// Last segment of the same curve excluded with each segment (in the tree's order).
    far: Vec<u32>,
    tree: ChainTree,
    /// Segment at each place of the tree; empty if they are the same.
    order: Vec<u32>,
    generation: u64,
}

impl std::fmt::Debug for BroadPhase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BroadPhase").field("pairs", &self.pairs.len()).field("generation", &self.generation).finish()
    }
}

/// What the present list was built for.
#[derive(Default)]
struct Built {
    points: Vec<Vec3>,
    /// First segment, count, closed, radius.
    curves: Vec<(usize, usize, bool, f64)>,
    reach: Vec<u32>,
    range: f64,
    margin: f64,
}

impl BroadPhase {
    /// Nothing found yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Increments each time the list is rebuilt; while it stays the list is the very same.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The list as last built, without a check.
    #[must_use]
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// All pairs i < j of segments, sorted, that are not excluded as neighbours and whose curves may come within
    /// radius_i + radius_j + `range` \[L\] of each other, and some more: a pair up to `margin` \[L\] farther may be listed, one whose capsules are
    /// provably farther apart is not. `exclusion` must be up to date with `set`.
    ///
    /// A larger `margin` means fewer rebuilds and longer lists; 0 rebuilds at every call. Rebuilt also when `range`, `margin`, the number of segments
    /// or the curves (radii, closure) change. The result depends on the calls made, never on the number of threads.
    ///
    /// # Errors
    /// [`InputError`] for a control point that is not finite (naming curve and segment), or `range` (may be negative) or `margin` (≥ 0) not finite.
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
            self.generation += 1;
            self.refit(strands, 0.5 * (range + margin));
            self.search(strands, exclusion, Some(range + margin));
            if margin > 0.0 {
                self.built.get_or_insert_default().remember(strands, exclusion, range, margin);
            } else {
                self.built = None;
            }
        }
        Ok(&self.pairs)
    }

    /// Boxes, inflated by the radius and `inflate`, and the tree.
    pub(crate) fn refit(&mut self, strands: &Strands, inflate: f64) {
        self.order = spatial_order(strands);
        let (centre, size) = frame(strands, inflate);
        let order = &self.order;
        self.tree.refit(strands.len(), |place| {
            let segment = if order.is_empty() { place } else { order[place] as usize };
            // A negative range may shrink boxes, but not inside out.
            let r = (strands.radius_of(segment) + inflate).max(0.0);
            outward(strands.bounds(segment), r, &centre, size)
        });
        self.bulges.clear();
        if strands.curves.iter().any(|c| matches!(c.shape, Shape::Cubics(_))) {
            let bulge = |i| if strands.is_straight(i) { 0.0 } else { strands.cubic(i).bulge() };
            (0..strands.len()).into_par_iter().with_min_len(MIN_LEN).map(bulge).collect_into_vec(&mut self.bulges);
        }
    }

    /// Fills the list from the tree: pairs not excluded whose boxes overlap and, if `reach` is given, whose capsules may be within both
    /// radii + `reach`.
    pub(crate) fn search(&mut self, strands: &Strands, exclusion: &Exclusion, reach: Option<f64>) {
        let reaches = exclusion.reduced_reach();
        let order = &self.order;
        self.far.clear();
        self.far.extend((0..strands.len()).map(|place| {
            let segment = if order.is_empty() { place } else { order[place] as usize };
            let curve = strands.strand(segment);
            // Round a closed curve the pairs beyond its seam are looked at one by one.
            let left = curve.first + curve.count - 1 - segment;
            (place + left.min(reaches[segment] as usize)) as u32
        }));
        let seams = strands.curves.iter().any(|c| c.closed);
        let (tree, far, bulges) = (&self.tree, &self.far, &self.bulges);
        let lists: Vec<Vec<[u32; 2]>> = (0..tree.num_tasks())
            .into_par_iter()
            .map_init(Vec::new, |found, task| {
                found.clear();
                tree.visit(task, far, &mut |p, q| {
                    let (i, j) = if order.is_empty() { (p, q) } else { (order[p as usize], order[q as usize]) };
                    let (i, j) = if i < j { (i, j) } else { (j, i) };
                    if !seams || !exclusion.excluded_reduced(i as usize, j as usize) {
                        found.push([i, j]);
                    }
                });
                let mut list = Vec::new();
                match reach {
                    Some(reach) => keep_near(strands, bulges, reach, found, &mut list),
                    None => list.extend_from_slice(found),
                }
                if order.is_empty() { sort_pairs(list, tree.task_range(task)) } else { list }
            })
            .collect();
        self.pairs.clear();
        self.pairs.reserve(lists.iter().map(Vec::len).sum());
        for list in &lists {
            self.pairs.extend_from_slice(list);
        }
        if !order.is_empty() {
            self.pairs = sort_pairs(std::mem::take(&mut self.pairs), 0..strands.len());
        }
    }
}

/// Sorts pairs whose first index lies in `rows`: counting by the first, then each row by the second.
fn sort_pairs(pairs: Vec<[u32; 2]>, rows: Range<usize>) -> Vec<[u32; 2]> {
    let mut start = vec![0u32; rows.len() + 1];
    for &[i, _] in &pairs {
        start[i as usize - rows.start + 1] += 1;
    }
    for k in 1..start.len() {
        start[k] += start[k - 1];
    }
    let mut sorted = vec![[0; 2]; pairs.len()];
    for &[i, j] in &pairs {
        let place = &mut start[i as usize - rows.start];
        sorted[*place as usize] = [i, j];
        *place += 1;
    }
    // `start[k]` has become the end of row k.
    let mut first = 0;
    for &end in &start[..rows.len()] {
        let row = &mut sorted[first..end as usize];
        if row.len() > 1 {
            row.sort_unstable_by_key(|p| p[1]);
        }
        first = end as usize;
    }
    sorted
}

impl Built {
    fn still_holds(&self, strands: &Strands, exclusion: &Exclusion, range: f64, margin: f64) -> bool {
        // Rounded to the safe side: a few ulp short of half the margin (and exact rest always holds).
        let allowed = 0.5 * margin * (1.0 - 1e-12);
        let near = |(then, now): (&Vec3, &Vec3)| then == now || (now - then).norm() <= allowed;
        let same_curves = self.curves.iter().copied().eq(curves_of(strands));
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
            let still = if run.len() > MIN_LEN {
                then.par_iter().with_min_len(MIN_LEN).zip(run).all(near)
            } else {
                then.iter().zip(run).all(near)
            };
            if !still {
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
        self.reach.clear();
        self.reach.extend_from_slice(exclusion.reduced_reach());
        (self.range, self.margin) = (range, margin);
    }
}

fn curves_of<'a>(strands: &'a Strands) -> impl Iterator<Item = (usize, usize, bool, f64)> + 'a {
    strands.curves.iter().map(|c| (c.first, c.count, c.closed, c.radius))
}

/// Order of the segments in the tree: as they are, unless there are many curves; then neighbouring curves are put next to each other
/// (Morton order of their middles), each curve in one piece.
fn spatial_order(strands: &Strands) -> Vec<u32> {
    const FEW: usize = 8;
    if strands.curves.len() <= FEW {
        return Vec::new();
    }
    let (centre, size) = frame(strands, 0.0);
    let mut keys: Vec<(u64, usize)> = strands
        .curves
        .iter()
        .enumerate()
        .map(|(index, curve)| {
            let (a, b) = (strands.ends(curve.first).0, strands.ends(curve.first + curve.count - 1).1);
            let middle = ((a * 0.5 + b * 0.5) - centre) / size;
            // 21 bits of each coordinate in [−1, 1].
            let bits = |x: f64| (((x + 1.0) * 1_048_576.0).clamp(0.0, 2_097_151.0)) as u64;
            (spread(bits(middle.x)) | spread(bits(middle.y)) << 1 | spread(bits(middle.z)) << 2, index)
        })
        .collect();
    keys.par_sort_unstable();
    let segments = |&(_, c): &(u64, usize)| {
        let curve = &strands.curves[c];
        curve.first as u32..(curve.first + curve.count) as u32
    };
    keys.iter().flat_map(segments).collect()
}

/// Puts two zero bits after each of the lowest 21.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Centre and half-size of everything, inflation included.
fn frame(strands: &Strands, inflate: f64) -> (Vec3, f64) {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let grow = |(lo, hi): (Vec3, Vec3), p: &Vec3| (lower(&lo, p), upper(&hi, p));
    let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (lower(&a.0, &b.0), upper(&a.1, &b.1));
    let part = |run: &[Vec3]| run.iter().fold(none, grow);
    let (lo, hi) = strands
        .control_points()
        .map(
            |run| {
                if run.len() <= MIN_LEN { part(run) } else { run.par_chunks(MIN_LEN).map(part).reduce(|| none, join) }
            },
        )
        .fold(none, join);
    let radius = strands.curves.iter().map(|c| c.radius).fold(0.0, f64::max);
    // Halved first: the sum of two huge coordinates may overflow.
    let size = (hi * 0.5 - lo * 0.5).amax() + (radius + inflate).max(0.0);
    (lo * 0.5 + hi * 0.5, size)
}

/// f32 box in the frame, grown by `r` and rounded outward. In a frame too small or large for f64 everything is one box.
#[inline]
fn outward((lo, hi): (Vec3, Vec3), r: f64, centre: &Vec3, size: f64) -> Box3 {
    if !(1e-290..1e290).contains(&size) {
        return ([-2.0; 3], [2.0; 3]);
    }
    let scale = 1.0 / size;
    // Coordinates are within ±1 (to rounding): 2⁻²⁴ covers the cast, 1e-13 the f64 roundings before it.
    let grow = r * scale + (0.5 * f64::from(f32::EPSILON) + 1e-13);
    let below = |k: usize| ((lo[k] - centre[k]) * scale - grow) as f32;
    let above = |k: usize| ((hi[k] - centre[k]) * scale + grow) as f32;
    (std::array::from_fn(below), std::array::from_fn(above))
}

/// What [`BroadPhase::candidates`] must contain, by trying all pairs with the capsule bound: those not excluded and perhaps within
/// radius_i + radius_j + `range`. For tests; O(n²).
#[doc(hidden)]
#[must_use]
pub fn brute_force_candidates(set: &CurveSet, exclusion: &Exclusion, range: f64) -> Vec<[u32; 2]> {
    use super::capsule::Capsule;
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
