//! Terms of strands against rigid bodies, which no strand may enter or leave: supports that only push.
//!
//! ```text
//! U = Σ_segments ∫_zone ½ κ ⟨c(s) − gap(s)⟩² ds        gap = φ(r(s)) − ε
//! ```
//!
//! φ is the signed distance from the body's surface, `math::signed_distance`, c the offset, linear between the ends of
//! a segment, ε the radius. Nothing is projected: along a segment, a cubic, a polynomial rises with the distance δ from
//! the body's skeleton, δ itself of a plane, δ² of others. Zones end at roots of this polynomial less that of the
//! distance up to which pressure reaches, and gaps are smallest at roots of its derivative. At a point under pressure
//! p, with n = ∇φ,
//!
//! ```text
//! δU = −p n·δr      δ²U = k (n·δr)² − p δr·∇∇φ δr − p n·δ²r
//! ```
//!
//! A node may carry the body: its point c moves by δc, and it turns about c by a rotation vector θ. With a = r − c and
//! w = δr − δc − θ × a, how the strand moves as the body sees it,
//!
//! ```text
//! δU = −p n·w      δ²U = k (n·w)² − p w·∇∇φ w − p n·δ²r − 2 p n·((δr − δc) × θ) − p n·(θ × (θ × a))
//! ```
//!
//! A plane does to a strand what the strand's mirror image would, at the distance 2(gap + ε) of its own: the law's
//! contact distance is 2ε.

use std::ops::Range;

use super::Pressures;
use super::pressure::PairLaw;
use crate::contact::curves::curve::CurveSet;
use crate::contact::law::potential::Request;
use crate::contact::law::potential::stiffness::PairTangent;
use crate::contact::measures::{MAX_PARTS, POINTS_PER_PART};
use crate::math::bernstein::{Roots, cubic_weights, derivative, roots};
use crate::math::handles::{Handles, StretchTerms};
use crate::math::parallel::DEAR;
use crate::math::quadrature::gauss;
use crate::math::signed_distance::{Skeleton, Surface};
use crate::math::{Mat3, Vec3, parallel};

/// Control points of a segment relative to a surface's own point \[L\].
pub(crate) fn relative(surface: &Surface, set: &CurveSet, segment: usize) -> [Vec3; 4] {
    let points = &set.segments[segment].b;
    let lost = set.remainders.get(segment).copied().unwrap_or_default();
    std::array::from_fn(|m| (points[m] - surface.point()) + (lost[m] - surface.lost))
}

/// A ball about the control points of a segment: its centre and radius \[L\]. Where strands are far from a surface it
/// says so for less than the control points.
pub(crate) fn ball(set: &CurveSet, segment: usize) -> (Vec3, f64) {
    let points = &set.segments[segment].b;
    let middle = (points[0] + points[3]) * 0.5;
    (middle, points.iter().map(|point| (point - middle).norm_squared()).fold(0.0, f64::max).sqrt())
}

/// A point of a cubic.
pub(crate) fn point_of(r: &[Vec3; 4], u: f64) -> Vec3 {
    cubic_weights(u).iter().zip(r).map(|(w, r)| r * *w).sum()
}

/// One piece of a contact zone, for reports and multiplier updates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SurfaceZone {
    /// Parameters of both ends, ascending, in \[0, 1\].
    pub(crate) u: [f64; 2],
    /// Smallest gap inside \[L\].
    pub(crate) min_gap: f64,
    /// Where it is.
    pub(crate) nearest: f64,
    /// ∫p ds, ∫p u ds and ∫p u² ds \[F\].
    pub(crate) moments: [f64; 3],
    /// ∫p n ds \[F\].
    pub(crate) force: Vec3,
    /// ∫p (x − x₀) × n ds \[F·L\], x₀ the start of the segment.
    pub(crate) torque: Vec3,
}

/// A quadrature point in contact: its parameter, weight × stiffness of the law \[F/L\], normal, and place relative to
/// the surface's own point \[L\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct SurfacePoint {
    u: f64,
    stiffness: f64,
    normal: Vec3,
    arm: Vec3,
}

