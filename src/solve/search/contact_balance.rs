//! Whether contact forces have found their places with the last step of a search.

use crate::solve::measures::{FINE, SAME};
use crate::solve::problem::assembly::Residual;
use crate::solve::problem::engine::Engine;

/// Largest change of a contact force relative to the largest before; 0 if none changes.
pub(super) fn relative_change(before: &Residual, after: &Residual) -> f64 {
    let both = before.contact_forces().zip(after.contact_forces());
    let change = both.fold(0.0f64, |a, (x, y)| a.max((x - y).abs()));
    if change == 0.0 { 0.0 } else { change / largest_contact_force(before) }
}

/// \[F\].
pub(super) fn largest_contact_force(residual: &Residual) -> f64 {
    residual.contact_forces().fold(0.0f64, |a, b| a.max(b.abs()))
}

/// Whether a step is far below the tolerance of increments, and contact forces bend no rod: forces of strands that touch
/// without load are rounding, and never converge.
pub(super) fn is_light(engine: &Engine, residual: &Residual, size: f64, tol_increment: f64) -> bool {
    // rotations that the largest contact force causes, F L²/B
    let bends = largest_contact_force(residual) * engine.scales.length.powi(2) / engine.scales.bending;
    size <= SAME * tol_increment && bends <= FINE
}
