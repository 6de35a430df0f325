//! What a scene will hold once its images are decoded and its meshes posed: asked of the memory budget before either is done.
//!
//! In: the file's JSON, its instances, pixels of its images. Out: leave to go on, or [`SceneError::TooLarge`].

use super::SceneError;
use super::accessor::MAX_ZEROS;
use super::file::File;
use super::instances::Instances;
use crate::memory;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index};

/// Bytes of a pixel of an image: as RGBA8, as it is decoded, and in the smaller levels of the raster.
const PIXEL: u128 = 12;

/// Bytes of a vertex as the scene stores it, without morph targets.
const STORED_VERTEX: u128 = 64;

/// Bytes of a vertex of a morph target.
const TARGET_VERTEX: u128 = 36;

/// Bytes of a vertex of each node that shows it: posed at three moments, on the screen, and drawn.
const POSED_VERTEX: u128 = 250;

/// Bytes of a corner of a triangle.
const CORNER: u128 = 8;

/// Bytes of a node: as JSON, in the scene, posed, with its name.
const NODE: u128 = 1024;

/// Asks for what the file needs; `instances` are nodes that are not in the file yet, `pixels` those of all images.
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

/// What a mesh holds.
struct MeshSize {
    vertices: u128,
    corners: u128,
    /// Bytes of its vertices with their morph targets.
    stored: u128,
}

fn size(file: &File, primitives: &[Primitive]) -> MeshSize {
    // An element that is stored takes a byte at least: who reads an accessor says where it asks for more than there is.
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
        // Flat triangles share no vertices.
        let vertices = if attribute(Semantic::Normals).is_some() { positions } else { positions.max(corners) };
        let targets = primitive.targets.as_ref().map_or(0, Vec::len) as u128;
        size.vertices += vertices;
        size.corners += corners;
        size.stored += vertices * (STORED_VERTEX + targets * TARGET_VERTEX);
    }
    size
}
