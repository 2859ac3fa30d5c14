//! Tables in CSV, centrelines from CSV or XYZ, nodal states.
//!
//! Floating-point numbers are written with the fewest digits that read back to the same bits (at most 17).

use crate::error::InputError;
use crate::math::{Quat, Vec3};
use crate::scene::Units;
use crate::scene::finite;
use std::path::{Path, PathBuf};

/// Re-export from scenes, one layer below, beside the other readers.
pub use crate::scene::read_points;

/// One cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A real number.
    Number(f64),
    /// A count or index.
    Count(usize),
    /// A string; quoted in the file if necessary.
    Text(String),
    /// No number, where the column has numbers: an empty cell.
    Missing,
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Count(value)
    }
}

impl From<&str> for Cell {
    fn from(value: &str) -> Self {
        Self::Text(value.to_owned())
    }
}

impl From<String> for Cell {
    fn from(value: String) -> Self {
        Self::Text(value)
    }
}

impl std::fmt::Display for Cell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Count(value) => write!(f, "{value}"),
            Self::Text(value) => f.write_str(value),
            Self::Missing => Ok(()),
        }
    }
}

/// Writes a table with a header line, replacing what is there.
///
/// # Errors
/// [`InputError::Inconsistent`] if a row's length differs from the header's, [`InputError::Write`] if the file cannot
/// be written.
pub fn write_table<Row>(path: &Path, header: &[&str], rows: impl IntoIterator<Item = Row>) -> Result<(), InputError>
where
    Row: IntoIterator<Item: Into<Cell>>,
{
    let file = std::fs::File::create(path).map_err(|e| write_error(path, &e.to_string()))?;
    write_rows(file, header, rows).map_err(|error| match error {
        InputError::Write { reason, .. } => write_error(path, &reason),
        other => other,
    })
}

/// Writes a table to where bytes go; errors of writing name no file.
fn write_rows<Row>(
    to: impl std::io::Write,
    header: &[&str],
    rows: impl IntoIterator<Item = Row>,
) -> Result<(), InputError>
where
    Row: IntoIterator<Item: Into<Cell>>,
{
    let refuse = |reason: String| write_error(Path::new(""), &reason);
    let mut writer = ::csv::Writer::from_writer(to);
    writer.write_record(header).map_err(|e| refuse(e.to_string()))?;
    for (index, row) in rows.into_iter().enumerate() {
        let cells: Vec<String> = row.into_iter().map(|c| c.into().to_string()).collect();
        if cells.len() != header.len() {
            let reason = format!("{} cells for {} columns", cells.len(), header.len());
            return Err(InputError::Inconsistent { field: format!("rows[{index}]"), reason });
        }
        writer.write_record(&cells).map_err(|e| refuse(e.to_string()))?;
    }
    writer.flush().map_err(|e| refuse(e.to_string()))
}

/// A column of a file: name, unit (empty for plain numbers and texts), meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExplainedColumn {
    /// Its head in the file.
    pub name: String,
    /// Name of its unit; may be empty.
    pub unit: String,
    /// Meaning of the column.
    pub meaning: &'static str,
}

