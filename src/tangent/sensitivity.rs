//! Sensitivities: dq/dp of observables q with respect to what is prescribed, p, by the adjoint.
//!
//! ```text
//! K δx + ∂r/∂p δp = 0        dq/dp = ∂q/∂p − λ·∂r/∂p,  K λ = ∂q/∂x
//! ```
//!
//! One solve an observable gives its derivatives with respect to any number of parameters. r is the gradient of the
//! potential. K is that of the chosen [`ContactResponse`]: [`ContactResponse::Locked`] differentiates the equilibrium under hard
//! contact, gaps with force staying closed; [`ContactResponse::ByLaw`] that under a penalty. Where a contact is about to
//! open or to close, the derivative holds on one side.
//!
//! ∂r/∂p and ∂q/∂p at fixed unknowns are central differences of fourth order of exact residuals, in which dead loads
//! and stiffnesses are linear; motions of supports are columns of the tangent; radii and obstacles change gaps by as
//! much as they move.

use std::f64::consts::TAU;

use super::observables::{Observable, of_rod};
use super::{ContactResponse, EquilibriumTangent, contact};
use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::RodNumber;
use crate::scene::model::unit;
use crate::scene::{ContactLaw, Model, NodeRef};
use crate::solve::problem::engine::{Engine, give_to_masters};
use crate::solve::problem::linearised::dot;
use crate::solve::{RunError, State};

/// Relative step of numbers of rods: residuals are linear or quadratic in them.
const STEP: f64 = 1e-3;
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
    /// Level of an obstacle \[L\]: the height of a plane along its normal, the radius of others.
    Level {
        /// Obstacle index.
        obstacle: usize,
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
    /// From a name: `load`, or one of `bending`, `bending_1`, `bending_2`, `twisting`, `stretching`, `shearing`,
    /// `contact_radius`, `length`, `natural_curvature_1`, `natural_curvature_2`, `natural_twist`, `link`, `pressure`,
    /// of the first rod or, after a colon, of the rod of a name.
    ///
    /// # Errors
    /// Another name.
    pub fn parse(model: &Model, text: &str) -> Result<Self, InputError> {
        use RodNumber::{
            Bending1, Bending2, ContactRadius, Curvature1, Curvature2, Length, Shearing1, Shearing2, Stretching, Twist,
            Twisting,
        };
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
                ];
                let found = single.into_iter().find(|number| number[0].name() == name);
                let allowed = "load, link, pressure, bending, bending_1, bending_2, twisting, stretching, shearing, \
                               contact_radius, length, natural_curvature_1, natural_curvature_2, natural_twist";
                let refuse =
                    || InputError::Name { field: "to".to_owned(), name: name.to_owned(), allowed: allowed.to_owned() };
                found.ok_or_else(refuse)?
            }
        };
        Ok(Self::Number { rod, which: which.to_vec() })
    }

    /// Refuses what is not there, and numbers that ramps refuse.
    fn check(&self, engine: &Engine) -> Result<(), InputError> {
        let model = engine.model();
        let closed = |rod: usize| model.rods.get(rod).map(|rod| rod.closed);
        let is_node = |node: &NodeRef| model.rods.get(node.rod).is_some_and(|rod| node.node < rod.num_nodes());
        let is_way = |v: &Vec3| v.norm() > 0.0 && v.iter().all(|x| x.is_finite());
        let fits = match self {
            Self::Load => true,
            Self::Number { rod, which } => !which.is_empty() && closed(*rod).is_some(),
            Self::Pressure { rod } => closed(*rod) == Some(true) && model.planar,
            Self::Link { rod } => closed(*rod) == Some(true) && !model.planar,
            Self::Level { obstacle } => *obstacle < model.obstacles.len(),
            Self::Displacement { node, direction: way } | Self::Rotation { node, axis: way } => {
                is_node(node) && is_way(way)
            }
        };
        if !fits {
            return Err(InputError::inconsistent(format!("{self:?}"), "is nothing that is prescribed in this model"));
        }
        if let Self::Number { rod, which } = self {
            for number in which {
                let rod = &model.rods[*rod];
                rod.check_number(number.name(), *number, rod.number(*number))?;
            }
            let is_gap = which.contains(&RodNumber::ContactRadius) && which.len() > 1;
            let is_length =
                which.contains(&RodNumber::Length) && engine.contact.as_ref().is_some_and(|side| side.is_near());
            if is_gap || is_length {
                let reason = "a contact radius is differentiated alone, a length only where nothing is near contact";
                return Err(InputError::inconsistent(format!("{self:?}"), reason));
            }
        }
        Ok(())
    }

    /// The engine's state with the parameter changed, nodes as they are.
    fn changed(&self, engine: &Engine, by: f64) -> State {
        let mut state = engine.state().clone();
        match self {
            Self::Number { rod, which } => {
                let value = |number: RodNumber| engine.model().rods[*rod].number(number) + by;
                state.numbers.extend(which.iter().map(|&number| ((*rod, number), value(number))));
            }
            Self::Load => state.load_factor += by,
            Self::Pressure { rod } => state.pressures[*rod] += by,
            Self::Link { rod } => state.seams[*rod] += TAU * by,
            Self::Level { .. } | Self::Displacement { .. } | Self::Rotation { .. } => {}
        }
        state
    }

    fn step(&self, engine: &Engine) -> f64 {
        match self {
            Self::Number { rod, which } => {
                let rod = &engine.model().rods[*rod];
                let size = which.iter().map(|&number| rod.number(number).abs()).fold(0.0, f64::max);
                STEP * if size > 0.0 { size } else { 1.0 / rod.length }
            }
            Self::Load => 1.0,
            Self::Pressure { .. } => engine.scales.bending / engine.scales.length.powi(3),
            _ => TURN_STEP,
        }
    }

    /// The motion of a node per unit.
    fn motion(&self, engine: &Engine) -> Option<(usize, Vec3, Vec3)> {
        let index = |node: &NodeRef| engine.first_node[node.rod] + node.node;
        match self {
            Self::Displacement { node, direction } => Some((index(node), unit(direction), Vec3::zeros())),
            Self::Rotation { node, axis } => Some((index(node), Vec3::zeros(), unit(axis) * TAU)),
            _ => None,
        }
    }

    /// The rod whose radius it is, or the obstacle whose level.
    fn closes(&self) -> (Option<usize>, Option<usize>) {
        match self {
            Self::Number { rod, which } if which[..] == [RodNumber::ContactRadius] => (Some(*rod), None),
            Self::Level { obstacle } => (None, Some(*obstacle)),
            _ => (None, None),
        }
    }

    fn changes_gaps(&self) -> bool {
        self.closes() != (None, None)
    }
}

