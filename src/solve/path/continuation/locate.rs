//! Where between two neighbouring points of a path something happens: a limit point, a branch point, a corner, the
//! target.

use crate::error::SolveError;
use crate::solve::measures::{HALVINGS, MAX_ROUNDS};
use crate::solve::path::continuation::PointKind;
use crate::solve::path::continuation::corrector::{Hyperplane, PathMotion, Point, Tracer};

/// Part of a step within which two events are one, because an eigenvalue that only touches zero crosses it there and
/// back by rounding.
const SAME_EVENT: f64 = 0.01;
/// Part of a bracket that a trial keeps from its ends, because a trial at an end shows nothing.
const MARGIN: f64 = 1e-3;

/// How far the states on both sides of a corner may be apart, relative to the step and in units of how well it is
/// located, because beyond it Newton has gone to another path.
const JUMP: [f64; 2] = [1e-4, 100.0];

/// Quantity whose sign changes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Test {
    /// The parameter's rate along the path: limit points.
    Slope,
    /// The parameter less its target.
    Target(f64),
    /// The critical eigenvalue; the number of unstable directions decides on the side.
    Critical,
}

/// One end of the interval: distance from the base, the tested function if known, the point there.
#[derive(Debug, Clone)]
struct End {
    distance: f64,
    value: Option<f64>,
    point: Point,
}

/// A zero: the last ends, the best point, and the numbers of unstable directions on either side.
struct Found {
    before: End,
    best: End,
    after: End,
    counts: [usize; 2],
}

/// An event between two points.
pub(super) struct Event {
    pub(super) kind: PointKind,
    pub(super) point: Point,
    pub(super) distance: f64,
}

impl Event {
    fn multiplicity(&self) -> usize {
        if let PointKind::Branch { multiplicity } = self.kind { multiplicity } else { 0 }
    }
}

