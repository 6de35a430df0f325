//! Descriptor sets: the buffers and textures that shaders read.
//!
//! In: layouts, buffers, images, samplers. Out: sets from a pool that owns them.

use super::device::Device;
use super::fault::vulkan_error;
use super::formats::TEXTURES_PER_MATERIAL;
use super::memory::Buffer;
use super::owned::Owned;
use crate::raster::RasterError;
use ash::vk;
use std::sync::Arc;

/// A pool with space for a scene's sets, which are freed with it.
pub(super) struct Descriptors {
    pool: Owned<vk::DescriptorPool>,
}

/// A part of a buffer: offset and size in bytes.
pub(super) type BufferPart<'a> = (&'a Buffer, u64, u64);

impl Descriptors {
    /// Creates a pool for `materials` sets of textures and a buffer, `passes` sets of one buffer, and one image set.
    pub(super) fn new(device: &Arc<Device>, materials: usize, passes: usize) -> Result<Self, RasterError> {
        let count = |each: usize| u32::try_from(each).unwrap_or(u32::MAX);
        let size = |kind, each| vk::DescriptorPoolSize { ty: kind, descriptor_count: count(each) };
        let sizes = [
            size(vk::DescriptorType::STORAGE_BUFFER, passes),
            size(vk::DescriptorType::UNIFORM_BUFFER, materials + 1),
            size(vk::DescriptorType::SAMPLED_IMAGE, materials * TEXTURES_PER_MATERIAL + 1),
            size(vk::DescriptorType::SAMPLER, materials * TEXTURES_PER_MATERIAL + 1),
        ];
        Self::with_sizes(device, count(materials + passes + 1), &sizes)
    }

    /// Creates a pool for one set of storage buffers.
    pub(super) fn for_buffers(device: &Arc<Device>, buffers: u32) -> Result<Self, RasterError> {
        let size = vk::DescriptorPoolSize { ty: vk::DescriptorType::STORAGE_BUFFER, descriptor_count: buffers };
        Self::with_sizes(device, 1, &[size])
    }

    fn with_sizes(device: &Arc<Device>, sets: u32, sizes: &[vk::DescriptorPoolSize]) -> Result<Self, RasterError> {
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(sets).pool_sizes(sizes);
        let pool = Owned::new(device, ("vkCreateDescriptorPool", "sets"), |raw| {
            // SAFETY: all counts > 0 (VUID-VkDescriptorPoolCreateInfo-descriptorPoolOverallocation-09227,
            // VUID-VkDescriptorPoolSize-descriptorCount-00302).
            unsafe { raw.create_descriptor_pool(&info, None) }
        })?;
        Ok(Self { pool })
    }

    /// Allocates an empty set; the pool is large enough.
    pub(super) fn set(&self, layout: vk::DescriptorSetLayout, name: &str) -> Result<vk::DescriptorSet, RasterError> {
        let device = self.pool.device();
        let layouts = [layout];
        let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.pool.get()).set_layouts(&layouts);
        // SAFETY: the pool is alive and used by one thread at a time.
        let sets = unsafe { device.raw().allocate_descriptor_sets(&info) };
        let sets = sets.map_err(vulkan_error("vkAllocateDescriptorSets"))?;
        let set = sets.first().copied().ok_or(RasterError::Misuse("no descriptor set was made"))?;
        device.set_name(set, name);
        Ok(set)
    }

    /// Binds a part of a buffer (offset and size in bytes). No submitted commands may use the set.
    pub(super) fn write_buffer(
        &self,
        (set, binding): (vk::DescriptorSet, u32),
        kind: vk::DescriptorType,
        (buffer, offset, range): BufferPart,
    ) {
        let info = [vk::DescriptorBufferInfo::default().buffer(buffer.get()).offset(offset).range(range)];
        let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(binding).descriptor_type(kind);
        self.update(&[write.buffer_info(&info)]);
    }

    /// Binds images from binding 0 on, then their samplers. No submitted commands may use the set.
    pub(super) fn write_images(&self, set: vk::DescriptorSet, images: &[vk::ImageView], samplers: &[vk::Sampler]) {
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let images: Vec<_> = images
            .iter()
            .map(|&view| vk::DescriptorImageInfo::default().image_view(view).image_layout(layout))
            .collect();
        let samplers: Vec<_> =
            samplers.iter().map(|&sampler| vk::DescriptorImageInfo::default().sampler(sampler)).collect();
        let kinds = [(vk::DescriptorType::SAMPLED_IMAGE, &images), (vk::DescriptorType::SAMPLER, &samplers)];
        let infos = kinds.iter().flat_map(|(kind, infos)| infos.iter().map(move |info| (*kind, info)));
        let writes: Vec<_> = (0..)
            .zip(infos)
            .map(|(binding, (kind, info))| {
                vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(binding)
                    .descriptor_type(kind)
                    .image_info(std::slice::from_ref(info))
            })
            .collect();
        self.update(&writes);
    }

    fn update(&self, writes: &[vk::WriteDescriptorSet]) {
        // SAFETY: the sets are from this pool, not in use (VUID-vkUpdateDescriptorSets-None-03047), the bindings match
        // their layouts; the resources outlive the commands that read them.
        unsafe { self.pool.device().raw().update_descriptor_sets(writes, &[]) };
    }
}
