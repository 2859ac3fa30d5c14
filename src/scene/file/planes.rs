//! Planes of a scene file, and how stages call them.

use crate::error::InputError;
use crate::scene::Plane;

use super::text::PlaneText;

/// Name of the only plane of a scene, if it has none.
const ONLY_PLANE: &str = "plane";

pub(super) fn planes(text: &[PlaneText]) -> Result<Vec<Plane>, InputError> {
    let mut planes: Vec<Plane> = Vec::new();
    for (i, plane) in text.iter().enumerate() {
        let field = || format!("planes[{i}].name");
        let name = if text.len() == 1 && plane.name.is_empty() { ONLY_PLANE } else { &plane.name };
        if name.is_empty() {
            let reason =
                "missing: where there are several planes, each needs a name, by which stages and reports call it";
            return Err(InputError::inconsistent(field(), reason));
        }
        if planes.iter().any(|other| other.name == name) {
            let allowed = "a name that no other plane has".to_owned();
            return Err(InputError::Name { field: field(), name: name.to_owned(), allowed });
        }
        planes.push(Plane { name: name.to_owned(), point: plane.point.into(), normal: plane.normal.into() });
    }
    Ok(planes)
}

/// Index of the plane called `name`; the only plane needs no name.
pub(super) fn find(planes: &[Plane], field: &str, name: Option<&str>) -> Result<usize, InputError> {
    let found = match name {
        None if planes.len() == 1 => Some(0),
        None => None,
        Some(name) => planes.iter().position(|plane| plane.name == name),
    };
    let names = planes.iter().map(|plane| format!("\"{}\"", plane.name)).collect::<Vec<_>>().join(", ");
    let allowed = if names.is_empty() { "a plane: the scene has none".to_owned() } else { format!("one of {names}") };
    let name = name.unwrap_or_default().to_owned();
    found.ok_or_else(|| InputError::Name { field: format!("{field}.name"), name, allowed })
}