/// A segment in contact with a surface, kept after its term is summed.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceContact {
    pub(crate) segment: usize,
    pub(crate) surface: usize,
    /// None unless requested.
    pub(crate) zones: Vec<SurfaceZone>,
    /// None unless the tangent was requested.
    points: Vec<SurfacePoint>,
}

/// A term with respect to both ends of a segment, six coordinates each (displacement, rotation vector), and the same of
/// the node that carries the body; zero of one that none carries.
pub(crate) struct SurfaceTerm {
    pub(crate) contact: SurfaceContact,
    /// Energy \[F·L\].
    pub(crate) energy: f64,
    pub(crate) gradient: [f64; 18],
    /// Second derivative, the first eighteen rows and columns filled; none unless requested.
    pub(crate) tangent: Option<Box<PairTangent>>,
}

/// Terms of those pairs of a segment and a surface that touch, in their order. `pressures.offset(segment, surface)` is
/// the offset c at both ends of a segment towards a surface \[L\].
pub(crate) fn evaluate(
    set: &CurveSet,
    (surfaces, pairs): (&[Surface], &[[u32; 2]]),
    pressures: &Pressures,
    request: Request,
) -> Vec<SurfaceTerm> {
    let of_range = |range: Range<usize>| {
        let pairs = pairs[range].iter().map(|pair| (pair[0] as usize, pair[1] as usize));
        pairs.filter_map(|at| term(set, surfaces, at, pressures, request)).collect::<Vec<_>>()
    };
    parallel::map_ranges(pairs.len(), DEAR, &of_range).into_iter().flatten().collect()
}

