//! Parametrised curves sampled at equal arc lengths, with twist-free frames.

use crate::math::chebyshev::{ChebyshevRule, DEGREE};
use crate::math::{Quat, Vec3, parallel};

use super::spline::gauss;
use super::{Placement, frame, normal_to};

/// Relative accuracy of the arc length of one panel.
const ACCURACY: f64 = 1e-13;

/// Largest number of halvings of one panel.
const MAX_DEPTH: usize = 24;

/// A curve by its parameter: position and derivative, smooth between the breaks of its panels.
pub(super) trait Parametrised: Sync {
    fn at(&self, u: f64) -> [Vec3; 2];

    fn speed(&self, u: f64) -> f64 {
        self.at(u)[1].norm()
    }

    fn tangent(&self, u: f64) -> Vec3 {
        self.at(u)[1].normalize()
    }
}

/// A curve cut into panels on each of which an 8-point rule gives the arc length to rounding.
pub(super) struct Measured<'a, C> {
    curve: &'a C,
    /// Parameters at which panels begin, and the end of the last.
    breaks: Vec<f64>,
    /// Arc length up to each of them.
    arcs: Vec<f64>,
}

impl<'a, C: Parametrised> Measured<'a, C> {
    /// `breaks` in ascending order; the curve is smooth between them.
    pub(super) fn new(curve: &'a C, breaks: &[f64]) -> Self {
        let refined = parallel::map_ranges(breaks.len() - 1, parallel::DEAR, &|range| {
            let mut panels = Vec::new();
            range.for_each(|k| refine(curve, breaks[k], breaks[k + 1], MAX_DEPTH, &mut panels));
            panels
        });
        let (mut starts, mut arcs, mut sum) = (vec![breaks[0]], vec![0.0], 0.0);
        for (end, arc) in refined.into_iter().flatten() {
            sum += arc;
            starts.push(end);
            arcs.push(sum);
        }
        Self { curve, breaks: starts, arcs }
    }

    pub(super) fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    /// Parameter at an arc length: Newton's method inside the panel, in a shrinking bracket.
    fn parameter_at(&self, arc: f64) -> f64 {
        let last = self.breaks.len() - 2;
        let panel = self.arcs.partition_point(|&a| a <= arc).saturating_sub(1).min(last);
        let (start, end) = (self.breaks[panel], self.breaks[panel + 1]);
        let (wanted, total) = (arc - self.arcs[panel], self.arcs[panel + 1] - self.arcs[panel]);
        let (mut low, mut high) = (start, end);
        let mut u = start + (end - start) * (wanted / total).clamp(0.0, 1.0);
        for _ in 0..60 {
            let excess = gauss(&|u| self.curve.speed(u), start, u) - wanted;
            if excess.abs() <= 2e-15 * total {
                break;
            }
            *(if excess > 0.0 { &mut high } else { &mut low }) = u;
            let newton = u - excess / self.curve.speed(u);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - u).abs() <= 4.0 * f64::EPSILON * end.abs() {
                break;
            }
            u = next;
        }
        u
    }

    /// Transport between two parameters, panel by panel, because the speed of the parameter may jump between panels.
    fn carry(&self, rule: &ChebyshevRule, from: f64, to: f64) -> Carry {
        let first = self.breaks.partition_point(|&b| b <= from);
        let last = self.breaks.partition_point(|&b| b < to).max(first);
        let tangent = |u: f64| self.curve.tangent(u);
        let (start, mut at) = (tangent(from), from);
        let mut whole: Option<Carry> = None;
        for end in self.breaks[first..last].iter().copied().chain([to]) {
            let piece = Carry::new(rule, tangent, at, end, MAX_DEPTH);
            whole = Some(whole.map_or(piece, |before: Carry| before.then(&piece, start)));
            at = end;
        }
        whole.unwrap_or(Carry { rotation: Quat::identity(), turn: 0.0, to: start })
    }

    /// Nodes at equal arc lengths, frames transported from the first; `length` is the reference length (that of the
    /// curve to rounding).
    pub(super) fn place(&self, closed: bool, num_segments: usize, length: f64) -> Placement {
        let total = self.length();
        let num_nodes = num_segments + usize::from(!closed);
        let parameter = |node: usize| self.parameter_at(total * (node as f64 / num_segments as f64));
        let parameters = parallel::map(num_nodes, parallel::DEAR, &parameter);
        let rule = ChebyshevRule::new();
        let carry = |k: usize| self.carry(&rule, parameters[k], parameters[k + 1]);
        let carries = parallel::map(num_nodes - 1, parallel::DEAR, &carry);
        let tangent = self.curve.tangent(parameters[0]);
        let mut d1 = normal_to(&tangent, &Vec3::z(), &Vec3::x());
        let mut frames = vec![frame(&d1, &tangent)];
        for carry in &carries {
            d1 = carry.apply(&d1);
            frames.push(frame(&d1, &carry.to));
        }
        let positions = parallel::map(num_nodes, parallel::DEAR, &|node| self.curve.at(parameters[node])[0]);
        Placement { length, positions, frames, closed }
    }
}

