//! Numbers of contacts at nodes: one per node, and where a node touches several strands at once, one for each of them;
//! besides, one for each plane.
//!
//! Where two strands touch a node, or two places of one that are apart (a knot, a ply of three), each has an entry: an
//! interval of its arc length. A segment of a strand belongs to the entry that is nearest along its curve, so in
//! between numbers change half way from one contact to the next, where nothing touches. Of a single curve nearly all
//! nodes touch one place at most and need no entry: their number follows it wherever it slides.

use std::ops::Range;

use crate::contact::arc::{self, ascending};
use crate::contact::curve::CurveSet;
use crate::contact::potential::ZonePiece;
use crate::math::Vec3;
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::contact_side::ContactSide;

/// Distance of centrelines, over the contact distance, up to which a strand that no longer touches keeps its entry.
/// Farther away no offset is felt.
const REMEMBERED: f64 = 2.0;

/// A place on a strand that a node touches.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Entry {
    node: u32,
    curve: u32,
    /// Arc length \[L\], ascending; on a closed curve possibly beyond its seam.
    arc: [f64; 2],
}

impl Entry {
    /// How far a place on its curve is from it along that \[L\].
    fn distance(&self, set: &CurveSet, arc: [f64; 2]) -> f64 {
        arc::apart(self.arc, arc, set.period(self.curve as usize)).max(0.0)
    }

    /// Takes in a place that is near.
    fn extend(&mut self, set: &CurveSet, arc: [f64; 2]) {
        self.arc = arc::joined(self.arc, arc, set.period(self.curve as usize));
    }
}

/// See the [module](self).
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactField {
    num_nodes: usize,
    num_planes: usize,
    /// Of the nodes; of the nodes towards each plane; of the entries. The number of a node that has entries is for
    /// whatever other strand it touches.
    pub(crate) values: Vec<f64>,
    /// Sorted by node.
    entries: Vec<Entry>,
}

impl ContactField {
    /// The same number at all nodes.
    pub(crate) fn uniform(num_nodes: usize, num_planes: usize, value: f64) -> Self {
        Self::of_nodes(&vec![value; num_nodes], num_planes)
    }

    /// A number per node, for all that it touches.
    pub(crate) fn of_nodes(values: &[f64], num_planes: usize) -> Self {
        Self { num_nodes: values.len(), num_planes, values: values.repeat(1 + num_planes), entries: Vec::new() }
    }

    pub(crate) fn num_nodes(&self) -> usize {
        self.num_nodes
    }

    /// Where the numbers of entries begin.
    fn first_entry(&self) -> usize {
        self.num_nodes * (1 + self.num_planes)
    }

    /// The same places, other numbers, from these and where they are.
    pub(crate) fn map(&self, mut f: impl FnMut(usize, f64) -> f64) -> Self {
        Self { values: self.values.iter().enumerate().map(|(k, x)| f(k, *x)).collect(), ..self.clone() }
    }

    /// Whether it has numbers for a model of so many nodes and planes and these curves.
    pub(crate) fn fits(&self, [num_nodes, num_planes]: [usize; 2], set: &CurveSet) -> bool {
        let known = |e: &Entry| (e.node as usize) < num_nodes && (e.curve as usize) < set.curves.len();
        [self.num_nodes, self.num_planes] == [num_nodes, num_planes]
            && self.values.len() == self.first_entry() + self.entries.len()
            && self.entries.is_sorted_by_key(|e| e.node)
            && self.entries.iter().all(|e| known(e) && e.arc.iter().all(|s| s.is_finite()))
    }

    fn entries_of(&self, node: usize) -> Range<usize> {
        let first = self.entries.partition_point(|e| (e.node as usize) < node);
        first..first + self.entries[first..].iter().take_while(|e| e.node as usize == node).count()
    }

    /// Where all numbers of a node are.
    pub(crate) fn of_node(&self, node: usize) -> impl Iterator<Item = usize> {
        let (nodes, first) = (self.num_nodes, self.first_entry());
        (0..=self.num_planes).map(move |k| k * nodes + node).chain(self.entries_of(node).map(move |k| first + k))
    }

