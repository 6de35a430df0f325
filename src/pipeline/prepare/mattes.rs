//! Ids and names by which the parts of a scene are distinguished: layer and node ids, and Cryptomatte names.
//!
//! In: scene, parts, layer assignment, layers. Out: [`Mattes`]: the submeshes of every part, and manifests for the files.

use super::selection::{SharedPart, material_name};
use crate::image::cryptomatte::{Manifest, MatteHeader, MatteId, clean_name};
use crate::pipeline::LayerAssignment;
use crate::pose::PosedPart;
use crate::raster::MATTE_LAYERS;
use crate::raster::geometry::Submesh;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::Shot;

/// Name in `CryptoLayer` of everything that belongs to no layer, as in Arnold for objects without an asset.
const NO_LAYER: &str = "default";

/// The submeshes of all parts, and the Cryptomatte headers of the files.
#[derive(Clone, Debug, Default)]
pub(in crate::pipeline) struct Mattes {
    /// #parts: the whole part as one submesh, or its triangles grouped by the layer that moves most of each.
    pub(in crate::pipeline) submeshes: Vec<Vec<Submesh>>,
    /// One header per Cryptomatte, with its manifest.
    pub(in crate::pipeline) headers: Vec<MatteHeader>,
}

impl Mattes {
    /// Creates submeshes and headers. The names do not depend on the frame, so every frame of a sequence has the same manifest.
    pub(in crate::pipeline) fn new(
        shot: &Shot,
        scene: &Scene,
        (parts, assignment): (&[PosedPart], &LayerAssignment),
    ) -> Self {
        let mut all_names = Vec::new();
        let mut submesh = |part: &PosedPart, owner: Option<usize>, triangles: Option<Vec<u32>>| {
            let names = names(shot, scene, (part, owner));
            let mattes = names.each_ref().map(|name| MatteId::of_name(name));
            all_names.push(names);
            Submesh { triangles, layer_id: owner.map_or(0, |layer| layer as u32 + 1), mattes }
        };
        let of_part = |(index, part): (usize, &PosedPart)| match &assignment.shared_parts[index] {
            None => vec![submesh(part, assignment.layer_of_part[index], None)],
            Some(shared) => {
                owned(shared).into_iter().map(|(owner, triangles)| submesh(part, owner, Some(triangles))).collect()
            }
        };
        let submeshes = parts.iter().enumerate().map(of_part).collect();
        let headers = MATTE_LAYERS.iter().enumerate().map(|(place, layer)| MatteHeader {
            name: (*layer).to_owned(),
            manifest: Manifest::of_names(all_names.iter().map(|names| names[place].as_str())),
            side_file: None,
        });
        Self { submeshes, headers: headers.collect() }
    }
}

/// Returns the names of a submesh, in the order of [`MATTE_LAYERS`].
fn names(shot: &Shot, scene: &Scene, (part, owner): (&PosedPart, Option<usize>)) -> [String; MATTE_LAYERS.len()] {
    let layer = owner.map_or(NO_LAYER, |layer| &shot.layers[layer].name);
    let node = &scene.nodes[part.node].name;
    let material = material_name(scene, primitive(scene, part).material);
    [clean_name(node), clean_name(&material), clean_name(layer)]
}

/// Returns the triangles of a shared part, grouped by the layer that moves most of each.
fn owned(shared: &SharedPart) -> Vec<(Option<usize>, Vec<u32>)> {
    let layers = std::iter::once(None).chain(shared.layers.iter().copied().map(Some));
    let of_owner = |owner: Option<usize>| {
        let triangles = (0..).zip(&shared.layer_of_triangle).filter(move |(_, other)| **other == owner);
        (owner, triangles.map(|(number, _)| number).collect::<Vec<u32>>())
    };
    layers.map(of_owner).filter(|(_, triangles)| !triangles.is_empty()).collect()
}
