//! Where dependencies come from and under which licences, as `deny.toml` says; held without any tool but cargo.

#![allow(clippy::unwrap_used)] // a test stops where it cannot go on

use std::process::Command;

use toml::Value;

fn manifest(name: &str) -> Value {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    toml::from_str::<toml::Table>(&std::fs::read_to_string(path).unwrap()).unwrap().into()
}

fn names(value: &Value) -> Vec<String> {
    let name = |item: &Value| item.get("name").unwrap_or(item).as_str().unwrap().to_owned();
    value.as_array().unwrap().iter().map(name).collect()
}

/// All packages of the lock file, as cargo sees them.
fn packages() -> Vec<serde_json::Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let metadata: serde_json::Value =
        serde_json::from_str(&text).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    metadata["packages"].as_array().unwrap().clone()
}

/// Whether a licence expression can be met with the allowed licences: OR needs one side, AND both; "/" is an old OR.
fn is_allowed(expression: &str, allowed: &[String]) -> bool {
    let text = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let tokens: Vec<&str> = text.split_whitespace().collect();
    let (mut at, tokens) = (0, tokens.as_slice());
    let met = either(tokens, &mut at, allowed);
    met && at == tokens.len()
}

fn either(tokens: &[&str], at: &mut usize, allowed: &[String]) -> bool {
    let mut met = both(tokens, at, allowed);
    while tokens.get(*at) == Some(&"OR") {
        *at += 1;
        met |= both(tokens, at, allowed);
    }
    met
}

fn both(tokens: &[&str], at: &mut usize, allowed: &[String]) -> bool {
    let mut met = one(tokens, at, allowed);
    while tokens.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one(tokens, at, allowed);
    }
    met
}

fn one(tokens: &[&str], at: &mut usize, allowed: &[String]) -> bool {
    let token = tokens.get(*at).copied().unwrap_or_default();
    *at += 1;
    if token == "(" {
        let met = either(tokens, at, allowed);
        *at += 1;
        return met;
    }
    // a licence with an exception is one of its own
    let licence = match tokens.get(*at) {
        Some(&"WITH") => {
            *at += 2;
            format!("{token} WITH {}", tokens.get(*at - 1).unwrap_or(&""))
        }
        _ => token.to_owned(),
    };
    allowed.contains(&licence)
}

/// The workspace's own packages.
const MEMBERS: [&str; 4] = [env!("CARGO_PKG_NAME"), "supercoil-live", "supercoil-python", "supercoil-tools"];

#[test]
fn licences_and_sources_are_allowed() {
    let deny = manifest("deny.toml");
    let allowed = names(&deny["licenses"]["allow"]);
    let banned = names(&deny["bans"]["deny"]);
    let packages = packages();
    assert!(packages.len() > 50, "{}", packages.len());
    for package in &packages {
        let name = package["name"].as_str().unwrap();
        let licence = package["license"].as_str().unwrap_or("none");
        assert!(is_allowed(licence, &allowed), "{name}: {licence}");
        let source = package["source"].as_str().unwrap_or("");
        let home = if MEMBERS.contains(&name) { "" } else { "registry+https://github.com/rust-lang/crates.io-index" };
        assert_eq!(source, home, "{name}");
        assert!(!banned.iter().any(|banned| banned == name), "{name} is banned by deny.toml");
    }
}

/// Each direct dependency is explained: a comment in Cargo.toml above it or its group, a row in the book.
#[test]
fn dependencies_have_reasons() {
    let page = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/book/src/library.md");
    let library = std::fs::read_to_string(page).unwrap();
    let table = library.split("## Dependencies").nth(1).unwrap().split("\n## ").next().unwrap();
    let first_cells: String = table.lines().filter_map(|line| line.split('|').nth(1)).collect();
    let named: Vec<&str> = first_cells.split([' ', ',']).filter(|name| !name.is_empty()).collect();
    for (name, _) in manifest("Cargo.toml")["dependencies"].as_table().unwrap() {
        assert!(
            named.contains(&name.as_str()),
            "{name} is not in the list of dependencies of docs/book/src/library.md"
        );
    }
}

#[test]
fn expressions_are_read_right() {
    let allowed = ["MIT".to_owned(), "Zlib".to_owned(), "BSD WITH known-exception".to_owned()];
    let cases = [
        ("MIT", true),
        ("GPL-3.0", false),
        ("GPL-3.0 OR MIT", true),
        ("GPL-3.0/MIT", true),
        ("MIT AND GPL-3.0", false),
        ("(MIT OR GPL-3.0) AND Zlib", true),
        ("MIT OR GPL-3.0 AND BSD", true),
        ("MIT WITH some-exception", false),
        ("BSD WITH known-exception", true),
        ("BSD", false),
        ("GPL WITH some-exception OR Zlib", true),
        ("", false),
        ("MIT GPL", false),
    ];
    for (expression, expected) in cases {
        assert_eq!(is_allowed(expression, &allowed), expected, "{expression}");
    }
}

#[test]
fn the_citation_is_of_this_version() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("CITATION.cff");
    let version = format!("\nversion: {}\n", env!("CARGO_PKG_VERSION"));
    assert!(std::fs::read_to_string(path).unwrap().contains(&version), "CITATION.cff: version is not{version}");
}
