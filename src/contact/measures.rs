//! Measures that several folders share: roundings, the same, the end of a search for a foot, the size of pieces of
//! work.

/// Relative rounding of sums of up to twenty products of control points, distances and their squares among them,
/// because forty roundings of 2⁻⁵³ are a third of it. Bounds of steps contain it: with 1e-13 the beam beside a clamp
/// takes 641 iterations for 618.
pub(in crate::contact) const SUM_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Sizes \[L\] and their squares that are computed with as they are; others are scaled first, or the pair is kept.
/// Fourth powers of these sizes, times the square of a small angle, are normal numbers, because f64 reaches to 1e-308.
pub(in crate::contact) const USUAL: std::ops::Range<f64> = 1e-60..1e60;
/// Distance, over a size, and angle, rad, up to which two points or two directions count as one, because coordinates
/// far from the origin, and points where the distance is flat, are rounded by as much.
pub(in crate::contact) const COINCIDENT: f64 = 1e-6;
/// Angle of two tangents, rad, up to which a joint is smooth, rounding of the coordinates added, because shapes
/// computed in f64 have joints with less.
pub(in crate::contact) const SMOOTH: f64 = 1e-12;
/// Newton step, of a segment's parameter, after which a foot is found, because the remaining error is its square.
pub(in crate::contact) const LAST_STEP: f64 = 1e-9;
/// Newton steps for a foot, at most, because a search that needs more does not converge: bisection goes on, or the
/// general method.
pub(in crate::contact) const MAX_STEPS: usize = 16;
/// Points of the Gauss rule on each part of a zone, because the energy of a part is a square of a cubic where strands
/// are straight, and degree 9 contains it.
pub(in crate::contact) const POINTS_PER_PART: usize = 5;
/// Parts of a zone, at most, because parts are as long as strands are thick, and segments of slender curves may be of
/// any length.
pub(in crate::contact) const MAX_PARTS: f64 = 64.0;
