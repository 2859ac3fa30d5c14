//! Report of a load step.

use crate::error::SolveError;
use crate::solve::search::newton::Iteration;

/// End of a run or a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Status {
    /// All tolerances are met.
    Converged,
    /// Newton ran out of iterations.
    MaxIterations,
    /// Equilibrium with unstable directions that were not or could not be left.
    Unstable,
    /// The augmented Lagrangian loop ended above its penetration tolerance.
    Penetration,
    /// Numerical breakdown.
    BrokeDown,
    /// The load step fell below its smallest size.
    StepTooSmall,
    /// The same, from a state in which a rod is bent about as tightly as it is thick:
    /// [`Failure::bend`](crate::solve::Failure::bend).
    TooTight,
    /// Stopped by the observer or an [`Interrupt`](crate::solve::Interrupt).
    Stopped,
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged",
            Self::MaxIterations => "Newton did not converge",
            Self::Unstable => "unstable equilibrium",
            Self::Penetration => "penetration above tolerance",
            Self::BrokeDown => "numbers broke down",
            Self::StepTooSmall => "load step too small",
            Self::TooTight => "bent as tightly as it is thick",
            Self::Stopped => "stopped",
        })
    }
}

/// Where the guess comes from that a search starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// A plectoneme between two tails that has taken up rod from them, or given rod back, as its end turned.
    Growth,
    /// The last accepted states, extrapolated.
    Prediction,
    /// The present state as it is.
    Present,
    /// The equilibrium of a coarse mesh, after several turns.
    CoarseMesh,
    /// A closed plectoneme: that into which a ring snaps by several turns; a long one made of the equilibrium of a
    /// short one.
    ClosedPlectoneme,
    /// The plectoneme that a short piece of a long straight rod snaps into.
    ShortRod,
    /// The present state under a soft contact law, which is then raised to the requested one.
    CoreLaw,
}

impl Origin {
    /// All, in the order in which they are tried. The last always applies.
    pub(crate) fn all() -> [Self; 7] {
        use Origin::{ClosedPlectoneme, CoarseMesh, CoreLaw, Growth, Prediction, Present, ShortRod};
        [Growth, Prediction, Present, CoarseMesh, ClosedPlectoneme, ShortRod, CoreLaw]
    }
}

/// A start that failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attempt {
    /// Which.
    pub origin: Origin,
    /// How.
    pub status: Status,
}

/// Why a search or a step did not converge.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::solve) struct Failed {
    pub(in crate::solve) status: Status,
    /// The error of a breakdown, or what kept the last step of a search from being taken as a whole.
    pub(in crate::solve) error: Option<SolveError>,
}

impl From<Status> for Failed {
    fn from(status: Status) -> Self {
        Self { status, error: None }
    }
}

impl From<SolveError> for Failed {
    fn from(error: SolveError) -> Self {
        Self { status: Status::BrokeDown, error: Some(error) }
    }
}

/// Report of a load step.
#[derive(Debug, Clone, PartialEq)]
pub struct StepReport {
    /// Its end.
    pub status: Status,
    /// Newton iterations in all.
    pub iterations: usize,
    /// Augmentations of the contact offsets.
    pub augmentations: usize,
    /// Number of unstable equilibria left.
    pub escapes: usize,
    /// Energy that the step set free by leaving its branch \[F·L\]: what its start and the work of supports, loads and
    /// ramped numbers would have come to on it, less what is kept. 0 where the branch was followed (its energy is then
    /// met to a tenth of the work), for a start state, and where no potential is known.
    pub energy_released: f64,
    /// Unstable directions of the final state.
    pub num_unstable: usize,
    /// Worst penetration over the smallest contact radius; 0 without contact.
    pub penetration: f64,
    /// Σ force × gap over the elastic energy, of contacts that the offsets of an augmented Lagrangian hold open beside
    /// others that touch: by so much is the energy too high. They are released until it is 1e-9, but for contacts none
    /// of whose nodes is theirs alone, so near are their neighbours; 0 without contact and under other laws.
    pub complementarity: f64,
    /// Factor by which the contact law stayed softer than requested, because the mesh could not carry it; 1 otherwise.
    /// Gaps are enforced all the same; a point contact is spread wider by the cube root of it.
    pub stiffness_reduction: f64,
    /// Newton iterations elsewhere, not among the others: on a shorter rod, from whose equilibrium the start of a long
    /// plectoneme was made, or on a coarser mesh, on which a step of several turns was made first.
    pub iterations_on_other_meshes: usize,
    /// The start from which the step converged; `None` if it did not, or if there was no search.
    pub start: Option<Origin>,
    /// Starts that failed before it, in order; without one that succeeded, all.
    pub attempts: Vec<Attempt>,
    /// Whether the state to which the branch leads was found unstable.
    pub branch_ends: bool,
    /// The error of a breakdown, or what kept the last step of a search from being taken as a whole.
    pub error: Option<SolveError>,
    /// All Newton iterations, one list per equilibrium search.
    pub history: Vec<Vec<Iteration>>,
}

impl StepReport {
    /// Of a state that is at rest without anything having been done.
    pub(crate) fn settled() -> Self {
        Self {
            status: Status::Converged,
            iterations: 0,
            augmentations: 0,
            escapes: 0,
            energy_released: 0.0,
            num_unstable: 0,
            penetration: 0.0,
            complementarity: 0.0,
            stiffness_reduction: 1.0,
            iterations_on_other_meshes: 0,
            start: None,
            attempts: Vec::new(),
            branch_ends: false,
            error: None,
            history: Vec::new(),
        }
    }

    /// Of a step that was not even tried.
    pub(crate) fn refused(error: SolveError) -> Self {
        Self { status: Status::BrokeDown, error: Some(error), ..Self::settled() }
    }

    /// Of a step made in two parts.
    pub(in crate::solve) fn join(&mut self, mut second: Self) {
        second.iterations += self.iterations;
        second.augmentations += self.augmentations;
        second.escapes += self.escapes;
        second.energy_released += self.energy_released;
        second.iterations_on_other_meshes += self.iterations_on_other_meshes;
        second.branch_ends |= self.branch_ends;
        second.attempts.splice(0..0, std::mem::take(&mut self.attempts));
        second.history.splice(0..0, std::mem::take(&mut self.history));
        *self = second;
    }

    /// Whether the step converged from a state to which its branch was expected to lead.
    #[must_use]
    pub fn is_predicted(&self) -> bool {
        matches!(self.start, Some(Origin::Growth | Origin::Prediction | Origin::Present))
    }

    /// Another attempt from where the last one began: iterations stay counted.
    pub(in crate::solve) fn start_again(&mut self) {
        (self.num_unstable, self.augmentations, self.escapes) = (0, 0, 0);
    }
}
