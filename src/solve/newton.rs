//! Mixed-integration-point Newton with an inertia-controlled shift and a passage-free step bound.

use crate::error::SolveError;
use crate::rod::element::Six;
use crate::solve::assembly::{Residual, Tangent};
use crate::solve::engine::Engine;
use crate::solve::neutral;
use crate::solve::state::{Drive, State};
use crate::sparse::{Factor, Pattern};

/// Choices of one equilibrium search; lengths are relative to the node spacing, rotations in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct NewtonOptions {
    /// Converged when a full step moves no node by more than this × node spacing and turns none by more (rad).
    pub tol_increment: f64,
    /// Give up after so many iterations.
    pub max_iterations: usize,
    /// Shift the tangent until it has no negative eigenvalue: seeks minima. Off: seeks any equilibrium.
    pub stable_only: bool,
}

impl Default for NewtonOptions {
    fn default() -> Self {
        Self { tol_increment: 1e-8, max_iterations: 100, stable_only: true }
    }
}

/// One Newton iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Size of the full increment: largest of displacement / node spacing and rotation (rad).
    pub increment: f64,
    /// Largest |residual| over the size of its contributions.
    pub residual: f64,
    /// Fraction of the step taken.
    pub fraction: f64,
    /// Shift used, in units of B/L⁴ per length.
    pub shift: f64,
    /// Total potential before the step.
    pub potential: f64,
}

/// How an equilibrium search ended.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub struct NewtonReport {
    /// Met the tolerance.
    pub converged: bool,
    /// History.
    pub iterations: Vec<Iteration>,
    /// Unstable directions of the last tangent (without shift).
    pub num_unstable: usize,
}

/// Matrix, factorisation and their life between calls.
#[derive(Debug, Default)]
pub struct Workspace {
    pattern: Option<Pattern>,
    factor: Option<Factor>,
    tangent: Tangent,
    /// Candidate list the pattern was made for.
    generation: u64,
    shift: f64,
    shifted: Vec<f64>,
    /// Last estimate of the softest direction.
    softest: Vec<f64>,
}

/// A search whose steps stay shorter than this fraction is given up.
const STUCK: f64 = 1e-4;
/// How often a step is shortened because of contact before it is taken as it is.
const MAX_SHORTENINGS: usize = 12;
/// Contact corrections tried on one factorisation.
const MAX_CORRECTIONS: usize = 4;
/// Iterations allowed to the search without shifts.
const MAX_DIRECT: usize = 15;
/// Smallest shift tried, in units of B/L⁴.
const FIRST_SHIFT: f64 = 10.0;
const MAX_SHIFT: f64 = 1e30;

impl Workspace {
    /// Finds an equilibrium from the engine's state with `drive` applied on the way; the engine keeps the last iterate.
    ///
    /// A plain mixed Newton search comes first where nothing is near contact: it takes a rod through a full circle in one step,
    /// passing tangents that are indefinite although both ends of the way are stable. If it does not end in a
    /// stable state, or if strands are near, the search with shifts takes over from the start.
    ///
    /// # Errors
    /// Numbers that break down; not converging is in the report.
    pub fn equilibrate(
        &mut self,
        engine: &mut Engine,
        drive: &Drive,
        options: &NewtonOptions,
        start_stress: Option<&[[Six; 3]]>,
    ) -> Result<NewtonReport, SolveError> {
        let start = engine.state.clone();
        self.refresh(engine, &start)?;
        let near_contact = engine.contact.as_ref().is_some_and(|side| !side.broad_phase.pairs().is_empty());
        let mut spent = Vec::new();
        if !near_contact || !options.stable_only {
            let direct = NewtonOptions {
                stable_only: false,
                max_iterations: if options.stable_only { MAX_DIRECT } else { options.max_iterations },
                ..options.clone()
            };
            match self.iterate(engine, drive, &direct, start_stress) {
                Ok(report) if !options.stable_only || (report.converged && report.num_unstable == 0) => return Ok(report),
                Ok(report) => spent = report.iterations,
                Err(_) if options.stable_only => {}
                Err(error) => return Err(error),
            }
            engine.state = start;
        }
        let mut report = self.iterate(engine, drive, options, start_stress)?;
        spent.append(&mut report.iterations);
        report.iterations = spent;
        Ok(report)
    }

