//! The kinds of files that are read: sound ones to start from, and their readers.

use crate::assets::asset;
use pinwarp::export::{Landmarks, LatticeFile, Track, lattice_at};
use pinwarp::image::{is_complete, picture_size, read_any, read_any_head, read_metadata};
use pinwarp::plate::map_of_stmap;
use pinwarp::pose::{ClipChoice, pose};
use pinwarp::shot::Shot;
use pinwarp::solve::problem_file::{read_figure, run_file};
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
    let read = |path: &Path| {
        let Ok(shot) = Shot::read(path) else { return false };
        for (layer, frame) in (0..shot.layers.len()).flat_map(|layer| [-1e6, 0.5, 12.0].map(|frame| (layer, frame))) {
            let _ = shot.pin_targets(layer, frame);
        }
        true
    };
    Kind { name: "shots", ending: "toml", sound: files(&sound, &[]), words: NUMBERS, cases: 3000, read }
}

const LATTICES: &str = r#"{ "pinwarp_lattice": 1, "frame_aspect": 1.5, "rate": 24, "layers": [
  { "name": "body", "space": "screen", "dims": [4, 4], "basis": "bspline", "frames": [
    { "frame": 1, "box": [[0, 0], [1, 1]], "handles": [[-1,-1],[0,-1],[1,-1],[2,-1],[-1,0],[0,0],[1,0],[2,0],
      [-1,1],[0,1],[1,1],[2,1],[-1,2],[0,2],[1,2],[2,2.5]] },
    { "frame": 5, "box": [[0, 0], [1, 2]], "handles": [[-1,-1],[0,-1],[1,-1],[2,-1],[-1,0],[0,0],[1,0],[2,0],
      [-1,1],[0,1],[1,1],[2,1],[-1,2],[0,2],[1,2],[2,2.5]] } ] },
  { "name": "room", "space": "world", "dims": [2, 2, 2], "basis": "bernstein", "frames": [
    { "frame": 1, "box": [[0, 0, 0], [1, 1, 1]], "placement": [[1,0,0],[0,1,0],[0,0,1],[5,6,7]],
      "handles": [[0,0,0],[1,0,0],[0,1,0],[1,1,0],[0,0,1],[1,0,1],[0,1,1],[1,1,1.5]] } ] } ] }"#;

pub(crate) fn lattices() -> Kind {
    let read = |path: &Path| {
        let Ok(file) = LatticeFile::read(path) else { return false };
        for layer in &file.layers {
            match &layer.track {
                Track::Screen(lattices) => _ = lattice_at(lattices, 2.5).deform([0.3, 9.0]),
                Track::World(lattices) => _ = lattice_at(lattices, 2.5).deform([0.3, 9.0, -4.0]),
            }
        }
        true
    };
    Kind { name: "lattices", ending: "json", sound: vec![LATTICES.into()], words: NUMBERS, cases: 3000, read }
}

pub(crate) fn pairs_as_csv() -> Kind {
    let sound = "# by hand\nname,ax,ay,bx,by\nnose, 1, 2.5, 3, 4\n\n5;6;7;8\n\"an ear\",1e2,2,3,4\n".into();
    Kind { name: "pairs as CSV", ending: "csv", sound: vec![sound], words: NUMBERS, cases: 3000, read: read_pairs }
}

pub(crate) fn pairs_as_json() -> Kind {
    let sound = r#"{ "unit": "frame", "pairs": [ { "name": "nose", "a": [1, 2.5], "b": [3, 4] }, { "a": [5, 6], "b": [7, 8] } ] }"#;
    Kind {
        name: "pairs as JSON",
        ending: "json",
        sound: vec![sound.into()],
        words: NUMBERS,
        cases: 3000,
        read: read_pairs,
    }
}

fn read_pairs(path: &Path) -> bool {
    Landmarks::read(path).is_ok_and(|landmarks| {
        let numbers = landmarks.pairs.iter().flat_map(|pair| pair.a.into_iter().chain(pair.b));
        assert!(numbers.into_iter().all(f64::is_finite));
        true
    })
}

const PROBLEM: &str = r#"{ "dims": [4, 4], "bbox": [[0, 0], [1, 1]], "triangles": [[0, 1, 2], [0, 2, 3]], "strokes": [[0, 2]],
  "vertices": [[0, 0], [1, 0], [1, 1], [0, 1]], "basis": "bspline", "form": "edge", "weights": "cot", "regulariser": "gr",
  "lambdas": { "ml": 1, "mp": 100 }, "iterations": 5, "pins": [ { "vertex": 2, "target": [1.5, 1.0] },
  { "triangle": 0, "bary": [0.5, 0.25, 0.25], "target": [0, 0] } ], "handles": [ { "index": 3, "target": [2, 2] } ] }"#;
const SPACE: &str = r#"{ "dims": [3, 3, 3], "triangles": [[0, 1, 2]], "vertices": [[0, 0, 0], [1, 0, 0], [1, 1, 1]],
  "basis": "bernstein", "samples": [[0.1, 0.1, 0.1, 1]], "pins": [{ "point": [1, 0, 0], "target": [1, 0, 0.5] }] }"#;

pub(crate) fn problems() -> Kind {
    let read = |path: &Path| {
        let Ok(result) = run_file(path) else { return false };
        assert!(result.handles.iter().chain(&result.vertices).flatten().all(|x| x.is_finite()), "no finite lattice");
        true
    };
    let sound = vec![PROBLEM.into(), SPACE.into()];
    Kind { name: "problems", ending: "json", sound, words: NUMBERS, cases: 2000, read }
}

pub(crate) fn figures() -> Kind {
    let (sound, read) = (files(&["scenes/figures/girl.json"], &[]), |path: &Path| read_figure(path).is_ok());
    Kind { name: "figures", ending: "json", sound, words: NUMBERS, cases: 1000, read }
}

/// Everything that is done with a picture before it is warped.
fn read_image(path: &Path) -> bool {
    let _ = (picture_size(path), read_any_head(path), read_metadata(path), is_complete(path));
    let Ok(plate) = read_any(path) else { return false };
    let _ = map_of_stmap(&plate);
    true
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

fn read_scene(path: &Path) -> bool {
    let Ok(scene) = pinwarp::scene::load(path) else { return false };
    for clip in [None, Some(0)] {
        let _ = pose(&scene, ClipChoice { clip, is_looped: true }, 0.3);
    }
    true
}

pub(crate) fn glb_files() -> Kind {
    let samples = ["AnimatedMorphCube", "BoxAnimated", "BoxVertexColors", "Fox"];
    let others = samples.map(|name| format!("gltf-samples/{name}.glb"));
    let sound = files(&["scenes/teapot/teapot.glb"], &others.each_ref().map(String::as_str));
    Kind { name: "GLB files", ending: "glb", sound, words: &[], cases: 2000, read: read_scene }
}

const TRIANGLE: &str = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 4 }] }], "accessors": [{ "bufferView": 0, "type": "VEC3",
  "componentType": 5126, "count": 3, "byteOffset": 0 }], "bufferViews": [{ "buffer": 0, "byteOffset": 0, "byteLength": 36 }],
  "buffers": [{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }] }"#;

pub(crate) fn gltf_files() -> Kind {
    let samples = ["Cameras", "SimpleMorph", "SimpleSkin", "SimpleSparseAccessor"];
    let others = samples.map(|name| format!("gltf-samples/{name}.gltf"));
    let mut sound = files(&[], &others.each_ref().map(String::as_str));
    sound.push(TRIANGLE.into());
    Kind { name: "glTF files", ending: "gltf", sound, words: NUMBERS, cases: 3000, read: read_scene }
}
