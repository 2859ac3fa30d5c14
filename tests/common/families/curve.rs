//! How thick a rod along a curve may be.

use supercoil::math::Vec3;

/// Strands this much longer than the chord between their ends can lie beside each other: a half circle has π/2.
const DETOUR: f64 = 1.6;

/// Largest diameter of a tube along a polygon that neither overlaps itself nor is bent tighter than it is thick.
pub fn room(points: &[Vec3], closed: bool) -> f64 {
    let n = points.len();
    let mut arc = vec![0.0; n + 1];
    for i in 0..n {
        arc[i + 1] = arc[i] + (points[(i + 1) % n] - points[i]).norm();
    }
    let length = arc[n];
    let mut room = f64::INFINITY;
    for i in 0..n {
        for j in 0..i {
            let along = arc[i] - arc[j];
            let along = if closed { along.min(length - along) } else { along };
            let distance = (points[i] - points[j]).norm();
            if along > DETOUR * distance {
                room = room.min(distance);
            }
        }
    }
    let bends = if closed { 0..n } else { 1..n - 1 };
    for i in bends {
        let (a, b) = (points[i] - points[(i + n - 1) % n], points[(i + 1) % n] - points[i]);
        room = room.min((a.norm() + b.norm()) / a.angle(&b).max(1e-9));
    }
    room
}

/// The curve scaled to a length.
pub fn scaled(points: &[Vec3], closed: bool, length: f64) -> Vec<Vec3> {
    let n = points.len();
    let edges = if closed { n } else { n - 1 };
    let whole: f64 = (0..edges).map(|i| (points[(i + 1) % n] - points[i]).norm()).sum();
    points.iter().map(|p| p * (length / whole)).collect()
}
