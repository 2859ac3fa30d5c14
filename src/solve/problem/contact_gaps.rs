//! Smallest gap of each contact near each node, and the entries of the contacts that a node has.

use crate::contact::arc::ascending;
use crate::contact::curve::CurveSet;
use crate::contact::potential::{ContactPair, ZonePiece};
use crate::math::Vec3;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_field::{ContactField, Entry};
use crate::solve::problem::contact_side::ContactSide;

/// Distance of centrelines, over the contact distance, up to which a strand that no longer touches keeps its entry,
/// because no offset is felt farther away.
const REMEMBERED: f64 = 2.0;

/// The contact near a node: its place on the other strand, if there is only one.
#[derive(Clone, Copy)]
enum Partner {
    None,
    One(Entry),
    Several,
}

/// A zone as its slave's nodes see it.
struct Seen<'a> {
    slave: usize,
    master: usize,
    zone: &'a ZonePiece,
    window: f64,
    /// Farther from it along the other strand is another contact \[L\]: beyond the extent of one contact in the window,
    /// and beyond the contact distance. Feet on one strand that far from each other lie 60° apart or more about the
    /// slave.
    apart: f64,
    /// Its place on the other strand; the node is still to be said.
    place: Entry,
}

impl Seen<'_> {
    fn by_nodes(&self, side: &ContactSide, mut visit: impl FnMut(usize)) {
        for forward in [true, false] {
            side.spread(self.slave, self.window, forward, &mut visit);
        }
    }
}

/// All zones, with the window that `window(slave, master)` gives them.
fn seen<'a>(side: &ContactSide, residual: &'a Residual, window: impl Fn(usize, usize) -> f64) -> Vec<Seen<'a>> {
    let of_pair = |term: &'a ContactPair| {
        let (slave, master) = (term.slave, term.master);
        let window = window(slave, master);
        let apart = (2.0 * window).max(side.set.radius_of(slave) + side.set.radius_of(master));
        term.zones.iter().map(move |zone| {
            let arc = ascending(zone.piece.v.map(|v| side.set.arc_length(master, v)));
            let place = Entry { node: 0, curve: side.set.curve_of(master) as u32, arc };
            Seen { slave, master, zone, window, apart, place }
        })
    };
    residual.contact_pairs.iter().flat_map(of_pair).collect()
}

/// Smallest gap of each contact in the window of each node \[L\], infinite where nothing touches; `window(slave,
/// master)`, without a master of contact with obstacles. Offsets at nodes that touch several strands get entries of
/// their own by that; those that there are already stay for as long as the strands are near.
pub(crate) fn smallest_gaps(
    side: &ContactSide,
    residual: &Residual,
    positions: &[Vec3],
    window: impl Fn(usize, Option<usize>) -> f64,
) -> ContactField {
    let seen = seen(side, residual, |slave, master| window(slave, Some(master)));
    let entries = entries(side, &seen, positions);
    let [num_nodes, num_surfaces] = side.size();
    let mut gaps = ContactField::uniform_with(num_nodes, num_surfaces, entries, f64::INFINITY);
    for seen in &seen {
        let gap = seen.zone.min_gap;
        seen.by_nodes(side, |node| {
            let index = gaps.index(&side.set, node, seen.master);
            gaps.values[index] = gaps.values[index].min(gap);
        });
    }
    for contact in &residual.surface_contacts {
        let (window, gap) = (window(contact.segment, None), contact.min_gap());
        for forward in [true, false] {
            side.spread(contact.segment, window, forward, |node| {
                let index = gaps.index_of_surface(node, contact.surface);
                gaps.values[index] = gaps.values[index].min(gap);
            });
        }
    }
    gaps
}