    /// Where the number of a node's contact with a plane is.
    pub(crate) fn index_of_plane(&self, node: usize, plane: usize) -> usize {
        self.num_nodes * (1 + plane) + node
    }

    /// Where the number of a node's contact with a segment is.
    pub(crate) fn index(&self, set: &CurveSet, node: usize, segment: usize) -> usize {
        if self.entries.is_empty() {
            return node;
        }
        self.index_of_arc(set, node, set.curve_of(segment), [0.0, 1.0].map(|u| set.arc_length(segment, u)))
    }

    fn index_of_arc(&self, set: &CurveSet, node: usize, curve: usize, arc: [f64; 2]) -> usize {
        if self.entries.is_empty() {
            return node;
        }
        let own = self.entries_of(node).filter(|&k| self.entries[k].curve as usize == curve);
        let nearest = own.map(|k| (self.entries[k].distance(set, arc), k)).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map_or(node, |(_, k)| self.first_entry() + k)
    }

    /// A node's number for a segment that it touches.
    pub(crate) fn at(&self, set: &CurveSet, node: usize, segment: usize) -> f64 {
        self.values[self.index(set, node, segment)]
    }

    /// A number per node: `choose` of all that a node has.
    pub(crate) fn per_node(&self, choose: fn(f64, f64) -> f64) -> Vec<f64> {
        let mut values = self.of_strands(choose);
        for (k, value) in self.of_planes().iter().enumerate() {
            let chosen = &mut values[k % self.num_nodes];
            *chosen = choose(*chosen, *value);
        }
        values
    }

    /// A number per node: `choose` of all that a node has for strands.
    fn of_strands(&self, choose: fn(f64, f64) -> f64) -> Vec<f64> {
        let mut values = self.values[..self.num_nodes].to_vec();
        for (k, entry) in self.entries.iter().enumerate() {
            let value = &mut values[entry.node as usize];
            *value = choose(*value, self.values[self.first_entry() + k]);
        }
        values
    }

    /// The numbers of the nodes towards the first plane, the second, …
    fn of_planes(&self) -> &[f64] {
        &self.values[self.num_nodes..self.first_entry()]
    }

    /// These numbers on a finer mesh of the same strands, each of whose nodes lies between two of this one's, nearer to
    /// the second by the fraction given.
    pub(crate) fn interleaved(&self, set: &CurveSet, between: &[([usize; 2], f64)]) -> Self {
        let mix = |[a, b]: [f64; 2], part: f64| if part == 0.0 { a } else { a + part * (b - a) };
        let of_row = |row: usize| {
            let number = move |n: usize| self.values[row * self.num_nodes + n];
            between.iter().map(move |(ends, part)| mix(ends.map(number), *part))
        };
        let mut fine = Self {
            num_nodes: between.len(),
            num_planes: self.num_planes,
            values: (0..=self.num_planes).flat_map(of_row).collect(),
            entries: Vec::new(),
        };
        for (node, (ends, part)) in between.iter().enumerate().filter(|_| !self.entries.is_empty()) {
            let [first, second] = ends.map(|n| &self.entries[self.entries_of(n)]);
            let here = |e: &Entry| Entry { node: node as u32, ..*e };
            let mut own: Vec<Entry> = first.iter().map(here).collect();
            for place in second {
                match own.iter_mut().find(|e| e.curve == place.curve && e.distance(set, place.arc) == 0.0) {
                    Some(known) => known.extend(set, place.arc),
                    None => own.push(here(place)),
                }
            }
            for e in &own {
                let at = |n: usize| self.values[self.index_of_arc(set, n, e.curve as usize, e.arc)];
                fine.values.push(mix(ends.map(at), *part));
            }
            fine.entries.extend(own);
        }
        fine
    }

    /// These numbers at the places of others; nodes that have one again take the largest.
    pub(crate) fn at_places_of(&self, set: &CurveSet, other: &Self) -> Self {
        if self.entries == other.entries {
            return self.clone();
        }
        let mut values = self.of_strands(f64::max);
        other.entries.iter().for_each(|e| values[e.node as usize] = 0.0);
        values.extend(self.of_planes());
        let of_entry = |e: &Entry| self.values[self.index_of_arc(set, e.node as usize, e.curve as usize, e.arc)];
        values.extend(other.entries.iter().map(of_entry));
        Self { values, entries: other.entries.clone(), ..*self }
    }
}

