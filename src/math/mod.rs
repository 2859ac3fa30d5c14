//! Small mathematics shared by all layers: vectors, quaternions, shape functions, quadrature, Bernstein and Chebyshev
//! polynomials, minimisation, groups, topology of closed curves.

pub mod bernstein;
pub(crate) mod chebyshev;
pub(crate) mod groups;
pub mod link;
pub mod minimise;
pub mod quadrature;
pub mod quaternion;
#[cfg(test)]
#[path = "../../tests/common/random.rs"] // one generator for unit tests and tests of the public interface
pub(crate) mod random;
pub mod shape_functions;
pub(crate) mod two_sum;

/// Vector of ℝ³.
pub type Vec3 = nalgebra::Vector3<f64>;
/// 3×3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// Unit quaternion, a rotation of ℝ³.
pub type Quat = nalgebra::UnitQuaternion<f64>;
