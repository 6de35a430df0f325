//! Whole files of other programs, read and written again: every part, view, channel, window and attribute.

use super::assets::asset;
use super::support::{CHANNELS, metadata, rect, sample_frame, write};
use pinwarp::image::{Channel, Frame, Plate, Storage, is_complete, read_exr, read_metadata, read_plate, write_plate};
use std::fs;
use std::path::Path;

const REAL: [&str; 7] = [
    "openexr-images/Beachball/multipart.0001.exr",
    "openexr-images/Beachball/singlepart.0001.exr",
    "openexr-images/DisplayWindow/t01.exr",
    "openexr-images/DisplayWindow/t05.exr",
    "openexr-images/DisplayWindow/t10.exr",
    "openexr-images/DisplayWindow/t16.exr",
    "openexr-images/ScanLines/CandleGlass.exr",
];

/// Writes the plate, and gives back what a reader finds.
fn written(path: &Path, plate: &Plate) -> Plate {
    write_plate(path, plate).expect("a sound plate in a writable folder");
    assert!(is_complete(path));
    read_plate(path).expect("just written")
}

#[test]
fn real_files_lose_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("again.exr");
    for file in REAL {
        let Some(original) = asset(file) else { return };
        let plate = read_plate(&original).expect(file);
        assert_eq!(plate.left_out, [""; 0]);
        assert!(written(&path, &plate) == plate, "{file}: something changed");
        let bytes = fs::read(&path).expect("just written");
        write_plate(&path, &plate).expect("written again");
        assert!(fs::read(&path).expect("just written") == bytes, "{file}: other bytes");
    }
}

#[test]
fn the_beach_ball_has_its_views_and_windows() {
    let Some(original) = asset(REAL[0]) else { return };
    let plate = read_plate(&original).expect("a sound file");
    assert_eq!((plate.display, plate.pixel_aspect, plate.parts.len()), (rect(0, 0, 2048, 1556), 1.0, 10));
    let names = |plate: &Plate| plate.parts.iter().filter_map(|part| part.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&plate)[..3], ["rgba_right", "depth_left", "forward_left"]);
    let right = plate.part("rgba_right").expect("a part of the right eye");
    assert_eq!((right.view.as_deref(), right.data_window), (Some("right"), rect(654, 245, 877, 876)));
    assert_eq!(plate.part("disparityL").expect("a part of no eye").view, None);
    assert_eq!(right.channels.iter().map(|channel| channel.name.as_str()).collect::<Vec<_>>(), ["A", "B", "G", "R"]);
}

/// Attributes of all kinds, among them several that the EXR crate does not know, and names that are not ASCII.
fn rich() -> Plate {
    let mut plate = Plate::from_frame(sample_frame());
    let more: Vec<_> = plate.parts[0].channels.iter().rev().cloned().collect();
    let mut other = plate.parts[0].with_channels(plate.parts[0].data_window, more);
    other.name = Some("links".into());
    other.view = Some("left".into());
    plate.parts[0].name = Some("Farbe.größer".into());
    plate.parts.push(other);
    for part in &mut plate.parts {
        for number in 0..8 {
            part.set_text(
                &format!("cryptomatte/{number}/manifest"),
                &format!("{{\"Bälle{number}\":\"0000000{number}\"}}"),
            );
        }
        part.set_text(&"long name ".repeat(20), "kept");
        part.set_text("empty", "");
    }
    plate.set_metadata(&metadata());
    plate
}

#[test]
fn everything_comes_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("rich.exr");
    let plate = rich();
    let read = written(&path, &plate);
    assert_eq!(read.part("Farbe.größer").expect("the name").texts("cryptomatte/").len(), 8);
    let manifest = read.parts[1].text("cryptomatte/3/manifest");
    assert_eq!(manifest.as_deref(), Some("{\"Bälle3\":\"00000003\"}"));
    assert_eq!(read.parts[1].text("absent"), None);
    assert!(written(&path, &read) == read);
    let metadata = read_metadata(&path).expect("readable").expect("our own mark");
    assert_eq!((metadata.frame, metadata.shot_hash.as_str()), (-12, "5f1d\"c0de"));

    let mut bare = read.clone();
    bare.parts.iter_mut().for_each(|part| part.remove_attributes(""));
    assert_eq!(written(&path, &bare).parts[0].texts("").len(), 0);
    assert_eq!(read_metadata(&path).expect("readable"), None);
}

