//! Slips that people make every day, and the words that put them right.

use crate::support::{Bench, HEAD, OUTPUT, PIN};
use crate::tiny::{Tiny, grid};

#[test]
fn pixels_where_frame_heights_are_meant() {
    let bench = Bench::new();
    for (at, told) in [("36,14.4", "--at-px 36,14.4"), ("960,540", "--at-px 960,540"), ("1.0,14", "--at-px 1,14")] {
        bench.run(&format!("pick shot.toml --at {at}")).says(2, &["far outside the frame", "1.778,1", told]);
    }
    bench.run("pick shot.toml --at 1.9,0.5").says(2, &["no surface at"]);
}

#[test]
fn a_missing_file_is_named_with_its_line_and_the_nearest_name() {
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{OUTPUT}").replace("tiny.gltf", "tinny.gltf"));
    for command in ["render shot.toml", "check shot.toml", "pick shot.toml --at 1,0.5"] {
        bench.run(command).says(2, &["shot.toml:3: scene: there is no file tinny.gltf", "did you mean \"tiny.gltf\"?"]);
    }
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{OUTPUT}").replace("tiny.gltf", "gone/tiny.gltf"));
    bench.run("check shot.toml").says(2, &["shot.toml:3: scene:", "the folder gone is not there either"]);
    let flat = "version = 1\nimage = [\n  \"cat.png\",\n  \"hta.png\"]\nframes = { first = 1, last = 2 }\n";
    let bench = Bench::with_shot(flat);
    for name in ["cat.png", "hat.png"] {
        image::RgbaImage::from_pixel(8, 8, image::Rgba([255; 4])).save(bench.path(name)).expect("saved");
    }
    bench.run("check shot.toml").says(2, &["image: there is no file hta.png", "did you mean \"hat.png\"?"]);
    let transfer = "transfer = { lattice = \"arm.json\", fit = \"as-is\" }\n";
    let bench = Bench::with_shot(&format!("{HEAD}{transfer}{OUTPUT}"));
    bench.run("check shot.toml").says(2, &["layer[0].transfer.lattice: there is no file arm.json"]);
}

#[test]
fn frames_are_exr_files() {
    let bench = Bench::new();
    for (asked, advice) in [("x.png", "-o x.exr"), ("x.####.png", "-o x.####.exr"), ("x.jpg", "-o x.exr")] {
        bench.render(&format!("-o {asked}")).says(2, &[asked, advice, "--preview"]);
    }
}

