//! The CPU raster against closed forms: coverage, depth, interpolation, alpha, data, hostile input.

#[path = "support/random.rs"]
mod random;

#[path = "support/ball.rs"]
mod ball;
#[path = "support/compare.rs"]
mod compare;
#[path = "support/mesh.rs"]
mod mesh;

use compare::{Limits, compare};
use glam::{Vec2, Vec3, Vec4};
use mesh::{draw, flat, vertex};
use pinwarp::image::Frame;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::{ChannelGroup, Draw, Geometry, Pass, PassRole, Raster, RasterVertex, Target};
use pinwarp::scene::{AlphaMode, Material, Scene};
use pinwarp::space::{FrameSize, PixelRect};
use proptest::prelude::*;

const ALL: [ChannelGroup; 5] =
    [ChannelGroup::Beauty, ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];

/// A scene of unlit materials.
fn unlit(materials: impl IntoIterator<Item = (Vec4, AlphaMode)>) -> Scene {
    let material = |(base_color, alpha)| Material { base_color, alpha, unlit: true, ..Material::default() };
    Scene { materials: materials.into_iter().map(material).collect(), ..Scene::default() }
}

fn white() -> Scene {
    unlit([(Vec4::ONE, AlphaMode::Opaque)])
}

fn target(frame: FrameSize, window: PixelRect, beauty_passes: u32) -> Target {
    Target { frame, window, channels: ALL.to_vec(), beauty_passes }
}

/// One pass over the whole frame.
fn render(scene: &Scene, geometry: &Geometry, frame: FrameSize) -> Frame {
    render_window(scene, geometry, &target(frame, frame.window(), 1))
}

fn render_window(scene: &Scene, geometry: &Geometry, target: &Target) -> Frame {
    let mut raster = CpuRaster::new(scene);
    raster.start(target).expect("the window is small");
    raster.draw(&Pass { geometry, jitter_px: Vec2::ZERO, role: PassRole::BeautyAndData }).expect("a frame was started");
    raster.finish().expect("a frame was started")
}

fn samples<'a>(frame: &'a Frame, name: &str) -> &'a [f32] {
    &frame.channel(name).expect("the channel was asked for").samples
}

/// Corners of the unit square in counter-clockwise order, at one z.
fn square(z: f32) -> Vec<RasterVertex> {
    [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|at| vertex(at, z)).to_vec()
}

const SQUARE: [u32; 6] = [0, 1, 2, 0, 2, 3];

#[test]
fn a_triangle_covers_the_centres_inside_it_and_its_neighbour_the_rest() {
    let frame = FrameSize::new(8, 8);
    for (corners, count) in [([0, 1, 3], 28), ([1, 2, 3], 36)] {
        let picture = render(&white(), &flat(square(0.5), corners.to_vec()), frame);
        let alpha = samples(&picture, "A");
        assert_eq!(alpha.iter().sum::<f32>(), count as f32);
        for (index, &alpha) in alpha.iter().enumerate() {
            // Counted from the lower left; the diagonal's centres belong to the upper right half (its left edge).
            let (i, j) = (index % 8, 7 - index / 8);
            let is_inside = if count == 28 { i + j < 7 } else { i + j >= 7 };
            assert_eq!(alpha, f32::from(u8::from(is_inside)), "({i}, {j})");
        }
    }
}

