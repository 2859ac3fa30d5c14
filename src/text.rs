//! Text files of limited size, and tables of numbers with named columns.

pub(crate) mod npy;

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::error::InputError;

/// Most bytes of a scene or of a file of points: a million points with all their digits take 60 MB.
const MOST_BYTES: u64 = 256 << 20;

/// The text that the bytes of a file are.
pub(crate) fn utf8(bytes: Vec<u8>, path: &Path) -> Result<String, InputError> {
    String::from_utf8(bytes).map_err(|_| {
        let reason = "stream did not contain valid UTF-8".to_owned();
        InputError::File { path: path.to_owned(), reason }
    })
}

/// The bytes of a regular file of at most [`MOST_BYTES`].
pub(crate) fn read_regular_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    let refuse = |reason: String| InputError::File { path: path.to_owned(), reason };
    // checked before opening, because opening a pipe without a writer never ends
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        return Err(refuse("is no regular file: only those are read".to_owned()));
    }
    let file = File::open(path).map_err(|e| refuse(e.to_string()))?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(|e| refuse(e.to_string()))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(refuse(format!("holds more than {} MiB", MOST_BYTES >> 20)));
    }
    Ok(bytes)
}

/// First bytes of a checkpoint.
#[cfg(any(feature = "scenes", feature = "runs"))]
pub(crate) const CHECKPOINT: &[u8; 8] = b"SUPRCOIL";
/// Version of the format of checkpoints; raised whenever anything in them changes.
#[cfg(any(feature = "scenes", feature = "runs"))]
pub(crate) const CHECKPOINT_FORMAT: u32 = 17;
/// Bytes before the body of a checkpoint.
#[cfg(any(feature = "scenes", feature = "runs"))]
pub(crate) const CHECKPOINT_HEAD: usize = 28;

/// The nodal state in a checkpoint of the present format, as a `final_state.csv` has it: the first field of its body,
/// with its length before it in digits to the base 128, lowest first. None if it is cut short or of another format.
#[cfg(feature = "scenes")]
pub(crate) fn state_in_checkpoint(bytes: &[u8]) -> Option<&[u8]> {
    let body = bytes.get(CHECKPOINT_HEAD..).filter(|_| bytes[8..12] == CHECKPOINT_FORMAT.to_le_bytes())?;
    let digits = body.iter().position(|byte| byte & 0x80 == 0)? + 1;
    let with = |sum: usize, byte: &u8| sum.checked_mul(128)?.checked_add(usize::from(byte & 0x7f));
    let length = body[..digits].iter().rev().try_fold(0, with)?;
    body[digits..].get(..length)
}

/// The text of a regular file.
pub(crate) fn read_regular(path: &Path) -> Result<String, InputError> {
    utf8(read_regular_bytes(path)?, path)
}

/// Smallest Jaro similarity of a suggested word, as for clap's own suggestions.
#[cfg(feature = "scenes")]
const LIKE: f64 = 0.7;

/// The word that is most similar to another, if any is similar.
#[cfg(feature = "scenes")]
pub(crate) fn likest<'a>(word: &str, words: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let alike = words.map(|other| (strsim::jaro(word, other), other)).filter(|(likeness, _)| *likeness > LIKE);
    // the first of equals
    alike.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, other)| other)
}

/// Cells of a line: separated by its commas or semicolons, or else by blanks and tabs.
pub(crate) fn split(line: &str) -> Vec<&str> {
    match [',', ';'].into_iter().find(|s| line.contains(*s)) {
        Some(separator) => line.split(separator).map(|cell| cell.trim().trim_matches('"')).collect(),
        None => line.split_whitespace().collect(),
    }
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("a finite number expected, found \"{text}\"")),
    }
}

/// A table with named columns of finite numbers.
pub(crate) struct NumberTable {
    /// Line of the column names.
    pub(crate) head: usize,
    pub(crate) names: Vec<String>,
    /// Line and cells.
    pub(crate) rows: Vec<(usize, Vec<f64>)>,
    /// The first cell of each line, as written.
    pub(crate) words: Vec<String>,
}

impl NumberTable {
    /// Reads a table whose first line names the columns.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        Self::parse_with(text, None)
    }

    /// As [`NumberTable::parse`]; a first column with the name `words` holds words.
    pub(crate) fn parse_with(text: &str, words: Option<&str>) -> Result<Self, String> {
        let mut lines = (1..)
            .zip(text.trim_start_matches('\u{feff}').lines())
            .map(|(number, line)| (number, line.split('#').next().unwrap_or_default().trim()))
            .filter(|(_, line)| !line.is_empty());
        let (head, names) = lines.next().ok_or("holds no line with the names of columns")?;
        let names: Vec<String> = split(names).iter().map(|name| name.to_lowercase()).collect();
        if let Some(number) = names.iter().find(|name| name.parse::<f64>().is_ok()) {
            return Err(format!("line {head}: names of columns expected, found {number}"));
        }
        let skipped = usize::from(words.is_some());
        if let Some(word) = words.filter(|word| names[0] != *word) {
            return Err(format!("line {head}: the first column must be {word}, found {}", names[0]));
        }
        if let Some(k) = (1..names.len()).find(|&k| names[..k].contains(&names[k])) {
            return Err(format!("line {head}: column \"{}\" is there twice", names[k]));
        }
        let row = |(number, line): (usize, &str)| {
            let cells = split(line);
            if cells.len() != names.len() {
                return Err(format!(
                    "line {number}: {} cells expected, found {} (\"{line}\")",
                    names.len(),
                    cells.len()
                ));
            }
            let cell = |(name, text): (&String, &&str)| {
                finite(text).map_err(|reason| format!("line {number}, column {name}: {reason}"))
            };
            names
                .iter()
                .zip(&cells)
                .skip(skipped)
                .map(cell)
                .collect::<Result<_, _>>()
                .map(|numbers| (number, numbers, cells[0].to_owned()))
        };
        let rows = lines.map(row).collect::<Result<Vec<_>, _>>()?;
        let words = rows.iter().map(|(_, _, word)| word.clone()).collect();
        let rows = rows.into_iter().map(|(number, numbers, _)| (number, numbers)).collect();
        Ok(Self { head, names: names[skipped..].to_vec(), rows, words })
    }

    /// The columns other than `others`, each with its meaning; unknown ones are refused.
    pub(crate) fn columns<T>(
        &self,
        others: &[&str],
        meaning: impl Fn(&str) -> Option<T>,
        known: &str,
    ) -> Result<Vec<(usize, T)>, String> {
        let of = |(column, name): (usize, &String)| match meaning(name) {
            Some(meaning) => Ok((column, meaning)),
            None => {
                Err(format!("line {}: unknown column \"{name}\": must be {}, {known}", self.head, others.join(", ")))
            }
        };
        let found: Vec<_> = self
            .names
            .iter()
            .enumerate()
            .filter(|(_, name)| !others.contains(&name.as_str()))
            .map(of)
            .collect::<Result<_, _>>()?;
        if found.is_empty() {
            Err(format!("line {}: no columns besides {}", self.head, others.join(", ")))
        } else {
            Ok(found)
        }
    }

    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|found| found == name)
    }
}
