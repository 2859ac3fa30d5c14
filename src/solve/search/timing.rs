//! Times of the parts of searches.

use std::time::Duration;

/// The clock; the standard library has none in the browser and panics.
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub(in crate::solve) use std::time::Instant;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub(in crate::solve) use web_time::Instant;

/// Work of searches so far and time on the clock spent in their parts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Timings {
    /// Newton iterations × nodes of the mesh each was made on, those on shorter rods and coarser meshes included.
    pub node_iterations: usize,
    /// Moving contact curves, turning bounds, candidate pairs, the step bound.
    pub detection: Duration,
    /// Elements and contact terms: gradients and tangents.
    pub assembly: Duration,
    /// Sparsity pattern, ordering and symbolic analysis.
    pub symbolic: Duration,
    /// Numeric factorisation.
    pub factor: Duration,
    /// Solves with it.
    pub solve: Duration,
}

impl Timings {
    /// Sum of the times of all parts.
    #[must_use]
    pub fn total(&self) -> Duration {
        self.detection + self.assembly + self.symbolic + self.factor + self.solve
    }
}

impl std::ops::AddAssign for Timings {
    fn add_assign(&mut self, other: Self) {
        self.node_iterations += other.node_iterations;
        self.detection += other.detection;
        self.assembly += other.assembly;
        self.symbolic += other.symbolic;
        self.factor += other.factor;
        self.solve += other.solve;
    }
}

/// Runs and adds the time it took.
pub(crate) fn timed<R>(sum: &mut Duration, work: impl FnOnce() -> R) -> R {
    let started = Instant::now();
    let result = work();
    *sum += started.elapsed();
    result
}
