//! Natural strains and stiffnesses along a rod from tables.
//!
//! The first line names the columns. A table with `from` and `to` has constant pieces, one with `s` has points with
//! straight lines between them; arc lengths in the unit of the rod's length. Separators, comments and blank lines as in
//! files of points.

use std::path::Path;

use crate::error::InputError;
use crate::rod::{Along, NaturalStrains, STRAINS, Stiffness, check_stiffness};
use crate::text::{NumberTable, read_regular};

/// Largest gap between pieces that counts as rounding of the written numbers, relative to the arc length.
const TOL_JOINT: f64 = 1e-9;

/// Columns of arc lengths.
const ARCS: [&str; 3] = ["s", "from", "to"];
/// Column of the contact radius.
const RADIUS: &str = "contact_radius";

/// Reads natural strains along a rod: any of the columns `gamma1 gamma2 gamma3 kappa1 kappa2 kappa3`. Missing ones are
/// 0, `gamma3` 1.
///
/// # Errors
/// [`InputError::File`] if the file cannot be read; [`InputError::Parse`] with line and value for columns that are
/// unknown, missing or duplicate, cells that are not numbers, pieces with gaps or overlaps, points that do not
/// increase.
pub fn read_natural(path: &Path) -> Result<Along<NaturalStrains>, InputError> {
    read(path, parse_natural)
}

/// Section along a rod, as read from a table.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionTable {
    /// Stiffness, for [`Rod::with_stiffness`](crate::rod::Rod::with_stiffness).
    pub stiffness: Along<Stiffness>,
    /// Contact radius \[L\], if there is a column of it, for
    /// [`Rod::with_contact_radii`](crate::rod::Rod::with_contact_radii).
    pub contact_radii: Option<Along<f64>>,
}

/// Reads the section along a rod: the columns `shearing1 shearing2 stretching bending1 bending2 twisting`, or
/// `shearing` and `bending` for both axes alike, and any couplings, each named by its two strains: `kappa2_kappa3`
/// couples bending about d2 with twist, `gamma3_kappa3` stretch with twist. With `contact_radius` the rod is tapered.
///
/// # Errors
/// As [`read_natural`]; matrices that are not positive definite and radii that are not positive, with their line.
pub fn read_section(path: &Path) -> Result<SectionTable, InputError> {
    read(path, parse_section)
}

fn read<T>(path: &Path, parse: impl Fn(&str) -> Result<T, String>) -> Result<T, InputError> {
    parse(&read_regular(path)?).map_err(|reason| InputError::Parse { file: path.display().to_string(), reason })
}

