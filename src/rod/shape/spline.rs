//! C² cubic splines through points over chord length, resampled by arc length, with twist-free frames.

use crate::error::InputError;
use crate::math::{Quat, Vec3};

use super::{Placement, finite, frame, normal_to};

/// Gauss–Legendre rule of 8 points on −1..1 (Abramowitz & Stegun 1964, table 25.4): positive abscissae and weights.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Relative accuracy of arc lengths and (absolute, rad) of transport angles over one spline piece.
const ACCURACY: f64 = 1e-14;

/// Largest number of halvings of one piece; no smooth curve needs pieces of 2⁻³⁰.
const MAX_DEPTH: usize = 30;

/// One cubic r(u) = c0 + c1 u + c2 u² + c3 u³, 0 ≤ u ≤ `span`.
struct SplinePiece {
    coefficients: [Vec3; 4],
    span: f64,
}

impl SplinePiece {
    fn position(&self, u: f64) -> Vec3 {
        let [c0, c1, c2, c3] = self.coefficients;
        c0 + (c1 + (c2 + c3 * u) * u) * u
    }

    fn derivative(&self, u: f64) -> Vec3 {
        let [_, c1, c2, c3] = self.coefficients;
        c1 + (c2 * 2.0 + c3 * (3.0 * u)) * u
    }

    fn second_derivative(&self, u: f64) -> Vec3 {
        let [_, _, c2, c3] = self.coefficients;
        c2 * 2.0 + c3 * (6.0 * u)
    }

    fn arc_length(&self, from: f64, to: f64) -> f64 {
        let speed = |u: f64| self.derivative(u).norm();
        integrate(&speed, from, to, ACCURACY * self.span, MAX_DEPTH)
    }

    /// Parameter at arc length `arc` (0 ≤ arc ≤ `total`) from the start: Newton's method inside a shrinking bracket.
    fn parameter_at(&self, arc: f64, total: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.span);
        let mut u = self.span * arc / total;
        for _ in 0..60 {
            let excess = self.arc_length(0.0, u) - arc;
            if excess.abs() <= 1e-15 * total {
                break;
            }
            if excess > 0.0 {
                high = u
            } else {
                low = u
            }
            let newton = u - excess / self.derivative(u).norm();
            u = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        u
    }

    /// Parallel transport of `d1` from `from` to `to`; returns it with the tangent there.
    ///
    /// The smallest rotation from the tangent t0 to t(u) carries a frame with twist −(t0 × t)·t′/(1 + t0·t) per u; a
    /// rotation by its integral removes it. Exact up to quadrature; steps are short enough that t0·t stays above ½.
    /// `None` over a cusp, where no step is short enough.
    fn transport(&self, d1: Vec3, from: f64, to: f64, depth: usize) -> Option<Vec3> {
        let tangent_0 = self.derivative(from).normalize();
        let tangent_1 = self.derivative(to).normalize();
        let tangent_mid = self.derivative(0.5 * (from + to)).normalize();
        if tangent_0.dot(&tangent_1).min(tangent_0.dot(&tangent_mid)) < 0.5 {
            let (middle, depth) = (0.5 * (from + to), depth.checked_sub(1)?);
            return self.transport(self.transport(d1, from, middle, depth)?, middle, to, depth);
        }
        let twist_rate = |u: f64| {
            let derivative = self.derivative(u);
            let (tangent, speed) = (derivative.normalize(), derivative.norm());
            tangent_0.cross(&tangent).dot(&self.second_derivative(u)) / (speed * (1.0 + tangent_0.dot(&tangent)))
        };
        let twist = integrate(&twist_rate, from, to, ACCURACY, MAX_DEPTH);
        let carried = Quat::rotation_between(&tangent_0, &tangent_1).map_or(d1, |rotation| rotation * d1);
        let (sin, cos) = twist.sin_cos();
        Some(carried * cos + tangent_1.cross(&carried) * sin)
    }
}

/// A spline through points, open (natural ends) or closed (periodic).
pub(super) struct Spline {
    pieces: Vec<SplinePiece>,
    closed: bool,
}

