//! Lattices that branch, as hosts render them.

use super::drawn_girl::small_girl;
use pinwarp::image::{Frame, read_exr};
use pinwarp::lattice::Basis;
use pinwarp::live::{
    Alpha, Controls, Mix, OwnPins, Picture, Pin, Render, ShapeSource, ShotShape, Warp, render, stmap, warp,
};
use pinwarp::pipeline::{PreparedShot, RenderOptions};
use pinwarp::plate::Filter;
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use pinwarp::space::{FrameSize, PixelRect, ScreenPoint};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The girl waves.
const FRAME: i32 = 7;

/// The girl's frame as the program renders it, and the handles of its lattice.
fn rendered(path: &Path, strength: f64) -> (Frame, [usize; 2]) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut shot = Shot::read(path).expect("a right shot");
    shot.output.path = folder.path().join("f.####.exr");
    shot.layers[0].strength = strength;
    // A host solves each frame alone.
    shot.layers[0].settings.temporal = 0.0;
    let prepared = PreparedShot::new(shot).expect("the picture is there");
    let options = RenderOptions { frames: vec![FRAME], device: DeviceChoice::Cpu, ..RenderOptions::default() };
    let summary = pinwarp::pipeline::render(&prepared, &options, &AtomicBool::new(false), &|_| {}).expect("rendered");
    assert_eq!(summary.failed, 0);
    let [across, up, _] = prepared.shot.layers[0].space.dims();
    (read_exr(&folder.path().join(format!("f.{FRAME:04}.exr"))).expect("a frame"), [across, up])
}

/// Red, green, blue and alpha over the whole frame.
fn planes(frame: &Frame, window: PixelRect) -> Vec<Vec<f32>> {
    let plane =
        |name: &&str| frame.data_window.resized_samples(&frame.channel(name).expect("a channel").samples, window, 0.0);
    ["R", "G", "B", "A"].iter().map(plane).collect()
}

fn warped(warp: &Warp, source: &Picture, size: FrameSize, window: PixelRect) -> Vec<Vec<f32>> {
    let job = Render {
        frame: size,
        window,
        source,
        mask: None,
        background: None,
        filter: Filter::Ewa,
        mix: Mix::FULL,
        abort: &|| false,
    };
    render(warp, &job).expect("rendered")
}

#[test]
fn a_host_shows_what_the_program_renders() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("shot.toml");
    std::fs::write(&path, small_girl(folder.path())).expect("written");
    let (plate, dims) = rendered(&path, 0.0);
    let (expected, _) = rendered(&path, 1.0);
    let size = FrameSize::new(expected.display.width, expected.display.height);
    let window = size.window();
    let shape =
        ShotShape { path, camera: None, layer: None, frame: f64::from(FRAME), pin_frame: 1, own_pins: OwnPins::Act };
    let controls = Controls { dims, ..Controls::default() };
    let warp = warp(&controls, &ShapeSource::Shot(shape), size).expect("solves");
    assert!(warp.parts.len() > 1 && !warp.is_identity());
    let source = planes(&plate, window);
    let source =
        Picture { window, planes: source.iter().map(|plane| &plane[..]).collect(), alpha: Alpha::Premultiplied };
    let seen = warped(&warp, &source, size, window);
    let expected = planes(&expected, window);
    let off = |seen: &[Vec<f32>]| {
        let apart = |pixel: &usize| (0..4).any(|k| (seen[k][*pixel] - expected[k][*pixel]).abs() > 0.1);
        (0..window.area()).filter(apart).count()
    };
    let found = off(&seen);
    println!("{found} of {} pixels differ", window.area());
    assert!(found < 150, "{found}");
    // A host that takes the field alone moves all with the largest branch.
    let mut one = (*warp).clone();
    one.parts.clear();
    assert!(off(&planes_of_map(&one, &source, size)) > 2000);
    // The map shows them, with hard edges.
    let map = planes_of_map(&warp, &source, size);
    let is_lost = |pixel: &usize| (expected[3][*pixel] > 0.99) != (map[3][*pixel] > 0.5);
    let lost = (0..window.area()).filter(|pixel| expected[3][*pixel] > 0.99 || expected[3][*pixel] < 0.01);
    let lost = lost.filter(is_lost).count();
    assert!(lost < 25, "{lost}");
    let tile = PixelRect { x: 50, y: 150, width: 150, height: 100 };
    let part = warped(&warp, &source, size, tile);
    for (whole, part) in seen.iter().zip(&part) {
        assert_eq!(&window.resized_samples(whole, tile, 0.0), part, "tiles are parts of the whole");
    }
}

