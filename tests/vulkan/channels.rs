//! What single pixels hold, worked out by hand.

use super::stage::{self, Builder, CUTOUT, EYE, FAINT, FLAT, GLASS, PLAIN};
use super::support::{self, ALL, draw, pixel, samples, target};
use glam::{Vec2, Vec3, Vec4};
use pinwarp::raster::{ChannelGroup, Geometry, Target};

const SIZE: u32 = 64;
const MIDDLE: (usize, usize) = (32, 32);

/// A square that covers the whole square frame at z.
fn wall(builder: &mut Builder, z: f32, material: u32) {
    let half = (EYE - z) / EYE * 1.1;
    builder.quad(Vec3::new(-half, -half, z), (Vec3::X * (2.0 * half), Vec3::Y * (2.0 * half)), material, Vec4::ONE);
}

fn near(got: f32, wanted: f32) -> bool {
    (got - wanted).abs() <= 2e-4 * wanted.abs().max(1.0)
}

#[test]
fn nothing_is_transparent_far_and_still() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let frame = draw(&mut *vulkan, &target(5, 3), &Geometry::default());
    let names = ["R", "G", "B", "A", "depth.Z", "forward.u", "forward.v", "backward.u", "backward.v"];
    let names = names.into_iter().chain(["N.X", "N.Y", "N.Z", "id.layer", "id.object"]);
    assert_eq!(
        frame.channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>(),
        names.collect::<Vec<_>>()
    );
    for channel in &frame.channels {
        let wanted = if channel.name == "depth.Z" { 1e10 } else { 0.0 };
        assert_eq!(channel.samples, [wanted; 15], "{}", channel.name);
    }
}

#[test]
fn only_wanted_channels_come_back_in_their_order() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let mut builder = Builder::new(1.0);
    wall(&mut builder, 0.0, FLAT);
    let all = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    for groups in [vec![ChannelGroup::Id, ChannelGroup::Depth], vec![ChannelGroup::Beauty], vec![ChannelGroup::Normal]]
    {
        let wanted = Target { channels: groups.clone(), ..target(SIZE, SIZE) };
        let frame = draw(&mut *vulkan, &wanted, &builder.geometry);
        let count = |group: &ChannelGroup| [4, 1, 4, 3, 2][ALL.iter().position(|other| other == group).unwrap()];
        assert_eq!(frame.channels.len(), groups.iter().map(count).sum::<usize>());
        let positions = frame.channels.iter().map(|channel| all.channels.iter().position(|other| other == channel));
        assert!(positions.collect::<Option<Vec<_>>>().unwrap().is_sorted());
    }
}

#[test]
fn a_wall_has_the_depth_motion_normal_and_ids_of_its_place() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let mut builder = Builder::new(1.0);
    wall(&mut builder, -1.0, PLAIN);
    wall(&mut builder, 1.0, FLAT);
    let frame = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    let at = |name| pixel(&frame, name, (5, 50));
    assert!(near(at("depth.Z"), EYE - 1.0));
    // A tenth to the right at distance 2; a frame height spans 4/3 there.
    assert!(near(at("forward.u"), 0.1 / (2.0 / 1.5) * 64.0), "{}", at("forward.u"));
    assert!(near(at("forward.v"), 0.0));
    assert!(near(at("backward.u"), 0.0));
    assert!(near(at("backward.v"), -0.2 / (2.0 / 1.5) * 64.0), "{}", at("backward.v"));
    assert!(["N.X", "N.Y", "N.Z"].map(at).into_iter().zip([0.0, 0.0, 1.0]).all(|(got, wanted)| near(got, wanted)));
    assert_eq!([at("id.layer"), at("id.object")], [2.0, 2.0]);
    let color = ["R", "G", "B", "A"].map(at);
    assert!(color.into_iter().zip([0.25, 0.5, 0.75, 1.0]).all(|(got, wanted)| near(got, wanted)), "{color:?}");
}

#[test]
fn the_picture_stands_upright() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let mut builder = Builder::new(1.0);
    builder.quad(Vec3::new(-1.0, 0.5, 0.0), (Vec3::X * 0.5, Vec3::Y * 0.5), FLAT, Vec4::ONE);
    let frame = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    let lit = |at| pixel(&frame, "A", at);
    assert_eq!([lit((2, 2)), lit((61, 2)), lit((2, 61)), lit((61, 61))], [1.0, 0.0, 0.0, 0.0]);
    // Its edges lie on whole pixels: a quarter of each side, not a row more or less.
    assert_eq!(samples(&frame, "A").iter().sum::<f32>(), 256.0);
}

#[test]
fn panes_lie_over_each_other_and_count_in_data_from_half_on() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let mut builder = Builder::new(1.0);
    wall(&mut builder, -1.0, FLAT);
    wall(&mut builder, 0.0, GLASS);
    wall(&mut builder, 1.0, FAINT);
    // Hidden by the wall.
    builder.quad(Vec3::new(-9.0, -9.0, -2.0), (Vec3::X * 18.0, Vec3::Y * 18.0), GLASS, Vec4::ONE);
    let frame = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    let over = |top: Vec3, alpha: f32, below: Vec3| top * alpha + below * (1.0 - alpha);
    let glass = over(Vec3::new(0.1, 0.4, 0.9), 0.6, Vec3::new(0.25, 0.5, 0.75));
    let wanted = over(Vec3::new(0.9, 0.1, 0.1), 0.3, glass);
    for (name, wanted) in ["R", "G", "B"].into_iter().zip(wanted.to_array()) {
        assert!(near(pixel(&frame, name, MIDDLE), wanted), "{name}: {}", pixel(&frame, name, MIDDLE));
    }
    assert!(near(pixel(&frame, "A", MIDDLE), 1.0));
    assert!(near(pixel(&frame, "depth.Z", MIDDLE), EYE), "the glass, not the faint pane before it");
    assert_eq!(pixel(&frame, "id.object", MIDDLE), 2.0);
}

