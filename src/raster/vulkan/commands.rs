//! A command buffer with its fence: recording, submission, waiting.
//!
//! In: safe calls on live objects. Out: work on the queue. The recording code keeps the objects alive until
//! [`Commands::wait`] has returned; dropping waits, too.

use super::device::Device;
use super::fault::vulkan_error;
use super::memory::{Buffer, Image, ImageState};
use super::owned::Owned;
use super::pipeline::{Pipeline, PipelineLayout};
use crate::raster::RasterError;
use ash::vk;
use std::sync::Arc;

/// A reusable command buffer.
pub(super) struct Commands {
    buffer: vk::CommandBuffer,
    pool: Owned<vk::CommandPool>,
    fence: Owned<vk::Fence>,
    is_pending: bool,
}

/// A dispatch.
pub(super) struct Compute<'a> {
    pub(super) pipeline: &'a Pipeline,
    pub(super) layout: &'a PipelineLayout,
    pub(super) set: vk::DescriptorSet,
    /// The complete push constants.
    pub(super) push: &'a [u8],
    /// Number of workgroups across and down.
    pub(super) groups: [u32; 2],
}

/// The next use of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Usage {
    ColorAttachment,
    DepthAttachment,
    Sampled,
    CopySource,
    CopyTarget,
    HostRead,
}

/// Whether an image's pixels are preserved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contents {
    Keep,
    Discard,
}

impl Usage {
    fn state(self) -> ImageState {
        use vk::{AccessFlags2 as Access, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let (layout, stage, access) = match self {
            Self::ColorAttachment => (
                Layout::COLOR_ATTACHMENT_OPTIMAL,
                Stage::COLOR_ATTACHMENT_OUTPUT,
                Access::COLOR_ATTACHMENT_READ | Access::COLOR_ATTACHMENT_WRITE,
            ),
            Self::DepthAttachment => (
                Layout::DEPTH_ATTACHMENT_OPTIMAL,
                Stage::EARLY_FRAGMENT_TESTS | Stage::LATE_FRAGMENT_TESTS,
                Access::DEPTH_STENCIL_ATTACHMENT_READ | Access::DEPTH_STENCIL_ATTACHMENT_WRITE,
            ),
            Self::Sampled => (Layout::SHADER_READ_ONLY_OPTIMAL, Stage::FRAGMENT_SHADER, Access::SHADER_SAMPLED_READ),
            Self::CopySource => (Layout::TRANSFER_SRC_OPTIMAL, Stage::COPY, Access::TRANSFER_READ),
            Self::CopyTarget => (Layout::TRANSFER_DST_OPTIMAL, Stage::COPY, Access::TRANSFER_WRITE),
            Self::HostRead => (Layout::GENERAL, Stage::HOST, Access::HOST_READ),
        };
        ImageState { layout, stage, access }
    }
}

impl Commands {
    pub(super) fn new(device: &Arc<Device>, name: &str) -> Result<Self, RasterError> {
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(device.facts().queue_family);
        let pool = Owned::new(device, ("vkCreateCommandPool", name), |raw| {
            // SAFETY: the family is the device's (VUID-vkCreateCommandPool-queueFamilyIndex-01937).
            unsafe { raw.create_command_pool(&info, None) }
        })?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool.get()).command_buffer_count(1);
        // SAFETY: the pool is alive and not used by anyone else; buffers are freed with it.
        let buffers = unsafe { device.raw().allocate_command_buffers(&info) };
        let buffers = buffers.map_err(vulkan_error("vkAllocateCommandBuffers"))?;
        let fence = Owned::new(device, ("vkCreateFence", name), |raw| {
            // SAFETY: no preconditions.
            unsafe { raw.create_fence(&vk::FenceCreateInfo::default(), None) }
        })?;
        let buffer = buffers.first().copied().ok_or(RasterError::Misuse("no command buffer was made"))?;
        device.set_name(buffer, name);
        Ok(Self { buffer, pool, fence, is_pending: false })
    }

    fn device(&self) -> &Device {
        self.pool.device()
    }

