//! What frames of a shot leave for their neighbours: time samples, bounds, trajectories. All of it would be computed
//! again to the same bits.

use super::TimeSample;
use super::followed_box::BoundsCache;
use super::watched_trajectory::Trajectories;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Samples kept: a frame, its two neighbours, and the one before.
const KEPT_SAMPLES: usize = 4;

/// What is kept between frames.
#[derive(Debug, Default)]
pub(super) struct FrameCache {
    samples: Mutex<VecDeque<Arc<TimeSample>>>,
    /// Of layers on the screen.
    pub(super) screen_bounds: BoundsCache<2>,
    /// Of world layers.
    pub(super) world_bounds: BoundsCache<3>,
    /// Of layers on the screen whose frames are solved together.
    pub(super) trajectories: Trajectories<2>,
    /// Of such layers in the scene.
    pub(super) world_trajectories: Trajectories<3>,
    /// What all trajectories follow from.
    pub(super) trajectory_inputs: OnceLock<u128>,
}

impl FrameCache {
    /// The kept sample of a (fractional) frame.
    pub(super) fn sample(&self, frame: f64) -> Option<Arc<TimeSample>> {
        let samples = self.samples.lock().unwrap_or_else(PoisonError::into_inner);
        samples.iter().find(|sample| sample.frame == frame).map(Arc::clone)
    }

    /// Keeps a sample; the oldest goes where there are too many.
    pub(super) fn keep(&self, sample: &Arc<TimeSample>) {
        let mut samples = self.samples.lock().unwrap_or_else(PoisonError::into_inner);
        samples.push_back(Arc::clone(sample));
        if samples.len() > KEPT_SAMPLES {
            samples.pop_front();
        }
    }
}
