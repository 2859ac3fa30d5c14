//! Contact in the tangent: as the law in force has it, locked, or free.
//!
//! The law's tangent is κ ∂g ∂gᵀ at each point of a zone, and the pressure's geometric part. What κ means depends on
//! the kind of contact (distinguished as in reports):
//!
//! * A *point* has one force, where the strands are nearest. The law spreads it over a zone, whose ends follow the
//!   strands as they tilt; that part of the law's stiffness is geometric, F/d″, and does not depend on κ. The law's
//!   own part is b bᵀ/m, b = ∫κ ∂g ds and m = ∫κ ds: that of the mean gap.
//! * Along a *line* each point has a pressure of its own. The law's part is all of ∫κ ∂g ∂gᵀ ds.
//!
//! *Free* takes the law's part out, *locked* makes it [`HARDER`] times as stiff.
//!
//! Under the augmented Lagrangian what stays is the *smallest* gap of a point: its offsets are raised until that is 0.
//! It differs from the mean gap by the bend of the strands over the zone, of which a force takes 1e-5. Derivatives of
//! equilibria therefore have a row ∂(smallest gap) and a column b for each point, see [`ClosedPoint`].

use std::collections::BTreeMap;

use crate::contact::chain::chains;
use crate::contact::law::{Law, shortest_line};
use crate::contact::potential::second_order::{gap_gradient, gap_gradients};
use crate::contact::potential::surface::{SurfacePiece, surface_runs};
use crate::math::Vec3;
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
    /// What a derivative of an equilibrium under a law is made with: gaps stay closed under the augmented Lagrangian,
    /// and give under a penalty.
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
    let side = &engine.contact;
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
        force: chain.iter().map(|piece| piece.zone.force).sum(),
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
    let side = &engine.contact;
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
    pub(super) rods: [Option<usize>; 2],
    /// The obstacle, if it is the other body.
    pub(super) surface: Option<PushedBy>,
    /// Whether it is the mean of a point of contact.
    pub(super) is_point: bool,
}

/// An obstacle at a point of contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct PushedBy {
    pub(super) obstacle: usize,
    /// 1 where strands are outside, −1 where they are inside.
    pub(super) sign: f64,
    /// Of its surface, towards the strand.
    pub(super) normal: Vec3,
    /// \[L\]
    pub(super) at: Vec3,
}

/// A point of contact whose smallest gap stays, whatever force that takes. Its force is that of an offset c, which is
/// the same in the whole zone: with it the linear problem is
///
/// ```text
/// [K  −b] [δx]   [−∂r/∂p]
/// [aᵀ  0] [δc] = [−∂g/∂p]      a = ∂(smallest gap)/∂x, b = ∫κ ∂gap ds
/// ```
#[derive(Debug, Clone)]
pub(super) struct ClosedPoint {
    places: Vec<TouchPlace>,
    pub(super) smallest: NodeVector,
    pub(super) push: NodeVector,
    /// ∫κ ds \[F/L\].
    pub(super) stiffness: f64,
}

/// The points of contact, by a residual with zones.
pub(super) fn closed_points(
    engine: &Engine,
    contacts: &[Touching],
    rates: &[Vec<GapRate>],
    residual: &Residual,
) -> Vec<ClosedPoint> {
    let side = &engine.contact;
    let of_contact = |(contact, points): (&Touching, &Vec<GapRate>)| {
        let (_, smallest) = nearest(side, &contact.places, residual)?;
        let mean = mean(points)?;
        let push = mean.rate.iter().map(|(node, six)| (*node, six.map(|x| x * mean.stiffness))).collect();
        Some(ClosedPoint { places: contact.places.clone(), smallest, push, stiffness: mean.stiffness })
    };
    contacts.iter().zip(rates).filter(|(contact, _)| contact.is_point).filter_map(of_contact).collect()
}

