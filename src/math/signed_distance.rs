//! Signed distance of points from the surface of a rigid body.
//!
//! ```text
//! φ(x) = ±(δ(x) − ℓ)      δ = n·(x − p) from a plane, |x − p| from a point, |x − p − a a·(x − p)| from a line
//! ```
//!
//! A body's surface is at one distance, its level ℓ, from its skeleton: a plane, a point, a line, a piece of a line. A
//! sphere is about a point, a cylinder about a line, a capsule about a piece, a plane about itself. φ is positive where
//! strands may be: outside (+) or inside (−). Its gradient is a unit vector, and its second derivative that of δ:
//!
//! ```text
//! ∇φ = ±e      ∇∇φ = ±(Q − e eᵀ)/δ      e = Q(x − p)/δ, Q = 1 about a point, 1 − a aᵀ about a line; 0 on a plane
//! ```
//!
//! Beside a piece of a line δ is the distance from the line, before and behind it that from its ends: the gradient is
//! continuous, the second derivative jumps.

use crate::math::{Mat3, Quat, Vec3};

/// What a body's surface is everywhere equally far from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Skeleton {
    /// A plane; distances from it are negative on the side that its normal leaves.
    Plane {
        /// A point on it \[L\].
        point: Vec3,
        /// Unit normal.
        normal: Vec3,
    },
    /// A point, of a sphere.
    Point {
        /// The centre \[L\].
        point: Vec3,
    },
    /// An endless straight line, of a cylinder.
    Line {
        /// A point on it \[L\].
        point: Vec3,
        /// Unit vector along it.
        axis: Vec3,
    },
    /// A straight piece that begins at a point, of a capsule.
    Piece {
        /// Where it begins \[L\].
        point: Vec3,
        /// Unit vector along it.
        axis: Vec3,
        /// Its length \[L\]; without one it has no other end.
        length: Option<f64>,
    },
}

/// The surface of a rigid body. Points are relative to [`Self::point`], so that they are as accurate far from the
/// origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    pub(crate) skeleton: Skeleton,
    /// Distance of the surface from the skeleton, ℓ \[L\].
    pub(crate) level: f64,
    /// Rounding error of [`Self::point`] \[L\]: it is at their sum.
    pub(crate) lost: Vec3,
    /// 1 where strands are outside, −1 where they are inside.
    pub(crate) sign: f64,
    /// Whether a node carries it: its point moves, and it turns about that, as the node does.
    pub(crate) carried: bool,
}

impl Skeleton {
    /// The point that others are relative to.
    pub(crate) fn point(&self) -> Vec3 {
        match self {
            Self::Plane { point, .. }
            | Self::Point { point }
            | Self::Line { point, .. }
            | Self::Piece { point, .. } => *point,
        }
    }

    /// The same with its point there, turned.
    pub(crate) fn moved(&self, there: Vec3, rotation: &Quat) -> Self {
        match self {
            Self::Plane { normal, .. } => Self::Plane { point: there, normal: rotation * normal },
            Self::Point { .. } => Self::Point { point: there },
            Self::Line { axis, .. } => Self::Line { point: there, axis: rotation * axis },
            Self::Piece { axis, length, .. } => Self::Piece { point: there, axis: rotation * axis, length: *length },
        }
    }

    /// From its point to where the line that it is a piece of leaves it, along the line \[L\]; none of others.
    pub(crate) fn ends(&self) -> impl Iterator<Item = f64> + use<> {
        let [first, last] = match self {
            Self::Piece { length, .. } => [Some(0.0), *length],
            _ => [None; 2],
        };
        first.into_iter().chain(last)
    }

    /// Whether distances from it are linear.
    pub(crate) fn is_flat(&self) -> bool {
        matches!(self, Self::Plane { .. })
    }

    /// The part of a vector that leads away from it.
    pub(crate) fn away(&self, r: &Vec3) -> Vec3 {
        match self {
            Self::Plane { normal, .. } => normal * normal.dot(r),
            Self::Point { .. } => *r,
            Self::Line { axis, .. } => r - axis * axis.dot(r),
            Self::Piece { axis, length, .. } => {
                let along = axis.dot(r).max(0.0);
                r - axis * length.map_or(along, |length| along.min(length))
            }
        }
    }

    /// δ \[L\].
    fn distance(&self, r: &Vec3) -> f64 {
        match self {
            Self::Plane { normal, .. } => normal.dot(r),
            _ => self.away(r).norm(),
        }
    }
}

impl Surface {
    pub(crate) fn point(&self) -> Vec3 {
        self.skeleton.point()
    }

    /// φ \[L\].
    pub(crate) fn distance(&self, r: &Vec3) -> f64 {
        self.sign * (self.skeleton.distance(r) - self.level)
    }

