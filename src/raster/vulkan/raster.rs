//! [`VulkanRaster`]: renders a frame, from its first pass to its channels.
//!
//! In: a device, a scene, passes. Out: a [`Frame`]. Two passes are in flight: one is drawn while the next is uploaded.

use super::attachments::{AttachmentSet, Attachments};
use super::choose::choose;
use super::descriptors::Descriptors;
use super::device::Device;
use super::draws::DrawContext;
use super::instance::Instance;
use super::materials::Materials;
use super::messenger::Messages;
use super::pass::{self, DrawGroups, PassOutput};
use super::pipeline::Pipelines;
use super::readback::Readback;
use super::upload::UploadSlot;
use crate::image::{ChannelGroup, Frame};
use crate::raster::cpu::CpuRaster;
use crate::raster::window::WindowFromScreen;
use crate::raster::{
    DeviceChoice, DeviceClass, Geometry, Pass, PassRole, Raster, RasterError, SECOND_DATA_PASS, Target,
};
use crate::scene::Scene;
use ash::vk;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Number of passes in flight.
const SLOTS: usize = 2;

/// Size from which meshes use only one slot: two copies would cost more memory than the overlap is worth.
const ONE_SLOT_BYTES: usize = 8 << 20;

/// Renders on a Vulkan device. Field order: objects that wait for the device are dropped first, then what the device
/// reads.
pub struct VulkanRaster {
    pub(super) slots: [UploadSlot; SLOTS],
    pub(super) readback: Readback,
    pub(super) attachments: Attachments,
    pub(super) pipelines: Pipelines,
    pub(super) materials: Materials,
    pub(super) descriptors: Descriptors,
    device: Arc<Device>,
    /// Renders mattes on the host while the device renders the rest: lists of ids do not fit into attachments, and this
    /// makes mattes the same on every device.
    mattes: CpuRaster,
    pub(super) current: Option<CurrentFrame>,
    times: StageTimes,
}

/// Time spent since the last `start`, for benchmarks. Device and host work in parallel: these are times of the host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageTimes {
    /// Uploading geometry, recording and submitting commands.
    pub upload: Duration,
    /// Waiting for the device.
    pub draw: Duration,
    /// Copying images to the host and splitting them into channels.
    pub read: Duration,
    /// Rendering mattes on the host while the device works.
    pub mattes: Duration,
}

/// The frame being drawn.
pub(super) struct CurrentFrame {
    target: Target,
    pub(super) extent: vk::Extent2D,
    /// Number of beauty passes so far.
    beauty_passes: u32,
    /// Whether the data pass has been drawn.
    has_data: bool,
    /// Number of passes recorded so far; they alternate between the slots.
    passes: usize,
}

impl VulkanRaster {
    /// Opens the chosen device for a scene's materials and textures.
    ///
    /// # Errors
    /// [`RasterError`] if there is no such device, or it lacks memory.
    pub fn open(choice: &DeviceChoice, scene: &Scene) -> Result<Self, RasterError> {
        Self::open_with(choice, scene, None)
    }

    /// Opens a device with validation (core and synchronisation checks). Messages of the layers are collected in
    /// `messages`; those about leaked objects and memory appear when the rasteriser is dropped.
    ///
    /// # Errors
    /// As [`Self::open`]; [`RasterError::NoDevice`] also if the validation layer is not installed.
    #[cfg(test)]
    pub(crate) fn open_validated(
        choice: &DeviceChoice,
        scene: &Scene,
        messages: &Messages,
    ) -> Result<Self, RasterError> {
        Self::open_with(choice, scene, Some(messages))
    }

    fn open_with(choice: &DeviceChoice, scene: &Scene, messages: Option<&Messages>) -> Result<Self, RasterError> {
        let instance = Arc::new(Instance::new(messages)?);
        let candidate = choose(&instance, choice)?;
        Self::on_device(Device::new(instance, &candidate)?, scene)
    }

