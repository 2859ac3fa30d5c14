//! From a point of a path to the next: tangent, bordered mixed-integration-point Newton, critical eigenvalue.

use crate::error::SolveError;
use crate::rod::element::Stress;
use crate::scene::ContactLaw;
use crate::solve::load_step::enforce_contact::MAX_TANGENT_ROUNDS;
use crate::solve::load_step::multipliers::SecantSteps;
use crate::solve::load_step::solver::Solver;
use crate::solve::measures::{BALANCED, MAX_ITERATIONS};
use crate::solve::path::continuation::contacts::LabelledContacts;
use crate::solve::path::continuation::parameter::Parameter;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::state::State;
use crate::solve::search::newton::{increment_size, relative_residual};
use crate::solve::search::workspace::NEUTRAL_SHIFT;

/// Largest ratio of two residuals in a row of corrections that converge.
const CONTRACTION: f64 = 0.4;
/// Corrections in a row without gain after which there will be none, because the first may be chance.
const STALLS: usize = 2;
/// Corrections in a row of which a part was taken, after which there will be no whole one, because the first may be
/// chance.
const MAX_CUTS: usize = 3;

/// A motion of all unknowns and of the parameter.
#[derive(Debug, Clone)]
pub(super) struct PathMotion {
    /// Six per node.
    pub(super) field: Vec<f64>,
    pub(super) parameter: f64,
}

impl PathMotion {
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { field: self.field.iter().map(|x| x * factor).collect(), parameter: self.parameter * factor }
    }

    pub(super) fn subtract(&mut self, other: &Self, amount: f64) {
        self.field.iter_mut().zip(&other.field).for_each(|(x, o)| *x -= amount * o);
        self.parameter -= amount * other.parameter;
    }
}

/// A point of the path.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub(super) state: State,
    /// Contact offsets (augmented Lagrangian).
    pub(super) offsets: ContactField,
    /// The parameter.
    pub(super) value: f64,
    /// Unit tangent, oriented along the path.
    pub(super) tangent: PathMotion,
    pub(super) num_unstable: usize,
    /// Number of resolved contacts.
    pub(super) num_contacts: usize,
    pub(super) iterations: usize,
    pub(super) augmentations: usize,
    pub(super) penetration: f64,
    /// See [`StepReport::complementarity`](crate::solve::StepReport::complementarity).
    pub(super) complementarity: f64,
    /// Arc length of the chord from the point it was found from.
    pub(super) chord: f64,
}

/// A plane `normal` · (x − base) = distance in which the next point is sought.
pub(super) struct Hyperplane<'a> {
    pub(super) normal: &'a PathMotion,
    pub(super) distance: f64,
}

/// Solver, parameter and the metric of a path.
pub(super) struct Tracer<'a> {
    pub(super) solver: &'a mut Solver,
    pub(super) parameter: Parameter,
    /// Newton iterations so far, failed points included.
    pub(super) iterations: usize,
    /// Eigenvalues above minus this count as neutral, in units of B/L⁴.
    pub(super) eigenvalue_noise: f64,
}

/// Residuals that rounding keeps from shrinking.
struct Stall {
    /// In a row.
    count: usize,
    /// Smallest relative residual so far.
    least: f64,
}

impl Stall {
    /// Whether a path's point is at rest although increments do not shrink: near a branch point rounding makes
    /// increments along the critical direction without end; the residual is their square, and decides convergence.
    fn is_reached(&mut self, residual: f64, increment: f64) -> bool {
        let stalls = residual <= BALANCED && residual > CONTRACTION * self.least && increment <= BALANCED.sqrt();
        self.count = if stalls { self.count + 1 } else { 0 };
        self.least = self.least.min(residual);
        self.count >= STALLS
    }
}

