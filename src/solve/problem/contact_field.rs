//! Numbers of contacts at nodes: one per node, and where a node touches several strands at once, one for each of them;
//! besides, one for each obstacle.
//!
//! Where two strands touch a node, or two places of one that are apart (a knot, a ply of three), each has an entry: an
//! interval of its arc length. A segment of a strand belongs to the entry that is nearest along its curve, so in
//! between numbers change half way from one contact to the next, where nothing touches. Of a single curve nearly all
//! nodes touch one place at most and need no entry: their number follows it wherever it slides.

use std::ops::Range;

use crate::contact::arc;
use crate::contact::curve::CurveSet;

/// A place on a strand that a node touches.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Entry {
    pub(super) node: u32,
    pub(super) curve: u32,
    /// Arc length \[L\], ascending; on a closed curve possibly beyond its seam.
    pub(super) arc: [f64; 2],
}

impl Entry {
    /// How far a place on its curve is from it along that \[L\].
    pub(super) fn distance(&self, set: &CurveSet, arc: [f64; 2]) -> f64 {
        arc::apart(self.arc, arc, set.period(self.curve as usize)).max(0.0)
    }

    /// Takes in a place that is near.
    pub(super) fn extend(&mut self, set: &CurveSet, arc: [f64; 2]) {
        self.arc = arc::joined(self.arc, arc, set.period(self.curve as usize));
    }
}

/// See the [module](self).
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactField {
    num_nodes: usize,
    num_surfaces: usize,
    /// Of the nodes; of the nodes towards each obstacle; of the entries. The number of a node that has entries is for
    /// whatever other strand it touches.
    pub(crate) values: Vec<f64>,
    /// Sorted by node.
    pub(super) entries: Vec<Entry>,
}

impl ContactField {
    /// The same number at all nodes.
    pub(crate) fn uniform(num_nodes: usize, num_surfaces: usize, value: f64) -> Self {
        Self::of_nodes(&vec![value; num_nodes], num_surfaces)
    }

    /// The same number at all nodes and these entries.
    pub(super) fn uniform_with(num_nodes: usize, num_surfaces: usize, entries: Vec<Entry>, value: f64) -> Self {
        let count = num_nodes * (1 + num_surfaces) + entries.len();
        Self { num_nodes, num_surfaces, values: vec![value; count], entries }
    }

    /// A number per node, for all that it touches.
    pub(crate) fn of_nodes(values: &[f64], num_surfaces: usize) -> Self {
        Self { num_nodes: values.len(), num_surfaces, values: values.repeat(1 + num_surfaces), entries: Vec::new() }
    }

    pub(crate) fn num_nodes(&self) -> usize {
        self.num_nodes
    }

    /// Where the numbers of entries begin.
    fn first_entry(&self) -> usize {
        self.num_nodes * (1 + self.num_surfaces)
    }

    /// The same places, other numbers, from these and where they are.
    pub(crate) fn map(&self, mut f: impl FnMut(usize, f64) -> f64) -> Self {
        Self { values: self.values.iter().enumerate().map(|(k, x)| f(k, *x)).collect(), ..self.clone() }
    }

    /// Whether it has numbers for a model of so many nodes and obstacles and these curves.
    pub(crate) fn fits(&self, [num_nodes, num_surfaces]: [usize; 2], set: &CurveSet) -> bool {
        let known = |e: &Entry| (e.node as usize) < num_nodes && (e.curve as usize) < set.curves.len();
        [self.num_nodes, self.num_surfaces] == [num_nodes, num_surfaces]
            && self.values.len() == self.first_entry() + self.entries.len()
            && self.entries.is_sorted_by_key(|e| e.node)
            && self.entries.iter().all(|e| known(e) && e.arc.iter().all(|s| s.is_finite()))
    }

    /// Where the entries of a node are.
    pub(super) fn entries_of(&self, node: usize) -> Range<usize> {
        let first = self.entries.partition_point(|e| (e.node as usize) < node);
        first..first + self.entries[first..].iter().take_while(|e| e.node as usize == node).count()
    }

    /// Where the number of a node's contact with an obstacle is.
    pub(crate) fn index_of_surface(&self, node: usize, surface: usize) -> usize {
        self.num_nodes * (1 + surface) + node
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
        for (k, value) in self.of_surfaces().iter().enumerate() {
            let chosen = &mut values[k % self.num_nodes];
            *chosen = choose(*chosen, *value);
        }
        values
    }

    /// The numbers of a rod whose nodes come from these, one for all strands that a node touches: the largest.
    pub(crate) fn moved(&self, from: impl Iterator<Item = usize>) -> Self {
        let from: Vec<usize> = from.collect();
        let rows = [self.of_strands(f64::max), self.of_surfaces().to_vec()].concat();
        let values = rows.chunks(self.num_nodes).flat_map(|row| from.iter().map(|node| row[*node])).collect();
        Self { num_nodes: from.len(), num_surfaces: self.num_surfaces, values, entries: Vec::new() }
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

    /// The numbers of the nodes towards the first obstacle, the second, …
    fn of_surfaces(&self) -> &[f64] {
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
            num_surfaces: self.num_surfaces,
            values: (0..=self.num_surfaces).flat_map(of_row).collect(),
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
        values.extend(self.of_surfaces());
        let of_entry = |e: &Entry| self.values[self.index_of_arc(set, e.node as usize, e.curve as usize, e.arc)];
        values.extend(other.entries.iter().map(of_entry));
        Self { values, entries: other.entries.clone(), ..*self }
    }
}

#[cfg(test)]
mod tests;
