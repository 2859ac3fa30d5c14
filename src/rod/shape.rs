//! Shapes a rod starts from, each sampled at equally spaced reference arc lengths with frames.

use crate::error::InputError;
use crate::math::{Quat, Vec3};

/// A start shape. Frames are twist-free (parallel transport along the curve).
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Straight from `start` along `direction`.
    Line {
        /// First point \[L\].
        start: Vec3,
        /// Direction (need not be unit).
        direction: Vec3,
        /// Length \[L\].
        length: f64,
    },
    /// Circle about `center` in the plane normal to `normal`; for closed rods.
    Circle {
        /// Circumference \[L\].
        length: f64,
        /// Centre \[L\].
        center: Vec3,
        /// Normal (need not be unit); the curve runs counter-clockwise about it.
        normal: Vec3,
    },
    /// Arc of a circle from `start` with initial tangent `tangent`, turning towards `towards`.
    Arc {
        /// First point \[L\].
        start: Vec3,
        /// Tangent at the first point.
        tangent: Vec3,
        /// Direction of the centre of curvature at the first point (made orthogonal to the tangent).
        towards: Vec3,
        /// Radius \[L\].
        radius: f64,
        /// Opening angle, rad.
        angle: f64,
    },
    /// Helix about the axis through `center` along `axis`.
    Helix {
        /// Point on the axis at the start \[L\].
        center: Vec3,
        /// Axis (need not be unit).
        axis: Vec3,
        /// Radius \[L\].
        radius: f64,
        /// Advance along the axis per turn \[L\]; negative for a left-handed helix.
        pitch: f64,
        /// Number of turns.
        turns: f64,
    },
    /// A curve through the user's points (C² spline, resampled by arc length).
    Points(Vec<Vec3>),
}

/// A shape sampled for a rod: reference length and nodes at equal reference arc lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Reference length \[L\].
    pub length: f64,
    /// Node positions \[L\]; `num_segments + 1` for open rods, `num_segments` for closed ones.
    pub positions: Vec<Vec3>,
    /// Node frames, d3 = tangent, twist-free from the first node on.
    pub frames: Vec<Quat>,
}

impl Shape {
    /// Samples the shape at `num_segments + 1` (open) or `num_segments` (closed) equally spaced nodes.
    ///
    /// # Errors
    /// Non-finite or non-positive sizes, zero directions, too few or repeated points, an open shape asked to be closed
    /// or the other way round.
    pub fn place(&self, closed: bool, num_segments: usize) -> Result<Placement, InputError> {
        let _ = (closed, num_segments);
        Err(InputError::Inconsistent { field: "shape".into(), reason: "not written yet".into() })
    }
}
