// Shading of a surface: the metallic-roughness BRDF of glTF, punctual lights, a neutral environment.
//
// In: a Surface and a Light (plain values; no bindings, no entry points). Out: linear radiance towards the viewer.
// src/raster/cpu/shading.rs has the same functions under the same names.
// BRDF: Khronos, "glTF 2.0 Specification", Appendix B, https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#appendix-b-brdf-implementation
// Lights: Khronos, KHR_lights_punctual, https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_lights_punctual

const PI: f32 = 3.14159265358979;

/// Values of Light.kind.
const LIGHT_DIRECTIONAL: u32 = 0u;
const LIGHT_POINT: u32 = 1u;
const LIGHT_SPOT: u32 = 2u;

/// Reflectance of a dielectric (index of refraction 1.5) at normal incidence.
const DIELECTRIC_F0: f32 = 0.04;

/// Cosine-weighted mean of `matte_fraction`: (1 - f0)·(1 - 1/21), since the mean of (1 - c)^5 is 1/21.
const MEAN_MATTE_FRACTION: f32 = 0.9142857;

/// Lower bound of roughness: highlights of punctual lights would otherwise be narrower than a half float can represent.
const MIN_ROUGHNESS: f32 = 0.045;

/// Square of the smallest distance from a point light, metres²; keeps 1/d² finite.
const MIN_DISTANCE_SQUARED: f32 = 1e-4;

/// The neutral environment: radiance GROUND below the horizon, SKY + OVERHEAD·(d·up) above it.
/// SKY + 2/3·OVERHEAD = 1, so a white matte surface that faces up has radiance 1.
const GROUND: f32 = 0.25;
const SKY: f32 = 0.5;
const OVERHEAD: f32 = 0.75;

/// A point of a surface, with the parameters of its BRDF.
struct Surface {
    /// Scene position.
    position: vec3<f32>,
    /// Unit shading normal, on the viewer's side of the triangle.
    normal: vec3<f32>,
    /// Unit vector towards the viewer.
    to_viewer: vec3<f32>,
    /// Linear, 0..1.
    base_color: vec3<f32>,
    /// 0 dielectric, 1 metal.
    metallic: f32,
    /// Perceptual roughness, 0..1.
    roughness: f32,
    /// Ambient occlusion: 1 open, 0 hidden from the environment. Does not affect punctual lights.
    occlusion: f32,
    /// Emitted linear radiance.
    emissive: vec3<f32>,
}

/// A punctual light; 64 bytes in a storage buffer, members at the offsets 0, 12, 16, 28, 32, 44, 48.
struct Light {
    /// Scene position; unused by directional lights.
    position: vec3<f32>,
    /// 1 / range in 1/metres; 0 if the light has no range.
    inverse_range: f32,
    /// Unit vector along which the light shines.
    direction: vec3<f32>,
    /// LIGHT_DIRECTIONAL, LIGHT_POINT or LIGHT_SPOT.
    kind: u32,
    /// Linear RGB: illuminance in lux for directional lights, else intensity in candela.
    color: vec3<f32>,
    /// 1 / max(0.001, cos inner - cos outer); 0 unless the light is a spot.
    cone_scale: f32,
    /// -cos outer · cone_scale; 1 unless the light is a spot.
    cone_offset: f32,
}

/// Light arriving at a point.
struct Arrival {
    /// Unit vector towards the light.
    to_light: vec3<f32>,
    /// Illuminance on a plane perpendicular to the light's direction, lux.
    illuminance: vec3<f32>,
}

/// Unit vector along v, or `fallback` if the length of v is 0.
fn unit_or(v: vec3<f32>, fallback: vec3<f32>) -> vec3<f32> {
    let squared = dot(v, v);
    return select(fallback, v * inverseSqrt(max(squared, 1e-37)), squared > 1e-37);
}

/// The normal after the normal map, on the side that is visible.
///
/// `mapped` is the map's normal in tangent space with its scale applied, (0, 0, 1) without a map.
/// `tangent.w` is the handedness; a zero tangent means no map.
fn shading_normal(normal: vec3<f32>, tangent: vec4<f32>, mapped: vec3<f32>, is_front: bool) -> vec3<f32> {
    let n = unit_or(normal, vec3<f32>(0.0, 0.0, 1.0));
    let t = unit_or(tangent.xyz - n * dot(n, tangent.xyz), vec3<f32>(0.0));
    let b = cross(n, t) * tangent.w;
    let bent = unit_or(t * mapped.x + b * mapped.y + n * mapped.z, n);
    return select(-bent, bent, is_front);
}

