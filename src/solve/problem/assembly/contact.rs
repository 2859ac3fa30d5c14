//! Contact at a state, and its contributions.

use super::scatter::{TermBatch, TermKind, batch_size};
use super::{Residual, Sink};
use crate::contact::potential::{self, CandidateTerms, ContactGeometry, EndTerm, Offsets, Pressures, Request, surface};
use crate::error::{InputError, SolveError};
use crate::math::parallel::{self, in_pool};
use crate::solve::measures::AT_ONCE;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

impl Engine {
    /// Moves the contact curves to `state` and refreshes candidates; true if the candidate list changed.
    pub(crate) fn update_contact(&mut self, state: &State) -> Result<bool, SolveError> {
        in_pool(self.pool.as_ref(), || self.contact.update(state))
    }

    /// Whether contact exerts any force in the engine's state; contact must be up to date for it.
    pub(crate) fn is_touching(&self) -> bool {
        let near = self.contact.is_near();
        near && self.residual_of_trial(&self.state).contact_gradient.iter().any(|force| *force != 0.0)
    }

    /// Gradient and potential of contact, tangent too if there is a sink for it.
    pub(super) fn add_contact(&self, request: Request, out: &mut Residual, mut sink: Option<&mut Sink>) {
        let side = &self.contact;
        self.add_surfaces(side, request, out, sink.as_deref_mut());
        if side.broad_phase.pairs().is_empty() {
            return;
        }
        let geometry = ContactGeometry::by_ends(&side.set);
        let largest_offset = side.largest_offset();
        let offset = |slave, master| side.offset(slave, master);
        let earlier = side.before.as_ref().filter(|_| sink.is_some());
        let offset_before =
            |slave, master| earlier.map_or([0.0; 2], |(_, offsets)| side.at_ends(offsets, slave, master));
        let before = earlier.map(|(law, _)| (*law, &offset_before as &Offsets));
        let pressures = Pressures { law: side.law, offset: &offset, before, largest_offset };
        if let Some(sink) = sink {
            return add_pairs(side, &geometry, &pressures, out, sink);
        }
        for pairs in side.broad_phase.pairs().chunks(AT_ONCE) {
            let found = potential::evaluate_ends(&geometry, pairs, &pressures, request);
            found.into_iter().flatten().for_each(|term| add_term(side, term, out));
        }
    }
}

/// Adds the terms of all candidates with their second derivatives. These live for one batch of the candidates only,
/// five kilobytes a pair.
fn add_pairs(
    side: &ContactSide,
    geometry: &ContactGeometry,
    pressures: &Pressures,
    out: &mut Residual,
    sink: &mut Sink,
) {
    let all = side.broad_phase.pairs();
    let mut batch = std::mem::take(&mut sink.scratch.pairs);
    let at_once = batch_size();
    batch.resize_with(at_once.min(all.len()), || CandidateTerms::NONE);
    for (index, pairs) in all.chunks(at_once).enumerate() {
        let found = &mut batch[..pairs.len()];
        potential::evaluate_tangents(geometry, pairs, pressures, found);
        let nodes = |k: usize| (side.ends_of(pairs[k]), 4);
        let blocks = |k: usize| found[k].second_derivative();
        let first = index * at_once;
        sink.add_batch(&TermBatch { kind: TermKind::Pair, first, count: pairs.len(), nodes: &nodes, blocks: &blocks });
        for term in found.iter_mut().flat_map(|pair| &mut pair.terms).filter_map(Option::take) {
            add_term(side, term, out);
        }
    }
    sink.scratch.pairs = batch;
}

/// Adds the forces of a pair in contact, which is kept.
fn add_term(side: &ContactSide, term: EndTerm, out: &mut Residual) {
    out.potential.contact += term.energy;
    add_to_contact(out, &side.nodes_of(&term.pair), &term.gradient);
    out.contact_pairs.push(term.pair);
}

/// Adds forces of contact on some nodes, six numbers each, to the gradient.
fn add_to_contact(out: &mut Residual, nodes: &[usize], gradient: &[f64]) {
    for (node, force) in nodes.iter().zip(gradient.chunks_exact(6)) {
        for k in 0..6 {
            out.gradient[6 * node + k] += force[k];
            out.contact_gradient[6 * node + k] += force[k];
            out.magnitude[6 * node + k] += force[k].abs();
        }
    }
}

