//! Where a new layer can be inserted, so that each layer moves something.
//!
//! In: a loaded shot. Out: one [`LayerOffer`] for everything and for each node with a mesh.

use super::open_shot::OpenShot;
use crate::pipeline::PinAnchor;
use crate::pipeline::evaluate::topology::branches_over;
use crate::shot::{Layer, LayerSpace, Shot, Source};
use std::collections::{BTreeMap, BTreeSet};

/// A new layer that could be added to a shot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LayerOffer {
    /// Name of the node that it moves, with what hangs below it; `None`: everything.
    pub node: Option<String>,
    /// Whether the shot hides the node.
    pub is_hidden: bool,
    /// Its place among the layers, the last one that works; else the reason why there is none.
    pub place: Result<usize, String>,
    /// The pins that lie on what it takes from other layers: names of layer and pin. None of layers in the scene.
    pub pins: Vec<[String; 2]>,
}

impl OpenShot {
    /// Returns the layers that can be added: one for everything, then one for each node with a mesh, in scene order.
    #[must_use]
    pub(crate) fn layer_offers(&self) -> Vec<LayerOffer> {
        let layers = &self.given().layers;
        let everything = |place| LayerOffer { node: None, is_hidden: false, place, pins: Vec::new() };
        if self.given().source == Source::Frame {
            // Layers of a plate take nothing from each other.
            return vec![everything(Ok(layers.len()))];
        }
        let all: BTreeSet<usize> = (0..self.prepared().assignment.node_of_part.len()).collect();
        let below = self.parts_below();
        let none = BTreeSet::new();
        let of_node = |(name, is_hidden): (&str, bool)| {
            let parts = below.get(name).unwrap_or(&none);
            let place = if parts.is_empty() { Err(NOT_DRAWN.to_owned()) } else { self.place_of(parts) };
            let pins = place.as_ref().map_or_else(|_| Vec::new(), |&place| self.pins_on(parts, place));
            LayerOffer { node: Some(name.to_owned()), is_hidden, place, pins }
        };
        let mut known = BTreeSet::new();
        let named = self.drawn_nodes().filter(|(name, _)| known.insert(name.to_owned())).map(of_node).collect();
        [vec![everything(self.place_of(&all))], named].concat()
    }

    /// Returns whether the lattice of a new layer of a scene branches, as in a new shot.
    #[must_use]
    pub(crate) fn can_branch(&self) -> bool {
        matches!(self.given().source, Source::Scene(_)) && branches_over(&self.prepared().scene)
    }

    /// Returns the parts of the scene by the names of the nodes that they hang on or below.
    fn parts_below(&self) -> BTreeMap<&str, BTreeSet<usize>> {
        let nodes = &self.prepared().scene.nodes;
        let mut below: BTreeMap<&str, BTreeSet<usize>> = BTreeMap::new();
        for (part, &node) in self.prepared().assignment.node_of_part.iter().enumerate() {
            for node in std::iter::successors(Some(node), |&node| nodes[node].parent) {
                below.entry(&nodes[node].name).or_default().insert(part);
            }
        }
        below
    }

    /// Returns the last place of a layer that names these parts where it gets some of them and leaves some to each other layer.
    fn place_of(&self, parts: &BTreeSet<usize>) -> Result<usize, String> {
        let (shot, assignment) = (self.given(), &self.prepared().assignment);
        let emptied = |place: usize| {
            let is_emptied = |&index: &usize| assignment.parts_of_layer[index].iter().all(|part| parts.contains(part));
            (0..shot.layers.len()).filter(|&index| loses(shot, index, place)).find(is_emptied)
        };
        let gets = |place: usize| {
            let is_free = |&part: &usize| match (&assignment.shared_parts[part], assignment.layer_of_part[part]) {
                (Some(_), _) | (None, None) => true,
                (None, Some(owner)) => loses(shot, owner, place),
            };
            parts.iter().any(is_free)
        };
        let place = (0..=shot.layers.len()).rev().find(|&place| emptied(place).is_none() && gets(place));
        place.ok_or_else(|| {
            let name = emptied(shot.layers.len()).map_or("another", |index| &shot.layers[index].name);
            format!("Layer '{name}' moves nothing else: give it other nodes, or delete it first")
        })
    }

    /// Returns the pins on parts that a layer at a place takes from others.
    fn pins_on(&self, parts: &BTreeSet<usize>, place: usize) -> Vec<[String; 2]> {
        let (shot, mut found) = (self.given(), Vec::new());
        let is_on_screen = |layer: &Layer| matches!(layer.space, LayerSpace::Screen { .. });
        for (index, layer) in shot.layers.iter().enumerate().filter(|(_, layer)| is_on_screen(layer)) {
            let anchors = self.prepared().anchors_of(index).iter().zip(&layer.pins);
            let lies = |anchor: &PinAnchor| matches!(anchor, PinAnchor::Surface { part, .. } if parts.contains(part));
            let own = anchors.filter(|(anchor, _)| loses(shot, index, place) && lies(anchor));
            found.extend(own.map(|(_, pin)| [layer.name.clone(), pin.name.clone()]));
        }
        found
    }
}

/// The reason why a hidden node cannot have a layer.
const NOT_DRAWN: &str = "It is hidden: show it first";

/// Returns whether a layer loses parts to a new one at a place: one behind it, or any if it takes the rest.
fn loses(shot: &Shot, layer: usize, place: usize) -> bool {
    layer < place || shot.layers[layer].selection.is_rest
}