/// The term of one segment and one surface; none where they do not touch.
pub(crate) fn term(
    set: &CurveSet,
    surfaces: &[Surface],
    (segment, surface): (usize, usize),
    pressures: &Pressures,
    request: Request,
) -> Option<SurfaceTerm> {
    let body = &surfaces[surface];
    let r = relative(body, set, segment);
    let radius = set.radius_of(segment);
    let contact_distance = 2.0 * radius;
    let reach = pressures.reach(segment, surface, contact_distance);
    // distance up to which pressure reaches
    let limit = reach.map(|reach| reach - radius);
    if body.least_in_hull(&r) >= limit[0].max(limit[1]) {
        return None;
    }
    let intervals = where_nearer(body, &r, limit);
    if intervals.is_empty() {
        return None;
    }
    let length = set.lengths[segment];
    let offset = (pressures.offset)(segment, surface);
    let law = PairLaw { pressures, contact_distance, share: 1.0, length, reach, offset, straight: false, span: length };
    let mut sum = SurfaceSum::default();
    let mut zones = Vec::new();
    for u in intervals {
        let force_before = sum.force;
        let mut moments = [0.0; 3];
        for part in smooth_parts(body, &r, u) {
            let of_part = sum.add_zone(part, &law, (body, &r), request.tangent);
            (0..3).for_each(|k| moments[k] += of_part[k]);
        }
        if request.zones {
            let (nearest, distance) = nearest_in(body, &r, u);
            let force: [Vec3; 4] = std::array::from_fn(|m| sum.force[m] - force_before[m]);
            let torque = (1..4).map(|m| (r[m] - r[0]).cross(&force[m])).sum();
            zones.push(SurfaceZone {
                u,
                min_gap: distance - radius,
                nearest,
                moments,
                force: force.iter().sum(),
                torque,
            });
        }
    }
    let handles = Handles::of(&set.segments[segment].b);
    Some(SurfaceTerm {
        energy: sum.energy,
        gradient: gradient(&handles, &sum.force, &sum.torque),
        tangent: request.tangent.then(|| sum.tangent(&handles, body.carried)),
        contact: SurfaceContact { segment, surface, zones, points: sum.points },
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

/// Bernstein coefficients of polynomials along a cubic, one of which rises with the distance δ from the skeleton at any
/// place: δ of a plane, δ² of others. `of_linear` is the same of a distance that is linear, from one end to the other.
fn rising(surface: &Surface, r: &[Vec3; 4]) -> Vec<Vec<f64>> {
    let squared = |away: [Vec3; 4]| square(|i, j| away[i].dot(&away[j]));
    match surface.skeleton {
        Skeleton::Plane { normal, .. } => vec![r.iter().map(|r| normal.dot(r)).collect()],
        Skeleton::Point { .. } => vec![squared(*r)],
        Skeleton::Line { axis, .. } => vec![squared(across(r, &axis))],
        Skeleton::Piece { axis, .. } => {
            let of_ends = surface.skeleton.ends().map(|end| squared(r.map(|r| r - axis * end)));
            of_ends.chain([squared(across(r, &axis))]).collect()
        }
    }
}

/// The parts of control points that lead away from a line.
fn across(r: &[Vec3; 4], axis: &Vec3) -> [Vec3; 4] {
    r.map(|r| r - axis * axis.dot(&r))
}

/// An interval cut where the second derivative of φ jumps.
fn smooth_parts(surface: &Surface, r: &[Vec3; 4], [start, end]: [f64; 2]) -> Vec<[f64; 2]> {
    let mut cuts = vec![start, end];
    if let Skeleton::Piece { axis, .. } = surface.skeleton {
        for at in surface.skeleton.ends() {
            let mut found = Roots::new();
            roots(&r.map(|r| axis.dot(&r) - at), &mut found);
            cuts.extend(found.as_slice().iter().filter(|u| **u > start && **u < end));
        }
        cuts.sort_by(f64::total_cmp);
    }
    cuts.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// See [`rising`].
fn of_linear(surface: &Surface, ends: [f64; 2]) -> Vec<f64> {
    let elevated: [f64; 4] = std::array::from_fn(|m| ends[0] + (ends[1] - ends[0]) * (m as f64 / 3.0));
    if surface.skeleton.is_flat() { elevated.to_vec() } else { square(|i, j| elevated[i] * elevated[j]) }
}

/// Bernstein coefficients, degree six, of the square of a cubic; `products(i, j)` is that of its coefficients i and j.
fn square(products: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    const CUBIC: [f64; 4] = [1.0, 3.0, 3.0, 1.0];
    const SEXTIC: [f64; 7] = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
    let mut sum = vec![0.0; 7];
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        sum[i + j] += CUBIC[i] * CUBIC[j] / SEXTIC[i + j] * products(i, j);
    }
    sum
}

/// Where a cubic is nearer to a surface than a distance that is linear from one end to the other, ascending.
fn where_nearer(surface: &Surface, r: &[Vec3; 4], limit: [f64; 2]) -> Vec<[f64; 2]> {
    let of_skeleton = limit.map(|limit| surface.level + surface.sign * limit);
    let there = of_linear(surface, of_skeleton);
    let beyond = |here: &Vec<f64>| -> Vec<f64> {
        here.iter().zip(&there).map(|(here, there)| surface.sign * (there - here)).collect()
    };
    let beyond: Vec<Vec<f64>> = rising(surface, r).iter().map(beyond).collect();
    let has_sign = surface.skeleton.is_flat() || of_skeleton.iter().all(|distance| *distance > 0.0);
    if has_sign && beyond.iter().flatten().all(|x| *x <= 0.0) {
        return Vec::new();
    }
    if has_sign && beyond.iter().flatten().all(|x| *x > 0.0) {
        return vec![[0.0, 1.0]];
    }
    let mut ends = Vec::new();
    for beyond in &beyond {
        let mut found = Roots::new();
        roots(beyond, &mut found);
        ends.extend(found.as_slice());
    }
    if !has_sign {
        // squares do not tell a distance from its negative
        ends.push(of_skeleton[0] / (of_skeleton[0] - of_skeleton[1]));
    }
    ends.retain(|u| *u > 0.0 && *u < 1.0);
    ends.sort_by(f64::total_cmp);
    ends.insert(0, 0.0);
    ends.push(1.0);
    let is_nearer = |u: f64| surface.distance(&point_of(r, u)) < limit[0] + (limit[1] - limit[0]) * u;
    let mut zones: Vec<[f64; 2]> = Vec::new();
    for pair in ends.windows(2).filter(|pair| is_nearer(0.5 * (pair[0] + pair[1]))) {
        match zones.last_mut().filter(|last| last[1] == pair[0]) {
            Some(last) => last[1] = pair[1],
            None => zones.push([pair[0], pair[1]]),
        }
    }
    zones
}

/// Place and value of the smallest distance of a cubic from a surface in an interval.
pub(crate) fn nearest_in(surface: &Surface, r: &[Vec3; 4], [start, end]: [f64; 2]) -> (f64, f64) {
    let mut stationary = Vec::new();
    for rising in rising(surface, r) {
        let mut found = Roots::new();
        roots(&derivative(&rising)[..rising.len() - 1], &mut found);
        stationary.extend(found.as_slice());
    }
    let inside = stationary.into_iter().filter(|u| *u > start && *u < end);
    let places = [start, end].into_iter().chain(inside).map(|u| (u, surface.distance(&point_of(r, u))));
    places.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((start, f64::INFINITY))
}

/// Sums over the quadrature points of a term.
#[derive(Debug, Default)]
struct SurfaceSum {
    energy: f64,
    /// ∫p w_m n ds of the four control points \[F\].
    force: [Vec3; 4],
    /// ∫p a × n ds, of the force about the surface's own point \[F·L\].
    torque: Vec3,
    /// ∫a_i a_j (k n nᵀ − p ∇∇φ) ds, a the shares of the ends in a point, see [`shares`] \[F/L\].
    stiffness: [[Mat3; 4]; 4],
    /// What a body that a node carries adds to it.
    carried: CarriedStiffness,
    /// The points in contact, if the tangent was requested.
    points: Vec<SurfacePoint>,
}

impl SurfaceSum {
    /// Adds the zone between two parameters of a segment; returns ∫p ds, ∫p u ds and ∫p u² ds.
    fn add_zone(
        &mut self,
        zone: [f64; 2],
        law: &PairLaw,
        (surface, r): (&Surface, &[Vec3; 4]),
        tangent: bool,
    ) -> [f64; 3] {
        let mut moments = [0.0; 3];
        let radius = 0.5 * law.contact_distance;
        for_each_point(zone, law.length, law.contact_distance, |u, weight| {
            let here = point_of(r, u);
            let (response, carried) = law.response(u, surface.distance(&here) + radius);
            if carried == 0.0 {
                return;
            }
            let normal = surface.normal(&here);
            let force = weight * response.pressure;
            self.energy += weight * response.energy;
            (0..3).for_each(|k| moments[k] += force * u.powi(k as i32));
            cubic_weights(u).iter().zip(&mut self.force).for_each(|(w, sum)| *sum += normal * (force * w));
            self.torque += here.cross(&normal) * force;
            if tangent && response.stiffness.is_finite() {
                let stiffness = weight * response.stiffness;
                let matrix = normal * normal.transpose() * stiffness - surface.curvature(&here) * (weight * carried);
                self.add_stiffness(u, &matrix);
                if surface.carried {
                    self.carried.add(u, &matrix, (&here, &(normal * (weight * carried))));
                }
                self.points.push(SurfacePoint { u, stiffness, normal, arm: here });
            }
        });
        moments
    }

    fn add_stiffness(&mut self, u: f64, matrix: &Mat3) {
        let a = shares(&cubic_weights(u));
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            self.stiffness[i][j] += matrix * (a[i] * a[j]);
        }
    }

    fn tangent(&self, handles: &Handles, carried: bool) -> Box<PairTangent> {
        let mut tangent: Box<PairTangent> = Box::new([[0.0; 24]; 24]);
        let maps = rates(&handles.of_ends);
        let mut stretch = StretchTerms::<1, 18>::ZERO;
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let block = maps[i].transpose() * self.stiffness[i][j] * maps[j];
            (0..9).for_each(|k| tangent[3 * i + k / 3][3 * j + k % 3] = block[(k / 3, k % 3)]);
        }
        if carried {
            self.carried.add_to(&mut tangent, &maps);
        }
        // a handle under a force f turns by θ × h + ½θ × (θ × h) + …: ½(f hᵀ + h fᵀ) − f·h
        for (end, handle) in handles.of_ends.iter().enumerate() {
            let (first, force) = (6 * end + 3, -self.force[1 + end]);
            let share = 2 * end + 1;
            for (q, other) in handles.of_ends.iter().enumerate() {
                let [moved, turned] = [0, 1].map(|k| self.stiffness[share][2 * q + k].transpose() * handle);
                stretch.add_motion([end, q], other, [&moved, &turned]);
            }
            if carried {
                let by_body = [-self.carried.displaced[share], self.carried.turned[share]];
                let by_body = by_body.map(|block| block.transpose() * handle);
                (0..6).for_each(|k| stretch.mixed[0][12 + k] += by_body[k / 3][k % 3]);
            }
            stretch.add_force(end, handle, &force);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let straightens = if i == j { force.dot(handle) } else { 0.0 };
                tangent[first + i][first + j] += 0.5 * (force[i] * handle[j] + handle[i] * force[j]) - straightens;
            }
        }
        stretch.each_entry([handles], |row, col, value| tangent[row][col] += value);
        tangent
    }
}