    pub(super) fn on_device(device: Arc<Device>, scene: &Scene) -> Result<Self, RasterError> {
        let descriptors = Descriptors::new(&device, scene.materials.len(), SLOTS)?;
        let pipelines = Pipelines::new(&device)?;
        let materials = Materials::new(&device, scene, &descriptors, &pipelines.geometry_layout)?;
        let slot = || UploadSlot::new(&device, &descriptors, &pipelines.geometry_layout);
        Ok(Self {
            slots: [slot()?, slot()?],
            readback: Readback::new(&device)?,
            attachments: Attachments::new(&device, &descriptors, &pipelines.resolve_layout)?,
            pipelines,
            materials,
            descriptors,
            device,
            mattes: CpuRaster::for_mattes(scene),
            current: None,
            times: StageTimes::default(),
        })
    }

    /// Returns the time spent since the last `start`.
    #[must_use]
    pub fn stage_times(&self) -> StageTimes {
        self.times
    }

    /// Waits until the device has completed all commands.
    fn wait(&mut self) -> Result<(), RasterError> {
        self.slots.iter_mut().try_for_each(|slot| slot.commands.wait())?;
        self.readback.wait()
    }

    /// Draws geometry into the current frame.
    fn add(
        &mut self,
        frame: &mut CurrentFrame,
        (geometry, jitter_px): (&Geometry, glam::Vec2),
        output: PassOutput,
    ) -> Result<(), RasterError> {
        let mean = frame.mean_weight(output)?;
        for &set in attachment_sets(output, mean.is_some()) {
            self.attachments.prepare(set, &self.descriptors)?;
        }
        if mean.is_some() {
            self.pipelines.prepare_resolve()?;
        }
        let is_large = size_of_val(geometry.vertices.as_slice()) >= ONE_SLOT_BYTES;
        let slot = &mut self.slots[if is_large { 0 } else { frame.passes % SLOTS }];
        frame.passes += 1;
        let window_from_screen = WindowFromScreen::new(&frame.target, jitter_px);
        let mesh = slot.fill(geometry, (window_from_screen, frame.extent), &self.descriptors)?;
        let groups = DrawGroups::new(geometry, output, &self.materials, &mut self.pipelines)?;
        slot.commands.begin()?;
        let context = DrawContext {
            commands: &slot.commands,
            buffer: slot.buffer()?,
            mesh,
            pass_set: slot.pass_set,
            pipelines: &self.pipelines,
            materials: &self.materials,
            pixels_from_screen: pixels_from_screen(&frame.target),
            extent: frame.extent,
        };
        pass::record(&context, &mut self.attachments, &groups, (output, mean.is_some()))?;
        if let Some(weight) = mean {
            pass::resolve(&context, &mut self.attachments, (weight, frame.beauty_passes == 0))?;
        }
        slot.commands.submit()?;
        frame.beauty_passes += u32::from(output != PassOutput::Data);
        frame.has_data |= output != PassOutput::Beauty;
        Ok(())
    }

    /// Clears the outputs that no pass has drawn into.
    fn complete(&mut self, frame: &mut CurrentFrame) -> Result<(), RasterError> {
        let nothing = Geometry::default();
        if frame.beauty_passes == 0 && frame.wants_beauty() {
            self.add(frame, (&nothing, glam::Vec2::ZERO), PassOutput::Beauty)?;
        }
        if !frame.has_data && frame.wants_data() {
            self.add(frame, (&nothing, glam::Vec2::ZERO), PassOutput::Data)?;
        }
        Ok(())
    }
}

impl CurrentFrame {
    fn wants_beauty(&self) -> bool {
        self.target.channels.contains(&ChannelGroup::Beauty)
    }

    fn wants_data(&self) -> bool {
        self.target.channels.iter().any(|group| group.is_data())
    }

    fn wants_mattes(&self) -> bool {
        self.target.channels.contains(&ChannelGroup::Cryptomatte)
    }

    /// Returns the outputs of a pass with that role; `None` if there are none.
    fn output(&self, role: PassRole) -> Option<PassOutput> {
        let is_beauty = role != PassRole::Data && self.wants_beauty();
        let is_data = role != PassRole::Beauty && self.wants_data();
        match (is_beauty, is_data) {
            (true, true) => Some(PassOutput::Both),
            (true, false) => Some(PassOutput::Beauty),
            (false, true) => Some(PassOutput::Data),
            (false, false) => None,
        }
    }

