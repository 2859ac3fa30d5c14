//! The guarded search: Newton steps that the potential itself confirms.
//!
//! A rod is nearly inextensible and contact is nearly rigid: both confine the motion to a curved surface in the space of
//! configurations. A straight Newton step leaves that surface by second order, which the large stiffnesses turn into
//! a potential that says nothing about the step (Maratos effect). So each step Δ is first brought back: with
//! e = ε(x ⊕ Δ) − ε(x) − BΔ the strain it made beyond its linear prediction and s the forces of gaps that did the same, it is
//! corrected by −K⁻¹(BᵀC e + s) on the factorisation at hand, a few times. After that the potential is meaningful and the step
//! is accepted like any trust-region step, by comparing its decrease with the model's. Where contact opens or closes along the
//! way the corrections may not converge; the best state they passed is as good as any if it lies low enough. The trust region is
//! a radius in rotations and in sliding at contacts, held by the shift τ in K + τM: at least so large that no negative eigenvalue is
//! left, larger until the step is within the radius. Where the eigenvalue asks for a larger shift than the radius does, the
//! step is lengthened along the softest direction (the hard case of Moré & Sorensen 1983): a slope of negative curvature is left in few
//! steps instead of many that its own shift keeps short.

use crate::error::SolveError;
use crate::math::Vec3;
use crate::rod::element::Six;
use crate::solve::assembly::Residual;
use crate::solve::engine::Engine;
use crate::solve::newton::{Iteration, NewtonOptions, NewtonReport, Workspace, increment_size, relative_residual};
use crate::solve::state::{Drive, State};
use crate::solve::timing::timed;
use crate::solve::trust::{Outcome, Trust};

/// Smallest shift that is tried, in units of B/L⁴.
const FIRST_SHIFT: f64 = 10.0;
/// Largest shift that is tried.
const MAX_SHIFT: f64 = 1e30;
/// Largest change of a contact force, over the largest, in a step that is corrected by all that is out of balance after it.
const GENTLE: f64 = 0.1;
/// Correction rounds per step.
const MAX_ROUNDS: usize = 10;
/// A correction this small in energy, relative to the step, ends the rounds.
const SMALL_CORRECTION: f64 = 1e-2;
/// Each correction must be smaller than this times its predecessor (energies).
const CONTRACTION: f64 = 0.4;
/// Steps rejected in a row before the search gives up.
const MAX_REJECTIONS: usize = 30;
/// Fractions of a step tried before the shift is raised.
const SHORTER: [f64; 3] = [0.5, 0.2, 0.06];
/// Decrease of the potential, relative to the expected one, with which a fraction whose corrections did not converge is good enough.
const ENOUGH: f64 = 0.1;
/// Extent (see [`extent`]) of a response that is that of a nearly singular tangent.
const TOO_FAR: f64 = 2.0;
/// Larger shifts tried to bring a step within the radius.
const MAX_SHORTENINGS: usize = 3;
/// Factor on the shift after a step as long as the radius; a shift that turns out too small for the next costs one factorisation.
const RELAXING: f64 = 0.5;
/// Smallest fraction of a prescribed motion taken at a time.
const SHORTEST: f64 = 1e-3;
/// At rest no contact force changes by more than this in the last step, relative to the largest: where contact is lightly loaded,
/// increments far below any length of the rods still matter to it.
const TOL_CONTACT_CHANGE: f64 = 1e-6;
/// A search that only prepares the next one goes on while a step changes contact forces by more than this, relative to the largest.
const STEADY: f64 = 0.3;
/// Increments this much below the tolerance are rest where contact forces changed in the last step by no more than [`NEARLY_BALANCED`], relative, and are out of balance by no more,
/// or where contact bends nothing by more than [`UNLOADED`], rad: strands that touch without a load press by rounding alone.
const IMMOBILE: f64 = 1e-4;
const NEARLY_BALANCED: f64 = 1e-3;
const UNLOADED: f64 = 1e-6;
/// Relative residual below which shifted steps that stay tiny are taken for rest at a saddle.
const TOL_SADDLE: f64 = 1e-8;
/// Decrements that the potential cannot see and that fall by less than this in three steps are made of rounding.
const SETTLING: f64 = 0.1;
/// Relative size of changes of the potential that rounding makes.
const ROUNDING: f64 = 1e-11;

