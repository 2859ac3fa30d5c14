//! Files of results, as the command line writes them; the command line itself.

use std::collections::HashMap;
use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use supercoil::InputError;
use supercoil::dna::base_pairs::{BasePairs, Nodes};
use supercoil::dna::sequence::Sequence;
use supercoil::dna::{HELICAL_REPEAT, RISE};
use supercoil::io::export::Formats;
use supercoil::io::record::Record;
use supercoil::io::schema::scene_schema;
use supercoil::io::view::{GlbOptions, MAX_NODES, Quantity, of_run};
use supercoil::scene;

use crate::refuse;
use crate::scene::Scene;
use crate::state::State;

/// JSON Schema of scenes.
#[pyfunction]
pub fn schema() -> String {
    scene_schema()
}

/// The command line with these arguments; its exit code.
#[pyfunction]
pub fn program(py: Python, arguments: Vec<OsString>) -> u8 {
    py.detach(|| crate::program::program(arguments))
}

/// Writes base pairs of a state in the formats that are named; returns their number.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn export(
    py: Python,
    scene: &Scene,
    state: &State,
    rod: Option<&str>,
    count: Option<usize>,
    sequence: Option<&str>,
    mut formats: HashMap<String, PathBuf>,
) -> PyResult<usize> {
    let files = Formats {
        oxdna: formats.remove("oxdna"),
        xyz: formats.remove("xyz"),
        vect: formats.remove("vect"),
        pdb: formats.remove("pdb"),
        par: formats.remove("par"),
        ref_frames: formats.remove("ref_frames"),
        npy: formats.remove("npy"),
    };
    let written = py.detach(|| {
        let pairs = base_pairs(&scene.0, state, rod, count, sequence)?;
        files.write(&pairs).map(|_| pairs.positions.len())
    });
    written.map_err(refuse::input)
}

/// Writes the files of a run with these states, in order, into a folder; with `for_page` what a page needs, whatever
/// outputs the scene has.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn write_files(
    py: Python,
    scene: &Scene,
    states: Vec<PyRef<State>>,
    dir: PathBuf,
    converged: bool,
    outcome: (String, Option<String>),
    seconds: f64,
    for_page: bool,
) -> PyResult<()> {
    let mut scene = scene.0.clone();
    if for_page {
        let output = &mut scene.output;
        (output.vtk, output.view, output.every, output.picture) = (true, true, 1, false);
    }
    let states: Vec<&State> = states.iter().map(|state| &**state).collect();
    let written = py.detach(|| {
        let mut record = Record::new(&scene, &dir)?;
        for state in &states {
            record.push(state.observation.clone(), state.snapshots())?;
        }
        let (status, failure) = outcome;
        record.set_failure(failure);
        record.finish(converged, &status, seconds)
    });
    written.map_err(refuse::input)
}

/// Writes the states in a folder of a run as binary glTF, coloured by a quantity.
#[pyfunction]
pub fn write_glb(py: Python, dir: PathBuf, path: PathBuf, color: &str) -> PyResult<()> {
    let written = py.detach(|| {
        let options = GlbOptions { color: Quantity::from_name(color)?, ..GlbOptions::default() };
        of_run(&dir, MAX_NODES)?.save_glb(&path, &options)
    });
    written.map_err(refuse::input)
}

/// Base pairs of a rod of a state: those of its sequence where it has one and `count` is not another number.
fn base_pairs(
    scene: &scene::Scene,
    state: &State,
    rod: Option<&str>,
    count: Option<usize>,
    sequence: Option<&str>,
) -> Result<BasePairs, InputError> {
    let names = || scene.model.rods.iter().map(|rod| format!("\"{}\"", rod.name)).collect::<Vec<_>>().join(", ");
    if scene.units.length != "nm" {
        let (field, name) = ("units.length".to_owned(), scene.units.length.clone());
        return Err(InputError::Name { field, name, allowed: "\"nm\": base pairs have a size".to_owned() });
    }
    let index = match rod {
        None if scene.model.rods.len() == 1 => Some(0),
        None => None,
        Some(name) => scene.model.rods.iter().position(|rod| rod.name == name),
    };
    let Some(index) = index else {
        let (field, name) = ("rod".to_owned(), rod.unwrap_or_default().to_owned());
        return Err(InputError::Name { field, name, allowed: format!("one of {}", names()) });
    };
    let sequence = sequence.map(Sequence::parse).transpose()?;
    let at_rest = scene.base_pairs.get(index).and_then(Option::as_ref);
    // a rod with a sequence of its own has as many base pairs, whatever is given
    let by_letters = sequence.as_ref().filter(|_| at_rest.is_none()).map(Sequence::num_bases);
    let count = count.or(by_letters);
    let rod = &scene.model.rods[index];
    let (positions, frames, link) = state.nodes(index);
    let (closed, turns_left_out) = (rod.closed.then_some(link), rod.turns_left_out);
    let (own, repeat) = scene.double_helix(index).unzip();
    let helical_repeat = repeat.unwrap_or(HELICAL_REPEAT);
    let nodes =
        Nodes { positions: &positions, frames: &frames, order: rod.order, closed, turns_left_out, helical_repeat };
    let pairs = match at_rest {
        Some(at_rest) if count.is_none_or(|count| count == at_rest.sequence.num_bases()) => at_rest.along(&nodes)?,
        _ => {
            let by_length = (rod.length / RISE).round() as usize + usize::from(!rod.closed);
            BasePairs::along(&nodes, count.or(own).unwrap_or(by_length))?
        }
    };
    match sequence {
        Some(sequence) => pairs.with_sequence(sequence),
        None => Ok(pairs),
    }
}
