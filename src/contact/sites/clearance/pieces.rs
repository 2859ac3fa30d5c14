//! Bounds for one pair of cubic pieces; the mathematics is in the parent's header.

use crate::contact::curves::curve::Cubic;
use crate::contact::measures::{MAX_STEPS, SUM_ROUNDING};
use crate::contact::projection::stationarity;
use crate::math::Vec3;
use crate::math::bernstein::{Roots, derivative, eval, product_with_quadratic, roots};

/// Two pieces in coordinates relative to the second's start and the pair's size.
pub(super) struct PowerForm {
    pub(super) a: Cubic,
    pub(super) b: Cubic,
    pub(super) scale: f64,
}

/// Lower bound of the distance between two pieces \[L\], and where its model is smallest (piece parameters in \[0,
/// 1\]).
pub(super) struct DistanceBound {
    pub(super) lower: f64,
    pub(super) at_place: f64,
    pub(super) u: f64,
    pub(super) v: f64,
}

impl PowerForm {
    pub(super) fn new(a: &Cubic, b: &Cubic, u: [f64; 2], v: [f64; 2]) -> Self {
        let origin = b.b[0];
        let (a, b) = (a.b.map(|p| p - origin), b.b.map(|p| p - origin));
        let scale = a.iter().chain(&b).map(Vec3::amax).fold(0.0, f64::max);
        let scale = if scale > 0.0 { scale } else { 1.0 };
        let unit = |p: [Vec3; 4]| Cubic { b: p.map(|x| x / scale) };
        Self { a: part(&unit(a), u), b: part(&unit(b), v), scale }
    }

    /// Lower bound of ½∂²D/∂v² over the box (scaled units): Bernstein coefficients in v, control points of a (D's
    /// v-derivatives are linear in a, so its hull's corners suffice).
    pub(super) fn convexity(&self) -> f64 {
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        for x in &self.a.b {
            // stationarity() is a third of (b − x)·b′.
            for c in &derivative(&stationarity(&self.b, x))[..5] {
                least = least.min(3.0 * c);
                largest = largest.max(c.abs());
            }
        }
        least - SUM_ROUNDING * largest
    }