/// A step and the quadratic model along it.
struct Step {
    increment: Vec<f64>,
    /// The increment as it was solved for, neutral motions in it.
    raw: Vec<f64>,
    /// See [`extent`].
    extent: f64,
    /// g·Δ.
    slope: f64,
    /// ΔᵀKΔ.
    curvature: f64,
    /// ΔᵀMΔ.
    inertia: f64,
}

/// A step after its corrections.
#[derive(Clone)]
struct Trial {
    increment: Vec<f64>,
    state: State,
    potential: f64,
    /// Decrease that the quadratic model expects.
    expected: f64,
    fraction: f64,
    rounds: usize,
    /// Largest change of a contact force along the step over the largest contact force.
    contact_change: f64,
    /// The corrections shrank.
    settled: bool,
    /// C e of the last correction: with the linear prediction the stresses that balance the step.
    excess: Option<Vec<[Six; 3]>>,
}

impl Workspace {
    /// The guarded search. `forces`, if there are any, are the shear forces and the tension of the first linearisation.
    pub(crate) fn guarded(
        &mut self,
        engine: &mut Engine,
        drive: &Drive,
        options: &NewtonOptions,
        forces: &[[[f64; 3]; 3]],
    ) -> Result<NewtonReport, SolveError> {
        let mut report = NewtonReport { converged: false, iterations: Vec::new(), num_unstable: 0 };
        let mut remaining = if drive.nodes.is_empty() { 0.0 } else { 1.0 };
        let mut state = engine.state.clone();
        let (mut rejections, mut at_saddle) = (0, 0);
        let mut decrements = Vec::new();
        let mut trust = Trust::new();
        let mut stress = engine.actual_stress(&state);
        for (point, force) in stress.iter_mut().flatten().zip(forces.iter().flatten()) {
            point[..3].copy_from_slice(force);
        }
        self.shift = 0.0;
        while report.iterations.len() < options.max_iterations {
            self.refresh(engine, &state)?;
            let drive_now = drive.scaled(remaining);
            let residual = self.linearise(engine, &state, &stress, &drive_now);
            let mut longest = 1.0;
            let pushed = remaining > 0.0;
            loop {
                if self.must_stop(options) {
                    return Ok(report);
                }
                let at = report.iterations.len();
                let within = if pushed { f64::INFINITY } else { trust.radius };
                let step = self.step_within(engine, &residual, &drive_now, within, (at, options.tol_increment))?;
                let size = increment_size(engine, &step.increment);
                let mut trial = self.trial(engine, &state, &residual, &step, longest, pushed)?;
                // shorter along the same direction first: it costs no factorisation
                for shorter in if pushed { [].as_slice() } else { &SHORTER } {
                    let falls =
                        residual.potential.total() - trial.potential >= ENOUGH * trial.expected - noise(&residual);
                    if trial.settled || falls || size <= options.tol_increment {
                        break;
                    }
                    trial = self.trial(engine, &state, &residual, &step, *shorter, pushed)?;
                }
                let noise = noise(&residual);
                let gain = residual.potential.total() - trial.potential;
                let driven = remaining > 0.0 || !engine.is_conservative();
                // below the tolerance rounding decides over decrease and corrections
                let tiny = size <= options.tol_increment && trial.potential.is_finite();
                let indefinite = self.shift > 0.0;
                let unbalanced = relative_residual(engine, &residual);
                let nearly = trial.contact_change <= NEARLY_BALANCED && unbalanced <= NEARLY_BALANCED;
                let light = size <= IMMOBILE * options.tol_increment
                    && (nearly || contact_bends(engine, &residual) <= UNLOADED);
                let balances = light || trial.contact_change <= TOL_CONTACT_CHANGE.max(10.0 * options.tol_increment);
                // where only the next search is prepared, relative motion decides, for a long rod swings far by little, once forces have found their places:
                // the end of a line of contact moves by about a layer (B/κ)^¼ an iteration, so it has less far to go under the softer law
                let steady = tiny || trial.contact_change <= STEADY;
                let still = self.rough.map_or(tiny && balances, |tol| step.extent <= tol && steady);
                let at_rest = still && self.shift == 0.0;
                let falls = gain >= 0.05 * trial.expected - noise;
                let acceptable = tiny || if driven { trial.settled } else { falls };
                let accepted = acceptable && (trial.rounds == 0 || engine.keeps_apart(&state, &trial.increment)?);
                report.iterations.push(Iteration {
                    increment: size,
                    residual: unbalanced,
                    fraction: if accepted { trial.fraction } else { 0.0 },
                    shift: self.shift,
                    potential: residual.potential.total(),
                    rounds: trial.rounds,
                });
                if accepted {
                    rejections = 0;
                    remaining *= 1.0 - trial.fraction;
                    let hardened = engine.contact.as_mut().is_some_and(|side| side.before.take().is_some());
                    let unseen = trial.expected.abs() <= 10.0 * noise;
                    trust.accept(Outcome {
                        extent: step.extent,
                        fraction: trial.fraction,
                        rounds: trial.rounds,
                        gain: (!unseen).then_some(gain / trial.expected),
                    });
                    if hardened {
                        // the first step under a new law tells how far the strands have to go; what follows is no longer
                        trust.radius = trust.radius.min(step.extent);
                    }
                    self.shift *= RELAXING * (step.extent / trust.radius).min(1.0);
                    // the geometric stiffness belongs to the stresses that the linear solve balanced, not to what rounding off the
                    // constraint surface makes of them
                    stress = engine.predicted_stress(&state, &trial.increment);
                    for (total, excess) in stress.iter_mut().zip(trial.excess.iter().flatten()) {
                        for (t, e) in total.iter_mut().flatten().zip(excess.iter().flatten()) {
                            *t += e;
                        }
                    }
                    state = trial.state;
                    engine.state = state.clone();
                    // shifted steps that stay tiny have come to a saddle: whoever asked decides whether to leave it
                    // (large shifts make any step tiny: the residual must have gone too)
                    let balanced = report.iterations.last().is_some_and(|i| i.residual <= TOL_SADDLE);
                    at_saddle = if tiny && indefinite && balanced { at_saddle + 1 } else { 0 };
                    // what keeps moving without a change of the potential or a force is rounding along motions that nothing resists
                    if trial.expected.abs() >= noise || indefinite || trial.fraction < 1.0 || remaining > 0.0 {
                        decrements.clear();
                    } else {
                        decrements.push(trial.expected.abs());
                    }
                    let idle =
                        balanced && matches!(decrements[..], [.., before, _, _, last] if last > SETTLING * before);
                    report.converged = trial.fraction == 1.0 && (at_rest || at_saddle >= 3 || idle);
                    break;
                }
                // the potential cannot resolve the decrease that is left in a full step (of one that was cut short it says nothing): this is
                // as far as rounding lets anyone go
                if self.shift == 0.0
                    && remaining == 0.0
                    && trial.expected.abs() < noise * trial.fraction * (2.0 - trial.fraction)
                {
                    report.converged = true;
                    break;
                }
                rejections += 1;
                if rejections > MAX_REJECTIONS || report.iterations.len() >= options.max_iterations {
                    return self.finish(engine, &state, report);
                }
                if remaining > 0.0 {
                    // shifts do not shorten what is prescribed
                    longest = 0.4 * trial.fraction;
                    if longest < SHORTEST {
                        return self.finish(engine, &state, report);
                    }
                    if step.extent > TOO_FAR {
                        self.shift = self.shift_for(&step, step.extent / TOO_FAR).max(4.0 * self.shift);
                    }
                } else {
                    trust.reject(step.extent);
                    self.shift = self.shift_for(&step, step.extent / trust.radius).max(4.0 * self.shift);
                }
            }
            if report.converged {
                break;
            }
        }
        self.finish(engine, &state, report)
    }

