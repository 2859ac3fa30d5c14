//! Contents of the parts of a sweep: progress, and one table of all rows.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::error::InputError;

use super::case::{CONVERGED, ID, MESSAGE, SECONDS, STATUS};
use super::columns::SweepTable;
use super::parquet::to_bytes;
use super::parts::{parts, read_part, replace, sweep_temporaries};
use super::plan::{Case, Plan};

/// The collected table in the folder of a sweep.
const TABLE: &str = "table.parquet";
/// Most failures that are listed one by one.
const MOST_FAILURES: usize = 5;

/// Cases that have rows in the parts.
struct Finished {
    /// Status and message by id.
    cases: HashMap<String, (String, String)>,
    /// Parts that are refused.
    damaged: Vec<String>,
}

/// Reads the parts in the folder of a sweep. Damaged ones are skipped; their cases count as missing.
fn finished(dir: &Path) -> Result<Finished, InputError> {
    let mut found = Finished { cases: HashMap::new(), damaged: Vec::new() };
    for path in parts(dir)? {
        match read_part(&path, &|name| [ID, STATUS, MESSAGE].contains(&name)) {
            Err(error) => found.damaged.push(error.to_string()),
            Ok(table) => {
                let text = |name: &str, row: usize| table.column(name).and_then(|values| values.text(row));
                for row in 0..table.num_rows() {
                    if let Some(id) = text(ID, row) {
                        let end = || (text(STATUS, row).unwrap_or_default(), text(MESSAGE, row).unwrap_or_default());
                        found.cases.entry(id).or_insert_with(end);
                    }
                }
            }
        }
    }
    Ok(found)
}

/// Ids of the cases that have rows in the folder of a sweep, of any plan.
///
/// # Errors
/// Parts that cannot be read.
pub fn finished_ids(dir: &Path) -> Result<HashSet<String>, InputError> {
    Ok(finished(dir)?.cases.into_keys().collect())
}

/// Progress of a sweep.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SweepStatus {
    /// Cases of the plan.
    pub cases: usize,
    /// Number of finished cases by status.
    pub by_status: BTreeMap<String, usize>,
    /// Numbers of the cases that have no rows, ascending.
    pub missing: Vec<usize>,
    /// Numbers of the cases that did not converge, with the values that they replace, their status and message.
    pub failures: Vec<(usize, Vec<String>, String)>,
    /// Damaged parts, as text; their cases are missing.
    pub damaged: Vec<String>,
    /// The base scene.
    pub scene: PathBuf,
}

/// Progress of the sweep in a folder.
///
/// # Errors
/// A plan or parts that cannot be read.
pub fn status(dir: &Path) -> Result<SweepStatus, InputError> {
    let plan = Plan::read(dir)?;
    let Finished { cases, damaged } = finished(dir)?;
    let (mut by_status, mut missing, mut failures) = (BTreeMap::new(), Vec::new(), Vec::new());
    for (index, case) in plan.cases().iter().enumerate() {
        match cases.get(&case.id) {
            None => missing.push(index),
            Some((status, message)) => {
                *by_status.entry(status.clone()).or_default() += 1;
                if status != CONVERGED {
                    failures.push((index, plan.set(case), format!("{status}: {message}")));
                }
            }
        }
    }
    let scene = plan.base_scene().to_owned();
    Ok(SweepStatus { cases: plan.cases().len(), by_status, missing, failures, damaged, scene })
}

impl SweepStatus {
    /// Numbers of the shards, of so many, that have cases without rows, ascending.
    #[must_use]
    pub fn missing_shards(&self, count: usize) -> Vec<usize> {
        let mut shards: Vec<usize> = self.missing.iter().map(|case| case % count.max(1)).collect();
        shards.sort_unstable();
        shards.dedup();
        shards
    }
}

impl fmt::Display for SweepStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} cases", self.cases)?;
        self.by_status.iter().try_for_each(|(status, count)| write!(f, ", {count} {status}"))?;
        write!(f, ", {} missing", self.missing.len())?;
        self.damaged.iter().try_for_each(|part| write!(f, "\nrefused: {part}"))?;
        for (index, set, why) in self.failures.iter().take(MOST_FAILURES) {
            let first = why.lines().next().unwrap_or_default();
            write!(f, "\ncase {index} {first}\n  to look at it: supercoil run {}", self.scene.display())?;
            set.iter().try_for_each(|assignment| write!(f, " --set {}", quoted(assignment)))?;
        }
        match self.failures.len().saturating_sub(MOST_FAILURES) {
            0 => Ok(()),
            more => write!(f, "\n{more} more did not converge"),
        }
    }
}

