//! Four f32 boxes side by side (structure of arrays), so that one box is tested against four at once: the leaves of the
//! broad phase's tree.

/// Number of boxes of a block, because a vector register holds four f32.
pub(crate) const WIDTH: usize = 4;

/// A box: lowest and highest corner.
pub(crate) type Box3 = ([f32; 3], [f32; 3]);

/// Four boxes, coordinate by coordinate; unused places are empty boxes that overlap nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Block {
    lo: [[f32; WIDTH]; 3],
    hi: [[f32; WIDTH]; 3],
}

impl Block {
    /// The first `count` (at most four) boxes.
    pub(crate) fn gather(count: usize, get: impl Fn(usize) -> Box3) -> Self {
        let mut block = Self { lo: [[f32::INFINITY; WIDTH]; 3], hi: [[f32::NEG_INFINITY; WIDTH]; 3] };
        for lane in 0..count.min(WIDTH) {
            let (lo, hi) = get(lane);
            for k in 0..3 {
                block.lo[k][lane] = lo[k];
                block.hi[k][lane] = hi[k];
            }
        }
        block
    }

    /// Smallest box around all four.
    pub(crate) fn union(&self) -> Box3 {
        let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for k in 0..3 {
            for lane in 0..WIDTH {
                lo[k] = lo[k].min(self.lo[k][lane]);
                hi[k] = hi[k].max(self.hi[k][lane]);
            }
        }
        (lo, hi)
    }

    /// Bit 4c + d is set if box c of this block overlaps box d of the other.
    #[inline(always)]
    pub(crate) fn overlaps_all(&self, other: &Self) -> u32 {
        let mut mask = 0;
        for c in 0..WIDTH {
            let lane = (std::array::from_fn(|k| self.lo[k][c]), std::array::from_fn(|k| self.hi[k][c]));
            mask |= other.overlaps(&lane) << (WIDTH * c);
        }
        mask
    }

    /// Bit d is set if box d overlaps (touches) the given one.
    #[inline(always)]
    pub(crate) fn overlaps(&self, (lo, hi): &Box3) -> u32 {
        let mut apart = [f32::NEG_INFINITY; WIDTH];
        for k in 0..3 {
            for d in 0..WIDTH {
                let (left, right) = (self.lo[k][d] - hi[k], lo[k] - self.hi[k][d]);
                let larger = if left > right { left } else { right };
                apart[d] = if larger > apart[d] { larger } else { apart[d] };
            }
        }
        u32::from(apart[0] <= 0.0)
            | u32::from(apart[1] <= 0.0) << 1
            | u32::from(apart[2] <= 0.0) << 2
            | u32::from(apart[3] <= 0.0) << 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Masks against single comparisons: touching, flat and missing boxes included.
    #[test]
    fn masks_are_the_overlaps() {
        let unit = |x: f32, y: f32, z: f32| ([x, y, z], [x + 1.0, y + 1.0, z + 1.0]);
        let flat = ([0.5; 3], [0.5, 0.5, 2.0]);
        let boxes = [unit(0.0, 0.0, 0.0), unit(1.0, 0.5, 0.0), unit(0.0, 2.5, 0.0), flat, unit(0.9, 0.0, 1.5)];
        let overlap = |a: &Box3, b: &Box3| (0..3).all(|k| a.0[k] <= b.1[k] && b.0[k] <= a.1[k]);
        let (mut seen, mut missed) = (0, 0);
        for (m, n) in (0..=5).flat_map(|m| (0..=5).map(move |n| (m, n))) {
            let (a, b) = (Block::gather(m, |k| boxes[k]), Block::gather(n, |k| boxes[4 - k]));
            let mask = a.overlaps_all(&b);
            for (c, d) in (0..WIDTH).flat_map(|c| (0..WIDTH).map(move |d| (c, d))) {
                let expected = c < m && d < n && overlap(&boxes[c], &boxes[4 - d]);
                assert_eq!(mask >> (WIDTH * c + d) & 1 == 1, expected, "{m} {n} {c} {d}");
                *(if expected { &mut seen } else { &mut missed }) += 1;
            }
        }
        assert!(seen > 50 && missed > 50, "{seen} {missed}");
        let whole = Block::gather(4, |k| boxes[k]).union();
        assert_eq!(whole, ([0.0; 3], [2.0, 3.5, 2.0]));
    }
}
