//! `--resume`: what is kept, what is rendered again and why; runs that died, and runs that meet.

use crate::support::{Bench, HEAD, OUTPUT, PIN, PROGRAM, names_in};
use pinwarp::image::{Frame, FrameMetadata, Plate, read_exr, write_exr, write_plate};
use serde_json::Value;
use std::process::{Command, Stdio};

/// What a render, a warp and a render of pictures have in common.
struct Kind {
    bench: Bench,
    /// Makes both frames of `out/`.
    run: &'static str,
    frames: [&'static str; 2],
}

const FLAT: &str = r#"
version = 1
image = "cat.png"
frames = { first = 1, last = 2, rate = 24 }
[[layer]]
lattice = { dims = [4, 4] }
  [[layer.pin]]
  anchor = { screen = [0.9, 0.5] }
  keys = [ { frame = 1, offset = [0.0, 0.0] }, { frame = 2, offset = [0.1, 0.05] } ]
[output]
path = "out/f.####.exr"
channels = ["beauty"]
"#;

fn picture(bench: &Bench, name: &str) {
    let inside = |x, y| if (20..44).contains(&x) && (6..30).contains(&y) { [200, 100, 50, 255] } else { [0; 4] };
    image::RgbaImage::from_fn(64, 36, |x, y| image::Rgba(inside(x, y))).save(bench.path(name)).expect("saved");
}

fn kinds() -> [Kind; 4] {
    const FRAMES: [&str; 2] = ["out/f.0001.exr", "out/f.0002.exr"];
    let flat = Bench::with_shot(FLAT);
    picture(&flat, "cat.png");
    let plates = Bench::new();
    plates.render("-o in/b.####.exr").says(0, &[]);
    let pngs = Bench::new();
    for name in ["in.0001.png", "in.0002.png"] {
        picture(&pngs, name);
    }
    [
        Kind { bench: Bench::new(), run: "render shot.toml --device cpu", frames: FRAMES },
        Kind { bench: flat, run: "render shot.toml", frames: FRAMES },
        Kind {
            bench: plates,
            run: "warp in/b.####.exr --shot shot.toml -o out/f.####.exr --device cpu",
            frames: FRAMES,
        },
        Kind {
            bench: pngs,
            run: "warp in.####.png --shot shot.toml -o out/f.####.png --device cpu",
            frames: ["out/f.0001.png", "out/f.0002.png"],
        },
    ]
}

/// Resumes, and checks which frames were rendered again and why.
#[track_caller]
fn resumed(kind: &Kind, flags: &str, redone: &[(i64, &str)]) {
    let ended = kind.bench.run(&format!("{} --resume --json {flags}", kind.run)).says(0, &[]);
    let events = ended.events();
    let told: Vec<&Value> = events.iter().filter(|event| event["event"] == "frame_redone").collect();
    assert_eq!(told.len(), redone.len(), "{} {flags}: {events:#?}", kind.run);
    for (event, (frame, why)) in told.iter().zip(redone) {
        assert_eq!(event["frame"], *frame, "{event}");
        assert!(event["reason"].as_str().is_some_and(|reason| reason.contains(why)), "{why}: {event}");
    }
    let last = events.last().expect("events");
    assert_eq!(
        (last["redone"].as_u64(), last["kept"].as_u64()),
        (Some(redone.len() as u64), Some(2 - redone.len() as u64))
    );
    if let Some((_, why)) = redone.first() {
        let is_note = |event: &Value| {
            event["text"].as_str().is_some_and(|text| text.contains("rendered again") && text.contains(why))
        };
        assert!(events.iter().any(is_note), "{events:#?}");
    }
}

#[test]
fn frames_equal_to_the_requested_ones_are_kept_and_others_are_rendered_again() {
    for kind in kinds() {
        let bench = &kind.bench;
        bench.run(kind.run).says(0, &[]);
        let good = kind.frames.map(|name| bench.read(name));
        let restored = || assert_eq!(kind.frames.map(|name| bench.read(name)), good, "{}: the same bytes", kind.run);
        resumed(&kind, "", &[]);
        resumed(&kind, "--verify", &[]);

        for length in [0, 100, good[1].len() / 2, good[1].len() - 1] {
            bench.write(kind.frames[1], &good[1][..length]);
            resumed(&kind, "", &[(2, "cut off or damaged")]);
            restored();
        }
        // The other frame's file.
        bench.write(kind.frames[0], &good[1]);
        resumed(&kind, "", &[(1, "holds frame 2")]);
        restored();
        // A file of another program.
        if kind.frames[0].ends_with(".png") {
            picture(bench, kind.frames[0]);
        } else {
            let Frame { display, data_window, pixel_aspect, channels } =
                read_exr(&bench.path(kind.frames[0])).expect("read");
            let foreign = Plate::from_frame(Frame { display, data_window, pixel_aspect, channels });
            write_plate(&bench.path(kind.frames[0]), &foreign).expect("written");
        }
        resumed(&kind, "", &[(1, "pinwarp did not write")]);
        restored();
        // Another state of the shot.
        let shot = bench.read("shot.toml");
        let other = String::from_utf8(shot.clone()).expect("text").replace("0.1, 0.05", "0.1, 0.06");
        bench.write("shot.toml", other.as_bytes());
        resumed(&kind, "", &[(1, "another state of the shot"), (2, "another state of the shot")]);
        bench.write("shot.toml", &shot);
        resumed(&kind, "", &[(1, "another state of the shot"), (2, "another state of the shot")]);
        restored();
    }
}

/// The same file with other pixels, as long and as old as before.
fn disguised(path: &std::path::Path, change: impl FnOnce()) {
    let before = path.metadata().expect("it is there").modified().expect("a time");
    change();
    std::fs::File::options().append(true).open(path).expect("open").set_modified(before).expect("set");
}

#[test]
fn frames_whose_files_hold_something_else_are_made_again() {
    const WHY: &str = "a file that it is made from (scene, picture, plate or lattice) has changed";
    for (kind, source) in kinds().iter().zip(["tiny.gltf", "cat.png", "tiny.gltf", "tiny.gltf"]) {
        let bench = &kind.bench;
        bench.run(kind.run).says(0, &[]);
        let path = bench.path(source);
        let good = bench.read(source);
        disguised(&path, || match source {
            "cat.png" => {
                let mut cat = image::open(&path).expect("a picture").to_rgba8();
                cat.put_pixel(30, 20, image::Rgba([1, 2, 3, 255]));
                cat.save(&path).expect("saved");
            }
            // Blanks are no change of the scene, and still other bytes.
            _ => bench.write(source, &[&good[..], b"\n"].concat()),
        });
        resumed(kind, "", &[(1, WHY), (2, WHY)]);
        resumed(kind, "", &[]);
        bench.write(source, &good);
        resumed(kind, "", &[(1, WHY), (2, WHY)]);
    }
    // Of plates only the frame's own counts.
    let [.., plates, pngs] = &kinds();
    for (kind, source) in [(plates, "in/b.0002.exr"), (pngs, "in.0002.png")] {
        kind.bench.run(kind.run).says(0, &[]);
        let mut bytes = kind.bench.read(source);
        bytes.push(0);
        disguised(&kind.bench.path(source), || kind.bench.write(source, &bytes));
        resumed(kind, "", &[(2, WHY)]);
        resumed(kind, "", &[]);
    }
}

#[test]
fn plates_that_are_missing_are_told_when_all_others_are_done() {
    let [.., Kind { bench, run, frames }] = kinds();
    let shot = String::from_utf8(bench.read("shot.toml")).expect("text").replace("last = 2", "last = 4");
    bench.write("shot.toml", shot.as_bytes());
    bench.run(run).says(1, &["frame 3: cannot read in.0003.png", "frame 4: cannot read in.0004.png", "2 FAILED"]);
    let good = frames.map(|name| bench.read(name));
    let run = format!("{run} --resume");
    bench.run(&run).says(1, &["2 kept", "frame 3: cannot read", "frame 4: cannot read in.0004.png", "2 FAILED"]);
    let events = bench.run(&format!("{run} --json")).says(1, &[]).events();
    let last = events.last().expect("events");
    assert_eq!((&last["kept"], &last["warped"], &last["failed"]), (&2.into(), &0.into(), &2.into()), "{last}");
    assert_eq!(frames.map(|name| bench.read(name)), good);
    // Where no frame at all has a plate, the path is wrong.
    bench.run(&format!("{run} --frames 3-4")).says(2, &["in.0003.png: it is not there, nor is any other"]);
}

#[test]
fn lattices_and_clean_plates_that_changed_are_seen() {
    let bench = Bench::new();
    bench.render("-o in/b.####.exr").says(0, &[]);
    bench.run("export shot.toml --to lattice-json -o l.json").says(0, &[]);
    std::fs::copy(bench.path("in/b.0001.exr"), bench.path("clean.exr")).expect("copied");
    let run = "warp in/b.####.exr --lattice l.json --clean clean.exr -o out/f.####.exr --device cpu";
    let kind = Kind { bench, run, frames: ["out/f.0001.exr", "out/f.0002.exr"] };
    kind.bench.run(run).says(0, &[]);
    let mut clean = kind.bench.read("clean.exr");
    clean.push(0);
    kind.bench.write("clean.exr", &clean);
    resumed(&kind, "", &[(1, "has changed"), (2, "has changed")]);
    let lattice = String::from_utf8(kind.bench.read("l.json")).expect("text");
    let place = lattice.rfind("handles").expect("handles");
    let digit = place + lattice[place..].find(['1', '2', '3']).expect("a digit");
    let mut other = lattice.into_bytes();
    other[digit] = b'4';
    kind.bench.write("l.json", &other);
    resumed(&kind, "", &[(1, "another state"), (2, "another state")]);
}

#[test]
fn a_changed_byte_is_found_on_request() {
    for kind in kinds() {
        let bench = &kind.bench;
        bench.run(kind.run).says(0, &[]);
        let good = bench.read(kind.frames[1]);
        // Bytes of pixels: the head is most of so small a file.
        for place in [good.len() - 20, good.len() - 60, good.len() - 120] {
            let mut bytes = good.clone();
            bytes[place] ^= 0x10;
            bench.write(kind.frames[1], &bytes);
            let why = if kind.frames[1].ends_with(".png") { "damaged" } else { "" };
            resumed(&kind, "--verify", &[(2, why)]);
            assert_eq!(bench.read(kind.frames[1]), good, "{} at {place}", kind.run);
        }
    }
}

#[test]
fn other_sizes_versions_and_devices_are_made_again() {
    let bench = Bench::new();
    bench.render("").says(0, &[]);
    let good = bench.read("out/f.0001.exr");
    bench.render("--resume --scale 1/2").says(0, &["2 frames are rendered again (1 to 2): its size is 64 x 36"]);
    bench.render("--resume").says(0, &["its size is 32 x 18"]);
    assert_eq!(bench.read("out/f.0001.exr"), good);
    bench.render("--resume --samples 2").says(0, &["another state of the shot"]);
    bench.render("--resume").says(0, &["another state of the shot"]);
    let replaced = |from: &str, to: &str| {
        assert_eq!(from.len(), to.len());
        let place = good.windows(from.len()).position(|bytes| bytes == from.as_bytes()).expect("it is in the head");
        let mut bytes = good.clone();
        bytes[place..place + to.len()].copy_from_slice(to.as_bytes());
        bench.write("out/f.0001.exr", &bytes);
    };
    replaced("\"device\":\"CPU", "\"device\":\"GPU");
    bench.render("--resume").says(0, &["1 frame is rendered again (1): it was drawn on GPU"]);
    replaced(&format!("\"version\":\"{}", env!("CARGO_PKG_VERSION")), "\"version\":\"9.9.9");
    bench.render("--resume").says(0, &["1 frame is rendered again (1): pinwarp 9.9.9 wrote it"]);
    assert_eq!(bench.read("out/f.0001.exr"), good);
}

#[test]
fn previews_belong_to_their_frames() {
    let bench = Bench::new();
    bench.render("--preview").says(0, &[]);
    let plain = bench.read("out/f.0002.png");
    bench.render("--preview --resume").says(0, &["0 frames", "2 kept"]);
    bench.render("--overlay --resume").says(0, &["2 frames are rendered again", "preview is missing or out of date"]);
    assert_ne!(bench.read("out/f.0002.png"), plain, "the overlay is drawn");
    bench.write("out/f.0002.png", &plain[..plain.len() / 2]);
    bench.render("--preview --resume").says(0, &["preview is missing or out of date"]);
    assert_eq!(bench.read("out/f.0002.png"), plain);
}

#[test]
fn maps_are_checked_as_frames_are() {
    let bench = Bench::new();
    for (format, output, name) in
        [("stmap", "st/m.####.exr", "st/m.0001.exr"), ("after-effects", "ae/x", "ae/x.all.displacement_4px.0001.png")]
    {
        let export = format!("export shot.toml --to {format} -o {output}");
        bench.run(&export).says(0, &[]);
        let folder = bench.path(name).parent().expect("a folder").to_owned();
        let found =
            names_in(&folder).into_iter().find(|other| other.ends_with("0001.exr") || other.ends_with("0001.png"));
        let path = folder.join(found.expect("a map"));
        let good = std::fs::read(&path).expect("read");
        std::fs::write(&path, &good[..good.len() / 2]).expect("written");
        bench.run(&format!("{export} --resume")).says(0, &["rendered again (1)", "cut off or damaged"]);
        assert!(std::fs::read(&path).expect("read") == good, "{format}: the same bytes");
    }
}

#[test]
fn leftovers_of_killed_runs_are_removed() {
    let bench = Bench::new();
    bench.render("").says(0, &[]);
    let clean = names_in(&bench.path("out"));
    let second = bench.read("out/f.0002.exr");
    for name in ["out/.f.0002.exrAb12Cd.tmp", "out/.f.0002.exr.tmp", "out/.pinwarp-dead01.lock"] {
        bench.write(name, b"part");
    }
    bench.write("out/.other.tmp.txt", b"not ours");
    std::fs::remove_file(bench.path("out/f.0002.exr")).expect("removed");
    bench.render("--resume").says(0, &["1 frame on CPU"]);
    assert_eq!(bench.read("out/f.0002.exr"), second);
    std::fs::remove_file(bench.path("out/.other.tmp.txt")).expect("strangers' files stay");
    assert_eq!(names_in(&bench.path("out")), clean);
    bench.write("result.json", b"{}");
    bench.write(".result.json4f5G6h.tmp", b"part");
    bench.run("export shot.toml --to lattice-json -o result.json --overwrite").says(0, &[]);
    assert!(!bench.path(".result.json4f5G6h.tmp").exists());
}

#[test]
fn leftovers_of_a_run_killed_after_its_last_frame_are_removed() {
    for Kind { bench, run, frames } in kinds() {
        bench.run(run).says(0, &[]);
        let clean = names_in(&bench.path("out"));
        let [_, last] = frames.map(|frame| frame.trim_start_matches("out/"));
        for name in [format!("out/.{last}Ab12Cd.tmp"), "out/.pinwarp-dead01.lock".to_owned()] {
            bench.write(&name, b"part");
        }
        bench.run(&format!("{run} --resume")).says(0, &[]);
        assert_eq!(names_in(&bench.path("out")), clean, "{run}");
    }
}

#[test]
fn runs_that_make_the_same_frames_exclude_each_other() {
    let head = HEAD.replace("last = 2", "last = 4000").replace("samples = 1", "samples = 4");
    let bench = Bench::with_shot(&format!("{head}{PIN}{OUTPUT}"));
    let mut command = Command::new(PROGRAM);
    command.current_dir(bench.path("")).args(["render", "shot.toml", "--device", "cpu", "--frames", "1-3000"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts");
    while !bench.path("out/f.0001.exr").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let busy = bench.command(PROGRAM).args(["render", "shot.toml", "--device", "cpu", "--resume"]).output();
    let other_frames =
        bench.command(PROGRAM).args(["render", "shot.toml", "--device", "cpu", "--frames", "3999"]).output();
    child.kill().expect("killed");
    child.wait().expect("ended");
    let busy = String::from_utf8(busy.expect("the program starts").stderr).expect("text");
    assert!(busy.contains(&format!("process {} is writing frame", child.id())), "{busy}");
    assert_eq!(other_frames.expect("the program starts").status.code(), Some(0), "farms share a folder");
    // The dead run blocks nobody, and nothing of it is left.
    let last = bench.frames().iter().filter(|name| name.starts_with("f.") && *name != "f.3999.exr").count();
    bench.render(&format!("--frames 1-{} --resume", last + 20)).says(0, &[]);
    assert!(bench.frames().iter().all(|name| !name.starts_with('.')), "{:?}", bench.frames());
}

#[test]
fn frames_on_the_disk_before_they_have_their_names() {
    let bench = Bench::new();
    bench.render("").says(0, &[]);
    let before = bench.read("out/f.0002.exr");
    bench.render("--overwrite --fsync --preview").says(0, &[]);
    assert_eq!(bench.read("out/f.0002.exr"), before);
    // Only with a tracer can one see that the disk was waited for.
    let mut command = bench.command("strace");
    command.args(["-f", "-e", "trace=fsync,fdatasync,rename,renameat,renameat2", PROGRAM]);
    let arguments = ["render", "shot.toml", "--device", "cpu", "--overwrite", "--frames", "1"];
    let Ok(traced) = command.args(arguments).arg("--fsync").output() else {
        crate::skip::skip("strace is not installed, so --fsync was run but not watched");
        return;
    };
    let calls = String::from_utf8_lossy(&traced.stderr).into_owned();
    let sync = calls.find("fsync(").expect("a file is synchronised");
    assert!(sync < calls.find("f.0001.exr\"").expect("renamed"), "{calls}");
}

#[test]
fn metadata_carries_no_clock() {
    let bench = Bench::new();
    let frame = Frame {
        channels: vec![pinwarp::image::Channel {
            name: "R".into(),
            storage: pinwarp::image::Storage::Half,
            samples: vec![0.5; 4],
        }],
        display: pinwarp::space::PixelRect { x: 0, y: 0, width: 2, height: 2 },
        data_window: pinwarp::space::PixelRect { x: 0, y: 0, width: 2, height: 2 },
        pixel_aspect: 1.0,
    };
    let write = |name: &str| {
        let metadata =
            FrameMetadata { frame: 3, shot_hash: "x".into(), device: "CPU".into(), ..FrameMetadata::default() };
        write_exr(&bench.path(name), &frame, &metadata, pinwarp::image::Compression::Zip).expect("written");
        bench.read(name)
    };
    assert_eq!(write("a.exr"), write("b.exr"));
}
