//! The elements' own centreline, in arcs.
//!
//! Each part of an element between two nodes is cut into arcs that turn by less than [`MAX_TURN`]: cubics of a
//! parameter from 0 to 1, with a bound of their distance from their chord. Each knows by how much curves that are
//! smooth through the nodes may lie beside it: between elements r has kinks, of an angle j that goes to zero with the
//! mesh, and such curves lie beside it by up to [`BESIDE`] j h, h the node spacing.

use super::first_nodes;
use super::strains::{PlacedRod, element_length};
use crate::math::shape_functions::lagrange;
use crate::math::{Vec3, parallel};
use crate::scene::Model;
use crate::solve::State;

/// Turn of an arc, rad, at most, because two arcs that turn by less have one nearest pair of points.
const MAX_TURN: f64 = 0.3;
/// Arcs of a part between two nodes, at most.
const MAX_ARCS: f64 = 8.0;
/// Distance of an element from smooth curves through its nodes, over node spacing × kink: an eighth for chords, a
/// twelfth for cubics, whose error is 5.1e-4 r⁗H⁴ where kinks are 1.85e-2 r⁗H³; four times that, because meshes do not
/// converge evenly.
const BESIDE: f64 = 0.5;

/// A piece of the centreline of a rod: a cubic of the parameter t ∈ [0, 1], by its Taylor coefficients about `from`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub(super) rod: usize,
    /// Place along the rod.
    pub(super) index: usize,
    pub(super) from: Vec3,
    pub(super) c: [Vec3; 3],
    pub(super) radius: f64,
    /// Largest distance from the chord \[L\].
    pub(super) sagitta: f64,
    /// Reference arc length at t = 0, and of the whole \[L\].
    pub(super) arc: [f64; 2],
    /// By how much smooth curves may lie beside it \[L\].
    pub(super) beside: f64,
}

impl Arc {
    pub(super) fn point(&self, t: f64) -> Vec3 {
        self.from + (self.c[0] + (self.c[1] + self.c[2] * t) * t) * t
    }

    pub(super) fn slope(&self, t: f64) -> Vec3 {
        self.c[0] + (self.c[1] * 2.0 + self.c[2] * (3.0 * t)) * t
    }

    pub(super) fn bend(&self, t: f64) -> Vec3 {
        self.c[1] * 2.0 + self.c[2] * (6.0 * t)
    }

    pub(super) fn end(&self) -> Vec3 {
        self.point(1.0)
    }

    /// The part between two parameters.
    pub(super) fn part(&self, low: f64, high: f64) -> Self {
        let h = high - low;
        let c = [self.slope(low) * h, self.bend(low) * (0.5 * h * h), self.c[2] * (h * h * h)];
        let arc = [self.arc[0] + low * self.arc[1], h * self.arc[1]];
        let mut part = Self { from: self.point(low), c, arc, ..*self };
        // |r″|/8 bounds the distance from the chord
        part.sagitta = 0.125 * part.bend(0.0).norm().max(part.bend(1.0).norm());
        part
    }

    /// A ball about it: centre, radius.
    pub(super) fn ball(&self) -> (Vec3, f64) {
        let end = self.end();
        ((self.from + end) * 0.5, 0.5 * (end - self.from).norm() + self.sagitta)
    }
}

/// The arcs of one rod, in order, with the turning up to each.
pub(super) struct StrandArcs {
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) closed: bool,
    /// Reference length between nodes \[L\].
    pub(super) spacing: f64,
    /// Turning from the start to the start of each arc, and to the end, rad.
    pub(super) turning: Vec<f64>,
}

impl StrandArcs {
    /// Turning between two arcs, both included; on a closed rod the smaller of both ways.
    pub(super) fn between(&self, a: usize, b: usize) -> f64 {
        let (low, high) = (a.min(b), a.max(b));
        let inside = self.turning[high + 1] - self.turning[low];
        if !self.closed {
            return inside;
        }
        let outside = self.turning[self.count] - self.turning[high] + self.turning[low + 1];
        inside.min(outside)
    }
}

/// Arcs of all rods that take part in contact.
pub(super) struct Arcs {
    pub(super) all: Vec<Arc>,
    pub(super) strands: Vec<Option<StrandArcs>>,
}

