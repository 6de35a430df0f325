//! Wrong shot files: each message names file, line and key, and says how to fix it.

use crate::support::{Bench, HEAD, OUTPUT, PIN};

fn shot() -> String {
    format!("{HEAD}{PIN}{OUTPUT}")
}

/// The usual shot with one place changed, rendered; nothing may be written.
#[track_caller]
fn refused(from: &str, to: &str, words: &[&str]) {
    assert!(shot().contains(from), "{from:?} is not in the shot");
    let text = shot().replacen(from, to, 1);
    let at = text.find(to).expect("the changed text");
    let line = format!("shot.toml:{}:", 1 + text[..at].matches('\n').count());
    let bench = Bench::with_shot(&text);
    let ended = bench.render("").says(2, words);
    assert!(ended.stderr.contains(&line), "{line} is not in:\n{}", ended.stderr);
    assert!(bench.frames().is_empty());
    bench.run("check shot.toml").says(2, words);
}

#[test]
fn the_usual_shot_is_good() {
    Bench::with_shot(&shot()).render("").says(0, &[]);
}

#[test]
fn missing_file() {
    Bench::new().run("render gone.toml").says(2, &["gone.toml", "cannot read", "check the path"]);
}

#[test]
fn not_toml() {
    refused("samples = 1", "samples = = 1", &["not valid TOML"]);
}

#[test]
fn not_text() {
    let bench = Bench::new();
    bench.write("shot.toml", b"# caf\xe9\nversion = 1\n");
    bench.render("").says(2, &["shot.toml", "UTF-8", "pinwarp new"]);
}

#[test]
fn unknown_key() {
    refused("samples = 1", "sampels = 1", &["sampels", "did you mean", "samples"]);
    refused("lattice = { dims", "lattice = { dimms", &["layer[0].lattice.dimms", "dims"]);
}

#[test]
fn wrong_type() {
    refused("size = [64, 36]", "size = \"big\"", &["size", "expected a list of 2 whole numbers", "the text \"big\""]);
    refused("{ frame = 2, offset = [0.1, 0.05] }", "{ frame = 2, offset = 0.1 }", &["layer[0].pin[0].keys[1].offset"]);
}

#[test]
fn unknown_name() {
    refused("lattice = { dims = [4, 4] }", "lattice = { dims = [4, 4], basis = \"bsplin\" }", &["bspline"]);
}

#[test]
fn keys_out_of_order() {
    refused("{ frame = 2, offset", "{ frame = 0, offset", &["layer[0].pin[0].keys[1].frame", "does not come after"]);
}

#[test]
fn empty_frame_range() {
    refused("last = 2", "last = -4", &["frames.last", "is empty", "1 or later"]);
}

#[test]
fn an_empty_size_is_refused() {
    refused("size = [64, 36]", "size = [0, 36]", &["size", "out of range"]);
}

#[test]
fn excessive_sizes_are_refused() {
    refused("size = [64, 36]", "size = [100000, 100000]", &["size[0]", "100000 is out of range", "from 1 to 65536"]);
    let bench = Bench::with_shot(&shot().replace("[64, 36]", "[65536, 65536]"));
    bench.render("").says(2, &["shot.toml", "65536 x 65536", "too large", "stay within"]);
    assert!(bench.frames().is_empty());
    let bench = Bench::with_shot(&shot().replace("[64, 36]", "[16384, 16384]"));
    bench.render("--scale 16").says(2, &["262144 x 262144", "too large"]);
}

#[test]
fn a_long_thin_frame_is_fine() {
    let bench = Bench::with_shot(&shot().replace("[64, 36]", "[65536, 2]"));
    bench.render("--frames 1").says(0, &[]);
}

#[test]
fn no_frame_counter() {
    refused("out/f.####.exr", "out/f.exr", &["output.path", "no frame counter for 2 frames", "####"]);
}

#[test]
fn not_an_exr_name() {
    refused("out/f.####.exr", "out/f.####.png", &["output.path", "not the name of an EXR file"]);
}

#[test]
fn pixels_instead_of_frame_heights() {
    refused("offset = [0.1, 0.05]", "offset = [120.0, 50.0]", &["look like pixels", "divide"]);
    let in_boxes = "unit = \"box\"\n  keys = [ { frame = 0, offset = [1e300, 0.0] }, { frame = 1,";
    let text = shot().replace("keys = [ { frame = 1,", in_boxes);
    Bench::with_shot(&text).render("").says(2, &["layer[0].pin[0].keys[0].offset", "box sizes look like pixels"]);
    let handle = "[[layer.handle]]\nindex = [3, 3]\nkeys = [{ frame = 1, offset = [0.0, -1e6] }]\n[output]";
    let text = shot().replace("[output]", handle);
    Bench::with_shot(&text).render("").says(2, &["layer[0].handle[0].keys[0].offset", "box sizes look like pixels"]);
}

#[test]
fn large_numbers_are_told_in_scientific_notation() {
    let says = ["1e300 frame heights look like pixels", "1e300 px of 36 is 2.777777777777778e298"];
    refused("offset = [0.1, 0.05]", "offset = [1e300, 0.05]", &says);
    refused("offset = [0.1, 0.05]", "offset = [-1e308, 0.05]", &["-1e308 px of 36 is -2.7777777777777"]);
    refused("offset = [0.1, 0.05]", "offset = [120.0, 50.0]", &["120 px of 36 is 3.3333"]);
    refused("[1.0, 0.0, 0.0]", "[1e300, 0.0, 0.0]", &["sum to 1e300, not 1"]);
}

#[test]
fn several_faults_are_reported_at_once() {
    let text = shot().replace("samples = 1", "sampels = 1").replace("last = 2", "last = 0");
    Bench::with_shot(&text).render("").says(2, &["sampels", "frames.last"]);
}

#[test]
fn missing_camera_and_clip() {
    let named = |line: &str| Bench::with_shot(&shot().replace("samples = 1", line));
    named("samples = 1\ncamera = \"Kam\"").render("").says(2, &["shot.toml", "Kam", "did you mean \"Cam\""]);
    let clip = shot().replace("rate = 24", "rate = 24, clip = \"Walk\"");
    Bench::with_shot(&clip).render("").says(2, &["shot.toml", "Walk"]);
}

#[test]
fn layers_that_do_not_fit_the_scene() {
    let nodes = |list: &str| shot().replace("name = \"all\"", &format!("name = \"all\"\nnodes = {list}"));
    Bench::with_shot(&nodes("[\"Quat\"]"))
        .render("")
        .says(2, &["shot.toml", "layer 'all'", "'Quat'", "did you mean", "Quad"]);
    Bench::with_shot(&nodes("[\"Cam\"]")).render("").says(2, &["layer 'all'", "triangles"]);
    let twice = shot().replace("[output]", "[[layer]]\nname = \"more\"\n[output]");
    Bench::with_shot(&twice).render("").says(2, &["layer 'all'", "later layers take all", "move its [[layer]] behind"]);
}
