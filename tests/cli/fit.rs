//! `pinwarp fit`: landmarks in, a lattice out that other commands take.

use crate::support::{Bench, HEAD, OUTPUT};
use pinwarp::export::{LatticeFile, Track};
use pinwarp::image::{Preview, write_png};
use pinwarp::space::ScreenPoint;

/// A picture of an opaque disc on nothing.
fn disc(bench: &Bench, name: &str, [width, height]: [u32; 2]) {
    let mut picture = Preview::transparent(width, height);
    let (x, y, radius) = (f64::from(width) * 0.5, f64::from(height) * 0.5, f64::from(height) * 0.4);
    for (number, pixel) in picture.rgba.chunks_exact_mut(4).enumerate() {
        let at = [number as u32 % width, number as u32 / width].map(|k| f64::from(k) + 0.5);
        if (at[0] - x).hypot(at[1] - y) < radius {
            pixel.copy_from_slice(&[200, 120, 60, 255]);
        }
    }
    write_png(&bench.path(name), &picture).expect("written");
}

fn bench() -> Bench {
    let bench = Bench::new();
    disc(&bench, "a.png", [128, 72]);
    disc(&bench, "b.png", [256, 144]);
    bench
}

fn lattice(bench: &Bench, name: &str) -> pinwarp::lattice::ScreenLattice {
    let file = LatticeFile::read(&bench.path(name)).expect("a lattice file");
    match file.layers.into_iter().next().expect("a layer").track {
        Track::Screen(lattices) => lattices.into_values().next().expect("a frame"),
        Track::World(_) => panic!("on the screen"),
    }
}

#[test]
fn landmarks_in_pixels_of_each_picture_are_met() {
    let bench = bench();
    // The middle stays, the right side of the disc goes up by 8 pixels of A, 16 of B.
    bench.write("pairs.csv", b"name,ax,ay,bx,by\nmiddle,64,36,128,72\nright,88,36,176,56\nleft,40,36,80,72\n");
    let told = bench.run("fit a.png b.png --pairs pairs.csv --dims 8,8").says(0, &[]).stdout;
    assert!(told.contains("right") && told.contains("0.000 px off"), "{told}");
    assert!(told.contains("wrote fit.lattice.json: 8 x 8 handles, 3 landmarks") && !told.contains("warning"), "{told}");
    let lattice = lattice(&bench, "fit.lattice.json");
    for (from, to) in [([64.0, 36.0], [64.0, 36.0]), ([88.0, 36.0], [88.0, 28.0]), ([40.0, 36.0], [40.0, 36.0])] {
        let screen = |[x, y]: [f64; 2]| ScreenPoint::new(x / 72.0, 1.0 - y / 72.0);
        let left = (lattice.warp(screen(from)) - screen(to)).0.length() * 72.0;
        assert!(left < 1e-4, "{from:?} is {left} px off");
    }
    // What it writes drives a shot.
    let head = HEAD.replace("size = [64, 36]", "size = [128, 72]");
    let transfer = "transfer = { lattice = \"fit.lattice.json\", fit = \"as-is\" }\n";
    bench.write("driven.toml", format!("{head}{transfer}{OUTPUT}").as_bytes());
    bench.run("render driven.toml --device cpu").says(0, &[]);
    bench.run("fit a.png b.png --pairs pairs.csv").says(2, &["fit.lattice.json exists already"]);
}

#[test]
fn a_drawn_pose_drives_a_shot() {
    let bench = bench();
    // The corner of the square of the shot, in frame heights: .889 - .4 and .5 - .4.
    bench.write(
        "pairs.json",
        br#"{ "unit": "frame", "pairs": [ { "name": "corner", "a": [0.489, 0.1], "b": [0.55, 0.2] },
             { "name": "top", "a": [1.28, 0.9], "b": [1.28, 0.9] } ] }"#,
    );
    let told = bench.run("fit shot.toml b.png --pairs pairs.json --frame 2").says(0, &[]).stdout;
    assert!(told.contains("wrote fit.lattice.json: 10 x 10 handles, 2 landmarks"), "{told}");
    let file = LatticeFile::read(&bench.path("fit.lattice.json")).expect("a lattice file");
    assert_eq!(file.layers[0].name, "all");
    let left = lattice(&bench, "fit.lattice.json").warp(ScreenPoint::new(0.489, 0.1)) - ScreenPoint::new(0.55, 0.2);
    assert!(left.0.length() < 1e-6);
    bench.run("fit tiny.gltf b.png --pairs pairs.json -o scene.json").says(0, &[]);
}

#[test]
fn swapped_and_contradicting_landmarks_are_reported() {
    let bench = bench();
    bench.write("swapped.csv", b"left,44,36,168,72\nright,84,36,88,72\ntop,64,20,128,40\nfoot,64,52,128,104\n");
    let told = bench.run("fit a.png b.png --pairs swapped.csv").says(0, &[]).stdout;
    assert!(told.contains("cells fold over what is seen"), "{told}");
    bench.write("rivals.csv", b"one,64,36,120,72\nother,64,36,136,72\n");
    let told = bench.run("fit a.png b.png --pairs rivals.csv --overwrite").says(0, &[]).stdout;
    assert!(
        told.contains("4.000 px off") && told.contains("landmark 'one' is off: it and 'other' over-constrain"),
        "{told}"
    );
}

#[test]
fn impossible_fits_are_refused() {
    let bench = bench();
    bench.write("good.csv", b"1,2,3,4\n");
    bench.write("bad.csv", b"1,2,3\n");
    bench.write("empty.json", b"{ \"pairs\": [] }");
    let nothing = Preview::transparent(16, 9);
    write_png(&bench.path("nothing.png"), &nothing).expect("written");
    let cases = [
        ("a.png b.png --pairs bad.csv", &["bad.csv", "line 1", "ax,ay,bx,by"][..]),
        ("a.png b.png --pairs empty.json", &["empty.json", "pairs", "at least one"]),
        ("a.png b.png --pairs gone.json", &["cannot read", "gone.json"]),
        ("a.png b.png --pairs good.csv --dims 3,3", &["4 to 64"]),
        ("a.png b.png --pairs good.csv --dims 8", &["1 number,", "2 axes"]),
        ("gone.png b.png --pairs good.csv", &["gone.png"]),
        ("nothing.png b.png --pairs good.csv", &["nothing.png"]),
        ("shot.toml b.png --pairs good.csv --layer al", &["no layer 'al'", "did you mean"]),
    ];
    for (arguments, says) in cases {
        bench.run(&format!("fit {arguments}")).says(2, says);
    }
}
