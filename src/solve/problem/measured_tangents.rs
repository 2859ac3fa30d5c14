//! The tangents of contact centrelines ([`MaterialTangents`]) measured on a state, by the strains at the integration
//! points, which are the most exact numbers of an element: from the state that a load step begins with, and again from
//! the state at rest, where they have become others.

use crate::math::quaternion::spin;
use crate::math::shape_functions::lagrange_weight;
use crate::math::{Vec3, parallel};
use crate::rod::element::raw_strains;
use crate::solve::problem::contact_tangents::MaterialTangents;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::state::State;

/// Deviation of fitted tangents, rad, from which they are renewed, because forces change by as little.
const FOLLOWED: f64 = 1e-3;
/// Shear from which tangents are fitted, because up to it directors are off by a hundredth.
const SHEARED: f64 = 0.1;

impl Engine {
    /// Tangents for a state: d3 along rods that are nowhere sheared by more than [`SHEARED`].
    pub(in crate::solve) fn tangents_of(&self, state: &State) -> MaterialTangents {
        self.replaced(&MaterialTangents::directors(self.num_nodes()), state)
    }

    /// The tangents of a state along rods where one of those known is off by more than [`FOLLOWED`], or [`SHEARED`]
    /// where they are directors. A rod has either all its tangents or none, because a jump from one node to the next
    /// would be a bend.
    fn replaced(&self, MaterialTangents(known): &MaterialTangents, state: &State) -> MaterialTangents {
        let mut tangents = self.measured_tangents(state);
        for nodes in (0..self.model.rods.len()).map(|rod| self.nodes(rod)) {
            let is_sheared = nodes.clone().any(|n| known[n] != Vec3::z());
            let tol = if is_sheared { FOLLOWED } else { SHEARED };
            let is_off = |n: usize| known[n].angle(&tangents[n]) > tol;
            if !nodes.clone().any(is_off) {
                tangents[nodes.clone()].copy_from_slice(&known[nodes]);
            }
        }
        MaterialTangents(tangents)
    }

    /// The tangents that the strains of a state tell: at each node the mean of those of its elements.
    fn measured_tangents(&self, state: &State) -> Vec<Vec3> {
        let at_nodes = parallel::map(self.elements.len(), parallel::CHEAP, &|e| self.tangents_in(state, e));
        let mut sums = vec![Vec3::zeros(); self.num_nodes()];
        for (element, tangents) in self.elements.iter().zip(&at_nodes) {
            let order = self.model.rods[element.rod].order;
            for (a, tangent) in tangents[..=order].iter().enumerate() {
                let through_seam = element.closes && a == order;
                // from the frame at s = L to that at s = 0
                let own = if through_seam { spin(state.seams[element.rod]) * tangent } else { *tangent };
                sums[element.nodes[a]] += own;
            }
        }
        sums.into_iter().map(|sum| sum.try_normalize(0.0).unwrap_or(Vec3::z())).collect()
    }

    /// r′ at the nodes of an element: the polynomial through its values at the integration points.
    fn tangents_in(&self, state: &State, e: usize) -> [Vec3; 4] {
        let element = &self.elements[e];
        let (table, length) = (self.table(element.rod), self.element_length(element.rod));
        let strains = raw_strains(table, &self.element_nodes(state, element), length);
        let v = |g: usize| Vec3::new(strains[g][0], strains[g][1], strains[g][2]);
        let weight = |g: usize, a: usize| {
            lagrange_weight(table.order, |k| table.rule.points[k], g, a as f64 / table.order as f64)
        };
        std::array::from_fn(|a| (0..table.order).map(|g| v(g) * weight(g, a)).sum())
    }

    /// Gives the contact centrelines the tangents of the present state where it is sheared. Candidates are looked for
    /// anew where they are next needed.
    pub(in crate::solve) fn take_tangents(&mut self) {
        if !self.contact.is_empty() {
            self.contact.tangents = self.tangents_of(&self.state);
        }
    }