    fn finish(
        &mut self,
        engine: &mut Engine,
        state: &State,
        mut report: NewtonReport,
    ) -> Result<NewtonReport, SolveError> {
        engine.state = state.clone();
        if let Some(side) = &mut engine.contact {
            side.before = None;
        }
        self.shift = 0.0;
        self.refresh(engine, state)?;
        report.num_unstable = self.count_unstable(engine)?;
        Ok(report)
    }

    /// Factorises with the present shift, raised until no eigenvalue is negative; a raised shift is then lowered to half again as much
    /// as the lowest eigenvalue asks for, so that an unstable direction is followed at the stride of a Newton step.
    fn convexify(&mut self, engine: &Engine, iteration: usize) -> Result<(), SolveError> {
        if self.shift < FIRST_SHIFT {
            self.shift = 0.0;
        }
        if self.factorise(engine, self.shift) == Some(0) {
            return Ok(());
        }
        let lower = self.shift;
        self.shift = (4.0 * self.shift).max(FIRST_SHIFT);
        while self.factorise(engine, self.shift) != Some(0) {
            self.shift *= 8.0;
            if self.shift > MAX_SHIFT {
                return Err(SolveError::Factorisation { iteration, shift: self.shift });
            }
        }
        let estimate = (1.5 * (self.shift - self.lowest_above(engine, 4))).max(1.5 * lower);
        if estimate < 0.6 * self.shift {
            let safe = self.shift;
            self.shift = estimate.max(1e-2 * FIRST_SHIFT);
            if self.factorise(engine, self.shift) != Some(0) {
                self.shift = safe;
                self.factorise(engine, safe);
            }
        }
        Ok(())
    }

