//! Solved lattices on their way to other shots: `export`, `resize`, and layers that take theirs from a file.

use crate::support::{Bench, HEAD, OUTPUT, PIN, square};
use pinwarp::export::{LatticeFile, Track};
use pinwarp::image::read_exr;

/// The usual shot, warped by a file instead of by pins.
fn transferred(fit: &str) -> String {
    let transfer = format!("transfer = {{ lattice = \"shot.lattice.json\", fit = {fit} }}\n");
    format!("{HEAD}{transfer}{OUTPUT}").replace("out/f", "out/t")
}

/// Greatest difference of a sample between the frame of the pins and that of the file.
fn greatest_gap(bench: &Bench, frame: &str) -> f32 {
    let [a, b] = ["f", "t"].map(|name| read_exr(&bench.path(&format!("out/{name}.{frame}.exr"))).expect("a frame"));
    assert_eq!(a.data_window, b.data_window);
    let samples = |frame: &pinwarp::image::Frame| -> Vec<f32> {
        frame.channels.iter().flat_map(|channel| channel.samples.clone()).collect()
    };
    samples(&a).iter().zip(samples(&b)).map(|(a, b)| (a - b).abs() / a.abs().max(1.0)).fold(0.0, f32::max)
}

#[test]
fn a_transfer_keeps_time_where_the_shutter_opens_late() {
    let late = |shot: String| shot.replace("samples = 1", "samples = 4\nshutter = { angle = 180, phase = 0 }");
    let bench = Bench::with_shot(&late(format!("{HEAD}{PIN}{OUTPUT}")));
    bench.run("export shot.toml --to lattice-json").says(0, &[]);
    bench.render("").says(0, &[]);
    bench.write("other.toml", late(transferred("\"as-is\"")).as_bytes());
    let ended = bench.run("render other.toml --device cpu --json").says(0, &[]);
    let told: Vec<_> = ended.events().into_iter().filter(|event| !event["layers"].is_null()).collect();
    assert_eq!(told.len(), 2, "{ended:?}");
    assert!(told.iter().all(|event| event["layers"][0]["solve"]["angular"].is_null()), "distortion is not measured");
    for frame in ["0001", "0002"] {
        let gap = greatest_gap(&bench, frame);
        assert!(gap < 1e-4, "frame {frame}: {gap}");
    }
}

#[test]
fn an_exported_lattice_warps_another_shot_alike() {
    let bench = Bench::new();
    let ended = bench.run("export shot.toml --to lattice-json").says(0, &[]);
    assert!(ended.stdout.contains("wrote shot.lattice.json: 2 frames of all"), "{ended:?}");
    bench.render("").says(0, &[]);
    for fit in ["\"as-is\"", "\"box\"", "{ landmarks = [[[0.3, 0.3], [0.3, 0.3]], [[0.6, 0.5], [0.6, 0.5]]] }"] {
        bench.write("other.toml", transferred(fit).as_bytes());
        bench.run("render other.toml --device cpu --overwrite").says(0, &[]);
        for frame in ["0001", "0002"] {
            let gap = greatest_gap(&bench, frame);
            assert!(gap < 1e-4, "{fit}, frame {frame}: {gap}");
        }
    }
    // A scale of one half about the middle of the frame halves the motion of the pinned corner.
    bench.write(
        "other.toml",
        transferred("{ landmarks = [[[0.0, 0.0], [0.4, 0.25]], [[1.0, 0.0], [0.9, 0.25]]] }").as_bytes(),
    );
    bench.run("render other.toml --device cpu --overwrite").says(0, &[]);
    let [full, half] = ["f", "t"].map(|name| read_exr(&bench.path(&format!("out/{name}.0002.exr"))).expect("a frame"));
    assert_ne!(full.channel("R").expect("red").samples, half.channel("R").expect("red").samples);
}

#[test]
fn a_resized_lattice_keeps_the_edit() {
    let bench = Bench::new();
    bench.run("export shot.toml --to lattice-json -o a.json --frames 2").says(0, &[]);
    let resized = bench.run("resize a.json --dims 6,9 -o b.json").says(0, &[]);
    assert!(resized.stdout.contains("e-1") && resized.stdout.contains("frame heights at most"), "{resized:?}");
    let [before, after] = ["a.json", "b.json"].map(|name| {
        let file = LatticeFile::read(&bench.path(name)).expect("a lattice file");
        let Track::Screen(lattices) = file.layers[0].track.clone() else { panic!("a screen lattice") };
        lattices[&2].clone()
    });
    assert_eq!((before.grid.dims, after.grid.dims), ([4, 4], [6, 9]));
    for k in 0..100 {
        let at = [f64::from(k % 10), f64::from(k / 10)].map(|x| x / 9.0);
        let at = [0, 1].map(|axis| before.grid.lo[axis] + at[axis] * before.grid.size(axis));
        let (a, b) = (before.evaluate(at), after.evaluate(at));
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12);
    }
    bench.run("resize a.json --dims 5,6,7 -o c.json").says(2, &["layer 'all'", "3 numbers", "2 axes"]);
    bench.run("resize a.json --dims 3,6 -o c.json").says(2, &["4 to 64", "dims"]);
    bench.run("resize a.json --dims 5,6 -o b.json").says(2, &["b.json exists already", "--overwrite"]);
    bench.run("resize shot.toml --dims 5,6 -o c.json").says(2, &["shot.toml is not a lattice file"]);
    bench.run("resize a.json --dims 5,6 --basis cubic -o c.json").says(2, &["bspline, bernstein"]);
}

#[test]
fn impossible_transfers_are_refused() {
    let bench = Bench::new();
    bench.run("export shot.toml --to lattice-json").says(0, &[]);
    bench.run("export shot.toml --to lattice-json").says(2, &["shot.lattice.json exists already"]);
    let still = Bench::with(&square().json(), &format!("{HEAD}{OUTPUT}"));
    still.run("export shot.toml --to lattice-json").says(2, &["no layer is warped", "add pins"]);
    let cases = [
        (
            transferred("\"box\"").replace("shot.lattice.json", "gone.json"),
            &["there is no file gone.json", "gone.json"][..],
        ),
        (transferred("\"bx\""), &["other.toml:11", "layer[0].transfer.fit", "allowed: \"box\", \"as-is\""]),
        (transferred("\"box\"").replace("fit =", "layer = \"al\", fit ="), &["has no layer 'al'", "did you mean"]),
        (
            transferred("\"box\"").replace("[output]", &format!("{PIN}[output]")),
            &["layer[0].pin", "remove it or `transfer`"],
        ),
    ];
    for (shot, says) in cases {
        bench.write("other.toml", shot.as_bytes());
        bench.run("render other.toml --device cpu").says(2, says);
    }
}