    /// Gives the contact centrelines the tangents of the present state where theirs have become others; whether there
    /// are any.
    pub(in crate::solve) fn follow_tangents(&mut self) -> bool {
        if self.contact.is_empty() {
            return false;
        }
        let followed = self.replaced(&self.contact.tangents, &self.state);
        let moved = followed != self.contact.tangents;
        self.contact.tangents = followed;
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quaternion::exp;
    use crate::rod::{Natural, Rod, RodMesh, Section, Shape};
    use crate::scene::Model;
    use crate::solve::problem::prescribed_motion::{PrescribedMotion, twist};
    use crate::solve::search::workspace::Workspace;

    /// Rings of radius 1, one above the other, whose sections are tilted about their normal.
    fn tilted_rings(num_rods: usize, (angle, seam): (f64, f64), radius: f64) -> Engine {
        let section = Section::isotropic(1.0, 1.0, 1e4, 1e4, radius);
        let ring = |k: usize| {
            let center = Vec3::z() * (2.5 * k as f64);
            let shape = Shape::Circle { length: std::f64::consts::TAU, center, normal: Vec3::z() };
            Rod::new(&format!("ring {k}"), &shape, RodMesh::closed(16, 3), section, Natural::Straight).unwrap()
        };
        let rods = (0..num_rods).map(ring).collect();
        let mut engine = Engine::new(Model { rods, ..Model::default() }, None).unwrap();
        let mut state = engine.state.clone();
        twist(&engine, &mut state, 0, seam);
        state.frames.iter_mut().for_each(|frame| *frame = exp(&(Vec3::z() * angle)) * *frame);
        engine.set_state(state).unwrap();
        engine
    }

    fn tilted_ring(angle: f64) -> Engine {
        tilted_rings(1, (angle, 0.0), 0.1)
    }

    /// Between nodes the centreline is a circle however sections are tilted, also through the seam; with d3 for its
    /// tangents it would be up to 0.1 × tilt × spacing beside it.
    #[test]
    fn the_centreline_of_a_sheared_ring_is_a_circle() {
        for (angle, seam) in [(0.0, 0.0), (0.5, 0.0), (-0.3, 2.0)] {
            let mut engine = tilted_rings(1, (angle, seam), 0.1);
            let state = engine.state.clone();
            engine.update_contact(&state).unwrap();
            let side = &engine.contact;
            assert_eq!(side.tangents.are_sheared(), angle != 0.0);
            let points = side.set.segments.iter().flat_map(|s| (0..8).map(|k| s.point(f64::from(k) / 8.0)));
            let farthest = points.map(|r| (r.norm() - 1.0).abs()).fold(0.0, f64::max);
            assert!(farthest < 2e-5, "tilted by {angle}: {farthest:e}");
        }
    }

    /// Rods that are hardly sheared keep their directors, to the bit.
    #[test]
    fn hardly_sheared_rods_have_directors_for_tangents() {
        let mut engine = tilted_ring(0.09);
        assert!(!engine.tangents_of(&engine.state).are_sheared());
        assert!(!engine.follow_tangents());
        engine.state = tilted_ring(0.11).state;
        assert!(engine.follow_tangents());
        assert!(!engine.follow_tangents());
        // from then on they follow by less
        engine.state = tilted_ring(0.13).state;
        assert!(engine.follow_tangents());
    }

    /// Symptom: a thick rod turned at its end, sheared by a tenth, searched for 500 iterations. Mechanism: contact with
    /// tangents held in the frames does work on the spin of a rod, which nothing else resists.
    #[test]
    fn contact_of_sheared_rods_does_no_work_on_neutral_motions() {
        for num_rods in [1, 2] {
            let mut engine = tilted_rings(num_rods, (0.4, 0.0), 0.3);
            // folded until each touches itself, and the other one
            for p in &mut engine.state.positions {
                *p = Vec3::new(1.6 * p.x, p.y * (0.25 + 0.4 * p.x * p.x), 0.15 * p.x * p.y + 0.3 * p.z);
            }
            engine.take_tangents();
            let state = engine.state.clone();
            let mut workspace = Workspace::default();
            workspace.refresh(&mut engine, &state).unwrap();
            let contact = engine.residual(&state).contact_gradient;
            let stress = engine.actual_stress(&state);
            let residual = workspace.linearise(&engine, &state, &stress, &PrescribedMotion::default());
            let size = contact.iter().map(|f| f.abs()).fold(0.0, f64::max);
            for rod in 0..num_rods {
                let of_node = |forces: &[f64], n: usize| {
                    let moment = Vec3::new(forces[6 * n + 3], forces[6 * n + 4], forces[6 * n + 5]);
                    (state.frames[n] * Vec3::z()).dot(&moment)
                };
                let work = |forces: &[f64]| engine.nodes(rod).map(|n| of_node(forces, n)).sum::<f64>();
                assert!(work(&contact).abs() > 1e-4 * size, "{} {size}", work(&contact));
                assert!(work(&residual.gradient).abs() < 1e-9 * size, "{}", work(&residual.gradient));
            }
        }
    }
}
