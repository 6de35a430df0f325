//! Resolves the names in a layer's selection to indices of the scene.
//!
//! In: a layer and its scene. Out: [`Rules`], or an error for a name that the scene lacks, with the nearest valid name.

use crate::image::{PaintedMap, are_of_one_shape};
use crate::pipeline::PipelineError;
use crate::pose::PosedPart;
use crate::scene::{Primitive, Scene};
use crate::screen::primitive;
use crate::shot::{ColorChannel, PaintedMask, Selection, Shot};
use crate::spelling;
use std::collections::BTreeSet;

/// A selection as a shot has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patterns<'a> {
    /// Patterns of names of nodes.
    pub(crate) nodes: &'a [String],
    pub(crate) rules: &'a Selection,
}

/// The parts from which a selection chooses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShotParts<'a> {
    pub(crate) shot: &'a Shot,
    pub(crate) scene: &'a Scene,
    pub(crate) parts: &'a [PosedPart],
}

/// A layer's selection, resolved to indices.
#[derive(Debug)]
pub(super) struct Rules {
    /// Nodes whose meshes are selected.
    pub(super) nodes: BTreeSet<usize>,
    /// Nodes that count as joints of the layer; `None`: no restriction by joints.
    pub(super) joints: Option<BTreeSet<usize>>,
    /// Selected materials; `None`: all.
    materials: Option<BTreeSet<usize>>,
    vertex_color: Option<ColorChannel>,
    /// A painted map and the index of its UV set.
    mask: Option<(PaintedMap, usize)>,
}

impl Rules {
    /// Resolves the selection of a layer.
    pub(super) fn of(shot: &Shot, index: usize, scene: &Scene, parts: &[PosedPart]) -> Result<Self, PipelineError> {
        let layer = &shot.layers[index];
        let keys = RuleKeys { layer: index, nodes: "nodes".to_owned(), select: "select".to_owned() };
        let patterns = Patterns { nodes: &layer.nodes, rules: &layer.selection };
        Self::find(patterns, keys, ShotParts { shot, scene, parts })
    }

    /// Resolves node patterns and rules; `keys`: their keys in the shot, for errors.
    pub(super) fn find(
        Patterns { nodes, rules: rule }: Patterns,
        keys: RuleKeys,
        ShotParts { shot, scene, parts }: ShotParts,
    ) -> Result<Self, PipelineError> {
        let search = Search { shot, keys, scene, nodes: BTreeSet::new(), parts };
        let nodes = search.nodes(nodes)?;
        let search = Search { nodes, ..search };
        let is_given = |patterns: &[String]| !patterns.is_empty();
        Ok(Self {
            joints: is_given(&rule.joints).then(|| search.joints(&rule.joints)).transpose()?,
            materials: is_given(&rule.materials).then(|| search.materials(&rule.materials)).transpose()?,
            vertex_color: rule.vertex_color.map(|channel| search.vertex_color(channel)).transpose()?,
            mask: rule.mask.as_ref().map(|mask| search.mask(mask)).transpose()?,
            nodes: search.nodes,
        })
    }

    /// Whether whole meshes are selected.
    pub(super) const fn is_whole(&self) -> bool {
        self.joints.is_none() && self.materials.is_none() && self.vertex_color.is_none() && self.mask.is_none()
    }

    /// Returns the selected share of a vertex of a selected node's mesh, 0 to 1.
    pub(super) fn share(&self, scene: &Scene, part: &PosedPart, vertex: usize) -> f32 {
        let source = primitive(scene, part);
        if self.materials.as_ref().is_some_and(|materials| !materials.contains(&source.material)) {
            return 0.0;
        }
        let tied = self.joints.as_ref().map_or(1.0, |joints| tied(scene, part, (source, vertex), joints));
        let colored = self.vertex_color.map_or(1.0, |channel| {
            source.colors.get(vertex).map_or(0.0, |color| color[channel.index()].clamp(0.0, 1.0))
        });
        let painted = self.mask.as_ref().map_or(1.0, |(map, set)| {
            source.uvs[*set].get(vertex).filter(|_| has_uvs(source, *set)).map_or(0.0, |uv| map.at(uv.to_array()))
        });
        let share = tied * colored * painted;
        if share.is_finite() { share } else { 0.0 }
    }
}

