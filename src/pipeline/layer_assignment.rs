//! Assigns the parts of the scene to layers, and finds the node that carries a layer.
//!
//! In: the layers' node patterns and the posed parts. Out: a [`LayerAssignment`]; overlaps and empty layers are errors.

use super::PipelineError;
use crate::pose::PosedPart;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{Shot, Source};
use crate::spelling;
use std::collections::BTreeSet;

/// Which part belongs to which layer. The same in every frame.
#[derive(Clone, Debug)]
pub struct LayerAssignment {
    /// One a part of every pose: the layer that moves it.
    pub layer_of_part: Vec<Option<usize>>,
    /// One a part: the node that carries it.
    pub(super) node_of_part: Vec<usize>,
    /// One a layer: its parts.
    pub(super) parts_of_layer: Vec<Vec<usize>>,
    /// One a layer: the node that carries all of it.
    pub(super) carriers: Vec<Option<usize>>,
}

impl LayerAssignment {
    /// Assigns all parts. The layers of a plate all lie on the one card that stands for the frame.
    pub(super) fn new(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Self, PipelineError> {
        let (layer_of_part, parts_of_layer): (_, Vec<Vec<usize>>) = if shot.source == Source::Frame {
            let first = (!shot.layers.is_empty()).then_some(0);
            (vec![first; parts.len()], vec![(0..parts.len()).collect(); shot.layers.len()])
        } else {
            let layer_of_part = layer_of_part(shot, scene, parts)?;
            let of_layer = |layer| (0..parts.len()).filter(|&part| layer_of_part[part] == Some(layer)).collect();
            let parts_of_layer = (0..shot.layers.len()).map(of_layer).collect();
            (layer_of_part, parts_of_layer)
        };
        let carriers = parts_of_layer.iter().map(|own| carrier(scene, parts, own)).collect();
        let node_of_part = parts.iter().map(|part| part.node).collect();
        Ok(Self { layer_of_part, node_of_part, parts_of_layer, carriers })
    }
}

fn layer_of_part(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Vec<Option<usize>>, PipelineError> {
    let mut layer_of_part = vec![None; parts.len()];
    for (index, layer) in shot.layers.iter().enumerate() {
        let nodes = nodes_of(shot, index, scene)?;
        for (layer, part) in layer_of_part.iter_mut().zip(parts).filter(|(_, part)| nodes.contains(&part.node)) {
            if let Some(other) = layer.replace(index) {
                return Err(assigned_twice(shot, scene, part, (other, index)));
            }
        }
        if !layer_of_part.contains(&Some(index)) {
            let what = format!("layer '{}': none of its nodes has triangles or lines", layer.name);
            let hint = "name nodes that carry a mesh in `nodes`, or leave `nodes` out for all";
            return Err(PipelineError::mismatch(shot, &key(index), what, hint));
        }
    }
    Ok(layer_of_part)
}

/// All nodes that a layer's patterns match, with their subtrees.
fn nodes_of(shot: &Shot, index: usize, scene: &Scene) -> Result<BTreeSet<usize>, PipelineError> {
    let layer = &shot.layers[index];
    if layer.nodes.is_empty() {
        return Ok((0..scene.nodes.len()).collect());
    }
    let mut nodes = BTreeSet::new();
    for pattern in &layer.nodes {
        let matched = scene.matching(pattern);
        if matched.is_empty() {
            let names = scene.nodes.iter().map(|node| node.name.as_str());
            let what = format!("layer '{}': no node matches '{pattern}'", layer.name);
            return Err(PipelineError::mismatch(shot, &key(index), what, spelling::hint(pattern, names)));
        }
        nodes.extend(matched.into_iter().flat_map(|node| scene.subtree(node)));
    }
    Ok(nodes)
}

/// The deepest node whose subtree holds everything that places a layer's parts: their nodes, and the joints of those
/// that are skinned. `None` where they have no common root.
fn carrier(scene: &Scene, parts: &[PosedPart], own: &[usize]) -> Option<usize> {
    let placers = |&part: &usize| {
        let PosedPart { node, .. } = parts[part];
        let is_skinned = !primitive(scene, &parts[part]).influences.is_empty();
        match scene.nodes[node].skin {
            Some(skin) if is_skinned => scene.skins[skin].joints.clone(),
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

/// Two layers want the same part.
fn assigned_twice(shot: &Shot, scene: &Scene, part: &PosedPart, (one, other): (usize, usize)) -> PipelineError {
    let node = &scene.nodes[part.node].name;
    let [first, second] = [one, other].map(|layer| &shot.layers[layer].name);
    let what = format!("layers '{first}' and '{second}' both claim node '{node}'");
    PipelineError::mismatch(shot, &key(other), what, "give the layers patterns that do not overlap")
}

/// The key that holds a layer's patterns.
fn key(layer: usize) -> String {
    format!("layer[{layer}].nodes")
}
