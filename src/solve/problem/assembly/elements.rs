//! Contributions of elements, and their strains and stresses.

use super::scatter::{TermBatch, TermKind, batch_size};
use super::{Residual, Sink};
use crate::math::{Quat, Vec3, parallel};
use crate::rod::element::{self, ElementOutput, ElementProperties, ElementTangent, MAX_DOF, Strain, Stress, evaluate};
use crate::solve::measures::AT_ONCE;
use crate::solve::problem::engine::{Element, Engine};
use crate::solve::problem::state::State;

impl Engine {
    /// Gradient and potential of all elements.
    pub(in crate::solve) fn add_element_gradients(&self, state: &State, out: &mut Residual) {
        for first in (0..self.elements.len()).step_by(AT_ONCE) {
            let count = AT_ONCE.min(self.elements.len() - first);
            let results = parallel::map(count, parallel::DEAR, &|k| self.element_output(first + k, state, None, None));
            for (k, result) in results.iter().enumerate() {
                self.add_element_gradient(first + k, result, state, out);
            }
        }
    }

    /// Gradient, potential and tangent of all elements; `predicted` are the stresses of mixed-integration-point Newton,
    /// three per element.
    pub(super) fn add_elements(
        &self,
        state: &State,
        predicted: Option<&[[Strain; 3]]>,
        out: &mut Residual,
        sink: &mut Sink,
    ) {
        let mut results = std::mem::take(&mut sink.scratch.elements);
        let blank = (ElementOutput::default(), [[0.0; MAX_DOF]; MAX_DOF]);
        let at_once = batch_size();
        results.resize(at_once.min(self.elements.len()), blank);
        for first in (0..self.elements.len()).step_by(at_once) {
            let count = at_once.min(self.elements.len() - first);
            parallel::each(&mut results[..count], parallel::DEAR, &|k, (result, blocks)| {
                *blocks = [[0.0; MAX_DOF]; MAX_DOF];
                let e = first + k;
                *result = self.element_output(e, state, predicted.map(|p| &p[e]), Some(blocks));
            });
            let results = &results[..count];
            for (k, (result, _)) in results.iter().enumerate() {
                self.add_element_gradient(first + k, result, state, out);
            }
            let nodes = |k: usize| {
                let element = &self.elements[first + k];
                (element.nodes, self.nodes_of(element).len())
            };
            sink.add_batch(&TermBatch {
                kind: TermKind::Element,
                first,
                count,
                nodes: &nodes,
                blocks: &|k| Some(&results[k].1),
            });
        }
        sink.scratch.elements = results;
    }

    /// Gradient of all elements, and of their tangent the part that is due to these stresses, without Bᵀ C B.
    pub(super) fn add_geometric_tangent(
        &self,
        state: &State,
        stress: &[[Stress; 3]],
        out: &mut Residual,
        sink: &mut Sink,
    ) {
        self.add_element_gradients(state, out);
        for (e, element) in self.elements.iter().enumerate() {
            let body = self.body(e);
            let body = ElementProperties { material: body.material.without_stiffness(), ..body };
            let (nodes, reference) = (self.element_nodes(state, element), self.reference[element.rod].of(e));
            let mut blocks = [[0.0; MAX_DOF]; MAX_DOF];
            evaluate(&body, &nodes, &reference, Some(&stress[e]), Some(&mut blocks));
            sink.add(self.nodes_of(element), &blocks);
        }
    }

    /// Forces Bᵀ C B x on the nodes, six numbers each, of a motion x. Strains are differences of motions, so rounding
    /// acts as small strains do, which balance; that of sums in a matrix acts as forces on the whole, which slender
    /// rods yield to.
    pub(in crate::solve) fn material_product(&self, state: &State, motion: &[f64]) -> Vec<f64> {
        // strains that stay as they are, in place of the linear change
        let (_, mut forces) = self.elastic_second_order(state, state, motion);
        forces.iter_mut().for_each(|force| *force = -*force);
        forces
    }

