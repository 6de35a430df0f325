//! Paints layers stiff: `[[layer.stiffness]]` becomes a number a triangle, once, when a shot is prepared.
//!
//! In: a shot, its scene, which layer has which part. Out: stiffness of the triangles of every part.

use super::PipelineError;
use crate::pose::PosedPart;
use crate::scene::{Primitive, Scene};
use crate::screen::primitive;
use crate::shot::{ColorChannel, Shot, StiffPart, StiffnessRule};
use crate::solve::Shape;
use crate::spelling;

/// Gives the triangles last added to a shape the stiffness of the triangle of a part that they came from. `painted`: the
/// stiffness of the part's triangles; `None`: the layer has none.
pub(super) fn extend_stiffness<const D: usize>(painted: Option<&[f64]>, triangle: usize, shape: &mut Shape<D>) {
    if let Some(painted) = painted {
        let value = painted.get(triangle).copied().unwrap_or(1.0);
        shape.stiffness.resize(shape.triangles.len(), value);
    }
}

/// One a part: stiffness of its triangles; empty: 1 everywhere.
pub(super) fn paint(
    shot: &Shot,
    scene: &Scene,
    (parts, parts_of_layer): (&[PosedPart], &[Vec<usize>]),
) -> Result<Vec<Vec<f64>>, PipelineError> {
    let mut painted = vec![Vec::new(); parts.len()];
    for (index, layer) in shot.layers.iter().enumerate() {
        for (number, rule) in layer.stiffness.iter().enumerate() {
            let brush = Brush { scene, parts, own: &parts_of_layer[index], rule };
            let is_met = brush.paint(&mut painted);
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
    }
    Ok(painted)
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
    /// Multiplies what the rule names; `false` where the layer has no triangles of it.
    fn paint(&self, painted: &mut [Vec<f64>]) -> bool {
        let met: Vec<usize> = self.own.iter().copied().filter(|&part| self.meets(part)).collect();
        let mut is_met = false;
        for &part in &met {
            let source = primitive(self.scene, &self.parts[part]);
            let stiffness = &mut painted[part];
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

    /// How much of a triangle the rule means, 0 to 1: for vertex colours the mean over its corners.
    fn share(&self, source: &Primitive, corners: &[u32; 3]) -> f64 {
        let StiffPart::VertexColor(channel) = self.rule.part else { return 1.0 };
        let value = |corner: &u32| f64::from(source.colors[*corner as usize][channel_index(channel)]);
        (corners.iter().map(value).sum::<f64>() / 3.0).clamp(0.0, 1.0)
    }

    /// Key, fault and remedy of a rule that meets nothing.
    fn fault(&self) -> (&'static str, String, String) {
        if self.own.iter().any(|&part| self.meets(part)) {
            let key = match self.rule.part {
                StiffPart::Nodes(_) => "nodes",
                StiffPart::Material(_) => "material",
                StiffPart::VertexColor(_) => "vertex_color",
            };
            let what = "what it names is drawn by lines only, and stiffness is a matter of triangles";
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

fn channel_index(channel: ColorChannel) -> usize {
    match channel {
        ColorChannel::R => 0,
        ColorChannel::G => 1,
        ColorChannel::B => 2,
        ColorChannel::A => 3,
    }
}
