//! Sums of second derivatives in the tangent, on all threads.
//!
//! Terms (elements, candidates of contact) couple up to four nodes each. Where their blocks lie in the matrix is found
//! once for a pattern ([`Places`]). A batch of terms is computed first, then added: each thread owns a range of columns
//! and adds to it, in the order of the terms, the blocks that lie there. Each entry sums the same numbers in the same
//! order for any number of threads and any cuts.

use crate::math::parallel;
use crate::solve::problem::engine::Engine;
use crate::solve::problem::prescribed_motion::PrescribedMotion;
use crate::solve::problem::swivel::Bases;
use crate::sparse::Pattern;

use super::{Batches, Tangent};

/// Second derivatives with respect to the six unknowns of each of up to four nodes; blocks above the diagonal, those on
/// it in full.
pub(super) type Blocks = [[f64; 24]; 24];

/// Where the blocks of a term lie among the values of the pattern: a row of the upper triangle after the other.
type Starts = [u32; 10];

/// A block without equations: all its unknowns are supported.
const NOWHERE: u32 = u32::MAX;
/// Terms of a batch for each thread, because a piece of work is `parallel::DEAR` of them and four are shared out
/// evenly; their second derivatives fill a megabyte, which a cache holds.
const BATCH: usize = 4 * parallel::DEAR;

/// Places of the blocks of all terms in a pattern; empty: not known.
#[derive(Debug, Default)]
pub(crate) struct Places {
    elements: Vec<Starts>,
    /// Pairs of segments in the order of [`ContactSide::coupled`](crate::solve::problem::contact_side::ContactSide).
    pairs: Vec<Starts>,
}

impl Places {
    /// Fills what is missing. A new pattern needs new places.
    pub(super) fn complete(&mut self, engine: &Engine, pattern: &Pattern) {
        let find = |nodes: &[usize]| -> Starts {
            let mut starts = [NOWHERE; 10];
            for (start, [a, c]) in starts.iter_mut().zip(upper(nodes.len())) {
                *start = pattern.block_start(nodes[a], nodes[c]).map_or(NOWHERE, |start| start as u32);
            }
            starts
        };
        let elements = &engine.elements;
        if self.elements.len() != elements.len() {
            let of = |e: usize| find(engine.nodes_of(&elements[e]));
            self.elements = parallel::map(elements.len(), parallel::CHEAP, &of);
        }
        let side = &engine.contact;
        let coupled: Vec<[u32; 2]> = side.coupled().copied().collect();
        if self.pairs.len() != coupled.len() {
            self.pairs = parallel::map(coupled.len(), parallel::CHEAP, &|k| find(&side.ends_of(coupled[k])));
        }
    }
}

/// Index pairs of an upper triangle, row after row.
fn upper(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |a| (a..count).map(move |c| [a, c]))
}

/// Terms whose places are known.
#[derive(Clone, Copy)]
pub(super) enum TermKind {
    Element,
    Pair,
}

/// Number of terms in a batch. Sums do not depend on it.
pub(super) fn batch_size() -> usize {
    BATCH * parallel::num_threads()
}

/// A batch of computed terms of one kind.
pub(super) struct TermBatch<'a> {
    pub(super) kind: TermKind,
    /// Index of the first among all of its kind.
    pub(super) first: usize,
    pub(super) count: usize,
    /// Nodes of a term of the batch; `count` of them.
    pub(super) nodes: &'a (dyn Fn(usize) -> ([usize; 4], usize) + Sync),
    /// Second derivatives of a term of the batch; `None` where there are none.
    pub(super) blocks: &'a (dyn Fn(usize) -> Option<&'a Blocks> + Sync),
}

/// Where second derivatives are added up.
pub(in crate::solve) struct Sink<'a> {
    pub(super) pattern: &'a Pattern,
    pub(super) values: &'a mut [f64],
    /// K_fp · drive per unknown.
    drive: &'a mut [f64],
    places: &'a Places,
    pub(super) scratch: &'a mut Batches,
    bases: Bases,
    /// Prescribed increments, six per node, if supports move.
    prescribed: Option<Vec<f64>>,
}

impl<'a> Sink<'a> {
    pub(super) fn new(
        engine: &Engine,
        bases: Bases,
        drive: &PrescribedMotion,
        pattern: &'a Pattern,
        Tangent { values, drive: pushed, places, scratch }: &'a mut Tangent,
    ) -> Self {
        if values.capacity() < pattern.num_entries() {
            *values = Vec::new();
            values.reserve_exact(pattern.num_entries());
        }
        values.resize(pattern.num_entries(), 0.0);
        parallel::each_part(values, 64 * parallel::CHEAP, &|_, part| part.fill(0.0));
        pushed.clear();
        pushed.resize(6 * engine.num_nodes(), 0.0);
        places.complete(engine, pattern);
        Self { pattern, values, drive: pushed, places, scratch, bases, prescribed: engine.prescribed(drive) }
    }

