//! The program as tests run it: a scene, a folder, the files of a run.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The program, without a terminal.
pub(crate) fn supercoil(arguments: &[impl AsRef<OsStr>]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_supercoil")).args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// An empty folder that no other test uses.
pub(crate) fn folder(name: &str) -> PathBuf {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let dir = std::env::temp_dir().join(format!("supercoil_{}_{count}_{name}", std::process::id()));
    std::fs::remove_dir_all(&dir).ok();
    std::fs::create_dir_all(&dir).unwrap();
    dir
}

/// Runs a scene; exit code, standard output, standard error.
pub(crate) fn run(dir: &Path, scene: &str) -> (i32, String, String) {
    let file = dir.join("scene.toml");
    std::fs::write(&file, scene).unwrap();
    let out = supercoil(&["run", file.to_str().unwrap(), "--force", "--out", dir.join("out").to_str().unwrap()]);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (out.status.code().unwrap(), text(&out.stdout), text(&out.stderr))
}

/// Columns, and rows by column.
pub(crate) type Table = (Vec<String>, Vec<BTreeMap<String, String>>);

/// A CSV file.
pub(crate) fn table(path: &Path) -> Table {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let columns: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| columns.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    let rows = reader.records().map(|record| row(record.unwrap())).collect();
    (columns.clone(), rows)
}

/// A number of a row.
pub(crate) fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} = {:?}", row[column]))
}