/// Sums over the quadrature points of what the motion of the node that carries a body adds to a second derivative. A
/// strand moves by w = Σ a_i δ_i − δc + A θ as the body sees it, A θ = a × θ, under M = k n nᵀ − p ∇∇φ.
#[derive(Debug, Default)]
struct CarriedStiffness {
    /// ∫a_i M ds, and ∫M ds \[F/L\].
    displaced: [Mat3; 5],
    /// ∫a_i (M A + \[p n\]×) ds, and ∫M A + \[p n\]× ds \[F\].
    turned: [Mat3; 5],
    /// ∫Aᵀ M A − p (½(n aᵀ + a nᵀ) − n·a) ds \[F·L\].
    spun: Mat3,
}

impl CarriedStiffness {
    /// Adds a point at `arm` from the body's, with M ds and p n ds.
    fn add(&mut self, u: f64, matrix: &Mat3, (arm, force): (&Vec3, &Vec3)) {
        let turning = arm.cross_matrix();
        let turned = matrix * turning + force.cross_matrix();
        let [a, b, c, d] = shares(&cubic_weights(u));
        for (k, share) in [a, b, c, d, 1.0].into_iter().enumerate() {
            self.displaced[k] += matrix * share;
            self.turned[k] += turned * share;
        }
        let straightens = (force * arm.transpose() + arm * force.transpose()) * 0.5 - Mat3::identity() * force.dot(arm);
        self.spun += turning.transpose() * matrix * turning - straightens;
    }

