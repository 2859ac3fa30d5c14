//! Gradient, tangent and potential of the whole problem at a state, the sums over elements, contact and loads. Contact
//! must have been brought up to date with the state before (`Engine::update_contact`).

mod contact;
mod elements;
mod loads;
mod scatter;

pub(in crate::solve) use elements::symmetric;
pub(crate) use scatter::Places;
pub(in crate::solve) use scatter::Sink;

use crate::contact::potential::surface::SurfaceContact;
use crate::contact::potential::{CandidateTerms, ContactPair, Request};
use crate::error::SolveError;
use crate::rod::ElasticEnergies;
use crate::rod::element::{ElementOutput, ElementTangent, Strain, Stress};
use crate::solve::measures::LAST_PLACES;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::Bases;
use crate::sparse::{NodeGraph, Pattern};

/// Parts of the potential \[F·L\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Potential {
    /// Of the elements.
    pub(crate) elastic: ElasticEnergies,
    /// Energy of the contact law.
    pub(crate) contact: f64,
    /// Energy of screened charges.
    pub(crate) electrostatic: f64,
    /// Minus the work of dead forces and pressure.
    pub(crate) load: f64,
}

impl Potential {
    /// Sum of all parts.
    pub(crate) fn total(&self) -> f64 {
        self.elastic.total() + self.contact + self.electrostatic + self.load
    }

    /// Sum of all parts but stretch and shear, which are nearly rigid: errors of a guess show in them first, and the
    /// first correction mends them.
    pub(crate) fn without_stretch_and_shear(&self) -> f64 {
        self.elastic.bending + self.elastic.twisting + self.contact + self.electrostatic + self.load
    }
}

/// Everything first-order at a state.
#[derive(Debug, Clone, Default)]
pub(crate) struct Residual {
    /// Gradient of the potential, six per node, supported unknowns included (there it is the reaction).
    pub(crate) gradient: Vec<f64>,
    /// Per unknown: sum of absolute contributions, the size against which rounding and convergence are judged.
    pub(crate) magnitude: Vec<f64>,
    /// Potential.
    pub(crate) potential: Potential,
    /// Rounding error of the potential \[F·L\].
    pub(crate) rounding: f64,
    /// Where there is contact.
    pub(crate) contact_pairs: Vec<ContactPair>,
    /// Where there is contact with obstacles.
    pub(crate) surface_contacts: Vec<SurfaceContact>,
    /// Gradient of the contact potential alone.
    pub(crate) contact_gradient: Vec<f64>,
    /// Per closed rod (per rod): derivative of the potential with respect to the seam angle \[F·L\], the twisting
    /// moment there.
    pub(crate) seam_moments: Vec<f64>,
    /// Bases of the unknowns at the state.
    pub(crate) bases: Bases,
}

impl Residual {
    /// Components of the contact forces on the nodes, without the moments, which are in another unit \[F\].
    pub(crate) fn contact_forces(&self) -> impl Iterator<Item = f64> {
        self.contact_gradient.chunks(6).flat_map(|node| node[..3].iter().copied())
    }

    /// Largest of [`Residual::contact_forces`] \[F\].
    pub(crate) fn largest_contact_force(&self) -> f64 {
        self.contact_forces().fold(0.0f64, |a, b| a.max(b.abs()))
    }
}

/// Tangent in the pattern's values plus the load-step right-hand side.
#[derive(Debug, Default)]
pub(crate) struct Tangent {
    /// Values of the pattern's entries.
    pub(crate) values: Vec<f64>,
    /// K_fp · drive per unknown (six per node).
    pub(crate) drive: Vec<f64>,
    /// Places of the terms' blocks in the pattern; to be cleared with it.
    pub(crate) places: Places,
    scratch: Batches,
}

/// Memory for batches of terms, kept from one linearisation to the next.
#[derive(Default)]
struct Batches {
    elements: Vec<(ElementOutput, ElementTangent)>,
    pairs: Vec<CandidateTerms>,
}

impl std::fmt::Debug for Batches {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Batches").finish_non_exhaustive()
    }
}

impl Engine {
    /// Gradient (and potential) at `state` with the zones of contact; contact must be up to date for it.
    pub(crate) fn residual(&self, state: &State) -> Residual {
        self.residual_besides(state, Request { zones: true, tangent: false })
    }

    /// Potential at a state, to which contact is brought up to date.
    pub(crate) fn potential_at(&mut self, state: &State) -> Result<Potential, SolveError> {
        self.update_contact(state)?;
        Ok(self.residual_of_trial(state).potential)
    }

    /// [`Engine::residual`] for searches: contact pairs without their zones.
    pub(crate) fn residual_of_trial(&self, state: &State) -> Residual {
        self.residual_besides(state, Request::default())
    }

    fn residual_besides(&self, state: &State, request: Request) -> Residual {
        let mut out = self.residual_of_nodes(state, request);
        self.join(&mut out);
        out
    }

    /// Forces and moments that joints and supports must exert on each node at `state`, six numbers a node; contact must
    /// be up to date for it.
    pub(crate) fn forces_on_nodes(&self, state: &State) -> Vec<f64> {
        self.residual_of_nodes(state, Request::default()).gradient
    }

