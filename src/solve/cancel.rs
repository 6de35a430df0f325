//! Cancellation of solves: a hook of the caller that all long loops poll.
//!
//! In: a hook that returns true to cancel. Out: whether to stop. Once the hook has returned true it is not called again.

use std::cell::Cell;
use std::fmt;

/// Multiplications between two polls, which take a few milliseconds.
const WORK_PER_POLL: usize = 1 << 22;

/// Cancels a solve early. Long loops poll the hook every few milliseconds, on the calling thread.
///
/// ```
/// use pinwarp::lattice::{Basis, Grid};
/// use pinwarp::solve::{Cancel, PointPin, Problem, Settings, Shape, SolveError, Solver};
/// let grid = Grid { dims: [6, 6], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 };
/// let shape = Shape::of_triangles(vec![[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]], vec![[0, 1, 2]]);
/// let (pins, settings) = ([PointPin::new([0.5, 0.9], [0.6, 0.9])], Settings::default());
/// let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &[], settings: &settings };
/// let solver = Solver::new(&problem)?;
/// let cancel = Cancel::when(&|| true);
/// assert!(matches!(solver.with_cancel(&cancel).solve(), Err(SolveError::Cancelled)));
/// # Ok::<(), SolveError>(())
/// ```
pub struct Cancel<'a> {
    hook: Option<&'a dyn Fn() -> bool>,
    is_requested: Cell<bool>,
}

impl<'a> Cancel<'a> {
    /// A `Cancel` that never stops the solve.
    #[must_use]
    pub(crate) const fn never() -> Self {
        Self { hook: None, is_requested: Cell::new(false) }
    }

    /// A `Cancel` that stops the solve as soon as `hook` returns true.
    #[must_use]
    pub const fn when(hook: &'a dyn Fn() -> bool) -> Self {
        Self { hook: Some(hook), is_requested: Cell::new(false) }
    }

    /// Polls the hook; true once the solve is to stop.
    #[must_use]
    pub(crate) fn is_requested(&self) -> bool {
        if let (false, Some(hook)) = (self.is_requested.get(), self.hook) {
            self.is_requested.set(hook());
        }
        self.is_requested.get()
    }

    /// Polls the hook; [`Cancelled`] if the solve is to stop.
    pub(crate) fn check(&self) -> Result<(), Cancelled> {
        if self.is_requested() { Err(Cancelled) } else { Ok(()) }
    }

    /// Returns a counter of work, which polls the hook every few million multiplications.
    pub(crate) fn meter(&self) -> WorkMeter<'_> {
        WorkMeter { cancel: self, work: 0 }
    }
}

impl fmt::Debug for Cancel<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("Cancel").field("is_requested", &self.is_requested.get()).finish_non_exhaustive()
    }
}

/// Error of a cancelled computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cancelled;

/// Counter of multiplications since the last poll.
pub(crate) struct WorkMeter<'a> {
    cancel: &'a Cancel<'a>,
    work: usize,
}

impl WorkMeter<'_> {
    /// Adds to the count. Returns true if the loop must stop, whose result must then be discarded.
    #[must_use]
    pub(crate) fn count_and_poll(&mut self, multiplications: usize) -> bool {
        self.work += multiplications;
        if self.work < WORK_PER_POLL {
            return false;
        }
        self.work = 0;
        self.cancel.is_requested()
    }

    /// Whether the solve has been cancelled, without polling the hook.
    pub(crate) fn is_stopped(&self) -> bool {
        self.cancel.is_requested.get()
    }
}
