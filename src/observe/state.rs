//! Computation of the report of an accepted state.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use crate::certificate::{Certificate, Check, ContactForce, Counterpart, OwnGap, Subject, SupportForce};
use crate::contact::clearance::smallest_clearance;
use crate::contact::law::Law;
use crate::math::Vec3;
use crate::math::link::{link_numbers, link_of_ends};
use crate::rod::{ElasticEnergies, Rod};
use crate::scene::{NodeRef, Support};
use crate::solve::problem::assembly::{Potential, Residual};
use crate::solve::problem::bend::Bend;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::{Engine, NodalFields, Progress, Status};

use super::knots;
use super::mesh::mesh_error;
use super::obstacles::{obstacle_reactions, obstacle_sites};
use super::report::{
    Energies, GapReport, JointForce, LineSample, Observation, ObstacleReaction, ObstacleSite, Reaction, RodEnds,
    RodLink, RodSize, SiteReport,
};
use super::sites::{Layer, lines, sites, spread};
use super::topology;

/// Points per node segment for the link, because neighbouring frames must differ by much less than half a turn.
const POINTS_PER_SEGMENT: usize = 4;
/// Largest gap reported, in radii of the thinnest rod: two diameters.
const MAX_GAP: f64 = 4.0;
/// Width of the interval that encloses the smallest gap, relative to the smallest contact radius.
const TOL_GAP: f64 = 1e-10;
/// Overlap, in radii of the thinnest rod, beyond twice the penetration of contact, from which it counts as not
/// resisted.
const UNRESISTED: f64 = 1e-2;
/// Factor by which the contact law in force is softer from which it is noted: a point of contact is wider by 3 %.
const NOTED: f64 = 1.1;

/// Energy set free over what is stored that is none, because contact forces, and energies with them, are known to 1e-6.
const TOL_ENERGY: f64 = 1e-6;

/// Relative rounding of a sum of lengths.
const ROUNDING: f64 = 1e-12;

/// Note of a step in which the rods snapped; [`Observation::energy_released`] says how much energy that set free.
pub(crate) const SNAP: &str = "snap: the path was no longer stable";

/// [`Observation::status`] of an equilibrium in which tubes overlap where contact does not resist it.
pub const OVERLAP: &str = "overlap";

/// Beginning of the [`Observation::status`] of an equilibrium of which a check of the certificate does not hold.
pub(super) const FAILING: &str = "fails ";

/// The end of a run whose last step is `last`, in words: of a run that converged, the status of its last step, which
/// may be [`OVERLAP`] or a check that fails.
pub fn ending(status: Status, last: Option<&Observation>) -> String {
    let last = last.filter(|_| status == Status::Converged);
    last.map_or_else(|| status.to_string(), |last| last.status.clone())
}

/// [`Observation::status`] of an equilibrium of which a check does not hold: its name, and by how much it fails.
fn failing(check: &Check) -> String {
    format!("{FAILING}{}: {:.1e}, not {:.1e}", check.name, check.value, check.tolerance)
}

/// The report of the state that a solver has just accepted.
///
/// Takes about as long as one evaluation of the residual, plus link and the certified clearance. All numbers except
/// `seconds` are independent of the number of threads.
pub fn observe(progress: &Progress) -> Observation {
    let engine = progress.engine;
    let residual = engine.residual(engine.state());
    let sites = sites_of(engine, &residual);
    let obstacle_sites = obstacle_sites_of(engine, &residual);
    let energies = energies(&residual.potential);
    let released = progress.report.energy_released;
    let least = TOL_ENERGY * energies.total;
    let energy_released = if released > least { released } else { 0.0 };
    let reactions = reactions(engine, &residual);
    let joints = joint_forces(engine, &reactions);
    let (mut certificate, gap) = certificate(progress, (&sites, &obstacle_sites), (&reactions, &joints), &energies);
    let (min_gap, contact_gap) = (gap.map(gap_report), contact_gap(engine));
    let (links, linking, knots) =
        (links(engine, &residual), knots::linking(engine), knots::knots(engine, contact_gap.as_ref()));
    let (kept, changed) = topology::kept(progress, &links, &linking, &knots);
    certificate.checks.extend(kept);
    certificate.checks.extend(stability(progress));
    let forces = || sites.iter().map(|site| site.force).chain(obstacle_sites.iter().map(|site| site.force));
    let resultants = || sites.iter().map(|site| Vec3::from(site.force_on_a).norm());
    let (at_end, overlaps) = overlaps(progress, min_gap.as_ref(), &certificate);
    let status = match progress.report.status {
        Status::Converged if !overlaps.is_empty() => OVERLAP.to_owned(),
        Status::Converged => certificate.failures().next().map_or_else(|| Status::Converged.to_string(), failing),
        other => other.to_string(),
    };
    Observation {
        stage: progress.stage,
        step: progress.step,
        fraction: progress.fraction,
        status,
        links,
        energies,
        notes: notes(progress, energy_released).into_iter().chain(changed).chain(at_end).chain(overlaps).collect(),
        sizes: engine.model().rods.iter().map(size).collect(),
        ends: ends(engine),
        linking,
        knots,
        min_gap,
        contact_gap,
        num_sites: sites.len() + obstacle_sites.len(),
        total_contact_force: forces().fold(0.0, |sum, force| sum + force),
        contact_resultants: resultants()
            .chain(obstacle_sites.iter().map(|site| Vec3::from(site.force_on_rod).norm()))
            .fold(0.0, |sum, force| sum + force),
        obstacle_reactions: obstacle_reactions_of(engine, &residual),
        sites,
        obstacle_sites,
        reactions,
        joints,
        certificate,
        mesh_error: mesh_error(engine, residual.potential.elastic.bending + residual.potential.elastic.twisting),
        num_unstable: progress.report.num_unstable,
        iterations: progress.report.iterations,
        energy_released,
        iterations_on_other_meshes: progress.report.iterations_on_other_meshes,
        seconds: progress.seconds,
    }
}

