//! Surface shading: `shaders/shading.wgsl` in Rust, function for function.
//!
//! In: a [`Surface`] and a [`Light`]. Out: linear radiance towards the viewer. BRDF: Khronos, "glTF 2.0 Specification",
//! Appendix B, <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#appendix-b-brdf-implementation>. Lights:
//! <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_lights_punctual>

use crate::pose::PosedLight;
use crate::scene::LightKind;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use std::f32::consts::PI;

/// Values of [`Light::kind`].
const LIGHT_DIRECTIONAL: u32 = 0;
const LIGHT_POINT: u32 = 1;
const LIGHT_SPOT: u32 = 2;

/// Reflectance of a dielectric (index of refraction 1.5) at normal incidence.
const DIELECTRIC_F0: f32 = 0.04;

/// Cosine-weighted mean of `matte_fraction`: (1 − f0)·(1 − 1/21), since the mean of (1 − c)⁵ is 1/21.
const MEAN_MATTE_FRACTION: f32 = 0.914_285_7;

/// Minimum roughness: below it, highlights of punctual lights are too bright for half floats.
const MIN_ROUGHNESS: f32 = 0.045;

/// Square of the minimum distance from a point light in metres²: keeps 1/d² finite.
const MIN_DISTANCE_SQUARED: f32 = 1e-4;

/// The neutral environment: radiance `GROUND` below the horizon, `SKY + OVERHEAD·(d·up)` above it. SKY + 2/3·OVERHEAD =
/// 1, so a white diffuse surface that faces up has radiance 1.
const GROUND: f32 = 0.25;
const SKY: f32 = 0.5;
const OVERHEAD: f32 = 0.75;

/// A surface point to be shaded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Scene position.
    pub(crate) position: Vec3,
    /// Unit shading normal, on the viewer's side of the triangle.
    pub(crate) normal: Vec3,
    /// Unit vector towards the viewer.
    pub(crate) to_viewer: Vec3,
    /// Linear base colour, 0..1.
    pub(crate) base_color: Vec3,
    /// 0 dielectric, 1 metal.
    pub(crate) metallic: f32,
    /// Perceptual roughness, 0..1.
    pub(crate) roughness: f32,
    /// Ambient occlusion: 1 open, 0 occluded; punctual lights are not affected.
    pub(crate) occlusion: f32,
    /// Emitted linear radiance.
    pub(crate) emissive: Vec3,
}

/// A punctual light, laid out as the shaders' storage buffer expects it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Light {
    /// Scene position (unused for directional lights).
    position: [f32; 3],
    /// 1 / range in 1/metres; 0 for an infinite range.
    inverse_range: f32,
    /// Unit vector along which it shines.
    direction: [f32; 3],
    /// `LIGHT_DIRECTIONAL`, `LIGHT_POINT` or `LIGHT_SPOT`.
    kind: u32,
    /// Linear RGB: lux for directional lights, else candela.
    color: [f32; 3],
    /// 1 / max(0.001, cos inner − cos outer); 0 for lights other than spots.
    cone_scale: f32,
    /// −cos outer · `cone_scale`; 1 for lights other than spots.
    cone_offset: f32,
    /// Padding to the shaders' 16-byte rows.
    _padding: [f32; 3],
}

impl From<&PosedLight> for Light {
    fn from(light: &PosedLight) -> Self {
        let (kind, cone_scale, cone_offset) = match light.kind {
            LightKind::Directional => (LIGHT_DIRECTIONAL, 0.0, 1.0),
            LightKind::Point => (LIGHT_POINT, 0.0, 1.0),
            LightKind::Spot { inner, outer } => {
                let scale = 1.0 / (inner.cos() - outer.cos()).max(0.001);
                (LIGHT_SPOT, scale, -outer.cos() * scale)
            }
        };
        Self {
            position: light.position.0.to_array(),
            inverse_range: if light.range.is_finite() && light.range > 0.0 { 1.0 / light.range } else { 0.0 },
            direction: light.direction.0.to_array(),
            kind,
            color: light.color.to_array(),
            cone_scale,
            cone_offset,
            _padding: [0.0; 3],
        }
    }
}

/// Incident light at a point.
struct Arrival {
    /// Unit vector towards the light.
    to_light: Vec3,
    /// Illuminance on a plane that faces the light, in lux.
    illuminance: Vec3,
}

/// Returns the unit vector along `v`, or `fallback` if `v` is zero.
pub(crate) fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let squared = v.length_squared();
    if squared > 1e-37 { v * (1.0 / squared.sqrt()) } else { fallback }
}

