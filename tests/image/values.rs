//! What is in the files: values, windows, metadata, the same bytes every time.

use super::support::{ALL, CHANNELS, bits, metadata, rect, sample_frame, write};
use exr::prelude::{MetaData, Vec2};
use pinwarp::image::{
    Compression, Frame, FrameMetadata, Preview, Storage, is_complete, preview, read_exr, read_metadata, write_exr,
    write_png,
};
use std::fs;

#[test]
fn every_compression_keeps_data_exact_and_colour_close() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let frame = sample_frame();
    for compression in ALL {
        let path = folder.path().join(format!("{compression:?}.exr"));
        write_exr(&path, &frame, &metadata(), compression).expect("written");
        assert!(is_complete(&path), "{compression:?}");
        let read = read_exr(&path).expect("read back");
        assert_eq!(read.display, frame.display);
        assert_eq!(read.data_window, frame.data_window);
        assert_eq!(read.pixel_aspect, 2.0);
        let names: Vec<_> = read.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["A", "B", "G", "N.X", "R", "depth.Z", "other.id"], "the order that EXR demands");
        for (name, _) in CHANNELS {
            if compression.is_lossy() && ["R", "G", "B"].contains(&name) {
                assert_close(&read, &frame, name);
            } else {
                assert_eq!(bits(&read, name), bits(&frame, name), "{compression:?} {name}");
            }
        }
    }
}

fn assert_close(read: &Frame, frame: &Frame, name: &str) {
    let (read, frame) = (read.channel(name).expect("read"), frame.channel(name).expect("written"));
    assert_eq!(read.storage, Storage::Half);
    let worst = read.samples.iter().zip(&frame.samples).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst > 0.0 && worst < 0.02, "{name}: {worst}");
}

/// DWA takes channels for colour by their names, and would store normals and ids at half precision and worse.
#[test]
fn dwa_keeps_data_whole_in_a_part_of_its_own() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("parts.exr");
    let mut frame = sample_frame();
    frame.channels[5].name = "N.Y".into();
    frame.channels[4].name = "CryptoObject00.R".into();
    for compression in [Compression::Dwaa, Compression::Dwab, Compression::Zip] {
        write_exr(&path, &frame, &metadata(), compression).expect("written");
        let parts = MetaData::read_from_file(&path, true).expect("a sound head").headers.len();
        assert_eq!(parts, if compression.is_lossy() { 2 } else { 1 });
        let read = read_exr(&path).expect("read back");
        assert_eq!((read.data_window, read.channels.len()), (frame.data_window, 7));
        for name in ["A", "N.Y", "CryptoObject00.R", "other.id"] {
            assert_eq!(bits(&read, name), bits(&frame, name), "{name}");
        }
        assert_eq!(read_metadata(&path).expect("readable").expect("our own").frame, -12);

        assert!(is_complete(&path));
        let whole = fs::read(&path).expect("just written");
        fs::write(&path, &whole[..whole.len() - 1]).expect("written");
        assert!(!is_complete(&path));
    }
    frame.channels.retain(|channel| channel.storage != Storage::Half);
    write_exr(&path, &frame, &metadata(), Compression::Dwaa).expect("written");
    assert_eq!(bits(&read_exr(&path).expect("read back"), "N.Y"), bits(&frame, "N.Y"));
}

#[test]
fn an_empty_frame_is_one_pixel_that_holds_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("empty.exr");
    let empty = Frame::blank(rect(0, 0, 48, 32), rect(0, 0, 48, 32), &CHANNELS).crop_to_covered();
    assert_eq!(empty.data_window.area(), 0);
    write(&path, &empty);
    let read = read_exr(&path).expect("read back");
    assert_eq!((read.display, read.data_window), (rect(0, 0, 48, 32), rect(0, 0, 1, 1)));
    for channel in &read.channels {
        let expected = if channel.name == "depth.Z" { 1e10 } else { 0.0 };
        assert_eq!(channel.samples, [expected], "{}", channel.name);
    }
}

