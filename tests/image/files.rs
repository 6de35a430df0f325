//! Whole files or none: cut off, damaged, malformed, no room, no permission.

use super::support::{ALL, metadata, names_in, rect, sample_frame, write};
use crate::internal::numbers::{Random, SplitMix};
use crate::internal::skip::skip;
use pinwarp::image::{
    Channel, Compression, Frame, ImageError, Plate, PlatePart, Preview, Storage, is_complete, picture_size, read_exr,
    read_metadata, read_plate, write_exr, write_plate, write_png,
};
use std::fs;
use std::path::{Path, PathBuf};

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
    for compression in [Compression::Zip, Compression::Piz, Compression::Dwaa] {
        write_exr(&path, &sample_frame(), &metadata(), compression).expect("written");
        let whole = fs::read(&path).expect("just written");
        for position in (0..1500).step_by(5).chain((1500..whole.len()).step_by(101)) {
            let mut damaged = whole.clone();
            damaged[position] ^= 0x80 | position as u8;
            fs::write(&path, damaged).expect("written");
            let _ = (is_complete(&path), read_exr(&path), read_metadata(&path));
        }
    }
    fs::write(&path, b"no picture").expect("written");
    let error = read_exr(&path).expect_err("not EXR").to_string();
    assert!(error.contains("damaged.exr is damaged"), "{error}");
}

#[test]
fn a_head_that_promises_too_much_is_not_believed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("huge.exr");
    write(&path, &sample_frame());
    let whole = fs::read(&path).expect("just written");
    let key = b"dataWindow\0box2i\0\x10\0\0\0";
    let window = whole.windows(key.len()).position(|bytes| bytes == key).expect("a data window") + key.len();
    for edges in [&[8][..], &[12], &[8, 12]] {
        let mut huge = whole.clone();
        edges
            .iter()
            .for_each(|edge| huge[window + edge..window + edge + 4].copy_from_slice(&0x3FFF_0000_u32.to_le_bytes()));
        fs::write(&path, huge).expect("written");
        let error = read_exr(&path).expect_err("no such picture").to_string();
        assert!(error.contains("is damaged") && error.contains("MB of pixels"), "{error}");
        assert!(!is_complete(&path) || edges == [8], "the width does not show without decoding");
    }
}

#[test]
fn a_dwa_chunk_that_promises_too_much_is_not_believed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("dwa.exr");
    let window = rect(0, 0, 8, 8);
    let frame = Frame::blank(window, window, &["R", "G", "B"].map(|name| (name, Storage::Half)));
    write_exr(&path, &frame, &metadata(), Compression::Dwaa).expect("written");
    assert_eq!(read_exr(&path).expect("sound").channel("R").map(|red| red.samples.len()), Some(64));
    // The one chunk: y, size, version, then the sizes that are tested.
    let mut file = fs::read(&path).expect("just written");
    let head = b"\x02\0\0\0\0\0\0\0";
    let sizes = file.windows(8).rposition(|bytes| bytes == head).expect("version 2") + 8;
    for size in 0..9 {
        let place = sizes + 8 * size + 5;
        file[place] ^= 0x40;
        fs::write(&path, &file).expect("written");
        let error = read_exr(&path).expect_err("too large").to_string();
        assert!(error.contains("DWA chunk"), "{error}");
        file[place] ^= 0x40;
    }
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
        ("1 sample for 2257 pixels", with_channels(vec![channel("S", 1)])),
        ("not a valid channel name", with_channels(vec![channel("", 2257)])),
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
    let mut random = SplitMix(1);
    (0..count).map(|_| random.below(1 << 24) as u32).collect()
}

#[test]
fn a_full_disk_leaves_the_old_frame_and_no_litter() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(disk) = TinyDisk::mount(folder.path()) else {
        skip("cannot mount a tiny disk here, so a full disk is not tested");
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
        skip("this user may write anywhere, so a read-only folder is not tested");
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
fn compressions_that_are_not_read_are_named_and_not_called_damage() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("new.exr");
    let of = |name: &str| {
        let channel = Channel { name: "R".into(), storage: Storage::Half, samples: vec![0.5; 64] };
        let mut part = PlatePart::new(rect(0, 0, 8, 8), vec![channel]);
        part.name = Some(name.into());
        part
    };
    for parts in [vec![of("one")], vec![of("one"), of("two")]] {
        write_plate(&path, &Plate::new(rect(0, 0, 8, 8), 1.0, parts)).expect("written");
        let whole = fs::read(&path).expect("just written");
        let key = b"compression\0compression\0\x01\0\0\0";
        let last = whole.windows(key.len()).rposition(|bytes| bytes == key).expect("a compression") + key.len();
        for (code, name) in [(10, "HTJ2K256"), (11, "HTJ2K32"), (12, "LJ2K"), (13, "ZSTD"), (99, "number 99")] {
            let mut file = whole.clone();
            file[last] = code;
            fs::write(&path, file).expect("written");
            let error = read_plate(&path).expect_err("not read").to_string();
            let is_told = error.contains(&format!("its compression ({name}) is not supported yet"));
            assert!(is_told && error.contains("save it again with ZIP") && !error.contains("damaged"), "{error}");
            assert!(!is_complete(&path) || code < 12, "{name}");
            if let Err(error) = picture_size(&path) {
                assert!(error.to_string().contains(name), "{error}");
            }
        }
    }
}

#[test]
fn dwa_chunks_that_are_stored_as_they_are_are_sound() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("noise.exr");
    let mut frame =
        Frame::blank(rect(0, 0, 50, 40), rect(0, 0, 50, 40), &["R", "G", "B"].map(|name| (name, Storage::Half)));
    let noise = |k: usize| (k as u32).wrapping_mul(0x9E37_79B9) ^ ((k as u32) << 7);
    for (channel, seed) in frame.channels.iter_mut().zip([1, 5000, 90_000]) {
        let samples = channel.samples.iter_mut().enumerate();
        samples.for_each(|(k, sample)| *sample = (noise(k * 31 + seed) >> 16) as f32 / 65536.0);
    }
    write_exr(&path, &frame, &metadata(), Compression::Dwaa).expect("written");
    assert_eq!(read_exr(&path).expect("sound").channels.len(), 3);
}
