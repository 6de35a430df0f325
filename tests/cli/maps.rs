//! `export --to stmap`, `nuke` and `after-effects`: maps that compositors read.

use crate::python;
use crate::support::{Bench, HEAD, OUTPUT, PIN, names_in};
use crate::tiny::{Tiny, grid};
use pinwarp::image::{Frame, read_exr};
use std::path::Path;

fn read(bench: &Bench, name: &str) -> Frame {
    read_exr(&bench.path(name)).expect("a frame")
}

/// A channel at a pixel of the display window; 0 outside the data window.
fn at(frame: &Frame, channel: &str, [x, y]: [i32; 2]) -> f32 {
    let window = frame.data_window;
    let (column, row) = (x - window.x, y - window.y);
    let is_inside = (0..window.width as i32).contains(&column) && (0..window.height as i32).contains(&row);
    let samples = &frame.channel(channel).expect("the channel").samples;
    if is_inside { samples[(row * window.width as i32 + column) as usize] } else { 0.0 }
}

fn pixels() -> impl Iterator<Item = [i32; 2]> {
    (0..36).flat_map(|y| (0..64).map(move |x| [x, y]))
}

#[test]
fn maps_are_written_kept_and_replaced_like_frames() {
    let bench = Bench::plain();
    let told = bench.run("export shot.toml --to stmap -o st/m.####.exr").says(0, &[]).stdout;
    assert!(told.contains("m.####.exr: 2 frames"), "{told}");
    assert_eq!(names_in(&bench.path("st")), ["m.0001.exr", "m.0002.exr"]);
    // Nothing moves in the first frame: the identity, to the bit.
    let still = read(&bench, "st/m.0001.exr");
    for [x, y] in pixels() {
        let [u, v] = [(f64::from(x) + 0.5) / 64.0, 1.0 - (f64::from(y) + 0.5) / 36.0].map(|place| place as f32);
        assert_eq!([at(&still, "R", [x, y]), at(&still, "G", [x, y])], [u, v], "pixel {x}, {y}");
    }
    bench.run("export shot.toml --to stmap -o st/m.####.exr").says(2, &["m.0001.exr", "--resume"]);
    std::fs::remove_file(bench.path("st/m.0002.exr")).expect("it is there");
    let told = bench.run("export shot.toml --to stmap -o st/m.####.exr --resume").says(0, &[]).stdout;
    assert!(told.contains("1 frame, 1 kept"), "{told}");
    // Frames that stay are of the same state: another selection of frames is none, another pin is.
    let resumed = |shot: &str, words: &str| {
        let command = format!("export {shot} --to stmap -o st/m.####.exr --resume");
        let ended = bench.run(&command).says(0, &[]);
        assert!(ended.stdout.contains(words), "{}", ended.stdout);
        ended.stderr
    };
    bench.run("export shot.toml --to stmap -o st/m.####.exr --overwrite --frames 2").says(0, &[]);
    assert_eq!(resumed("shot.toml", "0 frames, 2 kept"), "", "nothing is stale");
    let text = String::from_utf8(bench.read("shot.toml")).expect("text");
    bench.write("other.toml", text.replace("0.1, 0.05", "0.1, 0.06").as_bytes());
    let told = resumed("other.toml", "1 frame, 1 kept");
    assert!(told.contains("1 frame is rendered again (2): it was made from another state of the shot"), "{told}");
    bench.run("export shot.toml --to stmap -o st/m.exr").says(2, &["no frame counter for 2 frames"]);
    bench.run("export shot.toml --to stmap --layer al").says(2, &["no warped layer 'al'", "did you mean"]);
    bench.run("export shot.toml --to stmap --size 64").says(2, &["1920x1080"]);
}

#[test]
fn a_lattice_file_gives_the_maps_of_its_shot() {
    let bench = Bench::plain();
    bench.run("export shot.toml --to lattice-json").says(0, &[]);
    bench.run("export shot.toml --to stmap -o a.####.exr --frames 2").says(0, &[]);
    bench.run("export shot.lattice.json --to stmap -o b.####.exr --frames 2 --size 64x36").says(0, &[]);
    assert_eq!(read(&bench, "a.0002.exr").channels, read(&bench, "b.0002.exr").channels);
    bench.run("export shot.lattice.json --to stmap -o c.####.exr --frames 7").says(2, &["no lattice in the frames"]);
    bench.run("export shot.lattice.json --to lattice-json -o d.json --frames 2").says(0, &[]);
    bench.run("export d.json --to stmap -o d.####.exr").says(0, &[]);
    let [height, width] = [1080, 1920].map(|side: u32| side);
    let window = read(&bench, "d.0002.exr").data_window;
    assert_eq!((window.width, window.height), (width, height), "without pixels of its own it has 1080 lines");
}

