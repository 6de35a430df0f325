// Draws warped triangles: bindings and entry points for the functions of shading.wgsl.
//
// In: vertices, one material, lights. Out: colour (linear, associated alpha), data channels or both, depending on the
// entry point.
// build.rs compiles each fragment entry for every combination of ALPHA and TEXTURES that is used.

/// Alpha mode: 0 opaque, 1 cut off at the material's cutoff, 2 blended (alpha is coverage).
override ALPHA: u32 = 0u;

/// Textures that are read: 0 none, 1 base colour, 2 all.
override TEXTURES: u32 = 2u;

/// Base colour only, no shading. An override instead of a uniform, because drivers that specialise shaders for uniforms
/// in branches (llvmpipe) would compile the shader again for every draw.
override UNLIT: bool = false;

/// Smallest alpha at which blended surfaces are written to data channels.
const DATA_ALPHA: f32 = 0.5;

/// Constants of a draw; 16 bytes.
struct Push {
    /// Pixels per frame height, across and up.
    pixels_from_screen: vec2<f32>,
    /// Values of the channels id.layer and id.object.
    ids: vec2<f32>,
}

/// Constants of a pass: position of the viewer, and lights.
struct Pass {
    /// Eye position with w = 1, or for a parallel camera the unit vector towards the viewer with w = 0.
    eye: vec4<f32>,
    /// Strength of the neutral environment.
    environment: f32,
    light_count: u32,
    padding: vec2<u32>,
    lights: array<Light>,
}

/// Rows of texture_from_uv. row_u.w is the UV set, 0 or 1; row_v.w is 1 if there is a texture.
struct TexturePlace {
    row_u: vec4<f32>,
    row_v: vec4<f32>,
}

/// Factors of a material; 240 bytes.
struct Material {
    base_color: vec4<f32>,
    emissive: vec3<f32>,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    cutoff: f32,
    padding: array<vec4<f32>, 2>,
    /// In the order base colour, metallic-roughness, normal, occlusion, emissive.
    places: array<TexturePlace, 5>,
}

var<immediate> push: Push;
@group(0) @binding(0) var<storage, read> pass_data: Pass;
@group(1) @binding(0) var base_color_texture: texture_2d<f32>;
@group(1) @binding(1) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(2) var normal_texture: texture_2d<f32>;
@group(1) @binding(3) var occlusion_texture: texture_2d<f32>;
@group(1) @binding(4) var emissive_texture: texture_2d<f32>;
@group(1) @binding(5) var base_color_sampler: sampler;
@group(1) @binding(6) var metallic_roughness_sampler: sampler;
@group(1) @binding(7) var normal_sampler: sampler;
@group(1) @binding(8) var occlusion_sampler: sampler;
@group(1) @binding(9) var emissive_sampler: sampler;
// A uniform buffer, because llvmpipe reads zeros from storage buffers in helper invocations, which makes derivatives at
// edges wrong.
@group(1) @binding(10) var<uniform> material: Material;

struct VertexIn {
    /// Homogeneous screen position: x·w, y·w, z·w, w.
    @location(0) screen: vec4<f32>,
    /// Scene position, view depth.
    @location(1) position_depth: vec4<f32>,
    @location(2) normal: vec3<f32>,
    @location(3) next: vec3<f32>,
    @location(4) previous: vec3<f32>,
    @location(5) tangent: vec4<f32>,
    @location(6) uv: vec4<f32>,
    @location(7) color: vec4<f32>,
    /// Position in clip space, y down, snapped to the sub-pixel grid.
    @location(8) clip_position: vec4<f32>,
}

struct Varying {
    // Invariant, so that separate passes for colour and data compute equal depths.
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) position_depth: vec4<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) next: vec3<f32>,
    @location(3) previous: vec3<f32>,
    @location(4) tangent: vec4<f32>,
    @location(5) uv: vec4<f32>,
    @location(6) color: vec4<f32>,
    /// Homogeneous screen position at this time, like `next` and `previous`: x·w, y·w, w.
    @location(7) here: vec3<f32>,
}

struct Data {
    normal_depth: vec4<f32>,
    motion: vec4<f32>,
    ids: vec2<f32>,
}

struct DataOut {
    @location(0) normal_depth: vec4<f32>,
    @location(1) motion: vec4<f32>,
    @location(2) ids: vec2<f32>,
}

struct BothOut {
    @location(0) color: vec4<f32>,
    @location(1) normal_depth: vec4<f32>,
    @location(2) motion: vec4<f32>,
    @location(3) ids: vec2<f32>,
}

@vertex
fn vertex(in: VertexIn) -> Varying {
    return Varying(
        in.clip_position,
        in.position_depth, in.normal, in.next, in.previous, in.tangent, in.uv, in.color, in.screen.xyw,
    );
}

/// Values of the textures at a point; white, or the unperturbed normal, if there is no texture.
struct Texels {
    base_color: vec4<f32>,
    metallic_roughness: vec4<f32>,
    normal: vec3<f32>,
    occlusion: f32,
    emissive: vec3<f32>,
}

fn place_uv(place: TexturePlace, uv: vec4<f32>) -> vec2<f32> {
    let at = vec3<f32>(select(uv.xy, uv.zw, place.row_u.w > 0.5), 1.0);
    return vec2<f32>(dot(place.row_u.xyz, at), dot(place.row_v.xyz, at));
}

fn read_normal(in: Varying, place: TexturePlace, scale: f32) -> vec3<f32> {
    let texel = textureSample(normal_texture, normal_sampler, place_uv(place, in.uv)).xyz;
    return select(vec3<f32>(0.0, 0.0, 1.0), normal_from_texel(texel, scale), place.row_v.w > 0.5);
}

