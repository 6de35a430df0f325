//! `pinwarp warp`: plates in, plates out, and everything that can be wrong with what it is given.

use crate::support::{Bench, HEAD, OUTPUT, PIN, PROGRAM, square};
use pinwarp::image::{Channel, Frame, Plate, Storage, read_plate, write_picture, write_plate};
use pinwarp::space::{FrameSize, PixelRect};
use std::path::Path;

/// A shot over a plate: a lattice over the whole frame that shifts its middle by an eighth of its height.
const SHOT: &str = r#"
plate  = "in/b.####.exr"
frames = { first = 1, last = 2 }

[[layer]]
name    = "all"

  [[layer.pin]]
  anchor = { screen = [0.889, 0.5] }
  keys   = [ { frame = 1, offset = [0.0, 0.0] }, { frame = 2, offset = [0.125, 0.0] } ]

[output]
path = "out/w.####.exr"
"#;

/// A grey frame with a white square in the middle, 8 pixels wide; a depth; numbers of things.
fn frame(size: FrameSize) -> Frame {
    let window = size.window();
    let places = || (0..size.height as i32).flat_map(|y| (0..size.width as i32).map(move |x| (x, y)));
    let is_square =
        move |(x, y): (i32, i32)| (x - size.width as i32 / 2).abs() <= 4 && (y - size.height as i32 / 2).abs() <= 4;
    let channel = |name: &str, storage, [inside, outside]: [f32; 2]| Channel {
        name: name.into(),
        storage,
        samples: places().map(|place| if is_square(place) { inside } else { outside }).collect(),
    };
    let mut channels: Vec<Channel> = ["R", "G", "B"].map(|name| channel(name, Storage::Half, [1.0, 0.25])).into();
    channels.push(channel("A", Storage::Half, [1.0, 1.0]));
    channels.push(channel("depth.Z", Storage::Float, [2.0, 10.0]));
    channels.push(channel("id.object", Storage::Uint, [7, 3].map(f32::from_bits)));
    Frame { display: window, data_window: window, pixel_aspect: size.pixel_aspect, channels }
}

/// Two plates of 64 x 36 pixels, and a shot over them.
fn bench(shot: &str) -> Bench {
    let bench = Bench::with(&square().json(), shot);
    std::fs::create_dir_all(bench.path("in")).expect("a folder");
    for number in [1, 2] {
        let plate = Plate::from_frame(frame(FrameSize::new(64, 36)));
        write_plate(&bench.path(&format!("in/b.000{number}.exr")), &plate).expect("written");
    }
    bench
}

/// The columns of the middle row in which a channel holds a value.
fn columns(path: &Path, channel: &str, holds: impl Fn(f32) -> bool) -> Vec<i32> {
    let plate = read_plate(path).expect("a plate");
    let PixelRect { x, y, width, .. } = plate.parts[0].data_window;
    let samples = &plate.parts[0].channel(channel).expect("the channel is there").samples;
    let row = (plate.display.height as i32 / 2 - y) as usize * width as usize;
    (0..width as i32).filter(|&column| holds(samples[row + column as usize])).map(|column| column + x).collect()
}

#[test]
fn a_shot_warps_its_plate() {
    let bench = bench(SHOT);
    let ended = bench.run("warp --shot shot.toml").says(0, &["2 frames", "frame 2 -> out/w.0002.exr"]);
    assert!(!ended.stderr.contains("warning"), "{}", ended.stderr);
    let [before, after] = ["out/w.0001.exr", "out/w.0002.exr"].map(|name| bench.path(name));
    let is_near = |value: f32| value == 2.0;
    assert_eq!(columns(&before, "depth.Z", is_near), (28..=36).collect::<Vec<_>>(), "nothing moves in frame 1");
    let moved = columns(&after, "depth.Z", is_near);
    let middle = f64::from(moved.iter().sum::<i32>()) / moved.len() as f64;
    assert!((middle - 36.5).abs() <= 1.0, "4.5 pixels to the right: {moved:?}");
    assert_eq!(columns(&after, "id.object", |id| id.to_bits() == 7), moved, "ids go where depth goes");
    assert_eq!(
        columns(&after, "depth.Z", |value| value == 1e10),
        Vec::<i32>::new(),
        "the border stays, so nothing comes from outside the frame"
    );
    assert_eq!(
        columns(&after, "depth.Z", |depth| ![2.0, 10.0, 1e10].contains(&depth)),
        Vec::<i32>::new(),
        "never blended"
    );
}

