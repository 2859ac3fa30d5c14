//! The linear problem at a state, for those above the solver: tangent, factor, and the motions that nothing resists.
//!
//! Springs hold zero-energy modes and a constraint holds sliding, as in a search ([`ZeroEnergyModes`]). A force that
//! does no work on any of them stretches no spring, so that the response to it is one of the exact ones.

use crate::error::SolveError;
use crate::math::Vec3;
use crate::solve::measures::MAX_ROUNDS;
use crate::solve::problem::assembly::{Residual, Tangent};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::reduction::Reduction;
use crate::solve::problem::sliding_constraint::SlidingConstraint;
pub(crate) use crate::solve::problem::sliding_constraint::dot;
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::Bases;
use crate::solve::problem::zero_energy::ZeroEnergyModes;
use crate::sparse::{Factor, Pattern};

/// Error of a response at which refinement ends, over the response in the norm of the energy, because the next
/// correction is below rounding.
const REFINED: f64 = 1e-9;

/// Displacement and rotation of some nodes, or force and moment on them.
pub(crate) type NodeVector = Vec<(usize, [f64; 6])>;

/// Tangent and factor at the engine's state. Vectors have six numbers a node. Joined nodes have the motions that
/// they share, and their forces are those of the owners of the unknowns.
#[derive(Debug)]
pub(crate) struct Linearised {
    pattern: Pattern,
    factor: Factor,
    bases: Bases,
    /// ∂²Π/∂x² with springs, without the part of the material, which products take element by element.
    besides_material: Vec<f64>,
    /// What springs on zero-energy modes add.
    springs: Vec<f64>,
    border: Option<SlidingConstraint>,
    /// Gradient and zones of contact at the state.
    pub(crate) residual: Residual,
    /// Zero-energy modes, sliding the last if there is any.
    pub(crate) zero_energy: Vec<Vec<f64>>,
    /// Negative eigenvalues of the tangent, those of zero-energy modes left out.
    pub(crate) num_negative: usize,
}

impl Linearised {
    /// Assembles and factorises the tangent at the engine's state. `coupled` are nodes that products couple besides
    /// those that elements and contact do; `products` gives vectors v and factors f: Σ f v vᵀ is added to the
    /// tangent.
    ///
    /// # Errors
    /// Contact geometry that breaks down; a factorisation that does not fit into memory, or with a pivot that vanishes.
    pub(crate) fn at(
        engine: &mut Engine,
        coupled: &[Vec<usize>],
        products: impl FnOnce(&Engine, &Residual) -> Vec<(NodeVector, f64)>,
    ) -> Result<Self, SolveError> {
        let state = engine.state.clone();
        engine.update_contact(&state)?;
        engine.check_memory()?;
        let engine = &*engine;
        let (pattern, factor) = engine.install(|| Factor::of(engine.node_graph_with(coupled)))?;
        let (mut assembled, drive) = (Tangent::default(), PrescribedMotion::default());
        let stress = engine.actual_stress(&state);
        let residual = engine.linearise(&state, Some(&stress), &drive, (&pattern, &mut assembled));
        let (bases, mut tangent) = (residual.bases.clone(), std::mem::take(&mut assembled.values));
        engine.linearise_besides_material(&state, &stress, (&pattern, &mut assembled));
        let mut besides_material = assembled.values;
        for (vector, factor) in products(engine, &residual) {
            for values in [&mut tangent, &mut besides_material] {
                add_product(&pattern, &bases, values, &vector, factor);
            }
        }
        let zero_energy = ZeroEnergyModes::at(engine, &state, &residual);
        let mut springs = vec![0.0; tangent.len()];
        zero_energy.add_pins(engine, &state, (&pattern, &bases), &mut springs);
        for values in [&mut tangent, &mut besides_material] {
            values.iter_mut().zip(&springs).for_each(|(k, spring)| *k += spring);
        }
        let constraint = zero_energy.sliding_constraint();
        let motions = zero_energy.all(engine);
        let mut linearised = Self {
            pattern,
            factor,
            bases,
            besides_material,
            springs,
            border: None,
            residual,
            zero_energy: motions,
            num_negative: 0,
        };
        engine.install(|| linearised.factorise(&tangent, constraint))?;
        Ok(linearised)
    }

    /// Factorises the tangent with its springs.
    fn factorise(&mut self, tangent: &[f64], constraint: Option<Vec<f64>>) -> Result<(), SolveError> {
        let inertia = self.factor.factorise(&self.pattern, tangent);
        self.num_negative = inertia.ok_or(SolveError::Factorisation { iteration: 0, shift: 0.0 })?.num_negative;
        let Some(constraint) = constraint else { return Ok(()) };
        let response = self.solve_unconstrained(&constraint);
        let border = SlidingConstraint::new(constraint, response);
        self.num_negative = border.num_negative(self.num_negative);
        self.border = Some(border);
        Ok(())
    }