/// Applies a normal map, and flips the normal to the visible side.
///
/// `mapped` is the map's normal in tangent space with its scale applied, (0, 0, 1) without a map; `tangent.w` is the
/// handedness, a zero tangent means no map.
pub(crate) fn shading_normal(normal: Vec3, tangent: Vec4, mapped: Vec3, is_front: bool) -> Vec3 {
    let n = unit_or(normal, Vec3::Z);
    let t = unit_or(tangent.xyz() - n * n.dot(tangent.xyz()), Vec3::ZERO);
    let b = n.cross(t) * tangent.w;
    let bent = unit_or(t * mapped.x + b * mapped.y + n * mapped.z, n);
    if is_front { bent } else { -bent }
}

/// Converts a stored normal map texel (0..1) to a tangent-space vector; `scale` acts on x and y (glTF 2.0, 3.9.3).
pub(crate) fn normal_from_texel(texel: Vec3, scale: f32) -> Vec3 {
    (texel * 2.0 - 1.0) * Vec3::new(scale, scale, 1.0)
}

/// Trowbridge-Reitz (GGX) distribution D (Appendix B.3.2).
fn distribution_ggx(n_h: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let f = n_h * n_h * (a2 - 1.0) + 1.0;
    a2 / (PI * f * f)
}

/// Height-correlated Smith visibility V = G / (4 n·l n·v) (Appendix B.3.2).
fn visibility_smith(n_l: f32, n_v: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let view = n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt();
    let light = n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt();
    0.5 / (view + light).max(1e-6)
}

/// Schlick's Fresnel term (Appendix B.3.3).
fn fresnel_schlick(f0: Vec3, v_h: f32) -> Vec3 {
    let m = 1.0 - v_h;
    let m2 = m * m;
    f0 + (Vec3::ONE - f0) * (m2 * m2 * m)
}

/// Returns the reflectance at normal incidence.
fn normal_reflectance(surface: &Surface) -> Vec3 {
    Vec3::splat(DIELECTRIC_F0).lerp(surface.base_color, surface.metallic)
}

/// Returns the albedo of the diffuse layer.
fn diffuse_albedo(surface: &Surface) -> Vec3 {
    surface.base_color * (1.0 - surface.metallic)
}

/// Returns the cosine towards the viewer, kept above 0 where a smooth normal faces away beyond the silhouette.
fn view_cosine(surface: &Surface) -> f32 {
    surface.normal.dot(surface.to_viewer).clamp(1e-3, 1.0)
}

/// Returns the fraction of light transmitted by a dielectric's surface at a cosine.
fn matte_fraction(cosine: f32) -> f32 {
    let m = 1.0 - cosine;
    let m2 = m * m;
    (1.0 - DIELECTRIC_F0) * (1.0 - m2 * m2 * m)
}

/// Returns BRDF times cosine, 1/sr. The specular part is that of Appendix B.3.5. Its diffuse layer (1 − F(v·h)) gains
/// up to 28 % at grazing views; here it is coupled to the specular layer so that a white surface never reflects more
/// than it receives: Kelemen and Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance
/// Sampling", 2001.
fn reflect_light(surface: &Surface, to_light: Vec3) -> Vec3 {
    let n_l = surface.normal.dot(to_light).clamp(0.0, 1.0);
    let n_v = view_cosine(surface);
    let halfway = unit_or(to_light + surface.to_viewer, surface.normal);
    let n_h = surface.normal.dot(halfway).clamp(0.0, 1.0);
    let v_h = surface.to_viewer.dot(halfway).clamp(0.0, 1.0);
    let roughness = surface.roughness.max(MIN_ROUGHNESS);
    let alpha = roughness * roughness;
    let fresnel = fresnel_schlick(normal_reflectance(surface), v_h);
    let matte =
        diffuse_albedo(surface) * (matte_fraction(n_l) * matte_fraction(n_v) * (1.0 / (PI * MEAN_MATTE_FRACTION)));
    let gloss = fresnel * (distribution_ggx(n_h, alpha) * visibility_smith(n_l, n_v, alpha));
    (matte + gloss) * n_l
}

/// Returns the attenuation of a light towards its range (`KHR_lights_punctual`, "Range Property").
fn range_window(squared_distance: f32, inverse_range: f32) -> f32 {
    let x = squared_distance * inverse_range * inverse_range;
    (1.0 - x * x).clamp(0.0, 1.0)
}

