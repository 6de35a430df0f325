//! `pinwarp transfer`: lattices of a shot laid over pictures, scenes and shots.

use crate::support::{Bench, square};
use pinwarp::image::{Frame, read_exr};

/// A folder with the usual shot, its lattices, and a picture of a square.
fn bench() -> Bench {
    let bench = Bench::new();
    let ended = bench.run(&["export", "shot.toml", "--to", "lattice-json", "-o", "square.json"].join(" "));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let inside = |x: u32, y: u32| (20..44).contains(&x) && (6..30).contains(&y);
    let pixel = |x: u32, y: u32| image::Rgba(if inside(x, y) { [200, 100, 50, 255] } else { [0; 4] });
    image::RgbaImage::from_fn(64, 36, pixel).save(bench.path("drawn.png")).expect("the folder can be written to");
    bench
}

fn alpha(frame: &Frame) -> f32 {
    frame.channel("A").expect("beauty is written").samples.iter().sum()
}

/// The rightmost column that is covered.
fn right(frame: &Frame) -> i32 {
    frame.data_window.x + frame.data_window.width as i32
}

#[test]
fn a_picture_is_bent_over_the_frames_of_the_lattices() {
    let bench = bench();
    let args = ["transfer", "--lattice", "square.json", "--onto", "drawn.png", "-o", "cat/c.####.exr", "--preview"];
    let ended = bench.run(&args.join(" "));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let [still, bent] = [1, 2].map(|frame| read_exr(&bench.path(&format!("cat/c.000{frame}.exr"))).expect("a frame"));
    assert_eq!(alpha(&still), 24.0 * 24.0, "the first frame of the source is at rest");
    assert_ne!(still.data_window, bent.data_window);
    assert!(bench.path("cat/c.0002.png").exists() && !bench.path("drawn.toml").exists());
    let half = bench.run(
        &["transfer", "--lattice", "square.json", "--onto", "drawn.png", "-o", "h.####.exr", "--strength", "0"]
            .join(" "),
    );
    assert_eq!(half.code, Some(0), "{half:?}");
    let none = read_exr(&bench.path("h.0002.exr")).expect("a frame");
    assert_eq!((none.data_window, alpha(&none)), (still.data_window, alpha(&still)));
}

#[test]
fn a_scene_gets_a_shot_that_can_be_rendered_again() {
    let bench = bench();
    std::fs::write(bench.path("other.gltf"), square().json().to_string()).expect("written");
    let args = [
        "transfer",
        "--lattice",
        "square.json",
        "--onto",
        "other.gltf",
        "-o",
        "o.####.exr",
        "--frames",
        "2",
        "--scale",
        "1/30",
        "--samples",
        "1",
    ];
    let ended = bench.run(&args.join(" "));
    assert_eq!(ended.code, Some(0), "{ended:?}");
    let text = std::fs::read_to_string(bench.path("o.toml")).expect("the shot is written beside the frames");
    assert!(text.contains("scene   = \"other.gltf\"") && text.contains("fit = \"box\""), "{text}");
    let again = bench
        .run(&["render", "o.toml", "--frames", "2", "--scale", "1/30", "--samples", "1", "-o", "p.####.exr"].join(" "));
    assert_eq!(again.code, Some(0), "{again:?}");
    let [one, two] = ["o", "p"].map(|name| read_exr(&bench.path(&format!("{name}.0002.exr"))).expect("a frame"));
    assert_eq!(one, two);
}

#[test]
fn a_shot_takes_lattices_instead_of_its_pins() {
    let bench = bench();
    let text = std::fs::read_to_string(bench.path("shot.toml")).expect("the usual shot");
    bench.write("still.toml", text.replace("offset = [0.1, 0.05]", "offset = [0.0, 0.0]").as_bytes());
    let render = |args: &[&str]| {
        let ended = bench.run(&args.join(" "));
        assert_eq!(ended.code, Some(0), "{ended:?}");
    };
    render(&["render", "shot.toml", "--frames", "2", "-o", "a.####.exr"]);
    render(&[
        "transfer",
        "--lattice",
        "square.json",
        "--onto",
        "still.toml",
        "--fit",
        "as-is",
        "--frames",
        "2",
        "-o",
        "b.####.exr",
    ]);
    render(&["render", "still.toml", "--frames", "2", "-o", "c.####.exr"]);
    let [moved, transferred, still] =
        ["a", "b", "c"].map(|name| read_exr(&bench.path(&format!("{name}.0002.exr"))).expect("a frame"));
    assert_eq!(moved, transferred, "the same lattices over the same model");
    assert_ne!(transferred, still);
}

