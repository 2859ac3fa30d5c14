//! Plots of columns of a run's tables.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::InputError;

use super::csv::legend_of;
use super::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use super::record::check_finished;
use super::table::PRESCRIBED;

/// Tables of a run: along its steps, or along the rods of its final state.
pub const PLOTTED: [&str; 4] = ["table", "resultants", "lines", "sites"];

/// A table of a finished run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunTable {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Units of the columns that have one.
    pub units: BTreeMap<String, String>,
    /// Columns that stages prescribe.
    prescribed: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl RunTable {
    /// Reads `table.csv` and `table_columns.csv` in the folder of a run.
    ///
    /// # Errors
    /// [`InputError::Parse`] for files that are missing or no tables.
    pub fn read(dir: &Path) -> Result<Self, InputError> {
        Self::read_named(dir, PLOTTED[0])
    }

    /// Reads the table of that name, one of [`PLOTTED`], and the file that explains its columns.
    ///
    /// # Errors
    /// [`InputError::Name`] for another name, [`InputError::Parse`] for files that are missing or no tables.
    pub fn read_named(dir: &Path, name: &str) -> Result<Self, InputError> {
        check_finished(dir)?;
        if !PLOTTED.contains(&name) {
            let (field, allowed) = ("table".to_owned(), format!("one of {}", PLOTTED.join(", ")));
            return Err(InputError::Name { field, name: name.to_owned(), allowed });
        }
        let file = dir.join(format!("{name}.csv"));
        if !file.exists() {
            let reason = "is not there: the run has no such contact, or is of an earlier version".to_owned();
            return Err(InputError::File { path: file, reason });
        }
        let (columns, rows) = read(&file)?;
        let (_, legend) = read(&legend_of(&file))?;
        let unit = |row: &Vec<String>| Some((row.first()?.clone(), row.get(1)?.clone()));
        let units = legend.iter().filter_map(unit).filter(|(_, unit)| !unit.is_empty()).collect();
        let is_prescribed = |row: &&Vec<String>| row.get(2).is_some_and(|meaning| meaning == PRESCRIBED);
        let prescribed = legend.iter().filter(is_prescribed).filter_map(|row| row.first().cloned()).collect();
        Ok(Self { columns, units, prescribed, rows })
    }

    /// Number of rows.
    pub(super) fn num_rows(&self) -> usize {
        self.rows.len()
    }

    /// Whether stages prescribe a column; excess link has one whether they do or not.
    pub(super) fn is_prescribed(&self, column: &str) -> bool {
        self.prescribed.iter().any(|name| name == column) || column.ends_with("excess_link")
    }

    /// The rows of one rod, by its name.
    ///
    /// # Errors
    /// [`InputError::Name`] if the table has no column `rod`, or no row of that rod.
    pub fn of_rod(mut self, rod: &str) -> Result<Self, InputError> {
        let refuse = |allowed: String| InputError::Name { field: "rod".to_owned(), name: rod.to_owned(), allowed };
        let Some(index) = self.columns.iter().position(|name| name == "rod") else {
            return Err(refuse("none: this table has no column rod".to_owned()));
        };
        let mut names: Vec<String> = self.rows.iter().filter_map(|row| row.get(index).cloned()).collect();
        names.dedup();
        self.rows.retain(|row| row.get(index).is_some_and(|name| name == rod));
        if self.rows.is_empty() { Err(refuse(format!("one of {}", names.join(", ")))) } else { Ok(self) }
    }

    /// Numbers of a column; blank cells are NaN.
    ///
    /// # Errors
    /// [`InputError::Name`] if there is none of that name, or it holds no numbers.
    pub fn numbers(&self, column: &str) -> Result<Vec<f64>, InputError> {
        let refuse =
            |allowed: String| InputError::Name { field: "column".to_owned(), name: column.to_owned(), allowed };
        let index = self.columns.iter().position(|name| name == column);
        let index = index.ok_or_else(|| {
            let likest = crate::text::likest(column, self.columns.iter().map(String::as_str));
            let hint = likest.map_or_else(String::new, |name| format!(": did you mean {name}?"));
            refuse(format!("one of {}{hint}", self.columns.join(", ")))
        })?;
        let cells = || self.rows.iter().map(|row| row.get(index).map_or("", String::as_str));
        if cells().any(|cell| !cell.is_empty() && cell.parse::<f64>().is_err()) {
            return Err(refuse("a column of numbers".to_owned()));
        }
        Ok(cells().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect())
    }

    /// Refuses columns that cannot share an axis.
    fn check_units(&self, columns: &[String]) -> Result<(), InputError> {
        let unit = |name: &String| self.units.get(name).map_or("none", String::as_str);
        let [first, others @ ..] = columns else { return Ok(()) };
        match others.iter().find(|other| unit(other) != unit(first)) {
            None => Ok(()),
            Some(other) => {
                let (a, b) = (unit(first), unit(other));
                let reason = format!(
                    "\"{first}\" and \"{other}\" cannot share an axis: their units are {a} and {b}. Plot each by itself"
                );
                Err(InputError::inconsistent("y", reason))
            }
        }
    }

    /// Plots columns against another one as SVG or PDF; a dashed line marks steps in which the rods snapped.
    ///
    /// # Errors
    /// As [`RunTable::numbers`] and [`plot_lines`]; columns of different units.
    pub fn plot(&self, x: &str, columns: &[String], file: &Path) -> Result<(), InputError> {
        self.check_units(columns)?;
        let places = self.numbers(x)?;
        let snapped = self.numbers("energy_released").map_or_else(
            |_| vec![false; places.len()],
            |released| released.into_iter().map(|energy| energy > 0.0).collect(),
        );
        let mut series = Vec::new();
        let mut snaps = Vec::new();
        for column in columns {
            let points: Vec<(f64, f64)> = places.iter().copied().zip(self.numbers(column)?).collect();
            let (line, jumps) = with_jumps(&points, &snapped);
            snaps.extend(jumps);
            series.push(Series { name: column.clone(), points: line, style: SeriesStyle::LinePoints });
        }
        if !snaps.is_empty() {
            series.push(Series { name: "snap".to_owned(), points: snaps, style: SeriesStyle::Dashed });
        }
        let label = |name: &str| match self.units.get(name) {
            Some(unit) => format!("{name}, {unit}"),
            None => name.to_owned(),
        };
        let y_label = match columns {
            [only] => label(only),
            [first, ..] => self.units.get(first).cloned().unwrap_or_default(),
            [] => String::new(),
        };
        plot_lines(file, &PlotSpec { x_label: label(x), y_label, series, ..PlotSpec::default() })
    }
}

/// A curve interrupted where the rods snapped, and the pieces across the interruptions.
pub(super) fn with_jumps(points: &[PlotPoint], snapped: &[bool]) -> (Vec<PlotPoint>, Vec<PlotPoint>) {
    let gap = (f64::NAN, f64::NAN);
    let (mut line, mut jumps) = (Vec::new(), Vec::new());
    for (k, &point) in points.iter().enumerate() {
        if k > 0 && snapped.get(k) == Some(&true) {
            line.push(gap);
            jumps.extend([points[k - 1], point, gap]);
        }
        line.push(point);
    }
    (line, jumps)
}

type PlotPoint = (f64, f64);
type TextTable = (Vec<String>, Vec<Vec<String>>);

fn read(path: &Path) -> Result<TextTable, InputError> {
    let refuse = |e: ::csv::Error| InputError::Parse { file: path.display().to_string(), reason: e.to_string() };
    let mut reader = ::csv::Reader::from_path(path).map_err(refuse)?;
    let words = |record: &::csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
    let columns = words(reader.headers().map_err(refuse)?);
    let rows = reader.records().map(|record| record.map(|record| words(&record)).map_err(refuse));
    Ok((columns, rows.collect::<Result<_, _>>()?))
}
