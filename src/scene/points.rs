//! Centrelines from CSV or XYZ files.

use std::path::Path;

use crate::error::InputError;
use crate::math::Vec3;
use crate::text::{finite, read_regular, split};

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
    let text = read_regular(path)?;
    let is_xyz = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xyz"));
    let parsed = if is_xyz { parse_xyz(&text) } else { parse_columns(&text) };
    parsed.map_err(|reason| InputError::Parse { file: path.display().to_string(), reason })
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
