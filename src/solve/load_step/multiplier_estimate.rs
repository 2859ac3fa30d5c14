//! Forces that balance the moments of a shape which is not at rest: tension and shear of the rods, pressures where
//! strands touch.
//!
//! A start shape knows its curvature and twist but no forces: its strains of stretch and shear are zero, its strands
//! just touch. Taken for a state, it is far out of balance, and its tangent, with pressures or without, is that of
//! another problem. So the forces are found first: the response of the rods' material stiffness (no geometric part) and
//! of stiff contact along its normals to the moments and loads of the shape, held by inertia against motions longer
//! than some tens of contact distances. Its displacements mean nothing, its forces are multipliers: those that leave
//! the least unbalanced. Strands that would have to pull are let go.

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::math::Vec3;
use crate::solve::load_step::solver::Solver;
use crate::solve::measures::{NOTHING, ROUNDING};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_field::ContactField;
use crate::solve::problem::prescribed_motion::PrescribedMotion;

/// Pressure, over the law's own, of the offsets with which strands that touch are found, and gap, over the contact
/// distance, that the law's pressure may open, because strands nearby stay apart then.
const PROBE: f64 = 0.01;
/// Rounds in which strands that would pull are let go, because the third changes next to nothing.
const ROUNDS: usize = 3;

/// Largest pressure of an estimate, over the law's own.
const LARGEST_PRESSURE: f64 = 0.5;
/// Wavelength over 2π, in contact distances, beyond which inertia holds the rods, because longer waves are motions of
/// the shape, not forces in it.
const HELD: f64 = 30.0;

/// Forces of a state in balance.
#[derive(Debug, Default)]
pub(in crate::solve) struct MultiplierEstimate {
    /// Pressure near each node \[F/L\], 0 where strands are apart.
    pub(in crate::solve) pressures: Vec<f64>,
    /// Two shear forces and the tension at each integration point of each element \[F\].
    pub(in crate::solve) forces: Vec<[[f64; 3]; 3]>,
}

impl Solver {
    /// The forces that balance the present state best. `law` decides which strands touch, `scale` is its
    /// pressure \[F/L\]; no result is above its half.
    pub(in crate::solve) fn multiplier_estimate(
        &mut self,
        law: Law,
        scale: f64,
    ) -> Result<MultiplierEstimate, SolveError> {
        let before = self.snapshot();
        let side = &mut self.engine.contact;
        let distance = 2.0 * side.min_radius;
        // so little pressure that strands nearby stay apart
        let probe = law.overlap(PROBE * scale, distance);
        side.law = law;
        let [num_nodes, num_surfaces] = side.size();
        side.offsets = ContactField::uniform(num_nodes, num_surfaces, probe);
        side.before = None;
        let state = self.engine.state().clone();
        self.engine.update_contact(&state)?;
        let probed = self.engine.residual(&state);
        let gaps = self.contact_errors_of(&probed).gaps.per_node(f64::min);
        let rest: Vec<f64> = probed.contact_gradient.iter().zip(&probed.gradient).map(|(c, g)| c - g).collect();
        let mut multiplier_estimate = MultiplierEstimate::default();
        let mut reach = vec![probe; gaps.len()];
        for _ in 0..ROUNDS {
            let Some((forces, push)) = self.respond_stiffly(&rest, &reach, scale, distance)? else { break };
            multiplier_estimate.forces = forces;
            let works = self.works_apart(&probed, &push);
            let pressure = |([push, contact], gap): (&[f64; 2], &f64)| {
                let here = law.response(probe - gap, distance).pressure;
                let pressure = push / contact * here;
                if *contact > 0.0 && pressure.is_finite() { pressure.min(LARGEST_PRESSURE * scale) } else { 0.0 }
            };
            multiplier_estimate.pressures = works.iter().zip(&gaps).map(pressure).collect();
            let mut pulls = false;
            for (reach, pressure) in reach.iter_mut().zip(&mut multiplier_estimate.pressures) {
                // those that would pull by no more than rounding keep their place
                if *pressure < -NOTHING * scale {
                    pulls |= *reach > -distance;
                    *reach = -distance;
                }
                *pressure = pressure.max(0.0);
            }
            if !pulls {
                break;
            }
        }
        self.restore(before)?;
        Ok(multiplier_estimate)
    }

