//! The keys of a scene file, read off its types: for help, for the page of the documentation, for editors.

use std::fmt::Write as _;

use schemars::generate::SchemaSettings;
use serde_json::{Map, Value};

use crate::scene::file::syntax::SceneText;

/// Most keys of a table that is described in the row of its key, as `{ rod, to }`, in place of a table of its own.
const SMALL: usize = 2;

/// A key of a scene file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key {
    /// The table of the key, as `rods.shape`; `scene` for the outermost.
    pub table: String,
    /// The kind of table that has the key, where it has kinds.
    pub kind: Option<String>,
    /// The key itself.
    pub name: String,
    /// Form and unit of the value.
    pub value: String,
    /// Legal values; may be empty.
    pub allowed: String,
    /// Whether the key must be given.
    pub is_required: bool,
    /// Default, in words where it depends on other keys; empty if the key is required.
    pub default: String,
    /// Meaning.
    pub meaning: String,
}

impl Key {
    /// The key with its table, as `rods.shape.length`.
    pub fn path(&self) -> String {
        path(&self.table, &self.name)
    }

    /// Form, unit, range and default of the value, without Markdown: `number, L (> 0; required)`.
    pub(super) fn form(&self) -> String {
        let default = if self.is_required { "required".to_owned() } else { format!("default: {}", self.default) };
        format!("{} ({})", self.value, joined(&self.allowed, &default)).replace('`', "")
    }

    /// The table with its kind, as `rods.shape, kind = "line"`.
    pub(super) fn heading(&self) -> String {
        match &self.kind {
            Some(kind) => format!("{}, kind = \"{kind}\"", self.table),
            None => self.table.clone(),
        }
    }
}

fn path(table: &str, name: &str) -> String {
    if table == "scene" { name.to_owned() } else { format!("{table}.{name}") }
}

/// All keys of a scene file, table by table.
pub fn keys() -> Vec<Key> {
    let schema = schema();
    let mut reader = Reader::of(&schema);
    reader.table("scene", &schema);
    reader.keys
}

/// The reference of keys as Markdown: a heading and a table for each table of a scene.
pub fn reference() -> String {
    let schema = schema();
    let mut reader = Reader::of(&schema);
    reader.table("scene", &schema);
    let mut text = format!("{}\n", description(&schema));
    let mut heading = String::new();
    for key in &reader.keys {
        if key.heading() != heading {
            heading = key.heading();
            writeln!(text, "\n### {heading}\n").ok();
            let intro = reader.intros.iter().find(|(of, intro)| *of == heading && !intro.is_empty());
            if let Some((_, intro)) = intro.filter(|_| heading != "scene") {
                writeln!(text, "{intro}\n").ok();
            }
            text += "| key | value | allowed | default | meaning |\n|---|---|---|---|---|\n";
        }
        let default = if key.is_required { "required" } else { &key.default };
        writeln!(text, "| `{}` | {} | {} | {default} | {} |", key.name, key.value, key.allowed, key.meaning).ok();
    }
    text
}

/// The JSON Schema (draft 2020-12) of scene files, for editors, which show descriptions and no keywords of others.
#[cfg(feature = "runs")]
pub(crate) fn schema_for_editors() -> Value {
    let schema = schema();
    let mut described = schema.clone();
    Reader::of(&schema).describe(&mut described);
    described
}

/// The schema of the types. TOML has no null: a key that may be left out has the type that it has when given.
fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = generator.into_root_schema_for::<SceneText>().to_value();
    tidy(&mut schema);
    schema
}

/// Takes out null and the names of Rust's number types.
fn tidy(schema: &mut Value) {
    match schema {
        Value::Array(all) => all.iter_mut().for_each(tidy),
        Value::Object(object) => {
            if object.get("format").is_some_and(Value::is_string) {
                object.shift_remove("format");
            }
            if object.get("default").is_some_and(Value::is_null) {
                object.shift_remove("default");
            }
            if let Some(Value::Array(types)) = object.get("type") {
                let given = types.iter().find(|name| *name != "null").cloned();
                object.extend(given.map(|name| ("type".to_owned(), name)));
            }
            if let Some(Value::Array(any)) = object.get_mut("anyOf") {
                any.retain(|one| one["type"] != "null");
                if let [only] = any.as_slice() {
                    let only = only.as_object().cloned().unwrap_or_default();
                    object.shift_remove("anyOf");
                    for (key, value) in only {
                        object.entry(key).or_insert(value);
                    }
                }
            }
            object.values_mut().for_each(tidy);
        }
        _ => {}
    }
}

