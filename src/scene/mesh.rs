//! Reads meshes: triangles and lines of every mode, with missing attributes completed.
//!
//! In: the JSON's meshes and the materials. Out: primitives with normals (and tangents if a normal map needs them). A
//! primitive keeps its index in the file; a point primitive is left empty, with a warning.

use super::accessor::Integers;
use super::attributes::{Attributes, Label};
use super::file::File;
use super::limits::{LARGEST, is_usable};
use super::nodes::Used;
use super::{Material, Mesh, Primitive, SceneError, geometry, lines, tangents, vertices};
use crate::spelling::pluralised;
use glam::{Vec2, Vec3, Vec4};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{self, Accessor, Index};
use std::collections::HashMap;

/// A mesh with the rest weights of its morph targets.
pub(super) struct Loaded {
    pub(super) mesh: Mesh,
    /// The mesh's own weights; may be shorter than its targets.
    pub(super) weights: Vec<f32>,
}

/// Reads the meshes in use. Adds the default material to `materials` if a primitive has none.
pub(super) fn load(
    file: &File,
    used: &Used,
    materials: &mut Vec<Material>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Loaded>, SceneError> {
    let of_file = materials.len();
    let lacks_material =
        |index: &usize| file.root.meshes[*index].primitives.iter().any(|primitive| primitive.material.is_none());
    if of_file == 0 || used.file_from_scene.iter().any(lacks_material) {
        materials.push(Material::default());
    }
    let unlit = line_materials(file, used, materials, of_file);
    let mut loader = Loader { file, materials, unlit, of_file, warnings };
    used.file_from_scene.iter().map(|&index| loader.mesh(index)).collect()
}

/// Adds the materials of lines to `materials`: base colour only, double-sided. Returns their indices by those of the
/// file's materials.
fn line_materials(file: &File, used: &Used, materials: &mut Vec<Material>, of_file: usize) -> HashMap<usize, usize> {
    let meshes = used.file_from_scene.iter().map(|&index| &file.root.meshes[index]);
    let mut unlit = HashMap::new();
    for primitive in meshes.flat_map(|mesh| &mesh.primitives).filter(|primitive| is_line(primitive.mode)) {
        let index = primitive.material.map_or(of_file, |index| index.value());
        let Some(material) = materials.get(index).filter(|_| !unlit.contains_key(&index)) else { continue };
        unlit.insert(index, materials.len());
        materials.push(Material { unlit: true, double_sided: true, normal_texture: None, ..material.clone() });
    }
    unlit
}

fn is_line(mode: Checked<Mode>) -> bool {
    matches!(mode, Checked::Valid(Mode::Lines | Mode::LineLoop | Mode::LineStrip))
}

struct Loader<'a> {
    file: &'a File,
    materials: &'a [Material],
    /// Index of the line material by the index of the file's material.
    unlit: HashMap<usize, usize>,
    /// Number of materials in the file; the default one follows them.
    of_file: usize,
    warnings: &'a mut Vec<String>,
}