    /// Forces in the rods, and of contact on the nodes (as a gradient), of the response to nodal forces `load` with
    /// stiff contact where gaps are below `reach` (per node \[L\]); none if the matrix cannot be factorised.
    #[allow(clippy::type_complexity)] // two lists
    fn respond_stiffly(
        &mut self,
        load: &[f64],
        reach: &[f64],
        scale: f64,
        distance: f64,
    ) -> Result<Option<(Vec<[[f64; 3]; 3]>, Vec<f64>)>, SolveError> {
        let state = self.engine.state().clone();
        let side = &mut self.engine.contact;
        // the law's pressure opens no gap by more than this part of the contact distance
        side.law = Law::Linear { stiffness: scale / (PROBE * distance) };
        let reach = ContactField::of_nodes(reach, side.surfaces.len());
        // pressures are not known yet: the geometric part of contact is left out
        side.before = Some((Law::Linear { stiffness: NOTHING * scale / distance }, reach));
        self.workspace.refresh(&mut self.engine, &state)?;
        let unstressed = vec![[[0.0; 6]; 3]; self.engine.elements.len()];
        let slack = self.workspace.linearise(&self.engine, &state, &unstressed, &PrescribedMotion::default());
        let shift = (self.engine.scales.length / (HELD * distance)).powi(4);
        if self.workspace.factorise(&self.engine, shift).is_none() {
            return Ok(None);
        }
        let step = self.workspace.solve_last(load);
        if step.iter().any(|x| !x.is_finite()) {
            return Ok(None);
        }
        let push = self.engine.contact_stiffness_force(&state, &step, &slack);
        let stress = self.engine.predicted_stress(&state, &step);
        Ok(Some((stress.iter().map(|points| points.map(|six| [six[0], six[1], six[2]])).collect(), push)))
    }

    /// Work of a gradient, and of contact, as strands move apart by a unit length around each node, the frames turning
    /// with the tangents so that nothing is sheared \[F\]: summed over one contact distance to either side.
    fn works_apart(&self, probed: &Residual, push: &[f64]) -> Vec<[f64; 2]> {
        let side = &self.engine.contact;
        let part = |of: &[f64], i: usize| Vec3::new(of[i], of[i + 1], of[i + 2]);
        let apart = |node: usize| {
            let pull = part(&probed.contact_gradient, 6 * node);
            // a strand that others press from all sides has no direction but that of rounding
            let rounding = ROUNDING * part(&probed.magnitude, 6 * node).norm();
            -pull.try_normalize(rounding.max(f64::MIN_POSITIVE)).unwrap_or_default()
        };
        let mut works = vec![[0.0; 2]; side.offsets.num_nodes()];
        for (segment, &[node, next]) in side.nodes.iter().enumerate() {
            let (first, length) = match side.set.prev(segment) {
                Some(prev) => (side.nodes[prev][0], side.set.lengths[prev] + side.set.lengths[segment]),
                None => (node, side.set.lengths[segment]),
            };
            let tangent = self.engine.state().frames()[node] * Vec3::z();
            let turn = tangent.cross(&((apart(next) - apart(first)) / length));
            let work = |of: &[f64]| -part(of, 6 * node).dot(&apart(node)) - part(of, 6 * node + 3).dot(&turn);
            let here = [work(push), work(&probed.contact_gradient)];
            for forward in [true, false] {
                side.spread(segment, 2.0 * side.min_radius, forward, |node| {
                    works[node].iter_mut().zip(here).for_each(|(sum, work)| *sum += work);
                });
            }
        }
        works
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, Plectoneme, Rod, RodMesh, Section, Shape};
    use crate::scene::{Model, NodeLoad, NodeRef, Support};
    use crate::solve::options::Options;

