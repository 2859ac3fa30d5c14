//! Sparse LDLᵀ with inertia. The only file that names faer, whose analysis, dense kernels and solves it uses; the order
//! of the work is that of [`fronts`](super::fronts).
//!
//! The supernodal method is forced, because the simplicial one reports no failures. faer still takes the simplicial
//! method for diagonal matrices; their pivots are their entries. `Par::Seq`: the library parallelises dense kernels
//! only, and the supernodes of rods are about twelve wide, where threads cost more than they save.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt;
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLdltRef,
};
use faer::sparse::linalg::{SupernodalThreshold, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, Conj, MatMut, MatRef, Par, Side};

use crate::error::SolveError;
use crate::sparse::fronts::{EliminationTree, Lower, Supernodes};
use crate::sparse::ordering::Adjacency;
use crate::sparse::{NodeGraph, Pattern};

/// Signs of the eigenvalues of a factorised matrix (Sylvester).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Inertia {
    /// Number of negative eigenvalues.
    pub num_negative: usize,
}

/// Symbolic analysis of one pattern with buffers for repeated numeric factorisation.
pub struct Factor {
    symbolic: SymbolicCholesky<u32>,
    method: Method,
    values: Vec<f64>,
}

/// Who does the numeric work.
enum Method {
    /// The library by itself, with this scratch and the rows of all entries.
    Library(MemBuffer, Vec<u32>),
    /// The library's dense kernels, in the order of this tree, on all threads.
    Fronts(EliminationTree),
}

impl std::fmt::Debug for Factor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Factor").field("num_values", &self.values.len()).finish()
    }
}

/// Operations in the order from the ends, over those by minimum degree, from which it is taken, because above that the
/// time is hardly another.
const WORTH: f64 = 0.8;
/// Multiplications of a factorisation that are left to one thread, because they take a millisecond, and waking others
/// some hundredths of one.
const FOR_ONE_THREAD: f64 = 1e7;

/// The pattern in an order of nodes with few operations: by approximate minimum degree over the equations, or from the
/// ends where that has fewer; of those that threads share, fewer one after the other on two threads. (Minimum degree
/// over the nodes takes a thirtieth of the time, for the same fill; rolling a rod up to a full circle in one step then
/// fails.)
///
/// # Errors
/// As [`Factor::of`].
fn ordered(graph: NodeGraph) -> Result<Pattern, SolveError> {
    let (col_ptr, row_idx) = graph.upper();
    let n = col_ptr.len() - 1;
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let scratch = amd::order_maybe_unsorted_scratch::<u32>(n, row_idx.len());
    let mut scratch = MemBuffer::try_new(scratch).map_err(|_| failed("out of memory".to_owned()))?;
    let stack = MemStack::new(&mut scratch);
    amd::order_maybe_unsorted(&mut order, &mut inverse, matrix, Default::default(), stack)
        .map_err(|e| failed(format!("{e:?}")))?;
    let by_degree = graph.nodes_of(&order);
    let adjacency = Adjacency::new(&graph);
    let from_ends = adjacency.ends_to_middle();
    let [ours, theirs] = [&from_ends, &by_degree].map(|order| adjacency.elimination(order));
    let threads = if theirs.work() > FOR_ONE_THREAD { 2 } else { 1 };
    let is_worth = ours.cut(threads).longest <= WORTH * theirs.cut(threads).longest;
    Ok(graph.ordered(if is_worth { from_ends } else { by_degree }))
}

fn failed(reason: String) -> SolveError {
    SolveError::Symbolic { reason }
}

impl Factor {
    /// Orders the nodes to reduce fill and analyses the pattern.
    ///
    /// # Errors
    /// `SolveError::Symbolic` when memory or the 32-bit index range does not suffice.
    pub fn of(graph: NodeGraph) -> Result<(Pattern, Self), SolveError> {
        let pattern = ordered(graph)?;
        let factor = Self::analyse(&pattern)?;
        Ok((pattern, factor))
    }

