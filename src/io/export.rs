//! The base pairs of a finished run, from the files in its folder.

use std::path::Path;

use crate::dna::RISE;
use crate::dna::base_pairs::{BasePairs, Nodes};
use crate::error::InputError;
use crate::io::csv::read_state;
use crate::io::record::read_summary;

/// The part of `summary.json` that describes the meshes of rods.
#[derive(serde::Deserialize)]
struct MeshSummary {
    units: crate::scene::Units,
    rods: Vec<MeshOfRod>,
    #[serde(rename = "final")]
    last: Option<Last>,
}

#[derive(serde::Deserialize)]
struct MeshOfRod {
    name: String,
    length: f64,
    closed: bool,
    order: usize,
    #[serde(default)]
    turns_left_out: f64,
}

#[derive(serde::Deserialize)]
struct Last {
    links: Vec<Link>,
}

#[derive(serde::Deserialize)]
struct Link {
    rod: usize,
    link: f64,
}

/// Base pairs of the final state in the folder of a run: of the rod named `rod` (the only one needs no name). `count`
/// is their number; default: its length over [`RISE`].
///
/// # Errors
/// Files that are missing or unreadable; several rods and no name, or an unknown name; a unit of length other than nm;
/// see [`BasePairs::along`].
pub fn base_pairs(dir: &Path, rod: Option<&str>, count: Option<usize>) -> Result<BasePairs, InputError> {
    let summary: MeshSummary = read_summary(dir)?;
    if summary.units.length != "nm" {
        let (field, name) = ("units.length of the scene".to_owned(), summary.units.length);
        return Err(InputError::Name { field, name, allowed: "\"nm\": base pairs have a size".to_owned() });
    }
    let names = || summary.rods.iter().map(|rod| format!("\"{}\"", rod.name)).collect::<Vec<_>>().join(", ");
    let index = match rod {
        None if summary.rods.len() == 1 => Some(0),
        None => None,
        Some(name) => summary.rods.iter().position(|rod| rod.name == name),
    };
    let Some(index) = index else {
        let (field, name) = ("rod".to_owned(), rod.unwrap_or_default().to_owned());
        return Err(InputError::Name { field, name, allowed: format!("one of {}", names()) });
    };
    let head = &summary.rods[index];
    let links = summary.last.as_ref().map_or(&[][..], |last| &last.links);
    let link = links.iter().find(|link| link.rod == index).map_or(0.0, |link| link.link);
    let states = read_state(&dir.join("final_state.csv"))?;
    let Some(state) = states.get(index) else {
        let reason = format!("final_state.csv has {} rods, summary.json {}", states.len(), summary.rods.len());
        return Err(InputError::Inconsistent { field: dir.display().to_string(), reason });
    };
    let by_length = (head.length / RISE).round() as usize + usize::from(!head.closed);
    let (positions, frames) = (&state.positions, &state.frames);
    let (closed, turns_left_out) = (head.closed.then_some(link), head.turns_left_out);
    let nodes = Nodes { positions, frames, order: head.order, closed, turns_left_out };
    BasePairs::along(&nodes, count.unwrap_or(by_length))
}