impl Tracer<'_> {
    /// The point at `distance` from `base` along its tangent.
    pub(super) fn ahead(&mut self, base: &Point, distance: f64) -> Result<Option<Point>, SolveError> {
        self.correct(base, &base.tangent.scaled(distance), &Hyperplane { normal: &base.tangent, distance })
    }

    /// The same point, sought from a known one.
    fn beside(&mut self, base: &Point, from: &End, distance: f64) -> Result<Option<Point>, SolveError> {
        let (normal, left) = (&base.tangent, distance - from.distance);
        self.correct(&from.point, &normal.scaled(left), &Hyperplane { normal, distance: left })
    }

    /// Limit points, branch points and corners between `base` and `next`, `distance` ahead of it, in their order.
    /// `None` if contact changes in a jump: `next` is on another path.
    pub(super) fn events(&mut self, base: &Point, next: &Point, distance: f64, tol: f64) -> Option<Vec<Event>> {
        let end = |point: &Point, distance: f64| End { distance, value: None, point: point.clone() };
        let (mut from, to) = (end(base, 0.0), end(next, distance));
        let mut events = Vec::new();
        for _ in 0..MAX_ROUNDS {
            if from.point.num_contacts == to.point.num_contacts {
                break;
            }
            let [before, after] = self.corner(base, [from.clone(), to.clone()], tol);
            if self.apart(&before.point, &after.point) > JUMP[0] * distance + JUMP[1] * tol {
                return None;
            }
            self.smooth_events(base, [from, before.clone()], tol, &mut events);
            events.push(Event { kind: PointKind::Corner, point: before.point, distance: before.distance });
            from = after;
        }
        self.smooth_events(base, [from, to], tol, &mut events);
        Some(events)
    }

    /// Distance between two states that are nearly the same.
    fn apart(&self, x: &Point, y: &Point) -> f64 {
        let nodes = x.state.positions().iter().zip(y.state.positions()).map(|(a, b)| b - a);
        let field = nodes.flat_map(|d| [d.x, d.y, d.z, 0.0, 0.0, 0.0]).collect();
        let motion = PathMotion { field, parameter: y.value - x.value };
        self.dot(&motion, &motion).sqrt()
    }

    /// The last point with as many contacts as at the first end and the first one with another number, by bisection.
    /// Each is sought from the nearest known to lie before the corner, which leaves Newton the least to find out about
    /// contact.
    fn corner(&mut self, base: &Point, [mut low, mut high]: [End; 2], tol: f64) -> [End; 2] {
        while high.distance - low.distance > tol {
            let distance = 0.5 * (low.distance + high.distance);
            let Ok(Some(point)) = self.beside(base, &low, distance) else { break };
            let end = End { distance, value: None, point };
            let before = end.point.num_contacts == low.point.num_contacts;
            *(if before { &mut low } else { &mut high }) = end;
        }
        [low, high]
    }

    /// Limit and branch points between two ends with no corner between them, in their order.
    fn smooth_events(&mut self, base: &Point, [first, last]: [End; 2], tol: f64, events: &mut Vec<Event>) {
        let distance = last.distance - first.distance;
        if distance <= tol {
            return;
        }
        let inertia_tells = self.solver.engine.is_conservative();
        if first.point.tangent.parameter * last.point.tangent.parameter >= 0.0 {
            if inertia_tells {
                self.crossings(base, [first, last], tol, events);
            }
            return;
        }
        let net = first.point.num_unstable.abs_diff(last.point.num_unstable);
        let Found { before, best: found, after, .. } = self.root(base, Test::Slope, [first.clone(), last.clone()], tol);
        let at = found.distance;
        let mut here = Vec::new();
        if inertia_tells {
            self.crossings(base, [first, before], tol, &mut here);
            self.crossings(base, [after, last], tol, &mut here);
            // where the eigenvalue only touches zero rounding makes it cross there and back
            let near = (SAME_EVENT * distance).max(100.0 * tol);
            here.retain(|event| (event.distance - at).abs() > near);
        }
        let elsewhere: usize = here.iter().map(Event::multiplicity).sum();
        // the path turns: at a limit point one eigenvalue passes zero; if none does, other paths cross there
        let passes = (net + elsewhere) % 2 == 1 || !inertia_tells;
        let kind = if passes { PointKind::Limit } else { PointKind::Branch { multiplicity: 0 } };
        here.push(Event { kind, point: found.point, distance: at });
        here.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        events.append(&mut here);
    }

    /// Where the parameter passes its target between `base` and the point `distance` ahead.
    pub(super) fn target_point(&mut self, base: &Point, next: &Point, distance: f64, tol: f64) -> (Point, f64) {
        let target = self.parameter.target;
        let first = End { distance: 0.0, value: Some(base.value - target), point: base.clone() };
        let last = End { distance, value: Some(next.value - target), point: next.clone() };
        let found = self.root(base, Test::Target(target), [first, last], tol).best;
        (found.point, found.distance)
    }

    /// Branch points: changes of the number of unstable directions.
    fn crossings(&mut self, base: &Point, [mut from, to]: [End; 2], tol: f64, events: &mut Vec<Event>) {
        for _ in 0..MAX_ROUNDS {
            if from.point.num_unstable == to.point.num_unstable {
                return;
            }
            from.value = None;
            let found = self.root(base, Test::Critical, [from, to.clone()], tol);
            let kind = PointKind::Branch { multiplicity: found.counts[0].abs_diff(found.counts[1]) };
            let End { distance, mut point, .. } = found.best;
            // at the point itself rounding decides over the tangent's part along the critical direction
            point.tangent = found.before.point.tangent;
            events.push(Event { kind, point, distance });
            from = found.after;
            from.point.num_unstable = found.counts[1];
        }
    }

    /// The tested function's zero between two ends: regula falsi with the Illinois rule, bisection where the function
    /// is not yet known. Each trial is sought from the nearer end: at branch points the matrix is singular, and Newton
    /// multiplies what its start is off by. A trial that fails is enclosed from both sides, as far as others converge.
    fn root(&mut self, base: &Point, test: Test, ends: [End; 2], tol: f64) -> Found {
        let mut bracket = Bracket::new(test, ends);
        let [low, high] = &bracket.ends;
        let mut best = if low.distance > 0.0 { low.clone() } else { high.clone() };
        let (mut last, mut misses) = (best.distance, 0);
        for _ in 0..HALVINGS {
            let distance = bracket.next();
            let found = self.beside(base, bracket.nearest(distance), distance).unwrap_or(None).map(|point| {
                let value = match test {
                    Test::Slope => point.tangent.parameter,
                    Test::Target(target) => point.value - target,
                    Test::Critical => self.critical_eigenvalue(),
                };
                End { distance, value: Some(value), point }
            });
            let Some(end) = found.filter(|end| bracket.admits(end)) else {
                bracket.missing = Some(distance);
                misses += 1;
                if misses > MAX_ROUNDS {
                    break;
                }
                continue;
            };
            bracket.narrow(&end, 10.0 * self.eigenvalue_noise);
            let size = |end: &End| end.value.map_or(f64::INFINITY, f64::abs);
            if misses == 0 || size(&end) < size(&best) {
                best = end;
            }
            if (distance - last).abs() <= tol || bracket.width() <= tol {
                break;
            }
            last = distance;
        }
        if misses > MAX_ROUNDS && test == Test::Critical {
            best = self.between(base, &bracket);
        }
        let Bracket { ends: [before, after], counts, .. } = bracket;
        Found { before, best, after, counts }
    }

    /// The zero by the values at both ends, its state along the tangent at the nearer one.
    fn between(&self, base: &Point, bracket: &Bracket) -> End {
        let [low, high] = &bracket.ends;
        let part = low.value.zip(high.value).map_or(0.5, |(a, b)| a / (a - b));
        let distance = low.distance + part * bracket.width();
        let from = bracket.nearest(distance);
        let along = (distance - from.distance) / self.dot(&from.point.tangent, &base.tangent);
        End { distance, value: Some(0.0), point: self.moved(&from.point, &from.point.tangent.scaled(along)) }
    }
}