    /// Symptom: seven parallel wires that nearly touch, pulled, took 91 iterations for 3. Mechanism: six wires press on
    /// the middle one from all sides, so that the direction in which it is pressed, and the part that others press it
    /// by, are rounding; a pull that is rounding let strands go on one side.
    #[test]
    fn wires_that_are_pulled_are_not_pressed_by_rounding() {
        let section = Section::isotropic(8e5, 6e5, 1.4e6, 4e5, 1.5);
        let around = |k: usize| {
            let angle = std::f64::consts::FRAC_PI_3 * k as f64;
            Vec3::new(angle.cos(), angle.sin(), 0.0) * 3.003
        };
        let rods: Vec<Rod> = std::iter::once(Vec3::zeros())
            .chain((0..6).map(around))
            .map(|start| {
                let shape = Shape::Line { start, direction: Vec3::z(), length: 120.0 };
                Rod::new("wire", &shape, RodMesh::open(16, 3), section, Natural::Straight).unwrap()
            })
            .collect();
        let rods: Vec<Rod> = rods.into_iter().enumerate().map(|(k, rod)| Rod { name: format!("{k}"), ..rod }).collect();
        let slides = |rod| Support { position: [true, true, false], ..Support::clamp(NodeRef { rod, node: 48 }) };
        let clamps = (0..7).map(|rod| Support::clamp(NodeRef { rod, node: 0 }));
        let pull = |rod| NodeLoad { node: NodeRef { rod, node: 48 }, force: Vec3::z() * 2000.0, moment: Vec3::zeros() };
        let supports = clamps.chain((0..7).map(slides)).collect();
        let loads = (0..7).map(pull).collect();
        let model = Model { rods, supports, loads, load: 1.0, ..Model::default() };
        let mut solver = Solver::new(model, Options::default()).unwrap();
        let scale = solver.engine.pressure_scale();
        let found = solver.multiplier_estimate(Law::Core { pressure: scale, depth: 0.4 }, scale).unwrap();
        let largest = found.pressures.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        assert!(largest < 1e-6 * scale, "{largest:e} of {scale:e}");
        let tension = found.forces.iter().flatten().map(|force| (force[2] / 2000.0 - 1.0).abs()).fold(0.0, f64::max);
        assert!(tension < 1e-3, "{tension:e}");
    }

    /// A plectoneme under the moment M = 2B sin³α cosα/(R cos2α): its strands press with p = B sin⁴α/(R³ cos2α) on each
    /// other and are under the tension pR, so that no force crosses a section; no pressure where the end loops are
    /// apart.
    #[test]
    fn a_plectoneme_presses_with_its_closed_form_before_it_is_solved() {
        let (length, radius, angle) = (150.0, 0.5, 0.35f64);
        let plectoneme = Plectoneme::of_angle(length, 2.0 * radius, angle).unwrap();
        let (sin, cos) = angle.sin_cos();
        let steepness = (2.0 * angle).cos();
        let exact = sin.powi(4) / (radius.powi(3) * steepness);
        let moment = 2.0 * sin.powi(3) * cos / (radius * steepness);
        let link = plectoneme.writhe() - moment * length / (1.5 * std::f64::consts::TAU);
        let section = Section::isotropic(1.0, 1.5, 1e3, 1e3, radius);
        let rod = Rod::new("ply", &Shape::Plectoneme(plectoneme), RodMesh::closed(150, 3), section, Natural::Straight)
            .unwrap();
        let rod = rod.with_excess_link(link).unwrap();
        let mut solver = Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default()).unwrap();
        let scale = solver.engine.pressure_scale();
        let law = Law::Core { pressure: scale, depth: 0.4 };
        let state = solver.engine.state().clone();
        let MultiplierEstimate { pressures, forces } = solver.multiplier_estimate(law, scale).unwrap();
        assert_eq!(solver.engine.state(), &state);
        let mean = pressures[100..140].iter().sum::<f64>() / 40.0;
        assert!((mean / exact - 1.0).abs() < 0.01, "{mean} {exact}");
        let tension = forces[33..47].iter().flatten().map(|force| force[2]).sum::<f64>() / 42.0;
        assert!((tension / (exact * radius) - 1.0).abs() < 0.02, "{tension} {}", exact * radius);
        assert!(pressures[..3].iter().all(|p| *p == 0.0), "{:?}", &pressures[..3]);
        // touching strands under offsets of these pressures are under these pressures
        solver.change_law(law, &pressures);
        let side = &solver.engine.contact;
        for (offset, pressure) in side.offsets.values.iter().zip(&pressures) {
            assert!((law.response(*offset, 1.0).pressure - pressure).abs() <= 1e-12 * exact);
        }
    }
}
