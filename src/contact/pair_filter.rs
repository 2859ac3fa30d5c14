//! Capsule test of candidate pairs, four at a time: discards a pair only if a separating direction *proves* it too far apart.
//!
//! For each pair the closest points of the two chords are computed (Ericson 2005, section 5.1.9, without branches); their difference w is then
//! only used as a direction: the chords cannot come closer than the gap between their projections on it,
//!
//! ```text
//!     |w| · distance ≥ min(w·a₀, w·a₁) − max(w·b₀, w·b₁)      for any w,
//! ```
//!
//! with equality for the true closest points. So rounding and nearly parallel chords can keep a pair that should go, never the reverse.
//! Lanes are arrays of four f64 in structure-of-arrays order, which the compiler turns into vector instructions.

use super::input::Strands;
use crate::math::Vec3;

/// Pairs tested together.
const LANES: usize = 4;
type Lane = [f64; LANES];

/// Relative roundings of the projections, with room to spare.
const SAFETY: f64 = 32.0 * f64::EPSILON;

/// Vectors of four pairs.
#[derive(Clone, Copy, Default)]
struct Vectors {
    x: Lane,
    y: Lane,
    z: Lane,
}

impl Vectors {
    #[inline(always)]
    fn set(&mut self, lane: usize, v: &Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (v.x, v.y, v.z);
    }

    #[inline(always)]
    fn dot(&self, other: &Self) -> Lane {
        std::array::from_fn(|l| self.x[l] * other.x[l] + self.y[l] * other.y[l] + self.z[l] * other.z[l])
    }

    /// self + d s − e t.
    #[inline(always)]
    fn combine(&self, d: &Self, s: &Lane, e: &Self, t: &Lane) -> Self {
        let mix = |r: &Lane, d: &Lane, e: &Lane| std::array::from_fn(|l| r[l] + d[l] * s[l] - e[l] * t[l]);
        Self { x: mix(&self.x, &d.x, &e.x), y: mix(&self.y, &d.y, &e.y), z: mix(&self.z, &d.z, &e.z) }
    }
}

/// num/den clamped to \[0, 1\]; 0 for 0/0 (NaN fails both comparisons).
#[inline(always)]
fn clamped(num: f64, den: f64) -> f64 {
    let q = num / den;
    let q = if q > 0.0 { q } else { 0.0 };
    if q < 1.0 { q } else { 1.0 }
}

/// Up to four pairs waiting for their test.
struct Batch {
    pairs: [[u32; 2]; LANES],
    count: usize,
    /// Chords and difference of the starts, and the largest allowed distance of the chords.
    d: Vectors,
    e: Vectors,
    r: Vectors,
    limit: Lane,
    /// Largest component of the three.
    size: Lane,
}

impl Batch {
    /// Bit l is set unless pair l is provably farther apart than its limit.
    #[inline(always)]
    fn test(&self) -> u32 {
        let (dd, ee, de) = (self.d.dot(&self.d), self.e.dot(&self.e), self.d.dot(&self.e));
        let (dr, er) = (self.d.dot(&self.r), self.e.dot(&self.r));
        let mut s: Lane = std::array::from_fn(|l| clamped(de[l] * er[l] - dr[l] * ee[l], dd[l] * ee[l] - de[l] * de[l]));
        let t: Lane = std::array::from_fn(|l| clamped(er[l] + de[l] * s[l], ee[l]));
        s = std::array::from_fn(|l| clamped(de[l] * t[l] - dr[l], dd[l]));
        let w = self.r.combine(&self.d, &s, &self.e, &t);
        // Projections on w of the second chord's start (0), its end, and the first chord's ends.
        let (we, wr, wd) = (w.dot(&self.e), w.dot(&self.r), w.dot(&self.d));
        let ww = w.dot(&w);
        let mut keep = 0;
        for l in 0..LANES {
            let near = if wd[l] < 0.0 { wr[l] + wd[l] } else { wr[l] };
            let apart = near - if we[l] > 0.0 { we[l] } else { 0.0 };
            let rounding = SAFETY * self.size[l] * (w.x[l].abs() + w.y[l].abs() + w.z[l].abs());
            let gap = apart - rounding;
            let far = gap > 0.0 && (self.limit[l] < 0.0 || gap * gap > self.limit[l] * self.limit[l] * ww[l] * (1.0 + SAFETY));
            keep |= u32::from(!far) << l;
        }
        keep
    }
}

/// Appends to `out`, in order, the pairs whose capsules are not provably farther apart than both radii + `reach` \[L\]. `bulges` holds the
/// capsule radius of each segment, or nothing if all are straight.
pub(crate) fn keep_near(strands: &Strands, bulges: &[f64], reach: f64, pairs: &[[u32; 2]], out: &mut Vec<[u32; 2]>) {
    let mut batch = Batch {
        pairs: [[0; 2]; LANES],
        count: 0,
        d: Vectors::default(),
        e: Vectors::default(),
        r: Vectors::default(),
        limit: [0.0; LANES],
        size: [0.0; LANES],
    };
    // Squares of anything representable would overflow or vanish beyond these units: such pairs are kept.
    let usual = 1e-130..1e130;
    for &[i, j] in pairs {
        let (a, b) = (i as usize, j as usize);
        let ((a0, a1), (b0, b1)) = (strands.ends(a), strands.ends(b));
        let (d, e, r) = (a1 - a0, b1 - b0, a0 - b0);
        let l = batch.count;
        batch.d.set(l, &d);
        batch.e.set(l, &e);
        batch.r.set(l, &r);
        batch.pairs[l] = [i, j];
        let radii = strands.radius_of(a) + strands.radius_of(b) + reach;
        let bulge = if bulges.is_empty() { 0.0 } else { bulges[a] + bulges[b] };
        // A pair out of the usual range of sizes gets no limit.
        let size = d.amax().max(e.amax()).max(r.amax());
        batch.limit[l] = if usual.contains(&size) { radii + bulge } else { f64::MAX };
        batch.size[l] = size;
        batch.count += 1;
        if batch.count == LANES {
            flush(&mut batch, out);
        }
    }
    flush(&mut batch, out);
}

#[inline(always)]
fn flush(batch: &mut Batch, out: &mut Vec<[u32; 2]>) {
    let mut mask = batch.test() & ((1 << batch.count) - 1);
    while mask != 0 {
        out.push(batch.pairs[mask.trailing_zeros() as usize]);
        mask &= mask - 1;
    }
    batch.count = 0;
}
