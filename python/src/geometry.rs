//! Contact and topology of the caller's own curves, and numbers of DNA.

use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use supercoil::contact::{self, Curve, DetectorOptions, Radius, Site};
use supercoil::math::{Vec3, link};
use supercoil::{InputError, dna as constants};

use crate::refuse;

fn points_of(field: &str, array: &PyReadonlyArray2<f64>) -> PyResult<Vec<Vec3>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        let reason = format!("has {} columns: must be of shape (n, 3)", array.ncols());
        return Err(refuse::input(InputError::Inconsistent { field: field.to_owned(), reason }));
    }
    Ok(array.rows().into_iter().map(|p| Vec3::new(p[0], p[1], p[2])).collect())
}

/// Points that are all finite; the error names the first that is not.
fn finite_points_of(field: &str, array: &PyReadonlyArray2<f64>) -> PyResult<Vec<Vec3>> {
    let points = points_of(field, array)?;
    match points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        None => Ok(points),
        Some(k) => {
            let (field, value) = (format!("{field}[{k}]"), points[k].into());
            Err(refuse::input(InputError::Vector { field, value, allowed: "three finite numbers" }))
        }
    }
}

fn curve_of<'a>(points: &'a [Vec3], radii: &'a [f64], closed: bool) -> Curve<'a> {
    let radius = if let [one] = radii { Radius::Constant(*one) } else { Radius::PerSegment(radii) };
    Curve { closed, ..Curve::polyline(points, radius) }
}

/// Sites of curves (points (n, 3), radii of one number or one a segment, closed) with a gap of at most `range`.
#[pyfunction]
pub fn detect<'py>(
    py: Python<'py>,
    curves: Vec<(PyReadonlyArray2<'py, f64>, Vec<f64>, bool)>,
    range: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let mut own = Vec::new();
    for (k, (points, radii, closed)) in curves.iter().enumerate() {
        own.push((points_of(&format!("curves[{k}].points"), points)?, radii.as_slice(), *closed));
    }
    let sites = py.detach(|| {
        let curves: Vec<Curve> = own.iter().map(|(points, radii, closed)| curve_of(points, radii, *closed)).collect();
        contact::detect(&curves, DetectorOptions { range, zones: false, ..DetectorOptions::default() })
            .map(|found| found.sites)
    });
    let sites = sites.map_err(refuse::input)?;
    let numbers = |of: fn(&Site) -> f64| sites.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    let indices = |of: fn(&Site) -> usize| sites.iter().map(|s| of(s) as i64).collect::<Vec<_>>().into_pyarray(py);
    let out = PyDict::new(py);
    out.set_item("curve_a", indices(|s| s.curve_a))?;
    out.set_item("segment_a", indices(|s| s.segment_a))?;
    out.set_item("u_a", numbers(|s| s.u_a))?;
    out.set_item("arc_a", numbers(|s| s.arc_a))?;
    out.set_item("curve_b", indices(|s| s.curve_b))?;
    out.set_item("segment_b", indices(|s| s.segment_b))?;
    out.set_item("u_b", numbers(|s| s.u_b))?;
    out.set_item("arc_b", numbers(|s| s.arc_b))?;
    out.set_item("gap", numbers(|s| s.gap))?;
    out.set_item("angle", numbers(|s| s.angle))?;
    let normals: Vec<f64> = sites.iter().flat_map(|s| [s.normal.x, s.normal.y, s.normal.z]).collect();
    out.set_item("normal", PyArray1::from_vec(py, normals).reshape([sites.len(), 3])?)?;
    Ok(out)
}

/// Linking number of two closed polygons, turns.
#[pyfunction]
pub fn linking_number(py: Python, a: PyReadonlyArray2<f64>, b: PyReadonlyArray2<f64>) -> PyResult<f64> {
    let (a, b) = (finite_points_of("a", &a)?, finite_points_of("b", &b)?);
    Ok(py.detach(|| link::linking_number(&a, &b)))
}

/// Writhe of a polygon, turns.
#[pyfunction]
pub fn writhe(py: Python, points: PyReadonlyArray2<f64>, closed: bool) -> PyResult<f64> {
    let points = finite_points_of("points", &points)?;
    Ok(py.detach(|| link::writhe(&points, closed)))
}

/// Constants of DNA, nm and pN: rise, bending, twisting, stretching.
#[pyfunction]
pub fn dna() -> (f64, f64, f64, f64) {
    (constants::RISE, constants::BENDING_STIFFNESS, constants::TWIST_STIFFNESS, constants::STRETCH_MODULUS)
}

/// Excess link of a molecule at a supercoiling density, turns.
#[pyfunction]
pub fn excess_link(base_pairs: u64, sigma: f64) -> f64 {
    constants::Molecule { name: "", base_pairs }.excess_link(sigma)
}

/// Contact diameter of DNA at a sodium chloride concentration in mol/l, nm.
#[pyfunction]
pub fn contact_diameter(sodium_chloride: f64) -> PyResult<f64> {
    constants::contact_diameter_nm(sodium_chloride).map_err(refuse::input)
}
