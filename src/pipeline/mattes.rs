//! The names of a shot, as Cryptomattes know them.
//!
//! In: scene, parts, layer_of_part, layers. Out: [`Mattes`]: ids of every part, manifests for the files.

use crate::image::cryptomatte::{Manifest, MatteHeader, MatteId, clean_name};
use crate::pose::PosedPart;
use crate::raster::MATTE_LAYERS;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::Shot;

/// What no layer claims goes by this name in `CryptoLayer`, as Arnold calls what belongs to no asset.
const NO_LAYER: &str = "default";

/// Ids of all parts, and what files say about them.
#[derive(Clone, Debug, Default)]
pub(super) struct Mattes {
    /// One a part, in the order of [`MATTE_LAYERS`].
    pub(super) of_part: Vec<[MatteId; MATTE_LAYERS.len()]>,
    /// One a Cryptomatte, with its manifest.
    pub(super) headers: Vec<MatteHeader>,
}

impl Mattes {
    /// `layer_of_part`: one a part, the layer that moves it. The names do not depend on the frame, so every frame of a
    /// sequence has the same manifest.
    pub(super) fn new(shot: &Shot, scene: &Scene, (parts, layer_of_part): (&[PosedPart], &[Option<usize>])) -> Self {
        let names = |(part, layer): (&PosedPart, &Option<usize>)| {
            let layer = layer.map_or(NO_LAYER, |layer| &shot.layers[layer].name);
            let node = &scene.nodes[part.node].name;
            [clean_name(node), material_name(scene, primitive(scene, part).material), clean_name(layer)]
        };
        let names: Vec<[String; MATTE_LAYERS.len()]> = parts.iter().zip(layer_of_part).map(names).collect();
        let of_part = names.iter().map(|names| names.each_ref().map(|name| MatteId::of_name(name))).collect();
        let headers = MATTE_LAYERS.iter().enumerate().map(|(place, layer)| MatteHeader {
            name: (*layer).to_owned(),
            manifest: Manifest::of_names(names.iter().map(|names| names[place].as_str())),
            side_file: None,
        });
        Self { of_part, headers: headers.collect() }
    }
}

/// Materials without a name go by their number, as nodes do.
fn material_name(scene: &Scene, material: usize) -> String {
    let name = &scene.materials[material].name;
    if name.trim().is_empty() { format!("material_{material}") } else { clean_name(name) }
}
