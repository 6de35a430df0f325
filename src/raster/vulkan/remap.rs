//! Resamples planes through an offset map on a device, as `src/plate/filter/` does on the CPU.
//!
//! In: a map, planes, a filter. Out: planes of the map's window, equal to those of
//! [`resampled`](crate::plate::resampled) within rounding. Maps and pictures too large for a buffer are processed in
//! tiles.

use super::choose::choose;
use super::commands::{Commands, Compute};
use super::descriptors::Descriptors;
use super::device::Device;
use super::instance::Instance;
use super::memory::{Buffer, BufferUse, MemoryLocation};
use super::messenger::Messages;
use super::owned::Owned;
use super::pipeline::{Pipeline, PipelineLayout, shader};
use super::remap_tiles::{Cut, Tile};
use crate::plate::{Extent, Filter, Planes, Resampler, WarpMap, lanczos_table};
use crate::raster::{DeviceChoice, RasterError};
use crate::space::PixelRect;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::ffi::CStr;
use std::sync::Arc;

/// Planes per dispatch.
const GROUP: usize = 4;
/// Side of a workgroup in pixels.
const GROUP_SIDE: u32 = 8;

/// `Push` of remap.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Push {
    area: [u32; 2],
    first: [i32; 2],
    offset_count: [i32; 2],
    start: [i32; 2],
    count: [i32; 2],
    low: [i32; 2],
    size: [i32; 2],
    goes_on_before: [u32; 2],
    goes_on_after: [u32; 2],
    planes: u32,
    padding: u32,
}

const PUSH_BYTES: u32 = size_of::<Push>() as u32;

/// The buffers of a dispatch, in the order of their bindings.
#[derive(Clone, Copy)]
enum Role {
    Offsets,
    Source,
    Lanczos,
    Result,
}

impl Role {
    const ALL: [Self; 4] = [Self::Offsets, Self::Source, Self::Lanczos, Self::Result];

    fn buffer_use(self) -> BufferUse {
        let (name, location) = match self {
            Self::Offsets => ("offsets of a map", MemoryLocation::CpuToGpu),
            Self::Source => ("planes of a plate", MemoryLocation::CpuToGpu),
            Self::Lanczos => ("weights of Lanczos", MemoryLocation::CpuToGpu),
            Self::Result => ("planes of a warped plate", MemoryLocation::GpuToCpu),
        };
        BufferUse { name, usage: vk::BufferUsageFlags::STORAGE_BUFFER, location }
    }
}

/// Number of neighbours on each side whose offsets a footprint looks at.
const RIM: i32 = 2;

/// Resamples planes on a Vulkan device. Field order: objects that wait for the device are dropped first, then what the
/// device reads.
pub struct VulkanRemap {
    commands: Commands,
    buffers: [Option<Buffer>; Role::ALL.len()],
    pipelines: [Option<Pipeline>; 4],
    set: vk::DescriptorSet,
    descriptors: Descriptors,
    layout: PipelineLayout,
    device: Arc<Device>,
    /// Maximum bytes of a buffer.
    max_bytes: u64,
}

/// The planes of a dispatch, their position, and how they are filtered.
struct Group<'a> {
    map: &'a WarpMap,
    window: PixelRect,
    planes: &'a [&'a [f32]],
    extents: [Extent; 2],
    start: [i32; 2],
    filter: Filter,
}

/// A rectangle of a row-major array.
struct Rows<S> {
    samples: S,
    /// Samples per row of the array.
    stride: u32,
    rect: PixelRect,
}

impl<S> Rows<S> {
    /// An array that is a rectangle.
    fn all(samples: S, rect: PixelRect) -> Self {
        Self { samples, stride: rect.width, rect: PixelRect { x: 0, y: 0, ..rect } }
    }
}

impl VulkanRemap {
    /// Opens the chosen device.
    ///
    /// # Errors
    /// [`RasterError`] if there is no such device, it lacks memory, or the choice is [`DeviceChoice::Cpu`].
    pub fn open(choice: &DeviceChoice) -> Result<Self, RasterError> {
        Self::open_with(choice, None)
    }