/// Panels (end, arc length) between `from` and `to`, halved until both halves agree with the whole.
fn refine<C: Parametrised>(curve: &C, from: f64, to: f64, depth: usize, panels: &mut Vec<(f64, f64)>) {
    let speed = |u: f64| curve.speed(u);
    let middle = 0.5 * (from + to);
    let halves = [gauss(&speed, from, middle), gauss(&speed, middle, to)];
    let sum = halves[0] + halves[1];
    if depth == 0 || (gauss(&speed, from, to) - sum).abs() <= ACCURACY * sum {
        panels.push((to, sum));
    } else {
        refine(curve, from, middle, depth - 1, panels);
        refine(curve, middle, to, depth - 1, panels);
    }
}

/// Parallel transport from one tangent to another along a curve: the smallest rotation, then a rotation about the new
/// tangent.
///
/// The smallest rotation from the tangent t0 to t(u) carries a frame with twist −(t0 × t)·t′/(1 + t0·t) per u; a
/// rotation by its integral removes it. t is interpolated at degree 8, on pieces over which it rotates by less than ½
/// rad.
#[derive(Clone, Copy)]
struct Carry {
    rotation: Quat,
    turn: f64,
    to: Vec3,
}

impl Carry {
    fn new(rule: &ChebyshevRule, tangent: impl Fn(f64) -> Vec3 + Copy, from: f64, to: f64, depth: usize) -> Self {
        let t: [Vec3; DEGREE + 1] = rule.nodes.map(|x| tangent(0.5 * (from + to) + 0.5 * (to - from) * x));
        let (start, end) = (t[0], t[DEGREE]);
        if depth > 0 && t.iter().any(|t| t.dot(&start) < 0.877) {
            let middle = 0.5 * (from + to);
            let first = Self::new(rule, tangent, from, middle, depth - 1);
            return first.then(&Self::new(rule, tangent, middle, to, depth - 1), start);
        }
        let mut twist = 0.0;
        for i in 0..=DEGREE {
            let slope = (0..=DEGREE).fold(Vec3::zeros(), |s, j| s + t[j] * rule.derivative[i][j]);
            twist += rule.weights[i] * start.cross(&t[i]).dot(&slope) / (1.0 + start.dot(&t[i]));
        }
        let rotation = Quat::rotation_between(&start, &end).unwrap_or_else(Quat::identity);
        Self { rotation, turn: twist, to: end }
    }

    fn apply(&self, d1: &Vec3) -> Vec3 {
        let carried = self.rotation * d1;
        let (sin, cos) = self.turn.sin_cos();
        carried * cos + self.to.cross(&carried) * sin
    }

    /// The composition: the smallest rotation between the outer tangents and the remaining rotation.
    fn then(&self, next: &Self, start: Vec3) -> Self {
        let probe = normal_to(&start, &Vec3::z(), &Vec3::x());
        let rotation = Quat::rotation_between(&start, &next.to).unwrap_or_else(Quat::identity);
        let (direct, carried) = (rotation * probe, next.apply(&self.apply(&probe)));
        let turn = next.to.dot(&direct.cross(&carried)).atan2(direct.dot(&carried));
        Self { rotation, turn, to: next.to }
    }
}
