// Adds a sample pass to the mean of a frame: a triangle that covers the window, blended with ONE, ONE.
//
// In: the colour of the pass, its weight. Out: colour · weight, added to the target.

struct Push {
    weight: f32,
}

var<immediate> push: Push;
@group(0) @binding(0) var sample_color: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn resolve(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(sample_color, vec2<i32>(position.xy), 0) * push.weight;
}
