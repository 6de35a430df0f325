//! Options of `render`, and nonsense in their place.

use crate::support::{Bench, HEAD, OUTPUT, PIN};
use pinwarp::image::{Storage, read_exr};
use serde_json::Value;

#[test]
fn invalid_frames_are_refused() {
    for list in ["", "a", "5-1", "1-5x0", "1,,2", "0-99999999", "2147483647", "-2147483648", "1-2x", "1.5"] {
        let bench = Bench::new();
        let mut command = bench.command(crate::support::PROGRAM);
        let output = command.args(["render", "shot.toml", "--device", "cpu", "--frames", list]).output();
        let ended = bench.checked(output.expect("the program starts"));
        ended.says(2, &["--frames"]);
        assert!(bench.frames().is_empty());
    }
    Bench::new().render("--frames 5-1").says(2, &["'5-1' holds no frame", "ranges go up"]);
    Bench::new().render("--frames a").says(2, &["'a' is not a frame or a range", "1-48x2,60"]);
}

#[test]
fn frames_in_any_order_and_outside_the_range() {
    let bench = Bench::new();
    bench.render("--frames 3,-1-1x2,3").says(0, &["3 frames on CPU"]);
    assert_eq!(bench.frames(), ["f.-001.exr", "f.0001.exr", "f.0003.exr"]);
}

#[test]
fn invalid_scales_are_refused() {
    for scale in ["0", "-1", "x", "1/0", "nan", "inf", "17"] {
        Bench::new().render(&format!("--scale={scale}")).says(2, &["--scale", "a factor above 0", "1/2"]);
    }
}

#[test]
fn scale_changes_the_size_only() {
    let bench = Bench::new();
    bench.render("--scale 1/2 --frames 1").says(0, &[]);
    let frame = read_exr(&bench.path("out/f.0001.exr")).expect("readable");
    assert_eq!((frame.display.width, frame.display.height), (32, 18));
    bench.render("--scale 1/1000 --frames 2").says(0, &[]);
    let frame = read_exr(&bench.path("out/f.0002.exr")).expect("readable");
    assert_eq!((frame.display.width, frame.display.height), (1, 1));
}

#[test]
fn invalid_samples_are_refused() {
    for samples in ["0", "-3", "x", "1.5", "99999"] {
        Bench::new().render(&format!("--samples={samples}")).says(2, &["--samples"]);
    }
}

#[test]
fn one_path_for_two_frames_is_refused() {
    let bench = Bench::new();
    bench.render("-o single.exr").says(2, &["single.exr", "no frame counter for 2 frames", "single.####.exr"]);
    bench.render("-o single.exr --frames 2").says(0, &["frame 2 -> single.exr"]);
    bench.render("-o picture.####.png").says(2, &["picture.####.png", "not the name of an EXR file", "--preview"]);
    bench.render("-o two.##.%03d.exr").says(2, &["two frame counters"]);
    bench.render("-o printf.%03d.exr").says(0, &["printf.001.exr", "printf.002.exr"]);
}

#[test]
fn the_output_folder_stands_beside_the_shot() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("elsewhere")).expect("a folder");
    let mut command = bench.command(crate::support::PROGRAM);
    command.current_dir(bench.path("elsewhere")).args(["render", "../shot.toml", "--device", "cpu"]);
    bench.checked(command.output().expect("the program starts")).says(0, &[]);
    assert_eq!(bench.frames(), ["f.0001.exr", "f.0002.exr"]);
}

#[test]
fn an_unknown_device_is_refused() {
    let bench = Bench::new();
    let ended = bench.run("render shot.toml --device no-such-thing").says(2, &["cpu"]);
    // Without any driver there is nothing to match.
    let is_told = ["no device matches 'no-such-thing'", "no usable Vulkan device"].iter();
    assert!(is_told.clone().any(|words| ended.stderr.contains(words)), "{}", ended.stderr);
    assert!(bench.frames().is_empty());
}

#[test]
fn without_drivers_the_cpu_draws() {
    let bench = Bench::new();
    let mut command = bench.command(crate::support::PROGRAM);
    command.env("VK_ICD_FILENAMES", "/nowhere.json").env("VK_DRIVER_FILES", "/nowhere.json");
    let output = command.args(["render", "shot.toml"]).output().expect("the program starts");
    bench.checked(output).says(0, &["2 frames on CPU"]);
}