/// What holds of the state with these contact forces and reactions.
fn certificate(
    progress: &Progress,
    (sites, obstacle_sites): (&[SiteReport], &[ObstacleSite]),
    (reactions, joints): (&[Reaction], &[JointForce]),
    energies: &Energies,
) -> (Certificate, Option<OwnGap>) {
    let &Energies { stretching, shearing, bending, twisting, .. } = energies;
    let strands = sites.iter().flat_map(|site| {
        let [force, moment, at] = [site.force_on_a, site.moment_on_a, site.feet[0]].map(Vec3::from);
        let strand = |rod, arc, sign: f64, partner| {
            let (force, moment) = (force * sign, moment * sign);
            ContactForce { rod, arc, force, moment, at, partner, carried: site.force }
        };
        let partner = Counterpart::Strand { rod: site.rod_b, arc: site.arc_b };
        [strand(site.rod_a, site.arc_a, 1.0, partner), strand(site.rod_b, site.arc_b, -1.0, Counterpart::Opposite)]
    });
    let model = progress.engine.model();
    let on_obstacles = obstacle_sites.iter().flat_map(|site| {
        let [force, moment, at] = [site.force_on_rod, site.moment_on_rod, site.nearest].map(Vec3::from);
        let partner = Counterpart::Obstacle(site.obstacle);
        let on_rod = ContactForce { rod: site.rod, arc: site.arc, force, moment, at, partner, carried: site.force };
        let on_carrier = model.obstacles[site.obstacle].carrier.map(|carrier| {
            let arc = model.rods[carrier.rod].spacing() * carrier.node as f64;
            let (force, moment, partner) = (-force, -moment, Counterpart::Opposite);
            ContactForce { rod: carrier.rod, arc: [arc; 2], force, moment, partner, ..on_rod }
        });
        [Some(on_rod), on_carrier].into_iter().flatten()
    });
    let contact: Vec<ContactForce> = strands.chain(on_obstacles).collect();
    let of_support = |at: &Reaction| SupportForce {
        node: NodeRef { rod: at.rod, node: at.node },
        force: at.force.into(),
        moment: at.moment.into(),
    };
    let reactions: Vec<SupportForce> = reactions.iter().map(of_support).collect();
    let of_joint = |at: &JointForce| SupportForce {
        node: NodeRef { rod: at.rod, node: at.node },
        force: at.force.into(),
        moment: at.moment.into(),
    };
    let joints: Vec<SupportForce> = joints.iter().map(of_joint).collect();
    let subject = Subject {
        model: progress.engine.model(),
        state: progress.engine.state(),
        given: progress.given.map(|given| (given, progress.stage, progress.fraction)),
        contact: Some(&contact),
        reactions: &reactions,
        joints: &joints,
        energies: ElasticEnergies { stretching, shearing, bending, twisting },
        penetration: progress.report.penetration,
    };
    progress.engine.install(|| Certificate::of(&subject))
}

/// The number of directions in which the energy falls, counted under the law requested or, where the mesh does not
/// carry it, the softer one that a note names. Without a potential it decides nothing.
fn stability(progress: &Progress) -> Option<Check> {
    progress.given.filter(|given| given.only_stable && progress.engine.is_conservative())?;
    let count = progress.report.num_unstable as f64;
    Some(Check::new("stability", count, 0.0, "unstable directions".to_owned()))
}

