//! The folder of a run: one run at a time, of one scene.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::error::InputError;
use crate::scene::Scene;

use super::fingerprint::Fingerprint;

/// The scene as it was run: its hash, where it came from, and its text.
pub(super) const SCENE: &str = "scene_as_run.toml";
/// Lock file of a run that writes to the folder. It is never removed, because removal could admit two runs.
const LOCK: &str = ".lock";

/// Creates the folder and locks it until the returned file is dropped or the program ends.
///
/// # Errors
/// [`InputError::Write`] if it cannot be created or written to, or another run has locked it.
pub(super) fn lock(dir: &Path) -> Result<File, InputError> {
    let refuse = |reason: String| InputError::Write { path: dir.to_owned(), reason };
    if dir.is_file() {
        return Err(refuse("is a file, and results need a folder: give another one with --out".to_owned()));
    }
    std::fs::create_dir_all(dir).map_err(|e| refuse(e.to_string()))?;
    let file = File::options().create(true).append(true).open(dir.join(LOCK)).map_err(|e| refuse(e.to_string()))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(refuse("another run is writing to this folder".to_owned())),
        // file systems without locks exclude no one
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// Comment that begins the line with what the results depend on.
const HASH: &str = "# model hash ";

/// Refuses a folder with the results of another problem, whatever file it came from: one number that differs is enough.
pub(super) fn check(dir: &Path, scene: &Scene) -> Result<(), InputError> {
    let Ok(found) = std::fs::read_to_string(dir.join(SCENE)) else { return Ok(()) };
    let hash = Fingerprint::of(scene).model_hash();
    if found.lines().any(|line| line.strip_prefix(HASH) == Some(hash.as_str())) {
        return Ok(());
    }
    let origin =
        found.lines().skip(1).map_while(|line| line.strip_prefix("# ")).filter(|line| !line.starts_with(&HASH[2..]));
    let of = match origin.collect::<Vec<_>>().join(" ") {
        file if file.is_empty() => String::new(),
        file => format!(" ({file}, as it was then)"),
    };
    let reason = format!(
        "holds the results of another scene{of}: something that decides the results differs. Give another folder, or \
         --force to replace them"
    );
    Err(InputError::Inconsistent { field: dir.display().to_string(), reason })
}

/// Leaves a copy of the scene in the folder, with the program's version, its model hash, its file and the values that
/// were replaced.
pub(super) fn describe(dir: &Path, scene: &Scene) -> Result<(), InputError> {
    let path = dir.join(SCENE);
    let (version, hash) = (env!("CARGO_PKG_VERSION"), Fingerprint::of(scene).model_hash());
    let file = scene.path.as_ref().map(|path| format!("# {path:?}\n")).unwrap_or_default();
    let set: String = scene.set.iter().map(|assignment| format!("# --set {assignment:?}\n")).collect();
    let text = format!("# supercoil {version} has run\n{HASH}{hash}\n{file}{set}\n{}", scene.text);
    std::fs::write(&path, text).map_err(|e| InputError::Write { path, reason: e.to_string() })
}
