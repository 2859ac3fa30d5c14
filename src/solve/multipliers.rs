//! Pressures of contact as they pass from one law to the next: what balances the elastic forces where strands touch, what the law in force
//! gives, and offsets that give a new law the same.

use crate::contact::law::Law;
use crate::error::SolveError;
use crate::math::Vec3;
use crate::solve::assembly::Residual;
use crate::solve::path::Solver;
use crate::solve::settle::TOL_OPENING;

/// Pressures over the law's own: what touching strands are probed with to find out what would balance them, and at most.
const PROBING_PRESSURE: f64 = 0.01;
const LARGEST_BALANCING_PRESSURE: f64 = 0.5;

/// How far the contact conditions are from met, by nodes and in all.
#[derive(Debug, Default)]
pub(super) struct ContactErrors {
    /// Smallest gap near each node (window of one contact distance along its zone) \[L\]; infinite where nothing is in reach.
    pub(super) gaps: Vec<f64>,
    /// Worst penetration over the smallest contact radius.
    pub(super) penetration: f64,
    /// Worst gap that an offset holds open over the smallest contact radius.
    pub(super) opening: f64,
}

impl Solver {
    /// Replaces the law; the pressures of the state at rest become those of strands that just touch.
    pub(super) fn harden_to(&mut self, law: Law) {
        let pressures = self.pressures();
        self.change_law(law, &pressures);
    }

    /// Replaces the law, with offsets that give touching strands these pressures (per node; none if empty).
    pub(super) fn change_law(&mut self, law: Law, pressures: &[f64]) {
        let Some(side) = &mut self.engine.contact else { return };
        let mut offsets = vec![0.0; side.offsets.len()];
        for (offset, pressure) in offsets.iter_mut().zip(pressures) {
            *offset = law.overlap(*pressure, 2.0 * side.min_radius);
        }
        side.change_law(law, offsets);
    }

    /// Replaces the law like [`Solver::change_law`]; the first step starts from the new law's pressures instead of the old ones.
    pub(super) fn start_under(&mut self, law: Law, pressures: &[f64]) {
        self.change_law(law, pressures);
        self.forget_pressures();
    }

    /// The first step after a change of law or offsets starts from the present pressures instead of those before.
    pub(super) fn forget_pressures(&mut self) {
        if let Some(side) = &mut self.engine.contact {
            side.before = None;
        }
    }

    /// Pressure near each node \[F/L\], at the smallest gap around it.
    fn pressures(&self) -> Vec<f64> {
        let errors = self.contact_errors();
        let Some(side) = &self.engine.contact else { return Vec::new() };
        let at = |(offset, gap): (&f64, &f64)| {
            let pressure = side.law.response(offset - gap, 2.0 * side.min_radius).pressure;
            if pressure.is_finite() { pressure } else { 0.0 }
        };
        side.offsets.iter().zip(&errors.gaps).map(at).collect()
    }

    /// Pressure near each node \[F/L\] that balances the elastic forces and loads of the present state where strands touch; 0 elsewhere.
    ///
    /// By virtual work: the strands are moved apart along their normals, the frames turning with the tangents, so that nothing is sheared.
    /// What the elastic forces do in that motion over one contact distance to either side is compared with what contact under `law` with
    /// a probing offset does. A shape whose strands are not yet under tension misses the tension's share: of the pressure in a
    /// plectoneme of angle α it finds cos²α. `scale` is a large pressure \[F/L\]: the probe is a part of it, and no result above its half.
    pub(super) fn balancing_pressures(&mut self, law: Law, scale: f64) -> Result<Vec<f64>, SolveError> {
        let before = self.snapshot();
        let Some(side) = &mut self.engine.contact else { return Ok(Vec::new()) };
        let distance = 2.0 * side.min_radius;
        let probe = law.overlap(PROBING_PRESSURE * scale, distance);
        side.law = law;
        side.offsets.fill(probe);
        side.before = None;
        let state = self.engine.state.clone();
        self.engine.update_contact(&state)?;
        let residual = self.engine.residual(&state);
        let gaps = self.contact_errors().gaps;
        let works = self.works_apart(&residual);
        self.restore(before)?;
        let pressure = |([elastic, contact], gap): ([f64; 2], f64)| {
            if elastic <= 0.0 || contact <= 0.0 || !gap.is_finite() {
                return 0.0;
            }
            let here = law.response(probe - gap, distance).pressure;
            (elastic / contact * here).min(LARGEST_BALANCING_PRESSURE * scale)
        };
        Ok(works.into_iter().zip(gaps).map(pressure).collect())
    }

