//! A scene's materials on the device.
//!
//! In: materials, textures. Out: per material a set of textures and parameters, and its drawing state.

use super::descriptors::{BufferPart, Descriptors};
use super::device::Device;
use super::formats::TEXTURES_PER_MATERIAL;
use super::memory::{Buffer, BufferUse, MemoryLocation};
use super::pipeline::{Alpha, PipelineLayout, Textures as TextureVariant, Variant};
use super::textures::Textures;
use crate::raster::RasterError;
use crate::scene::{AlphaMode, Material, Scene, TextureRef};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

const MATERIALS: BufferUse =
    BufferUse { name: "materials", usage: vk::BufferUsageFlags::UNIFORM_BUFFER, location: MemoryLocation::CpuToGpu };

/// Binding of the parameters, after textures and samplers.
const NUMBERS_BINDING: u32 = 2 * TEXTURES_PER_MATERIAL as u32;

/// `TexturePlace` of geometry.wgsl.
#[derive(Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
struct GpuPlace {
    row_u: [f32; 4],
    row_v: [f32; 4],
}

/// `Material` of geometry.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct GpuMaterial {
    base_color: [f32; 4],
    emissive: [f32; 3],
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    cutoff: f32,
    padding: [u32; 8],
    places: [GpuPlace; 5],
}

const _: () = assert!(size_of::<GpuMaterial>() == 240);

/// The drawing state of a material.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaterialState {
    pub(super) variant: Variant,
    pub(super) is_double_sided: bool,
    /// Its descriptor set.
    pub(super) set: vk::DescriptorSet,
}

/// All materials of a scene. Owns the textures and the buffer that the sets refer to.
pub(super) struct Materials {
    states: Vec<MaterialState>,
    _buffer: Buffer,
    _textures: Textures,
}

impl Materials {
    pub(super) fn new(
        device: &Arc<Device>,
        scene: &Scene,
        descriptors: &Descriptors,
        layout: &PipelineLayout,
    ) -> Result<Self, RasterError> {
        let textures = Textures::new(device, scene)?;
        let stride = (size_of::<GpuMaterial>() as u64).next_multiple_of(device.facts().offset_alignment.max(1));
        // A buffer must not be empty.
        let mut buffer = Buffer::new(device, MATERIALS, stride * scene.materials.len().max(1) as u64)?;
        let places = buffer.bytes_mut().chunks_mut(stride as usize);
        for (place, material) in places.zip(&scene.materials) {
            place[..size_of::<GpuMaterial>()].copy_from_slice(bytemuck::bytes_of(&numbers(material)));
        }
        let part = |at: u64| (&buffer, at * stride, size_of::<GpuMaterial>() as u64);
        let state = |(at, material)| state(material, &textures, part(at), (descriptors, layout));
        let states = (0..).zip(&scene.materials).map(state).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { states, _buffer: buffer, _textures: textures })
    }

    /// Returns the state of the material at an index.
    pub(super) fn state(&self, material: u32) -> Result<&MaterialState, RasterError> {
        self.states.get(material as usize).ok_or(RasterError::Misuse("a draw names a material that the scene lacks"))
    }
}

/// Returns the textures in the order of the bindings of geometry.wgsl.
fn references(material: &Material) -> [Option<&TextureRef>; 5] {
    [
        material.base_color_texture.as_ref(),
        material.metallic_roughness_texture.as_ref(),
        material.normal_texture.as_ref(),
        material.occlusion_texture.as_ref(),
        material.emissive_texture.as_ref(),
    ]
}

fn numbers(material: &Material) -> GpuMaterial {
    GpuMaterial {
        base_color: material.base_color.to_array(),
        emissive: material.emissive.to_array(),
        metallic: material.metallic,
        roughness: material.roughness,
        normal_scale: material.normal_scale,
        occlusion_strength: material.occlusion_strength,
        cutoff: match material.alpha {
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Opaque | AlphaMode::Blend => 0.0,
        },
        padding: [0; 8],
        places: references(material).map(|reference| reference.map_or_else(GpuPlace::default, place)),
    }
}

fn place(reference: &TextureRef) -> GpuPlace {
    let [u, v] = reference.texture_from_uv;
    GpuPlace { row_u: u.extend(reference.uv_set.min(1) as f32).to_array(), row_v: v.extend(1.0).to_array() }
}

fn state(
    material: &Material,
    textures: &Textures,
    numbers: BufferPart,
    (descriptors, layout): (&Descriptors, &PipelineLayout),
) -> Result<MaterialState, RasterError> {
    let found = references(material).map(|reference| textures.get(reference.map(|reference| reference.texture)));
    let set = descriptors.set(layout.set(1), &material.name)?;
    descriptors.write_images(set, &found.map(|(view, _)| view), &found.map(|(_, sampler)| sampler));
    descriptors.write_buffer((set, NUMBERS_BINDING), vk::DescriptorType::UNIFORM_BUFFER, numbers);
    let [base_color, others @ ..] = references(material);
    let textures = match (base_color, others.iter().any(Option::is_some)) {
        (_, true) => TextureVariant::All,
        (Some(_), false) => TextureVariant::BaseColor,
        (None, false) => TextureVariant::None,
    };
    let alpha = match material.alpha {
        AlphaMode::Opaque => Alpha::Opaque,
        AlphaMode::Mask { .. } => Alpha::Mask,
        AlphaMode::Blend => Alpha::Blend,
    };
    let variant = Variant { alpha, textures, is_unlit: material.unlit };
    Ok(MaterialState { variant, is_double_sided: material.double_sided, set })
}