    /// Opens a device with validation, as [`VulkanRaster::open_validated`](super::VulkanRaster::open_validated).
    ///
    /// # Errors
    /// As [`Self::open`]; [`RasterError::NoDevice`] also if the validation layer is not installed.
    #[cfg(test)]
    pub(crate) fn open_validated(choice: &DeviceChoice, messages: &Messages) -> Result<Self, RasterError> {
        Self::open_with(choice, Some(messages))
    }

    fn open_with(choice: &DeviceChoice, messages: Option<&Messages>) -> Result<Self, RasterError> {
        let instance = Arc::new(Instance::new(messages)?);
        let candidate = choose(&instance, choice)?;
        Self::on_device(Device::new(instance, &candidate)?)
    }

    pub(super) fn on_device(device: Arc<Device>) -> Result<Self, RasterError> {
        let descriptors = Descriptors::for_buffers(&device, Role::ALL.len() as u32)?;
        let types = [vk::DescriptorType::STORAGE_BUFFER; Role::ALL.len()];
        let layout = PipelineLayout::for_compute(&device, "remap", &types, PUSH_BYTES)?;
        let set = descriptors.set(layout.set(0), "remap")?;
        let mut remap = Self {
            commands: Commands::new(&device, "remap")?,
            buffers: Default::default(),
            pipelines: Default::default(),
            set,
            descriptors,
            layout,
            max_bytes: device.facts().max_buffer_bytes,
            device,
        };
        let table: &[u8] = bytemuck::cast_slice(lanczos_table());
        remap.bind(Role::Lanczos, table.len())?.copy_from_slice(table);
        Ok(remap)
    }

    /// Returns the device's name: `llvmpipe (LLVM 15.0.6, 256 bits)`.
    #[must_use]
    pub fn name(&self) -> String {
        self.device.facts().name.clone()
    }

    /// Limits the size of buffers in bytes; more and smaller tiles then give the same picture.
    #[cfg(test)]
    pub(crate) fn limit_buffers(&mut self, bytes: u64) {
        self.max_bytes = self.device.facts().max_buffer_bytes.min(bytes);
    }

    /// Resamples the planes through the map, as [`resampled`](crate::plate::resampled) does: one output per input
    /// plane, each with `map.window.area()` samples; 0 where the map holds NaN. Copied samples keep their bits, sums
    /// differ by rounding.
    ///
    /// # Errors
    /// [`RasterError`] if a plane or the map does not have as many elements as its window has pixels, or if memory is
    /// exhausted or the device fails.
    pub fn resample(&mut self, map: &WarpMap, source: &Planes, filter: Filter) -> Result<Vec<Vec<f32>>, RasterError> {
        let mut results = vec![vec![0.0; map.window.area()]; source.planes.len()];
        self.resample_into(map, source, filter, &mut results)?;
        Ok(results)
    }

    /// Resamples into existing planes. Every plane is uploaded once, and so is the map if it fits as a whole.
    fn resample_into(
        &mut self,
        map: &WarpMap,
        source: &Planes,
        filter: Filter,
        results: &mut [Vec<f32>],
    ) -> Result<(), RasterError> {
        check(map, source)?;
        if map.window.area() == 0 || source.window.area() == 0 {
            results.iter_mut().for_each(|plane| plane.fill(0.0));
            return Ok(());
        }
        self.prepare(filter)?;
        let extents = Extent::of_window(source.window, map.frame.window());
        let start = [map.window.x - source.window.x, map.window.y - source.window.y];
        let texel_bytes = (size_of::<f32>() * source.planes.len().clamp(2, GROUP)) as u64;
        let most = usize::try_from(self.max_bytes / texel_bytes).unwrap_or(usize::MAX);
        let tiles = Cut { map, extents, start, filter, most }.tiles();
        let mut uploaded = None;
        for (planes, results) in source.planes.chunks(GROUP).zip(results.chunks_mut(GROUP)) {
            let group = Group { map, window: source.window, planes, extents, start, filter };
            let mut held = None;
            for tile in &tiles {
                if held.replace(tile.part) != Some(tile.part) {
                    self.upload_source(&group, tile.part)?;
                }
                let offset_rect = match uploaded {
                    Some((area, offset_rect)) if area == tile.area => offset_rect,
                    _ => self.upload_offsets(map, tile.area)?,
                };
                uploaded = Some((tile.area, offset_rect));
                self.run(&group, tile, offset_rect, results)?;
            }
        }
        Ok(())
    }

