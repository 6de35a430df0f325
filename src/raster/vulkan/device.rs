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
    /// Whether commands may never complete, so that nothing of this device may be destroyed any more.
    is_abandoned: AtomicBool,
    instance: Arc<Instance>,
}

/// Device properties that the rasteriser needs.
#[derive(Clone, Debug)]
pub(super) struct Facts {
    pub(super) name: String,
    pub(super) queue_family: u32,
    pub(super) max_side: u32,
    pub(super) max_texture_side: u32,
    /// `None` without anisotropic filtering.
    pub(super) max_anisotropy: Option<f32>,
    /// Whether the host may read colour attachments in place.
    pub(super) has_mapped_attachments: bool,
    /// Alignment of the offsets of storage and uniform buffers.
    pub(super) offset_alignment: u64,
    /// Maximum size of a storage buffer in bytes.
    pub(super) max_buffer_bytes: u64,
    /// Maximum vertex index.
    pub(super) max_index: u32,
}

/// Maximum number of bytes per pixel over all attachments.
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
        // Each image of a square frame with the maximum side must fit into one allocation; all images of a 16:9 frame
        // of that width must fit into three quarters of the memory.
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
            // Source, offsets and result together take at most three quarters of the memory.
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

    /// Wraps a device created by [`create`]; its function table may differ from the driver's.
    pub(super) fn from_raw(
        raw: ash::Device,
        instance: Arc<Instance>,
        candidate: &Candidate,
    ) -> Result<Arc<Self>, RasterError> {
        let names = instance.messages().map(|_| ext::debug_utils::Device::new(instance.raw(), &raw));
        // SAFETY: the family and its first queue were requested in `create`
        // (VUID-vkGetDeviceQueue-queueFamilyIndex-00384).
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

    /// Returns the function table of the device.
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

    /// Prevents the destruction of anything of this device: commands that use it may still run.
    pub(super) fn abandon(&self) {
        self.is_abandoned.store(true, Ordering::SeqCst);
    }

    pub(super) fn is_abandoned(&self) -> bool {
        self.is_abandoned.load(Ordering::SeqCst)
    }

    /// Allocates memory; an error names its purpose.
    pub(super) fn allocate(&self, wanted: &AllocationCreateDesc) -> Result<Allocation, RasterError> {
        let allocated = self.with_allocator(|allocator| allocator.as_mut().map(|allocator| allocator.allocate(wanted)));
        let allocated = allocated.ok_or(RasterError::Misuse("the memory allocator is gone"))?;
        allocated.map_err(memory_error(wanted.name, wanted.requirements.size))
    }

    /// Frees memory; nothing may be bound to it any more.
    pub(super) fn free(&self, allocation: Allocation) {
        let freed = self.with_allocator(|allocator| allocator.as_mut().map(|allocator| allocator.free(allocation)));
        if let Some(Err(error)) = freed {
            tracing::error!("device memory could not be freed: {error}");
        }
    }

    /// Submits a recorded command buffer; `fence` is signalled when it completes.
    pub(super) fn submit(&self, buffer: vk::CommandBuffer, fence: vk::Fence) -> Result<(), RasterError> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(buffer)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        // SAFETY: the queue is locked; the buffer is recorded and not pending (VUID-vkQueueSubmit2-commandBuffer-03874,
        // -03875), the fence unsignalled (-fence-04894): `Commands` ensures both.
        unsafe { self.raw.queue_submit2(*queue, &submit, fence) }.map_err(vulkan_error("vkQueueSubmit2"))
    }

    /// Names an object for messages, if validation is enabled.
    pub(super) fn set_name<H: vk::Handle>(&self, handle: H, name: &str) {
        let (Some(names), Ok(name)) = (&self.names, CString::new(name)) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: the handle was just created by this device (VUID-VkDebugUtilsObjectNameInfoEXT-objectType-02590). A
        // failure only loses the name.
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
        // SAFETY: every object holds an `Arc` of this device, so all are destroyed (VUID-vkDestroyDevice-device-05137),
        // and `Commands` wait when they are dropped, so nothing runs.
        unsafe { self.raw.destroy_device(None) };
    }
}

/// Creates a device with the features that the rasteriser uses.
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
    // SAFETY: the device belongs to this instance; Vulkan 1.3 guarantees both features, the others were queried
    // (VUID-VkDeviceCreateInfo-queueFamilyIndex-02802, features of vkGetPhysicalDeviceFeatures).
    let made = unsafe { instance.raw().create_device(candidate.physical, &info, None) };
    made.map_err(vulkan_error("vkCreateDevice"))
}
