//! The logical device: queue, allocator, limits, object names.
//!
//! In: an instance and a chosen candidate. Out: a [`Device`] that every other object holds through an `Arc`.

use super::choose::Candidate;
use super::fault::{memory_error, vulkan_error};
use super::instance::Instance;
use crate::raster::RasterError;
use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, Allocator, AllocatorCreateDesc};
use std::ffi::CString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Owns the logical device. Drop order: allocator (frees its blocks), device, instance.
pub(super) struct Device {
    raw: ash::Device,
    /// `None` only while `new` fails or the device is dropped.
    allocator: Mutex<Option<Allocator>>,
    /// Submission needs external synchronisation (VUID-vkQueueSubmit2-queue parameter).
    queue: Mutex<vk::Queue>,
    names: Option<ext::debug_utils::Device>,
    facts: Facts,
    /// Commands may run for ever: nothing of this device is destroyed any more.
    is_abandoned: AtomicBool,
    instance: Arc<Instance>,
}

/// What the raster has to know of its device.
#[derive(Clone, Debug)]
pub(super) struct Facts {
    pub(super) name: String,
    pub(super) queue_family: u32,
    pub(super) max_side: u32,
    pub(super) max_texture_side: u32,
    /// `None`: no anisotropic filter.
    pub(super) max_anisotropy: Option<f32>,
    /// The host may read colour attachments where they lie.
    pub(super) has_mapped_attachments: bool,
    /// Offsets of parts of storage and uniform buffers are multiples of this.
    pub(super) offset_alignment: u64,
    /// The largest storage buffer, bytes.
    pub(super) max_buffer_bytes: u64,
    /// The largest index of a vertex that may be drawn.
    pub(super) max_index: u32,
}

/// Bytes of all attachments of a pixel, at most.
const BYTES_PER_PIXEL: u64 = 80;

impl Facts {
    fn new(candidate: &Candidate) -> Self {
        let limits = &candidate.limits;
        let [viewport_width, viewport_height] = limits.max_viewport_dimensions;
        let dimensions = [
            limits.max_image_dimension2_d,
            limits.max_framebuffer_width,
            limits.max_framebuffer_height,
            viewport_width,
            viewport_height,
        ];
        // A square of the largest side must fit into one allocation an image; with all images, a picture of 16:9 that
        // wide into three quarters of the memory.
        let by_allocation = (candidate.max_allocation_bytes / 16).isqrt();
        let by_memory = (candidate.info.memory_bytes * 3 / 4 / BYTES_PER_PIXEL * 16 / 9).isqrt();
        let by_memory = u32::try_from(by_allocation.min(by_memory)).unwrap_or(u32::MAX);
        let side = dimensions.into_iter().fold(by_memory, u32::min);
        Self {
            name: candidate.info.name.clone(),
            queue_family: candidate.queue_family,
            max_side: (side / 64 * 64).max(64),
            max_texture_side: limits.max_image_dimension2_d,
            max_anisotropy: candidate.has_anisotropy.then_some(limits.max_sampler_anisotropy),
            has_mapped_attachments: candidate.has_mapped_attachments,
            offset_alignment: limits
                .min_storage_buffer_offset_alignment
                .max(limits.min_uniform_buffer_offset_alignment),
            // Source, offsets and result at once take three quarters of the memory at most.
            max_buffer_bytes: u64::from(limits.max_storage_buffer_range)
                .min(candidate.max_allocation_bytes)
                .min(candidate.info.memory_bytes / 4),
            max_index: if candidate.has_full_indices { u32::MAX - 1 } else { limits.max_draw_indexed_index_value },
        }
    }
}

impl Device {
    pub(super) fn new(instance: Arc<Instance>, candidate: &Candidate) -> Result<Arc<Self>, RasterError> {
        let raw = create(&instance, candidate)?;
        Self::from_raw(raw, instance, candidate)
    }

