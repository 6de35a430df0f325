//! Input of a trajectory: the problem of a layer as a function of time, and the coupling of different times.
//!
//! In: a [`Timeline`], implemented by the pipeline and by tests. Out: [`TimedProblem`]s.

use crate::lattice::Grid;
use crate::solve::error::SolveError;
use crate::solve::problem::{ModelPoint, Shape};
use crate::solve::settings::Settings;
use crate::solve::targets::Targets;

/// The problem of one time. Grid, shape, pins and targets may all change with time.
#[derive(Clone, Debug)]
pub(crate) struct TimedProblem<const D: usize> {
    /// The rest grid.
    pub grid: Grid<D>,
    /// The shape to preserve.
    pub shape: Shape<D>,
    /// Targets of pins and handles along the path that they have taken; the last are those of this time. See
    /// [`crate::solve::Solver::follow`].
    pub path: Vec<Targets<D>>,
    /// Points of the model, the same at all times, #points.
    pub points: Vec<ModelPoint<D>>,
    /// The drawing that is visible, if targets are held over several frames and then jump ("on twos"), else 0. A trajectory is
    /// continuous within a drawing.
    pub drawing: i64,
    /// Number of cuts of the camera up to this time. Knots on different sides of a cut are not coupled, because their
    /// displacements are seen in different views; the first knot after a cut is solved along the whole path of its targets.
    pub take: i64,
}

/// The problem of a layer as a function of time.
pub(crate) trait Timeline<const D: usize> {
    /// Error of the implementation.
    type Error: From<SolveError>;

    /// Settings, the same at all times.
    fn settings(&self) -> &Settings;

    /// The problem at a time; `None` if nothing is solved then.
    ///
    /// # Errors
    /// Errors of the implementation.
    fn at(&self, time: f64) -> Result<Option<TimedProblem<D>>, Self::Error>;

    /// Number of knots in memory at once, at least 16. Later knots influence earlier ones by at most half a window. The number
    /// must depend on the problem alone, because the result depends on it.
    fn window(&self) -> usize {
        usize::MAX
    }

    /// Whether the problems of knots are built in parallel; false if that would need too much memory.
    fn is_light(&self) -> bool {
        true
    }

    /// Called while a [`Trajectory`](super::Trajectory) is solved, with the number of parts done and of all parts. Does not
    /// influence the result.
    fn progress(&self, _done: usize, _of: usize) {}
}

/// How the times of a trajectory are coupled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coupling {
    /// Time of the first knot, in frames.
    pub first: f64,
    /// Upper bound for the time of the last knot, in frames.
    pub last: f64,
    /// Number of knots per frame, at least 1.
    pub knots_per_frame: u32,
    /// Weight of the mean squared speed (in box diagonals per frame) relative to the energy of the shape, in frames.
    pub weight: f64,
    /// Speed that is always permitted, in units of the space per frame.
    pub least_speed: f64,
}

/// Bytes of matrices and factors per entry of the band of a knot's normal matrix, in the plane and in space. In the plane they
/// include a factor for Newton's method.
const BAND_BYTES: [usize; 2] = [64, 32];

/// Bytes of a knot other than matrices: samples of the shape, points.
const KNOT_BYTES: usize = 1 << 20;

/// Bytes available for the knots of a window.
const WINDOW_BYTES: usize = 1 << 30;

/// Bytes of a branching knot per triangle of its shape: the triangle, its parts in cells, and their copies of handles.
const TRIANGLE_BYTES: usize = 1024;

/// Number of knots with such a grid that fit into a GiB. `branching` is the number of triangles in the shape of a branching
/// lattice. Such a lattice has several copies of a handle where parts are close, and none away from the shape, so as a rule its
/// copies are not more than the handles of a plain lattice.
#[must_use]
pub(crate) fn knots_per_gib<const D: usize>(grid: &Grid<D>, branching: Option<usize>) -> usize {
    let handles = grid.handle_count();
    let apart = grid.basis.min_handles() - 1;
    let bandwidth = if grid.basis.is_local() { (0..D).map(|axis| apart * grid.stride(axis)).sum() } else { handles };
    let entries = handles * (1 + bandwidth.min(handles));
    let shape = branching.unwrap_or(0) * TRIANGLE_BYTES;
    WINDOW_BYTES / (KNOT_BYTES + shape + entries * BAND_BYTES[usize::from(D > 2)])
}

impl Coupling {
    /// Number of knots.
    #[must_use]
    pub(crate) fn knot_count(&self) -> usize {
        let frames = (self.last - self.first).max(0.0);
        (frames * f64::from(self.knots_per_frame) + 1e-9).floor() as usize + 1
    }

    /// Time of a knot, in frames.
    #[must_use]
    pub(crate) fn knot_time(&self, knot: usize) -> f64 {
        self.first + knot as f64 / f64::from(self.knots_per_frame)
    }
}