#[test]
fn layers_that_bend_each_others_parts_are_reported_once() {
    let two = SHOT.replace(
        "[output]",
        "[[layer]]\nname = \"other\"\n  [[layer.pin]]\n  anchor = { screen = [0.4, 0.5] }\n\n[output]",
    );
    let says = ["note: layers 'all', 'other' have no matte: each bends the whole picture", "matte = \"none\""];
    let ended = bench(&two).run("warp --shot shot.toml").says(0, &says);
    assert_eq!(ended.stderr.matches("have no matte").count(), 1, "{}", ended.stderr);
    let meant = two.replace("name = \"other\"", "name = \"other\"\nmatte = \"none\"");
    let ended = bench(&meant).run("warp --shot shot.toml").says(0, &[]);
    assert!(!ended.stderr.contains("have no matte"), "{}", ended.stderr);
}

/// Two pins that change places cannot both be met, and one that leaves the frame takes the border along.
#[test]
fn missed_pins_and_displaced_borders_are_told() {
    let shot = SHOT.replace(
        "[output]",
        "[[layer.pin]]\nname = \"gone\"\nanchor = { screen = [0.1, 0.5] }\nkeys = [{ frame = 1, offset = [-0.2, 0.0] }]\n\n\
         [[layer.pin]]\nname = \"here\"\nanchor = { screen = [1.2, 0.5] }\nkeys = [{ frame = 1, offset = [0.2, 0.0] }]\n\n\
         [[layer.pin]]\nname = \"there\"\nanchor = { screen = [1.4, 0.5] }\nkeys = [{ frame = 1, offset = [-0.2, 0.0] }]\n\n\
         [output]",
    );
    let bench = bench(&shot);
    let words = ["pin 'gone' comes too close to the border", "pin 'here' is ", "pin 'there' is "];
    for command in ["warp --shot shot.toml", "export shot.toml --to stmap -o maps/m.####.exr"] {
        bench.run(command).says(0, &words);
    }
}

#[test]
fn json_lines_tell_what_was_done() {
    let bench = bench(SHOT);
    let events = bench.run("warp --shot shot.toml --json").says(0, &[]).events();
    let done: Vec<_> = events.iter().filter(|event| event["event"] == "frame_done").collect();
    assert_eq!(done.iter().map(|event| event["frame"].as_i64()).collect::<Vec<_>>(), [Some(1), Some(2)]);
    let channels = done[0]["channels"].as_array().expect("what channels were taken for");
    assert_eq!(channels.len(), 6);
    assert!(channels.iter().any(|channel| channel["channel"] == "depth.Z" && channel["meaning"] == "depth"));
    assert!(done[1]["channels"].is_null(), "told once: {}", done[1]);
    assert!(done.iter().all(|event| event["read_ms"].is_f64() && event["hole_pixels"] == 0), "{events:?}");
    assert!(done.iter().all(|event| event["folded_pixels"] == 0), "{events:?}");
    let last = events.last().expect("events");
    assert_eq!((&last["event"], &last["warped"], &last["failed"]), (&"finished".into(), &2.into(), &0.into()));
}

#[test]
fn channels_left_out_of_plates_are_reported_once() {
    let bench = bench(SHOT);
    for number in [1, 2] {
        let mut plate = Plate::from_frame(frame(FrameSize::new(64, 36)));
        plate.parts[0].set_text("cryptomatte/1234567/name", "CryptoObject");
        plate.parts[0].set_text("cryptomatte/1234567/manif_file", "names.json");
        write_plate(&bench.path(&format!("in/b.000{number}.exr")), &plate).expect("written");
    }
    let told =
        bench.run("warp --shot shot.toml").says(0, &["note: left out of the plate from frame 1 on", "names.json"]);
    assert_eq!(told.stderr.matches("left out").count() + told.stdout.matches("left out").count(), 1, "{}", told.stderr);
}

#[test]
fn invalid_stmaps_are_named() {
    let bench = bench(SHOT);
    let stmap = Plate::from_frame(frame(FrameSize::new(32, 18)));
    write_plate(&bench.path("m.exr"), &stmap).expect("written");
    let says = ["m.exr: the map is for a frame of [32, 18] pixels, the plate shows [64, 36]"];
    bench.run("warp in/b.####.exr --stmap m.exr -o out/w.####.exr").says(2, &says);
    let channels = stmap.parts[0].channels[3..].to_vec();
    let blind = stmap.with_parts(vec![stmap.parts[0].with_channels(stmap.parts[0].data_window, channels)]);
    write_plate(&bench.path("m.exr"), &blind).expect("written");
    let says = ["m.exr: the picture is not an STMap: its channels are A, depth.Z, id.object"];
    bench.run("warp in/b.####.exr --stmap m.exr -o out/w.####.exr").says(2, &says);
}

