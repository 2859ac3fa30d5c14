//! Contact centrelines: curves of cubic Bézier segments with a radius. Knows nothing of rods.
//!
//! c(u) = Σ B_i(u) b_i, u in \[0, 1\], B_i the cubic Bernstein polynomials. All lengths in one unit \[L\] of the
//! caller's choice; nothing here has an absolute tolerance.

use crate::contact::curves::radius::Radius;
use crate::contact::measures::{COINCIDENT, USUAL};
use crate::error::InputError;
use crate::math::Vec3;

/// A cubic Bézier curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    /// Control points \[L\]; the curve runs from `b[0]` to `b[3]` inside their convex hull.
    pub b: [Vec3; 4],
}

impl Cubic {
    /// The curve with end points `p0`, `p1` and end derivatives `m0`, `m1` = dc/du \[L\] (u in \[0, 1\]).
    #[must_use]
    pub fn from_hermite(p0: Vec3, m0: Vec3, p1: Vec3, m1: Vec3) -> Self {
        Self { b: [p0, p0 + m0 / 3.0, p1 - m1 / 3.0, p1] }
    }

    /// The straight segment from `p0` to `p1` at constant speed.
    #[must_use]
    pub fn straight(p0: Vec3, p1: Vec3) -> Self {
        let third = (p1 - p0) / 3.0;
        Self { b: [p0, p0 + third, p1 - third, p1] }
    }

    /// c(u) \[L\]. Exactly `b[0]` at 0 and `b[3]` at 1.
    #[must_use]
    pub fn point(&self, u: f64) -> Vec3 {
        let v = 1.0 - u;
        let [b0, b1, b2, b3] = &self.b;
        b0 * (v * v * v) + b1 * (3.0 * v * v * u) + b2 * (3.0 * v * u * u) + b3 * (u * u * u)
    }

    /// (c, c′, c″) with respect to u \[L\]. The derivatives use differences of control points (no loss far from the
    /// origin).
    #[must_use]
    pub fn derivatives(&self, u: f64) -> (Vec3, Vec3, Vec3) {
        let v = 1.0 - u;
        let [e0, e1, e2] = self.edges();
        let first = (e0 * (v * v) + e1 * (2.0 * u * v) + e2 * (u * u)) * 3.0;
        let second = ((e1 - e0) * v + (e2 - e1) * u) * 6.0;
        (self.point(u), first, second)
    }

    /// The two halves, meeting at u = ½ (de Casteljau).
    #[must_use]
    pub fn split(&self) -> (Self, Self) {
        self.split_at(0.5)
    }

    /// The parts on \[0, u\] and \[u, 1\] (de Casteljau).
    #[must_use]
    pub fn split_at(&self, u: f64) -> (Self, Self) {
        let mix = |a: &Vec3, b: &Vec3| a * (1.0 - u) + b * u;
        let [b0, b1, b2, b3] = &self.b;
        let (c01, c12, c23) = (mix(b0, b1), mix(b1, b2), mix(b2, b3));
        let (c012, c123) = (mix(&c01, &c12), mix(&c12, &c23));
        let mid = mix(&c012, &c123);
        (Self { b: [*b0, c01, c012, mid] }, Self { b: [mid, c123, c23, *b3] })
    }

    /// The part on \[t0, t1\] (reversed if t0 > t1, constant if equal), by blossoming.
    #[must_use]
    pub fn restrict(&self, t0: f64, t1: f64) -> Self {
        let mix = |a: Vec3, b: Vec3, t: f64| a * (1.0 - t) + b * t;
        let blossom = |r: f64, s: f64, t: f64| {
            let [b0, b1, b2, b3] = self.b;
            let (p0, p1, p2) = (mix(b0, b1, r), mix(b1, b2, r), mix(b2, b3, r));
            mix(mix(p0, p1, s), mix(p1, p2, s), t)
        };
        Self { b: [blossom(t0, t0, t0), blossom(t0, t0, t1), blossom(t0, t1, t1), blossom(t1, t1, t1)] }
    }

