//! The command line inside the package: the entry point of the `pinwarp` script.

use crate::cli;
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command line and returns its exit code: 0 success, 1 some frames failed, 2 bad input or usage.
///
/// args: the program's name, then its arguments. Usage errors, --help and --version end the process. A process may render or warp only
/// once through this function: scripts should start the program `pinwarp` instead.
#[pyfunction]
pub(super) fn main(py: Python<'_>, args: Vec<OsString>) -> u8 {
    py.detach(|| cli::main_with(args))
}
