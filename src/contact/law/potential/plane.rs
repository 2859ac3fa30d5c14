//! Terms of strands against planes, which no strand may pass: supports that only push.
//!
//! ```text
//! U = Σ_segments ∫_zone ½ κ ⟨c(s) − gap(s)⟩² ds        gap = n·(r(s) − p) − ε
//! ```
//!
//! n is the plane's unit normal, p a point on it, c the offset, linear between the ends of a segment, ε the radius. Along
//! a segment the gap is a cubic polynomial: zones end at its roots, and nothing is projected. It is linear in the control
//! points, so that their Hessian is that of the law along n, and pressure has no geometric part but that of the turning
//! handles. A plane does to a strand what the strand's mirror image would, at the distance 2(gap + ε) of its own: the
//! law's contact distance is 2ε.

use super::Pressures;
use super::pressure::PairLaw;
use crate::contact::curves::curve::CurveSet;
use crate::contact::law::potential::Request;
use crate::contact::law::potential::stiffness::PairTangent;
use crate::contact::measures::{MAX_PARTS, POINTS_PER_PART};
use crate::math::bernstein::{Roots, cubic_weights, derivative, eval, roots};
use crate::math::parallel::CHEAP;
use crate::math::quadrature::gauss;
use crate::math::{Vec3, parallel};

/// The half-space n·(x − p) ≥ height that strands stay in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HalfSpace {
    /// A point p on the plane before it was moved \[L\].
    pub(crate) point: Vec3,
    /// Unit normal n, towards the strands.
    pub(crate) normal: Vec3,
    /// How far the plane has been moved along its normal \[L\].
    pub(crate) height: f64,
}

impl HalfSpace {
    /// Distance of a segment's control points from the plane \[L\], negative beyond it: the Bernstein coefficients of
    /// that of its points.
    pub(crate) fn distances(&self, set: &CurveSet, segment: usize) -> [f64; 4] {
        let points = &set.segments[segment].b;
        let lost = set.remainders.get(segment).copied().unwrap_or_default();
        std::array::from_fn(|m| self.normal.dot(&(points[m] - self.point)) - self.height + self.normal.dot(&lost[m]))
    }
}

/// One piece of a contact zone, for reports and multiplier updates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaneZone {
    /// Parameters of both ends, ascending, in \[0, 1\].
    pub(crate) u: [f64; 2],
    /// Smallest gap inside \[L\].
    pub(crate) min_gap: f64,
    /// Where it is.
    pub(crate) nearest: f64,
    /// ∫p ds, ∫p u ds and ∫p u² ds \[F\].
    pub(crate) moments: [f64; 3],
    /// ∫p (x − x₀) ds \[F·L\], x₀ the start of the segment.
    pub(crate) arm: Vec3,
}

/// A quadrature point in contact: its parameter, and weight × stiffness of the law \[F/L\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct PlanePoint {
    u: f64,
    stiffness: f64,
}

/// A segment in contact with a plane, kept after its term is summed.
#[derive(Debug, Clone)]
pub(crate) struct PlaneContact {
    pub(crate) segment: usize,
    pub(crate) plane: usize,
    /// None unless asked for.
    pub(crate) zones: Vec<PlaneZone>,
    /// None unless the tangent was asked for.
    points: Vec<PlanePoint>,
}

/// A term with respect to both ends of a segment, six coordinates each (displacement, rotation vector).
pub(crate) struct PlaneTerm {
    pub(crate) contact: PlaneContact,
    /// Energy \[F·L\].
    pub(crate) energy: f64,
    pub(crate) gradient: [f64; 12],
    /// Second derivative, the first twelve rows and columns filled; none unless asked for.
    pub(crate) tangent: Option<Box<PairTangent>>,
}

