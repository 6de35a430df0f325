//! Conversion of errors to Python exceptions.
//!
//! In: errors of the library. Out: `pinwarp.Error` or a subclass, with file, line, key and hint if the error has them.

use crate::export::ExportError;
use crate::image::ImageError;
use crate::lattice::LatticeError;
use crate::live::LiveError;
use crate::pipeline::PipelineError;
use crate::plate::PlateError;
use crate::raster::RasterError;
use crate::scene::SceneError;
use crate::shot::ShotError;
use crate::solve::SolveError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

/// Any error of the library, and invalid arguments found by the bindings.
#[derive(Debug, thiserror::Error)]
pub(super) enum Failure {
    /// An invalid argument.
    #[error("{key}: {what}; {hint}")]
    Argument {
        /// The argument, such as `pins[3]`.
        key: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// A callback returned False.
    #[error("cancelled: the progress callback returned False")]
    Cancelled,
    #[error(transparent)]
    Shot(#[from] ShotError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(transparent)]
    Export(#[from] ExportError),
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error(transparent)]
    Plate(#[from] PlateError),
    #[error(transparent)]
    Raster(#[from] RasterError),
    #[error(transparent)]
    Solve(#[from] SolveError),
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

/// The location of an error and its hint, as far as known.
#[derive(Default)]
struct Place<'a> {
    file: Option<&'a Path>,
    line: Option<usize>,
    key: Option<&'a str>,
    hint: Option<&'a str>,
}

impl Failure {
    /// Creates an invalid-argument error: which argument, what is wrong with it, how to fix it.
    pub(super) fn argument(key: impl Into<String>, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Argument { key: key.into(), what: what.into(), hint: hint.into() }
    }

    /// Returns whether the work was cancelled.
    fn is_cancelled(&self) -> bool {
        let of_pipeline =
            |error: &PipelineError| matches!(error, PipelineError::Solve { source: SolveError::Cancelled, .. });
        match self {
            Self::Cancelled | Self::Solve(SolveError::Cancelled) | Self::Live(LiveError::Aborted) => true,
            Self::Pipeline(error) | Self::Live(LiveError::Pipeline(error)) => of_pipeline(error),
            _ => false,
        }
    }

    fn place(&self) -> Place<'_> {
        match self {
            Self::Argument { key, hint, .. } => Place { key: Some(key), hint: Some(hint), ..Place::default() },
            Self::Shot(error) | Self::Live(LiveError::Shot(error)) => place_in_shot(error),
            Self::Pipeline(error) | Self::Live(LiveError::Pipeline(error)) => place_in_pipeline(error),
            Self::Live(LiveError::Controls { hint, .. }) | Self::Solve(SolveError::Invalid { hint, .. }) => {
                Place { hint: Some(hint), ..Place::default() }
            }
            Self::Live(LiveError::Layer { path, hint, .. }) => {
                Place { file: Some(path), hint: Some(hint), ..Place::default() }
            }
            Self::Export(error) => place_in_lattices(error),
            _ => Place::default(),
        }
    }

    /// Returns the individual faults of a shot file with several.
    fn faults(&self) -> &[ShotError] {
        match self {
            Self::Shot(error)
            | Self::Live(LiveError::Shot(error))
            | Self::Pipeline(PipelineError::Shot(error))
            | Self::Live(LiveError::Pipeline(PipelineError::Shot(error))) => error.each(),
            _ => &[],
        }
    }

    /// Returns the I/O error kind if a file could not be read or written.
    fn of_file(&self) -> Option<io::ErrorKind> {
        let mut cause: Option<&(dyn Error + 'static)> = Some(self);
        while let Some(error) = cause {
            if let Some(error) = error.downcast_ref::<io::Error>() {
                return Some(error.kind());
            }
            cause = error.source();
        }
        None
    }

    /// Returns the name of the exception class.
    fn kind(&self) -> &'static str {
        match (self, self.of_file()) {
            (failure, _) if failure.is_cancelled() => "Cancelled",
            (_, Some(io::ErrorKind::NotFound)) => "MissingFileError",
            (_, Some(_)) => "FileError",
            (Self::Raster(_), None) => "Error",
            _ => "InputError",
        }
    }
}

fn place_in_shot(error: &ShotError) -> Place<'_> {
    match error {
        ShotError::Io { path, .. } => Place { file: Some(path), ..Place::default() },
        ShotError::Syntax { path, line, .. } => Place { file: Some(path), line: Some(*line), ..Place::default() },
        ShotError::Invalid { path, line, key, hint, .. } => {
            Place { file: Some(path), line: Some(*line), key: Some(key), hint: Some(hint) }
        }
        ShotError::Many(errors) => errors.first().map(place_in_shot).unwrap_or_default(),
        ShotError::Edit { hint, .. } => Place { hint: Some(hint), ..Place::default() },
    }
}

fn place_in_pipeline(error: &PipelineError) -> Place<'_> {
    match error {
        PipelineError::Shot(error) => place_in_shot(error),
        PipelineError::Lattice(error) => place_in_lattices(error),
        PipelineError::Find { path, line, key, .. } => {
            Place { file: Some(path), line: Some(*line), key: Some(key), hint: None }
        }
        PipelineError::Mismatch { path, line, key, hint, .. } => {
            Place { file: Some(path), line: Some(*line), key: Some(key), hint: Some(hint) }
        }
        PipelineError::Unusable { hint, .. } => Place { hint: Some(hint), ..Place::default() },
        PipelineError::StMap { path, .. } | PipelineError::Folder { path, .. } => {
            Place { file: Some(path), ..Place::default() }
        }
        _ => Place::default(),
    }
}

fn place_in_lattices(error: &ExportError) -> Place<'_> {
    match error {
        ExportError::Read { path, .. } | ExportError::Json { path, .. } => {
            Place { file: Some(path), ..Place::default() }
        }
        ExportError::Invalid { path, key, hint, .. } => {
            Place { file: Some(path), line: None, key: Some(key), hint: Some(hint) }
        }
        _ => Place::default(),
    }
}

/// Creates an exception of a class defined in `src/python/pinwarp/_errors.py`.
fn exception<'py>(
    py: Python<'py>,
    kind: &str,
    (message, place): (String, Place),
    faults: Bound<'py, PyList>,
) -> PyResult<Bound<'py, PyAny>> {
    let details = PyDict::new(py);
    details.set_item("file", place.file.map(Path::to_owned).map(PathBuf::into_os_string))?;
    details.set_item("line", place.line)?;
    details.set_item("key", place.key)?;
    details.set_item("hint", place.hint)?;
    details.set_item("faults", faults)?;
    py.import("pinwarp._errors")?.getattr(kind)?.call((message,), Some(&details))
}

fn raised(py: Python<'_>, failure: &Failure) -> PyResult<PyErr> {
    let faults = PyList::empty(py);
    let single = failure.faults();
    for fault in single.iter().filter(|_| single.len() > 1) {
        let described = (fault.to_string(), place_in_shot(fault));
        faults.append(exception(py, "InputError", described, PyList::empty(py))?)?;
    }
    let described = (failure.to_string(), failure.place());
    Ok(PyErr::from_value(exception(py, failure.kind(), described, faults)?))
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| raised(py, &failure).unwrap_or_else(|error| error))
    }
}
