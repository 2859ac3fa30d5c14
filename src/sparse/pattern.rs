//! Sparsity pattern of the tangent: lower triangle, compressed columns, grouped by nodes.
//!
//! A node has up to six unknowns (three positions, three rotations). Supported and out-of-plane ones are eliminated
//! here; the factorisation does not see them. Joined nodes are one block: the first of them has all their unknowns.
//! Equations are numbered in the order of elimination ([`NodeGraph::ordered`]), so that the factorisation takes the
//! matrix as it is assembled.

use std::ops::Range;

/// Marks an eliminated unknown.
const NONE: u16 = u16::MAX;
/// Unknowns of a node that no support holds.
const ALL: [u16; 6] = [0, 1, 2, 3, 4, 5];

/// Lower triangle pattern over node blocks.
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    /// Nodes in the order of elimination.
    order: Vec<u32>,
    /// Position of each node in `order`.
    place: Vec<u32>,
    /// First equation of each node.
    first: Vec<u32>,
    unknowns: Unknowns,
    /// First entry of each column, and their number.
    col_ptr: Vec<u32>,
    /// Place of the node that has an equation.
    place_of: Vec<u32>,
    /// Per place: range in `rows`.
    row_ptr: Vec<u32>,
    /// Per place: rows of the first column of its block, ascending. Each further column has one row less.
    rows: Vec<u32>,
    /// Per place: range in `neighbours`.
    neighbour_ptr: Vec<u32>,
    /// (place of a node at or after this one, row offset of its block inside the first column of this one), ascending.
    neighbours: Vec<(u32, u32)>,
}

/// Which unknowns nodes have.
#[derive(Debug, Clone, Default)]
struct Unknowns {
    /// Per node: local unknown → position among the free unknowns of its block, or `NONE`.
    local: Vec<[u16; 6]>,
    /// Per node: bits of the unknowns that are its own.
    own: Vec<u8>,
    /// The node that has the block of a node: itself unless joined.
    master: Vec<u32>,
    /// Number of unknowns of the block of each node; 0 of those that have none.
    count: Vec<u32>,
}

impl Unknowns {
    fn new(free: &[[bool; 6]], owner: &[[usize; 6]]) -> Self {
        let num_nodes = free.len();
        let master: Vec<u32> = owner.iter().map(|owner| owner[0] as u32).collect();
        let (mut local, mut count) = (vec![[NONE; 6]; num_nodes], vec![0; num_nodes]);
        let mut own = vec![0; num_nodes];
        for node in 0..num_nodes {
            for k in (0..6).filter(|&k| owner[node][k] == node) {
                own[node] |= 1 << k;
                if free[node][k] {
                    let next: &mut u32 = &mut count[master[node] as usize];
                    local[node][k] = *next as u16;
                    *next += 1;
                }
            }
        }
        for node in 0..num_nodes {
            local[node] = std::array::from_fn(|k| local[owner[node][k]][k]);
        }
        Self { local, own, master, count }
    }
}

/// Nodes, their free unknowns and the pairs of nodes that are coupled: a pattern whose nodes have no order yet.
#[derive(Debug, Clone)]
pub struct NodeGraph {
    unknowns: Unknowns,
    /// Pairs of nodes, the lower first, each node with itself among them, ascending.
    pairs: Vec<(u32, u32)>,
}

impl NodeGraph {
    /// Nodes with the given free unknowns, coupled in the given pairs (any order, duplicates allowed; the diagonal is
    /// always present). Nodes may share unknowns of others: `owner[b][k]` is `b` itself or the node whose k-th unknown
    /// is that of b, too. Only the owner's `free` counts. All positions of a node have one owner, whose block holds all
    /// unknowns of the nodes that share them; it is the first of these.
    pub fn new(free: &[[bool; 6]], owner: &[[usize; 6]], pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let unknowns = Unknowns::new(free, owner);
        let master = &unknowns.master;
        let mut pairs: Vec<(u32, u32)> =
            pairs.map(|(a, b)| (master[a], master[b])).map(|(a, b)| (a.min(b), a.max(b))).collect();
        pairs.extend((0..free.len() as u32).map(|a| (a, a)));
        pairs.sort_unstable();
        pairs.dedup();
        Self { unknowns, pairs }
    }

