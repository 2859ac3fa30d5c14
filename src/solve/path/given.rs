//! The problem as it was given, for those who compare states with it.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use crate::math::{Quat, Vec3};
use crate::scene::{Model, NodeRef, Stage, SupportChange};
use crate::solve::options::Options;
use crate::solve::problem::engine::Engine;
use crate::solve::search::newton::NewtonOptions;

/// The problem as it was given, and what stages have come to hold, for those who compare states with it.
#[derive(Debug, Clone, Default)]
pub struct Given {
    /// The model before any stage.
    pub model: Model,
    /// All stages.
    pub stages: Vec<Stage>,
    /// Position \[L\] and frame of nodes when a stage began to hold them ([`SupportChange::Hold`]), last.
    pub held: BTreeMap<NodeRef, (Vec3, Quat)>,
    /// Tolerance of increments that the solver was given, see [`NewtonOptions`](crate::solve::NewtonOptions).
    pub tol_increment: f64,
    /// Whether only stable equilibria are accepted.
    pub only_stable: bool,
    /// Knots and links of the shapes as given, for observers that have measured them.
    pub(crate) topology: OnceLock<GivenTopology>,
}

/// Knots (rod, determinant, |Δ(exp(2πi/3))|, name) and linking numbers (rods, link) of the shapes as given.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct GivenTopology {
    pub(crate) knots: Vec<(usize, f64, f64, String)>,
    pub(crate) linking: Vec<([usize; 2], f64)>,
    /// Turns of open rods about each other.
    pub(crate) turns: Vec<([usize; 2], f64)>,
}

impl Given {
    pub(super) fn new(model: &Model, stages: &[Stage], options: &Options) -> Self {
        let (model, stages) = (model.clone(), stages.to_vec());
        let NewtonOptions { tol_increment, stable_only, .. } = options.newton;
        let only_stable = stable_only && options.leave_unstable;
        Self { model, stages, held: BTreeMap::new(), tol_increment, only_stable, topology: OnceLock::new() }
    }

    /// Notes where nodes are that a stage holds from now on.
    pub(super) fn note_held(&mut self, changes: &[SupportChange], engine: &Engine) {
        for change in changes {
            let SupportChange::Hold(support) = change else { continue };
            for node in self.model.joined_nodes(support.node) {
                let index = engine.first_node[node.rod] + node.node;
                self.held.insert(node, (engine.state().positions()[index], engine.state().frames()[index]));
            }
        }
    }
}
