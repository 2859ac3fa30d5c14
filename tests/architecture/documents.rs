//! Markdown files and doc comments: links, numbers and words. `docs/STYLE.md` has the rules.

use std::path::{Component, Path, PathBuf};

/// Pages written from comments in the sources.
const GENERATED: [&str; 3] = ["docs/SOLVER_CONSTANTS.md", "docs/CONTACT_CONSTANTS.md", "src/scene/reference.md"];

/// Pages that may use any word: the list of words itself, and notes for maintainers.
const FREE: [&str; 2] = ["docs/STYLE.md", "docs/notes/"];

/// Pages of the book that `docs/book/make` writes.
const BUILT: &str = "target/book-parts/";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files below the root with an ending, as paths from the root with their text.
fn files(ending: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root().to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
            let visible = !name.starts_with('.') || name == ".github";
            // folders of packages and results are no documents
            if path.is_dir() && visible && !["target", "out", "node_modules"].contains(&&*name) {
                folders.push(path);
            } else if name.ends_with(ending) {
                let page = path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
                found.push((page, std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// Markdown files.
fn pages() -> Vec<(String, String)> {
    files(".md")
}

/// Doc comments of the sources, on their lines; all others are empty.
fn doc_comments() -> Vec<(String, String)> {
    let comment = |line: &str| {
        let line = line.trim_start();
        line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).unwrap_or_default().to_owned()
    };
    let is_source = |(page, _): &(String, String)| page.starts_with("src/") || page.contains("/src/");
    let of_file = |(page, text): (String, String)| (page, text.lines().map(comment).collect::<Vec<_>>().join("\n"));
    files(".rs").into_iter().filter(is_source).map(of_file).collect()
}

/// Lines outside code blocks, with their numbers.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut is_code = false;
    let lines = text.lines().enumerate().filter(|(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    lines.map(|(number, line)| (number + 1, line)).collect()
}

/// A line without its code spans.
fn words(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// Targets of the links and images of a line.
fn links(line: &str) -> Vec<&str> {
    line.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next()).collect()
}

/// The name of a heading in links: GitHub's and mdBook's rule.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim();
    let kept = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
        _ => None,
    };
    text.chars().flat_map(char::to_lowercase).filter_map(kept).collect()
}

/// Path without `..` and `.`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(normal.pop()),
            Component::CurDir => {}
            part => normal.push(part),
        }
    }
    normal
}

/// The file that a link of a page means. Pages of the book are read beside `docs/`, whose files they include.
fn target(page: &str, link: &str) -> Option<PathBuf> {
    let home = Path::new(page).parent().unwrap();
    let mut homes = vec![home.to_path_buf()];
    if page.starts_with("docs/") {
        homes.extend(["docs", "docs/book/src"].map(PathBuf::from));
    }
    homes.iter().map(|home| normal(&root().join(home).join(link))).find(|path| path.exists())
}

/// Text of a page with the files it includes.
fn included(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let Some(name) = text.trim().strip_prefix("{{#include ").and_then(|rest| rest.strip_suffix("}}")) else {
        return text;
    };
    included(&normal(&path.parent().unwrap().join(name)))
}

/// Whether a page has a heading of this name.
fn has_anchor(path: &Path, name: &str) -> bool {
    prose(&included(path)).iter().any(|(_, line)| line.starts_with('#') && anchor(line) == name)
}

fn is_dead(page: &str, link: &str) -> bool {
    if link.contains("://") || link.starts_with("mailto:") || link.starts_with("{{") {
        return false;
    }
    let (file, name) = link.split_once('#').unwrap_or((link, ""));
    let path = if file.is_empty() { Some(root().join(page)) } else { target(page, file) };
    path.is_none_or(|path| !name.is_empty() && file.ends_with(".md") != file.is_empty() && !has_anchor(&path, name))
}

/// Includes of a line whose file is not there.
fn dead_include<'a>(page: &str, line: &'a str) -> Option<&'a str> {
    let file = line.trim().strip_prefix("{{#include ")?.split([':', '}']).next()?;
    let path = normal(&root().join(page).parent()?.join(file));
    (!path.exists() && !path.starts_with(root().join(BUILT))).then_some(file)
}

