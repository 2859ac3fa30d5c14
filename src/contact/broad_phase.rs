//! Broad phase: candidate segment pairs from a bounding-volume tree (parry3d; the only file that names it), kept while nothing has
//! moved far.
//!
//! The tree stores f32 boxes in coordinates relative to the set's centre and size, rounded *outward*: far offsets and odd units cost
//! nothing, a pair is never lost. The exact work, here a capsule bound per pair, is f64.
//!
//! **When the list is kept.** It is built for curves that come within `range + margin` of touching. While no control
//! point has moved more than `margin`/2 since, no distance has shrunk by more than `margin`, so the list still holds every pair within
//! `range`. Exclusion by turning changes with the geometry too: the list is built with the limit π/2 lowered by 0.25 rad, and is kept
//! only as long as every pair left out for that reason is still excluded by the present [`Exclusion`] (an exact O(segments) check of how far
//! each segment's exclusion reaches). So the list is always a superset of the pairs that can hold contact; users still ask
//! [`Exclusion::excluded`] per pair where they must not see neighbours.

use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use rayon::prelude::*;

use super::capsule::Capsule;
use super::curve::{Cubic, CurveInfo, CurveSet};
use super::exclusion::Exclusion;
use crate::error::InputError;
use crate::math::Vec3;

/// Below this many segments all pairs are tried: the tree costs more than it saves (and some of its builders dislike 1 or 2 leaves).
const SMALL: usize = 24;

/// Finds candidate pairs and keeps them from one call to the next.
#[derive(Default)]
pub struct BroadPhase {
    built: Option<Built>,
    pairs: Vec<[u32; 2]>,
    capsules: Vec<Capsule>,
    tree: Option<Tree>,
    workspace: BvhWorkspace,
    generation: u64,
}

impl std::fmt::Debug for BroadPhase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BroadPhase").field("pairs", &self.pairs.len()).field("generation", &self.generation).finish()
    }
}

/// What the present list was built for.
struct Built {
    segments: Vec<Cubic>,
    curves: Vec<CurveInfo>,
    reach: Vec<u32>,
    range: f64,
    margin: f64,
}

struct Tree {
    bvh: Bvh,
    /// Map to tree coordinates, x ↦ (x − centre)/size, fixed when the tree was built.
    centre: Vec3,
    size: f64,
    count: usize,
    /// Box pairs found right after the build; many more mean that refitting has spoilt the tree.
    fresh_pairs: usize,
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
    /// A larger `margin` means fewer rebuilds and longer lists; 0 rebuilds on any motion. Rebuilt also when `range`, `margin`, the number of segments
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
        InputError::check("range", range, true, "finite")?;
        InputError::check("margin", margin, margin >= 0.0, "finite and at least 0")?;
        set.validate_geometry()?;
        let kept = self.built.as_ref().is_some_and(|b| b.still_holds(set, exclusion, range, margin));
        if !kept {
            self.rebuild(set, exclusion, range, margin);
        }
        Ok(&self.pairs)
    }

    fn rebuild(&mut self, set: &CurveSet, exclusion: &Exclusion, range: f64, margin: f64) {
        self.generation += 1;
        self.capsules.clear();
        self.capsules.par_extend(set.segments.par_iter().map(Capsule::new));
        let capsules = &self.capsules;
        let wanted = |i: u32, j: u32| -> Option<[u32; 2]> {
            let (i, j) = if i < j { (i, j) } else { (j, i) };
            (!exclusion.excluded_reduced(i as usize, j as usize)
                && near(set, capsules, i as usize, j as usize, range + margin))
            .then_some([i, j])
        };
        self.pairs.clear();
        if set.len() <= SMALL {
            let n = set.len() as u32;
            self.pairs.extend((0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).filter_map(|(i, j)| wanted(i, j)));
        } else {
            let boxed = box_pairs(&mut self.tree, &mut self.workspace, set, 0.5 * (range + margin));
            self.pairs.par_extend(boxed.par_iter().filter_map(|&(i, j)| wanted(i, j)));
            self.pairs.par_sort_unstable();
            self.pairs.dedup();
        }
        // Reuse the buffers of the last time.
        let mut built = self.built.take().unwrap_or_else(|| Built {
            segments: Vec::new(),
            curves: Vec::new(),
            reach: Vec::new(),
            range,
            margin,
        });
        built.segments.clone_from(&set.segments);
        built.curves.clone_from(&set.curves);
        built.reach.clear();
        built.reach.extend_from_slice(exclusion.reduced_reach());
        (built.range, built.margin) = (range, margin);
        self.built = Some(built);
    }
}

impl Built {
    fn still_holds(&self, set: &CurveSet, exclusion: &Exclusion, range: f64, margin: f64) -> bool {
        self.range == range
            && self.margin == margin
            && self.curves == set.curves
            && self.segments.len() == set.len()
            && exclusion.covers(&self.reach)
            && self.segments.par_iter().with_min_len(4096).zip(&set.segments).all(|(then, now)| {
                // Rounded to the safe side: a few ulp short of half the margin (and exact rest always holds).
                then == now || (0..4).all(|k| (now.b[k] - then.b[k]).norm() <= 0.5 * margin * (1.0 - 1e-12))
            })
    }
}

