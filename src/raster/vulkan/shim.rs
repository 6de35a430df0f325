//! A function table between rasteriser and driver that makes any call fail, for tests.
//!
//! In: a device, a [`Fault`]. Out: the same device with a table that counts calls; the call selected by the fault
//! returns its error. The state is per thread, as tests run in parallel.

use super::choose::Candidate;
use super::device::{Device, create};
use super::instance::Instance;
use crate::raster::RasterError;
use ash::vk;
use std::cell::RefCell;
use std::sync::Arc;

/// The call that fails, and its error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fault {
    /// Number of matching calls that succeed first.
    pub(super) after: usize,
    /// The result code.
    pub(super) code: vk::Result,
    /// Matching calls; empty: all.
    pub(super) calls: &'static [&'static str],
    /// Whether all later matching calls fail, too.
    pub(super) is_lasting: bool,
}

#[derive(Default)]
struct State {
    tables: Option<(ash::DeviceFnV1_0, ash::DeviceFnV1_3)>,
    fault: Option<Fault>,
    /// Number of matching calls so far.
    seen: usize,
    /// The first call that failed.
    failed: Option<&'static str>,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// Creates a device whose calls fail as specified.
pub(super) fn device(
    instance: &Arc<Instance>,
    candidate: &Candidate,
    fault: Fault,
) -> Result<Arc<Device>, RasterError> {
    let raw = hook(create(instance, candidate)?);
    STATE.with_borrow_mut(|state| (state.fault, state.seen, state.failed) = (Some(fault), 0, None));
    Device::from_raw(raw, Arc::clone(instance), candidate)
}

/// Makes all further calls succeed; returns the call that failed, if any.
pub(super) fn heal() -> Option<&'static str> {
    STATE.with_borrow_mut(|state| {
        state.fault = None;
        state.failed
    })
}

/// Returns the error of a call if it fails now.
fn fault(call: &'static str) -> Option<vk::Result> {
    STATE.with_borrow_mut(|state| {
        let fault = state.fault?;
        if !fault.calls.is_empty() && !fault.calls.contains(&call) {
            return None;
        }
        state.seen += 1;
        let is_due = state.seen == fault.after + 1 || (fault.is_lasting && state.seen > fault.after);
        if is_due {
            state.failed.get_or_insert(call);
        }
        is_due.then_some(fault.code)
    })
}

macro_rules! shims {
    ($($table:tt $name:ident($($arg:ident: $kind:ty),* $(,)?);)*) => {
        $(
            /// # Safety
            /// As the call of that name.
            unsafe extern "system" fn $name($($arg: $kind),*) -> vk::Result {
                let real = STATE.with_borrow(|state| state.tables.as_ref().map(|tables| tables.$table.$name));
                let Some(real) = real else { return vk::Result::ERROR_UNKNOWN };
                match fault(stringify!($name)) {
                    // Reported only after the work is done: after a device loss the caller may destroy everything.
                    Some(vk::Result::ERROR_DEVICE_LOST) if stringify!($name) == "wait_for_fences" => {
                        // SAFETY: the caller's promise.
                        let _ = unsafe { real($($arg),*) };
                        vk::Result::ERROR_DEVICE_LOST
                    }
                    Some(code) => code,
                    // SAFETY: the caller's promise.
                    None => unsafe { real($($arg),*) },
                }
            }
        )*

        /// Installs the shims in the function table of a device.
        fn hook(raw: ash::Device) -> ash::Device {
            let mut tables = (raw.fp_v1_0().clone(), raw.fp_v1_3().clone());
            STATE.with_borrow_mut(|state| state.tables = Some(tables.clone()));
            $(tables.$table.$name = $name;)*
            let (v1_1, v1_2) = (raw.fp_v1_1().clone(), raw.fp_v1_2().clone());
            ash::Device::from_parts_1_3(raw.handle(), tables.0, v1_1, v1_2, tables.1)
        }
    };
}

type Callbacks<'a> = *const vk::AllocationCallbacks<'a>;

shims! {
    0 create_buffer(device: vk::Device, info: *const vk::BufferCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::Buffer);
    0 create_image(device: vk::Device, info: *const vk::ImageCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::Image);
    0 create_image_view(device: vk::Device, info: *const vk::ImageViewCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::ImageView);
    0 create_sampler(device: vk::Device, info: *const vk::SamplerCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::Sampler);
    0 create_fence(device: vk::Device, info: *const vk::FenceCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::Fence);
    0 create_command_pool(
        device: vk::Device, info: *const vk::CommandPoolCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::CommandPool
    );
    0 allocate_command_buffers(device: vk::Device, info: *const vk::CommandBufferAllocateInfo<'_>, out: *mut vk::CommandBuffer);
    0 create_descriptor_pool(
        device: vk::Device, info: *const vk::DescriptorPoolCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::DescriptorPool
    );
    0 create_descriptor_set_layout(
        device: vk::Device, info: *const vk::DescriptorSetLayoutCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::DescriptorSetLayout
    );
    0 allocate_descriptor_sets(device: vk::Device, info: *const vk::DescriptorSetAllocateInfo<'_>, out: *mut vk::DescriptorSet);
    0 create_pipeline_layout(
        device: vk::Device, info: *const vk::PipelineLayoutCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::PipelineLayout
    );
    0 create_graphics_pipelines(
        device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::GraphicsPipelineCreateInfo<'_>,
        callbacks: Callbacks<'_>, out: *mut vk::Pipeline
    );
    0 create_compute_pipelines(
        device: vk::Device, cache: vk::PipelineCache, count: u32, infos: *const vk::ComputePipelineCreateInfo<'_>,
        callbacks: Callbacks<'_>, out: *mut vk::Pipeline
    );
    0 create_shader_module(
        device: vk::Device, info: *const vk::ShaderModuleCreateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::ShaderModule
    );
    0 allocate_memory(
        device: vk::Device, info: *const vk::MemoryAllocateInfo<'_>, callbacks: Callbacks<'_>, out: *mut vk::DeviceMemory
    );
    0 map_memory(
        device: vk::Device, memory: vk::DeviceMemory, offset: vk::DeviceSize, size: vk::DeviceSize, flags: vk::MemoryMapFlags,
        out: *mut *mut std::ffi::c_void
    );
    0 bind_buffer_memory(device: vk::Device, buffer: vk::Buffer, memory: vk::DeviceMemory, offset: vk::DeviceSize);
    0 bind_image_memory(device: vk::Device, image: vk::Image, memory: vk::DeviceMemory, offset: vk::DeviceSize);
    0 reset_command_pool(device: vk::Device, pool: vk::CommandPool, flags: vk::CommandPoolResetFlags);
    0 wait_for_fences(device: vk::Device, count: u32, fences: *const vk::Fence, all: vk::Bool32, timeout: u64);
    0 reset_fences(device: vk::Device, count: u32, fences: *const vk::Fence);
    0 device_wait_idle(device: vk::Device);
    0 begin_command_buffer(buffer: vk::CommandBuffer, info: *const vk::CommandBufferBeginInfo<'_>);
    0 end_command_buffer(buffer: vk::CommandBuffer);
    1 queue_submit2(queue: vk::Queue, count: u32, submits: *const vk::SubmitInfo2<'_>, fence: vk::Fence);
}