    /// Owns a device that [`create`] made; its function table may be another than the driver's.
    pub(super) fn from_raw(
        raw: ash::Device,
        instance: Arc<Instance>,
        candidate: &Candidate,
    ) -> Result<Arc<Self>, RasterError> {
        let names = instance.messages().map(|_| ext::debug_utils::Device::new(instance.raw(), &raw));
        // SAFETY: the family and its first queue were asked for in `create` (VUID-vkGetDeviceQueue-queueFamilyIndex-00384).
        let queue = unsafe { raw.get_device_queue(candidate.queue_family, 0) };
        // From here on `Drop` cleans up.
        let device = Self {
            raw,
            allocator: Mutex::new(None),
            queue: Mutex::new(queue),
            names,
            facts: Facts::new(candidate),
            is_abandoned: AtomicBool::new(false),
            instance,
        };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance.raw().clone(),
            device: device.raw.clone(),
            physical_device: candidate.physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        });
        let allocator = allocator.map_err(memory_error("the memory allocator", 0))?;
        device.with_allocator(|slot| *slot = Some(allocator));
        Ok(Arc::new(device))
    }

    /// The functions of the device.
    pub(super) fn raw(&self) -> &ash::Device {
        &self.raw
    }

    pub(super) fn facts(&self) -> &Facts {
        &self.facts
    }

    /// Waits until the queue is empty; a lost device counts as idle.
    pub(super) fn wait_idle(&self) -> Result<(), RasterError> {
        let _queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the queue is locked (VUID-vkDeviceWaitIdle-device-parameter: host access to all queues).
        match unsafe { self.raw.device_wait_idle() } {
            Ok(()) | Err(vk::Result::ERROR_DEVICE_LOST) => Ok(()),
            Err(error) => Err(vulkan_error("vkDeviceWaitIdle")(error)),
        }
    }

    /// From now on nothing of this device is destroyed: commands that use it may still run.
    pub(super) fn abandon(&self) {
        self.is_abandoned.store(true, Ordering::SeqCst);
    }

    pub(super) fn is_abandoned(&self) -> bool {
        self.is_abandoned.load(Ordering::SeqCst)
    }

    /// Memory from the allocator, or an error that names what it was for.
    pub(super) fn allocate(&self, wanted: &AllocationCreateDesc) -> Result<Allocation, RasterError> {
        let allocated = self.with_allocator(|allocator| allocator.as_mut().map(|allocator| allocator.allocate(wanted)));
        let allocated = allocated.ok_or(RasterError::Misuse("the memory allocator is gone"))?;
        allocated.map_err(memory_error(wanted.name, wanted.requirements.size))
    }

    /// Gives memory back; nothing may be bound to it any more.
    pub(super) fn free(&self, allocation: Allocation) {
        let freed = self.with_allocator(|allocator| allocator.as_mut().map(|allocator| allocator.free(allocation)));
        if let Some(Err(error)) = freed {
            tracing::error!("device memory could not be freed: {error}");
        }
    }

    /// Submits a recorded command buffer; `fence` is signalled when it is done.
    pub(super) fn submit(&self, buffer: vk::CommandBuffer, fence: vk::Fence) -> Result<(), RasterError> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(buffer)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the queue is locked; the buffer is recorded and not pending (VUID-vkQueueSubmit2-commandBuffer-03874,
        // -03875), the fence unsignalled (-fence-04894): `Commands` sees to both.
        unsafe { self.raw.queue_submit2(*queue, &submit, fence) }.map_err(vulkan_error("vkQueueSubmit2"))
    }

    /// Names an object for messages, where validation is on.
    pub(super) fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        let (Some(names), Ok(name)) = (&self.names, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle was just made by this device (VUID-VkDebugUtilsObjectNameInfoEXT-objectType-02590).
        // A failure costs a name only.
        let _ = unsafe { names.set_debug_utils_object_name(&info) };
    }

    fn with_allocator<T>(&self, act: impl FnOnce(&mut Option<Allocator>) -> T) -> T {
        act(&mut self.allocator.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let allocator = self.with_allocator(Option::take);
        if self.is_abandoned() {
            std::mem::forget(allocator);
            // The instance must outlive its device.
            std::mem::forget(Arc::clone(&self.instance));
            return;
        }
        if let (Some(allocator), Some(messages)) = (&allocator, self.instance.messages()) {
            for leak in allocator.generate_report().allocations {
                messages.push(format!("leaked memory: {} ({} bytes)", leak.name, leak.size));
            }
        }
        drop(allocator);
        // SAFETY: every object holds an `Arc` of this device, so all are gone (VUID-vkDestroyDevice-device-05137), and
        // `Commands` wait before they go, so nothing runs.
        unsafe { self.raw.destroy_device(None) };
    }
}

/// A device with the features that the raster uses.
pub(super) fn create(instance: &Instance, candidate: &Candidate) -> Result<ash::Device, RasterError> {
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(candidate.queue_family).queue_priorities(&[1.0])];
    let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true);
    let features = vk::PhysicalDeviceFeatures::default()
        .sampler_anisotropy(candidate.has_anisotropy)
        .full_draw_index_uint32(candidate.has_full_indices);
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .push_next(&mut vulkan13);
    // SAFETY: the device is of this instance; Vulkan 1.3 guarantees both features, the others were looked for
    // (VUID-VkDeviceCreateInfo-queueFamilyIndex-02802, features of vkGetPhysicalDeviceFeatures).
    let made = unsafe { instance.raw().create_device(candidate.physical, &info, None) };
    made.map_err(vulkan_error("vkCreateDevice"))
}