/// Columns of name, dimension (in L and F, see [`Units::of`]) and meaning.
pub(crate) fn columns_in(units: &Units, columns: &[[&'static str; 3]]) -> Vec<ExplainedColumn> {
    let column = |&[name, dimension, meaning]: &[&'static str; 3]| ExplainedColumn {
        name: name.to_owned(),
        unit: units.of(dimension),
        meaning,
    };
    columns.iter().map(column).collect()
}

/// The file that explains the columns of a table: `table_columns.csv` of `table.csv`.
pub(crate) fn legend_of(table: &Path) -> PathBuf {
    let stem = table.file_stem().unwrap_or_default().to_string_lossy();
    table.with_file_name(format!("{stem}_columns.csv"))
}

/// Writes a table, and beside it name, unit and meaning of its columns, as `table_columns.csv` of `table.csv`.
///
/// # Errors
/// As [`write_table`].
pub(crate) fn write_explained<Row>(
    path: &Path,
    columns: &[ExplainedColumn],
    rows: impl IntoIterator<Item = Row>,
) -> Result<(), InputError>
where
    Row: IntoIterator<Item: Into<Cell>>,
{
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    write_table(path, &names, rows)?;
    let legend = columns.iter().map(|column| [column.name.as_str(), column.unit.as_str(), column.meaning]);
    write_table(&legend_of(path), &["column", "unit", "meaning"], legend)
}

/// Nodal state of one rod.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RodState {
    /// Reference arc length of each node \[L\].
    pub arc_lengths: Vec<f64>,
    /// Position of each node \[L\].
    pub positions: Vec<Vec3>,
    /// Frame of each node: d1 d2 d3 = q·e1, q·e2, q·e3.
    pub frames: Vec<Quat>,
}

/// Columns of a state file; quaternions scalar part first.
const STATE_COLUMNS: [[&str; 3]; 10] = [
    ["rod", "", "index of the rod, from 0"],
    ["node", "", "index of the node in its rod, from 0"],
    ["arc_length", "L", "reference arc length from the rod's start"],
    ["x", "L", POSITION],
    ["y", "L", POSITION],
    ["z", "L", POSITION],
    ["qw", "", FRAME],
    ["qx", "", FRAME],
    ["qy", "", FRAME],
    ["qz", "", FRAME],
];
const POSITION: &str = "position of the node";
const FRAME: &str = "unit quaternion of the frame: the rotation that takes x, y, z to d1, d2, d3";

/// Writes the nodal state of rods 0, 1, … as CSV: rod, node, arc_length, x, y, z, qw, qx, qy, qz; units and meanings in
/// a file beside it, as `final_state_columns.csv` of `final_state.csv`.
///
/// # Errors
/// [`InputError::Inconsistent`] if a rod's arrays differ in length, [`InputError::Write`] if the file cannot be
/// written.
pub fn write_state(path: &Path, rods: &[RodState], units: &Units) -> Result<(), InputError> {
    for (index, rod) in rods.iter().enumerate() {
        let counts = [rod.arc_lengths.len(), rod.positions.len(), rod.frames.len()];
        if counts[0] != counts[1] || counts[1] != counts[2] {
            let reason = format!("{} arc lengths, {} positions, {} frames", counts[0], counts[1], counts[2]);
            return Err(InputError::Inconsistent { field: format!("rods[{index}]"), reason });
        }
    }
    write_explained(path, &columns_in(units, &STATE_COLUMNS), state_rows(rods))
}

/// The text of a state file, as [`write_state`] writes it.
pub(crate) fn state_text(rods: &[RodState]) -> Result<String, InputError> {
    let mut bytes = Vec::new();
    write_rows(&mut bytes, &STATE_COLUMNS.map(|[name, ..]| name), state_rows(rods))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn state_rows(rods: &[RodState]) -> impl Iterator<Item = impl Iterator<Item = Cell>> {
    rods.iter().enumerate().flat_map(|(index, rod)| {
        (0..rod.positions.len()).map(move |node| {
            let (r, q) = (rod.positions[node], &rod.frames[node]);
            let numbers = [rod.arc_lengths[node], r.x, r.y, r.z, q.w, q.i, q.j, q.k].map(Cell::Number);
            [Cell::Count(index), Cell::Count(node)].into_iter().chain(numbers)
        })
    })
}

/// Reads what [`write_state`] wrote, bit for bit.
///
/// Quaternions may deviate from unit length by 1e-6 and are then normalised.
///
/// # Errors
/// [`InputError::File`] if the file cannot be read; [`InputError::Parse`] naming file and line if the header differs, a
/// number is missing or not finite, rods or nodes are out of order, or a quaternion is far from unit length.
pub fn read_state(path: &Path) -> Result<Vec<RodState>, InputError> {
    let refuse = |e: ::csv::Error| match e.kind() {
        ::csv::ErrorKind::Io(e) => file_error(path, &e.to_string()),
        _ => parse_error(path, e.to_string()),
    };
    let mut reader = ::csv::ReaderBuilder::new().trim(::csv::Trim::All).from_path(path).map_err(refuse)?;
    let header = reader.headers().map_err(refuse)?;
    let expected = STATE_COLUMNS.map(|[name, ..]| name);
    if header != expected.as_slice() {
        let found: Vec<&str> = header.iter().collect();
        return Err(parse_error(path, format!("line 1: columns {expected:?} expected, found {found:?}")));
    }
    let mut rods: Vec<RodState> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(refuse)?;
        let line = record.position().map_or(0, ::csv::Position::line);
        add_node(&mut rods, &record).map_err(|reason| parse_error(path, format!("line {line}: {reason}")))?;
    }
    Ok(rods)
}

/// Appends one line of a state file.
fn add_node(rods: &mut Vec<RodState>, record: &::csv::StringRecord) -> Result<(), String> {
    let index =
        |k: usize| record[k].parse::<usize>().map_err(|_| format!("an index expected, found \"{}\"", &record[k]));
    let (rod, node) = (index(0)?, index(1)?);
    if rod == rods.len() && node == 0 {
        rods.push(RodState::default());
    }
    let num_rods = rods.len();
    let Some(state) = rods.last_mut().filter(|s| rod + 1 == num_rods && node == s.positions.len()) else {
        return Err(format!("rod {rod} node {node} is out of order"));
    };
    let mut values = [0.0; 8];
    for (k, value) in values.iter_mut().enumerate() {
        *value = finite(&record[k + 2])?;
    }
    let [s, x, y, z, w, i, j, k] = values;
    let q = nalgebra::Quaternion::new(w, i, j, k);
    if (q.norm() - 1.0).abs() > 1e-6 {
        return Err(format!("quaternion of length {} is no rotation", q.norm()));
    }
    // A quaternion of unit length to rounding keeps its bits.
    let frame = if (q.norm() - 1.0).abs() < 1e-13 { Quat::new_unchecked(q) } else { Quat::new_normalize(q) };
    state.arc_lengths.push(s);
    state.positions.push(Vec3::new(x, y, z));
    state.frames.push(frame);
    Ok(())
}

fn write_error(path: &Path, reason: &str) -> InputError {
    InputError::Write { path: path.to_owned(), reason: reason.to_owned() }
}

fn file_error(path: &Path, reason: &str) -> InputError {
    InputError::File { path: path.to_owned(), reason: reason.to_owned() }
}

fn parse_error(path: &Path, reason: String) -> InputError {
    InputError::Parse { file: path.display().to_string(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// A path in the system's temporary folder that no other test uses.
    fn scratch(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("supercoil_csv_{}_{name}", std::process::id()))
    }

    #[test]
    fn numbers_come_back_bit_for_bit() {
        let path = scratch("table.csv");
        let numbers = [0.1 + 0.2, 1e-310, -f64::MAX, std::f64::consts::PI * 1e22, 5e-324, -0.0];
        let rows = numbers.iter().enumerate().map(|(i, x)| [Cell::from(i), (*x).into(), "a, \"b\"".into()]);
        write_table(&path, &["i", "x", "note"], rows).unwrap();
        let mut reader = ::csv::Reader::from_path(&path).unwrap();
        for (record, x) in reader.records().zip(numbers) {
            let record = record.unwrap();
            assert_eq!(record[1].parse::<f64>().unwrap().to_bits(), x.to_bits());
            assert_eq!(&record[2], "a, \"b\"");
        }
        std::fs::remove_file(&path).unwrap();
        assert!(write_table(&path, &["a", "b"], [[1.0]]).unwrap_err().to_string().contains("1 cells for 2 columns"));
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn states_come_back_bit_for_bit() {
        let path = scratch("state.csv");
        let rod = |n: usize| RodState {
            arc_lengths: (0..n).map(|i| i as f64 / 3.0).collect(),
            positions: (0..n).map(|i| Vec3::new((i as f64).sin(), 1e-17, -1e9 / 7.0)).collect(),
            frames: (0..n).map(|i| Quat::from_scaled_axis(Vec3::new(0.3 * i as f64, -1.0, 2.0))).collect(),
        };
        let rods = [rod(7), rod(2)];
        write_state(&path, &rods, &Units::default()).unwrap();
        assert_eq!(read_state(&path).unwrap(), rods);
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to, reason) in [
            ("\n1,0,", "\n2,0,", "line 9: rod 2 node 0 is out of order"),
            ("\n0,3,1.0,", "\n0,3,NaN,", "line 5: a finite number expected, found \"NaN\""),
            ("arc_length", "s", "line 1: columns"),
        ] {
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let error = read_state(&path).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
        std::fs::remove_file(legend_of(&path)).unwrap();
        std::fs::remove_file(&path).unwrap();
    }
}
