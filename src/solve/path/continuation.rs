//! Paths of equilibria: through limit points, past branch points, onto branches.
//!
//! Load stepping ([`path`](super::run)) prescribes the ramp and asks for stable states: it jumps where a path turns
//! back. Here the ramp's parameter λ is an unknown like the others, and the step is prescribed along the path
//! (pseudo-arc-length continuation, Riks 1972, Keller 1977): from a point with unit tangent t the next one lies in the
//! plane t·(x − x₀) = σ. Newton solves g(x, λ) = 0 with the plane's equation by two solves on the symmetric
//! factorisation of K (block elimination), with mixed-integration-point stresses and the passage bound as everywhere.
//!
//! At every point the inertia of K and the sign of dλ/ds are compared with those of the point before: where dλ/ds
//! changes sign and one eigenvalue passes zero, λ has a *limit point*; where eigenvalues pass zero and λ goes on, or
//! where λ turns and none passes, other paths cross: a *branch point*. Both are located by regula falsi, on dλ/ds and
//! on the critical eigenvalue. A branch is entered along the critical eigenvector, on either side, without noise: the
//! first point lies in the plane normal to it, so that it is found whether λ rises (supercritical) or falls
//! (subcritical).

mod contacts;
mod corner;
mod corrector;
mod locate;
mod parameter;

use std::ops::ControlFlow;

use crate::error::{InputError, SolveError};
use crate::scene::{Ramp, Stage};
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::StepReport;
use crate::solve::measures::ARC;
use crate::solve::path::continuation::corner::Corner;
use crate::solve::path::continuation::corrector::{Hyperplane, Point, Tracer};
use crate::solve::path::continuation::locate::Event;
use crate::solve::path::continuation::parameter::Parameter;
use crate::solve::path::run::Progress;
use crate::solve::problem::engine::Engine;
use crate::solve::search::timing::Instant;

/// Shortest step along a path, over the requested one, because what a hundredth of it misses is noise.
const SHORT: f64 = 0.01;
/// Least turn of a path from point to point, rad, that limits the next step.
const LEAST_TURN: f64 = 1e-3;

/// Newton iterations per point that the step size aims at.
const AIM: f64 = 5.0;
/// Lengths of such a step within which the corner is sought.
const CORNER_REACH: f64 = 4.0;
/// Longest chord of a step in units of its length along the tangent, because beyond it Newton has gone to another path.
const MAX_CHORD: f64 = 1.25;

/// How a path is begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Along the path through the present state, towards the ramp's target first.
    Towards,
    /// Along the same path, away from the target first.
    Away,
    /// At a branch point: onto the branch that crosses here, along the critical direction or against it. Where several
    /// directions are critical at once by symmetry (a ring, a round column) one of them is taken, always the same.
    Branch {
        /// Along the critical direction.
        forwards: bool,
    },
}

/// Choices of [`Solver::follow`]. Arc lengths: ds² = mean |δr|²/L² + mean |θ|² over the nodes + (δλ/range)², range the
/// ramp's way from the present value to its target.
#[derive(Debug, Clone, PartialEq)]
pub struct FollowOptions {
    /// Where to go first.
    pub start: Start,
    /// First step, and the first deflection on a branch. Legal: > 0.
    pub step: f64,
    /// Steps shorter than this end the path. Legal: > 0.
    pub min_step: f64,
    /// Longest step. Legal: ≥ `step`.
    pub max_step: f64,
    /// Points after which the path ends, located ones not counted. Legal: ≥ 1.
    pub max_points: usize,
    /// Arc length to which limit and branch points are located; the parameter at a limit point is then off by its
    /// square. Raising it saves a few Newton searches per point. Legal: > 0.
    pub tol_location: f64,
}

impl Default for FollowOptions {
    fn default() -> Self {
        Self { start: Start::Towards, step: 0.05, min_step: 1e-6, max_step: 0.2, max_points: 500, tol_location: 1e-7 }
    }
}

impl FollowOptions {
    fn check(&self) -> Result<(), InputError> {
        InputError::positive("follow.step", self.step)?;
        InputError::positive("follow.min_step", self.min_step)?;
        InputError::check("follow.max_step", self.max_step, self.max_step >= self.step, "at least step")?;
        InputError::positive("follow.tol_location", self.tol_location)?;
        if self.max_points == 0 {
            return Err(InputError::Count { field: "follow.max_points".into(), value: 0, allowed: "at least 1" });
        }
        Ok(())
    }
}

