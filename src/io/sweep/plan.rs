//! The plan of a sweep: its cases, each with an id.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use twox_hash::XxHash3_128;

use crate::error::InputError;
use crate::scene::Scene;
use crate::scene::file::Canonical;
use crate::text::read_regular;

use super::case::check_key;
use super::file::{Rows, SweepText};
use super::parts::replace;

/// Name of the plan in the folder of a sweep.
pub const PLAN: &str = "plan.jsonl";
/// Version of plans, ids and columns; raised whenever the rows of a scene change.
const FORMAT: u32 = 1;
/// Longest string that may be a file name.
const LONGEST_PATH: usize = 1024;

/// A case: one run of the base scene with values replaced.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// 32 hexadecimal digits: the hash of all that determines the case's rows.
    pub id: String,
    /// Values of this case alone, as `KEY=VALUE`.
    pub set: Vec<String>,
}

/// Data that all cases share.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    /// Version of the format.
    supercoil_sweep: u32,
    /// The base scene's file, absolute; files that it names are found relative to it.
    scene: PathBuf,
    rows: Rows,
    set: Vec<String>,
    text: String,
}

/// A planned sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    head: Head,
    cases: Vec<Case>,
}

impl Plan {
    /// Plans a sweep file. Combinations with the same scene are one case. Scenes are checked when they are run.
    ///
    /// # Errors
    /// Files that cannot be read; illegal axes; keys that do not exist in the base scene.
    pub fn of_file(path: &Path) -> Result<Self, InputError> {
        let sweep = SweepText::read(path)?;
        let scene = path.parent().unwrap_or(Path::new("")).join(&sweep.scene);
        let text = read_regular(&scene)?;
        let absolute = |e: std::io::Error| InputError::File { path: scene.clone(), reason: e.to_string() };
        let scene = std::path::absolute(&scene).map_err(absolute)?;
        let head = Head { supercoil_sweep: FORMAT, scene, rows: sweep.rows, set: sweep.shared(), text };
        let mut names = CaseIds::new(&head)?;
        let mut seen = HashSet::new();
        let mut cases = Vec::new();
        for set in sweep.cases()? {
            set.iter().try_for_each(|assignment| check_key(assignment))?;
            let id = names.id(&set)?;
            if seen.insert(id.clone()) {
                cases.push(Case { id, set });
            }
        }
        Ok(Self { head, cases })
    }

    /// Reads the plan in the folder of a sweep.
    ///
    /// # Errors
    /// A file that is missing, cut short or of another version.
    pub fn read(dir: &Path) -> Result<Self, InputError> {
        let path = dir.join(PLAN);
        let text = std::fs::read_to_string(&path).map_err(|e| {
            let reason = match e.kind() {
                std::io::ErrorKind::NotFound => "is not there: supercoil sweep plan makes it".to_owned(),
                _ => e.to_string(),
            };
            InputError::File { path: path.clone(), reason }
        })?;
        Self::from_text(&text, &path.display().to_string())
    }

    /// Reads a plan from the text of [`Plan::to_text`]; errors contain `name`.
    ///
    /// # Errors
    /// As [`Plan::read`].
    pub fn from_text(text: &str, name: &str) -> Result<Self, InputError> {
        let refuse = |line: usize, e: serde_json::Error| InputError::Parse {
            file: name.to_owned(),
            reason: format!("line {}: {e}", line + 1),
        };
        let mut lines = text.lines().enumerate();
        let (_, head) = lines.next().unwrap_or_default();
        let head: Head = serde_json::from_str(head).map_err(|e| refuse(0, e))?;
        if head.supercoil_sweep != FORMAT {
            let reason = format!("is of format {}, this program reads format {FORMAT}", head.supercoil_sweep);
            return Err(InputError::Parse { file: name.to_owned(), reason });
        }
        let case = |(line, text): (usize, &str)| serde_json::from_str(text).map_err(|e| refuse(line, e));
        Ok(Self { head, cases: lines.map(case).collect::<Result<_, _>>()? })
    }

