//! What is left after a short step: the next one, with the factorisation at hand (a chord).
//!
//! Newton's method converges quadratically: a step of 10⁻⁴ leaves about 10⁻⁸. The chord tells how much, for the price
//! of a solve. Where that is within the tolerance the chord is taken, and the search ends without another tangent.

use crate::error::SolveError;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;
use crate::solve::search::newton::increment_size;
use crate::solve::search::timing::timed;
use crate::solve::search::workspace::Workspace;

/// Size of a step, see [`increment_size`], after which the tangent of its start is that of its end, for chords and for
/// the count of unstable directions, because a tangent changes by as much, and 10⁻⁴ of a step of 10⁻⁴ is the usual
/// tolerance.
pub(super) const SHORT: f64 = 1e-4;

/// The next step, with the factorisation at hand.
pub(super) struct Chord {
    pub(super) increment: Vec<f64>,
    /// See [`increment_size`].
    pub(super) size: f64,
    /// Decrease of the potential that it expects.
    pub(super) decrease: f64,
}

impl Workspace {
    /// From a state of this residual, whose forces along neutral motions are removed.
    pub(super) fn chord(&mut self, engine: &Engine, there: &mut Residual) -> Chord {
        self.zero_energy.remove_forces(there);
        let mut increment = self.respond(engine, &there.gradient);
        increment.iter_mut().for_each(|x| *x = -*x);
        let size = increment_size(engine, &increment);
        let decrease = 0.5 * self.free_dot(engine, &increment, |i| there.gradient[i]).abs();
        Chord { increment, size, decrease }
    }

    /// The residual at a state, contact brought up to date.
    pub(super) fn residual_at(&mut self, engine: &mut Engine, state: &State) -> Result<Residual, SolveError> {
        timed(&mut self.timings.detection, || engine.update_contact(state))?;
        Ok(timed(&mut self.timings.assembly, || engine.residual_of_trial(state)))
    }
}
