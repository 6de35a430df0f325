//! Foreign files: the Khronos samples and a game character. Skipped, and said so, where they are not at hand.

#[path = "../support/shared.rs"]
mod shared;

use glam::Vec3;
use pinwarp::pose::{ClipChoice, Pose, pose};
use pinwarp::scene::{Lens, Scene, load};
use std::path::{Path, PathBuf};

/// A foreign file; tests that need it are skipped without it.
pub(crate) fn shared(file: &str) -> Option<PathBuf> {
    shared::shared(&format!("assets/{file}"))
}

fn load_good(path: &Path) -> Scene {
    load(path).unwrap_or_else(|error| panic!("{error}"))
}

fn check_pose(posed: &Pose) {
    for part in &posed.parts {
        assert_eq!(part.positions.len(), part.normals.len());
        assert!(part.positions.iter().all(|at| at.0.is_finite()));
        assert!(part.normals.iter().all(|normal| (normal.0.length() - 1.0).abs() < 1e-4));
    }
}

#[test]
fn the_knight_loads_and_poses() {
    let Some(path) = shared("kaykit/Knight.glb") else { return };
    let scene = load_good(&path);
    assert_eq!((scene.nodes.len(), scene.meshes.len(), scene.clips.len()), (57, 15, 76));
    assert_eq!((scene.images.len(), scene.textures.len(), scene.skins.len()), (1, 1, 1));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let clip = scene.find_clip(Some("Walking_A"), None).unwrap();
    for seconds in [0.0, 0.3, 100.0] {
        let posed = pose(&scene, ClipChoice { clip, is_looped: true }, seconds);
        assert_eq!(posed.parts.len(), 15);
        check_pose(&posed);
        let top = posed.parts.iter().flat_map(|part| &part.positions).map(|at| at.0.y).fold(0.0, f32::max);
        assert!((1.0..4.0).contains(&top), "the knight is {top} m high");
    }
    // Numbers of an independent reading of the file: two skinned parts and one that hangs on a joint.
    let posed = pose(&scene, ClipChoice { clip, is_looped: false }, 0.4);
    check_vertex(&scene, &posed, "Knight_ArmLeft", 50, [0.563_387, 0.994_034, 0.267_854]);
    check_vertex(&scene, &posed, "Knight_ArmRight", 0, [-0.484_754, 0.738_122, 0.045_046]);
    check_vertex(&scene, &posed, "1H_Sword_Offhand", 0, [0.537_583, 0.777_466, 0.244_048]);
}

fn check_vertex(scene: &Scene, posed: &Pose, node: &str, vertex: usize, expected: [f32; 3]) {
    let node = scene.node_named(node).unwrap();
    let part = posed.parts.iter().find(|part| part.node == node).unwrap();
    let found = part.positions[vertex].0;
    let expected = Vec3::from(expected);
    assert!((found - expected).length() < 2e-6 * expected.length().max(1.0), "{found} is not {expected}");
}

fn sample(name: &str) -> Option<Scene> {
    shared(&format!("gltf-samples/{name}")).map(|path| load_good(&path))
}

const FIRST: ClipChoice = ClipChoice { clip: Some(0), is_looped: false };

#[test]
fn the_fox_runs() {
    let Some(scene) = sample("Fox.glb") else { return };
    let names: Vec<&str> = scene.clips.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["Survey", "Walk", "Run"]);
    assert!((scene.clips[2].end_secs - 1.158_333_3).abs() < 1e-6);
    let posed = pose(&scene, ClipChoice { clip: Some(2), is_looped: false }, 0.35);
    check_vertex(&scene, &posed, "fox", 0, [2.891_124, 29.401_517, -21.118_69]);
    check_vertex(&scene, &posed, "fox", 100, [-0.000_007, 26.932_218, -6.170_403]);
    check_vertex(&scene, &posed, "fox", 1000, [7.206_176, 39.077_829, 44.117_732]);
    let posed = pose(&scene, FIRST, 1.0);
    check_vertex(&scene, &posed, "fox", 1000, [7.033_654, 27.774_018, 23.514_628]);
    check_pose(&posed);
}

#[test]
fn the_simple_skin_bends() {
    let Some(scene) = sample("SimpleSkin.gltf") else { return };
    let posed = pose(&scene, FIRST, 1.25);
    for expected in [[0.5, 0.75, 0.0], [0.25, 1.25, 0.0], [-1.0, 0.5, 0.0], [-1.0, 1.5, 0.0]].map(Vec3::from) {
        let is_there = posed.parts[0].positions.iter().any(|at| (at.0 - expected).length() < 1e-5);
        assert!(is_there, "{expected} is missing");
    }
}

#[test]
fn the_simple_morph_moves_its_tip() {
    let Some(scene) = sample("SimpleMorph.gltf") else { return };
    assert_eq!(scene.nodes[0].weights.len(), 2);
    let posed = pose(&scene, FIRST, 0.75);
    let tip = posed.parts[0].positions.iter().map(|at| at.0).max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
    assert!((tip - Vec3::new(1.25, 1.25, 0.0)).length() < 1e-6, "{tip}");
}

#[test]
fn the_sparse_sample_lifts_three_vertices() {
    let Some(scene) = sample("SimpleSparseAccessor.gltf") else { return };
    let positions = &scene.meshes[0].primitives[0].positions;
    for expected in [[1.0, 2.0, 0.0], [3.0, 3.0, 0.0], [5.0, 4.0, 0.0], [2.0, 1.0, 0.0]].map(Vec3::from) {
        assert!(positions.contains(&expected), "{expected} is missing");
    }
    assert!(!positions.contains(&Vec3::new(1.0, 1.0, 0.0)), "this one was replaced");
}

#[test]
fn the_box_rises() {
    let Some(scene) = sample("BoxAnimated.glb") else { return };
    let posed = pose(&scene, FIRST, 1.0);
    let heights: Vec<f32> = posed.scene_from_node.iter().map(|matrix| matrix.w_axis.y).collect();
    assert_eq!(scene.nodes.len(), 4);
    assert_eq!(scene.nodes[0].name, "node_3");
    assert!(heights[0] == 0.0 && heights[1..].iter().all(|y| (y - 2.016).abs() < 1e-5), "{heights:?}");
    assert_eq!(posed.parts.len(), 2);
}

#[test]
fn the_morph_cube_changes() {
    let Some(scene) = sample("AnimatedMorphCube.glb") else { return };
    let posed = pose(&scene, FIRST, 1.0);
    let name = scene.nodes[0].name.clone();
    check_vertex(&scene, &posed, &name, 5, [0.999_999, 1.0, -0.294_215]);
    check_vertex(&scene, &posed, &name, 11, [1.0, 1.0, -1.0]);
    check_pose(&posed);
}

#[test]
fn the_cameras_are_read() {
    let Some(scene) = sample("Cameras.gltf") else { return };
    assert_eq!(scene.cameras[0].lens, Lens::Perspective { yfov: 0.7 });
    assert_eq!(scene.cameras[1].lens, Lens::Orthographic { ymag: 1.0 });
    assert_eq!(scene.find_camera(None), Ok(1));
    assert_eq!(scene.find_camera(Some("node_2")), Ok(2));
}

#[test]
fn the_coloured_box_keeps_its_colours() {
    let Some(scene) = sample("BoxVertexColors.glb") else { return };
    let colors = &scene.meshes[0].primitives[0].colors;
    assert!((colors[2] - glam::Vec4::new(0.803_893, 0.803_869, 0.803_883, 1.0)).length() < 1e-5);
}
