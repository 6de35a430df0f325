//! Pipelines, their layouts and shaders.
//!
//! In: the entry point, the alpha mode and the textures. Out: pipelines, created on first use.

use super::device::Device;
use super::formats::{COLOR, DATA, DEPTH_FORMAT, TEXTURES_PER_MATERIAL};
use super::owned::Owned;
use crate::raster::{RasterError, RasterVertex};
use ash::vk;
use std::collections::HashMap;
use std::ffi::CStr;
use std::mem::offset_of;
use std::sync::Arc;

mod table {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

/// A graphics pipeline.
pub(super) type Pipeline = Owned<vk::Pipeline>;

/// The outputs of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Stage {
    /// Colour and data in one rendering.
    Both,
    /// Colour only.
    Beauty,
    /// Data only.
    Data,
}

/// The alpha mode; the values are those of `ALPHA` in geometry.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Alpha {
    /// Ignored.
    Opaque = 0,
    /// Alpha test.
    Mask = 1,
    /// Blending.
    Blend = 2,
}

/// The textures of a material; the values are those of `TEXTURES` in geometry.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Textures {
    /// None.
    None = 0,
    /// Base colour only.
    BaseColor = 1,
    /// Any.
    All = 2,
}

/// A variant of the geometry pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    pub(super) stage: Stage,
    pub(super) variant: Variant,
}

/// The shader variant that a material needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    pub(super) alpha: Alpha,
    pub(super) textures: Textures,
    pub(super) is_unlit: bool,
}

impl Key {
    fn shader(self) -> String {
        let Variant { alpha, textures, is_unlit } = self.variant;
        // Data are not shaded.
        let shading = if is_unlit && self.stage != Stage::Data { "unlit" } else { "lit" };
        format!("{}_{}_{}_{shading}", self.entry().to_string_lossy(), alpha as u8, textures as u8)
    }

    fn entry(self) -> &'static CStr {
        match self.stage {
            Stage::Both => c"both",
            Stage::Beauty => c"beauty",
            Stage::Data => c"data",
        }
    }

    /// Returns whether it blends colour over the target without writing depth.
    fn is_over(self) -> bool {
        self.stage == Stage::Beauty && self.variant.alpha == Alpha::Blend
    }
}

/// A pipeline layout with the layouts of its sets.
pub(super) struct PipelineLayout {
    handle: Owned<vk::PipelineLayout>,
    sets: Vec<Owned<vk::DescriptorSetLayout>>,
}

impl PipelineLayout {
    /// The shader stages that read push constants.
    pub(super) const PUSH_STAGES: vk::ShaderStageFlags =
        vk::ShaderStageFlags::from_raw(vk::ShaderStageFlags::VERTEX.as_raw() | vk::ShaderStageFlags::FRAGMENT.as_raw());

    /// Creates a layout from the descriptor sets of the fragment stage and the size of the push constants.
    fn new(
        device: &Arc<Device>,
        name: &str,
        sets: &[&[vk::DescriptorType]],
        push_bytes: u32,
    ) -> Result<Self, RasterError> {
        let layout = |types: &&[vk::DescriptorType]| set_layout(device, name, types, vk::ShaderStageFlags::FRAGMENT);
        let sets = sets.iter().map(layout).collect::<Result<Vec<_>, _>>()?;
        Self::of_sets(device, name, sets, (Self::PUSH_STAGES, push_bytes))
    }

    /// Creates a layout with one descriptor set and push constants for a compute shader.
    pub(super) fn for_compute(
        device: &Arc<Device>,
        name: &str,
        types: &[vk::DescriptorType],
        push_bytes: u32,
    ) -> Result<Self, RasterError> {
        let stage = vk::ShaderStageFlags::COMPUTE;
        Self::of_sets(device, name, vec![set_layout(device, name, types, stage)?], (stage, push_bytes))
    }

    fn of_sets(
        device: &Arc<Device>,
        name: &str,
        sets: Vec<Owned<vk::DescriptorSetLayout>>,
        (push_stages, push_bytes): (vk::ShaderStageFlags, u32),
    ) -> Result<Self, RasterError> {
        let handles: Vec<_> = sets.iter().map(Owned::get).collect();
        let ranges = [vk::PushConstantRange::default().stage_flags(push_stages).size(push_bytes)];
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&handles).push_constant_ranges(&ranges);
        let handle = Owned::new(device, ("vkCreatePipelineLayout", name), |raw| {
            // SAFETY: at most 4 sets, at most 128 bytes (VUID-VkPipelineLayoutCreateInfo-setLayoutCount-00286,
            // VUID-VkPushConstantRange-size-00298).
            unsafe { raw.create_pipeline_layout(&info, None) }
        })?;
        Ok(Self { handle, sets })
    }

    pub(super) fn get(&self) -> vk::PipelineLayout {
        self.handle.get()
    }

    pub(super) fn set(&self, index: usize) -> vk::DescriptorSetLayout {
        self.sets[index].get()
    }
}

