//! Where pictures are seen from, and how much they show.

use crate::io::picture::camera::principal_axes;
use crate::io::picture::{TubePicture, View};
use crate::io::record::run::RecordedRun;
use crate::math::{Mat3, Vec3};
use crate::scene::Skeleton;

use super::still::Still;

/// Largest width and height of `picture.png`, pixels.
pub(super) const PICTURE: [usize; 2] = [1600, 1200];
/// Largest width and height of a picture in the film strip, pixels.
const FRAME: [usize; 2] = [560, 420];
/// Angle at which planes are seen, rad: their grids are open, and what lies on them is hardly foreshortened.
const ELEVATION: f64 = 0.3;
/// Variance of a flat or straight state across it, over the largest: what is straight is then seen well from all sides
/// but along it.
const THIN: f64 = 1e-3;
/// Margin of a picture on each side, over the extent of its rods.
const MARGIN: f64 = 0.03;
/// Width with a colour bar over that without: the bar and its title take a fifth of the picture.
const BAR: f64 = 1.3;
/// Largest width over height, because legends need room in pictures of rods that are long and thin.
const FLATTEST: usize = 5;

/// Directions to the right and upwards in pictures of these frames: those of the scene, or those of [`best_axes`];
/// above a plane it is below.
pub(in crate::io::record) fn axes(run: &RecordedRun, frames: &[&Still]) -> [Vec3; 2] {
    if let Some(camera) = run.choice.camera.map(Vec3::from) {
        let camera = camera / camera.amax();
        let along_z = camera.xy().norm() < 1e-6 * camera.norm();
        let up = run.choice.up.map_or(if along_z { Vec3::y() } else { Vec3::z() }, Vec3::from);
        let right = up.cross(&camera).normalize();
        return [right, camera.cross(&right).normalize()];
    }
    if run.planar {
        return [Vec3::x(), Vec3::y()];
    }
    let axes = best_axes(frames);
    let normal = run.obstacles.iter().find_map(|obstacle| match obstacle.skeleton {
        Skeleton::Plane { normal, .. } => Some(normal),
        _ => None,
    });
    match normal {
        Some(normal) => above(normal, axes),
        None => [axes.row(0).transpose(), -axes.row(1).transpose()],
    }
}

/// Smallest and largest coordinates \[L\] of balls about points: to the right, upwards, towards the eye.
pub(in crate::io::record) fn region_of<'a>(
    points: impl Iterator<Item = &'a Vec3>,
    radius: f64,
    axes: &[Vec3; 2],
) -> [Vec3; 2] {
    let axes = coordinates(axes);
    let none = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    points
        .map(|point| axes * point)
        .fold(none, |[low, high], p| [low.inf(&p.add_scalar(-radius)), high.sup(&p.add_scalar(radius))])
}

pub(super) fn view_along(axes: &[Vec3; 2]) -> View {
    View::Along { forward: -axes[0].cross(&axes[1]), up: axes[1] }
}

/// A picture of a strip that shows a region, with nothing in it yet.
pub(in crate::io::record) fn of_strip(region: [Vec3; 2], axes: &[Vec3; 2]) -> TubePicture {
    let shown = extents(region, false);
    let [width, height] = canvas(shown, FRAME);
    let (center, visible_width) = (Some(middle(region, axes, None)), Some(width_shown(shown, [width, height])));
    let view = view_along(axes);
    TubePicture { width, height, supersampling: 2, center, visible_width, view, ..TubePicture::default() }
}

/// Width and height \[L\] that show a whole region, with room for a colour bar on the right if there is one.
pub(super) fn extents([low, high]: [Vec3; 2], has_bar: bool) -> [f64; 2] {
    let room = if has_bar { BAR } else { 1.0 } + 2.0 * MARGIN;
    [room * (high.x - low.x), (1.0 + 2.0 * MARGIN) * (high.y - low.y)]
}