/// The contact sites of the engine's state, as [`observe`] reports them.
pub fn contact_sites(engine: &Engine) -> Vec<SiteReport> {
    sites_of(engine, &engine.residual(engine.state()))
}

/// Contact along the lines of the engine's state: pressure and gap at points half the contact law's width, or a quarter
/// of an element, apart.
pub fn contact_lines(engine: &Engine) -> Vec<LineSample> {
    let residual = engine.residual(engine.state());
    let side = &engine.contact;
    lines(&side.set, &residual.contact_pairs, &side.rods, &layer(engine, side))
}

/// Contact force per length at the nodes of every rod \[F/L\], as lines have their pressure: the force on each node is
/// spread with a Gaussian over the width of the contact law, or half an element if that is more. What varies from
/// element to element, which is due to the mesh, is gone; times the nodes' shares of the length it sums to the same
/// resultant. `fields` are [`Engine::all_nodal_fields`].
pub fn smoothed_contact_forces(engine: &Engine, fields: &[NodalFields]) -> Vec<Vec<Vec3>> {
    let raw = || fields.iter().map(|fields| fields.contact_force.clone());
    let side = &engine.contact;
    let layer = layer(engine, side);
    let smoothed = |(rod, raw): (usize, Vec<Vec3>)| match side.rods.iter().position(|&other| other == rod) {
        Some(curve) => smoothed(&engine.model().rods[rod], &raw, layer.resolution(curve, curve)),
        None => raw,
    };
    raw().enumerate().map(smoothed).collect()
}

/// Forces per length at the nodes of a rod, spread over this width \[L\].
fn smoothed(rod: &Rod, raw: &[Vec3], width: f64) -> Vec<Vec3> {
    let mut shares = vec![rod.spacing(); raw.len()];
    if let (false, [first, .., last]) = (rod.closed, &mut shares[..]) {
        (*first, *last) = (0.5 * *first, 0.5 * *last);
    }
    let mut smoothed = vec![Vec3::zeros(); raw.len()];
    for (node, force) in raw.iter().enumerate().filter(|(_, force)| **force != Vec3::zeros()) {
        let spread = spread(node as f64, width / rod.spacing(), &shares, rod.closed);
        spread.into_iter().for_each(|(k, density)| smoothed[k] += force * (shares[node] * density));
    }
    smoothed
}

fn sites_of(engine: &Engine, residual: &Residual) -> Vec<SiteReport> {
    let side = &engine.contact;
    sites(&side.set, &residual.contact_pairs, &side.rods, &layer(engine, side))
}

fn obstacle_sites_of(engine: &Engine, residual: &Residual) -> Vec<ObstacleSite> {
    let side = &engine.contact;
    obstacle_sites(&side.set, &residual.surface_contacts, &side.rods, &layer(engine, side))
}

fn obstacle_reactions_of(engine: &Engine, residual: &Residual) -> Vec<ObstacleReaction> {
    obstacle_reactions(engine.placements(engine.state()), &residual.surface_contacts)
}

fn layer(engine: &Engine, side: &ContactSide) -> Layer {
    let softer = |rod: &usize| engine.model().rods[*rod].section.smaller_bending();
    let stiffness = match side.law {
        Law::Linear { stiffness } => stiffness,
        Law::Core { .. } => engine.contact_stiffness(),
    };
    let element = |rod: &usize| engine.model().rods[*rod].length / engine.model().rods[*rod].num_elements as f64;
    let (bending, elements) = (side.rods.iter().map(softer).collect(), side.rods.iter().map(element).collect());
    Layer { stiffness, bending, elements }
}

fn energies(potential: &Potential) -> Energies {
    let ElasticEnergies { stretching, shearing, bending, twisting } = potential.elastic;
    let (contact, electrostatic) = (potential.contact, potential.electrostatic);
    let total = potential.elastic.total() + contact + electrostatic;
    Energies { stretching, shearing, bending, twisting, contact, electrostatic, total }
}

