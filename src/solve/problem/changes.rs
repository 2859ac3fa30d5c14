//! Changes of the problem: another state, another contact law, ramped numbers of rods.
//!
//! Numbers belong to the state, as loads do: a restored state has its own numbers. The engine's model
//! follows them ([`Engine::take_numbers`]).

use crate::contact::broad_phase::BroadPhase;
use crate::contact::law::Law;
use crate::contact::screened::Repulsion;
use crate::error::{InputError, SolveError};
use crate::rod::{Natural, RodNumber};
use crate::scene::ContactLaw;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_side::{self, ContactSide};
use crate::solve::problem::engine::{Engine, Reference};
use crate::solve::problem::state::{Numbers, PrescribedValue, State};

impl Engine {
    /// Changes the contact law, for example to raise a penalty in steps; offsets are kept for the augmented Lagrangian
    /// and dropped for a penalty.
    ///
    /// # Errors
    /// A law out of range; a change from or to no contact, which needs a new engine.
    pub(crate) fn set_contact_law(&mut self, law: ContactLaw) -> Result<(), InputError> {
        let asked = law;
        let law = law.on_mesh(&self.model.rods);
        let side = &mut self.contact;
        let Some(stiffness) = law.stiffness().filter(|_| !side.is_empty()) else {
            let reason = "contact cannot be switched on or off in a running engine".to_owned();
            return Err(InputError::Inconsistent { field: "contact.law".to_owned(), reason });
        };
        InputError::positive("contact.stiffness", stiffness)?;
        let raised = contact_side::stiffness(stiffness, self.scales.bending, side.min_radius);
        let offsets = if matches!(law, ContactLaw::Penalty { .. }) { side.no_offsets() } else { side.offsets.clone() };
        side.change_law(Law::Linear { stiffness: raised }, offsets);
        self.model.contact.law = law;
        self.law_asked = asked;
        Ok(())
    }

    /// Replaces the configuration: by a start shape of one's own, or by a state of the same rods under other loads or
    /// supports.
    ///
    /// # Errors
    /// `InputError::Inconsistent` when the sizes do not match the model, or joined nodes are parted.
    pub(crate) fn set_state(&mut self, state: State) -> Result<(), InputError> {
        let fits = state.positions.len() == self.state.positions.len()
            && state.remainders.len() == self.state.remainders.len()
            && state.frames.len() == self.state.frames.len()
            && state.seams.len() == self.state.seams.len()
            && state.pressures.len() == self.state.pressures.len()
            && state.placements.len() == self.state.placements.len();
        if !fits {
            let reason = "has another number of nodes or rods than the model".to_owned();
            return Err(InputError::Inconsistent { field: "state".to_owned(), reason });
        }
        self.check_joined(&state)?;
        self.state = state;
        self.sharing.follow(&mut self.state);
        self.take_numbers()?;
        self.take_tangents();
        Ok(())
    }

    /// Gives prescribed quantities of the present state their values; nodes and frames stay. The model takes numbers of
    /// rods by [`Engine::take_numbers`].
    pub(crate) fn prescribe(&mut self, values: impl IntoIterator<Item = PrescribedValue>) {
        self.state.prescribe(values);
    }

    /// Notes in the state the present value of a number that is about to change, unless it is there.
    pub(in crate::solve) fn note_number(&mut self, rod: usize, which: RodNumber) {
        let value = self.model.rods[rod].number(which);
        self.state.numbers.entry((rod, which)).or_insert(value);
    }

    /// Makes the model that of the state's numbers.
    ///
    /// # Errors
    /// Contact curves that cannot be made of them.
    pub(crate) fn take_numbers(&mut self) -> Result<(), InputError> {
        let before = self.contact_stiffness();
        let numbers = self.state.numbers.clone();
        if self.set_numbers_of_elements(&numbers) { self.contact_of_numbers(before) } else { Ok(()) }
    }

    /// Elastic energy and potential of the loads in a state with its numbers; contact is left alone.
    pub(in crate::solve) fn potential_without_contact(&mut self, state: &State) -> f64 {
        self.residual_of_numbers(state, true).potential.total()
    }

    /// The residual of elements, and of loads if requested, in a state with its numbers; contact is left alone.
    pub(in crate::solve::problem) fn residual_of_numbers(&mut self, state: &State, loads: bool) -> Residual {
        self.with_numbers(&state.numbers, |engine| {
            let mut out = engine.start_residual(state);
            engine.install(|| {
                engine.add_element_gradients(state, &mut out);
                if loads {
                    engine.add_loads(state, &mut out, None);
                }
            });
            out
        })
    }

    /// Does some work under other numbers of rods and their elements.
    pub(in crate::solve::problem) fn with_numbers<R>(&mut self, numbers: &Numbers, work: impl FnOnce(&Self) -> R) -> R {
        let before = self.numbers_like(numbers);
        self.set_numbers_of_elements(numbers);
        let result = work(self);
        self.set_numbers_of_elements(&before);
        result
    }

