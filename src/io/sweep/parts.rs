//! The folder of parts, which are replaced atomically.

use std::fs::File;
use std::path::{Path, PathBuf};

use twox_hash::XxHash3_128;

use crate::error::InputError;

use super::super::replace::fill_and_rename;
use super::columns::SweepTable;
use super::parquet::{from_bytes, to_bytes};

/// Folder of the parts in that of a sweep.
const PARTS: &str = "parts";
/// File extension of a part.
const ENDING: &str = "parquet";
/// File extension of a file that is being written.
const TEMPORARY: &str = "tmp";

/// Writes rows of finished cases as a part into the folder of a sweep. Equal rows give equal files.
///
/// # Errors
/// [`InputError::Write`].
pub fn write_part(dir: &Path, rows: &SweepTable) -> Result<(), InputError> {
    let parts = dir.join(PARTS);
    let refuse = |reason: String| InputError::Write { path: parts.clone(), reason };
    std::fs::create_dir_all(&parts).map_err(|e| refuse(e.to_string()))?;
    let bytes = to_bytes(rows).map_err(refuse)?;
    replace(&parts.join(name(&bytes)), &bytes).map_err(|e| refuse(e.to_string()))
}

/// The name of a part: the hash of its content.
fn name(bytes: &[u8]) -> String {
    format!("{:032x}.{ENDING}", XxHash3_128::oneshot(bytes))
}

/// All parts in the folder of a sweep, in the order of their names.
pub(super) fn parts(dir: &Path) -> Result<Vec<PathBuf>, InputError> {
    with_ending(dir, ENDING)
}

fn with_ending(dir: &Path, ending: &str) -> Result<Vec<PathBuf>, InputError> {
    let parts = dir.join(PARTS);
    let refuse = |e: std::io::Error| InputError::File { path: parts.clone(), reason: e.to_string() };
    let entries = match std::fs::read_dir(&parts) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(refuse)?,
    };
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(refuse)?;
    let mut found: Vec<PathBuf> =
        paths.into_iter().filter(|path| path.extension().is_some_and(|found| found == ending)).collect();
    found.sort();
    Ok(found)
}

/// The `wanted` columns of a part; refused if the name is not the hash of the content.
pub(super) fn read_part(path: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<SweepTable, InputError> {
    let refuse = |reason: String| InputError::File { path: path.to_owned(), reason };
    let bytes = std::fs::read(path).map_err(|e| refuse(e.to_string()))?;
    if path.file_name().is_none_or(|found| found != name(&bytes).as_str()) {
        return Err(refuse("is damaged or cut short: its content does not match its name".to_owned()));
    }
    from_bytes(bytes, wanted).map_err(refuse)
}

/// Removes temporary files of killed writers; those of active writers are locked and remain.
pub(super) fn sweep_temporaries(dir: &Path) -> Result<usize, InputError> {
    let left = |path: &PathBuf| {
        let unlocked = File::options().append(true).open(path).and_then(|file| file.try_lock().map_err(Into::into));
        unlocked.and_then(|()| std::fs::remove_file(path)).is_ok()
    };
    Ok(with_ending(dir, TEMPORARY)?.iter().filter(|path| left(path)).count())
}

/// Writes a file atomically, also with several writers. The temporary file is locked.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let (beside, file) = temporary(path)?;
    // temporaries on file systems without locks are not removed
    file.try_lock().ok();
    fill_and_rename(file, &beside, path, bytes).inspect_err(|_| {
        std::fs::remove_file(&beside).ok();
    })
}

/// A new file beside `path`. Processes of several machines may have the same id, so names are tried until one is free.
fn temporary(path: &Path) -> std::io::Result<(PathBuf, File)> {
    let process = std::process::id();
    let mut attempt = 0u32;
    loop {
        let beside = path.with_extension(format!("{process}-{attempt}.{TEMPORARY}"));
        match File::create_new(&beside) {
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists && attempt < u32::MAX => attempt += 1,
            made => return made.map(|file| (beside, file)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::csv::Cell;
    use super::*;

    fn rows(id: &str) -> SweepTable {
        let mut table = SweepTable::default();
        table.push([("case", Cell::from(id)), ("x", Cell::Number(0.1))]);
        table
    }

    #[test]
    fn parts_are_whole_or_refused_and_leftovers_are_swept() {
        let dir = std::env::temp_dir().join(format!("supercoil_parts_{}", std::process::id()));
        std::fs::remove_dir_all(&dir).ok();
        assert_eq!(parts(&dir).unwrap().len(), 0);
        write_part(&dir, &rows("a")).unwrap();
        write_part(&dir, &rows("a")).unwrap();
        write_part(&dir, &rows("b")).unwrap();
        let found = parts(&dir).unwrap();
        assert_eq!(found.len(), 2);
        let bytes = std::fs::read(&found[0]).unwrap();
        for content in [&bytes[..bytes.len() - 1], &bytes[..0], &[&bytes[..], b"x"].concat()] {
            std::fs::write(&found[0], content).unwrap();
            let error = read_part(&found[0], &|_| true).unwrap_err().to_string();
            assert!(error.contains("is damaged or cut short"), "{error}");
        }
        std::fs::write(&found[0], &bytes).unwrap();
        assert_eq!(read_part(&found[0], &|_| true).unwrap().num_rows(), 1);
        // an active writer keeps its file, a dead one does not
        let (alive, file) = temporary(&found[0]).unwrap();
        file.try_lock().unwrap();
        let (dead, _) = temporary(&found[0]).unwrap();
        assert_ne!(alive, dead);
        assert_eq!(sweep_temporaries(&dir).unwrap(), 1);
        assert!(alive.exists() && !dead.exists());
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
