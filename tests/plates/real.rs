//! Files of other programs: every part, view, channel, window and attribute comes out again.

use crate::assets::asset;
use pinwarp::image::{Plate, Storage, read_plate};
use pinwarp::pipeline::{Existing, PlateWarp, PreparedShot, WarpDirection, WarpEvent, WarpJob, warp_frames};
use pinwarp::plate::WarpSettings;
use pinwarp::raster::DeviceChoice;
use pinwarp::shot::Shot;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;

/// A shot over a plate whose middle is pulled to the right and up, more from frame to frame.
fn shot(size: [u32; 2], last: i32) -> Shot {
    let [width, height] = size;
    let aspect = f64::from(width) / f64::from(height);
    let text = format!(
        "plate = 'plate.####.exr'\nframes = {{ first = 1, last = {last} }}\nsize = [{width}, {height}]\n\
         [[layer]]\nlattice = {{ dims = [8, 8] }}\n\
         [[layer.pin]]\nanchor = {{ screen = [{x}, 0.55] }}\n\
         keys = [{{ frame = 0, offset = [0.0, 0.0] }}, {{ frame = 4, offset = [0.1, 0.05], rotate = 10 }}]\n\
         [[layer.pin]]\nanchor = {{ screen = [{left}, 0.2] }}\n",
        x = aspect * 0.55,
        left = aspect * 0.1
    );
    Shot::parse(&text, Path::new("shot.toml")).expect("a right shot")
}

/// Warps files of other programs; what came out, and what was told.
fn warp(plate: &Path, shot: Shot) -> (TempDir, Vec<WarpEvent>) {
    let folder = TempDir::new().expect("a folder");
    let prepared = PreparedShot::new(shot).expect("a shot over a plate");
    let job = WarpJob {
        plate: plate.to_owned(),
        output: folder.path().join("w.####.exr"),
        warp: PlateWarp::Shot(&prepared),
        settings: WarpSettings::default(),
        direction: WarpDirection::Forward,
        layers: Vec::new(),
        frames: Vec::new(),
        existing: Existing::Refuse,
        device: DeviceChoice::Cpu,
        durability: pinwarp::image::Durability::Cached,
        inputs: Vec::new(),
    };
    let events = Mutex::new(Vec::new());
    let tell = |event| events.lock().expect("no test panics while it tells").push(event);
    let summary = warp_frames(&job, &AtomicBool::new(false), &tell).expect("warped");
    let events = events.into_inner().expect("all threads ended");
    assert_eq!(summary.failed, 0, "{events:?}");
    (folder, events)
}

/// Everything about a plate that no warp may change, a line each.
fn inventory(plate: &Plate) -> Vec<String> {
    let mut lines = vec![format!("{:?} {}", plate.display, plate.pixel_aspect)];
    for part in &plate.parts {
        lines.push(format!("part {:?} of view {:?}", part.name, part.view));
        lines.extend(part.channels.iter().map(|channel| format!("  {} {:?}", channel.name, channel.storage)));
        let mut texts = part.texts("");
        texts.remove("pinwarp");
        texts.remove("pinwarpChecksum");
        lines.extend(texts.iter().map(|(name, text)| format!("  {name}: {text}")));
    }
    lines
}

/// What came out holds what went in, and no sample that is not a number.
fn check_frame(before: &Path, after: &Path) {
    let [before, after] = [before, after].map(|path| read_plate(path).expect("a plate"));
    assert_eq!(inventory(&before), inventory(&after));
    for (old, new) in before.parts.iter().zip(&after.parts) {
        for (old, new) in old.channels.iter().zip(&new.channels).filter(|(old, _)| old.storage != Storage::Uint) {
            let bad = |samples: &[f32]| samples.iter().filter(|sample| sample.is_nan()).count();
            assert!(bad(&new.samples) <= bad(&old.samples), "{} has new samples that are no numbers", new.name);
        }
        assert!(
            old.channels.iter().zip(&new.channels).any(|(old, new)| old.samples != new.samples),
            "{:?} moved",
            old.name
        );
    }
}

/// Every channel of every part was taken for something, once.
fn check_told(events: &[WarpEvent], plate: &Plate) {
    let told = events.iter().find_map(|event| match event {
        WarpEvent::FrameDone(report) if !report.channels.is_empty() => Some(&report.channels),
        _ => None,
    });
    let told: Vec<_> =
        told.expect("semantics are told").iter().map(|told| (told.part.clone(), told.channel.clone())).collect();
    let there = plate
        .parts
        .iter()
        .flat_map(|part| part.channels.iter().map(|channel| (part.name.clone(), channel.name.clone())));
    assert_eq!(told, there.collect::<Vec<_>>());
}

fn beachball(name: &str) -> Option<PathBuf> {
    let folder = asset("openexr-images/Beachball")?;
    Some(folder.join(name))
}

#[test]
fn frames_in_many_parts_go_through() {
    let Some(plate) = beachball("multipart.####.exr") else { return };
    let (folder, events) = warp(&plate, shot([2048, 1556], 2));
    for frame in 1..=2 {
        let name = format!("multipart.{frame:04}.exr");
        check_frame(&plate.with_file_name(name), &folder.path().join(format!("w.{frame:04}.exr")));
    }
    check_told(&events, &read_plate(&plate.with_file_name("multipart.0001.exr")).expect("a plate"));
}

#[test]
fn one_part_with_two_views_goes_through() {
    let Some(plate) = beachball("singlepart.####.exr") else { return };
    let (folder, events) = warp(&plate, shot([2048, 1556], 1));
    let original = plate.with_file_name("singlepart.0001.exr");
    check_frame(&original, &folder.path().join("w.0001.exr"));
    check_told(&events, &read_plate(&original).expect("a plate"));
}

#[test]
fn a_flame_without_alpha_goes_through() {
    let Some(plate) = asset("openexr-images/ScanLines/CandleGlass.exr") else { return };
    let before = read_plate(&plate).expect("a plate");
    let (folder, _) = warp(&plate, shot([before.display.width, before.display.height], 1));
    let after = folder.path().join("w.0001.exr");
    check_frame(&plate, &after);
    let flame = |plate: Plate| {
        let frame = plate.into_frame();
        let samples = |name: &str| frame.channel(name).expect("beauty").samples.clone();
        let light = samples("R")
            .iter()
            .zip(samples("A"))
            .filter(|(_, alpha)| *alpha == 0.0)
            .map(|(red, _)| f64::from(*red))
            .sum::<f64>();
        (light, samples("R").into_iter().fold(f32::MIN, f32::max))
    };
    let (before, after) = (flame(before), flame(read_plate(&after).expect("a plate")));
    assert!(before.0 > 0.0 && (after.0 / before.0 - 1.0).abs() < 0.2, "light without alpha: {before:?}, {after:?}");
    assert!((after.1 / before.1 - 1.0).abs() < 0.1, "the brightest: {before:?}, {after:?}");
}
