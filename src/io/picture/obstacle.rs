//! Obstacles are drawn as lines: a plane as a grid below the rods, a sphere as circles of latitude and longitude, a
//! cylinder as circles and straight lines along the rods, a capsule as a sphere about either end and a cylinder between
//! them. The side that rods are on is seen, so that a ball hides its back and a tube is cut open.

use std::f64::consts::{PI, TAU};

use crate::math::Vec3;
use crate::math::direction::any_normal;
use crate::scene::{Obstacle, ObstaclePose, Skeleton};

/// Squares along the longer side of what lies above a plane, at least, because fewer do not show its slant.
const SQUARES: f64 = 8.0;
/// Edges of a circle, because more are not seen to be straight.
const EDGES: usize = 48;
/// Circles through both poles of a sphere, and straight lines along a cylinder over two: as many as still let rods be
/// seen.
const MERIDIANS: usize = 8;
/// Length of an endless capsule that is drawn, in radii: as much as shows its direction.
const SHOWN: f64 = 8.0;
/// Circles of a cylinder, at most.
const MOST_CIRCLES: f64 = 24.0;

/// Lines \[L\] that show the surface of an obstacle at the start where rods with these points are. None of a plane on
/// which all points have one foot.
pub fn lines<'a>(obstacle: &Obstacle, points: impl Iterator<Item = &'a Vec3>) -> Vec<[Vec3; 2]> {
    match &obstacle.skeleton {
        Skeleton::Plane { point, normal } => grid(point, normal, points),
        Skeleton::Point { point } => sphere(point, obstacle.radius),
        Skeleton::Line { point, axis } => cylinder([point, &axis.normalize()], obstacle.radius, points),
        Skeleton::Piece { point, axis, length } => {
            let drawn = length.unwrap_or(SHOWN * obstacle.radius);
            let ends = [*point, point + axis * drawn];
            let inside = ends.iter().flat_map(|end| sphere(end, obstacle.radius));
            inside.chain(cylinder([point, axis], obstacle.radius, ends.iter())).collect()
        }
    }
}

/// The same lines where the obstacle is placed.
pub(in crate::io) fn placed_lines<'a>(
    obstacle: &Obstacle,
    placement: &ObstaclePose,
    points: impl Iterator<Item = &'a Vec3>,
) -> Vec<[Vec3; 2]> {
    let (matrix, shift) = obstacle.image(placement);
    lines(obstacle, points).into_iter().map(|ends| ends.map(|end| matrix * end + shift)).collect()
}

/// Unit vector to the side of an obstacle that rods are on, in the middle of one of its lines; zero of a plane, which
/// is seen from both sides.
pub(in crate::io) fn normal(obstacle: &Obstacle, placement: &ObstaclePose, line: &[Vec3; 2]) -> Vec3 {
    if obstacle.is_plane() {
        return Vec3::zeros();
    }
    let surface = obstacle.placed(placement);
    surface.normal(&((line[0] + line[1]) * 0.5 - surface.point()))
}

/// Lines of a square grid about the points' feet on a plane, one square beyond them.
fn grid<'a>(point: &Vec3, normal: &Vec3, points: impl Iterator<Item = &'a Vec3>) -> Vec<[Vec3; 2]> {
    let right = any_normal(*normal);
    let axes = [right, normal.cross(&right)];
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for foot in points.map(|p| p - point) {
        for (range, axis) in ranges.iter_mut().zip(axes) {
            let x = axis.dot(&foot);
            *range = [range[0].min(x), range[1].max(x)];
        }
    }
    let widest = ranges.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
    if !(widest > 0.0 && widest.is_finite()) {
        return Vec::new();
    }
    let side = round_below(widest / SQUARES);
    let ranges = ranges.map(|[low, high]| [(low / side).floor() - 1.0, (high / side).ceil() + 1.0]);
    let at = |x: f64, y: f64| point + (axes[0] * x + axes[1] * y) * side;
    let steps = |[low, high]: [f64; 2]| (0..=(high - low) as usize).map(move |k| low + k as f64);
    let [x, y] = ranges;
    let along_y = steps(x).map(|u| [at(u, y[0]), at(u, y[1])]);
    along_y.chain(steps(y).map(|v| [at(x[0], v), at(x[1], v)])).collect()
}

/// Edges of a circle about a point, through the ends of both arms.
fn circle(center: Vec3, arms: [Vec3; 2]) -> impl Iterator<Item = [Vec3; 2]> {
    let at = move |k: usize| {
        let (sin, cos) = (TAU * k as f64 / EDGES as f64).sin_cos();
        center + arms[0] * cos + arms[1] * sin
    };
    (0..EDGES).map(move |k| [at(k), at(k + 1)])
}

fn sphere(center: &Vec3, radius: f64) -> Vec<[Vec3; 2]> {
    let [x, y, z] = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| axis * radius);
    let center = *center;
    let meridian = move |k: usize| {
        let (sin, cos) = (PI * k as f64 / MERIDIANS as f64).sin_cos();
        circle(center, [x * cos + y * sin, z])
    };
    let parallel = move |k: usize| {
        let (sin, cos) = (PI * k as f64 / MERIDIANS as f64).sin_cos();
        circle(center + z * cos, [x * sin, y * sin])
    };
    (0..MERIDIANS).flat_map(meridian).chain((1..MERIDIANS).flat_map(parallel)).collect()
}

