//! Handles that are destroyed when dropped.
//!
//! In: a device and a created handle. Out: an [`Owned`] handle, which keeps its device alive and is destroyed before
//! it.

use super::device::Device;
use super::fault::vulkan_error;
use crate::raster::RasterError;
use ash::vk;
use std::sync::Arc;

/// A handle that can be destroyed by its device.
pub(super) trait Destroy: vk::Handle + Copy {
    /// Destroys the handle.
    ///
    /// # Safety
    /// The handle was created by `device`, is no longer in use, and is destroyed once.
    unsafe fn destroy(self, device: &ash::Device);
}

macro_rules! destroy {
    ($($handle:ty => $call:ident),* $(,)?) => {$(
        impl Destroy for $handle {
            unsafe fn destroy(self, device: &ash::Device) {
                // SAFETY: the caller's promise.
                unsafe { device.$call(self, None) };
            }
        }
    )*};
}

destroy! {
    vk::Buffer => destroy_buffer,
    vk::Image => destroy_image,
    vk::ImageView => destroy_image_view,
    vk::Sampler => destroy_sampler,
    vk::Fence => destroy_fence,
    vk::CommandPool => destroy_command_pool,
    vk::DescriptorPool => destroy_descriptor_pool,
    vk::DescriptorSetLayout => destroy_descriptor_set_layout,
    vk::PipelineLayout => destroy_pipeline_layout,
    vk::Pipeline => destroy_pipeline,
    vk::ShaderModule => destroy_shader_module,
}

/// A handle with its device. Recorded handles must be kept until the commands complete: [`super::VulkanRaster`] drops
/// its `Commands`, which wait, before everything that they refer to.
pub(super) struct Owned<H: Destroy> {
    handle: H,
    device: Arc<Device>,
}

impl<H: Destroy> Owned<H> {
    /// Creates and names an object. `make` must return a new handle of this device.
    pub(super) fn new(
        device: &Arc<Device>,
        (call, name): (&'static str, &str),
        make: impl FnOnce(&ash::Device) -> Result<H, vk::Result>,
    ) -> Result<Self, RasterError> {
        let handle = make(device.raw()).map_err(vulkan_error(call))?;
        device.set_name(handle, name);
        Ok(Self { handle, device: Arc::clone(device) })
    }

    /// Returns the raw handle.
    pub(super) fn get(&self) -> H {
        self.handle
    }

    pub(super) fn device(&self) -> &Arc<Device> {
        &self.device
    }
}

impl<H: Destroy> Drop for Owned<H> {
    fn drop(&mut self) {
        if self.device.is_abandoned() {
            return;
        }
        // SAFETY: created by this device in `new`, destroyed only here; not in use, see the type.
        unsafe { self.handle.destroy(self.device.raw()) };
    }
}