fn parse_natural(text: &str) -> Result<Along<NaturalStrains>, String> {
    let table = NumberTable::parse(text)?;
    let columns =
        table.columns(&ARCS, |name| STRAINS.iter().position(|strain| *strain == name), &STRAINS.join(", "))?;
    table.along(|_, row| {
        let mut strains = NaturalStrains::from([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        columns.iter().for_each(|&(column, strain)| strains[strain] = row[column]);
        if strains[2] > 0.0 { Ok(strains) } else { Err(format!("gamma3 = {}: must be greater than 0", strains[2])) }
    })
}

/// Columns of the diagonal; the last two apply to both axes.
const STIFFNESSES: [(&str, &[usize]); 8] = [
    ("shearing1", &[0]),
    ("shearing2", &[1]),
    ("stretching", &[2]),
    ("bending1", &[3]),
    ("bending2", &[4]),
    ("twisting", &[5]),
    ("shearing", &[0, 1]),
    ("bending", &[3, 4]),
];

/// Entries of the matrix that a column sets.
fn entries(name: &str) -> Option<Vec<(usize, usize)>> {
    if let Some((_, axes)) = STIFFNESSES.iter().find(|(known, _)| *known == name) {
        return Some(axes.iter().map(|&i| (i, i)).collect());
    }
    let (a, b) = name.split_once('_')?;
    let strain = |name: &str| STRAINS.iter().position(|strain| *strain == name);
    let (i, j) = (strain(a)?, strain(b)?);
    (i != j).then(|| vec![(i, j), (j, i)])
}

fn parse_section(text: &str) -> Result<SectionTable, String> {
    let table = NumberTable::parse(text)?;
    let names = STIFFNESSES.map(|(name, _)| name).join(", ");
    let [s, from, to] = ARCS;
    let columns =
        table.columns(&[s, from, to, RADIUS], entries, &format!("{names}, or two strains such as kappa2_kappa3"))?;
    for (i, (name, _)) in STIFFNESSES.iter().enumerate().take(6) {
        match columns.iter().filter(|(_, entries)| entries.contains(&(i, i))).count() {
            1 => {}
            0 => {
                return Err(format!(
                    "line {}: there is no column {name}: it gives the matrix its diagonal",
                    table.head
                ));
            }
            _ => return Err(format!("line {}: two columns give {name}", table.head)),
        }
    }
    let stiffness = table.along(|_, row| {
        let mut matrix = Stiffness::zeros();
        for (column, entries) in &columns {
            entries.iter().for_each(|&entry| matrix[entry] = row[*column]);
        }
        check_stiffness("the stiffness", &matrix).map_err(|error| error.to_string()).map(|()| matrix)
    })?;
    let radius = |column: usize| {
        table.along(|_, row| match InputError::positive(RADIUS, row[column]) {
            Ok(()) => Ok(row[column]),
            Err(error) => Err(error.to_string()),
        })
    };
    Ok(SectionTable { stiffness, contact_radii: table.column(RADIUS).map(radius).transpose()? })
}

impl NumberTable {
    /// The rows as a function of s, each converted by `value`.
    fn along<T: crate::rod::Averaged>(
        &self,
        value: impl Fn(usize, &[f64]) -> Result<T, String>,
    ) -> Result<Along<T>, String> {
        let of = |(line, row): &(usize, Vec<f64>)| value(*line, row).map_err(|reason| format!("line {line}: {reason}"));
        let values = self.rows.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        let refuse = |error: InputError| error.to_string();
        match (self.column("s"), self.column("from"), self.column("to")) {
            (Some(s), None, None) => Along::points(self.increasing(s)?, values).map_err(refuse),
            (None, Some(from), Some(to)) => Along::pieces(self.joined(from, to)?, values).map_err(refuse),
            _ => {
                let reason = "columns from and to (constant pieces) or a column s (points) expected";
                Err(format!("line {}: {reason}, found {}", self.head, self.names.join(", ")))
            }
        }
    }

    /// Arc lengths of points, from 0 on.
    fn increasing(&self, column: usize) -> Result<Vec<f64>, String> {
        let mut before: Option<f64> = None;
        for (line, row) in &self.rows {
            let s = row[column];
            match before {
                None if s != 0.0 => return Err(format!("line {line}: s = {s}: must be 0, the start of the rod")),
                Some(before) if s <= before => {
                    return Err(format!(
                        "line {line}: s = {s}: must be greater than {before}, that of the line before"
                    ));
                }
                _ => before = Some(s),
            }
        }
        Ok(self.rows.iter().map(|(_, row)| row[column]).collect())
    }

    /// Ends of pieces without gaps, from 0 on.
    fn joined(&self, from: usize, to: usize) -> Result<Vec<f64>, String> {
        let mut end = 0.0;
        for (line, row) in &self.rows {
            let (start, next) = (row[from], row[to]);
            if (start - end).abs() > TOL_JOINT * next.abs() {
                let slip = if start > end { "a gap" } else { "an overlap" };
                return Err(format!(
                    "line {line}: from = {start}: must be {end}, where the piece before ends ({slip})"
                ));
            }
            if next <= start {
                return Err(format!("line {line}: to = {next}: must be greater than from = {start}"));
            }
            end = next;
        }
        Ok(self.rows.iter().map(|(_, row)| row[to]).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn natural_strains_as_pieces_and_as_points() {
        let pieces = parse_natural("from,to,kappa1,kappa3\n0,1.5,0.2,1.8\n# a kink\n1.5,2,-0.2,1.7\n").unwrap();
        assert_eq!(pieces.at(1.0).as_slice(), [0.0, 0.0, 1.0, 0.2, 0.0, 1.8]);
        assert_eq!(pieces.at(1.6).as_slice(), [0.0, 0.0, 1.0, -0.2, 0.0, 1.7]);
        let points = parse_natural("Gamma3 s\n1 0\n1.2 4").unwrap();
        assert_eq!(points.at(1.0).as_slice(), [0.0, 0.0, 1.05, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn stiffnesses_with_couplings() {
        let found = parse_section(
            "from;to;bending;twisting;stretching;shearing1;shearing2;kappa2_kappa3\n0;1;2;3;10;11;12;-0.5",
        );
        let found = found.unwrap();
        assert!(found.contact_radii.is_none());
        let matrix = found.stiffness.at(0.3);
        assert_eq!(matrix.diagonal().as_slice(), [11.0, 12.0, 10.0, 2.0, 2.0, 3.0]);
        assert_eq!((matrix[(4, 5)], matrix[(5, 4)], matrix[(3, 5)]), (-0.5, -0.5, 0.0));
        let cone = parse_section("s,bending,twisting,stretching,shearing,contact_radius\n0,2,3,9,9,.1\n2,2,3,9,9,.3\n");
        assert!((cone.unwrap().contact_radii.unwrap().at(0.5) - 0.15).abs() < 1e-15);
    }

    #[test]
    fn bad_tables_are_refused_with_line_and_value() {
        for (text, reason) in [
            ("", "holds no line with the names of columns"),
            ("0,1,0.2\n", "line 1: names of columns expected, found 0"),
            ("from,to,kapa1\n", "line 1: unknown column \"kapa1\": must be s, from, to, gamma1"),
            ("from,to,kappa1,kappa1\n", "line 1: column \"kappa1\" is there twice"),
            ("from,to\n0,1\n", "line 1: no columns besides s, from, to"),
            ("from,kappa1\n0,1\n", "line 1: columns from and to (constant pieces) or a column s (points) expected, f"),
            ("s,kappa1\n0,1\n2,0\n1,0", "line 4: s = 1: must be greater than 2, that of the line before"),
            ("s,kappa1\n\n0.5,1\n", "line 3: s = 0.5: must be 0, the start of the rod"),
            ("from,to,kappa1\n0,1,0\n1.5,2,0", "line 3: from = 1.5: must be 1, where the piece before ends (a gap)"),
            (
                "from,to,kappa1\n0,1,0\n0.5,2,0",
                "line 3: from = 0.5: must be 1, where the piece before ends (an overlap)",
            ),
            ("from,to,kappa1\n0,0,0\n", "line 2: to = 0: must be greater than from = 0"),
            ("from,to,kappa1\n0,1\n", "line 2: 3 cells expected, found 2 (\"0,1\")"),
            ("from,to,kappa1\n0,1,nan\n", "line 2, column kappa1: a finite number expected, found \"nan\""),
            ("from,to,gamma3\n0,1,0\n", "line 2: gamma3 = 0: must be greater than 0"),
            ("from,to,kappa1\n", "number of ends = 0: must be at least 1"),
        ] {
            let found = parse_natural(text).unwrap_err();
            assert!(found.starts_with(reason), "{text:?}: {found}");
        }
        let head = "from,to,bending,twisting,stretching,shearing,kappa2_kappa3\n";
        for (text, reason) in [
            (format!("{head}0,1,2,3,9,9,0.1\n1,2,2,3,9,9,2.5"), "line 3: the stiffness: is not positive definite"),
            (format!("{head}0,1,2,-3,9,9,0.1"), "line 2: the stiffness[5][5] = -3: must be a finite number greater"),
            ("from,to,bending\n0,1,2".to_owned(), "line 1: there is no column shearing1"),
            ("from,to,bending,bending1\n0,1,2,2".to_owned(), "line 1: there is no column shearing1"),
            (format!("{},bending1\n", head.trim()), "line 1: two columns give bending1"),
            ("from,to,kappa2_kappa2\n".to_owned(), "line 1: unknown column \"kappa2_kappa2\""),
            (
                "s,bending,twisting,stretching,shearing,contact_radius\n0,2,3,9,9,.1\n2,2,3,9,9,0\n".to_owned(),
                "line 3: contact_radius = 0: must be",
            ),
        ] {
            let found = parse_section(&text).unwrap_err();
            assert!(found.starts_with(reason), "{text:?}: {found}");
        }
    }
}