#[test]
fn landmarks_are_written_or_read() {
    let bench = bench();
    bench.write("pairs.json", b"[[[0.5, 0.5], [0.6, 0.5]]]");
    let render = |landmarks: &str, output: &str| {
        let args =
            ["transfer", "--lattice", "square.json", "--onto", "drawn.png", "--landmarks", landmarks, "-o", output];
        let ended = bench.run(&args.join(" "));
        assert_eq!(ended.code, Some(0), "{ended:?}");
    };
    render("[[[0.5,0.5],[0.6,0.5]]]", "a.####.exr");
    render("pairs.json", "b.####.exr");
    let [one, two] = ["a", "b"].map(|name| read_exr(&bench.path(&format!("{name}.0002.exr"))).expect("a frame"));
    assert_eq!(one, two);
    assert!(right(&one) > 0);
}

#[test]
fn faults_say_what_to_do() {
    let bench = bench();
    bench.write("bad.json", b"{}");
    bench.write("none.toml", b"image = \"drawn.png\"\nframes = { first = 1, last = 2 }\n");
    bench.write(
        "two.json",
        std::fs::read_to_string(bench.path("square.json")).map(|text| two_layers(&text)).expect("read").as_bytes(),
    );
    let good = ["--lattice", "square.json", "--onto", "drawn.png", "-o", "out.####.exr"];
    let cases: &[(&[&str], &str)] = &[
        (&["--lattice", "no.json", "--onto", "drawn.png"], "no.json"),
        (&["--lattice", "bad.json", "--onto", "drawn.png"], "bad.json"),
        (&["--lattice", "square.json", "--onto", "no.png"], "there is no such file"),
        (&["--lattice", "square.json", "--onto", "drawn.bmp"], "give a picture (.png, .jpg, .exr)"),
        (&["--lattice", "square.json", "--onto", "none.toml"], "has no layers on the screen"),
        (&["--lattice", "two.json", "--onto", "drawn.png"], "choose one with --layer"),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--layer", "al"], "did you mean \"all\"?"),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--fit", "landmarks"], "needs --landmarks"),
        (
            &["--lattice", "square.json", "--onto", "drawn.png", "--fit", "box", "--landmarks", "[[[0,0],[1,1]]]"],
            "leave one of them out",
        ),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--landmarks", "[]"], "pairs of screen points"),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--landmarks", "[[1,2]]"], "pairs of screen points"),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--landmarks", "no.json"], "cannot read no.json"),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--strength", "lots"], "from -100 to 100"),
        (&["--lattice", "square.json", "--onto", "shot.toml", "--shot", "x.toml"], "is a shot already"),
        (&["--lattice", "square.json", "--onto", "drawn.png", "--shot", "shot.toml"], "exists already"),
        (&["--onto", "drawn.png"], "--lattice"),
    ];
    for (args, wanted) in cases {
        let ended = bench.run(&[&["transfer"], *args].concat().join(" "));
        assert!(ended.code == Some(2) && ended.stderr.contains(wanted), "{args:?}: {ended:?}");
    }
    assert_eq!(bench.run(&[&["transfer"], good.as_slice()].concat().join(" ")).code, Some(0));
    let refused = bench.run(&[&["transfer"], good.as_slice()].concat().join(" "));
    assert!(refused.code == Some(2) && refused.stderr.contains("exist already"), "{refused:?}");
}

/// The same track once more, under another name.
fn two_layers(text: &str) -> String {
    let mut file: serde_json::Value = serde_json::from_str(text).expect("a lattice file");
    let mut other = file["layers"][0].clone();
    other["name"] = "other".into();
    file["layers"].as_array_mut().expect("a list").push(other);
    file.to_string()
}