    /// Pairs of coupled nodes, the lower first, each node with itself among them, ascending.
    pub(super) fn pairs(&self) -> &[(u32, u32)] {
        &self.pairs
    }

    /// Number of unknowns of the block of a node.
    pub(super) fn num_free(&self, node: u32) -> u32 {
        self.unknowns.count[node as usize]
    }

    /// Number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.unknowns.count.len()
    }

    /// First equation of each node, numbered in the nodes' own order, and their number in all.
    fn first_equations(&self) -> Vec<u32> {
        let mut firsts = vec![0];
        for count in &self.unknowns.count {
            firsts.push(firsts[firsts.len() - 1] + count);
        }
        firsts
    }

    /// The matrix with its nodes in their own order, upper triangle: column pointers and row indices, ascending within
    /// a column.
    pub fn upper(&self) -> (Vec<u32>, Vec<u32>) {
        let first = self.first_equations();
        let mut columns: Vec<(u32, u32)> = self.pairs.iter().map(|&(row, column)| (column, row)).collect();
        columns.sort_unstable();
        let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
        for blocks in columns.chunk_by(|a, b| a.0 == b.0) {
            let node = blocks[0].0 as usize;
            for equation in first[node]..first[node + 1] {
                let rows = |&(_, row): &(u32, u32)| first[row as usize]..first[row as usize + 1].min(equation + 1);
                row_idx.extend(blocks.iter().flat_map(rows));
                col_ptr.push(row_idx.len() as u32);
            }
        }
        (col_ptr, row_idx)
    }

    /// Nodes in the order of the first of their equations in a list of all.
    pub fn nodes_of(&self, equations: &[u32]) -> Vec<u32> {
        let first = self.first_equations();
        let mut when = vec![u32::MAX; equations.len()];
        equations.iter().zip(0u32..).for_each(|(&equation, at)| when[equation as usize] = at);
        let mut order: Vec<u32> = (0..self.num_nodes() as u32).collect();
        // nodes without equations go last
        order.sort_by_key(|&node| {
            let own = first[node as usize] as usize..first[node as usize + 1] as usize;
            when[own].iter().copied().min().unwrap_or(u32::MAX)
        });
        order
    }

    /// The pattern with its nodes in their own order.
    #[cfg(test)]
    pub fn natural(self) -> Pattern {
        let order = (0..self.num_nodes() as u32).collect();
        self.ordered(order)
    }

    /// The pattern with its nodes in an order of elimination.
    pub fn ordered(self, order: Vec<u32>) -> Pattern {
        let Self { unknowns, mut pairs } = self;
        let num_nodes = order.len();
        let mut pattern =
            Pattern { place: vec![0; num_nodes], first: vec![0; num_nodes], unknowns, ..Pattern::default() };
        let mut count = 0;
        for (&node, at) in order.iter().zip(0u32..) {
            pattern.place[node as usize] = at;
            pattern.first[node as usize] = count;
            count += pattern.num_free(node);
        }
        for pair in &mut pairs {
            let (a, b) = (pattern.place[pair.0 as usize], pattern.place[pair.1 as usize]);
            *pair = (a.min(b), a.max(b));
        }
        pairs.sort_unstable();
        pattern.order = order;
        pattern.fill(&pairs);
        pattern
    }
}

impl Pattern {
    /// Pattern of nodes with the given free unknowns in their own order, coupled in the given node pairs.
    #[cfg(test)]
    pub fn new(free: &[[bool; 6]], pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let owner: Vec<[usize; 6]> = (0..free.len()).map(|node| [node; 6]).collect();
        NodeGraph::new(free, &owner, pairs).natural()
    }