impl Arcs {
    pub(super) fn of(model: &Model, state: &State) -> Self {
        let first = first_nodes(model);
        let (mut all, mut strands): (Vec<Arc>, _) = (Vec::new(), Vec::new());
        for (k, rod) in model.rods.iter().enumerate() {
            if rod.section.contact_radius <= 0.0 {
                strands.push(None);
                continue;
            }
            let start = all.len();
            let shape = PlacedRod::of(state, (k, rod), first[k]);
            let of_element = |element: usize| arcs_of(&shape, k, element);
            all.extend(parallel::map(rod.num_elements, parallel::CHEAP, &of_element).into_iter().flatten());
            let arcs = &mut all[start..];
            let count = arcs.len();
            let kink = |arcs: &[Arc], i: usize| {
                let next = if i + 1 < count { i + 1 } else { 0 };
                let ends = !rod.closed && i + 1 == count;
                if ends { 0.0 } else { arcs[i].slope(1.0).angle(&arcs[next].slope(0.0)) }
            };
            let mut turning = vec![0.0];
            for i in 0..count {
                let turned = arcs[i].slope(0.0).angle(&arcs[i].slope(1.0)) + kink(arcs, i);
                turning.push(turning[i] + turned);
            }
            let kinks: Vec<f64> = (0..count).map(|i| kink(arcs, i)).collect();
            for (i, arc) in arcs.iter_mut().enumerate() {
                let before = if i > 0 {
                    kinks[i - 1]
                } else if rod.closed {
                    kinks[count - 1]
                } else {
                    0.0
                };
                (arc.index, arc.beside) = (i, BESIDE * rod.spacing() * kinks[i].max(before));
            }
            // kinks are at the ends of elements only; all arcs of an element lie beside smooth curves
            let per_node: Vec<f64> = arcs.iter().map(|arc| arc.beside).collect();
            let length = element_length(rod);
            let mut at = 0;
            while at < count {
                let element = ((arcs[at].arc[0] + 0.5 * arcs[at].arc[1]) / length) as usize;
                let mut to = at;
                while to < count && ((arcs[to].arc[0] + 0.5 * arcs[to].arc[1]) / length) as usize == element {
                    to += 1;
                }
                let most = per_node[at..to].iter().copied().fold(0.0, f64::max);
                arcs[at..to].iter_mut().for_each(|arc| arc.beside = most);
                at = to;
            }
            let (closed, spacing) = (rod.closed, rod.spacing());
            strands.push(Some(StrandArcs { first: start, count, closed, spacing, turning }));
        }
        Self { all, strands }
    }

    /// Arcs of a rod between two arc lengths, which run over the seam where the second is the lower one, clipped to
    /// them, and so many node spacings beyond.
    pub(super) fn along(&self, rod: usize, [start, end]: [f64; 2], spacings: f64) -> Vec<Arc> {
        let Some(strand) = &self.strands[rod] else { return Vec::new() };
        let all = &self.all[strand.first..strand.first + strand.count];
        let length = all.last().map_or(0.0, |last| last.arc[0] + last.arc[1]);
        let pad = spacings * strand.spacing;
        let end = if end < start { end + length } else { end };
        let (low, high) = (start - pad, end + pad);
        let copies = if strand.closed { -1..=1 } else { 0..=0 };
        let shifted = copies.flat_map(|copy| all.iter().map(move |arc| (arc, arc.arc[0] + f64::from(copy) * length)));
        let clipped = shifted.filter_map(|(arc, from)| {
            let [t0, t1] = [low, high].map(|s| ((s - from) / arc.arc[1]).clamp(0.0, 1.0));
            (t1 > t0).then(|| arc.part(t0, t1))
        });
        clipped.collect()
    }

    /// Arc lengths of the ends of an open rod; none of a closed one.
    pub(super) fn tips(&self, rod: usize) -> [f64; 2] {
        let strand = self.strands[rod].as_ref().filter(|strand| !strand.closed);
        let last = strand.and_then(|strand| self.all.get(strand.first + strand.count - 1));
        last.map_or([f64::NAN; 2], |last| [0.0, last.arc[0] + last.arc[1]])
    }

    /// The arcs before and after one along its rod.
    pub(super) fn beyond(&self, arc: &Arc) -> [Option<&Arc>; 2] {
        let Some(strand) = &self.strands[arc.rod] else { return [None; 2] };
        let at = |index: usize| self.all.get(strand.first + index);
        let (last, wraps) = (strand.count - 1, strand.closed);
        let before = if arc.index > 0 {
            at(arc.index - 1)
        } else if wraps {
            at(last)
        } else {
            None
        };
        let after = if arc.index < last {
            at(arc.index + 1)
        } else if wraps {
            at(0)
        } else {
            None
        };
        [before, after]
    }
}

/// The arcs of an element.
fn arcs_of(shape: &PlacedRod, rod: usize, element: usize) -> Vec<Arc> {
    let (of, nodes) = (shape.rod, shape.nodes(element));
    let (order, length) = (of.order, element_length(of));
    let start = shape.positions[nodes.index[0]] + shape.remainders.get(nodes.index[0]).copied().unwrap_or_default();
    let at = |xi: f64| (0..=order).map(|a| nodes.r[a] * lagrange(order, xi).0[a]).sum::<Vec3>();
    let slope = |xi: f64| (0..=order).map(|a| nodes.r[a] * lagrange(order, xi).1[a]).sum::<Vec3>();
    // the polynomial by its values and slopes at both ends, exact up to order three
    let (p0, p1, d0, d1) = (at(0.0), at(1.0), slope(0.0), slope(1.0));
    let c = [d0, (p1 - p0) * 3.0 - d0 * 2.0 - d1, d0 + d1 - (p1 - p0) * 2.0];
    let arc = [element as f64 * length, length];
    let whole = Arc { rod, index: 0, from: start, c, radius: 0.0, sagitta: 0.0, arc, beside: 0.0 };
    let mut arcs = Vec::with_capacity(2 * order);
    for k in 0..order {
        let [low, high] = [k, k + 1].map(|n| n as f64 / order as f64);
        let turn = whole.slope(low).angle(&whole.slope(high));
        let count = (turn / MAX_TURN).ceil().clamp(1.0, MAX_ARCS);
        let radius = of.contact_radius_of(element * order + k);
        for i in 0..count as usize {
            let [t0, t1] = [i, i + 1].map(|i| low + (high - low) * (i as f64 / count));
            arcs.push(Arc { radius, ..whole.part(t0, t1) });
        }
    }
    arcs
}
