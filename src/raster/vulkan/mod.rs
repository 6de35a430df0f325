//! The Vulkan raster: offscreen float targets through ash; the loader is opened at run time.
//!
//! In: a scene once, then geometry a pass. Out: the frames that the CPU twin draws too. Needs Vulkan 1.3 (dynamic
//! rendering, `synchronization2`) and nothing else.

#![expect(unsafe_code, reason = "Vulkan is a C API; safe wrappers around single calls, each with its SAFETY remark")]

mod choose;
mod commands;
mod descriptors;
mod device;
mod fault;
mod instance;
mod materials;
mod memory;
mod messenger;
mod owned;
mod painter;
mod pass;
mod pipeline;
mod readback;
mod remap;
mod remap_tiles;
mod rendering;
mod target;
#[cfg(test)]
mod tests;
mod textures;
mod upload;
mod yardstick;

pub use choose::{DeviceInfo, DeviceKind, devices};
pub use messenger::Messages;
pub use remap::VulkanRemap;
pub use yardstick::{BareTimes, StageTimes};

use crate::image::Frame;
use crate::raster::cpu::CpuRaster;
use crate::raster::{ChannelGroup, DeviceChoice, Geometry, Pass, PassRole, Raster, RasterError, Target};
use crate::scene::Scene;
use ash::vk;
use descriptors::Descriptors;
use device::Device;
use instance::Instance;
use materials::Materials;
use painter::Painter;
use pass::{Destination, Groups, Plan, View, Work};
use pipeline::Pipelines;
use readback::Readback;
use std::sync::Arc;
use std::time::Instant;
use target::{Attachments, Part};
use upload::Slot;

/// Passes in flight: one is drawn while the next is filled.
const SLOTS: usize = 2;

/// Draws on a Vulkan device. Field order: what waits for the device goes first, then what the device read.
pub struct VulkanRaster {
    slots: [Slot; SLOTS],
    readback: Readback,
    attachments: Attachments,
    pipelines: Pipelines,
    materials: Materials,
    descriptors: Descriptors,
    device: Arc<Device>,
    /// Draws mattes on the host while the device draws the rest: lists of ids have no place in attachments, and every
    /// device gives the same mattes.
    mattes: CpuRaster,
    begun: Option<Begun>,
    times: StageTimes,
}

/// The frame being drawn.
struct Begun {
    target: Target,
    extent: vk::Extent2D,
    /// Beauty passes so far.
    beauty_passes: u32,
    /// A data pass has been drawn.
    has_data: bool,
    /// Passes recorded so far, for taking turns.
    passes: usize,
}

impl VulkanRaster {
    /// Opens the chosen device for a scene's materials and textures.
    ///
    /// # Errors
    /// [`RasterError`] where there is no such device, or it lacks memory.
    pub fn open(choice: &DeviceChoice, scene: &Scene) -> Result<Self, RasterError> {
        Self::open_with(choice, scene, None)
    }

    /// The same with validation (core and synchronisation checks); what the layers say arrives in `messages`, leaks
    /// of objects and memory when the raster is dropped.
    ///
    /// # Errors
    /// As [`Self::open`]; [`RasterError::NoDevice`] also where the validation layer is not installed.
    pub fn open_validated(choice: &DeviceChoice, scene: &Scene, messages: &Messages) -> Result<Self, RasterError> {
        Self::open_with(choice, scene, Some(messages))
    }

    fn open_with(choice: &DeviceChoice, scene: &Scene, messages: Option<&Messages>) -> Result<Self, RasterError> {
        let instance = Arc::new(Instance::new(messages)?);
        let candidate = choose::choose(&instance, choice)?;
        Self::on_device(Device::new(instance, &candidate)?, scene)
    }

    fn on_device(device: Arc<Device>, scene: &Scene) -> Result<Self, RasterError> {
        let descriptors = Descriptors::new(&device, scene.materials.len(), SLOTS)?;
        let pipelines = Pipelines::new(&device)?;
        let materials = Materials::new(&device, scene, &descriptors, &pipelines.geometry_layout)?;
        let slot = || Slot::new(&device, &descriptors, &pipelines.geometry_layout);
        Ok(Self {
            slots: [slot()?, slot()?],
            readback: Readback::new(&device)?,
            attachments: Attachments::new(&device, &descriptors, &pipelines.resolve_layout)?,
            pipelines,
            materials,
            descriptors,
            device,
            mattes: CpuRaster::for_mattes(scene),
            begun: None,
            times: StageTimes::default(),
        })
    }

    /// Waits until the device has nothing to do.
    fn wait(&mut self) -> Result<(), RasterError> {
        self.slots.iter_mut().try_for_each(|slot| slot.commands.wait())?;
        self.readback.wait()
    }

    /// Draws geometry into the begun frame.
    fn add(
        &mut self,
        begun: &mut Begun,
        geometry: &Geometry,
        jitter: glam::Vec2,
        work: Work,
    ) -> Result<(), RasterError> {
        let plan = begun.plan(work)?;
        for &part in parts(plan) {
            self.attachments.prepare(part, &self.descriptors)?;
        }
        if plan.destination != Destination::Frame {
            self.pipelines.prepare_resolve()?;
        }
        let slot = &mut self.slots[begun.passes % SLOTS];
        begun.passes += 1;
        let place = slot.fill(geometry, &self.descriptors)?;
        let groups = Groups::new(geometry, work, &self.materials, &mut self.pipelines)?;
        slot.commands.begin()?;
        let painter = Painter {
            commands: &slot.commands,
            buffer: slot.buffer()?,
            place,
            pass_set: slot.pass_set,
            pipelines: &self.pipelines,
            materials: &self.materials,
            view: View::new(&begun.target, jitter),
            extent: begun.extent,
        };
        pass::record(&painter, &mut self.attachments, &groups, plan)?;
        if let (true, Destination::Mean { weight, is_first }) = (work != Work::Data, plan.destination) {
            pass::resolve(&painter, &mut self.attachments, &self.pipelines, (weight, is_first))?;
        }
        slot.commands.submit()?;
        begun.count(work);
        Ok(())
    }

