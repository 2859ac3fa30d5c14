//! Gradient, tangent and potential of the whole problem at a state, the sums over elements, contact and loads. Contact
//! must have been brought up to date with the state before (`Engine::update_contact`).

mod contact;
mod elements;
mod loads;

pub(in crate::solve) use elements::symmetric;

use crate::contact::potential::surface::SurfaceContact;
use crate::contact::potential::{ContactPair, Request};
use crate::error::SolveError;
use crate::rod::element::Strain;
use crate::solve::measures::LAST_PLACES;
use crate::solve::problem::engine::{Engine, give_to_masters};
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::state::State;
use crate::solve::problem::swivel::Bases;
use crate::sparse::{NodeGraph, Pattern};

/// Elastic energies by kind and the rest of the potential \[F·L\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Potential {
    /// Stretch, shear, bend, twist.
    pub(crate) elastic: [f64; 4],
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
        self.elastic.iter().sum::<f64>() + self.contact + self.electrostatic + self.load
    }

    /// Sum of all parts but stretch and shear, which are nearly rigid: errors of a guess show in them first, and the first
    /// correction mends them.
    pub(crate) fn without_stretch_and_shear(&self) -> f64 {
        let [_, _, bending, twisting] = self.elastic;
        bending + twisting + self.contact + self.electrostatic + self.load
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
}

/// Second derivatives with respect to the six unknowns of each of up to four nodes; blocks above the diagonal, those on
/// it in full.
type Blocks = [[f64; 24]; 24];

/// Where second derivatives are added up.
pub(in crate::solve) struct Sink<'a> {
    pattern: &'a Pattern,
    tangent: &'a mut Tangent,
    bases: Bases,
    /// Prescribed increments, six per node, if supports move.
    prescribed: Option<Vec<f64>>,
}

impl<'a> Sink<'a> {
    fn new(
        engine: &Engine,
        bases: Bases,
        drive: &PrescribedMotion,
        pattern: &'a Pattern,
        tangent: &'a mut Tangent,
    ) -> Self {
        if tangent.values.capacity() < pattern.num_entries() {
            tangent.values = Vec::new();
            tangent.values.reserve_exact(pattern.num_entries());
        }
        tangent.values.clear();
        tangent.values.resize(pattern.num_entries(), 0.0);
        tangent.drive.clear();
        tangent.drive.resize(6 * engine.num_nodes(), 0.0);
        Self { pattern, tangent, bases, prescribed: engine.prescribed(drive) }
    }

    fn add(&mut self, nodes: &[usize], blocks: &Blocks) {
        for (a, &p) in nodes.iter().enumerate() {
            for (c, &q) in nodes.iter().enumerate().skip(a) {
                let entry = |i: usize, j: usize| blocks[6 * a + i][6 * c + j];
                let at = (p, q);
                self.bases.add_block(self.pattern, &mut self.tangent.values, at, entry);
                if p == q && a != c {
                    self.bases.add_block(self.pattern, &mut self.tangent.values, at, |i, j| entry(j, i));
                }
                let Some(all) = &self.prescribed else { continue };
                for i in 0..6 {
                    for j in 0..6 {
                        self.tangent.drive[6 * p + i] += entry(i, j) * all[6 * q + j];
                        if a != c {
                            self.tangent.drive[6 * q + j] += entry(i, j) * all[6 * p + i];
                        }
                    }
                }
            }
        }
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
        self.install(|| {
            let mut out = self.start_residual(state);
            self.add_element_gradients(state, &mut out);
            self.add_contact(request, &mut out, None);
            self.add_electrostatics(&mut out, None);
            self.add_loads(state, &mut out, None);
            self.join(&mut out);
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
        (pattern, tangent): (&Pattern, &mut Tangent),
    ) -> Residual {
        let mut out = self.start_residual(state);
        let mut sink = Sink::new(self, out.bases.clone(), drive, pattern, tangent);
        let out = self.install(|| {
            self.add_elements(state, predicted, &mut out, &mut sink);
            self.add_contact(Request { zones: false, tangent: true }, &mut out, Some(&mut sink));
            self.add_electrostatics(&mut out, Some(&mut sink));
            self.add_loads(state, &mut out, Some(&mut sink));
            self.join(&mut out);
            out
        });
        give_to_masters(&mut tangent.drive, &self.master);
        out
    }

    /// Nodes and their couplings with the present candidates.
    pub(crate) fn node_graph(&self) -> NodeGraph {
        let elements = self.elements.iter().flat_map(|element| {
            let count = self.model.rods[element.rod].order + 1;
            (0..count).flat_map(move |a| (a..count).map(move |c| (element.nodes[a], element.nodes[c])))
        });
        let contacts = self.contact.iter().flat_map(|side| {
            side.coupled().flat_map(|&[i, j]| {
                let (p, q) = (side.nodes[i as usize], side.nodes[j as usize]);
                [(p[0], q[0]), (p[0], q[1]), (p[1], q[0]), (p[1], q[1])]
            })
        });
        NodeGraph::new(&self.equations, &self.master, elements.chain(contacts))
    }

    fn join(&self, out: &mut Residual) {
        give_to_masters(&mut out.gradient, &self.master);
        give_to_masters(&mut out.magnitude, &self.master);
        out.rounding = self.rounding_of_potential(out);
    }

    /// Rounding error of the potential \[F·L\]: of its parts, and of the strains and gaps that forces do work on, each of
    /// them a few units in the last place of a node spacing or of 1 rad.
    fn rounding_of_potential(&self, at: &Residual) -> f64 {
        let parts = at.potential.total().abs() + at.potential.elastic.iter().sum::<f64>();
        let way = |k: usize| if k % 6 < 3 { self.scales.lever } else { 1.0 };
        let work: f64 = at.magnitude.iter().enumerate().map(|(k, force)| force * way(k)).sum();
        LAST_PLACES * f64::EPSILON * (parts + work)
    }

    pub(in crate::solve) fn start_residual(&self, state: &State) -> Residual {
        let n = 6 * self.num_nodes();
        Residual {
            gradient: vec![0.0; n],
            magnitude: vec![0.0; n],
            seam_moments: vec![0.0; self.model.rods.len()],
            bases: Bases::at(&self.swivels, state),
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
