//! Morphing and skinning.
//!
//! In: primitives, morph weights, placed nodes. Out: [`PosedPart`]s. Each vertex depends only on its own data (flat
//! normals: on its triangle's), so the result does not depend on the number of threads.

use super::sample::Moved;
use super::{Detail, PosedPart};
use crate::scene::{Influence, MorphTarget, Primitive, Scene, Skin};
use crate::space::{ScenePoint, SceneVector};
use glam::{DMat4, Mat3, Mat4, Vec3, Vec4};
use rayon::prelude::*;

/// Minimum number of vertices from which multithreading pays off.
const PARALLEL_VERTICES: usize = 50_000;
/// Minimum number of vertices per thread task.
const CHUNK: usize = 8_192;

/// Poses all parts, in node order, then primitive order.
pub(super) fn parts(scene: &Scene, (moved, scene_from_node): (&Moved, &[DMat4]), detail: Detail) -> Vec<PosedPart> {
    let jobs: Vec<Job<'_>> =
        (0..scene.nodes.len()).flat_map(|node| jobs(scene, node, moved, scene_from_node)).collect();
    let vertices: usize = jobs.iter().map(|job| job.primitive.positions.len()).sum();
    if vertices >= PARALLEL_VERTICES {
        jobs.par_iter().map(|job| job.run(detail)).collect()
    } else {
        jobs.iter().map(|job| job.run(detail)).collect()
    }
}

/// One primitive to pose.
struct Job<'a> {
    node: usize,
    mesh: usize,
    number: usize,
    primitive: &'a Primitive,
    weights: &'a [f64],
    placing: Placing,
}

/// How vertices are placed in the scene.
enum Placing {
    /// scene_from_node.
    Rigid(Frame),
    /// scene_from_mesh per joint; the node's own transform is ignored (glTF 2.0, §3.7.3.3).
    Skinned(Vec<Mat4>),
}

/// A transform of points, directions and normals.
#[derive(Clone, Copy)]
struct Frame {
    scene_from_mesh: Mat4,
    /// Inverse transpose up to a positive factor, for normals.
    normals: Mat3,
    /// −1 if the transform mirrors, else 1.
    side: f32,
}

impl Frame {
    fn new(scene_from_mesh: Mat4) -> Self {
        let [x, y, z] = [scene_from_mesh.x_axis, scene_from_mesh.y_axis, scene_from_mesh.z_axis].map(Vec4::truncate);
        // The cofactor matrix, det · inverse transpose, is also defined if one axis is flattened.
        let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        let side = if x.dot(y.cross(z)) < 0.0 { -1.0 } else { 1.0 };
        Self { scene_from_mesh, normals: cofactors * side, side }
    }
}

fn jobs<'a>(scene: &'a Scene, node: usize, moved: &'a Moved, scene_from_node: &[DMat4]) -> Vec<Job<'a>> {
    let Some(index) = scene.nodes[node].mesh else { return Vec::new() };
    let skin = scene.nodes[node].skin.map(|skin| joint_matrices(&scene.skins[skin], scene_from_node));
    let primitives = scene.meshes[index].primitives.iter().enumerate();
    let visible = primitives.filter(|(_, primitive)| primitive.is_visible());
    let job = |(number, primitive): (usize, &'a Primitive)| Job {
        node,
        mesh: index,
        number,
        primitive,
        weights: &moved.weights[node],
        placing: match &skin {
            Some(joints) if !primitive.influences.is_empty() => Placing::Skinned(joints.clone()),
            _ => Placing::Rigid(Frame::new(scene_from_node[node].as_mat4())),
        },
    };
    visible.map(job).collect()
}

/// Returns scene_from_mesh per joint; multiplied in f64, because both factors may be far from the origin.
fn joint_matrices(skin: &Skin, scene_from_node: &[DMat4]) -> Vec<Mat4> {
    let pairs = skin.joints.iter().zip(&skin.joint_from_mesh);
    pairs.map(|(&joint, joint_from_mesh)| (scene_from_node[joint] * joint_from_mesh.as_dmat4()).as_mat4()).collect()
}

/// A vertex before and after posing.
#[derive(Clone, Copy)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
    tangent: Vec4,
    /// −1 if its transform mirrors, else 1.
    side: f32,
}

/// Positions, normals and tangents of a part.
type Attributes = (Vec<ScenePoint>, (Vec<SceneVector>, Vec<Vec4>));