#[test]
fn the_inverse_undoes_the_map_and_overscan_goes_around() {
    let bench = Bench::plain();
    for flags in ["--inverse -o inverse.####.exr", "--overscan 8 -o wide.####.exr", "-o plain.####.exr"] {
        bench.run(&format!("export shot.toml --to stmap --frames 2 {flags}")).says(0, &[]);
    }
    let [inverse, wide, plain] = ["inverse.0002.exr", "wide.0002.exr", "plain.0002.exr"].map(|name| read(&bench, name));
    let window = wide.data_window;
    assert_eq!((window.x, window.y, window.width, window.height), (-8, -8, 80, 52));
    assert!(pixels().all(|pixel| at(&wide, "R", pixel) == at(&plain, "R", pixel)), "the middle of both is one");
    assert!(at(&wide, "R", [-8, 0]) < 0.0, "measured by the display window");
    // From a pixel to where it goes and from there back (bilinear) is the pixel.
    let mut moved = 0.0_f32;
    for [x, y] in pixels().filter(|[x, y]| (16..48).contains(x) && (9..27).contains(y)) {
        let goes = [at(&inverse, "R", [x, y]) * 64.0 - 0.5, (1.0 - at(&inverse, "G", [x, y])) * 36.0 - 0.5];
        let corner = goes.map(|side| side.floor());
        let share = [goes[0] - corner[0], goes[1] - corner[1]];
        let mix = |channel: &str| {
            let near = |i: i32, j: i32| at(&wide, channel, [corner[0] as i32 + i, corner[1] as i32 + j]);
            let row = |j: i32| near(0, j) * (1.0 - share[0]) + near(1, j) * share[0];
            row(0) * (1.0 - share[1]) + row(1) * share[1]
        };
        let back = [mix("R") * 64.0 - 0.5, (1.0 - mix("G")) * 36.0 - 0.5];
        assert!((back[0] - x as f32).hypot(back[1] - y as f32) < 0.05, "{x}, {y} comes back to {back:?}");
        moved = moved.max((goes[0] - x as f32).hypot(goes[1] - y as f32));
    }
    assert!(moved > 1.0, "the warp moves pixels: {moved}");
}

const ST_WARP: &str = r#"
import OpenImageIO as oiio, sys
picture, stmap = oiio.ImageBuf(sys.argv[1]), oiio.ImageBuf(sys.argv[2])
# The result gets the data window of the picture, which ends where the unwarped layer does.
picture = oiio.ImageBufAlgo.crop(picture, picture.roi_full)
warped = oiio.ImageBufAlgo.st_warp(picture, stmap, "triangle", 0.0, 0, 1, False, True)
assert not warped.has_error, warped.geterror()
warped.write(sys.argv[3])
"#;

#[test]
fn openimageio_warps_by_our_maps_as_we_do() {
    // One sample a pixel would put edges up to half a pixel off before anything is warped.
    let head = HEAD.replace("samples = 1", "samples = 64");
    let bench = Bench::with_shot(&format!("{head}{PIN}{OUTPUT}"));
    bench.render("").says(0, &[]);
    bench.write("still.toml", format!("{head}{OUTPUT}").replace("out/f", "out/s").as_bytes());
    bench.run("render still.toml --device cpu").says(0, &[]);
    bench.run("export shot.toml --to stmap -o st.####.exr --frames 2").says(0, &[]);
    let [still, map, out] = ["out/s.0002.exr", "st.0002.exr", "warped.exr"].map(|name| bench.path(name));
    let arguments: Vec<_> =
        [&still, &map, &out].into_iter().map(|path: &std::path::PathBuf| path.as_os_str()).collect();
    if python::run(&["OpenImageIO"], ST_WARP, &arguments).is_none() {
        return;
    }
    // The coverage of an edge, mixed of that of two pixels, is off by a quarter at most. Measured: 0.18.
    let pixels_off = |a: &Path, b: &Path| {
        let [a, b] = [a, b].map(|path| read_exr(path).expect("a frame"));
        pixels().filter(|&pixel| (at(&a, "A", pixel) - at(&b, "A", pixel)).abs() > 0.25).count()
    };
    let wanted = bench.path("out/f.0002.exr");
    assert_eq!(pixels_off(&wanted, &out), 0);
    let unwarped = pixels_off(&wanted, &still);
    assert!(unwarped > 300, "the comparison can fail: {unwarped} of 2304");
}

