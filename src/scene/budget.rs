//! Estimates the memory of a scene, and checks it against the budget before images are decoded and meshes posed.
//!
//! In: the file's JSON, its instances, the pixels of its images. Out: permission to continue, or
//! [`SceneError::TooLarge`].

use super::SceneError;
use super::accessor::MAX_ZEROS;
use super::file::File;
use super::instances::Instances;
use crate::memory;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index};

/// Bytes per pixel of an image: as RGBA8, during decoding, and in the rasteriser's mipmaps.
const PIXEL: u128 = 12;

/// Bytes per stored vertex, without morph targets.
const STORED_VERTEX: u128 = 64;

/// Bytes per vertex of a morph target.
const TARGET_VERTEX: u128 = 36;

/// Bytes per vertex for each node that shows it: posed at three times, projected, and drawn.
const POSED_VERTEX: u128 = 250;

/// Bytes per triangle corner.
const CORNER: u128 = 8;

/// Bytes per node: as JSON, in the scene, posed, with its name.
const NODE: u128 = 1024;

/// Checks the file's memory; `instances`: nodes that are not in the file yet, `pixels`: those of all images.
pub(super) fn check(file: &File, instances: &[Instances], pixels: u128) -> Result<(), SceneError> {
    let meshes: Vec<MeshSize> = file.root.meshes.iter().map(|mesh| size(file, &mesh.primitives)).collect();
    let shown = |mesh: usize| meshes.get(mesh).map_or(0, |mesh| mesh.vertices * POSED_VERTEX + mesh.corners * CORNER);
    let stored: u128 = meshes.iter().map(|mesh| mesh.stored + mesh.corners * CORNER).sum();
    let of_nodes = file.root.nodes.iter().filter_map(|node| node.mesh).map(|mesh| NODE + shown(mesh.value()));
    let of_instances = instances.iter().map(|one| {
        let mesh = file.root.nodes[one.node()].mesh;
        one.count() as u128 * (NODE + mesh.map_or(0, |mesh| shown(mesh.value())))
    });
    let buffers: u128 = file.buffers().iter().map(|buffer| buffer.len() as u128).sum();
    let needed = buffers + stored + of_nodes.sum::<u128>() + of_instances.sum::<u128>() + pixels * PIXEL;
    memory::check(needed).map_err(|source| {
        let vertices: u128 = meshes.iter().map(|mesh| mesh.vertices).sum();
        let instances: usize = instances.iter().map(Instances::count).sum();
        let nodes = file.root.nodes.len() + instances;
        let what = format!("{vertices} vertices, {nodes} nodes, {:.1} million pixels of textures", pixels as f64 / 1e6);
        file.too_large(what, source)
    })
}

/// The size of a mesh.
struct MeshSize {
    vertices: u128,
    corners: u128,
    /// Bytes of its vertices with their morph targets.
    stored: u128,
}

fn size(file: &File, primitives: &[Primitive]) -> MeshSize {
    // A stored element takes at least one byte, so the buffers bound the count; the accessor's reader reports the
    // error.
    let buffered: u128 = file.buffers().iter().map(|buffer| buffer.len() as u128).sum();
    let count = |index: Index<Accessor>| {
        let count = |accessor: &Accessor| u128::from(accessor.count.0);
        let most = |accessor: &Accessor| if accessor.buffer_view.is_some() { buffered } else { MAX_ZEROS.into() };
        file.root.get(index).map_or(0, |accessor| count(accessor).min(most(accessor)))
    };
    let mut size = MeshSize { vertices: 0, corners: 0, stored: 0 };
    for primitive in primitives {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let positions = attribute(Semantic::Positions).map_or(0, count);
        let corners = primitive.indices.map_or(positions, count);
        // Triangles with flat normals share no vertices.
        let vertices = if attribute(Semantic::Normals).is_some() { positions } else { positions.max(corners) };
        let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u128;
        size.vertices += vertices;
        size.corners += corners;
        size.stored += vertices * (STORED_VERTEX + targets * TARGET_VERTEX);
    }
    size
}