    /// Symbolic analysis of a pattern in its own order of elimination.
    fn analyse(pattern: &Pattern) -> Result<Self, SolveError> {
        let n = pattern.num_equations();
        let (col_ptr, row_idx) = pattern.upper();
        let matrix = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, SymmetricOrdering::Identity, params)
            .map_err(|e| failed(format!("{e:?}")))?;
        drop((col_ptr, row_idx));
        let values = vec![0.0; symbolic.len_val()];
        let tree = match symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => {
                EliminationTree::of_more(&supernodes(symbolic), FOR_ONE_THREAD)
            }
            SymbolicCholeskyRaw::Simplicial(_) => None,
        };
        let method = match tree {
            Some(tree) => Method::Fronts(tree),
            None => Method::library(&symbolic, pattern)?,
        };
        Ok(Self { symbolic, method, values })
    }

    /// Number of stored entries of L.
    pub fn num_values(&self) -> usize {
        self.values.len()
    }

    /// Factorises the matrix with the given values; `None` when a pivot vanishes.
    pub fn factorise(&mut self, pattern: &Pattern, lower: &[f64]) -> Option<Inertia> {
        let n = pattern.num_equations();
        if n == 0 {
            // every unknown is supported: an empty matrix is legal
            return Some(Inertia { num_negative: 0 });
        }
        match (&mut self.method, self.symbolic.raw()) {
            (Method::Fronts(tree), SymbolicCholeskyRaw::Supernodal(symbolic)) => {
                let matrix = Lower { pattern, values: lower };
                tree.factorise(&supernodes(symbolic), matrix, &mut self.values, eliminate).then_some(())?;
            }
            (Method::Library(scratch, row_idx), _) => {
                let symbolic = SymbolicSparseColMatRef::new_checked(n, n, pattern.col_ptr(), None, row_idx);
                let matrix = SparseColMatRef::new(symbolic, lower);
                self.symbolic
                    .factorize_numeric_ldlt(
                        &mut self.values,
                        matrix,
                        Side::Lower,
                        LdltRegularization::default(),
                        Par::Seq,
                        MemStack::new(scratch),
                        Default::default(),
                    )
                    .ok()?;
            }
            (Method::Fronts(_), SymbolicCholeskyRaw::Simplicial(_)) => unreachable!("fronts are of supernodes"),
        }
        self.inertia()
    }

    /// Counts negative entries of D; `None` if any is zero or NaN.
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
                if pivot == 0.0 || pivot.is_nan() {
                    return None;
                }
                num_negative += usize::from(pivot < 0.0);
            }
        }
        Some(Inertia { num_negative })
    }

    /// ln |det A| of the last factorisation: the sum of ln |d| over the pivots.
    pub fn log_determinant(&self) -> f64 {
        let symbolic = match self.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic,
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let pivots = symbolic.col_ptr()[..symbolic.ncols()].iter().map(|&first| self.values[first as usize]);
                return pivots.map(|pivot| pivot.abs().ln()).sum();
            }
        };
        let factors = SupernodalLdltRef::new(symbolic, &self.values);
        let of_supernode = |s: usize| {
            let block = factors.supernode(s).val();
            (0..block.ncols()).map(|k| block[(k, k)].abs().ln()).sum::<f64>()
        };
        (0..symbolic.n_supernodes()).map(of_supernode).sum()
    }

    /// Solves A x = b in place with the last factorisation.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        let n = rhs.len();
        if n == 0 {
            return;
        }
        match (&mut self.method, self.symbolic.raw()) {
            (Method::Fronts(tree), SymbolicCholeskyRaw::Supernodal(symbolic)) => {
                tree.solve(&supernodes(symbolic), &self.values, rhs);
            }
            (Method::Library(scratch, _), _) => {
                let factors = LdltRef::new(&self.symbolic, &self.values);
                let (rhs, stack) = (MatMut::from_column_major_slice_mut(rhs, n, 1), MemStack::new(scratch));
                factors.solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack);
            }
            (Method::Fronts(_), SymbolicCholeskyRaw::Simplicial(_)) => unreachable!("fronts are of supernodes"),
        }
    }
}

