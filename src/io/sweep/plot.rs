//! Plots of a sweep: any column over any other.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::InputError;

use super::super::picture::{PlotSpec, Series, SeriesStyle, plot_lines};
use super::case::ID;
use super::columns::{ColumnValues, SweepTable};

/// Most curves, because more cannot be distinguished.
const MOST_CURVES: usize = 12;

/// Columns of a plot.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlotAxes {
    /// Column along the horizontal axis: numbers.
    pub x: String,
    /// Column along the vertical axis: numbers.
    pub y: String,
    /// A curve for each value of this column.
    pub by: Option<String>,
    /// All rows, a curve a case unless `by` is given; else the last row of each case.
    pub steps: bool,
}

/// Draws a column of a collected sweep over another as SVG or PDF. Where several rows of a curve have the same x, their
/// mean is drawn; rows without one of the two values are passed over.
///
/// # Errors
/// [`InputError::Name`] for columns that are not there or hold words; too many curves; errors of drawing.
pub fn plot(path: &Path, table: &SweepTable, axes: &PlotAxes) -> Result<(), InputError> {
    let (x, y) = (numbers(table, "x", &axes.x)?, numbers(table, "y", &axes.y)?);
    let by = axes.by.as_deref().or(axes.steps.then_some(ID));
    let by = by.map(|name| column(table, "by", name).map(|values| (name, values))).transpose()?;
    let ids = column(table, "case", ID)?;
    let is_last = |row: usize| row + 1 == table.num_rows() || ids.text(row) != ids.text(row + 1);
    // name, then the values at each x
    let mut curves: Vec<(String, BTreeMap<Ordered, Vec<f64>>)> = Vec::new();
    for row in (0..table.num_rows()).filter(|&row| axes.steps || is_last(row)) {
        let (Some(x), Some(y)) = (x.number(row), y.number(row)) else { continue };
        let name = by.map_or_else(String::new, |(name, values)| label(name, values, row));
        let curve = match curves.iter().position(|(found, _)| *found == name) {
            Some(curve) => curve,
            None if curves.len() == MOST_CURVES => return Err(too_many(by.map_or("", |(name, _)| name))),
            None => {
                curves.push((name, BTreeMap::new()));
                curves.len() - 1
            }
        };
        curves[curve].1.entry(Ordered(x)).or_default().push(y);
    }
    let mean = curves.iter().flat_map(|(_, points)| points.values()).any(|values| values.len() > 1);
    let series = |(name, points): (String, BTreeMap<Ordered, Vec<f64>>)| {
        let point = |(x, values): (Ordered, Vec<f64>)| (x.0, values.iter().sum::<f64>() / values.len() as f64);
        Series { name, points: points.into_iter().map(point).collect(), style: SeriesStyle::LinePoints }
    };
    let y_label = if mean { format!("{}, mean", axes.y) } else { axes.y.clone() };
    let series = curves.into_iter().map(series).collect();
    plot_lines(path, &PlotSpec { x_label: axes.x.clone(), y_label, series, ..PlotSpec::default() })
}

/// A number with a total order.
#[derive(Debug, Clone, Copy)]
struct Ordered(f64);

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ordered {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ordered {}

fn label(name: &str, values: &ColumnValues, row: usize) -> String {
    let value = values.text(row).unwrap_or_else(|| "none".to_owned());
    if name == ID {
        return value.chars().take(8).collect();
    }
    // the last part of a key is the most specific
    let short = name.rsplit('.').next().unwrap_or(name);
    format!("{short} = {}", value.strip_suffix(".0").unwrap_or(&value))
}

fn too_many(by: &str) -> InputError {
    let reason = format!("makes more than {MOST_CURVES} curves: name a column with fewer values with by");
    InputError::Inconsistent { field: by.to_owned(), reason }
}

fn column<'a>(table: &'a SweepTable, field: &str, name: &str) -> Result<&'a ColumnValues, InputError> {
    table.column(name).ok_or_else(|| {
        let names: Vec<&str> = table.columns().iter().map(|column| column.name.as_str()).collect();
        InputError::Name { field: field.to_owned(), name: name.to_owned(), allowed: names.join(", ") }
    })
}

fn numbers<'a>(table: &'a SweepTable, field: &str, name: &str) -> Result<&'a ColumnValues, InputError> {
    match column(table, field, name)? {
        ColumnValues::Text(_) => {
            let allowed = "a column of numbers".to_owned();
            Err(InputError::Name { field: field.to_owned(), name: name.to_owned(), allowed })
        }
        values => Ok(values),
    }
}
