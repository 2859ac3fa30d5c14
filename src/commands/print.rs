//! What the program prints: results to standard output, warnings to standard error.

use std::io::Write;

use supercoil::observe::StartOverlap;

/// Most overlaps listed one by one.
const MOST_WARNINGS: usize = 10;

/// Prints a line; a closed pipe (`supercoil check FILE | head`) is not an error.
pub fn say(line: std::fmt::Arguments) {
    std::io::stdout().write_fmt(format_args!("{line}\n")).ok();
}

/// Prints the deepest overlaps of a start shape.
pub fn warn(overlaps: &[StartOverlap]) {
    overlaps.iter().take(MOST_WARNINGS).for_each(|overlap| eprintln!("warning: {overlap}"));
    if let more @ 1.. = overlaps.len().saturating_sub(MOST_WARNINGS) {
        eprintln!("warning: {more} more overlaps, less deep");
    }
}
