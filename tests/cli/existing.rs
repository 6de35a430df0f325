//! Frames that are there already: refused, kept or replaced.

use crate::support::{Bench, HEAD, OUTPUT, PIN, square};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

#[test]
fn refused_unless_asked() {
    let bench = Bench::new();
    bench.render("").says(0, &["2 frames on CPU", "frame 1 ->", "frame 2 ->"]);
    let before = bench.read("out/f.0001.exr");
    bench.write("out/f.0002.exr", &before);
    bench.render("").says(2, &["2 of the frames exist", "f.0001.exr", "--resume", "--overwrite"]);
    assert_eq!(bench.read("out/f.0002.exr"), before, "nothing was touched");
    let check = bench.run("check shot.toml").says(0, &[]);
    assert!(check.stdout.contains("2 of the frames exist already"), "{check:?}");
}

#[test]
fn overwritten_with_the_same_bytes() {
    let bench = Bench::new();
    bench.render("").says(0, &[]);
    let good = bench.read("out/f.0002.exr");
    bench.write("out/f.0002.exr", b"rubbish");
    bench.render("--overwrite").says(0, &[]);
    assert_eq!(bench.read("out/f.0002.exr"), good);
    assert_eq!(bench.frames(), ["f.0001.exr", "f.0002.exr"]);
}

#[test]
fn resume_keeps_whole_frames_and_mends_cut_ones() {
    let bench = Bench::new();
    bench.render("").says(0, &[]);
    let [first, second] = [1, 2].map(|frame| bench.read(&format!("out/f.000{frame}.exr")));
    for length in [0, 100, second.len() / 2, second.len() - 1] {
        // A whole file of another frame stands for work that must not be done again.
        bench.write("out/f.0001.exr", &second);
        bench.write("out/f.0002.exr", &second[..length]);
        let ended = bench.render("--resume").says(0, &["1 frame on CPU", "1 kept", "frame 2 ->"]);
        assert!(!ended.stderr.contains("frame 1 ->"), "{}", ended.stderr);
        assert_eq!(bench.read("out/f.0001.exr"), second, "kept as it is");
        assert_eq!(bench.read("out/f.0002.exr"), second, "rendered again from {length} bytes");
    }
    bench.write("out/f.0001.exr", &first);
    bench.render("--resume").says(0, &["0 frames", "2 kept"]);
}

#[test]
fn resume_renders_frames_whose_preview_is_missing() {
    let bench = Bench::new();
    bench.render("").says(0, &[]);
    bench.render("--frames 2 --preview --overwrite").says(0, &[]);
    bench.render("--resume --preview").says(0, &["1 frame on CPU", "1 kept", "frame 1 ->"]);
    assert_eq!(bench.frames(), ["f.0001.exr", "f.0001.png", "f.0002.exr", "f.0002.png"]);
}

#[test]
fn resume_and_overwrite_exclude_each_other() {
    Bench::new().render("--resume --overwrite").says(2, &["--resume", "--overwrite", "cannot be used"]);
}

#[test]
fn nothing_is_written_over_what_it_is_made_of() {
    const REFUSED: &[&str] = &["written over what it is made of", "-o"];
    let bench = Bench::new();
    let scene = bench.read("tiny.gltf");
    bench.run("export shot.toml --to gltf -o tiny.gltf --overwrite").says(2, REFUSED);
    bench.run("export shot.toml --to gltf -o ./shot.toml --overwrite").says(2, REFUSED);
    assert_eq!(bench.read("tiny.gltf"), scene);
    bench.run("export shot.toml --to lattice-json -o l.json").says(0, &[]);
    bench.run("export l.json --to lattice-json -o ./l.json --overwrite").says(2, REFUSED);
    bench.run("fit tiny.gltf tiny.gltf --pairs l.json -o tiny.gltf --overwrite").says(2, REFUSED);
    let inside =
        |x: u32, y: u32| if (20..44).contains(&x) && (6..30).contains(&y) { [200, 100, 50, 255] } else { [0; 4] };
    let drawing = image::RgbaImage::from_fn(64, 36, |x, y| image::Rgba(inside(x, y)));
    drawing.save(bench.path("drawn.png")).expect("the folder can be written to");
    let drawing = bench.read("drawn.png");
    bench
        .run("transfer --lattice l.json --onto drawn.png -o drawn.exr --frames 1 --preview --overwrite")
        .says(2, REFUSED);
    assert_eq!(bench.read("drawn.png"), drawing);
}

#[test]
fn nothing_is_written_over_files_beside_a_scene_nor_over_plates() {
    const REFUSED: &[&str] = &["written over what it is made of", "-o"];
    let mut scene = square().json();
    let uri = scene["buffers"][0]["uri"].as_str().expect("a data URI").to_owned();
    let bytes = STANDARD.decode(uri.rsplit(',').next().expect("data")).expect("base64");
    scene["buffers"][0]["uri"] = "the%20quad.bin".into();
    scene["images"] = serde_json::json!([{ "uri": "skin.png" }]);
    let bench = Bench::with(&scene, &format!("plate = \"in/b.####.exr\"\n{HEAD}{PIN}{OUTPUT}"));
    bench.write("the quad.bin", &bytes);
    bench.write("skin.png", b"a picture");
    bench.render("").says(0, &[]);
    std::fs::create_dir_all(bench.path("in")).expect("a folder");
    for name in ["in/b.0001.exr", "in/b.0002.exr", "in/b.all.element.0001.exr", "in/n.stmap.0002.exr"] {
        std::fs::copy(bench.path("out/f.0001.exr"), bench.path(name)).expect("copied");
    }
    let plate = bench.read("in/b.0001.exr");
    std::os::unix::fs::symlink("the quad.bin", bench.path("link")).expect("linked");
    for format in ["lattice-json", "gltf", "blender", "nuke"] {
        bench.run(&format!("export shot.toml --to {format} -o link --overwrite")).says(2, REFUSED);
        bench.run(&format!("export shot.toml --to {format} -o skin.png --overwrite")).says(2, REFUSED);
    }
    bench.run("export shot.toml --to stmap -o in/b.####.exr --overwrite").says(2, REFUSED);
    bench.render("-o in/b.####.exr --overwrite").says(2, REFUSED);
    let of = |plate: &str| {
        let shot = format!("plate = \"{plate}\"\n{HEAD}{PIN}{OUTPUT}");
        bench.write("shot.toml", shot.as_bytes());
    };
    of("in/n.stmap.####.exr");
    bench.run("export shot.toml --to nuke -o in/n.nk").says(2, REFUSED);
    of("in/b.all.element.####.exr");
    bench.run("export shot.toml --to after-effects -o in/b --overwrite").says(2, REFUSED);
    assert_eq!(bench.read("the quad.bin"), bytes);
    assert_eq!(bench.read("skin.png"), b"a picture");
    for name in ["in/b.0001.exr", "in/b.0002.exr", "in/b.all.element.0001.exr", "in/n.stmap.0002.exr"] {
        assert_eq!(bench.read(name), plate, "{name}");
    }
}