fn set_layout(
    device: &Arc<Device>,
    name: &str,
    types: &[vk::DescriptorType],
    stage: vk::ShaderStageFlags,
) -> Result<Owned<vk::DescriptorSetLayout>, RasterError> {
    let bindings: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, &kind)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(stage)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    Owned::new(device, ("vkCreateDescriptorSetLayout", name), |raw| {
        // SAFETY: binding numbers differ (VUID-VkDescriptorSetLayoutCreateInfo-binding-00279).
        unsafe { raw.create_descriptor_set_layout(&info, None) }
    })
}

/// Bytes of `Push` in geometry.wgsl.
pub(super) const PUSH_BYTES: u32 = 16;

/// All pipelines of a device.
pub(super) struct Pipelines {
    geometry: HashMap<Key, Pipeline>,
    resolve: Option<Pipeline>,
    /// Set 0: the pass (a buffer); set 1: textures, samplers and parameters of a material.
    pub(super) geometry_layout: PipelineLayout,
    /// Set 0: the colour of a sample pass.
    pub(super) resolve_layout: PipelineLayout,
    device: Arc<Device>,
}

impl Pipelines {
    pub(super) fn new(device: &Arc<Device>) -> Result<Self, RasterError> {
        let pass = [vk::DescriptorType::STORAGE_BUFFER];
        let images = [vk::DescriptorType::SAMPLED_IMAGE; TEXTURES_PER_MATERIAL];
        let samplers = [vk::DescriptorType::SAMPLER; TEXTURES_PER_MATERIAL];
        let material = [&images[..], &samplers, &[vk::DescriptorType::UNIFORM_BUFFER]].concat();
        Ok(Self {
            geometry: HashMap::new(),
            resolve: None,
            geometry_layout: PipelineLayout::new(device, "geometry", &[&pass, &material], PUSH_BYTES)?,
            resolve_layout: PipelineLayout::new(device, "resolve", &[&images[..1]], 4)?,
            device: Arc::clone(device),
        })
    }

    /// Creates the geometry pipeline if needed.
    pub(super) fn prepare(&mut self, key: Key) -> Result<(), RasterError> {
        if !self.geometry.contains_key(&key) {
            self.geometry.insert(key, geometry_pipeline(&self.device, &self.geometry_layout, key)?);
        }
        Ok(())
    }

    /// Returns a prepared geometry pipeline.
    pub(super) fn geometry(&self, key: Key) -> Result<&Pipeline, RasterError> {
        self.geometry.get(&key).ok_or(RasterError::Misuse("a pipeline was not prepared"))
    }

    /// Creates the pipeline that adds a sample pass to the mean, if needed.
    pub(super) fn prepare_resolve(&mut self) -> Result<(), RasterError> {
        if self.resolve.is_none() {
            self.resolve = Some(resolve_pipeline(&self.device, &self.resolve_layout)?);
        }
        Ok(())
    }

    /// Returns that pipeline with its layout.
    pub(super) fn resolve(&self) -> Result<(&Pipeline, &PipelineLayout), RasterError> {
        let pipeline = self.resolve.as_ref().ok_or(RasterError::Misuse("a pipeline was not prepared"))?;
        Ok((pipeline, &self.resolve_layout))
    }
}

/// Returns the compiled shader of that name, an entry of build.rs.
pub(super) fn shader(device: &Arc<Device>, name: &str) -> Result<Owned<vk::ShaderModule>, RasterError> {
    let found = table::SHADERS.iter().find(|(known, _)| *known == name);
    let (_, bytes) = found.ok_or(RasterError::Misuse("a shader variant was not compiled"))?;
    let words: Vec<u32> =
        bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect();
    let info = vk::ShaderModuleCreateInfo::default().code(&words);
    Owned::new(device, ("vkCreateShaderModule", name), |raw| {
        // SAFETY: naga validated the module (VUID-VkShaderModuleCreateInfo-pCode-08737).
        unsafe { raw.create_shader_module(&info, None) }
    })
}

fn geometry_pipeline(device: &Arc<Device>, layout: &PipelineLayout, key: Key) -> Result<Pipeline, RasterError> {
    let formats = match key.stage {
        Stage::Both => [&[COLOR.format][..], &DATA.map(|spec| spec.format)].concat(),
        Stage::Beauty => vec![COLOR.format],
        Stage::Data => DATA.map(|spec| spec.format).to_vec(),
    };
    let name = key.shader();
    // Colour is associated: over = source + (1 - alpha) · destination.
    let blend = key.is_over().then_some(vk::BlendFactor::ONE_MINUS_SRC_ALPHA);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(!key.is_over())
        // Reversed z: larger is nearer.
        .depth_compare_op(vk::CompareOp::GREATER);
    let (bindings, attributes) = vertex_layout();
    let vertices = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    PipelineDescription {
        name: &name,
        shaders: [("vertex", c"vertex"), (&name, key.entry())],
        vertices,
        depth: Some(depth),
        formats: &formats,
        blend,
        dynamic: &[
            vk::DynamicState::VIEWPORT,
            vk::DynamicState::SCISSOR,
            vk::DynamicState::CULL_MODE,
            vk::DynamicState::FRONT_FACE,
        ],
    }
    .build(device, layout)
}

