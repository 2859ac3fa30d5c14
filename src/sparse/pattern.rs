//! Sparsity pattern of the tangent: upper triangle, compressed columns, grouped by nodes.
//!
//! A node has up to six unknowns (three positions, three rotations); supported and out-of-plane ones are eliminated
//! here, once, so that nothing further down knows of them.

/// Marks an eliminated unknown.
const NONE: u8 = u8::MAX;

/// Upper triangle pattern over node blocks.
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    /// First equation of each node; one more entry than nodes.
    first: Vec<u32>,
    /// Per node: local unknown → position among its free unknowns, or `NONE`.
    local: Vec<[u8; 6]>,
    /// The node whose unknowns a node shares; itself unless joined.
    master: Vec<u32>,
    col_ptr: Vec<u32>,
    row_idx: Vec<u32>,
    /// Per node b: range in `neighbours`.
    neighbour_ptr: Vec<u32>,
    /// (node a ≤ b, row offset of its block inside the columns of b), ascending in a.
    neighbours: Vec<(u32, u32)>,
}

impl Pattern {
    /// Pattern of nodes with the given free unknowns, coupled in the given node pairs (any order, duplicates allowed;
    /// the diagonal is always present).
    pub fn new(free: &[[bool; 6]], pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let master: Vec<usize> = (0..free.len()).collect();
        Self::joined(free, &master, pairs)
    }

    /// As [`Pattern::new`] with nodes that share the unknowns of another: `master[b]` is `b` itself or the node that b is joined to. Of
    /// joined nodes only the master's `free` counts; equations and blocks of the others are the master's.
    pub fn joined(free: &[[bool; 6]], master: &[usize], pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let num_nodes = free.len();
        let mut first = Vec::with_capacity(num_nodes + 1);
        let mut local = Vec::with_capacity(num_nodes);
        let mut count = 0u32;
        for (node, flags) in free.iter().enumerate() {
            first.push(count);
            if master[node] != node {
                local.push([NONE; 6]);
                continue;
            }
            let mut map = [NONE; 6];
            let mut here = 0u8;
            for (slot, _) in map.iter_mut().zip(flags).filter(|(_, is_free)| **is_free) {
                *slot = here;
                here += 1;
            }
            count += u32::from(here);
            local.push(map);
        }
        first.push(count);
        let mut blocks: Vec<(u32, u32)> =
            pairs.map(|(a, b)| (master[a], master[b])).map(|(a, b)| (a.max(b) as u32, a.min(b) as u32)).collect();
        blocks.extend((0..num_nodes as u32).map(|a| (a, a)));
        blocks.sort_unstable();
        blocks.dedup();
        let master = master.iter().map(|&m| m as u32).collect();
        let mut pattern = Self { first, local, master, ..Self::default() };
        pattern.fill(num_nodes, &blocks);
        pattern
    }

    fn fill(&mut self, num_nodes: usize, blocks: &[(u32, u32)]) {
        self.col_ptr.push(0);
        self.neighbour_ptr.push(0);
        let mut position = 0;
        for b in 0..num_nodes as u32 {
            let start = position;
            while position < blocks.len() && blocks[position].0 == b {
                position += 1;
            }
            let mut offset = 0;
            for &(_, a) in &blocks[start..position] {
                self.neighbours.push((a, offset));
                offset += self.num_free(a as usize) as u32;
            }
            self.neighbour_ptr.push(self.neighbours.len() as u32);
            for column in 0..self.num_free(b as usize) {
                for &(_, a) in &blocks[start..position] {
                    let rows = if a == b { column + 1 } else { self.num_free(a as usize) };
                    let base = self.first[a as usize];
                    self.row_idx.extend((0..rows as u32).map(|r| base + r));
                }
                self.col_ptr.push(self.row_idx.len() as u32);
            }
        }
    }

    /// Number of equations.
    pub fn num_equations(&self) -> usize {
        self.first.last().map_or(0, |&n| n as usize)
    }

    /// Number of stored entries.
    pub fn num_entries(&self) -> usize {
        self.row_idx.len()
    }

    /// Column pointers (upper triangle).
    pub fn col_ptr(&self) -> &[u32] {
        &self.col_ptr
    }

    /// Row indices (upper triangle), ascending within a column.
    pub fn row_idx(&self) -> &[u32] {
        &self.row_idx
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

    fn num_free(&self, node: usize) -> usize {
        (self.first[node + 1] - self.first[node]) as usize
    }

    /// Adds the 6×6 block with rows of node `a` and columns of node `b` (and by symmetry its transpose).
    ///
    /// For `a == b` the block is a contribution to the symmetric diagonal block: its upper part is used.
    /// Pairs not in the pattern are a programming error.
    pub fn add_block(&self, values: &mut [f64], a: usize, b: usize, entry: impl Fn(usize, usize) -> f64) {
        let joined = a != b && self.master[a] == self.master[b];
        let (a, b) = (self.master[a] as usize, self.master[b] as usize);
        if joined {
            // a coupling of two nodes that move as one acts on both sides of the diagonal
            self.add_ordered(values, a, b, |i, j| entry(i, j) + entry(j, i));
        } else if a > b {
            self.add_ordered(values, b, a, |i, j| entry(j, i));
        } else {
            self.add_ordered(values, a, b, entry);
        }
    }

    /// [`Pattern::add_block`] for a ≤ b.
    fn add_ordered(&self, values: &mut [f64], a: usize, b: usize, entry: impl Fn(usize, usize) -> f64) {
        let range = self.neighbour_ptr[b] as usize..self.neighbour_ptr[b + 1] as usize;
        let list = &self.neighbours[range];
        let slot = list.binary_search_by_key(&(a as u32), |n| n.0);
        assert!(slot.is_ok(), "node pair ({a}, {b}) is not in the sparsity pattern");
        let offset = slot.map_or(0, |s| list[s].1) as usize;
        for j in 0..6 {
            let Some(column) = self.equation(b, j) else { continue };
            let start = self.col_ptr[column] as usize + offset;
            for i in 0..6 {
                let row = self.local[a][i];
                if row == NONE || (a == b && i > j) {
                    continue;
                }
                values[start + row as usize] += entry(i, j);
            }
        }
    }

    /// y = A x for the symmetric matrix with the given upper values.
    pub fn multiply(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..x.len() {
            for entry in self.col_ptr[column] as usize..self.col_ptr[column + 1] as usize {
                let row = self.row_idx[entry] as usize;
                y[row] += values[entry] * x[column];
                if row != column {
                    y[column] += values[entry] * x[row];
                }
            }
        }
        y
    }

    /// Index of the diagonal entry of an equation in the value array.
    pub fn diagonal(&self, equation: usize) -> usize {
        self.col_ptr[equation + 1] as usize - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes 1 and 3 of a chain 0 1 2, 3 4 are one: the reduced matrix is Tᵀ A T of the full one, T the joining map.
    #[test]
    fn joined_nodes_share_their_equations() {
        let free = [[true, true, false, false, false, true]; 5];
        let pairs = [(0, 1), (1, 2), (3, 4), (1, 3), (3, 2)];
        let full = Pattern::new(&free, pairs.into_iter());
        let joined = Pattern::joined(&free, &[0, 1, 2, 1, 4], pairs.into_iter());
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
}