#[test]
fn lattices_warp_what_is_there() {
    let whole = bench(&format!("size = [64, 36]\n{SHOT}"));
    whole.run("export shot.toml --to lattice-json").says(0, &["layer 'all': its lattice is only part of its warp"]);
    // A fixed box is the lattice's alone.
    let fixed = SHOT.replace("\"all\"\n", "\"all\"\nlattice = { box = { fixed = [0.0, 0.0, 1.7777, 1.0] } }\n");
    let bench = bench(&format!("size = [64, 36]\n{fixed}"));
    bench.run("warp --shot shot.toml").says(0, &[]);
    let told = bench.run("export shot.toml --to lattice-json").says(0, &[]);
    assert!(!told.stderr.contains("only part"), "{}", told.stderr);
    bench.run("warp in/b.####.exr --lattice shot.lattice.json -o by/l.####.exr").says(0, &["2 frames found, 1 to 2"]);
    for frame in ["0001", "0002"] {
        let [of_shot, of_file] = [format!("out/w.{frame}.exr"), format!("by/l.{frame}.exr")]
            .map(|name| read_plate(&bench.path(&name)).expect("a plate").into_frame());
        assert_eq!(of_shot, of_file, "frame {frame}");
    }
    let half = "warp in/b.####.exr --lattice shot.lattice.json -o half/l.####.exr --strength 0 --frames 2";
    bench.run(half).says(0, &[]);
    assert_eq!(columns(&bench.path("half/l.0002.exr"), "depth.Z", |depth| depth == 2.0), (28..=36).collect::<Vec<_>>());
}

#[test]
fn a_bad_frame_does_not_stop_the_others() {
    let bench = bench(&SHOT.replace("last = 2", "last = 3"));
    bench.run("warp --shot shot.toml").says(1, &["error: frame 3: cannot read in/b.0003.exr", "1 FAILED"]);
    assert_eq!(bench.frames(), ["w.0001.exr", "w.0002.exr"]);
    let pictures = self::bench(&SHOT.replace("in/b.####.exr", "in/b.####.png"));
    let picture =
        Frame { channels: frame(FrameSize::new(64, 36)).channels[..3].to_vec(), ..frame(FrameSize::new(64, 36)) };
    write_picture(&pictures.path("in/b.0001.png"), &Plate::from_frame(picture)).expect("written");
    pictures.write("in/b.0002.png", b"no picture");
    pictures.run("warp --shot shot.toml").says(1, &["frame 1 ->", "error: frame 2: in/b.0002.png", "1 FAILED"]);
}

#[test]
fn resume_keeps_what_is_whole() {
    let bench = bench(SHOT);
    bench.run("warp --shot shot.toml").says(0, &[]);
    bench.run("warp --shot shot.toml").says(2, &["2 of the frames exist already", "--resume"]);
    let [first, second] = ["out/w.0001.exr", "out/w.0002.exr"].map(|name| bench.read(name));
    bench.write("out/w.0002.exr", &second[..second.len() / 2]);
    let ended = bench.run("warp --shot shot.toml --resume").says(0, &["1 frame, 1 kept", "frame 2 ->", "cut off"]);
    assert!(!ended.stderr.contains("another state"), "{}", ended.stderr);
    assert_eq!([bench.read("out/w.0001.exr"), bench.read("out/w.0002.exr")], [first, second], "the same bytes");
    let again = "2 frames are rendered again (1 to 2): it was made from another state of the shot";
    bench.run("warp --shot shot.toml --resume --filter nearest").says(0, &["2 frames", again]);
}

#[test]
fn pictures_stay_pictures() {
    let bench = bench(&SHOT.replace("w.####.exr", "w.####.png").replace("in/b.####.exr", "in/still.png"));
    let picture =
        Frame { channels: frame(FrameSize::new(64, 36)).channels[..4].to_vec(), ..frame(FrameSize::new(64, 36)) };
    write_picture(&bench.path("in/still.png"), &Plate::from_frame(picture)).expect("written");
    bench.run("warp --shot shot.toml").says(0, &["frame 2 -> out/w.0002.png"]);
    let whites = |name: &str| {
        let picture = image::load_from_memory(&bench.read(name)).expect("a PNG file").to_rgb8();
        (0..64).filter(|&x| picture.get_pixel(x, 18).0[0] > 240).collect::<Vec<u32>>()
    };
    assert_eq!(whites("out/w.0001.png"), (28..=36).collect::<Vec<_>>());
    assert!(whites("out/w.0002.png").first().is_some_and(|&first| (32..=34).contains(&first)));
    bench.run("warp --shot shot.toml -o out/e.####.exr").says(0, &["frame 2 -> out/e.0002.exr"]);
}

