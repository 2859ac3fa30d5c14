//! Canonical text of a scene: equal for scene files with equal results.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use toml::{Table, Value};

use crate::error::InputError;

use super::set;

/// A scene reduced to the settings that determine its results: values replaced, keys in order, without comments, title,
/// outputs and threads.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Canonical {
    /// The text, independent of the layout of the file.
    pub text: String,
    /// All string values, in order; they include the files that the scene names.
    pub words: Vec<String>,
}

impl Canonical {
    /// Canonical text of a scene's table, with values replaced as by `--set`. The scene itself is not checked.
    ///
    /// # Errors
    /// A key that does not exist.
    pub fn new(scene: &Table, set: &[String]) -> Result<Self, InputError> {
        let mut table = scene.clone();
        set.iter().try_for_each(|assignment| set::apply(&mut table, assignment))?;
        table.remove("title");
        table.remove("output");
        if let Some(Value::Table(solver)) = table.get_mut("solver") {
            solver.remove("threads");
            if solver.is_empty() {
                table.remove("solver");
            }
        }
        let mut canonical = Self { text: String::new(), words: Vec::new() };
        canonical.push(&Value::Table(table));
        Ok(canonical)
    }

    fn push(&mut self, value: &Value) {
        match value {
            Value::Table(table) => {
                self.text.push('{');
                for (key, value) in table.iter().collect::<BTreeMap<_, _>>() {
                    // writing to a String does not fail
                    let _ = write!(self.text, "{key:?}:");
                    self.push(value);
                    self.text.push(',');
                }
                self.text.push('}');
            }
            Value::Array(list) => {
                self.text.push('[');
                for value in list {
                    self.push(value);
                    self.text.push(',');
                }
                self.text.push(']');
            }
            Value::String(word) => {
                let _ = write!(self.text, "{word:?}");
                self.words.push(word.clone());
            }
            // all bits of a number; integers and reals differ
            Value::Float(number) => {
                let _ = write!(self.text, "{number:?}");
            }
            other => {
                let _ = write!(self.text, "{other}");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_title_outputs_and_threads_do_not_count_but_values_do() {
        let of = |text: &str, set: &[&str]| {
            Canonical::new(&toml::from_str(text).unwrap(), &set.iter().map(|&s| s.to_owned()).collect::<Vec<_>>())
                .unwrap()
        };
        let one = of("a = 1 # a remark\nb = { y = 2.0, x = 'w' }\n", &[]);
        assert_eq!(one.text, r#"{"a":1,"b":{"x":"w","y":2.0,},}"#);
        assert_eq!(one.words, ["w"]);
        let laid_out = "title = 't'\n[b]\nx = \"w\"\ny = 3.0\n[output]\nvtk = false\n[solver]\nthreads = 2\n";
        assert_eq!(of(laid_out, &["a=1", "b.y=2.0"]), one);
        for other in ["a=2", "b.y=2.0000000000000004", "b.x=v", "solver.max_iterations=9", "c=0"] {
            assert_ne!(of(laid_out, &["a=1", "b.y=2.0", other]), one, "{other}");
        }
    }
}
