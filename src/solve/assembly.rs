//! Gradient, tangent and potential of the whole problem at a state.

use rayon::prelude::*;

use crate::contact::detect::stiffness::Blocks;
use crate::contact::detect::{self, Besides, Meeting};
use crate::error::{InputError, SolveError};
use crate::math::quadrature::gauss;
use crate::math::shape_functions::lagrange;
use crate::math::{Quat, Vec3};
use crate::rod::element::{ElementOutput, ElementTangent, MAX_DOF, Six, evaluate};
use crate::solve::engine::{ContactSide, Element, Engine, contact_cubic_exactly, give_to_masters};
use crate::solve::state::{Drive, State};
use crate::sparse::Pattern;

/// Elements computed in parallel before one ordered scatter: bounds the buffer, not the result.
const BATCH: usize = 1024;
/// The same with their tangents, five kilobytes each: what a cache holds.
const TANGENTS: usize = 128;
/// Candidate pairs evaluated before their terms are scattered.
pub(super) const PAIRS: usize = 1024;

/// Elastic energies by kind and the rest of the potential \[F·L\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Potential {
    /// Stretch, shear, bend, twist.
    pub elastic: [f64; 4],
    /// Energy of the contact law.
    pub contact: f64,
    /// Minus the work of dead forces and pressure.
    pub load: f64,
}

impl Potential {
    /// Sum of all parts.
    pub fn total(&self) -> f64 {
        self.elastic.iter().sum::<f64>() + self.contact + self.load
    }
}

/// Everything first-order at a state.
#[derive(Debug, Clone, Default)]
pub struct Residual {
    /// Gradient of the potential, six per node, supported unknowns included (there it is the reaction).
    pub gradient: Vec<f64>,
    /// Per unknown: sum of absolute contributions, the size against which rounding and convergence are judged.
    pub magnitude: Vec<f64>,
    /// Potential.
    pub potential: Potential,
    /// Where there is contact.
    pub meetings: Vec<Meeting>,
    /// Gradient of the contact potential alone.
    pub(crate) contact_gradient: Vec<f64>,
    /// Per closed rod (per rod): derivative of the potential with respect to the seam angle \[F·L\], the twisting moment there.
    pub seam_moments: Vec<f64>,
}

/// Tangent in the pattern's values plus the load-step right-hand side.
#[derive(Debug, Default)]
pub struct Tangent {
    /// Upper values in the pattern.
    pub values: Vec<f64>,
    /// K_fp · drive per unknown (six per node).
    pub drive: Vec<f64>,
}

/// Geometry and candidates at a state, brought up to date once before gradient or tangent are asked for.
impl Engine {
    /// Moves the contact curves to `state` and refreshes candidates; true if the candidate list changed.
    pub(crate) fn update_contact(&mut self, state: &State) -> Result<bool, SolveError> {
        let Some(mut side) = self.contact.take() else { return Ok(false) };
        let pool = self.pool.take();
        let result = in_pool(pool.as_ref(), || side.update(state));
        self.pool = pool;
        self.contact = Some(side);
        result
    }

    /// Gradient (and potential) at `state` with the zones of contact; contact must be up to date for it.
    pub(crate) fn residual(&self, state: &State) -> Residual {
        self.residual_besides(state, Besides { zones: true, tangent: false })
    }

    /// [`Engine::residual`] for searches, which ask for no zones: it tells who is in contact.
    pub(crate) fn residual_of_trial(&self, state: &State) -> Residual {
        self.residual_besides(state, Besides::default())
    }

    fn residual_besides(&self, state: &State, besides: Besides) -> Residual {
        self.install(|| {
            let mut out = self.start_residual();
            for (batch_index, batch) in self.elements.chunks(BATCH).enumerate() {
                let results: Vec<ElementOutput> = batch
                    .par_iter()
                    .enumerate()
                    .map(|(k, _)| self.element_output(batch_index * BATCH + k, state, None, None))
                    .collect();
                for (k, result) in results.iter().enumerate() {
                    self.scatter_element_gradient(batch_index * BATCH + k, result, state, &mut out);
                }
            }
            self.add_contact_gradient(besides, &mut out, None);
            self.add_loads(state, &mut out, None);
            self.join(&mut out);
            out
        })
    }