    /// The plan as text: a line that all cases share, then a line a case.
    ///
    /// # Errors
    /// A path that is not Unicode.
    pub fn to_text(&self) -> Result<String, InputError> {
        let refuse = |e: serde_json::Error| InputError::Inconsistent { field: PLAN.into(), reason: e.to_string() };
        let mut text = serde_json::to_string(&self.head).map_err(refuse)? + "\n";
        for case in &self.cases {
            text += &(serde_json::to_string(case).map_err(refuse)? + "\n");
        }
        Ok(text)
    }

    /// Writes the plan into the folder of a sweep, which is created if need be. Rows of an earlier plan remain.
    ///
    /// # Errors
    /// [`InputError::Write`].
    pub fn write(&self, dir: &Path) -> Result<(), InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: dir.join(PLAN), reason: e.to_string() };
        std::fs::create_dir_all(dir).map_err(refuse)?;
        replace(&dir.join(PLAN), self.to_text()?.as_bytes()).map_err(refuse)
    }

    /// The cases.
    #[must_use]
    pub fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// Steps that become rows.
    #[must_use]
    pub fn rows(&self) -> Rows {
        self.head.rows
    }

    /// The plan of a part of the cases.
    ///
    /// # Errors
    /// [`InputError::Count`] for an index beyond the cases.
    pub fn only(&self, indices: &[usize]) -> Result<Self, InputError> {
        let case = |&index: &usize| {
            let allowed = "the number of a case, from 0";
            let beyond = || InputError::Count { field: "case".to_owned(), value: index, allowed };
            self.cases.get(index).cloned().ok_or_else(beyond)
        };
        Ok(Self { head: self.head.clone(), cases: indices.iter().map(case).collect::<Result<_, _>>()? })
    }

    /// All values that a case replaces, as `KEY=VALUE`.
    #[must_use]
    pub fn set(&self, case: &Case) -> Vec<String> {
        self.head.set.iter().chain(&case.set).cloned().collect()
    }

    /// The file of the base scene.
    #[must_use]
    pub(crate) fn base_scene(&self) -> &Path {
        &self.head.scene
    }

    /// The scene of a case, checked.
    ///
    /// # Errors
    /// As [`Scene::from_toml`].
    pub fn scene(&self, case: &Case) -> Result<Scene, InputError> {
        Scene::from_toml_with(&self.head.text, &self.set(case), self.base_dir())
    }

    fn base_dir(&self) -> &Path {
        self.head.scene.parent().unwrap_or(Path::new(""))
    }
}

/// Computation of the ids of cases.
struct CaseIds<'a> {
    head: &'a Head,
    scene: toml::Table,
    /// Hashes of the files that scenes name.
    files: HashMap<String, u128>,
}

impl<'a> CaseIds<'a> {
    fn new(head: &'a Head) -> Result<Self, InputError> {
        let name = head.scene.display().to_string();
        let refuse = |e: toml::de::Error| InputError::Parse { file: name.clone(), reason: e.to_string() };
        Ok(Self { head, scene: toml::from_str(&head.text).map_err(refuse)?, files: HashMap::new() })
    }

    fn id(&mut self, set: &[String]) -> Result<String, InputError> {
        let all: Vec<String> = self.head.set.iter().chain(set).cloned().collect();
        let Canonical { mut text, words } = Canonical::new(&self.scene, &all)?;
        for word in words {
            if let Some(hash) = self.file(&word)? {
                text += &format!("\n{word:?} {hash:032x}");
            }
        }
        let text = format!("{FORMAT} {:?}\n{text}", self.head.rows);
        Ok(format!("{:032x}", XxHash3_128::oneshot(text.as_bytes())))
    }

    /// The hash of the file of this name, if there is one.
    fn file(&mut self, word: &str) -> Result<Option<u128>, InputError> {
        if let Some(&hash) = self.files.get(word) {
            return Ok(Some(hash));
        }
        let path = self.head.scene.parent().unwrap_or(Path::new("")).join(word);
        if word.is_empty() || word.len() > LONGEST_PATH || !path.is_file() {
            return Ok(None);
        }
        let refuse = |e: std::io::Error| InputError::File { path: path.clone(), reason: e.to_string() };
        let hash = XxHash3_128::oneshot(&std::fs::read(&path).map_err(refuse)?);
        self.files.insert(word.to_owned(), hash);
        Ok(Some(hash))
    }
}
