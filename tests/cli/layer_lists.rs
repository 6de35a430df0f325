//! `export --layer a,b`: the named layers are exported, in every format that has layers; the others rest.

use crate::support::{Bench, HEAD, OUTPUT, names_in};
use crate::tiny::{Tiny, grid};
use pinwarp::export::LatticeFile;
use pinwarp::image::read_exr;

/// Three squares side by side, each with a layer that moves up by another amount, unless it rests.
fn bench(resting: &[&str]) -> Bench {
    let parts = ["a", "b", "c"].iter().enumerate().map(|(index, name)| {
        let left = -0.75 + 0.5 * index as f32;
        grid(name, [left, -0.2, left + 0.4, 0.2], 2)
    });
    let layer = |(index, name): (usize, &&str)| {
        let (x, by) = (0.35 + 0.5 * index as f64, 0.05 * (index + 1) as f64);
        let pin = format!(
            "[[layer.pin]]\nanchor = {{ screen = [{x}, 0.5], frame = 1 }}\n\
             keys = [{{ frame = 1, offset = [0.0, 0.0] }}, {{ frame = 2, offset = [0.0, {by}] }}]\n"
        );
        let pin = if resting.contains(name) { String::new() } else { pin };
        format!("[[layer]]\nname = '{name}'\nnodes = ['{name}']\nlattice = {{ dims = [4, 4] }}\n{pin}")
    };
    let layers: String = ["a", "b", "c"].iter().enumerate().map(layer).collect();
    let head = HEAD.split("[[layer]]").next().unwrap_or_default();
    Bench::with(&Tiny::of(parts.collect()).json(), &format!("{head}{layers}{OUTPUT}"))
}

#[test]
fn maps_of_several_layers_move_these_alone() {
    let (bench, rested) = (bench(&[]), self::bench(&["c"]));
    let command = "export shot.toml --to stmap --frames 2 -o m.####.exr";
    bench.run(&format!("{command} --layer a,b")).says(0, &[]);
    rested.run(command).says(0, &[]);
    let read = |bench: &Bench, name: &str| read_exr(&bench.path(name)).expect("a map").channels;
    assert_eq!(read(&bench, "m.0002.exr"), read(&rested, "m.0002.exr"));
    bench.run(&format!("{command} --overwrite")).says(0, &[]);
    assert_ne!(read(&bench, "m.0002.exr"), read(&rested, "m.0002.exr"), "the third layer moves, too");
    // Another choice of layers is another map.
    let resumed = |layers: &str, words: &str| {
        let ended = bench.run(&format!("{command} --resume --layer {layers}")).says(0, &[]);
        assert!(ended.stdout.contains(words), "{layers}: {ended:?}");
    };
    resumed("c,a", "1 frame");
    resumed("a,c", "0 frames, 1 kept");
    resumed("b,c", "1 frame");
    let told = bench.run("export shot.toml --to nuke --frames 2 --layer a,b").says(0, &[]);
    assert!(told.stdout.contains("an STMap and 2 grids"), "{told:?}");
}

#[test]
fn lattices_and_elements_of_several_layers() {
    let bench = bench(&[]);
    bench.run("export shot.toml --to lattice-json --layer c,a -o ac.json").says(0, &[]);
    let file = LatticeFile::read(&bench.path("ac.json")).expect("lattices");
    assert_eq!(file.layers.iter().map(|layer| layer.name.as_str()).collect::<Vec<_>>(), ["a", "c"]);
    bench.run("export ac.json --to stmap --layer a,c --size 64x36 -o f.####.exr").says(0, &[]);
    bench.run("export ac.json --to lattice-json --layer c -o c.json").says(0, &[]);
    assert_eq!(LatticeFile::read(&bench.path("c.json")).expect("lattices").layers, file.layers[1..]);
    bench.run("export shot.toml --to after-effects --frames 2 --layer a,b -o ae/s").says(0, &[]);
    let notes: Vec<_> = names_in(&bench.path("ae")).into_iter().filter(|name| name.ends_with(".txt")).collect();
    assert_eq!(notes, ["s.a.after-effects.txt", "s.b.after-effects.txt"]);
}

#[test]
fn layers_that_are_not_there_or_have_no_place_are_refused() {
    let bench = bench(&["c"]);
    for format in ["stmap", "nuke", "after-effects", "lattice-json"] {
        let ended = bench.run(&format!("export shot.toml --to {format} --layer a,d"));
        ended.says(2, &["shot.toml has no warped layer 'd'"]);
        bench.run(&format!("export shot.toml --to {format} --layer c")).says(2, &["no warped layer 'c'"]);
    }
    for format in ["gltf", "blender"] {
        let says = ["--layer is for maps and lattices", "writes the whole scene", "leave it out"];
        bench.run(&format!("export shot.toml --to {format} --layer a,b")).says(2, &says);
    }
}
