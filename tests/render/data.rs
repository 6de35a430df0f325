//! Data channels are one exact sample at the pixel centre and mid-shutter: the number of samples does not change them, and
//! ids agree with the Cryptomatte.

use super::assets::asset;
use super::support::{Studio, at, pixels};
use pinwarp::image::Frame;
use pinwarp::image::cryptomatte::MatteId;
use pinwarp::pipeline::PreparedShot;
use pinwarp::raster::vulkan::VulkanRaster;
use pinwarp::raster::{ChannelGroup, DeviceChoice, RasterError};
use pinwarp::shot::{Shot, Shutter};
use pinwarp::space::FrameSize;
use std::path::Path;

/// What a shot may write; a pixel is data of one sample.
const DATA: [ChannelGroup; 4] = [ChannelGroup::Depth, ChannelGroup::Motion, ChannelGroup::Normal, ChannelGroup::Id];

/// A shot with its frame, small, with the shutter open or closed.
struct Case {
    name: String,
    shot: Shot,
    frame: i32,
}

fn cases() -> Vec<Case> {
    let small = |mut shot: Shot, angle: f64| {
        shot.size = FrameSize::new((shot.size.aspect() * 72.0).round() as u32, 72);
        shot.shutter = Shutter { angle, phase: -angle / 2.0 };
        shot
    };
    let of_scene = |scene: &str, frame, angle| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene).join("shot.toml");
        let shot = small(Shot::read(&path).expect("a right shot"), angle);
        Case { name: format!("{scene}, shutter {angle}"), shot, frame }
    };
    let of_asset = |file: &str, frame, angle| {
        let path = asset(file)?;
        let text = format!(
            "version = 1\nscene = {path:?}\nframes = {{ first = 1, last = 30, rate = 24 }}\nsize = [128, 72]\n"
        );
        let shot = Shot::parse(&text, Path::new("shot.toml")).expect("a right shot");
        Some(Case { name: format!("{file}, shutter {angle}"), shot: small(shot, angle), frame })
    };
    let mut cases = vec![
        of_scene("teapot", 7, 0.0),
        of_scene("teapot", 7, 180.0),
        of_scene("gingerman", 8, 0.0),
        of_scene("hare", 8, 180.0),
        of_scene("walker", 7, 180.0),
    ];
    let characters =
        [("kaykit/Knight.glb", 5, 180.0), ("gltf-samples/Fox.glb", 9, 180.0), ("gltf-samples/Fox.glb", 3, 0.0)];
    cases.extend(characters.into_iter().filter_map(|(file, frame, angle)| of_asset(file, frame, angle)));
    cases
}

/// The frame of a case with so many samples, on the CPU.
fn drawn(case: &Case, samples: u32, channels: &[ChannelGroup]) -> Frame {
    let mut studio = Studio::of_shot(case.shot.clone());
    (studio.shot.samples, studio.shot.output.channels) = (samples, channels.to_vec());
    studio.frame(case.frame)
}

/// The same on a Vulkan device; `None`: there is none, said so.
fn drawn_by_vulkan(case: &Case, samples: u32, channels: &[ChannelGroup]) -> Option<Frame> {
    let mut studio = Studio::of_shot(case.shot.clone());
    (studio.shot.samples, studio.shot.output.channels) = (samples, channels.to_vec());
    match VulkanRaster::open(&DeviceChoice::Vulkan, &studio.prepared().scene) {
        Err(error @ RasterError::NoDevice { .. }) if std::env::var_os("PINWARP_REQUIRE_VULKAN").is_none() => {
            eprintln!("SKIPPED: {error}");
            return None;
        }
        opened => drop(opened.expect("a device")),
    }
    let open = |prepared: &PreparedShot| VulkanRaster::open(&DeviceChoice::Vulkan, &prepared.scene).expect("a device");
    let (files, _) = studio.files_by(&[case.frame], open);
    Some(pinwarp::image::read_exr(&files[0]).expect("the frame is readable"))
}

fn data_names() -> impl Iterator<Item = &'static str> {
    DATA.iter().flat_map(|group| group.channels()).map(|spec| spec.name)
}

