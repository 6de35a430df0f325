//! Foreign files: the Khronos samples and a game character. Skipped, and said so, where they are not at hand.

use pinwarp::pose::{ClipChoice, Pose, pose};
use pinwarp::scene::{Scene, load};
use std::path::{Path, PathBuf};

/// The folder of foreign files; tests that need it are skipped without it.
pub(crate) fn shared(file: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("PINWARP_SHARED").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let path = folder.join("assets").join(file);
    if path.exists() {
        return Some(path);
    }
    eprintln!("SKIPPED: {file} is not at hand (PINWARP_SHARED)");
    None
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
}
