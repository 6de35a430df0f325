//! Data channels are one exact sample at the pixel centre and mid-shutter: the number of samples does not change them, and
//! ids agree with the Cryptomatte.

use super::assets::asset;
use super::support::{Studio, at, pixels};
use crate::internal::skip::skip;
use pinwarp::image::cryptomatte::MatteId;
use pinwarp::image::{Frame, read_exr};
use pinwarp::pipeline::PreparedShot;
use pinwarp::raster::cpu::CpuRaster;
use pinwarp::raster::vulkan::VulkanRaster;
use pinwarp::raster::{ChannelGroup, DeviceChoice, Raster, RasterError};
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
        // One frame is drawn.
        shot.layers.iter_mut().for_each(|layer| layer.settings.temporal = 0.0);
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

/// A case that is prepared, and a device that draws it.
struct Easel<R> {
    studio: Studio,
    prepared: PreparedShot,
    device: R,
}

impl<R: Raster> Easel<R> {
    /// `None` if `open` finds no device.
    fn new(case: &Case, open: impl FnOnce(&PreparedShot) -> Option<R>) -> Option<Self> {
        let studio = Studio::of_shot(case.shot.clone());
        let prepared = studio.prepared();
        let device = open(&prepared)?;
        Some(Self { studio, prepared, device })
    }

    /// A frame of the case with so many samples.
    fn draw(&mut self, frame: i32, samples: u32, channels: &[ChannelGroup]) -> Frame {
        let shot = &mut self.prepared.shot;
        (shot.samples, shot.output.channels) = (samples, channels.to_vec());
        let files = self.studio.files_on(&mut self.device, &mut self.prepared, &[frame]);
        read_exr(&files[0]).expect("the frame is readable")
    }
}

fn cpu(case: &Case) -> Easel<CpuRaster> {
    Easel::new(case, |prepared| Some(CpuRaster::new(&prepared.scene))).expect("there always is a CPU")
}

/// `None`: there is no Vulkan device, said so.
fn vulkan(case: &Case) -> Option<Easel<VulkanRaster>> {
    Easel::new(case, |prepared| match VulkanRaster::open(&DeviceChoice::Vulkan, &prepared.scene) {
        Err(error @ RasterError::NoDevice { .. }) if std::env::var_os("PINWARP_REQUIRE_VULKAN").is_none() => {
            skip(&error.to_string());
            None
        }
        opened => Some(opened.expect("a device")),
    })
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
fn assert_samples_do_not_matter<R: Raster>(part: f32, easel: impl Fn(&Case) -> Option<Easel<R>>) {
    for case in cases() {
        let channels = [&[ChannelGroup::Beauty][..], &DATA].concat();
        let Some(mut easel) = easel(&case) else { return };
        let one = easel.draw(case.frame, 1, &channels);
        for samples in [4, 11, 16] {
            let several = easel.draw(case.frame, samples, &channels);
            let (covered, different) = differences(&one, &several, part);
            assert!(covered > 200, "{}: {covered} pixels", case.name);
            assert!(different.is_empty(), "{}, {samples} samples: {different:?}", case.name);
        }
    }
}

#[test]
fn data_are_the_same_bits_for_every_number_of_samples() {
    assert_samples_do_not_matter(0.0, |case| Some(cpu(case)));
}

#[test]
fn data_of_a_device_are_the_same_for_every_number_of_samples() {
    // Shaders of colour with data and of data alone may round apart.
    assert_samples_do_not_matter(1e-5, vulkan);
}

#[test]
fn data_of_another_time_are_distinguished() {
    let all = cases();
    let case = all.iter().find(|case| case.name.starts_with("walker")).expect("a case");
    let mut easel = cpu(case);
    let [one, other] = [case.frame, case.frame + 1].map(|frame| easel.draw(frame, 1, &DATA));
    let (_, different) = differences(&one, &other, 0.0);
    assert!(different.len() > 100, "{}", different.len());
}

#[test]
fn ids_are_the_first_rank_of_the_cryptomatte_inside_shapes() {
    for case in cases() {
        let mut easel = cpu(&case);
        let frame = easel.draw(case.frame, 16, &[ChannelGroup::Beauty, ChannelGroup::Id, ChannelGroup::Cryptomatte]);
        let mut inside = 0;
        for (x, y) in pixels(&frame).filter(|&(x, y)| at(&frame, "CryptoObject00.G", x, y) > 0.999) {
            let object = at(&frame, "id.object", x, y);
            assert!(object >= 1.0, "{}: no id at {x}, {y}", case.name);
            let name = &easel.prepared.scene.nodes[object as usize - 1].name;
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
        let Some(mut device) = vulkan(&case) else { return };
        let [cpu, device] = [cpu(&case).draw(case.frame, 4, &DATA), device.draw(case.frame, 4, &DATA)];
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