    /// Returns the weight of a pass in the mean of its frame; `None` if it is the frame's only beauty pass, or draws no
    /// colour.
    fn mean_weight(&self, output: PassOutput) -> Result<Option<f32>, RasterError> {
        let announced = self.target.beauty_passes.max(1);
        if output != PassOutput::Data && self.beauty_passes >= announced {
            return Err(RasterError::Misuse("more beauty passes were drawn than the target announced"));
        }
        if output != PassOutput::Beauty && self.has_data {
            return Err(RasterError::Misuse(SECOND_DATA_PASS));
        }
        Ok((output != PassOutput::Data && announced > 1).then(|| 1.0 / announced as f32))
    }
}

/// Returns the pixels per frame height, across and up.
pub(super) fn pixels_from_screen(target: &Target) -> [f32; 2] {
    let height = f64::from(target.frame.height);
    [(height / target.frame.pixel_aspect) as f32, height as f32]
}

/// Returns the attachments that a pass renders into.
fn attachment_sets(output: PassOutput, is_one_of_several: bool) -> &'static [AttachmentSet] {
    use AttachmentSet::{BeautyDepth, Color, Data, Sample};
    match (output, is_one_of_several) {
        (PassOutput::Data, _) => &[Data],
        (PassOutput::Both, false) => &[Color, Data],
        (PassOutput::Both, true) => &[Color, Sample, Data],
        (PassOutput::Beauty, false) => &[Color, BeautyDepth],
        (PassOutput::Beauty, true) => &[Color, Sample, BeautyDepth],
    }
}

impl Raster for VulkanRaster {
    fn name(&self) -> String {
        self.device.facts().name.clone()
    }

    fn class(&self) -> DeviceClass {
        DeviceClass::Vulkan
    }

    fn max_side(&self) -> u32 {
        self.device.facts().max_side
    }

    fn start(&mut self, target: &Target) -> Result<(), RasterError> {
        let (width, height) = (target.window.width, target.window.height);
        if width == 0 || height == 0 {
            return Err(RasterError::Misuse("the target has no pixels"));
        }
        if width.max(height) > self.max_side() {
            return Err(RasterError::Misuse("the target is larger than the device allows; draw it in tiles"));
        }
        // The device may still be drawing an abandoned frame.
        self.wait()?;
        let extent = vk::Extent2D { width, height };
        self.attachments.resize(extent);
        self.times = StageTimes::default();
        let frame = CurrentFrame { target: target.clone(), extent, beauty_passes: 0, has_data: false, passes: 0 };
        if frame.wants_mattes() {
            self.mattes.start(&Target { channels: vec![ChannelGroup::Cryptomatte], ..target.clone() })?;
        }
        self.current = Some(frame);
        Ok(())
    }

    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError> {
        let mut frame = self.current.take().ok_or(RasterError::Misuse("draw was called before start"))?;
        if let Some(output) = frame.output(pass.role) {
            let begin = Instant::now();
            // On an error the frame is dropped.
            self.add(&mut frame, (pass.geometry, pass.jitter_px), output)?;
            self.times.upload += begin.elapsed();
        }
        if frame.wants_mattes() && pass.role != PassRole::Data {
            let begin = Instant::now();
            self.mattes.draw(&Pass { role: PassRole::Beauty, ..*pass })?;
            self.times.mattes += begin.elapsed();
        }
        self.current = Some(frame);
        Ok(())
    }

    fn finish(&mut self) -> Result<Frame, RasterError> {
        let mut frame = self.current.take().ok_or(RasterError::Misuse("finish was called before start"))?;
        self.complete(&mut frame)?;
        let begin = Instant::now();
        self.readback.copy(&mut self.attachments, frame.extent, &frame.target.channels)?;
        // The copies must follow the draws.
        self.slots.iter_mut().try_for_each(|slot| slot.commands.wait())?;
        let drawn = Instant::now();
        let mut channels = self.readback.read(&mut self.attachments, frame.extent, &frame.target.channels)?;
        self.times.draw += drawn - begin;
        self.times.read += drawn.elapsed();
        if frame.wants_mattes() {
            let begin = Instant::now();
            channels.extend(self.mattes.finish()?.channels);
            self.times.mattes += begin.elapsed();
        }
        Ok(Frame {
            display: frame.target.frame.window(),
            data_window: frame.target.window,
            pixel_aspect: frame.target.frame.pixel_aspect,
            channels,
        })
    }
}