    fn fill(&mut self, blocks: &[(u32, u32)]) {
        self.col_ptr.push(0);
        self.row_ptr.push(0);
        self.neighbour_ptr.push(0);
        let (mut blocks, mut num_entries) = (blocks, 0);
        for (&node, at) in self.order.iter().zip(0u32..) {
            let (here, rest) = blocks.split_at(blocks.partition_point(|block| block.0 == at));
            blocks = rest;
            let mut offset = 0;
            for &(_, other) in here {
                self.neighbours.push((other, offset));
                offset += self.num_free(self.order[other as usize]);
            }
            self.neighbour_ptr.push(self.neighbours.len() as u32);
            let width = self.num_free(node);
            for &(_, other) in here.iter().filter(|_| width > 0) {
                let other = self.order[other as usize];
                let base = self.first[other as usize];
                self.rows.extend(base..base + self.num_free(other));
            }
            self.row_ptr.push(self.rows.len() as u32);
            for column in 0..width {
                num_entries += offset - column;
                self.col_ptr.push(num_entries);
                self.place_of.push(at);
            }
        }
        [&mut self.rows, &mut self.col_ptr, &mut self.place_of].into_iter().for_each(Vec::shrink_to_fit);
        self.neighbours.shrink_to_fit();
    }

    /// Number of equations.
    pub fn num_equations(&self) -> usize {
        self.col_ptr.len().saturating_sub(1)
    }

    /// Number of stored entries.
    pub fn num_entries(&self) -> usize {
        self.col_ptr.last().map_or(0, |&last| last as usize)
    }

    /// Rows of a column of the lower triangle, ascending; the first is the diagonal.
    #[inline]
    pub fn rows(&self, column: usize) -> &[u32] {
        let place = self.place_of[column] as usize;
        let above = column - self.first[self.order[place] as usize] as usize;
        &self.rows[self.row_ptr[place] as usize + above..self.row_ptr[place + 1] as usize]
    }

    /// Entries of a column.
    #[inline]
    pub fn entries(&self, column: usize) -> Range<usize> {
        self.col_ptr[column] as usize..self.col_ptr[column + 1] as usize
    }

    /// First entry of each column, and the number of all.
    pub fn col_ptr(&self) -> &[u32] {
        &self.col_ptr
    }

    /// Rows of all entries, one column after the other.
    pub fn row_idx(&self) -> Vec<u32> {
        let mut row_idx = Vec::with_capacity(self.num_entries());
        (0..self.num_equations()).for_each(|column| row_idx.extend_from_slice(self.rows(column)));
        row_idx
    }

    /// The upper triangle: column pointers and row indices, ascending within a column.
    pub fn upper(&self) -> (Vec<u32>, Vec<u32>) {
        let (mut col_ptr, columns) = (vec![0u32; self.col_ptr.len()], 0..self.num_equations());
        columns.clone().for_each(|column| self.rows(column).iter().for_each(|&row| col_ptr[row as usize + 1] += 1));
        (1..col_ptr.len()).for_each(|k| col_ptr[k] += col_ptr[k - 1]);
        let mut next = col_ptr.clone();
        let mut row_idx = vec![0u32; self.num_entries()];
        for column in columns {
            for &row in self.rows(column) {
                let slot = &mut next[row as usize];
                row_idx[*slot as usize] = column as u32;
                *slot += 1;
            }
        }
        (col_ptr, row_idx)
    }

    /// Equation of unknown `k` (0..3 position, 3..6 rotation) of a node, `None` if eliminated.
    #[inline]
    pub fn equation(&self, node: usize, k: usize) -> Option<usize> {
        match self.unknowns.local[node][k] {
            NONE => None,
            position => Some(self.first[self.master(node)] as usize + position as usize),
        }
    }

    /// [`Pattern::equation`], `None` also of an unknown that is another node's.
    pub fn own_equation(&self, node: usize, k: usize) -> Option<usize> {
        if self.unknowns.own[node] & (1 << k) != 0 { self.equation(node, k) } else { None }
    }

    fn num_free(&self, node: u32) -> u32 {
        self.unknowns.count[node as usize]
    }

    fn master(&self, node: usize) -> usize {
        self.unknowns.master[node] as usize
    }

    /// Adds the 6×6 block with rows of node `a` and columns of node `b` (and by symmetry its transpose).
    ///
    /// For `a == b` the block is a contribution to the symmetric diagonal block: its upper part is used.
    /// Pairs not in the pattern are a programming error.
    pub fn add_block(&self, values: &mut [f64], a: usize, b: usize, entry: impl Fn(usize, usize) -> f64) {
        if let Some(start) = self.block_start(a, b) {
            self.add_at(values, start, [a, b], entry);
        }
    }

