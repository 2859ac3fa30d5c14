//! Exclusion of parts of one curve that are too close *along the curve* to touch, by the total turning of the tangent.
//!
//! **One-sided (π/2).** Let an arc have all its tangents within less than π/2 of the tangent t(σ) at one of its points,
//! c(σ). For any other point c(s) of the arc, (c(s) − c(σ))·t(σ) = ∫ t·t(σ) > 0 (< 0 for s < σ): it is not orthogonal
//! to t(σ), so c(σ) is not an orthogonal projection of c(s). Angles between tangents are bounded by the turning of the
//! arc, so turning < π/2 over the arc spanning two segments proves that the pair can hold no contact. The same with a
//! kink at the foot: the tangent inside the arc alone already has the wrong sign.
//!
//! **Bilateral (π).** If the chord between two points is orthogonal to the curve at both, arc and chord form a closed
//! curve with two corners of π/2; Fenchel's theorem gives total curvature ≥ 2π, so the arc turns by at least π.
//!
//! **Joints.** Strands of two curves that are joined overlap there at any angle, and no turning says how far. Pairs of
//! their segments near the joint are given ([`Exclusion::leave_out`]).
//!
//! Of one curve neither element indices nor arc lengths enter: a tight loop of few elements is detected, a long
//! straight part is excluded as a whole.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::contact::curves::curve::{Cubic, CurveSet, angle};
use crate::contact::curves::input::{CurveShape, Strand, Strands};
use crate::contact::measures::USUAL;
use crate::error::SolveError;
use crate::math::Vec3;

/// Change of turning after which a candidate list is rebuilt, rad, because a larger one puts more neighbours on the
/// list, and a smaller one rebuilds it more often.
const SLACK: f64 = 0.25;

/// Turning bounds of all curves; updated with the geometry.
#[derive(Clone, Debug, Default)]
pub struct Exclusion {
    /// Accumulated turning from the start of the curve to the start of the segment, and to its end.
    start: Vec<f64>,
    end: Vec<f64>,
    /// Per curve: turning of the whole curve, of a closed one once round.
    total: Vec<f64>,
    /// Number of following segments that are excluded with each segment, at π/2, π/2 − slack and π.
    reach: Vec<u32>,
    reach_reduced: Vec<u32>,
    reach_bilateral: Vec<u32>,
    /// Per segment: (first, count of its curve, closed).
    place: Vec<(u32, u32, bool)>,
    /// Curve of each segment.
    curve: Vec<u32>,
    /// Further pairs i < j that are left out whatever the geometry, sorted.
    joined: Vec<[u32; 2]>,
}

impl Exclusion {
    /// An exclusion of no pairs; call [`Exclusion::update`].
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Leaves out further pairs of segments, i < j: the surroundings of points at which curves are joined.
    pub(crate) fn leave_out(&mut self, mut pairs: Vec<[u32; 2]>) {
        pairs.sort_unstable();
        pairs.dedup();
        self.joined = pairs;
    }

    /// Forgets the geometry, not the pairs left out for good.
    pub(crate) fn forget(&mut self) {
        *self = Self { joined: std::mem::take(&mut self.joined), ..Self::default() };
    }

    /// Whether a pair is left out because its curves are joined there.
    pub(crate) fn are_joined(&self, i: usize, j: usize) -> bool {
        !self.joined.is_empty() && self.joined.binary_search(&[i.min(j) as u32, i.max(j) as u32]).is_ok()
    }

    /// Recomputes everything for the present geometry, O(segments).
    ///
    /// # Errors
    /// [`SolveError::TooCoarse`] for a segment whose own turning bound is not below π/2 (NaN included): it could touch
    /// itself. [`SolveError::TooTight`] if it is bent more tightly than it is thick besides.
    pub fn update(&mut self, set: &CurveSet) -> Result<(), SolveError> {
        self.update_strands(&Strands::of_set(set))
    }

    /// As [`Exclusion::update`], for borrowed curves.
    pub(crate) fn update_strands(&mut self, strands: &Strands) -> Result<(), SolveError> {
        self.clear(strands);
        for (index, curve) in strands.curves.iter().enumerate() {
            let mut sum = 0.0;
            for k in 0..curve.count {
                let i = curve.first + k;
                let (turning, joint) = turning(curve, k);
                let fine = turning < FRAC_PI_2;
                if !fine {
                    let length: f64 = strands.cubic(i).edges().iter().map(Vec3::norm).sum();
                    let tightness = turning / length * strands.radius_of(i);
                    if tightness >= 1.0 {
                        return Err(SolveError::TooTight { curve: index, segment: k, tightness });
                    }
                    return Err(SolveError::TooCoarse { curve: index, segment: k, turning, limit: FRAC_PI_2 });
                }
                self.start[i] = sum;
                sum += turning;
                self.end[i] = sum;
                sum += joint;
            }
            self.total.push(sum);
            let range = curve.first..curve.first + curve.count;
            let (start, end) = (&self.start[range.clone()], &self.end[range.clone()]);
            let turning = CurveTurning { closed: curve.closed, start, end, total: sum };
            turning.reach(FRAC_PI_2, &mut self.reach[range.clone()]);
            turning.reach(FRAC_PI_2 - SLACK, &mut self.reach_reduced[range.clone()]);
            turning.reach(PI, &mut self.reach_bilateral[range]);
        }
        Ok(())
    }

