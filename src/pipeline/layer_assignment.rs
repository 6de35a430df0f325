//! Assigns the parts of the scene to layers, and finds the node that carries a layer.
//!
//! In: the layers' selections and the posed parts. Out: a [`LayerAssignment`]; unknown names and empty layers are errors.

use super::PipelineError;
use super::selection::{LayerShare, PartLayers, Selected, SharedPart, select};
use crate::pose::PosedPart;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{Shot, Source};
use std::collections::BTreeSet;

/// Which part belongs to which layer. The same in every frame.
#[derive(Clone, Debug)]
pub struct LayerAssignment {
    /// One a part of every pose: the layer that moves it; of a shared part the layer that moves most of it.
    pub layer_of_part: Vec<Option<usize>>,
    /// One a part: set where several layers move it, or one moves some of it.
    pub shared_parts: Vec<Option<SharedPart>>,
    /// One a part: the node that carries it.
    pub(super) node_of_part: Vec<usize>,
    /// One a layer: its parts, shared ones too.
    pub(super) parts_of_layer: Vec<Vec<usize>>,
    /// One a layer: the node that carries all of it.
    pub(super) carriers: Vec<Option<usize>>,
    /// One a layer: it shares meshes with others, or with what rests.
    pub(super) is_sharing: Vec<bool>,
}

impl LayerAssignment {
    /// Assigns all parts. The layers of a plate all lie on the one card that stands for the frame.
    pub(super) fn new(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Self, PipelineError> {
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

    /// How much of a part a layer moves that has the part.
    pub(super) fn share(&self, layer: usize, part: usize) -> LayerShare<'_> {
        self.shared_parts[part].as_ref().map_or(LayerShare::Whole, |shared| LayerShare::Shared(shared, layer))
    }

    /// The layer that moves a triangle; of a shared one the layer that moves most of it.
    #[must_use]
    pub fn layer_of_triangle(&self, part: usize, triangle: usize) -> Option<usize> {
        let shared = self.shared_parts[part].as_ref().and_then(|shared| shared.layer_of_triangle.get(triangle));
        shared.copied().unwrap_or(self.layer_of_part[part])
    }
}

/// The layer that moves most of a part; and the weights, where it is shared.
fn split(layers: PartLayers) -> (Option<usize>, Option<SharedPart>) {
    match layers {
        PartLayers::Whole(owner) => (owner, None),
        PartLayers::Shared(shared) => (shared.most(), Some(shared)),
    }
}

/// The deepest node whose subtree holds everything that places a layer's parts: their nodes, and the joints of those
/// that are skinned, where the layer names joints those alone. `None` where they have no common root.
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

/// The ancestors of a node, the root first, and itself.
fn path_from_root(scene: &Scene, node: usize) -> Vec<usize> {
    let mut path: Vec<usize> = std::iter::successors(Some(node), |&node| scene.nodes[node].parent).collect();
    path.reverse();
    path
}
