//! A scene's textures on the device.
//!
//! In: decoded images, sampler settings. Out: images with all mip levels (the chains of the CPU rasteriser, averaged in
//! linear light; colour in sRGB formats, which the device decodes before filtering) and samplers.

use super::commands::{Commands, Contents, Usage};
use super::device::Device;
use super::memory::{Buffer, BufferUse, Image, ImageUse, MemoryLocation, Placement};
use super::owned::Owned;
use crate::raster::RasterError;
use crate::raster::cpu::mipmap::{Level, mip_chain};
use crate::scene::{self, Filter, Wrap};
use ash::vk;
use std::sync::Arc;

const STAGING: BufferUse =
    BufferUse { name: "texture upload", usage: vk::BufferUsageFlags::TRANSFER_SRC, location: MemoryLocation::CpuToGpu };

/// Maximum number of taps along the long axis of a footprint, as in the CPU rasteriser.
const MAX_ANISOTROPY: f32 = 16.0;

/// Returns a single white texel.
fn white() -> scene::Image {
    scene::Image { width: 1, height: 1, rgba: vec![255; 4], is_srgb: false }
}

/// Images and samplers of a scene.
pub(super) struct Textures {
    /// In the order of the scene's images.
    images: Vec<Image>,
    /// In the order of the scene's textures.
    samplers: Vec<Owned<vk::Sampler>>,
    /// Image of each of the scene's textures.
    image_of_texture: Vec<usize>,
    white: Image,
    plain_sampler: Owned<vk::Sampler>,
}

impl Textures {
    pub(super) fn new(device: &Arc<Device>, scene: &scene::Scene) -> Result<Self, RasterError> {
        let images = scene.images.iter().map(|image| upload_image(device, image));
        let images = images.collect::<Result<Vec<_>, _>>()?;
        let samplers = scene.textures.iter().map(|texture| sampler(device, texture)).collect::<Result<Vec<_>, _>>()?;
        let plain = scene::Texture {
            image: 0,
            wrap: [Wrap::Clamp; 2],
            magnify: Filter::Nearest,
            minify: Filter::Nearest,
            mipmap: None,
        };
        Ok(Self {
            images,
            samplers,
            image_of_texture: scene.textures.iter().map(|texture| texture.image).collect(),
            white: upload_image(device, &white())?,
            plain_sampler: sampler(device, &plain)?,
        })
    }

    /// Returns view and sampler of a scene's texture; white if there is none.
    pub(super) fn get(&self, texture: Option<usize>) -> (vk::ImageView, vk::Sampler) {
        let found = texture.and_then(|texture| {
            let image = self.images.get(*self.image_of_texture.get(texture)?)?;
            Some((image.view(), self.samplers.get(texture)?.get()))
        });
        found.unwrap_or((self.white.view(), self.plain_sampler.get()))
    }
}

/// Creates an image with its levels and waits until it is uploaded.
fn upload_image(device: &Arc<Device>, image: &scene::Image) -> Result<Image, RasterError> {
    let limit = device.facts().max_texture_side;
    // Levels larger than the device's limit are skipped.
    let levels: Vec<Level> =
        mip_chain(image).into_iter().skip_while(|level| level.width.max(level.height) > limit).collect();
    let first = levels.first().ok_or(RasterError::Misuse("an image has no levels"))?;
    let wanted = ImageUse {
        name: "texture",
        format: if image.is_srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM },
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
        mip_levels: levels.len() as u32,
        placement: Placement::Device,
    };
    let mut on_device = Image::new(device, wanted, vk::Extent2D { width: first.width, height: first.height })?;
    let bytes: usize = levels.iter().map(|level| level.texels.len() * 4).sum();
    let mut staging = Buffer::new(device, STAGING, bytes as u64)?;
    let regions = fill(&mut staging, &levels);
    // Declared last, so dropped first: image and buffer live until the copy is done, whatever fails.
    let mut commands = Commands::new(device, "texture upload")?;
    commands.begin()?;
    commands.prepare(&mut on_device, Usage::CopyTarget, Contents::Discard);
    commands.copy_from_host(&staging, &on_device, &regions);
    commands.prepare(&mut on_device, Usage::Sampled, Contents::Keep);
    commands.submit()?;
    commands.wait()?;
    Ok(on_device)
}

/// Writes levels consecutively; returns their level number, extent and offset.
fn fill(staging: &mut Buffer, levels: &[Level]) -> Vec<(u32, vk::Extent2D, u64)> {
    let mut offset = 0;
    let place = |(index, level): (u32, &Level)| {
        let texels: &[u8] = bytemuck::cast_slice(&level.texels);
        staging.bytes_mut()[offset..offset + texels.len()].copy_from_slice(texels);
        let region = (index, vk::Extent2D { width: level.width, height: level.height }, offset as u64);
        offset += texels.len();
        region
    };
    (0u32..).zip(levels).map(place).collect()
}

fn sampler(device: &Arc<Device>, texture: &scene::Texture) -> Result<Owned<vk::Sampler>, RasterError> {
    let filter = |filter| match filter {
        Filter::Nearest => vk::Filter::NEAREST,
        Filter::Linear => vk::Filter::LINEAR,
    };
    let wrap = |wrap| match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    // Without mipmapping, a maximum level of 0.25 still distinguishes minification from magnification, and rounds to
    // level 0 (Vulkan specification, VkSamplerCreateInfo, on OpenGL's filters).
    let (between, max_lod) = match texture.mipmap {
        None => (vk::SamplerMipmapMode::NEAREST, 0.25),
        Some(Filter::Nearest) => (vk::SamplerMipmapMode::NEAREST, vk::LOD_CLAMP_NONE),
        Some(Filter::Linear) => (vk::SamplerMipmapMode::LINEAR, vk::LOD_CLAMP_NONE),
    };
    let is_smooth = texture.mipmap.is_some() && [texture.magnify, texture.minify] == [Filter::Linear; 2];
    let anisotropy = device.facts().max_anisotropy.filter(|_| is_smooth).map(|most| most.min(MAX_ANISOTROPY));
    let info = vk::SamplerCreateInfo::default()
        .mag_filter(filter(texture.magnify))
        .min_filter(filter(texture.minify))
        .mipmap_mode(between)
        .max_lod(max_lod)
        .address_mode_u(wrap(texture.wrap[0]))
        .address_mode_v(wrap(texture.wrap[1]))
        .anisotropy_enable(anisotropy.is_some())
        .max_anisotropy(anisotropy.unwrap_or(1.0));
    Owned::new(device, ("vkCreateSampler", "sampler"), |raw| {
        // SAFETY: anisotropy is enabled only if the feature is (VUID-VkSamplerCreateInfo-anisotropyEnable-01070).
        unsafe { raw.create_sampler(&info, None) }
    })
}