impl Tracer<'_> {
    /// Inner product of the arc length: ds² = mean |δr|²/L² + mean |θ|² over the nodes + (δparameter/range)².
    pub(super) fn dot(&self, a: &PathMotion, b: &PathMotion) -> f64 {
        let engine = &self.solver.engine;
        let weight = 1.0 / engine.num_nodes() as f64;
        let weights = [weight / engine.scales.length.powi(2), weight];
        let field = |(i, (x, y)): (usize, (&f64, &f64))| weights[usize::from(i % 6 >= 3)] * x * y;
        let unknowns: f64 = a.field.iter().zip(&b.field).enumerate().map(field).sum();
        unknowns + a.parameter * b.parameter / self.parameter.range().powi(2)
    }

    fn normalise(&self, mut motion: PathMotion) -> Option<PathMotion> {
        let norm = self.dot(&motion, &motion).sqrt();
        motion = motion.scaled(1.0 / norm);
        motion.field.iter().all(|x| x.is_finite()).then_some(motion).filter(|m| m.parameter.is_finite())
    }

    /// The first point: the solver's present state brought to equilibrium at its parameter.
    pub(super) fn start(&mut self, value: f64) -> Result<Option<Point>, SolveError> {
        let here = self.bare(value);
        let still = PathMotion { field: vec![0.0; 6 * self.solver.engine.num_nodes()], parameter: 0.0 };
        let hold = PathMotion { field: still.field.clone(), parameter: 1.0 };
        self.correct(&here, &still, &Hyperplane { normal: &hold, distance: 0.0 })
    }

    /// A point near `point` at the given value of the parameter.
    pub(super) fn at_value(&mut self, point: &Point, value: f64) -> Result<Option<Point>, SolveError> {
        let still = PathMotion { field: vec![0.0; point.tangent.field.len()], parameter: 0.0 };
        let hold = PathMotion { field: still.field.clone(), parameter: self.parameter.range().powi(2) };
        let plane = Hyperplane { normal: &hold, distance: value - point.value };
        let found = self.correct(point, &still, &plane)?;
        Ok(found.map(|mut found| {
            // exactly there, not but for the last rounding
            found.value = value;
            if self.dot(&found.tangent, &point.tangent) < 0.0 {
                found.tangent = found.tangent.scaled(-1.0);
            }
            found
        }))
    }

    /// The solver's present state as a point without a tangent.
    pub(super) fn bare(&self, value: f64) -> Point {
        let engine = &self.solver.engine;
        Point {
            state: engine.state().clone(),
            offsets: engine.contact.offsets.clone(),
            value,
            tangent: PathMotion { field: Vec::new(), parameter: 0.0 },
            num_unstable: 0,
            num_contacts: 0,
            iterations: 0,
            augmentations: 0,
            penetration: 0.0,
            complementarity: 0.0,
            chord: 0.0,
        }
    }

    /// Puts the solver into a point.
    pub(super) fn enter(&mut self, point: &Point) -> Result<(), SolveError> {
        let solver = &mut *self.solver;
        solver.engine.take_state(point.state.clone());
        solver.engine.take_tangents();
        solver.engine.contact.offsets.clone_from(&point.offsets);
        solver.workspace.refresh(&mut solver.engine, &point.state)
    }

    /// The point of the path in a plane, from `base` with `first` as the first step; `None` if Newton does not
    /// converge. The tangent is oriented along the plane's normal.
    pub(super) fn correct(
        &mut self,
        base: &Point,
        first: &PathMotion,
        plane: &Hyperplane,
    ) -> Result<Option<Point>, SolveError> {
        self.enter(base)?;
        let mut point = Point { iterations: 0, augmentations: 0, penetration: 0.0, ..base.clone() };
        let mut moved = PathMotion { field: vec![0.0; first.field.len()], parameter: 0.0 };
        if !self.newton(&mut point, &mut moved, first, plane)? {
            return Ok(None);
        }
        if !self.enforce_gaps(&mut point, &mut moved, plane)? {
            return Ok(None);
        }
        point.chord = self.dot(&moved, &moved).sqrt();
        self.analyse(point, plane.normal)
    }

    /// Bordered Newton: with Δ1 = −K⁻¹g and Δ2 = −K⁻¹c, c the gradient's rate with the parameter, the step Δ1 + δ Δ2
    /// ends in the plane. Two solves on one symmetric factorisation; K is singular at the points sought only where the
    /// path crosses another.
    fn newton(
        &mut self,
        point: &mut Point,
        moved: &mut PathMotion,
        first: &PathMotion,
        plane: &Hyperplane,
    ) -> Result<bool, SolveError> {
        let tol = self.solver.options.newton.tol_increment;
        let mut step = first.clone();
        let (mut cut_in_a_row, mut stall) = (0, Stall { count: 0, least: f64::INFINITY });
        for iteration in 0..=MAX_ITERATIONS {
            let size =
                increment_size(&self.solver.engine, &step.field).max(step.parameter.abs() / self.parameter.range());
            if !size.is_finite() {
                return Ok(false);
            }
            let fraction = self.solver.engine.step_fraction(&point.state, &step.field)?;
            let taken = if fraction < 1.0 { step.scaled(fraction) } else { step };
            let stress = self.take(point, moved, &taken);
            cut_in_a_row = if fraction < 1.0 { cut_in_a_row + 1 } else { 0 };
            if iteration > 0 {
                // a step has been taken under the offsets there are now
                self.solver.forget_pressures();
            }
            let solver = &mut *self.solver;
            solver.engine.take_state(point.state.clone());
            solver.workspace.refresh(&mut solver.engine, &point.state)?;
            if iteration > 0 && fraction == 1.0 && size <= tol {
                return Ok(true);
            }
            if cut_in_a_row >= MAX_CUTS || iteration == MAX_ITERATIONS {
                return Ok(false);
            }
            self.iterations += 1;
            point.iterations += 1;
            solver.workspace.timings.node_iterations += solver.engine.num_nodes();
            let residual = solver.workspace.linearise(&solver.engine, &point.state, &stress, &self.parameter.drive());
            if stall.is_reached(relative_residual(&solver.engine, &residual), size) {
                return Ok(true);
            }
            if solver.workspace.factorise(&solver.engine, 0.0).is_none() {
                return Ok(false);
            }
            let along = self.response_to_parameter(&point.state, &stress);
            step = self.bordered_step(&along, &residual, moved, plane);
        }
        Ok(false)
    }

    /// Takes a step, and gives the stresses that it predicted.
    fn take(&self, point: &mut Point, moved: &mut PathMotion, step: &PathMotion) -> Vec<[Stress; 3]> {
        let engine = &self.solver.engine;
        let stress = self.parameter.predicted_stress(engine, &point.state, &step.field, step.parameter);
        point.state = engine.retract(&point.state, &step.field, 1.0);
        self.parameter.advance(&mut point.state, step.parameter);
        point.value += step.parameter;
        moved.subtract(step, -1.0);
        stress
    }

    /// The step to the plane; `along` is the motion per unit of the parameter.
    fn bordered_step(
        &mut self,
        along: &PathMotion,
        residual: &Residual,
        moved: &PathMotion,
        plane: &Hyperplane,
    ) -> PathMotion {
        let solver = &mut *self.solver;
        let force: Vec<f64> = residual.gradient.iter().map(|g| -g).collect();
        let mut step = PathMotion { field: solver.workspace.respond(&solver.engine, &force), parameter: 0.0 };
        let missing = plane.distance - self.dot(plane.normal, moved) - self.dot(plane.normal, &step);
        let part = missing / self.dot(plane.normal, along);
        step.subtract(along, -part);
        step
    }

    /// Motion per unit of the parameter by the last linearisation and factorisation: −K⁻¹c, supports moved along.
    pub(super) fn response_to_parameter(&mut self, state: &State, stress: &[[Stress; 3]]) -> PathMotion {
        let solver = &mut *self.solver;
        let driven = &solver.workspace.tangent.drive;
        let rate = self.parameter.rate(&solver.engine, state, stress, driven);
        let force: Vec<f64> = rate.iter().map(|c| -c).collect();
        let mut field = solver.workspace.respond(&solver.engine, &force);
        self.parameter.drive().add_to(&mut field);
        PathMotion { field, parameter: 1.0 }
    }

    /// Raises the offsets of an augmented Lagrangian until gaps are met, staying in the plane.
    fn enforce_gaps(
        &mut self,
        point: &mut Point,
        moved: &mut PathMotion,
        plane: &Hyperplane,
    ) -> Result<bool, SolveError> {
        if self.solver.engine.contact.is_empty() {
            return Ok(true);
        }
        let tol = match self.solver.engine.model.contact.law {
            ContactLaw::AugmentedLagrangian { tol_penetration, .. } => tol_penetration,
            _ => f64::INFINITY,
        };
        let still = PathMotion { field: vec![0.0; moved.field.len()], parameter: 0.0 };
        let mut secant_steps = SecantSteps::new(tol);
        let mut num_followed = 0;
        loop {
            if num_followed < MAX_TANGENT_ROUNDS && self.solver.engine.follow_tangents() {
                num_followed += 1;
                if !self.newton(point, moved, &still, plane)? {
                    return Ok(false);
                }
                continue;
            }
            let outstanding = self.solver.outstanding(&mut secant_steps);
            point.penetration = outstanding.penetration;
            point.complementarity = outstanding.complementarity.unwrap_or(point.complementarity);
            let Some(gaps) = outstanding.gaps else { break };
            if point.augmentations >= self.solver.options.max_augmentations {
                return Ok(false);
            }
            point.augmentations += 1;
            self.solver.augment(&gaps, &mut secant_steps);
            if !self.newton(point, moved, &still, plane)? {
                return Ok(false);
            }
        }
        point.offsets = self.solver.engine.contact.offsets.clone();
        Ok(true)
    }

    /// Tangent and inertia at a point in which the solver stands; `None` where the tangent has no size.
    pub(super) fn analyse(&mut self, mut point: Point, along: &PathMotion) -> Result<Option<Point>, SolveError> {
        point.num_unstable = self.linearise_there(&point.state)?;
        point.num_contacts = LabelledContacts::of(self.solver).count();
        let stress = self.solver.engine.actual_stress(&point.state);
        let response = self.response_to_parameter(&point.state, &stress);
        let Some(tangent) = self.normalise(response) else { return Ok(None) };
        point.tangent = if self.dot(&tangent, along) < 0.0 { tangent.scaled(-1.0) } else { tangent };
        Ok(Some(point))
    }

    /// Factorises the true tangent at a state the solver stands in; its number of negative eigenvalues.
    pub(super) fn linearise_there(&mut self, state: &State) -> Result<usize, SolveError> {
        let solver = &mut *self.solver;
        let stress = solver.engine.actual_stress(state);
        solver.workspace.linearise(&solver.engine, state, &stress, &self.parameter.drive());
        self.eigenvalue_noise = solver.workspace.rounding_of_eigenvalues(&solver.engine).max(NEUTRAL_SHIFT);
        let shift = self.eigenvalue_noise;
        solver.workspace.factorise(&solver.engine, shift).ok_or(SolveError::Factorisation { iteration: 0, shift })
    }

    /// The eigenvalue of the tangent nearest to zero, in units of B/L⁴, at the point analysed last; the workspace keeps
    /// its vector.
    pub(super) fn critical_eigenvalue(&mut self) -> f64 {
        let solver = &mut *self.solver;
        solver.workspace.lowest_above(&solver.engine, MAX_ITERATIONS) - self.eigenvalue_noise
    }

    /// Unit critical direction at a branch point in which the solver stands, normal to the path through it.
    pub(super) fn branching_direction(&mut self, value: f64) -> Result<Option<PathMotion>, SolveError> {
        let bare = self.bare(value);
        self.enter(&bare)?;
        self.linearise_there(&bare.state)?;
        self.solver.workspace.softest.clear();
        for _ in 0..5 {
            self.critical_eigenvalue();
        }
        let solver = &mut *self.solver;
        // one more inverse iteration, which takes the neutral motions out
        let force: Vec<f64> = solver.workspace.softest.iter().zip(&solver.engine.metric).map(|(x, m)| x * m).collect();
        let mut critical = PathMotion { field: solver.workspace.respond(&solver.engine, &force), parameter: 0.0 };
        // the path's own direction: at the branch point rounding decides over its critical part, which is taken out
        let stress = self.solver.engine.actual_stress(&bare.state);
        let mut along = self.response_to_parameter(&bare.state, &stress);
        let part = self.dot(&along, &critical) / self.dot(&critical, &critical);
        along.subtract(&critical, part);
        if let Some(along) = self.normalise(along) {
            let part = self.dot(&critical, &along);
            critical.subtract(&along, part);
        }
        Ok(self.normalise(critical))
    }
}
