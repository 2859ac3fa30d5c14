//! Numbers of a state that are differentiated: their gradients by the unknowns, and what they are at fixed unknowns.

use std::f64::consts::TAU;

use super::{ContactResponse, EquilibriumTangent, contact};
use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::element::{Material, Strain, evaluate, raw_strains};
use crate::scene::{Model, NodeRef};
use crate::solve::problem::engine::{Engine, give_to_masters};
use crate::solve::{RunError, State};

/// A number of a state.
#[derive(Debug, Clone, PartialEq)]
pub enum Observable {
    /// Elastic energy of all rods \[F·L\].
    Energy,
    /// Twist of a rod ∫K3 ds/2π, turns.
    Twist {
        /// Rod index.
        rod: usize,
    },
    /// Writhe of a closed rod: link − twist, turns.
    Writhe {
        /// Rod index.
        rod: usize,
    },
    /// Distance of the ends of an open rod \[L\].
    Extension {
        /// Rod index.
        rod: usize,
    },
    /// A component of a node's position \[L\].
    Position {
        /// The node.
        node: NodeRef,
        /// 0, 1, 2: x, y, z.
        axis: usize,
    },
    /// Twisting moment at the seam of a closed rod \[F·L\].
    SeamMoment {
        /// Rod index.
        rod: usize,
    },
    /// A component of what a support bears \[F\], \[F·L\].
    Reaction {
        /// The supported node.
        node: NodeRef,
        /// 0 to 5: force along x, y, z, moment about x, y, z.
        component: usize,
    },
    /// Sum of the forces of all contacts \[F\].
    ContactForce,
}

impl Observable {
    /// From a name: `energy`, `contact_force`, or one of `twist`, `writhe`, `extension`, `seam_moment`, of the first
    /// rod or, after a colon, of the rod of a name (`writhe:ring`).
    ///
    /// # Errors
    /// Another name.
    pub fn parse(model: &Model, text: &str) -> Result<Self, InputError> {
        let (name, rod) = of_rod(model, text)?;
        Ok(match name {
            "energy" => Self::Energy,
            "contact_force" => Self::ContactForce,
            "twist" => Self::Twist { rod },
            "writhe" => Self::Writhe { rod },
            "extension" => Self::Extension { rod },
            "seam_moment" => Self::SeamMoment { rod },
            _ => {
                let allowed = "energy, contact_force, twist, writhe, extension, seam_moment".to_owned();
                return Err(InputError::Name { field: "of".to_owned(), name: name.to_owned(), allowed });
            }
        })
    }

    /// Refuses rods and nodes that are not there, and numbers that they do not have.
    fn check(&self, engine: &Engine) -> Result<(), InputError> {
        let rods = &engine.model().rods;
        let closed = |rod: usize| rods.get(rod).map(|rod| rod.closed);
        let is_node = |node: &NodeRef| rods.get(node.rod).is_some_and(|rod| node.node < rod.num_nodes());
        let fits = match self {
            Self::Energy | Self::ContactForce => true,
            Self::Twist { rod } => closed(*rod).is_some() && !engine.model().planar,
            Self::Writhe { rod } | Self::SeamMoment { rod } => closed(*rod) == Some(true),
            Self::Extension { rod } => closed(*rod) == Some(false),
            Self::Position { node, axis } => is_node(node) && *axis < 3,
            Self::Reaction { node, component } => is_node(node) && *component < 6,
        };
        let reason = "is no number of this model: twist is that of rods in space, writhe and seam moment are those of \
                      closed rods, extension is that of open ones";
        if fits { Ok(()) } else { Err(InputError::inconsistent(format!("{self:?}"), reason)) }
    }

    /// Value at a state that differs from the engine's in what is prescribed alone, without what depends on contact.
    pub(super) fn value(&self, engine: &mut Engine, state: &State) -> f64 {
        match self {
            Self::Energy => engine.elastic_residual(state).potential.elastic.iter().sum(),
            Self::Twist { rod } => twist(engine, state, *rod),
            Self::Writhe { rod } => state.seams[*rod] / TAU - twist(engine, state, *rod),
            Self::SeamMoment { rod } => engine.elastic_residual(state).seam_moments[*rod],
            Self::Extension { rod } => {
                let nodes = engine.nodes(*rod);
                state.chord(nodes.start, nodes.end - 1).norm()
            }
            Self::Position { node, axis } => state.positions[engine.first_node[node.rod] + node.node][*axis],
            // their changes are those of residuals
            Self::Reaction { .. } | Self::ContactForce => 0.0,
        }
    }
}

/// A name and the rod after its colon; the first rod without one.
pub(super) fn of_rod<'a>(model: &Model, text: &'a str) -> Result<(&'a str, usize), InputError> {
    let Some((name, rod)) = text.split_once(':') else { return Ok((text, 0)) };
    let index = model.rods.iter().position(|own| own.name == rod);
    let allowed = || model.rods.iter().map(|rod| rod.name.as_str()).collect::<Vec<_>>().join(", ");
    let refuse = || InputError::Name { field: "rod".to_owned(), name: rod.to_owned(), allowed: allowed() };
    Ok((name, index.ok_or_else(refuse)?))
}

