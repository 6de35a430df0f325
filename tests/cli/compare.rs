//! `pinwarp compare`: tables, JSON, pictures, and what it refuses.

use crate::support::{Bench, HEAD, OUTPUT, PIN};
use serde_json::Value;

/// A square of two triangles whose upper corners are pushed aside.
const SQUARE: &str = r##"{"name": "square", "dims": [6, 6], "vertices": [[0,0],[1,0],[1,1],[0,1]],
    "triangles": [[0,1,2],[0,2,3]], "parts": [{"name": "all", "color": "#c04020", "triangles": 2}],
    "poses": [{"name": "push", "pins": [{"vertex": 0, "target": [0,0]}, {"vertex": 1, "target": [1,0]},
        {"vertex": 2, "target": [1.4,0.9]}, {"vertex": 3, "target": [0.4,0.9]}]},
        {"name": "lift", "pins": [{"vertex": 0, "target": [0,0.5]}]}]}"##;

fn square() -> Bench {
    let bench = Bench::new();
    bench.write("square.json", SQUARE.as_bytes());
    bench
}

#[test]
fn all_methods_stand_in_the_table_and_on_the_sheet() {
    let bench = square();
    let table = bench.run("compare square.json -o sheet.png").says(0, &[]).stdout;
    for name in ["method", "Hsu 1992", "Rigid MLS", "ARAP + inverse FFD", "lp-FFD, as published", "pinwarp"] {
        assert!(table.contains(name), "{name} is missing:\n{table}");
    }
    let bases = |name: &str| table.lines().filter(|line| line.contains(name)).count();
    assert_eq!([bases(" Bernstein "), bases(" B-spline ")], [5, 5], "{table}");
    let sheet = image::open(bench.path("sheet.png")).expect("a picture").into_rgb8();
    let has = |wanted: [u8; 3]| sheet.pixels().filter(|pixel| pixel.0 == wanted).count();
    assert!(has([255, 214, 10]) > 500, "pins are yellow");
    assert!(has([192, 64, 32]) > 10_000, "the model has its colour");
}

#[test]
fn chosen_methods_and_poses_as_json() {
    let bench = square();
    let lines =
        bench.run("compare square.json --methods default,hsu --basis bspline --pose lift --json").says(0, &[]).stdout;
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(lines.len(), 2);
    let figure = |line: usize, key: &str| lines[line]["figures"][key].as_f64().expect("a number");
    assert!(lines.iter().all(|line| line["basis"] == "bspline"), "{lines:?}");
    // A single pin is a translation for us, and a pinch for Hsu.
    assert!(figure(1, "angle") < 1e-6 && figure(0, "angle") > 1e-2, "{lines:?}");
}

#[test]
fn a_layer_of_a_shot_is_compared() {
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{OUTPUT}"));
    let table = bench.run("compare shot.toml --frame 2 -o sheet.png --methods default").says(0, &[]).stdout;
    assert!(table.contains("pinwarp"), "{table}");
    assert!(bench.path("sheet.png").exists());
    bench.run("compare shot.toml --layer gone").says(2, &["there is no layer 'gone'", "all"]);
    bench.run("compare shot.toml --pose push").says(2, &["--pose: shot.toml is a shot", "give --frame"]);
}

#[test]
fn missing_inputs_are_named() {
    let bench = square();
    bench.run("compare gone.json").says(2, &["gone.json", "cannot read"]);
    bench.run("compare square.json --methods hsu,magic").says(2, &["there is no method 'magic'", "mls"]);
    bench.run("compare square.json --basis spline").says(2, &["spline", "bspline"]);
    bench.run("compare square.json --frame 2").says(2, &["--frame: square.json is a problem", "give --pose"]);
    bench.run("compare square.json --pose sleep").says(2, &["there is no pose 'sleep'", "push, lift"]);
}