    /// Creates a filter's pipeline if needed.
    fn prepare(&mut self, filter: Filter) -> Result<(), RasterError> {
        let slot = &mut self.pipelines[filter as usize];
        if slot.is_none() {
            *slot = Some(pipeline(&self.device, &self.layout, filter)?);
        }
        Ok(())
    }

    /// Binds a number of bytes of a buffer, for the host to write or read once the device has finished with it.
    fn bind(&mut self, role: Role, bytes: usize) -> Result<&mut [u8], RasterError> {
        self.commands.wait()?;
        let size = bytes as u64;
        let slot = &mut self.buffers[role as usize];
        let buffer = Buffer::reserve(slot, &self.device, role.buffer_use(), (size, size))?;
        let place = (self.set, role as u32);
        self.descriptors.write_buffer(place, vk::DescriptorType::STORAGE_BUFFER, (buffer, 0, size));
        buffer.bytes_mut().get_mut(..bytes).ok_or(RasterError::Misuse("a buffer of a plate is not mapped"))
    }

    /// Uploads a part of the planes into the source buffer, consecutively.
    fn upload_source(&mut self, group: &Group, part: PixelRect) -> Result<(), RasterError> {
        let bytes = self.bind(Role::Source, part.area() * size_of::<f32>() * group.planes.len())?;
        let to: &mut [f32] = bytemuck::cast_slice_mut(bytes);
        for (plane, to) in group.planes.iter().zip(to.chunks_exact_mut(part.area())) {
            copy_rows(Rows { samples: plane, stride: group.window.width, rect: part }, Rows::all(to, part));
        }
        Ok(())
    }

    /// Uploads the offsets of an area and of its neighbours; returns the rectangle that they cover.
    fn upload_offsets(&mut self, map: &WarpMap, area: PixelRect) -> Result<PixelRect, RasterError> {
        let axis = |low: i32, size: u32, all: u32| {
            let first = (low - RIM).max(0);
            (first, (low as u32 + size + RIM as u32).min(all) - first as u32)
        };
        let (x, width) = axis(area.x, area.width, map.window.width);
        let (y, height) = axis(area.y, area.height, map.window.height);
        let offset_rect = PixelRect { x, y, width, height };
        let bytes = self.bind(Role::Offsets, offset_rect.area() * size_of::<[f32; 2]>())?;
        let from = Rows { samples: &map.offsets[..], stride: map.window.width, rect: offset_rect };
        copy_rows(from, Rows::all(bytemuck::cast_slice_mut(bytes), offset_rect));
        Ok(offset_rect)
    }

    /// Resamples a tile, whose source and offsets (of the rectangle `offset_rect`) are uploaded, into its planes.
    fn run(
        &mut self,
        group: &Group,
        tile: &Tile,
        offset_rect: PixelRect,
        results: &mut [Vec<f32>],
    ) -> Result<(), RasterError> {
        let area = tile.area;
        self.bind(Role::Result, area.area() * size_of::<f32>() * results.len())?;
        self.dispatch(&group.push(tile, offset_rect), group.filter)?;
        let result = self.buffers[Role::Result as usize].as_ref().map_or(&[][..], Buffer::bytes);
        let result: &[f32] = bytemuck::cast_slice(&result[..area.area() * size_of::<f32>() * results.len()]);
        for (from, to) in result.chunks_exact(area.area()).zip(results) {
            copy_rows(Rows::all(from, area), Rows { samples: to, stride: group.map.window.width, rect: area });
        }
        Ok(())
    }