/// The interval that contains a zero.
struct Bracket {
    test: Test,
    ends: [End; 2],
    /// The function at the ends, halved by the Illinois rule.
    weights: [Option<f64>; 2],
    /// Numbers of unstable directions on either side of the zero.
    counts: [usize; 2],
    /// The end that was moved last.
    last_side: Option<usize>,
    /// The critical eigenvalue has been seen to pass zero.
    seen: bool,
    /// Where the last trial that failed did not converge.
    missing: Option<f64>,
}

impl Bracket {
    fn new(test: Test, mut ends: [End; 2]) -> Self {
        if matches!(test, Test::Slope) {
            ends.iter_mut().for_each(|end| end.value = Some(end.point.tangent.parameter));
        }
        let counts = [0, 1].map(|side| ends[side].point.num_unstable);
        let weights = [0, 1].map(|side| ends[side].value);
        Self { test, ends, weights, counts, last_side: None, seen: false, missing: None }
    }

    fn width(&self) -> f64 {
        self.ends[1].distance - self.ends[0].distance
    }

    /// The end nearer to a trial.
    fn nearest(&self, distance: f64) -> &End {
        let [low, high] = &self.ends;
        if distance - low.distance <= high.distance - distance { low } else { high }
    }

    /// Whether the tested function has opposite signs at the ends.
    fn changes_sign(&self) -> bool {
        self.ends[0].value.zip(self.ends[1].value).is_some_and(|(a, b)| a * b < 0.0)
    }

    /// Whether a trial lies on this path: near a branch point Newton may find the other, and the critical eigenvalue
    /// jumps out of the interval between those of the ends.
    fn admits(&self, trial: &End) -> bool {
        let [low, high] = &self.ends;
        match (self.test, low.value, high.value, trial.value) {
            (Test::Critical, Some(a), Some(b), Some(value)) if a * b < 0.0 => (a.min(b)..a.max(b)).contains(&value),
            _ => true,
        }
    }

    /// Distance of the next trial; beside a place without a point half way to the farther end.
    fn next(&self) -> f64 {
        let [low, high] = &self.ends;
        if let Some(missing) = self.missing.filter(|at| (low.distance..high.distance).contains(at)) {
            let farther = if missing - low.distance > high.distance - missing { low } else { high };
            return 0.5 * (missing + farther.distance);
        }
        match self.weights.into() {
            (Some(a), Some(b)) if a * b < 0.0 => {
                low.distance + self.width() * (a / (a - b)).clamp(MARGIN, 1.0 - MARGIN)
            }
            _ => 0.5 * (low.distance + high.distance),
        }
    }

    /// Takes a trial for the end on its side of the zero; eigenvalues below `noise` have no sign.
    fn narrow(&mut self, trial: &End, noise: f64) {
        // inertia counts neutral motions as stable and is late by that much: once the eigenvalue itself is seen to
        // pass, its sign decides
        let clear = |end: &End| end.value.is_some_and(|v| v.abs() > noise);
        let passes = self.ends.iter().all(clear) && self.changes_sign();
        let [low, _] = &self.ends;
        let is_low = match self.test {
            Test::Critical if !(self.seen || passes) => trial.point.num_unstable == low.point.num_unstable,
            _ => low.value.zip(trial.value).is_some_and(|(low, value)| low * value > 0.0),
        };
        self.seen |= passes;
        let side = usize::from(!is_low);
        self.ends[side] = trial.clone();
        self.weights[side] = trial.value;
        if !self.seen {
            self.counts[side] = trial.point.num_unstable;
        }
        if self.last_side == Some(side) {
            let other = &mut self.weights[1 - side];
            *other = other.map(|v| 0.5 * v);
        }
        self.last_side = Some(side);
    }
}