/// Every thread seeds its hash maps anew, like every run of the program, so eight threads stand for eight runs.
#[test]
fn the_same_plate_gives_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bytes = |run: usize| {
        let path = folder.path().join(format!("{run}.exr"));
        write_plate(&path, &rich()).expect("written");
        fs::read(path).expect("just written")
    };
    let runs: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|run| scope.spawn(move || bytes(run))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert!(runs.iter().all(|run| *run == runs[0]));
}

#[test]
fn samples_pass_through_untouched() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("wild.exr");
    let window = rect(0, 0, 6, 1);
    let mut frame = Frame::blank(window, window, &[("N.X", Storage::Float), ("R", Storage::Half)]);
    let wild = vec![f32::NAN, 1e9, f32::NEG_INFINITY, -65_519.0, 1e-9, -0.0];
    frame.channels.iter_mut().for_each(|channel| channel.samples.clone_from(&wild));
    let read = written(&path, &Plate::from_frame(frame)).into_frame();
    let bits = |samples: &[f32]| samples.iter().map(|sample| sample.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&read.channels[0].samples), bits(&wild));
    let halves = [f32::NAN, 65_504.0, f32::NEG_INFINITY, -65_504.0, 0.0, -0.0];
    assert_eq!(bits(&read.channels[1].samples), bits(&halves));
}

#[test]
fn a_part_without_pixels_is_one_pixel_that_holds_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("empty.exr");
    let empty = Frame::blank(rect(4, 5, 48, 32), rect(4, 5, 48, 32), &CHANNELS).crop_to_covered();
    let read = written(&path, &Plate::from_frame(empty));
    assert_eq!(read.parts[0].data_window, rect(4, 5, 1, 1));
    assert_eq!(read.parts[0].channel("depth.Z").expect("depth").samples, [1e10]);
}

#[test]
fn frames_and_plates_are_the_same_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("frame.exr");
    write(&path, &sample_frame());
    let plate = read_plate(&path).expect("just written");
    let frame = plate.clone().into_frame();
    assert!(frame == read_exr(&path).expect("just written"));
    assert!(Plate::from_frame(frame).parts[0].channels == plate.parts[0].channels);
    let bytes = fs::read(&path).expect("just written");
    write_plate(&path, &plate).expect("written");
    assert!(fs::read(&path).expect("just written") == bytes, "camera, software and rate are kept");
}

#[test]
fn malformed_plates_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bad.exr");
    let good = rich();
    let with = |change: &dyn Fn(&mut Plate)| {
        let mut plate = good.clone();
        change(&mut plate);
        plate
    };
    let stray = Channel { name: "S".into(), storage: Storage::Half, samples: vec![0.0] };
    for (part, plate) in [
        ("no parts", with(&|plate| plate.parts.clear())),
        ("a part has no name", with(&|plate| plate.parts[1].name = None)),
        ("two parts are called 'links'", with(&|plate| plate.parts[0].name = Some("links".into()))),
        ("part 'links': channel 'S' has 1 sample for 2257", with(&|plate| plate.parts[1].channels.push(stray.clone()))),
        ("pixel aspect", with(&|plate| plate.pixel_aspect = 0.0)),
        ("too far out", with(&|plate| plate.display.x = i32::MAX)),
    ] {
        let error = write_plate(&path, &plate).expect_err(part).to_string();
        assert!(error.contains(part) && error.contains("bad.exr"), "{error}");
    }
    assert!(!path.exists());
}

#[test]
fn damaged_plates_give_errors_never_panics() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("damaged.exr");
    write_plate(&path, &rich()).expect("written");
    let whole = fs::read(&path).expect("just written");
    for position in (0..4000).step_by(13).chain((4000..whole.len()).step_by(911)) {
        let mut damaged = whole.clone();
        damaged[position] ^= 0x80 | position as u8;
        fs::write(&path, damaged).expect("written");
        if let Ok(plate) = read_plate(&path) {
            let _ = write_plate(&folder.path().join("again.exr"), &plate);
        }
    }
    for length in (0..whole.len()).step_by(997) {
        fs::write(&path, &whole[..length]).expect("written");
        assert!(read_plate(&path).is_err(), "{length}");
    }
}
