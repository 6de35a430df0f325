//! Loads a scene: reads the file and combines the results of the other modules.
//!
//! In: the path of a .gltf or .glb file. Out: a [`Scene`] with everything resolved, or an error that says what is wrong
//! and where; ignored content becomes a warning in the scene.

use super::file::File;
use super::nodes::References;
use super::{
    FileAccess, Mesh, Primitive, Scene, SceneError, access, animation, budget, instances, json, materials, mesh, nodes,
    skin,
};
use std::path::{Path, PathBuf};

/// Loads a glTF 2.0 file with all buffers and images it refers to, which must be in or below its folder.
///
/// # Errors
/// [`SceneError`] if the file or a buffer cannot be read, violates the format, or requires an unsupported extension.
///
/// ```no_run
/// let scene = pinwarp::scene::load("teapot.glb".as_ref())?;
/// println!("{} nodes, {} clips", scene.nodes.len(), scene.clips.len());
/// # Ok::<(), pinwarp::scene::SceneError>(())
/// ```
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_with(path, FileAccess::default())
}

/// Loads a scene as [`load`] does, with a choice of the files that it may refer to.
///
/// # Errors
/// As [`load`].
pub(crate) fn load_with(path: &Path, access: FileAccess) -> Result<Scene, SceneError> {
    let bytes = access::read_scene_file(path)?;
    let mut warnings = Vec::new();
    let parsed = json::parse(path, &bytes, &mut warnings)?;
    let mut file = File::resolve((path, access), parsed.root, bytes, parsed.binary)?;
    let instances = instances::read(&file, &mut warnings)?;
    budget::check(&file, &instances, 0)?;
    instances::add_nodes(&mut file.root, &instances);
    let mut scene = build(&file, &mut warnings)?;
    scene.path = path.to_owned();
    scene.files_beside = file.beside();
    let is_visible = scene.meshes.iter().flat_map(|mesh| &mesh.primitives).any(Primitive::is_visible);
    if !is_visible {
        warnings.push("the scene has no triangles and no lines: nothing of it can be seen".to_owned());
    }
    scene.warnings = warnings;
    Ok(scene)
}

/// Returns the files that buffers and images of a glTF file refer to, which [`load`] reads, too.
///
/// # Errors
/// [`SceneError`] if the file itself cannot be read.
pub(crate) fn files_beside(path: &Path) -> Result<Vec<PathBuf>, SceneError> {
    let bytes = access::read_scene_file(path)?;
    let parsed = json::parse(path, &bytes, &mut Vec::new())?;
    Ok(File::unresolved((path, FileAccess::default()), parsed.root).beside())
}

fn build(file: &File, warnings: &mut Vec<String>) -> Result<Scene, SceneError> {
    let tree = nodes::tree(file)?;
    let mut used = References::default();
    let mut nodes = nodes::load(file, &tree, &mut used)?;
    let (mut materials, textures) = materials::load(file, warnings)?;
    let loaded = mesh::load(file, &used.meshes, &mut materials, warnings)?;
    for node in &mut nodes {
        complete_weights(node, &loaded);
    }
    let mut scene = Scene {
        meshes: loaded.into_iter().map(|loaded| loaded.mesh).collect(),
        skins: skin::load(file, &tree, &used.skins)?,
        cameras: nodes::cameras(file, &used.cameras)?,
        lights: nodes::lights(file, &used.lights)?,
        materials,
        textures: textures.textures,
        images: textures.images,
        clips: animation::load(file, &tree, &mut nodes, warnings)?,
        nodes,
        file_from_scene: tree.file_from_scene,
        ..Scene::default()
    };
    skin::check_influences(file, &scene)?;
    drop_idle_skins(&mut scene);
    Ok(scene)
}

/// Sets one weight per morph target: the node's own, else the mesh's, else zero.
fn complete_weights(node: &mut super::Node, meshes: &[mesh::Loaded]) {
    let Some(loaded) = node.mesh.map(|mesh| &meshes[mesh]) else {
        node.weights.clear();
        return;
    };
    if node.weights.is_empty() {
        node.weights.clone_from(&loaded.weights);
    }
    node.weights.resize(target_count(&loaded.mesh), 0.0);
    node.weights.iter_mut().filter(|weight| !weight.is_finite()).for_each(|weight| *weight = 0.0);
}

fn target_count(mesh: &Mesh) -> usize {
    mesh.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0)
}

/// Removes the skins of meshes without joint weights, which are placed by their nodes alone.
fn drop_idle_skins(scene: &mut Scene) {
    for node in &mut scene.nodes {
        let is_skinned = |mesh: usize| scene.meshes[mesh].primitives.iter().any(|one| !one.influences.is_empty());
        node.skin = node.skin.filter(|_| node.mesh.is_some_and(is_skinned));
    }
}
