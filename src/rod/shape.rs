//! Start shapes of rods, sampled at equally spaced reference arc lengths with frames.

mod plectoneme;
mod sampler;
mod spline;
mod torus;

use std::f64::consts::TAU;

use crate::error::InputError;
use crate::math::{Mat3, Quat, Vec3};

use spline::Spline;

pub use plectoneme::{Axis, Plectoneme, superhelix_angle};
pub use torus::TorusKnot;

/// A start shape. Frames are twist-free: parallel transport along the continuous curve, exact to rounding.
///
/// Directions of the first frame (d2 = d3 × d1 always):
///  * line, points, plectoneme, torus knot: d1 is the part of global z normal to the tangent (of global x where the
///    tangent is within 1e-3 rad of z);
///  * circle, arc, helix: d1 is the binormal, so that K1 is the curvature at the start (everywhere, on circle and arc).
///
/// On curves in the x-y plane d1 is therefore normal to the plane, and EI1 is the bending stiffness in the plane.
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
    ///
    /// It starts on the side of +x of the centre (of +y where `normal` is within 1e-3 rad of x).
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
        /// Opening angle, rad; at most 2π.
        angle: f64,
    },
    /// Helix about the axis through `center` along `axis`; starts on the same side as [`Shape::Circle`].
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
    /// A curve through the user's points \[L\]: C² cubic spline over chord length (natural ends, or periodic if
    /// closed), resampled by arc length. Closed rods: do not repeat the first point at the end.
    Points(Vec<Vec3>),
    /// Two strands wound about each other; for closed rods.
    Plectoneme(Plectoneme),
    /// A torus knot; for closed rods.
    TorusKnot(TorusKnot),
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
    /// Whether the last node is joined to the first.
    pub closed: bool,
}

/// Most node segments of a rod, because sparse matrices over more nodes exceed 32-bit indices.
pub const MAX_SEGMENTS: usize = 10_000_000;

impl Placement {
    /// Samples `curve`, which gives position, d1 and d3 at the fraction s/L of the length.
    fn sample(closed: bool, num_segments: usize, length: f64, curve: impl Fn(f64) -> [Vec3; 3]) -> Self {
        let num_nodes = num_segments + usize::from(!closed);
        let samples = (0..num_nodes).map(|i| curve(i as f64 / num_segments as f64));
        let (positions, frames) = samples.map(|[position, d1, d3]| (position, frame(&d1, &d3))).unzip();
        Self { length, positions, frames, closed }
    }
}

impl Shape {
    /// Samples the shape at `num_segments + 1` (open) or `num_segments` (closed) equally spaced nodes.
    ///
    /// ```
    /// use supercoil::math::Vec3;
    /// use supercoil::rod::Shape;
    /// let circle = Shape::Circle { length: 6.0, center: Vec3::zeros(), normal: Vec3::z() };
    /// let placement = circle.place(true, 12)?;
    /// assert_eq!((placement.positions.len(), placement.length), (12, 6.0));
    /// // an open rod cannot be a circle
    /// assert!(circle.place(false, 12).is_err());
    /// # Ok::<(), supercoil::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Non-finite or non-positive sizes, zero directions, too few or repeated points, a closed rod of an open shape or
    /// the reverse.
    pub fn place(&self, closed: bool, num_segments: usize) -> Result<Placement, InputError> {
        if num_segments == 0 {
            return Err(InputError::Count { field: "elements".into(), value: 0, allowed: "at least 1" });
        }
        if num_segments > MAX_SEGMENTS {
            let allowed = "such that the rod has at most ten million nodes";
            return Err(InputError::Count { field: "elements".into(), value: num_segments, allowed });
        }
        self.check_closed(closed)?;
        match self {
            Self::Line { start, direction, length } => line(*start, direction, *length, num_segments),
            Self::Circle { length, center, normal } => circle(*length, *center, normal, num_segments),
            Self::Arc { start, tangent, towards, radius, angle } => {
                let curve = arc(*start, tangent, towards, *radius, *angle)?;
                Ok(Placement::sample(false, num_segments, radius * angle, curve))
            }
            Self::Helix { center, axis, radius, pitch, turns } => {
                let (length, curve) = helix(*center, axis, *radius, *pitch, *turns)?;
                Ok(Placement::sample(false, num_segments, length, curve))
            }
            Self::Points(points) => Spline::new(points, closed)?.place(num_segments),
            Self::Plectoneme(plectoneme) => plectoneme.place(num_segments),
            Self::TorusKnot(knot) => knot.place(num_segments),
        }
    }

    /// K1, K2, K3 \[1/L\] in the frames of [`Shape::place`], if they are uniform.
    pub(crate) fn uniform_curvature(&self) -> Option<[f64; 3]> {
        match self {
            Self::Circle { length, .. } => Some([TAU / length, 0.0, 0.0]),
            Self::Arc { radius, .. } => Some([1.0 / radius, 0.0, 0.0]),
            _ => None,
        }
    }

    fn check_closed(&self, closed: bool) -> Result<(), InputError> {
        let reason = match (self, closed) {
            (Self::Line { .. }, true) => "a line is open: use a circle or points for a closed rod",
            (Self::Arc { .. }, true) => "an arc is open: use a circle or points for a closed rod",
            (Self::Helix { .. }, true) => "a helix is open: use a circle or points for a closed rod",
            (Self::Circle { .. }, false) => "a circle is closed: set closed = true, or use an arc for an open rod",
            (Self::Plectoneme(_), false) => "a plectoneme is closed: set closed = true",
            (Self::TorusKnot(_), false) => "a torus knot is closed: set closed = true",
            _ => return Ok(()),
        };
        Err(InputError::Inconsistent { field: "shape".into(), reason: reason.into() })
    }
}