/// Pixels with data; and those whose samples differ between two frames by more than a part of them.
fn differences(one: &Frame, other: &Frame, part: f32) -> (usize, Vec<(i32, i32)>) {
    let covered = pixels(one).filter(|&(x, y)| at(one, "depth.Z", x, y) < 1e10).count();
    let differs = |&(x, y): &(i32, i32)| {
        data_names().any(|name| {
            let (a, b) = (at(one, name, x, y), at(other, name, x, y));
            (a - b).abs() > part * a.abs().max(b.abs()).max(1.0)
        })
    };
    (covered, pixels(one).filter(differs).collect())
}

/// Every number of samples draws the data of one sample.
fn assert_samples_do_not_matter(part: f32, draw: impl Fn(&Case, u32, &[ChannelGroup]) -> Option<Frame>) {
    for case in cases() {
        let channels = [&[ChannelGroup::Beauty][..], &DATA].concat();
        let Some(one) = draw(&case, 1, &channels) else { return };
        for samples in [4, 11, 16] {
            let Some(several) = draw(&case, samples, &channels) else { return };
            let (covered, different) = differences(&one, &several, part);
            assert!(covered > 200, "{}: {covered} pixels", case.name);
            assert!(different.is_empty(), "{}, {samples} samples: {different:?}", case.name);
        }
    }
}

#[test]
fn data_are_the_same_bits_for_every_number_of_samples() {
    assert_samples_do_not_matter(0.0, |case, samples, channels| Some(drawn(case, samples, channels)));
}

#[test]
fn data_of_a_device_are_the_same_for_every_number_of_samples() {
    // Shaders of colour with data and of data alone may round apart.
    assert_samples_do_not_matter(1e-5, drawn_by_vulkan);
}

#[test]
fn data_of_another_time_are_distinguished() {
    let all = cases();
    let case = all.iter().find(|case| case.name.starts_with("walker")).expect("a case");
    let other = Case { frame: case.frame + 1, name: case.name.clone(), shot: case.shot.clone() };
    let (_, different) = differences(&drawn(case, 1, &DATA), &drawn(&other, 1, &DATA), 0.0);
    assert!(different.len() > 100, "{}", different.len());
}

#[test]
fn ids_are_the_first_rank_of_the_cryptomatte_inside_shapes() {
    for case in cases() {
        let frame = drawn(&case, 16, &[ChannelGroup::Beauty, ChannelGroup::Id, ChannelGroup::Cryptomatte]);
        let prepared = PreparedShot::new(case.shot.clone()).expect("a right shot");
        let mut inside = 0;
        for (x, y) in pixels(&frame).filter(|&(x, y)| at(&frame, "CryptoObject00.G", x, y) > 0.999) {
            let object = at(&frame, "id.object", x, y);
            assert!(object >= 1.0, "{}: no id at {x}, {y}", case.name);
            let name = &prepared.scene.nodes[object as usize - 1].name;
            let first = MatteId::from_sample(at(&frame, "CryptoObject00.R", x, y));
            assert_eq!(MatteId::of_name(name), first, "{}: '{name}' at {x}, {y}", case.name);
            inside += 1;
        }
        assert!(inside > 150, "{}: {inside} pixels", case.name);
    }
}

/// Pixels of a case, how many of them differ between CPU and device by more than rounding, and by how much ids do.
#[test]
fn cpu_and_device_draw_the_same_data() {
    for case in cases() {
        let cpu = drawn(&case, 4, &DATA);
        let Some(device) = drawn_by_vulkan(&case, 4, &DATA) else { return };
        let (covered, different) = differences(&cpu, &device, 2e-3);
        eprintln!("{}: {} of {covered} pixels differ: {different:?}", case.name, different.len());
        // Where two surfaces cross or touch, rounding of their z decides; edges are on one grid.
        assert!(different.len() * 500 <= covered, "{}: {} of {covered}: {different:?}", case.name, different.len());
    }
}

#[test]
fn files_do_not_name_the_machine() {
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut studio = Studio::teapot(96, 54);
        studio.shot.samples = 4;
        pool.install(|| std::fs::read(&studio.files(&[3])[0]).expect("the frame is there"))
    };
    let one = bytes(1);
    assert!(one == bytes(3), "the same shot, the same bytes");
    let text = String::from_utf8_lossy(&one);
    assert!(text.contains("\"device\":\"CPU\"") && !text.contains("thread"));
}