#[test]
fn landmarks_outside_the_picture() {
    let bench = Bench::new();
    let square = |x, y| if (20..44).contains(&x) && (6..30).contains(&y) { [200, 100, 50, 255] } else { [0; 4] };
    image::RgbaImage::from_fn(64, 36, |x, y| image::Rgba(square(x, y))).save(bench.path("cat.png")).expect("saved");
    let fit = |unit: &str, a: [f64; 2], b: [f64; 2]| {
        let pairs = format!(r#"{{"unit": "{unit}", "pairs": [{{"name": "nose", "a": {a:?}, "b": {b:?}}}]}}"#);
        bench.write("pairs.json", pairs.as_bytes());
        bench.run("fit cat.png cat.png --pairs pairs.json -o l.json --overwrite")
    };
    assert_eq!(fit("pixels", [30.0, 20.0], [34.0, 20.0]).says(0, &[]).stderr, "");
    fit("frame", [30.0, 20.0], [34.0, 20.0])
        .says(2, &["pairs.json", "'nose' at 30,20", "cat.png", "unit = \"pixels\""]);
    fit("pixels", [30.0, 20.0], [34.0, 400.0]).says(2, &["'nose' at 34,400", "64 x 36 pixels", "unit = \"frame\""]);
    fit("pixels", [30.0, 20.0], [70.0, 20.0]).says(0, &["warning: landmark 'nose' at 70,20 lies outside"]);
}

#[test]
fn keys_and_anchors_outside_the_range() {
    let shot = format!("{HEAD}{PIN}{OUTPUT}").replace("{ frame = 2, offset", "{ frame = 30, offset");
    let screen = "
  [[layer.pin]]
  name = \"late\"
  anchor = { screen = [0.9, 0.5], frame = 7 }
  keys = [ { frame = 1, offset = [0.0, 0.0] } ]
";
    let bench = Bench::with_shot(&shot.replace(OUTPUT, &format!("{screen}{OUTPUT}")));
    let told = bench.run("check shot.toml").says(0, &[]).stdout;
    assert!(
        told.contains("note: layer 'all': 1 key lies outside the shot's frames 1 to 2, for example in frame 30"),
        "{told}"
    );
    assert!(told.contains("pin 'late' is anchored in frame 7, outside the shot's frames 1 to 2"), "{told}");
    let told = Bench::new().run("check shot.toml").says(0, &[]).stdout;
    assert!(!told.contains("outside"), "{told}");
}

/// A square held on both sides, whose middle is pulled.
fn folding(offset: &str) -> Bench {
    let pin = |x: f64, to: &str| {
        format!(
            "
  [[layer.pin]]
  anchor = {{ screen = [{x}, 0.5], frame = 1 }}
  keys = [ {{ frame = 1, offset = [0.0, 0.0] }}, {{ frame = 2, offset = {to} }} ]
"
        )
    };
    let pins = [pin(0.6, "[0.0, 0.0]"), pin(1.2, "[0.0, 0.0]"), pin(0.9, offset)].concat();
    let scene = Tiny::of(vec![grid("Quad", [-0.4, -0.4, 0.4, 0.4], 8)]);
    Bench::with(
        &scene.json(),
        &format!("{HEAD}{pins}{OUTPUT}")
            .replace("dims = [4, 4]", "dims = [8, 8], topology = \"plain\"")
            .replace("name = \"all\"", "name = \"all\"\nsolve = { temporal = 0, guard = \"report\" }"),
    )
}

#[test]
fn folds_of_the_model_are_reported_with_layer_frame_and_remedy() {
    let bench = folding("[0.6, 0.0]");
    const WORDS: &[&str] = &[
        "frame 2: layer 'all': the model folds over itself in",
        "guard = \"limit\"",
        "add pins",
        "topology = \"branching\"",
    ];
    let told = bench.render("").says(0, WORDS);
    assert!(!told.stderr.contains("frame 1: layer 'all': the model folds"), "{}", told.stderr);
    let checked = bench.run("check shot.toml").says(0, &[]).stdout;
    assert!(WORDS.iter().all(|word| checked.contains(word)), "{checked}");
    let told = folding("[0.02, 0.0]").render("").says(0, &[]);
    assert!(!told.stderr.contains("folds"), "{}", told.stderr);
}

/// An arm on a body: a bar whose end is raised within twelve frames, and lowered again.
fn arm() -> Bench {
    let head = HEAD.replace("last = 2", "last = 40").replace("dims = [4, 4]", "dims = [8, 8], topology = \"plain\"");
    let pins = "
  [[layer.pin]]
  name = \"hand\"
  anchor = { node = \"Quad\", triangle = 14, barycentric = [1.0, 0.0, 0.0] }
  keys = [ { frame = 5, offset = [0.0, 0.0] }, { frame = 11, offset = [0.0, 0.3] }, { frame = 30, offset = [0.0, 0.3], ease = \"hold\" },
           { frame = 31, offset = [0.0, 0.0] } ]
  [[layer.pin]]
  name = \"foot\"
  anchor = { node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }
  keys = [ { frame = 1, offset = [0.0, 0.0] } ]
";
    let scene = Tiny::of(vec![grid("Quad", [-0.4, -0.4, 0.4, 0.4], 8)]);
    Bench::with(&scene.json(), &format!("{head}{pins}{OUTPUT}"))
}

#[test]
fn a_plain_arm_raise_is_no_reason_for_a_page_of_warnings() {
    let told = arm().run("check shot.toml").says(0, &[]).stdout;
    assert!(told.lines().filter(|line| line.contains("warning") && line.contains("jerks")).count() <= 1, "{told}");
    assert!(told.contains("its warp jerks by at most") && told.contains("jerk: how much the acceleration"), "{told}");
}

#[test]
fn pins_that_share_cells_are_reported_with_frames_and_dims() {
    let bench = arm();
    let text = String::from_utf8(bench.read("shot.toml")).expect("text");
    let skirt = "
  [[layer.pin]]
  name = \"skirt\"
  anchor = { node = \"Quad\", triangle = 14, barycentric = [0.0, 1.0, 0.0] }
  keys = [ { frame = 1, offset = [0.0, 0.0] } ]
";
    bench.write("shot.toml", text.replace(OUTPUT, &format!("{skirt}{OUTPUT}")).as_bytes());
    let told = bench.run("check shot.toml").says(0, &[]).stdout;
    let line = told.lines().find(|line| line.contains("share cells")).unwrap_or_default();
    let words = [
        "warning: frames ",
        "layer 'all'",
        "'hand' and 'skirt'",
        "dims = [",
        "topology = \"branching\"",
        "a layer of its own",
    ];
    assert!(words.iter().all(|word| line.contains(word)), "{told}");
}

#[test]
fn a_frame_alone_says_what_it_says_in_a_sequence() {
    let bench = arm();
    let reports = |frames: &str| {
        let ended = bench.render(&format!("--json --overwrite --frames {frames}")).says(0, &[]);
        let done = ended.events().into_iter().filter(|event| event["event"] == "frame_done");
        done.map(|event| (event["frame"].clone(), event["warnings"].clone(), event["layers"][0]["jerk"].clone()))
            .collect::<Vec<_>>()
    };
    let sequence = reports("1-14");
    assert!(sequence.iter().skip(3).all(|(.., jerk)| jerk["warp_px"].as_f64().is_some()), "{sequence:?}");
    for frame in [1, 3, 4, 6, 12] {
        assert_eq!(reports(&frame.to_string()), sequence[frame - 1..frame], "frame {frame}");
    }
    let gaps: Vec<_> = sequence.iter().step_by(3).cloned().collect();
    assert_eq!(reports("1-14x3"), gaps);
}

#[test]
fn long_and_unusual_names_are_handled() {
    let long = format!("{}.####.exr", "n".repeat(245));
    Bench::new().render(&format!("-o {long}")).says(0, &["2 frames"]);
    let bench = Bench::new();
    bench.render(&format!("-o {}.exr", "#".repeat(70_000))).says(2, &["longer than any file name"]);
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt;
        let name = |bytes: &[u8]| std::ffi::OsStr::from_bytes(bytes).to_owned();
        let run = |arguments: &[&std::ffi::OsStr]| {
            let mut command = bench.command(crate::support::PROGRAM);
            bench.checked(command.args(arguments).output().expect("the program starts"))
        };
        let [render, shot, flag, json, frames, one] =
            ["render", "shot.toml", "-o", "--json", "--frames", "1"].map(|word| name(word.as_bytes()));
        let cpu = [name(b"--device"), name(b"cpu")];
        let base = [&*render, &shot, &cpu[0], &cpu[1], &frames, &one, &flag];
        let strange = name(b"caf\xe9.exr");
        let ended = run(&[&base[..], &[&strange, &json]].concat()).says(0, &[]);
        assert!(ended.events().iter().any(|event| event["event"] == "frame_done"), "no event is lost: {ended:?}");
        assert!(bench.path("").join(&strange).exists());
        run(&[&base[..], &[&name(b"caf\xe9.####.exr")]].concat()).says(2, &["not valid Unicode"]);
        std::fs::rename(bench.path("tiny.gltf"), bench.path("").join(name(b"caf\xe9.gltf"))).expect("renamed");
        let new = [name(b"new"), name(b"caf\xe9.gltf"), name(b"-o"), name(b"new.toml")];
        run(&new.each_ref().map(|word| word.as_os_str())).says(2, &["not valid Unicode", "rename it"]);
        assert!(!bench.path("new.toml").exists());
    }
}
