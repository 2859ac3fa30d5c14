//! Quaternions as plain arrays (w, x, y, z) for the element kernels. Products follow Hamilton.

use std::f64::consts::TAU;

use nalgebra::Rotation3;

use crate::math::{Mat3, Quat, Vec3};

/// A quaternion (w, x, y, z), not necessarily of unit length.
pub type Q = [f64; 4];

/// Hamilton product a b.
#[inline]
pub fn mul(a: &Q, b: &Q) -> Q {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// Inner product of ℝ⁴.
#[inline]
pub fn dot(a: &Q, b: &Q) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// q e1.
#[inline]
pub fn mul_e1(q: &Q) -> Q {
    [-q[1], q[0], q[3], -q[2]]
}

/// q e2.
#[inline]
pub fn mul_e2(q: &Q) -> Q {
    [-q[2], -q[3], q[0], q[1]]
}

/// q e3.
#[inline]
pub fn mul_e3(q: &Q) -> Q {
    [-q[3], q[2], -q[1], q[0]]
}

/// q (n1 e1 + n2 e2 + n3 e3).
#[inline]
pub fn mul_pure(q: &Q, n: &[f64; 3]) -> Q {
    mul(q, &[0.0, n[0], n[1], n[2]])
}

/// (v1 e1 + v2 e2 + v3 e3) q.
#[inline]
pub fn pure_mul(v: &[f64; 3], q: &Q) -> Q {
    mul(&[0.0, v[0], v[1], v[2]], q)
}

/// As an array.
#[inline]
pub fn to_array(q: &Quat) -> Q {
    [q.w, q.i, q.j, q.k]
}

/// The rotation vector about a unit axis, of an angle in rad and whole turns more, that is nearest to another vector.
pub fn nearest_turn(axis: &Vec3, angle: f64, to: &Vec3) -> Vec3 {
    axis * (angle + TAU * ((to.dot(axis) - angle) / TAU).round())
}

/// The rotation vector, rad, of a rotation and whole turns more, that is nearest to another vector.
pub fn rotation_vector(rotation: &Quat, to: &Vec3) -> Vec3 {
    match rotation.axis_angle() {
        Some((axis, angle)) => nearest_turn(&axis, angle, to),
        None => to.try_normalize(0.0).map_or(*to, |axis| nearest_turn(&axis, 0.0, to)),
    }
}

/// The rotation R for which the sum of b · R a is largest, from the sum of b aᵀ; `None` if there is none.
pub fn rotation_of(spread: &Mat3) -> Option<Quat> {
    // three numbers take a few iterations each; without a limit there is no end for some
    let svd = spread.try_svd(true, true, f64::EPSILON, 100)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mirror = Mat3::from_diagonal(&Vec3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    let rotation = Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(u * mirror * v_t));
    rotation.coords.iter().all(|x| x.is_finite()).then_some(rotation)
}

/// Rotation by the rotation vector `theta` (rad).
#[inline]
pub fn exp(theta: &Vec3) -> Quat {
    Quat::from_scaled_axis(*theta)
}

/// Rotation about d3 by `angle` (rad), to be multiplied from the right.
pub fn spin(angle: f64) -> Quat {
    let (s, c) = (0.5 * angle).sin_cos();
    Quat::new_unchecked(nalgebra::Quaternion::new(c, 0.0, 0.0, s))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn products_with_units_agree_with_the_general_product() {
        let q = [0.3, -0.7, 0.2, 1.1];
        assert_eq!(mul_e1(&q), mul(&q, &[0.0, 1.0, 0.0, 0.0]));
        assert_eq!(mul_e2(&q), mul(&q, &[0.0, 0.0, 1.0, 0.0]));
        assert_eq!(mul_e3(&q), mul(&q, &[0.0, 0.0, 0.0, 1.0]));
        let nalgebra_product =
            nalgebra::Quaternion::new(0.3, -0.7, 0.2, 1.1) * nalgebra::Quaternion::new(0.5, 1.0, -2.0, 0.25);
        let ours = mul(&q, &[0.5, 1.0, -2.0, 0.25]);
        assert_eq!(ours, [nalgebra_product.w, nalgebra_product.i, nalgebra_product.j, nalgebra_product.k]);
    }

    /// Of all angles, half a turn among them; also of an unequal spread, and of points in a plane.
    #[test]
    fn rotations_are_found_from_spreads() {
        for axis in [Vec3::x(), Vec3::z(), Vec3::new(1.0, 2.0, 2.0) / 3.0, Vec3::new(0.6, 0.0, -0.8)] {
            for angle in [0.0, 1e-9, 1.0, 3.0, PI, PI - 1e-9] {
                let turn = exp(&(axis * angle));
                for stretch in [Vec3::new(1.0, 1.0, 1.0), Vec3::new(2.0, 1e-3, 1.0), Vec3::new(1.0, 0.0, 0.5)] {
                    let spread = turn.to_rotation_matrix().matrix() * Mat3::from_diagonal(&stretch);
                    let off = rotation_of(&spread).unwrap().angle_to(&turn);
                    assert!(off < 1e-7, "{axis:?} {angle} {stretch:?}: {off:e}");
                }
            }
        }
        assert_eq!(rotation_of(&Mat3::from_element(f64::NAN)), None);
    }

    #[test]
    fn rotation_vectors_go_on_from_others() {
        let turn = exp(&(Vec3::z() * 1.0));
        assert!((rotation_vector(&turn, &(Vec3::z() * 7.0)) - Vec3::z() * (1.0 + TAU)).norm() < 1e-12);
        assert!((rotation_vector(&turn, &(Vec3::z() * -5.0)) - Vec3::z() * (1.0 - TAU)).norm() < 1e-12);
        let none = Quat::identity();
        assert!((rotation_vector(&none, &(Vec3::x() * 6.0)) - Vec3::x() * TAU).norm() < 1e-12);
        assert_eq!(rotation_vector(&none, &Vec3::zeros()), Vec3::zeros());
    }
}
