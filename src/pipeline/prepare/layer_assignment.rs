//! Assigns the parts of the scene to layers, and finds the node that carries each layer.
//!
//! In: the layers' selections and the posed parts. Out: a [`LayerAssignment`]; unknown names and empty layers are errors.

use super::selection::{LayerShare, PartLayers, Selected, SharedPart, select};
use crate::pipeline::PipelineError;
use crate::pose::PosedPart;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{Shot, Source};
use std::collections::BTreeSet;

/// The mapping from parts to layers, which is the same in every frame.
#[derive(Clone, Debug)]
pub struct LayerAssignment {
    /// #parts: the layer that moves the part; for a shared part, the layer that moves most of it.
    pub layer_of_part: Vec<Option<usize>>,
    /// #parts: set if several layers move the part, or one layer moves some of it.
    pub(crate) shared_parts: Vec<Option<SharedPart>>,
    /// #parts: the node that carries the part.
    pub(in crate::pipeline) node_of_part: Vec<usize>,
    /// #layers: the layer's parts, including shared ones.
    pub(in crate::pipeline) parts_of_layer: Vec<Vec<usize>>,
    /// #layers: the node that carries the whole layer.
    pub(in crate::pipeline) carriers: Vec<Option<usize>>,
    /// #layers: whether the layer shares a mesh with other layers, or with what no layer moves.
    pub(in crate::pipeline) is_sharing: Vec<bool>,
}

impl LayerAssignment {
    /// Assigns all parts. The layers of a plate all lie on the one card that represents the frame.
    pub(in crate::pipeline) fn new(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Self, PipelineError> {
        let node_of_part = parts.iter().map(|part| part.node).collect();
        let all = || (0..parts.len()).collect::<Vec<usize>>();
        if shot.source == Source::Frame {
            let first = (!shot.layers.is_empty()).then_some(0);
            return Ok(Self {
                layer_of_part: vec![first; parts.len()],
                shared_parts: vec![None; parts.len()],
                node_of_part,
                parts_of_layer: vec![all(); shot.layers.len()],
                carriers: vec![carrier(scene, parts, (&all(), None)); shot.layers.len()],
                is_sharing: vec![false; shot.layers.len()],
            });
        }
        let Selected { layers_of_part, joints } = select(shot, scene, parts)?;
        let of_layer = |layer| all().into_iter().filter(|&part| layers_of_part[part].have(layer)).collect();
        let parts_of_layer: Vec<Vec<usize>> = (0..shot.layers.len()).map(of_layer).collect();
        let own = parts_of_layer.iter().zip(&joints);
        let carriers = own.map(|(own, joints)| carrier(scene, parts, (own, joints.as_ref()))).collect();
        let (layer_of_part, shared_parts): (_, Vec<Option<SharedPart>>) = layers_of_part.into_iter().map(split).unzip();
        let shares = |own: &Vec<usize>| own.iter().any(|&part| shared_parts[part].is_some());
        let is_sharing = parts_of_layer.iter().map(shares).collect();
        Ok(Self { layer_of_part, shared_parts, node_of_part, parts_of_layer, carriers, is_sharing })
    }

    /// Returns how much of a part the layer moves; the part must belong to the layer.
    pub(in crate::pipeline) fn share(&self, layer: usize, part: usize) -> LayerShare<'_> {
        self.shared_parts[part].as_ref().map_or(LayerShare::Whole, |shared| LayerShare::Shared(shared, layer))
    }

    /// Returns the layer that moves a triangle; for a shared triangle, the layer that moves most of it.
    #[cfg(any(test, feature = "cli", feature = "editor"))]
    #[must_use]
    pub(crate) fn layer_of_triangle(&self, part: usize, triangle: usize) -> Option<usize> {
        let shared = self.shared_parts[part].as_ref().and_then(|shared| shared.layer_of_triangle.get(triangle));
        shared.copied().unwrap_or(self.layer_of_part[part])
    }
}

/// Returns the layer that moves most of a part, and the weights if the part is shared.
fn split(layers: PartLayers) -> (Option<usize>, Option<SharedPart>) {
    match layers {
        PartLayers::Whole(owner) => (owner, None),
        PartLayers::Shared(shared) => (shared.most(), Some(shared)),
    }
}

/// Returns the deepest node whose subtree contains all nodes that place a layer's parts: their own nodes, or for
/// skinned parts the joints of the skin (if the layer names joints, those alone). `None` if they have no common root.
fn carrier(scene: &Scene, parts: &[PosedPart], (own, named): (&[usize], Option<&BTreeSet<usize>>)) -> Option<usize> {
    let is_named = |joint: &usize| named.is_none_or(|named| named.contains(joint));
    let placers = |&part: &usize| {
        let PosedPart { node, .. } = parts[part];
        let is_skinned = !primitive(scene, &parts[part]).influences.is_empty();
        match scene.nodes[node].skin {
            Some(skin) if is_skinned => scene.skins[skin].joints.iter().copied().filter(is_named).collect(),
            _ => vec![node],
        }
    };
    let paths = own.iter().flat_map(placers).map(|node| path_from_root(scene, node));
    let shared = paths.reduce(|mut one, other| {
        let count = one.iter().zip(&other).take_while(|(a, b)| a == b).count();
        one.truncate(count);
        one
    });
    shared?.last().copied()
}

/// Returns the ancestors of a node from the root down, ending with the node itself.
fn path_from_root(scene: &Scene, node: usize) -> Vec<usize> {
    let mut path: Vec<usize> = std::iter::successors(Some(node), |&node| scene.nodes[node].parent).collect();
    path.reverse();
    path
}