/// Returns the share of a vertex that is bound to some joints: by its skin weights, or by its node if it has no skin.
fn tied(scene: &Scene, part: &PosedPart, (source, vertex): (&Primitive, usize), joints: &BTreeSet<usize>) -> f32 {
    let (Some(skin), Some(influences)) = (scene.nodes[part.node].skin, source.influences.get(vertex)) else {
        return f32::from(u8::from(joints.contains(&part.node)));
    };
    let of_joint = |joint: u16| scene.skins[skin].joints.get(usize::from(joint));
    let own = influences.iter().filter(|one| of_joint(one.joint).is_some_and(|node| joints.contains(node)));
    let (own, all): (f32, f32) =
        (own.map(|one| one.weight).sum(), influences.iter().map(|one| one.weight).sum::<f32>().max(f32::MIN_POSITIVE));
    (own / all).clamp(0.0, 1.0)
}

/// Whether a UV set is usable; a set in which all points are equal is only a placeholder for meshes without UVs.
fn has_uvs(source: &Primitive, set: usize) -> bool {
    source.uvs[set].iter().any(|uv| *uv != source.uvs[set][0])
}

/// Returns the name of a material; unnamed ones are numbered.
pub(in crate::pipeline) fn material_name(scene: &Scene, index: usize) -> String {
    let name = &scene.materials[index].name;
    if name.trim().is_empty() { format!("material_{index}") } else { name.clone() }
}

/// The keys of rules in a shot, for errors.
#[derive(Clone, Debug)]
pub(super) struct RuleKeys {
    /// Index of the layer.
    pub(super) layer: usize,
    /// Key of the node patterns within the layer.
    pub(super) nodes: String,
    /// Key of the rules within the layer.
    pub(super) select: String,
}

/// Resolves names for one layer.
struct Search<'a> {
    shot: &'a Shot,
    keys: RuleKeys,
    scene: &'a Scene,
    /// Nodes of the layer, once resolved.
    nodes: BTreeSet<usize>,
    parts: &'a [PosedPart],
}

