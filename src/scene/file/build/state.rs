//! A rod whose nodes and frames are the final state of a run, or the state in a checkpoint.

use std::path::Path;

use nalgebra::{Quaternion, Unit};

use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::rod::{Natural, Placement, Rod, Section, within};
use crate::scene::file::syntax::RodText;
use crate::scene::points::named_columns;
use crate::text::{CHECKPOINT, read_regular_bytes, state_in_checkpoint, utf8};

/// Columns of a final state that are read; quaternions scalar part first.
const COLUMNS: [&str; 9] = ["rod", "arc_length", "x", "y", "z", "qw", "qx", "qy", "qz"];

/// Largest deviation of a quaternion from unit length.
const TOL_UNIT: f64 = 1e-6;

/// The rod of a final state or a checkpoint, on its own elements or on the number of the scene.
pub(super) fn rod(
    text: &RodText,
    path: &Path,
    which: usize,
    section: Section,
    natural: Natural,
) -> Result<Rod, InputError> {
    let refuse = |reason: String| InputError::Parse { file: path.display().to_string(), reason };
    let bytes = read_regular_bytes(path)?;
    let table = match bytes.starts_with(CHECKPOINT) {
        true => state_in_checkpoint(&bytes).map(<[u8]>::to_vec).ok_or_else(|| {
            refuse("is a checkpoint that is cut short, or of another version of the program".to_owned())
        })?,
        false => bytes,
    };
    let rows = named_columns(&utf8(table, path)?, COLUMNS).map_err(refuse)?;
    let rows: Vec<[f64; 9]> = rows.into_iter().filter(|row| row[0] == which as f64).collect();
    if rows.len() < 2 {
        return Err(refuse(format!("has no rod {which} of two nodes or more: rods count from 0")));
    }
    let positions: Vec<Vec3> = rows.iter().map(|row| Vec3::new(row[2], row[3], row[4])).collect();
    let frame = |row: &[f64; 9]| -> Result<Quat, InputError> {
        let q = Quaternion::new(row[5], row[6], row[7], row[8]);
        let reason = || refuse(format!("the quaternion at arc_length {} has length {}, not 1", row[1], q.norm()));
        if (q.norm() - 1.0).abs() <= TOL_UNIT { Ok(Unit::new_normalize(q)) } else { Err(reason()) }
    };
    let frames = rows.iter().map(frame).collect::<Result<Vec<_>, _>>()?;
    let segments = if text.closed { rows.len() } else { rows.len() - 1 };
    let length = rows[rows.len() - 1][1] / (rows.len() - 1) as f64 * segments as f64;
    let path = format!("rods.{}", text.name);
    let from = |order: usize, positions: Vec<Vec3>, frames: Vec<Quat>| {
        let nodes = Placement { length, positions, frames, closed: text.closed };
        Rod::from_nodes(&text.name, nodes, section, order, natural.clone())
    };
    let wanted = text.elements.map(|elements| elements.saturating_mul(text.order));
    if wanted.is_none_or(|wanted| wanted == segments) {
        if !segments.is_multiple_of(text.order.max(1)) {
            let reason = format!("the state has {segments} segments, no multiple of the order: give elements");
            return Err(InputError::inconsistent(format!("{path}.elements"), &reason));
        }
        return from(text.order, positions, frames);
    }
    let coarse = from(1, positions, frames)?;
    let (positions, frames) = coarse.resampled(wanted.unwrap_or(segments)).map_err(|error| within(&path, error))?;
    from(text.order, positions, frames)
}
