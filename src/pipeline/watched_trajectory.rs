//! Trajectories of a shot's layers, each solved or read once, and the points of the model that they watch.

use super::PinAnchor;
use crate::solve::{Spread, Trajectory};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// The trajectory of a layer.
#[derive(Debug)]
pub(super) struct WatchedTrajectory<const D: usize> {
    pub(super) trajectory: Trajectory<D>,
    pub(super) points: Vec<PinAnchor>,
    /// The file that keeps it.
    pub(super) file: Option<PathBuf>,
    /// It was read from there.
    pub(super) is_read: bool,
}

/// What became of the attempt to solve a layer over time.
#[derive(Clone, Debug)]
pub(super) enum Outcome<const D: usize> {
    /// Its trajectory.
    Solved(Arc<WatchedTrajectory<D>>),
    /// Why there is none: each frame is solved alone.
    Failed(Arc<str>),
}

/// What is known of a trajectory, wherever its layer lies.
#[derive(Clone, Debug)]
pub(super) struct Facts {
    /// Times at which it was solved together with its neighbours.
    pub(super) knots: usize,
    /// Where a snap is spread.
    pub(super) spreads: Vec<Spread>,
    /// The file that keeps it.
    pub(super) file: Option<PathBuf>,
    /// It was read from there.
    pub(super) is_read: bool,
}

impl<const D: usize> Outcome<D> {
    /// What is known of it, or why there is none.
    pub(super) fn facts(&self) -> Result<Facts, Arc<str>> {
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

/// Outcomes by layer. Who asks for one that is in the making waits for it; other layers do not wait.
#[derive(Debug)]
pub(super) struct Trajectories<const D: usize>(Mutex<HashMap<usize, Arc<Mutex<Option<Outcome<D>>>>>>);

impl<const D: usize> Default for Trajectories<D> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<const D: usize> Trajectories<D> {
    /// The outcome of a layer, made the first time; errors are not kept.
    pub(super) fn of<E>(&self, layer: usize, make: impl FnOnce() -> Result<Outcome<D>, E>) -> Result<Outcome<D>, E> {
        let own = Arc::clone(self.0.lock().unwrap_or_else(PoisonError::into_inner).entry(layer).or_default());
        let mut own = own.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*own {
            return Ok(known.clone());
        }
        let made = make()?;
        *own = Some(made.clone());
        Ok(made)
    }

    /// The outcome of a layer is there.
    pub(super) fn is_known(&self, layer: usize) -> bool {
        let own = self.0.lock().unwrap_or_else(PoisonError::into_inner).get(&layer).map(Arc::clone);
        own.is_some_and(|own| own.try_lock().is_ok_and(|own| own.is_some()))
    }

    /// Lets go of those of other layers.
    pub(super) fn retain(&self, is_kept: impl Fn(usize) -> bool) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|&layer, _| is_kept(layer));
    }
}
