//! Numbers of a state that are differentiated: their gradients by the unknowns, and what they are at fixed unknowns.

use std::f64::consts::TAU;

use super::{ContactResponse, EquilibriumTangent, contact};
use crate::error::InputError;
use crate::math::Vec3;
use crate::rod::element::{Material, Strain, evaluate, raw_strains};
use crate::scene::{Model, NodeRef};
use crate::solve::problem::engine::Engine;
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
    /// From a name: `energy`, `contact_force`; `twist`, `writhe`, `extension`, `seam_moment` of the first rod or, after
    /// a colon, of the rod of a name (`writhe:ring`); `position_x`, `position_y`, `position_z` of a node, `force_x`,
    /// `force_y`, `force_z`, `moment_x`, `moment_y`, `moment_z` of the support of a node, after the rod
    /// (`force_z:rod:end`: `start`, `end` or its index).
    ///
    /// # Errors
    /// Another name.
    pub fn parse(model: &Model, text: &str) -> Result<Self, InputError> {
        let name = text.split(':').next().unwrap_or(text);
        let axis = |prefix: &str| "xyz".find(name.strip_prefix(prefix)?).filter(|_| name.len() == prefix.len() + 1);
        if let Some(axis) = axis("position_") {
            return Ok(Self::Position { node: of_node(model, text)?, axis });
        }
        if let Some(component) = axis("force_").or_else(|| Some(3 + axis("moment_")?)) {
            return Ok(Self::Reaction { node: of_node(model, text)?, component });
        }
        let (name, rod) = of_rod(model, text)?;
        Ok(match name {
            "energy" => Self::Energy,
            "contact_force" => Self::ContactForce,
            "twist" => Self::Twist { rod },
            "writhe" => Self::Writhe { rod },
            "extension" => Self::Extension { rod },
            "seam_moment" => Self::SeamMoment { rod },
            _ => {
                let allowed =
                    "energy, contact_force, twist, writhe, extension, seam_moment, position_x (y, z), force_x \
                               (y, z), moment_x (y, z)"
                        .to_owned();
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
        if let Self::Reaction { node, component } = self
            && is_node(node)
        {
            let supported = |at: &NodeRef| engine.model().supports.iter().any(|support| support.node == *at);
            let shared = engine.model().joined_nodes(*node).iter().filter(|at| supported(at)).count() > 1;
            let reason = "is shared by supports of joined nodes: let one of them bear it";
            let label = || format!("the reaction at node {} of rod {}", node.node, node.rod);
            if shared {
                return Err(InputError::inconsistent(label(), reason));
            }
            if *component < 6 && !is_borne(engine, *node, *component) {
                let way = ["force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"][*component];
                return Err(InputError::inconsistent(label(), format!("has no {way}: no support holds it there")));
            }
        }
        let reason = "is no number of this model: twist is that of rods in space, writhe and seam moment are those of \
                      closed rods, extension is that of open ones";
        if fits { Ok(()) } else { Err(InputError::inconsistent(self.label(), reason)) }
    }

    /// What messages call it.
    pub(super) fn label(&self) -> &'static str {
        match self {
            Self::Energy => "energy",
            Self::Twist { .. } => "twist",
            Self::Writhe { .. } => "writhe",
            Self::Extension { .. } => "extension",
            Self::Position { .. } => "position",
            Self::SeamMoment { .. } => "seam_moment",
            Self::Reaction { .. } => "the reaction",
            Self::ContactForce => "contact_force",
        }
    }

    /// Its rate with the offset of a point of contact that stays closed, unknowns fixed.
    pub(super) fn by_offset(&self, engine: &Engine, point: &contact::ClosedPoint) -> f64 {
        match self {
            Self::ContactForce => point.stiffness,
            Self::Reaction { node, component } => {
                let at = engine.index(*node);
                -point.push.iter().filter(|(node, _)| *node == at).map(|(_, six)| six[*component]).sum::<f64>()
            }
            _ => 0.0,
        }
    }

    /// Whether its value depends on numbers of rods and loads at fixed unknowns, besides what contact and reactions do.
    pub(super) fn depends_on_numbers(&self) -> bool {
        matches!(self, Self::Energy | Self::SeamMoment { .. } | Self::Twist { .. } | Self::Writhe { .. })
    }

    /// Value at a state that differs from the engine's in what is prescribed alone, without what depends on contact.
    pub(super) fn value(&self, engine: &mut Engine, state: &State) -> f64 {
        match self {
            Self::Energy => engine.elastic_residual(state).potential.elastic.total(),
            Self::Twist { rod } => twist(engine, state, *rod),
            Self::Writhe { rod } => state.seams()[*rod] / TAU - twist(engine, state, *rod),
            Self::SeamMoment { rod } => engine.elastic_residual(state).seam_moments[*rod],
            Self::Extension { rod } => {
                let nodes = engine.nodes(*rod);
                state.chord(nodes.start, nodes.end - 1).norm()
            }
            Self::Position { node, axis } => state.positions()[engine.first_node[node.rod] + node.node][*axis],
            // their changes are those of residuals
            Self::Reaction { .. } | Self::ContactForce => 0.0,
        }
    }
}

/// Whether a support bears a component, 0 to 5, at a node; of a hinge the rotations that it holds are about no axis of
/// space.
pub(super) fn is_borne(engine: &Engine, node: NodeRef, component: usize) -> bool {
    let at = engine.index(node);
    component >= 3 && engine.is_swivel(at) || engine.is_held(at, component)
}

/// A name and the rod after its colon; the first rod without one.
pub(super) fn of_rod<'a>(model: &Model, text: &'a str) -> Result<(&'a str, usize), InputError> {
    let Some((name, rod)) = text.split_once(':') else { return Ok((text, 0)) };
    let index = model.rods.iter().position(|own| own.name == rod);
    let allowed = || model.rods.iter().map(|rod| rod.name.as_str()).collect::<Vec<_>>().join(", ");
    let refuse = || InputError::Name { field: "rod".to_owned(), name: rod.to_owned(), allowed: allowed() };
    Ok((name, index.ok_or_else(refuse)?))
}