fn cylinder<'a>([point, axis]: [&Vec3; 2], radius: f64, points: impl Iterator<Item = &'a Vec3>) -> Vec<[Vec3; 2]> {
    let [low, high] = points
        .map(|p| axis.dot(&(p - point)))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    if !(high - low).is_finite() {
        return Vec::new();
    }
    let [low, high] = [low - 0.5 * radius, high + 0.5 * radius];
    let right = any_normal(*axis) * radius;
    let arms = [right, axis.cross(&right)];
    let count = ((high - low) / radius).ceil().clamp(2.0, MOST_CIRCLES) as usize;
    let center = |k: usize| point + axis * (low + (high - low) * k as f64 / count as f64);
    let along = |k: usize| {
        let (sin, cos) = (PI * k as f64 / MERIDIANS as f64).sin_cos();
        [low, high].map(|x| point + axis * x + arms[0] * cos + arms[1] * sin)
    };
    (0..=count).flat_map(|k| circle(center(k), arms)).chain((0..2 * MERIDIANS).map(along)).collect()
}

/// The largest number 1, 2 or 5 times a power of ten that is not above `length`.
pub(in crate::io) fn round_below(length: f64) -> f64 {
    let power = 10_f64.powf(length.log10().floor());
    [5.0, 2.0].into_iter().map(|m| m * power).find(|round| *round <= length).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Hinge, ObstaclePose, Side};

    #[test]
    fn a_grid_lies_on_its_plane_below_all_points() {
        let normal = Vec3::new(1.0, 2.0, 2.0) / 3.0;
        let plane = Obstacle::plane("table", Vec3::new(5.0, 0.0, 1.0), normal);
        let points: Vec<Vec3> = (0..50).map(|i| f64::from(i) * Vec3::new(0.3, -0.1, 0.2)).collect();
        let (matrix, shift) = plane.image(&ObstaclePose { level: 0.25, ..ObstaclePose::default() });
        let lines: Vec<[Vec3; 2]> =
            lines(&plane, points.iter()).into_iter().map(|ends| ends.map(|p| matrix * p + shift)).collect();
        assert!((12..60).contains(&lines.len()), "{}", lines.len());
        let height = |p: &Vec3| normal.dot(&(p - Vec3::new(5.0, 0.0, 1.0)));
        assert!(lines.iter().flatten().all(|p| (height(p) - 0.25).abs() < 1e-12));
        // each foot has lines on both sides, in both directions
        for point in &points {
            let foot = point - normal * (height(point) - 0.25);
            for [a, b] in [0, lines.len() - 1].map(|k| lines[k]) {
                let along = (b - a).normalize();
                let part = along.dot(&(foot - a)) / (b - a).norm();
                assert!(part > 0.0 && part < 1.0, "{part}");
            }
        }
        assert!(super::lines(&plane, [Vec3::zeros()].iter()).is_empty());
    }

    /// Lines lie on the surface, at the start and where it has been moved, turned and blown up to.
    #[test]
    fn lines_lie_on_curved_surfaces_wherever_they_are() {
        let (point, axis) = (Vec3::new(0.3, -0.2, 0.5), Vec3::new(2.0, -1.0, 3.0));
        let points = [Vec3::zeros(), Vec3::new(4.0, 1.0, 2.0)];
        let hinge = Some(Hinge { through: Vec3::new(1.0, 0.0, -1.0), axis: Vec3::new(0.0, 2.0, 1.0) });
        let placement =
            ObstaclePose { level: 1.7, displacement: Vec3::new(0.4, 0.1, -0.6), turns: 0.3, ..ObstaclePose::default() };
        let size = (0.8, Side::Inside);
        for made in [Obstacle::sphere("ball", point, size), Obstacle::cylinder("tube", [point, axis], size)] {
            let obstacle = Obstacle { hinge, ..made };
            for placement in [obstacle.start(), placement] {
                let drawn = placed_lines(&obstacle, &placement, points.iter());
                assert!(drawn.len() > 90, "{}", drawn.len());
                let surface = obstacle.placed(&placement);
                for p in drawn.iter().flatten() {
                    assert!(surface.distance(&(p - surface.point())).abs() < 1e-12, "{obstacle:?}");
                }
                // of a hollow body the far side is seen, of a solid one the near side
                let eye = Vec3::new(0.1, 0.7, -0.3);
                let solid = Obstacle { side: Side::Outside, ..obstacle.clone() };
                for line in &drawn {
                    let out = (line[0] + line[1]) * 0.5 - surface.point();
                    let out = surface.skeleton.away(&out).dot(&eye);
                    if out.abs() > 1e-9 {
                        assert_eq!(normal(&obstacle, &placement, line).dot(&eye) > 0.0, out < 0.0);
                        assert_eq!(normal(&solid, &placement, line).dot(&eye) > 0.0, out > 0.0);
                    }
                }
            }
        }
    }
}