    /// Edges of the control polygon, b_{i+1} − b_i \[L\]; c′ = 3 × the quadratic Bézier curve of these.
    #[must_use]
    pub fn edges(&self) -> [Vec3; 3] {
        [self.b[1] - self.b[0], self.b[2] - self.b[1], self.b[3] - self.b[2]]
    }

    /// End-to-end vector b3 − b0 \[L\].
    #[must_use]
    pub fn chord(&self) -> Vec3 {
        self.b[3] - self.b[0]
    }

    /// Upper bound of the largest distance \[L\] of a point of the curve from the chord *segment* b0 b3:
    /// ¾ max(d(b1), d(b2)), because the distance from a segment is convex, zero at both ends, and B_1 + B_2 ≤ ¾.
    /// Quarters (in the limit) with every halving of the curve. Rounded up.
    #[must_use]
    pub fn bulge(&self) -> f64 {
        let chord = self.chord();
        let farthest = farthest_from_segment([&(self.b[1] - self.b[0]), &(self.b[2] - self.b[0])], &chord);
        // Rounding of the foot costs second order, of the offset a few ulp of the polygon's size.
        let size = self.edges().iter().map(Vec3::amax).sum::<f64>();
        0.75 * farthest + 4.0 * f64::EPSILON * size
    }

    /// Upper bound of the total turning of the tangent along the curve, rad: the sum of the angles between successive
    /// edges of the control polygon, zero edges (repeated control points) left out. A curve shrunk to a point has 0.
    #[must_use]
    pub(crate) fn turning_bound(&self) -> f64 {
        let mut turning = 0.0;
        let mut last: Option<Vec3> = None;
        for edge in self.edges() {
            // Written so that NaN is not taken for a zero edge.
            if edge == Vec3::zeros() {
                continue;
            }
            if let Some(before) = last {
                turning += angle(&before, &edge);
            }
            last = Some(edge);
        }
        turning
    }

    /// The curve in coordinates relative to a point.
    pub(crate) fn relative_to(&self, origin: &Vec3) -> Self {
        Self { b: self.b.map(|p| p - origin) }
    }

    /// True if `next` starts where this curve ends, to [`COINCIDENT`] of their size (and the ulps of points far from
    /// the origin).
    pub(crate) fn joins(&self, next: &Self) -> bool {
        let size: f64 = self.edges().iter().chain(&next.edges()).map(Vec3::amax).sum();
        (next.b[0] - self.b[3]).amax() <= COINCIDENT * size + 8.0 * f64::EPSILON * self.b[3].amax()
    }

    /// Direction of the tangent at u = 0 (not normalised): the first non-zero edge; zero for a curve shrunk to a point.
    #[must_use]
    pub fn start_tangent(&self) -> Vec3 {
        self.edges().into_iter().find(|e| *e != Vec3::zeros()).unwrap_or_default()
    }

    /// Direction of the tangent at u = 1 (not normalised): the last non-zero edge; zero for a curve shrunk to a point.
    #[must_use]
    pub(crate) fn end_tangent(&self) -> Vec3 {
        self.edges().into_iter().rev().find(|e| *e != Vec3::zeros()).unwrap_or_default()
    }
}

/// Length of a vector of any magnitude.
pub(crate) fn norm(v: &Vec3) -> f64 {
    let size = v.amax();
    if size == 0.0 || USUAL.contains(&size) { v.norm() } else { (v / size).norm() * size }
}

/// Angle between two vectors in \[0, π\], accurate at both ends and for any magnitudes; 0 if either is zero.
#[must_use]
pub fn angle(a: &Vec3, b: &Vec3) -> f64 {
    let (sa, sb) = (a.amax(), b.amax());
    let (a, b) = if USUAL.contains(&sa) && USUAL.contains(&sb) {
        (*a, *b)
    } else {
        if sa == 0.0 || sb == 0.0 {
            return 0.0;
        }
        (a / sa, b / sb)
    };
    a.cross(&b).norm().atan2(a.dot(&b))
}

