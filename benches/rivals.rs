//! Rivals of the detector on one polyline: all pairs, a uniform grid, parry3d's tree used plainly (one leaf a segment),
//! and a tree along the curve.

use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use supercoil::internals::capsule::segment_distance;
use supercoil::math::Vec3;

#[path = "chain_tree.rs"]
mod chain_tree;

fn bounds(points: &[Vec3], r: f64, i: usize) -> (Vec3, Vec3) {
    let (a, b) = (&points[i], &points[i + 1]);
    (a.inf(b) - Vec3::repeat(r), a.sup(b) + Vec3::repeat(r))
}

/// Whether the boxes of two segments, inflated by r, overlap.
pub fn boxes_overlap(points: &[Vec3], r: f64, i: usize, j: usize) -> bool {
    let ((lo_i, hi_i), (lo_j, hi_j)) = (bounds(points, r, i), bounds(points, r, j));
    (0..3).all(|k| lo_i[k] <= hi_j[k] && lo_j[k] <= hi_i[k])
}

/// What no method can do without, as plain as can be: the box of every segment is written (f32, rounded outward), one
/// after the other.
pub fn write_boxes(points: &[Vec3], r: f64, boxes: &mut Vec<[f32; 6]>) -> usize {
    boxes.clear();
    boxes.extend((0..points.len() - 1).map(|i| {
        let (low, high) = bounds(points, r, i);
        let down = |x: f64| (x as f32).next_down();
        let up = |x: f64| (x as f32).next_up();
        [down(low.x), down(low.y), down(low.z), up(high.x), up(high.y), up(high.z)]
    }));
    boxes.len()
}

/// For every segment the box of another is read, in no order; nothing is looked for. Returns how many overlap.
pub fn read_boxes(boxes: &[[f32; 6]]) -> usize {
    let overlap = |a: &[f32; 6], b: &[f32; 6]| (0..3).all(|k| a[k] <= b[k + 3] && b[k] <= a[k + 3]);
    let (mut state, mut count) = (1_u64, 0);
    for own in boxes {
        // Knuth's linear congruential generator; its upper bits are random.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let other = ((state >> 32) * boxes.len() as u64) >> 32;
        count += usize::from(overlap(own, &boxes[other as usize]));
    }
    count
}

fn touching(points: &[Vec3], r: f64, i: usize, j: usize) -> bool {
    boxes_overlap(points, r, i, j) && segment_distance(&points[i], &points[i + 1], &points[j], &points[j + 1]) < 2.0 * r
}

/// All pairs more than `neighbours` apart along the line and closer than 2r, by trying all.
pub fn brute_force(points: &[Vec3], r: f64, neighbours: usize) -> Vec<[u32; 2]> {
    let n = points.len() - 1;
    let mut found = Vec::new();
    for i in 0..n {
        found.extend((i + neighbours + 1..n).filter(|&j| touching(points, r, i, j)).map(|j| [i as u32, j as u32]));
    }
    found
}

/// The same pairs by a uniform grid: segments sorted by the cell of their middle, cells as wide as the largest box;
/// each cell is compared with itself and the 13 following neighbours, found by walking five rows of cells at once (no
/// hashing). Sorted.
pub fn grid(points: &[Vec3], r: f64, neighbours: usize) -> Vec<[u32; 2]> {
    let n = points.len() - 1;
    let middle = |i: usize| (points[i] + points[i + 1]) * 0.5;
    let edge = points.windows(2).map(|w| (w[1] - w[0]).amax()).fold(0.0, f64::max);
    let cell = edge + 2.0 * r;
    let low = points.iter().fold(points[0], |l, p| l.inf(p)) - Vec3::repeat(1.5 * cell);
    // 21 bits a coordinate: x lowest, so that neighbours in x follow one another.
    let key = |i: usize| -> u64 {
        let c = (middle(i) - low) / cell;
        (c.x as u64) | (c.y as u64) << 21 | (c.z as u64) << 42
    };
    let mut cells: Vec<(u64, u32)> = (0..n).map(|i| (key(i), i as u32)).collect();
    cells.sort_unstable();
    let mut found = Vec::new();
    let mut test = |a: u32, b: u32| {
        let (i, j) = (a.min(b), a.max(b));
        if (j - i) as usize > neighbours && touching(points, r, i as usize, j as usize) {
            found.push([i, j]);
        }
    };
    // Cells of the same row: up to one further in x.
    for k in 0..n {
        let mut m = k + 1;
        while m < n && cells[m].0 <= cells[k].0 + 1 {
            test(cells[k].1, cells[m].1);
            m += 1;
        }
    }
    // The four following rows: y + 1, and z + 1 with y − 1, y, y + 1.
    for step in [1 << 21, (1 << 42) - (1 << 21), 1 << 42, (1 << 42) + (1 << 21)] {
        let mut first = 0;
        for k in 0..n {
            let target: u64 = cells[k].0 + step;
            while first < n && cells[first].0 + 1 < target {
                first += 1;
            }
            let mut m = first;
            while m < n && cells[m].0 <= target + 1 {
                test(cells[k].1, cells[m].1);
                m += 1;
            }
        }
    }
    found.sort_unstable();
    found
}

/// parry3d's tree, one leaf a segment, binned build; lists box pairs (neighbours included, unsorted).
pub struct Tree {
    bvh: Bvh,
    workspace: BvhWorkspace,
    len: usize,
}

fn leaf(points: &[Vec3], r: f64, i: usize) -> Aabb {
    let (lo, hi) = bounds(points, r, i);
    let cast = |v: Vec3| Vector::new(v.x as f32, v.y as f32, v.z as f32);
    Aabb::new(cast(lo), cast(hi))
}

impl Tree {
    /// Builds it.
    pub fn new(points: &[Vec3], r: f64) -> Self {
        let len = points.len() - 1;
        let leaves: Vec<Aabb> = (0..len).map(|i| leaf(points, r, i)).collect();
        Self { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves), workspace: BvhWorkspace::default(), len }
    }

    /// Number of segments.
    pub fn num_leaves(&self) -> usize {
        self.len
    }

    /// Refits all leaves and counts the pairs.
    pub fn refit_and_list(&mut self, points: &[Vec3], r: f64) -> usize {
        for i in 0..self.len {
            self.bvh.insert_or_update_partially(leaf(points, r, i), i as u32, 0.0);
        }
        self.bvh.refit_without_opt();
        let mut pairs = Vec::new();
        self.bvh.traverse_bvtt_single_tree::<false>(&mut self.workspace, &mut |i, j| pairs.push((i, j)));
        pairs.len()
    }
}

/// A tree over the order along the curve, unscaled coordinates rounded to f32; lists box pairs, neighbours left out.
#[derive(Default)]
pub struct Chain {
    tree: chain_tree::ChainTree,
    far: Vec<u32>,
    found: Vec<[u32; 2]>,
}

impl Chain {
    /// Makes all boxes anew and counts the pairs more than `neighbours` apart.
    pub fn refit_and_list(&mut self, points: &[Vec3], r: f64, neighbours: usize) -> usize {
        let len = points.len() - 1;
        self.tree.refit(len, |i| {
            let (lo, hi) = bounds(points, r, i);
            (std::array::from_fn(|k| lo[k] as f32), std::array::from_fn(|k| hi[k] as f32))
        });
        self.far.clear();
        self.far.extend((0..len).map(|i| (i + neighbours).min(len - 1) as u32));
        self.found.clear();
        for task in 0..self.tree.num_tasks() {
            self.tree.visit(task, &self.far, &mut |i, j| self.found.push([i, j]));
        }
        self.found.len()
    }
}
