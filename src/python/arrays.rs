//! Conversion of points and indices between NumPy and plain data.
//!
//! In: anything that NumPy can convert to an array. Out: lists of points, checked for shape and finite values. In the
//! other direction, lists become arrays without a copy.

use super::failure::Failure;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// Reads points, (N, D). They are copied, since the library reads them without holding the GIL.
pub(super) fn points<const D: usize>(values: &Bound<'_, PyAny>, key: &str) -> Result<Vec<[f64; D]>, Failure> {
    if values.len().is_ok_and(|rows| rows == 0) {
        // An empty list has no columns.
        return Ok(Vec::new());
    }
    let array = table(values, key, D)?;
    let array = array.as_array();
    let rows = array.rows().into_iter().enumerate().map(|(row, point)| {
        let point: [f64; D] = std::array::from_fn(|axis| point[axis]);
        if point.iter().all(|value| value.is_finite()) {
            return Ok(point);
        }
        Err(Failure::argument(format!("{key}[{row}]"), format!("is {point:?}"), "give finite numbers"))
    });
    rows.collect()
}

/// Returns the number of columns of a table.
pub(super) fn columns(values: &Bound<'_, PyAny>, key: &str) -> Result<usize, Failure> {
    let array = any_table(values, key, "(N, 2) or (N, 3)")?;
    Ok(array.shape()[1])
}

/// Reads triangles, (M, 3), as zero-based indices.
pub(super) fn triangles(values: &Bound<'_, PyAny>, key: &str) -> Result<Vec<[u32; 3]>, Failure> {
    let array = table(values, key, 3)?;
    let array = array.as_array();
    let rows = array.rows().into_iter().enumerate().map(|(row, corners)| {
        let is_index = |value: f64| value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0;
        if corners.iter().all(|&value| is_index(value)) {
            return Ok(std::array::from_fn(|corner| corners[corner] as u32));
        }
        let given: Vec<f64> = corners.to_vec();
        Err(Failure::argument(format!("{key}[{row}]"), format!("is {given:?}"), "give indices of points, from 0"))
    });
    rows.collect()
}

/// Reads a table with `columns` columns.
fn table<'py>(
    values: &Bound<'py, PyAny>,
    key: &str,
    columns: usize,
) -> Result<PyArrayLike2<'py, f64, AllowTypeChange>, Failure> {
    let wanted = format!("(N, {columns})");
    let array = any_table(values, key, &wanted)?;
    let [rows, found] = [array.shape()[0], array.shape()[1]];
    if found == columns {
        return Ok(array);
    }
    Err(Failure::argument(key, format!("has the shape ({rows}, {found})"), format!("give {wanted}")))
}

fn any_table<'py>(
    values: &Bound<'py, PyAny>,
    key: &str,
    wanted: &str,
) -> Result<PyArrayLike2<'py, f64, AllowTypeChange>, Failure> {
    values.extract().map_err(|_| {
        let given = described(values);
        Failure::argument(
            key,
            format!("is {given}, not a table of numbers"),
            format!("give an array of the shape {wanted}"),
        )
    })
}

/// Describes a value in a message: shape and dtype of an array, else its type.
pub(super) fn described(value: &Bound<'_, PyAny>) -> String {
    let own = |name: &str| value.getattr(name).and_then(|own| own.str()).map(|text| text.to_string());
    match (own("dtype"), own("shape")) {
        (Ok(dtype), Ok(shape)) => format!("an array of {dtype} with the shape {shape}"),
        _ => value.get_type().name().map_or_else(|_| "an object".into(), |name| format!("of the type {name}")),
    }
}

/// Returns points as an array (N, D) of float64, without a copy.
pub(super) fn from_points<const D: usize>(py: Python<'_>, points: Vec<[f64; D]>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let rows = points.len();
    PyArray1::from_vec(py, points.into_flattened()).reshape([rows, D])
}

/// Returns triangles as an array (M, 3) of uint32, without a copy.
pub(super) fn from_triangles(py: Python<'_>, triangles: Vec<[u32; 3]>) -> PyResult<Bound<'_, PyArray2<u32>>> {
    let rows = triangles.len();
    PyArray1::from_vec(py, triangles.into_flattened()).reshape([rows, 3])
}
