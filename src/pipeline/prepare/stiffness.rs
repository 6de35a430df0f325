//! Computes the stiffness of every triangle from `[[layer.stiffness]]`, when a shot is prepared and when its painting changes.
//!
//! In: a shot, its scene, and the parts of each layer. Out: the stiffness of the triangles of every part, and notes.

use super::brush_strokes::{RestParts, Strokes};
use super::rest_mesh::rest_pose;
use super::selection::LayerShare;
use crate::pipeline::PipelineError;
use crate::pipeline::evaluate::frame_cache::FrameCache;
use crate::pose::PosedPart;
use crate::scene::{Primitive, Scene};
use crate::screen::primitive;
use crate::shot::{Shot, StiffPart, StiffnessRule};
use crate::solve::Shape;
use crate::spelling;
use std::collections::BTreeMap;

/// Minimum fraction in the stiffness of triangles that a layer moves only slightly, so that they still constrain its lattice.
const MIN_FRACTION: f64 = 1e-3;

/// Stiffness of a part's triangles in a layer: the value from the rules, times the share of each triangle that the layer moves.
#[derive(Clone, Copy, Debug)]
pub(in crate::pipeline) struct PartStiffness<'a> {
    /// #triangles; empty: 1 everywhere.
    pub(in crate::pipeline) painted: &'a [f64],
    /// How much of the part the layer moves.
    pub(in crate::pipeline) share: LayerShare<'a>,
    /// Whether triangles of the layer may differ in stiffness.
    pub(in crate::pipeline) is_uneven: bool,
}

impl PartStiffness<'_> {
    /// Whether the layer moves some of a triangle.
    pub(in crate::pipeline) fn meets(&self, corners: &[u32; 3]) -> bool {
        self.share.meets(corners)
    }

    /// Whether all triangles of the layer have the same stiffness.
    pub(in crate::pipeline) const fn is_even(&self) -> bool {
        !self.is_uneven
    }

    /// Assigns the triangles last added to a shape the stiffness of the part's triangle from which they come.
    pub(in crate::pipeline) fn extend<const D: usize>(
        &self,
        (triangle, corners): (usize, &[u32; 3]),
        shape: &mut Shape<D>,
    ) {
        if self.is_uneven {
            let value = self.painted.get(triangle).copied().unwrap_or(1.0) * self.share.of(corners).max(MIN_FRACTION);
            shape.stiffness.resize(shape.triangles.len(), value);
        }
    }
}

/// #layers, then by part: stiffness of the part's triangles; parts without an entry have 1 everywhere.
pub(in crate::pipeline) type Painted = Vec<BTreeMap<usize, Vec<f64>>>;

/// The stiffness of all layers.
#[derive(Clone, Debug, Default)]
pub(in crate::pipeline) struct Stiffness {
    pub(in crate::pipeline) painted: Painted,
    /// What the user should know about it.
    pub(in crate::pipeline) notes: Vec<String>,
}

/// Computes the stiffness for all layers.
pub(in crate::pipeline) fn paint(
    shot: &Shot,
    scene: &Scene,
    (parts_of_layer, cache): (&[Vec<usize>], &FrameCache),
) -> Result<Stiffness, PipelineError> {
    let mut found = Stiffness::default();
    if shot.layers.iter().all(|layer| layer.stiffness.is_empty() && layer.strokes.is_empty()) {
        found.painted.resize(shot.layers.len(), BTreeMap::new());
        return Ok(found);
    }
    let rest = cache.rest.get_or_init(|| rest_pose(scene));
    let parts = &rest.parts[..];
    for (index, layer) in shot.layers.iter().enumerate() {
        let mut own = BTreeMap::new();
        for (number, rule) in layer.stiffness.iter().enumerate() {
            let brush = Brush { scene, parts, own: &parts_of_layer[index], rule };
            let is_met = brush.paint(&mut own);
            if !is_met {
                let (key, what, hint) = brush.fault();
                let what = format!("layer '{}': {what}", layer.name);
                return Err(PipelineError::mismatch(
                    shot,
                    &format!("layer[{index}].stiffness[{number}].{key}"),
                    what,
                    hint,
                ));
            }
        }
        if !layer.strokes.is_empty() {
            let strokes = Strokes::of(shot, index, scene)?;
            let unmet =
                strokes.paint(RestParts { scene, rest, parts: &parts_of_layer[index] }, &cache.strokes, &mut own);
            found.notes.extend(unmet.map(|unmet| format!("layer '{}': {unmet}", layer.name)));
        }
        found.painted.push(own);
    }
    cache.strokes.retain(shot);
    Ok(found)
}