    /// Index of the block of two nodes among the values: of the first row of its block in the first column. `None` if
    /// either has no unknowns. Pairs not in the pattern are a programming error.
    pub fn block_start(&self, a: usize, b: usize) -> Option<usize> {
        let (a, b) = (self.master(a), self.master(b));
        let (first, last) = if self.place[a] > self.place[b] { (b, a) } else { (a, b) };
        if self.num_free(first as u32) == 0 || self.num_free(last as u32) == 0 {
            return None;
        }
        let at = self.place[first] as usize;
        let list = &self.neighbours[self.neighbour_ptr[at] as usize..self.neighbour_ptr[at + 1] as usize];
        let found = list.binary_search_by_key(&self.place[last], |n| n.0);
        assert!(found.is_ok(), "node pair ({a}, {b}) is not in the sparsity pattern");
        let offset = found.map_or(0, |k| list[k].1);
        Some((self.col_ptr[self.first[first] as usize] + offset) as usize)
    }

    /// [`Pattern::add_block`] of two nodes whose block starts at an index of `values`, which may be a part of all that
    /// holds the first node's columns as a whole.
    #[inline]
    pub fn add_at(&self, values: &mut [f64], start: usize, [a, b]: [usize; 2], entry: impl Fn(usize, usize) -> f64) {
        let [p, q] = [a, b].map(|node| self.place[self.master(node)]);
        if p == q {
            self.add_within(values, start, [a, b], entry);
        } else if p > q {
            self.add_ordered(values, start, [b, a], |i, j| entry(j, i));
        } else {
            self.add_ordered(values, start, [a, b], entry);
        }
    }

    /// Number of rows in the first column of a node's block.
    fn length(&self, node: usize) -> usize {
        let first = self.first[self.master(node)] as usize;
        (self.col_ptr[first + 1] - self.col_ptr[first]) as usize
    }

    /// [`Pattern::add_at`] within a diagonal block: of one node the upper part, of two joined ones their coupling and
    /// its transpose.
    fn add_within(&self, values: &mut [f64], start: usize, [a, b]: [usize; 2], entry: impl Fn(usize, usize) -> f64) {
        let length = self.length(a);
        let [rows, columns] = [a, b].map(|node| self.unknowns.local[node].map(usize::from));
        let none = usize::from(NONE);
        for (i, &row) in rows.iter().enumerate().filter(|(_, row)| **row != none) {
            for (j, &column) in columns.iter().enumerate().filter(|(_, column)| **column != none) {
                let (low, high) = (row.min(column), row.max(column));
                let at = start + low * length - low * (low + 1) / 2 + high;
                if a != b && low == high {
                    values[at] += 2.0 * entry(i, j);
                } else if a != b || i <= j {
                    values[at] += entry(i, j);
                }
            }
        }
    }

    /// [`Pattern::add_at`] for `a` before `b`: goes to rows of b in columns of a.
    #[inline]
    fn add_ordered(&self, values: &mut [f64], start: usize, [a, b]: [usize; 2], entry: impl Fn(usize, usize) -> f64) {
        let (length, [of_a, of_b]) = (self.length(a), [a, b].map(|node| &self.unknowns.local[node]));
        if *of_a == ALL && *of_b == ALL {
            let mut at = start;
            for i in 0..6 {
                values[at..at + 6].iter_mut().zip(0..).for_each(|(value, j)| *value += entry(i, j));
                at += length - i - 1;
            }
            return;
        }
        for (i, &column) in of_a.iter().enumerate().filter(|(_, column)| **column != NONE) {
            // each column is shorter by one, because entries above the diagonal are not stored
            let column = usize::from(column);
            let at = start + column * length - column * (column + 1) / 2;
            for (j, &row) in of_b.iter().enumerate().filter(|(_, row)| **row != NONE) {
                values[at + usize::from(row)] += entry(i, j);
            }
        }
    }

    /// y = A x for the symmetric matrix with the given values.
    pub fn multiply(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (place, &node) in self.order.iter().enumerate() {
            let (first, width) = (self.first[node as usize] as usize, self.num_free(node) as usize);
            let rows = &self.rows[self.row_ptr[place] as usize..self.row_ptr[place + 1] as usize];
            let mut column = 0;
            while column < width {
                let rows = &rows[column..];
                let values = &values[self.col_ptr[first + column] as usize..];
                // nodes in space, in the plane, others
                column += match width - column {
                    6.. => multiply_columns::<6>(rows, values, x, &mut y),
                    3.. => multiply_columns::<3>(rows, values, x, &mut y),
                    _ => multiply_columns::<1>(rows, values, x, &mut y),
                };
            }
        }
        y
    }

