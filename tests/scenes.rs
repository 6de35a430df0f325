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
