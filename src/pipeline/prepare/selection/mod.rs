//! Determines which layers move each part of the scene: by nodes, joints, materials, vertex colours and painted masks.
//!
//! In: the layers' selections and the posed parts. Out: one [`PartLayers`] per part; unknown names and layers left
//! without any geometry are errors. Where layers share a mesh, weights blend its vertices from one layer to the other,
//! so nothing tears.

mod coverage;
mod feather;
mod mesh_graph;
mod precedence;
mod rules;
mod shared_part;

pub(in crate::pipeline) use precedence::PartLayers;
pub(in crate::pipeline) use rules::material_name;
pub(crate) use rules::{Patterns, ShotParts};
pub(crate) use shared_part::LayerShare;
pub(crate) use shared_part::SharedPart;

use crate::pipeline::PipelineError;
use crate::pose::PosedPart;
use crate::scene::Scene;
use crate::screen::primitive;
use crate::shot::Shot;
use coverage::PartCoverage;
use rules::{RuleKeys, Rules};
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// The result of all selections.
#[derive(Debug)]
pub(crate) struct Selected {
    /// One per part.
    pub(crate) layers_of_part: Vec<PartLayers>,
    /// #layers: the nodes that count as the layer's joints, if it names some.
    pub(crate) joints: Vec<Option<BTreeSet<usize>>>,
}

/// Distributes all parts to the layers that select them.
pub(crate) fn select(shot: &Shot, scene: &Scene, parts: &[PosedPart]) -> Result<Selected, PipelineError> {
    let (mut named, mut joints): (Vec<Vec<PartCoverage>>, Vec<_>) = (Vec::new(), Vec::new());
    for (index, layer) in shot.layers.iter().enumerate() {
        let rules = Rules::of(shot, index, scene, parts)?;
        let coverage = coverage::named(scene, parts, &rules, layer.selection.feather);
        if coverage.iter().all(PartCoverage::is_nothing) {
            return Err(names_nothing(shot, index));
        }
        named.push(coverage);
        joints.push(rules.joints);
    }
    let mut order: Vec<usize> = (0..named.len()).collect();
    order.sort_by_key(|&layer| (shot.layers[layer].selection.is_rest, Reverse(layer)));
    let layers_of = |(index, part): (usize, &PosedPart)| {
        let named = order.iter().map(|&layer| (layer, &named[layer][index]));
        precedence::layers_of(named, primitive(scene, part))
    };
    let layers_of_part: Vec<PartLayers> = parts.iter().enumerate().map(layers_of).collect();
    let is_left = |layer: usize| layers_of_part.iter().any(|layers| layers.have(layer));
    match (0..named.len()).find(|&layer| !is_left(layer)) {
        Some(layer) => Err(left_with_nothing(shot, layer)),
        None => Ok(Selected { layers_of_part, joints }),
    }
}

/// Returns which triangles of a layer's parts a cut selects: those whose corners are mostly selected. Triangles are
/// numbered consecutively over all parts. `keys`: index of the layer, number of the cut.
pub(crate) fn cut_off(own: ShotParts, keys: [usize; 2], patterns: Patterns) -> Result<Vec<bool>, PipelineError> {
    let ShotParts { scene, parts, .. } = own;
    let [layer, number] = keys;
    let key = format!("lattice.cuts[{number}]");
    let keys = RuleKeys { layer, nodes: format!("{key}.nodes"), select: key };
    let rules = Rules::find(patterns, keys, own)?;
    let of_part = |part: &PosedPart| {
        let is_named = |&triangle: &[u32; 3]| {
            let shares = triangle.map(|corner| rules.share(scene, part, corner as usize));
            rules.nodes.contains(&part.node) && shares.iter().sum::<f32>() > 1.5
        };
        primitive(scene, part).triangles.iter().map(is_named).collect::<Vec<_>>()
    };
    Ok(parts.iter().flat_map(of_part).collect())
}

impl PartLayers {
    /// Whether a layer moves some of the part.
    pub(crate) fn have(&self, layer: usize) -> bool {
        match self {
            Self::Whole(owner) => *owner == Some(layer),
            Self::Shared(shared) => shared.layers.contains(&layer),
        }
    }
}

/// Creates the error for a layer whose selection matches nothing.
fn names_nothing(shot: &Shot, index: usize) -> PipelineError {
    let (name, rule) = (&shot.layers[index].name, &shot.layers[index].selection);
    if rule.is_whole() {
        let what = format!("layer '{name}': none of its nodes has triangles or lines");
        let hint = "name nodes that carry a mesh in `nodes`, or leave `nodes` out for all";
        return PipelineError::mismatch(shot, &format!("layer[{index}].nodes"), what, hint);
    }
    let rules = [
        (!rule.joints.is_empty(), "hangs on its joints"),
        (!rule.materials.is_empty(), "has its materials"),
        (rule.vertex_color.is_some(), "is coloured in its channel"),
        (rule.mask.is_some(), "is white in its mask"),
    ];
    let wanted: Vec<&str> = rules.iter().filter(|(is_given, _)| *is_given).map(|&(_, text)| text).collect();
    let what = format!("layer '{name}': no vertex of its meshes {}", wanted.join(" and "));
    let hint = "`pinwarp info` lists joints, materials and vertex colours of a scene; masks count at vertices";
    PipelineError::mismatch(shot, &format!("layer[{index}].select"), what, hint)
}

/// Creates the error for a layer whose whole selection is taken by other layers.
fn left_with_nothing(shot: &Shot, index: usize) -> PipelineError {
    let layer = &shot.layers[index];
    let name = &layer.name;
    if layer.selection.is_rest {
        let what = format!("layer '{name}': nothing is left, the other layers take all of the scene");
        let hint = "remove the layer, or let another take less";
        return PipelineError::mismatch(shot, &format!("layer[{index}].nodes"), what, hint);
    }
    let what = format!("layer '{name}': later layers take all that it names");
    let hint = "move its [[layer]] behind them, give them other `nodes`, or name with a '!' what they leave alone";
    PipelineError::mismatch(shot, &format!("layer[{index}].nodes"), what, hint)
}
