//! The folder of a run: one run at a time, of one scene.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::error::InputError;
use crate::scene::Scene;

/// Copy of the scene: its origin and its text.
pub(super) const SCENE: &str = "scene_as_run.toml";
/// Lock file of a run that writes to the folder. It is never removed, because removal could admit two runs.
const LOCK: &str = ".lock";

/// Creates the folder and locks it until the returned file is dropped or the program ends.
///
/// # Errors
/// [`InputError::Write`] if it cannot be created or written to, or another run has locked it.
pub(super) fn lock(dir: &Path) -> Result<File, InputError> {
    let refuse = |reason: String| InputError::Write { path: dir.to_owned(), reason };
    std::fs::create_dir_all(dir).map_err(|e| refuse(e.to_string()))?;
    let file = File::options().create(true).append(true).open(dir.join(LOCK)).map_err(|e| refuse(e.to_string()))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(refuse("another run is writing to this folder".to_owned())),
        // file systems without locks exclude no one
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// Origin of a scene: its file and the values that were replaced. `None` for a scene from text.
fn origin(scene: &Scene) -> Option<String> {
    let path = scene.path.as_ref()?;
    let set: String = scene.set.iter().map(|assignment| format!("# --set {assignment:?}\n")).collect();
    Some(format!("# {path:?}\n{set}\n"))
}

/// Refuses a folder with the results of another scene.
pub(super) fn check(dir: &Path, scene: &Scene) -> Result<(), InputError> {
    let Ok(found) = std::fs::read_to_string(dir.join(SCENE)) else { return Ok(()) };
    let found = found.split_once('\n').map_or("", |(_, rest)| rest);
    if origin(scene).is_some_and(|origin| found.starts_with(&origin)) {
        return Ok(());
    }
    let of: Vec<&str> = found.lines().map_while(|line| line.strip_prefix("# ")).collect();
    let reason = format!(
        "holds the results of another scene ({}): give another folder, or --force to replace them",
        of.join(" ")
    );
    Err(InputError::Inconsistent { field: dir.display().to_string(), reason })
}

/// Writes a copy of the scene to the folder, with its origin and the program's version.
pub(super) fn describe(dir: &Path, scene: &Scene) -> Result<(), InputError> {
    let Some(origin) = origin(scene) else { return Ok(()) };
    let path = dir.join(SCENE);
    let text = format!("# supercoil {} has run\n{origin}{}", env!("CARGO_PKG_VERSION"), scene.text);
    std::fs::write(&path, text).map_err(|e| InputError::Write { path, reason: e.to_string() })
}