impl Method {
    /// # Errors
    /// Memory that does not suffice.
    fn library(symbolic: &SymbolicCholesky<u32>, pattern: &Pattern) -> Result<Self, SolveError> {
        let scratch = symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let scratch = MemBuffer::try_new(scratch).map_err(|_| failed("out of memory".to_owned()))?;
        Ok(Self::Library(scratch, pattern.row_idx()))
    }
}

fn supernodes(symbolic: &SymbolicSupernodalCholesky<u32>) -> Supernodes<'_> {
    Supernodes {
        columns: [symbolic.supernode_begin(), symbolic.supernode_end()],
        row_ptr: symbolic.col_ptr_for_row_idx(),
        num_rows: symbolic.nnz_per_super(),
        rows: symbolic.row_idx(),
        panel_ptr: symbolic.col_ptr_for_val(),
    }
}

/// See [`Eliminate`](super::fronts::Eliminate): with A₁₁ = L₁₁ D L₁₁ᵀ the panel's rows become L₂₁ = A₂₁ L₁₁⁻ᵀ D⁻¹, and
/// L₂₁ D L₂₁ᵀ is subtracted from the update.
fn eliminate(panel: &mut [f64], [width, height]: [usize; 2], update: &mut [f64], product: &mut Vec<f64>) -> bool {
    let panel = MatMut::from_column_major_slice_mut(panel, width + height, width);
    let (mut top, mut bottom) = panel.split_at_row_mut(width);
    let scratch = ldlt::factor::cholesky_in_place_scratch::<f64>(width, Par::Seq, Default::default());
    let mut scratch = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut scratch);
    let regularization = LdltRegularization::default();
    if ldlt::factor::cholesky_in_place(top.as_mut(), regularization, Par::Seq, stack, Default::default()).is_err() {
        return false;
    }
    for column in 1..width {
        (0..column).for_each(|row| top[(row, column)] = 0.0);
    }
    if height == 0 {
        return true;
    }
    solve_unit_lower_triangular_in_place(top.as_ref(), bottom.as_mut().transpose_mut(), Par::Seq);
    // L₂₁ D
    product.clear();
    for column in 0..width {
        let inverse = top[(column, column)].recip();
        for value in bottom.as_mut().col_mut(column).iter_mut() {
            product.push(*value);
            *value *= inverse;
        }
    }
    matmul(
        MatMut::from_column_major_slice_mut(update, height, height),
        BlockStructure::TriangularLower,
        Accum::Add,
        MatRef::from_column_major_slice(product, height, width),
        BlockStructure::Rectangular,
        bottom.as_ref().transpose(),
        BlockStructure::Rectangular,
        -1.0,
        Par::Seq,
    );
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed ladder with long-range rungs: the factor is that of faer's own method, with the same bits for any
    /// number of threads.
    #[test]
    fn fronts_give_the_factor_of_the_library() {
        let count = 600;
        let free = vec![[true; 6]; count];
        let pairs = (0..count)
            .flat_map(|a| (1..4).map(move |k| (a, (a + k) % count)))
            .chain((0..count).map(|a| (a, count - 1 - a)))
            .chain((0..20).map(|k| (31 * k, (97 * k + 300) % count)));
        let owner: Vec<[usize; 6]> = (0..count).map(|node| [node; 6]).collect();
        let (pattern, mut factor) = Factor::of(NodeGraph::new(&free, &owner, pairs)).unwrap();
        let mut values: Vec<f64> = (0..pattern.num_entries()).map(|k| (1.0 + 1.7 * k as f64).sin()).collect();
        for equation in 0..pattern.num_equations() {
            values[pattern.diagonal(equation)] = if equation % 97 == 3 { -40.0 } else { 45.0 };
        }
        let exact: Vec<f64> = (0..pattern.num_equations()).map(|k| (0.3 + k as f64).cos()).collect();
        let mut run = |threads: usize, fewest: Option<usize>| {
            let pool = crate::math::parallel::Pool::new(threads).unwrap();
            crate::math::parallel::in_pool(Some(&pool), || {
                let SymbolicCholeskyRaw::Supernodal(symbolic) = factor.symbolic.raw() else { panic!("no diagonal") };
                factor.method = match fewest {
                    None => Method::library(&factor.symbolic, &pattern).unwrap(),
                    Some(fewest) => {
                        let tree = EliminationTree::of_more(&supernodes(symbolic), 0.0).unwrap();
                        assert!(tree.num_tasks() >= fewest, "{}", tree.num_tasks());
                        Method::Fronts(tree)
                    }
                };
                let inertia = factor.factorise(&pattern, &values);
                let mut x = pattern.multiply(&values, &exact);
                factor.solve(&mut x);
                (inertia, factor.values.clone(), x)
            })
        };
        let (inertia, ours, x) = run(1, Some(1));
        x.iter().zip(&exact).for_each(|(x, exact)| assert!((x - exact).abs() < 1e-11, "{x} {exact}"));
        assert_eq!((inertia, ours.clone(), x), run(3, Some(3)));
        let (expected, theirs, _) = run(1, None);
        assert_eq!(inertia, expected);
        assert!(inertia.unwrap().num_negative > 10);
        let largest = theirs.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (k, (ours, theirs)) in ours.iter().zip(&theirs).enumerate() {
            assert!((ours - theirs).abs() < 1e-12 * largest, "{k}: {ours} {theirs}");
        }
    }

    /// A 1D chain with one soft negative spring: solution and inertia against a dense computation.
    #[test]
    fn solves_and_counts_negative_eigenvalues() {
        let free = vec![[true, false, false, false, false, true]; 20];
        let pattern = Pattern::new(&free, (0..19).map(|a| (a, a + 1)));
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
        let mut dense = nalgebra::DMatrix::<f64>::zeros(n, n);
        for column in 0..n {
            for (&row, value) in pattern.rows(column).iter().zip(&values[pattern.entries(column)]) {
                dense[(row as usize, column)] = *value;
                dense[(column, row as usize)] = *value;
            }
        }
        let negative = dense.clone().symmetric_eigenvalues().iter().filter(|x| **x < 0.0).count();
        assert!(negative > 0);
        let mut factor = Factor::analyse(&pattern).unwrap();
        assert_eq!(factor.factorise(&pattern, &values), Some(Inertia { num_negative: negative }));
        assert!((factor.log_determinant() - dense.determinant().abs().ln()).abs() < 1e-11);
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut rhs = pattern.multiply(&values, &exact);
        factor.solve(&mut rhs);
        for i in 0..n {
            assert!((rhs[i] - exact[i]).abs() < 1e-12);
        }
    }

    /// Symptom: a model with a single unknown, or with uncoupled unknowns, broke down. Mechanism: without off-diagonal
    /// entries faer uses its simplicial method in any case, and pivots were read from supernodes.
    #[test]
    fn diagonal_matrices() {
        for diagonal in [vec![3.0], vec![-2.0], vec![4.0, -1.0, 0.5]] {
            let pattern =
                Pattern::new(&vec![[true, false, false, false, false, false]; diagonal.len()], std::iter::empty());
            let mut values = vec![0.0; pattern.num_entries()];
            for (node, x) in diagonal.iter().enumerate() {
                pattern.add_block(&mut values, node, node, |_, _| *x);
            }
            let mut factor = Factor::analyse(&pattern).unwrap();
            let num_negative = diagonal.iter().filter(|x| **x < 0.0).count();
            assert_eq!(factor.factorise(&pattern, &values), Some(Inertia { num_negative }));
            let mut rhs = diagonal.clone();
            factor.solve(&mut rhs);
            assert_eq!(rhs, vec![1.0; diagonal.len()]);
            let product = diagonal.iter().product::<f64>().abs();
            assert!((factor.log_determinant() - product.ln()).abs() < 1e-15);
            values[0] = 0.0;
            assert_eq!(factor.factorise(&pattern, &values), None, "a pivot vanishes");
            values[0] = f64::NAN;
            assert_eq!(factor.factorise(&pattern, &values), None);
        }
    }
}
