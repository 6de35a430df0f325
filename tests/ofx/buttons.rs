//! Buttons: shots are written and read, maps are written; `pinwarp` itself takes them.

use crate::host::api::Status;
use crate::host::api::names::param;
use crate::host::profile::BOOK;
use crate::host::{Frame, Host, Pixels, Profile, Which};
use crate::{SIZE, pulled};
use std::process::Command;

/// The number of that filter.
const LANCZOS: i32 = 2;

/// A folder of its own for a test.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder for files")
}

#[test]
fn a_shot_that_was_written_is_read_back() {
    // Some hosts keep keys and do not say of a parameter that it has some.
    for profile in [BOOK, Profile { refuses: &[param::IS_ANIMATING], ..BOOK }] {
        write_and_read_back(&profile);
    }
}

fn write_and_read_back(profile: &Profile) {
    let folder = folder();
    let path = folder.path().join("pins.toml");
    let mut host = Host::start(profile, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.key(node, "pin1Target", 0.0, [96.0, 54.0]);
    host.key(node, "pin1Target", 8.0, [60.0, 30.0]);
    host.set(node, "filter", LANCZOS);
    host.set(node, "writePath", path.to_str().expect("plain letters"));
    assert_eq!(host.press(node, "writeShot"), Status::OK, "{:?}", host.said());
    assert!(path.exists());
    let other = host.node();
    host.through(other, &Pixels::scenery(SIZE, 4));
    host.set(other, "shotFile", path.to_str().expect("plain letters"));
    assert_eq!(host.press(other, "readShot"), Status::OK, "{:?}", host.said());
    for time in [0.0, 4.0, 8.0] {
        for id in ["pin1Rest", "pin1Target", "pin2Rest", "pin2Target"] {
            let [found, expected] = [other, node].map(|node| host.point(node, id, time));
            let distance = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(distance < 1e-6, "{id} at {time}: {found:?}, not {expected:?}");
        }
    }
    assert_eq!([host.int(other, "pin1On"), host.int(other, "filter")], [1, LANCZOS]);
    assert_eq!(host.undo().last().map(|undo| undo.label.is_empty()), Some(false), "one step to undo");
    host.finish();
}

#[test]
fn a_filter_is_taken_from_files_that_name_one_and_written_into_them() {
    let folder = folder();
    let [bare, bent] = ["bare.toml", "bent.toml"].map(|name| folder.path().join(name));
    let head = "version = 1\nplate = \"plate.####.exr\"\nframes = { first = 0, last = 9 }\nsize = [160, 90]\n";
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "filter", LANCZOS);
    host.set(node, "shotFile", bare.to_str().expect("plain letters"));
    for (named, expected) in [("", LANCZOS), ("warp = { filter = \"nearest\" } # ids\n", 3)] {
        std::fs::write(&bare, format!("{head}{named}[[layer]]\nname = \"all\"\n")).expect("written");
        assert_eq!(host.press(node, "readShot"), Status::OK, "{:?}", host.said());
        assert_eq!(host.int(node, "filter"), expected, "{named:?}");
    }
    host.set(node, "filter", LANCZOS);
    host.set(node, "writePath", bent.to_str().expect("plain letters"));
    assert_eq!(host.press(node, "writeShot"), Status::OK, "{:?}", host.said());
    let text = std::fs::read_to_string(&bent).expect("written");
    assert!(text.contains("warp = { filter = \"lanczos\" } # ids\n"), "{text}");
    host.finish();
}

#[test]
fn buttons_without_a_path_say_what_is_missing() {
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    for (button, missing) in [("readShot", "Shot file"), ("writeShot", "Write to"), ("writeStmaps", "STMaps folder")] {
        for _again in 0..2 {
            assert_ne!(host.press(node, button), Status::OK, "{button}");
            let said = host.said();
            assert!(said.len() == 1 && said[0].text.contains(missing), "{button}: {said:?}");
        }
    }
    host.set(node, "shotFile", "/nowhere/shot.toml");
    assert_ne!(host.press(node, "readShot"), Status::OK);
    let file = tempfile::NamedTempFile::new().expect("a file");
    // A file is no folder.
    host.set(node, "writePath", file.path().join("shot.toml").to_str().expect("plain letters"));
    assert_ne!(host.press(node, "writeShot"), Status::OK);
    host.finish();
}

/// A shot over a drawing, both in a folder, and a host whose node follows it.
fn over_a_shot(folder: &std::path::Path) -> (Host, crate::host::Node) {
    let window = pinwarp::space::PixelRect { x: 0, y: 0, width: 16, height: 9 };
    let channels = ["R", "G", "B", "A"].map(|name| (name, pinwarp::image::Storage::Float));
    let mut drawing = pinwarp::image::Frame::blank(window, window, &channels);
    drawing.channels.iter_mut().for_each(|channel| channel.samples.fill(1.0));
    let metadata =
        pinwarp::image::FrameMetadata { frame: 0, frames_per_second: 24.0, device: "CPU".into(), ..Default::default() };
    // Of the form of an STMap of this program: only the guard keeps it.
    let path = folder.join("drawing.0001.exr");
    pinwarp::image::write_exr(&path, &drawing, &metadata, pinwarp::image::Compression::Zip).expect("written");
    let shot = "version = 1\nimage = \"drawing.0001.exr\"\nframes = { first = 0, last = 0 }\nsize = [16, 9]\n";
    std::fs::write(folder.join("shot.toml"), shot).expect("written");
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "shape", 2);
    host.set(node, "shotFile", folder.join("shot.toml").to_str().expect("plain letters"));
    (host, node)
}

