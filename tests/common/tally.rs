//! Tables of runs: by family, those that failed, and what differs between two files of rows.

#![allow(dead_code)] // every user takes its part
#![allow(clippy::print_stdout)] // benches talk to their readers

use std::collections::BTreeMap;
use std::path::Path;

use super::play::Row;

/// Relative difference of energies from which two runs count as having come to other states.
const SAME_ENERGY: f64 = 1e-5;

/// The entry at a share of a sorted list, 0 if it is empty.
fn quantile<T: Copy + Default>(sorted: &[T], share: f64) -> T {
    sorted.get((share * (sorted.len().max(1) - 1) as f64).round() as usize).copied().unwrap_or_default()
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

/// Families in the order in which they come, with their rows.
fn grouped(rows: &[Row]) -> Vec<(&str, Vec<&Row>)> {
    let mut groups: Vec<(&str, Vec<&Row>)> = Vec::new();
    for row in rows {
        match groups.iter_mut().find(|(name, _)| *name == row.family) {
            Some((_, list)) => list.push(row),
            None => groups.push((&row.family, vec![row])),
        }
    }
    groups
}

fn line(name: &str, rows: &[&Row]) {
    let passed = rows.iter().filter(|row| row.passed).count();
    let mut steps: Vec<usize> = rows.iter().flat_map(|row| row.steps_taken()).collect();
    steps.sort_unstable();
    let seconds = sorted(rows.iter().map(|row| row.seconds).collect());
    let sum = |of: fn(&Row) -> usize| rows.iter().map(|row| of(row)).sum::<usize>();
    println!(
        "| {name:<18} | {:>5} | {passed:>6} | {:>10} | {:>9} | {:>6} | {:>4} | {:>5} | {:>9} | {:>8.1} | {:>8.1} |",
        rows.len(),
        sum(|row| row.iterations),
        sum(|row| row.elsewhere),
        quantile(&steps, 0.5),
        quantile(&steps, 0.9),
        quantile(&steps, 1.0),
        sum(|row| row.cutbacks),
        quantile(&seconds, 0.5),
        quantile(&seconds, 1.0)
    );
}

/// A line for every family, and what failed.
pub fn print(rows: &[Row]) {
    println!(
        "| {:<18} | {:>5} | {:>6} | {:>10} | {:>9} | {:>6} | {:>4} | {:>5} | {:>9} | {:>8} | {:>8} |",
        "family",
        "cases",
        "passed",
        "iterations",
        "elsewhere",
        "median",
        "90 %",
        "worst",
        "cut-backs",
        "median s",
        "worst s"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    grouped(rows).iter().for_each(|(name, list)| line(name, list));
    line("all", &rows.iter().collect::<Vec<_>>());
    println!(
        "(elsewhere: iterations on coarser meshes and shorter rods, not among the others; median, 90 %, worst: \
         iterations per accepted load step, failed attempts before it included)"
    );
    let failed: Vec<&Row> = rows.iter().filter(|row| !row.passed).collect();
    if !failed.is_empty() {
        println!("\n{} of {} did not pass:", failed.len(), rows.len());
    }
    for row in failed {
        println!("  {} {}: {}; {}", row.family, row.case, row.status, row.reason);
    }
}

/// Rows as a CSV file.
pub fn write(path: &Path, rows: &[Row]) -> Result<(), csv::Error> {
    if let Some(dir) = path.parent() {
        std::fs::create_dir_all(dir)?;
    }
    let mut writer = csv::Writer::from_path(path)?;
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.flush().map_err(Into::into)
}

/// Rows of such a file.
pub fn read(path: &Path) -> Result<Vec<Row>, csv::Error> {
    csv::Reader::from_path(path)?.deserialize().collect()
}

/// What differs from earlier rows of the same cases.
pub fn compare(before: &[Row], now: &[Row]) {
    let earlier: BTreeMap<(&str, &str), &Row> =
        before.iter().map(|row| ((row.family.as_str(), row.case.as_str()), row)).collect();
    let pairs: Vec<(&Row, &Row)> = now
        .iter()
        .filter_map(|row| earlier.get(&(row.family.as_str(), row.case.as_str())).map(|before| (*before, row)))
        .collect();
    println!("\n{} cases in both files; of those that passed both times:", pairs.len());
    println!("| {:<18} | {:>5} | {:>10} | {:>10} | {:>6} |", "family", "cases", "before", "now", "now/before");
    println!("|---|---|---|---|---|");
    for (family, _) in grouped(now) {
        let both: Vec<_> = pairs.iter().filter(|(a, b)| b.family == family && a.passed && b.passed).collect();
        let [old, new] =
            [both.iter().map(|p| p.0.iterations).sum::<usize>(), both.iter().map(|p| p.1.iterations).sum()];
        let ratio = new as f64 / old.max(1) as f64;
        println!("| {family:<18} | {:>5} | {old:>10} | {new:>10} | {ratio:>6.2} |", both.len());
    }
    for (a, b) in &pairs {
        let name = format!("{} {}", b.family, b.case);
        if a.passed != b.passed {
            let word = if b.passed { "passes now" } else { "fails now" };
            println!("  {name}: {word} ({}; was: {} {})", b.status, a.status, a.reason);
        } else if a.passed && (a.energy - b.energy).abs() > SAME_ENERGY * a.energy.abs() {
            println!("  {name}: another state, energy {:.8e}, was {:.8e}", b.energy, a.energy);
        }
    }
}