/// The larger distance of two points from the segment from 0 to `d`.
fn farthest_from_segment(points: [&Vec3; 2], d: &Vec3) -> f64 {
    let dd = d.norm_squared();
    if USUAL.contains(&dd) && points.iter().all(|p| p.norm_squared() < USUAL.end) {
        let [first, second] = points.map(|p| (p - d * (p.dot(d) / dd).clamp(0.0, 1.0)).norm_squared());
        return first.max(second).sqrt();
    }
    let [first, second] = points.map(|p| distance_to_segment(p, d));
    first.max(second)
}

/// Distance of the point `p` from the segment from 0 to `d`, of any size.
fn distance_to_segment(p: &Vec3, d: &Vec3) -> f64 {
    let scale = d.amax().max(p.amax());
    if scale == 0.0 || !scale.is_finite() {
        return scale;
    }
    let (p, d) = (p / scale, d / scale);
    let t = (p.dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    // 0/0 of a vanishing chord: its start is used.
    let t = if t.is_nan() { 0.0 } else { t };
    scale * (p - d * t).norm()
}

/// One curve of a [`CurveSet`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveInfo {
    /// Global index of its first segment.
    pub first: usize,
    /// Number of segments, at least 1.
    pub count: usize,
    /// Whether the last segment joins the first.
    pub closed: bool,
    /// Contact radius \[L\], greater than 0; the largest if it differs from segment to segment.
    pub radius: f64,
}

/// A curve to be put into a [`CurveSet`].
#[derive(Clone, Debug, PartialEq)]
pub struct CurveInput {
    /// Segments in order; the end of each is the start of the next (and of the first, if closed).
    pub segments: Vec<Cubic>,
    /// Reference (unstressed) arc length \[L\] of each segment.
    pub lengths: Vec<f64>,
    /// Whether the last segment joins the first.
    pub closed: bool,
    /// Contact radius \[L\].
    pub radius: f64,
}

/// Several curves, flat: segment indices run over all of them, 0..`segments.len()`.
#[derive(Clone, Debug, Default)]
pub struct CurveSet {
    /// All segments, curve after curve.
    pub segments: Vec<Cubic>,
    /// Reference arc length \[L\] of each segment.
    pub lengths: Vec<f64>,
    /// The curves, in order of their segments.
    pub curves: Vec<CurveInfo>,
    /// Remainders of the control points of each segment after rounding \[L\]; empty if they are not known.
    pub(crate) remainders: Vec<[Vec3; 4]>,
    /// Bending stiffness of each curve \[F·L²\]; empty if they count as equal.
    pub(crate) bending: Vec<f64>,
    owner: Vec<u32>,
    arc_start: Vec<f64>,
    /// Radius of each segment; empty if each curve has one.
    radii: Vec<f64>,
}

impl CurveSet {
    /// Joins the curves. No curve at all is legal (an empty set).
    ///
    /// # Errors
    /// [`InputError`] naming curve and segment: no segments, `lengths` of another size, a radius or length that is not
    /// finite and positive, a control point that is not finite, or neighbours that do not join (to 1e-6 of their size).
    pub fn new(curves: Vec<CurveInput>) -> Result<Self, InputError> {
        let mut set = Self::default();
        for (index, curve) in curves.into_iter().enumerate() {
            let count = curve.segments.len();
            let field = |what: &str| format!("curves[{index}].{what}");
            if count == 0 {
                return Err(InputError::Count { field: field("segments"), value: 0, allowed: "at least 1" });
            }
            if curve.lengths.len() != count {
                let value = curve.lengths.len();
                return Err(InputError::Count { field: field("lengths"), value, allowed: "as many as segments" });
            }
            InputError::positive(&field("radius"), curve.radius)?;
            let mut arc = 0.0;
            for (i, &length) in curve.lengths.iter().enumerate() {
                InputError::positive(&field(&format!("lengths[{i}]")), length)?;
                set.arc_start.push(arc);
                arc += length;
            }
            let first = set.segments.len();
            let owner =
                u32::try_from(index).ok().filter(|_| u32::try_from(first + count).is_ok()).ok_or_else(|| {
                    InputError::Count { field: field("segments"), value: count, allowed: "below 2³² in all" }
                })?;
            set.owner.extend(std::iter::repeat_n(owner, count));
            set.segments.extend(curve.segments);
            set.lengths.extend(curve.lengths);
            set.curves.push(CurveInfo { first, count, closed: curve.closed, radius: curve.radius });
        }
        set.validate_geometry()?;
        set.check_joints()?;
        Ok(set)
    }

