//! Step parameters and poses, in the convention of El Hassan & Calladine (1995, J. Mol. Biol. 251:648).

use crate::math::{Mat3, Quat, Vec3};
use crate::rod::NaturalStrains;

/// Length unit of the translations in nm.
pub(crate) const ANGSTROM: f64 = 0.1;

/// Rotation, and rotation to the mid-step frame, for tilt, roll and twist in degrees.
fn turns(tilt: f64, roll: f64, twist: f64) -> (Quat, Quat) {
    let [tilt, roll, twist] = [tilt, roll, twist].map(f64::to_radians);
    let (bend, phase) = (roll.hypot(tilt), tilt.atan2(roll));
    let about = |axis: Vec3, angle: f64| Quat::from_scaled_axis(axis * angle);
    let (first, hinge) = (about(Vec3::z(), 0.5 * twist - phase), about(Vec3::y(), 0.5 * bend));
    let middle = first * hinge * about(Vec3::z(), phase);
    (first * hinge * hinge * about(Vec3::z(), 0.5 * twist + phase), middle)
}

/// Rotation and displacement (nm) from one base pair to the next, in the frame of the first: tilt, roll, twist in
/// degrees, shift, slide, rise in Å.
pub(crate) fn pose(&[tilt, roll, twist, shift, slide, rise]: &[f64; 6]) -> (Quat, Vec3) {
    let (turn, middle) = turns(tilt, roll, twist);
    (turn, middle * Vec3::new(shift, slide, rise) * ANGSTROM)
}

/// The parameters of a rotation and a displacement (nm): the inverse of [`pose`], twist within half a turn.
pub(crate) fn parameters(turn: &Quat, shift: &Vec3) -> [f64; 6] {
    let matrix = turn.to_rotation_matrix();
    let bend = matrix[(0, 2)].hypot(matrix[(1, 2)]).atan2(matrix[(2, 2)]);
    // R = Rz(twist/2 − phase) Ry(bend) Rz(twist/2 + phase)
    let [sum, difference] = if bend < 1e-9 {
        [matrix[(1, 0)].atan2(matrix[(0, 0)]), 0.0]
    } else {
        let (first, last) = (matrix[(1, 2)].atan2(matrix[(0, 2)]), matrix[(2, 1)].atan2(-matrix[(2, 0)]));
        [first + last, last - first]
    };
    let twist = sum.sin().atan2(sum.cos());
    // sum and difference are each known modulo a turn; half a turn shifts both
    let phase = 0.5 * (difference + (twist - sum));
    let [tilt, roll, twist] = [bend * phase.sin(), bend * phase.cos(), twist].map(f64::to_degrees);
    let (_, middle) = turns(tilt, roll, twist);
    let along = middle.inverse() * shift / ANGSTROM;
    [tilt, roll, twist, along.x, along.y, along.z]
}

/// Strains that are constant over a length `spacing` (nm) and lead from one base pair to another with these parameters.
pub(crate) fn strains(parameters: &[f64; 6], spacing: f64) -> NaturalStrains {
    strains_between(&pose(parameters), spacing)
}

/// Strains that are constant over a length `spacing` (nm) and lead from one frame to another, which is turned and
/// shifted (nm) so as seen from the first: by less than half a turn.
pub(crate) fn strains_between((turn, shift): &(Quat, Vec3), spacing: f64) -> NaturalStrains {
    let rotation = turn.scaled_axis();
    let (angle, cross) = (rotation.norm(), rotation.cross_matrix());
    // mean of exp(u θ×), u from 0 to 1
    let mean = if angle < 1e-4 {
        Mat3::identity() + cross * 0.5 + cross * cross / 6.0
    } else {
        let (sin, cos) = angle.sin_cos();
        Mat3::identity() + cross * ((1.0 - cos) / angle.powi(2)) + cross * cross * ((angle - sin) / angle.powi(3))
    };
    // a rotation of less than a turn leaves the mean invertible
    let along = mean.try_inverse().map_or(*shift, |inverse| inverse * shift) / spacing;
    let kappa = rotation / spacing;
    [along.x, along.y, along.z, kappa.x, kappa.y, kappa.z].into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_the_inverse_of_poses() {
        for k in 0..200 {
            let x = |i: usize| (1.7 * f64::from(k) + 2.3 * i as f64).sin();
            let given = [30.0 * x(0), 60.0 * x(1), 175.0 * x(2), 2.0 * x(3), x(4), 3.4 + x(5)];
            let (turn, shift) = pose(&given);
            let found = parameters(&turn, &shift);
            (0..6).for_each(|i| assert!((found[i] - given[i]).abs() < 1e-9, "{k}: {found:?} {given:?}"));
        }
        let straight = [0.0, 0.0, 34.3, 0.0, 0.0, 3.4];
        let (turn, shift) = pose(&straight);
        let found = parameters(&turn, &shift);
        (0..6).for_each(|i| assert!((found[i] - straight[i]).abs() < 1e-9, "{found:?}"));
    }
}
