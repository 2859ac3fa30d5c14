//! The base pairs of a finished run, from the files in its folder.

use std::path::{Path, PathBuf};

use crate::dna::base_pairs::{AtRest, BasePairs, Nodes};
use crate::dna::{HELICAL_REPEAT, RISE};
use crate::error::InputError;
use crate::io::csv::read_state;
use crate::io::record::{BASE_PAIRS, read_summary};

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
    #[serde(default)]
    base_pairs: Option<usize>,
    #[serde(default)]
    helical_repeat: Option<f64>,
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

/// Base pairs of the final state in the folder of a run: of the rod named `rod` (the only one needs no name). Those of
/// a rod with a sequence are placed as [`AtRest`] says and know their bases. Otherwise, or where `count` is another
/// number, they are `count` equally spaced ones; default: those of its `dna`,
/// or its length over [`RISE`]. Their double helix has the `helical_repeat` of its `dna`.
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
    let by_length = || (head.length / RISE).round() as usize + usize::from(!head.closed);
    let (positions, frames) = (&state.positions, &state.frames);
    let (closed, turns_left_out) = (head.closed.then_some(link), head.turns_left_out);
    let helical_repeat = head.helical_repeat.unwrap_or(HELICAL_REPEAT);
    let nodes = Nodes { positions, frames, order: head.order, closed, turns_left_out, helical_repeat };
    match at_rest(dir, index, head.closed)? {
        Some(at_rest) if count.is_none_or(|count| count == at_rest.sequence.num_bases()) => at_rest.along(&nodes),
        _ => BasePairs::along(&nodes, count.or(head.base_pairs).unwrap_or_else(by_length)),
    }
}

/// Files of base pairs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Formats {
    /// oxDNA: NAME.top and NAME.dat; needs the bases.
    pub oxdna: Option<PathBuf>,
    /// XYZ, one point a base pair, nm.
    pub xyz: Option<PathBuf>,
    /// Geomview's VECT, nm.
    pub vect: Option<PathBuf>,
    /// PDB, the atoms P of both strands, Å.
    pub pdb: Option<PathBuf>,
    /// Step parameters as 3DNA's `bp_step.par`.
    pub par: Option<PathBuf>,
    /// Frames as 3DNA's `ref_frames.dat`, Å.
    pub ref_frames: Option<PathBuf>,
    /// NumPy array of frames, shape (pairs, 4, 3), nm.
    pub npy: Option<PathBuf>,
}

impl Formats {
    /// Writes the files that are named; their paths.
    ///
    /// # Errors
    /// [`InputError::Write`]; a format that needs the bases where they are not known; a molecule too large for PDB.
    pub fn write(&self, pairs: &BasePairs) -> Result<Vec<PathBuf>, InputError> {
        let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
        if let Some(name) = &self.oxdna {
            let reason = "needs the bases: give a sequence (--sequence FASTA), because the rod of this run has none";
            let sequence = pairs.sequence.as_ref().ok_or_else(|| InputError::inconsistent("oxdna", reason))?;
            // a name may contain dots
            let named = |ending: &str| PathBuf::from(format!("{}.{ending}", name.display()));
            files.push((named("top"), pairs.oxdna_topology(sequence)?.into_bytes()));
            files.push((named("dat"), pairs.oxdna_configuration().into_bytes()));
        }
        if let Some(path) = &self.pdb {
            let refuse = |reason: String| InputError::inconsistent(path.display().to_string(), reason);
            files.push((path.clone(), pairs.pdb().map_err(refuse)?.into_bytes()));
        }
        files.extend(self.xyz.iter().map(|path| (path.clone(), pairs.xyz().into_bytes())));
        files.extend(self.vect.iter().map(|path| (path.clone(), pairs.vect().into_bytes())));
        files.extend(self.par.iter().map(|path| (path.clone(), pairs.par().into_bytes())));
        files.extend(self.ref_frames.iter().map(|path| (path.clone(), pairs.ref_frames().into_bytes())));
        files.extend(self.npy.iter().map(|path| (path.clone(), pairs.npy())));
        files.iter().try_for_each(|(path, content)| BasePairs::write(path, content))?;
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }
}

/// Base pairs at rest of a rod of the run in a folder, if it has a sequence.
fn at_rest(dir: &Path, rod: usize, closed: bool) -> Result<Option<AtRest>, InputError> {
    let path = dir.join(BASE_PAIRS);
    if path.exists() { AtRest::read(&path, rod, closed) } else { Ok(None) }
}