#[test]
fn nuke_gets_a_script_beside_its_maps() {
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{OUTPUT}").replace("name = \"all\"", "name = \"left arm\""));
    let told = bench.run("export shot.toml --to nuke -o comp/arm.nk").says(0, &[]).stdout;
    assert!(told.contains("wrote comp/arm.nk: an STMap and 1 grid (GridWarp3, not verified in Nuke)"), "{told}");
    assert_eq!(names_in(&bench.path("comp")), ["arm.nk", "arm.stmap.0001.exr", "arm.stmap.0002.exr"]);
    let text = String::from_utf8(bench.read("comp/arm.nk")).expect("text");
    for part in
        ["file \"arm.stmap.####.exr\"", "uv rgb", "name pinwarp_grid_left_arm", "{curve L x1 ", "first 1\n last 2"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    bench.run("export shot.toml --to nuke -o comp/arm.nk").says(2, &["arm.nk exists already"]);
    let told = bench.run("export shot.toml --to nuke -o comp/arm.nk --resume").says(0, &[]).stdout;
    assert!(told.contains("0 frames, 2 kept"), "{told}");
    // A script that somebody went on working on is not replaced by going on.
    bench.write("comp/arm.nk", b"my own");
    bench.run("export shot.toml --to nuke -o comp/arm.nk --resume").says(2, &["arm.nk exists already", "--overwrite"]);
    assert_eq!(bench.read("comp/arm.nk"), b"my own");
    bench.run("export shot.toml --to nuke -o comp/arm.nk --overwrite").says(0, &[]);
    assert_eq!(bench.read("comp/arm.nk"), text.as_bytes());
}

#[test]
fn after_effects_gets_elements_maps_and_their_settings() {
    let bench = Bench::new();
    bench.run("export shot.toml --to after-effects -o ae/x.####.exr").says(2, &["without a frame counter"]);
    let told = bench.run("export shot.toml --to after-effects -o ae/shot").says(0, &[]);
    // The pin moves by (.1, .05) of 36 lines.
    assert!(told.stdout.contains("max displacement 4 px, steps of 0.00012 px"), "{told:?}");
    assert!(!told.stderr.contains("nothing is warped"), "an element is at rest on purpose: {told:?}");
    let wanted = ["after-effects.txt", "displacement_4px.0001.png", "displacement_4px.0002.png", "element.0001.exr"];
    let names = names_in(&bench.path("ae"));
    assert!(wanted.iter().all(|name| names.contains(&format!("shot.all.{name}"))), "{names:?}");
    assert_eq!(&bench.read("ae/shot.all.displacement_4px.0001.png")[..4], b"\x89PNG");
    let note = String::from_utf8(bench.read("ae/shot.all.after-effects.txt")).expect("text");
    assert!(note.contains("Max Horizontal Displacement: 4"), "{note}");
    // The element is the layer as it is without pins.
    bench.write("still.toml", format!("{HEAD}{OUTPUT}").replace("out/f", "out/s").as_bytes());
    bench.run("render still.toml --device cpu").says(0, &[]);
    let [element, still] = ["ae/shot.all.element.0002.exr", "out/s.0002.exr"].map(|name| read(&bench, name));
    assert!(pixels().all(|pixel| (at(&element, "A", pixel) - at(&still, "A", pixel)).abs() < 1e-3));
    bench.run("export shot.toml --to after-effects -o ae/shot").says(2, &["exist already"]);
    // What is in the way of the last file keeps the first from being written.
    bench.write("ae/late.all.element.0002.exr", &bench.read("out/s.0002.exr"));
    bench.run("export shot.toml --to after-effects -o ae/late").says(2, &["element.0002.exr"]);
    let written = names_in(&bench.path("ae")).into_iter().filter(|name| name.starts_with("late")).count();
    assert_eq!(written, 1, "nothing but what was there");
    bench.run("export shot.toml --to after-effects -o ae/shot --resume").says(0, &[]);
    // Maps of one frame less, or of another state of the shot: the note is not replaced in silence.
    bench
        .run("export shot.toml --to after-effects -o ae/shot --resume --frames 2")
        .says(2, &["after-effects.txt exists already", "--overwrite"]);
    assert_eq!(String::from_utf8(bench.read("ae/shot.all.after-effects.txt")).expect("text"), note);
    // Maps alone come from a lattice file.
    bench.run("export shot.toml --to lattice-json -o l.json").says(0, &[]);
    bench.run("export l.json --to after-effects -o ae/l --size 64x36").says(0, &[]);
    // The heads differ: they name what the maps were made from.
    let [alone, of_shot] = ["ae/l.all.displacement_4px.0002.png", "ae/shot.all.displacement_4px.0002.png"]
        .map(|name| image::open(bench.path(name)).expect("a picture"));
    assert!(alone == of_shot);
}

