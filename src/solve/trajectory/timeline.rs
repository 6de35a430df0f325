//! What a trajectory is solved for: the problem of a layer at any time, and how its times hang together.
//!
//! In: implemented by the pipeline and by tests. Out: [`TimedProblem`]s.

use crate::lattice::Grid;
use crate::solve::error::SolveError;
use crate::solve::problem::{ModelPoint, Shape};
use crate::solve::settings::Settings;
use crate::solve::targets::Targets;

/// The problem of one time. Grid, shape, pins and targets all may move.
#[derive(Clone, Debug)]
pub struct TimedProblem<const D: usize> {
    /// The rest grid.
    pub grid: Grid<D>,
    /// The shape to preserve.
    pub shape: Shape<D>,
    /// How pins and handles came to their targets, which are the last; see [`crate::solve::Solver::follow`].
    pub path: Vec<Targets<D>>,
    /// Points of the model, the same ones at every time, #points.
    pub points: Vec<ModelPoint<D>>,
    /// Which drawing is shown, where targets are held over several times and then jump ("on twos"); else 0. A trajectory is continuous
    /// within a drawing.
    pub drawing: i64,
}

/// The problem of a layer as a function of time.
pub trait Timeline<const D: usize> {
    /// What goes wrong.
    type Error: From<SolveError>;

    /// The settings of all times.
    fn settings(&self) -> &Settings;

    /// The problem at a time; `None` where nothing is solved.
    ///
    /// # Errors
    /// Those of the implementation.
    fn at(&self, time: f64) -> Result<Option<TimedProblem<D>>, Self::Error>;

    /// How many knots are held in memory at once, 16 or more: later ones cannot pull at those half a window before them. A function of the
    /// problem alone, because the result depends on it.
    fn window(&self) -> usize {
        usize::MAX
    }

    /// Knots are made on all cores at once; false where that would take too much memory.
    fn is_light(&self) -> bool {
        true
    }

    /// Hears how far a [`Trajectory`](super::Trajectory) has been solved: parts done, of all. Of no consequence for the result.
    fn progress(&self, _done: usize, _of: usize) {}
}

/// How the times of a trajectory hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Time of the first knot, frames.
    pub first: f64,
    /// Time of the last knot, at most; frames.
    pub last: f64,
    /// Knots a frame, 1 or more.
    pub knots_per_frame: u32,
    /// Weight of the mean squared speed, in box diagonals a frame, against the shape's energy; frames.
    pub weight: f64,
    /// A speed, in units of the space a frame, that needs no reason.
    pub least_speed: f64,
}

/// Bytes of a knot's matrices and factors for each entry of the band of its normal matrix; in the plane Newton's method has a factor, too.
const BAND_BYTES: [usize; 2] = [64, 32];

/// Bytes of a knot beside its matrices: samples of the shape and points.
const KNOT_BYTES: usize = 1 << 20;

/// Bytes of the knots of a window.
const WINDOW_BYTES: usize = 1 << 30;

/// Bytes of a branching knot for each triangle of its shape: the triangle, its parts in cells, the copies over them.
const TRIANGLE_BYTES: usize = 1024;

/// How many knots with such a grid take a GiB; `branching`: the number of triangles in the shape of a branching lattice. It has copies of
/// handles where parts are close, and none where nothing of the shape is: as a rule not more than a plain one has handles.
#[must_use]
pub fn knots_per_gib<const D: usize>(grid: &Grid<D>, branching: Option<usize>) -> usize {
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
    pub fn knot_count(&self) -> usize {
        let frames = (self.last - self.first).max(0.0);
        (frames * f64::from(self.knots_per_frame) + 1e-9).floor() as usize + 1
    }

    /// The time of a knot.
    #[must_use]
    pub fn knot_time(&self, knot: usize) -> f64 {
        self.first + knot as f64 / f64::from(self.knots_per_frame)
    }
}