/// Kind of a point of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointKind {
    /// Where the path begins.
    Start,
    /// Any other.
    Regular,
    /// The parameter has a maximum or minimum along the path.
    Limit,
    /// Other paths cross.
    Branch {
        /// Eigenvalues that pass zero at once; 0 where one touches zero and turns back, as at the root of a branch when
        /// it is run through.
        multiplicity: usize,
    },
    /// The number of contacts changes: one begins or ends, splits in two or joins another. The path has a corner there,
    /// at which the parameter may turn back and the number of unstable directions change. The state is that just
    /// before, or extrapolated from there; the number is that before.
    ///
    /// A point splits where its zone parts in two, which under a law κ is some layers (B/κ)^¼ later than where it
    /// opens. Under an augmented Lagrangian points count as one contact that its offsets cannot tell apart, nearer than
    /// about two layers or an element.
    Corner,
    /// The parameter has come to the ramp's target; the path ends.
    Target,
}

/// A point of a path, as the observer sees it.
#[derive(Debug)]
pub struct PathPoint<'a> {
    /// The state, for `observe::observe` and the like; `step` counts the points, `fraction` is the parameter's way from
    /// start to target (below 0 and beyond 1 where the path goes there).
    pub progress: Progress<'a>,
    /// Kind of the point.
    pub kind: PointKind,
    /// The parameter in the ramp's own unit; displacements: along the straight line to the target \[L\].
    pub value: f64,
    /// Arc length from the start of the path.
    pub arc: f64,
    /// dλ/ds there, in units of the parameter.
    pub slope: f64,
}

impl PathPoint<'_> {
    /// The engine in this state.
    pub fn engine(&self) -> &Engine {
        self.progress.engine
    }

    /// Unstable directions. Of limit and branch points themselves it is the number on either side.
    pub fn num_unstable(&self) -> usize {
        self.progress.report.num_unstable
    }
}

/// How a path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathEnd {
    /// The parameter came to the ramp's target.
    Target,
    /// The observer asked to stop.
    Stopped,
    /// As many points as were allowed.
    MaxPoints,
    /// No step longer than the shortest allowed converged.
    StepTooSmall,
    /// The start is no equilibrium and none was found near it at the same parameter; at the start of a branch: no
    /// branch was found.
    NoStart,
    /// Numbers broke down at every step size.
    BrokeDown,
}

/// Result of following a path; the solver keeps the last point.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct FollowReport {
    /// How it ended.
    pub end: PathEnd,
    /// The parameter at the last point, in the ramp's own unit.
    pub value: f64,
    /// Points, located ones not counted.
    pub num_points: usize,
    /// Newton iterations in all, failed steps and locations included.
    pub iterations: usize,
    /// The last breakdown, if any.
    pub error: Option<SolveError>,
}

/// The observer and its data.
struct Reporter<'a> {
    observer: &'a mut dyn FnMut(&PathPoint) -> ControlFlow<()>,
    points: usize,
    started: Instant,
}

impl Reporter<'_> {
    fn tell(&mut self, tracer: &mut Tracer, point: &Point, kind: PointKind, arc: f64) -> Result<bool, SolveError> {
        tracer.enter(point)?;
        let report = StepReport {
            iterations: point.iterations,
            augmentations: point.augmentations,
            num_unstable: point.num_unstable,
            penetration: point.penetration,
            complementarity: point.complementarity,
            stiffness_reduction: tracer.solver.engine.stiffness_reduction(),
            ..StepReport::settled()
        };
        let way = tracer.parameter.target - tracer.parameter.start;
        let progress = Progress {
            given: None,
            engine: &tracer.solver.engine,
            stage: 0,
            step: self.points,
            fraction: (point.value - tracer.parameter.start) / way,
            report: &report,
            seconds: self.started.elapsed().as_secs_f64(),
        };
        let seen = PathPoint { progress, kind, value: point.value, arc, slope: point.tangent.parameter };
        let go_on = (self.observer)(&seen).is_continue();
        self.started = Instant::now();
        Ok(go_on)
    }

    /// Reports the events of a step and its end; whether to go on. `arc` is the arc length up to its start, then to its
    /// end.
    fn tell_stride(
        &mut self,
        tracer: &mut Tracer,
        stride: &Stride,
        arc: &mut f64,
        report: &mut FollowReport,
    ) -> Result<bool, SolveError> {
        for event in &stride.events {
            report.value = event.point.value;
            if !self.tell(tracer, &event.point, event.kind, *arc + event.distance)? {
                return Ok(false);
            }
        }
        *arc += stride.distance;
        self.count(&stride.next, report);
        let kind = if stride.arrives { PointKind::Target } else { PointKind::Regular };
        self.tell(tracer, &stride.next, kind, *arc)
    }

    /// Reports a corner and the first point beyond it; whether to go on.
    fn tell_corner(
        &mut self,
        tracer: &mut Tracer,
        found: &Corner,
        arc: &mut f64,
        report: &mut FollowReport,
    ) -> Result<bool, SolveError> {
        report.value = found.corner.value;
        if !self.tell(tracer, &found.corner, PointKind::Corner, *arc + found.before)? {
            return Ok(false);
        }
        *arc += found.before + found.after;
        self.count(&found.next, report);
        self.tell(tracer, &found.next, PointKind::Regular, *arc)
    }

    fn count(&mut self, next: &Point, report: &mut FollowReport) {
        self.points += 1;
        (report.num_points, report.value) = (self.points, next.value);
    }
}