    /// Index of the diagonal entry of an equation in the value array.
    pub fn diagonal(&self, equation: usize) -> usize {
        self.col_ptr[equation] as usize
    }
}

/// Adds the products of the first `W` columns of a node's block, and of their transpose, to y; `W`. Sums that do not
/// wait for each other run at once: those of the columns.
fn multiply_columns<const W: usize>(rows: &[u32], values: &[f64], x: &[f64], y: &mut [f64]) -> usize {
    let mut columns: [&[f64]; W] = [&[]; W];
    let mut rest = values;
    for (k, column) in columns.iter_mut().enumerate() {
        (*column, rest) = rest.split_at(rows.len() - k);
    }
    let first = rows[0] as usize;
    let own: [f64; W] = std::array::from_fn(|k| x[first + k]);
    let mut sums = [0.0; W];
    for k in 0..W {
        sums[k] = y[first + k] + columns[k][0] * own[k];
        for (row, value) in (k + 1..W).zip(&columns[k][1..]) {
            y[first + row] += value * own[k];
            sums[k] += value * own[row];
        }
    }
    let below = &rows[W..];
    let columns: [&[f64]; W] = std::array::from_fn(|k| &columns[k][W - k..][..below.len()]);
    for (at, &row) in below.iter().enumerate() {
        let (given, mut sum) = (x[row as usize], y[row as usize]);
        for k in 0..W {
            sum += columns[k][at] * own[k];
            sums[k] += columns[k][at] * given;
        }
        y[row as usize] = sum;
    }
    y[first..first + W].copy_from_slice(&sums);
    W
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes 1, 3 and 5 of a chain 0 1 2, 3 4, 5 are joined: the reduced matrix is Tᵀ A T of the full one, T the
    /// joining map. Node 3 is rigid to 1, or pinned to it, or shares all but its last rotation; node 5 is rigid to 3.
    #[test]
    fn joined_nodes_share_their_equations() {
        let mut free = [[true; 6]; 6];
        free[2] = [true, true, false, false, false, true];
        let pairs = [(0, 1), (1, 2), (3, 4), (1, 3), (3, 2), (5, 4), (5, 1), (5, 3)];
        let full = Pattern::new(&free, pairs.into_iter());
        for (third, count) in [([1; 3], 21), ([3; 3], 24), ([1, 1, 3], 22)] {
            let mut owner: [[usize; 6]; 6] = std::array::from_fn(|node| [node; 6]);
            for node in [3, 5] {
                owner[node] = [1, 1, 1, third[0], third[1], third[2]];
            }
            let joined = NodeGraph::new(&free, &owner, pairs.into_iter()).natural();
            assert_eq!((full.num_equations(), joined.num_equations()), (33, count));
            let (mut a, mut b) = (vec![0.0; full.num_entries()], vec![0.0; joined.num_entries()]);
            for (n, (p, q)) in pairs.into_iter().enumerate() {
                let off = |i: usize, j: usize| (1 + n * 36 + 6 * i + j) as f64;
                let on = |i: usize, j: usize| (3 + n + i * j + (i + j) * (i + j)) as f64;
                for (pattern, values) in [(&full, &mut a), (&joined, &mut b)] {
                    pattern.add_block(values, p, q, off);
                    pattern.add_block(values, p, p, on);
                    pattern.add_block(values, q, q, on);
                }
            }
            let x: Vec<f64> = (0..count).map(|i| (1.0 + i as f64).sin()).collect();
            let (mut expanded, mut reduced) = (vec![0.0; 33], vec![0.0; count]);
            let both = || (0..36).filter_map(|i| Some((full.equation(i / 6, i % 6)?, joined.equation(i / 6, i % 6)?)));
            both().for_each(|(of_full, of_joined)| expanded[of_full] = x[of_joined]);
            let y = full.multiply(&a, &expanded);
            both().for_each(|(of_full, of_joined)| reduced[of_joined] += y[of_full]);
            for (ours, exact) in joined.multiply(&b, &x).iter().zip(&reduced) {
                assert!((ours - exact).abs() < 1e-12 * exact.abs().max(1.0), "{ours} {exact}");
            }
            let owned = (0..36).filter_map(|i| joined.own_equation(i / 6, i % 6)).collect::<Vec<_>>();
            assert_eq!(owned.len(), count);
        }
    }

    #[test]
    fn blocks_land_where_a_dense_matrix_has_them() {
        let free = [[true; 6], [true, true, false, false, false, true], [true; 6]];
        let pattern = Pattern::new(&free, [(0, 1), (2, 0), (1, 0)].into_iter());
        assert_eq!(pattern.num_equations(), 15);
        let mut values = vec![0.0; pattern.num_entries()];
        pattern.add_block(&mut values, 2, 0, |i, j| (10 * i + j) as f64);
        pattern.add_block(&mut values, 1, 1, |i, j| if i == j { 1.0 } else { 0.5 });
        let mut x = vec![0.0; 15];
        x[pattern.equation(0, 4).unwrap()] = 1.0;
        let y = pattern.multiply(&values, &x);
        for i in 0..6 {
            assert_eq!(y[pattern.equation(2, i).unwrap()], (10 * i + 4) as f64);
        }
        assert_eq!(pattern.equation(1, 3), None);
        let mut x = vec![0.0; 15];
        x[pattern.equation(1, 5).unwrap()] = 2.0;
        let y = pattern.multiply(&values, &x);
        assert_eq!(y[pattern.equation(1, 0).unwrap()], 1.0);
        assert_eq!(y[pattern.equation(1, 5).unwrap()], 2.0);
    }

    /// The same blocks in another order of nodes make the same matrix, its upper triangle the transpose of the lower
    /// one.
    #[test]
    fn order_changes_nothing_but_numbers() {
        let mut free = [[true; 6]; 5];
        (free[1], free[3]) = ([true, true, false, false, false, true], [false; 6]);
        let pairs = [(0, 1), (1, 2), (3, 4), (1, 4), (4, 2), (0, 4)];
        let graph = NodeGraph::new(&free, &std::array::from_fn::<_, 5, _>(|node| [node; 6]), pairs.into_iter());
        let natural = graph.clone().natural();
        let other = graph.ordered(vec![4, 1, 3, 0, 2]);
        assert_eq!((natural.num_equations(), natural.num_entries()), (other.num_equations(), other.num_entries()));
        let [a, b] = [&natural, &other].map(|pattern| {
            let mut values = vec![0.0; pattern.num_entries()];
            for (n, (p, q)) in pairs.into_iter().enumerate() {
                pattern.add_block(&mut values, p, q, |i, j| (1 + n * 36 + 6 * i + j) as f64);
                pattern.add_block(&mut values, q, q, |i, j| (3 + n + i * j) as f64);
            }
            let mut x = vec![0.0; pattern.num_equations()];
            let all = || (0..5).flat_map(|node| (0..6).map(move |k| (node, k)));
            for (at, equation) in all().filter_map(|(node, k)| pattern.equation(node, k)).enumerate() {
                x[equation] = (1.0 + at as f64).sin();
            }
            let y = pattern.multiply(&values, &x);
            all().filter_map(|(node, k)| pattern.equation(node, k)).map(|equation| y[equation]).collect::<Vec<_>>()
        });
        assert!(a.iter().zip(&b).all(|(x, y)| (x - y).abs() < 1e-9), "{a:?} {b:?}");
        let (col_ptr, row_idx) = other.upper();
        let dense = |ptr: &[u32], rows: &[u32]| -> Vec<(u32, u32)> {
            let columns = (0..other.num_equations()).flat_map(|c| ptr[c] as usize..ptr[c + 1] as usize);
            let column_of = |entry: usize| ptr.partition_point(|&first| first as usize <= entry) as u32 - 1;
            columns.map(|entry| (rows[entry], column_of(entry))).collect()
        };
        let lower = dense(other.col_ptr(), &other.row_idx());
        let mut upper: Vec<(u32, u32)> = dense(&col_ptr, &row_idx).into_iter().map(|(r, c)| (c, r)).collect();
        assert!(lower.iter().all(|(row, column)| row >= column));
        upper.sort_by_key(|&(row, column)| (column, row));
        assert_eq!(lower, upper);
    }
}
