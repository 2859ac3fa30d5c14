//! From an accepted state to its report.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use crate::contact::clearance::smallest_clearance;
use crate::contact::law::Law;
use crate::math::link::link_numbers;
use crate::scene::NodeRef;
use crate::solve::assembly::{Potential, Residual};
use crate::solve::{Engine, Progress, Status};

use super::report::{Energies, GapReport, Observation, Reaction, RodLink, SiteReport};
use super::sites::{Layer, sites};

/// Points per node segment at which link is measured: neighbouring frames are then much less than half a turn apart.
const POINTS_PER_SEGMENT: usize = 4;
/// Gaps are looked for up to this many radii of the thinnest rod: two diameters.
const MAX_GAP: f64 = 4.0;
/// Overlap, in radii of the thinnest rod, beyond twice what contact leaves from which it counts as not resisted.
const UNRESISTED: f64 = 1e-2;
/// Width of the interval that encloses the smallest gap, relative to the smallest contact radius.
const TOL_GAP: f64 = 1e-10;

/// Everything there is to report about the state that a solver has just accepted.
///
/// Takes about as long as one evaluation of the residual, plus link and the certified clearance. The same numbers for
/// any number of threads, but for `seconds`.
pub fn observe(progress: &Progress) -> Observation {
    let engine = progress.engine;
    let residual = engine.residual(engine.state());
    let sites = sites_of(engine, &residual);
    let min_gap = min_gap(engine);
    Observation {
        stage: progress.stage,
        step: progress.step,
        fraction: progress.fraction,
        status: progress.report.status.to_string(),
        links: links(engine, &residual),
        energies: energies(&residual.potential),
        notes: notes(progress, min_gap.as_ref()),
        min_gap,
        num_sites: sites.len(),
        total_contact_force: sites.iter().fold(0.0, |sum, site| sum + site.force),
        sites,
        reactions: reactions(engine, &residual),
        num_unstable: progress.report.num_unstable,
        iterations: progress.report.iterations,
        energy_released: progress.report.energy_released,
        iterations_elsewhere: progress.report.iterations_elsewhere,
        seconds: progress.seconds,
    }
}

/// The contact sites of the engine's state, as [`observe`] reports them.
pub fn contact_sites(engine: &Engine) -> Vec<SiteReport> {
    sites_of(engine, &engine.residual(engine.state()))
}

fn sites_of(engine: &Engine, residual: &Residual) -> Vec<SiteReport> {
    engine.contact.as_ref().map_or_else(Vec::new, |side| {
        let softer = |rod: &usize| engine.model().rods[*rod].section.smaller_bending();
        let stiffness = match side.law {
            Law::Linear { stiffness } => stiffness,
            Law::Core { .. } => engine.contact_stiffness(),
        };
        let layer = Layer { stiffness, bending: side.rods.iter().map(softer).collect() };
        sites(&side.set, &residual.contact_pairs, &side.rods, &layer)
    })
}

fn energies(potential: &Potential) -> Energies {
    let [stretch, shear, bend, twist] = potential.elastic;
    let (contact, electrostatic) = (potential.contact, potential.electrostatic);
    let total = stretch + shear + bend + twist + contact + electrostatic;
    Energies { stretch, shear, bend, twist, contact, electrostatic, total }
}

fn links(engine: &Engine, residual: &Residual) -> Vec<RodLink> {
    let rods = &engine.model().rods;
    let link_of = |rod: usize| {
        let prescribed = engine.state().seams[rod] / TAU;
        let excess_link = prescribed - rods[rod].natural_link();
        let (points, d1) = engine.centerline(rod, POINTS_PER_SEGMENT);
        let link = link_numbers(&points, &d1, prescribed).link;
        let (twist, excess_twist) = engine.twist(rod);
        let seam_moment = residual.seam_moments[rod];
        RodLink { rod, excess_link, link, twist, excess_twist, writhe: link - twist, seam_moment }
    };
    (0..rods.len()).filter(|&rod| rods[rod].closed).map(link_of).collect()
}

/// What a reader of the numbers should know of a state at rest: a snap on the way to it, overlaps that contact does not
/// resist, a law softer than asked for.
fn notes(progress: &Progress, min_gap: Option<&GapReport>) -> Vec<String> {
    let engine = progress.engine;
    if progress.report.status != Status::Converged {
        return Vec::new();
    }
    let released = progress.report.energy_released;
    let snap =
        (released > 0.0).then(|| format!("snap: the path was no longer stable; it set {released:.4} of energy free"));
    let Some(side) = &engine.contact else { return snap.into_iter().collect() };
    let rods = &engine.model().rods;
    let too_tight = side.rods.iter().filter_map(|&rod| {
        let (name, radius) = (&rods[rod].name, rods[rod].section.contact_radius);
        let [curvature, arc] = engine.largest_curvature(rod);
        let tightness = curvature * radius;
        (tightness > 1.0).then(|| {
            format!(
                "rod \"{name}\" is bent {tightness:.2} times as tightly as its contact radius allows, at arc {arc:.4}: it \
                 overlaps itself there, which contact does not resist"
            )
        })
    });
    let mut notes: Vec<String> = snap.into_iter().chain(too_tight).collect();
    let softening = progress.report.softening;
    if softening > 1.0 {
        notes.push(format!(
            "the mesh does not carry the contact law asked for: one {softening:.0} times softer is in force, which widens \
             points of contact; gaps are closed all the same"
        ));
    }
    let resisted = (UNRESISTED + 2.0 * progress.report.penetration) * side.min_radius;
    if let Some(gap) = min_gap.filter(|gap| -gap.upper > resisted) {
        let (a, b) = (&rods[gap.rod_a].name, &rods[gap.rod_b].name);
        notes.push(format!(
            "rod \"{a}\" at arc {:.4} and rod \"{b}\" at arc {:.4} overlap by {:.4}, {:.2} contact radii, which contact does \
             not resist there",
            gap.arc_a,
            gap.arc_b,
            -gap.upper,
            -gap.upper / side.min_radius
        ));
    }
    notes
}

fn min_gap(engine: &Engine) -> Option<GapReport> {
    let side = engine.contact.as_ref().filter(|side| side.is_current)?;
    let (max_gap, tol) = (MAX_GAP * side.min_radius, TOL_GAP * side.min_radius);
    let found = engine.install(|| smallest_clearance(&side.set, &side.exclusion, max_gap, tol))?;
    let rod = |segment: usize| side.rods[side.set.curve_of(segment)];
    Some(GapReport {
        lower: found.lower,
        upper: found.upper,
        rod_a: rod(found.segment_a),
        arc_a: found.arc_a,
        rod_b: rod(found.segment_b),
        arc_b: found.arc_b,
    })
}

/// At rest the gradient of the potential vanishes but for supported components, where it is what the support adds.
fn reactions(engine: &Engine, residual: &Residual) -> Vec<Reaction> {
    let nodes: BTreeSet<NodeRef> = engine.model().supports.iter().map(|support| support.node).collect();
    let reaction = |node: NodeRef| {
        let first = 6 * engine.master[engine.first_node[node.rod] + node.node];
        let gradient = &residual.gradient[first..first + 6];
        let (position, rotation) = engine.model().fixed(node);
        Reaction {
            rod: node.rod,
            node: node.node,
            force: std::array::from_fn(|k| if position[k] { gradient[k] } else { 0.0 }),
            moment: std::array::from_fn(|k| if rotation[k] { gradient[3 + k] } else { 0.0 }),
        }
    };
    nodes.into_iter().map(reaction).collect()
}
