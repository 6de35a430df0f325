//! Which layer claims which part of the scene, and which node carries what a layer claims.
//!
//! In: the layers' node patterns and the posed parts. Out: a layer a part; overlaps and empty claims are errors.

use super::PipelineError;
use crate::pose::PosedPart;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::{Shot, Source};
use crate::spelling;
use std::collections::BTreeSet;

/// Which layer claims which part.
pub(super) struct Claims {
    /// One a part: the index of the layer that moves it.
    pub(super) owners: Vec<Option<usize>>,
    /// One a layer: its parts.
    pub(super) parts_of_layer: Vec<Vec<usize>>,
}

/// Who claims what. All layers of a plate lie on the one card that stands for the frame.
pub(super) fn claim(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Claims, PipelineError> {
    if shot.source == Source::Frame {
        let owners = vec![(!shot.layers.is_empty()).then_some(0); parts.len()];
        return Ok(Claims { owners, parts_of_layer: vec![(0..parts.len()).collect(); shot.layers.len()] });
    }
    let owners = owners(shot, scene, parts)?;
    let of_layer = |layer: usize| (0..owners.len()).filter(|&part| owners[part] == Some(layer)).collect();
    let parts_of_layer = (0..shot.layers.len()).map(of_layer).collect();
    Ok(Claims { owners, parts_of_layer })
}

fn owners(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Vec<Option<usize>>, PipelineError> {
    let mut owners = vec![None; parts.len()];
    for (index, layer) in shot.layers.iter().enumerate() {
        let nodes = nodes_of(shot, index, scene)?;
        for (owner, part) in owners.iter_mut().zip(parts).filter(|(_, part)| nodes.contains(&part.node)) {
            if let Some(other) = owner.replace(index) {
                return Err(twice(shot, scene, part, (other, index)));
            }
        }
        if !owners.contains(&Some(index)) {
            let what = format!("layer '{}': none of its nodes has triangles or lines", layer.name);
            let hint = "name nodes that carry a mesh in `nodes`, or leave `nodes` out for all";
            return Err(PipelineError::mismatch(shot, &key(index), what, hint));
        }
    }
    Ok(owners)
}

/// All nodes that a layer's patterns claim, with their subtrees.
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
pub(super) fn carrier(scene: &Scene, parts: &[PosedPart], claimed: &[usize]) -> Option<usize> {
    let placers = |&part: &usize| {
        let PosedPart { node, .. } = parts[part];
        let is_skinned = !primitive(scene, &parts[part]).influences.is_empty();
        match scene.nodes[node].skin {
            Some(skin) if is_skinned => scene.skins[skin].joints.clone(),
            _ => vec![node],
        }
    };
    let paths = claimed.iter().flat_map(placers).map(|node| path_from_root(scene, node));
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
fn twice(shot: &Shot, scene: &Scene, part: &PosedPart, (one, other): (usize, usize)) -> PipelineError {
    let node = &scene.nodes[part.node].name;
    let [first, second] = [one, other].map(|layer| &shot.layers[layer].name);
    let what = format!("layers '{first}' and '{second}' both claim node '{node}'");
    PipelineError::mismatch(shot, &key(other), what, "give the layers patterns that do not overlap")
}

/// The key that holds a layer's patterns.
fn key(layer: usize) -> String {
    format!("layer[{layer}].nodes")
}
