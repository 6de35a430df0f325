//! Whole pictures against the CPU twin, and the same picture drawn in different ways.

use super::limits::assert_alike;
use super::stage::{self, everything};
use super::support::{self, draw, target};
use glam::Vec3;
use pinwarp::raster::Target;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::space::{FrameSize, PixelRect};

const SIZE: (u32, u32) = (320, 180);
const ASPECT: f32 = 320.0 / 180.0;

#[test]
fn every_kind_of_material_looks_as_on_the_cpu() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let (target, geometry) = (target(SIZE.0, SIZE.1), everything(ASPECT));
    let ours = draw(&mut *vulkan, &target, &geometry);
    support::dump("everything", &ours);
    assert_alike(&ours, &draw(&mut CpuRaster::new(&scene), &target, &geometry), 1.0);
}

#[test]
fn a_missing_object_is_noticed() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let (target, geometry) = (target(SIZE.0, SIZE.1), everything(ASPECT));
    let mut lacking = geometry.clone();
    lacking.draws.remove(4);
    let ours = draw(&mut *vulkan, &target, &lacking);
    let twin = draw(&mut CpuRaster::new(&scene), &target, &geometry);
    let compared = std::panic::catch_unwind(|| assert_alike(&ours, &twin, 1.0));
    assert!(compared.is_err(), "the smallest object is missing, and the limits do not see it");
}

#[test]
fn an_orthographic_view_and_wide_pixels_look_as_on_the_cpu() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let frame = FrameSize { width: 240, height: 180, pixel_aspect: 4.0 / 3.0 };
    let target = Target { frame, window: frame.window(), ..target(240, 180) };
    let mut geometry = everything(ASPECT);
    geometry.parallel_view = Some(Vec3::Z);
    let ours = draw(&mut *vulkan, &target, &geometry);
    assert_alike(&ours, &draw(&mut CpuRaster::new(&scene), &target, &geometry), 1.2);
}

#[test]
fn the_same_frame_has_the_same_bytes() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    let (target, geometry) = (target(SIZE.0, SIZE.1), everything(ASPECT));
    let first = draw(&mut *vulkan, &target, &geometry);
    // Another frame in between leaves other contents in every image.
    draw(&mut *vulkan, &support::target(100, 170), &geometry);
    assert!(first == draw(&mut *vulkan, &target, &geometry), "drawn again with the same raster");
    let Some(mut other) = support::open(&scene) else { return };
    assert!(first == draw(&mut *other, &target, &geometry), "drawn with another raster");
}

#[test]
fn tiles_make_up_the_frame() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    // More than the frame on all sides.
    let window = PixelRect { x: -20, y: -10, width: 360, height: 200 };
    let whole = Target { window, ..target(SIZE.0, SIZE.1) };
    let geometry = everything(ASPECT);
    let full = draw(&mut *vulkan, &whole, &geometry);
    let mut stitched = full.clone();
    stitched.channels.iter_mut().for_each(|channel| channel.samples.fill(f32::NAN));
    for tile in window.tiles(77) {
        let part = draw(&mut *vulkan, &Target { window: tile, ..whole.clone() }, &geometry);
        assert_eq!(part.data_window, tile);
        support::paste(&mut stitched, &part);
    }
    // Positions are rounded to fractions of a pixel after another offset in each tile.
    assert_alike(&stitched, &full, 0.3);
}

#[test]
fn odd_sizes_look_as_on_the_cpu() {
    let scene = stage::scene();
    let Some(mut vulkan) = support::open(&scene) else { return };
    for (width, height) in [(1, 1), (3, 1), (1, 5), (67, 33), (401, 3)] {
        let target = target(width, height);
        let geometry = everything(width as f32 / height as f32);
        let ours = draw(&mut *vulkan, &target, &geometry);
        // A small picture is mostly edges.
        assert_alike(&ours, &draw(&mut CpuRaster::new(&scene), &target, &geometry), 8.0);
    }
}
