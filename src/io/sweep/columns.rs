//! Tables with named columns that grow row by row; rows may have different columns.

use std::ops::Range;

use super::super::csv::Cell;

/// Values of a column, one per row; `None` where the row has no value.
#[derive(Debug, Clone, PartialEq)]
pub enum ColumnValues {
    /// Real numbers.
    Number(Vec<Option<f64>>),
    /// Whole numbers.
    Whole(Vec<Option<i64>>),
    /// Words.
    Text(Vec<Option<String>>),
}

impl ColumnValues {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Number(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of a row as a number, if it is one.
    #[must_use]
    pub fn number(&self, row: usize) -> Option<f64> {
        match self {
            Self::Number(values) => values[row],
            Self::Whole(values) => values[row].map(|value| value as f64),
            Self::Text(_) => None,
        }
    }

    /// The value of a row as text, if there is any.
    #[must_use]
    pub fn text(&self, row: usize) -> Option<String> {
        match self {
            Self::Number(values) => values[row].map(|value| format!("{value:?}")),
            Self::Whole(values) => values[row].map(|value| value.to_string()),
            Self::Text(values) => values[row].clone(),
        }
    }

    /// Whether two rows hold the same value, to the bit.
    fn is_same(&self, row: usize, other: &Self, other_row: usize) -> bool {
        match (self, other) {
            (Self::Number(a), Self::Number(b)) => a[row].map(f64::to_bits) == b[other_row].map(f64::to_bits),
            (Self::Whole(a), Self::Whole(b)) => a[row] == b[other_row],
            (a, b) => a.text(row) == b.text(other_row),
        }
    }

    /// No values of the same kind.
    fn empty(&self) -> Self {
        match self {
            Self::Number(_) => Self::Number(Vec::new()),
            Self::Whole(_) => Self::Whole(Vec::new()),
            Self::Text(_) => Self::Text(Vec::new()),
        }
    }

    fn is_none(&self, row: usize) -> bool {
        match self {
            Self::Number(values) => values[row].is_none(),
            Self::Whole(values) => values[row].is_none(),
            Self::Text(values) => values[row].is_none(),
        }
    }

    fn push_none(&mut self, count: usize) {
        let len = self.len() + count;
        match self {
            Self::Number(values) => values.resize(len, None),
            Self::Whole(values) => values.resize(len, None),
            Self::Text(values) => values.resize(len, None),
        }
    }

    /// Appends a value. A value of another kind converts the column to a kind that holds both.
    fn push(&mut self, cell: Cell) {
        match (&mut *self, cell) {
            (Self::Number(values), Cell::Number(value)) => values.push(Some(value)),
            (Self::Whole(values), Cell::Count(value)) => values.push(Some(value as i64)),
            (Self::Text(values), Cell::Text(value)) => values.push(Some(value)),
            (Self::Number(values), Cell::Count(value)) => values.push(Some(value as f64)),
            (values, Cell::Missing) => values.push_none(1),
            (Self::Text(values), other) => values.push(Some(other.to_string())),
            (Self::Whole(values), Cell::Number(value)) => {
                let mut numbers: Vec<_> = values.iter().map(|value| value.map(|value| value as f64)).collect();
                numbers.push(Some(value));
                *self = Self::Number(numbers);
            }
            (_, Cell::Text(value)) => {
                let mut words: Vec<_> = (0..self.len()).map(|row| self.text(row)).collect();
                words.push(Some(value));
                *self = Self::Text(words);
            }
        }
    }

    fn cell(&self, row: usize) -> Option<Cell> {
        match self {
            Self::Number(values) => values[row].map(Cell::Number),
            Self::Whole(values) => values[row].map(|value| Cell::Count(value as usize)),
            Self::Text(values) => values[row].clone().map(Cell::Text),
        }
    }
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its values, one a row.
    pub values: ColumnValues,
}

/// A table; all columns have the same number of rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SweepTable {
    columns: Vec<Column>,
    rows: usize,
}

impl SweepTable {
    /// A table of columns. Shorter columns are padded with rows without a value.
    #[must_use]
    pub fn new(mut columns: Vec<Column>) -> Self {
        let rows = columns.iter().map(|column| column.values.len()).max().unwrap_or(0);
        columns.iter_mut().for_each(|column| column.values.push_none(rows - column.values.len()));
        Self { columns, rows }
    }

    /// The columns, in the order of first appearance.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows.
    #[must_use]
    pub fn num_rows(&self) -> usize {
        self.rows
    }

