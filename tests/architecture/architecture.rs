//! Layers: lower ones know nothing of higher ones.
//!
//! math → {contact, rod → dna, sparse} → scene → solve → observe → io → main; `error` and `text` are open to all. Scans
//! every `crate::` path in the sources outside comments.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::path::{Path, PathBuf};

/// Each module of the crate's root and what it may use besides itself.
const MAY_USE: [(&str, &[&str]); 11] = [
    ("error", &[]),
    ("text", &["error"]),
    ("math", &["error"]),
    ("contact", &["error", "math"]),
    ("rod", &["error", "math"]),
    ("sparse", &["error", "math"]),
    ("scene", &["error", "math", "rod", "text", "dna"]),
    ("solve", &["error", "math", "contact", "rod", "sparse", "scene"]),
    ("observe", &["error", "math", "contact", "rod", "scene", "solve"]),
    ("io", &["error", "math", "rod", "scene", "solve", "observe", "text", "dna"]),
    ("dna", &["error", "math", "rod", "text"]),
];

/// Foreign crates that a single file names.
const NAMED_ONCE: [(&str, &str); 10] = [
    ("rayon", "math/parallel.rs"),
    ("parry3d", "contact/tree/leaves.rs"),
    ("faer", "sparse/factor.rs"),
    ("web_time", "solve/search/timing.rs"),
    ("gltf_json", "io/view/glb.rs"),
    ("base64", "io/view/page.rs"),
    ("postcard", "io/checkpoint.rs"),
    ("crc32fast", "io/checkpoint.rs"),
    ("ctrlc", "main.rs"),
    ("parquet::file", "io/sweep/parquet.rs"),
];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// All sources as (path below src, text without comments).
fn sources() -> Vec<(String, String)> {
    let (mut folders, mut found) = (vec![source()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(source()).unwrap().to_string_lossy().replace('\\', "/");
                found.push((name, without_comments(&std::fs::read_to_string(&path).unwrap())));
            }
        }
    }
    found.sort();
    found
}

fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Root modules named in `crate::name` and `crate::{name::…, other}`.
fn roots(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let mut depth = 0;
        let mut start = true;
        let mut name = String::new();
        for c in rest.chars() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 1 => start = true,
                _ if start && (c.is_alphanumeric() || c == '_') => {
                    name.push(c);
                    continue;
                }
                _ if c.is_whitespace() && name.is_empty() => continue,
                _ => {}
            }
            if !name.is_empty() {
                found.push(std::mem::take(&mut name));
                start = false;
            }
            if depth == 0 {
                break;
            }
        }
    }
    found
}

/// What breaks the layers in one file.
fn offences(file: &str, text: &str) -> Vec<String> {
    let module = file.split(['/', '.']).next().unwrap_or_default();
    let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == module) else {
        return vec![format!("{file}: \"{module}\" has no place among the layers")];
    };
    let known = |name: &str| MAY_USE.iter().any(|(module, _)| *module == name);
    let uses = roots(text).into_iter().filter(|name| known(name) && name != module);
    uses.filter(|name| !allowed.contains(&name.as_str())).map(|name| format!("{file} uses {name}")).collect()
}

#[test]
fn lower_layers_know_nothing_of_higher_ones() {
    let broken: Vec<String> = sources()
        .iter()
        .filter(|(file, _)| !["lib.rs", "internals.rs", "main.rs", "progress.rs", "sweep.rs"].contains(&file.as_str()))
        .flat_map(|(file, text)| offences(file, text))
        .collect();
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn foreign_crates_are_named_in_one_place() {
    for (name, home) in NAMED_ONCE {
        let used: Vec<String> = sources()
            .into_iter()
            .filter(|(file, text)| text.contains(name) && !file.ends_with("/tests.rs"))
            .map(|s| s.0)
            .collect();
        assert_eq!(used, [home], "{name}");
    }
}

/// Paths named in the page on architecture that are not there.
fn missing_paths(page: &str) -> Vec<&str> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let paths = page.split('`').skip(1).step_by(2).filter(|word| {
        ["src/", "tests/", "docs/", "examples/"].iter().any(|start| word.starts_with(start)) && !word.contains(' ')
    });
    paths.filter(|path| !root.join(path).exists()).collect()
}

#[test]
fn the_page_on_architecture_names_what_is_there() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/ARCHITECTURE.md")).unwrap();
    assert!(page.matches("`src/").count() > 50);
    assert_eq!(missing_paths(&page), Vec::<&str>::new());
    assert_eq!(missing_paths("see `src/lib.rs` and `src/gone.rs`"), ["src/gone.rs"]);
}

/// Constants of a source, tests left out, as rows of the page begin: file, name, value.
fn constants(file: &str, text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let constant = |start: usize| {
        let (name, rest) = code[start..].split_once(':')?;
        let (_, value) = rest.split_once(" = ")?;
        let value = value.split(';').next()?.split_whitespace().collect::<Vec<_>>().join(" ");
        let named = name.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_');
        named.then(|| format!("| `{}` | `{name}` | `{value}` |", file.trim_start_matches("solve/")))
    };
    code.match_indices("const ").filter_map(|(at, word)| constant(at + word.len())).collect()
}

/// `tools/constants` writes the page again.
#[test]
fn the_page_of_constants_has_every_constant_of_the_solver() {
    let page = std::fs::read_to_string(source().join("../docs/SOLVER_CONSTANTS.md")).unwrap();
    let solver = sources().into_iter().filter(|(file, _)| file.starts_with("solve/") && !file.ends_with("tests.rs"));
    let mut there: Vec<String> = solver.flat_map(|(file, text)| constants(&file, &text)).collect();
    assert!(there.len() > 50);
    there.retain(|row| !page.contains(row.as_str()));
    assert!(there.is_empty(), "not on the page, or with another value: {there:#?}");
    assert_eq!(constants("solve/a.rs", "const A: f64 = 1e-3;\nfn f() {}"), ["| `a.rs` | `A` | `1e-3` |"]);
}

#[test]
fn a_broken_layer_is_seen() {
    assert_eq!(offences("math/mod.rs", "use crate::solve::Engine;"), ["math/mod.rs uses solve"]);
    assert_eq!(offences("contact/law.rs", "fn f(x: crate::rod::Rod) {}"), ["contact/law.rs uses rod"]);
    let grouped = "use crate::{\n    error::{InputError, SolveError},\n    io::csv,\n    math::Vec3,\n};";
    assert_eq!(offences("observe/mod.rs", grouped), ["observe/mod.rs uses io"]);
    assert_eq!(offences("dna/mod.rs", "use crate::scene;"), ["dna/mod.rs uses scene"]);
    assert!(offences("io/run.rs", "use crate::observe;\nuse crate::io::csv;").is_empty());
    assert_eq!(offences("gui/mod.rs", "").len(), 1);
    assert!(roots(&without_comments("//! see crate::io\nlet x = 1; // crate::solve")).is_empty());
}
