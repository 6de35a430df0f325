//! Buffers and images with their memory.
//!
//! In: sizes, formats, uses. Out: objects that own handle and memory; host-visible ones are mapped and coherent
//! (gpu-allocator uses no other memory for them), so nothing has to be flushed.

use super::device::Device;
use super::fault::vulkan_error;
use super::owned::Owned;
use crate::raster::RasterError;
use ash::vk;
pub(super) use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::Arc;

/// Minimum size of objects with a dedicated allocation, which is returned to the system with them.
const DEDICATED_BYTES: u64 = 16 << 20;

/// Alignment that allows reading mapped memory as vectors of four floats.
const MIN_ALIGNMENT: u64 = 16;

/// An allocation that is freed when dropped.
struct Memory {
    allocation: Allocation,
    device: Arc<Device>,
}

impl Memory {
    /// Allocates memory as requested by `wanted`; small objects are always suballocated.
    fn new(device: &Arc<Device>, wanted: AllocationCreateDesc) -> Result<Self, RasterError> {
        let is_small = wanted.requirements.size < DEDICATED_BYTES;
        let allocation_scheme = if is_small { AllocationScheme::GpuAllocatorManaged } else { wanted.allocation_scheme };
        let allocation = device.allocate(&AllocationCreateDesc { allocation_scheme, ..wanted })?;
        Ok(Self { allocation, device: Arc::clone(device) })
    }

    fn handle(&self) -> vk::DeviceMemory {
        // SAFETY: the handle is only bound to the object that owns this memory and is dropped before it.
        unsafe { self.allocation.memory() }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        let allocation = std::mem::take(&mut self.allocation);
        if !self.device.is_abandoned() {
            self.device.free(allocation);
        }
    }
}

/// The use of a buffer.
#[derive(Clone, Copy, Debug)]
pub(super) struct BufferUse {
    pub(super) name: &'static str,
    pub(super) usage: vk::BufferUsageFlags,
    pub(super) location: MemoryLocation,
}

/// A buffer; host-visible ones are mapped. Field order: the handle is destroyed before its memory.
pub(super) struct Buffer {
    handle: Owned<vk::Buffer>,
    memory: Memory,
    size: u64,
}

impl Buffer {
    /// Creates a buffer of `size` > 0 bytes.
    pub(super) fn new(device: &Arc<Device>, wanted: BufferUse, size: u64) -> Result<Self, RasterError> {
        let info = vk::BufferCreateInfo::default().size(size).usage(wanted.usage);
        let handle = Owned::new(device, ("vkCreateBuffer", wanted.name), |raw| {
            // SAFETY: size > 0 (VUID-VkBufferCreateInfo-size-00912), usage not empty (-None-09499).
            unsafe { raw.create_buffer(&info, None) }
        })?;
        // SAFETY: the buffer is of this device.
        let mut requirements = unsafe { device.raw().get_buffer_memory_requirements(handle.get()) };
        requirements.alignment = requirements.alignment.max(MIN_ALIGNMENT);
        let memory = Memory::new(
            device,
            AllocationCreateDesc {
                name: wanted.name,
                requirements,
                location: wanted.location,
                linear: true,
                allocation_scheme: AllocationScheme::DedicatedBuffer(handle.get()),
            },
        )?;
        // SAFETY: the memory was allocated for these requirements and is bound once
        // (VUID-vkBindBufferMemory-buffer-07459, -memory-01035, -memoryOffset-01036, -size-01037).
        let bound =
            unsafe { device.raw().bind_buffer_memory(handle.get(), memory.handle(), memory.allocation.offset()) };
        bound.map_err(vulkan_error("vkBindBufferMemory"))?;
        Ok(Self { handle, memory, size })
    }

    /// Returns the buffer in `slot` if it has `bytes`; otherwise replaces it by one of `new_bytes`. No submitted
    /// commands may use the old one.
    pub(super) fn reserve<'a>(
        slot: &'a mut Option<Self>,
        device: &Arc<Device>,
        wanted: BufferUse,
        (bytes, new_bytes): (u64, u64),
    ) -> Result<&'a mut Self, RasterError> {
        let kept = slot.take().filter(|buffer| buffer.size >= bytes);
        let buffer = match kept {
            Some(buffer) => buffer,
            None => Self::new(device, wanted, new_bytes)?,
        };
        Ok(slot.insert(buffer))
    }

    pub(super) fn get(&self) -> vk::Buffer {
        self.handle.get()
    }

    /// Returns the bytes written by the device; empty if the buffer is not host-visible.
    pub(super) fn bytes(&self) -> &[u8] {
        self.memory.allocation.mapped_slice().unwrap_or_default()
    }

    /// Returns the bytes to be read by the device; empty if the buffer is not host-visible.
    pub(super) fn bytes_mut(&mut self) -> &mut [u8] {
        self.memory.allocation.mapped_slice_mut().unwrap_or_default()
    }
}

/// The use of an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageUse {
    pub(super) name: &'static str,
    pub(super) format: vk::Format,
    pub(super) usage: vk::ImageUsageFlags,
    pub(super) mip_levels: u32,
    pub(super) placement: Placement,
}

/// The placement of an image in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placement {
    /// Device-local memory and optimal tiling.
    Device,
    /// Linear tiling in mapped memory, if [`super::device::Facts::has_mapped_attachments`]: the host reads it without a
    /// copy.
    Mapped,
}

