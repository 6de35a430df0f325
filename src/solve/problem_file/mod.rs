//! Problem files: the bare solver on a mesh, as JSON, for researchers and tests.
//!
//! In: a JSON file (vertices, triangles, dims, pins, ...). Out: P', V', energies per iteration, distortion measures.
//! Keys left out take the defaults of the program; `lambdas` switch to the paper's plain sums, see [`run_file`].

mod error;
mod figure;
mod file;
mod job;
mod measures;

pub use error::ProblemError;
pub use figure::{Figure, FigurePart, FigurePose, Figures, read_figure};
pub use measures::Measures;

use super::minimization::Energies;
use serde::Serialize;
use std::path::Path;

/// The result of a problem file. Points have two or three coordinates, as `dims` has entries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultFile {
    /// Moved handles, #handles, x fastest.
    #[serde(rename = "P")]
    pub handles: Vec<Vec<f64>>,
    /// Moved vertices, #vertices.
    #[serde(rename = "V")]
    pub vertices: Vec<Vec<f64>>,
    /// Terms after each accepted step: local-global ones under the rotations they were solved with, Newton's under
    /// the best ones. The last entry belongs to `P`.
    pub energies: Vec<Energies>,
    /// Distortion of the triangles, rest to `V`.
    pub measures: Measures,
    /// Iterations run.
    pub iterations: usize,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Solves the problem in a file.
///
/// With `lambdas`: plain sums, one sample per triangle, started at rest, no clamping; with `iterations`: exactly so many,
/// not accelerated. Without them: the defaults, to convergence.
///
/// # Errors
/// [`ProblemError`], naming the file and the key.
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
/// [`ProblemError`], naming the key.
pub fn run_text(problem: &str) -> Result<ResultFile, ProblemError> {
    let file = file::ProblemFile::parse(problem)?;
    match file.axes()? {
        3 => job::run::<3>(&file),
        _ => job::run::<2>(&file),
    }
}
