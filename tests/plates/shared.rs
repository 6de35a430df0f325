//! Layers that share one mesh (`select`) over finished frames: a plate of the unwarped model, warped, shows what the
//! same shot renders, where the layers meet too.

use super::agreement::Pair;
use super::assets::asset;
use super::branches::{Apart, apart, check, warped_by};
use pinwarp::pipeline::PlateWarp;
use pinwarp::shot::Shot;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

/// A fox whose head is pulled up and whose tail is pulled down; the body between them does not move.
fn fox() -> Option<String> {
    let scene = asset("gltf-samples/Fox.glb")?;
    let layer = |name: &str, select: &str, [x, y]: [f64; 2], by: f64| {
        format!(
            "[[layer]]\nname = '{name}'\nselect = {{ joints = ['{select}'] }}\nlattice = {{ dims = [6, 6] }}\n\
             [[layer.pin]]\nanchor = {{ screen = [{x}, {y}], frame = 8 }}\nkeys = [{{ frame = 8, offset = [0.0, {by}] }}]\n"
        )
    };
    Some(format!(
        "version = 1\nscene = '{}'\ncamera = 'left'\nframes = {{ first = 8, last = 12, rate = 24, clip = 'Walk' }}\n\
         size = [480, 270]\nsamples = 8\nshutter = {{ angle = 0 }}\n[output]\npath = 'f.####.exr'\n\
         channels = ['beauty', 'depth', 'motion', 'id']\n{}{}[[layer]]\nname = 'body'\nnodes = 'rest'\n",
        scene.display(),
        layer("head", "b_Neck*", [1.5, 0.75], 0.1),
        layer("tail", "b_Tail01*", [0.35, 0.6], -0.08)
    ))
}

fn shot(text: &str) -> Shot {
    Shot::parse(text, Path::new("/fox.toml")).expect("a right shot")
}

/// The same with its plates.
fn fox_with_plates() -> Option<(String, &'static Pair)> {
    static PAIR: OnceLock<Pair> = OnceLock::new();
    let text = fox()?;
    let pair = PAIR.get_or_init(|| Pair::of(shot(&text)));
    Some((text, pair))
}

#[test]
fn a_plate_bends_where_layers_of_one_mesh_meet() {
    let Some((_, pair)) = fox_with_plates() else { return };
    let found = check(&pair.shot, pair);
    assert!(found.iter().all(|apart| apart.covered > 10_000), "{found:?}");
    assert!(found.iter().all(|apart| apart.holes < 250 && apart.seams < 10 && apart.off < 700), "{found:?}");
    assert!(found.iter().all(|apart| apart.vectors < apart.covered / 50), "{found:?}");
}

#[test]
fn an_stmap_bends_where_layers_of_one_mesh_meet() {
    let Some((text, pair)) = fox_with_plates() else { return };
    let (plates, expected) = (pair.still.folder(), &pair.moved.frames);
    let written = plates.path().join("shot.toml");
    std::fs::write(&written, &text).expect("written");
    let export = |words: &[&str]| {
        let shot = written.to_str().expect("UTF-8");
        let mut command = Command::new(env!("CARGO_BIN_EXE_pinwarp"));
        command.args(["export", shot, "--to", "stmap", "--frames", "8,12"]).args(words).current_dir(plates.path());
        let done = command.output().expect("it runs");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    };
    export(&["-o", "m.####.exr"]);
    let mapped = warped_by(PlateWarp::Maps(plates.path().join("m.####.exr")), plates.path());
    let found: Vec<Apart> = mapped.iter().zip(expected).map(|(plate, geometry)| apart(plate, geometry)).collect();
    println!("{found:?}");
    assert!(found.iter().all(|apart| apart.holes < 250 && apart.seams < 10 && apart.off < 700), "{found:?}");
    // The map of one layer alone cannot know the others.
    export(&["-o", "h.####.exr", "--layer", "head"]);
    let alone = warped_by(PlateWarp::Maps(plates.path().join("h.####.exr")), plates.path());
    let alone = apart(&alone[0], &expected[0]);
    assert!(alone.holes + alone.off > 1500, "another map is found: {alone:?}");
}

#[test]
fn the_inverse_map_brings_surfaces_back() {
    let Some((text, pair)) = fox_with_plates() else { return };
    let plates = pair.moved.folder();
    let written = plates.path().join("shot.toml");
    std::fs::write(&written, &text).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_pinwarp"));
    let words = ["export", "shot.toml", "--to", "stmap", "--inverse", "--frames", "8,12", "-o", "i.####.exr"];
    let done = command.args(words).current_dir(plates.path()).output().expect("it runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let back = warped_by(PlateWarp::Maps(plates.path().join("i.####.exr")), plates.path());
    let expected = &pair.still.frames;
    let found = apart(&back[0], &expected[0]);
    println!("{found:?}");
    assert!(found.holes < 700 && found.off < 900, "{found:?}");
    let unmapped = apart(&pair.moved.frames[0], &expected[0]);
    assert!(unmapped.holes + unmapped.off > 2000, "the warp moves pixels: {unmapped:?}");
}