    /// Draws nothing into what no pass has drawn into, so that it holds what stands for nothing.
    fn complete(&mut self, begun: &mut Begun) -> Result<(), RasterError> {
        let nothing = Geometry::default();
        if begun.beauty_passes == 0 && begun.wants_beauty() {
            self.add(begun, &nothing, glam::Vec2::ZERO, Work::Beauty)?;
        }
        if !begun.has_data && begun.wants_data() {
            self.add(begun, &nothing, glam::Vec2::ZERO, Work::Data)?;
        }
        Ok(())
    }
}

impl Begun {
    fn wants_beauty(&self) -> bool {
        self.target.channels.contains(&ChannelGroup::Beauty)
    }

    fn wants_data(&self) -> bool {
        let is_data = |group: &ChannelGroup| !matches!(group, ChannelGroup::Beauty | ChannelGroup::Cryptomatte);
        self.target.channels.iter().any(is_data)
    }

    fn wants_mattes(&self) -> bool {
        self.target.channels.contains(&ChannelGroup::Cryptomatte)
    }

    /// What a pass of that role has to draw; `None`: nothing.
    fn work(&self, role: PassRole) -> Option<Work> {
        let is_beauty = role != PassRole::Data && self.wants_beauty();
        let is_data = role != PassRole::Beauty && self.wants_data();
        match (is_beauty, is_data) {
            (true, true) if self.has_data => Some(Work::BeautyThenData),
            (true, true) => Some(Work::Both),
            (true, false) => Some(Work::Beauty),
            (false, true) => Some(Work::Data),
            (false, false) => None,
        }
    }

    fn plan(&self, work: Work) -> Result<Plan, RasterError> {
        let announced = self.target.beauty_passes.max(1);
        if work != Work::Data && self.beauty_passes >= announced {
            return Err(RasterError::Misuse("more beauty passes were drawn than the target announced"));
        }
        let destination = match announced {
            1 => Destination::Frame,
            _ => Destination::Mean { weight: 1.0 / announced as f32, is_first: self.beauty_passes == 0 },
        };
        Ok(Plan { work, destination, has_data: self.has_data })
    }

    fn count(&mut self, work: Work) {
        self.beauty_passes += u32::from(work != Work::Data);
        self.has_data |= work != Work::Beauty;
    }
}

/// The images that a pass draws into.
fn parts(plan: Plan) -> &'static [Part] {
    match (plan.work, plan.destination) {
        (Work::Data, _) => &[Part::Data],
        (Work::Both, Destination::Frame) => &[Part::Color, Part::Data],
        (Work::Both, Destination::Mean { .. }) => &[Part::Color, Part::Sample, Part::Data],
        (Work::Beauty, Destination::Frame) => &[Part::Color, Part::BeautyDepth],
        (Work::Beauty, Destination::Mean { .. }) => &[Part::Color, Part::Sample, Part::BeautyDepth],
        (Work::BeautyThenData, _) => &[Part::Color, Part::Sample, Part::BeautyDepth, Part::Data],
    }
}

impl Raster for VulkanRaster {
    fn name(&self) -> String {
        self.device.facts().name.clone()
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
        // A frame given up may still be drawn.
        self.wait()?;
        let extent = vk::Extent2D { width, height };
        self.attachments.resize(extent);
        self.times = StageTimes::default();
        let begun = Begun { target: target.clone(), extent, beauty_passes: 0, has_data: false, passes: 0 };
        if begun.wants_mattes() {
            self.mattes.start(&Target { channels: vec![ChannelGroup::Cryptomatte], ..target.clone() })?;
        }
        self.begun = Some(begun);
        Ok(())
    }

    fn draw(&mut self, pass: &Pass) -> Result<(), RasterError> {
        let mut begun = self.begun.take().ok_or(RasterError::Misuse("draw was called before start"))?;
        if let Some(work) = begun.work(pass.role) {
            let begin = Instant::now();
            // A frame whose pass failed is not gone on with.
            self.add(&mut begun, pass.geometry, pass.jitter_px, work)?;
            self.times.upload += begin.elapsed();
        }
        if begun.wants_mattes() && pass.role != PassRole::Data {
            let begin = Instant::now();
            self.mattes.draw(pass)?;
            self.times.mattes += begin.elapsed();
        }
        self.begun = Some(begun);
        Ok(())
    }

    fn finish(&mut self) -> Result<Frame, RasterError> {
        let mut begun = self.begun.take().ok_or(RasterError::Misuse("finish was called before start"))?;
        self.complete(&mut begun)?;
        let begin = Instant::now();
        self.readback.copy(&mut self.attachments, begun.extent, &begun.target.channels)?;
        // The copies wait for the draws anyway.
        self.slots.iter_mut().try_for_each(|slot| slot.commands.wait())?;
        let drawn = Instant::now();
        let mut channels = self.readback.read(&mut self.attachments, begun.extent, &begun.target.channels)?;
        self.times.draw += drawn - begin;
        self.times.read += drawn.elapsed();
        if begun.wants_mattes() {
            let begin = Instant::now();
            channels.extend(self.mattes.finish()?.channels);
            self.times.mattes += begin.elapsed();
        }
        Ok(Frame {
            display: begun.target.frame.window(),
            data_window: begun.target.window,
            pixel_aspect: begun.target.frame.pixel_aspect,
            channels,
        })
    }
}
