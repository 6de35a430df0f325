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
    instance: Arc<Instance>,
    #[cfg(test)]
    countdown: std::sync::atomic::AtomicI64,
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
        }
    }
}

impl Device {
    pub(super) fn new(instance: Arc<Instance>, candidate: &Candidate) -> Result<Arc<Self>, RasterError> {
        let raw = create(&instance, candidate)?;
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
            instance,
            #[cfg(test)]
            countdown: std::sync::atomic::AtomicI64::new(i64::MAX),
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

    /// Runs a creating call; all objects are made through here, so that tests can make any of them fail.
    pub(super) fn created<T>(
        &self,
        call: &'static str,
        make: impl FnOnce() -> Result<T, vk::Result>,
    ) -> Result<T, RasterError> {
        self.fail_on_countdown(call)?;
        make().map_err(vulkan_error(call))
    }

    /// Memory from the allocator, or an error that names what it was for.
    pub(super) fn allocate(&self, wanted: &AllocationCreateDesc) -> Result<Allocation, RasterError> {
        self.fail_on_countdown("vkAllocateMemory")?;
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

    #[cfg(not(test))]
    #[expect(clippy::unused_self, clippy::unnecessary_wraps, reason = "tests have another version that uses them")]
    fn fail_on_countdown(&self, _call: &'static str) -> Result<(), RasterError> {
        Ok(())
    }

    #[cfg(test)]
    fn fail_on_countdown(&self, call: &'static str) -> Result<(), RasterError> {
        use std::sync::atomic::Ordering;
        if self.countdown.fetch_sub(1, Ordering::SeqCst) == 0 {
            return Err(vulkan_error(call)(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY));
        }
        Ok(())
    }

    /// The creation after the next `count` ones fails.
    #[cfg(test)]
    pub(super) fn fail_after(&self, count: i64) {
        self.countdown.store(count, std::sync::atomic::Ordering::SeqCst);
    }

    /// The failure asked for has happened.
    #[cfg(test)]
    pub(super) fn has_failed(&self) -> bool {
        self.countdown.load(std::sync::atomic::Ordering::SeqCst) < 0
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let allocator = self.with_allocator(Option::take);
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

fn create(instance: &Instance, candidate: &Candidate) -> Result<ash::Device, RasterError> {
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(candidate.queue_family).queue_priorities(&[1.0])];
    let mut vulkan13 = vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true);
    let features = vk::PhysicalDeviceFeatures::default().sampler_anisotropy(candidate.has_anisotropy);
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .push_next(&mut vulkan13);
    // SAFETY: the device is of this instance; Vulkan 1.3 guarantees both features, anisotropy was looked for
    // (VUID-VkDeviceCreateInfo-queueFamilyIndex-02802, features of vkGetPhysicalDeviceFeatures).
    let made = unsafe { instance.raw().create_device(candidate.physical, &info, None) };
    made.map_err(vulkan_error("vkCreateDevice"))
}
