//! Reads the vertex attributes of one primitive.
//!
//! In: accessors. Out: arrays of #vertices; every array is checked to be as long as the positions.

use super::accessor::{Floats, Integers};
use super::file::File;
use super::limits::{LARGEST, is_usable};
use super::{Influence, MorphTarget, SceneError};
use crate::spelling::pluralised;
use glam::{Vec2, Vec3, Vec4};
use gltf::json::accessor::Type;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{self, Accessor, Index};
use std::fmt::{self, Arguments};

/// A primitive's name, for messages.
#[derive(Clone, Copy)]
pub(super) struct Label<'a> {
    /// Name of the mesh.
    pub(super) mesh: &'a str,
    /// Index of the primitive in the mesh.
    pub(super) primitive: usize,
}

impl fmt::Display for Label<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "mesh \"{}\", primitive {}", self.mesh, self.primitive)
    }
}

/// Reads the attributes of one primitive.
pub(super) struct Attributes<'a> {
    pub(super) file: &'a File,
    pub(super) json: &'a json::mesh::Primitive,
    /// #vertices.
    pub(super) count: usize,
    pub(super) label: Label<'a>,
}

impl Attributes<'_> {
    /// Reads UV set `set`; empty if missing.
    pub(super) fn uvs(&self, set: u32) -> Result<Vec<Vec2>, SceneError> {
        let floats = self.optional(Semantic::TexCoords(set), &[Type::Vec2], Integers::AsFlagged)?;
        let mut uvs = floats.map_or_else(Vec::new, |floats| floats.map(Vec2::from_array));
        replace_broken(&mut uvs, |uv| uv.is_finite(), Vec2::ZERO);
        Ok(uvs)
    }

    /// Reads COLOR_0 as RGBA; empty if missing.
    pub(super) fn colors(&self) -> Result<Vec<Vec4>, SceneError> {
        let floats = self.optional(Semantic::Colors(0), &[Type::Vec3, Type::Vec4], Integers::Normalized)?;
        let Some(floats) = floats else { return Ok(Vec::new()) };
        let mut colors: Vec<Vec4> = match floats.width {
            3 => floats.map(|rgb| Vec3::from_array(rgb).extend(1.0)),
            _ => floats.map(Vec4::from_array),
        };
        replace_broken(&mut colors, |color| color.is_finite(), Vec4::ONE);
        Ok(colors)
    }

    /// Reads three-component vectors unchanged.
    pub(super) fn vectors(&self, semantic: Semantic) -> Result<Option<Vec<Vec3>>, SceneError> {
        let floats = self.optional(semantic, &[Type::Vec3], Integers::AsFlagged)?;
        Ok(floats.map(|floats| floats.map(Vec3::from_array)))
    }

    /// Reads TANGENT unchanged.
    pub(super) fn tangents(&self) -> Result<Option<Vec<Vec4>>, SceneError> {
        let floats = self.optional(Semantic::Tangents, &[Type::Vec4], Integers::AsFlagged)?;
        Ok(floats.map(|floats| floats.map(Vec4::from_array)))
    }

    /// Reads JOINTS_0 and JOINTS_1 with their weights, normalised to sum to 1 per vertex; empty if missing.
    pub(super) fn influences(&self, warnings: &mut Vec<String>) -> Result<Vec<[Influence; 8]>, SceneError> {
        let mut influences = Vec::new();
        for set in 0..2 {
            let Some((joints, weights)) = self.joint_set(set)? else { continue };
            influences.resize(self.count, [Influence::default(); 8]);
            let shares = joints.as_chunks::<4>().0.iter().zip(weights.values.as_chunks::<4>().0);
            for (vertex, (joints, weights)) in influences.iter_mut().zip(shares) {
                for k in 0..4 {
                    vertex[4 * set as usize + k] = self.influence(joints[k], weights[k])?;
                }
            }
        }
        if self.attribute(Semantic::Joints(2)).is_some() {
            warnings.push(format!("{}: more than eight joints per vertex, the rest is ignored", self.label));
        }
        let orphans = influences.iter_mut().filter_map(normalize).count();
        if orphans > 0 {
            let orphans =
                pluralised(orphans, "vertex without weights follows its", "vertices without weights follow their");
            warnings.push(format!("{}: {orphans} first joint", self.label));
        }
        Ok(influences)
    }

    fn influence(&self, joint: u32, weight: f32) -> Result<Influence, SceneError> {
        // Joints without weight often have arbitrary indices, which are ignored.
        let weight = if weight.is_finite() { weight.max(0.0) } else { 0.0 };
        let joint = if weight > 0.0 { joint } else { 0 };
        let too_far = |_| self.file.invalid(format!("{}: joint {joint} is out of range", self.label));
        Ok(Influence { joint: u16::try_from(joint).map_err(too_far)?, weight })
    }

    fn joint_set(&self, set: u32) -> Result<Option<(Vec<u32>, Floats)>, SceneError> {
        let joints = self.attribute(Semantic::Joints(set));
        let weights = self.attribute(Semantic::Weights(set));
        let (Some(joints), Some(weights)) = (joints, weights) else { return Ok(None) };
        let label = self.label;
        self.check_count(joints, format_args!("{label}, JOINTS_{set}"))?;
        let joints = self.file.integers(joints, Type::Vec4, format_args!("{label}, JOINTS_{set}"))?;
        let weights =
            self.read(weights, &[Type::Vec4], Integers::Normalized, format_args!("{label}, WEIGHTS_{set}"))?;
        Ok(Some((joints, weights)))
    }

    /// Reads the morph targets.
    pub(super) fn targets(&self) -> Result<Vec<MorphTarget>, SceneError> {
        let targets = self.json.targets.iter().flatten().enumerate();
        targets.map(|(number, target)| self.target(number, target)).collect()
    }

    fn target(&self, number: usize, json: &json::mesh::MorphTarget) -> Result<MorphTarget, SceneError> {
        let read = |accessor: Option<Index<Accessor>>, name: &str| {
            let stored = accessor.filter(|accessor| !self.file.is_all_zero(*accessor));
            let Some(accessor) = stored else { return Ok(Vec::new()) };
            let what = format_args!("{}, morph target {number}, {name}", self.label);
            let floats = self.read(accessor, &[Type::Vec3], Integers::AsFlagged, what)?;
            Ok(floats.map(Vec3::from_array))
        };
        let positions = read(json.positions, "POSITION")?;
        if let Some(vertex) = positions.iter().position(|by| !by.to_array().into_iter().all(is_usable)) {
            let label = self.label;
            let what = format!(
                "{label}, morph target {number}: vertex {vertex} is not moved by a finite number, or beyond {LARGEST:e}"
            );
            return Err(self.file.invalid(what));
        }
        let mut normals = read(json.normals, "NORMAL")?;
        let mut tangents = read(json.tangents, "TANGENT")?;
        replace_broken(&mut normals, |by| by.is_finite(), Vec3::ZERO);
        replace_broken(&mut tangents, |by| by.is_finite(), Vec3::ZERO);
        Ok(MorphTarget { positions, normals, tangents })
    }

    fn attribute(&self, semantic: Semantic) -> Option<Index<Accessor>> {
        self.json.attributes.get(&Checked::Valid(semantic)).copied()
    }

    fn optional(&self, semantic: Semantic, types: &[Type], integers: Integers) -> Result<Option<Floats>, SceneError> {
        let Some(accessor) = self.attribute(semantic.clone()) else { return Ok(None) };
        self.read(accessor, types, integers, format_args!("{}, {semantic:?}", self.label)).map(Some)
    }

    fn read(
        &self,
        accessor: Index<Accessor>,
        types: &[Type],
        integers: Integers,
        what: Arguments<'_>,
    ) -> Result<Floats, SceneError> {
        // The count is checked first, so that a small file cannot request much memory.
        self.check_count(accessor, what)?;
        self.file.floats(accessor, types, integers, what)
    }

    fn check_count(&self, accessor: Index<Accessor>, what: Arguments<'_>) -> Result<(), SceneError> {
        let count = self.file.count(accessor, what)?;
        if count == self.count {
            return Ok(());
        }
        let (found, wanted) = (pluralised(count, "element", "elements"), pluralised(self.count, "vertex", "vertices"));
        Err(self.file.invalid(format!("{what} has {found} for {wanted}")))
    }
}

fn replace_broken<T: Copy>(values: &mut [T], is_good: impl Fn(&T) -> bool, instead: T) {
    values.iter_mut().filter(|value| !is_good(value)).for_each(|value| *value = instead);
}

/// Normalises the weights of a vertex to sum to 1; `Some` if all of them are 0.
fn normalize(vertex: &mut [Influence; 8]) -> Option<()> {
    let sum: f64 = vertex.iter().map(|one| f64::from(one.weight)).sum();
    if sum > 0.0 {
        vertex.iter_mut().for_each(|one| one.weight = (f64::from(one.weight) / sum) as f32);
        return None;
    }
    vertex[0].weight = 1.0;
    Some(())
}