fn twist(engine: &Engine, state: &State, rod: usize) -> f64 {
    let of_element = |element: &crate::solve::problem::engine::Element| {
        let nodes = engine.element_nodes(state, element);
        let (table, length) = (engine.table(rod), engine.element_length(rod));
        let strains = raw_strains(table, &nodes, length);
        let points = strains.iter().zip(table.rule.weights);
        points.map(|(strain, weight)| strain[5] * weight * length).sum::<f64>()
    };
    engine.elements.iter().filter(|element| element.rod == rod).map(of_element).sum::<f64>() / TAU
}

/// ∂twist/∂x: the residual of elements that bear a unit twisting moment.
fn twist_gradient(engine: &Engine, rod: usize) -> Vec<f64> {
    const TWISTING: Strain = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let mut out = vec![0.0; 6 * engine.num_nodes()];
    for (e, element) in engine.elements.iter().enumerate().filter(|(_, element)| element.rod == rod) {
        let nodes = engine.element_nodes(engine.state(), element);
        let mut body = engine.body(e);
        let raw = raw_strains(body.table, &nodes, body.length);
        let reference = raw.map(|strain| std::array::from_fn(|i| strain[i] - TWISTING[i]));
        (body.material, body.plane) = (Material::Diagonal(&TWISTING), None);
        let residual = evaluate(&body, &nodes, &reference, None, None).residual;
        let count = engine.model().rods[rod].order + 1;
        for (node, six) in element.nodes[..count].iter().zip(residual.chunks_exact(6)) {
            (0..6).for_each(|k| out[6 * node + k] += six[k] / TAU);
        }
    }
    out
}

impl EquilibriumTangent<'_> {
    /// Value of an observable at the equilibrium.
    ///
    /// # Errors
    /// An observable that the model does not have.
    pub fn value(&mut self, of: &Observable) -> Result<f64, InputError> {
        of.check(self.engine)?;
        let state = self.engine.state().clone();
        Ok(match of {
            Observable::ContactForce => self.contacts.iter().map(|contact| contact.force).sum(),
            Observable::Reaction { node, component } => {
                let node = self.engine.first_node[node.rod] + node.node;
                self.linearised.residual.gradient[6 * node + component]
            }
            other => other.value(self.engine, &state),
        })
    }

    /// ∂q/∂x, six numbers a node, supported unknowns included.
    pub(super) fn gradient_of(&mut self, of: &Observable) -> Result<Vec<f64>, RunError> {
        of.check(self.engine)?;
        let state = self.engine.state().clone();
        let index = |node: &NodeRef| self.engine.first_node[node.rod] + node.node;
        let mut out = vec![0.0; 6 * self.engine.num_nodes()];
        match of {
            Observable::Energy => return Ok(self.engine.elastic_residual(&state).gradient),
            Observable::Twist { rod } => out = twist_gradient(self.engine, *rod),
            Observable::Writhe { rod } => {
                out = twist_gradient(self.engine, *rod);
                out.iter_mut().for_each(|x| *x = -*x);
            }
            Observable::Extension { rod } => {
                let nodes = self.engine.nodes(*rod);
                let along: Vec3 = state.chord(nodes.start, nodes.end - 1).normalize();
                for k in 0..3 {
                    out[6 * (nodes.end - 1) + k] = along[k];
                    out[6 * nodes.start + k] = -along[k];
                }
            }
            Observable::Position { node, axis } => out[6 * index(node) + axis] = 1.0,
            Observable::SeamMoment { rod } => {
                // M = ∂Π/∂seam, so that ∂M/∂x = ∂²Π/∂x∂seam
                let rate = self.rate(&super::PrescribedNumber::Link { rod: *rod })?;
                return Ok(rate.into_iter().map(|x| x / TAU).collect());
            }
            Observable::Reaction { node, component } => {
                let mut unit = [Vec3::zeros(); 2];
                unit[component / 3][component % 3] = 1.0;
                return Ok(self.linearised.driven(self.engine, (index(node), unit[0], unit[1])));
            }
            Observable::ContactForce => {
                for gap in contact::responses(self.choice, &self.contacts, &self.rates) {
                    for (node, six) in &gap.rate {
                        (0..6).for_each(|k| out[6 * node + k] -= gap.stiffness * six[k]);
                    }
                }
            }
        }
        give_to_masters(&mut out, &self.engine.master);
        Ok(out)
    }

    /// Refuses contact forces of a tangent in which contact has none.
    pub(super) fn check_contact_force(&self, of: &Observable) -> Result<(), InputError> {
        let reason = "contact forces do not change where contacts are free: lock them, or take the law's";
        let bad = *of == Observable::ContactForce && self.choice == ContactResponse::Free;
        if bad { Err(InputError::inconsistent("contact_force", reason)) } else { Ok(()) }
    }
}
