//! Bounding-volume tree over the *order along the curves*: leaf blocks are chains of four consecutive segments, a
//! parent joins four consecutive blocks. Boxes are f32 in coordinates relative to the whole set, rounded outward,
//! stored as structure of arrays (one coordinate of four boxes side by side), so that one box is tested against four at
//! once.
//!
//! A curve is already sorted by itself, so nothing is sorted to build the tree: a refit *is* a build, O(segments) in
//! one pass, its quality never decays, it depends on nothing but the present geometry, it cannot degenerate (the depth
//! is log₄ of the segments) and it takes any box, identical and flat ones included. Along-strand neighbours are
//! contiguous: a pair of blocks all of whose pairs are excluded is recognised by one comparison and never opened.
//! Memory: 24 bytes × (1 + 1/4 + 1/16 + …) = 32 bytes a segment.
//!
//! A rival of the engine's tree (parry3d's), measured in `benches/scaling.rs`: same pairs.

use rayon::prelude::*;

#[allow(unused_imports)] // its tests are the library's
#[path = "../src/contact/tree/boxes.rs"]
mod boxes;
use boxes::{Block, Box3, WIDTH};

/// At most this many segments under one task, as a power of [`WIDTH`]: 4⁷ = 16384, 512 kB of tree, so that two tasks'
/// boxes stay in the cache while they are compared.
const MAX_TASK_POWER: usize = 7;
/// Tasks are made smaller until there are this many, for the sake of several threads.
const MIN_TASKS: usize = 32;
/// Blocks per parallel piece of work when boxes are made.
const MIN_LEN: usize = 256;

/// The tree; see the module's head.
#[derive(Clone, Debug, Default)]
pub struct ChainTree {
    /// `levels[0]` holds the segments' boxes, `levels[l]` those of the blocks of level l − 1.
    levels: Vec<Vec<Block>>,
    len: usize,
}

impl ChainTree {
    /// Makes the tree of `len` boxes anew in the old buffers. Boxes must not hold NaN.
    pub(crate) fn refit(&mut self, len: usize, boxes: impl Fn(usize) -> Box3 + Sync) {
        self.len = len;
        let mut depth = 0;
        let mut count = len;
        while depth == 0 || count > 1 {
            let blocks = count.div_ceil(WIDTH);
            if self.levels.len() == depth {
                self.levels.push(Vec::new());
            }
            let (below, rest) = self.levels.split_at_mut(depth);
            let level = &mut rest[0];
            level.clear();
            match below.last() {
                None => (0..blocks)
                    .into_par_iter()
                    .with_min_len(MIN_LEN)
                    .map(|b| Block::gather(len - b * WIDTH, |lane| boxes(b * WIDTH + lane)))
                    .collect_into_vec(level),
                Some(children) => (0..blocks)
                    .into_par_iter()
                    .with_min_len(MIN_LEN)
                    .map(|b| Block::gather(count - b * WIDTH, |lane| children[b * WIDTH + lane].union()))
                    .collect_into_vec(level),
            }
            depth += 1;
            count = blocks;
        }
        self.levels.truncate(depth);
    }

    /// Number of independent tasks; together they see every pair once.
    pub fn num_tasks(&self) -> usize {
        self.len.div_ceil(1 << (2 * self.task_level() + 2))
    }

    /// Level whose blocks are tasks.
    fn task_level(&self) -> usize {
        let mut power = MAX_TASK_POWER;
        while power > 1 && self.len < MIN_TASKS << (2 * power) {
            power -= 1;
        }
        (power - 1).min(self.levels.len().saturating_sub(1))
    }

