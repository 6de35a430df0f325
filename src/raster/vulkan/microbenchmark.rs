//! The minimum cost of a frame, as a baseline for benchmarks.
//!
//! In: a target with all channels and one pass. Out: the times of a bare draw and copy.

use super::attachments::AttachmentSet;
use super::draws::DrawContext;
use super::pass::{self, DrawGroups, PassOutput};
use super::raster::{VulkanRaster, pixels_from_screen};
use crate::raster::window::WindowFromScreen;
use crate::raster::{Geometry, Raster, RasterError, Target};
use std::time::{Duration, Instant};

/// Times of a bare frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BareTimes {
    /// From the first command to the last byte in host-visible device memory.
    pub device: Duration,
    /// Copying the bytes, image by image, into ordinary host memory.
    pub host: Duration,
}

impl VulkanRaster {
    /// Measures a bare frame: the geometry is uploaded, one command buffer draws it with the pipelines and into the
    /// images of a frame, and copies all of them; no channels are assembled. The target must have all channels and one
    /// beauty pass.
    ///
    /// # Errors
    /// As for a frame.
    pub fn time_bare_frame(&mut self, target: &Target, geometry: &Geometry) -> Result<BareTimes, RasterError> {
        self.start(target)?;
        let frame = self.current.take().ok_or(RasterError::Misuse("no frame was begun"))?;
        for set in [AttachmentSet::Color, AttachmentSet::Data] {
            self.attachments.prepare(set, &self.descriptors)?;
        }
        let slot = &mut self.slots[0];
        let window_from_screen = WindowFromScreen::new(target, glam::Vec2::ZERO);
        let mesh = slot.fill(geometry, (window_from_screen, frame.extent), &self.descriptors)?;
        self.readback.reserve(frame.extent)?;
        let groups = DrawGroups::new(geometry, PassOutput::Both, &self.materials, &mut self.pipelines)?;
        let begin = Instant::now();
        slot.commands.begin()?;
        let context = DrawContext {
            commands: &slot.commands,
            buffer: slot.buffer()?,
            mesh,
            pass_set: slot.pass_set,
            pipelines: &self.pipelines,
            materials: &self.materials,
            pixels_from_screen: pixels_from_screen(target),
            extent: frame.extent,
        };
        pass::record(&context, &mut self.attachments, &groups, (PassOutput::Both, false))?;
        self.readback.record_all(&slot.commands, &mut self.attachments, frame.extent)?;
        slot.commands.submit()?;
        slot.commands.wait()?;
        let device = begin.elapsed();
        let begin = Instant::now();
        std::hint::black_box(self.readback.bytes());
        Ok(BareTimes { device, host: begin.elapsed() })
    }
}