/// The picture that an STMap shows, by the nearest sample.
fn planes_of_map(warp: &Warp, source: &Picture, size: FrameSize) -> Vec<Vec<f32>> {
    let window = size.window();
    let map = stmap(warp, size, window);
    let [width, height] = [size.width, size.height].map(|side| side as f32);
    let sample = |plane: &[f32], pixel: usize| {
        if map.coverage[pixel] == 0.0 {
            return 0.0;
        }
        let place = [(map.u[pixel] * width).floor() as i32, ((1.0 - map.v[pixel]) * height).floor() as i32];
        window.sample_index(place).map_or(0.0, |place| plane[place])
    };
    let planes = source.planes.iter();
    planes.map(|plane| (0..window.area()).map(|pixel| sample(plane, pixel)).collect()).collect()
}

/// An arm that is cut from the body, laid over it, in front or behind as the pin of the shot says, whoever moves it.
#[test]
fn the_order_of_the_pins_of_a_shot_acts_whoever_moves_them() {
    const SIZE: FrameSize = FrameSize::new(96, 64);
    let folder = tempfile::tempdir().expect("a folder");
    let code =
        |x: u32, y: u32, columns: std::ops::Range<u32>| 255 * u8::from(columns.contains(&x) && (10..54).contains(&y));
    let pixel = |x: u32, y: u32| image::Rgba([code(x, y, 10..40), 0, code(x, y, 40..56), code(x, y, 10..56)]);
    let picture = image::RgbaImage::from_fn(96, 64, pixel);
    picture.save(folder.path().join("arm.png")).expect("saved");
    let source: Vec<Vec<f32>> =
        (0..4).map(|plane| picture.pixels().map(|pixel| f32::from(pixel[plane]) / 255.0).collect()).collect();
    let place = |x: f64, y: f64| ScreenPoint::new(x / 64.0, 1.0 - y / 64.0);
    let (held, hand, by) = ([(15.0, 15.0), (15.0, 48.0), (35.0, 30.0)], (50.0, 40.0), -25.0);
    let shot = |order: i32| {
        let pin = |(x, y): (f64, f64), more: &str| {
            let ScreenPoint(at) = place(x, y);
            format!("[[layer.pin]]\nanchor = {{ screen = [{}, {}], frame = 1 }}\n{more}\n", at.x, at.y)
        };
        let moved = format!("order = {order}\nkeys = [{{ frame = 1, offset = [{}, 0.0] }}]", by / 64.0);
        let pins = held.map(|at| pin(at, "")).concat() + &pin(hand, &moved);
        let lattice = "{ dims = [24, 24], cuts = [[[0.625, 0.0], [0.625, 1.0]]] }";
        let head = "version = 1\nimage = 'arm.png'\nframes = { first = 1, last = 2 }\n";
        let path = folder.path().join(format!("{order}.toml"));
        std::fs::write(&path, format!("{head}[[layer]]\nlattice = {lattice}\n{pins}")).expect("written");
        path
    };
    let shows_arm = |order: i32, own_pins: OwnPins, moved: &[((f64, f64), f64)]| {
        let shape = ShotShape { path: shot(order), camera: None, layer: None, frame: 1.0, pin_frame: 1, own_pins };
        let pins = moved.iter().map(|&((x, y), by)| Pin::new(place(x, y), place(x + by, y))).collect();
        let controls = Controls { dims: [24, 24], pins, ..Controls::default() };
        let warp = warp(&controls, &ShapeSource::Shot(shape), SIZE).expect("solves");
        let window = SIZE.window();
        let planes = source.iter().map(|plane| &plane[..]).collect();
        let seen = warped(&warp, &Picture { window, planes, alpha: Alpha::Premultiplied }, SIZE, window);
        let [red, blue] = [0, 2].map(|plane| seen[plane][40 * 96 + 25]);
        assert!((red - blue).abs() > 0.5, "red {red}, blue {blue}");
        blue > red
    };
    for order in [-1, 1] {
        assert_eq!(shows_arm(order, OwnPins::Act, &[]), order > 0, "its own pins");
        assert_eq!(shows_arm(order, OwnPins::Act, &[((20.0, 30.0), 0.0)]), order > 0, "its own pins and another");
        // The host lists its pins in another order.
        let moved = [(hand, by), (held[0], 0.0), (held[1], 0.0), (held[2], 0.0)];
        assert_eq!(shows_arm(order, OwnPins::LeftOut, &moved), order > 0, "the pins of the host");
    }
    // A basis that cannot branch would ignore the cut.
    let own_pins = OwnPins::Act;
    let shape = ShotShape { path: shot(1), camera: None, layer: None, frame: 1.0, pin_frame: 1, own_pins };
    let controls = Controls { dims: [24, 24], basis: Basis::Bernstein, ..Controls::default() };
    let told = warp(&controls, &ShapeSource::Shot(shape), SIZE).expect_err("it does not fit").to_string();
    assert!(told.contains("1.toml") && told.contains("`lattice.cuts`") && told.contains("B-spline"), "{told}");
}
