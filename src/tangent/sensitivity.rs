//! Sensitivities: dq/dp of observables q with respect to what is prescribed, p, by the adjoint.
//!
//! ```text
//! K δx − b δc + ∂r/∂p δp = 0        aᵀ δx + ∂g/∂p δp = 0
//! K λ + a ν = ∂q/∂x                 −bᵀ λ = ∂q/∂c
//! dq/dp = ∂q/∂p − λ·∂r/∂p − ν·∂g/∂p
//! ```
//!
//! One solve an observable gives its derivatives with respect to any number of parameters. r is the gradient of the
//! potential, K the tangent of the chosen [`ContactResponse`]. [`ContactResponse::Locked`] differentiates the
//! equilibrium under hard contact: each point of contact has a row a and a column b, see
//! [`ClosedPoint`](super::contact::ClosedPoint); along lines every gap with force stays closed.
//! [`ContactResponse::ByLaw`] differentiates that under a penalty, without rows and columns. Where a contact is about
//! to open or to close, the derivative holds on one side.
//!
//! ∂r/∂p, ∂g/∂p and ∂q/∂p at fixed unknowns are central differences of fourth order of the exact residual, contact
//! under the law included; motions of supports are columns of the tangent.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::contact::GapRate;
use super::observables::{Observable, is_borne, of_node, of_rod};
use super::{EquilibriumTangent, contact};
use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::RodNumber;
use crate::scene::model::unit;
use crate::scene::{Model, NodeRef, ObstacleNumber};
use crate::solve::problem::engine::Engine;
use crate::solve::problem::linearised::dot;
use crate::solve::problem::state::PrescribedValue;
use crate::solve::{RunError, State};

/// Relative step of numbers of rods: residuals are linear or quadratic in them.
const STEP: f64 = 1e-3;
/// The same of a radius or an obstacle where strands touch, over the overlap of the weakest contact: a force goes as
/// the overlap to the power 3/2, whose difference of fourth order is then right to 1e-9. Where offsets keep the
/// overlaps, it is that of the change of an overlap to second order, h²/ε.
const STEP_OF_GAPS: f64 = 1e-2;
/// Force of a contact, over the largest, below which it is about to open: a per mille change of what is prescribed may
/// do.
const WEAK: f64 = 1e-3;
/// Step of links, turns: the fourth-order difference is exact to 1e-11, and rounding of stiff stretch divided by it
/// is 1e-12.
const TURN_STEP: f64 = 3e-4;

/// What is prescribed.
#[derive(Debug, Clone, PartialEq)]
pub enum PrescribedNumber {
    /// Numbers of a rod, all changed by as much (both bending stiffnesses).
    Number {
        /// Rod index.
        rod: usize,
        /// The numbers.
        which: Vec<RodNumber>,
    },
    /// The factor on dead loads.
    Load,
    /// Pressure on a closed rod in the plane \[F/L\].
    Pressure {
        /// Rod index.
        rod: usize,
    },
    /// Link of a closed rod, turns.
    Link {
        /// Rod index.
        rod: usize,
    },
    /// A number of an obstacle: the level is the height of a plane along its normal, and the radius of others.
    Obstacle {
        /// Obstacle index.
        obstacle: usize,
        /// The number.
        which: ObstacleNumber,
    },
    /// Displacement of a supported node along a direction \[L\].
    Displacement {
        /// The node.
        node: NodeRef,
        /// The direction; its length does not matter.
        direction: Vec3,
    },
    /// Rotation of a supported node about an axis through it, turns.
    Rotation {
        /// The node.
        node: NodeRef,
        /// The axis; its length does not matter.
        axis: Vec3,
    },
}

