//! Distances from obstacles and normals of them: points are carried back to where the obstacle was at the start, and
//! turned back with the frame of a node that carries it.

use std::f64::consts::TAU;

use super::{Subject, first_nodes};
use crate::math::{Quat, Vec3};
use crate::scene::{Hinge, ObstaclePose, Side, Skeleton};

/// A vector turned about the axis of a hinge by some turns (Rodrigues).
fn turned(hinge: &Hinge, r: &Vec3, turns: f64) -> Vec3 {
    let ((sin, cos), a) = ((turns * TAU).sin_cos(), hinge.axis / hinge.axis.norm());
    r * cos + a.cross(r) * sin + a * (a.dot(r) * (1.0 - cos))
}

/// For a point its distance from the surface of an obstacle, on its rods' side \[L\], and the direction in which that
/// grows.
pub(super) fn at_obstacle(subject: &Subject, index: usize) -> impl Fn(&Vec3) -> (f64, Vec3) {
    let (model, state) = (subject.model, subject.state);
    let obstacle = &model.obstacles[index];
    let (skeleton, side) = (obstacle.skeleton, obstacle.side);
    let ObstaclePose { level, displacement, turns, .. } = state.placements()[index];
    let hinge = obstacle.hinge.filter(|_| turns != 0.0);
    // where the node was and is
    let carrier = obstacle.carrier.map(|at| {
        let (rod, node) = (&model.rods[at.rod], first_nodes(model)[at.rod] + at.node);
        let place = state.positions()[node] + state.remainders()[node];
        ([rod.positions[at.node], place], rod.frames[at.node] * state.frames()[node].inverse())
    });
    move |x: &Vec3| {
        let carried_back = |([then, now], turn): ([Vec3; 2], Quat)| then + turn * (x - now);
        let still = carrier.map_or_else(|| x - displacement, carried_back);
        let back = hinge.map_or(still, |hinge| hinge.through + turned(&hinge, &(still - hinge.through), -turns));
        let (from_skeleton, away) = match skeleton {
            Skeleton::Plane { point, normal } => (normal.dot(&(back - point)), normal),
            Skeleton::Point { point } => ((back - point).norm(), back - point),
            Skeleton::Line { point, axis } => {
                let across = axis.cross(&(back - point)).cross(&axis) / axis.norm_squared();
                (across.norm(), across)
            }
            Skeleton::Piece { point, axis, length } => {
                let along = axis.dot(&(back - point)).clamp(0.0, length.unwrap_or(f64::INFINITY));
                let foot = point + axis * along;
                ((back - foot).norm(), back - foot)
            }
        };
        let away = hinge.map_or(away, |hinge| turned(&hinge, &away, turns)).normalize();
        let away = carrier.map_or(away, |(_, turn)| turn.inverse() * away);
        if side == Side::Outside { (from_skeleton - level, away) } else { (level - from_skeleton, -away) }
    }
}
