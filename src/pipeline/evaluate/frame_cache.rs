//! Cache of values that the frames of a shot share: time samples, bounds, trajectories. Recomputing any of them yields
//! the same bits.

use super::followed_box::BoundsCache;
use super::frame_crossings::CrossingCache;
use crate::pipeline::TimeSample;
#[cfg(any(test, feature = "editor"))]
use crate::pipeline::pictures::plate_drafts::PlateDrafts;
use crate::pipeline::prepare::brush_strokes::StrokeCache;
use crate::pipeline::prepare::known_far_points::KnownFarPoints;
use crate::pipeline::prepare::slenderness::Slenderness;
#[cfg(any(test, feature = "editor"))]
use crate::pipeline::prepare::symmetry::LayerMirror;
use crate::pipeline::trajectories::watched_trajectory::Trajectories;
use crate::pose::Pose;
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Number of cached samples: a frame, its two neighbours, and the one before.
const KEPT_SAMPLES: usize = 4;

/// The values shared between frames.
#[derive(Debug, Default)]
pub(in crate::pipeline) struct FrameCache {
    samples: Mutex<VecDeque<Arc<TimeSample>>>,
    /// Bounds of screen layers.
    pub(in crate::pipeline) screen_bounds: BoundsCache<2>,
    /// How much the camera changes the picture from a frame to the next.
    pub(in crate::pipeline) picture_changes: Mutex<HashMap<i32, f64>>,
    /// Crossings of limbs in whole frames.
    pub(in crate::pipeline) crossings: CrossingCache,
    /// Frames of the solve range that a cut of the camera follows, ascending.
    pub(in crate::pipeline) cuts: OnceLock<Vec<i32>>,
    /// The scene at rest, for what asks for it many times.
    pub(in crate::pipeline) rest: OnceLock<Pose>,
    /// How thin the thinnest parts of layers with automatic dims are.
    pub(in crate::pipeline) slenderness: Mutex<HashMap<usize, Slenderness>>,
    /// What lies far apart along the pictures of layers with automatic dims, but shares handles.
    pub(in crate::pipeline) far_points: Mutex<HashMap<usize, KnownFarPoints>>,
    /// What brush strokes cover.
    pub(in crate::pipeline) strokes: StrokeCache,
    /// Where the brush is mirrored on layers; `None`: nowhere.
    #[cfg(any(test, feature = "editor"))]
    pub(in crate::pipeline) mirrors: Mutex<HashMap<usize, Option<LayerMirror>>>,
    /// Plates for drafts.
    #[cfg(any(test, feature = "editor"))]
    pub(in crate::pipeline) plate_drafts: PlateDrafts,
    /// Bounds of world layers.
    pub(in crate::pipeline) world_bounds: BoundsCache<3>,
    /// Trajectories of screen layers.
    pub(in crate::pipeline) trajectories: Trajectories<2>,
    /// Trajectories of world layers.
    pub(in crate::pipeline) world_trajectories: Trajectories<3>,
    /// Digest of the inputs that all trajectories have in common.
    pub(in crate::pipeline) trajectory_inputs: OnceLock<u128>,
}

impl FrameCache {
    /// Returns the cached sample of a (fractional) frame.
    pub(in crate::pipeline) fn sample(&self, frame: f64) -> Option<Arc<TimeSample>> {
        let samples = self.samples.lock().unwrap_or_else(PoisonError::into_inner);
        samples.iter().find(|sample| sample.frame == frame).map(Arc::clone)
    }

    /// Caches a sample and evicts the oldest one if there are too many.
    pub(in crate::pipeline) fn keep(&self, sample: &Arc<TimeSample>) {
        let mut samples = self.samples.lock().unwrap_or_else(PoisonError::into_inner);
        samples.push_back(Arc::clone(sample));
        if samples.len() > KEPT_SAMPLES {
            samples.pop_front();
        }
    }
}
