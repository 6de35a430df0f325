//! Solves a problem without moved handles.

use pinwarp::lattice::Grid;
use pinwarp::solve::{PointPin, Problem, Settings, Shape, Solution, solve};

pub(crate) fn run<const D: usize>(
    grid: &Grid<D>,
    shape: &Shape<D>,
    pins: &[PointPin<D>],
    settings: &Settings,
) -> Solution<D> {
    solve(&Problem { grid, shape, pins, handles: &[], settings }).expect("a valid problem")
}
