//! Sparsity pattern of the tangent: lower triangle, compressed columns, grouped by nodes, in the order of elimination.
//!
//! A node has up to six unknowns (three positions, three rotations); supported and out-of-plane ones are eliminated
//! here, once, so that nothing further down knows of them. Equations are numbered in an order of the nodes that keeps the factor
//! sparse: what is assembled goes to the place where it is factorised, and who works with nodes sees nothing of it.

use crate::error::SolveError;
use crate::sparse::factor::elimination_order;

/// Marks an eliminated unknown.
const NONE: u8 = u8::MAX;

/// Lower triangle pattern over node blocks.
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    /// First equation of each node.
    first: Vec<u32>,
    /// Number of equations of each node.
    num_free: Vec<u8>,
    /// Per node: local unknown → position among its free unknowns, or `NONE`.
    local: Vec<[u8; 6]>,
    /// The node whose unknowns a node shares; itself unless joined.
    master: Vec<u32>,
    /// Nodes in the order of their equations.
    order: Vec<u32>,
    /// Place of each node in that order.
    rank: Vec<u32>,
    col_ptr: Vec<u32>,
    /// Per place in the order: range in `neighbours`.
    neighbour_ptr: Vec<u32>,
    /// Per column of nodes, the diagonal first: place of the row's node, ascending, and row offset of its block inside the columns.
    neighbours: Vec<(u32, u32)>,
}

impl Pattern {
    /// Pattern of nodes with the given free unknowns, coupled in the given node pairs (any order, duplicates allowed;
    /// the diagonal is always present).
    ///
    /// # Errors
    /// `SolveError::Symbolic` when memory or the 32-bit index range does not suffice.
    pub fn new(free: &[[bool; 6]], pairs: impl Iterator<Item = (usize, usize)>) -> Result<Self, SolveError> {
        let master: Vec<usize> = (0..free.len()).collect();
        Self::joined(free, &master, pairs)
    }

    /// As [`Pattern::new`] with nodes that share the unknowns of another: `master[b]` is `b` itself or the node that b is joined to. Of
    /// joined nodes only the master's `free` counts; equations and blocks of the others are the master's.
    ///
    /// # Errors
    /// As there.
    pub fn joined(
        free: &[[bool; 6]],
        master: &[usize],
        pairs: impl Iterator<Item = (usize, usize)>,
    ) -> Result<Self, SolveError> {
        let num_nodes = free.len();
        let mut blocks: Vec<[u32; 2]> = pairs
            .map(|(a, b)| (master[a] as u32, master[b] as u32))
            .filter(|(a, b)| a != b)
            .map(|(a, b)| [a.min(b), a.max(b)])
            .collect();
        sort(&mut blocks);
        let (order, rank) = elimination_order(num_nodes, &blocks)?;
        let (mut local, mut num_free) = (vec![[NONE; 6]; num_nodes], vec![0u8; num_nodes]);
        for node in (0..num_nodes).filter(|&node| master[node] == node) {
            for k in (0..6).filter(|&k| free[node][k]) {
                local[node][k] = num_free[node];
                num_free[node] += 1;
            }
        }
        let mut first = vec![0; num_nodes];
        let mut count = 0u32;
        for &node in &order {
            first[node as usize] = count;
            count += u32::from(num_free[node as usize]);
        }
        for [a, b] in &mut blocks {
            let (p, q) = (rank[*a as usize], rank[*b as usize]);
            (*a, *b) = (p.min(q), p.max(q));
        }
        sort(&mut blocks);
        let master = master.iter().map(|&m| m as u32).collect();
        let mut pattern = Self { first, num_free, local, master, order, rank, ..Self::default() };
        pattern.fill(&blocks);
        Ok(pattern)
    }

