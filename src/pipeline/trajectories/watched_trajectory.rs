//! Cache of the trajectories of a shot's layers, each solved or read once, with the points of the model that couple its knots.

use crate::pipeline::PinAnchor;
use crate::solve::{Spread, Trajectory};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// The file that stores a trajectory, `None` if the run stores none, or why it could not be written.
pub(in crate::pipeline) type StoredIn = Result<Option<PathBuf>, Arc<str>>;

/// The trajectory of a layer.
#[derive(Debug)]
pub(in crate::pipeline) struct WatchedTrajectory<const D: usize> {
    pub(in crate::pipeline) trajectory: Trajectory<D>,
    pub(in crate::pipeline) points: Vec<PinAnchor>,
    /// The file that stores it.
    pub(in crate::pipeline) file: StoredIn,
    /// Whether it was read from that file.
    pub(in crate::pipeline) is_read: bool,
}

/// The outcome of solving a layer over time.
#[derive(Clone, Debug)]
pub(in crate::pipeline) enum Outcome<const D: usize> {
    /// The trajectory.
    Solved(Arc<WatchedTrajectory<D>>),
    /// The reason why there is none; each frame is then solved alone.
    Failed(Arc<str>),
}

/// Figures of a trajectory of a screen or world layer.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct Facts {
    /// Number of knots: times solved together with their neighbours.
    pub(in crate::pipeline) knots: usize,
    /// Frames over which a sudden jump is spread.
    pub(in crate::pipeline) spreads: Vec<Spread>,
    /// The file that stores it.
    pub(in crate::pipeline) file: StoredIn,
    /// Whether it was read from that file.
    pub(in crate::pipeline) is_read: bool,
}

impl<const D: usize> Outcome<D> {
    /// Returns the figures of the trajectory, or the reason why there is none.
    pub(in crate::pipeline) fn facts(&self) -> Result<Facts, Arc<str>> {
        match self {
            Self::Failed(why) => Err(Arc::clone(why)),
            Self::Solved(kept) => Ok(Facts {
                knots: kept.trajectory.knot_count(),
                spreads: kept.trajectory.spreads().to_vec(),
                file: kept.file.clone(),
                is_read: kept.is_read,
            }),
        }
    }
}

/// Outcomes by layer. A caller waits for an outcome that another thread is computing, but only for that layer.
#[derive(Debug)]
pub(in crate::pipeline) struct Trajectories<const D: usize>(Mutex<HashMap<usize, Arc<Mutex<Option<Outcome<D>>>>>>);

impl<const D: usize> Default for Trajectories<D> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<const D: usize> Trajectories<D> {
    /// Returns the outcome of a layer, which is computed on first use; errors are not cached.
    pub(in crate::pipeline) fn of<E>(
        &self,
        layer: usize,
        make: impl FnOnce() -> Result<Outcome<D>, E>,
    ) -> Result<Outcome<D>, E> {
        let own = Arc::clone(self.0.lock().unwrap_or_else(PoisonError::into_inner).entry(layer).or_default());
        let mut own = own.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*own {
            return Ok(known.clone());
        }
        let made = make()?;
        *own = Some(made.clone());
        Ok(made)
    }

    /// Whether the outcome of a layer has been computed.
    pub(in crate::pipeline) fn is_known(&self, layer: usize) -> bool {
        let own = self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&layer).map(Arc::clone);
        own.is_some_and(|own| own.try_lock().is_ok_and(|own| own.is_some()))
    }

    /// Removes the outcomes of layers for which `is_kept` is false.
    #[cfg(any(test, feature = "editor"))]
    pub(in crate::pipeline) fn retain(&self, is_kept: impl Fn(usize) -> bool) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|&layer, _| is_kept(layer));
    }
}