    /// Straight segments through the given points: `(points, radius, closed)`. The joints have kinks; good for
    /// benchmarks and tests, too rough for equilibria. Reference lengths are the edges' lengths.
    ///
    /// # Errors
    /// As [`CurveSet::new`]; also fewer than 2 points (3 if closed) and repeated neighbours (length 0).
    pub fn from_polylines(lines: &[(&[Vec3], f64, bool)]) -> Result<Self, InputError> {
        let mut curves = Vec::with_capacity(lines.len());
        for (index, &(points, radius, closed)) in lines.iter().enumerate() {
            if points.len() < if closed { 3 } else { 2 } {
                let allowed = "at least 2 (3 if closed)";
                return Err(InputError::Count {
                    field: format!("curves[{index}].points"),
                    value: points.len(),
                    allowed,
                });
            }
            for (i, p) in points.iter().enumerate() {
                if !p.iter().all(|x| x.is_finite()) {
                    return Err(not_finite(format!("curves[{index}].points[{i}]"), p));
                }
            }
            let count = if closed { points.len() } else { points.len() - 1 };
            let segments: Vec<Cubic> =
                (0..count).map(|i| Cubic::straight(points[i], points[(i + 1) % points.len()])).collect();
            let lengths = segments.iter().map(|s| s.chord().norm()).collect();
            curves.push(CurveInput { segments, lengths, closed, radius });
        }
        Self::new(curves)
    }

    /// Number of segments of all curves.
    #[must_use]
    pub fn len(&self) -> usize {
        self.segments.len()
    }

    /// True if there is no segment.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// Index of the curve a segment belongs to.
    #[must_use]
    pub fn curve_of(&self, segment: usize) -> usize {
        self.owner[segment] as usize
    }

    /// The following segment of the same curve; `None` at an open end.
    #[must_use]
    pub fn next(&self, segment: usize) -> Option<usize> {
        let curve = &self.curves[self.curve_of(segment)];
        if segment + 1 < curve.first + curve.count { Some(segment + 1) } else { curve.closed.then_some(curve.first) }
    }

    /// The preceding segment of the same curve; `None` at an open end.
    #[must_use]
    pub fn prev(&self, segment: usize) -> Option<usize> {
        let curve = &self.curves[self.curve_of(segment)];
        if segment > curve.first { Some(segment - 1) } else { curve.closed.then_some(curve.first + curve.count - 1) }
    }

    /// Reference arc length \[L\] from the start of the curve to parameter `u` of a segment.
    #[must_use]
    pub fn arc_length(&self, segment: usize, u: f64) -> f64 {
        self.arc_start[segment] + u * self.lengths[segment]
    }

    /// Reference length \[L\] of a curve.
    #[must_use]
    pub fn length_of(&self, curve: usize) -> f64 {
        let info = &self.curves[curve];
        self.arc_length(info.first + info.count - 1, 1.0)
    }

    /// Reference length \[L\] of a curve if it is closed.
    #[must_use]
    pub fn period(&self, curve: usize) -> Option<f64> {
        self.curves[curve].closed.then(|| self.length_of(curve))
    }