impl Spline {
    /// # Errors
    /// Fewer than 2 (open) or 3 (closed) points, points that are not finite, consecutive points that coincide.
    pub(super) fn new(points: &[Vec3], closed: bool) -> Result<Self, InputError> {
        check_points(points, closed)?;
        let num_pieces = points.len() - usize::from(!closed);
        let next = |i: usize| points[(i + 1) % points.len()];
        let spans: Vec<f64> = (0..num_pieces).map(|i| (next(i) - points[i]).norm()).collect();
        let slopes: Vec<Vec3> = (0..num_pieces).map(|i| (next(i) - points[i]) / spans[i]).collect();
        let seconds = if closed { periodic_seconds(&spans, &slopes) } else { natural_seconds(&spans, &slopes) };
        let piece = |i: usize| {
            let (h, m0, m1) = (spans[i], seconds[i], seconds[(i + 1) % seconds.len()]);
            let c1 = slopes[i] - (m0 * 2.0 + m1) * (h / 6.0);
            SplinePiece { coefficients: [points[i], c1, m0 * 0.5, (m1 - m0) / (6.0 * h)], span: h }
        };
        Ok(Self { pieces: (0..num_pieces).map(piece).collect(), closed })
    }

    /// Nodes at equal arc lengths, frames transported from the first.
    pub(super) fn place(&self, num_segments: usize) -> Result<Placement, InputError> {
        let lengths: Vec<f64> = self.pieces.iter().map(|piece| piece.arc_length(0.0, piece.span)).collect();
        let length: f64 = lengths.iter().sum();
        let num_nodes = num_segments + usize::from(!self.closed);
        let (mut piece, mut from, mut start) = (0, 0.0, 0.0);
        let tangent = self.pieces[0].derivative(0.0).normalize();
        let mut d1 = normal_to(&tangent, &Vec3::z(), &Vec3::x());
        let mut placement = Placement { length, positions: Vec::new(), frames: Vec::new(), closed: self.closed };
        for node in 0..num_nodes {
            let arc = length * (node as f64 / num_segments as f64);
            while arc > start + lengths[piece] && piece + 1 < self.pieces.len() {
                let end = self.pieces[piece].span;
                d1 = self.pieces[piece].transport(d1, from, end, MAX_DEPTH).ok_or_else(|| cusp(piece))?;
                start += lengths[piece];
                (piece, from) = (piece + 1, 0.0);
            }
            let current = &self.pieces[piece];
            let to = current.parameter_at((arc - start).clamp(0.0, lengths[piece]), lengths[piece]);
            d1 = current.transport(d1, from, to, MAX_DEPTH).ok_or_else(|| cusp(piece))?;
            from = to;
            placement.positions.push(current.position(to));
            placement.frames.push(frame(&d1, &self.tangent(current, to, piece)?));
        }
        Ok(placement)
    }

    fn tangent(&self, piece: &SplinePiece, u: f64, index: usize) -> Result<Vec3, InputError> {
        let derivative = piece.derivative(u);
        if derivative.norm() > 1e-6 {
            return Ok(derivative.normalize());
        }
        Err(cusp(index))
    }
}

fn cusp(piece: usize) -> InputError {
    let next = piece + 1;
    let reason = format!(
        "the curve through the points turns back on itself in a cusp between points {piece} and {next}: move points, \
         or add some"
    );
    InputError::Inconsistent { field: "shape.points".into(), reason }
}

/// Largest distance of points, because squares of larger ones overflow.
const FARTHEST: f64 = 1e150;

fn check_points(points: &[Vec3], closed: bool) -> Result<(), InputError> {
    let (needed, allowed) =
        if closed { (3, "at least 3 points for a closed rod") } else { (2, "at least 2 points for an open rod") };
    if points.len() < needed {
        return Err(InputError::Count { field: "shape.points".into(), value: points.len(), allowed });
    }
    for (i, point) in points.iter().enumerate() {
        finite(&format!("shape.points[{i}]"), point)?;
    }
    let size = points.iter().map(|point| (point - points[0]).amax()).fold(0.0, f64::max);
    if size > FARTHEST {
        let reason =
            format!("points lie {size:e} apart: more than {FARTHEST:e}, beyond which squares of distances overflow");
        return Err(InputError::Inconsistent { field: "shape.points".into(), reason });
    }
    for i in 0..points.len() - usize::from(!closed) {
        let next = (i + 1) % points.len();
        if (points[next] - points[i]).norm() <= 1e-12 * size {
            let hint = if next == 0 { "; a closed rod does not repeat its first point at the end" } else { "" };
            let reason = format!("points {i} and {next} coincide{hint}");
            return Err(InputError::Inconsistent { field: "shape.points".into(), reason });
        }
    }
    Ok(())
}

