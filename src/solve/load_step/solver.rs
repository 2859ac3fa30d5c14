//! The solver: engine, workspace, and all that one load step leaves to the next.

use crate::error::{InputError, SolveError};
use crate::math::parallel::in_pool;
use crate::scene::{ContactLaw, Model};
use crate::solve::load_step::predictor::History;
use crate::solve::options::Options;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::Moved;
use crate::solve::problem::problem_size::ProblemSize;
use crate::solve::problem::state::State;
use crate::solve::search::timing::Timings;
use crate::solve::search::workspace::Workspace;

/// Engine and workspace: finds equilibria one after the other.
#[derive(Debug)]
pub struct Solver {
    pub(crate) engine: Engine,
    pub(crate) workspace: Workspace,
    pub(crate) options: Options,
    /// Motions of supports so far.
    pub(crate) moved: Moved,
    /// The last accepted states, for predictions.
    pub(crate) history: History,
}

impl Solver {
    /// Builds the engine.
    ///
    /// # Errors
    /// Refused input; a rod so far from the origin that rounding moves its nodes by a thousandth of their spacing.
    pub fn new(model: Model, options: Options) -> Result<Self, InputError> {
        options.check()?;
        let engine = Engine::new(model, options.threads)?;
        engine.check_resolution()?;
        Ok(Self {
            engine,
            workspace: Workspace::default(),
            options,
            moved: Moved::default(),
            history: History::default(),
        })
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Changes the contact law, for example to raise a penalty in steps; offsets are kept for the augmented Lagrangian
    /// and dropped for a penalty.
    ///
    /// # Errors
    /// A law out of range; a change from or to no contact, which needs a new solver.
    pub fn set_contact_law(&mut self, law: ContactLaw) -> Result<(), InputError> {
        self.engine.set_contact_law(law)
    }

    /// Replaces the configuration: by a start shape of one's own, or by the state of the same rods under other loads or
    /// supports.
    ///
    /// # Errors
    /// `InputError::Inconsistent` when the sizes do not match the model, or joined nodes are parted.
    pub fn set_state(&mut self, state: State) -> Result<(), InputError> {
        self.engine.set_state(state)
    }

    /// Sizes of the problem with the contact candidates of the present state; analyses the pattern of the tangent anew,
    /// which takes about as long as a Newton iteration.
    ///
    /// # Errors
    /// Contact geometry that breaks down, a factorisation that does not fit into memory.
    pub fn problem_size(&mut self) -> Result<ProblemSize, SolveError> {
        self.engine.problem_size()
    }

    /// The solver's options.
    pub fn options_mut(&mut self) -> &mut Options {
        &mut self.options
    }

    /// Where the time of all searches of this solver went.
    pub fn timings(&self) -> Timings {
        self.workspace.timings
    }

    /// Number of unstable directions at the present state.
    ///
    /// # Errors
    /// When the tangent cannot be factorised.
    pub fn num_unstable(&mut self) -> Result<usize, SolveError> {
        self.workspace.count_unstable(&mut self.engine)
    }

    /// Runs `work` in the solver's own pool, if it has one, because to enter the pool for every sum takes longer than a
    /// small sum.
    pub(in crate::solve) fn in_own_pool<R: Send>(&mut self, work: impl FnOnce(&mut Self) -> R + Send) -> R {
        let pool = self.engine.pool.take();
        let result = in_pool(pool.as_ref(), || work(self));
        self.engine.pool = pool;
        result
    }

    /// Drops all that depends on how the present state was reached.
    pub(crate) fn forget_path(&mut self) -> Result<(), SolveError> {
        let timings = self.workspace.timings;
        self.workspace = Workspace::default();
        self.workspace.timings = timings;
        self.engine.forget_path()
    }
}
