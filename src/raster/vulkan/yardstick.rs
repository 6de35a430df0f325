//! What a frame costs at the least: the yardstick of the benches.
//!
//! In: a target with all channels and one pass. Out: the times of a bare draw and copy.

use super::pass::{self, Destination, Groups, Plan, View, Work};
use super::{Painter, Part, VulkanRaster};
use crate::raster::{Geometry, Raster, RasterError, Target};
use std::time::{Duration, Instant};

/// Time spent since the last `start`, for measurements. Device and host work side by side: these are times of the host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Geometry to the device, commands recorded and submitted.
    pub upload: Duration,
    /// The host waits for the device to draw.
    pub draw: Duration,
    /// Images copied to the host, and made channels.
    pub read: Duration,
    /// The host draws mattes, while the device is at work.
    pub mattes: Duration,
}

/// Times of a bare frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BareTimes {
    /// From the first command to the last byte in host memory that belongs to the device.
    pub device: Duration,
    /// The bytes copied, image by image, into memory of the program's own.
    pub host: Duration,
}

impl VulkanRaster {
    /// Time spent since the last `start`.
    #[must_use]
    pub fn stage_times(&self) -> StageTimes {
        self.times
    }

    /// A bare frame: the geometry lies ready, one command buffer draws it with the pipelines and into the images of a
    /// frame, and copies all of them. It makes no channels. The target wants all channels and one beauty pass.
    ///
    /// # Errors
    /// As a frame.
    pub fn time_bare_frame(&mut self, target: &Target, geometry: &Geometry) -> Result<BareTimes, RasterError> {
        self.start(target)?;
        let begun = self.begun.take().ok_or(RasterError::Misuse("no frame was begun"))?;
        for part in [Part::Color, Part::Data] {
            self.attachments.prepare(part, &self.descriptors)?;
        }
        let slot = &mut self.slots[0];
        let place = slot.fill(geometry, &self.descriptors)?;
        self.readback.reserve(begun.extent)?;
        let groups = Groups::new(geometry, Work::Both, &self.materials, &mut self.pipelines)?;
        let plan = Plan { work: Work::Both, destination: Destination::Frame, has_data: false };
        let begin = Instant::now();
        slot.commands.begin()?;
        let painter = Painter {
            commands: &slot.commands,
            buffer: slot.buffer()?,
            place,
            pass_set: slot.pass_set,
            pipelines: &self.pipelines,
            materials: &self.materials,
            view: View::new(target, glam::Vec2::ZERO),
            extent: begun.extent,
        };
        pass::record(&painter, &mut self.attachments, &groups, plan)?;
        self.readback.record_all(&slot.commands, &mut self.attachments, begun.extent)?;
        slot.commands.submit()?;
        slot.commands.wait()?;
        let device = begin.elapsed();
        let begin = Instant::now();
        std::hint::black_box(self.readback.bytes());
        Ok(BareTimes { device, host: begin.elapsed() })
    }
}