    fn iterate(
        &mut self,
        engine: &mut Engine,
        drive: &Drive,
        options: &NewtonOptions,
        start_stress: Option<&[[Six; 3]]>,
    ) -> Result<NewtonReport, SolveError> {
        let mut report = NewtonReport { converged: false, iterations: Vec::new(), num_unstable: 0 };
        let mut remaining = 1.0;
        let mut stuck = 0;
        let mut state = engine.state.clone();
        let mut stress = start_stress.map_or_else(|| engine.actual_stress(&state), <[[Six; 3]]>::to_vec);
        for iteration in 0..options.max_iterations {
            self.refresh(engine, &state)?;
            let drive_now = drive.scaled(remaining);
            let residual = self.linearise(engine, &state, &stress, &drive_now);
            let mut step = self.step(engine, &residual, &state, options, iteration)?;
            set_prescribed(&mut step, &drive_now);
            let increment = increment_size(engine, &step);
            if !increment.is_finite() {
                return Err(SolveError::NotFinite { iteration, quantity: "increment", index: 0, value: increment });
            }
            let safe = engine.step_fraction(&state, &step, &drive_now)?;
            let (taken, fraction) = self.contact_corrected(engine, &state, &residual, &step, &drive_now, safe)?;
            let predicted = engine.predicted_stress(&state, &taken, &drive_now.scaled(fraction));
            advance_stress(&mut stress, &engine.actual_stress(&state), &predicted, fraction);
            report.iterations.push(Iteration {
                increment,
                residual: relative_residual(engine, &residual),
                fraction,
                shift: self.shift,
                potential: residual.potential.total(),
            });
            state = state.retract_scaled(&taken, &drive_now, fraction);
            stuck = if fraction < STUCK { stuck + 1 } else { 0 };
            remaining *= 1.0 - fraction;
            engine.state = state.clone();
            if fraction == 1.0 && increment <= options.tol_increment {
                report.converged = true;
                break;
            }
            if stuck >= 3 {
                break;
            }
        }
        self.refresh(engine, &state)?;
        report.num_unstable = self.count_unstable(engine)?;
        Ok(report)
    }

    /// The increment actually taken: `safe` × step, corrected for what the contact tangent did not foresee, and shortened where
    /// that is too much.
    ///
    /// The elastic part of a step is trusted (its predicted stresses are what makes long steps possible). Contact is not: a
    /// step along a curved contact surface leaves it by second order, and a stiff law turns that into large forces (the Maratos
    /// effect of penalty methods). With s(Δ) = g_c(x ⊕ Δ) − g_c(x) − K_c Δ the increment solves K Δ = t(−g) − s(Δ) by fixed-point
    /// iteration on the factorisation at hand; t is reduced until the first correction is smaller than the step in the
    /// energy norm and the second much smaller than the first.
    fn contact_corrected(
        &mut self,
        engine: &mut Engine,
        state: &State,
        residual: &Residual,
        step: &[f64],
        drive: &Drive,
        safe: f64,
    ) -> Result<(Vec<f64>, f64), SolveError> {
        let scaled = |t: f64| -> Vec<f64> { step.iter().map(|x| x * t).collect() };
        let near_contact = engine.contact.as_ref().is_some_and(|side| !side.broad_phase.pairs().is_empty());
        if !near_contact {
            let mut t = safe;
            // a contact curve that turns too sharply within one segment is a step too long, not the end
            while engine.update_contact(&state.retract_scaled(&scaled(t), drive, t)).is_err() && t > 1e-6 {
                t *= 0.5;
            }
            return Ok((scaled(t), t));
        }
        let work = -self.free_dot(engine, step, |i| residual.gradient[i] + self.tangent.drive[i]);
        let mut t = safe;
        for _ in 0..MAX_SHORTENINGS {
            let base = scaled(t);
            let mut total = base.clone();
            let mut last = f64::INFINITY;
            let mut accepted = false;
            for round in 0..MAX_CORRECTIONS {
                let surprise = self.surprise(engine, state, residual, &total, drive, t)?;
                let correction = self.solve_last(engine, &surprise);
                let wanted: Vec<f64> = base.iter().zip(&correction).map(|(b, c)| b - c).collect();
                let change: Vec<f64> = wanted.iter().zip(&total).map(|(w, x)| w - x).collect();
                // energy norm of the change: Δᵀ K Δ = − Δ · (s(new) − s(old)) is not at hand for later rounds; use the force at hand
                let size = self.free_dot(engine, &change, |i| surprise[i]).abs() / (t * t * work);
                if !size.is_finite() {
                    break;
                }
                if round == 0 && size > 0.5 || round > 0 && size > 0.5 * last {
                    last = size;
                    break;
                }
                total = wanted;
                last = size;
                accepted = size < 0.1;
                if size < 1e-3 {
                    break;
                }
            }
            if accepted {
                return Ok((total, t));
            }
            t *= (0.3 / last).sqrt().clamp(0.1, 0.6);
        }
        Ok((scaled(t), t))
    }