#[test]
fn unsupported_inputs_are_refused() {
    let bench = bench(SHOT);
    let wrong = [
        ("warp in/b.####.exr", &["--shot", "--lattice", "--stmap"][..]),
        ("warp --lattice l.json -o a.exr", &["<PLATE>"]),
        ("warp in/b.####.exr --lattice l.json", &["--output"]),
        ("warp in/b.####.exr --lattice nowhere.json -o a.####.exr", &["cannot read nowhere.json"]),
        (
            "warp in/b.####.exr --shot shot.toml -o in/b.####.exr --overwrite",
            &["is an input of this job and would be overwritten", "-o"],
        ),
        (
            "warp in/b.####.exr --shot shot.toml -o in/../in/b.%04d.exr",
            &["is an input of this job and would be overwritten"],
        ),
        ("warp in/b.####.exr --shot shot.toml -o w.exr", &["no frame counter for 2 frames", "w.####.exr"]),
        ("warp in/b.####.exr --shot shot.toml -o w.####.png", &["cannot hold the channels", ".exr"]),
        (
            "warp in/b.####.exr --shot shot.toml -o w.####.jpg",
            &["w.####.jpg: JPEG files cannot be written; use .exr\n"],
        ),
        ("warp in/b.####.tif --shot shot.toml", &["is not the name of a picture", ".png, .jpg or .exr"]),
        ("warp in/b.##.##.exr --shot shot.toml", &["two frame counters"]),
        ("warp --shot shot.toml --layer al", &["has no layer 'al'", "did you mean"]),
        ("warp --shot shot.toml --filter sinc", &["ewa, cubic, lanczos or nearest"]),
        ("warp --shot shot.toml --matte alpha", &["--matte", "--shot", "cannot be used"]),
        ("warp --shot shot.toml --strength nan", &["a number is needed"]),
        (
            "warp in/c.####.exr --stmap in/b.####.exr -o w.####.exr",
            &["there are no frames in/c.####.exr", "in/c.0001.exr"],
        ),
        ("warp in/b.####.exr --stmap in/b.0001.exr --inverse -o w.####.exr", &["--inverse", "--stmap"]),
        ("render shot.toml", &["no scene to render", "pinwarp warp"]),
    ];
    for (arguments, says) in wrong {
        bench.run(arguments).says(2, says);
    }
    assert!(bench.frames().is_empty());
}

