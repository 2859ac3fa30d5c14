//! Leaves of up to four consecutive segments, their boxes, and the tree over them (parry3d's; the only file that names
//! it).

use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace, TraversalAction};

use crate::contact::curves::input::{Strands, lower, upper};
use crate::contact::measures::{SUM_ROUNDING, USUAL};
use crate::contact::tree::boxes::{Block, Box3, WIDTH};
use crate::contact::tree::exclusion::bytes;
use crate::math::parallel::CHEAP;
use crate::math::{Vec3, parallel};

/// Below this many leaves all their pairs are tested, because a tree costs more than it saves (and the library's
/// builder does not accept 1 or 2 leaves).
const SMALL: usize = 8;
/// Growth of the inner boxes relative to the leaves after which a tree is rebuilt, because a build costs more than a
/// refit.
const SPOILT: f64 = 1.5;

/// Leaves and the tree over them.
#[derive(Default)]
pub(super) struct Leaves {
    /// First segment of each leaf, and the number of segments.
    pub(super) firsts: Vec<u32>,
    /// Boxes of each leaf's segments.
    pub(super) blocks: Vec<Block>,
    /// `None` if there are few leaves, or sizes beyond the range of f64: then all pairs of leaves are tested.
    tree: Option<Tree>,
    workspace: BvhWorkspace,
}

struct Tree {
    bvh: Bvh,
    /// [`looseness`] right after the build.
    fresh: f64,
}

impl Leaves {
    /// Boxes, inflated by the radius and `inflate`, and the tree.
    pub(super) fn refit(&mut self, strands: &Strands, inflate: f64) {
        let firsts = leaves(strands);
        if firsts != self.firsts {
            self.firsts = firsts;
            self.tree = None;
        }
        let (centre, size) = frame(strands, inflate);
        let firsts = &self.firsts;
        let num_leaves = firsts.len() - 1;
        let block = |leaf: usize| {
            let first = firsts[leaf] as usize;
            Block::gather(firsts[leaf + 1] as usize - first, |lane| {
                // A negative range shrinks boxes to a point at most.
                let r = (strands.reach_of(first + lane) + inflate).max(0.0);
                outward(strands.bounds(first + lane), r, &centre, size)
            })
        };
        self.blocks.resize(num_leaves, Block::default());
        parallel::each(&mut self.blocks, CHEAP / WIDTH, &|leaf, place| *place = block(leaf));
        if num_leaves < SMALL || !USUAL.contains(&size) {
            self.tree = None;
        } else {
            self.fit_tree();
        }
    }

    /// Memory, bytes, without the scratch of the tree's library.
    pub(super) fn memory(&self) -> usize {
        bytes(&self.firsts) + bytes(&self.blocks) + self.tree.as_ref().map_or(0, |t| t.bvh.heap_memory_size())
    }

    /// Fits the tree to the present blocks: refits it, or builds it if there is none or it has grown too loose.
    fn fit_tree(&mut self) {
        let aabb = |block: &Block| {
            let (lo, hi) = block.union();
            Aabb::new(Vector::from_array(lo), Vector::from_array(hi))
        };
        if let Some(tree) = &mut self.tree {
            for (leaf, block) in self.blocks.iter().enumerate() {
                tree.bvh.insert_or_update_partially(aabb(block), leaf as u32, 0.0);
            }
            fit(&mut tree.bvh, &mut self.workspace);
            if looseness(&tree.bvh) <= SPOILT * tree.fresh {
                return;
            }
        }
        let boxes: Vec<Aabb> = self.blocks.iter().map(aabb).collect();
        let mut bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        // Sorts the nodes in the order of the traversal.
        fit(&mut bvh, &mut self.workspace);
        let fresh = looseness(&bvh);
        self.tree = Some(Tree { bvh, fresh });
    }

