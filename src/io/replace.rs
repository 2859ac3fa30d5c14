//! Files that are there whole or not at all.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

/// Fills a new file that stands beside `path` and gives it that name: at every moment either the old or the new content
/// is found there, also after a loss of power.
pub(super) fn fill_and_rename(mut file: File, beside: &Path, path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    file.write_all(bytes)?;
    file.sync_all()?;
    std::fs::rename(beside, path)?;
    // the new name, too, has to reach the disk; where folders cannot be opened this is left to the system
    if let Some(folder) = path.parent() {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if let Ok(folder) = File::open(folder) {
            folder.sync_all().ok();
        }
    }
    Ok(())
}