    /// Calls `emit(i, j)` for every pair of overlapping boxes i < j with i in the task's range and j > `far(i)`, in an
    /// order that depends on the geometry only. `far` must not decrease with i (pairs with j ≤ `far(i)` are not
    /// wanted).
    pub fn visit(&self, task: usize, far: &[u32], emit: &mut impl FnMut(u32, u32)) {
        if self.len == 0 {
            return;
        }
        let level = self.task_level();
        let mut walk = Walk { tree: self, far, emit };
        if !walk.excluded(level + 1, task, task) {
            walk.inside(level, task);
        }
        if self.levels.len() > level + 1 {
            let own = self.levels[level][task].union();
            walk.partners(self.levels.len() - 1, 0, (level, task), &own);
        }
    }
}

struct Walk<'a, F> {
    tree: &'a ChainTree,
    far: &'a [u32],
    emit: &'a mut F,
}

impl<F: FnMut(u32, u32)> Walk<'_, F> {
    /// True if every pair of nodes p ≤ q of 4^power segments each is unwanted: the last of q is unwanted with the first
    /// of p.
    #[inline]
    fn excluded(&self, power: usize, p: usize, q: usize) -> bool {
        let last = (((q + 1) << (2 * power)).min(self.tree.len)) - 1;
        last <= self.far[p << (2 * power)] as usize
    }

    /// Blocks at the task's level, after the task's own, that overlap it.
    fn partners(&mut self, level: usize, block: usize, (target, task): (usize, usize), own: &Box3) {
        let mut mask = self.tree.levels[level][block].overlaps(own);
        while mask != 0 {
            let child = block * WIDTH + mask.trailing_zeros() as usize;
            mask &= mask - 1;
            // Last block of the target level under this child.
            let last = ((child + 1) << (2 * (level - 1 - target))) - 1;
            if last <= task {
                continue;
            }
            if level - 1 == target {
                if !self.excluded(target + 1, task, child) {
                    self.between(target, task, child);
                }
            } else {
                self.partners(level - 1, child, (target, task), own);
            }
        }
    }

    /// Pairs inside one block.
    fn inside(&mut self, level: usize, p: usize) {
        let block = &self.tree.levels[level][p];
        for c in 0..WIDTH {
            let child = p * WIDTH + c;
            if level > 0 && child << (2 * level) < self.tree.len && !self.excluded(level, child, child) {
                self.inside(level - 1, child);
            }
        }
        // Bit 4c + d for children c < d.
        self.follow(level, p, p, block.overlaps_all(block) & 0b0000_1000_1100_1110);
    }

    /// Pairs between blocks p < q of one level.
    fn between(&mut self, level: usize, p: usize, q: usize) {
        let blocks = &self.tree.levels[level];
        let mask = blocks[p].overlaps_all(&blocks[q]);
        self.follow(level, p, q, mask);
    }

    #[inline(always)]
    fn follow(&mut self, level: usize, p: usize, q: usize, mask: u32) {
        let mut mask = self.trim(level, p, q, mask);
        // One loop over all sixteen bits: its end is the only branch the processor cannot foresee.
        while mask != 0 {
            let bit = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let (child, other) = (p * WIDTH + bit / WIDTH, q * WIDTH + bit % WIDTH);
            if level == 0 {
                (self.emit)(child as u32, other as u32);
            } else {
                self.between(level - 1, child, other);
            }
        }
    }

    /// Takes out the pairs of children that are unwanted altogether.
    #[inline(always)]
    fn trim(&self, level: usize, p: usize, q: usize, mask: u32) -> u32 {
        // Number of children (counted from the first of all) that are unwanted with the children c of p; grows with c.
        let cut = |c: usize| {
            let first = ((p * WIDTH + c) << (2 * level)).min(self.tree.len - 1);
            (self.far[first] as usize + 1) >> (2 * level)
        };
        if cut(WIDTH - 1) <= q * WIDTH {
            return mask;
        }
        let mut wanted = 0;
        for c in 0..WIDTH {
            let out = cut(c).saturating_sub(q * WIDTH).min(WIDTH);
            wanted |= ((0b1111 << out) & 0b1111) << (WIDTH * c);
        }
        mask & wanted
    }
}