/// Reads all textures that shading needs.
fn read_texels(in: Varying) -> Texels {
    var texels = Texels(vec4<f32>(1.0), vec4<f32>(1.0), vec3<f32>(0.0, 0.0, 1.0), 1.0, vec3<f32>(1.0));
    if TEXTURES >= 1u {
        let uv = place_uv(material.places[0], in.uv);
        texels.base_color = textureSample(base_color_texture, base_color_sampler, uv);
    }
    if TEXTURES == 2u {
        let roughness_uv = place_uv(material.places[1], in.uv);
        texels.metallic_roughness = textureSample(metallic_roughness_texture, metallic_roughness_sampler, roughness_uv);
        texels.normal = read_normal(in, material.places[2], material.normal_scale);
        let occlusion_uv = place_uv(material.places[3], in.uv);
        texels.occlusion = textureSample(occlusion_texture, occlusion_sampler, occlusion_uv).r;
        let emissive_uv = place_uv(material.places[4], in.uv);
        texels.emissive = textureSample(emissive_texture, emissive_sampler, emissive_uv).rgb;
    }
    return texels;
}

/// Reads the textures that data channels need: alpha unless the surface is opaque, and the normal map.
fn read_data_texels(in: Varying) -> Texels {
    var texels = Texels(vec4<f32>(1.0), vec4<f32>(1.0), vec3<f32>(0.0, 0.0, 1.0), 1.0, vec3<f32>(1.0));
    if TEXTURES >= 1u && ALPHA != 0u {
        let uv = place_uv(material.places[0], in.uv);
        texels.base_color = textureSample(base_color_texture, base_color_sampler, uv);
    }
    if TEXTURES == 2u {
        texels.normal = read_normal(in, material.places[2], material.normal_scale);
    }
    return texels;
}

/// Alpha before the alpha mode is applied.
fn raw_alpha(in: Varying, texels: Texels) -> f32 {
    return material.base_color.a * texels.base_color.a * in.color.a;
}

/// Shading normal in the scene, on the viewer's side of the triangle.
fn seen_normal(in: Varying, texels: Texels, is_front: bool) -> vec3<f32> {
    return shading_normal(in.normal, in.tangent, texels.normal, is_front);
}

fn to_viewer(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return unit_or(pass_data.eye.xyz - position * pass_data.eye.w, normal);
}

/// The surface at a fragment, as input of the shading functions.
fn surface_at(in: Varying, texels: Texels, normal: vec3<f32>) -> Surface {
    let position = in.position_depth.xyz;
    return Surface(
        position,
        normal,
        to_viewer(position, normal),
        material.base_color.rgb * texels.base_color.rgb * in.color.rgb,
        clamp(material.metallic * texels.metallic_roughness.b, 0.0, 1.0),
        clamp(material.roughness * texels.metallic_roughness.g, 0.0, 1.0),
        occlusion_from_texel(texels.occlusion, material.occlusion_strength),
        material.emissive * texels.emissive,
    );
}

fn radiance(surface: Surface) -> vec3<f32> {
    if UNLIT {
        return surface.base_color;
    }
    var sum = ambient_surface(surface, pass_data.environment);
    for (var i = 0u; i < pass_data.light_count; i++) {
        sum += light_surface(surface, pass_data.lights[i]);
    }
    return sum;
}

/// Colour of a fragment with coverage `alpha`, multiplied by `alpha`.
fn color_at(in: Varying, texels: Texels, normal: vec3<f32>, alpha: f32) -> vec4<f32> {
    return vec4<f32>(radiance(surface_at(in, texels, normal)) * alpha, alpha);
}

/// Motion between two homogeneous screen positions in pixels, y up; 0 if one is behind the camera.
fn motion_to(there: vec3<f32>, here: vec3<f32>) -> vec2<f32> {
    let moved = (there.xy / there.z - here.xy / here.z) * push.pixels_from_screen;
    return select(vec2<f32>(0.0), moved, min(there.z, here.z) > 1e-6);
}

fn data_at(in: Varying, normal: vec3<f32>) -> Data {
    return Data(
        vec4<f32>(normal, in.position_depth.w),
        vec4<f32>(motion_to(in.next, in.here), motion_to(in.previous, in.here)),
        push.ids,
    );
}

/// Coverage of a fragment; 1 unless the surface is blended.
fn coverage(in: Varying, texels: Texels) -> f32 {
    if ALPHA == 2u {
        return clamp(raw_alpha(in, texels), 0.0, 1.0);
    }
    return 1.0;
}

@fragment
fn beauty(in: Varying, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let texels = read_texels(in);
    if ALPHA == 1u && raw_alpha(in, texels) < material.cutoff {
        discard;
    }
    return color_at(in, texels, seen_normal(in, texels, is_front), coverage(in, texels));
}

@fragment
fn data(in: Varying, @builtin(front_facing) is_front: bool) -> DataOut {
    let texels = read_data_texels(in);
    if ALPHA == 1u && raw_alpha(in, texels) < material.cutoff {
        discard;
    }
    if ALPHA == 2u && raw_alpha(in, texels) < DATA_ALPHA {
        discard;
    }
    let at = data_at(in, seen_normal(in, texels, is_front));
    return DataOut(at.normal_depth, at.motion, at.ids);
}

@fragment
fn both(in: Varying, @builtin(front_facing) is_front: bool) -> BothOut {
    let texels = read_texels(in);
    if ALPHA == 1u && raw_alpha(in, texels) < material.cutoff {
        discard;
    }
    let normal = seen_normal(in, texels, is_front);
    let at = data_at(in, normal);
    return BothOut(color_at(in, texels, normal, 1.0), at.normal_depth, at.motion, at.ids);
}
