//! Rods and nodes that a scene file names.

use crate::error::InputError;
use crate::rod::Rod;
use crate::scene::NodeRef;
use crate::scene::file::syntax::values::{At, RodNames};

/// Index of the rod called `name`; the only rod needs no name.
pub(super) fn find_rod(rods: &[Rod], field: &str, name: Option<&str>) -> Result<usize, InputError> {
    let allowed =
        || format!("one of {}", rods.iter().map(|rod| format!("\"{}\"", rod.name)).collect::<Vec<_>>().join(", "));
    match name {
        None if rods.len() == 1 => Ok(0),
        None => Err(InputError::inconsistent(format!("{field}.rod"), format!("missing: {}", allowed()))),
        Some(name) => rods.iter().position(|rod| rod.name == name).ok_or_else(|| InputError::Name {
            field: format!("{field}.rod"),
            name: name.to_owned(),
            allowed: allowed(),
        }),
    }
}

/// Indices of the named rods; the only rod needs no name.
pub(super) fn find_rods(rods: &[Rod], field: &str, names: &RodNames) -> Result<Vec<usize>, InputError> {
    if names.0.is_empty() {
        return find_rod(rods, field, None).map(|rod| vec![rod]);
    }
    let mut found = Vec::new();
    for name in &names.0 {
        let rod = find_rod(rods, field, Some(name))?;
        if found.contains(&rod) {
            let allowed = "named once in a list".to_owned();
            return Err(InputError::Name { field: format!("{field}.rod"), name: name.clone(), allowed });
        }
        found.push(rod);
    }
    Ok(found)
}

/// The node `at` of each named rod; the only rod needs no name.
pub(super) fn nodes(rods: &[Rod], field: &str, names: &RodNames, at: At) -> Result<Vec<NodeRef>, InputError> {
    find_rods(rods, field, names)?.into_iter().map(|rod| node(rods, field, rod, at)).collect()
}

pub(super) fn node(rods: &[Rod], field: &str, index: usize, at: At) -> Result<NodeRef, InputError> {
    let rod = &rods[index];
    let node = match at {
        At::Start => 0,
        At::End if rod.closed => {
            let reason =
                format!("rod \"{}\" is closed and has no end: use \"start\", a node index or {{ arc = s }}", rod.name);
            return Err(InputError::inconsistent(format!("{field}.at"), &reason));
        }
        At::End => rod.num_nodes() - 1,
        At::Node(node) if node >= rod.num_nodes() => {
            let allowed = "the index of a node of the rod (less than elements × order, or at most that if open)";
            return Err(InputError::Count { field: format!("{field}.at"), value: node, allowed });
        }
        At::Node(node) => node,
        At::Arc(arc) => {
            let ok = (0.0..=rod.length).contains(&arc);
            InputError::check(&format!("{field}.at.arc"), arc, ok, "between 0 and the length of the rod")?;
            (arc / rod.length * rod.num_segments() as f64).round() as usize % rod.num_nodes()
        }
    };
    Ok(NodeRef { rod: index, node })
}