fn links(engine: &Engine, residual: &Residual) -> Vec<RodLink> {
    let rods = &engine.model().rods;
    let link_of = |rod: usize| {
        let prescribed = engine.state().seams()[rod] / TAU;
        let excess_link = prescribed - rods[rod].natural_link();
        let (points, d1) = engine.centerline(rod, POINTS_PER_SEGMENT);
        let left_out = rods[rod].turns_left_out;
        let link = link_numbers(&points, &d1, prescribed).link + left_out;
        let (twist, excess_twist) = engine.twist(rod);
        let twist = twist + left_out;
        let seam_moment = residual.seam_moments[rod];
        RodLink { rod, excess_link, link, twist, excess_twist, writhe: link - twist, seam_moment }
    };
    (0..rods.len()).filter(|&rod| rods[rod].closed).map(link_of).collect()
}

fn size(rod: &Rod) -> RodSize {
    RodSize { length: rod.length, contact_radius: rod.section.contact_radius, bending: rod.section.smaller_bending() }
}

/// Angle between the tangents at both ends, rad, up to which they count as parallel.
pub(super) const PARALLEL: f64 = 1e-3;

fn ends(engine: &Engine) -> Vec<RodEnds> {
    let rods = &engine.model().rods;
    let of = |rod: usize| {
        let positions = engine.positions(rod);
        let (twist, excess_twist) = engine.twist(rod);
        let twist = twist + rods[rod].turns_left_out;
        let link = open_link(engine, rod).map(|link| link + rods[rod].turns_left_out);
        let (start, end) = (positions[0].into(), positions[positions.len() - 1].into());
        RodEnds { rod, start, end, twist, excess_twist, link, writhe: link.map(|link| link - twist) }
    };
    (0..rods.len()).filter(|&rod| !rods[rod].closed).map(of).collect()
}

/// Link of an open rod with straight extensions, turns, on a polygon, where Tw + Wr is exact.
fn open_link(engine: &Engine, rod: usize) -> Option<f64> {
    let frames = engine.frames(rod);
    let [start, end] = [0, frames.len() - 1].map(|node| frames[node] * Vec3::z());
    if start.angle(&end) > PARALLEL {
        return None;
    }
    let (points, d1) = engine.centerline(rod, POINTS_PER_SEGMENT);
    Some(link_of_ends(&points, &d1, start + end))
}

/// Warnings about an equilibrium: a snap before it, a contact law softer than prescribed.
fn notes(progress: &Progress, released: f64) -> Vec<String> {
    if progress.report.status != Status::Converged {
        return Vec::new();
    }
    let stiffness_reduction = progress.report.stiffness_reduction;
    let snap = (released > 0.0).then(|| SNAP.to_owned());
    let softer = (stiffness_reduction > NOTED).then(|| {
        let digits = if stiffness_reduction < 10.0 { 1 } else { 0 };
        format!(
            "the mesh does not carry the contact law asked for: one {stiffness_reduction:.digits$} times softer is in \
             force, which widens points of contact; gaps are closed all the same"
        )
    });
    snap.into_iter().chain(softer).collect()
}

/// Overlaps of an equilibrium that contact does not resist, because it acts between strands, not between neighbours
/// along one. The overlap of a rod's rounded end with the part next to it, which is not an overlap of the tube, is
/// returned separately.
fn overlaps(
    progress: &Progress,
    min_gap: Option<&GapReport>,
    certificate: &Certificate,
) -> (Option<String>, Vec<String>) {
    let engine = progress.engine;
    let side = &engine.contact;
    if side.is_empty() || progress.report.status != Status::Converged {
        return (None, Vec::new());
    }
    let rods = &engine.model().rods;
    let too_tight = side.rods.iter().filter_map(|&rod| {
        let name = &rods[rod].name;
        let Bend { arc, tightness, .. } = engine.tightest_bend_of(rod);
        (tightness > 1.0).then(|| {
            format!(
                "rod \"{name}\" is bent {tightness:.2} times as tightly as its contact radius allows, at arc \
                 {arc:.4}: it overlaps itself there, which contact does not resist"
            )
        })
    });
    let inside = certificate.check("gaps").filter(|check| !check.holds).map(|check| {
        format!(
            "strands overlap by {:.1e} {}, which contact does not resist there, or the mesh does not resolve",
            check.value, check.detail
        )
    });
    let at_end = min_gap.filter(|gap| {
        let resisted = (UNRESISTED + 2.0 * progress.report.penetration) * side.min_radius;
        -gap.upper > resisted && is_of_end(&rods[gap.rod_a], gap)
    });
    let at_end = at_end.map(|gap| {
        format!(
            "rod \"{}\" overlaps its own end by {:.4}, {:.2} contact radii, at arc {:.4} and arc {:.4}",
            rods[gap.rod_a].name,
            -gap.upper,
            -gap.upper / side.min_radius,
            gap.arc_a,
            gap.arc_b
        )
    });
    (at_end, too_tight.chain(inside).collect())
}

