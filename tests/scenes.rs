//! The scenes that come with the program: code makes the same files as are stored, and they can be shot.

#[path = "../scenes/make/mod.rs"]
mod make;

use std::path::{Path, PathBuf};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

#[test]
fn code_makes_the_stored_files() {
    for (name, bytes) in make::files().expect("textures are drawn") {
        let stored = std::fs::read(scenes().join(name)).unwrap_or_default();
        assert!(stored == bytes, "scenes/{name} differs from what code makes: run `cargo run --example make_scenes`");
        assert!(bytes.len() < 1_000_000, "scenes/{name} has {} bytes", bytes.len());
    }
}

#[test]
fn teapot_has_as_many_vertices_as_in_the_paper() {
    let teapot = make::teapot::teapot();
    assert_eq!(teapot.positions.len(), 530);
    assert_eq!(teapot.triangles.len(), 32 * 16 * 2 - 32, "32 patches of 4x4 quads, less a triangle at each pole");
    for [a, b, c] in teapot.triangles.iter().map(|corners| corners.map(|corner| corner as usize)) {
        let at = |index: usize| teapot.positions[index];
        let facing =
            (at(b) - at(a)).cross(at(c) - at(a)).dot(teapot.normals[a] + teapot.normals[b] + teapot.normals[c]);
        assert!(facing > 0.0, "triangle {a} {b} {c} faces inwards");
    }
}

#[test]
fn gingerman_is_about_as_fine_as_in_the_paper() {
    let parts = make::gingerman::parts([0, 1, 2]);
    let of = |wanted: fn(&str) -> bool| {
        parts.iter().filter(|(name, _)| wanted(name)).map(|(_, surface)| surface.positions.len()).sum::<usize>()
    };
    assert!((215..=235).contains(&of(|name| name != "Shadow")), "{}", of(|name| name != "Shadow"));
    for (name, surface) in &parts {
        for corners in &surface.triangles {
            let [a, b, c] = corners.map(|corner| surface.positions[corner as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "{name}: triangle {corners:?} is turned over");
        }
    }
}

/// The shot files of all scenes.
fn shots() -> Vec<PathBuf> {
    let folders = std::fs::read_dir(scenes()).expect("the folder exists").flatten().map(|entry| entry.path());
    let mut shots: Vec<_> = folders.map(|folder| folder.join("shot.toml")).filter(|path| path.is_file()).collect();
    shots.sort();
    shots
}

#[test]
fn every_shot_is_read_and_has_pins() {
    assert!(shots().len() >= 2, "{:?}", shots());
    for path in shots() {
        let shot = pinwarp::shot::Shot::read(&path).unwrap_or_else(|error| panic!("{error}"));
        assert!(shot.scene.is_file(), "{} is missing", shot.scene.display());
        assert!(path.with_file_name("LICENSE.txt").is_file(), "{} has no licence", path.display());
        assert!(shot.layers.iter().all(|layer| !layer.pins.is_empty()), "{}", path.display());
    }
}
