//! Which files a scene may make the program read.

use super::build::{Doc, write};
use pinwarp::scene::{FileAccess, SceneError, load, load_with, pack};
use serde_json::json;
use std::path::{Path, PathBuf};

/// A scene in `folder/inner` whose buffer is at `uri`; a good buffer lies at `folder/outside.bin` and `inner/inside.bin`.
fn scene_with_buffer(folder: &Path, uri: &str) -> PathBuf {
    let doc = Doc::triangle();
    let inner = folder.join("inner");
    std::fs::create_dir_all(inner.join("deep")).unwrap();
    write(folder, "outside.bin", &doc.bytes);
    write(&inner, "inside.bin", &doc.bytes);
    let mut json = doc.json.clone();
    json["buffers"] = json!([{ "byteLength": doc.bytes.len(), "uri": uri }]);
    write(&inner, "a.gltf", json.to_string().as_bytes())
}

fn check_outside(path: &Path) {
    for result in [load(path).map(|_| ()), pack(path, FileAccess::SceneFolder).map(|_| ())] {
        let error = result.unwrap_err();
        assert!(matches!(error, SceneError::Unsupported { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains("outside the folder of the scene") && text.contains("--allow-outside"), "{text}");
    }
    assert!(load_with(path, FileAccess::Anywhere).is_ok());
    assert!(pack(path, FileAccess::Anywhere).is_ok());
}

#[test]
fn uris_stay_below_the_folder_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    for uri in ["inside.bin", "./inside.bin", "deep/../inside.bin", "../inner/inside.bin"] {
        assert!(load(&scene_with_buffer(folder.path(), uri)).is_ok(), "{uri}");
    }
    let absolute = folder.path().join("outside.bin").display().to_string();
    for uri in
        ["../outside.bin", "deep/../../outside.bin", "%2e%2e/outside.bin", &absolute, &format!("file://{absolute}")]
    {
        check_outside(&scene_with_buffer(folder.path(), uri));
    }
}

#[cfg(unix)]
#[test]
fn links_that_lead_outside_count_as_outside() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_with_buffer(folder.path(), "link.bin");
    std::os::unix::fs::symlink("../outside.bin", folder.path().join("inner/link.bin")).unwrap();
    check_outside(&scene);
    let scene = scene_with_buffer(folder.path(), "up/outside.bin");
    std::os::unix::fs::symlink("..", folder.path().join("inner/up")).unwrap();
    check_outside(&scene);
    let scene = scene_with_buffer(folder.path(), "good.bin");
    std::os::unix::fs::symlink("inside.bin", folder.path().join("inner/good.bin")).unwrap();
    assert!(load(&scene).is_ok());
}

#[test]
fn images_from_outside_are_left_out_with_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    image::RgbImage::new(1, 1).save(folder.path().join("a.png")).unwrap();
    let mut doc = Doc::square();
    doc.attribute("TEXCOORD_0", "VEC2", &[0.0; 8]);
    doc.json["images"] = json!([{ "uri": "../a.png" }]);
    doc.json["textures"] = json!([{ "source": 0 }]);
    doc.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    doc.primitive()["material"] = json!(0);
    let path = write(&inner, "a.gltf", doc.with_data_uri().to_string().as_bytes());
    let scene = load(&path).unwrap();
    assert!(scene.images.is_empty() && scene.warnings[0].contains("--allow-outside"), "{:?}", scene.warnings);
    assert_eq!(load_with(&path, FileAccess::Anywhere).unwrap().images.len(), 1);
}

#[cfg(unix)]
#[test]
fn pipes_devices_and_folders_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("inner/pipe.bin");
    let scene = scene_with_buffer(folder.path(), "pipe.bin");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let error = load(&scene).unwrap_err().to_string();
    assert!(error.contains("pipe.bin") && error.contains("not a regular file"), "{error}");
    assert!(load(&pipe).unwrap_err().to_string().contains("not a regular file"));
    let error =
        load_with(&scene_with_buffer(folder.path(), "/dev/zero"), FileAccess::Anywhere).unwrap_err().to_string();
    assert!(error.contains("not a regular file"), "{error}");
    let error = load(&scene_with_buffer(folder.path(), "deep")).unwrap_err().to_string();
    assert!(error.contains("it is a folder"), "{error}");
}