proptest! {
    #![proptest_config(random::config(24))]

    /// A jittered grid over the frame and beyond, half transparent: a gap shows 0, a pixel drawn twice 0.75.
    #[test]
    fn shared_edges_neither_crack_nor_draw_twice(
        moves in prop::collection::vec((-0.24f32..0.24, -0.24f32..0.24), 11 * 9),
        shift in (-0.5f32..0.5, -0.5f32..0.5),
    ) {
        // Quarters of a pixel, so that many centres lie exactly on edges and corners.
        let quarter = |place: Vec2| (place * (128.0 * 4.0)).round() / (128.0 * 4.0);
        let place = |i: u32, j: u32| {
            let by = moves[(j * 11 + i) as usize];
            vertex(quarter((Vec2::new(i as f32 + by.0, j as f32 + by.1) - 1.0) / 6.0), 0.5)
        };
        let vertices = (0..9).flat_map(|j| (0..11).map(move |i| (i, j))).map(|(i, j)| place(i, j)).collect();
        let cell = |i: u32, j: u32| {
            let a = j * 11 + i;
            [a, a + 1, a + 12, a, a + 12, a + 11]
        };
        let indices = (0..8).flat_map(|j| (0..10).flat_map(move |i| cell(i, j))).collect();
        let scene = Scene {
            materials: vec![Material {
                base_color: Vec4::new(1.0, 1.0, 1.0, 0.5),
                alpha: AlphaMode::Blend,
                unlit: true,
                double_sided: true,
                ..Material::default()
            }],
            ..Scene::default()
        };
        let frame = FrameSize::new(150, 128);
        let mut raster = CpuRaster::new(&scene);
        raster.start(&target(frame, frame.window(), 1)).expect("the window is small");
        let geometry = flat(vertices, indices);
        let jitter_px = (Vec2::new(shift.0, shift.1) * 4.0).round() / 4.0;
        raster.draw(&Pass { geometry: &geometry, jitter_px, role: PassRole::Beauty }).expect("a frame was started");
        let picture = raster.finish().expect("a frame was started");
        let wrong = samples(&picture, "A").iter().filter(|&&alpha| (alpha - 0.5).abs() > 1e-3).count();
        prop_assert_eq!(wrong, 0);
    }
}

#[test]
fn the_greater_z_wins_in_any_order() {
    let frame = FrameSize::new(4, 4);
    let (mut near, mut far) = (square(0.8), square(0.3));
    near.iter_mut().for_each(|vertex| vertex.color = [1.0, 0.0, 0.0, 1.0]);
    far.iter_mut().for_each(|vertex| vertex.color = [0.0, 1.0, 0.0, 1.0]);
    let indices: Vec<u32> = SQUARE.iter().copied().chain(SQUARE.map(|corner| corner + 4)).collect();
    for vertices in [[near.clone(), far.clone()].concat(), [far, near].concat()] {
        let picture = render(&white(), &flat(vertices, indices.clone()), frame);
        assert_eq!((samples(&picture, "R")[5], samples(&picture, "G")[5]), (1.0, 0.0));
        assert!((samples(&picture, "depth.Z")[5] - 1.25).abs() < 1e-6);
    }
}

#[test]
fn attributes_are_interpolated_with_perspective() {
    let frame = FrameSize::new(64, 64);
    let w = [1.0f32, 2.0, 5.0];
    let at = [Vec2::new(-0.2, -0.1), Vec2::new(1.3, 0.1), Vec2::new(0.3, 1.4)];
    let corners: Vec<RasterVertex> = (0..3)
        .map(|i| RasterVertex {
            screen: [at[i].x * w[i], at[i].y * w[i], 0.1, w[i]],
            color: [f32::from(i == 0), f32::from(i == 1), f32::from(i == 2), 1.0],
            depth: w[i],
            ..vertex(at[i], 0.1)
        })
        .collect();
    let picture = render(&white(), &flat(corners, vec![0, 1, 2]), frame);
    let [p, q, r] = at.map(Vec2::as_dvec2);
    for index in 0..64 * 64 {
        if samples(&picture, "A")[index] == 0.0 {
            continue;
        }
        let place = glam::DVec2::new((index % 64) as f64 + 0.5, 63.5 - (index / 64) as f64) / 64.0;
        let area = |a: glam::DVec2, b: glam::DVec2, c: glam::DVec2| (b - a).perp_dot(c - a);
        let shares = [area(q, r, place), area(r, p, place), area(p, q, place)];
        let divided = [0, 1, 2].map(|i| shares[i] / f64::from(w[i]));
        let whole: f64 = divided.iter().sum();
        for (name, share) in ["R", "G", "B"].iter().zip(divided) {
            // 1/256 pixel of snapping over a triangle of 80 pixels.
            assert!((f64::from(samples(&picture, name)[index]) - share / whole).abs() < 3e-4);
        }
        let depth: f64 = (0..3).map(|i| divided[i] / whole * f64::from(w[i])).sum();
        assert!((f64::from(samples(&picture, "depth.Z")[index]) - depth).abs() < 1e-3);
    }
}

