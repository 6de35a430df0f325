//! Evaluates a prepared shot at a time: pose, world layers, projection, screen layers.
//!
//! In: a [`PreparedShot`] and a (fractional) frame. Out: a [`TimeSample`]. World layers come first, because they deform
//! the meshes that are projected.

pub(super) mod camera_cuts;
mod crossing_times;
pub(super) mod followed_box;
pub(super) mod frame_cache;
mod frame_crossings;
pub(super) mod lattice_box;
pub(super) mod layer_pins;
pub(super) mod layer_solve;
pub(super) mod moved_meshes;
pub(super) mod ordered_parts;
mod part_levels;
pub(super) mod part_order;
pub(super) mod part_triangle_ranges;
mod pin_places;
pub(super) mod screen_layer;
pub(super) mod screen_shape;
pub(super) mod time_sample;
pub(super) mod timed_layer;
pub(super) mod timed_world;
pub(super) mod topology;
pub(super) mod whole_layer;
pub(super) mod world_layer;

use crate::pipeline::draw::passes::mid_shutter;
use crate::pipeline::{PipelineError, PreparedShot, TimeSample};
use crate::shot::LayerSpace;
use std::sync::Arc;

impl PreparedShot {
    /// Returns the solved scene at the middle of a frame's exposure, which the frame's data channels show.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(crate) fn mid_exposure(&self, frame: i32) -> Result<Arc<TimeSample>, PipelineError> {
        self.sample_at(self.mid_exposure_time(f64::from(frame)))
    }

    /// Returns the solved scene at a (fractional) frame. The latest samples that neighbouring frames also need are cached.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub fn sample_at(&self, frame: f64) -> Result<Arc<TimeSample>, PipelineError> {
        if let Some(sample) = self.cache.sample(frame) {
            return Ok(sample);
        }
        let sample = Arc::new(self.evaluate(frame)?);
        // Neighbouring frames only need the middle of an exposure again, no other time in it.
        let exposed = frame - mid_shutter(self.shot.shutter);
        if (exposed - exposed.round()).abs() <= 1e-9 {
            self.cache.keep(&sample);
        }
        Ok(sample)
    }

    /// Poses, projects and solves a (fractional) frame.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(in crate::pipeline) fn evaluate(&self, frame: f64) -> Result<TimeSample, PipelineError> {
        let mut sample = self.unsolved_at(frame)?;
        for (index, layer) in self.shot.layers.iter().enumerate() {
            if let LayerSpace::Screen { bounds, .. } = layer.space {
                sample.layers[index] = timed_layer::solve(self, &sample, index, bounds)?;
            }
        }
        sample.mesh = None;
        Ok(sample)
    }
}