/// Terms of all segments that touch a plane, by segments and then by planes. `pressures.offset(segment, plane)` is the
/// offset c at both ends of a segment towards a plane \[L\].
pub(crate) fn evaluate(
    set: &CurveSet,
    planes: &[HalfSpace],
    pressures: &Pressures,
    request: Request,
) -> Vec<PlaneTerm> {
    if planes.is_empty() {
        return Vec::new();
    }
    let of_segments = parallel::map_ranges(set.len(), CHEAP, &|range| {
        let pairs = range.flat_map(|segment| (0..planes.len()).map(move |plane| (segment, plane)));
        pairs.filter_map(|at| term(set, planes, at, pressures, request)).collect::<Vec<_>>()
    });
    of_segments.into_iter().flatten().collect()
}

/// The term of one segment and one plane; none where they do not touch.
pub(crate) fn term(
    set: &CurveSet,
    planes: &[HalfSpace],
    (segment, plane): (usize, usize),
    pressures: &Pressures,
    request: Request,
) -> Option<PlaneTerm> {
    let half_space = &planes[plane];
    let radius = set.radius_of(segment);
    let gap = half_space.distances(set, segment).map(|distance| distance - radius);
    let contact_distance = 2.0 * radius;
    let reach = pressures.reach(segment, plane, contact_distance);
    // how far pressure reaches beyond the gap, elevated to a cubic
    let beyond = reach.map(|reach| reach - contact_distance);
    let overlap: [f64; 4] = std::array::from_fn(|m| beyond[0] + (beyond[1] - beyond[0]) * (m as f64 / 3.0) - gap[m]);
    let intervals = where_positive(&overlap);
    if intervals.is_empty() {
        return None;
    }
    let length = set.lengths[segment];
    let offset = (pressures.offset)(segment, plane);
    let law = PairLaw { pressures, contact_distance, length, reach, offset, straight: false, span: length };
    let mut sum = PlaneSum::default();
    let mut zones = Vec::new();
    for u in intervals {
        let force_before = sum.force;
        let moments = sum.add_zone(u, &law, &gap, request.tangent);
        if request.zones {
            let (nearest, min_gap) = least(&gap, u);
            let points = &set.segments[segment].b;
            let arm = (0..4).map(|m| (points[m] - points[0]) * (sum.force[m] - force_before[m])).sum();
            zones.push(PlaneZone { u, min_gap, nearest, moments, arm });
        }
    }
    let ends = Ends::of(set, segment, half_space.normal);
    Some(PlaneTerm {
        energy: sum.energy,
        gradient: ends.along(&sum.force.map(|force| -force)),
        tangent: request.tangent.then(|| ends.tangent(&sum)),
        contact: PlaneContact { segment, plane, zones, points: sum.points },
    })
}

/// Calls `visit(u, weight)` for the points of the quadrature ∫ds over a zone, divided into parts shorter than the
/// contact distance.
fn for_each_point([start, end]: [f64; 2], length: f64, contact_distance: f64, mut visit: impl FnMut(f64, f64)) {
    let width = end - start;
    let parts = (width * length / contact_distance).ceil().clamp(1.0, MAX_PARTS);
    let rule = gauss(POINTS_PER_PART);
    for part in 0..parts as usize {
        for (&x, &w) in rule.points.iter().zip(rule.weights) {
            visit(start + width * (part as f64 + x) / parts, w * width * length / parts);
        }
    }
}

/// Where a cubic of these Bernstein coefficients is positive in \[0, 1\], ascending.
fn where_positive(coeffs: &[f64; 4]) -> Vec<[f64; 2]> {
    if coeffs.iter().all(|x| *x <= 0.0) {
        return Vec::new();
    }
    if coeffs.iter().all(|x| *x > 0.0) {
        return vec![[0.0, 1.0]];
    }
    let mut found = Roots::new();
    roots(coeffs, &mut found);
    let mut ends = vec![0.0];
    ends.extend(found.as_slice().iter().filter(|u| **u > 0.0 && **u < 1.0));
    ends.push(1.0);
    let positive = |ends: &[f64]| (eval(coeffs, 0.5 * (ends[0] + ends[1])) > 0.0).then_some([ends[0], ends[1]]);
    ends.windows(2).filter_map(positive).collect()
}