/// Smallest gap at some places with its rate, by a residual with zones.
fn nearest(side: &ContactSide, places: &[TouchPlace], residual: &Residual) -> Option<(f64, NodeVector)> {
    let is_of = |place: TouchPlace| places.binary_search(&place).is_ok();
    let pairs = residual.contact_pairs.iter().filter(|term| is_of(pair([term.slave, term.master])));
    let zones = pairs.flat_map(|term| term.zones.iter().map(move |zone| (term, zone)));
    let zones = zones.filter(|(_, zone)| !zone.piece.branch.is_subtracted());
    let strand = zones.min_by(|a, b| a.1.min_gap.total_cmp(&b.1.min_gap)).and_then(|(term, zone)| {
        let cubics = [term.slave, term.master].map(|segment| &side.set.segments[segment]);
        let rate = gap_gradient(cubics, [zone.piece.nearest.u, zone.piece.nearest.v])?;
        Some((zone.min_gap, at_nodes(&side.nodes_of(term), &rate)))
    });
    let surfaces = residual.surface_contacts.iter();
    let surfaces = surfaces.filter(|contact| is_of(TouchPlace::Surface(contact.segment, contact.surface)));
    let surface = surfaces.min_by(|a, b| a.min_gap().total_cmp(&b.min_gap())).and_then(|contact| {
        let point = contact.nearest(&side.set, &side.surfaces[contact.surface])?;
        let (nodes, count) = side.nodes_at_surface(contact.segment, contact.surface);
        Some((contact.min_gap(), at_nodes(&nodes[..count], &point.gap_gradient)))
    });
    strand.into_iter().chain(surface).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Smallest gaps \[L\] of points of contact in a residual with zones, NaN of one that is no longer near.
pub(super) fn gaps_of(engine: &Engine, closed: &[ClosedPoint], residual: &Residual) -> Vec<f64> {
    let smallest = |point: &ClosedPoint| nearest(&engine.contact, &point.places, residual);
    closed.iter().map(|point| smallest(point).map_or(f64::NAN, |(gap, _)| gap)).collect()
}

/// Where the offsets of a point of contact are.
pub(super) fn offsets_of(engine: &Engine, point: &ClosedPoint) -> Vec<usize> {
    let side = &engine.contact;
    let of_place = |place: &TouchPlace| match *place {
        TouchPlace::Pair([a, b]) => {
            let both = [(a, b), (b, a)].into_iter();
            let towards =
                |(own, other): (usize, usize)| side.nodes[own].map(|node| side.offsets.index(&side.set, node, other));
            both.flat_map(towards).collect::<Vec<_>>()
        }
        TouchPlace::Surface(segment, surface) => {
            side.nodes[segment].map(|node| side.offsets.index_of_surface(node, surface)).to_vec()
        }
    };
    let mut all: Vec<usize> = point.places.iter().flat_map(of_place).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Sum of the forces of all contacts \[F\], by a residual with zones.
pub(super) fn total_force(engine: &Engine, residual: &Residual) -> f64 {
    parts(&engine.contact, residual).iter().map(|part| part.force).sum()
}

/// [`GapRate`] of the points of each contact, by the residual of the tangent.
pub(super) fn gap_rates(engine: &Engine, contacts: &[Touching], residual: &Residual) -> Vec<Vec<GapRate>> {
    let side = &engine.contact;
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
            GapRate { rate, stiffness, rods: segments.map(rod), surface: None, is_point: false }
        }));
    }
    for contact in &residual.surface_contacts {
        let Some(&index) = owner.get(&TouchPlace::Surface(contact.segment, contact.surface)) else { continue };
        let surface = &side.surfaces[contact.surface];
        let (nodes, count) = side.nodes_at_surface(contact.segment, contact.surface);
        rates[index].extend(contact.gap_gradients(&side.set).map(|(point, stiffness)| {
            let rate = at_nodes(&nodes[..count], &point.gap_gradient);
            let by = PushedBy { obstacle: contact.surface, sign: surface.sign, normal: point.normal, at: point.at };
            let rods = [rod(contact.segment), None];
            GapRate { rate, stiffness, rods, surface: Some(by), is_point: false }
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
    let mut all = points.first()?.clone();
    if let Some(by) = &mut all.surface {
        let pushes = points.iter().filter_map(|point| Some((point.stiffness / stiffness, point.surface?)));
        let zero = (Vec3::zeros(), Vec3::zeros());
        (by.normal, by.at) = pushes.fold(zero, |(n, x), (w, push)| (n + push.normal * w, x + push.at * w));
    }
    Some(GapRate { rate: sum.into_iter().collect(), stiffness, is_point: true, ..all })
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