/// The last use of an image, which the next barrier waits for.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageState {
    pub(super) layout: vk::ImageLayout,
    pub(super) stage: vk::PipelineStageFlags2,
    pub(super) access: vk::AccessFlags2,
}

impl ImageState {
    const NEW: Self = Self {
        layout: vk::ImageLayout::UNDEFINED,
        stage: vk::PipelineStageFlags2::NONE,
        access: vk::AccessFlags2::NONE,
    };
}

/// An image with a view of all of it. Field order: view, handle, memory.
pub(super) struct Image {
    view: Owned<vk::ImageView>,
    handle: Owned<vk::Image>,
    memory: Memory,
    /// Offset of the first row and row pitch in bytes, if the image is mapped.
    rows: Option<(usize, usize)>,
    pub(super) aspect: vk::ImageAspectFlags,
    pub(super) state: ImageState,
}

impl Image {
    /// Creates an image of at least 1x1 pixels, within the device's limits.
    pub(super) fn new(device: &Arc<Device>, wanted: ImageUse, extent: vk::Extent2D) -> Result<Self, RasterError> {
        let handle = create_image(device, wanted, extent)?;
        // SAFETY: the image is of this device.
        let requirements = unsafe { device.raw().get_image_memory_requirements(handle.get()) };
        let memory = Memory::new(
            device,
            AllocationCreateDesc {
                name: wanted.name,
                requirements,
                location: match wanted.placement {
                    Placement::Device => MemoryLocation::GpuOnly,
                    Placement::Mapped => MemoryLocation::GpuToCpu,
                },
                linear: wanted.placement == Placement::Mapped,
                allocation_scheme: AllocationScheme::DedicatedImage(handle.get()),
            },
        )?;
        // SAFETY: as for buffers (VUID-vkBindImageMemory-image-07460, -memory-01047, -memoryOffset-01048, -size-01049).
        let bound =
            unsafe { device.raw().bind_image_memory(handle.get(), memory.handle(), memory.allocation.offset()) };
        bound.map_err(vulkan_error("vkBindImageMemory"))?;
        let aspect = match wanted.usage.contains(vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT) {
            true => vk::ImageAspectFlags::DEPTH,
            false => vk::ImageAspectFlags::COLOR,
        };
        let view = create_view(device, &handle, wanted, aspect)?;
        let rows = (wanted.placement == Placement::Mapped).then(|| rows(device, &handle, aspect));
        Ok(Self { view, handle, memory, rows, aspect, state: ImageState::NEW })
    }

    pub(super) fn get(&self) -> vk::Image {
        self.handle.get()
    }

    pub(super) fn view(&self) -> vk::ImageView {
        self.view.get()
    }

    /// Returns the bytes written by the device from the first pixel on, and the row pitch in bytes; `None` if not
    /// mapped.
    pub(super) fn mapped_rows(&self) -> Option<(&[u8], usize)> {
        let (first, pitch) = self.rows?;
        Some((self.memory.allocation.mapped_slice()?.get(first..)?, pitch))
    }
}

/// Returns the offset of the first row and the row pitch in bytes of a linear image.
fn rows(device: &Arc<Device>, image: &Owned<vk::Image>, aspect: vk::ImageAspectFlags) -> (usize, usize) {
    let part = vk::ImageSubresource::default().aspect_mask(aspect);
    // SAFETY: linear tiling, a level and layer that exist (VUID-vkGetImageSubresourceLayout-image-07790, -01716, -01717).
    let layout = unsafe { device.raw().get_image_subresource_layout(image.get(), part) };
    (layout.offset as usize, layout.row_pitch as usize)
}

fn create_image(device: &Arc<Device>, wanted: ImageUse, extent: vk::Extent2D) -> Result<Owned<vk::Image>, RasterError> {
    let info = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(wanted.format)
        .extent(extent.into())
        .mip_levels(wanted.mip_levels)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(match wanted.placement {
            Placement::Device => vk::ImageTiling::OPTIMAL,
            Placement::Mapped => vk::ImageTiling::LINEAR,
        })
        .usage(wanted.usage)
        .initial_layout(vk::ImageLayout::UNDEFINED);
    Owned::new(device, ("vkCreateImage", wanted.name), |raw| {
        // SAFETY: format and usage were checked in `choose`, or are mandatory (RGBA8 textures); sides are within the
        // limits (VUID-VkImageCreateInfo-extent-02252, -02253, -mipLevels-00958).
        unsafe { raw.create_image(&info, None) }
    })
}

fn create_view(
    device: &Arc<Device>,
    image: &Owned<vk::Image>,
    wanted: ImageUse,
    aspect: vk::ImageAspectFlags,
) -> Result<Owned<vk::ImageView>, RasterError> {
    let range = vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(wanted.mip_levels).layer_count(1);
    let info = vk::ImageViewCreateInfo::default()
        .image(image.get())
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(wanted.format)
        .subresource_range(range);
    Owned::new(device, ("vkCreateImageView", wanted.name), |raw| {
        // SAFETY: the image has memory (VUID-VkImageViewCreateInfo-image-01020), the same format and all levels.
        unsafe { raw.create_image_view(&info, None) }
    })
}
