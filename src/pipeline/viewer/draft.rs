//! Quick drafts of single frames for the editor, and the samples that they show.
//!
//! In: a prepared shot, a frame or a solved time. Out: a provisional [`TimeSample`]; a [`Frame`] with colour.

use super::still::Device;
use crate::image::Frame;
use crate::pipeline::draw::geometry_thread::geometry_keeping;
use crate::pipeline::evaluate::screen_layer;
use crate::pipeline::evaluate::timed_layer;
use crate::pipeline::evaluate::timed_world::Unsolved;
use crate::pipeline::pictures::paint_draft;
use crate::pipeline::trajectories::has_trajectory;
use crate::pipeline::{LayerState, PipelineError, PreparedShot, TimeSample};
use crate::raster::geometry::{IsCancelled, KeptParts};
use crate::raster::{ChannelGroup, Pass, PassRole, Target};
use crate::shot::{LayerSpace, Source};
use crate::space::FrameSize;
use glam::Vec2;

/// What a draft shows.
#[derive(Clone, Copy)]
pub(crate) struct Draft<'a> {
    /// The solved time.
    pub(crate) sample: &'a TimeSample,
    /// Parts that have been built for this time before.
    pub(crate) kept: &'a KeptParts,
    /// Size of the picture.
    pub(crate) size: FrameSize,
}

impl PreparedShot {
    /// Returns the solved sample shown by a frame, without waiting for trajectories. Layers whose trajectory is not
    /// solved yet are solved for this frame alone, so the sample is provisional.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(crate) fn provisional(&self, frame: i32) -> Result<TimeSample, PipelineError> {
        self.provisional_without(frame, &[])
    }

    /// As [`Self::provisional`], with some of the screen layers left unsolved.
    ///
    /// # Errors
    /// As [`Self::provisional`].
    pub(crate) fn provisional_without(&self, frame: i32, layers: &[usize]) -> Result<TimeSample, PipelineError> {
        let time = self.mid_exposure_time(f64::from(frame));
        let mut sample = self.world_solved_at(time, Unsolved::Alone)?;
        for index in (0..self.shot.layers.len()).filter(|index| !layers.contains(index)) {
            if matches!(self.shot.layers[index].space, LayerSpace::Screen { .. }) {
                sample.layers[index] = self.provisional_layer(&sample, index)?;
            }
        }
        Ok(sample)
    }

    /// Returns the state of a screen layer in a sample, without waiting for its trajectory; as it is for a layer of the scene.
    ///
    /// # Errors
    /// As [`Self::provisional`].
    pub(crate) fn provisional_layer(&self, sample: &TimeSample, index: usize) -> Result<LayerState, PipelineError> {
        match self.shot.layers[index].space {
            LayerSpace::Screen { bounds, .. } if self.is_solved_over_time(index) => {
                timed_layer::solve(self, sample, index, bounds)
            }
            LayerSpace::Screen { bounds, .. } => screen_layer::solve(self, sample, index, bounds),
            LayerSpace::World { .. } => Ok(sample.layers[index].clone()),
        }
    }

    /// Whether a provisional sample solves a layer from its keys for one frame alone.
    #[must_use]
    pub(crate) fn is_solved_alone(&self, index: usize) -> bool {
        self.layer_inputs.loaded[index].is_none() && !self.is_solved_over_time(index)
    }

    /// Whether the trajectories of all layers that have one are solved.
    #[must_use]
    pub(crate) fn is_settled(&self) -> bool {
        (0..self.shot.layers.len()).all(|index| !has_trajectory(self, index) || self.is_solved_over_time(index))
    }

    /// Whether the trajectory of a layer has been solved.
    fn is_solved_over_time(&self, index: usize) -> bool {
        match self.shot.layers[index].space {
            LayerSpace::Screen { .. } => self.cache.trajectories.is_known(index),
            LayerSpace::World { .. } => self.cache.world_trajectories.is_known(index),
        }
    }

    /// Returns the parts that stay the same while only these layers move; none if a layer of the scene is among them, which may
    /// displace the parts of all others.
    #[must_use]
    pub(crate) fn parts_at_rest(&self, moved: &[usize]) -> KeptParts {
        let mut is_kept = vec![true; self.assignment.layer_of_part.len()];
        for &layer in moved {
            match self.shot.layers[layer].space {
                LayerSpace::Screen { .. } => {
                    self.assignment.parts_of_layer[layer].iter().for_each(|&part| is_kept[part] = false);
                }
                LayerSpace::World { .. } => is_kept.fill(false),
            }
        }
        KeptParts::new(is_kept)
    }

    /// Draws a solved time with one sample per pixel; `None` if it was cancelled.
    ///
    /// # Errors
    /// [`PipelineError`] if drawing fails.
    pub(crate) fn draft(
        &self,
        device: Option<&mut Device>,
        Draft { sample, kept, size }: Draft,
        is_cancelled: &IsCancelled,
    ) -> Result<Option<Frame>, PipelineError> {
        let drawn = match (device, &self.shot.source) {
            (Some(device), Source::Scene(_)) => {
                let Some(geometry) = geometry_keeping(self, sample, kept, is_cancelled) else { return Ok(None) };
                let target = Target {
                    frame: size,
                    window: size.window(),
                    channels: vec![ChannelGroup::Beauty],
                    beauty_passes: 1,
                };
                device.start(&target)?;
                device.draw(&Pass { geometry: &geometry, jitter_px: Vec2::ZERO, role: PassRole::Beauty })?;
                device.finish()?
            }
            (_, Source::Frame) => self.warped_plate_draft(sample, size)?,
            _ => paint_draft(self, sample, size)?,
        };
        Ok(Some(drawn))
    }

    /// As [`Self::warped_plate`], smaller by as much as `size` is smaller than the shot, with the channels that are shown.
    fn warped_plate_draft(&self, sample: &TimeSample, size: FrameSize) -> Result<Frame, PipelineError> {
        let Some(path) = self.plate_path(sample)? else { return Ok(self.blank()) };
        let mut layers = self.layers_of_plate(sample);
        let draft = self.cache.plate_drafts.of(&path, (&layers, &self.shot.warp), [self.shot.size, size])?;
        layers.iter_mut().zip(&draft.mattes).for_each(|(layer, matte)| layer.matte.clone_from(matte));
        self.warped(&draft.plate, layers)
    }
}