    pub(super) fn raw(&self) -> &ash::Device {
        self.pool.device().raw()
    }

    pub(super) fn buffer(&self) -> vk::CommandBuffer {
        self.buffer
    }

    /// Waits for the last submission, then begins a new recording.
    pub(super) fn begin(&mut self) -> Result<(), RasterError> {
        self.wait()?;
        // SAFETY: its only buffer is not pending (VUID-vkResetCommandPool-commandPool-00040).
        let reset = unsafe { self.raw().reset_command_pool(self.pool.get(), vk::CommandPoolResetFlags::empty()) };
        reset.map_err(vulkan_error("vkResetCommandPool"))?;
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the reset above made it initial (VUID-vkBeginCommandBuffer-commandBuffer-00049).
        let begun = unsafe { self.raw().begin_command_buffer(self.buffer, &info) };
        begun.map_err(vulkan_error("vkBeginCommandBuffer"))
    }

    /// Ends the recording and submits it.
    pub(super) fn submit(&mut self) -> Result<(), RasterError> {
        let fences = [self.fence.get()];
        // SAFETY: `begin` waited for the last use, so no queue uses it (VUID-vkResetFences-pFences-01123).
        unsafe { self.raw().reset_fences(&fences) }.map_err(vulkan_error("vkResetFences"))?;
        // SAFETY: recording, outside of a render pass instance (VUID-vkEndCommandBuffer-commandBuffer-00059, -00060).
        let ended = unsafe { self.raw().end_command_buffer(self.buffer) };
        ended.map_err(vulkan_error("vkEndCommandBuffer"))?;
        self.device().submit(self.buffer, self.fence.get())?;
        self.is_pending = true;
        Ok(())
    }

    /// Waits until the submission has completed; returns at once if there is none. After an error other than a lost
    /// device the commands may still run, and remain pending.
    pub(super) fn wait(&mut self) -> Result<(), RasterError> {
        if !self.is_pending {
            return Ok(());
        }
        // SAFETY: the fence is of this device and was submitted.
        let waited = unsafe { self.raw().wait_for_fences(&[self.fence.get()], true, u64::MAX) };
        // A lost device no longer executes commands (Vulkan specification, "Lost Device").
        self.is_pending = !matches!(waited, Ok(()) | Err(vk::Result::ERROR_DEVICE_LOST));
        waited.map_err(vulkan_error("vkWaitForFences"))
    }