    /// Nodes of an element among all.
    pub(in crate::solve) fn nodes_of<'a>(&self, element: &'a Element) -> &'a [usize] {
        &element.nodes[..=self.model.rods[element.rod].order]
    }

    pub(in crate::solve) fn element_output(
        &self,
        e: usize,
        state: &State,
        predicted: Option<&[Strain; 3]>,
        tangent: Option<&mut ElementTangent>,
    ) -> ElementOutput {
        let element = &self.elements[e];
        let nodes = self.element_nodes(state, element);
        let reference = self.reference[element.rod].of(e);
        evaluate(&self.body(e), &nodes, &reference, predicted, tangent)
    }

    pub(in crate::solve) fn seam_axis(&self, state: &State, rod: usize) -> Vec3 {
        let frame: Quat = state.seam_frame(rod, self.first_node[rod]);
        frame * Vec3::z()
    }

    fn add_element_gradient(&self, e: usize, result: &ElementOutput, state: &State, out: &mut Residual) {
        let element = &self.elements[e];
        let count = self.model.rods[element.rod].order + 1;
        for a in 0..count {
            let base = 6 * element.nodes[a];
            for k in 0..6 {
                out.gradient[base + k] += result.residual[6 * a + k];
                out.magnitude[base + k] += result.residual[6 * a + k].abs();
            }
        }
        out.potential.elastic += result.energy;
        if element.closes {
            let moment = &result.residual[6 * (count - 1) + 3..6 * count];
            out.seam_moments[element.rod] =
                self.seam_axis(state, element.rod).dot(&Vec3::new(moment[0], moment[1], moment[2]));
        }
    }

    /// Stresses C(ε + B Δx) at all points, predicted by mixed-integration-point Newton for a linear step.
    pub(crate) fn predicted_stress(&self, state: &State, increment: &[f64]) -> Vec<[Stress; 3]> {
        let predict = |e: usize| self.predict_element(e, state, increment);
        self.install(|| parallel::map(self.elements.len(), parallel::DEAR, &predict))
    }

    /// Stresses C ε at all points.
    pub(crate) fn actual_stress(&self, state: &State) -> Vec<[Stress; 3]> {
        let stress = |e: usize| -> [Stress; 3] {
            let strain = self.element_strain(e, state);
            let material = self.body(e).material;
            std::array::from_fn(|g| material.stress(g, &strain[g]))
        };
        self.install(|| parallel::map(self.elements.len(), parallel::DEAR, &stress))
    }

    /// [`Engine::actual_stress`] with shear forces and tension from elsewhere, if there are any.
    pub(crate) fn stress_with(&self, state: &State, forces: &[[[f64; 3]; 3]]) -> Vec<[Stress; 3]> {
        let mut stress = self.actual_stress(state);
        for (point, force) in stress.iter_mut().flatten().zip(forces.iter().flatten()) {
            point[..3].copy_from_slice(force);
        }
        stress
    }

    /// Strains minus reference at the points of an element.
    pub(crate) fn element_strain(&self, e: usize, state: &State) -> [Strain; 3] {
        let element = &self.elements[e];
        let nodes = self.element_nodes(state, element);
        let raw = element::raw_strains(self.table(element.rod), &nodes, self.element_length(element.rod));
        let reference = self.reference[element.rod].of(e);
        std::array::from_fn(|g| std::array::from_fn(|i| raw[g][i] - reference[g][i]))
    }

    fn predict_element(&self, e: usize, state: &State, increment: &[f64]) -> [Strain; 3] {
        let element = &self.elements[e];
        let nodes = self.element_nodes(state, element);
        let local = self.local_increment(element, increment);
        element::predicted_stress(&self.body(e), &nodes, &self.reference[element.rod].of(e), &local)
    }

    /// Increment of the element's own nodes.
    pub(in crate::solve) fn local_increment(&self, element: &Element, increment: &[f64]) -> [f64; MAX_DOF] {
        let count = self.model.rods[element.rod].order + 1;
        let mut local = [0.0; MAX_DOF];
        for a in 0..count {
            local[6 * a..6 * a + 6].copy_from_slice(&increment[6 * element.nodes[a]..6 * element.nodes[a] + 6]);
        }
        local
    }

    /// C e per integration point and Bᵀ C e summed over elements, six per node, for the step from `state` to `moved`:
    /// see [`element::second_order_force`].
    pub(crate) fn elastic_second_order(
        &self,
        state: &State,
        moved: &State,
        increment: &[f64],
    ) -> (Vec<[Strain; 3]>, Vec<f64>) {
        let mut out = vec![0.0; increment.len()];
        let mut stresses = Vec::with_capacity(self.elements.len());
        self.install(|| {
            for (batch_index, batch) in self.elements.chunks(AT_ONCE).enumerate() {
                let force = |k: usize| {
                    let element: &Element = &batch[k];
                    element::second_order_force(
                        &self.body(batch_index * AT_ONCE + k),
                        &self.element_nodes(state, element),
                        &self.element_nodes(moved, element),
                        &self.local_increment(element, increment),
                    )
                };
                let forces = parallel::map(batch.len(), parallel::DEAR, &force);
                for (k, (stress, force)) in forces.iter().enumerate() {
                    stresses.push(*stress);
                    let element = &self.elements[batch_index * AT_ONCE + k];
                    for a in 0..=self.model.rods[element.rod].order {
                        for i in 0..6 {
                            out[6 * element.nodes[a] + i] += force[6 * a + i];
                        }
                    }
                }
            }
        });
        (stresses, out)
    }
}

/// Entry of a tangent whose blocks are stored above the diagonal.
pub(in crate::solve) fn symmetric(tangent: &ElementTangent, row: usize, col: usize) -> f64 {
    if row / 6 <= col / 6 { tangent[row][col] } else { tangent[col][row] }
}