/// Point in the middle of the picture of a region. With a colour bar the region is at the left of the width shown.
pub(super) fn middle([low, high]: [Vec3; 2], axes: &[Vec3; 2], with_bar: Option<f64>) -> Vec3 {
    let mut point = 0.5 * (low + high);
    if let Some(width) = with_bar {
        point.x = low.x - MARGIN * (high.x - low.x) + 0.5 * width;
    }
    coordinates(axes).transpose() * point
}

/// Rows to the right, upwards, towards the eye.
fn coordinates([right, up]: &[Vec3; 2]) -> Mat3 {
    Mat3::from_rows(&[right.transpose(), up.transpose(), right.cross(up).transpose()])
}

/// Width and height of a picture as wide as `largest` and only as high as is needed to show what is seen.
pub(super) fn canvas(extents: [f64; 2], largest: [usize; 2]) -> [usize; 2] {
    let [width, height] = largest;
    let needed = (width as f64 * extents[1] / extents[0]).ceil();
    [width, (needed as usize).clamp(width / FLATTEST, height)]
}

/// Width \[L\] at which both extents fit into a picture of that many pixels.
pub(super) fn width_shown(extents: [f64; 2], [width, height]: [usize; 2]) -> f64 {
    extents[0].max(extents[1] * width as f64 / height as f64)
}

/// Rows right, down, towards the eye for pictures of states of one run, so that none is seen edge-on: of the directions
/// along which single states spread least, and those midway between two of them, the eye is where the worst seen state
/// is seen best. A state is seen as well as the area of its shadow is large. The widest axis of the last is to the
/// right.
fn best_axes(frames: &[&Still]) -> Mat3 {
    let own: Vec<(Mat3, Vec3)> = frames.iter().map(|frame| spreads(frame)).collect();
    let least = || own.iter().map(|(axes, _)| Vec3::from(axes.row(2).transpose()));
    let between = least().flat_map(|a| least().flat_map(move |b| [a + b, a - b]));
    let candidates = between.filter_map(|eye| eye.try_normalize(0.1));
    let seen = |(axes, variances): &(Mat3, Vec3), eye: &Vec3| {
        let shares = (axes * eye).component_mul(&(axes * eye));
        shares.component_div(variances).sum() * variances[2]
    };
    let worst = |eye: &Vec3| own.iter().map(|own| seen(own, eye)).fold(f64::INFINITY, f64::min);
    // the first of equals
    let better = |best: Vec3, eye: Vec3| if worst(&eye) > worst(&best) { eye } else { best };
    let last = own.last().map_or_else(Mat3::identity, |(axes, _)| *axes);
    let eye = candidates.fold(last.row(2).transpose(), better);
    let right = across(eye, last);
    Mat3::from_rows(&[right.transpose(), right.cross(&eye).transpose(), eye.transpose()])
}

/// Principal axes of a state, and the variances along them over the largest, at least [`THIN`].
fn spreads(frame: &Still) -> (Mat3, Vec3) {
    let points = frame.rods.iter().flat_map(|rod| &rod.points);
    let axes = principal_axes(points.clone(), true);
    let mean = points.clone().sum::<Vec3>() / points.clone().count().max(1) as f64;
    let along = points.map(|point| axes * (point - mean)).fold(Vec3::zeros(), |sum, p| sum + p.component_mul(&p));
    (axes, along.map(|sum| (sum / along[0].max(f64::MIN_POSITIVE)).clamp(THIN, 1.0)))
}

/// The widest axis of a picture across a direction.
fn across(direction: Vec3, axes: Mat3) -> Vec3 {
    let across = |row: usize| {
        let axis: Vec3 = axes.row(row).transpose();
        axis - direction * direction.dot(&axis)
    };
    // the widest axis may be the direction itself
    if across(0).norm() > 0.5 { across(0).normalize() } else { across(1).normalize() }
}