    /// Dispatches a filter over the bound buffers and waits.
    fn dispatch(&mut self, push: &Push, filter: Filter) -> Result<(), RasterError> {
        let missing = RasterError::Misuse("a filter was not prepared");
        let (Some(pipeline), Some(result)) = (&self.pipelines[filter as usize], &self.buffers[Role::Result as usize])
        else {
            return Err(missing);
        };
        let groups = push.area.map(|side| side.div_ceil(GROUP_SIDE));
        let push = bytemuck::bytes_of(push);
        self.commands.begin()?;
        self.commands.compute(&Compute { pipeline, layout: &self.layout, set: self.set, push, groups }, result);
        self.commands.submit()?;
        self.commands.wait()
    }
}

impl Resampler for VulkanRemap {
    fn name(&self) -> String {
        Self::name(self)
    }

    fn resample(
        &mut self,
        map: &WarpMap,
        source: &Planes,
        filter: Filter,
        results: &mut [Vec<f32>],
    ) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        Ok(self.resample_into(map, source, filter, results)?)
    }
}

impl Group<'_> {
    fn push(&self, tile: &Tile, offset_rect: PixelRect) -> Push {
        let Tile { area, part } = *tile;
        let goes_on = |side: usize| self.extents.map(|extent| u32::from(extent.goes_on[side]));
        Push {
            area: [area.width, area.height],
            first: [area.x - offset_rect.x, area.y - offset_rect.y],
            offset_count: [offset_rect.width as i32, offset_rect.height as i32],
            start: [self.start[0] + area.x, self.start[1] + area.y],
            count: self.extents.map(|extent| extent.count),
            low: [part.x, part.y],
            size: [part.width as i32, part.height as i32],
            goes_on_before: goes_on(0),
            goes_on_after: goes_on(1),
            planes: self.planes.len() as u32,
            padding: 0,
        }
    }
}

fn check(map: &WarpMap, source: &Planes) -> Result<(), RasterError> {
    if map.offsets.len() != map.window.area() {
        return Err(RasterError::Misuse("the map does not have an offset a pixel"));
    }
    if source.planes.iter().any(|plane| plane.len() != source.window.area()) {
        return Err(RasterError::Misuse("a plane does not have a sample a pixel"));
    }
    Ok(())
}

/// Copies a rectangle between two arrays; both are of equal size.
fn copy_rows<T: Copy>(from: Rows<&[T]>, to: Rows<&mut [T]>) {
    let width = from.rect.width as usize;
    for row in 0..from.rect.height as usize {
        let first = (from.rect.y as usize + row) * from.stride as usize + from.rect.x as usize;
        let to_first = (to.rect.y as usize + row) * to.stride as usize + to.rect.x as usize;
        to.samples[to_first..to_first + width].copy_from_slice(&from.samples[first..first + width]);
    }
}

fn pipeline(device: &Arc<Device>, layout: &PipelineLayout, filter: Filter) -> Result<Pipeline, RasterError> {
    let (name, entry): (&str, &CStr) = match filter {
        Filter::Ewa => ("remap_ewa", c"ewa"),
        Filter::Cubic => ("remap_cubic", c"cubic"),
        Filter::Lanczos => ("remap_lanczos", c"lanczos"),
        Filter::Nearest => ("remap_nearest", c"nearest"),
    };
    let module = shader(device, name)?;
    let stage = vk::PipelineShaderStageCreateInfo::default()
        .stage(vk::ShaderStageFlags::COMPUTE)
        .module(module.get())
        .name(entry);
    let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.get())];
    Owned::new(device, ("vkCreateComputePipelines", name), |raw| {
        // SAFETY: shader and layout agree (VUID-VkComputePipelineCreateInfo-layout-07988, -07987, -07990), the entry
        // point is the module's only one.
        let made = unsafe { raw.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        // Only one pipeline was requested, so on failure there is none to destroy.
        made.map(|pipelines| pipelines[0]).map_err(|(_, result)| result)
    })
}

const _: () = assert!(PUSH_BYTES == 80);
