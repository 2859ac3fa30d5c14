//! JSON Schema of scene files, for editors.

use crate::scene::file::schema_for_editors;

/// The schema (draft 2020-12), as text. Editors check keys, types and bounds with it and show the meaning of keys.
#[must_use]
pub fn scene_schema() -> String {
    format!("{:#}\n", schema_for_editors())
}