/// Whether a gap is between an open rod's end and a point less than half a turn about its own radius away along the
/// rod.
fn is_of_end(rod: &Rod, gap: &GapReport) -> bool {
    // arcs are sums of lengths of segments
    let is_end = |arc: f64| arc <= ROUNDING * rod.length || arc >= (1.0 - ROUNDING) * rod.length;
    let along = (gap.arc_a - gap.arc_b).abs();
    gap.rod_a == gap.rod_b
        && !rod.closed
        && (is_end(gap.arc_a) || is_end(gap.arc_b))
        && along < std::f64::consts::PI * rod.section.contact_radius
}

fn gap_report(found: OwnGap) -> GapReport {
    let ([rod_a, rod_b], [arc_a, arc_b]) = (found.rods, found.arcs);
    GapReport { lower: found.gap - found.accuracy, upper: found.gap, rod_a, arc_a, rod_b, arc_b }
}

fn contact_gap(engine: &Engine) -> Option<GapReport> {
    let side = &engine.contact;
    if !side.is_current {
        return None;
    }
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

/// In equilibrium the gradient of the potential vanishes except in supported components, where it is the reaction. Of
/// several joined nodes that are supported each bears what its own rod needs; the first bears what rods without a
/// support there need, too.
fn reactions(engine: &Engine, residual: &Residual) -> Vec<Reaction> {
    let model = engine.model();
    let nodes: BTreeSet<NodeRef> = model.supports.iter().map(|support| support.node).collect();
    let of_each = if model.joints.is_empty() { Vec::new() } else { engine.forces_on_nodes(engine.state()) };
    let reaction = |node: NodeRef| {
        let owner = &engine.sharing.owner[engine.index(node)];
        let (position, rotation) = model.fixed(node);
        // where rotation about one axis is held the moment is about a direction between it and where it was tilted to
        let is_swivel = rotation.iter().filter(|held| **held).count() == 1 && !model.planar;
        let together = [model.joined_nodes(node), model.turning_nodes(node)];
        let holds = |at: &NodeRef, k: usize| {
            let of_support = |support: &Support| match k {
                0..3 => support.position[k],
                _ => support.rotation[k - 3] || is_swivel && support.rotation.contains(&true),
            };
            model.supports.iter().filter(|support| support.node == *at).any(of_support)
        };
        let component = |k: usize| {
            let total = residual.gradient[6 * owner[if k < 3 { k } else { 5 }] + k];
            let others: Vec<NodeRef> =
                together[k / 3].iter().filter(|at| **at != node && holds(at, k)).copied().collect();
            let own = |at: NodeRef| of_each[6 * engine.index(at) + k];
            match others.iter().min() {
                None => total,
                Some(_) if !holds(&node, k) => 0.0,
                Some(first) if *first < node => own(node),
                Some(_) => total - others.iter().map(|at| own(*at)).sum::<f64>(),
            }
        };
        Reaction {
            rod: node.rod,
            node: node.node,
            force: std::array::from_fn(|k| if position[k] { component(k) } else { 0.0 }),
            moment: std::array::from_fn(|k| if rotation[k] || is_swivel { component(3 + k) } else { 0.0 }),
        }
    };
    nodes.into_iter().map(reaction).collect()
}

/// What joints exert on each of their nodes: all that is exerted there but reactions of supports.
fn joint_forces(engine: &Engine, reactions: &[Reaction]) -> Vec<JointForce> {
    let model = engine.model();
    if model.joints.is_empty() {
        return Vec::new();
    }
    let mut forces = engine.forces_on_nodes(engine.state());
    for at in reactions {
        let first = 6 * engine.index(NodeRef { rod: at.rod, node: at.node });
        at.force.iter().chain(&at.moment).enumerate().for_each(|(k, of_support)| forces[first + k] -= of_support);
    }
    let mut all = Vec::new();
    let nodes: BTreeSet<NodeRef> = model.joints.iter().flat_map(|joint| [joint.a, joint.b]).collect();
    let mut points: Vec<NodeRef> = Vec::new();
    for node in nodes {
        let first = model.joined_nodes(node).into_iter().min().unwrap_or(node);
        let point = points.iter().position(|other| *other == first).unwrap_or(points.len());
        if point == points.len() {
            points.push(first);
        }
        let six = &forces[6 * engine.index(node)..];
        let (force, moment) = ([six[0], six[1], six[2]], [six[3], six[4], six[5]]);
        all.push(JointForce { point, rod: node.rod, node: node.node, force, moment });
    }
    all
}

#[cfg(test)]
mod tests;