    /// Columns from their blocks (places of column and row), sorted, diagonals left out.
    fn fill(&mut self, blocks: &[[u32; 2]]) {
        self.col_ptr.push(0);
        self.neighbour_ptr.push(0);
        let (mut rest, mut entries) = (blocks, 0);
        for column in 0..self.order.len() as u32 {
            let (own, after) = rest.split_at(rest.partition_point(|block| block[0] == column));
            rest = after;
            let mut offset = 0;
            for row in std::iter::once(column).chain(own.iter().map(|block| block[1])) {
                self.neighbours.push((row, offset));
                offset += u32::from(self.num_free[self.order[row as usize] as usize]);
            }
            self.neighbour_ptr.push(self.neighbours.len() as u32);
            // below the diagonal only
            for k in 0..u32::from(self.num_free[self.order[column as usize] as usize]) {
                entries += offset - k;
                self.col_ptr.push(entries);
            }
        }
    }

    /// Number of equations.
    pub fn num_equations(&self) -> usize {
        self.col_ptr.len() - 1
    }

    /// Number of stored entries.
    pub fn num_entries(&self) -> usize {
        self.col_ptr.last().map_or(0, |&n| n as usize)
    }

    /// Column pointers (lower triangle).
    pub fn col_ptr(&self) -> &[u32] {
        &self.col_ptr
    }

    /// Row indices (lower triangle), ascending within a column.
    pub fn row_idx(&self) -> Vec<u32> {
        let mut rows = Vec::with_capacity(self.num_entries());
        for column in 0..self.order.len() {
            for k in 0..self.num_free_at(column) {
                for &(row, _) in self.blocks_of(column) {
                    let (first, count) = (self.first_at(row as usize), self.num_free_at(row as usize));
                    let from = if row as usize == column { k } else { 0 };
                    rows.extend((from..count).map(|i| (first + i) as u32));
                }
            }
        }
        rows
    }

    /// Equation of unknown `k` (0..3 position, 3..6 rotation) of a node, `None` if eliminated.
    #[inline]
    pub fn equation(&self, node: usize, k: usize) -> Option<usize> {
        let node = self.master[node] as usize;
        match self.local[node][k] {
            NONE => None,
            position => Some(self.first[node] as usize + position as usize),
        }
    }

    fn num_free_at(&self, place: usize) -> usize {
        usize::from(self.num_free[self.order[place] as usize])
    }

    fn first_at(&self, place: usize) -> usize {
        self.first[self.order[place] as usize] as usize
    }

    fn blocks_of(&self, place: usize) -> &[(u32, u32)] {
        &self.neighbours[self.neighbour_ptr[place] as usize..self.neighbour_ptr[place + 1] as usize]
    }

    /// Adds the 6×6 block with rows of node `a` and columns of node `b` (and by symmetry its transpose).
    ///
    /// For `a == b` the block is a contribution to the symmetric diagonal block: its upper part is used.
    /// Pairs not in the pattern are a programming error.
    #[inline]
    pub fn add_block(&self, values: &mut [f64], a: usize, b: usize, entry: impl Fn(usize, usize) -> f64) {
        let joined = a != b && self.master[a] == self.master[b];
        let (a, b) = (self.master[a] as usize, self.master[b] as usize);
        if joined {
            // a coupling of two nodes that move as one acts on both sides of the diagonal
            self.add_diagonal(values, a, |i, j| entry(i, j) + entry(j, i));
        } else if a == b {
            self.add_diagonal(values, a, entry);
        } else if self.rank[a] > self.rank[b] {
            self.add_below(values, a, b, entry);
        } else {
            self.add_below(values, b, a, |i, j| entry(j, i));
        }
    }

    /// A symmetric block by its upper part.
    fn add_diagonal(&self, values: &mut [f64], node: usize, entry: impl Fn(usize, usize) -> f64) {
        let (local, first) = (&self.local[node], self.first[node] as usize);
        for j in 0..6 {
            if local[j] == NONE {
                continue;
            }
            let start = self.col_ptr[first + usize::from(local[j])] as usize;
            for i in j..6 {
                if local[i] != NONE {
                    values[start + usize::from(local[i] - local[j])] += entry(j, i);
                }
            }
        }
    }