    /// Excludes the `num` following and preceding segments of each segment, whatever the geometry.
    pub(crate) fn update_by_count(&mut self, strands: &Strands, num: usize) {
        self.clear(strands);
        for curve in &strands.curves {
            for k in 0..curve.count {
                let ahead = if curve.closed { curve.count - 1 } else { curve.count - 1 - k };
                let reach = num.min(ahead) as u32;
                for list in [&mut self.reach, &mut self.reach_reduced, &mut self.reach_bilateral] {
                    list[curve.first + k] = reach;
                }
            }
            self.total.push(0.0);
        }
    }

    /// Memory, bytes.
    pub(crate) fn memory(&self) -> usize {
        bytes(&self.start)
            + bytes(&self.end)
            + bytes(&self.total)
            + bytes(&self.reach)
            + bytes(&self.reach_reduced)
            + bytes(&self.reach_bilateral)
            + bytes(&self.place)
            + bytes(&self.curve)
    }

    fn clear(&mut self, strands: &Strands) {
        let n = strands.len();
        for list in [&mut self.start, &mut self.end] {
            list.clear();
            list.resize(n, 0.0);
        }
        for list in [&mut self.reach, &mut self.reach_reduced, &mut self.reach_bilateral] {
            list.clear();
            list.resize(n, 0);
        }
        self.total.clear();
        self.place.clear();
        self.curve.clear();
        for (index, curve) in strands.curves.iter().enumerate() {
            self.curve.extend(std::iter::repeat_n(index as u32, curve.count));
            let place = (curve.first as u32, curve.count as u32, curve.closed);
            self.place.extend(std::iter::repeat_n(place, curve.count));
        }
    }

    /// True if the pair can hold no contact: `i == j`, or the same curve with less than π/2 of turning over the arc
    /// that spans both segments, in either direction on a closed curve. Symmetric.
    #[must_use]
    pub fn excluded(&self, i: usize, j: usize) -> bool {
        self.within(&self.reach, i, j) || self.are_joined(i, j)
    }

    /// True if no two points of the segments can be each other's orthogonal projections: turning below π. Symmetric;
    /// `i == j` always.
    #[must_use]
    pub fn excluded_bilateral(&self, i: usize, j: usize) -> bool {
        self.within(&self.reach_bilateral, i, j) || self.are_joined(i, j)
    }

    /// As [`Exclusion::excluded`] with a limit lower by 0.25 rad, for candidate lists that are kept while the geometry
    /// changes.
    pub(crate) fn excluded_reduced(&self, i: usize, j: usize) -> bool {
        self.within(&self.reach_reduced, i, j) || self.are_joined(i, j)
    }

    /// Number of segments following each segment that a list built now excludes.
    pub(crate) fn reduced_reach(&self) -> &[u32] {
        &self.reach_reduced
    }

    /// True if all pairs excluded by `built` (a former [`Exclusion::reduced_reach`]) are still excluded.
    pub(crate) fn covers(&self, built: &[u32]) -> bool {
        self.reach.len() == built.len() && self.reach.iter().zip(built).all(|(now, then)| now >= then)
    }

    /// Upper bound of the turning, rad, of the forward arc from one point to another of the same curve, each a segment
    /// and its parameter (through the closing joint if need be; on open curves `from` must come before `to`). Sharper
    /// than whole segments, because the end pieces are cut. Infinite if there is no such arc.
    #[must_use]
    pub fn turning_between(&self, set: &CurveSet, from: (usize, f64), to: (usize, f64)) -> f64 {
        self.turning_of_arc(from, to, |k| set.segments[k])
    }

    /// As [`Exclusion::turning_between`], for borrowed curves.
    pub(crate) fn turning_between_pieces(&self, strands: &Strands, from: (usize, f64), to: (usize, f64)) -> f64 {
        self.turning_of_arc(from, to, |k| strands.cubic(k))
    }

