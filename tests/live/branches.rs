//! Lattices that branch, as hosts render them.

use pinwarp::image::{Frame, read_exr};
use pinwarp::live::{
    Alpha, Controls, Mix, OwnPins, Picture, Render, ShapeSource, ShotShape, Warp, render, stmap, warp,
};
use pinwarp::pipeline::{PreparedShot, RenderOptions};
use pinwarp::plate::Filter;
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use pinwarp::space::{FrameSize, PixelRect};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// The girl waves.
const FRAME: i32 = 7;

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes/puppet/shot.toml")
}

/// The puppet's frame as the program renders it, and the handles of its lattice.
fn rendered(strength: f64) -> (Frame, [usize; 2]) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut shot = Shot::read(&path()).expect("a right shot");
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
    let (plate, dims) = rendered(0.0);
    let (expected, _) = rendered(1.0);
    let size = FrameSize::new(expected.display.width, expected.display.height);
    let window = size.window();
    let shape = ShotShape {
        path: path(),
        camera: None,
        layer: None,
        frame: f64::from(FRAME),
        pin_frame: 1,
        own_pins: OwnPins::Act,
    };
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
    assert!(lost < 100, "{lost}");
    let tile = PixelRect { x: 100, y: 300, width: 300, height: 200 };
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