#[test]
fn data_shows_the_nearest_pane_whatever_the_order() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let mut builder = Builder::new(1.0);
    wall(&mut builder, 1.0, GLASS);
    wall(&mut builder, 0.0, GLASS);
    let frame = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    assert!(near(pixel(&frame, "depth.Z", MIDDLE), EYE - 1.0));
    // Both panes colour, as no pane hides another.
    assert!(near(pixel(&frame, "A", MIDDLE), 1.0 - 0.4 * 0.4));
}

#[test]
fn cut_outs_are_there_or_not() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let mut builder = Builder::new(1.0);
    wall(&mut builder, 0.0, CUTOUT);
    let frame = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    let alpha = samples(&frame, "A");
    assert!(alpha.iter().all(|&alpha| alpha == 0.0 || alpha == 1.0));
    let share = alpha.iter().sum::<f32>() / alpha.len() as f32;
    assert!((0.4..0.6).contains(&share), "a chequer: {share}");
    let ids = samples(&frame, "id.object");
    assert!(alpha.iter().zip(ids).all(|(alpha, id)| alpha == id), "data and colour have the same holes");
}

#[test]
fn back_faces_show_only_where_materials_are_double_sided() {
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let turned = |material, is_mirrored| {
        let mut builder = Builder::new(1.0);
        let corners = builder.quad_corners(Vec3::new(-2.0, -2.0, 0.0), (Vec3::Y * 4.0, Vec3::X * 4.0), Vec4::ONE);
        builder.draw(&corners, material, is_mirrored);
        builder.geometry
    };
    let target = target(SIZE, SIZE);
    let mut shown = |material, is_mirrored| {
        let frame = draw(&mut *vulkan, &target, &turned(material, is_mirrored));
        (samples(&frame, "A").iter().sum::<f32>() > 0.0, pixel(&frame, "N.Z", MIDDLE).round())
    };
    assert_eq!(shown(FLAT, false), (false, 0.0));
    // The vertices' normals point away (-z); on a mirrored front they are what is seen.
    assert_eq!(shown(FLAT, true), (true, -1.0));
    assert_eq!(shown(GLASS, false), (true, 1.0), "turned towards the viewer");
}

#[test]
fn textures_far_away_are_averaged_in_linear_light() {
    let mut builder = Builder::new(1.0);
    let corners = builder.quad_corners(Vec3::new(-1.0, -1.0, 0.0), (Vec3::X * 2.0, Vec3::Y * 2.0), Vec4::ONE);
    builder.draw(&corners, 1, false);
    // 16 texels a repeat, 40 repeats over 64 pixels: every pixel sees a tenth of the image or more.
    builder.geometry.vertices.iter_mut().for_each(|vertex| vertex.uv = vertex.uv.map(|uv| uv * 40.0));
    let mut scene = stage::scene();
    let cutout = &mut scene.materials[CUTOUT as usize];
    (cutout.unlit, cutout.alpha) = (true, pinwarp::scene::AlphaMode::Opaque);
    let texel = |x: u32, y: u32| if (x + y).is_multiple_of(2) { [255, 255, 255, 255] } else { [0, 0, 0, 255] };
    scene.images[0].rgba = (0..256).flat_map(|at| texel(at % 16, at / 16)).collect();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let frame = draw(&mut *vulkan, &target(SIZE, SIZE), &builder.geometry);
    let red = samples(&frame, "R");
    assert!(red.iter().all(|red| (red - 0.5).abs() < 0.02), "half the light, not half the code");
}

#[test]
fn a_whole_pixel_of_jitter_moves_the_picture_a_pixel_right_and_down() {
    use pinwarp::raster::PassRole;
    let Some(mut vulkan) = support::open(&stage::scene()) else { return };
    let (target, geometry) = (target(SIZE, SIZE), stage::everything(1.0));
    let still = draw(&mut *vulkan, &target, &geometry);
    let passes = [(&geometry, Vec2::new(1.0, 2.0), PassRole::BeautyAndData)];
    let moved = support::draw_passes(&mut *vulkan, &target, &passes);
    let ids = |frame, x, y| pixel(frame, "id.object", (x, y));
    let wrong = (2..64).flat_map(|y| (1..64).map(move |x| (x, y)));
    let wrong = wrong.filter(|&(x, y)| ids(&moved, x, y) != ids(&still, x - 1, y - 2)).count();
    assert!(wrong < 20, "{wrong} pixels");
    // Motion is measured from the surface, not from the jittered pixel.
    let differences =
        (2..64).map(|y| (pixel(&moved, "forward.u", (20, y)) - pixel(&still, "forward.u", (19, y - 2))).abs());
    assert!(differences.filter(|&difference| difference > 0.01).count() < 4);
}
