//! Axes of plectonemes: straight, or the middle part of any open shape.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;

use crate::error::InputError;
use crate::math::quaternion::{Q, dot, mul, to_array};
use crate::math::{Quat, Vec3};

use super::super::{Shape, finite, frame, normal_to, unit};
use super::Axis;

/// Samples of a curved axis per distance between the strands, because the interpolated axis must be as smooth as the
/// rod.
const SAMPLES_PER_DISTANCE: f64 = 2.0;

/// Most samples of a curved axis.
const MAX_SAMPLES: f64 = 2e7;

/// The axis at one point: position, derivative by arc length z, frame, and the rate of rotation K of the frame (in its
/// own axes).
pub(super) struct AxisPoint {
    pub position: Vec3,
    pub slope: Vec3,
    pub frame: Quat,
    pub rate: Vec3,
}

/// An axis as a function of its arc length z, 0 in the middle.
pub(super) enum AxisCurve {
    Straight {
        center: Vec3,
        frame: Quat,
    },
    /// Cubic Hermite interpolation of positions and of twist-free frames at equal arc lengths: continuous tangents and,
    /// to the square of the spacing, curvature.
    Curved {
        spacing: f64,
        positions: Vec<Vec3>,
        tangents: Vec<Vec3>,
        frames: Vec<Q>,
        slopes: Vec<Q>,
    },
}

impl AxisCurve {
    pub(super) fn new(axis: &Axis, distance: f64) -> Result<Self, InputError> {
        match axis {
            Axis::Straight { center, direction } => {
                finite("shape.center", center)?;
                let d3 = unit("shape.direction", direction)?;
                Ok(Self::Straight { center: *center, frame: frame(&normal_to(&d3, &Vec3::z(), &Vec3::x()), &d3) })
            }
            Axis::Along(shape) => Self::along(shape, distance),
        }
    }

