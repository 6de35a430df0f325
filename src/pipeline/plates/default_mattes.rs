//! Finds mattes for layers over a scene that name none, so that each moves its own nodes as in a render.
//!
//! In: a [`PreparedShot`] and a plate. Out: one matte per layer, from a Cryptomatte of the plate that contains the
//! nodes, or else rendered from the scene at rest.

use super::at_rest::SceneAtRest;
use crate::image::Plate;
use crate::image::cryptomatte::clean_name;
use crate::pipeline::{LayerAssignment, PipelineError, PreparedShot};
use crate::plate::{Matte, WarpSettings, mattes_of_names};
use crate::raster::{DeviceChoice, MATTE_LAYERS};
use crate::shot::{LayerSpace, Source, Unmatted};
use crate::solve::Topology;
use std::collections::{BTreeMap, BTreeSet};

/// Finds the mattes of layers that name none.
pub(super) struct DefaultMattes<'a> {
    prepared: &'a PreparedShot,
    /// Indices of the layers.
    layers: Vec<usize>,
    /// The node names of each layer; `None` if several layers share a name, so that no Cryptomatte can separate them.
    names: Option<Vec<Vec<String>>>,
    device: &'a DeviceChoice,
    /// Opened for the first plate that needs it.
    scene: Option<SceneAtRest<'a>>,
}

/// The mattes of one plate.
#[derive(Debug, Default)]
pub(super) struct FoundMattes {
    /// Mattes by layer.
    pub(super) mattes: BTreeMap<usize, Matte>,
    /// Description of their source.
    pub(super) source: String,
}

impl PreparedShot {
    /// Whether a layer without a matte of its own takes its nodes out of a plate: the layer is moved, and the shot has
    /// a scene with parts that the layer does not move, or asks for it. A branching layer always does, because it would tear
    /// its surroundings.
    pub(crate) fn moves_own_nodes(&self, layer: usize) -> bool {
        let settings = &self.shot.layers[layer];
        settings.is_moved()
            && matches!(self.shot.source, Source::Scene(_))
            && matches!(settings.space, LayerSpace::Screen { .. })
            && settings.matte.is_none()
            && settings.unmatted != Unmatted::Picture
            && (settings.unmatted == Unmatted::Nodes
                || settings.settings.topology == Topology::Branching
                || self.assignment.is_sharing[layer]
                || self.assignment.layer_of_part.iter().any(|owner| *owner != Some(layer)))
    }

    /// Whether a layer bends the whole of a plate although its shot does not ask for that.
    pub(super) fn bends_picture_unasked(&self, layer: usize) -> bool {
        let settings = &self.shot.layers[layer];
        settings.matte.is_none() && settings.unmatted == Unmatted::OwnNodes && !self.moves_own_nodes(layer)
    }

    /// Returns a note on layers that share a mesh: a plate, or the map of one layer, is cut along their border.
    pub(crate) fn note_on_shared(&self, layers: &[usize]) -> Option<String> {
        let shared: Vec<String> = layers
            .iter()
            .filter(|&&layer| self.assignment.is_sharing[layer] && self.moves_own_nodes(layer))
            .map(|&layer| format!("'{}'", self.shot.layers[layer].name))
            .collect();
        (!shared.is_empty()).then(|| {
            format!(
                "{}: each moves part of a mesh; where they meet parts that move differently the picture is cut, and a seam may open: \
                 look at the border, or warp by the STMap of all layers (`export --to stmap`), which blends them as `render` does",
                shared.join(", ")
            )
        })
    }

    /// Returns the names of the nodes that a layer moves.
    fn node_names(&self, layer: Option<usize>) -> BTreeSet<String> {
        let LayerAssignment { node_of_part, layer_of_part, shared_parts, .. } = &self.assignment;
        // A shared part belongs to several layers, so its name does not identify one.
        let is_own = |part: &usize| layer_of_part[*part] == layer || shared_parts[*part].is_some();
        let nodes = (0..node_of_part.len()).filter(is_own).map(|part| node_of_part[part]);
        nodes.map(|node| clean_name(&self.scene.nodes[node].name)).collect()
    }
}

impl<'a> DefaultMattes<'a> {
    /// Creates the finder; `None` if no layer needs a matte.
    pub(super) fn of(prepared: &'a PreparedShot, device: &'a DeviceChoice, layers: &[usize]) -> Option<Self> {
        let layers: Vec<usize> = layers.iter().copied().filter(|&layer| prepared.moves_own_nodes(layer)).collect();
        let everyone = (0..prepared.shot.layers.len()).map(Some).chain([None]);
        let mut seen = BTreeSet::new();
        let is_unique = everyone.flat_map(|owner| prepared.node_names(owner)).all(|name| seen.insert(name));
        let names = || layers.iter().map(|&layer| prepared.node_names(Some(layer)).into_iter().collect()).collect();
        let names = is_unique.then(names);
        (!layers.is_empty()).then_some(Self { prepared, layers, names, device, scene: None })
    }

    /// Returns the mattes for a frame's plate.
    pub(super) fn at(
        &mut self,
        frame: i32,
        (plate, settings): (&Plate, &WarpSettings),
    ) -> Result<FoundMattes, PipelineError> {
        let known = self.names.as_ref().and_then(|names| mattes_of_names(plate, names, settings));
        let (mattes, source) = match known {
            Some(mattes) => {
                let source = match mattes.first() {
                    Some(Matte::Cryptomatte { layer: Some(name), .. }) => format!("{name} of the plate"),
                    _ => String::new(),
                };
                (mattes, source)
            }
            None => (self.drawn(frame, plate)?, "the scene, drawn at rest".to_owned()),
        };
        Ok(FoundMattes { mattes: self.layers.iter().copied().zip(mattes).collect(), source })
    }

    /// Renders the coverage of each layer in the frame, with the samples and the shutter of a render.
    fn drawn(&mut self, frame: i32, plate: &Plate) -> Result<Vec<Matte>, PipelineError> {
        let scene = self
            .scene
            .get_or_insert_with(|| SceneAtRest::new(self.prepared, self.device, Vec::new()).with_numbered_layers());
        let names: Vec<_> = self.layers.iter().map(|&layer| vec![SceneAtRest::number_of(layer)]).collect();
        let [_, _, of_layers] = MATTE_LAYERS;
        scene.mattes(frame, plate, (of_layers, &names))
    }
}