    /// The block of rows of `a` and columns of `b`, which is eliminated before.
    fn add_below(&self, values: &mut [f64], a: usize, b: usize, entry: impl Fn(usize, usize) -> f64) {
        let list = self.blocks_of(self.rank[b] as usize);
        let row = self.rank[a];
        // short lists: looking through them beats bisection
        let offset = list.iter().find(|block| block.0 == row).map(|block| block.1 as usize);
        assert!(offset.is_some(), "node pair ({a}, {b}) is not in the sparsity pattern");
        let (offset, first) = (offset.unwrap_or_default(), self.first[b] as usize);
        if self.num_free[a] == 6 && self.num_free[b] == 6 {
            for j in 0..6 {
                let start = self.col_ptr[first + j] as usize + offset - j;
                for (i, value) in values[start..start + 6].iter_mut().enumerate() {
                    *value += entry(i, j);
                }
            }
            return;
        }
        for j in 0..6 {
            let k = self.local[b][j];
            if k == NONE {
                continue;
            }
            let start = self.col_ptr[first + usize::from(k)] as usize + offset - usize::from(k);
            for i in 0..6 {
                let row = self.local[a][i];
                if row != NONE {
                    values[start + usize::from(row)] += entry(i, j);
                }
            }
        }
    }

    /// y = A x for the symmetric matrix with the given lower values.
    pub fn multiply(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..self.order.len() {
            let first = self.first_at(column);
            for k in 0..self.num_free_at(column) {
                let (mut at, mut sum, factor) = (self.col_ptr[first + k] as usize, 0.0, x[first + k]);
                for &(row, _) in self.blocks_of(column) {
                    let (mut from, to) = (self.first_at(row as usize), self.num_free_at(row as usize));
                    let to = from + to;
                    if row as usize == column {
                        from += k + 1;
                        sum += values[at] * factor;
                        at += 1;
                    }
                    let count = to - from;
                    for ((y, x), value) in y[from..to].iter_mut().zip(&x[from..to]).zip(&values[at..at + count]) {
                        *y += value * factor;
                        sum += value * x;
                    }
                    at += count;
                }
                y[first + k] += sum;
            }
        }
        y
    }

    /// Index of the diagonal entry of an equation in the value array.
    pub fn diagonal(&self, equation: usize) -> usize {
        self.col_ptr[equation] as usize
    }
}

/// Ascending, each once.
fn sort(blocks: &mut Vec<[u32; 2]>) {
    blocks.sort_unstable();
    blocks.dedup();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes 1 and 3 of a chain 0 1 2, 3 4 are one: the reduced matrix is Tᵀ A T of the full one, T the joining map.
    #[test]
    fn joined_nodes_share_their_equations() {
        let free = [[true, true, false, false, false, true]; 5];
        let pairs = [(0, 1), (1, 2), (3, 4), (1, 3), (3, 2)];
        let full = Pattern::new(&free, pairs.into_iter()).unwrap();
        let joined = Pattern::joined(&free, &[0, 1, 2, 1, 4], pairs.into_iter()).unwrap();
        assert_eq!((full.num_equations(), joined.num_equations()), (15, 12));
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
        let x: Vec<f64> = (0..12).map(|i| (1.0 + i as f64).sin()).collect();
        let (mut expanded, mut reduced) = (vec![0.0; 15], vec![0.0; 12]);
        for node in 0..5 {
            for k in [0, 1, 5] {
                expanded[full.equation(node, k).unwrap()] = x[joined.equation(node, k).unwrap()];
            }
        }
        let y = full.multiply(&a, &expanded);
        for node in 0..5 {
            for k in [0, 1, 5] {
                reduced[joined.equation(node, k).unwrap()] += y[full.equation(node, k).unwrap()];
            }
        }
        for (ours, exact) in joined.multiply(&b, &x).iter().zip(&reduced) {
            assert!((ours - exact).abs() < 1e-12 * exact.abs().max(1.0), "{ours} {exact}");
        }
    }

    #[test]
    fn blocks_land_where_a_dense_matrix_has_them() {
        let free = [[true; 6], [true, true, false, false, false, true], [true; 6]];
        let pattern = Pattern::new(&free, [(0, 1), (2, 0), (1, 0)].into_iter()).unwrap();
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
}
