//! The same state on a finer mesh, or under a harder contact law, for estimates of the error.

use crate::contact::law::Law;
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::Rod;
use crate::scene::{Joint, Model, NodeLoad, NodeRef, Obstacle, Support};
use crate::solve::load_step::guess::Ahead;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::StepReport;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::zero_energy::ZeroEnergyModes;
use crate::solve::search::newton::relative_residual;

impl Model {
    /// The same problem on `factor` times the elements of every rod, see [`Rod::refined`](crate::rod::Rod::refined).
    ///
    /// # Errors
    /// As there.
    pub fn refined(&self, factor: usize) -> Result<Self, InputError> {
        let rods = self.rods.iter().map(|rod| rod.refined(factor)).collect::<Result<_, _>>()?;
        Ok(self.with_rods(rods, |node| NodeRef { node: factor.saturating_mul(node.node), ..node }))
    }

    /// The same problem on every `factor`-th node, where there is one: elements can be counted off, and all nodes that
    /// are held, joined or loaded, or carry obstacles, are among these.
    pub(crate) fn coarsened(&self, factor: usize) -> Option<Self> {
        let rods = self.rods.iter().map(|rod| rod.coarsened(factor)).collect::<Option<_>>()?;
        let at = self.supports.iter().map(|s| s.node).chain(self.joints.iter().flat_map(|j| [j.a, j.b]));
        let at = at.chain(self.obstacles.iter().filter_map(|obstacle| obstacle.carrier));
        let all_there = at.chain(self.loads.iter().map(|load| load.node)).all(|at| at.node % factor == 0);
        all_there.then(|| self.with_rods(rods, |node| NodeRef { node: node.node / factor, ..node }))
    }

    /// The same problem on other meshes.
    fn with_rods(&self, rods: Vec<Rod>, node: impl Fn(NodeRef) -> NodeRef) -> Self {
        Self {
            rods,
            supports: self.supports.iter().map(|s| Support { node: node(s.node), ..*s }).collect(),
            joints: self.joints.iter().map(|j| Joint { a: node(j.a), b: node(j.b), kind: j.kind }).collect(),
            loads: self.loads.iter().map(|load| NodeLoad { node: node(load.node), ..*load }).collect(),
            line_loads: self.line_loads.clone(),
            load: self.load,
            obstacles: self.obstacles.iter().map(|o| Obstacle { carrier: o.carrier.map(&node), ..o.clone() }).collect(),
            contact: self.contact,
            electrostatics: self.electrostatics,
            planar: self.planar,
        }
    }
}

impl Engine {
    /// Largest residual over the largest sum of its contributions at the present state, moments compared with forces
    /// over the node spacing (dimensionless). The force along the sliding of a uniform closed rod, a ripple of the
    /// mesh, does not count, nor contact's along motions that cost nothing.
    pub fn relative_residual(&self) -> f64 {
        let mut residual = self.residual(self.state());
        ZeroEnergyModes::at(self, self.state(), &residual).remove_forces(&mut residual);
        relative_residual(self, &residual)
    }
}

impl Solver {
    /// A solver for the same problem on `factor` times the elements, in this solver's state interpolated, with its
    /// contact law and offsets; [`Solver::resettle`] brings it to rest.
    ///
    /// # Errors
    /// A rod that cannot be refined.
    pub fn refined(&self, factor: usize) -> Result<Self, InputError> {
        let (coarse, model) = (&self.engine, self.engine.model.refined(factor)?);
        let mut fine = Self::new(model, self.options.clone())?;
        let (mut positions, mut frames): (Vec<Vec3>, Vec<Quat>) = (Vec::new(), Vec::new());
        for (index, rod) in coarse.model.rods.iter().enumerate() {
            let (r, q) =
                rod.interleave(coarse.positions(index), coarse.frames(index), coarse.state().seams()[index], factor);
            positions.extend(r);
            frames.extend(q);
        }
        fine.engine.set_state(coarse.state().with_nodes(positions, frames))?;
        let between = |node: usize| {
            let rod = fine.engine.rod_of(node);
            let [first, end] = [coarse.first_node[rod], coarse.first_node[rod + 1]];
            let k = node - fine.engine.first_node[rod];
            let ends = [first + k / factor, first + k.div_ceil(factor) % (end - first)];
            (ends, (k % factor) as f64 / factor as f64)
        };
        let between: Vec<([usize; 2], f64)> = (0..fine.engine.num_nodes()).map(between).collect();
        let (from, to) = (&coarse.contact, &mut fine.engine.contact);
        if !from.is_empty() {
            to.law = from.law;
            to.offsets = from.offsets.interleaved(&from.set, &between);
        }
        let fine_node = |node: usize| {
            let rod = coarse.rod_of(node);
            fine.engine.first_node[rod] + factor * (node - coarse.first_node[rod])
        };
        fine.moved = self.moved.on_nodes(fine_node);
        Ok(fine)
    }

    /// Multiplies the contact stiffness in force by `factor`; pressures are kept, and the next search lets the strands
    /// find the gaps that go with them. Without contact nothing happens.
    pub fn harden_contact(&mut self, factor: f64) {
        let side = &mut self.engine.contact;
        if let Law::Linear { stiffness } = side.law {
            side.change_law(Law::Linear { stiffness: stiffness * factor }, side.no_offsets());
        }
    }

    /// Brings the present state to rest as it is: from there under the law in force first, by a softened law only if
    /// that fails.
    pub fn resettle(&mut self) -> StepReport {
        self.load_step(&PrescribedMotion::default(), &Ahead::Present)
    }
}
