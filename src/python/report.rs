//! Conversion of the library's reports to Python dicts and lists.
//!
//! In: the structures that the command line prints with `--json`. Out: the same keys and values; non-finite numbers
//! become None.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;

/// Converts a report to plain Python values.
pub(super) fn plain<'py>(py: Python<'py>, report: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(report).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}