    /// Pairs p < q of leaves whose boxes overlap and whose segments are not all excluded, in the order of the tree:
    /// neighbours in space follow one another, so that their boxes and points are still in the cache (sorted by leaf,
    /// every second one would be a cache miss in a crowd).
    ///
    /// `far`: the last segment of the same curve excluded with each segment.
    pub(super) fn pairs(&mut self, far: &[u32]) -> Vec<[u32; 2]> {
        let firsts = &self.firsts;
        let num_leaves = (firsts.len() - 1) as u32;
        // If the last segment of q is excluded with the first of p, all pairs between are.
        let wanted = |a: u32, b: u32| {
            let (p, q) = if a < b { (a, b) } else { (b, a) };
            (firsts[q as usize + 1] - 1 > far[firsts[p as usize] as usize]).then_some([p, q])
        };
        let Some(tree) = &self.tree else {
            return (0..num_leaves).flat_map(|p| (p + 1..num_leaves).filter_map(move |q| wanted(p, q))).collect();
        };
        #[cfg(feature = "parallel")]
        if !parallel::is_serial() {
            // The same pairs in the same order.
            let overlapping = tree.bvh.traverse_bvtt_single_tree_parallel::<false>();
            return overlapping.iter().filter_map(|&(a, b)| wanted(a, b)).collect();
        }
        let mut found = Vec::new();
        tree.bvh.traverse_bvtt_single_tree::<false>(&mut self.workspace, &mut |a, b| found.extend(wanted(a, b)));
        found
    }
}

/// First segment of each leaf, and the number of segments: each curve in runs of four.
fn leaves(strands: &Strands) -> Vec<u32> {
    let mut firsts = Vec::with_capacity(strands.len().div_ceil(WIDTH) + strands.curves.len() + 1);
    for curve in &strands.curves {
        firsts.extend((curve.first..curve.first + curve.count).step_by(WIDTH).map(|i| i as u32));
    }
    firsts.push(strands.len() as u32);
    firsts
}

/// Boxes of all nodes from those of the leaves, by as many threads as there are.
fn fit(bvh: &mut Bvh, workspace: &mut BvhWorkspace) {
    #[cfg(feature = "parallel")]
    if !parallel::is_serial() {
        return bvh.refit_parallel(workspace);
    }
    bvh.refit(workspace);
}

/// Surface of the inner boxes relative to that of the leaves: the cost of a traversal, in any unit.
fn looseness(bvh: &Bvh) -> f64 {
    let (mut inner, mut leaves) = (0.0, 0.0);
    bvh.traverse(|node| {
        let e = node.maxs() - node.mins();
        let surface = f64::from(e.x * e.y + e.y * e.z + e.z * e.x);
        *(if node.is_leaf() { &mut leaves } else { &mut inner }) += surface;
        TraversalAction::Continue
    });
    inner / leaves
}

/// Centre and half-size of everything, inflation included.
fn frame(strands: &Strands, inflate: f64) -> (Vec3, f64) {
    let none = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let grow = |(lo, hi): (Vec3, Vec3), p: &Vec3| (lower(&lo, p), upper(&hi, p));
    let join = |a: (Vec3, Vec3), b: (Vec3, Vec3)| (lower(&a.0, &b.0), upper(&a.1, &b.1));
    let of_run = |run: &[Vec3]| {
        let parts = parallel::map_ranges(run.len(), CHEAP, &|part| run[part].iter().fold(none, grow));
        parts.into_iter().fold(none, join)
    };
    let (lo, hi) = strands.control_points().map(of_run).fold(none, join);
    let radius = strands.largest_radius();
    // Halved first: the sum of two huge coordinates may overflow.
    let size = (hi * 0.5 - lo * 0.5).amax() + (radius + inflate).max(0.0);
    (lo * 0.5 + hi * 0.5, size)
}

/// f32 box in the frame, grown by `r` and rounded outward. In a frame too small or large for f64 everything is one box.
#[inline]
fn outward((lo, hi): (Vec3, Vec3), r: f64, centre: &Vec3, size: f64) -> Box3 {
    if !USUAL.contains(&size) {
        return ([-2.0; 3], [2.0; 3]);
    }
    let scale = 1.0 / size;
    // Coordinates are within ±1 (to rounding): 2⁻²⁴ covers the cast, 1e-13 the f64 roundings before it.
    let grow = r * scale + (0.5 * f64::from(f32::EPSILON) + SUM_ROUNDING);
    let below = |k: usize| ((lo[k] - centre[k]) * scale - grow) as f32;
    let above = |k: usize| ((hi[k] - centre[k]) * scale + grow) as f32;
    (std::array::from_fn(below), std::array::from_fn(above))
}