    /// g_c(x ⊕ Δ) − g_c(x) − K_c Δ.
    fn surprise(
        &self,
        engine: &mut Engine,
        state: &State,
        residual: &Residual,
        increment: &[f64],
        drive: &Drive,
        t: f64,
    ) -> Result<Vec<f64>, SolveError> {
        let trial = state.retract_scaled(increment, drive, t);
        engine.update_contact(&trial)?;
        let mut out = engine.contact_gradient(&trial);
        for (o, g) in out.iter_mut().zip(&residual.contact_gradient) {
            *o -= g;
        }
        for (nodes, block) in &residual.contact_blocks {
            crate::solve::assembly::subtract_product(nodes, block, increment, &mut out);
        }
        Ok(out)
    }

    /// Sum over free unknowns of step × f.
    fn free_dot(&self, engine: &Engine, step: &[f64], f: impl Fn(usize) -> f64) -> f64 {
        let free = |i: usize| engine.free[i / 6][i % 6];
        (0..step.len()).filter(|&i| free(i)).map(|i| step[i] * f(i)).sum()
    }

    /// Brings contact candidates, pattern and symbolic analysis up to date with a state.
    fn refresh(&mut self, engine: &mut Engine, state: &State) -> Result<(), SolveError> {
        engine.update_contact(state)?;
        let generation = engine.contact.as_ref().map_or(0, |side| side.broad_phase.generation());
        if self.pattern.is_none() || generation != self.generation {
            let pattern = engine.build_pattern();
            self.factor = Some(Factor::analyse(&pattern)?);
            self.pattern = Some(pattern);
            self.generation = generation;
        }
        Ok(())
    }

    fn linearise(&mut self, engine: &Engine, state: &State, stress: &[[Six; 3]], drive: &Drive) -> Residual {
        let Some(pattern) = &self.pattern else { return Residual::default() };
        let residual = engine.linearise(state, Some(stress), drive, pattern, &mut self.tangent);
        neutral::add_pins(engine, state, pattern, &mut self.tangent.values);
        residual
    }

    /// Solves for the increment of all unknowns, shifting the tangent as needed.
    fn step(
        &mut self,
        engine: &Engine,
        residual: &Residual,
        state: &State,
        options: &NewtonOptions,
        iteration: usize,
    ) -> Result<Vec<f64>, SolveError> {
        self.choose_shift(engine, options, iteration)?;
        let (Some(pattern), Some(factor)) = (&self.pattern, &mut self.factor) else { return Ok(Vec::new()) };
        let mut rhs = vec![0.0; pattern.num_equations()];
        for node in 0..engine.num_nodes() {
            for k in 0..6 {
                if let Some(eq) = pattern.equation(node, k) {
                    rhs[eq] = -residual.gradient[6 * node + k] - self.tangent.drive[6 * node + k];
                }
            }
        }
        factor.solve(&mut rhs);
        let mut step = expand(engine, pattern, &rhs);
        neutral::remove(engine, state, &mut step);
        Ok(step)
    }

