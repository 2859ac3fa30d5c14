//! Runs the tests, slow ones included, and writes their verification rows to VERIFICATION.md: one table per physical case.
//!
//! `cargo run --example verification` for all (some ten minutes on two cores), `cargo run --example verification -- lee_frame roll_up` for some tests only
//! (to the terminal, without the slow ones).
#![allow(clippy::print_stdout)] // an example talks to its reader

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, ExitCode};

/// A row that a test printed: case, quantity, measured, reference, error, tolerance.
type Row = [String; 6];

const INTRODUCTION: &str = "# Verification\n\n\
    Written by `cargo run --example verification` from the rows that the tests print; do not edit. Every row is asserted by the test \
    that heads its table: |measured − reference| ≤ tolerance. `cargo test --test NAME -- --nocapture` prints them again, with all digits; rows \
    marked *slow* are of tests that run on demand only, with `--ignored` after the `--`. The header of each test file says how its references \
    were come by: closed forms, numerical solutions of the continuous equations (shooting or collocation, all printed digits meant), or, for \
    tight knots, the literature. Tolerances allow for the reference's last digit, for the mesh and for what separates the case from its \
    limit (finite stiffness against stretch, thickness, penalty), as the header says.\n\n\
    Errors are rounded up to a power of ten, and numbers cut one digit below their error, so that a rerun gives the same file as long as nothing has \
    changed but the last bits. `≈ 0` is a number no larger than the error shown beside it. Orders of convergence are fitted slopes.\n";

/// Put before the quantity of rows of slow tests.
const SLOW: &str = "*slow:* ";

fn main() -> ExitCode {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = INTRODUCTION.to_owned();
    let mut failed = Vec::new();
    for test in tests(&root.join("tests")) {
        if !wanted.is_empty() && !wanted.contains(&test) {
            continue;
        }
        let Ok(source) = std::fs::read_to_string(root.join("tests").join(format!("{test}.rs"))) else { continue };
        if !source.contains("verify") {
            continue;
        }
        let Some((mut rows, mut passed)) = rows_of(root, &test, &[]) else {
            println!("cargo could not be run");
            return ExitCode::FAILURE;
        };
        if wanted.is_empty() && source.contains("#[ignore") {
            let Some((slow, all_passed)) = rows_of(root, &test, &["--ignored"]) else { return ExitCode::FAILURE };
            rows.extend(slow.into_iter().map(|mut row| {
                row[1].insert_str(0, SLOW);
                row
            }));
            passed &= all_passed;
        }
        if !passed {
            failed.push(test.clone());
        }
        println!("{test}: {} rows{}", rows.len(), if passed { "" } else { ", FAILED" });
        if !rows.is_empty() {
            section(&mut text, &test, &source, rows);
        }
    }
    if !failed.is_empty() {
        println!("VERIFICATION.md is left as it is, failed: {}", failed.join(", "));
        return ExitCode::FAILURE;
    }
    if !wanted.is_empty() {
        println!("\n{text}");
        return ExitCode::SUCCESS;
    }
    match std::fs::write(root.join("VERIFICATION.md"), text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            println!("VERIFICATION.md: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The rows that a test file prints, run with some more arguments, and whether all passed; `None` if cargo could not be run.
fn rows_of(root: &Path, test: &str, arguments: &[&str]) -> Option<(Vec<Row>, bool)> {
    let mut cargo = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()));
    cargo.args(["test", "--quiet", "--test", test, "--", "--nocapture", "--test-threads=1"]).args(arguments);
    let output = cargo.current_dir(root).output().ok()?;
    let rows = String::from_utf8_lossy(&output.stdout).lines().filter_map(row).collect();
    Some((rows, output.status.success()))
}

/// Names of the test files, sorted.
fn tests(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let name = |entry: std::fs::DirEntry| Some(entry.file_name().to_str()?.strip_suffix(".rs")?.to_owned());
    let mut names: Vec<String> = entries.filter_map(name).collect();
    names.sort();
    names
}

/// The row in a line of output, whatever the test runner has put before it.
fn row(line: &str) -> Option<Row> {
    let cells: Vec<&str> =
        line[line.find("| ")?..].trim_matches('|').split(" | ").map(|c| c.trim_matches([' ', '|'])).collect();
    let row: Row = cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>().try_into().ok()?;
    row[2..].iter().all(|number| number.parse::<f64>().is_ok()).then_some(row)
}

/// One table: the header's first paragraph, then the rows as they came.
fn section(text: &mut String, test: &str, source: &str, mut rows: Vec<Row>) {
    let header = source.lines().take_while(|l| l.starts_with("//!")).map(|l| l.trim_start_matches("//!").trim());
    let caption: Vec<&str> = header.take_while(|l| !l.is_empty()).collect();
    let _ = write!(text, "\n## {test}\n\n{}\n\n", caption.join(" "));
    text.push_str("| case | quantity | measured | reference | error | tolerance |\n|---|---|---|---|---|---|\n");
    // several tests of a file may pass through the same check
    rows.dedup();
    for [case, quantity, measured, reference, error, tolerance] in &rows {
        let [m, r, e, t] = [measured, reference, error, tolerance].map(|x| x.parse::<f64>().unwrap_or(f64::NAN));
        let known = e.clamp(1e-2 * t, t);
        let (m, r) = (number(m, known), number(r, known));
        let _ = writeln!(text, "| {case} | {quantity} | {m} | {r} | {} | {} |", rounded_up(e, t), plain(t));
    }
}

/// Down to the digit before that of the error.
fn number(x: f64, known: f64) -> String {
    if x.abs() <= known {
        return if x == 0.0 { "0".to_owned() } else { "≈ 0".to_owned() };
    }
    let digits = (x.abs() / known).log10().ceil().clamp(1.0, 11.0) as usize + 1;
    if (1e-3..1e6).contains(&x.abs()) {
        let decimals = (digits as i32 - 1 - x.abs().log10().floor() as i32).max(0) as usize;
        format!("{x:.decimals$}")
    } else {
        format!("{x:.0$e}", digits - 1)
    }
}

/// The error to the next power of ten above it, never less than a thousandth of the tolerance: below that it is rounding.
fn rounded_up(error: f64, tolerance: f64) -> String {
    let shown = error.max(1e-3 * tolerance);
    if shown == 0.0 { "0".to_owned() } else { format!("< 1e{}", shown.log10().floor() as i32 + 1) }
}

fn plain(x: f64) -> String {
    format!("{x:.0e}")
}
