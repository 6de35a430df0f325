//! Single frames in memory for viewers, with the pixels of a render.
//!
//! In: a prepared shot, a frame. Out: a [`Frame`] with colour.

use crate::image::{Frame, Plate, SequencePath, read_any};
use crate::pipeline::draw::draw_frame;
use crate::pipeline::draw::passes::mid_shutter;
use crate::pipeline::pictures::paint_frame;
use crate::pipeline::trajectories::layer_timeline::Watcher;
use crate::pipeline::trajectories::{facts, has_trajectory};
use crate::pipeline::{PipelineError, PreparedShot, TimeSample};
use crate::plate::{LayerJob, PlateJob, warp_plate};
use crate::raster::geometry::IsCancelled;
use crate::raster::{DeviceClass, Pass, Raster, RasterError, Target};
use crate::shot::Source;
use crate::solve::SolveError;
use std::path::PathBuf;

/// A device that draws frames and can be sent between threads.
pub(crate) type Device = dyn Raster + Send + 'static;

impl PreparedShot {
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

    /// Whether a device draws the shot; pictures and plates are warped instead.
    #[must_use]
    pub(crate) fn needs_raster(&self) -> bool {
        matches!(self.shot.source, Source::Scene(_))
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

    /// Returns the file of the plate of a sample's frame; `None` if the shot has no plate.
    pub(super) fn plate_path(&self, sample: &TimeSample) -> Result<Option<PathBuf>, PipelineError> {
        let Some(pattern) = &self.shot.plate else { return Ok(None) };
        let frame = (sample.frame - mid_shutter(self.shot.shutter)).round() as i32;
        Ok(Some(SequencePath::of_input(pattern)?.path_of(frame)))
    }

    /// Returns the layers of a sample that move the plate.
    pub(super) fn layers_of_plate(&self, sample: &TimeSample) -> Vec<LayerJob> {
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
    pub(super) fn warped(&self, plate: &Plate, layers: Vec<LayerJob>) -> Result<Frame, PipelineError> {
        let settings = self.shot.warp.in_pixels(plate.frame_size());
        let job = PlateJob { layers, settings: &settings, fill: None };
        Ok(warp_plate(plate, &job).map(|(plate, _): (Plate, _)| plate.into_frame())?)
    }

    /// Returns an empty frame.
    pub(super) fn blank(&self) -> Frame {
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