/// Place and value of the minimum of a cubic of these Bernstein coefficients in an interval.
pub(crate) fn least(coeffs: &[f64; 4], [start, end]: [f64; 2]) -> (f64, f64) {
    let mut found = Roots::new();
    roots(&derivative(coeffs)[..3], &mut found);
    let inside = found.as_slice().iter().copied().filter(|u| *u > start && *u < end);
    let places = [start, end].into_iter().chain(inside).map(|u| (u, eval(coeffs, u)));
    places.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((start, f64::INFINITY))
}

/// Sums over the quadrature points of a term.
#[derive(Debug, Default)]
struct PlaneSum {
    energy: f64,
    /// ∫p w_m ds of the four control points \[F\].
    force: [f64; 4],
    /// ∫k a_i a_j ds, a the shares of the ends in a point, see [`shares`] \[F/L\].
    stiffness: [[f64; 4]; 4],
    /// The points in contact, if the tangent was asked for.
    points: Vec<PlanePoint>,
}

impl PlaneSum {
    /// Adds the zone between two parameters of a segment whose gap has these Bernstein coefficients; returns ∫p ds, ∫p u ds
    /// and ∫p u² ds.
    fn add_zone(&mut self, zone: [f64; 2], law: &PairLaw, gap: &[f64; 4], tangent: bool) -> [f64; 3] {
        let mut moments = [0.0; 3];
        for_each_point(zone, law.length, law.contact_distance, |u, weight| {
            let (response, carried) = law.response(u, eval(gap, u) + law.contact_distance);
            if carried == 0.0 {
                return;
            }
            let (force, stiffness) = (weight * response.pressure, weight * response.stiffness);
            self.add(u, weight * response.energy, force, if tangent { stiffness } else { 0.0 });
            (0..3).for_each(|k| moments[k] += force * u.powi(k as i32));
            if tangent && response.stiffness.is_finite() {
                self.points.push(PlanePoint { u, stiffness });
            }
        });
        moments
    }

    fn add(&mut self, u: f64, energy: f64, force: f64, stiffness: f64) {
        self.energy += energy;
        let w = cubic_weights(u);
        let a = shares(&w);
        for i in 0..4 {
            self.force[i] += force * w[i];
            (0..4).for_each(|j| self.stiffness[i][j] += stiffness * a[i] * a[j]);
        }
    }
}

/// Shares of displacement and handle of the start, and of the end, in a sum over the control points.
fn shares(w: &[f64; 4]) -> [f64; 4] {
    [w[0] + w[1], w[1], w[2] + w[3], w[2]]
}

/// The ends of a segment as seen from a plane.
struct Ends {
    normal: Vec3,
    /// From each end to the control point next to it \[L\].
    handles: [Vec3; 2],
}

impl Ends {
    fn of(set: &CurveSet, segment: usize, normal: Vec3) -> Self {
        let b = &set.segments[segment].b;
        Self { normal, handles: [b[1] - b[0], b[2] - b[3]] }
    }

    /// Changes of the gap by displacement and rotation of both ends, three numbers each.
    fn rates(&self) -> [Vec3; 4] {
        let turned = self.handles.map(|handle| handle.cross(&self.normal));
        [self.normal, turned[0], self.normal, turned[1]]
    }

    /// Σ s_m ∂gap_m by the coordinates of the ends, s a number for each control point.
    fn along(&self, s: &[f64; 4]) -> [f64; 12] {
        let (rates, shares) = (self.rates(), shares(s));
        std::array::from_fn(|i| rates[i / 3][i % 3] * shares[i / 3])
    }