    /// ∇φ, towards where strands may be; zero on the skeleton of a curved surface, where there is none.
    pub(crate) fn normal(&self, r: &Vec3) -> Vec3 {
        match self.skeleton {
            Skeleton::Plane { normal, .. } => normal * self.sign,
            _ => self.skeleton.away(r).try_normalize(0.0).unwrap_or_default() * self.sign,
        }
    }

    /// ∇∇φ \[1/L\]; zero where there is no normal.
    pub(crate) fn curvature(&self, r: &Vec3) -> Mat3 {
        let across = match self.skeleton {
            Skeleton::Plane { .. } => return Mat3::zeros(),
            Skeleton::Point { .. } => Mat3::identity(),
            Skeleton::Piece { axis, length, .. } if !is_beside(axis.dot(r), length) => Mat3::identity(),
            Skeleton::Line { axis, .. } | Skeleton::Piece { axis, .. } => Mat3::identity() - axis * axis.transpose(),
        };
        let distance = self.skeleton.distance(r);
        if distance == 0.0 {
            return Mat3::zeros();
        }
        let e = self.normal(r);
        (across - e * e.transpose()) * (self.sign / distance)
    }

    /// Whether the places where strands may be are convex: φ is concave then, and convex otherwise.
    pub(crate) fn is_hollow(&self) -> bool {
        self.skeleton.is_flat() || self.sign < 0.0
    }

    /// A bound from below of φ in the convex hull of points \[L\].
    pub(crate) fn least_in_hull(&self, r: &[Vec3; 4]) -> f64 {
        if self.is_hollow() {
            return r.iter().map(|r| self.distance(r)).fold(f64::INFINITY, f64::min);
        }
        let middle = (r[0] + r[3]) * 0.5;
        // a distance changes by no more than a point moves
        self.distance(&middle) - r.iter().map(|r| (r - middle).norm()).fold(0.0, f64::max)
    }
}

/// Whether a place along a line is on the piece that begins at 0.
fn is_beside(along: f64, length: Option<f64>) -> bool {
    along > 0.0 && length.is_none_or(|length| along < length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surfaces() -> Vec<Surface> {
        let point = Vec3::new(0.3, -0.2, 0.5);
        let axis = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        let piece = |axis, length| Skeleton::Piece { point, axis, length };
        let skeletons = [
            Skeleton::Plane { point, normal: axis },
            Skeleton::Point { point },
            Skeleton::Line { point, axis },
            piece(axis, None),
            piece(-axis, None),
            piece(axis, Some(0.2)),
            piece(-axis, Some(0.1)),
        ];
        let sides = |skeleton| {
            [1.0, -1.0].map(|sign| Surface { skeleton, level: 0.8, lost: Vec3::zeros(), sign, carried: false })
        };
        skeletons.into_iter().flat_map(sides).collect()
    }

    #[test]
    fn gradient_and_curvature_match_finite_differences() {
        let at = Vec3::new(0.9, 0.4, -0.6);
        let h = 1e-5;
        for surface in surfaces() {
            let slope = Vec3::from_fn(|k, _| {
                let e = Vec3::ith(k, h);
                (surface.distance(&(at + e)) - surface.distance(&(at - e))) / (2.0 * h)
            });
            assert!((slope - surface.normal(&at)).norm() < 1e-9, "{surface:?}");
            assert!((surface.normal(&at).norm() - 1.0).abs() < 1e-15);
            for k in 0..3 {
                let e = Vec3::ith(k, h);
                let change = (surface.normal(&(at + e)) - surface.normal(&(at - e))) / (2.0 * h);
                assert!((change - surface.curvature(&at).column(k)).norm() < 1e-9, "{surface:?}");
            }
        }
    }

    /// The surface is where it is said to be, and no point of a hull is nearer than its bound.
    #[test]
    fn hulls_are_no_nearer_than_their_bound() {
        let hull = [[0.9, 0.4, -0.7], [1.4, 0.1, 0.3], [0.2, 1.9, 0.4], [-0.5, -0.3, 1.0]].map(Vec3::from);
        for surface in surfaces() {
            let foot = hull[0] - surface.normal(&hull[0]) * surface.distance(&hull[0]);
            assert!(surface.distance(&foot).abs() < 1e-15);
            let least = surface.least_in_hull(&hull);
            for k in 0..1000 {
                let weights = [0, 1, 2, 3].map(|m| f64::from((k * (7 + m * m)) % (11 + m)) + 1e-3);
                let sum: f64 = weights.iter().sum();
                let point: Vec3 = hull.iter().zip(weights).map(|(r, w)| r * (w / sum)).sum();
                assert!(surface.distance(&point) >= least - 1e-15, "{surface:?}");
            }
        }
    }
}
