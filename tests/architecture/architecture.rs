//! Layers: lower ones know nothing of higher ones.
//!
//! math → {contact, rod → dna, sparse} → scene → solve → certificate → observe → io → main; `error`, `memory` and
//! `text` are open to all. Scans every `crate::` path in the sources outside comments.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Each module of the crate's root and what it may use besides itself.
const MAY_USE: [(&str, &[&str]); 14] = [
    ("error", &[]),
    ("memory", &[]),
    ("text", &["error"]),
    ("math", &["error"]),
    ("contact", &["error", "math"]),
    ("rod", &["error", "math"]),
    ("sparse", &["error", "math"]),
    ("scene", &["error", "math", "memory", "rod", "text", "dna"]),
    ("solve", &["error", "math", "memory", "contact", "rod", "sparse", "scene"]),
    ("certificate", &["error", "math", "rod", "scene", "solve"]),
    ("observe", &["error", "math", "contact", "rod", "scene", "solve", "certificate"]),
    ("tangent", &["error", "math", "contact", "rod", "scene", "solve"]),
    ("io", &["error", "math", "rod", "scene", "solve", "tangent", "certificate", "observe", "text", "dna"]),
    ("dna", &["error", "math", "rod", "text"]),
];

/// Foreign crates that a single file names.
const NAMED_ONCE: [(&str, &str); 12] = [
    ("rayon", "math/parallel.rs"),
    ("parry3d", "contact/tree/leaves.rs"),
    ("faer", "sparse/factor.rs"),
    ("web_time", "solve/search/timing.rs"),
    ("gltf_json", "io/view/glb.rs"),
    ("base64", "io/view/page.rs"),
    ("postcard", "io/checkpoint.rs"),
    ("crc32fast", "io/checkpoint.rs"),
    ("ctrlc", "commands/signals.rs"),
    ("parquet::file", "io/sweep/parquet.rs"),
    ("pdf_writer", "io/picture/pdf.rs"),
    ("plotters_backend", "io/picture/pdf.rs"),
];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Rust files in a folder and below as (path below it, text).
fn rust_files(folder: &Path) -> Vec<(String, String)> {
    let (mut folders, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(here) = folders.pop() {
        for entry in std::fs::read_dir(here).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/");
                found.push((name, std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// All sources as (path below src, text without comments).
fn sources() -> Vec<(String, String)> {
    rust_files(&source()).into_iter().map(|(name, text)| (name, without_comments(&text))).collect()
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
        .filter(|(file, _)| {
            !["lib.rs", "internals.rs", "main.rs"].contains(&file.as_str()) && !file.starts_with("commands")
        })
        .flat_map(|(file, text)| offences(file, text))
        .collect();
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Folders in which no modules use each other in a circle. A file and the folder of its name are one module there;
/// inside, the file may use its parts and they its types.
const WITHOUT_CIRCLES: [&str; 3] = ["solve", "contact", "scene"];

type ModulePath = Vec<String>;

/// The path of a module by its file.
fn module_of(file: &str) -> ModulePath {
    let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
    path.split('/').map(str::to_owned).collect()
}

/// All paths of a use tree (`a::{b, c::d}`), which may go on after it.
fn paths_of_tree(tree: &str) -> Vec<ModulePath> {
    let mut found = Vec::new();
    let (mut stack, mut path): (Vec<ModulePath>, ModulePath) = (Vec::new(), Vec::new());
    let mut name = String::new();
    for c in tree.chars().chain([';']) {
        if c.is_alphanumeric() || c == '_' {
            name.push(c);
            continue;
        }
        if !name.is_empty() {
            path.push(std::mem::take(&mut name));
        }
        match c {
            ':' => {}
            '{' => stack.push(path.clone()),
            ',' | '}' if !stack.is_empty() => {
                found.push(path);
                path = stack.last().unwrap().clone();
                if c == '}' {
                    stack.pop();
                }
            }
            c if c.is_whitespace() && !stack.is_empty() => {}
            _ => {
                found.push(path);
                return found;
            }
        }
        if c == '}' && stack.is_empty() {
            return found;
        }
    }
    found
}

/// Paths from the root that a module names by `crate`, `super` or the name of a module in it; without its tests.
fn named_paths(module: &ModulePath, text: &str, all: &BTreeSet<ModulePath>) -> Vec<ModulePath> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let mut found = Vec::new();
    for (at, _) in text.match_indices("::") {
        let head = text[..at].rsplit(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).next().unwrap();
        let child = [&module[..], &[head.to_owned()]].concat();
        let tree = &text[at - head.len()..];
        match head {
            "crate" => found.extend(paths_of_tree(tree).into_iter().map(|path| path[1..].to_vec())),
            "super" => found.extend(paths_of_tree(tree).into_iter().map(|path| {
                let up = path.iter().take_while(|name| *name == "super").count();
                [&module[..module.len().saturating_sub(up)], &path[up..]].concat()
            })),
            _ if all.contains(&child) => {
                found.extend(paths_of_tree(tree).into_iter().map(|path| [&module[..], &path[..]].concat()));
            }
            _ => {}
        }
    }
    found
}

/// Names that modules re-export, with where they are.
fn re_exports(sources: &[(ModulePath, String)], all: &BTreeSet<ModulePath>) -> BTreeMap<ModulePath, ModulePath> {
    let mut found = BTreeMap::new();
    for (module, text) in sources {
        for line in text.split(';').filter(|line| line.trim_start().starts_with("pub") && line.contains(" use ")) {
            for path in named_paths(module, &format!("{line};"), all) {
                found.insert([&module[..], &path[path.len() - 1..]].concat(), path);
            }
        }
    }
    found
}

/// The module that a path leads to, through re-exports.
fn resolved(path: &[String], all: &BTreeSet<ModulePath>, re_exports: &BTreeMap<ModulePath, ModulePath>) -> ModulePath {
    let mut here = ModulePath::new();
    for (k, name) in path.iter().enumerate() {
        let next = [&here[..], std::slice::from_ref(name)].concat();
        if let Some(there) = re_exports.get(&next).filter(|_| !all.contains(&next)) {
            return resolved(&[&there[..], &path[k + 1..]].concat(), all, re_exports);
        }
        if !all.contains(&next) {
            break;
        }
        here = next;
    }
    here
}

/// Circles of modules that stand beside each other below a folder, as (module, module it uses) of all in the circles.
fn circles(files: &[(String, String)], folder: &str) -> Vec<[String; 2]> {
    let sources: Vec<(ModulePath, String)> = files.iter().map(|(file, text)| (module_of(file), text.clone())).collect();
    let all: BTreeSet<ModulePath> = sources.iter().map(|(module, _)| module.clone()).collect();
    let re_exports = re_exports(&sources, &all);
    let mut uses: BTreeMap<ModulePath, BTreeSet<ModulePath>> = BTreeMap::new();
    for (module, text) in sources.iter().filter(|(module, _)| module[0] == folder) {
        for path in named_paths(module, text, &all) {
            let used = resolved(&path, &all, &re_exports);
            let common = module.iter().zip(&used).take_while(|(a, b)| a == b).count();
            if common > 0 && common < module.len().min(used.len()) {
                uses.entry(module[..=common].to_vec()).or_default().insert(used[..=common].to_vec());
            }
        }
    }
    // what uses nothing that is left is in no circle
    while let Some(free) = uses.keys().find(|module| uses[*module].is_empty()).cloned() {
        uses.remove(&free);
    }
    loop {
        let count: usize = uses.values().map(BTreeSet::len).sum();
        let known: BTreeSet<ModulePath> = uses.keys().cloned().collect();
        uses.values_mut().for_each(|used| used.retain(|module| known.contains(module)));
        uses.retain(|_, used| !used.is_empty());
        if uses.values().map(BTreeSet::len).sum::<usize>() == count {
            break;
        }
    }
    let pair = |a: &ModulePath, b: &ModulePath| [a.join("/"), b.join("/")];
    uses.iter().flat_map(|(module, used)| used.iter().map(move |other| pair(module, other))).collect()
}

#[test]
fn modules_use_each_other_one_way() {
    let sources: Vec<(String, String)> =
        sources().into_iter().filter(|(file, _)| !file.ends_with("tests.rs")).collect();
    for folder in WITHOUT_CIRCLES {
        let found = circles(&sources, folder);
        assert!(found.is_empty(), "{found:#?}");
    }
}

#[test]
fn a_circle_is_seen() {
    let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    let face = file("solve/mod.rs", "pub use path::run::{Solver, run};");
    let path = file("solve/path/run.rs", "use crate::solve::step::report::{Report, Status};");
    let parts = [file("solve/path/mod.rs", ""), file("solve/step/mod.rs", "")];
    let report = |text: &str| file("solve/step/report.rs", text);
    let house = |text: &str| [&[face.clone(), path.clone(), report(text)], &parts[..]].concat();
    let circle = [["solve/path", "solve/step"], ["solve/step", "solve/path"]];
    assert!(circles(&house("use crate::math::{Vec3, Quat};"), "solve").is_empty());
    for text in
        ["use crate::solve::Solver;", "fn f(x: crate::solve::path::run::Solver) {}", "use super::super::path::run;"]
    {
        assert_eq!(circles(&house(text), "solve"), circle, "{text}");
    }
    assert!(circles(&house("#[cfg(test)]\nmod tests {\n    use crate::solve::Solver;"), "solve").is_empty());
}

/// Names of the types that a source defines, tests included; associated types are no new names.
fn types_defined(text: &str) -> Vec<&str> {
    let visible = |line: &str| line.starts_with("pub") || !line.starts_with(char::is_whitespace);
    let name = |line: &'_ str| -> Option<(usize, usize)> {
        let (start, word) = ["struct ", "enum ", "trait ", "type "]
            .iter()
            .filter_map(|word| line.find(word).map(|at| (at, *word)))
            .find(|(at, _)| line[..*at].trim().is_empty() || line[..*at].trim_start().starts_with("pub"))?;
        let start = start + word.len();
        let length = line[start..].find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(line.len() - start);
        (word != "type " || visible(line)).then_some((start, start + length))
    };
    text.lines().filter_map(|line| name(line).map(|(start, end)| &line[start..end])).collect()
}

/// Who reads a type's name knows what it is, wherever it is used.
#[test]
fn a_type_name_stands_for_one_thing() {
    let mut homes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (file, text) in sources() {
        types_defined(&text).into_iter().for_each(|name| homes.entry(name.to_owned()).or_default().push(file.clone()));
    }
    assert!(homes.len() > 300, "{}", homes.len());
    homes.retain(|_, files| files.len() > 1);
    assert!(homes.is_empty(), "{homes:#?}");
    let text =
        "pub struct A;\npub(super) enum B<T> { C }\nmod m {\n    trait D {}\n}\nimpl E for A {\n    type F = u8;\n}\n";
    assert_eq!(types_defined(text), ["A", "B", "D"]);
    assert_eq!(types_defined("type G = u8;\nlet structure = 1; // no struct\nstruct H"), ["G", "H"]);
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

/// Lines of more than 120 columns, as (line, columns); rows of tables in comments have no shorter form.
fn long_lines(text: &str) -> Vec<(usize, usize)> {
    let comment = |line: &str| Some(line.trim_start().strip_prefix("//")?.trim_start_matches(['/', '!']).to_owned());
    let is_row = |line: &str| comment(line).is_some_and(|text| text.trim_start().starts_with('|'));
    let columns = text.lines().map(|line| if is_row(line) { 0 } else { line.chars().count() });
    (1..).zip(columns).filter(|(_, columns)| *columns > 120).collect()
}

/// What the formatter leaves alone, comments and strings, fits on the page, too.
#[test]
fn lines_have_120_columns() {
    assert_eq!(long_lines(&format!("a\n/// | {0} |\n{0}\n{0}x\n| {0}", "ä".repeat(120))), [(4, 121), (5, 122)]);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["src", "tests", "benches", "examples", "live/src", "tools/src", "python/src"] {
        for (file, text) in rust_files(&root.join(folder)) {
            assert_eq!(long_lines(&text), [], "{folder}/{file}");
        }
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
        let (name, rest) = code[start..].split_once(": ")?;
        let (kind, value) = rest.split_once(" = ")?;
        let value = value.split(';').next()?.split_whitespace().collect::<Vec<_>>().join(" ");
        let named = name.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_');
        // values of a type of its own are no numbers to choose
        let number = !kind.starts_with("Self") && !kind.contains('>') || kind.starts_with("std::ops");
        (named && number).then(|| format!("| `{file}` | `{name}` | `{value}` |"))
    };
    code.match_indices("const ").filter_map(|(at, word)| constant(at + word.len())).collect()
}

/// `tools/constants` writes the pages again.
#[test]
fn the_pages_of_constants_have_every_constant_of_solver_and_contact() {
    for (room, page) in [("solve/", "SOLVER_CONSTANTS.md"), ("contact/", "CONTACT_CONSTANTS.md")] {
        let page = std::fs::read_to_string(source().join("../docs").join(page)).unwrap();
        let here = sources().into_iter().filter(|(file, _)| file.starts_with(room) && !file.ends_with("tests.rs"));
        let there: Vec<String> =
            here.flat_map(|(file, text)| constants(file.trim_start_matches(room), &text)).collect();
        assert!(there.len() > 30);
        let missing: Vec<&String> = there.iter().filter(|row| !page.contains(row.as_str())).collect();
        assert!(missing.is_empty(), "not on the page, or with another value: {missing:#?}");
        let rows = page.lines().filter(|line| line.starts_with("| `") && !line.contains("constant | value")).count();
        assert_eq!(rows, there.len(), "the page has constants that are gone");
    }
    assert_eq!(constants("a.rs", "const A: f64 = 1e-3;\nfn f() {}"), ["| `a.rs` | `A` | `1e-3` |"]);
    assert!(constants("a.rs", "impl<const N: usize> B<N> {\n    const NONE: Self = Self { x: 1.0 };\n}").is_empty());
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