    /// The values of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&ColumnValues> {
        self.columns.iter().find(|column| column.name == name).map(|column| &column.values)
    }

    /// Appends a row; missing columns are added.
    pub fn push<'a>(&mut self, row: impl IntoIterator<Item = (&'a str, Cell)>) {
        for (name, cell) in row {
            let index = self.place(name, || match cell {
                Cell::Number(_) | Cell::Missing => ColumnValues::Number(Vec::new()),
                Cell::Count(_) => ColumnValues::Whole(Vec::new()),
                Cell::Text(_) => ColumnValues::Text(Vec::new()),
            });
            self.columns[index].values.push(cell);
        }
        self.end_row();
    }

    /// Adds rows of another table.
    pub fn append(&mut self, other: &Self, rows: Range<usize>) {
        let places: Vec<usize> = other.columns.iter().map(|c| self.place(&c.name, || c.values.empty())).collect();
        for row in rows {
            for (column, &place) in other.columns.iter().zip(&places) {
                if let Some(cell) = column.values.cell(row) {
                    self.columns[place].values.push(cell);
                }
            }
            self.end_row();
        }
    }

    /// Index of a column, which is added if missing.
    fn place(&mut self, name: &str, empty: impl FnOnce() -> ColumnValues) -> usize {
        self.columns.iter().position(|column| column.name == name).unwrap_or_else(|| {
            let mut values = empty();
            values.push_none(self.rows);
            self.columns.push(Column { name: name.to_owned(), values });
            self.columns.len() - 1
        })
    }

    fn end_row(&mut self) {
        self.rows += 1;
        let rows = self.rows;
        self.columns.iter_mut().for_each(|column| column.values.push_none(rows - column.values.len()));
    }

    /// The first column in which some rows differ from those of another table, in value or presence; columns named in
    /// `but` are ignored.
    #[must_use]
    pub fn difference(
        &self,
        rows: Range<usize>,
        other: &Self,
        other_rows: Range<usize>,
        but: &[&str],
    ) -> Option<String> {
        if rows.len() != other_rows.len() {
            return Some("number of rows".to_owned());
        }
        let differs = |name: &str| {
            let pairs = rows.clone().zip(other_rows.clone());
            match (self.column(name), other.column(name)) {
                (Some(a), Some(b)) => pairs.into_iter().any(|(row, other)| !a.is_same(row, b, other)),
                (Some(a), None) => rows.clone().any(|row| !a.is_none(row)),
                (None, Some(b)) => other_rows.clone().any(|row| !b.is_none(row)),
                (None, None) => false,
            }
        };
        let names = self.columns.iter().chain(&other.columns).map(|column| column.name.as_str());
        names.filter(|name| !but.contains(name)).find(|name| differs(name)).map(str::to_owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_with_different_columns_and_kinds_make_one_table() {
        let mut table = SweepTable::default();
        table.push([("a", Cell::Count(1))]);
        table.push([("b", Cell::from("w")), ("a", Cell::Number(0.5))]);
        table.push([]);
        assert_eq!(table.num_rows(), 3);
        assert_eq!(table.column("a"), Some(&ColumnValues::Number(vec![Some(1.0), Some(0.5), None])));
        assert_eq!(table.column("b"), Some(&ColumnValues::Text(vec![None, Some("w".into()), None])));
        table.push([("a", Cell::from("word"))]);
        assert_eq!(table.column("a").unwrap().text(1), Some("0.5".into()));
    }

    #[test]
    fn a_bit_makes_a_difference_and_zeros_have_signs() {
        let of = |x: f64, seconds: f64| {
            let mut table = SweepTable::default();
            table.push([("x", Cell::Number(x)), ("seconds", Cell::Number(seconds))]);
            table
        };
        let differ = |a: &SweepTable, b: &SweepTable| a.difference(0..1, b, 0..1, &["seconds"]);
        assert_eq!(differ(&of(1.0, 1.0), &of(1.0, 2.0)), None);
        assert_eq!(differ(&of(1.0, 1.0), &of(1.0 + f64::EPSILON, 1.0)), Some("x".into()));
        assert_eq!(differ(&of(0.0, 1.0), &of(-0.0, 1.0)), Some("x".into()));
        assert_eq!(differ(&of(f64::NAN, 1.0), &of(f64::NAN, 1.0)), None);
        let (mut long, one) = (of(1.0, 1.0), of(1.0, 1.0));
        long.append(&one, 0..1);
        assert_eq!(long.difference(0..2, &one, 0..1, &[]), Some("number of rows".into()));
        let mut wider = of(1.0, 1.0);
        wider.columns.push(Column { name: "y".into(), values: ColumnValues::Whole(vec![None]) });
        assert_eq!(differ(&wider, &one), None);
        wider.columns[2].values = ColumnValues::Whole(vec![Some(0)]);
        assert_eq!((differ(&wider, &one), differ(&one, &wider)), (Some("y".into()), Some("y".into())));
    }
}
