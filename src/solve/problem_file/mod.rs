//! Problem files: the solver applied to a mesh, with JSON as input and output, for researchers and tests.
//!
//! In: a JSON file (vertices, triangles, dims, pins, ...). Out: P', V', energies per iteration, distortion measures. Missing keys
//! take the defaults of the program; `lambdas` selects the plain sums of the paper, see [`run_file`].

mod error;
mod figure;
mod file;
mod job;
mod measures;

pub use error::ProblemError;
pub use figure::{Figure, FigurePart, FigurePose, Figures, read_figure};
pub(crate) use measures::Measures;

use super::minimization::Energies;
use serde::Serialize;
use std::path::Path;

/// The result of a problem file. Points have as many coordinates as `dims` has entries, two or three.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultFile {
    /// Moved handles, #handles, x fastest.
    #[serde(rename = "P")]
    pub handles: Vec<Vec<f64>>,
    /// Moved vertices, #vertices.
    #[serde(rename = "V")]
    pub vertices: Vec<Vec<f64>>,
    /// Energy terms after each accepted step: those of local-global steps with the rotations of the step, those of Newton steps
    /// with the best rotations. The last entry belongs to `P`.
    pub(crate) energies: Vec<Energies>,
    /// Distortion of the triangles from rest to `V`.
    pub(crate) measures: Measures,
    /// Number of iterations.
    pub iterations: usize,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Solves the problem in a file.
///
/// With `lambdas` the energies are plain sums with one sample per triangle, the solve starts at rest, and points outside the box
/// are not clamped. With `iterations` it takes exactly that number of steps without acceleration. Without both it uses the
/// defaults and runs to convergence.
///
/// # Errors
/// [`ProblemError`], which names the file and the key.
pub fn run_file(problem: &Path) -> Result<ResultFile, ProblemError> {
    let text = crate::files::read_text(problem, crate::files::LATTICE_BYTES);
    let text = text.map_err(|source| ProblemError::Read { path: problem.to_owned(), source })?;
    run_text(&text).map_err(|source| ProblemError::In { path: problem.to_owned(), source: Box::new(source) })
}

/// Solves a problem given as JSON text; see [`run_file`].
///
/// ```
/// let square = r#"{"dims": [4, 4], "bbox": [[0, 0], [1, 1]], "triangles": [[0, 1, 2]],
///     "vertices": [[0, 0], [1, 0], [1, 1]], "pins": [{"vertex": 2, "target": [1.5, 1.0]}]}"#;
/// let result = pinwarp::solve::problem_file::run_text(square)?;
/// assert!((result.vertices[0][0] - 0.5).abs() < 1e-6);
/// # Ok::<(), pinwarp::solve::problem_file::ProblemError>(())
/// ```
///
/// # Errors
/// [`ProblemError`], which names the key.
pub fn run_text(problem: &str) -> Result<ResultFile, ProblemError> {
    let file = file::ProblemFile::parse(problem)?;
    match file.axes()? {
        3 => job::run::<3>(&file),
        _ => job::run::<2>(&file),
    }
}