/// The node of a name such as `force_z:rod:end`: `start`, `end` or its index, after the rod.
pub(super) fn of_node(model: &Model, text: &str) -> Result<NodeRef, InputError> {
    let (rest, node) = text.rsplit_once(':').unwrap_or((text, ""));
    let (_, rod) = of_rod(model, rest)?;
    let count = model.rods.get(rod).map_or(0, crate::rod::Rod::num_nodes);
    let index = match node {
        "start" => Some(0),
        "end" => count.checked_sub(1),
        index => index.parse().ok().filter(|index| *index < count),
    };
    let allowed = || "start, end, or the index of a node, after the rod: name:rod:end".to_owned();
    let refuse = || InputError::Name { field: "node".to_owned(), name: node.to_owned(), allowed: allowed() };
    Ok(NodeRef { rod, node: index.ok_or_else(refuse)? })
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
        let engine = &*self.engine;
        let index = |node: &NodeRef| engine.index(*node);
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
                return Ok(self.rate_of_link(*rod)?.into_iter().map(|x| x / TAU).collect());
            }
            Observable::Reaction { node, component } => {
                let (at, mut unit) = (index(node), [Vec3::zeros(); 2]);
                unit[component / 3][component % 3] = 1.0;
                let [along, about] = unit;
                // a moment about axes fixed in space: its rate with the node's own rotation δθ is that of the gradient
                // by rotation vectors, which is symmetric, and ½ δθ × m
                let moment = Vec3::from_column_slice(&self.linearised.residual.gradient[6 * at + 3..6 * at + 6]);
                out[6 * at + 3..6 * at + 6].copy_from_slice((0.5 * moment.cross(&about)).as_slice());
                let driven = self.driven((at, along, about));
                self.engine.give_to_masters(&mut out);
                out.iter_mut().zip(driven).for_each(|(sum, force)| *sum += force);
                return Ok(out);
            }
            Observable::ContactForce => {
                for gap in contact::responses(self.choice, &self.contacts, &self.rates) {
                    for (node, six) in &gap.rate {
                        (0..6).for_each(|k| out[6 * node + k] -= gap.stiffness * six[k]);
                    }
                }
            }
        }
        self.engine.give_to_masters(&mut out);
        Ok(out)
    }

    /// Refuses contact forces of a tangent in which contact has none.
    pub(super) fn check_contact_force(&self, of: &Observable) -> Result<(), InputError> {
        let reason = "contact forces do not change where contacts are free: lock them, or take the law's";
        let bad = *of == Observable::ContactForce && self.choice == ContactResponse::Free;
        if bad { Err(InputError::inconsistent("contact_force", reason)) } else { Ok(()) }
    }
}