#[test]
fn json_lines_tell_every_frame() {
    let bench = Bench::new();
    let ended = bench.render("--json").says(0, &[]);
    assert_eq!(ended.stderr, "");
    let events = ended.events();
    let named = |name: &str| events.iter().filter(|event| event["event"] == name).collect::<Vec<_>>();
    assert_eq!(named("started")[0]["frames"], 2);
    let done = named("frame_done");
    assert_eq!(done.iter().map(|event| event["frame"].as_i64()).collect::<Vec<_>>(), [Some(1), Some(2)]);
    for event in done {
        let layer = &event["layers"][0];
        assert_eq!(layer["layer"], "all");
        assert!(layer["pin_error_px"].as_f64().is_some_and(|error| error < 0.05), "{event}");
        assert!(layer["solve"]["iterations"].is_u64() && layer["solve"]["folded_cells"] == 0, "{event}");
        assert!(event["path"].as_str().is_some_and(|path| bench.path(path).is_file()), "{event}");
    }
    let last = events.last().expect("events");
    assert_eq!((&last["event"], &last["rendered"], &last["failed"]), (&"finished".into(), &2.into(), &0.into()));
}

#[test]
fn json_tells_failures_too() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("out/f.0001.exr/inside")).expect("a folder");
    let events = bench.render("--json --overwrite").says(1, &[]).events();
    let failed: Vec<&Value> = events.iter().filter(|event| event["event"] == "frame_failed").collect();
    assert_eq!(failed.len(), 1, "{events:?}");
    assert_eq!(failed[0]["frame"], 1);
    assert!(failed[0]["error"].as_str().is_some_and(|text| text.contains("f.0001.exr")));
}

#[test]
fn previews_are_srgb_pictures() {
    let bench = Bench::new();
    bench.render("--preview --frames 1").says(0, &[]);
    assert_eq!(bench.frames(), ["f.0001.exr", "f.0001.png"]);
    let picture = image::load_from_memory(&bench.read("out/f.0001.png")).expect("a PNG file").to_rgba8();
    assert_eq!(picture.dimensions(), (64, 36));
    // Linear .5 .25 .125 by the sRGB curve.
    assert_eq!(picture.get_pixel(32, 18).0, [188, 137, 99, 255]);
    assert_eq!(picture.get_pixel(0, 0).0[3], 0);
}

#[test]
fn overlays_draw_pins_over_the_preview() {
    let bench = Bench::new();
    bench.render("--preview --frames 2").says(0, &[]);
    let plain = bench.read("out/f.0002.png");
    bench.render("--overlay --frames 2 --overwrite").says(0, &[]);
    let drawn = image::load_from_memory(&bench.read("out/f.0002.png")).expect("a PNG file").to_rgba8();
    let plain = image::load_from_memory(&plain).expect("a PNG file").to_rgba8();
    // The pin's rest is the lower left corner of the square; its target is [.1, .05] away: yellow.
    let target = drawn.get_pixel((0.1 * 36.0 + 64.0 / 2.0 - 0.4 * 36.0) as u32, (36.0 * (0.9 - 0.05)) as u32);
    assert!(target.0[0] > 200 && target.0[1] > 150 && target.0[2] < 120, "{target:?}");
    assert!(drawn.pixels().zip(plain.pixels()).filter(|(a, b)| a != b).count() > 100);
}

#[test]
fn channels_are_those_asked_for() {
    let output = format!("{OUTPUT}channels = [\"depth\", \"beauty\"]\n");
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{output}"));
    bench.render("--frames 1").says(0, &[]);
    let frame = read_exr(&bench.path("out/f.0001.exr")).expect("readable");
    let mut channels: Vec<_> = frame.channels.iter().map(|c| (c.name.as_str(), c.storage)).collect();
    channels.sort_by_key(|channel| channel.0);
    let half = |name| (name, Storage::Half);
    assert_eq!(channels, [half("A"), half("B"), half("G"), half("R"), ("depth.Z", Storage::Float)]);
}
