//! Pressures of contact as they pass from one law to the next: what the law in force gives, and offsets that give a new law the same.

use crate::contact::law::Law;
use crate::solve::assembly::Residual;
use crate::solve::path::Solver;
use crate::solve::settle::TOL_OPENING;

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

    /// How far the contact conditions are from met.
    pub(super) fn contact_errors(&self) -> ContactErrors {
        if self.engine.contact.is_none() {
            return ContactErrors::default();
        }
        self.contact_errors_of(&self.engine.residual(&self.engine.state))
    }

    /// [`Solver::contact_errors`] from the residual of the present state, with zones.
    pub(super) fn contact_errors_of(&self, residual: &Residual) -> ContactErrors {
        let Some(side) = &self.engine.contact else { return ContactErrors::default() };
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
