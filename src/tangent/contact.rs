//! Contact in the tangent: as the law in force has it, locked, or free.
//!
//! The law's tangent is κ ∂g ∂gᵀ at each point of a zone, and the pressure's geometric part. What κ means depends on
//! the kind of contact (told apart as in reports):
//!
//! * A *point* has one force, where the strands are nearest. The law spreads it over a zone, whose ends follow the
//!   strands as they tilt; that part of the law's stiffness is geometric, F/d″, and does not depend on κ. The law's
//!   own part is b bᵀ/m, b = ∫κ ∂g ds and m = ∫κ ds: that of the mean gap.
//! * Along a *line* each point has a pressure of its own. The law's part is all of ∫κ ∂g ∂gᵀ ds.
//!
//! *Free* takes the law's part out, *locked* makes it [`HARDER`] times as stiff.

use std::collections::BTreeMap;

use crate::contact::chain::chains;
use crate::contact::law::{Law, shortest_line};
use crate::contact::potential::second_order::gap_gradients;
use crate::contact::potential::surface::{SurfacePiece, surface_runs};
use crate::math::groups::Groups;
use crate::scene::ContactLaw;
use crate::solve::Engine;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_side::ContactSide;
use crate::solve::problem::linearised::NodeVector;

/// How much stiffer than the law locked contact is, because the law leaves about 1e-3 of a motion that closes a gap,
/// this 1e-7, and the matrix is then as stiff as that of stretch is anyway.
const HARDER: f64 = 1e4;

/// How gaps that carry force respond.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactResponse {
    /// As the contact law in force: the tangent of the potential that was minimised.
    #[default]
    ByLaw,
    /// They stay closed, and open as little as they close.
    Locked,
    /// Nothing resists their change: forces stay, and turn with the strands.
    Free,
}

impl ContactResponse {
    /// What a derivative of an equilibrium under a law is made with: gaps stay closed under the augmented Lagrangian, and
    /// give under a penalty.
    #[must_use]
    pub fn of_law(law: ContactLaw) -> Self {
        match law {
            ContactLaw::AugmentedLagrangian { .. } | ContactLaw::ByMesh { .. } => Self::Locked,
            ContactLaw::Penalty { .. } | ContactLaw::None => Self::ByLaw,
        }
    }
}

/// A pair of segments, the smaller index first, or a segment and an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum TouchPlace {
    Pair([usize; 2]),
    Surface(usize, usize),
}

/// A contact: its places, and whether it is a point.
#[derive(Debug, Clone, Default)]
pub(super) struct Touching {
    places: Vec<TouchPlace>,
    pub(super) is_point: bool,
    /// Sum of the magnitudes of its force \[F\].
    pub(super) force: f64,
}