    /// A motion under these forces, with some zero-energy modes in it: a response of the factor, refined by what is
    /// left of the forces. `engine` is in the state of the tangent.
    pub(crate) fn solve(&mut self, engine: &Engine, forces: &[f64]) -> Vec<f64> {
        engine.install(|| self.refined(engine, forces))
    }

    fn refined(&mut self, engine: &Engine, forces: &[f64]) -> Vec<f64> {
        let mut motion = self.respond(forces);
        let whole = dot(forces, &motion).abs();
        let mut left = whole;
        for _ in 0..MAX_ROUNDS {
            let defect: Vec<f64> = forces.iter().zip(self.resistance(engine, &motion)).map(|(f, k)| f - k).collect();
            let correction = self.respond(&defect);
            let work = dot(&defect, &correction).abs();
            if work.is_nan() || work >= left {
                break;
            }
            motion.iter_mut().zip(&correction).for_each(|(x, dx)| *x += dx);
            left = work;
            if left <= REFINED * REFINED * whole {
                break;
            }
        }
        motion
    }

    fn respond(&mut self, forces: &[f64]) -> Vec<f64> {
        let mut x = self.solve_unconstrained(forces);
        self.border.iter().for_each(|border| border.apply(&mut x));
        x
    }

    /// Forces of the tangent with its springs against a motion, the part of the material element by element.
    fn resistance(&self, engine: &Engine, motion: &[f64]) -> Vec<f64> {
        let material = engine.material_product(&engine.state, motion);
        self.product(&self.besides_material, motion)
            .iter()
            .zip(material)
            .map(|(rest, material)| rest + material)
            .collect()
    }

    /// The forces against a motion of what holds zero-energy modes: springs, and a spring of unit stiffness along the
    /// sliding constraint.
    pub(crate) fn holding(&self, motion: &[f64]) -> Vec<f64> {
        let mut forces = self.product(&self.springs, motion);
        self.border.iter().for_each(|border| border.add_spring(motion, &mut forces));
        forces
    }

    /// ln |det| of the tangent with [springs](Self::holding), that along the sliding constraint infinitely stiff, so
    /// that its stiffness is a factor that is left out.
    pub(crate) fn log_determinant(&self) -> f64 {
        let border = self.border.as_ref().map_or(0.0, |border| border.compliance().abs().ln());
        self.factor.log_determinant() + border
    }

    /// Number of unknowns.
    pub(crate) fn num_unknowns(&self) -> usize {
        self.pattern.num_equations()
    }

    /// The forces of the tangent against a motion of one node, displacement \[L\] and rotation vector \[rad\],
    /// supported unknowns included on both sides. Contact is that of the law.
    pub(crate) fn driven(&self, engine: &Engine, motion: (usize, Vec3, Vec3)) -> Vec<f64> {
        let (drive, mut tangent) = (PrescribedMotion { nodes: vec![motion], seams: Vec::new() }, Tangent::default());
        let stress = engine.actual_stress(&engine.state);
        engine.linearise(&engine.state, Some(&stress), &drive, (&self.pattern, &mut tangent));
        tangent.drive
    }

    fn reduction(&self) -> Reduction<'_> {
        Reduction { pattern: &self.pattern, bases: &self.bases }
    }

    fn product(&self, values: &[f64], motion: &[f64]) -> Vec<f64> {
        let product = self.pattern.multiply(values, &self.reduction().motion(motion));
        self.reduction().forces_on_nodes(motion.len(), &product)
    }

    fn solve_unconstrained(&mut self, forces: &[f64]) -> Vec<f64> {
        let mut reduced = self.reduction().forces(forces);
        self.factor.solve(&mut reduced);
        self.reduction().motion_of_nodes(forces.len(), &reduced)
    }
}

impl Engine {
    /// The residual of elements and loads in a state with its numbers, those of joined nodes at their masters.
    pub(crate) fn residual_without_contact(&mut self, state: &State) -> Residual {
        self.joined(state, true)
    }

    /// The residual of elements alone in a state with its numbers.
    pub(crate) fn elastic_residual(&mut self, state: &State) -> Residual {
        self.joined(state, false)
    }

    fn joined(&mut self, state: &State, loads: bool) -> Residual {
        let mut out = self.residual_of_numbers(state, loads);
        out.bases.give_to_masters(&self.sharing, &mut out.gradient);
        out
    }
}

/// Adds factor × v vᵀ, v six numbers for each of some nodes that the pattern couples.
fn add_product(pattern: &Pattern, bases: &Bases, values: &mut [f64], vector: &NodeVector, factor: f64) {
    for (k, (p, a)) in vector.iter().enumerate() {
        for (q, b) in &vector[k..] {
            bases.add_block(pattern, values, (*p, *q), |i, j| factor * a[i] * b[j]);
        }
    }
}