impl Engine {
    /// Gradient and potential of contact with obstacles, tangent too if there is a sink for it.
    fn add_surfaces(&self, side: &ContactSide, request: Request, out: &mut Residual, mut sink: Option<&mut Sink>) {
        if side.near_surfaces.pairs().is_empty() {
            return;
        }
        let offset = |segment, surface| side.offset_to_surface(segment, surface);
        let earlier = side.before.as_ref().filter(|_| sink.is_some());
        let offset_before = |segment, surface| {
            earlier.map_or([0.0; 2], |(_, offsets)| side.at_ends_for_surface(offsets, segment, surface))
        };
        let before = earlier.map(|(law, _)| (*law, &offset_before as &Offsets));
        let pressures = Pressures { before, ..Pressures::of(side.law, &offset) };
        let candidates = (&side.surfaces[..], side.near_surfaces.pairs());
        for found in surface::evaluate(&side.set, candidates, &pressures, request) {
            let (nodes, count) = side.nodes_at_surface(found.contact.segment, found.contact.surface);
            let nodes = &nodes[..count];
            out.potential.contact += found.energy;
            add_to_contact(out, nodes, &found.gradient);
            if let (Some(sink), Some(blocks)) = (&mut sink, found.tangent) {
                sink.add(nodes, &blocks);
            }
            out.surface_contacts.push(found.contact);
        }
    }
}

impl Engine {
    /// Gradient and potential of screened charges, tangent too if there is a sink for it.
    pub(super) fn add_electrostatics(&self, out: &mut Residual, mut sink: Option<&mut Sink>) {
        let side = &self.contact;
        let Some(repulsion) = &side.repulsion else { return };
        for pairs in repulsion.pairs().chunks(AT_ONCE) {
            for term in repulsion.terms(&side.set, pairs, sink.is_some()).into_iter().flatten() {
                let nodes = side.ends_of(term.segments.map(|segment| segment as u32));
                out.potential.electrostatic += term.energy;
                for (node, force) in nodes.iter().zip(term.gradient.chunks_exact(6)) {
                    for k in 0..6 {
                        out.gradient[6 * node + k] += force[k];
                        out.magnitude[6 * node + k] += force[k].abs();
                    }
                }
                if let (Some(sink), Some(blocks)) = (&mut sink, term.tangent) {
                    sink.add(&nodes, &blocks);
                }
            }
        }
    }
}

impl ContactSide {
    /// Moves the contact curves and refreshes candidates; true if the list changed.
    pub(crate) fn update(&mut self, state: &State) -> Result<bool, SolveError> {
        if self.is_empty() {
            return Ok(false);
        }
        self.place(state);
        let (range, margin) = self.candidate_range();
        let generation = self.generation();
        if self.is_current && self.broad_phase.is_for(range, margin) {
            return Ok(false);
        }
        self.update_near_surfaces((range, margin));
        self.is_current = false;
        self.exclusion.update(&self.set)?;
        self.broad_phase.candidates(&self.set, &self.exclusion, range, margin).map_err(not_finite)?;
        if let Some(repulsion) = &mut self.repulsion {
            repulsion.update(&self.set).map_err(not_finite)?;
        }
        self.is_current = true;
        Ok(self.generation() != generation)
    }

    /// Overwrites the contact curves with those of `state`; turning bounds and candidates are outdated if they moved.
    pub(crate) fn place(&mut self, state: &State) {
        let cubic = |k: usize| self.tangents.cubic(state, self.nodes[k]);
        let placed = parallel::map(self.nodes.len(), parallel::CHEAP, &cubic);
        for (k, (now, lost)) in placed.into_iter().enumerate() {
            self.set.remainders[k] = lost;
            self.is_current &= std::mem::replace(&mut self.set.segments[k], now) == now;
        }
        self.place_surfaces(state);
    }
}

fn not_finite(error: InputError) -> SolveError {
    let value = match error {
        InputError::Vector { value, .. } => value.into_iter().find(|x| !x.is_finite()).unwrap_or(f64::NAN),
        InputError::Value { value, .. } => value,
        _ => f64::NAN,
    };
    SolveError::NotFinite { iteration: 0, quantity: "contact geometry", index: 0, value }
}
