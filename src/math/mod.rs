//! Small mathematics shared by all layers: vectors, quaternions, shape functions, quadrature, Bernstein and Chebyshev
//! polynomials, minimisation, disjoint sets, threads, directions, topology of closed curves.

pub(crate) mod bernstein;
pub(crate) mod chebyshev;
pub(crate) mod direction;
pub(crate) mod groups;
pub(crate) mod handles;
pub mod link;
pub(crate) mod minimise;
pub(crate) mod parallel;
pub(crate) mod quadrature;
pub(crate) mod quaternion;
#[cfg(test)]
pub(crate) mod random;
pub(crate) mod screw;
pub(crate) mod shape_functions;
pub(crate) mod signed_distance;
pub(crate) mod two_sum;

/// Largest coordinate, radius or reach accepted, because products of three lengths must stay finite. (Squares of edges
/// overflowed for a polyline with a point at 1.8e308: a site 1.2 beyond the range was found.)
pub(crate) const LARGEST: f64 = 1e100;

/// Vector of ℝ³.
pub type Vec3 = nalgebra::Vector3<f64>;
/// 3×3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// Unit quaternion, a rotation of ℝ³.
pub type Quat = nalgebra::UnitQuaternion<f64>;