#[test]
fn a_mask_cuts_at_its_cutoff_and_leaves_whole_pixels() {
    let mut vertices = square(0.5);
    vertices.iter_mut().for_each(|vertex| vertex.color[3] = vertex.screen[0]);
    // The square is one frame height wide: eight of 16 pixels, alpha 1/16, 3/16, 5/16...
    let scene = unlit([(Vec4::ONE, AlphaMode::Mask { cutoff: 0.25 })]);
    let picture = render(&scene, &flat(vertices, SQUARE.to_vec()), FrameSize::new(16, 8));
    let wanted: Vec<f32> = (0..16).map(|x| f32::from(u8::from((2..8).contains(&x)))).collect();
    assert_eq!(samples(&picture, "A")[..16], wanted);
}

/// An opaque blue square at z 0.2, red over it at 0.5, green over it at 0.1 (hidden), by alpha `alpha`.
fn blended(alpha: f32) -> Frame {
    let scene = unlit([
        (Vec4::new(0.0, 0.0, 1.0, 0.3), AlphaMode::Opaque),
        (Vec4::new(1.0, 0.0, 0.0, alpha), AlphaMode::Blend),
        (Vec4::new(0.0, 1.0, 0.0, alpha), AlphaMode::Blend),
    ]);
    let vertices = [square(0.2), square(0.1), square(0.4), square(0.5)].concat();
    let indices: Vec<u32> = (0..4).flat_map(|k| SQUARE.map(|corner| corner + 4 * k)).collect();
    let part = |k: u32, material| Draw { material, object_id: 10 + k, ..draw(6 * k..6 * k + 6) };
    let draws = vec![part(0, 0), part(1, 2), part(2, 2), part(3, 1)];
    render(&scene, &Geometry { draws, ..flat(vertices, indices) }, FrameSize::new(2, 2))
}

#[test]
fn blending_is_over_in_order_behind_opaque_surfaces_and_writes_no_depth() {
    let picture = blended(0.25);
    let got = ["R", "G", "B", "A"].map(|name| samples(&picture, name)[0]);
    // Blue, 0.25 green over it, 0.25 red over that; the green square behind the blue one is hidden.
    assert_eq!(got, [0.25, 0.1875, 0.5625, 1.0]);
    assert_eq!(samples(&picture, "id.object")[0], 10.0);
    assert_eq!(samples(&blended(0.5), "id.object")[0], 13.0);
}

#[test]
fn motion_is_in_pixels_with_y_up_and_zero_at_rest() {
    let frame = FrameSize { width: 20, height: 10, pixel_aspect: 2.0 };
    let mut vertices = square(0.5);
    for vertex in &mut vertices {
        let w = 2.0 + vertex.screen[0];
        vertex.next = [(vertex.screen[0] + 0.1) * w, (vertex.screen[1] + 0.3) * w, w];
    }
    let picture = render(&white(), &flat(vertices, SQUARE.to_vec()), frame);
    let centre = 5 * 20 + 2;
    // The next frame's w differs between corners, so only its quotient counts: here it is linear in x, not constant.
    let place = Vec2::new(0.5, 0.45);
    let shares = [1.0 - place.x, place.x];
    let w: f32 = shares[0] * 2.0 + shares[1] * 3.0;
    let next_x = (shares[0] * 0.1 * 2.0 + shares[1] * 1.1 * 3.0) / w;
    assert!((samples(&picture, "forward.u")[centre] - (next_x - place.x) * 5.0).abs() < 1e-4);
    assert_eq!(samples(&picture, "backward.u")[centre], 0.0);
    assert_eq!(samples(&picture, "backward.v")[centre], 0.0);
    assert!(samples(&picture, "forward.v")[centre] > 2.9);
}

#[test]
fn ids_and_empty_values() {
    let geometry = flat(square(0.5), vec![0, 1, 3]);
    let picture = render(&white(), &geometry, FrameSize::new(4, 4));
    let names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(
        names.join(" "),
        "R G B A depth.Z forward.u forward.v backward.u backward.v N.X N.Y N.Z id.layer id.object"
    );
    let corner = |name: &str, index: usize| samples(&picture, name)[index];
    assert_eq!([corner("id.layer", 12), corner("id.object", 12), corner("N.Z", 12)], [3.0, 7.0, 1.0]);
    assert_eq!([corner("id.layer", 3), corner("depth.Z", 3), corner("N.Z", 3)], [0.0, 1e10, 0.0]);
}

