//! Second-order forces of a step: changes of the rods' strains and of the gaps beyond their linear prediction,
//! times their stiffness.

use crate::contact::curve::Cubic;
use crate::contact::potential::second_order::{second_order_of_gaps, stiffness_of_gaps};
use crate::contact::potential::surface::{self, SurfaceContact, point_of};
use crate::contact::potential::{self, ContactPair, Pressures, Request};
use crate::math::handles::Handles;
use crate::math::{Vec3, parallel};
use crate::solve::measures::AT_ONCE;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::carried_bodies::BodyMotion;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

impl Engine {
    /// Adds to `forces` (six per node) Σ k e ∂gap/∂x of the contacts of `residual`, the gradient at `state` with its
    /// tangent: e is the change of gaps beyond the one that `increment` predicted, at the present points of contact.
    /// Strands that were nowhere in contact push with the forces they have `there`.
    pub(crate) fn add_contact_second_order(
        &self,
        (state, increment): (&State, &[f64]),
        residual: &Residual,
        there: &Residual,
        forces: &mut [f64],
    ) {
        let side = &self.contact;
        let mut known = vec![false; side.nodes.len()];
        self.add_terms(
            &residual.contact_pairs,
            forces,
            |term| {
                let (cubics, change) = side.motion_of(term, state, increment);
                second_order_of_gaps(term, [&cubics[0], &cubics[1]], &change, &side.set)
            },
            |term, gone| [term.slave, gone[0], gone[1]].into_iter().for_each(|segment| known[segment] = true),
        );
        self.add_new(there, &known, forces);
        self.add_new_at_surfaces(residual, there, forces);
        self.add_surfaces_of(residual, (state, increment), forces, |now, linear| now - linear);
    }

    /// Adds to `forces` Σ k e ∂gap/∂x of the contacts of `residual` with obstacles, e made of the change of the gap at
    /// each point in contact up to where contact now is, and of the linear one that `increment` predicts from `state`
    /// \[L\].
    fn add_surfaces_of(
        &self,
        residual: &Residual,
        (state, increment): (&State, &[f64]),
        forces: &mut [f64],
        e: impl Fn(f64, f64) -> f64,
    ) {
        let side = &self.contact;
        for contact in &residual.surface_contacts {
            let cubic = side.cubic(state, contact.segment);
            let linear = side.motion(state, increment, contact.segment).linear;
            let surfaces = [side.surface_in(state, contact.surface), side.surfaces[contact.surface]];
            let body = BodyMotion::of(side, contact.surface, increment);
            let cubics = [cubic.b, side.set.segments[contact.segment].b];
            let [then, now] = [0, 1].map(|k| cubics[k].map(|b| b - surfaces[k].point()));
            let change = |u: f64, normal: &Vec3| {
                let arms = [&then, &now].map(|r| point_of(r, u));
                let [before, after] = [0, 1].map(|k| surfaces[k].distance(&arms[k]));
                e(after - before, normal.dot(&(point_of(&linear, u) - body.at(&arms[0]))))
            };
            let handles = Handles::of(&cubic.b);
            let (nodes, count) = side.nodes_at_surface(contact.segment, contact.surface);
            add_at(&nodes[..count], &contact.of_changes(&handles, change), forces);
        }
    }

    /// Adds the forces of obstacles on segments in contact `there`, where contact now is, that were not before.
    fn add_new_at_surfaces(&self, residual: &Residual, there: &Residual, forces: &mut [f64]) {
        let side = &self.contact;
        let offset = |segment, surface| side.offset_to_surface(segment, surface);
        let pressures = Pressures::of(side.law, &offset);
        let at = |contact: &SurfaceContact| (contact.segment, contact.surface);
        // both are in the order of segments and obstacles
        let is_new =
            |contact: &&SurfaceContact| residual.surface_contacts.binary_search_by_key(&at(contact), at).is_err();
        for contact in there.surface_contacts.iter().filter(is_new) {
            if let Some(term) = surface::term(&side.set, &side.surfaces, at(contact), &pressures, Request::default()) {
                let (nodes, count) = side.nodes_at_surface(contact.segment, contact.surface);
                add_at(&nodes[..count], &term.gradient, forces);
            }
        }
    }