impl PrescribedNumber {
    /// From a name: `load`; `link`, `pressure`, `bending`, `bending_1`, `bending_2`, `twisting`, `stretching`,
    /// `shearing`, `shearing_1`, `shearing_2`, `contact_radius`, `length`, `natural_curvature_1`,
    /// `natural_curvature_2`, `natural_twist`, `binding` of the first rod or, after a colon, of the rod of a name
    /// (`bending:ring`); `displacement_x`, `displacement_y`, `displacement_z`, `rotation_x`, `rotation_y`, `rotation_z`
    /// of a supported node, after the rod (`displacement_z:rod:end`: `start`, `end` or its index); `obstacle_level`,
    /// `obstacle_x`, `obstacle_y`, `obstacle_z`, `obstacle_turns` of the first obstacle or of that of a name.
    ///
    /// # Errors
    /// Another name.
    pub fn parse(model: &Model, text: &str) -> Result<Self, InputError> {
        use RodNumber::{
            Bending1, Bending2, Binding, ContactRadius, Curvature1, Curvature2, Length, Shearing1, Shearing2,
            Stretching, Twist, Twisting,
        };
        let name = text.split(':').next().unwrap_or(text);
        let axis = |prefix: &str| "xyz".find(name.strip_prefix(prefix)?).filter(|_| name.len() == prefix.len() + 1);
        let unit_vector = |k: usize| Vec3::ith(k, 1.0);
        if let Some(k) = axis("displacement_") {
            return Ok(Self::Displacement { node: of_node(model, text)?, direction: unit_vector(k) });
        }
        if let Some(k) = axis("rotation_") {
            return Ok(Self::Rotation { node: of_node(model, text)?, axis: unit_vector(k) });
        }
        let of_obstacle = match name {
            "obstacle_level" => Some(ObstacleNumber::Level),
            "obstacle_turns" => Some(ObstacleNumber::Turns),
            _ => axis("obstacle_").map(ObstacleNumber::Displacement),
        };
        if let Some(which) = of_obstacle {
            return Ok(Self::Obstacle { obstacle: obstacle_of(model, text)?, which });
        }
        let (name, rod) = of_rod(model, text)?;
        let which: &[RodNumber] = match name {
            "load" => return Ok(Self::Load),
            "link" => return Ok(Self::Link { rod }),
            "pressure" => return Ok(Self::Pressure { rod }),
            "bending" => &[Bending1, Bending2],
            "shearing" => &[Shearing1, Shearing2],
            _ => {
                let single = [
                    &[Bending1],
                    &[Bending2],
                    &[Twisting],
                    &[Stretching],
                    &[Shearing1],
                    &[Shearing2],
                    &[ContactRadius],
                    &[Length],
                    &[Curvature1],
                    &[Curvature2],
                    &[Twist],
                    &[Binding],
                ];
                let found = single.into_iter().find(|number| number[0].name() == name);
                let allowed = "load, link, pressure, bending, bending_1, bending_2, twisting, stretching, shearing, \
                               shearing_1, shearing_2, contact_radius, length, natural_curvature_1, \
                               natural_curvature_2, natural_twist, binding, displacement_x (y, z), rotation_x (y, z), \
                               obstacle_level, obstacle_x (y, z), obstacle_turns";
                let refuse =
                    || InputError::Name { field: "to".to_owned(), name: name.to_owned(), allowed: allowed.to_owned() };
                found.ok_or_else(refuse)?
            }
        };
        Ok(Self::Number { rod, which: which.to_vec() })
    }

