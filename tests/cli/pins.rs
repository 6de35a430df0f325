//! Pins that do not fit the scene, contradict each other, or are not there.

use crate::support::{Bench, HEAD, OUTPUT, PIN};
use pinwarp::image::read_exr;

fn with_pin(pin: &str) -> Bench {
    Bench::with_shot(&format!("{HEAD}{pin}{OUTPUT}"))
}

#[test]
fn pin_on_a_missing_node() {
    let ended = with_pin(&PIN.replace("\"Quad\"", "\"Quat\"")).render("");
    ended.says(2, &["shot.toml", "layer 'all'", "pin 'corner'", "no node 'Quat'", "did you mean \"Quad\""]);
}

#[test]
fn pin_on_a_missing_primitive() {
    let ended = with_pin(&PIN.replace("triangle = 0", "primitive = 3, triangle = 0")).render("");
    ended.says(2, &["shot.toml", "pin 'corner'", "no primitive 3", "it has 1"]);
}

#[test]
fn pin_on_a_missing_triangle() {
    let ended = with_pin(&PIN.replace("triangle = 0", "triangle = 8")).render("");
    ended.says(2, &["shot.toml", "pin 'corner'", "no triangle 8", "its last is 7", "pinwarp pick"]);
}

#[test]
fn a_pin_ray_that_hits_nothing() {
    let screen = "{ screen = [0.01, 0.01], frame = 1 }";
    let ended =
        with_pin(&PIN.replace("{ node = \"Quad\", triangle = 0, barycentric = [1.0, 0.0, 0.0] }", screen)).render("");
    ended.says(2, &["shot.toml", "pin 'corner'", "no surface at 0.01, 0.01 in frame 1", "move the anchor"]);
}

#[test]
fn pin_whose_triangle_has_moved() {
    let moved = "barycentric = [1.0, 0.0, 0.0], rest = [0.4, 0.4, 0.0]";
    let ended = with_pin(&PIN.replace("barycentric = [1.0, 0.0, 0.0]", moved)).render("");
    ended.says(0, &["note:", "pin 'corner'", "exported again", "pinwarp pick --write corner"]);
}

#[test]
fn two_pins_that_pull_one_point_apart() {
    let second = PIN.replace("\"corner\"", "\"rival\"").replace("[0.1, 0.05]", "[-0.1, 0.05]");
    let bench = with_pin(&format!("{PIN}{second}"));
    let ended =
        bench.render("").says(0, &["warning: frame 2", "'corner' and 'rival'", "7.20 px apart", "least squares"]);
    assert!(!ended.stderr.contains("warning: frame 1"), "they agree in frame 1:\n{}", ended.stderr);
    // Both pull equally hard: the square goes up and not aside.
    let [first, second] = [1, 2].map(|frame| {
        let frame = read_exr(&bench.path(&format!("out/f.000{frame}.exr"))).expect("readable");
        (frame.data_window.x, frame.data_window.y, frame.data_window.width)
    });
    assert_eq!((first.0, first.2), (second.0, second.2));
    assert!(second.1 < first.1, "{first:?} {second:?}");
}

#[test]
fn a_layer_whose_pins_are_all_behind_the_camera_is_named() {
    let mut tiny = crate::support::square();
    tiny.lens = crate::tiny::Lens::Perspective(1.0);
    // The pinned corner is behind the camera, the opposite one in front of it.
    tiny.parts[0].positions[0][2] = 6.0;
    let ended = Bench::with_scene(&tiny.json()).render("").says(0, &["warning: frame 1: layer 'all': all its pins"]);
    assert!(!ended.stderr.contains("in sight"), "{}", ended.stderr);
}

#[test]
fn a_layer_whose_pins_are_all_muted_is_like_one_without() {
    let muted = PIN.replace("name = \"corner\"", "name = \"corner\"\n  mute = true");
    let note = "layer 'all' has muted pins only: it is not warped";
    for lattice in ["dims = [4, 4]", "dims = [4, 4, 4], space = \"world\""] {
        let head = HEAD.replace("dims = [4, 4]", lattice);
        let bench = Bench::with_shot(&format!("{head}{muted}{OUTPUT}"));
        let ended = bench.render("").says(0, &[&format!("note: {note}")]);
        assert!(!ended.stderr.contains("warning"), "{}", ended.stderr);
        let check = bench.run("check shot.toml").says(0, &[]).stdout;
        assert!(check.contains(&format!("note: {note}")) && !check.contains("warning"), "{check}");
    }
    // Muted pins beside one that acts, and handles that move, are no reason for a note.
    let handles = "  [[layer.handle]]\n  index = [1, 1]\n  keys = [{ frame = 1, offset = [0.1, 0.0] }]\n";
    for other in [PIN.replace("corner", "other"), handles.to_owned()] {
        let ended = with_pin(&format!("{muted}{other}")).render("").says(0, &[]);
        assert!(!ended.stderr.contains("not warped"), "{}", ended.stderr);
    }
}

#[test]
fn missing_pins_are_reported_and_change_nothing() {
    let bare = Bench::with_shot(&format!("{HEAD}{OUTPUT}"));
    bare.render("").says(0, &["note: no layer has pins or moved handles: nothing is warped"]);
    let none = Bench::with_shot(&format!("{}{OUTPUT}", HEAD.split("[[layer]]").next().unwrap_or_default()));
    none.render("").says(0, &["nothing is warped"]);
    let resting = with_pin(&PIN.replace("[0.1, 0.05]", "[0.0, 0.0]"));
    let ended = resting.render("").says(0, &[]);
    assert!(!ended.stderr.contains("nothing is warped"), "{}", ended.stderr);
    let moved = with_pin(PIN);
    moved.render("").says(0, &[]);
    let colors = |bench: &Bench| {
        let frame = read_exr(&bench.path("out/f.0002.exr")).expect("readable");
        let beauty = ["R", "G", "B", "A"].map(|name| frame.channel(name).expect("a colour").samples.clone());
        (frame.data_window, beauty)
    };
    assert_eq!(colors(&bare), colors(&resting));
    assert_eq!(colors(&bare), colors(&none));
    assert_ne!(colors(&bare), colors(&moved));
}

#[test]
fn one_layer_without_pins_is_named() {
    let head = HEAD.replace("name = \"all\"", "name = \"all\"\nnodes = [\"Quad\"]");
    let tiny = {
        let mut tiny = crate::support::square();
        tiny.parts.push(crate::tiny::grid("Other", [0.5, 0.0, 0.7, 0.2], 1));
        tiny.json()
    };
    let shot = format!("{head}{PIN}\n[[layer]]\nname = \"still\"\nnodes = [\"Other\"]\n{OUTPUT}");
    Bench::with(&tiny, &shot).render("").says(0, &["note: layer 'still' has no pins"]);
}