/// Second derivatives at the knots, zero at both ends: h₋ m₋ + 2(h₋ + h₊) m + h₊ m₊ = 6 (slope₊ − slope₋).
fn natural_seconds(spans: &[f64], slopes: &[Vec3]) -> Vec<Vec3> {
    let inner = spans.len() - 1;
    let diagonal: Vec<f64> = (0..inner).map(|i| 2.0 * (spans[i] + spans[i + 1])).collect();
    let right: Vec<Vec3> = (0..inner).map(|i| (slopes[i + 1] - slopes[i]) * 6.0).collect();
    let mut seconds = vec![Vec3::zeros()];
    seconds.extend(solve_tridiagonal(&spans[1..], &diagonal, right));
    seconds.push(Vec3::zeros());
    seconds
}

/// The same equations around a closed curve, by the Sherman–Morrison formula for the two corner entries.
fn periodic_seconds(spans: &[f64], slopes: &[Vec3]) -> Vec<Vec3> {
    let n = spans.len();
    let before = |i: usize| (i + n - 1) % n;
    let corner = spans[n - 1];
    let mut diagonal: Vec<f64> = (0..n).map(|i| 2.0 * (spans[before(i)] + spans[i])).collect();
    let pivot = -diagonal[0];
    diagonal[0] -= pivot;
    diagonal[n - 1] -= corner * corner / pivot;
    let right: Vec<Vec3> = (0..n).map(|i| (slopes[i] - slopes[before(i)]) * 6.0).collect();
    let mut seconds = solve_tridiagonal(&spans[..n - 1], &diagonal, right);
    let mut border = vec![Vec3::zeros(); n];
    (border[0].x, border[n - 1].x) = (pivot, corner);
    let border: Vec<f64> = solve_tridiagonal(&spans[..n - 1], &diagonal, border).iter().map(|z| z.x).collect();
    let ratio = corner / pivot;
    let factor = (seconds[0] + seconds[n - 1] * ratio) / (1.0 + border[0] + border[n - 1] * ratio);
    for (second, z) in seconds.iter_mut().zip(border) {
        *second -= factor * z;
    }
    seconds
}

/// Thomas algorithm for a symmetric, diagonally dominant matrix; `off[i]` couples rows i and i + 1.
fn solve_tridiagonal(off: &[f64], diagonal: &[f64], mut right: Vec<Vec3>) -> Vec<Vec3> {
    let mut pivots = diagonal.to_vec();
    for i in 1..right.len() {
        let factor = off[i - 1] / pivots[i - 1];
        pivots[i] -= factor * off[i - 1];
        let above = right[i - 1];
        right[i] -= above * factor;
    }
    for i in (0..right.len()).rev() {
        if i + 1 < right.len() {
            let below = right[i + 1];
            right[i] -= below * off[i];
        }
        right[i] /= pivots[i];
    }
    right
}

/// ∫ f over `from`..`to`, halved until two halves agree with the whole within `tolerance`.
fn integrate(f: &dyn Fn(f64) -> f64, from: f64, to: f64, tolerance: f64, depth: usize) -> f64 {
    let middle = 0.5 * (from + to);
    let whole = gauss(f, from, to);
    let halves = gauss(f, from, middle) + gauss(f, middle, to);
    // NaN ends the subdivision
    if depth == 0 || !halves.is_finite() || (whole - halves).abs() <= tolerance {
        return halves;
    }
    integrate(f, from, middle, tolerance, depth - 1) + integrate(f, middle, to, tolerance, depth - 1)
}

pub(super) fn gauss(f: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (center, half) = (0.5 * (from + to), 0.5 * (to - from));
    half * GAUSS.iter().map(|(x, weight)| weight * (f(center - half * x) + f(center + half * x))).sum::<f64>()
}
