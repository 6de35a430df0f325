//! Frames that are there already: refused, kept or replaced.

use crate::support::Bench;

#[test]
fn existing_frames_are_refused_by_default() {
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
