//! Lets a render wait while something else needs the processor.
//!
//! In: a function that waits. Out: calls of it between the steps of a render, never from a thread that others may need.

use std::fmt::{Debug, Formatter, Result};
use std::sync::Arc;

/// Where a render waits while something else needs the processor; by default nowhere.
#[derive(Clone, Default)]
pub struct Pause(Option<Arc<dyn Fn() + Send + Sync>>);

impl Pause {
    /// Calls a function before each step of a render, which goes on when it returns.
    #[cfg(feature = "editor")]
    pub(crate) fn new(wait: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(wait)))
    }

    /// Waits as long as there is a reason.
    pub(in crate::pipeline) fn wait(&self) {
        if let Some(wait) = &self.0 {
            wait();
        }
    }
}

impl Debug for Pause {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        out.write_str(if self.0.is_some() { "Pause(set)" } else { "Pause(none)" })
    }
}
