//! One ramp as the scalar parameter of a path: its value, how it moves a state, how it changes the gradient.

use std::f64::consts::TAU;

use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::element::MAX_DOF;
use crate::rod::element::{Stress, predicted_stress};
use crate::scene::Ramp;
use crate::scene::model::unit;
use crate::solve::load_step::solver::Solver;
use crate::solve::problem::assembly::symmetric;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::{PrescribedValue, State};

/// Quantity that the parameter changes, per unit of the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
enum PrescribedQuantity {
    Load,
    Pressure(usize),
    /// Excess link of a rod, turns.
    Link(usize),
    /// A supported node: direction of its displacement, or axis times 2π of its rotation.
    Node(usize, Vec3, Vec3),
}

/// A ramp, its present value and its target, in the ramp's own unit; displacements count along the line to the target.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    quantity: PrescribedQuantity,
    pub(super) start: f64,
    pub(super) target: f64,
}

impl Parameter {
    /// The ramp seen from the solver's present state.
    ///
    /// # Errors
    /// A ramp whose target is where it already is; a [`Ramp::RotationAbout`] or a [`Ramp::Pose`]; joined nodes that
    /// move; a model with obstacles.
    pub(super) fn new(solver: &Solver, ramp: &Ramp) -> Result<Self, InputError> {
        if !solver.engine.model.obstacles.is_empty() {
            let reason =
                "paths of rods that may touch planes or other obstacles cannot be followed: go in steps (`step_to`, \
                 `run`)"
                    .to_owned();
            return Err(InputError::Inconsistent { field: "obstacles".to_owned(), reason });
        }
        let state = solver.engine.state();
        let index = |n: &crate::scene::NodeRef| solver.engine.first_node[n.rod] + n.node;
        if let Ramp::Rotation { node, .. } | Ramp::Displacement { node, .. } = ramp
            && solver.engine.model.joined_nodes(*node).len() > 1
        {
            let reason = "moves joined nodes, which cannot be followed: go in steps (`step_to`, `run`)".to_owned();
            return Err(InputError::Inconsistent { field: "ramp".to_owned(), reason });
        }
        let (quantity, start, target) = match ramp {
            Ramp::Load { to } => (PrescribedQuantity::Load, state.load_factor(), *to),
            Ramp::Pressure { rod, to } => (PrescribedQuantity::Pressure(*rod), state.pressures()[*rod], *to),
            Ramp::ExcessLink { rod, to } => {
                let natural = solver.engine.model.rods[*rod].natural_link();
                (PrescribedQuantity::Link(*rod), state.seams()[*rod] / TAU - natural, *to)
            }
            Ramp::Rotation { node, axis, to } => {
                let turned = solver.moved.turned.get(&index(node)).copied().unwrap_or(0.0);
                (PrescribedQuantity::Node(index(node), Vec3::zeros(), unit(axis) * TAU), turned, *to)
            }
            Ramp::RotationAbout { .. } => {
                let reason =
                    "leads round a circle, which cannot be followed: go in steps (`step_to`, `run`)".to_owned();
                return Err(InputError::Inconsistent { field: "ramp.rotation".to_owned(), reason });
            }
            Ramp::Number { .. } | Ramp::Obstacle { .. } => {
                let reason = "numbers of rods and obstacles change in steps only (`step_to`, `run`)".to_owned();
                return Err(InputError::Inconsistent { field: "ramp".to_owned(), reason });
            }
            Ramp::Pose { .. } => {
                let reason = "leads along a way of its own, which cannot be followed: go in steps (`step_to`, `run`)";
                return Err(InputError::Inconsistent { field: "ramp.pose".to_owned(), reason: reason.to_owned() });
            }
            Ramp::Displacement { node, to } => {
                let here = solver.moved.displaced.get(&index(node)).copied().unwrap_or_default();
                let way = to - here;
                let along = if way == Vec3::zeros() { way } else { unit(&way) };
                (PrescribedQuantity::Node(index(node), along, Vec3::zeros()), here.dot(&along), to.dot(&along))
            }
        };
        if target == start {
            let reason = format!("the ramp's target, {target}, is its present value: there is no way to follow");
            return Err(InputError::Inconsistent { field: "ramp.to".to_owned(), reason });
        }
        Ok(Self { quantity, start, target })
    }

    /// Distance to the target, the unit of the parameter in arc lengths.
    pub(super) fn range(&self) -> f64 {
        (self.target - self.start).abs()
    }

    /// Motion of supports per unit.
    pub(super) fn drive(&self) -> PrescribedMotion {
        match self.quantity {
            PrescribedQuantity::Node(node, displacement, rotation) => {
                PrescribedMotion { nodes: vec![(node, displacement, rotation)], seams: Vec::new() }
            }
            _ => PrescribedMotion::default(),
        }
    }