impl Loader<'_> {
    fn mesh(&mut self, index: usize) -> Result<Loaded, SceneError> {
        let json = &self.file.root.meshes[index];
        let name = json.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("mesh_{index}"));
        let mut primitives = Vec::with_capacity(json.primitives.len());
        for (number, primitive) in json.primitives.iter().enumerate() {
            primitives.push(self.primitive(primitive, Label { mesh: &name, primitive: number })?);
        }
        Ok(Loaded {
            mesh: Mesh { name, primitives, ..Mesh::default() },
            weights: json.weights.clone().unwrap_or_default(),
        })
    }

    fn primitive(&mut self, json: &json::mesh::Primitive, label: Label<'_>) -> Result<Primitive, SceneError> {
        let Checked::Valid(mode) = json.mode else {
            return Err(self.file.invalid(format!("{label} has an unknown mode")));
        };
        if mode == Mode::Points {
            self.warnings.push(format!("{label} consists of points and is not drawn"));
            return Ok(Primitive::default());
        }
        let Some(&position) = json.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            self.warnings.push(format!("{label} has no positions and is not drawn"));
            return Ok(Primitive::default());
        };
        let material = self.material(json, label)?;
        let material = self.unlit.get(&material).copied().filter(|_| is_line(json.mode)).unwrap_or(material);
        let positions = positions(self.file, position, label)?;
        let corners = corners(self.file, json, positions.len(), label)?;
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            let corners =
                pluralised(corners.len(), "corner is not a multiple of three", "corners are not a multiple of three");
            self.warnings.push(format!("{label}: {corners}, the rest is left out"));
        }
        let attributes = Attributes { file: self.file, json, count: positions.len(), label };
        let mut primitive = Primitive {
            uvs: [attributes.uvs(0)?, attributes.uvs(1)?],
            colors: attributes.colors()?,
            influences: attributes.influences(self.warnings)?,
            targets: attributes.targets()?,
            triangles: if is_line(json.mode) { Vec::new() } else { triangles(mode, &corners) },
            lines: if is_line(json.mode) { lines::polylines(mode, &corners) } else { Vec::new() },
            material,
            positions,
            ..Primitive::default()
        };
        let normals = attributes.vectors(Semantic::Normals)?;
        let tangents = attributes.tangents()?;
        complete_normals(&mut primitive, normals);
        self.complete_uvs(&mut primitive, label);
        self.complete_tangents(&mut primitive, tangents);
        Ok(primitive)
    }

    fn material(&self, json: &json::mesh::Primitive, label: Label<'_>) -> Result<usize, SceneError> {
        match json.material.map(|index| index.value()) {
            None => Ok(self.of_file),
            Some(index) if index < self.of_file => Ok(index),
            Some(index) => Err(self.file.invalid(format!("{label} names materials[{index}], which does not exist"))),
        }
    }

    /// A texture without UVs samples (0, 0), as on GPUs, so later stages need no special case.
    fn complete_uvs(&mut self, primitive: &mut Primitive, label: Label<'_>) {
        let material = &self.materials[primitive.material];
        let textures = [
            material.base_color_texture,
            material.metallic_roughness_texture,
            material.normal_texture,
            material.occlusion_texture,
            material.emissive_texture,
        ];
        for texture in textures.into_iter().flatten() {
            let uvs = &mut primitive.uvs[texture.uv_set];
            if uvs.is_empty() && !primitive.positions.is_empty() {
                let set = texture.uv_set;
                self.warnings.push(format!("{label} has textures but no TEXCOORD_{set}; they show one texel"));
                *uvs = vec![Vec2::ZERO; primitive.positions.len()];
            }
        }
    }

    fn complete_tangents(&self, primitive: &mut Primitive, stored: Option<Vec<Vec4>>) {
        let Some(texture) = self.materials[primitive.material].normal_texture else { return };
        match stored {
            // Without normals, a file's tangents are ignored, as the format requires.
            Some(mut stored) if !primitive.has_flat_normals => {
                geometry::repair_tangents(&primitive.normals, &mut stored);
                primitive.tangents = stored;
            }
            _ => tangents::generate(primitive, &texture),
        }
    }
}

fn positions(file: &File, accessor: Index<Accessor>, label: Label<'_>) -> Result<Vec<Vec3>, SceneError> {
    let what = format_args!("{label}, POSITION");
    let positions = file.floats(accessor, &[Type::Vec3], Integers::AsFlagged, what)?.map(Vec3::from_array);
    match positions.iter().position(|position| !position.to_array().into_iter().all(is_usable)) {
        Some(vertex) => Err(file.invalid(format!(
            "{label}: the position of vertex {vertex} is not a finite number, or beyond {LARGEST:e}"
        ))),
        None if u32::try_from(positions.len()).is_err() => Err(file.invalid(format!("{label} has too many vertices"))),
        None => Ok(positions),
    }
}

/// Returns vertex indices in drawing order, all below `count`.
fn corners(file: &File, json: &json::mesh::Primitive, count: usize, label: Label<'_>) -> Result<Vec<u32>, SceneError> {
    let Some(accessor) = json.indices else { return Ok((0..count as u32).collect()) };
    let corners = file.integers(accessor, Type::Scalar, format_args!("{label}, indices"))?;
    match corners.iter().position(|&corner| corner as usize >= count) {
        Some(place) => {
            let corner = corners[place];
            Err(file.invalid(format!("{label}: index {place} asks for vertex {corner} of {count}")))
        }
        None => Ok(corners),
    }
}

/// Converts strips and fans to triangles; the winding is that of glTF 2.0, §3.7.2.1.
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turn = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            corners.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => {
            let Some((&hub, rim)) = corners.split_first() else { return Vec::new() };
            rim.windows(2).map(|pair| [pair[0], pair[1], hub]).collect()
        }
        _ => corners.as_chunks::<3>().0.to_vec(),
    }
}

/// Gives every vertex a unit normal: the stored one or, for unshared vertices, that of its face.
fn complete_normals(primitive: &mut Primitive, stored: Option<Vec<Vec3>>) {
    if let Some(mut normals) = stored {
        geometry::repair_normals(&primitive.positions, &primitive.triangles, &mut normals);
        primitive.normals = normals;
        return;
    }
    if !primitive.lines.is_empty() {
        // Lines are not shaded; the line renderer turns them to the viewer.
        primitive.normals = vec![Vec3::Z; primitive.positions.len()];
        return;
    }
    vertices::unshare_vertices(primitive);
    primitive.normals = geometry::flat_normals(&primitive.positions);
    primitive.has_flat_normals = true;
    // Posing recomputes flat normals; stored displacements do not apply to them.
    primitive.targets.iter_mut().for_each(|target| target.normals.clear());
}