    /// Adds the forces of slaves in contact `there`, where contact now is, that are not known.
    fn add_new(&self, there: &Residual, known: &[bool], forces: &mut [f64]) {
        let new = there.contact_pairs.iter().filter(|pair| !known[pair.slave]);
        let mut pairs: Vec<[u32; 2]> =
            new.map(|m| [m.slave.min(m.master) as u32, m.slave.max(m.master) as u32]).collect();
        pairs.dedup();
        self.add_contact_of(&pairs, |pair| !known[pair.slave], forces);
    }

    /// Adds to `forces` (six per node) the gradient of the contact potential, of these candidate pairs as far as they
    /// are `wanted`, where contact now is.
    pub(crate) fn add_contact_of(&self, pairs: &[[u32; 2]], wanted: impl Fn(&ContactPair) -> bool, forces: &mut [f64]) {
        if pairs.is_empty() {
            return;
        }
        let side = &self.contact;
        let geometry = potential::ContactGeometry::by_ends(&side.set);
        let offset = |slave, master| side.offset(slave, master);
        let pressures = Pressures::of(side.law, &offset);
        for batch in pairs.chunks(AT_ONCE) {
            let found = self.install(|| potential::evaluate_ends(&geometry, batch, &pressures, Request::default()));
            for term in found.into_iter().flatten().filter(|term| wanted(&term.pair)) {
                side.scatter(&term.pair, &term.gradient, forces);
            }
        }
    }

    /// Forces (six per node) that the stiffness of contact along its normals makes of a motion from `state`, where the
    /// terms of `residual` were evaluated with the tangent: their pressures are −k times the change of the gap.
    pub(crate) fn contact_stiffness_force(&self, state: &State, increment: &[f64], residual: &Residual) -> Vec<f64> {
        let mut forces = vec![0.0; increment.len()];
        let side = &self.contact;
        let gradient = |term: &ContactPair| {
            let (cubics, change) = side.motion_of(term, state, increment);
            (stiffness_of_gaps(term, [&cubics[0], &cubics[1]], &change), ())
        };
        self.add_terms(&residual.contact_pairs, &mut forces, gradient, |_, ()| {});
        self.add_surfaces_of(residual, (state, increment), &mut forces, |_, linear| linear);
        forces
    }

    /// Adds the gradients of contacts to nodal forces; their other results go to `told`, in order.
    fn add_terms<R: Send>(
        &self,
        terms: &[ContactPair],
        forces: &mut [f64],
        gradient: impl Fn(&ContactPair) -> ([f64; 24], R) + Sync,
        mut told: impl FnMut(&ContactPair, R),
    ) {
        let side = &self.contact;
        for batch in terms.chunks(AT_ONCE) {
            let found = self.install(|| parallel::map(batch.len(), parallel::DEAR, &|k| gradient(&batch[k])));
            for (term, (gradient, rest)) in batch.iter().zip(found) {
                side.scatter(term, &gradient, forces);
                told(term, rest);
            }
        }
    }
}

/// Adds six numbers for each of some nodes to those of all.
fn add_at(nodes: &[usize], gradient: &[f64], forces: &mut [f64]) {
    for (&node, force) in nodes.iter().zip(gradient.chunks_exact(6)) {
        forces[6 * node..6 * node + 6].iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
    }
}

impl ContactSide {
    /// Adds the gradient of a contact, at both ends of both segments, to nodal forces.
    fn scatter(&self, pair: &ContactPair, gradient: &[f64; 24], forces: &mut [f64]) {
        add_at(&self.nodes_of(pair), gradient, forces);
    }