/// True unless the capsules are provably farther apart than both radii + reach.
fn near(set: &CurveSet, capsules: &[Capsule], i: usize, j: usize, reach: f64) -> bool {
    let limit = set.radius_of(i) + set.radius_of(j) + reach;
    capsules[i].distance_lower_bound(&capsules[j]) <= limit + 8.0 * f64::EPSILON * limit.abs()
}

/// All pairs of segments whose inflated boxes overlap (each once, in either order).
fn box_pairs(tree: &mut Option<Tree>, workspace: &mut BvhWorkspace, set: &CurveSet, inflate: f64) -> Vec<(u32, u32)> {
    if let Some(tree) = tree.as_mut().filter(|t| t.count == set.len())
        && let Some(boxes) = boxes(set, inflate, &tree.centre, tree.size)
    {
        for (i, aabb) in boxes.into_iter().enumerate() {
            tree.bvh.insert_or_update_partially(aabb, i as u32, 0.0);
        }
        tree.bvh.refit(workspace);
        let pairs = tree.bvh.traverse_bvtt_single_tree_parallel::<false>();
        if pairs.len() <= 2 * tree.fresh_pairs + set.len() {
            return pairs;
        }
    }
    let (centre, size) = frame(set, inflate);
    let Some(boxes) = boxes(set, inflate, &centre, size) else {
        // Sizes beyond the range of f64: no tree can help, so everything is a box pair.
        let n = set.len() as u32;
        return (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).collect();
    };
    let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let pairs = bvh.traverse_bvtt_single_tree_parallel::<false>();
    *tree = Some(Tree { bvh, centre, size, count: set.len(), fresh_pairs: pairs.len() });
    pairs
}

/// Centre and half-size of everything, inflation included.
fn frame(set: &CurveSet, inflate: f64) -> (Vec3, f64) {
    let (mut lo, mut hi) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    for p in set.segments.iter().flat_map(|s| &s.b) {
        lo = lo.inf(p);
        hi = hi.sup(p);
    }
    let radius = set.curves.iter().map(|c| c.radius).fold(0.0, f64::max);
    // Halved first: the sum of two huge coordinates may overflow.
    (lo * 0.5 + hi * 0.5, (hi * 0.5 - lo * 0.5).amax() + (radius + inflate).max(0.0))
}

/// f32 boxes of the control points, inflated by radius + `inflate` and rounded outward; `None` if they have left the range of the frame.
fn boxes(set: &CurveSet, inflate: f64, centre: &Vec3, size: f64) -> Option<Vec<Aabb>> {
    // Not while the set is 100 times larger or smaller than when the frame was fixed.
    let sane = size > 1e-290 && size < 1e290;
    let boxes: Vec<Aabb> = (0..set.len())
        .into_par_iter()
        .with_min_len(1024)
        .map(|i| {
            let [b0, b1, b2, b3] = &set.segments[i].b;
            // A negative range may shrink boxes, but not inside out.
            let r = Vec3::repeat((set.radius_of(i) + inflate).max(0.0));
            let lo = (b0.inf(b1).inf(&b2.inf(b3)) - centre - r) / size;
            let hi = (b0.sup(b1).sup(&b2.sup(b3)) - centre + r) / size;
            Aabb::new(
                Vector::new(below(lo.x), below(lo.y), below(lo.z)),
                Vector::new(above(hi.x), above(hi.y), above(hi.z)),
            )
        })
        .collect();
    let fits = |b: &Aabb| b.mins.min_element() > -100.0 && b.maxs.max_element() < 100.0;
    (sane && boxes.par_iter().with_min_len(1024).all(fits)).then_some(boxes)
}

/// A float safely below x: one f32 ulp covers the cast; 1e-13 of the frame covers the f64 roundings before it where x is near 0.
fn below(x: f64) -> f32 {
    (x as f32 - 1e-6 * f32::EPSILON).next_down()
}

/// A float safely above x.
fn above(x: f64) -> f32 {
    (x as f32 + 1e-6 * f32::EPSILON).next_up()
}

/// What [`BroadPhase::candidates`] must contain, by trying all pairs with the capsule bound: those not excluded and perhaps within
/// radius_i + radius_j + `range`. For tests; O(n²).
#[doc(hidden)]
#[must_use]
pub fn brute_force_candidates(set: &CurveSet, exclusion: &Exclusion, range: f64) -> Vec<[u32; 2]> {
    let capsules: Vec<Capsule> = set.segments.iter().map(Capsule::new).collect();
    let n = set.len();
    (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .filter(|&(i, j)| !exclusion.excluded(i, j) && near(set, &capsules, i, j, range))
        .map(|(i, j)| [i as u32, j as u32])
        .collect()
}
