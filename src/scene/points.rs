//! Centrelines from files: CSV, XYZ, Geomview's VECT, PDB, NumPy, oxDNA.

mod formats;
mod smooth;

use std::path::Path;

use crate::dna::base_pairs::BasePairs;
use crate::error::InputError;
use crate::math::Vec3;
use crate::text::{finite, read_regular, read_regular_bytes, split};

pub use smooth::smooth_points;

/// Which points of a file make a centreline.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// CSV: names of the columns of x, y, z in the header; `None`: `x`, `y`, `z` if there are such, else the only three
    /// columns.
    pub columns: Option<[String; 3]>,
    /// Index of the frame (XYZ), model (PDB) or curve (VECT), from 0; negative: from the last, -1. Required if the file
    /// has several.
    pub frame: Option<i64>,
    /// PDB: the chain. Required if the file has several.
    pub chain: Option<String>,
    /// Stride: every such point from the first. Legal: at least 1.
    pub every: usize,
    /// Factor on all coordinates. Legal: > 0.
    pub scale: f64,
}

impl Default for Import {
    fn default() -> Self {
        Self { columns: None, frame: None, chain: None, every: 1, scale: 1.0 }
    }
}

/// Reads a centreline: three coordinates per line, in any length unit. See [`read_points_with`].
///
/// # Errors
/// As [`read_points_with`].
pub fn read_points(path: &Path) -> Result<Vec<Vec3>, InputError> {
    read_points_with(path, &Import::default())
}

/// Reads a centreline; the extension of the file selects the format.
///
/// * `.xyz`: a line with the number of points, a comment line, then `element x y z`; several frames one after the
///   other.
/// * `.vect` (Geomview): polylines, open or closed; colours are ignored.
/// * `.pdb`: the phosphorus atoms (`P`) of a chain.
/// * `.npy` (NumPy): shape (points, 3), or (points, 4, 3), of which the first rows count: frames of base pairs.
/// * an oxDNA configuration of two strands, whatever its name: the axis, in nm, one point a base pair.
/// * anything else: x, y, z separated by commas, semicolons, tabs or blanks; a header may come first; empty lines and
///   comments after `#` are ignored. In a file with further columns (an index, for example) the header identifies them.
///
/// # Errors
/// [`InputError::File`] if the file cannot be read, is not a regular file or is larger than 256 MiB;
/// [`InputError::Parse`] naming file, line and what was found if a line has too few or too many numbers, a word, a NaN
/// or an infinity, if counts disagree, or if the selection is not in the file.
pub fn read_points_with(path: &Path, import: &Import) -> Result<Vec<Vec3>, InputError> {
    if import.every == 0 {
        return Err(InputError::Count { field: "every".to_owned(), value: 0, allowed: "at least 1" });
    }
    InputError::positive("scale", import.scale)?;
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let refuse = |reason: String| InputError::Parse { file: path.display().to_string(), reason };
    let thinned =
        |points: Vec<Vec3>| points.into_iter().step_by(import.every).map(|point| point * import.scale).collect();
    if extension == "npy" {
        return formats::npy(&read_regular_bytes(path)?).map(thinned).map_err(refuse);
    }
    let text = read_regular(path)?;
    let parsed = match extension.as_str() {
        "xyz" => parse_xyz(&text).and_then(|frames| one_of(frames, import.frame, "frames")),
        "vect" => formats::vect(&text).and_then(|curves| one_of(curves, import.frame, "curves")),
        "pdb" => formats::pdb(&text, import.chain.as_deref())
            .and_then(|models| one_of(models, import.frame, "models of this chain")),
        _ if is_oxdna(&text) => BasePairs::from_oxdna(&text, false).map(|pairs| pairs.positions),
        _ => match &import.columns {
            None => parse_columns(&text),
            Some(names) => named_columns(&text, names.each_ref().map(String::as_str))
                .map(|rows| rows.into_iter().map(Vec3::from).collect()),
        },
    };
    parsed.map(thinned).map_err(refuse)
}

/// An oxDNA configuration begins with time, box and energies.
fn is_oxdna(text: &str) -> bool {
    let begins = |line: Option<&str>, name: char| {
        line.is_some_and(|line| line.trim_start().starts_with(name) && line.contains('='))
    };
    let mut lines = text.lines();
    begins(lines.next(), 't') && begins(lines.next(), 'b') && begins(lines.next(), 'E')
}

/// One of several lists of points; `wanted` is required if there are several.
fn one_of(mut all: Vec<Vec<Vec3>>, wanted: Option<i64>, what: &str) -> Result<Vec<Vec3>, String> {
    let count = all.len() as i64;
    let index = match wanted {
        None if count == 1 => 0,
        None => return Err(format!("holds {count} {what}: say which by frame = 0 to {}, or -1, the last", count - 1)),
        Some(from_end) if from_end < 0 => count + from_end,
        Some(index) => index,
    };
    if (0..count).contains(&index) {
        return Ok(all.swap_remove(index as usize));
    }
    Err(format!("holds {count} {what}, none of them is frame = {}", wanted.unwrap_or(0)))
}