    /// Segment and parameter at a reference arc length \[L\] from the start of a curve. Closed curves are periodic;
    /// beyond the ends of an open one its end is returned.
    pub(crate) fn at_arc(&self, curve: usize, arc: f64) -> (usize, f64) {
        let arc = self.period(curve).map_or(arc, |period| arc.rem_euclid(period));
        let info = &self.curves[curve];
        let starts = &self.arc_start[info.first..info.first + info.count];
        let segment = info.first + starts.partition_point(|start| *start <= arc).max(1) - 1;
        (segment, ((arc - self.arc_start[segment]) / self.lengths[segment]).clamp(0.0, 1.0))
    }

    /// Contact radius \[L\] of a segment.
    #[must_use]
    pub fn radius_of(&self, segment: usize) -> f64 {
        if self.radii.is_empty() { self.curves[self.curve_of(segment)].radius } else { self.radii[segment] }
    }

    /// Gives each segment a radius of its own \[L\]; see [`Radius`].
    ///
    /// # Errors
    /// [`InputError`] naming the first radius that is not finite and positive, or if there are not as many as segments.
    pub fn set_radii(&mut self, radii: &[f64]) -> Result<(), InputError> {
        Radius::PerSegment(radii).check(self.len(), &|what| what.to_owned())?;
        self.radii.clear();
        self.radii.extend_from_slice(radii);
        for curve in &mut self.curves {
            curve.radius = Radius::PerSegment(&radii[curve.first..curve.first + curve.count]).largest();
        }
        Ok(())
    }

    /// Radius of one curve of this set.
    pub(crate) fn radius_between(&self, curve: &CurveInfo) -> Radius<'_> {
        match self.radii.get(curve.first..curve.first + curve.count) {
            Some(radii) => Radius::PerSegment(radii),
            None => Radius::Constant(curve.radius),
        }
    }

    /// Overwrites the reference lengths.
    pub(crate) fn set_lengths(&mut self, lengths: &[f64]) {
        self.lengths.copy_from_slice(lengths);
        for curve in &self.curves {
            let mut arc = 0.0;
            for i in curve.first..curve.first + curve.count {
                self.arc_start[i] = arc;
                arc += lengths[i];
            }
        }
    }

    /// The segments, to be overwritten with new geometry (the joints must keep meeting). Call
    /// [`CurveSet::validate_geometry`] after numbers of uncertain origin.
    pub fn segments_mut(&mut self) -> &mut [Cubic] {
        &mut self.segments
    }

    /// Checks that every control point is finite.
    ///
    /// # Errors
    /// [`InputError::Vector`] naming curve, segment within the curve and control point.
    pub fn validate_geometry(&self) -> Result<(), InputError> {
        for (segment, cubic) in self.segments.iter().enumerate() {
            for (k, p) in cubic.b.iter().enumerate() {
                if !p.iter().all(|x| x.is_finite()) {
                    let curve = self.curve_of(segment);
                    let local = segment - self.curves[curve].first;
                    return Err(not_finite(format!("curves[{curve}].segments[{local}].b[{k}]"), p));
                }
            }
        }
        Ok(())
    }

    fn check_joints(&self) -> Result<(), InputError> {
        for segment in 0..self.len() {
            let Some(next) = self.next(segment) else { continue };
            if !self.segments[segment].joins(&self.segments[next]) {
                let curve = self.curve_of(segment);
                let local = segment - self.curves[curve].first;
                let reason = "its end is not the start of the next segment: make them the same point".to_owned();
                return Err(InputError::Inconsistent { field: format!("curves[{curve}].segments[{local}]"), reason });
            }
        }
        Ok(())
    }
}

fn not_finite(field: String, p: &Vec3) -> InputError {
    InputError::Vector { field, value: [p.x, p.y, p.z], allowed: "finite" }
}

#[cfg(test)]
mod tests;