    /// The rod of `natural_strains`, or of that and a name after a colon; `None` for another name.
    ///
    /// # Errors
    /// A rod that is not there.
    pub fn parse_table(model: &Model, text: &str) -> Result<Option<usize>, InputError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        if name != "natural_strains" {
            return Ok(None);
        }
        if rest.is_empty() { Ok(Some(0)) } else { Ok(Some(of_rod(model, text)?.1)) }
    }

    /// What messages call it.
    fn label(&self) -> String {
        match self {
            Self::Number { which, .. } => which.iter().map(|number| number.name()).collect::<Vec<_>>().join(" and "),
            Self::Load => "load".to_owned(),
            Self::Pressure { .. } => "pressure".to_owned(),
            Self::Link { .. } => "link".to_owned(),
            Self::Obstacle { which: ObstacleNumber::Turns, .. } => "obstacle_turns".to_owned(),
            Self::Obstacle { obstacle, .. } => format!("obstacle {obstacle}"),
            Self::Displacement { node, .. } => format!("displacement of node {} of rod {}", node.node, node.rod),
            Self::Rotation { node, .. } => format!("rotation of node {} of rod {}", node.node, node.rod),
        }
    }

    /// Refuses what is not there, and numbers that ramps refuse.
    pub(super) fn check(&self, engine: &Engine) -> Result<(), InputError> {
        let model = engine.model();
        let closed = |rod: usize| model.rods.get(rod).map(|rod| rod.closed);
        let is_node = |node: &NodeRef| model.rods.get(node.rod).is_some_and(|rod| node.node < rod.num_nodes());
        let is_way = |v: &Vec3| v.norm() > 0.0 && v.iter().all(|x| x.is_finite());
        // only what is held can be moved
        let is_moved = |node: &NodeRef, way: &Vec3, first: usize| {
            is_node(node) && (0..3).all(|k| way[k] == 0.0 || is_borne(engine, *node, first + k))
        };
        let fits = match self {
            Self::Load => true,
            Self::Number { rod, which } => !which.is_empty() && closed(*rod).is_some(),
            Self::Pressure { rod } => closed(*rod) == Some(true) && model.planar,
            Self::Link { rod } => closed(*rod) == Some(true) && !model.planar,
            Self::Obstacle { obstacle, which } => model.obstacles.get(*obstacle).is_some_and(|body| {
                let turns = *which == ObstacleNumber::Turns;
                (!turns || body.hinge.is_some()) && !(model.planar && *which == ObstacleNumber::Displacement(2))
            }),
            Self::Displacement { node, direction: way } => is_way(way) && is_moved(node, way, 0),
            Self::Rotation { node, axis: way } => is_way(way) && is_moved(node, way, 3),
        };
        if !fits {
            let reason = "is nothing that is prescribed in this model: links are those of closed rods in space, \
                          pressures those of closed rods in the plane, motions those that a support holds, turns of \
                          obstacles those about a hinge";
            return Err(InputError::inconsistent(self.label(), reason));
        }
        if let Self::Number { rod, which } = self {
            for number in which {
                let rod = &model.rods[*rod];
                rod.check_number(number.name(), *number, rod.number(*number))?;
            }
        }
        Ok(())
    }

    /// The engine's state with the parameter changed, nodes as they are.
    pub(super) fn changed(&self, engine: &Engine, by: f64) -> State {
        let mut state = engine.state().clone();
        let values = match self {
            Self::Number { rod, which } => {
                let value = |number: RodNumber| engine.model().rods[*rod].number(number) + by;
                which.iter().map(|&number| PrescribedValue::Number(*rod, number, value(number))).collect()
            }
            Self::Load => vec![PrescribedValue::Load(state.load_factor() + by)],
            Self::Pressure { rod } => vec![PrescribedValue::Pressure(*rod, state.pressures()[*rod] + by)],
            Self::Link { rod } => vec![PrescribedValue::Seam(*rod, state.seams()[*rod] + TAU * by)],
            Self::Obstacle { obstacle, which } => {
                vec![PrescribedValue::Obstacle(*obstacle, *which, state.placements()[*obstacle].get(*which) + by)]
            }
            Self::Displacement { .. } | Self::Rotation { .. } => Vec::new(),
        };
        state.prescribe(values);
        state
    }

    /// Whether it changes gaps or the contact law at fixed unknowns.
    fn touches(&self) -> bool {
        use RodNumber::{Bending1, Bending2, ContactRadius, Length};
        match self {
            Self::Number { which, .. } => {
                which.iter().any(|number| matches!(number, ContactRadius | Length | Bending1 | Bending2))
            }
            Self::Obstacle { .. } => true,
            _ => false,
        }
    }

    /// Whether elements and loads are linear in it: stiffnesses, natural strains, loads.
    fn is_linear(&self) -> bool {
        match self {
            Self::Number { which, .. } => which
                .iter()
                .all(|number| !matches!(number, RodNumber::ContactRadius | RodNumber::Length | RodNumber::Binding)),
            Self::Load | Self::Pressure { .. } => true,
            _ => false,
        }
    }

    /// Step of differences; `near` is that of lengths that change gaps \[L\], where there are any.
    pub(super) fn step(&self, engine: &Engine, near: Option<f64>) -> f64 {
        match self {
            Self::Number { rod, which } => {
                let rod = &engine.model().rods[*rod];
                let size = which.iter().map(|&number| rod.number(number).abs()).fold(0.0, f64::max);
                let step = match (&which[..], near) {
                    ([RodNumber::ContactRadius], Some(near)) => return near,
                    _ => STEP,
                };
                if size > 0.0 { step * size } else { step / rod.length }
            }
            Self::Load => 1.0,
            Self::Pressure { .. } => engine.scales.bending / engine.scales.length.powi(3),
            Self::Obstacle { which: ObstacleNumber::Turns, .. } => {
                near.map_or(TURN_STEP, |near| near / engine.scales.length)
            }
            Self::Obstacle { .. } => near.unwrap_or(STEP * engine.scales.lever),
            Self::Link { .. } | Self::Displacement { .. } | Self::Rotation { .. } => TURN_STEP,
        }
    }

    /// The motion of a node per unit.
    pub(super) fn motion(&self, engine: &Engine) -> Option<(usize, Vec3, Vec3)> {
        let index = |node: &NodeRef| engine.first_node[node.rod] + node.node;
        match self {
            Self::Displacement { node, direction } => Some((index(node), unit(direction), Vec3::zeros())),
            Self::Rotation { node, axis } => Some((index(node), Vec3::zeros(), unit(axis) * TAU)),
            _ => None,
        }
    }

    /// By how much a unit of it closes a gap, unknowns fixed.
    fn closing(&self, engine: &Engine, gap: &GapRate) -> f64 {
        match self {
            Self::Number { rod, which } if which[..] == [RodNumber::ContactRadius] => {
                gap.rods.iter().filter(|own| **own == Some(*rod)).count() as f64
            }
            Self::Obstacle { obstacle, which } => {
                let Some(push) = gap.surface.filter(|push| push.obstacle == *obstacle) else { return 0.0 };
                let hinge = engine.model().obstacles[*obstacle].hinge;
                match (which, hinge) {
                    (ObstacleNumber::Level, _) => push.sign,
                    (ObstacleNumber::Displacement(k), _) => push.normal[*k],
                    (ObstacleNumber::Turns, Some(hinge)) => {
                        let arm = push.at - engine.state().placements()[*obstacle].displacement - hinge.through;
                        TAU * unit(&hinge.axis).dot(&arm.cross(&push.normal))
                    }
                    (ObstacleNumber::Turns, None) => 0.0,
                }
            }
            _ => 0.0,
        }
    }
}