    /// Whether contact exerts any force in the engine's state; contact must be up to date for it.
    pub(crate) fn is_touching(&self) -> bool {
        let near = self.contact.as_ref().is_some_and(|side| !side.broad_phase.pairs().is_empty());
        near && self.residual_of_trial(&self.state).contact_gradient.iter().any(|force| *force != 0.0)
    }

    /// Gradient and tangent at `state`, without zones; `predicted` are the stresses of mixed-integration-point Newton, three per element.
    pub(crate) fn linearise(
        &self,
        state: &State,
        predicted: Option<&[[Six; 3]]>,
        drive: &Drive,
        pattern: &Pattern,
        tangent: &mut Tangent,
    ) -> Residual {
        if tangent.values.capacity() < pattern.num_entries() {
            tangent.values = Vec::new();
            tangent.values.reserve_exact(pattern.num_entries());
        }
        tangent.values.clear();
        tangent.values.resize(pattern.num_entries(), 0.0);
        tangent.drive.clear();
        tangent.drive.resize(6 * self.num_nodes(), 0.0);
        let prescribed = self.prescribed(drive);
        self.install(|| {
            let mut out = self.start_residual();
            let mut results =
                vec![(ElementOutput::default(), [[0.0; MAX_DOF]; MAX_DOF]); TANGENTS.min(self.elements.len())];
            for first in (0..self.elements.len()).step_by(TANGENTS) {
                let count = TANGENTS.min(self.elements.len() - first);
                results[..count].par_iter_mut().with_min_len(8).enumerate().for_each(|(k, (result, block))| {
                    *block = [[0.0; MAX_DOF]; MAX_DOF];
                    let e = first + k;
                    *result = self.element_output(e, state, predicted.map(|p| &p[e]), Some(block));
                });
                for (k, (result, block)) in results[..count].iter().enumerate() {
                    self.scatter_element_gradient(first + k, result, state, &mut out);
                    self.scatter_element_tangent(first + k, block, prescribed.as_deref(), pattern, tangent);
                }
            }
            let besides = Besides { zones: false, tangent: true };
            self.add_contact_gradient(besides, &mut out, Some((pattern, prescribed.as_deref(), tangent)));
            self.add_loads(state, &mut out, Some((pattern, tangent)));
            self.join(&mut out);
            give_to_masters(&mut tangent.drive, &self.master);
            out
        })
    }

    /// Sparsity pattern for the present candidates.
    pub(crate) fn build_pattern(&self) -> Pattern {
        let elements = self.elements.iter().flat_map(|element| {
            let count = self.model.rods[element.rod].order + 1;
            (0..count).flat_map(move |a| (a..count).map(move |c| (element.nodes[a], element.nodes[c])))
        });
        let contacts = self.contact.iter().flat_map(|side| {
            side.broad_phase.pairs().iter().flat_map(|&[i, j]| {
                let (p, q) = (side.nodes[i as usize], side.nodes[j as usize]);
                [(p[0], q[0]), (p[0], q[1]), (p[1], q[0]), (p[1], q[1])]
            })
        });
        Pattern::joined(&self.free, &self.master, elements.chain(contacts))
    }

