//! Unit vectors: normals and parallel transport.

use crate::math::Vec3;

/// Some unit vector normal to the unit vector `t`; zero if `t` is not finite.
pub(crate) fn any_normal(t: Vec3) -> Vec3 {
    let axis = Vec3::ith(t.iamin(), 1.0);
    (axis - t * t.dot(&axis)).try_normalize(0.0).unwrap_or_default()
}

/// Rotates `v` (normal to the unit vector `from`) with the smallest rotation that takes `from` to the unit vector `to`.
pub(crate) fn transport(v: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let c = 1.0 + from.dot(&to);
    if c <= f64::EPSILON { v } else { v - (from + to) * (to.dot(&v) / c) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transport_keeps_length_and_normality() {
        let (from, to) = (Vec3::new(1.0, 2.0, 2.0) / 3.0, Vec3::new(2.0, -1.0, 2.0) / 3.0);
        let v = any_normal(from);
        let moved = transport(v, from, to);
        assert!((moved.norm() - 1.0).abs() < 1e-15 && moved.dot(&to).abs() < 1e-15);
        assert_eq!(transport(v, from, -from), v);
    }
}
