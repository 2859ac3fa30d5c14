//! Sparse LDLᵀ with inertia. The only file that names faer.
//!
//! The supernodal method is forced: the simplicial one reports no failures. Diagonal matrices, for which no work is to be done, are faer's simplicial ones
//! all the same; their pivots are their entries. `Par::Seq`: the library parallelises dense
//! kernels only, and the supernodes of rods are about twelve wide, where threads cost more than they give.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLdltRef,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::error::SolveError;
use crate::sparse::Pattern;

/// Signs of the eigenvalues of a factorised matrix (Sylvester).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inertia {
    /// Number of negative eigenvalues.
    pub num_negative: usize,
}

/// Order of elimination of the nodes of a graph (approximate minimum degree), and the place of each node in it. `edges`: pairs a < b, sorted, each once.
///
/// Nodes instead of equations: 36 times fewer entries, and the equations of a node stay together. Nodes that can be eliminated as they are numbered
/// without a new entry, as those of open rods that touch nothing, keep their numbers: no order is sparser, and a sweep along a rod keeps rounding lowest where
/// stretching is far stiffer than bending.
pub(super) fn elimination_order(num_nodes: usize, edges: &[[u32; 2]]) -> Result<(Vec<u32>, Vec<u32>), SolveError> {
    let (mut order, mut rank) = (vec![0; num_nodes], vec![0; num_nodes]);
    if num_nodes == 0 {
        return Ok((order, rank));
    }
    if fills_nothing(num_nodes, edges) {
        let order: Vec<u32> = (0..num_nodes as u32).collect();
        return Ok((order.clone(), order));
    }
    // edges by their first node are the lower triangle's columns
    let mut col_ptr = vec![0u32; num_nodes + 1];
    edges.iter().for_each(|edge| col_ptr[edge[0] as usize + 1] += 1);
    (0..num_nodes).for_each(|k| col_ptr[k + 1] += col_ptr[k]);
    let rows: Vec<u32> = edges.iter().map(|edge| edge[1]).collect();
    let graph = SymbolicSparseColMatRef::new_checked(num_nodes, num_nodes, &col_ptr, None, &rows);
    let scratch = amd::order_scratch::<u32>(num_nodes, edges.len());
    let mut scratch = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
    amd::order(&mut order, &mut rank, graph, amd::Control::default(), MemStack::new(&mut scratch)).map_err(failed)?;
    Ok((order, rank))
}

/// Whether elimination in the order of the numbers makes no new entries: each column has all rows down to the last that it or an earlier one has.
fn fills_nothing(num_nodes: usize, edges: &[[u32; 2]]) -> bool {
    let (mut last, mut entries, mut next) = (0, 0, 0);
    for node in 0..num_nodes {
        while next < edges.len() && edges[next][0] as usize == node {
            last = last.max(edges[next][1] as usize);
            next += 1;
        }
        entries += last.saturating_sub(node);
    }
    entries == edges.len()
}

fn failed(error: impl std::fmt::Debug) -> SolveError {
    SolveError::Symbolic { reason: format!("{error:?}") }
}

fn out_of_memory() -> SolveError {
    SolveError::Symbolic { reason: "out of memory".to_owned() }
}

/// Symbolic analysis of one pattern with buffers for repeated numeric factorisation.
pub struct Factor {
    matrix: SymbolicSparseColMat<u32>,
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    scratch: MemBuffer,
}

impl std::fmt::Debug for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Factor").field("num_values", &self.values.len()).finish()
    }
}

impl Factor {
    /// Analyses a pattern, in its own order.
    ///
    /// # Errors
    /// `SolveError::Symbolic` when memory or the 32-bit index range does not suffice.
    pub fn analyse(pattern: &Pattern) -> Result<Self, SolveError> {
        let n = pattern.num_equations();
        let matrix = SymbolicSparseColMat::new_checked(n, n, pattern.col_ptr().to_vec(), None, pattern.row_idx());
        // the analysis goes by the upper triangle
        let upper = matrix.as_ref().to_row_major().map_err(failed)?;
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let ordering = SymmetricOrdering::Identity;
        let symbolic =
            factorize_symbolic_cholesky(upper.as_ref().transpose(), Side::Upper, ordering, params).map_err(failed)?;
        let scratch = symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let scratch = MemBuffer::try_new(scratch).map_err(|_| out_of_memory())?;
        let values = vec![0.0; symbolic.len_val()];
        Ok(Self { matrix, symbolic, values, scratch })
    }

    /// Number of stored entries of L.
    pub fn num_values(&self) -> usize {
        self.values.len()
    }

