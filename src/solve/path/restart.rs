//! The data with which a run resumes as if it had never stopped.
//!
//! A load step depends on four things only: where the run stands ([`Place`]), the accepted state, the states before it
//! from which the next is predicted, and the contact law with its offsets. Everything else the solver keeps (candidate
//! lists, sparsity pattern, factorisation, the last soft direction) is dropped after every accepted step, because it
//! depends on how that step was reached and would show in the last bits of the next. So a run that goes on from a
//! [`Restart`] takes the same steps, bit for bit, as one that never stopped.

use crate::contact::law::Law;
use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::scene::{Model, NodeRef, ObstaclePose};
use crate::solve::load_step::predictor::History;
use crate::solve::load_step::solver::Solver;
use crate::solve::options::Options;
use crate::solve::path::given::Given;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::Moved;
use crate::solve::problem::state::State;

/// Where a run stands between two load steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Place {
    /// Stage index.
    pub stage: usize,
    /// Fraction of the stage done, 0..=1.
    pub fraction: f64,
    /// Fraction of the stage to be tried next; infinite at the start of a stage: its own step.
    pub step_size: f64,
    /// Accepted steps, the start not counted.
    pub num_steps: usize,
    /// Newton iterations so far, failed attempts included.
    pub iterations: usize,
}

impl Place {
    /// Before the first step of a stage.
    pub(crate) fn start_of(stage: usize, num_steps: usize, iterations: usize) -> Self {
        Self { stage, fraction: 0.0, step_size: f64::INFINITY, num_steps, iterations }
    }
}

/// A run between two steps as plain data: 80 bytes a node for the state and for each of up to three earlier ones, 8 for
/// offsets of contact.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Restart {
    /// Where the run stands.
    pub place: Place,
    /// The accepted state.
    pub state: State,
    /// Contact law in force.
    contact: ContactRestart,
    /// Motions of supports so far.
    moved: Moved,
    /// Rod, node, position \[L\] and frame of nodes that stages have come to hold, see [`Given::held`].
    held: Vec<(usize, usize, Vec3, Quat)>,
    /// The last accepted states.
    history: History,
}

#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct ContactRestart {
    law: Law,
    offsets: ContactField,
}

impl ContactRestart {
    fn of(engine: &Engine) -> Self {
        Self { law: engine.contact.law, offsets: engine.contact.offsets.clone() }
    }
}

/// An equilibrium with its problem, apart from the engine that had it: supports, loads and numbers as stages have left
/// them.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    model: Model,
    state: State,
    contact: ContactRestart,
}

impl Equilibrium {
    /// That of an engine.
    pub fn of(engine: &Engine) -> Self {
        Self { model: engine.model.clone(), state: engine.state().clone(), contact: ContactRestart::of(engine) }
    }

    /// The problem.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// A solver that is in it.
    ///
    /// # Errors
    /// As [`Solver::new`].
    pub fn solver(&self, options: Options) -> Result<Solver, InputError> {
        let mut solver = Solver::new(self.model.clone(), options)?;
        solver.engine.set_state(self.state.clone())?;
        solver.take_contact(self.contact.clone())?;
        Ok(solver)
    }
}

impl Restart {
    /// Poses of nodes that stages have come to hold.
    pub(in crate::solve) fn held(&self) -> impl Iterator<Item = (NodeRef, (Vec3, Quat))> {
        self.held.iter().map(|&(rod, node, x, q)| (NodeRef { rod, node }, (x, q)))
    }
}

impl Solver {
    /// The present state as the start of a later run. Taken apart field by field, so that whoever gives the solver a
    /// new field has to decide here whether a run depends on it.
    pub(crate) fn to_restart(&self, place: Place, given: &Given) -> Restart {
        let Self { engine, workspace: _, options: _, moved, history } = self;
        let contact = ContactRestart::of(engine);
        let held = given.held.iter().map(|(node, (x, q))| (node.rod, node.node, *x, *q)).collect();
        Restart { place, state: engine.state().clone(), contact, moved: moved.clone(), held, history: history.clone() }
    }

    /// Puts a contact law and its offsets in force.
    fn take_contact(&mut self, saved: ContactRestart) -> Result<(), InputError> {
        let side = &mut self.engine.contact;
        if !saved.offsets.fits(side.size(), &side.set) {
            return Err(InputError::inconsistent("restart", "has contact of other rods or obstacles than the model"));
        }
        (side.law, side.offsets, side.before) = (saved.law, saved.offsets, None);
        Ok(())
    }

    /// Takes over a run.
    ///
    /// # Errors
    /// [`InputError::Inconsistent`] if it belongs to another model.
    pub(crate) fn take_over(&mut self, restart: Restart) -> Result<(), InputError> {
        let Restart { place: _, state, contact, moved, held: _, history } = restart;
        let refuse = |reason: &str| InputError::Inconsistent { field: "restart".to_owned(), reason: reason.to_owned() };
        if let Some(node) = moved.nodes().find(|node| *node >= state.positions().len()) {
            return Err(refuse(&format!("moves node {node}, which the model has not")));
        }
        let numbers = state.positions().iter().chain(state.remainders()).flatten();
        let numbers = numbers.chain(state.frames().iter().flat_map(|q| q.coords.iter()));
        if !numbers.chain(state.seams()).chain(state.pressures()).chain([&state.load_factor()]).all(|x| x.is_finite())
            || !state.placements().iter().all(ObstaclePose::is_finite)
        {
            return Err(refuse("has a number that is not finite"));
        }
        let sizes = |s: &State| [s.positions().len(), s.remainders().len(), s.frames().len()];
        if history.states().any(|s| sizes(s) != sizes(&state)) {
            return Err(refuse("remembers states of another model"));
        }
        history.states().try_for_each(|remembered| self.engine.check_joined(remembered))?;
        self.engine.set_state(state)?;
        self.take_contact(contact)?;
        self.moved = moved;
        self.history = history;
        Ok(())
    }
}
