//! Z-buffer of capsules seen along −z.

use crate::math::{Vec3, parallel};

/// A straight capsule in sample coordinates.
#[derive(Clone, Copy)]
pub(super) struct ScreenCapsule {
    /// Ends of the axis.
    pub ends: [Vec3; 2],
    /// Radius in samples.
    pub radius: f64,
}

/// The visible surface at each sample.
pub(super) struct Samples {
    /// Samples per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Height z of the surface towards the eye; −∞ on the background.
    pub depth: Vec<f32>,
    /// Index of the capsule seen; [`NOTHING`] on the background.
    pub capsule: Vec<u32>,
}

/// Index of no capsule.
pub(super) const NOTHING: u32 = u32::MAX;

/// Rows of samples per parallel task.
const BAND: usize = 48;

/// Draws all capsules. Of equal depths the first wins, so the result does not depend on the number of threads.
pub(super) fn draw(shapes: &[ScreenCapsule], width: usize, height: usize) -> Samples {
    let mut samples = Samples {
        width,
        height,
        depth: vec![f32::NEG_INFINITY; width * height],
        capsule: vec![NOTHING; width * height],
    };
    let mut bands: Vec<Vec<u32>> = vec![Vec::new(); height.div_ceil(BAND)];
    for (index, shape) in shapes.iter().enumerate() {
        let rows = covered(shape, 1, height);
        if !rows.is_empty() {
            (rows.start / BAND..=(rows.end - 1) / BAND).for_each(|band| bands[band].push(index as u32));
        }
    }
    let depth = samples.depth.chunks_mut(BAND * width);
    let mut views: Vec<_> = depth.zip(samples.capsule.chunks_mut(BAND * width)).collect();
    parallel::each(&mut views, 1, &|band, (depth, capsule)| {
        let rows = BAND * band..BAND * band + depth.len() / width;
        for &index in &bands[band] {
            let shape = &shapes[index as usize];
            let ray = Ray::new(shape);
            let (columns, own) = (covered(shape, 0, width), covered(shape, 1, height));
            for row in rows.start.max(own.start)..rows.end.min(own.end) {
                let start = (row - rows.start) * width;
                for column in columns.clone() {
                    let Some(z) = ray.hit(column as f64 + 0.5, row as f64 + 0.5) else { continue };
                    if z as f32 > depth[start + column] {
                        depth[start + column] = z as f32;
                        capsule[start + column] = index;
                    }
                }
            }
        }
    });
    samples
}

/// Columns (axis 0) or rows (axis 1) a capsule may cover.
fn covered(shape: &ScreenCapsule, axis: usize, size: usize) -> std::ops::Range<usize> {
    let [a, b] = [shape.ends[0][axis], shape.ends[1][axis]];
    let low = (a.min(b) - shape.radius).floor().clamp(0.0, size as f64);
    let high = (a.max(b) + shape.radius + 1.0).ceil().clamp(0.0, size as f64);
    low as usize..high as usize
}

/// A capsule prepared for rays along z.
struct Ray {
    start: Vec3,
    end: Vec3,
    /// Unit axis and length.
    axis: Vec3,
    length: f64,
    radius_sq: f64,
    /// Squared sine of the angle between axis and ray.
    sine_sq: f64,
}

impl Ray {
    fn new(shape: &ScreenCapsule) -> Self {
        let [start, end] = shape.ends;
        let length = (end - start).norm();
        let axis = if length > 0.0 { (end - start) / length } else { Vec3::z() };
        Self { start, end, axis, length, radius_sq: shape.radius * shape.radius, sine_sq: 1.0 - axis.z * axis.z }
    }

    /// Largest z where the ray through (x, y) meets the capsule.
    fn hit(&self, x: f64, y: f64) -> Option<f64> {
        let (dx, dy) = (x - self.start.x, y - self.start.y);
        let mut along = if self.axis.z > 0.0 { self.length } else { 0.0 };
        if self.sine_sq > 1e-9 {
            // |q + z e_z|² − (axial part)² = r²: the infinite cylinder.
            let axial = dx * self.axis.x + dy * self.axis.y;
            let b = -axial * self.axis.z;
            let c = dx * dx + dy * dy - axial * axial - self.radius_sq;
            let discriminant = b * b - self.sine_sq * c;
            if discriminant < 0.0 {
                return None;
            }
            let z = (discriminant.sqrt() - b) / self.sine_sq;
            along = axial + z * self.axis.z;
            if (0.0..=self.length).contains(&along) {
                return Some(self.start.z + z);
            }
        }
        let center = if along > 0.0 { self.end } else { self.start };
        let (dx, dy) = (x - center.x, y - center.y);
        let rest = self.radius_sq - dx * dx - dy * dy;
        (rest >= 0.0).then(|| center.z + rest.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_cylinder_caps_and_spheres() {
        let ray = Ray::new(&ScreenCapsule { ends: [Vec3::zeros(), Vec3::new(10.0, 0.0, 0.0)], radius: 2.0 });
        assert_eq!(ray.hit(5.0, 0.0), Some(2.0));
        assert_eq!(ray.hit(-2.0, 0.0), Some(0.0));
        assert_eq!(ray.hit(12.1, 0.0), None);
        assert_eq!(ray.hit(5.0, 2.1), None);
        let towards = Ray::new(&ScreenCapsule { ends: [Vec3::zeros(), Vec3::new(0.0, 0.0, 10.0)], radius: 2.0 });
        assert_eq!(towards.hit(0.0, 0.0), Some(12.0));
        assert_eq!(towards.hit(0.0, 2.0), Some(10.0));
        let slanted = Ray::new(&ScreenCapsule { ends: [Vec3::zeros(), Vec3::new(10.0, 0.0, 10.0)], radius: 1.0 });
        assert!((slanted.hit(5.0, 0.0).unwrap() - (5.0 + 2.0_f64.sqrt())).abs() < 1e-12);
    }

    #[test]
    fn the_nearer_capsule_is_seen() {
        let at = |z: f64| ScreenCapsule { ends: [Vec3::new(3.0, 8.0, z), Vec3::new(13.0, 8.0, z)], radius: 2.0 };
        let samples = draw(&[at(0.0), at(5.0), at(-3.0)], 16, 16);
        assert_eq!(samples.capsule[8 * 16 + 8], 1);
        assert_eq!(samples.capsule[0], NOTHING);
    }
}
