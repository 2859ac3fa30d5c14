//! Errors in a scene's text, in words of its user.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::text::likest;

/// Most characters shown of a word that is quoted, because serde writes 1e300 with all its zeros.
const LONGEST_WORD: usize = 40;

/// Names of types in serde's messages and in ours.
const TYPES: [(&str, &str); 8] = [
    ("usize", "a whole number of at least 0"),
    ("i64", "a whole number"),
    ("i32", "a whole number"),
    ("f64", "a number"),
    ("a boolean", "true or false"),
    ("a string", "text in quotes"),
    ("variant identifier", "text in quotes"),
    ("a list of tables", "a list of tables: each begins with its name in double brackets, such as [[rods]]"),
];

/// Message of an error in a scene's text: with the allowed word that is most similar to an unknown one, and the table
/// in which a key is missing.
pub(in crate::scene::file) fn in_a_users_words(error: &toml::de::Error, scene: &str) -> String {
    let words: Vec<&str> = error.message().split('`').skip(1).step_by(2).collect();
    let suggestion = match words.as_slice() {
        [found, allowed @ ..] if error.message().starts_with("unknown ") => likest(found, allowed.iter().copied()),
        _ => None,
    };
    let hint = suggestion.map(|word| format!("did you mean `{word}`?"));
    let text =
        shortened(&error.to_string().replace("invalid type: map", "invalid type: table").replace(" as i128", ""));
    // a key may follow on a line of its own
    let named = |(before, after): (&str, &str)| {
        let (found, rest) = after.split_at(after.find('\n').unwrap_or(after.len()));
        let (_, said) = TYPES.iter().find(|(name, _)| *name == found)?;
        Some(format!("{before}expected {said}{rest}"))
    };
    let text = text.rsplit_once("expected ").and_then(named).unwrap_or(text);
    let is_missing = error.message().starts_with("missing field");
    let place = error.span().filter(|_| is_missing).and_then(|span| place(scene, span.start));
    let place = place.map(|place| format!(" in {place}"));
    format!("{}{}", text.trim_end(), hint.map(|hint| format!("\n{hint}")).or(place).unwrap_or_default())
}

/// Text in which each long number or word between backquotes is cut.
fn shortened(text: &str) -> String {
    let cut = |(index, part): (usize, &str)| match part.char_indices().nth(LONGEST_WORD) {
        Some((end, _)) if index % 2 == 1 => format!("{}…", &part[..end]),
        _ => part.to_owned(),
    };
    text.split('`').enumerate().map(cut).collect::<Vec<_>>().join("`")
}

/// The innermost table that begins at or around a place of the text, as `--set` addresses it: entries of lists by name
/// or by index.
fn place(scene: &str, at: usize) -> Option<String> {
    let table = DeTable::parse(scene).ok()?;
    in_table(table.get_ref(), at)
}

fn in_table(table: &DeTable, at: usize) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let inner = in_value(value, at)?;
        Some(format!("{}{inner}", key.get_ref()))
    })
}

/// Text after the key of the value that contains the place.
fn in_value(value: &Spanned<DeValue>, at: usize) -> Option<String> {
    let inside = match value.get_ref() {
        DeValue::Table(table) => in_table(table, at).map(|inner| format!(".{inner}")),
        DeValue::Array(list) => list.iter().enumerate().find_map(|(index, entry)| {
            let inner = in_value(entry, at)?;
            let name = entry.get_ref().get("name").and_then(|name| name.get_ref().as_str());
            Some(format!(".{}{inner}", name.map_or_else(|| index.to_string(), str::to_owned)))
        }),
        _ => None,
    };
    let is_table = matches!(value.get_ref(), DeValue::Table(_));
    inside.or_else(|| (is_table && value.span().contains(&at)).then(String::new))
}