fn resolve_pipeline(device: &Arc<Device>, layout: &PipelineLayout) -> Result<Pipeline, RasterError> {
    PipelineDescription {
        name: "resolve",
        shaders: [("resolve_vertex", c"vertex"), ("resolve", c"resolve")],
        vertices: vk::PipelineVertexInputStateCreateInfo::default(),
        depth: None,
        formats: &[COLOR.format],
        blend: Some(vk::BlendFactor::ONE),
        dynamic: &[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR],
    }
    .build(device, layout)
}

/// The parameters that differ between pipelines.
struct PipelineDescription<'a> {
    name: &'a str,
    /// Vertex and fragment stage: name in the table, entry point.
    shaders: [(&'a str, &'static CStr); 2],
    vertices: vk::PipelineVertexInputStateCreateInfo<'a>,
    /// `None` without a depth attachment.
    depth: Option<vk::PipelineDepthStencilStateCreateInfo<'a>>,
    formats: &'a [vk::Format],
    /// Factor of the destination; `None`: it is replaced.
    blend: Option<vk::BlendFactor>,
    dynamic: &'a [vk::DynamicState],
}

impl PipelineDescription<'_> {
    fn build(&self, device: &Arc<Device>, layout: &PipelineLayout) -> Result<Pipeline, RasterError> {
        let [(vertex, vertex_entry), (fragment, fragment_entry)] = self.shaders;
        let (vertex, fragment) = (shader(device, vertex)?, shader(device, fragment)?);
        let stage = |module: &Owned<vk::ShaderModule>, stage, entry| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module.get()).name(entry)
        };
        let stages = [
            stage(&vertex, vk::ShaderStageFlags::VERTEX, vertex_entry),
            stage(&fragment, vk::ShaderStageFlags::FRAGMENT, fragment_entry),
        ];
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let blends = vec![blend_state(self.blend); self.formats.len()];
        let blending = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(self.dynamic);
        let depth = self.depth.unwrap_or_default();
        let depth_format = self.depth.map_or(vk::Format::UNDEFINED, |_| DEPTH_FORMAT);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(self.formats)
            .depth_attachment_format(depth_format);
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&self.vertices)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blending)
            .dynamic_state(&dynamic)
            .layout(layout.get())
            .push_next(&mut rendering);
        create_pipeline(device, self.name, &info)
    }
}

fn create_pipeline(
    device: &Arc<Device>,
    name: &str,
    info: &vk::GraphicsPipelineCreateInfo,
) -> Result<Pipeline, RasterError> {
    Owned::new(device, ("vkCreateGraphicsPipelines", name), |raw| {
        // SAFETY: shaders, layout and vertex attributes agree (VUID-VkGraphicsPipelineCreateInfo-layout-07988, -Input-
        // 07904); the formats were checked in `choose` (-renderingInfo-06582, -06585; blending: -06062).
        let made =
            unsafe { raw.create_graphics_pipelines(vk::PipelineCache::null(), std::slice::from_ref(info), None) };
        // Only one pipeline was requested, so on failure there is none to destroy.
        made.map(|pipelines| pipelines[0]).map_err(|(_, result)| result)
    })
}

fn blend_state(factor: Option<vk::BlendFactor>) -> vk::PipelineColorBlendAttachmentState {
    let state = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
    let Some(factor) = factor else { return state };
    state
        .blend_enable(true)
        .src_color_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(factor)
        .src_alpha_blend_factor(vk::BlendFactor::ONE)
        .dst_alpha_blend_factor(factor)
}

/// Returns the vertex layout. Binding 0: [`RasterVertex`] at the locations of `VertexIn` (`position` and `depth` form
/// one vector); binding 1: the position in clip space.
fn vertex_layout() -> ([vk::VertexInputBindingDescription; 2], [vk::VertexInputAttributeDescription; 9]) {
    let (three, four) = (vk::Format::R32G32B32_SFLOAT, vk::Format::R32G32B32A32_SFLOAT);
    let fields = [
        (0, offset_of!(RasterVertex, screen), four),
        (0, offset_of!(RasterVertex, position), four),
        (0, offset_of!(RasterVertex, normal), three),
        (0, offset_of!(RasterVertex, next), three),
        (0, offset_of!(RasterVertex, previous), three),
        (0, offset_of!(RasterVertex, tangent), four),
        (0, offset_of!(RasterVertex, uv), four),
        (0, offset_of!(RasterVertex, color), four),
        (1, 0, four),
    ];
    let mut location = 0;
    let attributes = fields.map(|(binding, offset, format)| {
        location += 1;
        vk::VertexInputAttributeDescription::default()
            .binding(binding)
            .location(location - 1)
            .format(format)
            .offset(offset as u32)
    });
    let binding =
        |number: u32, stride: usize| vk::VertexInputBindingDescription::default().binding(number).stride(stride as u32);
    ([binding(0, size_of::<RasterVertex>()), binding(1, size_of::<[f32; 4]>())], attributes)
}
