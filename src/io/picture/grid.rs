//! Planes are drawn as a grid of lines below the rods.

use crate::math::Vec3;
use crate::math::direction::any_normal;

/// Squares along the longer side of what lies above the plane, at least, because fewer do not show its slant.
const SQUARES: f64 = 8.0;

/// A plane that rods rest on.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DrawnPlane {
    /// Name.
    pub name: String,
    /// A point on it at the start \[L\].
    pub point: [f64; 3],
    /// Unit normal, towards the rods.
    pub normal: [f64; 3],
}

impl DrawnPlane {
    /// Lines of a square grid \[L\] about the points' feet on the plane, one square beyond them; `displacement` \[L\] is how
    /// far the plane has moved along its normal. None where all points have one foot.
    pub fn grid<'a>(&self, points: impl Iterator<Item = &'a Vec3>, displacement: f64) -> Vec<[Vec3; 2]> {
        let (point, normal) = (Vec3::from(self.point), Vec3::from(self.normal));
        let right = any_normal(normal);
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
        let at = |x: f64, y: f64| point + normal * displacement + (axes[0] * x + axes[1] * y) * side;
        let steps = |[low, high]: [f64; 2]| (0..=(high - low) as usize).map(move |k| low + k as f64);
        let [x, y] = ranges;
        let along_y = steps(x).map(|u| [at(u, y[0]), at(u, y[1])]);
        along_y.chain(steps(y).map(|v| [at(x[0], v), at(x[1], v)])).collect()
    }
}

/// The largest number 1, 2 or 5 times a power of ten that is not above `length`.
pub(in crate::io) fn round_below(length: f64) -> f64 {
    let power = 10_f64.powf(length.log10().floor());
    [5.0, 2.0].into_iter().map(|m| m * power).find(|round| *round <= length).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_lies_on_its_plane_below_all_points() {
        let normal = Vec3::new(1.0, 2.0, 2.0) / 3.0;
        let plane = DrawnPlane { name: "table".to_owned(), point: [5.0, 0.0, 1.0], normal: normal.into() };
        let points: Vec<Vec3> = (0..50).map(|i| f64::from(i) * Vec3::new(0.3, -0.1, 0.2)).collect();
        let lines = plane.grid(points.iter(), 0.25);
        assert!((12..60).contains(&lines.len()), "{}", lines.len());
        assert!(lines.iter().flatten().all(|p| (normal.dot(&(p - Vec3::from(plane.point))) - 0.25).abs() < 1e-12));
        // each foot has lines on both sides, in both directions
        for direction in [any_normal(normal), normal.cross(&any_normal(normal))] {
            let places = |all: &[Vec3]| all.iter().map(|p| direction.dot(p)).collect::<Vec<_>>();
            let (grid, feet) = (places(&lines.concat()), places(&points));
            assert!(feet.iter().all(|x| grid.iter().any(|g| g < x) && grid.iter().any(|g| g > x)));
        }
        assert!(plane.grid([Vec3::zeros()].iter(), 0.0).is_empty());
    }

    #[test]
    fn lengths_are_rounded_down_to_1_2_5() {
        assert_eq!([7.3, 0.3, 1.0, 49.0].map(round_below), [5.0, 0.2, 1.0, 20.0]);
    }
}