#[test]
fn what_a_file_cannot_hold_is_contained() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("wild.exr");
    let window = rect(0, 0, 5, 1);
    let mut frame = Frame::blank(window, window, &[("R", Storage::Half), ("N.X", Storage::Float)]);
    let wild = vec![f32::NAN, 1e9, f32::NEG_INFINITY, 65_519.0, 1e-9];
    frame.channels.iter_mut().for_each(|channel| channel.samples.clone_from(&wild));
    assert_eq!(frame.nan_count(), 2);
    write(&path, &frame);
    let read = read_exr(&path).expect("read back");
    assert_eq!(read.channel("R").expect("R").samples, [0.0, 65504.0, -65504.0, 65504.0, 0.0]);
    assert_eq!(read.channel("N.X").expect("N.X").samples, [0.0, 1e9, f32::NEG_INFINITY, 65_519.0, 1e-9]);
}

#[test]
fn metadata_stands_in_standard_attributes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("meta.exr");
    write(&path, &sample_frame());
    let head = MetaData::read_from_file(&path, true).expect("a sound head");
    let (own, shared) = (&head.headers[0].own_attributes, &head.headers[0].shared_attributes);
    assert_eq!(own.frames_per_second, Some((24000, 1001)));
    let software = own.software_name.as_ref().expect("software").to_string();
    assert_eq!(software, format!("pinwarp {}", env!("CARGO_PKG_VERSION")));
    let matrix = own.world_to_camera.expect("a camera");
    assert_eq!(matrix, [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., -1., 0., 1., 2., -3., 1.]);
    assert!(own.world_to_normalized_device.is_some());
    assert_eq!(own.capture_date, None);
    assert_eq!(shared.chromaticities.expect("primaries").white, Vec2(0.3127, 0.3290));
    let mut custom: Vec<String> = own.other.keys().map(ToString::to_string).collect();
    custom.sort();
    assert_eq!(custom, ["pinwarp", "pinwarpChecksum"]);

    let read = read_metadata(&path).expect("readable").expect("our own file");
    assert!((read.frames_per_second - 24000.0 / 1001.0).abs() < 1e-9);
    let expected = FrameMetadata { frames_per_second: read.frames_per_second, camera: None, ..metadata() };
    assert_eq!(read, expected);
}

/// Every thread seeds its hash maps anew, like every run of the program, so eight threads stand for eight runs.
#[test]
fn the_same_frame_gives_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for compression in ALL {
        let bytes = |run: usize| {
            let path = folder.path().join(format!("{compression:?}.{run}.exr"));
            write_exr(&path, &sample_frame(), &metadata(), compression).expect("written");
            fs::read(path).expect("just written")
        };
        let runs: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..8).map(|run| scope.spawn(move || bytes(run))).collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
        });
        assert!(runs.iter().all(|run| *run == runs[0]), "{compression:?}");
    }
}

#[test]
fn a_preview_shows_the_display_window() {
    let colour = ["R", "G", "B", "A"].map(|name| (name, Storage::Half));
    let mut frame = Frame::blank(rect(0, 0, 4, 4), rect(-1, -1, 3, 3), &colour);
    frame.channels.iter_mut().for_each(|channel| channel.samples.fill(0.18));
    frame.channels[3].samples.fill(1.0);
    let picture = preview(&frame);
    assert_eq!((picture.width, picture.height), (4, 4));
    assert_eq!(picture.pixel(0, 0), Some([118, 118, 118, 255]));
    assert_eq!(picture.pixel(1, 1), Some([118, 118, 118, 255]));
    assert_eq!(picture.pixel(2, 2), Some([0; 4]));
    assert_eq!(picture.pixel(4, 0), None);

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("preview.png");
    write_png(&path, &picture).expect("written");
    let decoded = image::open(&path).expect("a sound PNG").into_rgba8();
    assert_eq!(decoded.dimensions(), (4, 4));
    assert_eq!(decoded.into_raw(), picture.rgba);
    assert!(write_png(&path, &Preview::transparent(0, 4)).is_err());
}
