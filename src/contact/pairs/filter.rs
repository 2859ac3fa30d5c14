//! Capsule test of candidate pairs, four at a time: discards a pair only if a separating direction *proves* it too far
//! apart.
//!
//! For each pair the closest points of the two chords are computed (Ericson 2005, section 5.1.9, without branches);
//! their difference w serves as a direction only: the chords cannot be closer than the gap between their projections on
//! it,
//!
//! ```text
//!     |w| · distance ≥ min(w·a₀, w·a₁) − max(w·b₀, w·b₁)      for any w,
//! ```
//!
//! with equality for the true closest points. So rounding and nearly parallel chords may keep a pair in vain, but never
//! discard one wrongly.
//!
//! Lanes are arrays of four f32 in structure-of-arrays order, which the compiler turns into vector instructions (f32
//! has twice the lanes and a far cheaper division). Only differences of f64 coordinates are cast, so offsets do not
//! matter, and the projections are shortened by [`SAFETY`]: pairs within 2e-6 of their size of the limit are kept.

use crate::contact::curves::input::{CurveShape, Strand, Strands};
use crate::contact::curves::radius::Radius;
use crate::contact::measures::USUAL;
use crate::math::Vec3;

type Lane = [f32; LANES];

/// Pairs tested together, because a vector register holds four f32.
const LANES: usize = 4;

/// Bound of the rounding of the projections, relative to |w|₁ × the largest component, because that is more than 3
/// casts, 3 products and 5 sums make.
const SAFETY: f32 = 16.0 * f32::EPSILON;

/// Largest ratio of size and radius of pairs that are tested, because f32 holds its fourth power; pairs beyond are
/// kept.
const LARGEST: f64 = 1e7;

/// Vectors of four pairs.
#[derive(Clone, Copy, Default)]
struct Vectors([Lane; 3]);

impl Vectors {
    #[inline(always)]
    fn set(&mut self, lane: usize, v: &Vec3, unit: f64) {
        for k in 0..3 {
            self.0[k][lane] = (v[k] * unit) as f32;
        }
    }

    #[inline(always)]
    fn dot(&self, other: &Self) -> Lane {
        let mut sum = [0.0; LANES];
        for k in 0..3 {
            for l in 0..LANES {
                sum[l] += self.0[k][l] * other.0[k][l];
            }
        }
        sum
    }
}

/// Up to four pairs waiting for their test.
#[derive(Default)]
struct Batch {
    pairs: [[u32; 2]; LANES],
    count: usize,
    /// Chords and difference of the starts, in units chosen once for all pairs.
    d: Vectors,
    e: Vectors,
    r: Vectors,
    /// Largest allowed distance of the chords.
    limit: Lane,
}

impl Batch {
    /// Bit l is set unless pair l is provably farther apart than its limit.
    #[inline(always)]
    fn test(&self) -> u32 {
        let (dd, ee, de) = (self.d.dot(&self.d), self.e.dot(&self.e), self.d.dot(&self.e));
        let (dr, er) = (self.d.dot(&self.r), self.e.dot(&self.r));
        let (mut s, mut t) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            s[l] = clamped((de[l] * er[l] - dr[l] * ee[l]) / (dd[l] * ee[l] - de[l] * de[l]));
        }
        for l in 0..LANES {
            t[l] = clamped((er[l] + de[l] * s[l]) / ee[l]);
        }
        for l in 0..LANES {
            s[l] = clamped((de[l] * t[l] - dr[l]) / dd[l]);
        }
        let mut w = self.r;
        let (mut size, mut sum) = ([0.0; LANES], [0.0; LANES]);
        for k in 0..3 {
            for l in 0..LANES {
                w.0[k][l] += self.d.0[k][l] * s[l] - self.e.0[k][l] * t[l];
                sum[l] += w.0[k][l].abs();
                size[l] =
                    larger(larger(self.d.0[k][l].abs(), self.e.0[k][l].abs()), larger(self.r.0[k][l].abs(), size[l]));
            }
        }
        // Projections on w of the second chord's end, the first chord's start and its end, from the second's start.
        let (we, wr, wd, ww) = (w.dot(&self.e), w.dot(&self.r), w.dot(&self.d), w.dot(&w));
        let mut excess = [0.0; LANES];
        for l in 0..LANES {
            let gap = wr[l] - larger(-wd[l], 0.0) - larger(we[l], 0.0) - SAFETY * size[l] * sum[l];
            // Positive only if gap > 0 and gap² > limit² |w|²; the last factor covers the roundings of this line.
            let gap = larger(gap, 0.0);
            excess[l] = gap * gap * (1.0 - SAFETY) - self.limit[l] * self.limit[l].abs() * ww[l];
        }
        let mut far = 0;
        for l in 0..LANES {
            // Pairs of sizes whose fourth powers overflow f32 are kept.
            let usual = size[l] > 1.0 / LARGEST as f32 && size[l] < LARGEST as f32;
            far |= u32::from(excess[l] > 0.0 && usual) << l;
        }
        !far
    }
}

/// In \[0, 1\]; 0 for NaN (which fails both comparisons).
#[inline(always)]
fn clamped(x: f32) -> f32 {
    let x = larger(x, 0.0);
    if x < 1.0 { x } else { 1.0 }
}

/// The larger, the second if either is NaN: one instruction, unlike `max`.
#[inline(always)]
fn larger(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}

/// Appends to `out`, in order, the pairs whose capsules are not provably farther apart than both radii + `reach` \[L\].
/// `bulges` holds the capsule radius of each segment, or nothing if all are straight.
pub(crate) fn keep_near(strands: &Strands, bulges: &[f64], reach: f64, pairs: &[[u32; 2]], out: &mut Vec<[u32; 2]>) {
    let unit = 1.0 / strands.largest_radius();
    let sane = USUAL.contains(&unit);
    let limit = |distance: f64| {
        let limit = distance * unit;
        if sane && limit < LARGEST { (limit as f32).next_up() } else { f32::INFINITY }
    };
    // The usual case of one polyline with one radius, without look-up per pair.
    if let [Strand { shape: CurveShape::Polyline(points), radius: Radius::Constant(radius), .. }] = strands.curves[..] {
        let ends = |k: usize| (points[k], points[if k + 1 < points.len() { k + 1 } else { 0 }]);
        let limit = limit(radius + radius + reach);
        return filter(ends, |_, _| limit, unit, pairs, out);
    }
    let bulge = |k: usize| if bulges.is_empty() { 0.0 } else { bulges[k] };
    let limit = |a: usize, b: usize| limit(strands.reach_of(a) + strands.reach_of(b) + reach + (bulge(a) + bulge(b)));
    filter(|k| strands.ends(k), limit, unit, pairs, out);
}

#[inline(always)]
fn filter(
    ends: impl Fn(usize) -> (Vec3, Vec3),
    limit: impl Fn(usize, usize) -> f32,
    unit: f64,
    pairs: &[[u32; 2]],
    out: &mut Vec<[u32; 2]>,
) {
    let mut batch = Batch::default();
    for &[i, j] in pairs {
        let (a, b) = (i as usize, j as usize);
        let ((a0, a1), (b0, b1)) = (ends(a), ends(b));
        let l = batch.count;
        batch.d.set(l, &(a1 - a0), unit);
        batch.e.set(l, &(b1 - b0), unit);
        batch.r.set(l, &(a0 - b0), unit);
        batch.pairs[l] = [i, j];
        batch.limit[l] = limit(a, b);
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
