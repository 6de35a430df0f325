//! Materials prepared for shading.
//!
//! In: a [`Scene`]. Out: [`Materials`]: factors, samplers and the mip chains of every image in use.

use super::texture::{Footprint, MipChain, Sampler};
use crate::scene::{AlphaMode, Material, Scene, TextureRef};
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

/// All materials of a scene and their images.
#[derive(Debug)]
pub(super) struct Materials {
    list: Vec<Prepared>,
    images: Vec<MipChain>,
}

/// A material with resolved samplers.
#[derive(Debug)]
pub(super) struct Prepared {
    /// Factors.
    pub(super) factors: Material,
    base_color: Option<Sampler>,
    metallic_roughness: Option<Sampler>,
    normal: Option<Sampler>,
    occlusion: Option<Sampler>,
    emissive: Option<Sampler>,
}

impl Prepared {
    fn of(material: &Material, scene: &Scene) -> Self {
        let sampler = |reference: &Option<TextureRef>| Sampler::of(reference.as_ref()?, &scene.textures);
        Self {
            base_color: sampler(&material.base_color_texture),
            metallic_roughness: sampler(&material.metallic_roughness_texture),
            normal: sampler(&material.normal_texture),
            occlusion: sampler(&material.occlusion_texture),
            emissive: sampler(&material.emissive_texture),
            factors: material.clone(),
        }
    }

    /// Prepares only what determines alpha.
    fn of_alpha(material: &Material, scene: &Scene) -> Self {
        let is_opaque = material.alpha == AlphaMode::Opaque;
        let base_color_texture = if is_opaque { None } else { material.base_color_texture };
        let factors = Material {
            base_color: material.base_color,
            base_color_texture,
            alpha: material.alpha,
            double_sided: material.double_sided,
            unlit: true,
            ..Material::default()
        };
        Self::of(&factors, scene)
    }

    fn samplers(&self) -> impl Iterator<Item = &Sampler> {
        [&self.base_color, &self.metallic_roughness, &self.normal, &self.occlusion, &self.emissive]
            .into_iter()
            .flatten()
    }

    /// Returns whether any texture is sampled, so that UVs are needed.
    pub(super) fn has_textures(&self) -> bool {
        self.samplers().next().is_some()
    }

    /// Returns whether a normal map is sampled, so that tangents are needed.
    pub(super) fn has_normal_map(&self) -> bool {
        self.normal.is_some()
    }

    pub(super) fn is_blended(&self) -> bool {
        self.factors.alpha == AlphaMode::Blend
    }

    /// Returns the minimum alpha that is drawn, for masked materials.
    pub(super) fn cutoff(&self) -> Option<f32> {
        match self.factors.alpha {
            AlphaMode::Mask { cutoff } => Some(cutoff),
            AlphaMode::Opaque | AlphaMode::Blend => None,
        }
    }
}

impl Materials {
    pub(super) fn of(scene: &Scene) -> Self {
        Self::with(scene, scene.materials.iter().map(|material| Prepared::of(material, scene)).collect())
    }

    /// Prepares only what determines alpha.
    pub(super) fn of_alpha(scene: &Scene) -> Self {
        Self::with(scene, scene.materials.iter().map(|material| Prepared::of_alpha(material, scene)).collect())
    }

    fn with(scene: &Scene, mut list: Vec<Prepared>) -> Self {
        if list.is_empty() {
            list.push(Prepared::of(&Material::default(), scene));
        }
        let is_used = |index| list.iter().flat_map(Prepared::samplers).any(|sampler| sampler.image == index);
        let blank = crate::scene::Image::default();
        let used: Vec<_> =
            scene.images.iter().enumerate().map(|(index, image)| if is_used(index) { image } else { &blank }).collect();
        Self { images: used.into_par_iter().map(MipChain::of).collect(), list }
    }

    /// Returns the material at an index, or the first.
    pub(super) fn get(&self, index: u32) -> &Prepared {
        self.list.get(index as usize).unwrap_or(&self.list[0])
    }

    /// Returns linear base colour and alpha, vertex colour included.
    pub(super) fn base_color(&self, material: &Prepared, uv: &[Footprint; 2], vertex_color: Vec4) -> Vec4 {
        material.factors.base_color * vertex_color * self.sample(&material.base_color, uv)
    }

    /// Returns metallic and roughness.
    pub(super) fn metallic_roughness(&self, material: &Prepared, uv: &[Footprint; 2]) -> (f32, f32) {
        let texel = self.sample(&material.metallic_roughness, uv);
        (material.factors.metallic * texel.z, material.factors.roughness * texel.y)
    }

    /// Returns the normal map's vector in tangent space.
    pub(super) fn mapped_normal(&self, material: &Prepared, uv: &[Footprint; 2]) -> Vec3 {
        if !material.has_normal_map() {
            return Vec3::Z;
        }
        super::shading::normal_from_texel(self.sample(&material.normal, uv).xyz(), material.factors.normal_scale)
    }

    /// Returns the ambient occlusion: 1 open, 0 occluded.
    pub(super) fn occlusion(&self, material: &Prepared, uv: &[Footprint; 2]) -> f32 {
        let texel = self.sample(&material.occlusion, uv).x;
        super::shading::occlusion_from_texel(texel, material.factors.occlusion_strength)
    }

    /// Returns the emitted linear radiance.
    pub(super) fn emissive(&self, material: &Prepared, uv: &[Footprint; 2]) -> Vec3 {
        if material.factors.emissive == Vec3::ZERO {
            return Vec3::ZERO;
        }
        material.factors.emissive * self.sample(&material.emissive, uv).xyz()
    }

    fn sample(&self, sampler: &Option<Sampler>, uv: &[Footprint; 2]) -> Vec4 {
        sampler.as_ref().map_or(Vec4::ONE, |sampler| sampler.sample(&self.images, uv))
    }
}