/// The obstacle after the colon of a name; the first one without.
fn obstacle_of(model: &Model, text: &str) -> Result<usize, InputError> {
    let name = text.split_once(':').map_or("", |(_, name)| name);
    if model.obstacles.is_empty() {
        return Err(InputError::inconsistent(text, "is a number of an obstacle, and the scene has none"));
    }
    let index = model.obstacles.iter().position(|own| name.is_empty() || own.name == name);
    let allowed = || model.obstacles.iter().map(|own| own.name.as_str()).collect::<Vec<_>>().join(", ");
    index.ok_or_else(|| InputError::Name { field: "obstacle".to_owned(), name: name.to_owned(), allowed: allowed() })
}

/// A central difference of fourth order of numbers.
fn difference(step: f64, mut at: impl FnMut(f64) -> Vec<f64>) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * step));
    (0..a.len()).map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step)).collect()
}

/// Does some work with offsets that are changed at their rates.
fn with_offsets<R>(engine: &mut Engine, (rates, by): (&[(usize, f64)], f64), work: impl FnOnce(&mut Engine) -> R) -> R {
    let before = engine.contact.offsets.clone();
    rates.iter().for_each(|(index, rate)| engine.contact.offsets.values[*index] += by * rate);
    let result = work(engine);
    engine.contact.offsets = before;
    result
}

/// Rates per unit of a parameter at fixed unknowns and offsets, or along a change of the offsets of points that stay
/// closed, which cancels.
#[derive(Default)]
struct Rate {
    /// Of the gradient of the potential.
    forces: Vec<f64>,
    /// Of the smallest gaps of [`ClosedPoint`](super::contact::ClosedPoint)s.
    gaps: Vec<f64>,
    /// Of the sum of the forces of contacts.
    contact_force: f64,
    /// Of the observable, if it is neither a reaction nor the contact force.
    value: f64,
}

/// The adjoint of an observable.
pub(super) struct Adjoint {
    /// ∂q/∂x.
    pub(super) gradient: Vec<f64>,
    /// λ.
    pub(super) motion: Vec<f64>,
    /// ν.
    pub(super) gaps: Vec<f64>,
}

