//! Single frames in memory for viewers: quick drafts, and frames with the pixels of a render.
//!
//! In: a prepared shot, a solved time. Out: a [`Frame`] with colour.

use crate::image::{Frame, Plate, SequencePath, read_any};
use crate::pipeline::draw::draw_frame;
use crate::pipeline::draw::geometry_thread::geometry_keeping;
use crate::pipeline::draw::passes::mid_shutter;
use crate::pipeline::evaluate::screen_layer;
use crate::pipeline::evaluate::timed_layer;
use crate::pipeline::evaluate::timed_world::Unsolved;
use crate::pipeline::pictures::{paint_draft, paint_frame};
use crate::pipeline::trajectories::layer_timeline::Watcher;
use crate::pipeline::trajectories::{facts, has_trajectory};
use crate::pipeline::{LayerState, PipelineError, PreparedShot, TimeSample};
use crate::plate::{LayerJob, PlateJob, warp_plate};
use crate::raster::geometry::IsCancelled;
use crate::raster::geometry::KeptParts;
use crate::raster::{ChannelGroup, DeviceClass, Pass, PassRole, Raster, RasterError, Target};
use crate::shot::{LayerSpace, Source};
use crate::solve::SolveError;
use crate::space::FrameSize;
use glam::Vec2;
use std::path::PathBuf;