    fn turning_of_arc(&self, (i, u): (usize, f64), (j, v): (usize, f64), cubic: impl Fn(usize) -> Cubic) -> f64 {
        let (first, count, closed) = self.place[i];
        if first != self.place[j].0 {
            return f64::INFINITY;
        }
        if i == j && u <= v {
            return piece(&cubic(i), u, v).turning_bound();
        }
        let total = self.total[self.curve[i] as usize];
        let mut between = self.start[j] - self.end[i];
        if j <= i {
            if !closed {
                return f64::INFINITY;
            }
            between += total;
        }
        let ends = [cubic(i).split_at(u).1, cubic(j).split_at(v).0].map(|end| end.turning_bound());
        between.max(0.0) + ends[0] + ends[1] + rounding(count as usize, total)
    }

    /// True if neither point can be an orthogonal projection of the other because less than π/2 of turning lies between
    /// them in either direction. For pairs of *neighbouring* segments that are not excluded as a whole, where the
    /// trivial foot (the point itself) and its surroundings must be distinguished from contact.
    #[must_use]
    pub fn excluded_points(&self, set: &CurveSet, a: (usize, f64), b: (usize, f64)) -> bool {
        self.turning_between(set, a, b) < FRAC_PI_2 || self.turning_between(set, b, a) < FRAC_PI_2
    }

    /// Turning accumulated from the start of its curve to the start and to the end of a segment, rad (bounds).
    pub(crate) fn turning_at(&self, segment: usize) -> [f64; 2] {
        [self.start[segment], self.end[segment]]
    }

    /// Turning of a whole curve, of a closed one once round, rad (bound).
    pub(crate) fn turning_of(&self, curve: usize) -> f64 {
        self.total[curve]
    }

    /// True if whole segments i ≠ j of one curve have at least `limit` of turning (bound) between their facing ends in
    /// both directions.
    pub(crate) fn turns_between_at_least(&self, set: &CurveSet, i: usize, j: usize, limit: f64) -> bool {
        let (i, j) = if i < j { (i, j) } else { (j, i) };
        let curve = set.curve_of(i);
        let around =
            if set.curves[curve].closed { self.total[curve] - self.end[j] + self.start[i] } else { f64::INFINITY };
        i != j && (self.start[j] - self.end[i]).min(around) >= limit
    }

    fn within(&self, reach: &[u32], i: usize, j: usize) -> bool {
        if i == j {
            return true;
        }
        let (first, count, closed) = self.place[i];
        if self.place[j].0 != first {
            return false;
        }
        let (lo, hi) = if i < j { (i, j) } else { (j, i) };
        let ahead = (hi - lo) as u32;
        ahead <= reach[lo] || (closed && count - ahead <= reach[hi])
    }
}

/// Bound of the rounding, rad, of turning accumulated over a curve: each segment adds two angles, rounded to an ulp,
/// and two roundings of the sum.
fn rounding(num_segments: usize, total: f64) -> f64 {
    4.0 * f64::EPSILON * num_segments as f64 * (1.0 + total)
}

/// Memory of a list, bytes, spare capacity included.
pub(crate) fn bytes<T>(list: &Vec<T>) -> usize {
    list.capacity() * size_of::<T>()
}

/// The part of a curve on [u, v].
fn piece(c: &Cubic, u: f64, v: f64) -> Cubic {
    let right = c.split_at(u).1;
    if u < 1.0 { right.split_at(((v - u) / (1.0 - u)).clamp(0.0, 1.0)).0 } else { right }
}

/// Turning bounds of the k-th segment and of the joint after it (0 at an open end).
fn turning(curve: &Strand, k: usize) -> (f64, f64) {
    let next = if k + 1 < curve.count { Some(k + 1) } else { curve.closed.then_some(0) };
    match curve.shape {
        CurveShape::Polyline(points) => {
            let wrap = |i: usize| if i < points.len() { i } else { i - points.len() };
            let joint = next.map_or(0.0, |_| {
                let (a, b) = (points[wrap(k + 1)] - points[k], points[wrap(k + 2)] - points[wrap(k + 1)]);
                angle_bound(&a, &b)
            });
            (0.0, joint)
        }
        CurveShape::Cubics(pieces) => {
            let joint = next.map_or(0.0, |n| angle(&pieces[k].end_tangent(), &pieces[n].start_tangent()));
            (pieces[k].turning_bound(), joint)
        }
    }
}

/// Upper bound of the angle between two vectors without inverse functions: with x the distance of the unit vectors, θ =
/// 2 asin(x/2) ≤ x (1 + 0.0554 x²) up to π/2. The bound is 0.1 % above θ at π/2 and 4e-8 above it at 0.
fn angle_bound(a: &Vec3, b: &Vec3) -> f64 {
    let (dot, size_sq) = (a.dot(b), a.norm_squared() * b.norm_squared());
    if !(dot > 0.0 && USUAL.contains(&size_sq)) {
        return angle(a, b);
    }
    let x_sq = (2.0 - 2.0 * (dot / size_sq.sqrt())).max(0.0) + 8.0 * f64::EPSILON;
    x_sq.sqrt() * (1.0 + 0.0554 * x_sq)
}