/// Axes of a picture in which a plane's normal points upwards: to the right what is widest along it, seen from a little
/// above it, so that its grid can be seen.
fn above(normal: Vec3, axes: Mat3) -> [Vec3; 2] {
    let right = across(normal, axes);
    let (sin, cos) = ELEVATION.sin_cos();
    [right, normal * cos - right.cross(&normal) * sin]
}

#[cfg(test)]
mod tests {
    use super::super::still::StillRod;
    use super::*;
    use std::f64::consts::TAU;

    /// Symptom: a colour bar covered the rod in pictures that are wider than it needs.
    #[test]
    fn a_colour_bar_has_its_own_place() {
        let axes = [Vec3::y(), Vec3::z()];
        for region in [[Vec3::zeros(), Vec3::new(1.0, 4.0, 4.0)], [Vec3::new(5.0, 2.0, 2.0), Vec3::new(9.0, 4.0, 9.0)]]
        {
            let needed = extents(region, true);
            let size = canvas(needed, PICTURE);
            let width = width_shown(needed, size);
            let middle = coordinates(&axes) * super::middle(region, &axes, Some(width));
            let [left, right] = region.map(|corner| corner.x - middle.x);
            assert!(left > -0.5 * width && right < 0.3 * width, "{left} {right} {width}");
            assert_eq!(middle.y, 0.5 * (region[0].y + region[1].y));
        }
    }

    /// A ring that folds into a figure-eight in another plane: no state is seen edge-on, and one alone is seen face-on.
    #[test]
    fn no_state_of_a_film_is_seen_edge_on() {
        let still = |point: fn(f64) -> Vec3| {
            let points = (0..100).map(|k| point(TAU * f64::from(k) / 100.0)).collect();
            let rod = StillRod { points, radii: Vec::new(), directions: Vec::new(), values: Vec::new() };
            Still { step: 0, rods: vec![rod], spots: Vec::new() }
        };
        let ring = still(|t| Vec3::new(3.0 * t.cos(), 3.0 * t.sin(), 0.0));
        let eight = still(|t| Vec3::new(4.0 * t.cos(), 0.1 * t.sin(), 2.0 * (2.0 * t).sin()));
        let straight = still(|t| Vec3::new(t, 0.0, 0.0));
        let eye = |frames: &[&Still]| Vec3::from(best_axes(frames).row(2).transpose());
        assert!(eye(&[&ring]).z.abs() > 0.999 && eye(&[&eight]).y.abs() > 0.999);
        let both = eye(&[&straight, &ring, &ring, &ring, &eight]);
        assert!(both.z.abs() > 0.5 && both.y.abs() > 0.5, "{both}");
        let axes = best_axes(&[&ring, &eight]);
        assert!((axes * axes.transpose() - Mat3::identity()).norm() < 1e-12, "{axes}");
    }

    #[test]
    fn planes_are_seen_from_a_little_above() {
        let normal = Vec3::z();
        // rods that spread most along x, y or z
        for axes in [[0, 1, 2], [1, 0, 2], [2, 0, 1], [2, 1, 0]] {
            let rows = axes.map(|k| Vec3::ith(k, 1.0).transpose());
            let [right, up] = above(normal, Mat3::from_rows(&rows));
            let eye = right.cross(&up);
            assert!(right.dot(&up).abs() < 1e-15 && right.dot(&normal).abs() < 1e-15);
            assert!(up.dot(&normal) > 0.9 && (eye.dot(&normal) - ELEVATION.sin()).abs() < 1e-15, "{eye}");
        }
    }

    #[test]
    fn pictures_are_as_high_as_their_rods_need() {
        for (extents, expected) in [([4.0, 4.0], 1200), ([10.0, 3.0], 480), ([10.0, 0.1], 320), ([0.0, 9.0], 1200)] {
            let size = canvas(extents, PICTURE);
            assert_eq!(size, [1600, expected], "{extents:?}");
            let visible = width_shown(extents, size);
            assert!(visible >= extents[0] && visible * expected as f64 / 1600.0 >= extents[1] * (1.0 - 1e-12));
        }
    }
}