    /// Fills the rows and columns of the node, 12 to 17; `maps` are the [`rates`] of the segment's ends.
    fn add_to(&self, tangent: &mut PairTangent, maps: &[Mat3; 4]) {
        let mut put = |[i, j]: [usize; 2], block: Mat3| {
            for (k, l) in (0..3).flat_map(|k| (0..3).map(move |l| (k, l))) {
                tangent[3 * i + k][3 * j + l] = block[(k, l)];
                tangent[3 * j + l][3 * i + k] = block[(k, l)];
            }
        };
        for (i, map) in maps.iter().enumerate() {
            put([i, 4], -map.transpose() * self.displaced[i]);
            put([i, 5], map.transpose() * self.turned[i]);
        }
        put([4, 4], self.displaced[4]);
        put([4, 5], -self.turned[4]);
        put([5, 5], self.spun);
    }
}

/// Shares of displacement and handle of the start, and of the end, in a sum over the control points.
fn shares(w: &[f64; 4]) -> [f64; 4] {
    [w[0] + w[1], w[1], w[2] + w[3], w[2]]
}

/// Motions of a point that has no share but that of the displacement, or the handle, of an end: by its displacement, or
/// its rotation vector.
fn rates(handles: &[Vec3; 2]) -> [Mat3; 4] {
    let turned = handles.map(|handle| -handle.cross_matrix());
    [Mat3::identity(), turned[0], Mat3::identity(), turned[1]]
}

/// Minus forces on the four control points, by the displacement and rotation of both ends; of the node that carries the
/// body their sum, and the torque of the forces about the body's point.
fn gradient(handles: &Handles, force: &[Vec3; 4], torque: &Vec3) -> [f64; 18] {
    let of_ends = handles.pull(std::array::from_fn(|m| &force[m]));
    let of_body = [-force.iter().sum::<Vec3>(), -torque];
    std::array::from_fn(|i| if i < 12 { -of_ends[i] } else { -of_body[i / 3 - 4][i % 3] })
}