    /// The Newton step with the factorisation at hand and what the model says of it.
    fn model_step(
        &mut self,
        engine: &Engine,
        residual: &Residual,
        drive: &Drive,
        iteration: usize,
    ) -> Result<Step, SolveError> {
        let raw = self.raw_step(engine, residual);
        let slope = self.free_dot(engine, &raw, |i| residual.gradient[i]);
        let work = -slope - self.free_dot(engine, &raw, |i| self.tangent.drive[i]);
        let inertia = self.free_dot(engine, &raw, |i| engine.masses[i] * raw[i]);
        let increment = self.finished_step(raw.clone(), drive, iteration)?;
        let extent = extent(engine, residual, &increment);
        Ok(Step { increment, raw, extent, slope, curvature: work - self.shift * inertia, inertia })
    }

    /// Adds to a step that shifts keep short as much of the softest direction as takes it `farther`, if the model falls along it.
    fn add_softest(&self, engine: &Engine, residual: &Residual, step: &mut Step, farther: f64) {
        let way = &self.softest;
        if way.len() != step.raw.len() {
            return;
        }
        let product = self.multiply(engine, &self.tangent.values, way);
        let curvature = self.free_dot(engine, way, |i| product[i]);
        let inertia = self.free_dot(engine, way, |i| engine.masses[i] * way[i]);
        if curvature >= -0.2 * self.shift * inertia {
            return;
        }
        let slope = self.free_dot(engine, way, |i| residual.gradient[i]);
        let mixed = self.free_dot(engine, way, |i| engine.masses[i] * step.raw[i]);
        let cross = -slope - self.shift * mixed;
        let mut clean = way.clone();
        self.neutral.remove(&mut clean);
        let scale = farther / extent(engine, residual, &clean) * if slope + cross > 0.0 { -1.0 } else { 1.0 };
        for (s, w) in step.increment.iter_mut().zip(&clean) {
            *s += scale * w;
        }
        step.extent = extent(engine, residual, &step.increment);
        step.slope += scale * slope;
        step.curvature += 2.0 * scale * cross + scale * scale * curvature;
        step.inertia += 2.0 * scale * mixed + scale * scale * inertia;
    }

