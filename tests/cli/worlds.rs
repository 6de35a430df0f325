//! Layers of the world on the command line: new, pick, check, render, reports.

use crate::support::{Bench, HEAD, OUTPUT};
use crate::tiny::{Lens, Part, Tiny, grid};
use serde_json::Value;

/// A bent sheet seen in perspective, in a world layer with these pins.
fn bench(lattice: &str, pins: &str) -> Bench {
    bench_of(6, lattice, pins)
}

/// The same, of `cells` x `cells` cells.
fn bench_of(cells: u32, lattice: &str, pins: &str) -> Bench {
    let mut part: Part = grid("Quad", [-0.4, -0.3, 0.4, 0.3], cells);
    part.positions.iter_mut().for_each(|point| point[2] = 0.3 * (3.0 * point[0]).cos() + 0.2 * point[1]);
    let tiny = Tiny { lens: Lens::Perspective(0.25), ..Tiny::of(vec![part]) };
    let head = HEAD.replace("lattice = { dims = [4, 4] }", lattice);
    assert_ne!(head, HEAD, "the lattice is replaced");
    Bench::with(&tiny.json(), &format!("{head}{pins}{OUTPUT}"))
}

const WORLD: &str = "lattice = { space = \"world\", dims = [4, 4, 4] }";

fn pin(keys: &str) -> String {
    format!(
        "[[layer.pin]]\nname = \"corner\"\n\
         anchor = {{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }}\nkeys = [{keys}]\n"
    )
}

#[test]
fn a_picked_pin_can_be_dragged_at_once() {
    let bench = bench(WORLD, "");
    let written = bench.run("pick shot.toml --at-px 32,18 --write nose").says(0, &[]).stdout;
    assert!(written.contains("wrote pin 'nose' of layer 'all'"), "{written}");
    bench.run("check shot.toml").says(0, &[]);
    let text = String::from_utf8(bench.read("shot.toml")).expect("text");
    for offset in ["[0.1, 0.2]", "[0.1, 0.2, 0.3]"] {
        assert!(text.contains("offset = [0.0, 0.0]"));
        bench.write("shot.toml", text.replace("offset = [0.0, 0.0]", &format!("offset = {offset}")).as_bytes());
        bench.render("--overwrite").says(0, &[]);
    }
}

#[test]
fn reports_tell_pixels_and_metres() {
    let bench = bench(WORLD, &pin("{ frame = 1, offset = [0.2, 0.1, 0.3] }"));
    let done: Vec<Value> = bench.render("--json --overlay").says(0, &[]).events();
    let layers: Vec<&Value> =
        done.iter().filter(|event| event["event"] == "frame_done").map(|e| &e["layers"][0]).collect();
    assert_eq!(layers.len(), 2);
    for layer in layers {
        assert!(layer["pin_error_px"].as_f64().is_some_and(|px| px < 0.05), "{layer}");
        assert!(layer["pin_error_metres"].as_f64().is_some_and(|metres| metres < 1e-5), "{layer}");
    }
}

#[test]
fn overlays_show_the_lattice_in_space() {
    let bench = bench(WORLD, &pin("{ frame = 1, offset = [0.2, 0.1, 0.3] }"));
    let picture = |arguments: &str| {
        bench.render(&format!("--frames 1 --overwrite {arguments}")).says(0, &[]);
        image::load_from_memory(&bench.read("out/f.0001.png")).expect("a picture").into_rgb8()
    };
    let (plain, drawn) = (picture("--preview"), picture("--overlay"));
    // Lines of the lattice are bluish-green where the picture is empty.
    let lines = plain.pixels().zip(drawn.pixels()).filter(|(before, after)| before != after && after.0[2] > after.0[0]);
    assert!(lines.count() > 60);
}

#[test]
fn wrong_places_name_key_and_remedy() {
    let refused = |lattice: &str, pins: &str, words: &[&str]| {
        let bench = bench(lattice, pins);
        bench.render("").says(2, words);
        assert!(bench.frames().is_empty());
        bench.run("check shot.toml").says(2, words);
    };
    refused("lattice = { dims = [4, 4, 4] }", "", &["layer[0].lattice.dims", "add space = \"world\""]);
    refused(
        WORLD,
        &pin("{ frame = 1, offset = [1, 1] }, { frame = 2, offset = [1, 1, 1] }"),
        &["keys[1].offset", "all three"],
    );
    refused("lattice = { space = \"world\", box = \"frame\" }", "", &["lattice.box", "box = \"follow\""]);
}

#[test]
fn a_mesh_too_coarse_is_noted() {
    let bench = bench_of(1, "lattice = { space = \"world\", dims = [8, 8, 8] }", &pin(""));
    let told = bench.run("check shot.toml").says(0, &[]).stdout;
    assert!(told.contains("note: layer 'all': edges of 'Quad' are up to") && told.contains("subdivide"), "{told}");
}

#[test]
fn world_lattices_are_exported_where_they_stand() {
    let bench = bench(WORLD, &pin("{ frame = 1, offset = [0.2, 0.1, 0.3] }"));
    bench.run("export shot.toml --to lattice-json -o a.json").says(0, &[]);
    let file: Value = serde_json::from_slice(&bench.read("a.json")).expect("JSON");
    let layer = &file["layers"][0];
    assert_eq!((layer["space"].as_str(), layer["dims"].as_array().map(Vec::len)), (Some("world"), Some(3)));
    let frame = &layer["frames"][1];
    assert_eq!(frame["handles"].as_array().map(Vec::len), Some(64));
    assert_eq!(frame["placement"].as_array().map(Vec::len), Some(4), "three axes and an origin");
    // What is written can be read.
    bench.run("resize a.json -o b.json --dims 6,6,6").says(0, &[]);
    let resized: Value = serde_json::from_slice(&bench.read("b.json")).expect("JSON");
    assert_eq!(resized["layers"][0]["frames"][1]["placement"], frame["placement"]);
}
