//! `pinwarp transfer`: lattices of a shot laid over pictures, scenes and shots.

use crate::support::{Bench, square};
use pinwarp::image::{Frame, read_exr};

/// A folder with the usual shot, its lattices, and a picture of a square.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.run("export shot.toml --to lattice-json -o square.json").says(0, &[]);
    let inside = |x: u32, y: u32| (20..44).contains(&x) && (6..30).contains(&y);
    let pixel = |x: u32, y: u32| image::Rgba(if inside(x, y) { [200, 100, 50, 255] } else { [0; 4] });
    image::RgbaImage::from_fn(64, 36, pixel).save(bench.path("drawn.png")).expect("the folder can be written to");
    bench
}

fn frame(bench: &Bench, name: &str) -> Frame {
    read_exr(&bench.path(name)).expect("a frame")
}

fn alpha(frame: &Frame) -> f32 {
    frame.channel("A").expect("beauty is written").samples.iter().sum()
}

#[test]
fn a_picture_is_bent_over_the_frames_of_the_lattices() {
    let bench = bench();
    bench.run("transfer --lattice square.json --onto drawn.png -o cat/c.####.exr --preview").says(0, &[]);
    let [still, bent] = ["cat/c.0001.exr", "cat/c.0002.exr"].map(|name| frame(&bench, name));
    assert_eq!(alpha(&still), 24.0 * 24.0, "the first frame of the source is at rest");
    // Its only pin carries all of it along: by a tenth of 36 lines, in a box that is about a tenth smaller.
    let middle = |frame: &Frame| {
        let columns = frame.channel("A").expect("beauty is written").samples.iter().enumerate();
        let place = |at: usize| f64::from(frame.data_window.x) + (at % frame.data_window.width as usize) as f64;
        columns.map(|(at, alpha)| place(at) * f64::from(*alpha)).sum::<f64>() / f64::from(alpha(frame))
    };
    assert!((3.1..3.5).contains(&(middle(&bent) - middle(&still))), "{} {}", middle(&bent), middle(&still));
    assert!(bench.path("cat/c.0002.png").exists() && !bench.path("drawn.toml").exists());
    bench.run("transfer --lattice square.json --onto drawn.png -o h.####.exr --strength 0").says(0, &[]);
    assert_eq!(alpha(&frame(&bench, "h.0002.exr")), alpha(&still));
}

#[test]
fn a_scene_gets_a_shot_that_can_be_rendered_again() {
    const SMALL: &str = "--frames 2 --scale 1/30 --samples 1 --device cpu";
    let bench = bench();
    bench.write("other.gltf", square().json().to_string().as_bytes());
    bench.run(&format!("transfer --lattice square.json --onto other.gltf -o o.####.exr {SMALL}")).says(0, &["o.toml"]);
    let text = String::from_utf8(bench.read("o.toml")).expect("the shot is written beside the frames");
    assert!(text.contains("scene   = \"other.gltf\"") && text.contains("fit = \"box\""), "{text}");
    bench.run(&format!("render o.toml -o p.####.exr {SMALL}")).says(0, &[]);
    assert_eq!(frame(&bench, "o.0002.exr"), frame(&bench, "p.0002.exr"));
    let new = "transfer --lattice square.json --onto other.gltf -o deep/er/o.####.exr";
    bench.run(&format!("{new} {SMALL}")).says(0, &["deep/er/o.toml"]);
    for (output, shot) in [("q.%04d.exr", "q.toml"), ("####.exr", "other.toml")] {
        let command = format!("transfer --lattice square.json --onto other.gltf -o {output} {SMALL}");
        bench.run(&command).says(0, &[&format!("wrote {shot}")]);
        assert!(bench.path(shot).exists(), "{shot}");
    }
    assert_eq!(frame(&bench, "o.0002.exr"), frame(&bench, "deep/er/o.0002.exr"));
}

