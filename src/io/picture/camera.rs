//! Orthographic camera: world → samples.

use super::{TubePicture, View};
use crate::error::InputError;
use crate::math::{Mat3, Vec3};

/// Margin on each side of a fitted view, over the size of the picture.
const MARGIN: f64 = 0.04;

/// Maps the world to sample coordinates: x to the right, y downwards, z towards the eye, all in samples.
pub(super) struct Camera {
    /// Rows: directions to the right, downwards, towards the eye.
    axes: Mat3,
    center: Vec3,
    /// Samples per length.
    pub scale: f64,
    /// Samples per pixel in each direction.
    pub per_pixel: f64,
    /// Size of the sample buffer.
    pub width: usize,
    /// Size of the sample buffer.
    pub height: usize,
}

impl Camera {
    pub fn new(picture: &TubePicture) -> Result<Self, InputError> {
        let axes = match picture.view {
            // The longer side of the picture shows the widest axis.
            View::Auto => principal_axes(points(picture), picture.width >= picture.height),
            View::Along { forward, up } => looking_along(forward, up)?,
        };
        let [width, height] = [picture.width, picture.height].map(|n| n * picture.supersampling);
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for tube in &picture.tubes {
            for (index, point) in tube.points.iter().enumerate() {
                let (seen, radius) = (axes * point, tube.radius(index));
                low = low.inf(&seen.add_scalar(-radius));
                high = high.sup(&seen.add_scalar(radius));
            }
        }
        if low.x > high.x {
            (low, high) = (Vec3::repeat(-1.0), Vec3::repeat(1.0));
        }
        let free = 1.0 - 2.0 * MARGIN;
        let fitted = (free * width as f64 / (high.x - low.x)).min(free * height as f64 / (high.y - low.y));
        let scale = picture.visible_width.map_or(fitted, |w| width as f64 / w);
        Ok(Self {
            axes,
            center: picture.center.unwrap_or_else(|| axes.transpose() * ((low + high) * 0.5)),
            scale,
            per_pixel: picture.supersampling as f64,
            width,
            height,
        })
    }

    /// Sample coordinates of a point of the world.
    pub fn place(&self, point: Vec3) -> Vec3 {
        let shift = Vec3::new(0.5 * self.width as f64, 0.5 * self.height as f64, 0.0);
        self.axes * (point - self.center) * self.scale + shift
    }

    /// A direction of the world in sample coordinates.
    pub fn turn(&self, direction: Vec3) -> Vec3 {
        self.axes * direction
    }
}

/// Rows right, down, towards the eye for a viewing direction.
fn looking_along(forward: Vec3, up: Vec3) -> Result<Mat3, InputError> {
    let refuse = |field: &str, value: Vec3, allowed| InputError::Vector {
        field: field.to_owned(),
        value: value.into(),
        allowed,
    };
    let eye = -forward
        .try_normalize(0.0)
        .filter(|f| f.iter().all(|x| x.is_finite()))
        .ok_or_else(|| refuse("view.forward", forward, "a finite vector other than zero"))?;
    let right = up.cross(&eye).try_normalize(1e-9 * up.norm()).filter(|r| r.iter().all(|x| x.is_finite()));
    let right = right.ok_or_else(|| refuse("view.up", up, "a finite vector not parallel to view.forward"))?;
    Ok(Mat3::from_rows(&[right.transpose(), right.cross(&eye).transpose(), eye.transpose()]))
}

/// All points of a picture.
fn points(picture: &TubePicture) -> impl Iterator<Item = &Vec3> + Clone {
    picture.tubes.iter().flat_map(|t| &t.points)
}

/// Rows right, down, towards the eye: widest and narrowest principal axis of all points, signs fixed by the largest
/// entry; `wide` has the widest to the right, else it points upwards.
pub(in crate::io) fn principal_axes<'a>(points: impl Iterator<Item = &'a Vec3> + Clone, wide: bool) -> Mat3 {
    let num = points.clone().count().max(1) as f64;
    let mean = points.clone().sum::<Vec3>() / num;
    let size = points.clone().fold(0.0_f64, |s, p| s.max((p - mean).amax())).max(f64::MIN_POSITIVE);
    let covariance = points.map(|p| (p - mean) / size).fold(Mat3::zeros(), |m, d| m + d * d.transpose()) / num;
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let axis = |k: usize| {
        let v: Vec3 = eigen.eigenvectors.column(order[k]).into();
        if v[v.iamax()] < 0.0 { -v } else { v }
    };
    let (right, down) = if wide { (axis(0), -axis(1)) } else { (axis(1), -axis(0)) };
    let eye = down.cross(&right);
    Mat3::from_rows(&[right.transpose(), down.transpose(), eye.transpose()])
}
