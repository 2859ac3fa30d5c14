//! Sparsity pattern of the tangent: lower triangle, compressed columns, grouped by nodes.
//!
//! A node has up to six unknowns (three positions, three rotations). Supported and out-of-plane ones are eliminated
//! here; the factorisation does not see them. Equations are numbered in the order of elimination
//! ([`NodeGraph::ordered`]), so that the factorisation takes the matrix as it is assembled.

/// Marks an eliminated unknown.
const NONE: u8 = u8::MAX;
/// Unknowns of a node that no support holds.
const ALL: [u8; 6] = [0, 1, 2, 3, 4, 5];

/// Lower triangle pattern over node blocks.
#[derive(Debug, Clone, Default)]
pub struct Pattern {
    /// Nodes in the order of elimination.
    order: Vec<u32>,
    /// Position of each node in `order`.
    place: Vec<u32>,
    /// First equation of each node.
    first: Vec<u32>,
    /// Per node: local unknown → position among its free unknowns, or `NONE`.
    local: Vec<[u8; 6]>,
    /// The node whose unknowns a node shares; itself unless joined.
    master: Vec<u32>,
    col_ptr: Vec<u32>,
    row_idx: Vec<u32>,
    /// Per place: range in `neighbours`.
    neighbour_ptr: Vec<u32>,
    /// (place of a node at or after this one, row offset of its block inside the first column of this one), ascending.
    neighbours: Vec<(u32, u32)>,
}

/// Number of unknowns of a node.
fn num_free(slots: &[u8; 6]) -> u32 {
    slots.iter().filter(|&&slot| slot != NONE).count() as u32
}

/// Nodes, their free unknowns and the pairs of nodes that are coupled: a pattern whose nodes have no order yet.
#[derive(Debug, Clone)]
pub struct NodeGraph {
    local: Vec<[u8; 6]>,
    master: Vec<u32>,
    /// Pairs of nodes, the lower first, each node with itself among them, ascending.
    pairs: Vec<(u32, u32)>,
}

impl NodeGraph {
    /// Nodes with the given free unknowns, coupled in the given pairs (any order, duplicates allowed; the diagonal is always
    /// present). Nodes may share the unknowns of another: `master[b]` is `b` itself or the node that b is joined to. Only
    /// the master's `free` counts; the others have the master's equations and blocks.
    pub fn new(free: &[[bool; 6]], master: &[usize], pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let num_nodes = free.len();
        let mut local = Vec::with_capacity(num_nodes);
        for (node, flags) in free.iter().enumerate() {
            let mut map = [NONE; 6];
            let free = (0..6).filter(|&k| flags[k] && master[node] == node);
            free.zip(0..).for_each(|(k, here)| map[k] = here);
            local.push(map);
        }
        let mut pairs: Vec<(u32, u32)> =
            pairs.map(|(a, b)| (master[a] as u32, master[b] as u32)).map(|(a, b)| (a.min(b), a.max(b))).collect();
        pairs.extend((0..num_nodes as u32).map(|a| (a, a)));
        pairs.sort_unstable();
        pairs.dedup();
        Self { local, master: master.iter().map(|&m| m as u32).collect(), pairs }
    }