    fn tangent(&self, sum: &PlaneSum) -> Box<PairTangent> {
        let mut tangent: Box<PairTangent> = Box::new([[0.0; 24]; 24]);
        let rates = self.rates();
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            tangent[i][j] = sum.stiffness[i / 3][j / 3] * rates[i / 3][i % 3] * rates[j / 3][j % 3];
        }
        // a handle under a force f turns by θ × h + ½θ × (θ × h) + …: ½(f hᵀ + h fᵀ) − f·h
        for (end, handle) in self.handles.iter().enumerate() {
            let (first, force) = (6 * end + 3, self.normal * -sum.force[1 + end]);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let straightens = if i == j { force.dot(handle) } else { 0.0 };
                tangent[first + i][first + j] += 0.5 * (force[i] * handle[j] + handle[i] * force[j]) - straightens;
            }
        }
        tangent
    }
}

impl PlaneContact {
    /// Smallest gap \[L\]; infinite if no zones were asked for.
    pub(crate) fn min_gap(&self) -> f64 {
        self.zones.iter().map(|zone| zone.min_gap).fold(f64::INFINITY, f64::min)
    }

    /// ∂gap/∂x at each point by the ends of the segment, which is one of `set`, and weight × stiffness there \[F/L\].
    pub(crate) fn gap_gradients<'a>(
        &'a self,
        set: &CurveSet,
        normal: Vec3,
    ) -> impl Iterator<Item = ([f64; 12], f64)> + 'a {
        let ends = Ends::of(set, self.segment, normal);
        self.points.iter().map(move |point| (ends.along(&cubic_weights(point.u)), point.stiffness))
    }

    /// Σ W k e ∂gap/∂x by the ends of the segment where the term was evaluated, its handles those of `set`: the gradient
    /// of a law that went on linearly, e the change of gap at each point in contact, of which `change` gives that at the
    /// control points \[L\].
    pub(crate) fn of_changes(&self, handles: [Vec3; 2], normal: Vec3, change: &[f64; 4]) -> [f64; 12] {
        let mut sum = [0.0; 4];
        for point in &self.points {
            let w = cubic_weights(point.u);
            let gap: f64 = w.iter().zip(change).map(|(w, change)| w * change).sum();
            (0..4).for_each(|m| sum[m] += point.stiffness * gap * w[m]);
        }
        Ends { normal, handles }.along(&sum)
    }
}

/// A zone with the segment and the plane that it is of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlanePiece {
    pub(crate) segment: usize,
    pub(crate) plane: usize,
    pub(crate) zone: PlaneZone,
}

/// The zones of each contact of a strand with a plane, in the order of arc length: those that end where a segment does
/// go on in one that begins where the next one does. Over the seam of a closed strand, too.
pub(crate) fn plane_runs(set: &CurveSet, contacts: &[PlaneContact]) -> Vec<Vec<PlanePiece>> {
    let pieces = |contact: &PlaneContact| {
        let (segment, plane) = (contact.segment, contact.plane);
        contact.zones.iter().map(move |zone| PlanePiece { segment, plane, zone: *zone }).collect::<Vec<_>>()
    };
    let mut all: Vec<PlanePiece> = contacts.iter().flat_map(pieces).collect();
    all.sort_by_key(|piece| piece.plane);
    let goes_on = |last: &PlanePiece, next: &PlanePiece| {
        let joined = last.plane == next.plane && set.next(last.segment) == Some(next.segment);
        joined && last.zone.u[1] == 1.0 && next.zone.u[0] == 0.0
    };
    let mut runs: Vec<Vec<PlanePiece>> = Vec::new();
    for piece in all {
        match runs.last_mut() {
            Some(run) if run.last().is_some_and(|last| goes_on(last, &piece)) => run.push(piece),
            _ => runs.push(vec![piece]),
        }
    }
    // over a seam the last run of a strand goes on in its first
    for first in (0..runs.len()).rev() {
        let head = runs[first][0];
        let before = (first + 1..runs.len()).find(|&k| runs[k].last().is_some_and(|last| goes_on(last, &head)));
        if let Some(before) = before {
            let rest = std::mem::take(&mut runs[first]);
            runs[before].extend(rest);
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

#[cfg(test)]
mod tests;
