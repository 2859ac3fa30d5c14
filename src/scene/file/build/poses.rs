//! From the text of a pose to the pose.

use std::f64::consts::TAU;

use nalgebra::{Quaternion, Rotation3, Unit};

use crate::error::InputError;
use crate::math::{Mat3, Quat, Vec3};
use crate::scene::file::syntax::values::List;
use crate::scene::file::syntax::{PathText, PoseText};
use crate::scene::{Model, NodeRef, Pose, PosePath};

/// Largest deviation of a quaternion or matrix from a rotation, because numbers may be given with seven digits.
const TOL_ROTATION: f64 = 1e-6;

const ONE_ROTATION: &str = "give one of quaternion, axis_angle, matrix";

/// The pose of a node.
pub(super) fn pose(field: &str, text: &PoseText, model: &Model, node: NodeRef) -> Result<Pose, InputError> {
    let rod = &model.rods[node.rod];
    let (start, frame) = (rod.positions[node.node], rod.frames[node.node]);
    let (rotation, half_turn) = rotation(field, text)?;
    let position = text.position.map(Vec3::from);
    let (position, frame) = match text.relative {
        true => (position.map(|by| start + by), rotation.map(|by| by * frame)),
        false => (position, rotation),
    };
    let path = match text.path {
        PathText::Straight => PosePath::Straight,
        PathText::Screw => PosePath::Screw,
    };
    Ok(Pose { position, frame, path, turns: text.extra_turns, half_turn })
}

/// The rotation, and the axis that selects between two half turns.
fn rotation(field: &str, text: &PoseText) -> Result<(Option<Quat>, Vec3), InputError> {
    let none = Vec3::zeros();
    match (text.quaternion, text.axis_angle, text.matrix) {
        (None, None, None) => Ok((None, none)),
        (Some(List(q)), None, None) => Ok((Some(quaternion(field, q)?), none)),
        (None, Some(List([x, y, z, turns])), None) => axis_angle(field, Vec3::new(x, y, z), turns),
        (None, None, Some(List(rows))) => Ok((Some(matrix(field, rows.map(|row| row.0))?), none)),
        _ => Err(InputError::inconsistent(field.to_owned(), ONE_ROTATION)),
    }
}

fn quaternion(field: &str, [w, x, y, z]: [f64; 4]) -> Result<Quat, InputError> {
    let q = Quaternion::new(w, x, y, z);
    if (q.norm() - 1.0).abs() <= TOL_ROTATION {
        return Ok(Unit::new_normalize(q));
    }
    let reason = format!("[{w}, {x}, {y}, {z}] has length {}: a rotation is [w, x, y, z] of length 1", q.norm());
    Err(InputError::inconsistent(format!("{field}.quaternion"), &reason))
}

fn axis_angle(field: &str, axis: Vec3, turns: f64) -> Result<(Option<Quat>, Vec3), InputError> {
    let field = format!("{field}.axis_angle");
    let allowed = "between -0.5 and 0.5 turns, for a pose is reached by the shortest turn (whole turns about the rod's \
        tangent: extra_turns; about any axis: ramp.rotation)";
    InputError::check(&field, turns, turns.abs() <= 0.5, allowed)?;
    if !axis.iter().all(|x| x.is_finite()) || axis.amax() == 0.0 {
        let allowed = "[x, y, z, turns] with an axis that is finite and not zero";
        return Err(InputError::Vector { field, value: axis.into(), allowed });
    }
    let axis = crate::scene::model::unit(&axis);
    Ok((Some(Quat::from_scaled_axis(axis * (turns * TAU))), axis * turns))
}

fn matrix(field: &str, rows: [[f64; 3]; 3]) -> Result<Quat, InputError> {
    let matrix = Mat3::from_fn(|i, j| rows[i][j]);
    let off = (matrix.transpose() * matrix - Mat3::identity()).amax();
    if off <= TOL_ROTATION && matrix.determinant() > 0.0 {
        return Ok(Quat::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix)));
    }
    let reason = format!(
        "is no rotation (determinant {}, products of columns off by {off}): give its rows; columns are d1, d2, d3",
        matrix.determinant()
    );
    Err(InputError::inconsistent(format!("{field}.matrix"), &reason))
}
