//! A guess: a value that a search may start from, and the starts that make one.

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::solve::load_step::predictor::Prediction;
use crate::solve::load_step::solver::Solver;
use crate::solve::load_step::step_report::Origin;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::{Lifted, PrescribedMotion, lifted};
use crate::solve::problem::state::State;

/// Largest energy of contact in a guess, over that of the rods, because cables took hundreds of iterations a step from
/// states with more.
const MAX_CONTACT_ENERGY: f64 = 100.0;

/// A contact law with its offsets.
#[derive(Debug, Clone)]
pub(in crate::solve) struct LawInForce {
    pub(in crate::solve) law: Law,
    pub(in crate::solve) offsets: ContactField,
    /// Law and offsets whose pressures the first linearisation uses; `None`: those in force.
    pub(in crate::solve) before: Option<(Law, ContactField)>,
}

impl LawInForce {
    /// That of contact as it is now.
    pub(in crate::solve) fn of(side: &ContactSide) -> Self {
        Self { law: side.law, offsets: side.offsets.clone(), before: side.before.clone() }
    }
}

/// What a guess knows of contact.
#[derive(Debug, Clone)]
pub(in crate::solve) enum ContactOfGuess {
    /// It is as it was in the last state.
    Kept,
    Known(LawInForce),
    /// Nothing: the guess is a shape. The search goes over the laws, from pressures that balance the shape.
    Unknown,
}

impl ContactOfGuess {
    /// That of a solver in whose state contact is enforced.
    pub(in crate::solve) fn of(engine: &Engine) -> Self {
        Self::Known(LawInForce::of(&engine.contact))
    }
}

/// A state from which the end of a load step may be near, with all that is known of it.
#[derive(Debug, Clone)]
pub(in crate::solve) struct Guess {
    pub(in crate::solve) state: State,
    /// Contact that holds it.
    pub(in crate::solve) contact: ContactOfGuess,
    /// Part of the prescribed motion that supports have still to make.
    pub(in crate::solve) drive: PrescribedMotion,
    /// Shear forces and tension, per element and integration point \[F\]; empty: those of the state.
    pub(in crate::solve) forces: Vec<[[f64; 3]; 3]>,
    /// Rotations, rad, to the equilibrium, by the order of magnitude; infinite: not known.
    pub(in crate::solve) uncertainty: f64,
    /// Potential without stretch and shear \[F·L\] of the present state, where the guess must have less to be worth a
    /// search.
    pub(in crate::solve) ceiling: Option<f64>,
    /// Unstable equilibria that the rods leave on the way to it.
    pub(in crate::solve) escapes: usize,
}

impl Guess {
    /// A state of which nothing else is known.
    pub(in crate::solve) fn of(state: State) -> Self {
        Self {
            state,
            contact: ContactOfGuess::Kept,
            drive: PrescribedMotion::default(),
            forces: Vec::new(),
            uncertainty: f64::INFINITY,
            ceiling: None,
            escapes: 0,
        }
    }
}

/// What is known of the end of a step before any search.
#[derive(Debug, Clone)]
pub(in crate::solve) enum Ahead {
    Unknown,
    /// It is near the present state.
    Present,
    Predicted(Prediction),
}

/// A load step from the present state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task<'a> {
    pub(super) drive: &'a PrescribedMotion,
    pub(super) ahead: &'a Ahead,
}

impl Solver {
    /// The state that a prediction leads to, as far as no strand passes another on the way.
    pub(super) fn predicted_guess(
        &mut self,
        drive: &PrescribedMotion,
        Prediction { increment, forces, uncertainty }: &Prediction,
    ) -> Result<Guess, SolveError> {
        let engine = &mut self.engine;
        let Lifted { state, drive, .. } = lifted(engine, engine.state(), drive);
        let fraction = engine.free_fraction(&state, increment)?;
        let drive = drive.scaled(1.0 - fraction);
        let (forces, uncertainty) = (forces.clone(), *uncertainty);
        Ok(Guess { drive, forces, uncertainty, ..Guess::of(engine.retract(&state, increment, fraction)) })
    }

    /// The present state, turns about the rods' own tangents made.
    pub(super) fn present_guess(&self, drive: &PrescribedMotion) -> Guess {
        let Lifted { state, drive, .. } = lifted(&self.engine, self.engine.state(), drive);
        Guess { drive, ..Guess::of(state) }
    }

    /// Puts state and contact of a guess in force.
    pub(super) fn take(&mut self, guess: &Guess) {
        self.engine.take_state(guess.state.clone());
        if let ContactOfGuess::Known(LawInForce { law, offsets, before }) = guess.contact.clone() {
            let side = &mut self.engine.contact;
            (side.law, side.offsets, side.before) = (law, offsets, before);
            self.engine.take_tangents();
        }
    }

    /// Whether a search from a guess, which is in force, is worth its cost: contact has not far more energy than the
    /// rods, and the potential is below the present one, if the guess was made to lower it.
    pub(super) fn is_promising(&mut self, guess: &Guess) -> Result<bool, SolveError> {
        if self.engine.contact.is_empty() {
            return Ok(true);
        }
        let potential = self.engine.potential_at(&guess.state)?;
        let elastic = potential.elastic.total();
        Ok(match guess.ceiling {
            Some(ceiling) => potential.without_stretch_and_shear() < ceiling,
            None => potential.contact <= MAX_CONTACT_ENERGY * elastic,
        })
    }

    /// The guess of a start, where it applies.
    ///
    /// # Errors
    /// Numbers that break down on the way to it.
    pub(super) fn guess(
        &mut self,
        origin: Origin,
        Task { drive, ahead }: Task,
        elsewhere: &mut usize,
    ) -> Result<Option<Guess>, SolveError> {
        match (origin, ahead) {
            (Origin::Prediction, Ahead::Predicted(prediction)) => self.predicted_guess(drive, prediction).map(Some),
            (Origin::Present, Ahead::Present) => Ok(Some(self.present_guess(drive))),
            (Origin::Growth, _) => self.growth(drive),
            (Origin::ShortRod, _) => self.snap_of_short_rod(drive, elsewhere),
            (Origin::ClosedPlectoneme, _) => self.closed_plectoneme(drive, matches!(ahead, Ahead::Unknown), elsewhere),
            (Origin::CoarseMesh, _) => self.coarse_mesh_guess(drive, elsewhere),
            _ => Ok(None),
        }
    }
}