/// All contacts at a state, from its residual with zones.
pub(super) fn contacts(engine: &Engine, residual: &Residual) -> Vec<Touching> {
    let Some(side) = &engine.contact else { return Vec::new() };
    let mut parts = parts(side, residual);
    let index: BTreeMap<TouchPlace, usize> = {
        let mut all: Vec<TouchPlace> = parts.iter().flat_map(|part| part.places.iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter().zip(0..).collect()
    };
    let mut scratch = Vec::new();
    let mut groups = Groups::apart(index.len(), &mut scratch);
    for part in &parts {
        part.places.iter().for_each(|place| groups.join(index[&part.places[0]], index[place]));
    }
    let mut found: BTreeMap<usize, Touching> = BTreeMap::new();
    for part in &mut parts {
        let contact = found
            .entry(groups.first(index[&part.places[0]]))
            .or_insert(Touching { is_point: true, ..Touching::default() });
        contact.is_point &= part.length <= shortest(engine, side, &part.places);
        contact.force += part.force;
        contact.places.append(&mut part.places);
    }
    let tidy = |mut contact: Touching| {
        contact.places.sort_unstable();
        contact.places.dedup();
        contact
    };
    found.into_values().map(tidy).collect()
}

/// A contact as one strand has it.
struct OneSide {
    places: Vec<TouchPlace>,
    length: f64,
    force: f64,
}

fn parts(side: &ContactSide, residual: &Residual) -> Vec<OneSide> {
    let strands = chains(&side.set, &residual.contact_pairs);
    let of_chain = |chain: &Vec<crate::contact::chain::ChainPiece>| OneSide {
        places: chain.iter().map(|piece| pair(piece.segments)).collect(),
        length: chain.iter().map(|piece| piece.arcs[0][1] - piece.arcs[0][0]).sum(),
        force: chain.iter().map(|piece| piece.zone.half_force).sum(),
    };
    let runs = surface_runs(&side.set, &residual.surface_contacts);
    let of_run = |run: &Vec<SurfacePiece>| OneSide {
        places: run.iter().map(|piece| TouchPlace::Surface(piece.segment, piece.surface)).collect(),
        length: run.iter().map(|piece| (piece.zone.u[1] - piece.zone.u[0]) * side.set.lengths[piece.segment]).sum(),
        force: run.iter().map(|piece| piece.zone.moments[0]).sum(),
    };
    strands.iter().map(of_chain).chain(runs.iter().map(of_run)).collect()
}

fn pair([a, b]: [usize; 2]) -> TouchPlace {
    TouchPlace::Pair([a.min(b), a.max(b)])
}

/// Length up to which a contact at some places is a point \[L\], as in reports of sites.
fn shortest(engine: &Engine, side: &ContactSide, places: &[TouchPlace]) -> f64 {
    let stiffness = match side.law {
        Law::Linear { stiffness } => stiffness,
        Law::Core { .. } => engine.contact_stiffness(),
    };
    let rod = |segment: usize| &engine.model().rods[engine.rod_of(side.nodes[segment][0])];
    let element = |segment: usize| rod(segment).length / rod(segment).num_elements as f64;
    let bending = |segment: usize| rod(segment).section.smaller_bending();
    match places[0] {
        TouchPlace::Pair([a, b]) => shortest_line(stiffness, [bending(a), bending(b)]).max(element(a)).max(element(b)),
        TouchPlace::Surface(a, _) => shortest_line(stiffness, [bending(a), f64::INFINITY]).max(element(a)),
    }
}

/// Nodes of each contact that is a point: products of its mean gap couple all of them.
pub(super) fn coupled(engine: &Engine, contacts: &[Touching]) -> Vec<Vec<usize>> {
    let Some(side) = &engine.contact else { return Vec::new() };
    let of_place = |place: &TouchPlace| match place {
        TouchPlace::Pair(pair) => pair.iter().flat_map(|&segment| side.nodes[segment]).collect::<Vec<_>>(),
        TouchPlace::Surface(segment, surface) => {
            let (nodes, count) = side.nodes_at_surface(*segment, *surface);
            nodes[..count].to_vec()
        }
    };
    contacts.iter().filter(|contact| contact.is_point).map(|c| c.places.iter().flat_map(of_place).collect()).collect()
}

/// How a gap changes with the unknowns, and the stiffness of its response.
#[derive(Debug, Clone)]
pub(super) struct GapRate {
    pub(super) rate: NodeVector,
    /// ∫κ ds \[F/L\].
    pub(super) stiffness: f64,
    /// The rods of the strands.
    rods: [Option<usize>; 2],
    /// The obstacle, and by how much a unit of its level closes the gap: 1 from outside, −1 from inside.
    surface: Option<(usize, f64)>,
}

impl GapRate {
    /// By how much a unit of a parameter that changes gaps closes it, unknowns fixed: a radius of a rod, the level of an
    /// obstacle.
    pub(super) fn closing(&self, thicker: Option<usize>, raised: Option<usize>) -> f64 {
        let strands = self.rods.iter().filter(|rod| rod.is_some() && **rod == thicker).count();
        let of_surface = self.surface.filter(|(surface, _)| Some(*surface) == raised);
        strands as f64 + of_surface.map_or(0.0, |(_, closing)| closing)
    }
}

/// [`GapRate`] of the points of each contact, by the residual of the tangent.
pub(super) fn gap_rates(engine: &Engine, contacts: &[Touching], residual: &Residual) -> Vec<Vec<GapRate>> {
    let Some(side) = &engine.contact else { return Vec::new() };
    let mut owner = BTreeMap::new();
    for (k, contact) in contacts.iter().enumerate() {
        owner.extend(contact.places.iter().map(|place| (*place, k)));
    }
    let rod = |segment: usize| Some(engine.rod_of(side.nodes[segment][0]));
    let mut rates: Vec<Vec<GapRate>> = vec![Vec::new(); contacts.len()];
    for term in &residual.contact_pairs {
        let Some(&contact) = owner.get(&pair([term.slave, term.master])) else { continue };
        let (segments, nodes) = ([term.slave, term.master], side.nodes_of(term));
        let cubics = segments.map(|segment| &side.set.segments[segment]);
        rates[contact].extend(gap_gradients(term, cubics).map(|(rate, stiffness)| {
            let rate = at_nodes(&nodes, &rate);
            GapRate { rate, stiffness, rods: segments.map(rod), surface: None }
        }));
    }
    for contact in &residual.surface_contacts {
        let Some(&index) = owner.get(&TouchPlace::Surface(contact.segment, contact.surface)) else { continue };
        let surface = &side.surfaces[contact.surface];
        let (nodes, count) = side.nodes_at_surface(contact.segment, contact.surface);
        rates[index].extend(contact.gap_gradients(&side.set).map(|(rate, stiffness)| {
            let rate = at_nodes(&nodes[..count], &rate);
            let surface = Some((contact.surface, surface.sign));
            GapRate { rate, stiffness, rods: [rod(contact.segment), None], surface }
        }));
    }
    rates
}

fn at_nodes(nodes: &[usize], rate: &[f64]) -> NodeVector {
    nodes.iter().zip(rate.chunks_exact(6)).map(|(node, six)| (*node, std::array::from_fn(|k| six[k]))).collect()
}

/// The mean of the points of a contact, each node once, with the sum of their stiffnesses.
fn mean(points: &[GapRate]) -> Option<GapRate> {
    let stiffness: f64 = points.iter().map(|point| point.stiffness).sum();
    let mut sum: BTreeMap<usize, [f64; 6]> = BTreeMap::new();
    for point in points {
        for (node, six) in &point.rate {
            let own = sum.entry(*node).or_default();
            (0..6).for_each(|k| own[k] += point.stiffness / stiffness * six[k]);
        }
    }
    Some(GapRate { rate: sum.into_iter().collect(), stiffness, ..points.first()?.clone() })
}

/// What locking or freeing adds to the law's response.
pub(super) fn changes(choice: ContactResponse, contacts: &[Touching], rates: &[Vec<GapRate>]) -> Vec<GapRate> {
    let factor = match choice {
        ContactResponse::ByLaw => return Vec::new(),
        ContactResponse::Locked => HARDER - 1.0,
        ContactResponse::Free => -1.0,
    };
    let of_contact = |(contact, points): (&Touching, &Vec<GapRate>)| match contact.is_point {
        true => mean(points).into_iter().collect(),
        false => points.clone(),
    };
    let all = contacts.iter().zip(rates).flat_map(of_contact);
    all.map(|change| GapRate { stiffness: factor * change.stiffness, ..change }).collect()
}

/// The response of contact in the chosen tangent: the law's with its [`changes`].
pub(super) fn responses(choice: ContactResponse, contacts: &[Touching], rates: &[Vec<GapRate>]) -> Vec<GapRate> {
    rates.iter().flatten().cloned().chain(changes(choice, contacts, rates)).collect()
}

/// Stiffness of the response of each point of contact that is locked, with its force; `None` if a contact is a line.
pub(super) fn locks(contacts: &[Touching], rates: &[Vec<GapRate>]) -> Option<Vec<(f64, f64)>> {
    let lock = |(contact, points): (&Touching, &Vec<GapRate>)| {
        let stiffness: f64 = points.iter().map(|point| point.stiffness).sum();
        contact.is_point.then_some((contact.force, HARDER * stiffness))
    };
    contacts.iter().zip(rates).map(lock).collect()
}