/// Turning accumulated along one curve, rad.
struct CurveTurning<'a> {
    closed: bool,
    /// Up to the start of each segment.
    start: &'a [f64],
    /// Up to the end of each segment.
    end: &'a [f64],
    /// Of the whole curve.
    total: f64,
}

impl CurveTurning<'_> {
    /// For each segment, the number of following ones within `limit` of turning (start of the one to end of the other).
    fn reach(&self, limit: f64, out: &mut [u32]) {
        let count = self.start.len();
        let limit = limit - rounding(count, self.total);
        // End of the k-th segment counted from the first, periodic on a closed curve (k below twice the count).
        let end_at = |k: usize| if k < count { self.end[k] } else { self.end[k - count] + self.total };
        let mut ahead = 0;
        for i in 0..count {
            ahead = ahead.max(i);
            let last = if self.closed { i + count - 1 } else { count - 1 };
            while ahead < last && end_at(ahead + 1) - self.start[i] < limit {
                ahead += 1;
            }
            out[i] = (ahead - i) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::curves::curve::CurveInput;

    fn circle(n: usize) -> CurveSet {
        thick_circle(n, 0.01)
    }

    /// Circle of radius 1 by n Hermite cubics.
    fn thick_circle(n: usize, radius: f64) -> CurveSet {
        let h = 2.0 * PI / n as f64;
        let p = |i: usize| {
            let (s, c) = (h * i as f64).sin_cos();
            (Vec3::new(c, s, 0.0), Vec3::new(-s, c, 0.0) * h)
        };
        let segments = (0..n).map(|i| Cubic::from_hermite(p(i).0, p(i).1, p(i + 1).0, p(i + 1).1)).collect();
        CurveSet::new(vec![CurveInput { segments, lengths: vec![h; n], closed: true, radius }]).unwrap()
    }

    #[test]
    fn circle_excludes_a_quarter_each_way() {
        let set = circle(40);
        let mut e = Exclusion::new();
        e.update(&set).unwrap();
        // 9 segments span 81°, 10 span 90°.
        assert!(e.excluded(0, 8) && !e.excluded(0, 10));
        assert!(e.excluded(0, 32) && e.excluded(32, 0) && !e.excluded(0, 30));
        assert!(e.excluded_bilateral(0, 18) && !e.excluded_bilateral(0, 20));
        for i in 0..40 {
            for j in 0..40 {
                assert_eq!(e.excluded(i, j), e.excluded(j, i));
                assert!(!e.excluded(i, j) || e.excluded_bilateral(i, j));
                assert!(!e.excluded_reduced(i, j) || e.excluded(i, j));
            }
        }
        let between = e.turning_between(&set, (39, 0.5), (1, 0.5));
        assert!((between - 2.0 * 2.0 * PI / 40.0).abs() < 1e-3, "{between}");
        assert!(e.excluded_points(&set, (1, 0.5), (39, 0.5)) && !e.excluded_points(&set, (0, 0.5), (20, 0.5)));
    }

    #[test]
    fn a_coarse_segment_is_refused_by_name() {
        let set = circle(3);
        let error = Exclusion::new().update(&set).unwrap_err();
        assert!(matches!(error, SolveError::TooCoarse { curve: 0, segment: 0, .. }), "{error}");
    }

    /// Symptom: a solenoid's loop, tighter than its rod is thick, ended with the advice to use more elements.
    #[test]
    fn a_segment_tighter_than_thick_is_no_matter_of_the_mesh() {
        for (radius, is_tight) in [(0.7, false), (1.4, true)] {
            let error = Exclusion::new().update(&thick_circle(3, radius)).unwrap_err();
            assert_eq!(matches!(error, SolveError::TooTight { .. }), is_tight, "{error}");
        }
    }

    #[test]
    fn polyline_joints_count() {
        let p = [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0), Vec3::y()];
        let set = CurveSet::from_polylines(&[(&p, 0.1, false)]).unwrap();
        let mut e = Exclusion::new();
        e.update(&set).unwrap();
        assert!(!e.excluded(0, 1) && e.excluded_bilateral(0, 1) && !e.excluded_bilateral(0, 2));
    }

    #[test]
    fn different_curves_are_never_excluded() {
        let p = [Vec3::zeros(), Vec3::x()];
        let set = CurveSet::from_polylines(&[(&p, 0.1, false), (&p, 0.1, false)]).unwrap();
        let mut e = Exclusion::new();
        e.update(&set).unwrap();
        assert!(!e.excluded(0, 1) && e.excluded(1, 1));
    }
}