    /// Changes quantities other than unknowns and supports: load factor, pressure, seam.
    pub(super) fn advance(&self, state: &mut State, by: f64) {
        let value = match self.quantity {
            PrescribedQuantity::Load => PrescribedValue::Load(state.load_factor() + by),
            PrescribedQuantity::Pressure(rod) => PrescribedValue::Pressure(rod, state.pressures()[rod] + by),
            PrescribedQuantity::Link(rod) => PrescribedValue::Seam(rod, state.seams()[rod] + TAU * by),
            PrescribedQuantity::Node(..) => return,
        };
        state.prescribe([value]);
    }

    /// Reports to the solver how far its ramps have come.
    pub(super) fn record(&self, solver: &mut Solver, by: f64) {
        let PrescribedQuantity::Node(node, displacement, rotation) = self.quantity else { return };
        if rotation == Vec3::zeros() {
            *solver.moved.displaced.entry(node).or_default() += displacement * by;
        } else {
            *solver.moved.turned.entry(node).or_insert(0.0) += by;
        }
    }

    /// ∂gradient/∂parameter for fixed unknowns; `driven` is the part of moved supports, from the tangent.
    pub(super) fn rate(&self, engine: &Engine, state: &State, stress: &[[Stress; 3]], driven: &[f64]) -> Vec<f64> {
        match self.quantity {
            PrescribedQuantity::Node(..) => driven.to_vec(),
            PrescribedQuantity::Load => loads_alone(engine, state, 1.0, None),
            PrescribedQuantity::Pressure(rod) => loads_alone(engine, state, 0.0, Some(rod)),
            PrescribedQuantity::Link(rod) => link_rate(engine, rod, state, stress),
        }
    }

    /// Stresses that mixed-integration-point Newton predicts for a step, the turn of the seam included.
    pub(super) fn predicted_stress(&self, engine: &Engine, state: &State, step: &[f64], by: f64) -> Vec<[Stress; 3]> {
        let mut stress = engine.predicted_stress(state, step);
        let PrescribedQuantity::Link(rod) = self.quantity else { return stress };
        let Some(e) = closing_element(engine, rod) else { return stress };
        let element = &engine.elements[e];
        let mut local = engine.local_increment(element, step);
        let (axis, last) = (engine.seam_axis(state, rod), 6 * engine.model.rods[rod].order + 3);
        (0..3).for_each(|k| local[last + k] += TAU * by * axis[k]);
        let nodes = engine.element_nodes(state, element);
        stress[e] = predicted_stress(&engine.body(e), &nodes, &engine.reference[rod].of(e), &local);
        stress
    }
}

fn closing_element(engine: &Engine, rod: usize) -> Option<usize> {
    engine.elements.iter().rposition(|e| e.rod == rod && e.closes)
}

/// Gradient of unit dead loads or of unit pressure.
fn loads_alone(engine: &Engine, state: &State, factor: f64, pressed: Option<usize>) -> Vec<f64> {
    let mut unit = state.clone();
    let pressure = |rod: usize| if pressed == Some(rod) { 1.0 } else { 0.0 };
    unit.prescribe([PrescribedValue::Load(factor)]);
    unit.prescribe((0..engine.model.rods.len()).map(|rod| PrescribedValue::Pressure(rod, pressure(rod))));
    let mut out = engine.start_residual(engine.state());
    engine.add_loads(&unit, &mut out, None);
    out.gradient
}

/// A turn of the seam turns the last node of the closing element about its own d3 before the increment turns it with
/// the first node: K d3, and ½ d3 × m where m is the moment there, because the two rotations do not commute.
fn link_rate(engine: &Engine, rod: usize, state: &State, stress: &[[Stress; 3]]) -> Vec<f64> {
    let mut out = vec![0.0; 6 * engine.num_nodes()];
    let Some(e) = closing_element(engine, rod) else { return out };
    let order = engine.model.rods[rod].order;
    let (axis, last) = (engine.seam_axis(state, rod) * TAU, 6 * order + 3);
    let mut tangent = [[0.0; MAX_DOF]; MAX_DOF];
    let result = engine.element_output(e, state, Some(&stress[e]), Some(&mut tangent));
    let nodes = &engine.elements[e].nodes;
    for row in 0..6 * (order + 1) {
        let sum: f64 = (0..3).map(|k| symmetric(&tangent, row, last + k) * axis[k]).sum();
        out[6 * nodes[row / 6] + row % 6] += sum;
    }
    let moment = Vec3::new(result.residual[last], result.residual[last + 1], result.residual[last + 2]);
    let commutator = axis.cross(&moment) * 0.5;
    (0..3).for_each(|k| out[6 * nodes[order] + 3 + k] += commutator[k]);
    out
}
