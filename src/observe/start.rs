//! Overlaps in start shapes.

use std::fmt;

use crate::contact::clearance::smallest_clearance;
use crate::observe::report::SiteReport;
use crate::scene::Model;
use crate::solve::{Engine, RunError};

use super::state::contact_sites;

/// Smallest overlap reported, over the contact distance, because discretised shapes have smaller ones.
const NOTABLE: f64 = 1e-3;
/// Width of the interval that encloses the deepest overlap, relative to the smallest contact radius.
const TOL_DEPTH: f64 = 1e-6;

/// Two strands that overlap at the start.
#[derive(Debug, Clone, PartialEq)]
pub struct StartOverlap {
    /// Names of the rods of strands a and b.
    pub rods: [String; 2],
    /// Arc length intervals on strands a and b \[L\].
    pub arcs: [[f64; 2]; 2],
    /// Distance of the centrelines \[L\].
    pub distance: f64,
    /// Sum of both contact radii \[L\].
    pub contact_distance: f64,
    /// Whether a centreline runs inside the other strand. The side to which such strands separate is arbitrary.
    pub through: bool,
}

/// All overlaps of strands in the start shape of a model, the deepest first. Contact separates overlapping strands to
/// the sides of their centrelines. If these pass [through](StartOverlap::through) the other strand, the shape is
/// probably not intended.
///
/// # Errors
/// Models that [`Engine::new`] refuses; start shapes too coarse for contact, or with more candidates of contact than
/// there is memory for.
pub fn start_overlaps(model: &Model) -> Result<Vec<StartOverlap>, RunError> {
    let mut engine = Engine::new(model.clone(), None).map_err(RunError::Input)?;
    let state = engine.state().clone();
    engine.update_contact(&state)?;
    engine.check_memory()?;
    let overlap = |rods: [usize; 2], arcs: [[f64; 2]; 2], gap: f64| {
        let radii = [0, 1].map(|k| engine.model().rods[rods[k]].contact_radius_at(arcs[k][0]));
        let contact_distance = radii[0] + radii[1];
        let distance = (contact_distance + gap).max(0.0);
        let names = rods.map(|rod| engine.model().rods[rod].name.clone());
        StartOverlap { rods: names, arcs, distance, contact_distance, through: distance < radii[0].max(radii[1]) }
    };
    let of_site = |site: &SiteReport| overlap([site.rod_a, site.rod_b], [site.arc_a, site.arc_b], site.gap);
    let mut overlaps: Vec<StartOverlap> = contact_sites(&engine).iter().map(of_site).collect();
    // coincident centrelines have no normal and no site
    let side = &engine.contact;
    let tol = TOL_DEPTH * side.min_radius;
    let found = smallest_clearance(&side.set, &side.exclusion, 0.0, tol);
    let deepest = overlaps.iter().map(|o| o.distance - o.contact_distance).fold(0.0, f64::min);
    if let Some(found) = found.filter(|found| found.upper < deepest - 2.0 * tol) {
        let rods = [found.segment_a, found.segment_b].map(|segment| side.rods[side.set.curve_of(segment)]);
        overlaps.push(overlap(rods, [[found.arc_a; 2], [found.arc_b; 2]], found.upper));
    }
    overlaps.retain(|o| o.distance < (1.0 - NOTABLE) * o.contact_distance);
    overlaps.sort_by(|a, b| (a.distance / a.contact_distance).total_cmp(&(b.distance / b.contact_distance)));
    Ok(overlaps)
}

impl fmt::Display for StartOverlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |k: usize| match self.arcs[k] {
            [from, to] if from == to => format!("rod \"{}\" at arc {from:.4}", self.rods[k]),
            [from, to] => format!("rod \"{}\" at arcs {from:.4} to {to:.4}", self.rods[k]),
        };
        let [a, b] = [place(0), place(1)];
        let (distance, allowed) = (self.distance, self.contact_distance);
        if self.through {
            write!(
                f,
                "{a} and {b} start through each other: centrelines {distance:.4} apart, contact radii {allowed:.4}"
            )?;
            write!(
                f,
                " together; contact parts them, if it can, to the side on which the centrelines happen to be: move \
                 one of them"
            )
        } else {
            write!(
                f,
                "{a} and {b} overlap at the start: centrelines {distance:.4} apart, contact radii {allowed:.4} together"
            )?;
            write!(f, "; contact will push them apart")
        }
    }
}
