//! Guesses for plectonemes. Double helices are uniform; so a plectoneme of another length is made of one that is known.
//!
//! | | |
//! |---|---|
//! | `double_helix` | a double helix made longer or shorter by its own screw motion |
//! | `growth` | a plectoneme between tails that takes up rod from them |
//! | `short_rod` | a straight rod that snaps: the plectoneme of a short piece, grown |
//! | `wound_ring` | a ring that snaps: the closed plectoneme of its link |
//! | `periodic_extension` | a closed plectoneme: that of a short rod, made longer |
//!
//! Their interface are three methods of the solver: [`Solver::growth`], [`Solver::snap_of_short_rod`],
//! [`Solver::closed_plectoneme`]. Each gives a guess, or none where it does not apply.

mod double_helix;
mod growth;
mod periodic_extension;
mod short_rod;
mod wound_ring;

use crate::error::SolveError;
use crate::solve::load_step::guess::{ContactOfGuess, Guess};
use crate::solve::load_step::solver::Solver;
use crate::solve::problem::prescribed_motion::{PrescribedMotion, lifted};
use crate::solve::problem::state::State;

impl Solver {
    /// The plectoneme that has grown or shrunk as the drive turns its end.
    pub(super) fn growth(&mut self, drive: &PrescribedMotion) -> Result<Option<Guess>, SolveError> {
        let Some(turned) = self.turned_end(drive) else { return Ok(None) };
        let Some(grown) = growth::grown(&mut self.engine, &turned) else { return Ok(None) };
        self.below(&turned, grown).map(Some)
    }

    /// The plectoneme that a short piece of a long straight rod snaps into, as long as the whole. Iterations on the
    /// piece are added to `elsewhere`.
    pub(super) fn snap_of_short_rod(
        &mut self,
        drive: &PrescribedMotion,
        elsewhere: &mut usize,
    ) -> Result<Option<Guess>, SolveError> {
        let Some(turned) = self.turned_end(drive) else { return Ok(None) };
        let Some(snapped) = self.snapped_short(&turned, elsewhere) else { return Ok(None) };
        // the straight rod was unstable
        let snapped = Guess { escapes: 1, ..snapped };
        self.below(&turned, snapped).map(Some)
    }

    /// The closed plectoneme of a free uniform ring: what it is already, where nothing moves it and nothing is known
    /// (`is_new`), or what it snaps into by several turns. A long one is made of a short one at rest; iterations there
    /// are added to `elsewhere`.
    pub(super) fn closed_plectoneme(
        &mut self,
        drive: &PrescribedMotion,
        is_new: bool,
        elsewhere: &mut usize,
    ) -> Result<Option<Guess>, SolveError> {
        if !self.augments() || !drive.nodes.is_empty() {
            return Ok(None);
        }
        if drive.seams.iter().all(|angle| *angle == 0.0) {
            if !is_new {
                return Ok(None);
            }
            let whole = self.engine.state().clone();
            return Ok(self.periodic_extension(&whole, elsewhere));
        }
        let Some(wound) = self.wound_ring(drive) else { return Ok(None) };
        let turned = lifted(&self.engine, self.engine.state(), drive).state;
        if !self.is_unstable(&turned).unwrap_or(false) {
            return Ok(None);
        }
        let shape = |state| Guess { contact: ContactOfGuess::Unknown, ..Guess::of(state) };
        let guess = self.periodic_extension(&wound, elsewhere).unwrap_or_else(|| shape(wound));
        // the ring was unstable
        self.below(&turned, Guess { escapes: 1, ..guess }).map(Some)
    }

    /// The state with the drive lifted, if growth and snaps of plectonemes may be put together: it turns an end of a
    /// uniform rod, and contact is augmented.
    fn turned_end(&self, drive: &PrescribedMotion) -> Option<State> {
        if self.augments() { growth::turned_end(&self.engine, drive) } else { None }
    }

    /// A guess that must lower the potential, without stretch and shear, from that of the present state with the
    /// drive's turn spread along the rod.
    fn below(&mut self, turned: &State, guess: Guess) -> Result<Guess, SolveError> {
        let ceiling = Some(self.engine.potential_at(turned)?.without_stretch_and_shear());
        Ok(Guess { ceiling, ..guess })
    }
}
