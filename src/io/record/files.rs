//! Names of the files of a record.

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::InputError;
use crate::io::csv::legend_of;
use crate::io::folder::SCENE;
use crate::text::read_regular;

pub(super) const COLLECTION: &str = "run.pvd";
pub(super) const TABLE: &str = "table.csv";
/// The final state bit for bit, in the format of checkpoints.
pub(in crate::io) const FINAL_STATE_BITS: &str = "final_state.bin";
pub(super) const FINAL_STATE: &str = "final_state.csv";
pub(super) const RESULTANTS: &str = "resultants.csv";
pub(super) const SITES: &str = "sites.csv";
pub(super) const LINES: &str = "lines.csv";
pub(super) const JOINTS: &str = "joints.csv";
pub(in crate::io) const BASE_PAIRS: &str = "base_pairs.csv";
pub(in crate::io) const SUMMARY: &str = "summary.json";
pub(super) const PICTURE: &str = "picture.png";
pub(super) const FILM_STRIP: &str = "filmstrip.png";
pub(super) const WRITHE: &str = "writhe.svg";
pub(in crate::io) const VIEW: &str = "view.html";
pub(super) const MODES: &str = "modes.vtp";
pub(super) const MODES_PAGE: &str = "modes.html";
pub(super) const MODES_PICTURE: &str = "modes.png";
pub(super) const SENSITIVITIES: &str = "sensitivities.csv";

/// All files except those of single steps and those that explain columns.
const ALL: [&str; 19] = [
    COLLECTION,
    TABLE,
    FINAL_STATE,
    RESULTANTS,
    SITES,
    LINES,
    JOINTS,
    BASE_PAIRS,
    SUMMARY,
    PICTURE,
    FILM_STRIP,
    WRITHE,
    VIEW,
    MODES,
    MODES_PAGE,
    MODES_PICTURE,
    SENSITIVITIES,
    FINAL_STATE_BITS,
    SCENE,
];
/// Tables whose columns are explained in files of their own.
const EXPLAINED: [&str; 6] = [TABLE, FINAL_STATE, RESULTANTS, SITES, LINES, JOINTS];
const STEP: [&str; 2] = ["step_", ".vtp"];
const OBSTACLES: [&str; 2] = ["obstacles_", ".vtp"];

/// A part of `summary.json` in the folder of a finished run.
pub(in crate::io) fn read_summary<T: DeserializeOwned>(dir: &Path) -> Result<T, InputError> {
    check_finished(dir)?;
    let path = dir.join(SUMMARY);
    let refuse = |e: serde_json::Error| InputError::Parse { file: path.display().to_string(), reason: e.to_string() };
    serde_json::from_str(&read_regular(&path)?).map_err(refuse)
}

/// Refuses folders that no run has finished in.
pub(in crate::io) fn check_finished(dir: &Path) -> Result<(), InputError> {
    if dir.join(SUMMARY).exists() {
        return Ok(());
    }
    let reason =
        format!("is no folder of a finished run: there is no {SUMMARY} in it. Give the folder that the run has named");
    Err(InputError::File { path: dir.to_owned(), reason })
}

/// Name of the VTK file of a step.
pub(super) fn of_step(step: usize) -> String {
    let [before, after] = STEP;
    format!("{before}{step:04}{after}")
}

/// Name of the VTK file of the obstacles in a step.
pub(super) fn of_obstacles(step: usize) -> String {
    let [before, after] = OBSTACLES;
    format!("{before}{step:04}{after}")
}

/// The step of a VTK file of rods, by its name.
pub(in crate::io) fn step_of(name: &str) -> Option<usize> {
    number_in(name, STEP)
}

/// The number of a file with a name of this kind.
fn number_in(name: &str, [before, after]: [&str; 2]) -> Option<usize> {
    let number = name.strip_prefix(before)?.strip_suffix(after)?;
    let ours = number.len() >= 4 && number.bytes().all(|b| b.is_ascii_digit());
    if ours { number.parse().ok() } else { None }
}

/// Removes the files of a record in `dir`, and nothing else.
pub(super) fn remove_all(dir: &Path) -> Result<(), InputError> {
    let explains = |name: &str| EXPLAINED.iter().any(|table| legend_of(Path::new(table)) == Path::new(name));
    let is_output = |name: &str| {
        ALL.contains(&name) || [STEP, OBSTACLES].iter().any(|kind| number_in(name, *kind).is_some()) || explains(name)
    };
    let refuse = |path: &Path, e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
    for entry in std::fs::read_dir(dir).map_err(|e| refuse(dir, e))? {
        let path = entry.map_err(|e| refuse(dir, e))?.path();
        if path.file_name().and_then(|name| name.to_str()).is_some_and(is_output) && !path.is_dir() {
            std::fs::remove_file(&path).map_err(|e| refuse(&path, e))?;
        }
    }
    Ok(())
}
