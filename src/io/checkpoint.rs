//! Checkpoints: the state of a run between two steps, on disk, from which a killed run can resume.
//!
//! | bytes | content (integers little endian) |
//! |---|---|
//! | 0–7 | `SUPRCOIL` |
//! | 8–11 | version of the format |
//! | 12–19 | length of the body |
//! | 20–23 | CRC-32 of the body |
//! | 24–27 | CRC-32 of the 24 bytes before |
//! | 28– | body: [`Checkpoint`] in the postcard format, numbers bit for bit; first the nodal state as text, which scenes can start from |
//!
//! A checkpoint is written to a temporary file, flushed to the disk and then renamed: there is a complete one at any
//! time. A damaged checkpoint is refused.

use std::fs::File;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::scene::Scene;
use crate::solve::Restart;
use crate::text::{CHECKPOINT as MAGIC, CHECKPOINT_FORMAT as FORMAT, CHECKPOINT_HEAD as HEADER};

use super::fingerprint::Fingerprint;
use super::record::RecordState;
use super::replace::fill_and_rename;

/// Name of the checkpoint in the folder of a run.
pub const FILE_NAME: &str = "checkpoint.bin";

/// A run between two steps: all data to resume it and to write its outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Positions and frames of all nodes as a `final_state.csv`, from which other scenes can start. The first field,
    /// because they find it there.
    pub nodes: String,
    /// Version of the program that wrote it.
    pub program: String,
    /// Absolute path of the scene file, if the scene came from one.
    pub scene: Option<PathBuf>,
    /// Values of the scene that were replaced, as `KEY=VALUE`.
    pub set: Vec<String>,
    /// Fingerprint of the scene.
    pub(crate) fingerprint: Fingerprint,
    /// Wall time of the run so far \[s\].
    pub seconds: f64,
    /// State of the solver.
    pub restart: Restart,
    /// State of the record.
    pub record: RecordState,
}

impl Checkpoint {
    /// Replaces the checkpoint at `path`; the old one remains until the new one is on the disk.
    ///
    /// # Errors
    /// [`InputError::Write`] if it cannot be written; the old one is then untouched.
    pub fn write(&self, path: &Path) -> Result<(), InputError> {
        let refuse = |reason: String| InputError::Write { path: path.to_owned(), reason };
        let bytes = self.to_bytes().map_err(|e| refuse(e.to_string()))?;
        replace(path, &bytes).map_err(|e| refuse(e.to_string()))
    }

    fn to_bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        let mut bytes = postcard::to_extend(self, vec![0; HEADER])?;
        let (header, body) = bytes.split_at_mut(HEADER);
        header[..8].copy_from_slice(MAGIC);
        header[8..12].copy_from_slice(&FORMAT.to_le_bytes());
        header[12..20].copy_from_slice(&(body.len() as u64).to_le_bytes());
        header[20..24].copy_from_slice(&crc32fast::hash(body).to_le_bytes());
        let check = crc32fast::hash(&header[..24]);
        header[24..].copy_from_slice(&check.to_le_bytes());
        Ok(bytes)
    }

    /// Reads the checkpoint at `path`.
    ///
    /// # Errors
    /// [`InputError::File`] if there is none, or the file is not a checkpoint, of another version, cut short or
    /// damaged.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let refuse = |reason: String| InputError::File { path: path.to_owned(), reason };
        let bytes = std::fs::read(path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => {
                refuse("there is no checkpoint to go on from (a run that came to its end leaves none)".to_owned())
            }
            _ => refuse(e.to_string()),
        })?;
        Self::from_bytes(&bytes).map_err(refuse)
    }

    fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() < MAGIC.len() || &bytes[..8] != MAGIC {
            return Err("is no checkpoint of this program".to_owned());
        }
        if bytes.len() < HEADER {
            return Err(format!("is cut short: {} bytes", bytes.len()));
        }
        let u32_at = |k: usize| bytes[k..k + 4].iter().rev().fold(0u32, |sum, &byte| sum << 8 | u32::from(byte));
        let version = u32_at(8);
        if version != FORMAT {
            let age = if version > FORMAT { "a newer" } else { "an older" };
            return Err(format!("was written by {age} version (format {version}; this program reads format {FORMAT})"));
        }
        if u32_at(24) != crc32fast::hash(&bytes[..24]) {
            return Err("is damaged: its head does not match its checksum".to_owned());
        }
        let (length, body) = (u64::from(u32_at(16)) << 32 | u64::from(u32_at(12)), &bytes[HEADER..]);
        if (body.len() as u64) < length {
            return Err(format!("is cut short: {} of {} bytes", bytes.len(), length + HEADER as u64));
        }
        if body.len() as u64 > length {
            return Err(format!("has {} bytes too many", body.len() as u64 - length));
        }
        if u32_at(20) != crc32fast::hash(body) {
            return Err("is damaged: its content does not match its checksum".to_owned());
        }
        match postcard::take_from_bytes(body) {
            Ok((checkpoint, [])) => Ok(checkpoint),
            Ok((_, rest)) => Err(format!("cannot be understood: {} bytes are left over", rest.len())),
            Err(error) => Err(format!("cannot be understood: {error}")),
        }
    }

    /// Refuses to resume with a scene other than that of the run.
    ///
    /// # Errors
    /// [`InputError::Inconsistent`] naming the part that differs.
    pub(crate) fn check_scene(&self, scene: &Scene) -> Result<(), InputError> {
        let changed = self.fingerprint.differences(&Fingerprint::of(scene));
        if changed.is_empty() {
            return Ok(());
        }
        let reason = format!(
            "differs from the one the checkpoint was written for in {}: restore it, or run the new scene from its \
             start",
            changed.join(" and ")
        );
        Err(InputError::Inconsistent { field: "scene".to_owned(), reason })
    }
}

/// Writes a file so that at every moment either the old or the new content is found under its name.
fn replace(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let beside = PathBuf::from(name);
    // A leftover is removed, also if it is a link, whose target must not be written to.
    if beside.symlink_metadata().is_ok() {
        std::fs::remove_file(&beside)?;
    }
    fill_and_rename(File::create_new(&beside)?, &beside, path, bytes)
}

#[cfg(test)]
mod tests;
