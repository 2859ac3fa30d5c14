//! JSON Schema of scene files, for editors, from the reference of `supercoil help scene`.

use serde_json::{Map, Value, json};

use crate::scene::file::{Key, keys};

/// The schema (draft 2020-12), as text. Editors check keys and types with it and show the meaning of keys.
#[must_use]
pub fn scene_schema() -> String {
    let all = keys();
    let mut tables: Vec<&str> = all.iter().map(|key| key.table.as_str()).collect();
    tables.dedup();
    let definitions: Map<String, Value> =
        tables.iter().map(|&table| (table.to_owned(), object(table, &all, &tables))).collect();
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "scene of supercoil",
        "$ref": "#/$defs/scene",
        "$defs": definitions,
    });
    format!("{schema:#}\n")
}

/// A table and its keys.
fn object(table: &str, all: &[Key], tables: &[&str]) -> Value {
    let own = || all.iter().filter(|key| key.table == table);
    let properties: Map<String, Value> = own().map(|key| (key.name.clone(), property(key, tables))).collect();
    json!({ "type": "object", "properties": properties, "additionalProperties": false })
}

fn property(key: &Key, tables: &[&str]) -> Value {
    let mut description = format!("{}: {}", key.value, key.meaning);
    if !key.allowed.is_empty() {
        description += &format!(" ({})", key.allowed);
    }
    if !key.default.is_empty() {
        description += &format!(". Default: {}", key.default);
    }
    let mut schema = kind(key, tables);
    schema["description"] = description.into();
    schema
}

fn list(of: Value) -> Value {
    json!({ "type": "array", "items": of })
}

fn number() -> Value {
    json!({ "type": "number" })
}

fn text() -> Value {
    json!({ "type": "string" })
}

/// A node in supports, loads and ramps.
fn node() -> Value {
    let arc = json!({ "type": "object", "properties": { "arc": number() }, "additionalProperties": false });
    json!({ "anyOf": [{ "enum": ["start", "end"] }, { "type": "integer", "minimum": 0 }, arc] })
}

/// Type of a key, from the wording of the reference.
fn kind(key: &Key, tables: &[&str]) -> Value {
    let path = key.path();
    let value = key.value.as_str();
    let reference = |name: &str| json!({ "$ref": format!("#/$defs/{name}") });
    let one_or_more = |of: Value| json!({ "anyOf": [of, list(of.clone())] });
    if tables.contains(&path.as_str()) {
        let of = reference(&path);
        return match value {
            _ if value.starts_with("[[") => list(of),
            // a stage may have several ramps of a kind
            _ if key.table == "stages.ramp" => one_or_more(of),
            _ => of,
        };
    }
    match value {
        "list of tables" => list(reference("supports")),
        "table" if key.name == "axis" => json!({}),
        _ if value.starts_with("true or false") => json!({ "type": "boolean" }),
        "axes" => json!({ "anyOf": [{ "type": "boolean" }, list(json!({ "enum": ["x", "y", "z"] }))] }),
        "node" => node(),
        "name or list of names" => one_or_more(text()),
        _ if value.starts_with("word or table") => json!({ "type": ["string", "object"] }),
        "word" => json!({ "enum": words(&key.allowed) }),
        _ if value.starts_with("text") || value == "name" => text(),
        _ if value.starts_with("integer") => json!({ "type": "integer" }),
        _ if value.starts_with("number or [") => one_or_more(number()),
        _ if value.starts_with("number") => number(),
        _ if value.contains("rows") => list(list(number())),
        _ if value.starts_with("[\"") => list(text()),
        _ if value.contains("; table") => json!({ "anyOf": [list(number()), { "type": "object" }] }),
        _ if value.starts_with('[') => list(number()),
        _ if value.starts_with('{') => braces(key),
        _ => json!({}),
    }
}

/// A small table without a heading: `{ rod, to }`, `{ rod, at }`, units.
fn braces(key: &Key) -> Value {
    let inside = key.value.trim_start_matches('{').split('}').next().unwrap_or_default();
    let of = |name: &str| match name {
        "to" => json!({ "anyOf": [number(), list(number())] }),
        "at" => node(),
        "rod" => json!({ "anyOf": [text(), list(text())] }),
        _ => text(),
    };
    let names = inside.split(',').filter_map(|part| part.split('=').next().map(str::trim));
    let properties: Map<String, Value> = names.map(|name| (name.to_owned(), of(name))).collect();
    let object = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if key.table == "stages.ramp" { json!({ "anyOf": [object, list(object.clone())] }) } else { object }
}

/// Allowed strings, as listed in the reference.
fn words(allowed: &str) -> Vec<&str> {
    let list = allowed.split([';', ':']).next().unwrap_or_default();
    list.split(',').map(|word| word.trim().trim_matches('"')).filter(|word| !word.is_empty()).collect()
}