    /// Slave and master of a term at a state and the linear motion of their control points.
    fn motion_of(&self, term: &ContactPair, state: &State, increment: &[f64]) -> ([Cubic; 2], [Vec3; 8]) {
        let [own, other] = [term.slave, term.master].map(|segment| self.motion(state, increment, segment).linear);
        let change = std::array::from_fn(|m| if m < 4 { own[m] } else { other[m - 4] });
        ([term.slave, term.master].map(|segment| self.cubic(state, segment)), change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::{Contact, ContactLaw, Model, NodeRef, Support};
    use crate::solve::problem::assembly::Tangent;
    use crate::solve::problem::prescribed_motion::PrescribedMotion;

    const RADIUS: f64 = 0.1;
    const OVERLAP: f64 = 0.01;
    const LENGTH: f64 = 1.5;

    /// Two rods in contact: the lower along x, the upper parallel to it, end above end, or across the middle of it.
    fn pair(across: bool) -> Engine {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, RADIUS);
        let rod = |name: &str, start: Vec3, direction: Vec3| {
            let shape = Shape::Line { start, direction, length: LENGTH };
            Rod::new(name, &shape, RodMesh::open(5, 3), section, Natural::Straight).unwrap()
        };
        let up = Vec3::z() * (2.0 * RADIUS - OVERLAP);
        let middle = Vec3::x() * (0.52 * LENGTH);
        let (start, direction) =
            if across { (middle - Vec3::y() * (0.47 * LENGTH), Vec3::y()) } else { (Vec3::zeros(), Vec3::x()) };
        let rods = vec![rod("lower", Vec3::zeros(), Vec3::x()), rod("upper", start + up, direction)];
        let supports = (0..2).map(|rod| Support::clamp(NodeRef { rod, node: 0 })).collect();
        let contact = Contact { law: ContactLaw::Penalty { stiffness: 1.0 } };
        Engine::new(Model { rods, supports, contact, ..Model::default() }, None).unwrap()
    }

    /// Second-order force of contact if the upper rod is moved by `by`, as the force on each rod over the law's
    /// stiffness \[L²\].
    fn moved(across: bool, by: Vec3) -> [Vec3; 2] {
        let mut engine = pair(across);
        let state = engine.state().clone();
        engine.update_contact(&state).unwrap();
        let pattern = engine.node_graph().natural();
        let residual =
            engine.linearise(&state, None, &PrescribedMotion::default(), (&pattern, &mut Tangent::default()));
        assert!(!residual.contact_pairs.is_empty());
        let mut increment = vec![0.0; 6 * engine.num_nodes()];
        for node in engine.first_node[1]..engine.first_node[2] {
            increment[6 * node..6 * node + 3].copy_from_slice(by.as_slice());
        }
        let there = engine.retract(&state, &increment, 1.0);
        engine.update_contact(&there).unwrap();
        let after = engine.residual_of_trial(&there);
        let mut forces = vec![0.0; 6 * engine.num_nodes()];
        engine.add_contact_second_order((&state, &increment), &residual, &after, &mut forces);
        [0, 1].map(|rod| {
            let nodes = engine.nodes(rod);
            let sum: Vec3 = nodes.map(|n| Vec3::new(forces[6 * n], forces[6 * n + 1], forces[6 * n + 2])).sum();
            sum / engine.contact_stiffness()
        })
    }

    /// Strands that slide sideways come apart by √(d² + s²) − d, whether they are still in contact there or not; the
    /// forces that it asks for lie along the normal of the start.
    #[test]
    fn sideways_sliding_opens_gaps_by_second_order() {
        let distance = 2.0 * RADIUS - OVERLAP;
        for s in [1e-3, 0.02, 0.1, 0.3] {
            let expected = LENGTH * s * s / (distance.hypot(s) + distance);
            let [lower, upper] = moved(false, Vec3::y() * s);
            assert!((upper - Vec3::z() * expected).norm() < 1e-9 * expected, "{s} {upper} {expected}");
            assert!((lower + upper).norm() < 1e-9 * expected);
        }
    }

    /// Where strands cross, motions along either, past joints, are predicted exactly; of strands along each other,
    /// motions along the normal, into or out of contact.
    #[test]
    fn motions_along_crossing_strands_and_along_the_normal_are_no_surprise() {
        let cases =
            [(true, [0.4, 0.0, 0.0]), (true, [-0.1, 0.5, 0.0]), (false, [0.0, 0.0, 0.03]), (false, [0.0, 0.0, -0.05])];
        for (across, by) in cases {
            let forces = moved(across, Vec3::from(by));
            assert!(forces.iter().all(|f| f.norm() < 1e-12), "{by:?} {forces:?}");
        }
    }
}
