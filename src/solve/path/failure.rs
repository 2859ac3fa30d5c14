//! Why a run went no further, for people: the last attempt, and where it was stuck.

use std::fmt;

use crate::contact::clearance::smallest_clearance;
use crate::error::SolveError;
use crate::solve::load_step::step_report::{Status, StepReport};
use crate::solve::measures::BALANCED;
use crate::solve::problem::bend::Bend;
use crate::solve::problem::engine::Engine;
use crate::solve::search::newton::{NewtonOptions, relative_residual};

/// Overlap over the contact radius from which a failure names it, because less is no reason to fail.
const OVERLAPS: f64 = 1e-3;

/// Curvature × contact radius of a state from which a failed step counts as ended by the rod's thickness, because the
/// tube is embedded up to 1, and rings end within 1e-3 of it.
const TIGHT: f64 = 0.95;

/// A place on a rod.
#[derive(Debug, Clone, PartialEq)]
pub struct RodPoint {
    /// Name of the rod.
    pub rod: String,
    /// Reference arc length from its start \[L\].
    pub arc: f64,
}

/// Two strands inside each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlap {
    /// Where on both strands.
    pub at: [RodPoint; 2],
    /// Depth over the smallest contact radius of the model.
    pub depth: f64,
}

/// A rod bent as tightly as it is thick.
#[derive(Debug, Clone, PartialEq)]
pub struct TightBend {
    /// Where it is bent the most.
    pub at: RodPoint,
    /// Curvature of the centreline × contact radius.
    pub tightness: f64,
}

/// The last attempt of a run that did not converge. It was given up: the run's state is the one before it (at the start
/// of a run, the attempt itself).
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Stage, 0-based; none at the start of the run, before any stage.
    pub stage: Option<usize>,
    /// Fractions of the stage between which the attempt was to lead.
    pub span: [f64; 2],
    /// Whether the stage ramps loads or pressures, which may go beyond what the rods bear.
    pub(crate) ramps_loads: bool,
    /// How the attempt ended.
    pub status: Status,
    /// The breakdown, if any.
    pub error: Option<SolveError>,
    /// Last Newton increment (over the node spacing, or rad), and the tolerance it was to meet.
    pub increment: Option<[f64; 2]>,
    /// Largest force out of balance, over the largest sum of contributions.
    pub residual: f64,
    /// Where it is.
    pub worst: Option<RodPoint>,
    /// Deepest overlap, if there is one beyond the tolerance of the contact law.
    pub overlap: Option<Overlap>,
    /// The tightest bend of the state that the attempt led on from, if curvature × contact radius is near 1 or beyond:
    /// opposite points of a bend touch at 1, all at once, and within it contact does not act.
    pub bend: Option<TightBend>,
}

impl Failure {
    /// Of the engine in the state that the attempt ended in.
    pub(crate) fn of(engine: &Engine, report: &StepReport, newton: &NewtonOptions) -> Self {
        let last = report.history.last().and_then(|search| search.last());
        let residual = engine.residual(engine.state());
        let gradient = residual.bases.without_reactions(&residual.gradient);
        let scale = |k: usize| if k < 3 { engine.scales.lever } else { 1.0 };
        let unbalanced = |node: usize| {
            let size = |k: usize| gradient[6 * node + k].abs() * scale(k);
            (0..6).filter(|&k| engine.free[node][k]).map(size).fold(0.0, f64::max)
        };
        let worst = (0..engine.num_nodes()).max_by(|&a, &b| unbalanced(a).total_cmp(&unbalanced(b)));
        let relative = relative_residual(engine, &residual);
        Self {
            stage: None,
            span: [0.0, 0.0],
            ramps_loads: false,
            status: report.status,
            error: report.error.clone(),
            increment: last.map(|iteration| [iteration.increment, newton.tol_increment]),
            residual: relative,
            worst: worst.filter(|_| relative > BALANCED).map(|node| {
                let rod = engine.rod_of(node);
                let spacing = engine.model.rods[rod].spacing();
                spot(engine, rod, (node - engine.first_node[rod]) as f64 * spacing)
            }),
            overlap: deepest_overlap(engine),
            bend: None,
        }
    }