/// Text of a doc comment on one line, without what is meant for Rust callers.
fn description(schema: &Value) -> String {
    let text = schema["description"].as_str().unwrap_or_default();
    let end = [" Legal:", " `None`"].iter().filter_map(|mark| text.replace('\n', " ").find(mark)).min();
    text[..end.unwrap_or(text.len())].split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Reads tables and their keys off a schema.
struct Reader<'a> {
    definitions: Option<&'a Map<String, Value>>,
    keys: Vec<Key>,
    /// Text above the keys of a heading.
    intros: Vec<(String, String)>,
    /// Definitions that have been described, and where.
    told: Vec<(String, String)>,
}

/// Definition that a value refers to.
struct Referred<'a> {
    name: &'a str,
    definition: &'a Value,
    /// Whether it is a list of these.
    is_list: bool,
}

impl Referred<'_> {
    fn is_table(&self) -> bool {
        self.definition.get("properties").is_some() || !kinds(self.definition).is_empty()
    }

    fn is_small(&self) -> bool {
        let holds_tables = |keys: &Map<String, Value>| keys.values().any(|key| key.get("$ref").is_some());
        self.definition["properties"].as_object().is_some_and(|keys| keys.len() <= SMALL && !holds_tables(keys))
    }
}

/// Kinds of a table, if it has any: the word and the schema of each.
fn kinds(definition: &Value) -> Vec<(&str, &Value)> {
    let all = definition["oneOf"].as_array().map(Vec::as_slice).unwrap_or_default();
    all.iter().filter_map(|one| Some((one["properties"]["kind"]["const"].as_str()?, one))).collect()
}

/// Words of an enumeration.
fn words(definition: &Value) -> Vec<&str> {
    let listed = definition["enum"].as_array().map(Vec::as_slice).unwrap_or_default();
    let told = definition["oneOf"].as_array().map(Vec::as_slice).unwrap_or_default();
    let told = told.iter().flat_map(|one| one["const"].as_str().into_iter().chain(words(one)));
    listed.iter().filter_map(Value::as_str).chain(told).collect()
}

impl<'a> Reader<'a> {
    fn of(schema: &'a Value) -> Self {
        Self { definitions: schema["$defs"].as_object(), keys: Vec::new(), intros: Vec::new(), told: Vec::new() }
    }

    fn referred(&self, property: &Value) -> Option<Referred<'a>> {
        let list = || Some((property["items"]["$ref"].as_str()?, true));
        let one = || Some((property["$ref"].as_str().or(property["anyOf"][0]["$ref"].as_str())?, false));
        let (reference, is_list) = one().or_else(list)?;
        let (name, definition) = self.definitions?.get_key_value(reference.rsplit('/').next()?)?;
        Some(Referred { name, definition, is_list })
    }

    /// Puts form, unit, range and default of each key into its description.
    #[cfg(feature = "runs")]
    fn describe(&self, schema: &mut Value) {
        match schema {
            Value::Array(all) => all.iter_mut().for_each(|one| self.describe(one)),
            Value::Object(object) => {
                let required = required(object.get("required"));
                for (name, property) in
                    object.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten()
                {
                    if property.get("description").is_some() {
                        let key = self.key(name, property, required.contains(name));
                        property["description"] = format!("{}: {}", key.form(), key.meaning).into();
                    }
                }
                object.values_mut().for_each(|inner| self.describe(inner));
            }
            _ => {}
        }
    }

    /// A key of the outermost table.
    fn key(&self, path: &str, property: &Value, is_required: bool) -> Key {
        let referred = self.referred(property);
        Key {
            table: "scene".to_owned(),
            kind: None,
            name: path.to_owned(),
            value: value(path, property, referred.as_ref()),
            allowed: allowed(property, referred.as_ref()),
            is_required,
            default: if is_required { String::new() } else { default(property) },
            meaning: description(property),
        }
    }

    /// A table: its own keys, then the tables in it.
    fn table(&mut self, table: &str, schema: &'a Value) {
        let kinds = kinds(schema);
        if kinds.is_empty() {
            self.properties(table, None, schema);
            return;
        }
        self.keys.push(Key {
            table: table.to_owned(),
            kind: None,
            name: "kind".to_owned(),
            value: "word".to_owned(),
            allowed: listed(kinds.iter().map(|(word, _)| *word)),
            is_required: true,
            default: String::new(),
            meaning: "Kind, which has the keys below.".to_owned(),
        });
        for (kind, schema) in kinds {
            self.properties(table, Some(kind), schema);
        }
    }

    fn properties(&mut self, table: &str, kind: Option<&str>, schema: &'a Value) {
        let Some(properties) = schema["properties"].as_object() else { return };
        let required = required(schema.get("required"));
        let mut inner = Vec::new();
        for (name, property) in properties.iter().filter(|(name, _)| kind.is_none() || *name != "kind") {
            let path = path(table, name);
            let mut key = Key {
                table: table.to_owned(),
                kind: kind.map(str::to_owned),
                name: name.clone(),
                ..self.key(&path, property, required.contains(name))
            };
            let referred = self.referred(property);
            if let Some(referred) = referred.filter(|referred| referred.is_table() && !referred.is_small()) {
                let told = self.told.iter().find(|(of, _)| of == referred.name);
                let place = told.map_or_else(|| format!("see `{path}`"), |(_, at)| format!("as `{at}`"));
                key.allowed = joined(&place, &key.allowed);
                if told.is_none() {
                    self.told.push((referred.name.to_owned(), path.clone()));
                    inner.push((path, referred.definition));
                }
            }
            self.keys.push(key);
        }
        if let Some(key) = self.keys.last().filter(|key| key.table == table) {
            self.intros.push((key.heading(), description(schema)));
        }
        for (path, definition) in inner {
            self.table(&path, definition);
        }
    }
}

