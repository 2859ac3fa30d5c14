//! Atomic replacement of files.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

/// Fills the new file at `beside` and renames it to `path`: at any time `path` has either the old or the new content,
/// also after a loss of power.
pub(super) fn fill_and_rename(mut file: File, beside: &Path, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    file.write_all(bytes)?;
    file.sync_all()?;
    std::fs::rename(beside, path)?;
    // the new name must reach the disk, too; where folders cannot be opened the system does it
    if let Some(folder) = path.parent() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if let Ok(folder) = File::open(folder) {
            folder.sync_all().ok();
        }
    }
    Ok(())
}