/// A word quoted for a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-.=/".contains(c);
    if word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// Ascending numbers in the notation of job schedulers: `0,3,7-9`.
#[must_use]
pub fn ranges(numbers: &[usize]) -> String {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => runs.push([number, number]),
        }
    }
    let run = |[first, last]: &[usize; 2]| if first == last { first.to_string() } else { format!("{first}-{last}") };
    runs.iter().map(run).collect::<Vec<_>>().join(",")
}

/// A collected sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Collected {
    /// All rows, in the order of the plan.
    pub table: SweepTable,
    /// Numbers of the cases that have no rows, ascending.
    pub missing: Vec<usize>,
}

/// Merges the rows of a plan's cases, in the order of the plan; rows of other cases are left out.
///
/// # Errors
/// [`InputError::Inconsistent`] if a case has two sets of rows that differ in anything but the wall time.
pub fn merge(plan: &Plan, tables: &[SweepTable]) -> Result<Collected, InputError> {
    let mut places: HashMap<&str, Vec<(usize, Range<usize>)>> =
        plan.cases().iter().map(|case| (case.id.as_str(), Vec::new())).collect();
    for (index, table) in tables.iter().enumerate() {
        for (id, rows) in runs(table) {
            if let Some(places) = places.get_mut(id.as_str()) {
                places.push((index, rows));
            }
        }
    }
    let (mut collected, mut missing) = (SweepTable::default(), Vec::new());
    for (number, case) in plan.cases().iter().enumerate() {
        let Some([(first, rows), others @ ..]) = places.get(case.id.as_str()).map(Vec::as_slice) else {
            missing.push(number);
            continue;
        };
        for (other, other_rows) in others {
            let (a, b) = (&tables[*first], &tables[*other]);
            if let Some(column) = a.difference(rows.clone(), b, other_rows.clone(), &[SECONDS]) {
                return Err(unequal(number, case, &column));
            }
        }
        collected.append(&tables[*first], rows.clone());
    }
    Ok(Collected { table: collected, missing })
}

fn unequal(number: usize, case: &Case, column: &str) -> InputError {
    let reason = format!(
        "is there twice, with unequal rows (first difference: {column}): its parts come from different programs or \
         machines; remove those of one of them, and run again"
    );
    InputError::Inconsistent { field: format!("case {number} ({})", case.id), reason }
}

/// Rows of each case; those of one case are consecutive.
fn runs(table: &SweepTable) -> Vec<(String, Range<usize>)> {
    let mut runs: Vec<(String, Range<usize>)> = Vec::new();
    let Some(ids) = table.column(ID) else { return runs };
    for row in 0..table.num_rows() {
        match (ids.text(row), runs.last_mut()) {
            (Some(id), Some((last, rows))) if *last == id => rows.end = row + 1,
            (Some(id), _) => runs.push((id, row..row + 1)),
            (None, _) => {}
        }
    }
    runs
}

/// Collects the parts in the folder of a sweep into its `table.parquet`, and removes temporary files of killed writers.
///
/// # Errors
/// As [`merge`]; a plan or parts that cannot be read; [`InputError::Write`].
pub fn collect(dir: &Path) -> Result<Collected, InputError> {
    let plan = Plan::read(dir)?;
    // the status reports damaged parts; their cases are missing
    let tables: Vec<SweepTable> = parts(dir)?.iter().filter_map(|path| read_part(path, &|_| true).ok()).collect();
    let collected = merge(&plan, &tables)?;
    let path = dir.join(TABLE);
    let refuse = |reason: String| InputError::Write { path: path.clone(), reason };
    let bytes = to_bytes(&collected.table).map_err(refuse)?;
    replace(&path, &bytes).map_err(|e| refuse(e.to_string()))?;
    sweep_temporaries(dir)?;
    Ok(collected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_the_words_of_schedulers() {
        assert_eq!(ranges(&[]), "");
        assert_eq!(ranges(&[0, 1, 2, 5, 7, 8]), "0-2,5,7-8");
    }
}