    /// The step of the smallest shift that keeps the model convex and the step within the radius (half again as far is near enough). Where
    /// the model is not convex and the step falls short of the radius, the softest direction makes up for it. `at` is the iteration
    /// and the tolerance below which a step is left as it is.
    fn step_within(
        &mut self,
        engine: &Engine,
        residual: &Residual,
        drive: &Drive,
        radius: f64,
        (at, tol): (usize, f64),
    ) -> Result<Step, SolveError> {
        self.convexify(engine, at)?;
        let mut step = self.model_step(engine, residual, drive, at)?;
        for _ in 0..MAX_SHORTENINGS {
            if step.extent <= 1.5 * radius {
                break;
            }
            self.shift = self.shift_for(&step, step.extent / radius).max(2.0 * self.shift);
            self.factorise(engine, self.shift);
            step = self.model_step(engine, residual, drive, at)?;
        }
        let small = increment_size(engine, &step.increment) <= tol;
        if radius.is_finite() && step.extent < 0.5 * radius && self.shift > 0.0 && !small {
            let farther = radius - step.extent;
            self.add_softest(engine, residual, &mut step, farther);
        }
        Ok(step)
    }

    /// The shift that would make a step shorter by a factor, if it were a single mode: of the stiffness over mass that the step has.
    fn shift_for(&self, step: &Step, shorter: f64) -> f64 {
        let ratio = step.curvature / step.inertia;
        let stiffness = if ratio.is_finite() { ratio.max(FIRST_SHIFT) } else { FIRST_SHIFT };
        ((stiffness + self.shift) * shorter - stiffness).max(FIRST_SHIFT)
    }

    /// Corrects at most the fraction `longest` of a step for what its linear prediction missed and evaluates the potential there. While
    /// supports are `pushed`, contact is left to the iterations after: its potential may rise, the push does the work.
    fn trial(
        &mut self,
        engine: &mut Engine,
        state: &State,
        residual: &Residual,
        step: &Step,
        longest: f64,
        pushed: bool,
    ) -> Result<Trial, SolveError> {
        let safe = timed(&mut self.timings.detection, || engine.step_fraction(state, &step.increment))?.min(longest);
        let work = step.curvature + self.shift * step.inertia;
        let base: Vec<f64> = step.increment.iter().map(|x| x * safe).collect();
        let mut trial = Trial {
            state: state.retract(&base, 1.0),
            increment: base.clone(),
            potential: f64::NAN,
            expected: -safe * step.slope - 0.5 * safe * safe * step.curvature,
            fraction: safe,
            rounds: 0,
            contact_change: 0.0,
            settled: false,
            excess: None,
        };
        let mut last = f64::INFINITY;
        let mut best: Option<Trial> = None;
        loop {
            // contact that cannot be resolved there is a step too long, not the end
            if timed(&mut self.timings.detection, || engine.update_contact(&trial.state)).is_err() {
                break;
            }
            let there = timed(&mut self.timings.assembly, || engine.residual_of_trial(&trial.state));
            trial.potential = there.potential.total();
            trial.contact_change = relative_change(&residual.contact_gradient, &there.contact_gradient);
            // the potential cannot tell, and corrections would be made of rounding
            trial.settled |= trial.expected.abs() < noise(residual);
            if trial.settled || trial.rounds >= MAX_ROUNDS || !trial.potential.is_finite() {
                break;
            }
            // near rest all that is out of balance is corrected (a chord step)
            let gentle = self.shift == 0.0 && safe == 1.0 && !pushed && trial.contact_change <= GENTLE;
            let with_contact = !(pushed || gentle);
            let (excess, surprise) = self.surprise(engine, state, residual, &there, &trial, with_contact);
            let (from, correction) = if gentle {
                let mut unbalanced = there.gradient;
                self.neutral.remove_sliding_force(&mut unbalanced);
                (&trial.increment, self.solve_last(engine, &unbalanced))
            } else {
                (&base, self.solve_last(engine, &surprise))
            };
            let wanted: Vec<f64> = from.iter().zip(&correction).map(|(b, c)| b - c).collect();
            let change: Vec<f64> = wanted.iter().zip(&trial.increment).map(|(w, x)| w - x).collect();
            let size = self.energy_norm_sq(engine, &change) / (safe * safe * work);
            if best.as_ref().is_none_or(|b: &Trial| trial.potential < b.potential) {
                best = Some(trial.clone());
            }
            if size.is_nan() || size >= CONTRACTION * last {
                break;
            }
            last = size;
            trial.rounds += 1;
            trial.settled = size < SMALL_CORRECTION;
            trial.state = state.retract(&wanted, 1.0);
            trial.increment = wanted;
            trial.excess = Some(excess);
        }
        timed(&mut self.timings.detection, || engine.update_contact(state))?;
        // among changes that rounding makes, the corrected state is the better one
        Ok(match best {
            Some(best) if !trial.settled && trial.expected > noise(residual) => best,
            _ => trial,
        })
    }

