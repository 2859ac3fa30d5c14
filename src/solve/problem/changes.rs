//! A problem that changes on the way: numbers of rods that stages ramp, supports that they set and take away.
//!
//! Numbers belong to the state, as loads do: whoever goes back to a state has its numbers, too. The engine's model
//! follows them ([`Engine::take_numbers`]).

use std::collections::BTreeMap;

use crate::contact::law::Law;
use crate::error::{InputError, SolveError};
use crate::rod::{Natural, RodNumber};
use crate::scene::Ramp;
use crate::solve::load_step::predictor::{History, Lifted, Prediction, lifted};
use crate::solve::path::run::Solver;
use crate::solve::problem::contact_side::{self, ContactSide};
use crate::solve::problem::engine::{Engine, Reference};
use crate::solve::problem::state::Target;

/// Numbers of rods that have been ramped.
pub type Numbers = BTreeMap<(usize, RodNumber), f64>;

/// Numbers as a list: text formats have words for keys only.
#[cfg(feature = "serde")]
pub(crate) mod as_list {
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{Numbers, RodNumber};

    pub(crate) fn serialize<S: Serializer>(numbers: &Numbers, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(numbers)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Numbers, D::Error> {
        Vec::<((usize, RodNumber), f64)>::deserialize(deserializer).map(|list| list.into_iter().collect())
    }
}

impl Engine {
    /// Makes the model that of the state's numbers.
    ///
    /// # Errors
    /// Contact curves that cannot be made of them.
    pub(crate) fn take_numbers(&mut self) -> Result<(), InputError> {
        let (mut changed, before) = (false, self.contact_stiffness());
        for (&(rod, which), &value) in &self.state.numbers {
            if let Some(rod) = self.model.rods.get_mut(rod).filter(|rod| rod.number(which) != value) {
                rod.set_number(which, value);
                changed = true;
            }
        }
        if !changed {
            return Ok(());
        }
        self.measure_again();
        for (rod, reference) in self.model.rods.iter().zip(&mut self.reference) {
            match &rod.natural {
                Natural::Straight => *reference = Reference::Uniform([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
                Natural::Uniform { kappa } => {
                    *reference = Reference::Uniform([0.0, 0.0, 1.0, kappa[0], kappa[1], kappa[2]]);
                }
                // as it was: these do not change
                Natural::Varying(_) | Natural::AsShaped => {}
            }
        }
        self.contact_of_numbers(before)
    }

    /// Contact curves and law of the present numbers, where the law had another stiffness \[F/L²\]; pressures stay.
    fn contact_of_numbers(&mut self, before: f64) -> Result<(), InputError> {
        let Some(side) = &self.contact else { return Ok(()) };
        let (law, offsets) = (side.law, side.offsets.clone());
        let asked = self.law_asked.on_mesh(&self.model.rods);
        let Some(stiffness) = asked.stiffness() else { return Ok(()) };
        let law_asked = (stiffness, self.scales.bending);
        let fresh = ContactSide::new(&self.model.rods, &self.first_node, &self.state, law_asked)?;
        let Some(mut fresh) = fresh else { return Ok(()) };
        let ratio = contact_side::stiffness(stiffness, self.scales.bending, fresh.min_radius) / before;
        fresh.offsets = offsets.map(|_, offset| offset / ratio);
        if let Law::Linear { stiffness } = law {
            fresh.law = Law::Linear { stiffness: stiffness * ratio };
        }
        self.model.contact.law = asked;
        self.contact = Some(fresh);
        Ok(())
    }
}

impl Solver {
    /// Notes the present values of numbers that ramps are about to move, so that a step that fails goes back to them.
    pub(in crate::solve) fn note_numbers(&mut self, ramps: &[Ramp]) {
        for ramp in ramps {
            if let Ramp::Number { rod, which, .. } = ramp {
                let value = self.engine.model.rods[*rod].number(*which);
                self.engine.state.numbers.entry((*rod, *which)).or_insert(value);
            }
        }
    }

    /// Sets and takes away supports as a stage says, before its first step: nodes are held where they are.
    ///
    /// # Errors
    /// Contact geometry that breaks down.
    pub(in crate::solve) fn change_supports(&mut self, ramps: &[Ramp]) -> Result<(), SolveError> {
        if !self.engine.model.change_supports(ramps) {
            return Ok(());
        }
        self.engine.hold_again();
        self.history = History::default();
        self.forget_the_way()
    }

    /// Where a step leads that changes numbers: nowhere by itself, supports move as they are told.
    pub(in crate::solve) fn unforeseen(&self, target: &Target) -> Option<Prediction> {
        let changes = target.numbers.iter().any(|(key, value)| self.engine.state.numbers.get(key) != Some(value));
        changes.then(|| {
            let Lifted { drive, .. } = lifted(&self.engine, &self.engine.state, &target.drive);
            let mut still = Prediction::still(&self.engine);
            drive.add_to(&mut still.increment);
            still
        })
    }
}
