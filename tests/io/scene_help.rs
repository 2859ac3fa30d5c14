//! `supercoil new` and `supercoil help`: scenes to begin with are accepted, and the reference of keys is that of the
//! program.

#![allow(clippy::unwrap_used)] // helpers of tests

use std::collections::BTreeSet;
use std::path::Path;

use supercoil::scene::Scene;
use supercoil::scene::file::{TEMPLATES, help, keys, reference};

use crate::program::supercoil;

#[test]
fn scenes_to_begin_with_are_accepted() {
    let dir = std::env::temp_dir().join(format!("supercoil_new_{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    for template in TEMPLATES {
        let file = dir.join(format!("{}.toml", template.name));
        let path = file.to_str().unwrap();
        let new = supercoil(&["new", template.name, path]);
        assert!(new.status.success(), "{}", String::from_utf8_lossy(&new.stderr));
        let check = supercoil(&["check", path]);
        let told = String::from_utf8_lossy(&check.stdout).into_owned();
        assert!(check.status.success() && check.stderr.is_empty(), "{}", String::from_utf8_lossy(&check.stderr));
        assert!(told.contains("nothing to object"), "{told}");
        // what is there is not overwritten
        std::fs::write(&file, "mine").unwrap();
        let again = supercoil(&["new", template.name, path]);
        assert_eq!(again.status.code(), Some(3));
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    }
    std::fs::remove_dir_all(&dir).unwrap();
    assert_eq!(supercoil(&["new", "castle"]).status.code(), Some(2));
}

/// The page is that of the types. `cargo run -p supercoil-tools --bin reference` writes it.
#[test]
fn the_page_of_keys_is_that_of_the_types() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/scene/reference.md");
    assert_eq!(std::fs::read_to_string(page).unwrap(), reference(), "write it anew");
}

/// The keys that a table of a scene may have, as the refusal of an unknown one tells them.
fn accepted(text: &str) -> BTreeSet<String> {
    let message = Scene::from_toml(text, Path::new("")).unwrap_err().to_string();
    assert!(message.contains("unknown field `zzz`"), "{message}");
    let allowed = message.split("expected ").nth(1).unwrap().split("did you").next().unwrap();
    allowed.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// What the schema derives and what serde reads are two derivations from one type.
#[test]
fn the_reference_has_all_keys_and_no_more() {
    let rods = |keys: &str| format!("[[rods]]\n{keys}");
    let ramp = |keys: &str| format!("[[stages]]\nramp = {{ {keys} }}");
    let mut told: Vec<(String, Option<String>)> = keys().into_iter().map(|key| (key.table, key.kind)).collect();
    told.dedup();
    assert!(told.len() >= 30, "{told:?}");
    for (table, kind) in told {
        let scene = match (table.as_str(), &kind) {
            ("scene", _) => "zzz = 1".to_owned(),
            ("rods.shape", Some(kind)) => rods(&format!("shape = {{ kind = \"{kind}\", zzz = 1 }}")),
            ("rods.shape", None) => continue,
            ("rods.beads", _) => rods("beads = [{ zzz = 1 }]"),
            (table, _) => match table.rsplit_once('.') {
                Some(("rods", key)) => rods(&format!("{key} = {{ zzz = 1 }}")),
                Some(("stages.ramp", key)) => ramp(&format!("{key} = {{ zzz = 1 }}")),
                Some(("stages", key)) => format!("[[stages]]\n{key} = {{ zzz = 1 }}"),
                Some((outer, key)) if outer == "contact" => format!("[{outer}]\n{key} = {{ zzz = 1 }}"),
                Some((outer, key)) => format!("[[{outer}]]\n{key} = {{ zzz = 1 }}"),
                None if ["contact", "solver", "output", "picture"].contains(&table) => format!("[{table}]\nzzz = 1"),
                None => format!("[[{table}]]\nzzz = 1"),
            },
        };
        let known: BTreeSet<String> =
            keys().into_iter().filter(|key| (&key.table, &key.kind) == (&table, &kind)).map(|key| key.name).collect();
        assert_eq!(known, accepted(&scene), "{table} {kind:?}");
    }
    assert!(keys().iter().all(|key| !key.value.is_empty() && !key.meaning.is_empty()));
    assert!(keys().iter().all(|key| key.is_required == key.default.is_empty()));
}

#[test]
fn help_tells_keys_tables_and_slips() {
    let one = help(Some("rods.dna.salt_mM")).unwrap();
    assert!(one.contains("10 to 1000") && one.contains("default: 150") && one.lines().count() <= 4, "{one}");
    let everywhere = help(Some("excess_link")).unwrap();
    assert!(everywhere.contains("rods\n") && everywhere.contains("stages.ramp\n"), "{everywhere}");
    let table = help(Some("[[supports]]")).unwrap();
    assert!(table.contains("rotation") && !table.contains("salt"), "{table}");
    let slip = help(Some("exces_link")).unwrap_err().to_string();
    assert!(slip.contains("did you mean rods.excess_link?"), "{slip}");
    assert!(help(None).unwrap().lines().all(|line| line.chars().count() <= 100));
    let printed = supercoil(&["help", "scene", "pose"]);
    assert_eq!(printed.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&printed.stdout).contains("extra_turns"));
    assert!(String::from_utf8_lossy(&supercoil(&["help"]).stdout).contains("new"));
    assert!(String::from_utf8_lossy(&supercoil(&["help", "run"]).stdout).contains("--time-limit"));
    assert_eq!(supercoil(&["help", "sceen"]).status.code(), Some(2));
}
