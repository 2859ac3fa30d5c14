//! Whether contact is in balance after the last step of a search.

use crate::error::SolveError;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;
use crate::solve::search::newton::unbalanced;
use crate::solve::search::timing::timed;
use crate::solve::search::workspace::Workspace;

/// Increment, over the tolerance, that is far below it.
const FAR_BELOW: f64 = 1e-3;
/// Rotation, rad, that contact forces cause where they bend no rod.
const BENDS_NOTHING: f64 = 1e-6;

/// Largest force out of balance over the largest contact force, because the most exact preset states contact forces to
/// 5e-4. With 1e-3 light forces on stiff contact are off by as much.
const UNBALANCED: f64 = 1e-4;

impl Workspace {
    /// Whether the forces of contact are in balance at `state`, after a step of this size from `before`: contact is so
    /// stiff that a step below the tolerance may change them much.
    pub(super) fn balances_contact(
        &mut self,
        engine: &mut Engine,
        (before, state): (&Residual, &State),
        (size, tol_increment): (f64, f64),
    ) -> Result<bool, SolveError> {
        if engine.contact.is_empty() {
            return Ok(true);
        }
        timed(&mut self.timings.detection, || engine.update_contact(state))?;
        let mut there = timed(&mut self.timings.assembly, || engine.residual_of_trial(state));
        self.zero_energy.remove_forces(&mut there);
        let largest = before.largest_contact_force().max(there.largest_contact_force());
        Ok(unbalanced(engine, &there) <= UNBALANCED * largest * engine.scales.lever
            || largest <= engine.scales.nothing
            || is_light(engine, before, size, tol_increment))
    }
}

/// Whether a step is far below the tolerance of increments, and contact forces bend no rod: forces of strands that
/// touch without load are rounding, and never converge.
pub(super) fn is_light(engine: &Engine, residual: &Residual, size: f64, tol_increment: f64) -> bool {
    size <= FAR_BELOW * tol_increment && bends_nothing(engine, residual)
}

/// Whether contact forces bend no rod.
pub(in crate::solve) fn bends_nothing(engine: &Engine, residual: &Residual) -> bool {
    // rotations that the largest contact force causes, F L²/B
    residual.largest_contact_force() * engine.scales.length.powi(2) / engine.scales.bending <= BENDS_NOTHING
}
