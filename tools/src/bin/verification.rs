//! Runs the tests, slow ones included, and writes what their verification rows say: a row per test file to
//! VERIFICATION.md, all rows to target/verification.md.
//!
//! `cargo run -p supercoil-tools --bin verification` for all (a quarter of an hour on two quiet cores),
//! `cargo run -p supercoil-tools --bin verification -- lee_frame roll_up` for some tests only (to the terminal, without
//! the slow ones).
#![allow(clippy::print_stdout)] // a program talks to its reader

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, ExitCode};

/// A row that a test printed.
#[derive(Clone)]
struct Row {
    case: String,
    quantity: String,
    measured: f64,
    reference: f64,
    error: f64,
    tolerance: f64,
    slow: bool,
}

/// What one test file has to say.
struct Section {
    /// The test binary that it is a module of.
    binary: String,
    test: String,
    /// The first paragraph of the file's header.
    caption: String,
    rows: Vec<Row>,
}

const SUMMARY: &str = "# Verification\n\n\
    Written by `cargo run -p supercoil-tools --bin verification`; do not edit. One line per test file: its case with \
    the source, the number of rows that it asserts, and the row nearest to its tolerance. The tool writes all rows to \
    `target/verification.md`; `cargo test NAME -- --nocapture` prints them with all digits.\n\n\
    References are closed forms, solutions of the continuous equations (shooting, collocation), or the literature for \
    tight knots. The header of each test file has source, parameters and units. Where a file computes its reference \
    itself, the method shares nothing with the engine. Tolerances cover the last digit of the reference, the mesh, \
    and the distance of the case from its limit (finite stiffness, thickness, penalty).\n\n\
    B, C: bending and twisting stiffness; L length, R radius, D contact diameter, ε contact radius; κ contact \
    stiffness; p order of the elements. Numbers end one digit below their error. `≈ 0` is no larger than the error.\n";

const DETAILS: &str = "# Verification, all rows\n\n\
    Written by `cargo run -p supercoil-tools --bin verification`. Each row is asserted by the test file that heads \
    its table: |measured − reference| ≤ tolerance. Rows marked *slow* need `--ignored` after the `--`. A row marked \
    **fails** is beyond its tolerance; its test ends there.\n\n\
    Errors are absolute, rounded up to one digit; `<` marks errors below a hundredth of the tolerance, given to a \
    power of ten. Of rows that differ in the slenderness L/ε only, the one with the largest error over its tolerance \
    is shown.\n";

/// Headings, each with its test files; what is in none of them comes last.
const GROUPS: [(&str, &[&str]); 7] = [
    (
        "One rod",
        &[
            "roll_up",
            "bathe_bolourchi",
            "ibrahimbegovic_helix",
            "helical_spring",
            "deep_arch",
            "lee_frame",
            "princeton",
            "intrinsic_curvature",
            "varying_rods",
            "dna_rings",
            "objectivity",
            "incremental_interpolation",
            "convergence_orders",
            "distributed_moment",
        ],
    ),
    ("Stability", &["greenhill", "michell_zajac", "lateral_buckling", "elastica_branches", "ring_branches", "snaps"]),
    (
        "Self-contact",
        &[
            "planar_touch",
            "planes",
            "obstacles",
            "beams",
            "contact_three_strands",
            "twisted_ring",
            "ring_events",
            "ring_topology",
            "ring_thickness",
            "path_corners",
            "two_ply",
            "plectoneme_under_tension",
            "tweezers",
            "turned_rods",
            "bowed_and_turned",
            "clamped_pop",
            "elastic_knots",
            "ropelength",
            "free_rods",
            "chain_of_rings",
            "electrostatics",
        ],
    ),
    ("Contact laws and Newton's method", &["contact_laws", "augmented_ring", "newton_orders", "held_motions"]),
    ("Topology", &["writhe_of_long_curves"]),
    ("Modes, free energies, sensitivities", &["modes", "free_energies", "sensitivities"]),
    ("Other", &[]),
];

