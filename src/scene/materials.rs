//! Reads materials.
//!
//! In: the JSON. Out: metallic-roughness and unlit materials with resolved textures; `materials[i]` is the file's i-th,
//! followed by glTF's default material if a primitive needs it.

use super::file::File;
use super::texture::{self, Textures, Use};
use super::{AlphaMode, Material, SceneError, TextureRef};
use glam::{Vec2, Vec3, Vec4};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::AlphaMode as JsonAlpha;
use gltf::json::validation::Checked;
use gltf::json::{self, texture::Info};
use std::collections::BTreeSet;

/// Name of the extension that transforms texture coordinates.
const TRANSFORM: &str = "KHR_texture_transform";

/// A texture slot of a material before its texture is resolved.
struct Slot {
    one: Use,
    uv_set: usize,
    texture_from_uv: [Vec3; 2],
}

/// The five slots of a material.
struct Slots {
    base_color: Option<Slot>,
    metallic_roughness: Option<Slot>,
    normal: Option<Slot>,
    occlusion: Option<Slot>,
    emissive: Option<Slot>,
}

impl Slots {
    fn all(&self) -> impl Iterator<Item = &Slot> {
        let all = [&self.base_color, &self.metallic_roughness, &self.normal, &self.occlusion, &self.emissive];
        all.into_iter().flatten()
    }
}

/// Reads all materials of the file, with their textures.
pub(super) fn load(file: &File, warnings: &mut Vec<String>) -> Result<(Vec<Material>, Textures), SceneError> {
    let mut slots = Vec::new();
    for (index, material) in file.root.materials.iter().enumerate() {
        slots.push(read_slots(file, material, index, warnings)?);
    }
    let uses: BTreeSet<Use> = slots.iter().flat_map(Slots::all).map(|slot| slot.one).collect();
    let textures = texture::load(file, &uses, warnings)?;
    let materials = file.root.materials.iter().zip(&slots);
    Ok((materials.map(|(material, slots)| resolve(material, slots, &textures)).collect(), textures))
}

fn read_slots(
    file: &File,
    material: &json::Material,
    index: usize,
    warnings: &mut Vec<String>,
) -> Result<Slots, SceneError> {
    let pbr = &material.pbr_metallic_roughness;
    let mut take = |slot: Option<Slot>, kind: &str| -> Result<Option<Slot>, SceneError> {
        let Some(slot) = slot else { return Ok(None) };
        let texture = slot.one.texture;
        if texture >= file.root.textures.len() {
            let what = format!("materials[{index}] names textures[{texture}] ({kind}), which does not exist");
            return Err(file.invalid(what));
        }
        if slot.uv_set > 1 {
            let set = slot.uv_set;
            warnings.push(format!("materials[{index}]: its {kind} texture uses TEXCOORD_{set}, only 0 and 1 are read"));
            return Ok(None);
        }
        Ok(Some(slot))
    };
    let normal = material.normal_texture.as_ref().map(|info| {
        data_slot(info.index.value(), info.tex_coord, info.extensions.as_ref().map(|extensions| &extensions.others))
    });
    let occlusion = material.occlusion_texture.as_ref().map(|info| {
        data_slot(info.index.value(), info.tex_coord, info.extensions.as_ref().map(|extensions| &extensions.others))
    });
    Ok(Slots {
        base_color: take(pbr.base_color_texture.as_ref().map(|info| slot(info, true)), "base colour")?,
        metallic_roughness: take(
            pbr.metallic_roughness_texture.as_ref().map(|info| slot(info, false)),
            "metallic-roughness",
        )?,
        normal: take(normal, "normal")?,
        occlusion: take(occlusion, "occlusion")?,
        emissive: take(material.emissive_texture.as_ref().map(|info| slot(info, true)), "emissive")?,
    })
}

fn slot(info: &Info, is_srgb: bool) -> Slot {
    let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.clone());
    build_slot(Use { texture: info.index.value(), is_srgb }, info.tex_coord, transform)
}

/// Returns the slot of a normal or occlusion texture. The crate types the transform of other slots only; here it remains JSON.
fn data_slot(texture: usize, tex_coord: u32, extensions: Option<&serde_json::Map<String, json::Value>>) -> Slot {
    let transform = extensions.and_then(|others| serde_json::from_value(others.get(TRANSFORM)?.clone()).ok());
    build_slot(Use { texture, is_srgb: false }, tex_coord, transform)
}

fn build_slot(one: Use, tex_coord: u32, transform: Option<TextureTransform>) -> Slot {
    let transform = transform.unwrap_or_default();
    let uv_set = transform.tex_coord.unwrap_or(tex_coord) as usize;
    Slot { one, uv_set, texture_from_uv: texture_from_uv(&transform) }
}

/// Returns the matrix of a transform: scale, then rotation, then offset. The angle is counter-clockwise in the image,
/// whose v points down:
///
/// ```text
/// u' =  cos·sx·u + sin·sy·v + tx
/// v' = −sin·sx·u + cos·sy·v + ty
/// ```
fn texture_from_uv(transform: &TextureTransform) -> [Vec3; 2] {
    let (sin, cos) = transform.rotation.0.sin_cos();
    let scale = Vec2::from(transform.scale.0);
    let offset = Vec2::from(transform.offset.0);
    let rows = [Vec3::new(cos * scale.x, sin * scale.y, offset.x), Vec3::new(-sin * scale.x, cos * scale.y, offset.y)];
    if rows.iter().all(|row| row.is_finite()) { rows } else { [Vec3::X, Vec3::Y] }
}

fn resolve(material: &json::Material, slots: &Slots, textures: &Textures) -> Material {
    let pbr = &material.pbr_metallic_roughness;
    let find = |slot: &Option<Slot>| {
        let slot = slot.as_ref()?;
        let texture = *textures.scene_from_use.get(&slot.one)?;
        Some(TextureRef { texture, uv_set: slot.uv_set, texture_from_uv: slot.texture_from_uv })
    };
    let extensions = material.extensions.as_ref();
    let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    Material {
        name: material.name.clone().unwrap_or_default(),
        base_color: Vec4::from(pbr.base_color_factor.0).clamp(Vec4::ZERO, Vec4::MAX),
        base_color_texture: find(&slots.base_color),
        metallic: pbr.metallic_factor.0.clamp(0.0, 1.0),
        roughness: pbr.roughness_factor.0.clamp(0.0, 1.0),
        metallic_roughness_texture: find(&slots.metallic_roughness),
        normal_texture: find(&slots.normal),
        normal_scale: material.normal_texture.as_ref().map_or(1.0, |texture| texture.scale),
        occlusion_texture: find(&slots.occlusion),
        occlusion_strength: material.occlusion_texture.as_ref().map_or(1.0, |texture| texture.strength.0),
        emissive: (Vec3::from(material.emissive_factor.0) * strength).clamp(Vec3::ZERO, Vec3::MAX),
        emissive_texture: find(&slots.emissive),
        alpha: alpha(material),
        double_sided: material.double_sided,
        unlit: extensions.is_some_and(|extensions| extensions.unlit.is_some()),
    }
}

fn alpha(material: &json::Material) -> AlphaMode {
    match material.alpha_mode {
        Checked::Valid(JsonAlpha::Mask) => AlphaMode::Mask { cutoff: material.alpha_cutoff.unwrap_or_default().0 },
        Checked::Valid(JsonAlpha::Blend) => AlphaMode::Blend,
        _ => AlphaMode::Opaque,
    }
}