    /// Factorises the matrix with the given lower values; `None` when a pivot vanishes.
    pub fn factorise(&mut self, lower: &[f64]) -> Option<Inertia> {
        if self.matrix.nrows() == 0 {
            // every unknown is supported: nothing to solve for, and nothing wrong with it
            return Some(Inertia { num_negative: 0 });
        }
        let matrix = SparseColMatRef::new(self.matrix.as_ref(), lower);
        let stack = MemStack::new(&mut self.scratch);
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.values,
                matrix,
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                stack,
                Default::default(),
            )
            .ok()?;
        self.inertia()
    }

    /// Counts negative entries of D; `None` if any is NaN.
    fn inertia(&self) -> Option<Inertia> {
        let symbolic = match self.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic,
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let pivots = || symbolic.col_ptr()[..symbolic.ncols()].iter().map(|&first| self.values[first as usize]);
                let sound = pivots().all(|pivot| pivot != 0.0 && !pivot.is_nan());
                return sound.then(|| Inertia { num_negative: pivots().filter(|pivot| *pivot < 0.0).count() });
            }
        };
        let factors = SupernodalLdltRef::new(symbolic, &self.values);
        let mut num_negative = 0;
        for s in 0..symbolic.n_supernodes() {
            let block = factors.supernode(s).val();
            for k in 0..block.ncols() {
                let pivot = block[(k, k)];
                if pivot.is_nan() {
                    return None;
                }
                num_negative += usize::from(pivot < 0.0);
            }
        }
        Some(Inertia { num_negative })
    }

    /// Solves A x = b in place with the last factorisation.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        let n = rhs.len();
        if n == 0 {
            return;
        }
        let factors = LdltRef::new(&self.symbolic, &self.values);
        let stack = MemStack::new(&mut self.scratch);
        factors.solve_in_place_with_conj(Conj::No, MatMut::from_column_major_slice_mut(rhs, n, 1), Par::Seq, stack);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 1D chain with one soft negative spring: solution and inertia against a dense computation.
    #[test]
    fn solves_and_counts_negative_eigenvalues() {
        let free = vec![[true, false, false, false, false, true]; 20];
        let pattern = Pattern::new(&free, (0..19).map(|a| (a, a + 1))).unwrap();
        let mut values = vec![0.0; pattern.num_entries()];
        for a in 0..20 {
            pattern.add_block(&mut values, a, a, |i, j| {
                if i != j {
                    0.1
                } else if i == 0 {
                    2.5
                } else {
                    1.0 - 0.15 * a as f64
                }
            });
        }
        for a in 0..19 {
            pattern.add_block(&mut values, a, a + 1, |i, j| if i == j { -0.4 } else { 0.03 });
        }
        let n = pattern.num_equations();
        let rows = pattern.row_idx();
        let mut dense = nalgebra::DMatrix::<f64>::zeros(n, n);
        for column in 0..n {
            for entry in pattern.col_ptr()[column] as usize..pattern.col_ptr()[column + 1] as usize {
                let row = rows[entry] as usize;
                dense[(row, column)] = values[entry];
                dense[(column, row)] = values[entry];
            }
        }
        let negative = dense.clone().symmetric_eigenvalues().iter().filter(|x| **x < 0.0).count();
        assert!(negative > 0);
        let mut factor = Factor::analyse(&pattern).unwrap();
        assert_eq!(factor.factorise(&values), Some(Inertia { num_negative: negative }));
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut rhs = pattern.multiply(&values, &exact);
        factor.solve(&mut rhs);
        for i in 0..n {
            assert!((rhs[i] - exact[i]).abs() < 1e-12);
        }
    }

    /// Symptom: a model with a single unknown left, or with unknowns that have nothing to do with each other, broke down. Mechanism: without off-diagonal
    /// entries faer takes its simplicial method, whatever is asked for, and pivots were looked for in supernodes.
    #[test]
    fn diagonal_matrices() {
        for diagonal in [vec![3.0], vec![-2.0], vec![4.0, -1.0, 0.5]] {
            let pattern =
                Pattern::new(&vec![[true, false, false, false, false, false]; diagonal.len()], std::iter::empty())
                    .unwrap();
            let mut values = vec![0.0; pattern.num_entries()];
            for (node, x) in diagonal.iter().enumerate() {
                pattern.add_block(&mut values, node, node, |_, _| *x);
            }
            let mut factor = Factor::analyse(&pattern).unwrap();
            let num_negative = diagonal.iter().filter(|x| **x < 0.0).count();
            assert_eq!(factor.factorise(&values), Some(Inertia { num_negative }));
            let mut rhs = diagonal.clone();
            factor.solve(&mut rhs);
            assert_eq!(rhs, vec![1.0; diagonal.len()]);
            values[0] = 0.0;
            assert_eq!(factor.factorise(&values), None, "a pivot vanishes");
            values[0] = f64::NAN;
            assert_eq!(factor.factorise(&values), None);
        }
    }

    #[test]
    fn only_bands_without_gaps_keep_their_order() {
        let element = |e: u32| (0..4).flat_map(move |a| (a + 1..4).map(move |b| [3 * e + a, 3 * e + b]));
        let chain: Vec<[u32; 2]> = (0..5).flat_map(element).collect();
        let natural: Vec<u32> = (0..16).collect();
        assert_eq!(elimination_order(16, &chain).unwrap(), (natural.clone(), natural));
        for other in [[0, 15], [1, 4], [7, 12]] {
            let mut with = chain.clone();
            with.push(other);
            with.sort_unstable();
            assert!(!fills_nothing(16, &with), "{other:?}");
            let (order, rank) = elimination_order(16, &with).unwrap();
            assert!((0..16).all(|k| order[rank[k] as usize] == k as u32));
        }
    }
}
