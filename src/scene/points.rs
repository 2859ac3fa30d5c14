//! Centrelines from CSV or XYZ files.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::error::InputError;
use crate::math::Vec3;

/// Reads a centreline: three coordinates a line, in any length unit.
///
/// * `.xyz`: first line the number of points, second line a comment, then `element x y z`.
/// * anything else: x, y, z separated by commas, semicolons, tabs or blanks; one header line of words is skipped; empty
///   lines and what follows `#` are ignored.
///
/// # Errors
/// [`InputError::File`] if the file cannot be read, is no regular one or holds more than 256 MiB; [`InputError::Parse`] naming file, line and what was found if a
/// line has too few or too many numbers, a word, a NaN or an infinity, or if the number of points disagrees with the
/// first line of an `.xyz` file.
pub fn read_points(path: &Path) -> Result<Vec<Vec3>, InputError> {
    // before it is opened: opening a pipe that nobody writes to never ends
    if path.metadata().is_ok_and(|found| !found.is_file()) {
        let reason = "is no regular file: points are read from those only".to_owned();
        return Err(InputError::File { path: path.to_owned(), reason });
    }
    let text = read_text(path)?;
    let is_xyz = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xyz"));
    let parsed = if is_xyz { parse_xyz(&text) } else { parse_columns(&text) };
    parsed.map_err(|reason| InputError::Parse { file: path.display().to_string(), reason })
}

/// Most bytes of a scene or of a file of points: a million points with all their digits take 60 MB.
const MOST_BYTES: u64 = 256 << 20;

/// The text of a file that somebody names: no more than is sensible, whatever it is.
pub(super) fn read_text(path: &Path) -> Result<String, InputError> {
    let refuse = |reason: String| InputError::File { path: path.to_owned(), reason };
    let file = File::open(path).map_err(|e| refuse(e.to_string()))?;
    let mut text = String::new();
    file.take(MOST_BYTES + 1).read_to_string(&mut text).map_err(|e| refuse(e.to_string()))?;
    if text.len() as u64 > MOST_BYTES {
        return Err(refuse(format!("holds more than {} MiB", MOST_BYTES >> 20)));
    }
    Ok(text)
}

/// Points of a text in columns.
fn parse_columns(text: &str) -> Result<Vec<Vec3>, String> {
    let mut points = Vec::new();
    let mut header_allowed = true;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let fields = split(content);
        let is_header = fields.iter().all(|f| f.parse::<f64>().is_err());
        if !(header_allowed && is_header) {
            points.push(point(number, &fields)?);
        }
        header_allowed = false;
    }
    Ok(points)
}

/// Points of a text in XYZ format.
fn parse_xyz(text: &str) -> Result<Vec<Vec3>, String> {
    let mut lines = (1..).zip(text.lines());
    let first = lines.next().map_or("", |(_, line)| line).trim();
    let expected: usize =
        first.parse().map_err(|_| format!("line 1: a number of points expected, found \"{first}\""))?;
    let mut points = Vec::new();
    for (number, line) in lines.skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let fields = split(line.trim());
        points.push(point(number, fields.get(1..).unwrap_or_default())?);
    }
    if points.len() == expected {
        Ok(points)
    } else {
        Err(format!("line 1 announces {expected} points, {} follow", points.len()))
    }
}

/// Cells of a line: separated by its commas or semicolons, or else by blanks and tabs.
pub(super) fn split(line: &str) -> Vec<&str> {
    match [',', ';'].into_iter().find(|s| line.contains(*s)) {
        Some(separator) => line.split(separator).map(|cell| cell.trim().trim_matches('"')).collect(),
        None => line.split_whitespace().collect(),
    }
}

/// Three finite numbers of line `number`.
fn point(number: usize, fields: &[&str]) -> Result<Vec3, String> {
    let [x, y, z] = fields else {
        return Err(format!(
            "line {number}: three coordinates expected, found {} (\"{}\")",
            fields.len(),
            fields.join(" ")
        ));
    };
    let coordinate = |text: &str| finite(text).map_err(|reason| format!("line {number}: {reason}"));
    Ok(Vec3::new(coordinate(x)?, coordinate(y)?, coordinate(z)?))
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("a finite number expected, found \"{text}\"")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centrelines_in_several_dialects() {
        let expected = [Vec3::new(1.0, 2.0, -3e-4), Vec3::new(4.0, 5.5, 6.0)];
        for text in [
            "x,y,z\n1,2,-3e-4\n4,5.5,6\n",
            "# a comment\n1 2 -3e-4\n\n  4\t 5.5 6 # end\n",
            "\u{feff}\"x\";\"y\";\"z\"\r\n1;2;-3e-4\r\n4;5.5;6",
            "1,\t2, -3E-4\n4 ,5.5, 6",
        ] {
            assert_eq!(parse_columns(text).unwrap(), expected, "{text}");
        }
        assert_eq!(parse_xyz("2\nhelix\nC 1 2 -3e-4\nC 4 5.5 6\n\n").unwrap(), expected);
        assert!(parse_columns("").unwrap().is_empty());
    }

    #[test]
    fn unusable_lines_are_named() {
        for (text, reason) in [
            ("x,y,z\n1,2\n", "line 2: three coordinates expected, found 2 (\"1 2\")"),
            ("1,2,3\n\n1,nan,3\n", "line 3: a finite number expected, found \"nan\""),
            ("1,2,3\nx,y,z\n", "line 2: a finite number expected, found \"x\""),
            ("1,2,inf", "line 1: a finite number expected, found \"inf\""),
            ("a b c\nd e f", "line 2: a finite number expected, found \"d\""),
        ] {
            assert_eq!(parse_columns(text).unwrap_err(), reason);
        }
        assert_eq!(parse_xyz("3\n\nC 1 2 3").unwrap_err(), "line 1 announces 3 points, 1 follow");
        assert!(parse_xyz("C 1 2 3").unwrap_err().starts_with("line 1: a number of points expected"));
        assert!(parse_xyz("1\n\nC 1 2").unwrap_err().starts_with("line 3: three"));
        let error = read_points(Path::new("/nowhere/a.csv")).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/a.csv: "), "{error}");
    }
}