/// A central difference of fourth order of numbers.
fn difference(step: f64, mut at: impl FnMut(f64) -> Vec<f64>) -> Vec<f64> {
    let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(k * step));
    (0..a.len()).map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step)).collect()
}

impl EquilibriumTangent<'_> {
    /// dq/dp for each parameter.
    ///
    /// # Errors
    /// Observables and parameters that the model does not have; a contact radius that varies, a length where there is
    /// contact.
    pub fn gradient(&mut self, of: &Observable, to: &[PrescribedNumber]) -> Result<Vec<f64>, RunError> {
        self.check_contact_force(of)?;
        let gradient = self.gradient_of(of)?;
        let adjoint = self.linearised.solve(&gradient);
        let mut all = Vec::new();
        for parameter in to {
            let rate = self.rate(parameter)?;
            all.push(self.explicit(of, parameter, &gradient)? - dot(&adjoint, &rate));
        }
        Ok(all)
    }

    /// ∂r/∂p at fixed unknowns.
    pub(super) fn rate(&mut self, parameter: &PrescribedNumber) -> Result<Vec<f64>, RunError> {
        parameter.check(self.engine)?;
        if let Some(motion) = parameter.motion(self.engine) {
            return Ok(self.linearised.driven(self.engine, motion));
        }
        if parameter.changes_gaps() {
            let mut rate = self.rate_of_gaps(parameter);
            self.add_stiffening(parameter, &mut rate);
            return Ok(rate);
        }
        let step = parameter.step(self.engine);
        let engine = &mut *self.engine;
        let mut rate = difference(step, |by| {
            let state = parameter.changed(engine, by);
            engine.residual_without_contact(&state).gradient
        });
        self.add_stiffening(parameter, &mut rate);
        Ok(rate)
    }

    /// Forces of contact where gaps close by themselves.
    fn rate_of_gaps(&self, parameter: &PrescribedNumber) -> Vec<f64> {
        let (thicker, raised) = parameter.closes();
        let mut out = vec![0.0; 6 * self.engine.num_nodes()];
        for gap in contact::responses(self.choice, &self.contacts, &self.rates) {
            let force = -gap.stiffness * gap.closing(thicker, raised);
            for (node, six) in &gap.rate {
                (0..6).for_each(|k| out[6 * node + k] += force * six[k]);
            }
        }
        give_to_masters(&mut out, &self.engine.master);
        out
    }

    /// ∂ln κ/∂p: a penalty κε⁴/B changes with the stiffness and the radius of the rods.
    fn stiffening(&mut self, parameter: &PrescribedNumber) -> f64 {
        let is_penalty = matches!(self.engine.model().contact.law, ContactLaw::Penalty { .. });
        match parameter {
            PrescribedNumber::Number { rod, which } if is_penalty && self.choice == ContactResponse::ByLaw => {
                self.engine.slope_of_contact_stiffness(*rod, which)
            }
            _ => 0.0,
        }
    }

    /// Adds the forces of contact whose stiffness changes: they are proportional to it.
    fn add_stiffening(&mut self, parameter: &PrescribedNumber, rate: &mut [f64]) {
        let slope = self.stiffening(parameter);
        for (out, force) in rate.iter_mut().zip(&self.linearised.residual.contact_gradient) {
            *out += slope * force;
        }
    }

    /// ∂q/∂p at fixed unknowns.
    fn explicit(&mut self, of: &Observable, parameter: &PrescribedNumber, gradient: &[f64]) -> Result<f64, RunError> {
        if let Some((node, displacement, rotation)) = parameter.motion(self.engine) {
            let six = [displacement.x, displacement.y, displacement.z, rotation.x, rotation.y, rotation.z];
            return Ok(dot(&gradient[6 * node..6 * node + 6], &six));
        }
        if let Observable::Reaction { node, component } = of {
            let at = 6 * (self.engine.first_node[node.rod] + node.node) + component;
            return Ok(self.rate(parameter)?[at]);
        }
        if *of == Observable::ContactForce {
            let (thicker, raised) = parameter.closes();
            let gaps = contact::responses(self.choice, &self.contacts, &self.rates);
            let closed: f64 = gaps.iter().map(|gap| gap.stiffness * gap.closing(thicker, raised)).sum();
            return Ok(closed + self.stiffening(parameter) * self.value(of)?);
        }
        if parameter.changes_gaps() {
            return Ok(0.0);
        }
        let (step, engine) = (parameter.step(self.engine), &mut *self.engine);
        let found = difference(step, |by| {
            let state = parameter.changed(engine, by);
            vec![of.value(engine, &state)]
        });
        Ok(found[0])
    }
}