    /// Runs in the engine's own pool, if it has one.
    pub(crate) fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        in_pool(self.pool.as_ref(), work)
    }

    /// Stresses C(ε + B Δx) at all points: what mixed-integration-point Newton predicts for a linear step.
    pub(crate) fn predicted_stress(&self, state: &State, increment: &[f64]) -> Vec<[Six; 3]> {
        self.install(|| {
            (0..self.elements.len())
                .into_par_iter()
                .with_min_len(64)
                .map(|e| self.predict_element(e, state, increment))
                .collect()
        })
    }

    /// Stresses C ε at all points.
    pub(crate) fn actual_stress(&self, state: &State) -> Vec<[Six; 3]> {
        self.install(|| {
            (0..self.elements.len())
                .into_par_iter()
                .with_min_len(64)
                .map(|e| {
                    let strain = self.element_strain(e, state);
                    let material = &self.material[self.elements[e].rod];
                    strain.map(|six| std::array::from_fn(|i| material[i] * six[i]))
                })
                .collect()
        })
    }

    /// Strains minus reference at the points of an element.
    pub(crate) fn element_strain(&self, e: usize, state: &State) -> [Six; 3] {
        let element = &self.elements[e];
        let nodes = self.element_nodes(state, element);
        let raw = crate::rod::element::raw_strains(self.table(element.rod), &nodes, self.element_length(element.rod));
        let reference = self.reference[element.rod].of(e);
        std::array::from_fn(|g| std::array::from_fn(|i| raw[g][i] - reference[g][i]))
    }

    fn predict_element(&self, e: usize, state: &State, increment: &[f64]) -> [Six; 3] {
        let element = &self.elements[e];
        let nodes = self.element_nodes(state, element);
        let local = self.local_increment(element, increment);
        crate::rod::element::predicted_stress(
            &self.body(element.rod),
            &nodes,
            &self.reference[element.rod].of(e),
            &local,
        )
    }

    /// Increment of the element's own nodes.
    pub(super) fn local_increment(&self, element: &Element, increment: &[f64]) -> [f64; MAX_DOF] {
        let count = self.model.rods[element.rod].order + 1;
        let mut local = [0.0; MAX_DOF];
        for a in 0..count {
            local[6 * a..6 * a + 6].copy_from_slice(&increment[6 * element.nodes[a]..6 * element.nodes[a] + 6]);
        }
        local
    }

    /// C e per integration point and Bᵀ C e summed over elements, six per node, for the step from `state` to `moved`: see [`crate::rod::element::surprise_force`].
    pub(crate) fn elastic_surprise(
        &self,
        state: &State,
        moved: &State,
        increment: &[f64],
    ) -> (Vec<[Six; 3]>, Vec<f64>) {
        let mut out = vec![0.0; increment.len()];
        let mut stresses = Vec::with_capacity(self.elements.len());
        self.install(|| {
            for (batch_index, batch) in self.elements.chunks(BATCH).enumerate() {
                let forces: Vec<([Six; 3], [f64; MAX_DOF])> = batch
                    .par_iter()
                    .with_min_len(32)
                    .map(|element| {
                        crate::rod::element::surprise_force(
                            &self.body(element.rod),
                            &self.element_nodes(state, element),
                            &self.element_nodes(moved, element),
                            &self.local_increment(element, increment),
                        )
                    })
                    .collect();
                for (k, (stress, force)) in forces.iter().enumerate() {
                    stresses.push(*stress);
                    let element = &self.elements[batch_index * BATCH + k];
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

    fn join(&self, out: &mut Residual) {
        give_to_masters(&mut out.gradient, &self.master);
        give_to_masters(&mut out.magnitude, &self.master);
    }

    pub(super) fn start_residual(&self) -> Residual {
        let n = 6 * self.num_nodes();
        Residual {
            gradient: vec![0.0; n],
            magnitude: vec![0.0; n],
            seam_moments: vec![0.0; self.model.rods.len()],
            ..Residual::default()
        }
    }

    pub(super) fn element_output(
        &self,
        e: usize,
        state: &State,
        predicted: Option<&[Six; 3]>,
        tangent: Option<&mut ElementTangent>,
    ) -> ElementOutput {
        let element = &self.elements[e];
        let nodes = self.element_nodes(state, element);
        let mut out = ElementOutput::default();
        let reference = self.reference[element.rod].of(e);
        evaluate(&self.body(element.rod), &nodes, &reference, predicted, tangent, &mut out);
        out
    }

    pub(super) fn seam_axis(&self, state: &State, rod: usize) -> Vec3 {
        let frame: Quat = state.seam_frame(rod, self.first_node[rod]);
        frame * Vec3::z()
    }

    fn scatter_element_gradient(&self, e: usize, result: &ElementOutput, state: &State, out: &mut Residual) {
        let element = &self.elements[e];
        let count = self.model.rods[element.rod].order + 1;
        for a in 0..count {
            let base = 6 * element.nodes[a];
            for k in 0..6 {
                out.gradient[base + k] += result.residual[6 * a + k];
                out.magnitude[base + k] += result.residual[6 * a + k].abs();
            }
        }
        for (sum, energy) in out.potential.elastic.iter_mut().zip(result.energy) {
            *sum += energy;
        }
        if element.closes {
            let moment = &result.residual[6 * (count - 1) + 3..6 * count];
            out.seam_moments[element.rod] =
                self.seam_axis(state, element.rod).dot(&Vec3::new(moment[0], moment[1], moment[2]));
        }
    }

    /// Per unknown increments of supported nodes, `None` when nothing moves.
    fn prescribed(&self, drive: &Drive) -> Option<Vec<f64>> {
        if drive.nodes.is_empty() {
            return None;
        }
        let mut all = vec![0.0; 6 * self.num_nodes()];
        for &(node, displacement, rotation) in &drive.nodes {
            for k in 0..3 {
                all[6 * node + k] += displacement[k];
                all[6 * node + 3 + k] += rotation[k];
            }
        }
        Some(all)
    }

    #[allow(clippy::too_many_arguments)]
    fn scatter_element_tangent(
        &self,
        e: usize,
        block: &ElementTangent,
        prescribed: Option<&[f64]>,
        pattern: &Pattern,
        tangent: &mut Tangent,
    ) {
        let element = &self.elements[e];
        let count = self.model.rods[element.rod].order + 1;
        for a in 0..count {
            for c in a..count {
                let (p, q) = (element.nodes[a], element.nodes[c]);
                let entry = |i: usize, j: usize| block[6 * a + i][6 * c + j];
                pattern.add_block(&mut tangent.values, p, q, entry);
                if p == q && a != c {
                    pattern.add_block(&mut tangent.values, p, q, |i, j| entry(j, i));
                }
            }
        }
        let Some(all) = prescribed else { return };
        let local = self.local_increment(element, all);
        for row in 0..6 * count {
            let sum: f64 = (0..6 * count).map(|col| symmetric(block, row, col) * local[col]).sum();
            tangent.drive[6 * element.nodes[row / 6] + row % 6] += sum;
        }
    }

    fn add_contact_gradient(
        &self,
        besides: Besides,
        out: &mut Residual,
        mut tangent: Option<(&Pattern, Option<&[f64]>, &mut Tangent)>,
    ) {
        let Some(side) = &self.contact else { return };
        out.contact_gradient.resize(out.gradient.len(), 0.0);
        if side.broad_phase.pairs().is_empty() {
            return;
        }
        let ground = detect::Ground::of_set(&side.set);
        // second derivatives live for one part of the candidates only: five kilobytes a term
        for pairs in side.broad_phase.pairs().chunks(PAIRS) {
            let offset = |slave, master| side.offset(slave, master);
            let earlier = side.before.as_ref().filter(|_| tangent.is_some());
            let offset_before =
                |slave, master| earlier.map_or([0.0; 2], |(_, offsets)| side.at_ends(offsets, slave, master));
            let before = earlier.map(|(law, _)| (*law, &offset_before as &detect::Offsets));
            let pressures = detect::Pressures { law: side.law, offset: &offset, before };
            for found in detect::evaluate_ends(&ground, pairs, &pressures, besides).into_iter().flatten() {
                let nodes = side.nodes_of(&found.meeting);
                out.potential.contact += found.energy;
                for (node, force) in nodes.iter().zip(found.gradient.chunks_exact(6)) {
                    for k in 0..6 {
                        out.gradient[6 * node + k] += force[k];
                        out.contact_gradient[6 * node + k] += force[k];
                        out.magnitude[6 * node + k] += force[k].abs();
                    }
                }
                if let (Some((pattern, prescribed, tangent)), Some(blocks)) = (&mut tangent, found.tangent) {
                    scatter_contact(&nodes, &blocks, pattern, *prescribed, tangent);
                }
                out.meetings.push(found.meeting);
            }
        }
    }

    /// Dead forces and moments, line loads, pressure.
    pub(super) fn add_loads(&self, state: &State, out: &mut Residual, mut tangent: Option<(&Pattern, &mut Tangent)>) {
        let factor = state.load_factor;
        for load in &self.model.loads {
            let node = self.first_node[load.node.rod] + load.node.node;
            for k in 0..3 {
                add_load(out, 6 * node + k, factor * load.force[k]);
                add_load(out, 6 * node + 3 + k, factor * load.moment[k]);
            }
            out.potential.load -= factor * load.force.dot(&state.positions[node]);
        }
        for load in &self.model.line_loads {
            self.add_line_load(load.rod, load.force * factor, state, out);
        }
        for (rod, &pressure) in state.pressures.iter().enumerate().filter(|(_, p)| **p != 0.0) {
            let tangent = tangent.as_mut().map(|(pattern, tangent)| (*pattern, &mut **tangent));
            self.add_pressure(rod, pressure, state, out, tangent);
        }
    }

    fn add_line_load(&self, rod: usize, force: Vec3, state: &State, out: &mut Residual) {
        let weights = integrals(self.model.rods[rod].order).0;
        let length = self.element_length(rod);
        for element in self.elements.iter().filter(|e| e.rod == rod) {
            for a in 0..=self.model.rods[rod].order {
                let nodal = force * (weights[a] * length);
                let node = element.nodes[a];
                for k in 0..3 {
                    add_load(out, 6 * node + k, nodal[k]);
                }
                out.potential.load -= nodal.dot(&state.positions[node]);
            }
        }
    }

    /// Pressure p on a closed planar rod has the potential p × enclosed area ½∮(x dy − y dx).
    fn add_pressure(
        &self,
        rod: usize,
        pressure: f64,
        state: &State,
        out: &mut Residual,
        mut tangent: Option<(&Pattern, &mut Tangent)>,
    ) {
        let order = self.model.rods[rod].order;
        let skew = integrals(order).1;
        for element in self.elements.iter().filter(|e| e.rod == rod) {
            for a in 0..=order {
                for c in 0..=order {
                    // ½ p (N_a N_c' − N_a' N_c) x_a y_c
                    let factor = 0.5 * pressure * skew[a][c];
                    let (p, q) = (element.nodes[a], element.nodes[c]);
                    let (x, y) = (state.positions[p].x, state.positions[q].y);
                    out.potential.load += factor * x * y;
                    out.gradient[6 * p] += factor * y;
                    out.magnitude[6 * p] += (factor * y).abs();
                    out.gradient[6 * q + 1] += factor * x;
                    out.magnitude[6 * q + 1] += (factor * x).abs();
                    if let Some((pattern, tangent)) = &mut tangent {
                        // a diagonal block is symmetric: its upper part holds ∂²/∂x∂y once
                        pattern.add_block(
                            &mut tangent.values,
                            p,
                            q,
                            |i, j| if i == 0 && j == 1 { factor } else { 0.0 },
                        );
                    }
                }
            }
        }
    }
}

impl ContactSide {
    /// Moves the contact curves and refreshes candidates; true if the list changed.
    pub(crate) fn update(&mut self, state: &State) -> Result<bool, SolveError> {
        self.place(state);
        let earlier = self.before.iter().flat_map(|(_, offsets)| &offsets.values);
        let largest = self.offsets.values.iter().chain(earlier).copied().fold(0.0, f64::max);
        // in steps, so that a slowly growing offset does not rebuild the list every time
        let range = self.min_radius * (2.0 * largest / self.min_radius).max(0.02).log2().ceil().exp2();
        let margin = 0.5 * self.min_radius;
        if self.is_current && self.broad_phase.is_for(range, margin) {
            return Ok(false);
        }
        self.is_current = false;
        self.exclusion.update(&self.set)?;
        let before = self.broad_phase.generation();
        self.broad_phase.candidates(&self.set, &self.exclusion, range, margin).map_err(not_finite)?;
        self.is_current = true;
        Ok(self.broad_phase.generation() != before)
    }

    /// Overwrites the contact curves with those of `state`; what goes with them is no longer current if they moved.
    pub(crate) fn place(&mut self, state: &State) {
        let (nodes, lengths) = (&self.nodes, &self.set.lengths);
        let moved = self
            .set
            .segments
            .par_iter_mut()
            .zip(&mut self.set.remainders)
            .with_min_len(256)
            .enumerate()
            .map(|(k, (segment, remainders))| {
                let (now, lost) = contact_cubic_exactly(state, nodes[k], lengths[k]);
                *remainders = lost;
                std::mem::replace(segment, now) != now
            })
            .reduce(|| false, |a, b| a || b);
        self.is_current &= !moved;
    }

    /// Global nodes: slave a, b, master a, b.
    pub(crate) fn nodes_of(&self, meeting: &Meeting) -> [usize; 4] {
        let (s, m) = (self.nodes[meeting.slave], self.nodes[meeting.master]);
        [s[0], s[1], m[0], m[1]]
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

pub(crate) fn in_pool<R: Send>(pool: Option<&rayon::ThreadPool>, work: impl FnOnce() -> R + Send) -> R {
    match pool {
        Some(pool) => pool.install(work),
        // inside the global pool, so that no sum on the way has to go in and out
        None if rayon::current_thread_index().is_none() => rayon::scope(|_| work()),
        None => work(),
    }
}

fn add_load(out: &mut Residual, unknown: usize, force: f64) {
    out.gradient[unknown] -= force;
    out.magnitude[unknown] += force.abs();
}

pub(super) fn symmetric(tangent: &ElementTangent, row: usize, col: usize) -> f64 {
    if row / 6 <= col / 6 { tangent[row][col] } else { tangent[col][row] }
}

fn scatter_contact(
    nodes: &[usize; 4],
    block: &Blocks,
    pattern: &Pattern,
    prescribed: Option<&[f64]>,
    tangent: &mut Tangent,
) {
    for a in 0..4 {
        for c in a..4 {
            let (p, q) = (nodes[a], nodes[c]);
            let entry = |i: usize, j: usize| block[6 * a + i][6 * c + j];
            pattern.add_block(&mut tangent.values, p, q, entry);
            if p == q && a != c {
                pattern.add_block(&mut tangent.values, p, q, |i, j| entry(j, i));
            }
            let Some(all) = prescribed else { continue };
            for i in 0..6 {
                for j in 0..6 {
                    tangent.drive[6 * p + i] += entry(i, j) * all[6 * q + j];
                    if a != c {
                        tangent.drive[6 * q + j] += entry(i, j) * all[6 * p + i];
                    }
                }
            }
        }
    }
}

/// ∫N_a dξ and ∫(N_a N_c' − N_a' N_c) dξ on the unit element.
fn integrals(order: usize) -> ([f64; 4], [[f64; 4]; 4]) {
    let rule = gauss(5);
    let (mut mass, mut skew) = ([0.0; 4], [[0.0; 4]; 4]);
    for (&xi, &w) in rule.points.iter().zip(rule.weights) {
        let (n, d) = lagrange(order, xi);
        for a in 0..=order {
            mass[a] += w * n[a];
            for c in 0..=order {
                skew[a][c] += w * (n[a] * d[c] - d[a] * n[c]);
            }
        }
    }
    (mass, skew)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, Rod, Section, Shape};
    use crate::scene::{Contact, ContactLaw, LineLoad, Model, NodeLoad, NodeRef};

    /// Two free rings that overlap, with dead loads and pressure, moved off every symmetry.
    fn engine() -> Engine {
        let section = Section { bending: [1.0, 1.3], ..Section::isotropic(1.0, 1.5, 900.0, 700.0, 0.06) };
        let ring = |name: &str, center: Vec3, normal: Vec3| {
            let shape = Shape::Circle { length: 2.0, center, normal };
            Rod::new(name, &shape, true, section, 8, 3, Natural::Straight).unwrap()
        };
        let rods = vec![ring("a", Vec3::zeros(), Vec3::z()), ring("b", Vec3::new(0.55, 0.0, 0.02), Vec3::y())];
        let law = ContactLaw::Penalty { stiffness: 0.5 };
        let mut engine = Engine::new(Model { rods, contact: Contact { law }, ..Model::default() }, None).unwrap();
        // loads and pressure belong to supported or planar scenes; here only their derivatives are of interest
        let node = NodeRef { rod: 0, node: 5 };
        engine.model.loads.push(NodeLoad { node, force: Vec3::new(1.0, -2.0, 0.5), moment: Vec3::zeros() });
        engine.model.line_loads.push(LineLoad { rod: 1, force: Vec3::new(0.3, 0.2, -0.4) });
        engine.state.load_factor = 0.7;
        engine.state.pressures[0] = 1.1;
        engine.state.seams[0] = 0.4;
        let direction = direction(engine.num_nodes(), 3.0);
        engine.state = engine.state.retract(&direction, 0.003);
        engine
    }

    fn direction(num_nodes: usize, phase: f64) -> Vec<f64> {
        (0..6 * num_nodes).map(|i| (phase + 1.7 * i as f64 + 0.3 * (i * i % 17) as f64).sin()).collect()
    }

    fn at(engine: &mut Engine, state: &State) -> Residual {
        engine.update_contact(state).unwrap();
        engine.residual(state)
    }

    /// Symptom: rods that reach 10⁵ node spacings from the origin came to rest no nearer than a relative residual of 1e-8. Mechanism: a unit in the last
    /// place of a position is a stretch of the elements beside it and an overlap of strands.
    #[test]
    fn far_from_the_origin_forces_are_the_same() {
        let mut engine = engine();
        // loads only know where the origin is
        engine.model.loads.clear();
        engine.model.line_loads.clear();
        engine.state.load_factor = 0.0;
        engine.state.pressures[0] = 0.0;
        let state = engine.state.clone();
        let here = at(&mut engine, &state);
        let shift = Vec3::new(1e6, -0.4e6, 0.7e6);
        let by: Vec<f64> = (0..6 * engine.num_nodes()).map(|i| if i % 6 < 3 { shift[i % 6] } else { 0.0 }).collect();
        let far = state.retract(&by, 1.0);
        // motions far below the resolution of the coordinates are kept
        let small: Vec<f64> = direction(engine.num_nodes(), 0.2).iter().map(|x| 1e-13 * x).collect();
        let moved = far.retract(&small, 1.0).increment_since(&far);
        for node in 0..engine.num_nodes() {
            (6 * node..6 * node + 3).for_each(|i| assert!((moved[i] - small[i]).abs() < 1e-20));
        }
        let there = at(&mut engine, &far);
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        let largest = here.magnitude.iter().copied().fold(0.0, f64::max);
        let pressed = here.contact_gradient.iter().map(|x| x.abs()).fold(0.0, f64::max);
        assert!(pressed > 1e-3 * largest, "{pressed} {largest}");
        assert!(difference(&here.gradient, &there.gradient) < 1e-13 * largest);
        assert!(difference(&here.contact_gradient, &there.contact_gradient) < 1e-12 * pressed);
    }

    #[test]
    fn gradient_and_tangent_of_the_whole_problem_match_finite_differences() {
        let mut engine = engine();
        let state = engine.state.clone();
        let residual = at(&mut engine, &state);
        assert!(residual.potential.contact > 0.0, "the case must have contact");
        engine.update_contact(&state).unwrap();
        let pattern = engine.build_pattern();
        let mut tangent = Tangent::default();
        engine.linearise(&state, None, &Drive::default(), &pattern, &mut tangent);
        let v = direction(engine.num_nodes(), 0.5);
        let w = direction(engine.num_nodes(), 8.1);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let potential = |engine: &mut Engine, a: f64, b: f64| {
            let step: Vec<f64> = v.iter().zip(&w).map(|(v, w)| a * v + b * w).collect();
            at(engine, &state.retract(&step, 1.0)).potential.total()
        };
        let h = 1e-6;
        let slope = (8.0 * (potential(&mut engine, h, 0.0) - potential(&mut engine, -h, 0.0))
            - (potential(&mut engine, 2.0 * h, 0.0) - potential(&mut engine, -2.0 * h, 0.0)))
            / (12.0 * h);
        let ours = dot(&residual.gradient, &v);
        assert!((slope - ours).abs() < 1e-7 * ours.abs(), "{slope} {ours}");
        // all unknowns are free and numbered in order: the pattern's product needs no mapping
        let ours = dot(&w, &pattern.multiply(&tangent.values, &v));
        let h = 1e-5;
        let second = |engine: &mut Engine, h: f64| {
            (potential(engine, h, h) - potential(engine, h, -h) - potential(engine, -h, h) + potential(engine, -h, -h))
                / (4.0 * h * h)
        };
        let difference = (4.0 * second(&mut engine, h) - second(&mut engine, 2.0 * h)) / 3.0;
        assert!((difference - ours).abs() < 1e-4 * ours.abs().max(1e3), "{difference} {ours}");
    }
}