    /// Adds the blocks of a term whose places are not known.
    pub(super) fn add(&mut self, nodes: &[usize], blocks: &Blocks) {
        for [a, c] in upper(nodes.len()) {
            if let Some(start) = self.pattern.block_start(nodes[a], nodes[c]) {
                let block = NodeBlock { nodes: [nodes[a], nodes[c]], at: [a, c], blocks };
                block.add(self.pattern, &self.bases, self.values, start);
            }
        }
        self.add_drive(nodes, blocks);
    }

    /// Adds the blocks of a batch of terms.
    pub(super) fn add_batch(&mut self, batch: &TermBatch) {
        let starts = match batch.kind {
            TermKind::Element => &self.places.elements,
            TermKind::Pair => &self.places.pairs,
        };
        let starts = &starts[batch.first..batch.first + batch.count];
        let (pattern, bases) = (self.pattern, &self.bases);
        let mut parts = cut(self.values, &cuts(starts));
        parallel::each(&mut parts, 1, &|_, (from, values)| {
            let here = *from..*from + values.len();
            for (k, starts) in starts.iter().enumerate() {
                if !starts.iter().any(|start| here.contains(&(*start as usize))) {
                    continue;
                }
                let Some(blocks) = (batch.blocks)(k) else { continue };
                let (nodes, count) = (batch.nodes)(k);
                for ([a, c], start) in upper(count).zip(starts).filter(|(_, start)| here.contains(&(**start as usize)))
                {
                    let block = NodeBlock { nodes: [nodes[a], nodes[c]], at: [a, c], blocks };
                    block.add(pattern, bases, values, *start as usize - *from);
                }
            }
        });
        let pushed = if self.prescribed.is_some() { batch.count } else { 0 };
        for k in 0..pushed {
            let (nodes, count) = (batch.nodes)(k);
            if let Some(blocks) = (batch.blocks)(k) {
                self.add_drive(&nodes[..count], blocks);
            }
        }
    }

    fn add_drive(&mut self, nodes: &[usize], blocks: &Blocks) {
        let Some(all) = &self.prescribed else { return };
        for [a, c] in upper(nodes.len()) {
            let (p, q) = (nodes[a], nodes[c]);
            for i in 0..6 {
                for j in 0..6 {
                    let entry = blocks[6 * a + i][6 * c + j];
                    self.drive[6 * p + i] += entry * all[6 * q + j];
                    if a != c {
                        self.drive[6 * q + j] += entry * all[6 * p + i];
                    }
                }
            }
        }
    }
}

/// A block of a term, and its place there.
struct NodeBlock<'a> {
    nodes: [usize; 2],
    at: [usize; 2],
    blocks: &'a Blocks,
}

impl NodeBlock<'_> {
    fn add(&self, pattern: &Pattern, bases: &Bases, values: &mut [f64], start: usize) {
        let [a, c] = self.at;
        let entry = |i: usize, j: usize| self.blocks[6 * a + i][6 * c + j];
        match bases.resolved_block(self.nodes, entry) {
            None => self.add_entries(pattern, values, start, entry),
            Some(block) => self.add_entries(pattern, values, start, |i, j| block[i][j]),
        }
    }

    #[inline]
    fn add_entries(&self, pattern: &Pattern, values: &mut [f64], start: usize, entry: impl Fn(usize, usize) -> f64) {
        let [p, q] = self.nodes;
        pattern.add_at(values, start, [p, q], &entry);
        if p == q && self.at[0] != self.at[1] {
            // a node that is at two places of its term: the transpose lies in the same block
            pattern.add_at(values, start, [p, q], |i, j| entry(j, i));
        }
    }
}

/// Where the values are cut so that each thread has as many of these terms as another: at first columns of nodes.
fn cuts(starts: &[Starts]) -> Vec<usize> {
    let count = parallel::num_threads().min(starts.len() / BATCH);
    if count < 2 {
        return Vec::new();
    }
    // the block of a term's first node with itself begins the columns of that node
    let mut firsts: Vec<u32> = starts.iter().map(|starts| starts[0]).filter(|start| *start != NOWHERE).collect();
    firsts.sort_unstable();
    let mut cuts: Vec<usize> =
        (1..count).filter_map(|k| firsts.get(k * firsts.len() / count)).map(|start| *start as usize).collect();
    cuts.dedup();
    cuts
}

/// The parts between cuts, each with the index of its first value.
fn cut<'a>(mut values: &'a mut [f64], cuts: &[usize]) -> Vec<(usize, &'a mut [f64])> {
    let (mut parts, mut from) = (Vec::with_capacity(cuts.len() + 1), 0);
    for &at in cuts {
        let (part, rest) = values.split_at_mut(at - from);
        parts.push((from, part));
        (values, from) = (rest, at);
    }
    parts.push((from, values));
    parts
}
