//! Textures as the CPU raster shows them: orientation, decoding, transforms, filtering in perspective.

#[path = "support/mesh.rs"]
mod mesh;

use glam::{Vec2, Vec3};
use mesh::{draw, flat, vertex};
use pinwarp::image::Frame;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::{ChannelGroup, Geometry, Pass, PassRole, Raster, RasterVertex, Target};
use pinwarp::scene::{Filter, Image, Material, Scene, Texture, TextureRef, Wrap};
use pinwarp::space::FrameSize;

/// An unlit material with that image as its base colour.
fn textured(image: Image, filter: Filter, texture_from_uv: [Vec3; 2]) -> Scene {
    let wrap = [Wrap::Repeat; 2];
    let texture = Texture { image: 0, wrap, magnify: filter, minify: filter, mipmap: Some(Filter::Linear) };
    let reference = TextureRef { texture: 0, uv_set: 0, texture_from_uv };
    let material = Material { base_color_texture: Some(reference), unlit: true, ..Material::default() };
    Scene { materials: vec![material], textures: vec![texture], images: vec![image], ..Scene::default() }
}

fn plain() -> [Vec3; 2] {
    [Vec3::X, Vec3::Y]
}

fn grey(width: u32, values: &[u8], is_srgb: bool) -> Image {
    let rgba = values.iter().flat_map(|&value| [value, value, value, 255]).collect();
    Image { width, height: values.len() as u32 / width, rgba, is_srgb }
}

fn render(scene: &Scene, geometry: &Geometry, side: u32) -> Frame {
    let frame = FrameSize::new(side, side);
    let mut raster = CpuRaster::new(scene);
    let channels = vec![ChannelGroup::Beauty];
    raster.start(&Target { frame, window: frame.window(), channels, beauty_passes: 1 }).expect("the window is small");
    raster.draw(&Pass { geometry, jitter_px: Vec2::ZERO, role: PassRole::Beauty }).expect("a frame was started");
    raster.finish().expect("a frame was started")
}

/// The unit square; u to the right, v down, as glTF has it.
fn square() -> Geometry {
    let corner = |at: Vec2| RasterVertex { uv: [at.x, 1.0 - at.y, 0.0, 0.0], ..vertex(at, 0.5) };
    flat([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(corner).to_vec(), vec![0, 1, 2, 0, 2, 3])
}

fn reds(frame: &Frame) -> Vec<f32> {
    frame
        .channel("R")
        .expect("beauty was asked for")
        .samples
        .iter()
        .map(|red| (red * 1000.0).round() / 1000.0)
        .collect()
}

#[test]
fn the_first_texel_is_at_the_upper_left_and_bytes_are_decoded() {
    let bytes = [255, 188, 0, 128];
    let linear = textured(grey(2, &bytes, false), Filter::Nearest, plain());
    assert_eq!(reds(&render(&linear, &square(), 2)), [1.0, 0.737, 0.0, 0.502]);
    let colour = textured(grey(2, &bytes, true), Filter::Nearest, plain());
    assert_eq!(reds(&render(&colour, &square(), 2)), [1.0, 0.503, 0.0, 0.216]);
}

#[test]
fn colours_are_blended_as_light() {
    // Halfway between black and white is half the light, not half the code.
    let scene = textured(grey(2, &[0, 255], true), Filter::Linear, plain());
    let row = reds(&render(&scene, &square(), 8));
    assert_eq!(row[..5], [0.375, 0.125, 0.125, 0.375, 0.625]);
}

#[test]
fn the_texture_transform_turns_coordinates() {
    // A quarter turn: u' = v, v' = 1 - u.
    let turn = [Vec3::new(0.0, 1.0, 0.0), Vec3::new(-1.0, 0.0, 1.0)];
    let scene = textured(grey(2, &[0, 51, 102, 153], false), Filter::Nearest, turn);
    assert_eq!(reds(&render(&scene, &square(), 2)), [0.4, 0.0, 0.6, 0.2]);
}

#[test]
fn a_fine_pattern_far_away_is_its_mean() {
    // A floor that runs from depth 1 at the lower edge to 40 at the upper, 512 texels a metre: 8 a pixel and more.
    let checker: Vec<u8> = (0..64 * 64).map(|i| if (i % 64 + i / 64) % 2 == 0 { 255 } else { 0 }).collect();
    let scene = textured(grey(64, &checker, false), Filter::Linear, [Vec3::X * 8.0, Vec3::Y * 8.0]);
    let corner = |x: f32, y: f32, w: f32| RasterVertex {
        screen: [x * w, y * w, 0.1, w],
        uv: [(x - 0.5) * w, w, 0.0, 0.0],
        ..vertex(Vec2::new(x, y), 0.1)
    };
    let corners = vec![corner(0.0, 0.0, 1.0), corner(1.0, 0.0, 1.0), corner(1.0, 1.0, 40.0), corner(0.0, 1.0, 40.0)];
    let mut geometry = flat(corners, vec![0, 1, 2, 0, 2, 3]);
    geometry.draws = vec![draw(0..6)];
    let picture = reds(&render(&scene, &geometry, 64));
    for (index, red) in picture.iter().enumerate() {
        assert!((red - 0.5).abs() < 0.02, "{red} at {index}");
    }
}