#[test]
fn the_mean_over_jitters_is_the_area() {
    let at = [Vec2::new(0.13, 0.21), Vec2::new(0.87, 0.34), Vec2::new(0.41, 0.93)];
    let geometry = flat(at.map(|at| vertex(at, 0.5)).to_vec(), vec![0, 1, 2]);
    let frame = FrameSize::new(32, 32);
    let mut raster = CpuRaster::new(&white());
    raster.start(&target(frame, frame.window(), 256)).expect("the window is small");
    for k in 0..256u32 {
        let jitter_px = Vec2::new((k % 16) as f32 - 7.5, (k / 16) as f32 - 7.5) / 16.0;
        raster.draw(&Pass { geometry: &geometry, jitter_px, role: PassRole::Beauty }).expect("a frame was started");
    }
    let picture = raster.finish().expect("a frame was started");
    let covered: f32 = samples(&picture, "A").iter().sum();
    let area = (at[1] - at[0]).perp_dot(at[2] - at[0]) * 0.5 * 32.0 * 32.0;
    assert!((covered - area).abs() < 0.05, "{covered} pixels of {area}");
    assert!(samples(&picture, "depth.Z").iter().all(|&depth| depth == 1e10), "beauty passes leave data alone");
}

#[test]
fn data_come_from_the_data_pass_whatever_is_nearer_in_others() {
    let frame = FrameSize::new(2, 2);
    let mut raster = CpuRaster::new(&white());
    raster.start(&target(frame, frame.window(), 2)).expect("the window is small");
    for (z, role) in [(0.25, PassRole::Data), (0.5, PassRole::Beauty), (0.9, PassRole::Beauty)] {
        let geometry = flat(square(z), SQUARE.to_vec());
        raster.draw(&Pass { geometry: &geometry, jitter_px: Vec2::ZERO, role }).expect("a frame was started");
    }
    let picture = raster.finish().expect("a frame was started");
    assert_eq!((samples(&picture, "A")[0], samples(&picture, "depth.Z")[0]), (1.0, 4.0));
}

#[test]
fn any_number_of_threads_draws_the_same_bytes() {
    let frame = FrameSize::new(200, 120);
    let geometry = ball::ball(frame, (60, 120), 0.03);
    let scene = Scene { materials: vec![Material { metallic: 0.3, ..Material::default() }], ..Scene::default() };
    let draw_with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &geometry, frame))
    };
    let first = draw_with(1);
    assert_eq!(first, draw_with(2));
    assert_eq!(first, draw_with(5));
    assert!(samples(&first, "R").iter().all(|light| light.is_finite() && *light >= 0.0));
}

#[test]
fn a_window_shows_its_part_of_the_frame() {
    let frame = FrameSize::new(200, 120);
    let geometry = ball::ball(frame, (30, 60), 0.0);
    let whole = render(&white(), &geometry, frame);
    let window = PixelRect { x: 75, y: 13, width: 70, height: 67 };
    let part = render_window(&white(), &geometry, &target(frame, window, 1));
    let mut expected = part.clone();
    for (channel, whole) in expected.channels.iter_mut().zip(&whole.channels) {
        for (index, sample) in channel.samples.iter_mut().enumerate() {
            *sample = whole.samples[(13 + index / 70) * 200 + 75 + index % 70];
        }
    }
    let limits = Limits { fail: 1e-4, fail_percent: 0.0, hard: 1e-3, mean: 1e-5 };
    compare(&part, &expected, &["R", "A", "depth.Z", "forward.u", "N.X", "id.object"], &limits).unwrap();
}

#[test]
fn corners_far_off_the_screen_cut_where_they_should() {
    // Half planes through the middle of the frame, by triangles with corners a million frame heights away.
    for far in [10.0, 1e3, 1e6] {
        let at = [Vec2::new(0.5, -far), Vec2::new(far, 0.5), Vec2::new(0.5, far)];
        let geometry = flat(at.map(|at| vertex(at, 0.5)).to_vec(), vec![0, 1, 2]);
        let picture = render(&white(), &geometry, FrameSize::new(100, 100));
        for (index, &alpha) in samples(&picture, "A").iter().enumerate() {
            assert_eq!(alpha, f32::from(u8::from(index % 100 >= 50)), "{far}: {index}");
        }
        assert!(samples(&picture, "depth.Z").iter().all(|depth| *depth == 1e10 || (*depth - 2.0).abs() < 1e-3));
    }
}