#[test]
fn after_effects_gets_pictures_of_a_layer_alone() {
    let bench = Bench::new();
    for (name, left) in [("back", 0), ("front", 20)] {
        let pixel = |x: u32, _: u32| image::Rgba(if x < left + 30 && x >= left { [200, 100, 50, 255] } else { [0; 4] });
        image::RgbaImage::from_fn(64, 36, pixel).save(bench.path(&format!("{name}.png"))).expect("it can be written");
    }
    let pin = "[[layer.pin]]\nanchor = { screen = [0.9, 0.5] }\nkeys = [{ frame = 1, offset = [0.1, 0.0] }]\n";
    let layer = format!("[[layer]]\nname = \"all\"\nnodes = [\"front\"]\n{pin}");
    let head = "image = [\"back.png\", \"front.png\"]\nframes = { first = 1, last = 2 }\n";
    bench.write("drawn.toml", format!("{head}{layer}").as_bytes());
    let told = bench.run("export drawn.toml --to after-effects -o ae").says(0, &[]);
    assert!(told.stdout.contains("max displacement 4 px"), "{told:?}");
    assert!(!told.stderr.contains("nothing is warped"), "an element is at rest on purpose: {told:?}");
    let element = read(&bench, "ae.all.element.0002.exr");
    for pixel in pixels() {
        assert_eq!(at(&element, "A", pixel), f32::from(u8::from((20..50).contains(&pixel[0]))), "{pixel:?}");
    }
}

#[test]
fn maps_follow_what_is_warped_in_the_scene() {
    let head =
        HEAD.replace("dims = [4, 4]", "space = \"world\", dims = [4, 4, 4]").replace("samples = 1", "samples = 16");
    let bench = Bench::with_shot(&format!("{head}{PIN}{OUTPUT}"));
    bench
        .run("export shot.toml --to stmap --layer all")
        .says(2, &["is warped in the scene", "there is no map to write"]);
    bench.write("still.toml", format!("{head}{OUTPUT}").as_bytes());
    bench.run("render shot.toml -o real.####.exr --device cpu --frames 2").says(0, &[]);
    bench.run("render still.toml -o still.####.exr --device cpu --frames 2").says(0, &[]);
    let told = bench.run("export shot.toml --to stmap -o st.####.exr").says(0, &[]);
    assert!(told.stdout.contains("2 frames") && !told.stderr.contains("is warped in the scene"), "{told:?}");
    bench.run("warp still.####.exr --stmap st.####.exr -o mapped.####.exr --frames 2").says(0, &[]);
    let [real, still, mapped] = ["real", "still", "mapped"].map(|name| read(&bench, &format!("{name}.0002.exr")));
    let off =
        |frame: &Frame| pixels().filter(|&pixel| (at(frame, "A", pixel) - at(&real, "A", pixel)).abs() > 0.25).count();
    assert!(off(&mapped) < 8 && off(&still) > 50, "{} of {} pixels are off", off(&mapped), off(&still));
    // Another pin in the scene is another map.
    bench.write("other.toml", format!("{head}{}{OUTPUT}", PIN.replace("0.1, 0.05", "0.1, 0.06")).as_bytes());
    let told = bench.run("export other.toml --to stmap -o st.####.exr --resume").says(0, &[]);
    assert!(told.stdout.contains("2 frames"), "{told:?}");
}