/// K⁻¹a of the points of contact that stay closed, and the matrix bᵀK⁻¹a.
#[derive(Debug)]
pub(super) struct ClosedResponses {
    responses: Vec<Vec<f64>>,
    matrix: DMatrix<f64>,
}

impl EquilibriumTangent<'_> {
    /// dq/dp for each parameter.
    ///
    /// # Errors
    /// Observables and parameters that the model does not have.
    pub fn gradient(&mut self, of: &Observable, to: &[PrescribedNumber]) -> Result<Vec<f64>, RunError> {
        let adjoint = self.adjoint(of)?;
        let (mut all, mut here) = (Vec::new(), None);
        for parameter in to {
            let rate = self.rate(parameter, Some(of), &mut here)?;
            let explicit = self.explicit(of, parameter, (&adjoint, &rate))?;
            all.push(explicit - dot(&adjoint.motion, &rate.forces) - dot(&adjoint.gaps, &rate.gaps));
        }
        Ok(all)
    }

    pub(super) fn adjoint(&mut self, of: &Observable) -> Result<Adjoint, RunError> {
        self.check_contact_force(of)?;
        let gradient = self.gradient_of(of)?;
        let mut motion = self.linearised.solve(self.engine, &gradient);
        if self.closed.is_empty() {
            return Ok(Adjoint { gradient, motion, gaps: Vec::new() });
        }
        let count = self.closed.len();
        let by_offset: Vec<f64> = self.closed.iter().map(|point| of.by_offset(self.engine, point)).collect();
        let rhs = DVector::from_fn(count, |k, _| self.closed[k].push_along(&motion) + by_offset[k]);
        let responses = self.responses.take().unwrap_or_else(|| self.closed_responses());
        let gaps = responses.matrix.clone().lu().solve(&rhs);
        let gaps = gaps.ok_or_else(|| InputError::inconsistent("contact", "has points that depend on each other"))?;
        for (response, gap) in responses.responses.iter().zip(&gaps) {
            motion.iter_mut().zip(response).for_each(|(x, a)| *x -= gap * a);
        }
        // all observables share them
        self.responses = Some(responses);
        Ok(Adjoint { gradient, motion, gaps: gaps.iter().copied().collect() })
    }

    fn closed_responses(&mut self) -> ClosedResponses {
        let mut responses = Vec::new();
        for point in &self.closed {
            let mut forces = vec![0.0; 6 * self.engine.num_nodes()];
            for (node, six) in &point.smallest {
                (0..6).for_each(|k| forces[6 * node + k] += six[k]);
            }
            self.engine.give_to_masters(&mut forces);
            responses.push(self.linearised.solve(self.engine, &forces));
        }
        let count = self.closed.len();
        let matrix = DMatrix::from_fn(count, count, |j, k| self.closed[j].push_along(&responses[k]));
        ClosedResponses { responses, matrix }
    }

    /// Rates at fixed unknowns, with that of an observable if there is any. `here` keeps the gradient of the potential
    /// without contact from one parameter to the next.
    fn rate(
        &mut self,
        parameter: &PrescribedNumber,
        of: Option<&Observable>,
        here: &mut Option<Vec<f64>>,
    ) -> Result<Rate, RunError> {
        parameter.check(self.engine)?;
        if let Some(motion) = parameter.motion(self.engine) {
            let gaps = self.closed.iter().map(|point| along(&point.smallest, motion)).collect();
            return Ok(Rate { forces: self.driven(motion), gaps, ..Rate::default() });
        }
        let of = of.filter(|of| !matches!(of, Observable::Reaction { .. } | Observable::ContactForce));
        let is_charged = self.engine.model().electrostatics.is_some();
        let touches = parameter.touches() && (self.engine.contact.is_near() || is_charged);
        if parameter.is_linear() && !touches {
            return Ok(self.linear_rate(parameter, of, here));
        }
        let overlap = self.weakest_overlap();
        let apart = touches && self.closed.len() == self.contacts.len();
        let offsets = if apart { self.offsets_that_follow(parameter)? } else { Vec::new() };
        let keeps_overlaps = !offsets.is_empty();
        let near = overlap.map(|overlap| match keeps_overlaps {
            true => (STEP_OF_GAPS * overlap * self.engine.contact.min_radius).sqrt(),
            false => STEP_OF_GAPS * overlap,
        });
        let step = parameter.step(self.engine, near);
        let (num_closed, closed) = (self.closed.len(), &self.closed);
        let engine = &mut *self.engine;
        let mut failed: Option<RunError> = None;
        let mut sums = difference(step, |by| {
            let state = parameter.changed(engine, by);
            let value = of.map_or(0.0, |of| of.value(engine, &state));
            let with_contact = |engine: &Engine| {
                let residual = engine.residual(&state);
                let force = contact::total_force(engine, &residual);
                let mut all = residual.gradient.clone();
                all.extend(contact::gaps_of(engine, closed, &residual));
                all.push(force);
                all
            };
            let found = match touches {
                true => with_offsets(engine, (&offsets, by), |engine| {
                    engine.at_state(&state, with_contact).map_err(RunError::from).and_then(|all| Ok(all?))
                }),
                false => Ok(engine.residual_without_contact(&state).gradient),
            };
            let mut all = found.unwrap_or_else(|error| {
                failed = Some(error);
                Vec::new()
            });
            all.resize(6 * engine.num_nodes() + num_closed + 1, 0.0);
            all.push(value);
            all
        });
        if let Some(error) = failed {
            return Err(error);
        }
        let value = sums.pop().unwrap_or_default();
        let contact_force = sums.pop().unwrap_or_default();
        let gaps = sums.split_off(6 * self.engine.num_nodes());
        let mut rate = Rate { forces: sums, gaps, contact_force, value };
        self.add_changes(parameter, &mut rate);
        Ok(rate)
    }

    /// The changes of offsets with a parameter by which overlaps stay as they are at fixed unknowns; none where points
    /// share offsets. A rate of the potential's gradient along them has no part b, which cancels, and would be known to
    /// the rounding of gaps over the overlap only.
    fn offsets_that_follow(&mut self, parameter: &PrescribedNumber) -> Result<Vec<(usize, f64)>, RunError> {
        let near = self.weakest_overlap().map(|overlap| STEP_OF_GAPS * overlap);
        let step = parameter.step(self.engine, near);
        let (engine, closed) = (&mut *self.engine, &self.closed);
        let mut failed: Option<RunError> = None;
        let rates = difference(step, |by| {
            let state = parameter.changed(engine, by);
            let found = engine.at_state(&state, |engine| contact::gaps_of(engine, closed, &engine.residual(&state)));
            found.map_err(RunError::from).and_then(|all| Ok(all?)).unwrap_or_else(|error| {
                failed = Some(error);
                vec![0.0; closed.len()]
            })
        });
        if let Some(error) = failed {
            return Err(error);
        }
        let mut all = std::collections::BTreeMap::new();
        for (point, rate) in closed.iter().zip(rates) {
            for index in contact::offsets_of(engine, point) {
                if all.insert(index, rate).is_some() {
                    return Ok(Vec::new());
                }
            }
        }
        Ok(all.into_iter().collect())
    }

    /// Rates with respect to what elements and loads are linear in: one residual each.
    fn linear_rate(
        &mut self,
        parameter: &PrescribedNumber,
        of: Option<&Observable>,
        here: &mut Option<Vec<f64>>,
    ) -> Rate {
        let engine = &mut *self.engine;
        let step = parameter.step(engine, None);
        let state = engine.state().clone();
        let here = here.get_or_insert_with(|| engine.residual_without_contact(&state).gradient);
        let there = engine.residual_without_contact(&parameter.changed(engine, step / STEP)).gradient;
        let forces = here.iter().zip(&there).map(|(here, there)| (there - here) / (step / STEP)).collect();
        let value = of
            .filter(|of| of.depends_on_numbers())
            .map_or(0.0, |of| difference(step, |by| vec![of.value(engine, &parameter.changed(engine, by))])[0]);
        Rate { forces, gaps: vec![0.0; self.closed.len()], contact_force: 0.0, value }
    }

    /// What the changes of the chosen response add to rates by the law: of points that stay closed nothing, because
    /// their offsets take it up.
    fn add_changes(&self, parameter: &PrescribedNumber, rate: &mut Rate) {
        let mut forces = vec![0.0; rate.forces.len()];
        for gap in contact::changes(self.choice, &self.contacts, &self.rates) {
            if gap.is_point && !self.closed.is_empty() {
                continue;
            }
            let force = gap.stiffness * parameter.closing(self.engine, &gap);
            rate.contact_force += force;
            for (node, six) in &gap.rate {
                (0..6).for_each(|k| forces[6 * node + k] -= force * six[k]);
            }
        }
        self.engine.give_to_masters(&mut forces);
        rate.forces.iter_mut().zip(&forces).for_each(|(sum, force)| *sum += force);
    }

    /// Where derivatives hold on one side: contacts that carry next to nothing, beside others or beside the forces in
    /// the rods, and are about to open.
    pub fn one_sided(&self) -> Vec<String> {
        let of_rods = self.engine.scales.bending / self.engine.scales.length.powi(2);
        let largest = self.contacts.iter().map(|contact| contact.force).fold(of_rods, f64::max);
        let weak = self.contacts.iter().filter(|contact| contact.force < WEAK * largest).count();
        let note = || {
            format!(
                "{weak} contacts carry less than {WEAK:e} of the largest force, or of B/L², and are about to open: \
                 derivatives hold on the side on which they stay closed"
            )
        };
        if weak > 0 { vec![note()] } else { Vec::new() }
    }

    /// Overlap of the weakest contact by the law \[L\].
    fn weakest_overlap(&self) -> Option<f64> {
        let overlap = |(contact, rates): (&super::Touching, &Vec<GapRate>)| {
            contact.force / rates.iter().map(|gap| gap.stiffness).sum::<f64>()
        };
        let all = self.contacts.iter().zip(&self.rates).map(overlap);
        all.filter(|overlap| *overlap > 0.0 && overlap.is_finite()).min_by(f64::total_cmp)
    }

    /// The forces of the tangent against a motion of one node.
    pub(super) fn driven(&mut self, motion: (usize, Vec3, Vec3)) -> Vec<f64> {
        let mut forces = vec![0.0; 6 * self.engine.num_nodes()];
        for gap in contact::changes(self.choice, &self.contacts, &self.rates) {
            let closing = gap.stiffness * along(&gap.rate, motion);
            if closing != 0.0 {
                for (node, six) in &gap.rate {
                    (0..6).for_each(|k| forces[6 * node + k] += closing * six[k]);
                }
            }
        }
        self.engine.give_to_masters(&mut forces);
        let by_law = self.linearised.driven(self.engine, motion);
        forces.iter_mut().zip(by_law).for_each(|(sum, force)| *sum += force);
        forces
    }

    /// ∂r/∂seam of a closed rod \[F·L\] per turn.
    pub(super) fn rate_of_link(&mut self, rod: usize) -> Result<Vec<f64>, RunError> {
        Ok(self.rate(&PrescribedNumber::Link { rod }, None, &mut None)?.forces)
    }

    /// ∂q/∂p at fixed unknowns.
    fn explicit(
        &mut self,
        of: &Observable,
        parameter: &PrescribedNumber,
        (adjoint, rate): (&Adjoint, &Rate),
    ) -> Result<f64, RunError> {
        if let Some(motion) = parameter.motion(self.engine) {
            let (node, displacement, rotation) = motion;
            let six = [displacement.x, displacement.y, displacement.z, rotation.x, rotation.y, rotation.z];
            return Ok(dot(&adjoint.gradient[6 * node..6 * node + 6], &six));
        }
        Ok(match of {
            Observable::Reaction { node, component } => rate.forces[6 * self.engine.index(*node) + component],
            Observable::ContactForce => rate.contact_force,
            _ => rate.value,
        })
    }
}

/// Change of a gap with the motion of a node.
fn along(rate: &[(usize, [f64; 6])], (node, displacement, rotation): (usize, Vec3, Vec3)) -> f64 {
    let of_six = |six: &[f64; 6]| (0..3).map(|k| six[k] * displacement[k] + six[3 + k] * rotation[k]).sum::<f64>();
    rate.iter().filter(|(own, _)| *own == node).map(|(_, six)| of_six(six)).sum()
}

impl contact::ClosedPoint {
    /// b·δx.
    fn push_along(&self, motion: &[f64]) -> f64 {
        self.push.iter().map(|(node, six)| dot(six, &motion[6 * node..6 * node + 6])).sum()
    }
}