impl SurfaceContact {
    /// Smallest gap \[L\]; infinite if no zones were requested.
    pub(crate) fn min_gap(&self) -> f64 {
        self.zones.iter().map(|zone| zone.min_gap).fold(f64::INFINITY, f64::min)
    }

    /// Each point with ∂gap/∂x by the ends of the segment, which is one of `set`, and the node that carries the body,
    /// and weight × stiffness there \[F/L\].
    pub(crate) fn gap_gradients<'a>(&'a self, set: &'a CurveSet) -> impl Iterator<Item = (TouchedPoint, f64)> + 'a {
        self.points.iter().map(move |point| (self.touched(set, point.u, point.normal, &point.arm), point.stiffness))
    }

    /// The point of the smallest gap, if zones were requested.
    pub(crate) fn nearest(&self, set: &CurveSet, body: &Surface) -> Option<TouchedPoint> {
        let zone = self.zones.iter().min_by(|a, b| a.min_gap.total_cmp(&b.min_gap))?;
        let arm = point_of(&relative(body, set, self.segment), zone.nearest);
        Some(self.touched(set, zone.nearest, body.normal(&arm), &arm))
    }

    fn touched(&self, set: &CurveSet, u: f64, normal: Vec3, arm: &Vec3) -> TouchedPoint {
        let weights = cubic_weights(u).map(|w| -normal * w);
        let gap_gradient = gradient(&Handles::of(&set.segments[self.segment].b), &weights, &-arm.cross(&normal));
        TouchedPoint { gap_gradient, at: set.segments[self.segment].point(u), normal }
    }

    /// Σ W k e ∂gap/∂x by the ends of the segment where the term was evaluated, with these handles, and the node that
    /// carries the body: the gradient of a law that went on linearly, `change(u, normal)` the change e of the gap at
    /// each point in contact \[L\].
    pub(crate) fn of_changes(&self, handles: &Handles, change: impl Fn(f64, &Vec3) -> f64) -> [f64; 18] {
        let (mut sum, mut torque) = ([Vec3::zeros(); 4], Vec3::zeros());
        for point in &self.points {
            let force = point.normal * (-point.stiffness * change(point.u, &point.normal));
            cubic_weights(point.u).iter().zip(&mut sum).for_each(|(w, sum)| *sum += force * *w);
            torque += point.arm.cross(&force);
        }
        gradient(handles, &sum, &torque)
    }
}

/// A point of a segment at a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TouchedPoint {
    /// ∂gap/∂x by the ends of the segment and the node that carries the body.
    pub(crate) gap_gradient: [f64; 18],
    /// \[L\]
    pub(crate) at: Vec3,
    /// Of the surface, towards the strand.
    pub(crate) normal: Vec3,
}

/// A zone with the segment and the surface that it is of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePiece {
    pub(crate) segment: usize,
    pub(crate) surface: usize,
    pub(crate) zone: SurfaceZone,
}

/// The zones of each contact of a strand with a surface, in the order of arc length: those that end where a segment
/// does go on in one that begins where the next one does. Over the seam of a closed strand, too.
pub(crate) fn surface_runs(set: &CurveSet, contacts: &[SurfaceContact]) -> Vec<Vec<SurfacePiece>> {
    let pieces = |contact: &SurfaceContact| {
        let (segment, surface) = (contact.segment, contact.surface);
        contact.zones.iter().map(move |zone| SurfacePiece { segment, surface, zone: *zone }).collect::<Vec<_>>()
    };
    let mut all: Vec<SurfacePiece> = contacts.iter().flat_map(pieces).collect();
    all.sort_by_key(|piece| piece.surface);
    let goes_on = |last: &SurfacePiece, next: &SurfacePiece| {
        let joined = last.surface == next.surface && set.next(last.segment) == Some(next.segment);
        joined && last.zone.u[1] == 1.0 && next.zone.u[0] == 0.0
    };
    let mut runs: Vec<Vec<SurfacePiece>> = Vec::new();
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