#[test]
#[cfg(unix)]
fn buttons_write_over_no_input_and_nothing_special() {
    let folder = folder();
    let (host, node) = over_a_shot(folder.path());
    let path = |name: &str| folder.path().join(name);
    std::fs::hard_link(path("drawing.0001.exr"), path("other.0002.exr")).expect("linked");
    std::fs::hard_link(path("shot.toml"), path("link.toml")).expect("linked");
    std::os::unix::fs::symlink(path("drawing.0001.exr"), path("link.0000.exr")).expect("linked");
    assert!(
        Command::new("mkfifo").args([path("pipe.0000.exr"), path("pipe.toml")]).status().expect("it runs").success()
    );
    let before = names(folder.path());
    let kept = ["drawing.0001.exr", "shot.toml"].map(|name| std::fs::read(path(name)).expect("there"));
    for (button, id, target, why) in [
        ("writeStmaps", "stmapPath", "drawing.####.exr", "an input of this job"),
        ("writeStmaps", "stmapPath", "other.####.exr", "an input of this job"),
        ("writeStmaps", "stmapPath", "link.####.exr", "an input of this job"),
        ("writeStmaps", "stmapPath", "pipe.####.exr", "not a regular file"),
        ("writeShot", "writePath", "drawing.0001.exr", "an input of this job"),
        ("writeShot", "writePath", "shot.toml", "the shot that is read"),
        ("writeShot", "writePath", "link.toml", "an input of this job"),
        ("writeShot", "writePath", "pipe.toml", "not a regular file"),
    ] {
        host.set(node, id, path(target).to_str().expect("plain letters"));
        assert_eq!(host.press(node, button), Status::FAILED, "{target}: {:?}", host.said());
        let said = host.said();
        assert!(said.len() == 1 && said[0].text.contains(why) && !said[0].text.contains("-o"), "{target}: {said:?}");
    }
    // A new file may be neither.
    host.set(node, "shape", 0);
    for special in [path("pipe.toml"), "/dev/null".into()] {
        host.set(node, "writePath", special.to_str().expect("plain letters"));
        assert_eq!(host.press(node, "writeShot"), Status::FAILED, "{:?}", host.said());
        assert!(host.said()[0].text.contains("not a regular file"), "{:?}", host.said());
    }
    assert_eq!(names(folder.path()), before);
    assert_eq!(["drawing.0001.exr", "shot.toml"].map(|name| std::fs::read(path(name)).expect("there")), kept);
    host.finish();
}

/// Names of the files in a folder, sorted.
fn names(folder: &std::path::Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).expect("a folder").map(|file| file.expect("readable").file_name());
    let mut names: Vec<String> = files.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn stmaps_go_into_a_folder_by_name_and_padding_or_along_a_pattern() {
    for (values, expected) in [
        (vec![], ["stmap.0000.exr", "stmap.0001.exr", "stmap.0002.exr"]),
        (vec![("stmapName", "nose")], ["nose.0000.exr", "nose.0001.exr", "nose.0002.exr"]),
        // What a host made of an older pattern does not matter then.
        (vec![("stmapPath", "/nowhere/map.0001.exr")], ["stmap.0000.exr", "stmap.0001.exr", "stmap.0002.exr"]),
    ] {
        let folder = folder();
        let mut host = Host::start(&BOOK, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        host.set(node, "stmapFolder", folder.path().to_str().expect("plain letters"));
        values.iter().for_each(|(id, value)| host.set(node, id, *value));
        assert_eq!(host.press(node, "writeStmaps"), Status::OK, "{:?}", host.said());
        assert_eq!(names(folder.path()), expected, "{values:?}");
        host.finish();
    }
    let folder = folder();
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "stmapPath", folder.path().join("old.##.exr").to_str().expect("plain letters"));
    assert_eq!(host.press(node, "writeStmaps"), Status::OK, "{:?}", host.said());
    assert_eq!(names(folder.path()), ["old.00.exr", "old.01.exr", "old.02.exr"]);
    host.set(node, "stmapFolder", folder.path().to_str().expect("plain letters"));
    host.set(node, "stmapPadding", 6);
    host.set(node, "stmapName", "deep/er");
    assert_ne!(host.press(node, "writeStmaps"), Status::OK);
    assert!(host.said().last().is_some_and(|said| said.text.contains("deep/er")), "{:?}", host.said());
    host.finish();
}

#[test]
fn the_map_in_the_host_is_the_map_that_pinwarp_exports() {
    let Some(program) = option_env!("CARGO_BIN_EXE_pinwarp") else {
        crate::skip::skip("the pinwarp program is not built (feature cli)");
        return;
    };
    let folder = folder();
    let shot = folder.path().join("pins.toml");
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    host.set(node, "writePath", shot.to_str().expect("plain letters"));
    assert_eq!(host.press(node, "writeShot"), Status::OK, "{:?}", host.said());
    host.finish();
    let out = folder.path().join("map.####.exr");
    let ran = Command::new(program)
        .args(["export", shot.to_str().expect("plain letters"), "--to", "stmap", "--frames", "0", "-o"])
        .arg(&out)
        .output()
        .expect("pinwarp runs");
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let exported = pinwarp::image::read_plate(&folder.path().join("map.0000.exr")).expect("an EXR file");
    let mut host = Host::start(&BOOK, Which::StMap);
    let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
    let found = host.render(node, Frame::default()).expect("it renders");
    // Two thousandths of a pixel: maps depend a little on where their windows begin.
    let worst = crate::maps::worst(&exported, &found);
    assert!(worst < 1e-5, "{worst} apart");
    host.finish();
}
