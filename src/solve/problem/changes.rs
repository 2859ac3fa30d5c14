//! Changes of the problem by stages: ramped numbers of rods, supports that are set and removed.
//!
//! Numbers belong to the state, as loads do: a restored state has its own numbers. The engine's model
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
                Natural::Straight => *reference = Reference::curved([0.0; 3]),
                Natural::Uniform { kappa } => *reference = Reference::curved(*kappa),
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
        let fresh = ContactSide::new(&self.model, &self.first_node, &self.state, law_asked)?;
        let Some(mut fresh) = fresh else { return Ok(()) };
        fresh.replaces(side);
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
        self.engine.find_unknowns();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rod::{Rod, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};

    /// Symptom: where a rod grew, candidates were counted from 0 again, and the matrix could keep the pattern of before.
    #[test]
    fn other_candidates_are_another_generation() {
        let rod = |height: f64| {
            let shape = Shape::Line { start: Vec3::z() * height, direction: Vec3::x(), length: 1.0 };
            let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.01);
            Rod::new("rod", &shape, false, section, 4, 3, Natural::Straight).unwrap()
        };
        let supports = (0..2).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect();
        let model = Model { rods: vec![rod(0.0), rod(0.1)], supports, ..Model::default() };
        let mut engine = Engine::new(model, None).unwrap();
        let mut pairs_and_generation = |radius: f64| {
            engine.state.numbers.insert((0, RodNumber::ContactRadius), radius);
            engine.take_numbers().unwrap();
            engine.update_contact(&engine.state.clone()).unwrap();
            let side = engine.contact.as_ref().unwrap();
            (side.broad_phase.pairs().len(), side.generation())
        };
        let ((none, thin), (some, thick)) = (pairs_and_generation(0.01), pairs_and_generation(0.1));
        assert!(none == 0 && some > 0, "{none} {some}");
        assert_ne!(thin, thick);
    }
}