    fn along(shape: &Shape, distance: f64) -> Result<Self, InputError> {
        let refuse = |reason: String| InputError::Inconsistent { field: "shape.axis".into(), reason };
        if matches!(shape, Shape::Circle { .. } | Shape::Plectoneme(_) | Shape::TorusKnot(_)) {
            return Err(refuse("must be an open curve: a line, an arc, a helix or points".into()));
        }
        let length = shape.place(false, 1)?.length;
        let wanted = (SAMPLES_PER_DISTANCE * length / distance).ceil();
        if wanted > MAX_SAMPLES {
            return Err(refuse(format!("its length {length} is too much for strands a distance {distance} apart")));
        }
        let num = (wanted as usize).max(16);
        let placement = shape.place(false, num)?;
        let spacing = placement.length / num as f64;
        let mut frames: Vec<Q> = placement.frames.iter().map(to_array).collect();
        for i in 1..frames.len() {
            if dot(&frames[i - 1], &frames[i]) < 0.0 {
                frames[i] = frames[i].map(|x| -x);
            }
        }
        let slope = |i: usize| {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(num));
            std::array::from_fn(|k| (frames[b][k] - frames[a][k]) / ((b - a) as f64 * spacing))
        };
        let slopes = (0..=num).map(slope).collect();
        let tangents = placement.frames.iter().map(|q| q * Vec3::z()).collect();
        Ok(Self::Curved { spacing, positions: placement.positions, tangents, frames, slopes })
    }

    /// Arc length of the whole axis; a straight one has no end.
    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Straight { .. } => f64::INFINITY,
            Self::Curved { spacing, positions, .. } => spacing * (positions.len() - 1) as f64,
        }
    }

    pub(super) fn at(&self, z: f64) -> AxisPoint {
        match self {
            Self::Straight { center, frame } => {
                let d3 = frame * Vec3::z();
                AxisPoint { position: center + d3 * z, slope: d3, frame: *frame, rate: Vec3::zeros() }
            }
            Self::Curved { spacing, positions, tangents, frames, slopes } => {
                let place = (z + 0.5 * self.length()) / spacing;
                let i = (place.max(0.0) as usize).min(positions.len() - 2);
                let (h, dh) = hermite(place - i as f64, *spacing);
                let vector = |h: &[f64; 4]| {
                    positions[i] * h[0] + tangents[i] * h[1] + positions[i + 1] * h[2] + tangents[i + 1] * h[3]
                };
                let q = |h: &[f64; 4]| -> Q {
                    std::array::from_fn(|k| {
                        frames[i][k] * h[0] + slopes[i][k] * h[1] + frames[i + 1][k] * h[2] + slopes[i + 1][k] * h[3]
                    })
                };
                let (value, slope) = (q(&h), q(&dh));
                let conjugate = [value[0], -value[1], -value[2], -value[3]];
                let rate = mul(&conjugate, &slope);
                let rate = Vec3::new(rate[1], rate[2], rate[3]) * (2.0 / dot(&value, &value));
                let frame = Quat::new_normalize(nalgebra::Quaternion::new(value[0], value[1], value[2], value[3]));
                AxisPoint { position: vector(&h), slope: vector(&dh), frame, rate }
            }
        }
    }

    /// Refuses an axis on whose part −`end`..`end` a plectoneme of the outer radius `reach(z)` would run into itself.
    ///
    /// Points of the axis that are more than a quarter circle of that size apart along it must be farther apart than
    /// both reaches (plus a fourteenth of a strand, because the axis is sampled every `step`).
    pub(super) fn check_clear(&self, end: f64, step: f64, reach: impl Fn(f64) -> f64) -> Result<(), InputError> {
        if matches!(self, Self::Straight { .. }) {
            return Ok(());
        }
        let refuse = |reason: String| Err(InputError::Inconsistent { field: "shape.axis".into(), reason });
        let count = (2.0 * end / step).ceil() as usize;
        let place = |i: usize| -end + 2.0 * end * (i as f64 / count as f64);
        let samples: Vec<(f64, Vec3, f64)> =
            (0..=count).map(|i| (place(i), self.at(place(i)).position, reach(place(i)))).collect();
        let widest = samples.iter().fold(0.0, |widest: f64, s| widest.max(s.2));
        let cell = 2.0 * widest + step;
        let cell_of = |p: &Vec3| -> [i64; 3] { std::array::from_fn(|k| (p[k] / cell).floor() as i64) };
        let mut grid: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        for (i, &(z, position, reach)) in samples.iter().enumerate() {
            let rate = self.at(z).rate;
            if rate.x.hypot(rate.y) * reach >= 1.0 {
                return refuse(format!(
                    "bends too tightly for a plectoneme of outer radius {reach} (at {z} from its middle)"
                ));
            }
            let home = cell_of(&position);
            for n in 0..27 {
                let cell = [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1];
                for &j in grid.get(&cell).into_iter().flatten() {
                    let (other_z, other, other_reach) = samples[j];
                    let (needed, apart) = (reach + other_reach, (position - other).norm());
                    if z - other_z > FRAC_PI_2 * needed && apart < needed.hypot(step * 0.5_f64.sqrt()) {
                        return refuse(format!(
                            "comes within {apart:.6} of itself (at {other_z:.6} and {z:.6} from its middle), where \
                             the plectoneme needs {needed:.6}"
                        ));
                    }
                }
            }
            grid.entry(home).or_default().push(i);
        }
        Ok(())
    }
}

/// Cubic Hermite weights (value, slope, value, slope) at u of an interval of length `span`, and their derivatives by
/// arc length.
fn hermite(u: f64, span: f64) -> ([f64; 4], [f64; 4]) {
    let v = 1.0 - u;
    let value = [v * v * (1.0 + 2.0 * u), u * v * v * span, u * u * (1.0 + 2.0 * v), -u * u * v * span];
    let slope = [-6.0 * u * v / span, v * (1.0 - 3.0 * u), 6.0 * u * v / span, u * (3.0 * u - 2.0)];
    (value, slope)
}
