//! Gives the view precedence over renders in the background.
//!
//! In: whether the view needs the processor now. Out: renders that wait meanwhile.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest that a render waits after the view was last said to need the processor, in case nobody says that it no longer does.
const LONGEST: Duration = Duration::from_secs(2);

/// Time between two looks of a render that waits.
const STEP: Duration = Duration::from_millis(5);

/// Holds a render back. Clones hold the same one.
#[derive(Clone, Debug, Default)]
pub(in crate::edit) struct RenderHold(Arc<Mutex<Option<Instant>>>);

impl RenderHold {
    /// Holds the render back for a while, or lets it go on.
    pub(in crate::edit) fn set(&self, is_held: bool) {
        let until = is_held.then(|| Instant::now() + LONGEST);
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = until;
    }

    /// Returns whether the render is held back.
    pub(in crate::edit) fn is_on(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some_and(|until| Instant::now() < until)
    }

    /// Waits while the render is held back, unless it is over.
    pub(in crate::edit) fn wait(&self, is_over: impl Fn() -> bool) {
        while self.is_on() && !is_over() {
            std::thread::sleep(STEP);
        }
    }
}
