//! The commands around a render: `new`, `pick`, `solve`, `devices`.

use crate::support::{Bench, HEAD, OUTPUT, PIN};
use serde_json::Value;

#[test]
fn a_new_shot_renders_as_it_stands() {
    let bench = Bench::new();
    let ended = bench.run("new tiny.gltf -o new.toml").says(0, &[]);
    assert!(ended.stdout.contains("wrote new.toml; next: pinwarp render new.toml"), "{ended:?}");
    bench.run("render new.toml --frames 1 --scale 1/40 --device cpu").says(0, &["out/new.0001.exr"]);
    let before = bench.read("new.toml");
    bench.run("new tiny.gltf -o new.toml").says(2, &["new.toml exists already", "--overwrite"]);
    bench.write("new.toml", b"old");
    bench.run("new tiny.gltf -o new.toml --overwrite").says(0, &[]);
    assert_eq!(bench.read("new.toml"), before);
}

#[test]
fn a_new_shot_of_nothing() {
    let bench = Bench::new();
    bench.run("new gone.glb -o new.toml").says(2, &["gone.glb", "cannot read"]);
    bench.run("new girl.####.png -o new.toml").says(2, &["this is a sequence", "plate = \"girl.####.png\""]);
    bench.run("new shot.toml -o new.toml").says(2, &["shot.toml", "not valid glTF"]);
    bench.run("new tiny.gltf -o gone/new.toml").says(2, &["gone", "not there"]);
    assert!(!bench.path("new.toml").exists());
}

#[test]
fn a_picked_pin_can_be_pasted() {
    let bench = Bench::new();
    // A quarter of the way from the middle of the frame to its right border.
    let pin = bench.run("pick shot.toml --frame 1 --at 1.0,0.6").says(0, &[]).stdout;
    assert!(pin.contains("[[layer.pin]]") && pin.contains("node = \"Quad\""), "{pin}");
    let pasted = Bench::with_shot(&format!("{HEAD}{pin}{OUTPUT}"));
    pasted.render("").says(0, &[]);
    let in_pixels = bench.run("pick shot.toml --frame 1 --at-px 36,14.4").says(0, &[]).stdout;
    assert_eq!(in_pixels, pin, "pixels count from the upper left corner");
}

#[test]
fn a_written_pin_leaves_the_rest_of_the_file_alone() {
    let shot = format!("# mine\n{HEAD}  # also mine\n{PIN}  # and this\n{OUTPUT}# the end\n");
    let bench = Bench::with_shot(&shot);
    let ended = bench.run("pick shot.toml --frame 1 --at 1.0,0.6 --write cheek").says(0, &[]);
    assert!(ended.stdout.contains("'cheek'") && ended.stdout.contains("'all'"), "{ended:?}");
    let written = String::from_utf8(bench.read("shot.toml")).expect("text");
    let mut lines = written.lines();
    for line in shot.lines() {
        assert!(lines.any(|other| other == line), "{line:?} is gone from:\n{written}");
    }
    assert!(written.contains("\"cheek\""));
    bench.render("").says(0, &[]);
    bench.run("pick shot.toml --at 1.0,0.6 --write cheek --layer nobody").says(2, &["nobody"]);
}

#[test]
fn picks_that_hit_nothing_are_refused() {
    let bench = Bench::new();
    bench.run("pick shot.toml --frame 1 --at 0.01,0.01").says(2, &["no surface at 0.0100,0.0100 in frame 1"]);
    bench.run("pick shot.toml --at 1").says(2, &["--at", "two numbers with a comma"]);
    bench.run("pick shot.toml --at nan,0").says(2, &["two numbers"]);
    bench.run("pick shot.toml").says(2, &["--at"]);
}

const PROBLEM: &str = r#"{ "dims": [4, 4], "vertices": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "triangles": [[0, 1, 2], [0, 2, 3]], "pins": [{ "vertex": 0, "target": [0.5, 0.25] }] }"#;

#[test]
fn a_bare_problem_is_solved() {
    let bench = Bench::new();
    bench.write("problem.json", PROBLEM.as_bytes());
    bench.run("solve problem.json -o result.json").says(0, &[]);
    let result: Value = serde_json::from_slice(&bench.read("result.json")).expect("JSON");
    let corner = |index: usize, axis: usize| result["V"][index][axis].as_f64().expect("a number");
    // One pin carries everything along.
    assert!((corner(2, 0) - 1.5).abs() < 1e-6 && (corner(2, 1) - 1.25).abs() < 1e-6, "{result}");
    let printed = bench.run("solve problem.json").says(0, &[]).stdout;
    assert_eq!(printed.as_bytes(), bench.read("result.json"));
}

#[test]
fn contradicting_pins_of_a_problem_are_reported() {
    let bench = Bench::new();
    let second = r#"}, { "vertex": 0, "target": [0.0, 0.25] }] }"#;
    bench.write("problem.json", PROBLEM.replace("}] }", second).as_bytes());
    let printed = bench.run("solve problem.json").says(0, &[]).stdout;
    assert!(printed.contains("pins 0 and 1 hold the same point"), "{printed}");
}

#[test]
fn invalid_problems_are_refused() {
    let bench = Bench::new();
    bench.run("solve gone.json").says(2, &["gone.json", "cannot read"]);
    for (wrong, words) in [
        ("{", &["problem.json"][..]),
        (&PROBLEM.replace("\"pins\"", "\"pinz\""), &["problem.json", "pinz"]),
        (&PROBLEM.replace("[0, 2, 3]", "[0, 2, 9]"), &["problem.json", "9"]),
        (&PROBLEM.replace("\"vertex\": 0", "\"vertex\": 7"), &["problem.json", "pins[0]", "7"]),
        (&PROBLEM.replace("[4, 4]", "[0, 4]"), &["problem.json", "dims"]),
    ] {
        bench.write("problem.json", wrong.as_bytes());
        bench.run("solve problem.json -o result.json").says(2, words);
        assert!(!bench.path("result.json").exists());
    }
}

#[test]
fn devices_are_listed() {
    let bench = Bench::new();
    let list = bench.run("devices").says(0, &[]).stdout;
    assert!(list.lines().any(|line| line.starts_with("cpu")), "{list}");
    let mut command = bench.command(crate::support::PROGRAM);
    command.env("VK_ICD_FILENAMES", "/nowhere.json").env("VK_DRIVER_FILES", "/nowhere.json").arg("devices");
    let ended =
        bench.checked(command.output().expect("the program starts")).says(0, &["note: no usable Vulkan device"]);
    assert_eq!(ended.stdout.lines().count(), 1, "{ended:?}");
}
