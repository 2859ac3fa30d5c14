//! Small mathematics shared by all layers: vectors, quaternions, shape functions, quadrature, Bernstein and Chebyshev
//! polynomials, minimisation, topology of closed curves.

pub mod bernstein;
pub(crate) mod chebyshev;
pub mod link;
pub mod minimise;
pub mod quadrature;
pub mod quaternion;
pub mod shape_functions;

/// Vector of ℝ³.
pub type Vec3 = nalgebra::Vector3<f64>;
/// 3×3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// Unit quaternion, a rotation of ℝ³.
pub type Quat = nalgebra::UnitQuaternion<f64>;
