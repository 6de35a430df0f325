//! Frames to files and back: values, windows, metadata, whole files or none, the same bytes every time.

use exr::prelude::{MetaData, Vec2};
use glam::{DMat4, DVec3};
use pinwarp::image::{
    CameraMatrices, Channel, Compression, Frame, FrameMetadata, ImageError, Preview, Storage, is_complete, preview,
    read_exr, read_metadata, write_exr, write_png,
};
use pinwarp::space::PixelRect;
use std::fs;
use std::path::{Path, PathBuf};

const ALL: [Compression; 7] = [
    Compression::None,
    Compression::Rle,
    Compression::Zips,
    Compression::Zip,
    Compression::Piz,
    Compression::Dwaa,
    Compression::Dwab,
];

const CHANNELS: [(&str, Storage); 7] = [
    ("R", Storage::Half),
    ("G", Storage::Half),
    ("B", Storage::Half),
    ("A", Storage::Half),
    ("depth.Z", Storage::Float),
    ("N.X", Storage::Float),
    ("other.id", Storage::Uint),
];

fn rect(x: i32, y: i32, width: u32, height: u32) -> PixelRect {
    PixelRect { x, y, width, height }
}

/// Smooth colour (half numbers, so that a round trip is exact), busy data, a data window that leaves the display window.
fn sample_frame() -> Frame {
    let window = rect(-5, -3, 61, 37);
    let mut frame = Frame::blank(rect(0, 0, 48, 32), window, &CHANNELS);
    frame.pixel_aspect = 2.0;
    for (number, channel) in frame.channels.iter_mut().enumerate() {
        for (index, sample) in channel.samples.iter_mut().enumerate() {
            let (x, y) = ((index % 61) as f32, (index / 61) as f32);
            *sample = match channel.storage {
                Storage::Half => ((x + y + number as f32) * 8.0).floor() / 1024.0,
                Storage::Float => (x * 0.37 + y * 1.91 + number as f32).sin() * 1234.567,
                Storage::Uint => f32::from_bits(0x9E37_79B9_u32.wrapping_mul(index as u32 + 1)),
            };
        }
    }
    frame
}

fn metadata() -> FrameMetadata {
    FrameMetadata {
        frame: -12,
        frames_per_second: 23.976,
        shot_hash: "5f1d\"c0de".into(),
        device: "CPU (2 threads)".into(),
        camera: Some(CameraMatrices {
            camera_from_scene: DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0)),
            screen_from_scene: DMat4::IDENTITY,
        }),
    }
}

/// Bits, so that NaN patterns among ids compare equal; by name, since files order channels by the alphabet.
fn bits(frame: &Frame, name: &str) -> (Storage, Vec<u32>) {
    let channel = frame.channel(name).expect(name);
    (channel.storage, channel.samples.iter().map(|sample| sample.to_bits()).collect())
}

fn write(path: &Path, frame: &Frame) {
    write_exr(path, frame, &metadata(), Compression::Zip).expect("a sound frame in a writable folder");
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the test's own folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut names: Vec<_> = names.collect();
    names.sort();
    names
}

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

#[test]
fn dwa_refuses_to_damage_data_with_names_of_colours() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let frame = Frame::blank(rect(0, 0, 4, 4), rect(0, 0, 4, 4), &[("CryptoObject00.R", Storage::Float)]);
    let path = folder.path().join("crypto.exr");
    let error = write_exr(&path, &frame, &metadata(), Compression::Dwaa).expect_err("lossy ids").to_string();
    assert!(error.contains("CryptoObject00.R") && error.contains("choose zip"), "{error}");
    write_exr(&path, &frame, &metadata(), Compression::Zip).expect("lossless");
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
    assert_eq!(own.other.len(), 1, "more than one custom attribute is written in random order");

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
fn files_cut_off_anywhere_are_seen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("whole.exr");
    let cut = folder.path().join("cut.exr");
    for compression in ALL {
        write_exr(&path, &sample_frame(), &metadata(), compression).expect("written");
        let whole = fs::read(&path).expect("just written");
        for length in (0..whole.len()).step_by(97).chain([whole.len() - 1]) {
            fs::write(&cut, &whole[..length]).expect("written");
            assert!(!is_complete(&cut), "{compression:?} {length} of {}", whole.len());
        }
        assert!(read_exr(&cut).is_err());
    }
    assert!(!is_complete(&folder.path().join("absent.exr")));
    assert!(!is_complete(folder.path()));
}

/// After a power cut, blocks that never reached the disk read as zeros.
#[test]
fn missing_chunks_are_seen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("holes.exr");
    for compression in [Compression::None, Compression::Zips, Compression::Zip, Compression::Piz] {
        write_exr(&path, &sample_frame(), &metadata(), compression).expect("written");
        let mut holes = fs::read(&path).expect("just written");
        let half = holes.len() / 2;
        holes[half..].fill(0);
        fs::write(&path, holes).expect("written");
        assert!(!is_complete(&path), "{compression:?}");
    }
}

#[test]
fn damaged_files_give_errors_never_panics() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("damaged.exr");
    write(&path, &sample_frame());
    let whole = fs::read(&path).expect("just written");
    for position in (0..whole.len()).step_by(7) {
        let mut damaged = whole.clone();
        damaged[position] ^= 0x80 | position as u8;
        fs::write(&path, damaged).expect("written");
        let _ = (is_complete(&path), read_exr(&path), read_metadata(&path));
    }
    fs::write(&path, b"no picture").expect("written");
    let error = read_exr(&path).expect_err("not EXR").to_string();
    assert!(error.contains("damaged.exr is damaged"), "{error}");
}