    /// The gradient by the unknowns of each node, as if it were joined to none.
    fn residual_of_nodes(&self, state: &State, request: Request) -> Residual {
        self.install(|| {
            let mut out = self.start_residual(state);
            self.add_element_gradients(state, &mut out);
            self.add_contact(request, &mut out, None);
            self.add_electrostatics(&mut out, None);
            self.add_loads(state, &mut out, None);
            out
        })
    }

    /// Gradient and tangent at `state`, without zones; `predicted` are the stresses of mixed-integration-point Newton,
    /// three per element.
    pub(crate) fn linearise(
        &self,
        state: &State,
        predicted: Option<&[[Strain; 3]]>,
        drive: &PrescribedMotion,
        to: (&Pattern, &mut Tangent),
    ) -> Residual {
        self.linearise_with(state, drive, to, |out, sink| self.add_elements(state, predicted, out, sink))
    }

    /// [`Engine::linearise`] without the part Bᵀ C B of the elements: see [`Engine::material_product`].
    pub(in crate::solve) fn linearise_besides_material(
        &self,
        state: &State,
        stress: &[[Stress; 3]],
        to: (&Pattern, &mut Tangent),
    ) {
        let still = PrescribedMotion::default();
        self.linearise_with(state, &still, to, |out, sink| self.add_geometric_tangent(state, stress, out, sink));
    }

    fn linearise_with(
        &self,
        state: &State,
        drive: &PrescribedMotion,
        (pattern, tangent): (&Pattern, &mut Tangent),
        add_elements: impl FnOnce(&mut Residual, &mut Sink) + Send,
    ) -> Residual {
        let mut out = self.start_residual(state);
        let out = self.install(|| {
            let mut sink = Sink::new(self, out.bases.clone(), drive, pattern, tangent);
            add_elements(&mut out, &mut sink);
            self.add_contact(Request { zones: false, tangent: true }, &mut out, Some(&mut sink));
            self.add_electrostatics(&mut out, Some(&mut sink));
            self.add_loads(state, &mut out, Some(&mut sink));
            self.add_hinges(&out.gradient, (pattern, &out.bases), sink.values);
            self.join(&mut out);
            out
        });
        out.bases.give_to_masters(&self.sharing, &mut tangent.drive);
        out
    }

    /// Nodes and their couplings with the present candidates.
    pub(crate) fn node_graph(&self) -> NodeGraph {
        self.node_graph_with(&[])
    }

    /// [`Engine::node_graph`] with all nodes of some lists coupled, too.
    pub(crate) fn node_graph_with(&self, coupled: &[Vec<usize>]) -> NodeGraph {
        let elements = self.elements.iter().flat_map(|element| {
            let nodes = self.nodes_of(element);
            (0..nodes.len()).flat_map(move |a| (a..nodes.len()).map(move |c| (nodes[a], nodes[c])))
        });
        let side = &self.contact;
        let contacts = side.coupled().flat_map(|&[i, j]| {
            let (p, q) = (side.nodes[i as usize], side.nodes[j as usize]);
            [(p[0], q[0]), (p[0], q[1]), (p[1], q[0]), (p[1], q[1])]
        });
        let bodies = self.contact.coupled_by_bodies();
        let pairs =
            |nodes: &'_ Vec<usize>| nodes.iter().flat_map(|&a| nodes.iter().map(move |&c| (a, c))).collect::<Vec<_>>();
        NodeGraph::new(
            &self.equations,
            &self.sharing.owner,
            elements.chain(contacts).chain(bodies).chain(coupled.iter().flat_map(pairs)),
        )
    }

    fn join(&self, out: &mut Residual) {
        out.bases.give_to_masters(&self.sharing, &mut out.gradient);
        self.sharing.give_sizes(&mut out.magnitude);
        out.rounding = self.rounding_of_potential(out);
    }

    /// Rounding error of the potential \[F·L\]: of its parts, and of the strains and gaps that forces do work on, each
    /// of them a few units in the last place of a node spacing or of 1 rad.
    fn rounding_of_potential(&self, at: &Residual) -> f64 {
        let parts = at.potential.total().abs() + at.potential.elastic.total();
        let way = |k: usize| if k % 6 < 3 { self.scales.lever } else { 1.0 };
        let work: f64 = at.magnitude.iter().enumerate().map(|(k, force)| force * way(k)).sum();
        LAST_PLACES * f64::EPSILON * (parts + work)
    }

    pub(in crate::solve) fn start_residual(&self, state: &State) -> Residual {
        let n = 6 * self.num_nodes();
        Residual {
            gradient: vec![0.0; n],
            magnitude: vec![0.0; n],
            contact_gradient: vec![0.0; n],
            seam_moments: vec![0.0; self.model.rods.len()],
            bases: self.bases(state),
            ..Residual::default()
        }
    }

    /// Per unknown increments of supported nodes, `None` when nothing moves.
    fn prescribed(&self, drive: &PrescribedMotion) -> Option<Vec<f64>> {
        if drive.nodes.is_empty() {
            return None;
        }
        let mut all = vec![0.0; 6 * self.num_nodes()];
        drive.add_to(&mut all);
        Some(all)
    }
}

#[cfg(test)]
mod tests;