/// Entries of the contacts of nodes that touch several strands, now or when the offsets were found; sorted by node.
fn entries(side: &ContactSide, seen: &[Seen], positions: &[Vec3]) -> Vec<Entry> {
    let counted = || seen.iter().filter(|seen| !seen.zone.piece.branch.is_subtracted());
    let partners = partners(side, counted(), positions.len());
    let touches_several = |node: usize| matches!(partners[node], Partner::Several);
    if !(0..positions.len()).any(touches_several) {
        return Vec::new();
    }
    let (mut places, mut apart): (Vec<(Entry, f64)>, f64) = (Vec::new(), 0.0);
    for seen in counted() {
        seen.by_nodes(side, |node| {
            if touches_several(node) {
                apart = apart.max(seen.apart);
                places.push((Entry { node: node as u32, ..seen.place }, seen.apart));
            }
        });
    }
    let mut entries = joined(&side.set, places);
    remember(side, positions, apart, &mut entries);
    entries
}

/// Partner of each node. With several curves every node counts as one that touches several strands, because an entry
/// names the curve.
fn partners<'a>(side: &ContactSide, seen: impl Iterator<Item = &'a Seen<'a>>, num_nodes: usize) -> Vec<Partner> {
    let set = &side.set;
    let alone = set.curves.len() == 1;
    let mut partners = vec![if alone { Partner::None } else { Partner::Several }; num_nodes];
    side.offsets.entries.iter().for_each(|e| partners[e.node as usize] = Partner::Several);
    for seen in seen {
        seen.by_nodes(side, |node| {
            let partner = &mut partners[node];
            match partner {
                Partner::None => *partner = Partner::One(seen.place),
                Partner::One(place) => {
                    if place.curve == seen.place.curve && place.distance(set, seen.place.arc) <= seen.apart {
                        place.extend(set, seen.place.arc);
                    } else {
                        *partner = Partner::Several;
                    }
                }
                Partner::Several => {}
            }
        });
    }
    partners
}

/// Places of a node that are no farther apart than one contact may be, joined; sorted by node.
pub(super) fn joined(set: &CurveSet, mut places: Vec<(Entry, f64)>) -> Vec<Entry> {
    places.sort_by(|(x, _), (y, _)| (x.node, x.curve).cmp(&(y.node, y.curve)).then(x.arc[0].total_cmp(&y.arc[0])));
    let mut entries: Vec<Entry> = Vec::new();
    for alike in places.chunk_by(|(x, _), (y, _)| (x.node, x.curve) == (y.node, y.curve)) {
        let mut own: Vec<Entry> = Vec::new();
        for (place, apart) in alike {
            match own.last_mut().filter(|last| last.distance(set, place.arc) <= *apart) {
                Some(last) => last.extend(set, place.arc),
                None => own.push(*place),
            }
        }
        // over the seam of a closed strand the last goes on in the first
        let apart = alike.iter().map(|(_, apart)| *apart).fold(0.0, f64::max);
        if let [first, .., last] = own[..]
            && first.distance(set, last.arc) <= apart
        {
            own[0].extend(set, last.arc);
            own.pop();
        }
        entries.extend(own);
    }
    entries
}

/// Adds the entries that there are already whose strands, out of reach by now, are still near; of a single curve leaves
/// out those of nodes that have but one.
fn remember(side: &ContactSide, positions: &[Vec3], apart: f64, entries: &mut Vec<Entry>) {
    let set = &side.set;
    let found = ContactField::uniform_with(positions.len(), 0, std::mem::take(entries), 0.0);
    let mut all = found.entries.clone();
    for old in &side.offsets.entries {
        let own = found.entries_of(old.node as usize);
        let known = found.entries[own].iter().any(|e| e.curve == old.curve && e.distance(set, old.arc) <= apart);
        let (point, radius) = point_of(set, old);
        let near = REMEMBERED * (radius + side.min_radius);
        if !known && (positions[old.node as usize] - point).norm() <= near {
            all.push(*old);
        }
    }
    all.sort_by_key(|e| e.node);
    let wanted = |own: &&[Entry]| own.len() > 1 || set.curves.len() > 1;
    *entries = all.chunk_by(|x, y| x.node == y.node).filter(wanted).flatten().copied().collect();
}

/// The middle of a place, and the radius there \[L\].
fn point_of(set: &CurveSet, entry: &Entry) -> (Vec3, f64) {
    let middle = 0.5 * (entry.arc[0] + entry.arc[1]);
    let (segment, u) = set.at_arc(entry.curve as usize, middle);
    (set.segments[segment].point(u), set.radius_of(segment))
}