#[test]
fn malformed_frames_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("bad.exr");
    let good = sample_frame();
    let channel = |name: &str, count| Channel { name: name.into(), storage: Storage::Half, samples: vec![0.0; count] };
    let with_channels = |channels| Frame { channels, ..good.clone() };
    for (part, frame) in [
        ("no channels", with_channels(Vec::new())),
        ("two channels are called 'R'", with_channels(vec![channel("R", 2257), channel("R", 2257)])),
        ("1 samples for 2257 pixels", with_channels(vec![channel("S", 1)])),
        ("no channel name", with_channels(vec![channel("", 2257)])),
        ("no pixels", Frame { display: rect(0, 0, 0, 5), ..good.clone() }),
        ("pixel aspect", Frame { pixel_aspect: f64::NAN, ..good.clone() }),
        ("too far out", Frame { data_window: rect(i32::MIN, 0, 61, 37), ..good.clone() }),
    ] {
        let error = write_exr(&path, &frame, &metadata(), Compression::Zip).expect_err(part).to_string();
        assert!(error.contains(part) && error.contains("bad.exr"), "{error}");
    }
    assert_eq!(names_in(folder.path()), [""; 0]);
}

/// A disk of 256 KiB, taken away at the end; `None` where the system does not let us have one.
struct TinyDisk(PathBuf);

impl TinyDisk {
    fn mount(at: &Path) -> Option<Self> {
        let arguments = ["-t", "tmpfs", "-o", "size=256k", "tmpfs"];
        let status = std::process::Command::new("mount").args(arguments).arg(at).output().ok()?.status;
        status.success().then(|| Self(at.to_owned()))
    }
}

impl Drop for TinyDisk {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount").arg(&self.0).output();
    }
}

/// Numbers that no compression makes smaller.
fn noise(count: usize) -> Vec<u32> {
    let step = |state: &mut u32| {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        Some(*state >> 8)
    };
    (0..count).scan(1_u32, |state, _| step(state)).collect()
}

#[test]
fn a_full_disk_leaves_the_old_frame_and_no_litter() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(disk) = TinyDisk::mount(folder.path()) else {
        eprintln!("SKIPPED: cannot mount a tiny disk here, so a full disk is not tested");
        return;
    };
    let path = disk.0.join("frame.0001.exr");
    write(&path, &sample_frame());
    let before = fs::read(&path).expect("the first frame fits");

    let window = rect(0, 0, 512, 512);
    let mut large = Frame::blank(window, window, &[("noise", Storage::Float)]);
    large.channels[0].samples = noise(window.area()).into_iter().map(|number| number as f32).collect();
    for compression in ALL {
        let error = write_exr(&path, &large, &metadata(), compression).expect_err("a megabyte on a tiny disk");
        assert!(matches!(error, ImageError::Io { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains("frame.0001.exr") && text.contains("free some space"), "{text}");
    }
    let rgba = noise(4 * window.area()).into_iter().map(|number| (number >> 8) as u8).collect();
    let error = write_png(&disk.0.join("frame.0001.png"), &Preview { width: 512, height: 512, rgba });
    let text = error.expect_err("a megabyte on a tiny disk").to_string();
    assert!(text.contains("free some space"), "{text}");

    assert_eq!(names_in(&disk.0), ["frame.0001.exr"]);
    assert_eq!(fs::read(&path).expect("still there"), before);
    assert!(is_complete(&path));
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).expect("our own folder");
    if fs::write(folder.path().join("probe"), "").is_ok() {
        eprintln!("SKIPPED: this user may write anywhere, so a read-only folder is not tested");
        return;
    }
    let path = folder.path().join("frame.exr");
    let error = write_exr(&path, &sample_frame(), &metadata(), Compression::Zip).expect_err("read-only").to_string();
    assert!(error.contains("frame.exr") && error.contains("choose another output folder"), "{error}");
}

#[test]
fn folders_are_made_and_what_is_in_the_way_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("new/deep/frame.exr");
    write(&path, &sample_frame());
    assert_eq!(names_in(path.parent().expect("a folder")), ["frame.exr"]);

    let error = write_exr(&path.join("frame.exr"), &sample_frame(), &metadata(), Compression::Zip);
    let text = error.expect_err("a file in the way").to_string();
    assert!(text.contains("deep/frame.exr"), "{text}");
    let error = write_exr(&folder.path().join("new"), &sample_frame(), &metadata(), Compression::Zip);
    let text = error.expect_err("a folder in the way").to_string();
    assert!(text.contains("folder of that name"), "{text}");
    assert_eq!(names_in(folder.path()), ["new"]);
    let text = read_exr(&folder.path().join("absent.exr")).expect_err("absent").to_string();
    assert!(text.contains("cannot read") && text.contains("typing"), "{text}");
}

#[cfg(unix)]
#[test]
fn others_may_read_the_frames() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let plain = folder.path().join("plain");
    fs::write(&plain, "").expect("written");
    let path = folder.path().join("frame.exr");
    write(&path, &sample_frame());
    let mode = |path: &Path| fs::metadata(path).expect("there").permissions().mode();
    assert_eq!(mode(&path), mode(&plain), "the umask decides, as for any file");
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