impl Job<'_> {
    fn run(&self, detail: Detail) -> PosedPart {
        let (positions, (normals, tangents)) = match detail {
            Detail::Positions => (self.positions(), (Vec::new(), Vec::new())),
            Detail::Surface => self.surface(),
        };
        PosedPart {
            node: self.node,
            mesh: self.mesh,
            primitive: self.number,
            positions,
            normals,
            tangents,
            is_mirrored: self.is_mirrored(),
        }
    }

    /// Returns the indices of all vertices, for several threads if there are many.
    fn indices(&self) -> impl IndexedParallelIterator<Item = usize> + use<> {
        let count = self.primitive.positions.len();
        (0..count).into_par_iter().with_min_len(if count >= PARALLEL_VERTICES { CHUNK } else { PARALLEL_VERTICES })
    }

    fn positions(&self) -> Vec<ScenePoint> {
        let active = self.active_targets();
        let at_rest = |index: usize| {
            let moves = active.iter().map(|(weight, target)| by(&target.positions, index, *weight));
            moves.fold(self.primitive.positions[index], |position, by| position + by)
        };
        let place = |index: usize| match &self.placing {
            Placing::Rigid(frame) => frame.scene_from_mesh.transform_point3(at_rest(index)),
            Placing::Skinned(joints) => {
                blend(joints, &self.primitive.influences[index]).transform_point3(at_rest(index))
            }
        };
        self.indices().map(|index| ScenePoint(place(index))).collect()
    }

    fn surface(&self) -> Attributes {
        let active = self.active_targets();
        let vertices = self.indices().map(|index| self.vertex(index, &active));
        let is_bent = matches!(self.placing, Placing::Skinned(_)) || !active.is_empty();
        if !(self.primitive.has_flat_normals && is_bent) {
            return self.attributes(vertices);
        }
        let mut vertices: Vec<Vertex> = vertices.collect();
        flatten(&self.primitive.triangles, &mut vertices);
        self.attributes(vertices.into_par_iter().with_min_len(CHUNK))
    }

    /// Separates the attributes of vertices. There are tangents if the primitive has some.
    fn attributes(&self, vertices: impl IndexedParallelIterator<Item = Vertex>) -> Attributes {
        let pair = |vertex: &Vertex| (ScenePoint(vertex.position), SceneVector(vertex.normal));
        if self.primitive.tangents.is_empty() {
            let (positions, normals) = vertices.map(|vertex| pair(&vertex)).unzip();
            return (positions, (normals, Vec::new()));
        }
        let apart = |vertex: Vertex| {
            let (position, normal) = pair(&vertex);
            (position, (normal, vertex.tangent))
        };
        vertices.map(apart).unzip()
    }

    /// Returns the targets with nonzero weight.
    fn active_targets(&self) -> Vec<(f32, &MorphTarget)> {
        let weighted = self.weights.iter().zip(&self.primitive.targets);
        weighted.filter(|(weight, _)| **weight != 0.0).map(|(weight, target)| (*weight as f32, target)).collect()
    }

    fn vertex(&self, index: usize, active: &[(f32, &MorphTarget)]) -> Vertex {
        let at_rest = morph(self.primitive, index, active);
        match &self.placing {
            Placing::Rigid(frame) => place(frame, at_rest),
            Placing::Skinned(joints) => place(&Frame::new(blend(joints, &self.primitive.influences[index])), at_rest),
        }
    }

    /// Returns whether the part is mirrored. Joints may disagree: the dominant joint of the first vertex decides.
    fn is_mirrored(&self) -> bool {
        match &self.placing {
            Placing::Rigid(frame) => frame.side < 0.0,
            Placing::Skinned(joints) => {
                let first = self.primitive.influences.first();
                first.is_some_and(|influences| Frame::new(blend(joints, influences)).side < 0.0)
            }
        }
    }
}

fn morph(primitive: &Primitive, index: usize, active: &[(f32, &MorphTarget)]) -> Vertex {
    let mut vertex = Vertex {
        position: primitive.positions[index],
        normal: primitive.normals[index],
        tangent: primitive.tangents.get(index).copied().unwrap_or_default(),
        side: 1.0,
    };
    for (weight, target) in active {
        vertex.position += by(&target.positions, index, *weight);
        vertex.normal += by(&target.normals, index, *weight);
        vertex.tangent += by(&target.tangents, index, *weight).extend(0.0);
    }
    vertex
}

/// Returns a weighted displacement; none if the list is empty.
fn by(list: &[Vec3], index: usize, weight: f32) -> Vec3 {
    list.get(index).copied().unwrap_or_default() * weight
}

/// Returns the weighted sum of joint matrices (linear blend skinning).
fn blend(joints: &[Mat4], influences: &[Influence; 8]) -> Mat4 {
    let mut sum = Mat4::ZERO;
    for influence in influences.iter().filter(|influence| influence.weight > 0.0) {
        // Loading validates the indices; in a scene built by hand, an invalid one collapses the vertex instead of
        // failing.
        let joint = joints.get(usize::from(influence.joint)).copied().unwrap_or(Mat4::ZERO);
        sum += joint * influence.weight;
    }
    sum
}

fn place(frame: &Frame, vertex: Vertex) -> Vertex {
    let normal = frame.normals * vertex.normal;
    let tangent = frame.scene_from_mesh.transform_vector3(vertex.tangent.truncate());
    Vertex {
        position: frame.scene_from_mesh.transform_point3(vertex.position),
        normal: direction(normal).or_else(|| direction(vertex.normal)).unwrap_or(Vec3::Z),
        tangent: direction(tangent).unwrap_or(Vec3::X).extend(vertex.tangent.w * frame.side),
        side: frame.side,
    }
}

/// Gives the corners of every triangle its face normal; degenerate triangles keep theirs.
fn flatten(triangles: &[[u32; 3]], vertices: &mut [Vertex]) {
    for triangle in triangles {
        let corners = triangle.map(|corner| vertices[corner as usize]);
        let Some(normal) = face_normal(corners.map(|corner| corner.position)) else { continue };
        triangle.iter().for_each(|&corner| vertices[corner as usize].normal = normal * corners[0].side);
    }
}

/// Returns the unit normal of a triangle, counter-clockwise from the front; `None` if it has no area.
fn face_normal(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).try_normalize().map(|normal| normal.as_vec3())
}

/// Normalises a vector; `None` if it is zero. Scaled first, as cofactors of small scales are tiny.
fn direction(vector: Vec3) -> Option<Vec3> {
    let largest = vector.abs().max_element();
    (largest > 0.0 && largest.is_finite()).then(|| (vector / largest).normalize())
}