/// Nodes by what touches near them: the place on the other strand as long as that is one and the same.
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
    /// Farther from it along the other strand is another contact \[L\]: beyond what one contact spans in the window,
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
fn seen<'a>(
    side: &'a ContactSide,
    residual: &'a Residual,
    window: &'a impl Fn(usize, usize) -> f64,
) -> impl Iterator<Item = Seen<'a>> {
    residual.contact_pairs.iter().flat_map(move |term| {
        let (slave, master) = (term.slave, term.master);
        let window = window(slave, master);
        let apart = (2.0 * window).max(side.set.radius_of(slave) + side.set.radius_of(master));
        term.zones.iter().map(move |zone| {
            let arc = ascending(zone.piece.v.map(|v| side.set.arc_length(master, v)));
            let place = Entry { node: 0, curve: side.set.curve_of(master) as u32, arc };
            Seen { slave, master, zone, window, apart, place }
        })
    })
}

/// Smallest gap of each contact in the window of each node \[L\], infinite where nothing touches; `window(slave, master)`,
/// without a master of contact with planes. Offsets at nodes that
/// touch several strands get entries of their own by that; those that there are already stay for as long as the strands
/// are near.
pub(crate) fn smallest_gaps(
    side: &ContactSide,
    residual: &Residual,
    positions: &[Vec3],
    window: impl Fn(usize, Option<usize>) -> f64,
) -> ContactField {
    let (num_nodes, num_planes) = (positions.len(), side.planes.len());
    let set = &side.set;
    let of_pair = |slave, master| window(slave, Some(master));
    let alone = set.curves.len() == 1;
    let mut partners = vec![if alone { Partner::None } else { Partner::Several }; num_nodes];
    side.offsets.entries.iter().for_each(|e| partners[e.node as usize] = Partner::Several);
    let counted = |seen: &Seen| !seen.zone.piece.branch.is_subtracted();
    for seen in seen(side, residual, &of_pair).filter(counted) {
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
    let several = |node: usize| matches!(partners[node], Partner::Several);
    let mut entries = Vec::new();
    if (0..num_nodes).any(several) {
        let (mut places, mut apart): (Vec<(Entry, f64)>, f64) = (Vec::new(), 0.0);
        for seen in seen(side, residual, &of_pair).filter(counted) {
            seen.by_nodes(side, |node| {
                if several(node) {
                    apart = apart.max(seen.apart);
                    places.push((Entry { node: node as u32, ..seen.place }, seen.apart));
                }
            });
        }
        entries = joined(set, places);
        remember(side, positions, apart, &mut entries);
    }
    let places = ContactField { num_nodes, num_planes, values: Vec::new(), entries };
    let count = places.first_entry() + places.entries.len();
    let mut gaps = ContactField { values: vec![f64::INFINITY; count], ..places };
    for seen in seen(side, residual, &of_pair) {
        let gap = seen.zone.min_gap;
        seen.by_nodes(side, |node| {
            let index = gaps.index(set, node, seen.master);
            gaps.values[index] = gaps.values[index].min(gap);
        });
    }
    for contact in &residual.plane_contacts {
        let (window, gap) = (window(contact.segment, None), contact.min_gap());
        for forward in [true, false] {
            side.spread(contact.segment, window, forward, |node| {
                let index = gaps.index_of_plane(node, contact.plane);
                gaps.values[index] = gaps.values[index].min(gap);
            });
        }
    }
    gaps
}

/// Places of a node that are no farther apart than one contact may be, joined; sorted by node.
fn joined(set: &CurveSet, mut places: Vec<(Entry, f64)>) -> Vec<Entry> {
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
    let entries_found = std::mem::take(entries);
    let found = ContactField { num_nodes: positions.len(), num_planes: 0, values: Vec::new(), entries: entries_found };
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

#[cfg(test)]
mod tests;