    /// Of an attempt that led on from the state that the engine is in now.
    pub(crate) fn failing_from(self, engine: &Engine) -> Self {
        let bend = engine.tightest_bend().filter(|bend| bend.tightness >= TIGHT);
        let told = |Bend { rod, arc, tightness }| TightBend { at: spot(engine, rod, arc), tightness };
        Self { bend: bend.map(told), ..self }
    }

    /// Whether a rod's thickness is the reason: of the state that the attempt led on from, or of the last one it came
    /// to.
    pub(super) fn is_too_tight(&self) -> bool {
        self.bend.is_some() || matches!(self.error, Some(SolveError::TooTight { .. }))
    }

    fn advice(&self) -> &'static str {
        match (self.status, &self.error, &self.overlap) {
            (Status::Stopped, ..) => "",
            _ if self.is_too_tight() => "a thinner or a stiffer rod, less load or fewer turns",
            (_, _, Some(overlap)) if overlap.depth > 1.0 => {
                "strands may be inside each other beyond what contact can undo, or squeezed without a way out: check \
                 where they start (supercoil check), and that the ramps leave room for them"
            }
            (Status::Penetration, ..) => {
                "strands may have no room left; otherwise more elements, a harder contact law or a larger \
                 tol_penetration"
            }
            (Status::Unstable, ..) => {
                "no stable state was found nearby: more steps, or a small load or displacement that decides to which \
                 side"
            }
            (_, Some(SolveError::TooCoarse { .. } | SolveError::TooTwisted { .. }), _) => "more elements",
            _ if !self.ramps_loads => "more elements, smaller steps or more solver.max_iterations",
            _ => {
                "more elements, smaller steps or more solver.max_iterations; beyond a limit load there is no state \
                 nearby: ramp a displacement or rotation instead of a load or pressure"
            }
        }
    }
}

/// The deepest overlap of the state, if it exceeds the tolerance of the contact law.
fn deepest_overlap(engine: &Engine) -> Option<Overlap> {
    let side = &engine.contact;
    if !side.is_current {
        return None;
    }
    let tol = OVERLAPS * side.min_radius;
    let found = engine.install(|| smallest_clearance(&side.set, &side.exclusion, 0.0, tol))?;
    let depth = -found.upper / side.min_radius;
    let at = [(found.segment_a, found.arc_a), (found.segment_b, found.arc_b)]
        .map(|(segment, arc)| spot(engine, side.rods[side.set.curve_of(segment)], arc));
    (depth > OVERLAPS).then_some(Overlap { at, depth })
}

fn spot(engine: &Engine, rod: usize, arc: f64) -> RodPoint {
    RodPoint { rod: engine.model.rods[rod].name.clone(), arc }
}

impl fmt::Display for RodPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rod \"{}\" at arc {:.4}", self.rod, self.arc)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.stage {
            None => write!(f, "the start did not come to rest: ")?,
            Some(stage) => {
                let [from, to] = self.span.map(|x| 100.0 * x);
                write!(f, "stage {} stands at {from:.3} %; the last try, to {to:.3} %: ", stage + 1)?;
            }
        }
        match &self.error {
            Some(error) => write!(f, "{error}")?,
            None => write!(f, "{}", self.status)?,
        }
        let ran_out = self.status == Status::MaxIterations && self.error.is_none();
        if let (Some([increment, tol]), true) = (self.increment, ran_out) {
            write!(f, " (last increment {increment:.1e} of the node spacing, to be {tol:.0e})")?;
        }
        if let Some(worst) = &self.worst {
            write!(f, "; forces out of balance by {:.1e} of what there is, most on {worst}", self.residual)?;
        }
        if let Some(Overlap { at: [a, b], depth }) = &self.overlap {
            write!(f, "; deepest overlap {depth:.3} contact radii, {a} and {b}")?;
        }
        if let Some(TightBend { at, tightness }) = &self.bend {
            write!(f, "; {at} is bent to curvature × contact radius {tightness:.3}")?;
        }
        match self.advice() {
            "" => Ok(()),
            advice => write!(f, ". What may help: {advice}"),
        }
    }
}
