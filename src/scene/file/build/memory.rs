//! Memory check of a mesh before a run.

use crate::error::InputError;
use crate::memory::{GIB, available};
use crate::rod::Rod;

/// Smallest memory of a node in a run, bytes, in space and in the plane. Rings of 12000 nodes use 7500 to 10000 and
/// 4000 to 5000 in a single step; contact and long runs use more.
const BYTES_A_NODE: [f64; 2] = [7000.0, 4000.0];
/// Memory of two elements of different rods that may touch, bytes: three wires side by side, of 1000 and 2000 elements,
/// take 145 and 125, and each element meets as many of its neighbour as lie on a diameter.
const BYTES_A_PAIR: f64 = 120.0;
/// Neighbours of a rod whose pairs are counted, at most, because those of a strand's core are too few to matter.
const NEIGHBOURS: usize = 2;

/// Smallest memory of a run, bytes.
pub(in crate::scene::file) fn least(nodes: usize, planar: bool) -> f64 {
    nodes as f64 * BYTES_A_NODE[usize::from(planar)]
}

/// Refuses a rod with which the scene needs more memory than available; `nodes` counts those of the rods before it.
pub(super) fn check(field: String, elements: usize, nodes: usize, planar: bool) -> Result<(), InputError> {
    let needed = least(nodes, planar);
    match available() {
        Some(available) if needed > available => {
            let (needed, available) = (needed / GIB, available / GIB);
            let reason = format!(
                "{elements} elements are too many: {nodes} nodes take at least {needed:.1} GiB, and {available:.1} GiB \
                 are available"
            );
            Err(InputError::inconsistent(field, &reason))
        }
        _ => Ok(()),
    }
}

/// Refuses rods so much finer than thick that their pairs of elements side by side need more memory than available.
pub(super) fn check_pairs(rods: &[Rod]) -> Result<(), InputError> {
    let Some(available) = available() else { return Ok(()) };
    let beside = rods.len().saturating_sub(1).min(NEIGHBOURS) as f64;
    let mut needed = 0.0;
    for (index, rod) in rods.iter().enumerate() {
        let others = rods.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, rod)| rod.num_elements);
        let (elements, most) = (rod.num_elements, others.max().unwrap_or(0) as f64);
        let a_diameter = 2.0 * rod.section.contact_radius * elements as f64 / rod.length;
        needed += BYTES_A_PAIR * beside * elements as f64 * a_diameter.min(most);
        if needed > available {
            let reason = format!(
                "{elements} elements are too many: {a_diameter:.0} lie on a contact diameter, and their pairs with \
                 rods beside them take {:.1} GiB, and {:.1} GiB are available",
                needed / GIB,
                available / GIB
            );
            return Err(InputError::inconsistent(format!("rods.{}.elements", rod.name), reason));
        }
    }
    Ok(())
}
