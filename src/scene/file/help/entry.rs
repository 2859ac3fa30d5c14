//! Help on the keys of a scene file.

use std::fmt::Write as _;

use crate::error::InputError;

use crate::text::likest;

use super::reference::{Key, keys};

/// Largest width of a line, in columns.
const WIDTH: usize = 100;

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
    let mut heading = String::new();
    for key in keys {
        if key.heading() != heading {
            let gap = if heading.is_empty() { "" } else { "\n" };
            heading = key.heading();
            writeln!(text, "{gap}{heading}").ok();
        }
        let words = format!("{}: {}", key.form(), key.meaning.replace('`', ""));
        push_wrapped(&mut text, &format!("  {:<20}", key.name), &words);
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