impl Search<'_> {
    fn fault(&self, key: &str, what: &str, hint: impl Into<String>) -> PipelineError {
        let name = &self.shot.layers[self.keys.layer].name;
        let key = format!("layer[{}].{key}", self.keys.layer);
        PipelineError::mismatch(self.shot, &key, format!("layer '{name}': {what}"), hint)
    }

    /// Returns the key of a rule within the layer.
    fn rule(&self, name: &str) -> String {
        format!("{}.{name}", self.keys.select)
    }

    /// Returns the parts of the layer's nodes.
    fn own(&self) -> impl Iterator<Item = &PosedPart> + Clone {
        self.parts.iter().filter(|part| self.nodes.contains(&part.node))
    }

    /// Returns all nodes that match the including patterns, with their subtrees, except those that match excluding patterns (`!`).
    fn nodes(&self, patterns: &[String]) -> Result<BTreeSet<usize>, PipelineError> {
        Self::chosen(patterns, (0..self.scene.nodes.len()).collect(), |pattern| {
            let matched = self.scene.matching(pattern);
            if matched.is_empty() {
                let names = self.scene.nodes.iter().map(|node| node.name.as_str());
                let what = format!("no node matches '{pattern}'");
                return Err(self.fault(&self.keys.nodes, &what, spelling::hint(pattern, names)));
            }
            Ok(matched.into_iter().flat_map(|node| self.scene.subtree(node)).collect())
        })
    }

    /// Resolves joints as the function `nodes` resolves nodes; each pattern must match a joint or an ancestor of one.
    fn joints(&self, patterns: &[String]) -> Result<BTreeSet<usize>, PipelineError> {
        let skins: BTreeSet<usize> = self.own().filter_map(|part| self.scene.nodes[part.node].skin).collect();
        let joints: BTreeSet<usize> = skins.iter().flat_map(|&skin| &self.scene.skins[skin].joints).copied().collect();
        if joints.is_empty() {
            let hint = "name materials, vertex_color or a mask instead, or nodes that have a skin";
            return Err(self.fault(&self.rule("joints"), "none of its meshes has a skin", hint));
        }
        Self::chosen(patterns, (0..self.scene.nodes.len()).collect(), |pattern| {
            let matched = self.scene.matching(pattern);
            let below: BTreeSet<usize> = matched.into_iter().flat_map(|node| self.scene.subtree(node)).collect();
            if below.is_disjoint(&joints) {
                let names = joints.iter().map(|&joint| self.scene.nodes[joint].name.as_str());
                let what = format!("no joint matches '{pattern}'");
                return Err(self.fault(&self.rule("joints"), &what, spelling::hint(pattern, names)));
            }
            Ok(below)
        })
    }

    fn materials(&self, patterns: &[String]) -> Result<BTreeSet<usize>, PipelineError> {
        let own: BTreeSet<usize> = self.own().map(|part| primitive(self.scene, part).material).collect();
        let names: Vec<(usize, String)> = own.iter().map(|&index| (index, material_name(self.scene, index))).collect();
        Self::chosen(patterns, own, |pattern| {
            let matched: BTreeSet<usize> = names
                .iter()
                .filter(|(_, name)| spelling::matches_pattern(pattern, name))
                .map(|(index, _)| *index)
                .collect();
            if matched.is_empty() {
                let what = format!("none of its meshes has a material that matches '{pattern}'");
                let hint = spelling::hint(pattern, names.iter().map(|(_, name)| name.as_str()));
                return Err(self.fault(&self.rule("materials"), &what, hint));
            }
            Ok(matched)
        })
    }

    fn vertex_color(&self, channel: ColorChannel) -> Result<ColorChannel, PipelineError> {
        if self.own().any(|part| !primitive(self.scene, part).colors.is_empty()) {
            return Ok(channel);
        }
        let hint = "export them with it (COLOR_0), or name joints, materials or a mask";
        Err(self.fault(&self.rule("vertex_color"), "none of its meshes has vertex colours", hint))
    }

    fn mask(&self, mask: &PaintedMask) -> Result<(PaintedMap, usize), PipelineError> {
        let set = mask.uv_set;
        if !self.own().any(|part| has_uvs(primitive(self.scene, part), set)) {
            let what = format!("none of its meshes has UVs (TEXCOORD_{set}) that a mask could lie on");
            let hint = "unwrap and export them, or name joints, materials or vertex_color";
            return Err(self.fault(&self.rule("mask"), &what, hint));
        }
        let read = PaintedMap::read(&mask.file, mask.channel.index());
        let map = read.map_err(|error| {
            self.fault(&self.rule("mask.file"), &error.to_string(), "give a PNG, JPEG or EXR file painted over the UVs")
        })?;
        self.check_shape(&map, set)?;
        Ok((map, set))
    }

    /// Checks that a mask has the shape of the texture on the same UVs, because both cover the same unit square.
    fn check_shape(&self, map: &PaintedMap, set: usize) -> Result<(), PipelineError> {
        for part in self.own() {
            let material = &self.scene.materials[primitive(self.scene, part).material];
            let Some(texture) = material.base_color_texture.filter(|texture| texture.uv_set == set) else { continue };
            let image = &self.scene.images[self.scene.textures[texture.texture].image];
            let size = [image.width, image.height];
            if are_of_one_shape(map.size, size) {
                continue;
            }
            let [[width, height], [w, h]] = [map.size, size];
            let node = &self.scene.nodes[part.node].name;
            let what =
                format!("the mask has {width} x {height} pixels, the texture of '{node}' on the same UVs {w} x {h}");
            let hint = "paint it over the UVs as the texture is, in the same shape; other sizes of that shape will do";
            return Err(self.fault(&self.rule("mask.file"), &what, hint));
        }
        Ok(())
    }

    /// Returns the choice of the patterns: those included minus those excluded, starting from `all` if no pattern includes.
    fn chosen(
        patterns: &[String],
        all: BTreeSet<usize>,
        find: impl Fn(&str) -> Result<BTreeSet<usize>, PipelineError>,
    ) -> Result<BTreeSet<usize>, PipelineError> {
        let (mut taken, mut left_out): (Option<BTreeSet<usize>>, _) = (None, BTreeSet::new());
        for pattern in patterns {
            match pattern.strip_prefix('!') {
                Some(pattern) => left_out.extend(find(pattern)?),
                None => taken.get_or_insert_default().extend(find(pattern)?),
            }
        }
        Ok(&taken.unwrap_or(all) - &left_out)
    }
}
