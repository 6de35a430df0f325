//! Texture sampling: wrap modes, bilinear within and linear between levels, several taps along an anisotropic
//! footprint.
//!
//! In: UVs and their change per pixel. Out: linear RGBA. The anisotropic footprint follows the Vulkan specification,
//! "Texel Anisotropic Filtering".

use super::mipmap::{LINEAR_FROM_BYTE, LINEAR_FROM_SRGB, Level, mip_chain};
use crate::scene::{Filter, Image, Texture, TextureRef, Wrap};
use glam::{Vec2, Vec3, Vec4};

/// Maximum number of taps along the long axis of a footprint, as on Vulkan devices.
const MAX_ANISOTROPY: f32 = 16.0;

/// An image prepared for sampling.
#[derive(Debug)]
pub(super) struct MipChain {
    levels: Vec<Level>,
    colour_table: &'static [f32; 256],
}

impl MipChain {
    pub(super) fn of(image: &Image) -> Self {
        let colour_table = if image.is_srgb { &*LINEAR_FROM_SRGB } else { &*LINEAR_FROM_BYTE };
        Self { levels: mip_chain(image), colour_table }
    }
}

/// A material's texture: image, filters, UV set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampler {
    pub(super) image: usize,
    texture: Texture,
    uv_set: usize,
    texture_from_uv: [Vec3; 2],
}

/// The UVs of a lookup, and their change to the next pixel to the right and below.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Footprint {
    pub(super) at: Vec2,
    pub(super) dx: Vec2,
    pub(super) dy: Vec2,
}

impl Sampler {
    /// Resolves a reference; `None` if it is invalid.
    pub(super) fn of(reference: &TextureRef, textures: &[Texture]) -> Option<Self> {
        let texture = *textures.get(reference.texture)?;
        let uv_set = reference.uv_set.min(1);
        Some(Self { image: texture.image, texture, uv_set, texture_from_uv: reference.texture_from_uv })
    }

    /// Samples the texture, returning linear values; `sets` holds TEXCOORD_0 and TEXCOORD_1.
    pub(super) fn sample(&self, images: &[MipChain], sets: &[Footprint; 2]) -> Vec4 {
        let Some(image) = images.get(self.image) else { return Vec4::ONE };
        let set = &sets[self.uv_set];
        let [u, v] = self.texture_from_uv;
        let turn = |d: Vec2| Vec2::new(u.truncate().dot(d), v.truncate().dot(d));
        let place = Footprint { at: turn(set.at) + Vec2::new(u.z, v.z), dx: turn(set.dx), dy: turn(set.dy) };
        if place.at.is_finite() { filter(&self.texture, image, &place) } else { Vec4::ONE }
    }
}

/// Filters over the footprint: taps along its long axis, each at the level that matches its short axis.
fn filter(texture: &Texture, image: &MipChain, place: &Footprint) -> Vec4 {
    let size = Vec2::new(image.levels[0].width as f32, image.levels[0].height as f32);
    let (across, down) = ((place.dx * size).length(), (place.dy * size).length());
    let (long, short) = (across.max(down), across.min(down));
    let (Some(between), true) = (texture.mipmap, long > 1.0 && long.is_finite()) else {
        let within = if long > 1.0 { texture.minify } else { texture.magnify };
        return tap(texture, image, (0, within), place.at);
    };
    let taps = (long / short.max(1e-6)).min(MAX_ANISOTROPY).min(long).round().max(1.0);
    let axis = if across >= down { place.dx } else { place.dy };
    let top = (image.levels.len() - 1) as f32;
    let level = (long / taps).log2().clamp(0.0, top);
    let mut sum = Vec4::ZERO;
    for i in 0..taps as u32 {
        let at = place.at + axis * ((i as f32 + 0.5) / taps - 0.5);
        sum += tap_between(texture, image, (level, between), at);
    }
    sum / taps
}

/// Samples at a fractional level.
fn tap_between(texture: &Texture, image: &MipChain, (level, between): (f32, Filter), at: Vec2) -> Vec4 {
    let (low, share) = match between {
        Filter::Nearest => (level.round(), 0.0),
        Filter::Linear => (level.floor(), level.fract()),
    };
    let low = low as usize;
    let near = tap(texture, image, (low, texture.minify), at);
    if share == 0.0 || low + 1 >= image.levels.len() {
        return near;
    }
    near.lerp(tap(texture, image, (low + 1, texture.minify), at), share)
}

