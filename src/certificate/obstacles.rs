//! Distances from obstacles and normals of them: points are carried back to where the obstacle was at the start.

use std::f64::consts::TAU;

use crate::math::Vec3;
use crate::scene::{Hinge, Obstacle, ObstaclePose, Side, Skeleton};

/// A vector turned about the axis of a hinge by some turns (Rodrigues).
fn turned(hinge: &Hinge, r: &Vec3, turns: f64) -> Vec3 {
    let ((sin, cos), a) = ((turns * TAU).sin_cos(), hinge.axis / hinge.axis.norm());
    r * cos + a.cross(r) * sin + a * (a.dot(r) * (1.0 - cos))
}

/// For a point its distance from the surface of an obstacle, on its rods' side \[L\], and the direction in which that grows.
pub(super) fn at_obstacle(obstacle: &Obstacle, placement: &ObstaclePose) -> impl Fn(&Vec3) -> (f64, Vec3) {
    let (skeleton, side) = (obstacle.skeleton, obstacle.side);
    let ObstaclePose { level, displacement, turns } = *placement;
    let hinge = obstacle.hinge.filter(|_| turns != 0.0);
    move |x: &Vec3| {
        let still = x - displacement;
        let back = hinge.map_or(still, |hinge| hinge.through + turned(&hinge, &(still - hinge.through), -turns));
        let (from_skeleton, away) = match skeleton {
            Skeleton::Plane { point, normal } => (normal.dot(&(back - point)), normal),
            Skeleton::Point { point } => ((back - point).norm(), back - point),
            Skeleton::Line { point, axis } => {
                let across = axis.cross(&(back - point)).cross(&axis) / axis.norm_squared();
                (across.norm(), across)
            }
        };
        let away = hinge.map_or(away, |hinge| turned(&hinge, &away, turns)).normalize();
        if side == Side::Outside { (from_skeleton - level, away) } else { (level - from_skeleton, -away) }
    }
}
