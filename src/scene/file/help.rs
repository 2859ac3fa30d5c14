//! The keys of a scene file as text, from the table in the documentation of [`Scene`](super::Scene).

use std::fmt::Write as _;

use crate::error::InputError;

use crate::text::likest;

/// The keys of a scene file: Markdown tables, one heading for each table of a scene.
pub const REFERENCE: &str = include_str!("../reference.md");

/// Largest width of a line, in columns.
const WIDTH: usize = 100;

/// A key of a scene file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// The table of the key, as `rods.shape`; `scene` for the outermost.
    pub table: String,
    /// The key itself.
    pub name: String,
    /// Type and unit of the value.
    pub value: String,
    /// Legal values; may be empty.
    pub allowed: String,
    /// Default; empty if the key is required or its default depends on others.
    pub default: String,
    /// Meaning.
    pub meaning: String,
}

impl Key {
    /// The key with its table, as `rods.shape.length`.
    pub fn path(&self) -> String {
        if self.table == "scene" { self.name.clone() } else { format!("{}.{}", self.table, self.name) }
    }
}

/// All keys of a scene file, in the order of the reference.
pub fn keys() -> Vec<Key> {
    let (mut table, mut all) = (String::new(), Vec::new());
    for line in REFERENCE.lines() {
        if let Some(heading) = line.strip_prefix("### ") {
            heading.clone_into(&mut table);
        }
        let Some(row) = line.strip_prefix("| `") else { continue };
        let mut cells = row.split('|').map(|cell| cell.replace('`', "").trim().to_owned());
        let mut next = || cells.next().unwrap_or_default();
        let (name, value, allowed, default, meaning) = (next(), next(), next(), next(), next());
        all.push(Key { table: table.clone(), name, value, allowed, default, meaning });
    }
    all
}

/// Help on a key (`excess_link`, `rods.excess_link`), a table (`rods.dna`) or, without a key, on all keys.
///
/// # Errors
/// [`InputError::Name`] if there is no such key, with the most similar one.
pub fn help(key: Option<&str>) -> Result<String, InputError> {
    let all = keys();
    let Some(wanted) = key else { return Ok(listing(&all)) };
    let wanted = wanted.trim_matches(['[', ']']);
    let is_at_end = |path: &str| path == wanted || path.ends_with(&format!(".{wanted}"));
    let fits = |key: &&Key| is_at_end(&key.path()) || is_at_end(&key.table);
    let found: Vec<Key> = all.iter().filter(fits).cloned().collect();
    if !found.is_empty() {
        return Ok(listing(&found));
    }
    let paths: Vec<String> = all.iter().map(Key::path).collect();
    let words = || all.iter().map(|key| key.name.as_str()).zip(paths.iter().map(String::as_str));
    let alike = likest(wanted, words().flat_map(|(name, path)| [name, path]));
    let allowed = match words().find(|(name, path)| alike == Some(*name) || alike == Some(*path)) {
        Some((_, path)) => format!("a key of a scene: did you mean {path}?"),
        None => "a key of a scene, or none to see all".to_owned(),
    };
    Err(InputError::Name { field: "key".to_owned(), name: wanted.to_owned(), allowed })
}

fn listing(keys: &[Key]) -> String {
    let mut text = String::new();
    let mut table = "";
    for key in keys {
        if key.table != table {
            let gap = if table.is_empty() { "" } else { "\n" };
            writeln!(text, "{gap}{}", key.table).ok();
            table = &key.table;
        }
        let default = if key.default.is_empty() { String::new() } else { format!("default: {}", key.default) };
        let more: Vec<&str> = [key.allowed.as_str(), &default].into_iter().filter(|part| !part.is_empty()).collect();
        let more = if more.is_empty() { String::new() } else { format!(" ({})", more.join("; ")) };
        push_wrapped(&mut text, &format!("  {:<20}", key.name), &format!("{}{more}: {}", key.value, key.meaning));
    }
    text
}

/// Adds wrapped text, indented by the width of `head`.
fn push_wrapped(text: &mut String, head: &str, words: &str) {
    let (mut line, mut width) = (head.to_owned(), head.chars().count());
    let indent = width;
    for word in words.split_whitespace() {
        let length = word.chars().count();
        if width > indent && width + length + 1 > WIDTH {
            writeln!(text, "{}", line.trim_end()).ok();
            (line, width) = (" ".repeat(indent), indent);
        }
        line += word;
        line.push(' ');
        width += length + 1;
    }
    writeln!(text, "{}", line.trim_end()).ok();
}