fn line(start: Vec3, direction: &Vec3, length: f64, num_segments: usize) -> Result<Placement, InputError> {
    finite("shape.start", &start)?;
    let d3 = unit("shape.direction", direction)?;
    InputError::positive("shape.length", length)?;
    let d1 = normal_to(&d3, &Vec3::z(), &Vec3::x());
    Ok(Placement::sample(false, num_segments, length, |t| [start + d3 * (t * length), d1, d3]))
}

fn circle(length: f64, center: Vec3, normal: &Vec3, num_segments: usize) -> Result<Placement, InputError> {
    InputError::positive("shape.length", length)?;
    finite("shape.center", &center)?;
    let normal = unit("shape.normal", normal)?;
    let side = normal_to(&normal, &Vec3::x(), &Vec3::y());
    let ahead = normal.cross(&side);
    Ok(Placement::sample(true, num_segments, length, |t| {
        let (sin, cos) = (TAU * t).sin_cos();
        [center + (side * cos + ahead * sin) * (length / TAU), normal, ahead * cos - side * sin]
    }))
}

/// Position, d1 and d3 of an arc at a fraction of its length.
fn arc(
    start: Vec3,
    tangent: &Vec3,
    towards: &Vec3,
    radius: f64,
    angle: f64,
) -> Result<impl Fn(f64) -> [Vec3; 3] + use<>, InputError> {
    finite("shape.start", &start)?;
    let tangent = unit("shape.tangent", tangent)?;
    let inward = unit("shape.towards", towards)?;
    let inward = inward - tangent * tangent.dot(&inward);
    if inward.norm() < 1e-6 {
        let allowed = "a direction that is not parallel to the tangent";
        return Err(InputError::Vector { field: "shape.towards".into(), value: (*towards).into(), allowed });
    }
    let inward = inward.normalize();
    InputError::positive("shape.radius", radius)?;
    InputError::check("shape.angle", angle, angle > 0.0 && angle <= TAU, "greater than 0 and at most 2π (radians)")?;
    let normal = tangent.cross(&inward);
    Ok(move |t: f64| {
        let (sin, cos) = (angle * t).sin_cos();
        let versine = 2.0 * (0.5 * angle * t).sin().powi(2);
        [start + (tangent * sin + inward * versine) * radius, normal, tangent * cos + inward * sin]
    })
}

/// Length of a helix; position, d1 and d3 at a fraction of it.
///
/// The Frenet frame of a helix rotates about d3 by its torsion τ per length; rotation by −τ s makes it twist-free.
fn helix(
    center: Vec3,
    axis: &Vec3,
    radius: f64,
    pitch: f64,
    turns: f64,
) -> Result<(f64, impl Fn(f64) -> [Vec3; 3] + use<>), InputError> {
    finite("shape.center", &center)?;
    let axis = unit("shape.axis", axis)?;
    InputError::positive("shape.radius", radius)?;
    InputError::check("shape.pitch", pitch, true, "a finite number")?;
    InputError::positive("shape.turns", turns)?;
    let side = normal_to(&axis, &Vec3::x(), &Vec3::y());
    let ahead = axis.cross(&side);
    let rise = pitch / TAU;
    let rate = radius.hypot(rise);
    let angle = TAU * turns;
    let torsion_per_angle = rise / rate;
    let curve = move |t: f64| {
        let theta = angle * t;
        let (sin, cos) = theta.sin_cos();
        let (outward, around) = (side * cos + ahead * sin, ahead * cos - side * sin);
        let tangent = (around * radius + axis * rise) / rate;
        let binormal = (axis * radius - around * rise) / rate;
        let (turn_sin, turn_cos) = (torsion_per_angle * theta).sin_cos();
        // −τs about the tangent: binormal towards the principal normal −outward.
        let d1 = binormal * turn_cos - outward * turn_sin;
        [center + outward * radius + axis * (rise * theta), d1, tangent]
    };
    Ok((angle * rate, curve))
}

/// Frame with the given d3 (unit) and d1 (made exactly normal to d3).
fn frame(d1: &Vec3, d3: &Vec3) -> Quat {
    let d3 = d3.normalize();
    let d1 = (d1 - d3 * d3.dot(d1)).normalize();
    let axes = Mat3::from_columns(&[d1, d3.cross(&d1), d3]);
    Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes))
}

/// Unit vector along the part of `first` normal to `tangent`, or of `second` where `first` is within 1e-3 of it.
fn normal_to(tangent: &Vec3, first: &Vec3, second: &Vec3) -> Vec3 {
    let part = |v: &Vec3| v - tangent * tangent.dot(v);
    let candidate = part(first);
    if candidate.norm() > 1e-3 { candidate.normalize() } else { part(second).normalize() }
}

fn finite(field: &str, value: &Vec3) -> Result<(), InputError> {
    if value.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(InputError::Vector { field: field.into(), value: (*value).into(), allowed: "three finite numbers" })
}

/// `direction` scaled to unit length, whatever its size (from 1e-300 to 1e300).
fn unit(field: &str, direction: &Vec3) -> Result<Vec3, InputError> {
    let size = direction.amax();
    if direction.iter().all(|x| x.is_finite()) && size > 0.0 {
        return Ok((direction / size).normalize());
    }
    Err(InputError::Vector { field: field.into(), value: (*direction).into(), allowed: "finite and not zero" })
}

#[cfg(test)]
mod tests;
