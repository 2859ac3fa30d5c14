//! Sweeps: plans, cases, tables.

use std::path::PathBuf;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use supercoil::io::sweep::{self, ColumnValues, SweepRun, SweepTable, from_bytes, to_bytes};
use supercoil::solve::Interrupt;

use crate::refuse;
use crate::supervise::supervised;

/// The plan of a sweep.
#[pyclass(frozen, module = "supercoil._supercoil")]
pub struct Plan(sweep::Plan);

fn table(bytes: &[u8]) -> PyResult<SweepTable> {
    from_bytes(bytes.to_vec(), &|_| true).map_err(|reason| refuse::damaged("part", reason))
}

fn as_bytes<'py>(py: Python<'py>, table: &SweepTable) -> PyResult<Bound<'py, PyBytes>> {
    Ok(PyBytes::new(py, &to_bytes(table).map_err(|reason| refuse::damaged("table", reason))?))
}

#[pymethods]
impl Plan {
    /// Plans a sweep file.
    #[staticmethod]
    fn of_file(path: PathBuf) -> PyResult<Self> {
        sweep::Plan::of_file(&path).map(Self).map_err(refuse::input)
    }

    /// Reads the plan in the folder of a sweep.
    #[staticmethod]
    fn read(dir: PathBuf) -> PyResult<Self> {
        sweep::Plan::read(&dir).map(Self).map_err(refuse::input)
    }

    #[staticmethod]
    fn from_text(text: &str) -> PyResult<Self> {
        sweep::Plan::from_text(text, "plan").map(Self).map_err(refuse::input)
    }

    fn to_text(&self) -> PyResult<String> {
        self.0.to_text().map_err(refuse::input)
    }

    fn write(&self, dir: PathBuf) -> PyResult<()> {
        self.0.write(&dir).map_err(refuse::input)
    }

    /// Of every case: id, values that it replaces.
    fn cases(&self) -> Vec<(String, Vec<String>)> {
        self.0.cases().iter().map(|case| (case.id.clone(), self.0.set(case))).collect()
    }

    /// The plan of some of the cases.
    fn only(&self, indices: Vec<usize>) -> PyResult<Self> {
        self.0.only(&indices).map(Self).map_err(refuse::input)
    }

    /// Runs all cases one after the other on one thread; their rows as bytes.
    fn run<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let interrupt = Interrupt::default();
        let rows = supervised(
            py,
            &interrupt,
            |_: std::sync::mpsc::Sender<()>| {
                let mut all = SweepTable::default();
                for case in self.0.cases() {
                    let rows = self.0.run(case, &interrupt)?;
                    all.append(&rows, 0..rows.num_rows());
                }
                Some(all)
            },
            |()| Ok(()),
        )?;
        as_bytes(py, &rows.ok_or_else(|| refuse::damaged("sweep", "was interrupted"))?)
    }

    /// Runs the cases that have no rows yet in the folder of the plan, side by side.
    #[staticmethod]
    fn run_in(py: Python, dir: PathBuf, jobs: Option<usize>) -> PyResult<()> {
        let interrupt = Interrupt::default();
        let default = SweepRun::default();
        let jobs = jobs.unwrap_or(default.jobs);
        let run = SweepRun { jobs, interrupt: interrupt.clone(), ..default };
        let work = |_: std::sync::mpsc::Sender<()>| run.go(&dir, &mut |_| ());
        supervised(py, &interrupt, work, |()| Ok(()))?.map(drop).map_err(refuse::input)
    }

    /// Numbers of the cases that have no rows in the folder of a sweep.
    fn missing(&self, py: Python, dir: PathBuf) -> PyResult<Vec<usize>> {
        let there = py.detach(|| sweep::finished_ids(&dir)).map_err(refuse::input)?;
        let is_missing = |(index, case): (usize, &sweep::Case)| (!there.contains(&case.id)).then_some(index);
        Ok(self.0.cases().iter().enumerate().filter_map(is_missing).collect())
    }

    /// All rows in the order of the plan, from parts as bytes, and the numbers of the cases that have none.
    fn merge<'py>(&self, py: Python<'py>, parts: Vec<Vec<u8>>) -> PyResult<(Bound<'py, PyBytes>, Vec<usize>)> {
        let tables = parts.iter().map(|part| table(part)).collect::<PyResult<Vec<_>>>()?;
        let collected = py.detach(|| sweep::merge(&self.0, &tables)).map_err(refuse::input)?;
        Ok((as_bytes(py, &collected.table)?, collected.missing))
    }

    /// All rows in the folder of a sweep, and the numbers of the cases that have none.
    #[staticmethod]
    fn collect(py: Python<'_>, dir: PathBuf) -> PyResult<(Bound<'_, PyBytes>, Vec<usize>)> {
        let collected = py.detach(|| sweep::collect(&dir)).map_err(refuse::input)?;
        Ok((as_bytes(py, &collected.table)?, collected.missing))
    }

    /// Writes rows, as bytes, into the folder of a sweep.
    #[staticmethod]
    fn write_part(py: Python, dir: PathBuf, parts: Vec<Vec<u8>>) -> PyResult<()> {
        let mut all = SweepTable::default();
        for part in &parts {
            let rows = table(part)?;
            all.append(&rows, 0..rows.num_rows());
        }
        py.detach(|| sweep::write_part(&dir, &all)).map_err(refuse::input)
    }
}

/// The columns of a table: arrays of numbers (NaN where there is none), lists of words.
#[pyfunction]
pub fn table_columns<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for column in table(bytes)?.columns() {
        let rows = 0..column.values.len();
        match &column.values {
            ColumnValues::Text(words) => columns.set_item(&column.name, words.clone())?,
            ColumnValues::Whole(wholes) if wholes.iter().all(Option::is_some) => {
                let wholes: Vec<i64> = wholes.iter().flatten().copied().collect();
                columns.set_item(&column.name, wholes.into_pyarray(py))?;
            }
            values => {
                let numbers: Vec<f64> = rows.map(|row| values.number(row).unwrap_or(f64::NAN)).collect();
                columns.set_item(&column.name, numbers.into_pyarray(py))?;
            }
        }
    }
    Ok(columns)
}
