//! Replacement of values of a scene by `KEY=VALUE`.

use toml::{Table, Value};

use crate::error::InputError;

/// Replaces or adds one value; it is checked when the scene is read from the table.
pub(in crate::scene::file) fn apply(scene: &mut Table, assignment: &str) -> Result<(), InputError> {
    let refuse = |reason: &str| InputError::inconsistent(format!("set {assignment}"), reason);
    let (key, value) = assignment.split_once('=').ok_or_else(|| refuse("must be KEY=VALUE"))?;
    let mut steps = key.trim().split('.');
    let mut place = scene.entry(steps.next().unwrap_or_default()).or_insert_with(|| Table::new().into());
    for step in steps {
        place = match place {
            Value::Table(table) => table.entry(step).or_insert_with(|| Table::new().into()),
            Value::Array(list) => {
                let named = |item: &Value| item.get("name").and_then(Value::as_str) == Some(step);
                let index = step.parse().ok().or_else(|| list.iter().position(named));
                let entry = index.and_then(|index: usize| list.get_mut(index));
                entry.ok_or_else(|| {
                    refuse(&format!("there is no entry \"{step}\": give its name or its index from 0"))
                })?
            }
            _ => return Err(refuse(&format!("what \"{step}\" is to be in is no table"))),
        };
    }
    *place = value_of(value.trim());
    Ok(())
}

/// A TOML value; anything else is a string.
pub(crate) fn value_of(text: &str) -> Value {
    let read = toml::from_str::<Table>(&format!("value = {text}")).ok();
    read.and_then(|mut table| table.remove("value")).unwrap_or_else(|| text.into())
}
