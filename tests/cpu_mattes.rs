//! Cryptomattes of the CPU raster against shares worked out by hand.

#[path = "support/mesh.rs"]
mod mesh;

use glam::{Vec2, Vec4};
use mesh::{draw, flat, vertex};
use pinwarp::image::Frame;
use pinwarp::image::cryptomatte::{MatteId, matte_layers};
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::{ChannelGroup, Draw, Geometry, MATTE_LAYERS, Pass, PassRole, Raster, Target};
use pinwarp::scene::{AlphaMode, Material, Scene};
use pinwarp::space::FrameSize;

/// A rectangle of the frame, its name, its material.
type Card<'a> = ([f32; 4], &'a str, u32);

/// Material 0 is opaque, 1 a quarter there, 2 three quarters.
fn scene() -> Scene {
    let material = |alpha: f32| Material {
        base_color: Vec4::new(1.0, 1.0, 1.0, alpha),
        alpha: if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque },
        unlit: true,
        ..Material::default()
    };
    Scene { materials: [1.0, 0.25, 0.75].map(material).to_vec(), ..Scene::default() }
}

/// Cards from back to front; opaque ones first.
fn cards(cards: &[Card]) -> Geometry {
    let (mut vertices, mut indices, mut draws) = (Vec::new(), Vec::new(), Vec::new());
    for (place, &([x0, y0, x1, y1], name, material)) in (0_u32..).zip(cards) {
        let z = 0.1 + 0.1 * place as f32;
        vertices.extend([[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|at| vertex(Vec2::from(at), z)));
        indices.extend([0, 1, 2, 0, 2, 3].map(|corner| 4 * place + corner));
        let ids = [name, "stuff", "layer"].map(MatteId::of_name);
        draws.push(Draw { material, mattes: ids, ..draw(6 * place..6 * place + 6) });
    }
    Geometry { draws, ..flat(vertices, indices) }
}

/// Drawn with 8 x 8 samples a pixel, spread evenly over it, that weigh the same.
fn render(geometry: &Geometry, frame: FrameSize, channels: &[ChannelGroup]) -> Frame {
    render_passes(geometry, frame, (channels, 64))
}

/// Drawn with the first of these samples.
fn render_passes(geometry: &Geometry, frame: FrameSize, (channels, passes): (&[ChannelGroup], u32)) -> Frame {
    let mut raster = CpuRaster::new(&scene());
    let target = Target { frame, window: frame.window(), channels: channels.to_vec(), beauty_passes: passes };
    raster.start(&target).expect("the window is small");
    for k in 0..passes {
        let jitter_px = (Vec2::new((k % 8) as f32, (k / 8) as f32) - 3.5) / 8.0;
        raster.draw(&Pass { geometry, jitter_px, role: PassRole::Beauty }).expect("a frame was started");
    }
    raster.finish().expect("a frame was started")
}

const MATTES: [ChannelGroup; 2] = [ChannelGroup::Beauty, ChannelGroup::Cryptomatte];

/// Coverage of a name in a Cryptomatte at a pixel.
fn coverage(frame: &Frame, layer: &str, name: &str, pixel: usize) -> f32 {
    let names = frame.channels.iter().enumerate().map(|(place, channel)| (place, channel.name.as_str()));
    let layers = matte_layers(names, &[]);
    let layer = layers.iter().find(|found| found.name == layer).expect("it was asked for");
    let sample = |channel: usize| frame.channels[channel].samples[pixel];
    let ranks = layer.ranks.iter().filter(|rank| sample(rank.id) == MatteId::of_name(name).sample());
    ranks.map(|rank| sample(rank.coverage)).sum()
}

#[test]
fn a_half_covered_pixel_has_half_the_coverage() {
    let frame = FrameSize::new(4, 4);
    // The card ends in the middle of the second column.
    let picture = render(&cards(&[([0.0, 0.0, 0.375, 1.0], "card", 0)]), frame, &MATTES);
    let shares: Vec<f32> = (0..4).map(|pixel| coverage(&picture, "CryptoObject", "card", pixel)).collect();
    assert_eq!(shares, [1.0, 0.5, 0.0, 0.0]);
}

#[test]
fn surfaces_that_meet_in_a_pixel_share_its_ranks() {
    let frame = FrameSize::new(4, 4);
    let scene = [([0.0, 0.0, 0.3125, 1.0], "left", 0), ([0.3125, 0.0, 1.0, 1.0], "right", 0)];
    let picture = render(&cards(&scene), frame, &MATTES);
    let shares = ["left", "right"].map(|name| coverage(&picture, "CryptoObject", name, 1));
    assert_eq!(shares, [0.25, 0.75]);
    let rank = |channel: &str| picture.channel(channel).expect("it is there").samples[1];
    let [left, right] = ["left", "right"].map(|name| MatteId::of_name(name).sample());
    assert_eq!(["R", "G", "B", "A"].map(|c| rank(&format!("CryptoObject00.{c}"))), [right, 0.75, left, 0.25]);
    assert_eq!(["R", "G", "B", "A"].map(|c| rank(&format!("CryptoObject01.{c}"))), [0.0; 4]);
    // Both are made of the same stuff.
    assert_eq!(coverage(&picture, "CryptoMaterial", "stuff", 1), 1.0);
}

#[test]
fn glass_covers_by_its_alpha_and_lets_the_rest_through() {
    let frame = FrameSize::new(2, 2);
    let whole = [0.0, 0.0, 1.0, 1.0];
    let picture = render(&cards(&[(whole, "wall", 0), (whole, "tint", 2), (whole, "glass", 1)]), frame, &MATTES);
    let shares = ["glass", "tint", "wall"].map(|name| coverage(&picture, "CryptoObject", name, 0));
    assert_eq!(shares, [0.25, 0.75 * 0.75, 0.75 * 0.25]);
}

#[test]
fn coverage_sums_to_alpha_everywhere() {
    let frame = FrameSize::new(97, 70);
    let scene = [
        ([0.11, 0.07, 0.63, 0.91], "a", 0),
        ([0.52, 0.33, 1.17, 0.72], "b", 0),
        ([0.3, 0.2, 0.97, 0.55], "c", 2),
        ([0.05, 0.41, 0.88, 0.83], "d", 1),
    ];
    let picture = render(&cards(&scene), frame, &MATTES);
    let alpha = &picture.channel("A").expect("beauty").samples;
    let mut partly = 0;
    for (pixel, &alpha) in alpha.iter().enumerate() {
        for (layer, names) in MATTE_LAYERS.into_iter().zip([&["a", "b", "c", "d"][..], &["stuff"], &["layer"]]) {
            let sum: f32 = names.iter().map(|name| coverage(&picture, layer, name, pixel)).sum();
            assert!((sum - alpha).abs() < 1e-5, "{layer} {sum}, alpha {alpha} at {pixel}");
        }
        partly += usize::from(alpha > 0.0 && alpha < 1.0);
    }
    assert!(partly > 500, "{partly} pixels are partly covered");
}

#[test]
fn rounding_never_makes_more_than_the_whole() {
    let card = cards(&[([0.0, 0.0, 1.0, 1.0], "card", 0)]);
    for passes in [3, 7, 24, 49] {
        let picture = render_passes(&card, FrameSize::new(2, 2), (&MATTES, passes));
        let share = coverage(&picture, "CryptoObject", "card", 0);
        assert!(share <= 1.0 && share > 0.99999, "{share} with {passes} passes");
    }
}

#[test]
fn nothing_named_nothing_covers_and_channels_come_only_when_asked_for() {
    let frame = FrameSize::new(3, 3);
    let mut geometry = cards(&[([0.0, 0.0, 1.0, 1.0], "card", 0)]);
    geometry.draws[0].mattes = [MatteId::NOTHING; 3];
    let picture = render(&geometry, frame, &MATTES);
    let mattes = picture.channels.iter().filter(|channel| channel.name.starts_with("Crypto"));
    assert_eq!(mattes.clone().count(), 36);
    assert!(mattes.flat_map(|channel| &channel.samples).all(|&sample| sample == 0.0));
    assert_eq!(render(&geometry, frame, &MATTES[..1]).channels.len(), 4);
}

#[test]
fn a_frame_forgets_the_last_one_and_threads_make_no_difference() {
    let frame = FrameSize::new(150, 130);
    let scene = [([0.1, 0.1, 0.9, 0.6], "a", 0), ([0.3, 0.2, 0.7, 0.95], "b", 2), ([0.2, 0.4, 1.1, 0.8], "c", 1)];
    let draw_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| render(&cards(&scene), frame, &MATTES))
    };
    let first = draw_with(1);
    assert_eq!(first, draw_with(3));
    let mut raster = CpuRaster::new(&self::scene());
    let target = Target { frame, window: frame.window(), channels: MATTES.to_vec(), beauty_passes: 1 };
    let mut draw = |geometry: &Geometry| {
        raster.start(&target).expect("the window is small");
        let pass = Pass { geometry, jitter_px: Vec2::ZERO, role: PassRole::BeautyAndData };
        raster.draw(&pass).expect("a frame was started");
        raster.finish().expect("a frame was started")
    };
    let empty = draw(&Geometry::default());
    let _ = draw(&cards(&scene));
    assert_eq!(draw(&Geometry::default()), empty);
}