    /// Parameters of a, ascending, where its foot on b passes an end of b: roots of (b(v_end) − a(u))·b′(v_end), linear
    /// in the cubic a.
    pub(super) fn foot_leaves(&self) -> Vec<f64> {
        let mut cuts = Vec::new();
        let mut found = Roots::new();
        let ends = [(self.b.b[0], self.b.start_tangent()), (self.b.b[3], self.b.end_tangent())];
        for (end, tangent) in ends {
            roots(&self.a.b.map(|p| (end - p).dot(&tangent)), &mut found);
            cuts.extend_from_slice(found.as_slice());
        }
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// v minimising |b(v) − x|, for b convex as seen from x: Newton in a shrinking bracket, clamped to \[0, 1\].
    fn foot(&self, x: &Vec3) -> f64 {
        let q = stationarity(&self.b, x);
        if q[0] >= 0.0 {
            return 0.0;
        }
        if q[5] <= 0.0 {
            return 1.0;
        }
        let slope = derivative(&q);
        let (mut lo, mut hi) = (0.0, 1.0);
        let mut v = q[0] / (q[0] - q[5]);
        // The bound holds for any v, so convergence is not required.
        for _ in 0..MAX_STEPS {
            let value = eval(&q, v);
            if value < 0.0 {
                lo = v
            } else {
                hi = v
            }
            let next = v - value / eval(&slope[..5], v);
            let next = if next >= lo && next <= hi { next } else { 0.5 * (lo + hi) };
            if (next - v).abs() <= SUM_ROUNDING {
                return next;
            }
            v = next;
        }
        v
    }

    /// The bound of the parent's header with convexity `m` > 0.
    pub(super) fn fourth_order(&self, m: f64) -> DistanceBound {
        let mut v = [self.foot(&self.a.b[0]), self.foot(&self.a.b[3])];
        // A foot that is at the end up to rounding of the cut counts as clamped.
        let middle = self.foot(&self.a.point(0.5));
        if middle == 0.0 || middle == 1.0 {
            v = [middle; 2];
        }
        let on_b = self.b.restrict(v[0], v[1]);
        let w = Cubic { b: std::array::from_fn(|k| on_b.b[k] - self.a.b[k]) };
        // |w|² at its stationary points and ends.
        let size_sq = w.b.iter().map(Vec3::norm_squared).fold(0.0, f64::max);
        let mut found = Roots::new();
        roots(&stationarity(&w, &Vec3::zeros()), &mut found);
        let (mut least, mut u) = (w.b[0].norm_squared(), 0.0);
        for &t in found.as_slice().iter().chain(&[1.0]) {
            let value = w.point(t).norm_squared();
            if value < least {
                (least, u) = (value, t);
            }
        }
        // Q in degree 5: cubic w times the quadratic b′ on [v0, v1].
        let e = self.b.edges().map(|e| e * 3.0);
        let blossom = |s: f64, t: f64| {
            let (p, q) = (e[0] * (1.0 - s) + e[1] * s, e[1] * (1.0 - s) + e[2] * s);
            p * (1.0 - t) + q * t
        };
        let slope = [blossom(v[0], v[0]), blossom(v[0], v[1]), blossom(v[1], v[1])];
        let harmful = harmful_slope(&w, &slope, v);
        // Coordinates are of order 1, so each component of w carries a few ulp of 1.
        let lower_sq = least - harmful * harmful / m - SUM_ROUNDING * (size_sq + size_sq.sqrt());
        let place = v[0] + (v[1] - v[0]) * u;
        DistanceBound {
            lower: self.scale * lower_sq.max(0.0).sqrt(),
            at_place: self.scale * least.sqrt(),
            u,
            v: place.clamp(0.0, 1.0),
        }
    }
}

/// Largest |Q| that can lower the distance: both signs inside, one sign where the foot rests against an end of v.
fn harmful_slope(w: &Cubic, slope: &[Vec3; 3], v: [f64; 2]) -> f64 {
    let q = product_with_quadratic(|i, j| w.b[i].dot(&slope[j]));
    let (min, max) = q.iter().fold((0.0_f64, 0.0_f64), |(lo, hi), &c| (lo.min(c), hi.max(c)));
    match v {
        // v can only grow from 0: harmful if that shortens (Q < 0); and shrink from 1: if Q > 0.
        [0.0, 0.0] => -min,
        [1.0, 1.0] => max,
        _ => max.max(-min),
    }
}

fn part(c: &Cubic, range: [f64; 2]) -> Cubic {
    if range == [0.0, 1.0] { *c } else { c.restrict(range[0], range[1]) }
}

pub(super) fn at(range: [f64; 2], t: f64) -> f64 {
    (range[0] * (1.0 - t) + range[1] * t).clamp(range[0], range[1])
}

pub(super) fn halves(range: [f64; 2]) -> [[f64; 2]; 2] {
    let middle = 0.5 * (range[0] + range[1]);
    [[range[0], middle], [middle, range[1]]]
}

pub(super) fn extent(c: &Cubic) -> f64 {
    c.edges().iter().map(Vec3::norm).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    /// The bound lies below the sampled distance of curved pieces, also where |w| alone does not, and close to it.
    #[test]
    fn fourth_order_bound_is_a_bound_and_tight() {
        let mut numbers = Random(1);
        let mut random = move || numbers.unit();
        let (mut convex, mut model_above) = (0, 0);
        for _ in 0..3000 {
            let mut vector = |size: f64| Vec3::new(random(), random(), random()) * size;
            let (offset, tilt) = (vector(1.0), vector(0.4));
            let a =
                Cubic::from_hermite(Vec3::zeros(), Vec3::x() + vector(0.7), Vec3::x() + tilt, Vec3::x() + vector(0.7));
            let b = Cubic::from_hermite(offset, Vec3::x() + vector(0.7), offset + Vec3::x(), Vec3::x() + vector(0.7));
            for unit in [1.0, 1e-100] {
                let scaled = |c: &Cubic| Cubic { b: c.b.map(|p| p * unit) };
                let local = PowerForm::new(&scaled(&a), &scaled(&b), [0.0, 1.0], [0.0, 1.0]);
                let m = local.convexity();
                if m <= 0.0 {
                    continue;
                }
                convex += 1;
                let bound = local.fourth_order(m);
                let mut least = f64::INFINITY;
                for i in 0..=60 {
                    for j in 0..=60 {
                        least = least.min((a.point(f64::from(i) / 60.0) - b.point(f64::from(j) / 60.0)).norm());
                    }
                }
                assert!(bound.lower <= least * unit, "{} {least}", bound.lower / unit);
                assert!(bound.lower <= bound.at_place);
                model_above += usize::from(bound.at_place > least * unit * (1.0 + 1e-9));
            }
        }
        assert!(convex > 500 && model_above > 50, "{convex} {model_above}");
    }

    /// Error of the bound on a pair of arcs of a double helix, whole and halved: falls by about 2⁴ (at least 10).
    #[test]
    fn the_bound_is_of_fourth_order() {
        let arc = |phase: f64, from: f64, to: f64| {
            let at = |t: f64| {
                let (s, c) = (phase + t).sin_cos();
                // A pitch that varies along the strand makes the foot a curved function of u.
                (Vec3::new(c, s, 1.6 * t + 0.2 * (t + phase).sin()), Vec3::new(-s, c, 1.6 + 0.2 * (t + phase).cos()))
            };
            let h = to - from;
            Cubic::from_hermite(at(from).0, at(from).1 * h, at(to).0, at(to).1 * h)
        };
        let error = |h: f64| {
            let local = PowerForm::new(&arc(0.0, 0.4, 0.4 + h), &arc(2.9, 0.1, 1.0), [0.0, 1.0], [0.0, 1.0]);
            let m = local.convexity();
            assert!(m > 0.0);
            let bound = local.fourth_order(m);
            bound.at_place - bound.lower
        };
        let errors = [error(0.1), error(0.05), error(0.025)];
        println!("{errors:?}");
        assert!(errors.windows(2).all(|e| e[0] > 10.0 * e[1]), "{errors:?}");
    }
}