/// Whether a number lacks its leading zero.
fn lacks_zero(line: &str) -> bool {
    let text: Vec<char> = words(line).chars().collect();
    let before = |k: usize| k.checked_sub(1).map_or(' ', |k| text[k]);
    let starts = |k: usize| !before(k).is_alphanumeric() && !"_./`)*]".contains(before(k));
    (0..text.len().saturating_sub(1)).any(|k| text[k] == '.' && text[k + 1].is_ascii_digit() && starts(k))
}

/// The words in the first column of the first table of `docs/STYLE.md`.
fn banned() -> Vec<String> {
    let page = std::fs::read_to_string(root().join("docs/STYLE.md")).unwrap();
    let rows = page.lines().skip_while(|line| !line.starts_with("| ")).take_while(|line| line.starts_with('|')).skip(2);
    let cells = rows.filter_map(|row| row.split('|').nth(1));
    cells.flat_map(|cell| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>()).collect()
}

/// Whether a line has a word or phrase, as whole words.
fn has_word(line: &str, word: &str) -> bool {
    let line = words(line).to_lowercase();
    let is_edge = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    line.match_indices(word)
        .any(|(at, _)| is_edge(line[..at].chars().next_back()) && is_edge(line[at + word.len()..].chars().next()))
}

/// `page:line: …` of each line of some pages that a rule refuses.
fn refused(pages: &[(String, String)], rule: impl Fn(&str, &str) -> Vec<String>) -> Vec<String> {
    let of_page = |(page, text): &(String, String)| -> Vec<String> {
        let lines = prose(text);
        lines
            .iter()
            .flat_map(|(n, line)| rule(page, line).into_iter().map(move |what| format!("{page}:{n}: {what}")))
            .collect()
    };
    pages.iter().flat_map(of_page).collect()
}

#[test]
fn links_lead_somewhere() {
    assert!(pages().len() > 30, "{}", pages().len());
    let dead = refused(&pages(), |page, line| {
        let links = links(line).into_iter().filter(|link| is_dead(page, link));
        links.chain(dead_include(page, line)).map(str::to_owned).collect()
    });
    assert!(dead.is_empty(), "{dead:#?}");
    assert!(
        is_dead("README.md", "docs/GONE.md")
            && is_dead("README.md", "docs/STYLE.md#gone")
            && is_dead("README.md", "#gone")
    );
    assert!(!is_dead("README.md", "docs/STYLE.md#style") && !is_dead("README.md", "#try-it"));
    assert_eq!(links("see [a](b.md), ![c](d.png \"e\")"), ["b.md", "d.png"]);
    assert_eq!(dead_include("docs/book/src/x.md", "{{#include ../../GONE.md}}"), Some("../../GONE.md"));
}

#[test]
fn comments_are_found() {
    let comments = doc_comments();
    let lines = comments.iter().flat_map(|(_, text)| text.lines()).filter(|line| !line.is_empty()).count();
    assert!(comments.len() > 250 && lines > 5000, "{} {lines}", comments.len());
}

#[test]
fn numbers_have_a_leading_zero() {
    let found = refused(&[pages(), doc_comments()].concat(), |page, line| {
        let is_found = !GENERATED.contains(&page) && lacks_zero(line);
        is_found.then(|| line.to_owned()).into_iter().collect()
    });
    assert!(found.is_empty(), "{found:#?}");
    assert!(["is .21 wide", "−.06", "(.3)", "| .5 |"].iter().all(|line| lacks_zero(line)));
    assert!(!["0.21", "a `.21`", "1.2.3", "rods.0.x", "../a", "e.g. 3"].iter().any(|line| lacks_zero(line)));
}

#[test]
fn words_are_the_fields() {
    let banned = banned();
    assert!(banned.len() > 8, "{banned:?}");
    let is_free = |page: &str| GENERATED.contains(&page) || FREE.iter().any(|free| page.starts_with(free));
    let found = refused(&[pages(), doc_comments()].concat(), |page, line| {
        let words = banned.iter().filter(|word| !is_free(page) && has_word(line, word));
        words.map(|word| format!("{word}: {line}")).collect()
    });
    assert!(found.is_empty(), "{found:#?}");
    assert!(has_word("It was Told so.", "told") && !has_word("untold, `told`", "told"));
}