impl Solver {
    /// Follows the path of equilibria through the present state with one ramp as its parameter: past limit points,
    /// stable or not. Ends where the parameter comes to the ramp's target, or as the options or the observer say. The
    /// observer sees the start, every point, and between them every limit and branch point located; it may stop there
    /// to switch branches by a second call.
    ///
    /// Contact is enforced at every point under the present law. Where a contact begins or ends a path has a corner, at
    /// which the parameter may turn back (a ring that first touches itself past its fold). Such corners are gone round
    /// and located, be it the first contact, the last or one of several; only where contacts come and go within one
    /// step, so that their number is the same after it, nothing is reported.
    ///
    /// Branch points are known to rounding of the tangent's eigenvalues, which grows with the stretching stiffness:
    /// about 1e-6 of the parameter at EA = 1e8 B/L² and 1e-8 at 1e5. Limit values of the parameter are not affected: it
    /// is stationary there. [`Options::leave_unstable`](crate::solve::Options) has no say here. Where loads have no
    /// potential (fixed-axis moments in space) inertia does not decide stability, and only limit points are reported.
    ///
    /// # Errors
    /// A ramp that does not fit the model or has no way to go, options out of range. What happens on the way is in the
    /// report.
    pub fn follow(
        &mut self,
        ramp: &Ramp,
        options: &FollowOptions,
        observer: &mut dyn FnMut(&PathPoint) -> ControlFlow<()>,
    ) -> Result<FollowReport, InputError> {
        options.check()?;
        self.engine.model.check_stages(&[Stage::new(vec![ramp.clone()], 1)])?;
        let parameter = Parameter::new(self, ramp)?;
        let mut tracer = Tracer { solver: self, parameter: parameter.clone(), iterations: 0, eigenvalue_noise: 0.0 };
        let mut reporter = Reporter { observer, points: 0, started: Instant::now() };
        let mut report =
            FollowReport { end: PathEnd::NoStart, value: parameter.start, num_points: 0, iterations: 0, error: None };
        match trace(&mut tracer, options, &mut reporter, &mut report) {
            Ok(end) => report.end = end,
            Err(error) => {
                report.end = PathEnd::BrokeDown;
                report.error = Some(error);
            }
        }
        report.iterations = tracer.iterations;
        parameter.record(self, report.value - parameter.start);
        Ok(report)
    }
}

/// The path itself: start, steps, events, end. On return the solver is at the last reported point.
fn trace(
    tracer: &mut Tracer,
    options: &FollowOptions,
    reporter: &mut Reporter,
    report: &mut FollowReport,
) -> Result<PathEnd, SolveError> {
    let Some((mut here, mut arc)) = begin(tracer, options, reporter, report)? else { return Ok(report.end) };
    let mut step = options.step;
    let mut last_error = None;
    while report.num_points < options.max_points {
        let stride = stride(tracer, &here, step, options.tol_location).unwrap_or_else(|error| {
            last_error = Some(error);
            None
        });
        if let Some(stride) = stride {
            let next_step = (step * stride.lengthening()).min(options.max_step);
            if !reporter.tell_stride(tracer, &stride, &mut arc, report)? {
                return Ok(PathEnd::Stopped);
            }
            if stride.arrives {
                return Ok(PathEnd::Target);
            }
            (here, step) = (stride.next, next_step);
        } else if let Some(found) = corner(tracer, &here, step, options) {
            if !reporter.tell_corner(tracer, &found, &mut arc, report)? {
                return Ok(PathEnd::Stopped);
            }
            (here, step) = (found.next, found.after);
        } else {
            step *= 0.5;
            if step < options.min_step {
                tracer.enter(&here)?;
                report.error = last_error;
                return Ok(PathEnd::StepTooSmall);
            }
        }
    }
    Ok(PathEnd::MaxPoints)
}