/// The normal in tangent space of a normal map texel (0..1); `scale` applies to x and y (glTF 2.0, 3.9.3).
fn normal_from_texel(texel: vec3<f32>, scale: f32) -> vec3<f32> {
    return (texel * 2.0 - 1.0) * vec3<f32>(scale, scale, 1.0);
}

/// Trowbridge-Reitz (GGX) distribution D (Appendix B.3.2).
fn distribution_ggx(n_h: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let f = n_h * n_h * (a2 - 1.0) + 1.0;
    return a2 / (PI * f * f);
}

/// Height-correlated Smith visibility V = G / (4 n·l n·v) (Appendix B.3.2).
fn visibility_smith(n_l: f32, n_v: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let view = n_l * sqrt(n_v * n_v * (1.0 - a2) + a2);
    let light = n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    return 0.5 / max(view + light, 1e-6);
}

/// Schlick's Fresnel term (Appendix B.3.3).
fn fresnel_schlick(f0: vec3<f32>, v_h: f32) -> vec3<f32> {
    let m = 1.0 - v_h;
    let m2 = m * m;
    return f0 + (vec3<f32>(1.0) - f0) * (m2 * m2 * m);
}

/// Reflectance at normal incidence.
fn normal_reflectance(surface: Surface) -> vec3<f32> {
    return mix(vec3<f32>(DIELECTRIC_F0), surface.base_color, surface.metallic);
}

/// Albedo of the diffuse component.
fn diffuse_albedo(surface: Surface) -> vec3<f32> {
    return surface.base_color * (1.0 - surface.metallic);
}

/// Cosine towards the viewer, clamped above 0 where a smooth normal points beyond the silhouette.
fn view_cosine(surface: Surface) -> f32 {
    return clamp(dot(surface.normal, surface.to_viewer), 1e-3, 1.0);
}

/// Fraction of the light that the surface of a dielectric transmits at a cosine.
fn matte_fraction(cosine: f32) -> f32 {
    let m = 1.0 - cosine;
    let m2 = m * m;
    return (1.0 - DIELECTRIC_F0) * (1.0 - m2 * m2 * m);
}

/// BRDF times cosine, 1/sr; gloss as in Appendix B.3.5. The diffuse layer there, (1 - F(v·h)), gains up to 28 % at
/// grazing views. Here it is coupled to the gloss so that a white surface never reflects more than it receives: Kelemen
/// and Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling", 2001.
fn reflect_light(surface: Surface, to_light: vec3<f32>) -> vec3<f32> {
    let n_l = clamp(dot(surface.normal, to_light), 0.0, 1.0);
    let n_v = view_cosine(surface);
    let halfway = unit_or(to_light + surface.to_viewer, surface.normal);
    let n_h = clamp(dot(surface.normal, halfway), 0.0, 1.0);
    let v_h = clamp(dot(surface.to_viewer, halfway), 0.0, 1.0);
    let roughness = max(surface.roughness, MIN_ROUGHNESS);
    let alpha = roughness * roughness;
    let fresnel = fresnel_schlick(normal_reflectance(surface), v_h);
    let matte = diffuse_albedo(surface)
        * (matte_fraction(n_l) * matte_fraction(n_v) * (1.0 / (PI * MEAN_MATTE_FRACTION)));
    let gloss = fresnel * (distribution_ggx(n_h, alpha) * visibility_smith(n_l, n_v, alpha));
    return (matte + gloss) * n_l;
}

/// Attenuation of a light towards its range (KHR_lights_punctual, "Range Property").
fn range_window(squared_distance: f32, inverse_range: f32) -> f32 {
    let x = squared_distance * inverse_range * inverse_range;
    return clamp(1.0 - x * x, 0.0, 1.0);
}

/// Attenuation of a spot towards the rim of its cone (KHR_lights_punctual, "Inner and Outer Cone Angles").
fn cone_window(light: Light, to_light: vec3<f32>) -> f32 {
    let f = clamp(dot(light.direction, -to_light) * light.cone_scale + light.cone_offset, 0.0, 1.0);
    return f * f;
}

