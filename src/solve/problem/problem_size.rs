//! Size of a problem: unknowns, entries of its matrices, contact segments. A scene has only those that it needs.

use crate::error::SolveError;
use crate::memory::{GIB, available};
use crate::solve::problem::engine::Engine;
use crate::sparse::Factor;

/// Sizes of a problem in its present state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProblemSize {
    /// Nodes of all rods.
    pub nodes: usize,
    /// Unknowns that are solved for: six a free node, three in a planar model.
    pub unknowns: usize,
    /// Stored entries of the tangent (one triangle), 12 bytes each.
    pub tangent_entries: usize,
    /// Stored entries of its factor, 8 bytes each.
    pub factor_entries: usize,
    /// Segments that take part in contact; 0 without contact, and then there is no tree and no list either.
    pub contact_segments: usize,
    /// Candidate pairs of segments.
    pub candidates: usize,
    /// Strains kept of the natural state, six numbers each; 0 for rods that are uniform by nature.
    pub natural_strains: usize,
}

/// Memory that a pair of segments adds to the matrices, bytes: each couples two nodes that no other does, by a block of
/// 6 × 6 numbers, 3 × 3 in the plane. The tangent has 12 bytes a number, its factor 8.
const BYTES_A_PAIR: [f64; 2] = [36.0 * 20.0, 9.0 * 20.0];

impl Engine {
    /// Refuses candidates of contact whose part of the matrices needs more memory than there is.
    pub(crate) fn check_memory(&self) -> Result<(), SolveError> {
        let pairs = self.contact.broad_phase.pairs().len();
        let needed = pairs as f64 * BYTES_A_PAIR[usize::from(self.model.planar)];
        let short = available().filter(|available| needed > *available);
        short.map_or(Ok(()), |available| {
            Err(SolveError::Memory { pairs, needed: needed / GIB, available: available / GIB })
        })
    }

    /// Sizes of the problem with the candidates of the present state; analyses the pattern anew, which takes about as
    /// long as a Newton iteration.
    ///
    /// # Errors
    /// Contact geometry that breaks down, a factorisation that does not fit into memory.
    pub fn problem_size(&mut self) -> Result<ProblemSize, SolveError> {
        let state = self.state.clone();
        self.update_contact(&state)?;
        let (pattern, factor) = Factor::of(self.node_graph())?;
        Ok(ProblemSize {
            nodes: self.num_nodes(),
            unknowns: pattern.num_equations(),
            tangent_entries: pattern.num_entries(),
            factor_entries: factor.num_values(),
            contact_segments: self.contact.nodes.len(),
            candidates: self.contact.broad_phase.pairs().len(),
            natural_strains: self.reference.iter().map(|reference| reference.num_stored()).sum(),
        })
    }
}