/// Returns the attenuation of a spot towards the rim of its cone (`KHR_lights_punctual`, "Inner and Outer Cone
/// Angles").
fn cone_window(light: &Light, to_light: Vec3) -> f32 {
    let f = Vec3::from(light.direction).dot(-to_light) * light.cone_scale + light.cone_offset;
    let f = f.clamp(0.0, 1.0);
    f * f
}

/// Returns the incident light at a scene position.
fn arrive(light: &Light, position: Vec3) -> Arrival {
    if light.kind == LIGHT_DIRECTIONAL {
        return Arrival { to_light: -Vec3::from(light.direction), illuminance: light.color.into() };
    }
    let path = Vec3::from(light.position) - position;
    let squared = path.length_squared().max(MIN_DISTANCE_SQUARED);
    let to_light = path * (1.0 / squared.sqrt());
    let window = range_window(squared, light.inverse_range) * cone_window(light, to_light);
    Arrival { to_light, illuminance: Vec3::from(light.color) * (window / squared) }
}

/// Returns the radiance towards the viewer caused by one light.
pub(crate) fn light_surface(surface: &Surface, light: &Light) -> Vec3 {
    let arrival = arrive(light, surface.position);
    reflect_light(surface, arrival.to_light) * arrival.illuminance
}

/// Returns the mean radiance of the environment over the cosine lobe around a direction whose cosine with up is y.
///
/// A plane sees (1 + y)/2 of the upper hemisphere weighted by the cosine; the overhead part is the clamped cosine
/// convolved with the clamped cosine, 2/(3π)·(sin θ + (π − θ)·cos θ), as in a Lambertian sphere's phase law: y/3 and an
/// even part, approximated by a cubic in y² (minimax over 0..1, error below 2e-4).
fn surroundings_matte(y: f32) -> f32 {
    let c = y.clamp(-1.0, 1.0);
    let t = c * c;
    let even = 0.212_037_9 + t * (0.110_114_5 + t * (-0.005_515_1 + t * 0.016_527_3));
    mix(GROUND, SKY, 0.5 + 0.5 * c) + OVERHEAD * (c * (1.0 / 3.0) + even)
}

/// Returns the mean radiance of the environment over the specular lobe around such a direction: with increasing
/// roughness the horizon softens, and the gradient approaches `surroundings_matte`.
fn surroundings_gloss(y: f32, roughness: f32) -> f32 {
    let half_width = mix(0.03, 1.0, roughness);
    let above = smoothstep(-half_width, half_width, y);
    let sharp = mix(GROUND, SKY + OVERHEAD * y.max(0.0), above);
    mix(sharp, surroundings_matte(y), roughness * roughness)
}

/// Returns scale and bias of f0 in the light reflected from a uniform environment.
///
/// Karis, "Physically Based Shading on Mobile", 2014, EnvBRDFApprox, a fit after Lazarov, "Getting More Physical in
/// Call of Duty: Black Ops II", 2013. <https://www.unrealengine.com/blog/physically-based-shading-on-mobile>
fn environment_brdf(roughness: f32, n_v: f32) -> Vec2 {
    let r = roughness * Vec4::new(-1.0, -0.0275, -0.572, 0.022) + Vec4::new(1.0, 0.0425, 1.04, -0.04);
    let a004 = (r.x * r.x).min((-9.28 * n_v).exp2()) * r.x + r.y;
    Vec2::new(-1.04, 1.04) * a004 + r.zw()
}

/// Returns the radiance towards the viewer caused by the environment at strength 1.
fn environment(surface: &Surface) -> Vec3 {
    let brdf = environment_brdf(surface.roughness, view_cosine(surface));
    let reflected = (normal_reflectance(surface) * brdf.x + brdf.y).clamp(Vec3::ZERO, Vec3::ONE);
    let mirror_y = 2.0 * surface.normal.dot(surface.to_viewer) * surface.normal.y - surface.to_viewer.y;
    let gloss = reflected * surroundings_gloss(mirror_y, surface.roughness);
    let matte = (Vec3::ONE - reflected) * diffuse_albedo(surface) * surroundings_matte(surface.normal.y);
    (gloss + matte) * surface.occlusion
}

/// Returns the radiance without punctual lights: emission, and the environment at `strength`.
pub(crate) fn ambient_surface(surface: &Surface, strength: f32) -> Vec3 {
    if strength <= 0.0 {
        return surface.emissive;
    }
    surface.emissive + environment(surface) * strength
}

/// Returns glTF's occlusion: 1 + strength·(texel − 1) (glTF 2.0, 3.9.3).
pub(crate) fn occlusion_from_texel(texel: f32, strength: f32) -> f32 {
    1.0 + strength * (texel - 1.0)
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests;