/// The light arriving at a scene position.
fn arrive(light: Light, position: vec3<f32>) -> Arrival {
    if light.kind == LIGHT_DIRECTIONAL {
        return Arrival(-light.direction, light.color);
    }
    let path = light.position - position;
    let squared = max(dot(path, path), MIN_DISTANCE_SQUARED);
    let to_light = path * inverseSqrt(squared);
    let window = range_window(squared, light.inverse_range) * cone_window(light, to_light);
    return Arrival(to_light, light.color * (window / squared));
}

/// Radiance towards the viewer due to one light.
fn light_surface(surface: Surface, light: Light) -> vec3<f32> {
    let arrival = arrive(light, surface.position);
    return reflect_light(surface, arrival.to_light) * arrival.illuminance;
}

/// Mean radiance of the environment over the cosine lobe around a direction whose cosine with up is y.
///
/// A plane sees (1 + y)/2 of the upper hemisphere, weighted by the cosine. The overhead component is the convolution of
/// the clamped cosine with itself, 2/(3π)·(sin θ + (π - θ)·cos θ), as in the phase law of a Lambertian sphere: y/3 plus
/// an even function, which is approximated by a cubic in y² (minimax over 0..1, error below 2e-4).
fn surroundings_matte(y: f32) -> f32 {
    let c = clamp(y, -1.0, 1.0);
    let t = c * c;
    let even = 0.2120379 + t * (0.1101145 + t * (-0.0055151 + t * 0.0165273));
    return mix(GROUND, SKY, 0.5 + 0.5 * c) + OVERHEAD * (c * (1.0 / 3.0) + even);
}

/// Mean radiance of the environment over the highlight lobe around such a direction. With growing roughness the horizon
/// softens and the gradient approaches `surroundings_matte`.
fn surroundings_gloss(y: f32, roughness: f32) -> f32 {
    let half_width = mix(0.03, 1.0, roughness);
    let above = smoothstep(-half_width, half_width, y);
    let sharp = mix(GROUND, SKY + OVERHEAD * max(y, 0.0), above);
    return mix(sharp, surroundings_matte(y), roughness * roughness);
}

/// Scale and offset of f0 in the light reflected from a uniform environment.
///
/// Karis, "Physically Based Shading on Mobile", 2014, EnvBRDFApprox, a fit after Lazarov, "Getting More Physical in
/// Call of Duty: Black Ops II", 2013. https://www.unrealengine.com/blog/physically-based-shading-on-mobile
fn environment_brdf(roughness: f32, n_v: f32) -> vec2<f32> {
    let r = roughness * vec4<f32>(-1.0, -0.0275, -0.572, 0.022) + vec4<f32>(1.0, 0.0425, 1.04, -0.04);
    let a004 = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    return vec2<f32>(-1.04, 1.04) * a004 + r.zw;
}

/// Radiance towards the viewer due to the environment with strength 1.
fn environment(surface: Surface) -> vec3<f32> {
    let n_v = view_cosine(surface);
    let brdf = environment_brdf(surface.roughness, n_v);
    let reflected = clamp(normal_reflectance(surface) * brdf.x + brdf.y, vec3<f32>(0.0), vec3<f32>(1.0));
    let mirror_y = 2.0 * dot(surface.normal, surface.to_viewer) * surface.normal.y - surface.to_viewer.y;
    let gloss = reflected * surroundings_gloss(mirror_y, surface.roughness);
    let matte = (vec3<f32>(1.0) - reflected) * diffuse_albedo(surface) * surroundings_matte(surface.normal.y);
    return (gloss + matte) * surface.occlusion;
}

/// Radiance without the punctual lights: emission, and the environment times `strength`.
/// The caller adds `light_surface` of each light. Unlit materials show their base colour and call nothing here.
fn ambient_surface(surface: Surface, strength: f32) -> vec3<f32> {
    if strength <= 0.0 {
        return surface.emissive;
    }
    return surface.emissive + environment(surface) * strength;
}

/// glTF's occlusion: 1 + strength·(texel - 1) (glTF 2.0, 3.9.3).
fn occlusion_from_texel(texel: f32, strength: f32) -> f32 {
    return 1.0 + strength * (texel - 1.0);
}
