//! The kinds of files that are read: sound ones to start from, and their readers.

use crate::assets::asset;
use crate::readers::{read_figures, read_image, read_lattice, read_pairs, read_problem, read_scene, read_shot};
use pinwarp::image::read_any;
use std::path::Path;

/// A kind of file.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Ending of its files.
    pub(crate) ending: &'static str,
    /// Sound files.
    pub(crate) sound: Vec<Vec<u8>>,
    /// What is put in place of numbers; empty: the files are no text.
    pub(crate) words: &'static [&'static str],
    /// Damaged files that are tried.
    pub(crate) cases: u64,
    /// Reads a file and uses what it holds; whether it was taken.
    pub(crate) read: fn(&Path) -> bool,
}

/// What stands where numbers should.
const NUMBERS: &[&str] = &[
    "-1",
    "0",
    "1",
    "2",
    "7",
    "0.5",
    "1e9",
    "-1e300",
    "1e999",
    "9999999999",
    "18446744073709551615",
    "4294967295",
    "nan",
    "null",
    "[]",
    "{}",
    "\"\"",
    "[[[[]]]]",
    "true",
    "\u{1F600}",
    ",",
    "}",
    "]",
    "\"",
];

fn ours(file: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// Ours, and those of other programs that are at hand.
fn files(own: &[&str], others: &[&str]) -> Vec<Vec<u8>> {
    let others = others.iter().filter_map(|file| std::fs::read(asset(file)?).ok());
    own.iter().map(|file| ours(file)).chain(others).collect()
}

pub(crate) fn shots() -> Kind {
    let sound =
        ["scenes/teapot/shot.toml", "scenes/teapot/bulge.toml", "scenes/hare/shot.toml", "tests/shots/knight.toml"];
    Kind { name: "shots", ending: "toml", sound: files(&sound, &[]), words: NUMBERS, cases: 3000, read: read_shot }
}

pub(crate) fn lattices() -> Kind {
    Kind {
        name: "lattices",
        ending: "json",
        sound: files(&["tests/fuzz/sound/lattice.json"], &[]),
        words: NUMBERS,
        cases: 3000,
        read: read_lattice,
    }
}

pub(crate) fn pairs_as_csv() -> Kind {
    let sound = files(&["tests/fuzz/sound/pairs.csv"], &[]);
    Kind { name: "pairs as CSV", ending: "csv", sound, words: NUMBERS, cases: 3000, read: read_pairs }
}

pub(crate) fn pairs_as_json() -> Kind {
    Kind {
        name: "pairs as JSON",
        ending: "json",
        sound: files(&["tests/fuzz/sound/pairs.json"], &[]),
        words: NUMBERS,
        cases: 3000,
        read: read_pairs,
    }
}

pub(crate) fn problems() -> Kind {
    let sound = files(&["tests/fuzz/sound/problem.json", "tests/fuzz/sound/problem_3d.json"], &[]);
    Kind { name: "problems", ending: "json", sound, words: NUMBERS, cases: 2000, read: read_problem }
}

pub(crate) fn figures() -> Kind {
    let sound = files(&["scenes/figures/girl.json"], &[]);
    Kind { name: "figures", ending: "json", sound, words: NUMBERS, cases: 1000, read: read_figures }
}

pub(crate) fn exr_files() -> Kind {
    let own = ["plate.stmap", "teapot.cryptomatte", "teapot.half"].map(|name| format!("tests/golden/{name}.exr"));
    let others = ["openexr-images/DisplayWindow/t01.exr", "openexr-images/DisplayWindow/t16.exr"];
    let sound = files(&own.each_ref().map(String::as_str), &others);
    Kind { name: "EXR files", ending: "exr", sound, words: &[], cases: 3000, read: read_image }
}

/// Large: several parts, views, windows of all kinds.
pub(crate) fn real_exr_files() -> Kind {
    let others = ["Beachball/multipart.0001.exr", "Beachball/singlepart.0001.exr", "ScanLines/CandleGlass.exr"];
    let sound = files(&[], &others.map(|name| format!("openexr-images/{name}")).each_ref().map(String::as_str));
    Kind { name: "real EXR files", ending: "exr", sound, words: &[], cases: 60, read: read_image }
}

pub(crate) fn png_files() -> Kind {
    let sound = files(&["scenes/flag/pole.png", "scenes/flag/flag.png", "scenes/cat/cat.png"], &[]);
    Kind { name: "PNG files", ending: "png", sound, words: &[], cases: 1000, read: read_image }
}

pub(crate) fn jpeg_files() -> Kind {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flag.jpg");
    let flag = read_any(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/flag/pole.png")).expect("a sound picture");
    pinwarp::image::write_any(&path, &flag).expect("written");
    let sound = vec![std::fs::read(&path).expect("written")];
    Kind { name: "JPEG files", ending: "jpg", sound, words: &[], cases: 1000, read: read_image }
}

pub(crate) fn glb_files() -> Kind {
    let samples = ["AnimatedMorphCube", "BoxAnimated", "BoxVertexColors", "Fox"];
    let others = samples.map(|name| format!("gltf-samples/{name}.glb"));
    let sound = files(&["scenes/teapot/teapot.glb"], &others.each_ref().map(String::as_str));
    Kind { name: "GLB files", ending: "glb", sound, words: &[], cases: 2000, read: read_scene }
}

pub(crate) fn gltf_files() -> Kind {
    let samples = ["Cameras", "SimpleMorph", "SimpleSkin", "SimpleSparseAccessor"];
    let others = samples.map(|name| format!("gltf-samples/{name}.gltf"));
    let sound = files(&["tests/fuzz/sound/triangle.gltf"], &others.each_ref().map(String::as_str));
    Kind { name: "glTF files", ending: "gltf", sound, words: NUMBERS, cases: 3000, read: read_scene }
}