fn required(names: Option<&Value>) -> Vec<String> {
    let names = names.and_then(Value::as_array).into_iter().flatten();
    names.filter_map(Value::as_str).map(str::to_owned).collect()
}

fn joined(a: &str, b: &str) -> String {
    [a, b].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
}

fn listed<'a>(words: impl Iterator<Item = &'a str>) -> String {
    words.map(|word| format!("`\"{word}\"`")).collect::<Vec<_>>().join(", ")
}

/// Form and unit of a value.
fn value(path: &str, property: &Value, referred: Option<&Referred>) -> String {
    let form = match (property["x-value"].as_str(), referred) {
        (Some(form), _) => form.to_owned(),
        (None, Some(referred)) => of_definition(path, referred),
        (None, None) => match (property["type"].as_str(), property["minItems"].as_u64()) {
            (Some("array"), Some(3)) => "[x, y, z]".to_owned(),
            (Some("boolean"), _) => "true or false".to_owned(),
            (Some("string"), _) => "text".to_owned(),
            (Some(name), _) => name.to_owned(),
            (None, _) => String::new(),
        },
    };
    match property["x-unit"].as_str() {
        Some(unit) => format!("{form}, {unit}"),
        None => form,
    }
}

fn of_definition(path: &str, referred: &Referred) -> String {
    if !referred.is_table() {
        return "word".to_owned();
    }
    match referred.definition["properties"].as_object().filter(|_| referred.is_small()) {
        Some(keys) => format!("`{{ {} }}`", keys.keys().cloned().collect::<Vec<_>>().join(", ")),
        None if referred.is_list && !path.contains('.') => format!("`[[{path}]]`"),
        None if referred.is_list => "list of tables".to_owned(),
        None if !path.contains('.') => format!("`[{path}]`"),
        None => "table".to_owned(),
    }
}

/// Legal values: bounds or words, then conditions.
fn allowed(property: &Value, referred: Option<&Referred>) -> String {
    let bound = |name: &str| property.get(name).filter(|bound| bound.is_number()).map(number);
    let [least, most] = ["minimum", "maximum"].map(bound);
    let [above, below] = ["exclusiveMinimum", "exclusiveMaximum"].map(bound);
    let range = match (above, least, below, most) {
        (Some(above), _, Some(below), _) => format!("between {above} and {below}"),
        (Some(above), _, _, Some(most)) => format!("above {above}, at most {most}"),
        (Some(above), ..) => format!("> {above}"),
        (_, Some(least), _, Some(most)) => format!("{least} to {most}"),
        (_, Some(least), ..) => format!("at least {least}"),
        (_, _, _, Some(most)) => format!("up to {most}"),
        _ => referred.map_or_else(String::new, |referred| listed(words(referred.definition).into_iter())),
    };
    joined(&range, property["x-allowed"].as_str().unwrap_or_default())
}

fn default(property: &Value) -> String {
    match (property["x-default"].as_str(), property.get("default")) {
        (Some(words), _) => words.to_owned(),
        (None, Some(Value::String(word))) => format!("`\"{word}\"`"),
        (None, Some(Value::Array(list))) => format!("[{}]", list.iter().map(number).collect::<Vec<_>>().join(", ")),
        (None, Some(value)) => number(value),
        (None, None) => "none".to_owned(),
    }
}

/// A number as a user writes it, 1 for 1.0.
fn number(value: &Value) -> String {
    value.as_f64().map_or_else(|| value.to_string(), |number| number.to_string())
}