    /// ΔᵀKΔ of the assembled (unshifted) tangent plus shift.
    fn energy_norm_sq(&self, engine: &Engine, change: &[f64]) -> f64 {
        let product = self.multiply(engine, &self.tangent.values, change);
        self.free_dot(engine, change, |i| product[i] + self.shift * engine.masses[i] * change[i])
    }

    /// Forces that the linear prediction missed: BᵀC e of the rods, and Σ k e ∂gap/∂x of contact.
    fn surprise(
        &self,
        engine: &Engine,
        state: &State,
        residual: &Residual,
        there: &Residual,
        trial: &Trial,
        contact: bool,
    ) -> (Vec<[Six; 3]>, Vec<f64>) {
        let (excess, mut out) = engine.elastic_surprise(state, &trial.state, &trial.increment);
        if contact {
            engine.add_contact_surprise(state, &trial.increment, residual, there, &mut out);
        }
        (excess, out)
    }
}

/// Changes of the potential that rounding makes.
fn noise(residual: &Residual) -> f64 {
    ROUNDING * (residual.potential.total().abs() + residual.potential.elastic.iter().sum::<f64>())
}

/// Size of the rotations, rad, that the largest contact force makes: F L²/B.
fn contact_bends(engine: &Engine, residual: &Residual) -> f64 {
    let force = residual.contact_gradient.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    force * engine.scales.length.powi(2) / engine.scales.bending
}

/// Largest difference over the largest value before; 0 where all is 0.
fn relative_change(before: &[f64], after: &[f64]) -> f64 {
    let largest = before.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    let change = before.iter().zip(after).fold(0.0f64, |a, (x, y)| a.max((x - y).abs()));
    if change == 0.0 { 0.0 } else { change / largest }
}

/// How far a step goes: the largest rotation of a node, rad, or the largest relative displacement of strands in contact over their contact
/// distance.
fn extent(engine: &Engine, residual: &Residual, step: &[f64]) -> f64 {
    let part = |n: usize, k: usize| Vec3::new(step[6 * n + k], step[6 * n + k + 1], step[6 * n + k + 2]);
    let turn = (0..step.len() / 6).map(|n| part(n, 3).norm()).fold(0.0, f64::max);
    let Some(side) = &engine.contact else { return turn };
    let sliding = |term: &crate::contact::detect::Meeting| {
        let [a, _, b, _] = side.nodes_of(term);
        (part(a, 0) - part(b, 0)).norm() / (side.set.radius_of(term.slave) + side.set.radius_of(term.master))
    };
    residual.meetings.iter().map(sliding).fold(turn, f64::max)
}