    /// Work against the elastic forces and loads, and of contact, as strands move apart by a unit length around each node \[F\].
    fn works_apart(&self, residual: &Residual) -> Vec<[f64; 2]> {
        let Some(side) = &self.engine.contact else { return Vec::new() };
        let part = |of: &[f64], i: usize| Vec3::new(of[i], of[i + 1], of[i + 2]);
        let apart = |node: usize| {
            let pull = part(&residual.contact_gradient, 6 * node);
            -pull.try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
        };
        let mut works = vec![[0.0; 2]; side.offsets.len()];
        for (segment, &[node, next]) in side.nodes.iter().enumerate() {
            let (first, length) = match side.set.prev(segment) {
                Some(prev) => (side.nodes[prev][0], side.set.lengths[prev] + side.set.lengths[segment]),
                None => (node, side.set.lengths[segment]),
            };
            let tangent = self.engine.state.frames[node] * Vec3::z();
            let turn = tangent.cross(&((apart(next) - apart(first)) / length));
            let work = |of: &[f64]| -part(of, 6 * node).dot(&apart(node)) - part(of, 6 * node + 3).dot(&turn);
            let contact = work(&residual.contact_gradient);
            let elastic = contact - work(&residual.gradient);
            for forward in [true, false] {
                side.spread(segment, 2.0 * side.min_radius, forward, |node| {
                    works[node][0] += elastic;
                    works[node][1] += contact;
                });
            }
        }
        works
    }

    /// How far the contact conditions are from met.
    pub(super) fn contact_errors(&self) -> ContactErrors {
        let Some(side) = &self.engine.contact else { return ContactErrors::default() };
        let residual = self.engine.residual(&self.engine.state);
        let mut gaps = vec![f64::INFINITY; side.offsets.len()];
        let mut touched = vec![false; side.offsets.len()];
        for term in &residual.terms {
            side.nodes[term.slave].iter().for_each(|&node| touched[node] = true);
            let window = side.set.radius_of(term.slave) + side.set.radius_of(term.master);
            for gap in term.zones.iter().map(|z| z.min_gap) {
                for forward in [true, false] {
                    side.spread(term.slave, window, forward, |node| gaps[node] = gaps[node].min(gap));
                }
            }
        }
        let penetration = gaps.iter().map(|g| -g).fold(0.0, f64::max) / side.min_radius;
        let held = (0..gaps.len()).filter(|&n| touched[n] && gaps[n].is_finite() && side.offsets[n] > 0.0);
        let opening = held.map(|n| gaps[n]).fold(0.0, f64::max) / side.min_radius;
        ContactErrors { gaps, penetration, opening }
    }

    /// Raises the contact offsets by the smallest gap found around each node, never below zero. At the edge of a zone a small gap may stay
    /// whatever the offset is, and would lower it for ever: with `give_way` offsets that hold gaps open are halved.
    pub(super) fn augment(&mut self, gaps: &[f64], give_way: bool) {
        let Some(side) = &mut self.engine.contact else { return };
        let open = TOL_OPENING * side.min_radius;
        let raised = |(offset, gap): (&f64, &f64)| {
            let share = if give_way && *gap > open { 0.5 } else { 1.0 };
            if gap.is_finite() { share * (offset - gap).max(0.0) } else { 0.0 }
        };
        let offsets = side.offsets.iter().zip(gaps).map(raised).collect();
        side.change_law(side.law, offsets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rod::{Natural, Plectoneme, Rod, Section, Shape};
    use crate::scene::Model;
    use crate::solve::Options;

    /// A plectoneme under the moment M = 2B sin³α cosα/(R cos2α): its strands press with B sin⁴α/(R³ cos2α), cos²α of which is seen in the
    /// middle; nothing where the end loops are apart.
    #[test]
    fn a_plectoneme_presses_with_its_closed_form_before_it_is_solved() {
        let (length, radius, angle) = (150.0, 0.5, 0.35f64);
        let plectoneme = Plectoneme::of_angle(length, 2.0 * radius, angle).unwrap();
        let (sin, cos) = angle.sin_cos();
        let steepness = (2.0 * angle).cos();
        let exact = (sin * sin * cos).powi(2) / (radius.powi(3) * steepness);
        let moment = 2.0 * sin.powi(3) * cos / (radius * steepness);
        let link = plectoneme.writhe() - moment * length / (1.5 * std::f64::consts::TAU);
        let section = Section::isotropic(1.0, 1.5, 1e3, 1e3, radius);
        let rod = Rod::new("ply", &Shape::Plectoneme(plectoneme), true, section, 150, 3, Natural::Straight).unwrap();
        let rod = rod.with_excess_link(link).unwrap();
        let mut solver = Solver::new(Model { rods: vec![rod], ..Model::default() }, Options::default()).unwrap();
        let scale = solver.engine.pressure_scale();
        let law = Law::Core { pressure: scale, depth: 0.4 };
        let state = solver.engine.state.clone();
        let pressures = solver.balancing_pressures(law, scale).unwrap();
        assert_eq!(solver.engine.state, state);
        let mean = pressures[100..140].iter().sum::<f64>() / 40.0;
        assert!((mean / exact - 1.0).abs() < 0.02, "{mean} {exact}");
        assert!(pressures[..3].iter().all(|p| *p == 0.0), "{:?}", &pressures[..3]);
        // touching strands under offsets of these pressures are under these pressures
        solver.change_law(law, &pressures);
        let side = solver.engine.contact.as_ref().unwrap();
        for (offset, pressure) in side.offsets.iter().zip(&pressures) {
            assert!((law.response(*offset, 1.0).pressure - pressure).abs() <= 1e-12 * exact);
        }
    }
}