/// Handles that fold the picture: the nothing on the right comes to lie over the square on the left.
const FOLDED: &str = r#"
version = 1
scene = "tiny.gltf"
frames = { first = 1, last = 1, rate = 24 }
size = [64, 36]
samples = 1

[[layer]]
name = "all"
solve = { guard = "report" }
lattice = { dims = [4, 2], basis = "bilinear", topology = "plain", box = { fixed = [0.0, 0.0, 1.7777777778, 1.0] } }
  [[layer.handle]]
  index = [1, 0]
  keys = [ { frame = 1, offset = [0.333, 0.0] } ]
  [[layer.handle]]
  index = [1, 1]
  keys = [ { frame = 1, offset = [0.333, 0.0] } ]
  [[layer.handle]]
  index = [2, 0]
  keys = [ { frame = 1, offset = [-0.333, 0.0] } ]
  [[layer.handle]]
  index = [2, 1]
  keys = [ { frame = 1, offset = [-0.333, 0.0] } ]

[output]
path = "out/f.####.exr"
"#;

#[test]
fn folds_hide_nothing_of_the_model_in_plates_and_in_maps() {
    let quad = Tiny::of(vec![grid("Quad", [-0.75, -0.4, -0.4, 0.4], 8)]);
    let bench = Bench::with(&quad.json(), FOLDED);
    let still = FOLDED.split("  [[layer.handle]]").next().unwrap_or_default();
    bench.write("still.toml", format!("{still}{OUTPUT}").as_bytes());
    bench.run("render shot.toml -o real.####.exr --device cpu").says(0, &[]);
    bench.run("render still.toml -o still.####.exr --device cpu").says(0, &[]);
    bench.run("warp still.####.exr --shot shot.toml -o warped.####.exr").says(0, &["frame 1", "layer \"all\" folds"]);
    let maps = "export shot.toml --to stmap -o st.####.exr";
    bench.run(maps).says(0, &["warning: frame 1", "layer \"all\"", "pixels", "pins less"]);
    bench.run("warp still.####.exr --stmap st.####.exr -o mapped.####.exr").says(0, &[]);
    let real = read(&bench, "real.0001.exr");
    let covered = pixels().filter(|&pixel| at(&real, "A", pixel) > 0.5).count();
    assert!(covered > 100, "the square is drawn: {covered}");
    for name in ["warped.0001.exr", "mapped.0001.exr"] {
        let made = read(&bench, name);
        let off = pixels().filter(|&pixel| (at(&made, "A", pixel) - at(&real, "A", pixel)).abs() > 0.6).count();
        assert!(off * 20 <= covered, "{name}: {off} of {covered}");
    }
}

#[test]
fn the_codes_of_png_maps_are_numbers() {
    let bench = Bench::new();
    bench.run("export shot.toml --to stmap -o st.####.exr --frames 2").says(0, &[]);
    bench.run("render shot.toml -o plate.####.exr --device cpu --frames 2").says(0, &[]);
    let map = read(&bench, "st.0002.exr");
    let code = |channel: &str, pixel| (at(&map, channel, pixel).clamp(0.0, 1.0) * 65535.0).round() as u16;
    let picture = image::ImageBuffer::from_fn(64, 36, |x, y| {
        let pixel = [x as i32, y as i32];
        image::Rgb([code("R", pixel), code("G", pixel), 0])
    });
    picture.save(bench.path("st.0002.png")).expect("saved");
    for kind in ["exr", "png"] {
        bench.run(&format!("warp plate.####.exr --stmap st.####.{kind} -o {kind}.####.exr --frames 2")).says(0, &[]);
    }
    let [by_exr, by_png, plate] = ["exr", "png", "plate"].map(|name| read(&bench, &format!("{name}.0002.exr")));
    let greatest = |other: &Frame| {
        let differences = pixels().map(|pixel| (at(&by_exr, "A", pixel) - at(other, "A", pixel)).abs());
        differences.fold(0.0, f32::max)
    };
    // A code is a thousandth of a pixel.
    assert!(greatest(&by_png) < 0.01, "{}", greatest(&by_png));
    assert!(greatest(&plate) > 0.2, "the map moves something: {}", greatest(&plate));
}
