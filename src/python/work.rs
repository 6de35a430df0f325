//! Runs work on a separate thread, without the GIL.
//!
//! In: a closure, and the caller's `progress` callback. Out: its result. Callbacks run on the calling thread only: at
//! every step that the work reports, and between steps about twenty times per second. `False` from a callback, an
//! exception in it, and Ctrl-C request cancellation; unfinished results are then discarded.

use super::failure::Failure;
use pyo3::prelude::*;
use pyo3::types::PyBool;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Interval at which the calling thread checks for Ctrl-C.
const NAP: Duration = Duration::from_millis(50);

/// The channel between the work and the calling thread: progress one way, cancellation the other.
#[derive(Default)]
pub(super) struct Watch {
    is_stopped: AtomicBool,
    news: Mutex<News>,
    told: Condvar,
}

/// Progress not yet passed on.
#[derive(Default)]
struct News {
    /// Completed and total steps.
    steps: VecDeque<[usize; 2]>,
    is_over: bool,
}

impl Watch {
    /// Returns whether the work should stop; long loops poll this.
    pub(super) fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Returns the flag that [`Self::is_stopped`] reads.
    pub(super) const fn stop_flag(&self) -> &AtomicBool {
        &self.is_stopped
    }

    /// Reports the completed and total steps.
    pub(super) fn tell(&self, done: usize, of: usize) {
        self.news.lock().unwrap_or_else(PoisonError::into_inner).steps.push_back([done, of]);
        self.told.notify_one();
    }

    /// Returns [`Failure::Cancelled`] if the work should stop.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.is_stopped() { Err(Failure::Cancelled) } else { Ok(()) }
    }

    fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Returns the progress since the last call, waiting up to [`NAP`] for some; and whether the work is over.
    fn next(&self) -> (VecDeque<[usize; 2]>, bool) {
        let news = self.news.lock().unwrap_or_else(PoisonError::into_inner);
        let is_quiet = |news: &mut News| news.steps.is_empty() && !news.is_over;
        let (mut news, _) = self.told.wait_timeout_while(news, NAP, is_quiet).unwrap_or_else(PoisonError::into_inner);
        (std::mem::take(&mut news.steps), news.is_over)
    }
}

/// Marks the work as over when dropped, also on a panic.
struct Ending<'a>(&'a Watch);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.news.lock().unwrap_or_else(PoisonError::into_inner).is_over = true;
        self.0.told.notify_one();
    }
}

/// Runs the work. A result completed before the cancellation is noticed is still returned.
pub(super) fn away<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    let watch = Watch::default();
    std::thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _ending = Ending(&watch);
            work(&watch)
        });
        let followed = follow(py, progress, &watch);
        if followed.is_err() {
            watch.stop();
        }
        let ended = py.detach(|| worker.join());
        followed?;
        // A panic is propagated: Python sees a PanicException.
        let outcome = ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match outcome {
            Err(_) if watch.is_stopped() => Err(Failure::Cancelled.into()),
            outcome => Ok(outcome?),
        }
    })
}

/// Passes progress on until the work is over.
fn follow(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    let mut last = [0, 0];
    loop {
        let (mut steps, is_over) = py.detach(|| watch.next());
        py.check_signals()?;
        if steps.is_empty() && !is_over && last[1] > 0 {
            // The callback also runs during long steps, to allow cancellation.
            steps.push_back(last);
        }
        for step in steps {
            last = step;
            let Some(progress) = progress else { continue };
            let answer = progress.call1((step[0], step[1]))?;
            if answer.cast::<PyBool>().is_ok_and(|answer| !answer.is_true()) {
                watch.stop();
            }
        }
        if is_over {
            return Ok(());
        }
    }
}
