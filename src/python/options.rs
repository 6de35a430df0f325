//! Keyword arguments of functions with many options.
//!
//! In: the dict of `**options`. Out: one value at a time; unknown arguments raise TypeError.

use crate::spelling;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Keyword arguments, each taken once.
pub(super) struct Options<'a, 'py> {
    given: Option<&'a Bound<'py, PyDict>>,
    known: Vec<&'static str>,
}

impl<'a, 'py> Options<'a, 'py> {
    pub(super) const fn new(given: Option<&'a Bound<'py, PyDict>>) -> Self {
        Self { given, known: Vec::new() }
    }

    /// Takes an argument unconverted; Python's `None` counts as missing.
    pub(super) fn any(&mut self, name: &'static str) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.known.push(name);
        let value = self.given.map(|given| given.get_item(name)).transpose()?.flatten();
        Ok(value.filter(|value| !value.is_none()))
    }

    /// Takes an argument, converted to `T`.
    pub(super) fn take<T: FromPyObjectOwned<'py>>(&mut self, name: &'static str) -> PyResult<Option<T>> {
        let Some(value) = self.any(name)? else { return Ok(None) };
        let extracted = value.extract::<T>().map_err(Into::into);
        extracted.map(Some).map_err(|error: PyErr| PyTypeError::new_err(format!("{name}: {}", error.value(value.py()))))
    }

    /// Rejects the arguments that were not taken.
    pub(super) fn end(self) -> PyResult<()> {
        for name in self.given.iter().flat_map(|given| given.keys()) {
            let name: String = name.extract()?;
            if !self.known.contains(&name.as_str()) {
                let hint = spelling::hint(&name, self.known.iter().copied());
                return Err(PyTypeError::new_err(format!("there is no argument '{name}'; {hint}")));
            }
        }
        Ok(())
    }
}