    /// Transitions an image to its next use, after its last one.
    pub(super) fn prepare(&self, image: &mut Image, usage: Usage, contents: Contents) {
        let (last, next) = (image.state, usage.state());
        let old_layout = match contents {
            Contents::Keep => last.layout,
            Contents::Discard => vk::ImageLayout::UNDEFINED,
        };
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(image.aspect)
            .level_count(vk::REMAINING_MIP_LEVELS)
            .layer_count(1);
        let barriers = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(last.stage)
            .src_access_mask(last.access)
            .dst_stage_mask(next.stage)
            .dst_access_mask(next.access)
            .old_layout(old_layout)
            .new_layout(next.layout)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.get())
            .subresource_range(range)];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: recording outside of rendering; the old layout is the tracked one or UNDEFINED
        // (VUID-VkImageMemoryBarrier2-oldLayout-01197), each usage is one that the image was created for.
        unsafe { self.raw().cmd_pipeline_barrier2(self.buffer, &info) };
        image.state = next;
    }

    /// Copies the upper left `extent` of a colour image, prepared as [`Usage::CopySource`], for the host to read after
    /// [`Self::wait`]. Rows are tightly packed.
    pub(super) fn copy_to_host(&self, image: &Image, buffer: &Buffer, extent: vk::Extent2D) {
        let region = copy_region(extent, 0);
        // SAFETY: recording; `extent` lies in the image and the buffer is large enough (VUID-vkCmdCopyImageToBuffer-
        // imageSubresource-07971, -pRegions-00183), as `readback` ensures; the layout is the tracked one.
        unsafe {
            self.raw().cmd_copy_image_to_buffer(self.buffer, image.get(), image.state.layout, buffer.get(), &[region]);
        }
        self.show_host(buffer, (vk::PipelineStageFlags2::COPY, vk::AccessFlags2::TRANSFER_WRITE));
    }

    /// Makes a stage's writes to a buffer visible to the host.
    fn show_host(&self, buffer: &Buffer, (stage, access): (vk::PipelineStageFlags2, vk::AccessFlags2)) {
        let barriers = [vk::BufferMemoryBarrier2::default()
            .src_stage_mask(stage)
            .src_access_mask(access)
            .dst_stage_mask(vk::PipelineStageFlags2::HOST)
            .dst_access_mask(vk::AccessFlags2::HOST_READ)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .buffer(buffer.get())
            .size(vk::WHOLE_SIZE)];
        let info = vk::DependencyInfo::default().buffer_memory_barriers(&barriers);
        // SAFETY: recording outside of rendering.
        unsafe { self.raw().cmd_pipeline_barrier2(self.buffer, &info) };
    }

    /// Dispatches a compute shader whose set matches its layout; the host can read `output` after [`Self::wait`].
    pub(super) fn compute(&self, work: &Compute, output: &Buffer) {
        let (raw, layout) = (self.raw(), work.layout.get());
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: recording; a compute pipeline (VUID-vkCmdBindPipeline-pipelineBindPoint-00780).
        unsafe { raw.cmd_bind_pipeline(self.buffer, point, work.pipeline.get()) };
        // SAFETY: recording; the set was allocated for set 0 of the layout
        // (VUID-vkCmdBindDescriptorSets-pDescriptorSets-00358).
        unsafe { raw.cmd_bind_descriptor_sets(self.buffer, point, layout, 0, &[work.set], &[]) };
        // SAFETY: recording; as long as the layout's range and for its stage (VUID-vkCmdPushConstants-offset-01795,
        // -01796, -size-00369).
        unsafe { raw.cmd_push_constants(self.buffer, layout, vk::ShaderStageFlags::COMPUTE, 0, work.push) };
        let [x, y] = work.groups;
        // SAFETY: pipeline, set and push constants are bound; every device supports 65535 groups per axis, and `remap`
        // requests fewer (VUID-vkCmdDispatch-groupCountX-00386, -groupCountY-00387).
        unsafe { raw.cmd_dispatch(self.buffer, x, y, 1) };
        self.show_host(output, (vk::PipelineStageFlags2::COMPUTE_SHADER, vk::AccessFlags2::SHADER_STORAGE_WRITE));
    }

    /// Fills the levels of an image, prepared as [`Usage::CopyTarget`], each given by (level, extent, offset in the
    /// buffer).
    pub(super) fn copy_from_host(&self, buffer: &Buffer, image: &Image, levels: &[(u32, vk::Extent2D, u64)]) {
        let regions: Vec<_> = levels
            .iter()
            .map(|&(level, extent, offset)| {
                let mut region = copy_region(extent, offset);
                region.image_subresource.mip_level = level;
                region
            })
            .collect();
        let layout = image.state.layout;
        // SAFETY: recording; `textures` lays levels out consecutively, each whole
        // (VUID-vkCmdCopyBufferToImage-imageSubresource-07971, -pRegions-00171), offsets multiples of 4 (-07975).
        unsafe { self.raw().cmd_copy_buffer_to_image(self.buffer, buffer.get(), image.get(), layout, &regions) };
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // The objects used by the commands may be destroyed as soon as this returns.
        if let Err(error) = self.wait() {
            tracing::error!("waiting for the device: {error}");
        }
        if self.is_pending
            && let Err(error) = self.device().wait_idle()
        {
            tracing::error!("the device may still be at work and keeps its memory: {error}");
            self.device().abandon();
        }
    }
}

fn copy_region(extent: vk::Extent2D, offset: u64) -> vk::BufferImageCopy {
    let color = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
    vk::BufferImageCopy::default().buffer_offset(offset).image_subresource(color).image_extent(extent.into())
}