/// Samples within a level.
fn tap(texture: &Texture, image: &MipChain, (level, within): (usize, Filter), at: Vec2) -> Vec4 {
    let level = &image.levels[level];
    let size = [level.width as i32, level.height as i32];
    // The fractional part of a repeated coordinate is taken first, so that large coordinates keep their precision.
    let local = Vec2::new(fold(at.x, texture.wrap[0]), fold(at.y, texture.wrap[1]));
    let texel = local * Vec2::new(level.width as f32, level.height as f32);
    let fetch = |x: i32, y: i32| {
        let (x, y) = (wrap(x, size[0], texture.wrap[0]), wrap(y, size[1], texture.wrap[1]));
        let [r, g, b, a] = level.texels[y as usize * level.width as usize + x as usize].map(usize::from);
        let colour = image.colour_table;
        Vec4::new(colour[r], colour[g], colour[b], a as f32 * (1.0 / 255.0))
    };
    if within == Filter::Nearest {
        let first = texel.floor();
        return fetch(first.x as i32, first.y as i32);
    }
    let corner = (texel - 0.5).floor();
    let share = texel - 0.5 - corner;
    let (x, y) = (corner.x as i32, corner.y as i32);
    let upper = fetch(x, y).lerp(fetch(x + 1, y), share.x);
    let lower = fetch(x, y + 1).lerp(fetch(x + 1, y + 1), share.x);
    upper.lerp(lower, share.y)
}

/// Reduces a coordinate to near 0..1, equivalent under the wrap mode.
fn fold(at: f32, mode: Wrap) -> f32 {
    match mode {
        Wrap::Repeat => at - at.floor(),
        Wrap::Mirror => at - 2.0 * (at * 0.5).floor(),
        Wrap::Clamp => at.clamp(-1.0, 2.0),
    }
}

/// Wraps a texel index to 0..size.
fn wrap(index: i32, size: i32, mode: Wrap) -> i32 {
    match mode {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::Mirror => {
            let folded = index.rem_euclid(2 * size);
            folded.min(2 * size - 1 - folded)
        }
        Wrap::Clamp => index.clamp(0, size - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four texels across: 0, 60, 120, 240 of 255, linear data.
    fn strip() -> MipChain {
        let rgba = [0u8, 60, 120, 240].iter().flat_map(|&v| [v, v, v, 255]).collect();
        MipChain::of(&Image { width: 4, height: 1, rgba, is_srgb: false })
    }

    fn texture(wrap: Wrap, filter: Filter) -> Texture {
        Texture { image: 0, wrap: [wrap; 2], magnify: filter, minify: filter, mipmap: Some(Filter::Linear) }
    }

    fn look(texture: &Texture, image: &MipChain, u: f32, du: f32) -> f32 {
        let place = Footprint { at: Vec2::new(u, 0.5), dx: Vec2::new(du, 0.0), dy: Vec2::new(0.0, du) };
        filter(texture, image, &place).x * 255.0
    }

    #[test]
    fn wrap_modes_agree_with_the_specification() {
        let image = strip();
        for (mode, u, wanted) in [
            (Wrap::Repeat, 1.125, 0.0),
            (Wrap::Repeat, -0.125, 240.0),
            (Wrap::Mirror, 1.125, 240.0),
            (Wrap::Mirror, -0.375, 60.0),
            (Wrap::Mirror, 2.375, 60.0),
            (Wrap::Clamp, 7.0, 240.0),
            (Wrap::Clamp, -7.0, 0.0),
        ] {
            let got = look(&texture(mode, Filter::Nearest), &image, u, 0.0);
            assert!((got - wanted).abs() < 1e-3, "{mode:?} at {u}: {got}, not {wanted}");
        }
    }

    #[test]
    fn magnified_texels_blend_between_their_centres() {
        let image = strip();
        assert!((look(&texture(Wrap::Clamp, Filter::Linear), &image, 0.25, 0.0) - 30.0).abs() < 1e-3);
        // Between the last and, wrapped around, the first.
        assert!((look(&texture(Wrap::Repeat, Filter::Linear), &image, 1.0, 0.0) - 120.0).abs() < 1e-3);
        assert!((look(&texture(Wrap::Clamp, Filter::Linear), &image, 1.0, 0.0) - 240.0).abs() < 1e-3);
    }

    #[test]
    fn a_footprint_as_large_as_the_image_sees_its_mean() {
        let image = strip();
        let place = Footprint { at: Vec2::new(0.3, 0.5), dx: Vec2::new(1.0, 0.0), dy: Vec2::new(0.0, 4.0) };
        let got = filter(&texture(Wrap::Repeat, Filter::Linear), &image, &place).x * 255.0;
        assert!((got - 105.0).abs() < 1.0, "{got}");
    }

    #[test]
    fn a_stretched_footprint_blurs_along_its_length_only() {
        // Rows alternate black and white; the footprint is 8 texels long across and 1 down.
        let rgba = (0..16 * 16).flat_map(|i| [if (i / 16) % 2 == 0 { 0 } else { 255 }; 4]).collect();
        let image = MipChain::of(&Image { width: 16, height: 16, rgba, is_srgb: false });
        let place = Footprint {
            at: Vec2::new(0.5, 4.5 / 16.0),
            dx: Vec2::new(8.0 / 16.0, 0.0),
            dy: Vec2::new(0.0, 1.0 / 16.0),
        };
        assert!(filter(&texture(Wrap::Repeat, Filter::Linear), &image, &place).x < 1e-3);
    }

    #[test]
    fn without_mipmaps_only_the_first_level_is_used() {
        let image = strip();
        let plain = Texture { mipmap: None, ..texture(Wrap::Repeat, Filter::Nearest) };
        assert_eq!(look(&plain, &image, 0.9, 3.0), 240.0);
    }
}