fn main() -> ExitCode {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let mut sections = Vec::new();
    let mut failed = Vec::new();
    for (binary, test) in tests(&root.join("tests")) {
        if !wanted.is_empty() && !wanted.contains(&test) {
            continue;
        }
        let file = root.join("tests").join(&binary).join(format!("{test}.rs"));
        let Ok(source) = std::fs::read_to_string(file) else { continue };
        if !source.contains("verify") {
            continue;
        }
        let Some((mut rows, mut passed)) = rows_of(root, (&binary, &test), false) else {
            println!("cargo could not be run");
            return ExitCode::FAILURE;
        };
        if wanted.is_empty() && source.contains("#[ignore") {
            let Some((slow, all_passed)) = rows_of(root, (&binary, &test), true) else { return ExitCode::FAILURE };
            rows.extend(slow);
            passed &= all_passed;
        }
        if !passed {
            failed.push(test.clone());
        }
        println!("{test}: {} rows{}", rows.len(), if passed { "" } else { ", FAILED" });
        if !rows.is_empty() {
            sections.push(Section { binary, caption: caption(&source), rows: condensed(rows), test });
        }
    }
    let (summary, details) = (summary(&sections), details(&sections));
    if !wanted.is_empty() {
        println!("\n{summary}\n{details}");
    } else {
        for (file, text) in [("VERIFICATION.md", summary), ("target/verification.md", details)] {
            if let Err(error) = std::fs::write(root.join(file), text) {
                println!("{file}: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    if failed.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("failed: {}", failed.join(", "));
    ExitCode::FAILURE
}

/// The rows that a test file prints, its ordinary or its slow tests, and whether all passed; `None` if cargo could not
/// be run.
fn rows_of(root: &Path, (binary, test): (&str, &str), slow: bool) -> Option<(Vec<Row>, bool)> {
    let mut cargo = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()));
    cargo.args(["test", "--quiet", "--test", binary, "--", "--nocapture", "--test-threads=1"]);
    cargo.arg(format!("{test}::"));
    cargo.args(slow.then_some("--ignored"));
    let output = cargo.current_dir(root).output().ok()?;
    let rows = String::from_utf8_lossy(&output.stdout).lines().filter_map(|line| row(line, slow)).collect();
    Some((rows, output.status.success()))
}

/// Test binaries and the names of their modules, sorted by these.
fn tests(folder: &Path) -> Vec<(String, String)> {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut all = Vec::new();
    for binary in entries(folder).filter(|entry| entry.path().join("main.rs").exists()) {
        let name = |entry: std::fs::DirEntry| Some(entry.file_name().to_str()?.strip_suffix(".rs")?.to_owned());
        let modules = entries(&binary.path()).filter_map(name).filter(|name| name != "main");
        all.extend(modules.map(|module| (binary.file_name().to_string_lossy().into_owned(), module)));
    }
    all.sort_by(|a, b| a.1.cmp(&b.1));
    all
}

/// The row in a line of output, whatever the test runner has put before it.
fn row(line: &str, slow: bool) -> Option<Row> {
    let cells: Vec<&str> =
        line[line.find("| ")?..].trim_matches('|').split(" | ").map(|c| c.trim_matches([' ', '|'])).collect();
    let [case, quantity, numbers @ ..] = &cells[..] else { return None };
    let numbers: Vec<f64> = numbers.iter().map(|n| n.parse().ok()).collect::<Option<_>>()?;
    let [measured, reference, error, tolerance] = numbers[..] else { return None };
    let [case, quantity] = [case, quantity].map(|c| (*c).to_owned());
    Some(Row { case, quantity, measured, reference, error, tolerance, slow })
}

/// The first paragraph of a test file's header.
fn caption(source: &str) -> String {
    let header = source.lines().take_while(|l| l.starts_with("//!")).map(|l| l.trim_start_matches("//!").trim());
    header.take_while(|l| !l.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Without repetitions (several tests of a file may pass through the same check); of rows that differ in their
/// slenderness only the worst, which keeps its slenderness.
fn condensed(rows: Vec<Row>) -> Vec<Row> {
    const SLENDERNESS: &str = ", L/ε = ";
    let key = |row: &Row| {
        let rest = |text: &str| text.split(SLENDERNESS).next().unwrap_or_default().to_owned();
        let slender = [&row.case, &row.quantity].iter().any(|text| text.contains(SLENDERNESS));
        slender.then(|| (rest(&row.case), rest(&row.quantity)))
    };
    let share = |row: &Row| row.error / row.tolerance;
    let mut kept: Vec<Row> = Vec::new();
    for row in rows {
        let same = |other: &Row| (&other.case, &other.quantity) == (&row.case, &row.quantity);
        let repeated = |other: &Row| same(other) && other.measured.to_bits() == row.measured.to_bits();
        if kept.iter().any(repeated) {
            continue;
        }
        let slender = key(&row).and_then(|k| kept.iter_mut().find(|other| key(other).as_ref() == Some(&k)));
        match slender {
            Some(other) if share(other) < share(&row) => *other = row,
            Some(_) => {}
            None => kept.push(row),
        }
    }
    kept
}

/// Headings with their sections.
fn groups(sections: &[Section]) -> Vec<(&'static str, Vec<&Section>)> {
    let listed = |test: &str| GROUPS.iter().any(|(_, tests)| tests.contains(&test));
    let of_group = |tests: &'static [&'static str]| -> Vec<&Section> {
        if tests.is_empty() {
            return sections.iter().filter(|s| !listed(&s.test)).collect();
        }
        tests.iter().filter_map(|test| sections.iter().find(|s| s.test == *test)).collect()
    };
    let groups = GROUPS.map(|(name, tests)| (name, of_group(tests)));
    groups.into_iter().filter(|(_, sections)| !sections.is_empty()).collect()
}

/// A line per test file.
fn summary(sections: &[Section]) -> String {
    let mut text = SUMMARY.to_owned();
    for (name, sections) in groups(sections) {
        let _ =
            write!(text, "\n## {name}\n\n| test | case | rows | quantity | value | reference | error / tolerance |\n");
        text.push_str("|---|---|---|---|---|---|---|\n");
        sections.iter().for_each(|section| write_line(&mut text, section));
    }
    text
}

fn write_line(text: &mut String, section: &Section) {
    let Section { binary, test, caption, rows } = section;
    // a row that is exact may have no tolerance
    let share = |row: &Row| if row.measured == row.reference { 0.0 } else { row.error / row.tolerance };
    let Some(worst) = rows.iter().max_by(|a, b| share(a).total_cmp(&share(b))) else { return };
    let known = worst.error.clamp(1e-2 * worst.tolerance, worst.tolerance);
    let (measured, reference) = (number(worst.measured, known), number(worst.reference, known));
    let (case, rows, quantity, share) = (first_sentence(caption), rows.len(), &worst.quantity, share(worst));
    let file = format!("[{test}](tests/{binary}/{test}.rs)");
    let _ = writeln!(text, "| {file} | {case} | {rows} | {quantity} | {measured} | {reference} | {share:.1} |");
}

/// Up to the first full stop that ends a word.
fn first_sentence(caption: &str) -> &str {
    let ends = |at: &usize| caption[..*at].ends_with(|c: char| c.is_lowercase() || c.is_ascii_digit() || c == ')');
    let end = caption.match_indices(". ").map(|(at, _)| at).find(ends);
    caption[..end.unwrap_or(caption.len())].trim_end_matches('.')
}

/// All rows.
fn details(sections: &[Section]) -> String {
    let mut text = DETAILS.to_owned();
    for (name, sections) in groups(sections) {
        let _ = write!(text, "\n## {name}\n");
        sections.iter().for_each(|section| write_section(&mut text, section));
    }
    text
}

fn write_section(text: &mut String, section: &Section) {
    let Section { binary, test, caption, .. } = section;
    let _ = write!(text, "\n### {test}\n\n{caption} ([tests/{binary}/{test}.rs](tests/{binary}/{test}.rs))\n\n");
    text.push_str("| case | quantity | measured | reference | error | tolerance |\n|---|---|---|---|---|---|\n");
    for row in &section.rows {
        let known = row.error.clamp(1e-2 * row.tolerance, row.tolerance);
        let (measured, reference) = (number(row.measured, known), number(row.reference, known));
        let fails = if row.error <= row.tolerance { "" } else { " **fails**" };
        let (error, tolerance) = (shown_error(row.error, row.tolerance) + fails, short(row.tolerance));
        let slow = if row.slow { "*slow:* " } else { "" };
        let (case, quantity) = (&row.case, &row.quantity);
        let _ = writeln!(text, "| {case} | {slow}{quantity} | {measured} | {reference} | {error} | {tolerance} |");
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

/// One digit, rounded up; below a hundredth of the tolerance, where it may be rounding, only the power of ten above it,
/// never less than a thousandth of the tolerance.
fn shown_error(error: f64, tolerance: f64) -> String {
    if error >= 1e-2 * tolerance {
        let unit = 10f64.powi(error.log10().floor() as i32);
        return format!("{:.0e}", (error / unit).ceil() * unit);
    }
    let bound = error.max(1e-3 * tolerance);
    if bound == 0.0 { "0".to_owned() } else { format!("< 1e{}", bound.log10().floor() as i32 + 1) }
}

/// As many digits as it takes, at most three.
fn short(x: f64) -> String {
    let shorter = (0..2).map(|digits| format!("{x:.digits$e}"));
    let exact = |text: &String| text.parse::<f64>().is_ok_and(|y| (y / x - 1.0).abs() < 1e-3);
    shorter.into_iter().find(exact).unwrap_or_else(|| format!("{x:.2e}"))
}