    /// Gives rods and their elements numbers; true if any is another.
    fn set_numbers_of_elements(&mut self, numbers: &Numbers) -> bool {
        let mut changed = false;
        for (&(rod, which), &value) in numbers {
            if let Some(rod) = self.model.rods.get_mut(rod).filter(|rod| rod.number(which) != value) {
                rod.set_number(which, value);
                changed = true;
            }
        }
        if !changed {
            return false;
        }
        self.measure_again();
        for (rod, reference) in self.model.rods.iter().zip(&mut self.reference) {
            match &rod.natural {
                Natural::Straight => *reference = Reference::curved([0.0; 3]),
                Natural::Uniform { kappa } => *reference = Reference::curved(*kappa),
                Natural::Varying(along) if rod.binding.is_some() => *reference = reference.varying(rod, along),
                // as it was: these do not change
                Natural::Varying(_) | Natural::AsShaped => {}
            }
        }
        true
    }

    /// Does some work with the problem at a state of the present nodes: other numbers of rods, other places of
    /// obstacles, contact brought up to date with them at the offsets that give the present pressures. Then all is as
    /// it was.
    ///
    /// # Errors
    /// Contact curves that cannot be made of the numbers; contact geometry that breaks down.
    pub(crate) fn at_state<R>(
        &mut self,
        state: &State,
        work: impl FnOnce(&Self) -> R,
    ) -> Result<Result<R, SolveError>, InputError> {
        let stiffness = self.contact_stiffness();
        let numbers = self.numbers_like(&state.numbers);
        let present = std::mem::replace(&mut self.state, state.clone());
        let fresh = match self.set_numbers_of_elements(&state.numbers) {
            true => self.side_of_numbers(stiffness),
            false => Ok(None),
        };
        let before = fresh.map(|fresh| {
            fresh.map(|(side, law)| {
                (std::mem::replace(&mut self.contact, side), std::mem::replace(&mut self.model.contact.law, law))
            })
        });
        let result = self.update_contact(state).map(|_| work(self));
        self.set_numbers_of_elements(&numbers);
        self.state = present;
        if let Some((side, law)) = before? {
            (self.contact, self.model.contact.law) = (side, law);
        }
        let present = self.state.clone();
        Ok(self.update_contact(&present).and(result))
    }

    /// The model's present values of these numbers.
    fn numbers_like(&self, numbers: &Numbers) -> Numbers {
        numbers.keys().map(|&(rod, which)| ((rod, which), self.model.rods[rod].number(which))).collect()
    }

    /// Contact curves and law of the present numbers, where the law had another stiffness \[F/L²\]; pressures stay.
    fn contact_of_numbers(&mut self, before: f64) -> Result<(), InputError> {
        if let Some((fresh, law)) = self.side_of_numbers(before)? {
            (self.contact, self.model.contact.law) = (fresh, law);
        }
        Ok(())
    }

    fn side_of_numbers(&self, before: f64) -> Result<Option<(ContactSide, ContactLaw)>, InputError> {
        let side = &self.contact;
        let (law, offsets) = (side.law, side.offsets.clone());
        let asked = self.law_asked.on_mesh(&self.model.rods);
        let Some(stiffness) = asked.stiffness().filter(|_| !side.is_empty()) else { return Ok(None) };
        let law_asked = (stiffness, self.scales.bending);
        let mut fresh =
            ContactSide::new(&self.model, &self.first_node, (&self.state, side.tangents.clone()), law_asked)?;
        fresh.replaces(side);
        let ratio = contact_side::stiffness(stiffness, self.scales.bending, fresh.min_radius) / before;
        fresh.offsets = offsets.map(|_, offset| offset / ratio);
        if let Law::Linear { stiffness } = law {
            fresh.law = Law::Linear { stiffness: stiffness * ratio };
        }
        Ok(Some((fresh, asked)))
    }

    /// Finds contact candidates anew, whatever lists are at hand: a list that still holds may be longer than a fresh
    /// one. Of a law under which no step was taken, as where strands were apart, none is remembered.
    pub(in crate::solve) fn forget_path(&mut self) -> Result<(), SolveError> {
        let side = &mut self.contact;
        side.before = None;
        side.exclusion.forget();
        side.broad_phase = BroadPhase::new();
        side.repulsion.iter_mut().for_each(Repulsion::forget);
        let state = self.state.clone();
        self.update_contact(&state).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::rod::{Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeRef, Support};

    /// Symptom: where a rod grew, candidates were counted from 0 again, and the matrix could keep the pattern of
    /// before.
    #[test]
    fn other_candidates_are_another_generation() {
        let rod = |height: f64| {
            let shape = Shape::Line { start: Vec3::z() * height, direction: Vec3::x(), length: 1.0 };
            let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, 0.01);
            Rod::new("rod", &shape, RodMesh::open(4, 3), section, Natural::Straight).unwrap()
        };
        let supports = (0..2).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect();
        let model = Model { rods: vec![rod(0.0), rod(0.1)], supports, ..Model::default() };
        let mut engine = Engine::new(model, None).unwrap();
        let mut pairs_and_generation = |radius: f64| {
            engine.state.numbers.insert((0, RodNumber::ContactRadius), radius);
            engine.take_numbers().unwrap();
            engine.update_contact(&engine.state.clone()).unwrap();
            let side = &engine.contact;
            (side.broad_phase.pairs().len(), side.generation())
        };
        let ((none, thin), (some, thick)) = (pairs_and_generation(0.01), pairs_and_generation(0.1));
        assert!(none == 0 && some > 0, "{none} {some}");
        assert_ne!(thin, thick);
    }
}