    /// Number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.local.len()
    }

    /// First equation of each node, numbered in the nodes' own order, and their number in all.
    fn first_equations(&self) -> Vec<u32> {
        let mut firsts = vec![0];
        for slots in &self.local {
            firsts.push(firsts[firsts.len() - 1] + num_free(slots));
        }
        firsts
    }

    /// The matrix with its nodes in their own order, upper triangle: column pointers and row indices, ascending within a
    /// column.
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
        let Self { local, master, mut pairs } = self;
        let num_nodes = order.len();
        let mut pattern =
            Pattern { place: vec![0; num_nodes], first: vec![0; num_nodes], local, master, ..Pattern::default() };
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
        let master: Vec<usize> = (0..free.len()).collect();
        NodeGraph::new(free, &master, pairs).natural()
    }

    fn fill(&mut self, blocks: &[(u32, u32)]) {
        self.col_ptr.push(0);
        self.neighbour_ptr.push(0);
        let mut blocks = blocks;
        for (&node, at) in self.order.iter().zip(0u32..) {
            let (here, rest) = blocks.split_at(blocks.partition_point(|block| block.0 == at));
            blocks = rest;
            let mut offset = 0;
            for &(_, other) in here {
                self.neighbours.push((other, offset));
                offset += self.num_free(self.order[other as usize]);
            }
            self.neighbour_ptr.push(self.neighbours.len() as u32);
            for column in 0..self.num_free(node) {
                for &(_, other) in here {
                    let below = if other == at { column } else { 0 };
                    let other = self.order[other as usize];
                    let base = self.first[other as usize];
                    self.row_idx.extend((below..self.num_free(other)).map(|row| base + row));
                }
                self.col_ptr.push(self.row_idx.len() as u32);
            }
        }
    }

    /// Number of equations.
    pub fn num_equations(&self) -> usize {
        self.col_ptr.len().saturating_sub(1)
    }

    /// Number of stored entries.
    pub fn num_entries(&self) -> usize {
        self.row_idx.len()
    }

    /// Column pointers (lower triangle).
    pub fn col_ptr(&self) -> &[u32] {
        &self.col_ptr
    }

    /// Row indices (lower triangle), ascending within a column; the first is the diagonal.
    pub fn row_idx(&self) -> &[u32] {
        &self.row_idx
    }

    /// The upper triangle: column pointers and row indices, ascending within a column.
    pub fn upper(&self) -> (Vec<u32>, Vec<u32>) {
        let mut col_ptr = vec![0u32; self.col_ptr.len()];
        self.row_idx.iter().for_each(|&row| col_ptr[row as usize + 1] += 1);
        (1..col_ptr.len()).for_each(|k| col_ptr[k] += col_ptr[k - 1]);
        let mut next = col_ptr.clone();
        let mut row_idx = vec![0u32; self.row_idx.len()];
        for column in 0..self.num_equations() {
            for entry in self.col_ptr[column] as usize..self.col_ptr[column + 1] as usize {
                let slot = &mut next[self.row_idx[entry] as usize];
                row_idx[*slot as usize] = column as u32;
                *slot += 1;
            }
        }
        (col_ptr, row_idx)
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

    /// [`Pattern::equation`], `None` also of a node that is joined to one before.
    pub fn own_equation(&self, node: usize, k: usize) -> Option<usize> {
        if self.master[node] as usize == node { self.equation(node, k) } else { None }
    }

    fn num_free(&self, node: u32) -> u32 {
        num_free(&self.local[node as usize])
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
        let (a, b) = (self.master[a] as usize, self.master[b] as usize);
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
        let joined = a != b && self.master[a] == self.master[b];
        let (a, b) = (self.master[a] as usize, self.master[b] as usize);
        if joined {
            // two joined nodes: their coupling and its transpose lie in one diagonal block
            self.add_ordered(values, start, [a, b], |i, j| entry(i, j) + entry(j, i));
        } else if self.place[a] > self.place[b] {
            self.add_ordered(values, start, [b, a], |i, j| entry(j, i));
        } else {
            self.add_ordered(values, start, [a, b], entry);
        }
    }

    /// [`Pattern::add_at`] for `a` at or before `b`: goes to rows of b in columns of a.
    #[inline]
    fn add_ordered(&self, values: &mut [f64], start: usize, [a, b]: [usize; 2], entry: impl Fn(usize, usize) -> f64) {
        let first = self.first[a] as usize;
        let length = (self.col_ptr[first + 1] - self.col_ptr[first]) as usize;
        if a != b && self.local[a] == ALL && self.local[b] == ALL {
            let mut at = start;
            for i in 0..6 {
                values[at..at + 6].iter_mut().zip(0..).for_each(|(value, j)| *value += entry(i, j));
                at += length - i - 1;
            }
            return;
        }
        for (i, &column) in self.local[a].iter().enumerate().filter(|(_, column)| **column != NONE) {
            // each column is shorter by one, because entries above the diagonal are not stored
            let column = usize::from(column);
            let at = start + column * length - column * (column + 1) / 2;
            for (j, &row) in self.local[b].iter().enumerate() {
                if row != NONE && (a != b || i <= j) {
                    values[at + usize::from(row)] += entry(i, j);
                }
            }
        }
    }

    /// y = A x for the symmetric matrix with the given values.
    pub fn multiply(&self, values: &[f64], x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..x.len() {
            let entries = self.col_ptr[column] as usize..self.col_ptr[column + 1] as usize;
            let (Some((diagonal, values)), [_, rows @ ..]) =
                (values[entries.clone()].split_first(), &self.row_idx[entries])
            else {
                continue;
            };
            let mut sum = y[column] + diagonal * x[column];
            for (&row, value) in rows.iter().zip(values) {
                y[row as usize] += value * x[column];
                sum += value * x[row as usize];
            }
            y[column] = sum;
        }
        y
    }

    /// Index of the diagonal entry of an equation in the value array.
    pub fn diagonal(&self, equation: usize) -> usize {
        self.col_ptr[equation] as usize
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
        let joined = NodeGraph::new(&free, &[0, 1, 2, 1, 4], pairs.into_iter()).natural();
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

    /// The same blocks in another order of nodes make the same matrix, its upper triangle the transpose of the lower
    /// one.
    #[test]
    fn order_changes_nothing_but_numbers() {
        let mut free = [[true; 6]; 5];
        (free[1], free[3]) = ([true, true, false, false, false, true], [false; 6]);
        let pairs = [(0, 1), (1, 2), (3, 4), (1, 4), (4, 2), (0, 4)];
        let graph = NodeGraph::new(&free, &[0, 1, 2, 3, 4], pairs.into_iter());
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
        let lower = dense(other.col_ptr(), other.row_idx());
        let mut upper: Vec<(u32, u32)> = dense(&col_ptr, &row_idx).into_iter().map(|(r, c)| (c, r)).collect();
        assert!(lower.iter().all(|(row, column)| row >= column));
        upper.sort_by_key(|&(row, column)| (column, row));
        assert_eq!(lower, upper);
    }
}