#[test]
fn a_shot_takes_lattices_instead_of_its_pins() {
    const SECOND: &str = "--frames 2 --device cpu";
    let bench = bench();
    let text = String::from_utf8(bench.read("shot.toml")).expect("the usual shot");
    bench.write("still.toml", text.replace("offset = [0.1, 0.05]", "offset = [0.0, 0.0]").as_bytes());
    bench.run(&format!("render shot.toml {SECOND} -o a.####.exr")).says(0, &[]);
    let onto = "transfer --lattice square.json --onto still.toml --fit as-is";
    bench.run(&format!("{onto} {SECOND} -o b.####.exr")).says(0, &[]);
    bench.run(&format!("render still.toml {SECOND} -o c.####.exr")).says(0, &[]);
    let [moved, transferred, still] =
        ["a.0002.exr", "b.0002.exr", "c.0002.exr"].map(|name| alpha(&frame(&bench, name)));
    // In the file's digits the lattices are the same.
    assert!((moved - transferred).abs() < 1e-3 && (moved - still).abs() > 1.0, "{moved} {transferred} {still}");
}

#[test]
fn landmarks_are_written_or_read() {
    let bench = bench();
    bench.write("pairs.json", b"[[[0.5, 0.5], [0.6, 0.5]]]");
    let onto = "transfer --lattice square.json --onto drawn.png --landmarks";
    bench.run(&format!("{onto} [[[0.5,0.5],[0.6,0.5]]] -o a.####.exr")).says(0, &[]);
    bench.run(&format!("{onto} pairs.json -o b.####.exr --shot kept.toml")).says(0, &["kept.toml"]);
    assert_eq!(frame(&bench, "a.0002.exr"), frame(&bench, "b.0002.exr"));
    assert!(String::from_utf8_lossy(&bench.read("kept.toml")).contains("landmarks = [[[0.5, 0.5], [0.6, 0.5]]]"));
}

#[test]
fn faults_say_what_to_do() {
    let bench = bench();
    bench.write("bad.json", b"{}");
    bench.write("none.toml", b"image = \"drawn.png\"\nframes = { first = 1, last = 2 }\n");
    bench.write("two.json", two_layers(&String::from_utf8(bench.read("square.json")).expect("JSON")).as_bytes());
    let cases = [
        ("--lattice no.json --onto drawn.png", "no.json"),
        ("--lattice bad.json --onto drawn.png", "bad.json"),
        ("--lattice square.json --onto no.png", "there is no such file"),
        ("--lattice square.json --onto drawn.####.png", "`pinwarp warp drawn.####.png --lattice FILE`"),
        ("--lattice square.json --onto drawn.bmp", "give a picture (.png, .jpg, .exr)"),
        ("--lattice square.json --onto none.toml", "has no layers on the screen"),
        ("--lattice two.json --onto drawn.png", "choose one with --layer"),
        ("--lattice square.json --onto drawn.png --layer al", "did you mean \"all\"?"),
        ("--lattice square.json --onto drawn.png --fit landmarks", "needs --landmarks"),
        ("--lattice square.json --onto drawn.png --fit box --landmarks [[[0,0],[1,1]]]", "leave one of them out"),
        ("--lattice square.json --onto drawn.png --landmarks []", "pairs of screen points"),
        ("--lattice square.json --onto drawn.png --landmarks [[1,2]]", "pairs of screen points"),
        ("--lattice square.json --onto drawn.png --landmarks no.json", "cannot read no.json"),
        ("--lattice square.json --onto drawn.png --strength lots", "from -100 to 100"),
        ("--lattice square.json --onto shot.toml --shot x.toml", "is a shot already"),
        ("--lattice square.json --onto drawn.png --shot shot.toml", "exists already"),
        ("--onto drawn.png", "--lattice"),
    ];
    for (arguments, wanted) in cases {
        bench.run(&format!("transfer {arguments}")).says(2, &[wanted]);
    }
    let good = "transfer --lattice square.json --onto drawn.png -o out.####.exr";
    bench.run(good).says(0, &[]);
    bench.run(good).says(2, &["exist already"]);
}

/// The same track once more, under another name.
fn two_layers(text: &str) -> String {
    let mut file: serde_json::Value = serde_json::from_str(text).expect("a lattice file");
    let mut other = file["layers"][0].clone();
    other["name"] = "other".into();
    file["layers"].as_array_mut().expect("a list").push(other);
    file.to_string()
}