/// A device that draws frames and can be sent between threads.
pub(crate) type Device = dyn Raster + Send + 'static;

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
    #[cfg(feature = "editor")]
    pub(crate) fn is_solved_alone(&self, index: usize) -> bool {
        self.layer_inputs.loaded[index].is_none() && !self.is_solved_over_time(index)
    }

    /// Whether the trajectories of all layers that have one are solved.
    #[must_use]
    pub(crate) fn is_settled(&self) -> bool {
        (0..self.shot.layers.len()).all(|index| !has_trajectory(self, index) || self.is_solved_over_time(index))
    }

    /// Solves the trajectories of all layers that have one. Returns false if it was stopped.
    ///
    /// # Errors
    /// [`PipelineError`] if a layer cannot be solved.
    pub(crate) fn solve_trajectories(
        &self,
        is_cancelled: &IsCancelled,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<bool, PipelineError> {
        let layers: Vec<usize> = (0..self.shot.layers.len()).filter(|&index| has_trajectory(self, index)).collect();
        for (place, &index) in layers.iter().enumerate() {
            let part = |done: usize, of: usize| done as f64 / of.max(1) as f64;
            let on_step = |done: usize, of: usize| progress((place as f64 + part(done, of)) / layers.len() as f64);
            match facts(self, index, Watcher { is_cancelled: &|| is_cancelled(), progress: &on_step }) {
                Ok(_) => {}
                Err(PipelineError::Solve { source: SolveError::Cancelled, .. }) => return Ok(false),
                Err(error) => return Err(error),
            }
        }
        Ok(!is_cancelled())
    }

    /// Whether the trajectory of a layer has been solved.
    fn is_solved_over_time(&self, index: usize) -> bool {
        match self.shot.layers[index].space {
            LayerSpace::Screen { .. } => self.cache.trajectories.is_known(index),
            LayerSpace::World { .. } => self.cache.world_trajectories.is_known(index),
        }
    }

    /// Whether a device draws the shot; pictures and plates are warped instead.
    #[must_use]
    pub(crate) fn needs_raster(&self) -> bool {
        matches!(self.shot.source, Source::Scene(_))
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

    /// Returns a frame with the pixels of a render; `None` if it was stopped.
    ///
    /// # Errors
    /// [`PipelineError`] if the frame cannot be solved or drawn.
    pub(crate) fn finished(
        &self,
        device: Option<&mut Device>,
        frame: i32,
        is_cancelled: &IsCancelled,
    ) -> Result<Option<Frame>, PipelineError> {
        let drawn = match (device, &self.shot.source) {
            (Some(device), Source::Scene(_)) => {
                draw_frame(&mut Stoppable { device, is_cancelled, is_stopped: false }, self, frame)
            }
            (_, Source::Frame) => self.mid_exposure(frame).and_then(|sample| self.warped_plate(&sample)),
            _ => self.mid_exposure(frame).and_then(|middle| {
                let times = crate::pipeline::pictures::times(self, frame);
                let sample_at = |time| if is_cancelled() { Err(stopped(frame)) } else { self.sample_at(time) };
                paint_frame(self, &middle, &times, &sample_at)
            }),
        };
        match drawn {
            Ok(frame) => Ok(Some(frame)),
            Err(_) if is_cancelled() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Returns the plate of a sample's frame, warped by its layers.
    fn warped_plate(&self, sample: &TimeSample) -> Result<Frame, PipelineError> {
        let Some(path) = self.plate_path(sample)? else { return Ok(self.blank()) };
        self.warped(&read_any(&path)?, self.layers_of_plate(sample))
    }

    /// As [`Self::warped_plate`], smaller by as much as `size` is smaller than the shot, with the channels that are shown.
    fn warped_plate_draft(&self, sample: &TimeSample, size: FrameSize) -> Result<Frame, PipelineError> {
        let Some(path) = self.plate_path(sample)? else { return Ok(self.blank()) };
        let mut layers = self.layers_of_plate(sample);
        let draft = self.cache.plate_drafts.of(&path, (&layers, &self.shot.warp), [self.shot.size, size])?;
        layers.iter_mut().zip(&draft.mattes).for_each(|(layer, matte)| layer.matte.clone_from(matte));
        self.warped(&draft.plate, layers)
    }

    /// Returns the file of the plate of a sample's frame; `None` if the shot has no plate.
    fn plate_path(&self, sample: &TimeSample) -> Result<Option<PathBuf>, PipelineError> {
        let Some(pattern) = &self.shot.plate else { return Ok(None) };
        let frame = (sample.frame - mid_shutter(self.shot.shutter)).round() as i32;
        Ok(Some(SequencePath::of_input(pattern)?.path_of(frame)))
    }

    /// Returns the layers of a sample that move the plate.
    fn layers_of_plate(&self, sample: &TimeSample) -> Vec<LayerJob> {
        let moved = self.shot.layers.iter().zip(&sample.layers).filter_map(|(layer, state)| {
            let field = state.field(layer.matte.is_none())?;
            Some(LayerJob {
                name: layer.name.clone(),
                field,
                previous: None,
                next: None,
                matte: layer.matte.clone(),
                front: None,
            })
        });
        moved.collect()
    }

    /// Returns a plate, warped by layers.
    fn warped(&self, plate: &Plate, layers: Vec<LayerJob>) -> Result<Frame, PipelineError> {
        let settings = self.shot.warp.in_pixels(plate.frame_size());
        let job = PlateJob { layers, settings: &settings, fill: None };
        Ok(warp_plate(plate, &job).map(|(plate, _): (Plate, _)| plate.into_frame())?)
    }

    /// Returns an empty frame.
    fn blank(&self) -> Frame {
        let display = self.shot.size.window();
        Frame { pixel_aspect: self.shot.size.pixel_aspect, ..Frame::blank(display, display, &[]) }
    }
}

fn stopped(frame: i32) -> PipelineError {
    PipelineError::Interrupted { frame }
}

/// A device that can be stopped between two passes.
struct Stoppable<'a> {
    device: &'a mut Device,
    is_cancelled: &'a IsCancelled<'a>,
    is_stopped: bool,
}

impl Raster for Stoppable<'_> {
    fn name(&self) -> String {
        self.device.name()
    }

    fn class(&self) -> DeviceClass {
        self.device.class()
    }

    fn max_side(&self) -> u32 {
        self.device.max_side()
    }

    fn start(&mut self, target: &Target) -> Result<(), RasterError> {
        self.device.start(target)
    }

    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError> {
        self.is_stopped = self.is_stopped || (self.is_cancelled)();
        if self.is_stopped {
            return Err(RasterError::Misuse("the frame is no longer wanted"));
        }
        self.device.draw(pass)
    }

    fn finish(&mut self) -> Result<Frame, RasterError> {
        self.device.finish()
    }
}
