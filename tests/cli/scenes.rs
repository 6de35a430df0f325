//! Damaged and strange scenes.

use crate::support::{Bench, HEAD, OUTPUT, PIN, square};
use crate::tiny::{Lens, Part, Tiny, grid};
use pinwarp::image::{Frame, read_exr};
use serde_json::json;

/// A frame whose samples are all finite.
#[track_caller]
fn finite_frame(bench: &Bench, name: &str) -> Frame {
    let frame = read_exr(&bench.path(name)).expect("the frame is readable");
    for channel in &frame.channels {
        assert!(channel.samples.iter().all(|sample| sample.is_finite()), "{} of {name} is not finite", channel.name);
    }
    frame
}

#[test]
fn missing_scene() {
    let bench = Bench::new();
    std::fs::remove_file(bench.path("tiny.gltf")).expect("it was there");
    bench.render("").says(2, &["shot.toml:3: scene: there is no file tiny.gltf", "check the path"]);
    assert!(bench.frames().is_empty());
}

#[test]
fn truncated_glb() {
    let scene = square().json().to_string();
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((scene.len() as u32 + 20).to_le_bytes());
    glb.extend((scene.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(scene.as_bytes());
    for length in [3, 11, 19, 25, glb.len() / 2, glb.len() - 1] {
        let bench = Bench::with_shot(&format!("{HEAD}{PIN}{OUTPUT}").replace("tiny.gltf", "cut.glb"));
        bench.write("cut.glb", &glb[..length]);
        bench.render("").says(2, &["cut.glb", "is not valid glTF"]);
        assert!(bench.frames().is_empty());
    }
}

#[test]
fn missing_buffer() {
    let mut scene = square().json();
    scene["buffers"][0]["uri"] = json!("gone.bin");
    Bench::with_scene(&scene).render("").says(2, &["gone.bin", "cannot read"]);
}

#[test]
fn short_buffer() {
    let mut scene = square().json();
    scene["buffers"][0]["byteLength"] = json!(100_000);
    Bench::with_scene(&scene).render("").says(2, &["tiny.gltf", "buffers[0]", "100000 bytes"]);
}

#[test]
fn index_out_of_range() {
    let mut tiny = square();
    tiny.parts[0].triangles[3] = [0, 1, 77];
    Bench::with_scene(&tiny.json()).render("").says(2, &["tiny.gltf", "77"]);
}

#[test]
fn positions_that_are_not_numbers() {
    let mut tiny = square();
    tiny.parts[0].positions[4][1] = f32::NAN;
    Bench::with_scene(&tiny.json()).render("").says(2, &["tiny.gltf", "vertex 4", "not a finite number"]);
}

#[test]
fn zero_area_triangles_are_drawn_around() {
    let mut tiny = square();
    let needle = Part { positions: vec![[0.2, 0.1, 0.1]; 3], triangles: vec![[0, 1, 2]], ..tiny.parts[0].clone() };
    tiny.parts.push(Part { name: "Point", ..needle });
    let bench = Bench::with_scene(&tiny.json());
    bench.render("").says(0, &[]);
    assert!(finite_frame(&bench, "out/f.0002.exr").data_window.area() > 100);
}

#[test]
fn a_scene_of_zero_area_only() {
    let mut tiny = square();
    tiny.parts[0].positions = vec![[0.1, 0.1, 0.0]; 9];
    let bench = Bench::with_scene(&tiny.json());
    bench.render("").says(0, &["empty"]);
    assert_eq!(finite_frame(&bench, "out/f.0002.exr").data_window.area(), 1);
    let together = HEAD.replace("name = \"all\"", "name = \"all\"\nsolve = { temporal = 0.3 }");
    let bench = Bench::with(&tiny.json(), &format!("{together}{PIN}{OUTPUT}"));
    bench.render("").says(0, &["empty"]);
}

#[test]
fn no_triangles() {
    let mut scene = square().json();
    scene["nodes"][0].as_object_mut().expect("a node").remove("mesh");
    Bench::with_scene(&scene).render("").says(2, &["shot.toml", "no triangles", "export meshes"]);
}

#[test]
fn a_required_extension_that_is_not_known() {
    let mut scene = square().json();
    scene["extensionsUsed"] = json!(["KHR_materials_unlit", "ACME_magic"]);
    scene["extensionsRequired"] = json!(["ACME_magic"]);
    Bench::with_scene(&scene).render("").says(2, &["tiny.gltf", "ACME_magic"]);
    scene.as_object_mut().expect("a scene").remove("extensionsRequired");
    Bench::with_scene(&scene).render("").says(0, &["note:", "ACME_magic", "ignored"]);
}

/// A square tunnel around the camera, open at both ends, four units wide.
fn tunnel() -> Tiny {
    let ring = |z: f32| [[-2.0, -2.0, z], [2.0, -2.0, z], [2.0, 2.0, z], [-2.0, 2.0, z]];
    let wall = |k: u32| [[k, (k + 1) % 4, 4 + k], [(k + 1) % 4, 4 + (k + 1) % 4, 4 + k]];
    let mut part = grid("Quad", [0.0, 0.0, 1.0, 1.0], 1);
    part.positions = [ring(-20.0), ring(20.0)].concat();
    part.triangles = (0..4).flat_map(wall).flat_map(|[a, b, c]| [[a, b, c], [a, c, b]]).collect();
    Tiny { lens: Lens::Perspective(1.0), ..Tiny::of(vec![part]) }
}

#[test]
fn a_camera_inside_the_mesh_cuts_it_at_the_near_plane() {
    let bench = Bench::with_scene(&tunnel().json());
    bench.render("").says(0, &[]);
    let frame = finite_frame(&bench, "out/f.0001.exr");
    let depth = &frame.channel("depth.Z").expect("a depth channel").samples;
    let near = depth.iter().copied().fold(f32::INFINITY, f32::min);
    // The walls cross the borders of the frame at 2 / tan(half the field of view) / aspect.
    assert!((0.5..4.0).contains(&near), "{near}");
    assert_eq!(frame.data_window, frame.display, "the walls reach every border of the frame");
}

#[test]
fn everything_behind_the_camera() {
    let mut tiny = square();
    tiny.lens = Lens::Perspective(1.0);
    tiny.parts[0].place = [0.0, 0.0, 9.0];
    let bench = Bench::with_scene(&tiny.json());
    bench.render("").says(0, &["warning: frame 1", "layer 'all'", "in sight", "the picture is empty"]);
    let frame = finite_frame(&bench, "out/f.0001.exr");
    assert_eq!((frame.data_window.width, frame.data_window.height), (1, 1));
    assert_eq!(frame.channel("depth.Z").expect("a depth channel").samples, [1e10]);
    let check = bench.run("check shot.toml");
    assert!(check.code == Some(0) && check.stdout.contains("in sight"), "{check:?}");
}