/// Non-empty lines, numbered, without comments.
fn contents(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = (1..).zip(text.trim_start_matches('\u{feff}').lines());
    lines
        .map(|(number, line)| (number, line.split('#').next().unwrap_or_default().trim()))
        .filter(|(_, l)| !l.is_empty())
}

/// Points of a text in columns.
fn parse_columns(text: &str) -> Result<Vec<Vec3>, String> {
    let head: Vec<&str> = contents(text).next().map(|(_, line)| split(line)).unwrap_or_default();
    if head.len() > 3 {
        let called = |name: &str| head.iter().copied().find(|cell| cell.eq_ignore_ascii_case(name));
        if let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(called) {
            return named_columns(text, [x, y, z]).map(|rows| rows.into_iter().map(Vec3::from).collect());
        }
    }
    let mut points = Vec::new();
    let mut header_allowed = true;
    for (number, content) in contents(text) {
        let fields = split(content);
        let is_header = fields.iter().all(|f| f.parse::<f64>().is_err());
        if !(header_allowed && is_header) {
            points.push(point(number, &fields)?);
        }
        header_allowed = false;
    }
    Ok(points)
}

/// Numbers of the columns with these names in the header.
pub(super) fn named_columns<const N: usize>(text: &str, names: [&str; N]) -> Result<Vec<[f64; N]>, String> {
    let mut lines = contents(text);
    let head = lines.next().map(|(_, line)| split(line)).unwrap_or_default();
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let found = head.iter().position(|cell| *cell == name);
        *place = found.ok_or_else(|| format!("line 1: no column \"{name}\"; the head line has {}", head.join(", ")))?;
    }
    let row = |(number, line): (usize, &str)| {
        let cells = split(line);
        let mut numbers = [0.0; N];
        for (value, &place) in numbers.iter_mut().zip(&places) {
            let cell = cells.get(place).copied().unwrap_or_default();
            *value = finite(cell).map_err(|reason| format!("line {number}, column {}: {reason}", head[place]))?;
        }
        Ok(numbers)
    };
    lines.map(row).collect()
}

/// Frames of a text in XYZ format.
fn parse_xyz(text: &str) -> Result<Vec<Vec<Vec3>>, String> {
    let mut lines = (1..).zip(text.lines()).peekable();
    let mut frames = Vec::new();
    while frames.is_empty() || lines.peek().is_some() {
        let (number, first) = lines.next().map_or((1, ""), |(number, line)| (number, line.trim()));
        let expected: usize =
            first.parse().map_err(|_| format!("line {number}: a number of points expected, found \"{first}\""))?;
        lines.next();
        let mut points = Vec::new();
        for (number, line) in lines.by_ref().take(expected).take_while(|(_, line)| !line.trim().is_empty()) {
            let fields = split(line.trim());
            points.push(point(number, fields.get(1..4).or(fields.get(1..)).unwrap_or_default())?);
        }
        if points.len() != expected {
            return Err(format!("line {number} announces {expected} points, {} follow", points.len()));
        }
        frames.push(points);
        while lines.next_if(|(_, line)| line.trim().is_empty()).is_some() {}
    }
    Ok(frames)
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
        let named = "index,Y,z,X\n7,2,-3e-4,1\n8,5.5,6,4\n";
        assert_eq!(parse_columns(named).unwrap(), expected);
        assert_eq!(named_columns(named, ["X", "Y", "z"]).unwrap(), expected.map(|v| [v.x, v.y, v.z]));
        assert_eq!(parse_xyz("2\nhelix\nC 1 2 -3e-4\nC 4 5.5 6\n\n").unwrap(), [expected]);
        let two = "1\nfirst\nC 0 0 0 17\n2\nsecond\nC 1 2 -3e-4\nC 4 5.5 6\n";
        assert_eq!(parse_xyz(two).unwrap(), [vec![Vec3::zeros()], expected.to_vec()]);
        for (frame, points) in [(0, 1), (1, 2), (-1, 2), (-2, 1)] {
            assert_eq!(one_of(parse_xyz(two).unwrap(), Some(frame), "frames").unwrap().len(), points);
        }
        let which = one_of(parse_xyz(two).unwrap(), None, "frames").unwrap_err();
        assert_eq!(which, "holds 2 frames: say which by frame = 0 to 1, or -1, the last");
        assert!(one_of(parse_xyz(two).unwrap(), Some(2), "frames").unwrap_err().contains("none of them is frame = 2"));
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
        let absent = named_columns("a,b\n1,2\n", ["x"]).unwrap_err();
        assert_eq!(absent, "line 1: no column \"x\"; the head line has a, b");
        let word = named_columns("a,b\n1,2\n1,c\n", ["b"]).unwrap_err();
        assert_eq!(word, "line 3, column b: a finite number expected, found \"c\"");
        assert!(parse_xyz("C 1 2 3").unwrap_err().starts_with("line 1: a number of points expected"));
        assert!(parse_xyz("1\n\nC 1 2").unwrap_err().starts_with("line 3: three"));
        let error = read_points(Path::new("/nowhere/a.csv")).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/a.csv: "), "{error}");
    }
}