    /// Factorises with the smallest useful shift: none where the tangent is positive definite; otherwise half again as much as the
    /// lowest eigenvalue asks for, so that the unstable direction is followed at the stride of a Newton step.
    fn choose_shift(&mut self, engine: &Engine, options: &NewtonOptions, iteration: usize) -> Result<(), SolveError> {
        let last = self.shift;
        self.shift = 0.0;
        match self.factorise(engine, 0.0) {
            Some(0) => return Ok(()),
            Some(_) if !options.stable_only => return Ok(()),
            _ => {}
        }
        self.shift = last.max(FIRST_SHIFT);
        while self.factorise(engine, self.shift) != Some(0) {
            self.shift *= 8.0;
            if self.shift > MAX_SHIFT {
                return Err(SolveError::Factorisation { iteration, shift: self.shift });
            }
        }
        let wanted = (1.5 * (self.shift - self.lowest_above(engine, 4))).max(1e-3 * FIRST_SHIFT);
        if wanted < 0.7 * self.shift {
            let safe = self.shift;
            self.shift = wanted;
            if self.factorise(engine, wanted) != Some(0) {
                self.shift = safe;
                self.factorise(engine, safe);
            }
        }
        Ok(())
    }

    /// Lowest eigenvalue of the factorised (positive definite) tangent + shift × mass, from above, by a few inverse iterations that
    /// start from the last such vector.
    fn lowest_above(&mut self, engine: &Engine, rounds: usize) -> f64 {
        let mut mass = vec![0.0; 6 * engine.num_nodes()];
        for_each_mass(engine, |node, k, m| mass[6 * node + k] = m);
        if self.softest.len() != mass.len() {
            // a fixed start with components everywhere: runs repeat
            self.softest = (0..mass.len()).map(|i| ((i + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5).collect();
        }
        let mut lowest = f64::INFINITY;
        for _ in 0..rounds {
            let norm: f64 = self.softest.iter().zip(&mass).map(|(x, m)| x * x * m).sum::<f64>().sqrt();
            self.softest.iter_mut().for_each(|x| *x /= norm);
            let rhs: Vec<f64> = self.softest.iter().zip(&mass).map(|(x, m)| x * m).collect();
            let next = self.solve_last(engine, &rhs);
            // Rayleigh quotient of the inverse
            lowest = 1.0 / next.iter().zip(&rhs).map(|(x, r)| x * r).sum::<f64>();
            self.softest = next;
        }
        lowest
    }

    /// Factorises tangent + shift × mass; number of negative eigenvalues, `None` if a pivot vanished.
    pub(crate) fn factorise(&mut self, engine: &Engine, shift: f64) -> Option<usize> {
        let (Some(pattern), Some(factor)) = (&self.pattern, &mut self.factor) else { return None };
        let values = if shift == 0.0 {
            &self.tangent.values
        } else {
            self.shifted.clone_from(&self.tangent.values);
            for_each_mass(engine, |node, k, mass| {
                if let Some(eq) = pattern.equation(node, k) {
                    self.shifted[pattern.diagonal(eq)] += shift * mass;
                }
            });
            &self.shifted
        };
        factor.factorise(pattern, values).map(|inertia| inertia.num_negative)
    }

    /// Solves with the last factorisation for all unknowns.
    pub(crate) fn solve_last(&mut self, engine: &Engine, rhs_nodes: &[f64]) -> Vec<f64> {
        let (Some(pattern), Some(factor)) = (&self.pattern, &mut self.factor) else { return Vec::new() };
        let mut rhs = vec![0.0; pattern.num_equations()];
        for node in 0..engine.num_nodes() {
            for k in 0..6 {
                if let Some(eq) = pattern.equation(node, k) {
                    rhs[eq] = rhs_nodes[6 * node + k];
                }
            }
        }
        factor.solve(&mut rhs);
        expand(engine, pattern, &rhs)
    }

    /// Linearises at the engine's state with its actual stresses and counts negative eigenvalues.
    pub fn count_unstable(&mut self, engine: &mut Engine) -> Result<usize, SolveError> {
        let state = engine.state.clone();
        self.refresh(engine, &state)?;
        let stress = engine.actual_stress(&state);
        self.linearise(engine, &state, &stress, &Drive::default());
        let neutral = NEUTRAL_SHIFT;
        self.factorise(engine, neutral).ok_or(SolveError::Factorisation { iteration: 0, shift: neutral })
    }
}

/// Eigenvalues above minus this (in units of B/L⁴) count as neutral: rigid motions and sliding of a uniform ring along itself
/// are neutral but for rounding and discretisation.
const NEUTRAL_SHIFT: f64 = 1e-3;

/// Calls `f(node, unknown, mass)` with the masses that shifts multiply: (B/L⁴)·h for positions, times lever² for rotations.
pub(crate) fn for_each_mass(engine: &Engine, mut f: impl FnMut(usize, usize, f64)) {
    let scales = &engine.scales;
    let unit = scales.bending / scales.length.powi(4);
    for (index, rod) in engine.model.rods.iter().enumerate() {
        let spacing = rod.length / (rod.num_elements * rod.order) as f64;
        for node in engine.first_node[index]..engine.first_node[index + 1] {
            for k in 0..6 {
                let lever_sq = if k < 3 { 1.0 } else { scales.lever * scales.lever };
                f(node, k, unit * spacing * lever_sq);
            }
        }
    }
}

fn expand(engine: &Engine, pattern: &Pattern, reduced: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; 6 * engine.num_nodes()];
    for node in 0..engine.num_nodes() {
        for k in 0..6 {
            if let Some(eq) = pattern.equation(node, k) {
                all[6 * node + k] = reduced[eq];
            }
        }
    }
    all
}

fn set_prescribed(step: &mut [f64], drive: &Drive) {
    for &(node, displacement, rotation) in &drive.nodes {
        for k in 0..3 {
            step[6 * node + k] += displacement[k];
            step[6 * node + 3 + k] += rotation[k];
        }
    }
}

fn increment_size(engine: &Engine, step: &[f64]) -> f64 {
    let lever = engine.scales.lever;
    step.iter().enumerate().map(|(i, x)| if i % 6 < 3 { x.abs() / lever } else { x.abs() }).fold(0.0, |a, b| {
        // NaN must not be swallowed by max
        if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
    })
}

/// Largest free |gradient| over the largest sum of contributions, separately for forces and moments.
pub(crate) fn relative_residual(engine: &Engine, residual: &Residual) -> f64 {
    let mut worst = 0.0f64;
    for kind in 0..2 {
        let (mut gradient, mut magnitude) = (0.0f64, 0.0f64);
        for node in 0..engine.num_nodes() {
            for k in 3 * kind..3 * kind + 3 {
                magnitude = magnitude.max(residual.magnitude[6 * node + k]);
                if engine.free[node][k] {
                    gradient = gradient.max(residual.gradient[6 * node + k].abs());
                }
            }
        }
        if magnitude > 0.0 {
            worst = worst.max(gradient / magnitude);
        }
    }
    worst
}

/// Mixed unknowns go the same fraction of their step as the positions: σ ← C(ε + B Δ) + (1 − t)(σ − C ε).
fn advance_stress(stress: &mut [[Six; 3]], actual: &[[Six; 3]], predicted: &[[Six; 3]], fraction: f64) {
    for ((old, now), new) in stress.iter_mut().zip(actual).zip(predicted) {
        for g in 0..3 {
            for i in 0..6 {
                old[g][i] = new[g][i] + (1.0 - fraction) * (old[g][i] - now[g][i]);
            }
        }
    }
}
