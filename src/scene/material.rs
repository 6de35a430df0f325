//! Materials, textures and images as plain data.
//!
//! In: nothing; `materials` and `texture` fill these types. Out: what the renderers read.

use glam::{Vec3, Vec4};

/// A metallic-roughness or unlit material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file (may be empty).
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// sRGB texture.
    pub base_color_texture: Option<TextureRef>,
    /// Metallic factor, 0..1.
    pub metallic: f32,
    /// Roughness factor, 0..1.
    pub roughness: f32,
    /// Linear texture: g = roughness, b = metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// Linear texture: r = occlusion.
    pub occlusion_texture: Option<TextureRef>,
    /// Strength of the occlusion, 0..1.
    pub occlusion_strength: f32,
    /// Linear RGB, emissive strength included.
    pub emissive: Vec3,
    /// sRGB texture.
    pub emissive_texture: Option<TextureRef>,
    /// The alpha mode.
    pub alpha: AlphaMode,
    /// Whether both sides of faces are visible.
    pub double_sided: bool,
    /// KHR_materials_unlit: base colour only, no shading.
    pub unlit: bool,
}

impl Default for Material {
    /// glTF's default material: white, fully metallic and rough, opaque.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

/// glTF's alpha modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Alpha test: transparent below the cutoff, opaque from it on.
    Mask {
        /// Threshold.
        cutoff: f32,
    },
    /// Alpha blending, sorted from back to front.
    Blend,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`super::Scene::textures`].
    pub texture: usize,
    /// The UV set, 0 or 1: index into [`super::Primitive::uvs`].
    pub uv_set: usize,
    /// KHR_texture_transform as rows of a 2x3 matrix: u' = `rows[0]`·(u, v, 1), v' = `rows[1]`·(u, v, 1).
    pub texture_from_uv: [Vec3; 2],
}

/// An image with its sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Index into [`super::Scene::images`].
    pub image: usize,
    /// Wrap modes across and down.
    pub(crate) wrap: [Wrap; 2],
    /// Magnification filter.
    pub magnify: Filter,
    /// Minification filter within a mipmap level.
    pub minify: Filter,
    /// Filter between mipmap levels; `None`: only level 0 is used.
    pub mipmap: Option<Filter>,
}

/// Sampler wrap modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrap {
    /// Repeats.
    Repeat,
    /// Repeats, every second copy mirrored.
    Mirror,
    /// Clamps to the edge.
    Clamp,
}

/// Sampler filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// Nearest texel.
    Nearest,
    /// Linear interpolation.
    Linear,
}

/// A decoded image: RGBA8, rows from the top, as stored (colour images are sRGB-encoded).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// RGBA, 4 * width * height bytes.
    pub rgba: Vec<u8>,
    /// Whether it holds colour (base colour, emissive: sRGB-encoded, decode before filtering), not linear data.
    pub is_srgb: bool,
}