#[test]
fn a_first_plate_that_is_missing_or_damaged_stops_no_other() {
    let bench = bench(SHOT);
    std::fs::remove_file(bench.path("in/b.0001.exr")).expect("removed");
    bench.run("warp --shot shot.toml").says(1, &["frame 1: cannot read in/b.0001.exr", "1 frame", "1 FAILED"]);
    assert_eq!(bench.frames(), ["w.0002.exr"]);
    // Not by `run`, which expects all files to be whole.
    let run = |arguments: &str| {
        let output = bench.command(PROGRAM).args(arguments.split_whitespace()).output().expect("the program starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    bench.write("in/b.0001.exr", b"rubbish");
    let (code, told) = run("warp --shot shot.toml --resume");
    let words = ["1 kept", "frame 1: ", "b.0001.exr", "1 FAILED"];
    assert!(code == Some(1) && words.iter().all(|word| told.contains(word)), "{code:?} {told}");
    std::fs::remove_file(bench.path("in/b.0002.exr")).expect("removed");
    let (code, told) = run("warp --shot shot.toml --overwrite");
    assert!(code == Some(2) && told.contains("b.0001.exr"), "{code:?} {told}");
}

#[test]
fn jpeg_files_are_read_and_not_written() {
    let bench = Bench::plain();
    for name in ["drawn.jpg", "drawn.png"] {
        image::RgbImage::from_pixel(64, 36, image::Rgb([200, 100, 50])).save(bench.path(name)).expect("saved");
        for output in ["w.jpg", "w.JPEG"] {
            let says = [output, ": JPEG files cannot be written; use .exr or .png"];
            bench.run(&format!("warp {name} --shot shot.toml --frames 2 -o {output}")).says(2, &says);
            assert!(!bench.path(output).exists());
        }
        bench.run(&format!("warp {name} --shot shot.toml --frames 2 -o {name}.png")).says(0, &[]);
    }
}

#[test]
fn a_plate_of_another_shape_is_another_shot() {
    let bench = bench(&format!("size = [64, 64]\n{SHOT}"));
    let shapes = ["in/b.0001.exr shows 64 x 36 pixels, 1.7778 wide to 1 high, the shot is 1.0000 to 1"];
    bench.run("warp --shot shot.toml").says(2, &shapes);
    assert!(bench.frames().is_empty());
    // A proxy of the right shape is welcome: 1920 x 1080 by a thirtieth.
    let proxy = self::bench(&format!("size = [1920, 1080]\n{SHOT}"));
    proxy.run("warp --shot shot.toml").says(0, &["2 frames"]);
}

#[test]
fn lattices_of_the_scene_cannot_warp_plates() {
    let world = r#"
scene  = "tiny.gltf"
plate  = "in/b.####.exr"
frames = { first = 1, last = 2 }
size   = [64, 36]

[[layer]]
name    = "deep"
lattice = { space = "world", dims = [4, 4, 4] }
[[layer.pin]]
anchor = { screen = [0.8, 0.5], frame = 1 }
keys   = [{ frame = 1, offset = [0.1, 0.0] }]
"#;
    let bench = bench(world);
    bench.run("warp --shot shot.toml -o w.####.exr").says(2, &["lattices of the scene only (deep)", "on the screen"]);
    bench.run("export shot.toml --to lattice-json -o l.json").says(0, &[]);
    bench.run("warp in/b.####.exr --lattice l.json -o w.####.exr").says(2, &["lattices of the scene only (deep)"]);
    bench.run("warp --shot shot.toml").says(2, &["-o warped.####.exr"]);
}

#[test]
fn mattes_that_are_not_there_are_named() {
    let matte = |matte: &str| bench(&SHOT.replace("name    = \"all\"", &format!("matte = {matte}")));
    let cases = [
        ("{ channel = \"mask.R\" }", &["no channel \"mask.R\""][..]),
        ("{ id = \"id.objekt\", values = [7] }", &["no channel \"id.objekt\"", "id.object"]),
        ("{ cryptomatte = [\"Body\"] }", &["no Cryptomatte"]),
    ];
    for (part, says) in cases {
        let bench = matte(part);
        bench.run("warp --shot shot.toml").says(2, says);
        assert!(!bench.path("out").exists(), "nothing was begun");
    }
}

#[test]
fn a_layer_of_all_nodes_leaves_the_background_on_request() {
    let shot = |topology: &str, matte: &str| {
        let head = HEAD.replace("[[layer]]", "plate = \"in/b.####.exr\"\n[[layer]]");
        let head = head.replace("dims = [4, 4]", &format!("dims = [4, 4], topology = \"{topology}\""));
        format!("{head}{matte}{PIN}{OUTPUT}")
    };
    let warped_by = |topology: &str, matte: &str| {
        let bench = bench(&shot(topology, matte));
        let ended = bench.run("warp --shot shot.toml --frames 2 -o w.####.exr").says(0, &[]);
        let plate = read_plate(&bench.path("w.0002.exr")).expect("a plate");
        let alpha = plate.parts[0].channel("A").expect("an alpha").samples.clone();
        let is_border = |index: usize| !(64..35 * 64).contains(&index) || [0, 63].contains(&(index % 64));
        let lost = (0..alpha.len()).filter(|&index| is_border(index) && alpha[index] < 0.5).count();
        (ended.stderr, lost)
    };
    let warped = |matte: &str| warped_by("plain", matte);
    let (told, lost) = warped("");
    assert!(lost > 30, "the whole picture moves: {lost}");
    let says = ["warning", "layer 'all' moves all of the scene", "matte = \"nodes\"", "matte = \"none\""];
    assert!(says.iter().all(|words| told.contains(words)), "{told}");
    let (told, _) = warped("matte = \"none\"\n");
    assert!(!told.contains("moves all"), "{told}");
    let (told, lost) = warped("matte = \"nodes\"\n");
    assert_eq!(lost, 0, "the background rests");
    assert!(!told.contains("moves all"), "{told}");
    let (told, lost) = warped_by("branching", "");
    assert_eq!(lost, 0, "the background rests");
    assert!(!told.contains("moves all"), "{told}");
    let pictures = bench(&SHOT.replace("name    = \"all\"", "matte = \"nodes\""));
    pictures.run("warp --shot shot.toml").says(2, &["matte", "those of a scene"]);
}

/// A plate of one thing over nothing comes apart where its reference frame is cut.
#[test]
fn a_plate_comes_apart_by_its_reference_frame() {
    let shot = |image: &str, cuts: &str| {
        let pin = |x: f64, y: f64, dx: f64| {
            let [x, y, dx] = [x, y, dx].map(|pixels| pixels / 64.0);
            format!(
                "[[layer.pin]]\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\nkeys = [{{ frame = 1, offset = [{dx}, 0.0] }}]\n"
            )
        };
        let pins = [pin(15.0, 15.0, 0.0), pin(15.0, 48.0, 0.0), pin(35.0, 30.0, 0.0), pin(50.0, 30.0, 20.0)].concat();
        let layer = format!("matte = \"alpha\"\nlattice = {{ dims = [24, 24], cuts = [{cuts}] }}\n{pins}");
        format!(
            "version = 1\n{image}plate = \"in/a.####.png\"\nframes = {{ first = 1, last = 2 }}\nsize = [96, 64]\n[[layer]]\n{layer}"
        )
    };
    let (reference, stroke) = ("image = \"in/a.0001.png\"\n", "[[0.625, 0.0], [0.625, 1.0]]");
    let bench = Bench::with_shot(&shot("", stroke));
    std::fs::create_dir(bench.path("in")).expect("a folder");
    let save = |name: &str, pixel: &dyn Fn(u32) -> [u8; 4]| {
        let is_thing = |x: u32, y: u32| (10..56).contains(&x) && (10..54).contains(&y);
        let pixel = |x, y| image::Rgba(if is_thing(x, y) { pixel(x) } else { [0; 4] });
        image::RgbaImage::from_fn(96, 64, pixel).save(bench.path(name)).expect("saved");
    };
    ["in/a.0001.png", "in/a.0002.png"].iter().for_each(|name| save(name, &|_| [200, 100, 50, 255]));
    save("ids.png", &|x| if x < 40 { [255, 0, 0, 255] } else { [0, 0, 255, 255] });
    bench.run("warp --shot shot.toml -o w.####.png").says(2, &["lattice.cuts[0]", "reference frame of the plate"]);
    for (cuts, comes_apart) in [("", false), (stroke, true), ("{ ids = { file = \"ids.png\" } }", true)] {
        bench.write("shot.toml", shot(reference, cuts).as_bytes());
        bench.run("warp --shot shot.toml -o w.####.png --overwrite").says(0, &[]);
        let warped = image::open(bench.path("w.0002.png")).expect("a picture").to_rgba8();
        let uncovered = (10..54).filter(|&y| warped.get_pixel(48, y)[3] < 10).count();
        assert!(if comes_apart { uncovered > 36 } else { uncovered < 14 }, "{cuts}: {uncovered} of 44 rows");
    }
}

#[test]
fn misspelt_names_are_refused_at_once() {
    let bench = bench(SHOT);
    let wrong = [
        ("warp --shot shot.toml --clean in/claen.####.exr", "cannot read in/claen.0001.exr"),
        ("warp --shot shot.toml --clean in/clean.exr", "cannot read in/clean.exr"),
        ("warp in/b.####.exr --stmap in/map.####.exr -o w.####.exr", "cannot read in/map.0001.exr"),
        ("warp in/x.####.exr --shot shot.toml", "cannot read in/x.0001.exr"),
    ];
    for (arguments, says) in wrong {
        bench.run(arguments).says(2, &[says]);
    }
    assert!(!bench.path("out").exists(), "nothing was begun");
    // One frame that is not there is a fault of that frame.
    std::fs::copy(bench.path("in/b.0001.exr"), bench.path("in/clean.0001.exr")).expect("copied");
    bench.run("warp --shot shot.toml --clean in/clean.####.exr").says(1, &["frame 1 ->", "error: frame 2", "1 FAILED"]);
}

#[test]
fn channels_that_fit_nothing_are_reported() {
    let channels = "[warp]\nchannels = [{ name = \"deep.Z\", meaning = \"data\" }]\n[output]";
    let bench = bench(&SHOT.replace("[output]", channels));
    let says = ["note: [[warp.channels]]: no channel of the plate matches 'deep.Z'", "depth.Z"];
    bench.run("warp --shot shot.toml").says(0, &says);
}

/// The shot with one layer, and a second one after it that has another matte.
fn two_layers(one: &str, other: &str) -> Bench {
    let first = SHOT.replace("name    = \"all\"", &format!("name = \"one\"\nmatte = {one}"));
    let second = format!(
        "[[layer]]\nname = \"other\"\nmatte = {other}\n[[layer.pin]]\nanchor = {{ screen = [0.5, 0.5] }}\n[output]"
    );
    bench(&first.replace("[output]", &second))
}

#[test]
fn two_layers_with_one_matte_are_refused() {
    let id = "{ id = \"id.object\", values = [7, 3] }";
    let cases = [("\"alpha\"", "\"alpha\""), (id, "{ id = \"id.object\", values = [3, 7, 3] }")];
    for (one, other) in cases {
        let bench = two_layers(one, other);
        let says = ["shot.toml:", "layer[1].matte", "layers 'one' and 'other' have the same matte", "--layer"];
        bench.run("warp --shot shot.toml").says(2, &says);
        assert!(bench.frames().is_empty());
        bench.run("warp --shot shot.toml --layer one").says(0, &[]);
    }
}

#[test]
fn mattes_that_overlap_are_reported_with_their_pixels() {
    let bench = two_layers("{ id = \"id.object\", values = [7] }", "{ id = \"id.object\", values = [7, 4] }");
    let says = ["the mattes of the layers \"one\" and \"other\" overlap: 81 pixels move more than once"];
    bench.run("warp --shot shot.toml --frames 2").says(0, &says);
    let apart = two_layers("{ id = \"id.object\", values = [7] }", "{ id = \"id.object\", values = [3] }");
    let ended = apart.run("warp --shot shot.toml --frames 2").says(0, &[]);
    assert!(!ended.stderr.contains("overlap"), "{}", ended.stderr);
}

#[test]
fn a_matted_thing_moves_before_the_rest() {
    let bench = bench(&SHOT.replace("name    = \"all\"", "matte = { id = \"id.object\", values = [7] }"));
    let events = bench.run("warp --shot shot.toml --frames 2 --json").says(0, &[]).events();
    let holes = events.iter().find_map(|event| event["hole_pixels"].as_u64()).expect("holes are counted");
    assert!((9 * 3..=9 * 6).contains(&holes), "the square leaves 4.5 columns of 9: {holes}");
    let path = bench.path("out/w.0002.exr");
    let moved = columns(&path, "id.object", |id| id.to_bits() == 7);
    assert!(moved.first().is_some_and(|&first| first > 30), "{moved:?}");
    assert_eq!(columns(&path, "A", |alpha| alpha == 0.0).len(), 4, "what it leaves is empty");
    let filled = "warp --shot shot.toml --frames 2 --clean in/b.0001.exr -o out/f.####.exr";
    let ended = bench.run(filled).says(0, &[]);
    assert!(!ended.stderr.contains("fill holes"), "{}", ended.stderr);
    let ended = bench.run("report out/f.####.exr --max-holes 0").says(0, &[]);
    assert!(!ended.stdout.contains("uncovered"), "{}", ended.stdout);
    let ended = bench.run("report out/w.####.exr --max-holes 0").says(1, &[]);
    assert!(ended.stdout.contains("uncovered"), "{}", ended.stdout);
    bench.run("warp --shot shot.toml --frames 2 -o out/e.####.exr").says(0, &["are empty; fill holes"]);
    assert_eq!(columns(&bench.path("out/f.0002.exr"), "A", |alpha| alpha < 0.999), Vec::<i32>::new());
}

#[test]
fn a_warp_can_be_undone() {
    let bench = bench(SHOT);
    bench.run("warp --shot shot.toml --frames 2").says(0, &[]);
    bench.run("warp out/w.####.exr --shot shot.toml --frames 2 --inverse -o back/b.####.exr").says(0, &[]);
    let back = columns(&bench.path("back/b.0002.exr"), "depth.Z", |depth| depth == 2.0);
    assert!(back.first().is_some_and(|&first| (27..=29).contains(&first)), "{back:?}");
    assert!(back.last().is_some_and(|&last| (35..=37).contains(&last)), "{back:?}");
}

/// A PNG of one colour: as small as a file of its size gets.
fn bomb(path: &Path, size: FrameSize) {
    let window = size.window();
    let channel =
        |name: &str| Channel { name: name.into(), storage: Storage::Half, samples: vec![0.25; window.area()] };
    let channels = ["R", "G", "B"].map(channel).into();
    let frame = Frame { display: window, data_window: window, pixel_aspect: 1.0, channels };
    write_picture(path, &Plate::from_frame(frame)).expect("written");
}

#[test]
fn a_frame_that_needs_too_much_memory_fails_alone() {
    let bench = bench(&SHOT.replace("last = 2", "last = 3"));
    let large = FrameSize::new(1280, 720);
    std::fs::copy(bench.path("in/b.0001.exr"), bench.path("in/b.0003.exr")).expect("copied");
    write_plate(&bench.path("in/b.0002.exr"), &Plate::from_frame(frame(large))).expect("written");
    let command = "warp --shot shot.toml --max-memory 32M";
    let words = ["error: frame 2", "b.0002.exr needs about", "32 MB may be used", "--max-memory", "1 FAILED"];
    bench.run(command).says(1, &words);
    assert_eq!(bench.frames(), ["w.0001.exr", "w.0003.exr"]);
    // A clean plate counts too, and so does an STMap.
    let small = "warp in/b.0001.exr --shot shot.toml --frames 1 -o c.exr --max-memory 16M --overwrite";
    bench.run(small).says(0, &[]);
    let overscan = Frame { display: FrameSize::new(64, 36).window(), ..frame(large) };
    write_plate(&bench.path("in/c.exr"), &Plate::from_frame(overscan)).expect("written");
    bench.run(&format!("{small} --clean in/c.exr")).says(1, &["error: frame 1", "needs about"]);
    bench.run("warp in/b.0001.exr --stmap in/b.0002.exr -o s.exr --max-memory 16M").says(2, &[]);
    bench.run("warp --shot shot.toml --max-memory much").says(2, &["8G, 512M, 50%"]);
    // With room for all it goes through.
    bench.run("warp --shot shot.toml --overwrite --max-memory 2G").says(0, &[]);
}

#[test]
fn pictures_that_unpack_to_too_much_are_refused_before_they_are_decoded() {
    let bench = bench(SHOT);
    bomb(&bench.path("bomb.png"), FrameSize::new(2560, 1440));
    let length = std::fs::metadata(bench.path("bomb.png")).expect("written").len();
    assert!(length < 200_000, "{length}");
    let of = |image: &str| {
        format!("version = 1\nimage = {image}\nframes = {{ first = 1, last = 1 }}\n[[layer]]\nname = \"all\"\n{OUTPUT}")
    };
    bench.write("bomb.toml", of("\"bomb.png\"").as_bytes());
    let words = ["bomb.png needs about", "32 MB may be used", "--max-memory"];
    for command in ["render bomb.toml", "check bomb.toml", "export bomb.toml --to stmap"] {
        bench.run(&format!("{command} --max-memory 32M")).says(2, &words);
    }
    // Each of three would fit alone.
    for name in ["a", "b", "c"] {
        bomb(&bench.path(&format!("{name}.png")), FrameSize::new(320, 180));
    }
    bench.write("three.toml", of("[\"a.png\", \"b.png\", \"c.png\"]").as_bytes());
    bench.run("check three.toml --max-memory 10M").says(2, &["c.png needs about"]);
    bench.run("check three.toml --max-memory 200M").says(0, &[]);
    // A frame that is too large to be drawn.
    let huge = square_shot("size = [16384, 16384]");
    bench.write("huge.toml", huge.as_bytes());
    bench
        .run("render huge.toml --device cpu --max-memory 1G")
        .says(2, &["huge.toml", "size", "16384 x 16384", "may be used"]);
}

/// The head of a PNG of that size, which holds no pixels.
fn png_head(size: u32) -> Vec<u8> {
    let mut head = [b"IHDR".as_slice(), &size.to_be_bytes(), &size.to_be_bytes(), &[8, 6, 0, 0, 0]].concat();
    let sum = crc32fast::hash(&head);
    head.extend(sum.to_be_bytes());
    [b"\x89PNG\r\n\x1a\n\0\0\0\r".as_slice(), &head, b"\0\0\0\0IDAT\x35\xaf\x06\x1e"].concat()
}

#[test]
fn scenes_that_hold_too_much_are_refused_before_they_are_decoded() {
    let mut scene = square().json();
    let bench = Bench::with(&scene, &square_shot("size = [64, 36]"));
    bench.run("check shot.toml --max-memory 64M").says(0, &[]);
    // Two textures that would fit alone.
    scene["images"] = serde_json::json!([{ "uri": "a.png" }, { "uri": "b.png" }]);
    scene["textures"] = serde_json::json!([{ "source": 0 }, { "source": 1 }]);
    scene["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = serde_json::json!({ "index": 0 });
    scene["materials"][0]["emissiveTexture"] = serde_json::json!({ "index": 1 });
    bench.write("tiny.gltf", scene.to_string().as_bytes());
    ["a.png", "b.png"].into_iter().for_each(|name| bench.write(name, &png_head(4096)));
    let words =
        ["tiny.gltf", "33.6 million pixels of textures", "256 MB may be used", "--max-memory", "smaller textures"];
    bench.run("check shot.toml --max-memory 256M").says(2, &words);
    // One of them fits.
    scene["materials"][0]["emissiveTexture"] = serde_json::Value::Null;
    bench.write("tiny.gltf", scene.to_string().as_bytes());
    bench.run("check shot.toml --max-memory 256M").says(0, &[]);
    // Instances: each is a node of its own.
    let instanced = |count: usize| {
        let mut scene = square().json();
        let accessors = scene["accessors"].as_array_mut().expect("accessors");
        accessors.push(serde_json::json!({ "componentType": 5126, "count": count, "type": "VEC3" }));
        let accessor = accessors.len() - 1;
        scene["extensionsUsed"] = serde_json::json!(["EXT_mesh_gpu_instancing", "KHR_materials_unlit"]);
        scene["nodes"][0]["extensions"] =
            serde_json::json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": accessor } } });
        bench.write("tiny.gltf", scene.to_string().as_bytes());
    };
    instanced(200_000);
    let words = ["tiny.gltf", "nodes", "256 MB may be used", "--max-memory", "fewer instances"];
    bench.run("check shot.toml --max-memory 256M").says(2, &words);
    instanced(1_000_000);
    bench.run("check shot.toml").says(2, &["1000000 instances", "export fewer"]);
}

/// A shot of the square, of that size.
fn square_shot(size: &str) -> String {
    format!(
        "version = 1\nscene = \"tiny.gltf\"\nframes = {{ first = 1, last = 1 }}\n{size}\n[[layer]]\nname = \"all\"\n{OUTPUT}"
    )
}