#[test]
fn hostile_geometry_is_skipped() {
    let mut vertices = square(0.5);
    vertices.push(RasterVertex { screen: [f32::NAN, 0.0, 0.5, 1.0], ..vertices[0] });
    vertices.push(RasterVertex { screen: [0.0, 0.0, 0.5, 0.0], ..vertices[0] });
    vertices.push(RasterVertex { screen: [f32::INFINITY, 1.0, 0.5, 1.0], ..vertices[0] });
    let indices = vec![0, 1, 4, 0, 1, 5, 0, 1, 6, 0, 1, 99, 0, 1, 1, 0, 0, 0, 2];
    let mut geometry = flat(vertices, indices);
    geometry.draws.push(draw(50..60));
    geometry.draws.push(draw(0..0));
    let picture = render(&white(), &geometry, FrameSize::new(9, 9));
    assert!(samples(&picture, "A").iter().all(|&alpha| alpha == 0.0));
}

#[test]
fn back_faces_show_only_where_the_material_is_double_sided() {
    let clockwise = vec![0, 2, 1];
    let mut scene = white();
    let count = |scene: &Scene, geometry: &Geometry| {
        samples(&render(scene, geometry, FrameSize::new(8, 8)), "A").iter().sum::<f32>()
    };
    let mut geometry = flat(square(0.5), clockwise);
    assert_eq!(count(&scene, &geometry), 0.0);
    geometry.draws[0].is_mirrored = true;
    assert_eq!(count(&scene, &geometry), 36.0);
    geometry.draws[0].is_mirrored = false;
    scene.materials[0].double_sided = true;
    assert_eq!(count(&scene, &geometry), 36.0);
    let picture = render(&scene, &geometry, FrameSize::new(8, 8));
    assert_eq!(samples(&picture, "N.Z")[63], -1.0, "the normal is turned to the side that is seen");
}

#[test]
fn odd_targets() {
    let geometry = flat(square(0.5), SQUARE.to_vec());
    let nothing = render(&white(), &Geometry::default(), FrameSize::new(70, 3));
    assert!(samples(&nothing, "A").iter().all(|&alpha| alpha == 0.0));
    assert_eq!(samples(&render(&white(), &geometry, FrameSize::new(1, 1)), "A"), [1.0]);
    let frame = FrameSize::new(8, 8);
    let beside = PixelRect { x: 20, y: -30, width: 5, height: 4 };
    let picture = render_window(&white(), &geometry, &target(frame, beside, 1));
    assert_eq!((picture.data_window, samples(&picture, "A").len()), (beside, 20));
    let empty = PixelRect { x: 0, y: 0, width: 0, height: 0 };
    assert_eq!(samples(&render_window(&white(), &geometry, &target(frame, empty, 1)), "A").len(), 0);
    let around = PixelRect { x: -2, y: -2, width: 12, height: 12 };
    let covered: f32 = samples(&render_window(&white(), &geometry, &target(frame, around, 1)), "A").iter().sum();
    assert_eq!(covered, 64.0);
}

#[test]
fn calls_out_of_order_and_windows_too_large_are_errors() {
    let mut raster = CpuRaster::new(&white());
    let geometry = Geometry::default();
    assert!(raster.finish().is_err());
    let pass = Pass { geometry: &geometry, jitter_px: Vec2::ZERO, role: PassRole::Beauty };
    assert!(raster.draw(&pass).is_err());
    let frame = FrameSize::new(8, 8);
    let window = PixelRect { x: 0, y: 0, width: raster.max_side() + 1, height: 1 };
    assert!(raster.start(&target(frame, window, 1)).is_err());
    assert_eq!((raster.name().as_str(), raster.class().to_string().as_str()), ("CPU", "CPU"));
}

#[test]
fn surfaces_face_the_light() {
    let frame = FrameSize::new(64, 64);
    let mut geometry = ball::ball(frame, (24, 48), 0.0);
    geometry.environment = 0.0;
    geometry.lights[0].direction.0 = Vec3::NEG_X;
    let material = Material { metallic: 0.0, ..Material::default() };
    let picture = render(&Scene { materials: vec![material], ..Scene::default() }, &geometry, frame);
    let red = |x: usize, y: usize| samples(&picture, "R")[y * 64 + x];
    assert!(red(45, 32) > 0.25, "{}", red(45, 32));
    assert_eq!(red(20, 32), 0.0);
}