/// One rule of one layer.
struct Brush<'a> {
    scene: &'a Scene,
    parts: &'a [PosedPart],
    /// The parts of the layer.
    own: &'a [usize],
    rule: &'a StiffnessRule,
}

impl Brush<'_> {
    /// Multiplies the stiffness of the triangles that the rule names; `false` if the layer has none.
    fn paint(&self, painted: &mut BTreeMap<usize, Vec<f64>>) -> bool {
        let met: Vec<usize> = self.own.iter().copied().filter(|&part| self.meets(part)).collect();
        let mut is_met = false;
        for &part in &met {
            let source = primitive(self.scene, &self.parts[part]);
            let stiffness = painted.entry(part).or_default();
            is_met |= !source.triangles.is_empty();
            stiffness.resize(source.triangles.len(), 1.0);
            for (slot, corners) in stiffness.iter_mut().zip(&source.triangles) {
                *slot *= 1.0 + (self.rule.value - 1.0) * self.share(source, corners);
            }
        }
        is_met
    }

    fn meets(&self, part: usize) -> bool {
        let source = primitive(self.scene, &self.parts[part]);
        match &self.rule.part {
            StiffPart::Nodes(patterns) => {
                let nodes = patterns.iter().flat_map(|pattern| self.scene.matching(pattern));
                nodes.flat_map(|node| self.scene.subtree(node)).any(|node| node == self.parts[part].node)
            }
            StiffPart::Material(name) => self.scene.materials[source.material].name == *name,
            StiffPart::VertexColor(_) => !source.colors.is_empty(),
        }
    }

    /// Returns how much of a triangle the rule names, 0 to 1: for vertex colours the mean over its corners.
    fn share(&self, source: &Primitive, corners: &[u32; 3]) -> f64 {
        let StiffPart::VertexColor(channel) = self.rule.part else { return 1.0 };
        let value = |corner: &u32| f64::from(source.colors[*corner as usize][channel.index()]);
        (corners.iter().map(value).sum::<f64>() / 3.0).clamp(0.0, 1.0)
    }

    /// Returns key, description and remedy for a rule that matches nothing.
    fn fault(&self) -> (&'static str, String, String) {
        if self.own.iter().any(|&part| self.meets(part)) {
            let key = match self.rule.part {
                StiffPart::Nodes(_) => "nodes",
                StiffPart::Material(_) => "material",
                StiffPart::VertexColor(_) => "vertex_color",
            };
            let what = "what it names is drawn by lines only, and stiffness applies to triangles only";
            return (key, what.into(), "remove the entry, or name meshes with triangles".into());
        }
        match &self.rule.part {
            StiffPart::Nodes(patterns) => {
                let names = self.scene.nodes.iter().map(|node| node.name.as_str());
                let unknown = patterns.iter().find(|pattern| self.scene.matching(pattern).is_empty());
                match unknown {
                    Some(pattern) => ("nodes", format!("no node matches '{pattern}'"), spelling::hint(pattern, names)),
                    None => {
                        let hint = "name nodes that the layer claims and that carry a mesh".into();
                        ("nodes", format!("it has no meshes of {}", patterns.join(", ")), hint)
                    }
                }
            }
            StiffPart::Material(name) => {
                let own = self.own.iter().map(|&part| primitive(self.scene, &self.parts[part]).material);
                let names = own.map(|material| self.scene.materials[material].name.as_str());
                let hint = spelling::hint(name, names.filter(|name| !name.is_empty()));
                ("material", format!("none of its meshes has the material '{name}'"), hint)
            }
            StiffPart::VertexColor(_) => {
                let hint = "export them with it (COLOR_0), or name nodes or a material".into();
                ("vertex_color", "none of its meshes has vertex colours".into(), hint)
            }
        }
    }
}