/// A corner within reach of a step that failed, if it has become short.
fn corner(tracer: &mut Tracer, here: &Point, step: f64, options: &FollowOptions) -> Option<Corner> {
    let short = SHORT * options.step;
    if step < short { tracer.round_corner(here, CORNER_REACH * step, short).unwrap_or(None) } else { None }
}

/// A step along the path.
struct Stride {
    next: Point,
    distance: f64,
    events: Vec<Event>,
    /// Angle between the tangents at its ends, rad.
    turned: f64,
    /// It ends where the parameter comes to its target.
    arrives: bool,
}

impl Stride {
    /// Length of the next step over that of this one.
    fn lengthening(&self) -> f64 {
        // iterations of one search; each augmentation of contact offsets asks for another
        let iterations = self.next.iterations.max(1) as f64 / (1 + self.next.augmentations) as f64;
        let ratio = (AIM / iterations).sqrt().min(0.5 * ARC / self.turned.max(LEAST_TURN));
        ratio.clamp(0.5, 2.0)
    }
}

/// The step of length `step` from `here`, or to the target if that comes first; `None` where Newton finds no point, or
/// one that is not on this path.
fn stride(tracer: &mut Tracer, here: &Point, step: f64, tol: f64) -> Result<Option<Stride>, SolveError> {
    let Some(mut next) = tracer.ahead(here, step)?.filter(|next| next.chord <= MAX_CHORD * step) else {
        return Ok(None);
    };
    let turned = tracer.dot(&here.tangent, &next.tangent).clamp(-1.0, 1.0).acos();
    if turned > ARC {
        return Ok(None);
    }
    let (mut distance, target) = (step, tracer.parameter.target);
    let arrives = (here.value - target) * (next.value - target) < 0.0 || next.value == target;
    if arrives {
        (next, distance) = tracer.target_point(here, &next, step, tol);
        if let Some(exact) = tracer.at_value(&next, target)? {
            next = exact;
        }
    }
    let events = tracer.events(here, &next, distance, tol);
    Ok(events.map(|events| Stride { next, distance, events, turned, arrives }))
}

/// The first point with its tangent: on the path, or the first one on a branch.
fn begin(
    tracer: &mut Tracer,
    options: &FollowOptions,
    reporter: &mut Reporter,
    report: &mut FollowReport,
) -> Result<Option<(Point, f64)>, SolveError> {
    let value = tracer.parameter.start;
    let Start::Branch { forwards } = options.start else {
        let snapshot = tracer.bare(value);
        let Some(mut point) = tracer.start(value)? else {
            tracer.enter(&snapshot)?;
            return Ok(None);
        };
        let towards = (tracer.parameter.target - value) * point.tangent.parameter >= 0.0;
        if towards != (options.start == Start::Towards) {
            point.tangent = point.tangent.scaled(-1.0);
        }
        let go_on = reporter.tell(tracer, &point, PointKind::Start, 0.0)?;
        report.end = PathEnd::Stopped;
        return Ok(go_on.then_some((point, 0.0)));
    };
    let crossing = tracer.bare(value);
    let Some(direction) = tracer.branching_direction(value)? else { return Ok(None) };
    let direction = if forwards { direction } else { direction.scaled(-1.0) };
    let mut size = options.step;
    while size >= options.min_step {
        let plane = Hyperplane { normal: &direction, distance: size };
        // deflections are found when the chord is about as long as requested: else Newton went elsewhere
        let found = tracer.correct(&crossing, &direction.scaled(size), &plane).unwrap_or(None);
        if let Some(point) = found.filter(|p| p.chord <= MAX_CHORD * size) {
            reporter.points = 1;
            (report.num_points, report.value) = (1, point.value);
            let go_on = reporter.tell(tracer, &point, PointKind::Regular, size)?;
            report.end = PathEnd::Stopped;
            return Ok(go_on.then_some((point, size)));
        }
        size *= 0.5;
    }
    tracer.enter(&crossing)?;
    Ok(None)
}

#[cfg(test)]
mod tests;
