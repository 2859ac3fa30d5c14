//! Screws: motions of a body with a constant velocity and a constant rotation vector, the exponential map of SE(3).

use super::Vec3;

/// Angle, rad, below which the series of the screw replaces its closed form, because their difference is rounding.
const SMALL_ANGLE: f64 = 1e-4;

/// Displacement in time 1 of a point with an initial velocity v on the screw motion of a rotation vector θ: (1 + (1 −
/// cos θ)/θ² [θ] + (θ − sin θ)/θ³ [θ]²) v.
pub(crate) fn screw(rotation: &Vec3, velocity: &Vec3) -> Vec3 {
    let angle = rotation.norm();
    let once = rotation.cross(velocity);
    let twice = rotation.cross(&once);
    let (a, b) = match angle < SMALL_ANGLE {
        true => (0.5 - angle.powi(2) / 24.0, 1.0 / 6.0 - angle.powi(2) / 120.0),
        // 1 − cos θ without cancellation
        false => (2.0 * (0.5 * angle).sin().powi(2) / angle.powi(2), (angle - angle.sin()) / angle.powi(3)),
    };
    velocity + once * a + twice * b
}

/// The inverse of [`screw`]: (1 − ½ [θ] + (1 − ½ θ cot ½θ)/θ² [θ]²) u.
pub(crate) fn unscrew(rotation: &Vec3, displacement: &Vec3) -> Vec3 {
    let angle = rotation.norm();
    let once = rotation.cross(displacement);
    let twice = rotation.cross(&once);
    let b = match angle < SMALL_ANGLE {
        true => 1.0 / 12.0 + angle.powi(2) / 720.0,
        false => (1.0 - 0.5 * angle / (0.5 * angle).tan()) / angle.powi(2),
    };
    displacement - once * 0.5 + twice * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn screws_of_small_angles_are_those_of_the_series() {
        let (v, axis) = (Vec3::new(0.3, 1.0, -2.0), Vec3::new(1.0, 2.0, 2.0) / 3.0);
        for angle in [0.0, 1e-9, 0.99e-4, 1.01e-4, 1e-2, 1.0, 3.1] {
            let there = screw(&(axis * angle), &v);
            assert!((unscrew(&(axis * angle), &there) - v).norm() < 1e-12, "{angle}");
        }
    }
}
